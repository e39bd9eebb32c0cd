// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = [|q, p, t| 0.5 * p * p + 0.5 * omega * omega * q * q, |q, _, t| epsilon * q.powi(3) * t.cos()], embedding = Verlet)]
// pub struct Perturbed { pub omega: f64, pub epsilon: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Verlet

A step of size h is two of size h/2, with half of the increments each:

DeltaPlus

Hamiltonians
  H0 = q² omega²/2 + p²/2 + q³ epsilon cos(t)
  H_A = q² omega²/2 + p²/2, a part of H0
  H_B = q³ epsilon cos(t), a part of H0

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (omega² q_i²/2 + P²/2 + epsilon q_i³ cos(t_i))
  Δq = q_{i+1} - q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = P h
  p_i = -D1 L_d:  P = p_i + δp,  δp = -h (omega² q_i + 3 epsilon q_i² cos(t_i))
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp

Step
  assign δp
  assign Δq

DeltaMinus

Hamiltonians
  H0 = q² omega²/2 + p²/2 + q³ epsilon cos(t)
  H_A = q² omega²/2 + p²/2, a part of H0
  H_B = q³ epsilon cos(t), a part of H0

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (omega² q_{i+1}²/2 + P²/2 + epsilon q_{i+1}³ cos(t_{i+1}))
  Δq = q_{i+1} - q_i
  q_{i+1} = Δq + q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = P h
  p_i = -D1 L_d:  P = p_i + δp,  δp = 0
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp - h (omega² q_{i+1} + 3 epsilon q_{i+1}² cos(t_{i+1}))

Step
  assign δp
  assign Δq

Step, by the flows of H = T(p) + V(q), which are exact
  kick of h/2 at t:      p <- p - h/2 ∂V/∂q
  drift of h:            q <- q + h ∂T/∂p
  kick of h/2 at t + h:  p <- p - h/2 ∂V/∂q, whose force is that of the first kick of the next step
  (in compositions drifts and kicks that meet are one)

Facts
  H0 is not a first integral

```
*/
pub struct Perturbed {
    pub omega: f64,
    pub epsilon: f64,
}
#[allow(
    warnings,
    clippy::all,
    clippy::pedantic,
    clippy::nursery,
    clippy::restriction,
    clippy::cargo
)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Constant, Discretized, Hamiltonian, Knowledge, Lanes, NoiseClass,
        Option, Over, Plan, SVector, Scalar, Solver, Some, bool, f64, str, usize,
        compose::{
            Composes, Equations, Flows, Form, Half, Nystrom, Parted, Parts, ROOM,
            Sequence, Structure,
        },
        embedding::{Composed, Verlet},
        gauss::{Field, Fixed},
    };
    #[automatically_derived]
    impl Hamiltonian for Perturbed {
        type Vector = SVector<f64, 1>;
        const READS_TIME: bool = true;
        fn degrees(&self) -> usize {
            1
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("omega", self.omega), ("epsilon", self.epsilon)].get(index).copied()
        }
        fn evaluate<S: Scalar>(&self, term: usize, q_: &[S], p_: &[S], t: f64) -> S {
            match (term, q_, p_) {
                (0, &[q], &[p]) => {
                    let omega: f64 = self.omega;
                    let epsilon: f64 = self.epsilon;
                    (q * (t.cos() * epsilon) + omega * omega * 0.5) * (q * q)
                        + p * p * 0.5
                }
                _ => S::from_f64(f64::NAN),
            }
        }
        fn differentiate<S: Scalar>(
            &self,
            term: usize,
            q_: &[S],
            p_: &[S],
            t: f64,
            by_q: &mut [S],
            by_p: &mut [S],
        ) {
            match (term, q_, p_) {
                (0, &[q], &[p]) => {
                    let omega: f64 = self.omega;
                    let epsilon: f64 = self.epsilon;
                    wzvi::gradient(
                        by_q,
                        by_p,
                        [q * (q * (3.0 * epsilon * t.cos()) + omega * omega)],
                        [p],
                    )
                }
                _ => {
                    by_q.fill(S::from_f64(f64::NAN));
                    by_p.fill(S::from_f64(f64::NAN));
                }
            }
        }
    }
    #[automatically_derived]
    impl Field for Perturbed {
        const IS_NYSTROM: bool = true;
        const IN_LANES: bool = true;
        type Shape = Fixed<1>;
        type Noises = Fixed<0>;
        const IS_STIFF: bool = true;
        fn stiffness(&self, k: &mut [f64]) {
            let omega: f64 = self.omega;
            k[0] = omega * omega;
        }
        type Parameters<K: Constant> = [K; 2];
        fn parameters_beside<const L: usize>(
            systems: [&Self; L],
        ) -> Option<Self::Parameters<Lanes<{ L }>>> {
            Some([
                Lanes::new(systems.map(|system| system.omega)),
                Lanes::new(systems.map(|system| system.epsilon)),
            ])
        }
        #[inline(always)]
        fn slopes<S: Scalar, const BY_Q: bool, const BY_P: bool>(
            &self,
            t: S,
            h: S,
            q_: &[S],
            p_: &[S],
            dw: &[S],
            by_q: &mut [S],
            by_p: &mut [S],
        ) {
            Self::slopes_over::<
                S,
                f64,
                { BY_Q },
                { BY_P },
            >(&[self.omega, self.epsilon], t, h, q_, p_, dw, by_q, by_p)
        }
        #[inline(always)]
        fn slopes_over<S: Over<K>, K: Constant, const BY_Q: bool, const BY_P: bool>(
            parameters: &Self::Parameters<K>,
            t: S,
            h: S,
            q_: &[S],
            p_: &[S],
            dw: &[S],
            by_q: &mut [S],
            by_p: &mut [S],
        ) {
            let [omega, epsilon] = *parameters;
            let (&[q], &[p], &[]) = (q_, p_, dw) else {
                return wzvi::gauss::unfit(by_q, by_p);
            };
            if BY_Q {
                by_q.copy_from_slice(
                    &[h * (q * (q * t.cos() * (epsilon * 3.0) + omega * omega))],
                );
            }
            if BY_P {
                by_p.copy_from_slice(&[p * h]);
            }
        }
    }
    #[automatically_derived]
    impl Flows for Perturbed {
        const PLAN: Plan = Plan {
            solver: Solver::Explicit,
            unknowns: 0,
            order: 2,
            noise: NoiseClass::None,
            consistent: true,
            conserves_energy: Knowledge::Refuted,
            commuting: Knowledge::Proven,
        };
        const FORCE_READS_TIME: bool = true;
        const IN_PLACE: bool = false;
    }
    #[automatically_derived]
    impl Parts for Perturbed {
        const PLAN: Plan = Plan {
            solver: Solver::Explicit,
            unknowns: 0,
            order: 2,
            noise: NoiseClass::None,
            consistent: true,
            conserves_energy: Knowledge::Refuted,
            commuting: Knowledge::Proven,
        };
        const FORMS: [Form; 2] = [Form::Quadratic, Form::Coordinates];
        type Shape = Fixed<1>;
        #[inline(always)]
        fn slopes_of_part<S: Scalar, const BY_Q: bool, const BY_P: bool>(
            &self,
            part: Half,
            t: f64,
            h: f64,
            q_: &[S],
            p_: &[S],
            by_q: &mut [S],
            by_p: &mut [S],
        ) {
            match part {
                Half::First => {
                    match (q_, p_) {
                        (&[q], &[p]) => {
                            let omega: f64 = self.omega;
                            if BY_Q {
                                by_q.copy_from_slice(&[q * (omega * omega * h)]);
                            }
                            if BY_P {
                                by_p.copy_from_slice(&[p * h]);
                            }
                        }
                        _ => wzvi::gauss::unfit(by_q, by_p),
                    }
                }
                Half::Second => {
                    match (q_, p_) {
                        (&[q], &[p]) => {
                            let epsilon: f64 = self.epsilon;
                            if BY_Q {
                                by_q.copy_from_slice(
                                    &[q * q * (3.0 * epsilon * t.cos() * h)],
                                );
                            }
                            if BY_P {
                                by_p.copy_from_slice(&[S::from_f64(0.0)]);
                            }
                        }
                        _ => wzvi::gauss::unfit(by_q, by_p),
                    }
                }
            }
        }
        fn value_of_part(&self, part: Half, t: f64, q_: &[f64], p_: &[f64]) -> f64 {
            match part {
                Half::First => {
                    match (q_, p_) {
                        (&[q], &[p]) => {
                            let omega: f64 = self.omega;
                            (q * q * (omega * omega) + p * p) * 0.5
                        }
                        _ => f64::NAN,
                    }
                }
                Half::Second => {
                    match (q_, p_) {
                        (&[q], &[p]) => {
                            let epsilon: f64 = self.epsilon;
                            q * (q * q) * (t.cos() * epsilon)
                        }
                        _ => f64::NAN,
                    }
                }
            }
        }
    }
    wzvi::composition! {
        [impl Discretized < Verlet > for Perturbed] Verlet, < Nystrom as Structure <
        Verlet >> ::Sequence, 2,
        "Verlet\n\nA step of size h is two of size h/2, with half of the increments each:\n\nDeltaPlus\n\nHamiltonians\n  H0 = q² omega²/2 + p²/2 + q³ epsilon cos(t)\n  H_A = q² omega²/2 + p²/2, a part of H0\n  H_B = q³ epsilon cos(t), a part of H0\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (omega² q_i²/2 + P²/2 + epsilon q_i³ cos(t_i))\n  Δq = q_{i+1} - q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = P h\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -h (omega² q_i + 3 epsilon q_i² cos(t_i))\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp\n\nStep\n  assign δp\n  assign Δq\n\nDeltaMinus\n\nHamiltonians\n  H0 = q² omega²/2 + p²/2 + q³ epsilon cos(t)\n  H_A = q² omega²/2 + p²/2, a part of H0\n  H_B = q³ epsilon cos(t), a part of H0\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (omega² q_{i+1}²/2 + P²/2 + epsilon q_{i+1}³ cos(t_{i+1}))\n  Δq = q_{i+1} - q_i\n  q_{i+1} = Δq + q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = P h\n  p_i = -D1 L_d:  P = p_i + δp,  δp = 0\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp - h (omega² q_{i+1} + 3 epsilon q_{i+1}² cos(t_{i+1}))\n\nStep\n  assign δp\n  assign Δq\n\nStep, by the flows of H = T(p) + V(q), which are exact\n  kick of h/2 at t:      p <- p - h/2 ∂V/∂q\n  drift of h:            q <- q + h ∂T/∂p\n  kick of h/2 at t + h:  p <- p - h/2 ∂V/∂q, whose force is that of the first kick of the next step\n  (in compositions drifts and kicks that meet are one)\n\nFacts\n  H0 is not a first integral\n",
        wzvi::compose::of_one:: < Verlet, Nystrom > ()
    }
    wzvi::composition! {
        [impl < W : Composes < Verlet, Parted < Nystrom > > > Discretized < Composed <
        Verlet, W > > for Perturbed where < W as Composes < Verlet, Parted < Nystrom > >
        > ::Sequence : Sequence < Self >] Composed < Verlet, W >, < W as Composes <
        Verlet, Parted < Nystrom > > > ::Sequence, < W as Composes < Verlet, Parted <
        Nystrom > > > ::ORDER, Equations:: < Self, Verlet, Parted < Nystrom >, W, { 1526
        + ROOM } > ::ALL, < W as Composes < Verlet, Parted < Nystrom > > > ::substeps()
    }
    /// The names that are bound above, so that no constant around can stand for them.
    use ::wzvi::__private::{
        binding as by_p, binding as by_q, binding as dw, binding as epsilon,
        binding as h, binding as index, binding as k, binding as omega, binding as p,
        binding as p_, binding as parameters, binding as part, binding as q,
        binding as q_, binding as system, binding as systems, binding as t,
        binding as term,
    };
};
#[allow(
    warnings,
    clippy::all,
    clippy::pedantic,
    clippy::nursery,
    clippy::restriction,
    clippy::cargo
)]
const _: () = {
    #[automatically_derived]
    impl ::wzvi::__private::checks::Checked for Perturbed {
        fn check(&self) {
            ::wzvi::__private::checks::is_same::<
                ::wzvi::embedding::Verlet,
            >(::core::marker::PhantomData::<Verlet>);
            {
                let omega = self.omega;
                ::wzvi::__private::checks::of_time::<
                    ::core::primitive::f64,
                    _,
                >(|q, p, t| 0.5 * p * p + 0.5 * omega * omega * q * q);
            }
            {
                let epsilon = self.epsilon;
                ::wzvi::__private::checks::of_time::<
                    ::core::primitive::f64,
                    _,
                >(|q, _, t| epsilon * q.powi(3) * t.cos());
            }
        }
    }
};
