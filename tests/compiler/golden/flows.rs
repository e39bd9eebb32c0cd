// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = [|q, p, t| 0.5 * p * p + 0.5 * omega * omega * q * q, |q, _, t| epsilon * q.powi(3) * t.cos()], embedding = Verlet)]
// pub struct Perturbed { pub omega: f64, pub epsilon: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Verlet

Hamiltonians
  H0 = p²/2 + omega² q²/2 + epsilon q³ cos(t)
  H_A = p²/2 + omega² q²/2, a part of H0
  H_B = epsilon q³ cos(t), a part of H0

A step of size h is two of size h/2, with half of the increments each:

DeltaPlus

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (P²/2 + omega² q_i²/2 + epsilon q_i³ cos(t_i))
  Δq = q_{i+1} - q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h P
  p_i = -D1 L_d:  P = p_i + δp,  δp = -h (omega² q_i + 3 epsilon q_i² cos(t_i))
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp

Step
  assign δp
  assign Δq

DeltaMinus

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (P²/2 + omega² q_{i+1}²/2 + epsilon q_{i+1}³ cos(t_{i+1}))
  Δq = q_{i+1} - q_i
  q_{i+1} = q_i + Δq

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h P
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
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, ComputesWith, Constant, ConstantsIn, Discretized, Facts, Kind,
        Knowledge, LiftParameter, Number, Option, Reals, SVector, Scalar, Scheme, Sized,
        Some, bool, f64, str, usize, compose::{Form, Nystrom, Parted, WholeOf},
        elements::{
            CommonRange, ElementInput, Elements, EvaluationPoint, FieldAt, PairColumns,
            Partials, Role, Sums,
        },
        embedding::Verlet, gauss::{Field, Fixed},
    };
    #[automatically_derived]
    impl Elements for Perturbed {
        const FACTS: Facts = Facts {
            conserves_energy: Knowledge::Refuted,
            kind: Kind {
                reads_time: true,
                ..Kind::AUTONOMOUS
            },
            summands: Some([Form::Quadratic, Form::Coordinates]),
            ..Facts::autonomous(1)
        };
        type Shape = Fixed<1>;
        type Structure = Parted<Nystrom>;
        type Vector = SVector<f64, 1>;
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("omega", self.omega), ("epsilon", self.epsilon)].get(index).copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let omega = at.parameter(0, self.omega);
            let epsilon = at.parameter(1, self.epsilon);
            let t = at.t;
            match role {
                Role::Drift => {
                    let product = S::of_constant(omega * omega * 0.5);
                    let product2 = S::of_constant(t.cos() * epsilon);
                    let q = at.q[0];
                    let p = at.p[0];
                    ((product + q * product2) * (q * q) + p * p * 0.5)
                        * S::of_constant(at.h)
                }
                Role::Summand(0) => {
                    let omega_squared = S::of_constant(omega * omega);
                    let q = at.q[0];
                    let p = at.p[0];
                    (p * p + omega_squared * (q * q)) * 0.5 * S::of_constant(at.h)
                }
                Role::Summand(1) => {
                    let product = S::of_constant(t.cos() * epsilon);
                    let q = at.q[0];
                    product * (q * (q * q)) * S::of_constant(at.h)
                }
                _ => S::from_f64(0.0),
            }
        }
        type CommonRange = CommonRange;
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn gradient<S: Scalar, T: Number<S>>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S, impl ElementInput<S> + ?Sized>,
            partials: Partials,
            by_q: &mut (impl Sums<S> + ?Sized),
            by_p: &mut (impl Sums<S> + ?Sized),
        ) {
            let omega = at.parameter(0, self.omega);
            let epsilon = at.parameter(1, self.epsilon);
            let t = at.t;
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        let p = T::of(at.p[0]);
                        by_p.add(0, p * factor);
                    }
                    if partials.by_q {
                        let omega_squared = T::of_constant(omega * omega);
                        let product = T::of_constant(epsilon * 3.0 * t.cos());
                        let factor = T::of_constant(at.h);
                        let q = T::of(at.q[0]);
                        by_q.add(0, (omega_squared + q * product) * (q * factor));
                    }
                }
                Role::Summand(0) => {
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        let p = T::of(at.p[0]);
                        by_p.add(0, p * factor);
                    }
                    if partials.by_q {
                        let omega_squared = T::of_constant(omega * omega);
                        let factor = T::of_constant(at.h);
                        let q = T::of(at.q[0]);
                        by_q.add(0, omega_squared * (q * factor));
                    }
                }
                Role::Summand(1) => {
                    if partials.by_q {
                        let product = T::of_constant(epsilon * 3.0 * t.cos());
                        let factor = T::of_constant(at.h);
                        let q = T::of(at.q[0]);
                        by_q.add(0, product * (factor * (q * q)));
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl Field for Perturbed {
        const IS_NYSTROM: bool = true;
        const IN_LANES: bool = true;
        const FORCE_READS_TIME: bool = true;
        type Noises = Fixed<0>;
        type Parameters = Reals<2>;
        fn parameters<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
        ) -> ConstantsIn<Self::Parameters, K> {
            [lift(0, self.omega), lift(1, self.epsilon)]
        }
        const IS_STIFF: bool = true;
        fn stiffness<K: Constant>(&self, parameters: &[K], k: &mut [K]) {
            let omega = K::parameter(parameters, 0, self.omega);
            k[0] = omega * omega;
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn step_gradient<
            K: Constant,
            S: ComputesWith<K>,
            const BY_Q: bool,
            const BY_P: bool,
        >(
            &self,
            parameters: &ConstantsIn<Self::Parameters, K>,
            ([t, h], [coordinates, momenta], increments): FieldAt<'_, S>,
            [by_q,
            by_p,
            ]: [&mut [S]; 2],
            _: &mut PairColumns,
        ) {
            let [omega, epsilon] = *parameters;
            let (&[q], &[p], &[]) = (coordinates, momenta, increments) else {
                return wzvi::gauss::unfit(by_q, by_p);
            };
            if BY_Q {
                by_q.copy_from_slice(
                    &[(q * t.cos() * (epsilon * 3.0) + omega * omega) * (q * h)],
                );
            }
            if BY_P {
                by_p.copy_from_slice(&[p * h]);
            }
        }
    }
    #[automatically_derived]
    impl Discretized<Verlet> for Perturbed {
        type Scheme = WholeOf<Self, Verlet>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Verlet\n\nHamiltonians\n  H0 = p²/2 + omega² q²/2 + epsilon q³ cos(t)\n  H_A = p²/2 + omega² q²/2, a part of H0\n  H_B = epsilon q³ cos(t), a part of H0\n\nA step of size h is two of size h/2, with half of the increments each:\n\nDeltaPlus\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (P²/2 + omega² q_i²/2 + epsilon q_i³ cos(t_i))\n  Δq = q_{i+1} - q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h P\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -h (omega² q_i + 3 epsilon q_i² cos(t_i))\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp\n\nStep\n  assign δp\n  assign Δq\n\nDeltaMinus\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (P²/2 + omega² q_{i+1}²/2 + epsilon q_{i+1}³ cos(t_{i+1}))\n  Δq = q_{i+1} - q_i\n  q_{i+1} = q_i + Δq\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h P\n  p_i = -D1 L_d:  P = p_i + δp,  δp = 0\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp - h (omega² q_{i+1} + 3 epsilon q_{i+1}² cos(t_{i+1}))\n\nStep\n  assign δp\n  assign Δq\n\nStep, by the flows of H = T(p) + V(q), which are exact\n  kick of h/2 at t:      p <- p - h/2 ∂V/∂q\n  drift of h:            q <- q + h ∂T/∂p\n  kick of h/2 at t + h:  p <- p - h/2 ∂V/∂q, whose force is that of the first kick of the next step\n  (in compositions drifts and kicks that meet are one)\n\nFacts\n  H0 is not a first integral\n";
    }
    wzvi::bindings! {
        at by_p by_q coordinates epsilon factor h increments index k lift momenta omega
        omega_squared p parameters partials product product2 q role t weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Perturbed {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<::wzvi::embedding::Verlet>(checks::PhantomData::<Verlet>);
            {
                let omega = self.omega;
                checks::of_time::<
                    checks::f64,
                    _,
                >(|q, p, t| 0.5 * p * p + 0.5 * omega * omega * q * q);
            }
            {
                let epsilon = self.epsilon;
                checks::of_time::<
                    checks::f64,
                    _,
                >(|q, _, t| epsilon * q.powi(3) * t.cos());
            }
        }
    }
};
