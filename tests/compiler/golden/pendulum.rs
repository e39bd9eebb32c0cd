// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q, p| 0.5 * p * p - omega * omega * q.cos(), embedding = [DeltaPlus, Midpoint])]
// pub struct Pendulum { pub omega: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
DeltaPlus

Hamiltonians
  H0 = p²/2 - omega² cos(q)

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (P²/2 - omega² cos(q_i))
  Δq = q_{i+1} - q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = P h
  p_i = -D1 L_d:  P = p_i + δp,  δp = -omega² h sin(q_i)
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp

Step
  assign δp
  assign Δq

Facts
  H0 is a first integral: kept by the step nearly, within O(h)
  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)
    H_p·H_q = p omega² sin(q)
    H_pp(H_q,H_q) = omega^4 sin(q)²
    H_qq(H_p,H_p) = p² omega² cos(q)

```

```text
Midpoint

Hamiltonians
  H0 = p²/2 - omega² cos(q)

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (P²/2 - omega² cos(q_{i+1/2}))
  Δq = q_{i+1} - q_i
  q_{i+1/2} = Δq/2 + q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = P h
  p_i = -D1 L_d:  P = p_i + δp,  δp = -omega² h sin(q_{i+1/2})/2
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp

Step
  solve for δp: Newton (then Δq)

Facts
  H0 is a first integral: kept by the step nearly, within O(h²)
  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)
    H_pp(H_q,H_q) = omega^4 sin(q)²
    H_qq(H_p,H_p) = p² omega² cos(q)

```
*/
pub struct Pendulum {
    pub omega: f64,
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
        self as wzvi, Block, Carry, ConfigError, Conservative, Constant, Effort, Err,
        Extrapolation, Facts, Hamiltonian, Knowledge, Lift, Listed, NoiseClass, Number,
        Of, Ok, Option, Over, PhantomData, Plain, Plan, Reals, Result, Rounded, SVector,
        Scalar, Sized, Solution, Solver, StepFailure, Straight, StraightLine, bool, f64,
        str, usize, compose::{Composes, Equations, General, Many, ROOM, Structure},
        elements::{
            Alone, Elements, Given, MomentumUpdate, Point, Quadrature, Run, Slopes,
            Stage, Sums, Unknowns, Usual,
        },
        embedding::{Composed, DeltaPlus, Midpoint},
    };
    #[automatically_derived]
    impl Hamiltonian for Pendulum {
        type Vector = SVector<f64, 1>;
        fn degrees(&self) -> usize {
            1
        }
        fn check(&self, degrees: usize) -> Result<(), StepFailure> {
            wzvi::elements::check(self, degrees)
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("omega", self.omega)].get(index).copied()
        }
        fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
            wzvi::elements::evaluate(self, term, q, p, t)
        }
        fn differentiate<S: Scalar>(
            &self,
            term: usize,
            q: &[S],
            p: &[S],
            t: f64,
            by_q: &mut [S],
            by_p: &mut [S],
        ) {
            wzvi::elements::differentiate(self, term, q, p, t, by_q, by_p);
        }
    }
    #[automatically_derived]
    impl Elements for Pendulum {
        const FACTS: Facts = Facts {
            degrees: 1,
            noise: NoiseClass::None,
            conserves_energy: Knowledge::Proven,
            commuting: Knowledge::Proven,
            is_damped: false,
            has_pieces: false,
        };
        const INTEGRALS: usize = 3;
        fn value<S: Scalar>(&self, part: usize, weight: f64, at: &Point<'_, S>) -> S {
            let omega: f64 = self.omega;
            let mut value = S::from_f64(0.0);
            match part {
                0 => {
                    let mut total = S::from_f64(0.0);
                    {
                        let omega_squared = omega * omega;
                        let q = at.q[0];
                        let p = at.p[0];
                        total = total + p * p * 0.5 - q.cos() * omega_squared;
                    }
                    value = value + total * S::from_f64(at.h);
                }
                _ => {}
            }
            value
        }
        type Exact = Alone;
        type Usual = Usual;
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn slopes<
            S: Scalar,
            T: Number<S>,
            V: Given<S> + ?Sized,
            Q: Sums<S> + ?Sized,
            P: Sums<S> + ?Sized,
        >(
            &self,
            part: usize,
            weight: f64,
            at: &Point<'_, S, V>,
            wanted: Slopes,
            by_q: &mut Q,
            by_p: &mut P,
        ) {
            use Run as _;
            let omega: f64 = self.omega;
            match part {
                0 => {
                    if wanted.by_q {
                        {
                            let omega_squared = omega * omega;
                            let factor = T::from_f64(at.h);
                            let q = T::of(at.q[0]);
                            by_q.add(0, factor * q.sin() * omega_squared);
                        }
                    }
                    if wanted.by_p {
                        {
                            let factor = T::from_f64(at.h);
                            let p = T::of(at.p[0]);
                            by_p.add(0, p * factor);
                        }
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl StraightLine<DeltaPlus, 1, 0> for Pendulum {
        const PLAN: Plan = <Self as Elements>::FACTS.plan(Solver::Explicit, 0, 1, true);
        const QUADRATURE: Quadrature = Quadrature {
            stages: &[Stage::new([0.0, 1.0, 0.0], &[(0, 1.0)])],
            update: MomentumUpdate::Multiple(1.0),
            unknowns: Unknowns::Momenta,
            remembers: false,
            is_linear: false,
        };
        type Prepared = Reals<1>;
        type Memory<S: Scalar> = PhantomData<S>;
        type Carry<S: Scalar> = Plain;
        fn prepare<K: Constant>(
            &self,
            lift: Lift<'_, K>,
            h: K,
        ) -> Result<Of<Self::Prepared, K>, ConfigError> {
            let omega = lift(0, self.omega);
            if omega.magnitude().is_nan() {
                return Err(ConfigError::Parameter);
            }
            Ok([omega * omega * h])
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn solve<S: Over<K>, K: Constant, C: Carry<S>, const CAREFUL: bool>(
            prepared: &Of<Self::Prepared, K>,
            t: K,
            h: K,
            q: [S; 1],
            p: [S; 1],
            dw: [S; 0],
            memory: &mut Self::Memory<S>,
            carry: &C,
            next: &mut Solution<S, 1>,
        ) -> Result<(), StepFailure> {
            let ([q], [p]) = (q, p);
            let [product] = *prepared;
            let product2 = q.sin() * product;
            *next = Solution::new(
                carry,
                [[q], [p]],
                [[(p - product2) * h], [-product2]],
                Effort::fast(0),
            );
            if !next.is_finite() {
                return Err(StepFailure::NonFinite);
            }
            Ok(())
        }
    }
    #[automatically_derived]
    impl Listed<DeltaPlus> for Pendulum {
        type Scheme = Straight<DeltaPlus, 1, 0>;
        const TEXT: &'static str = "DeltaPlus\n\nHamiltonians\n  H0 = p²/2 - omega² cos(q)\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (P²/2 - omega² cos(q_i))\n  Δq = q_{i+1} - q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = P h\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -omega² h sin(q_i)\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp\n\nStep\n  assign δp\n  assign Δq\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h)\n  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)\n    H_p·H_q = p omega² sin(q)\n    H_pp(H_q,H_q) = omega^4 sin(q)²\n    H_qq(H_p,H_p) = p² omega² cos(q)\n";
    }
    const _: () = {
        /// The equations of a block, and their Jacobian by rows.
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn equations<S: Over<K>, K: Constant>(
            given: [S; 2],
            constants: [K; 3],
            iterate: [S; 1],
        ) -> ([S; 1], [[S; 1]; 1]) {
            let ([q, p], [half_h, product, product2], [delta_p]) = (
                given,
                constants,
                iterate,
            );
            let stage_q = q + (p + delta_p) * half_h;
            let (sin_stage_q, cos_stage_q) = stage_q.sin_cos();
            ([delta_p + sin_stage_q * product], [[cos_stage_q * product2 + 1.0]])
        }
        /// The equations of a block at all numbers that round to `iterate`.
        #[cold]
        #[inline(never)]
        fn rounded(
            given: [f64; 2],
            constants: [f64; 3],
            iterate: [f64; 1],
        ) -> [Rounded; 1] {
            equations(
                    given.map(Rounded::exact),
                    constants,
                    iterate.map(Rounded::nearest),
                )
                .0
        }
        #[automatically_derived]
        impl StraightLine<Midpoint, 1, 0> for Pendulum {
            const PLAN: Plan = <Self as Elements>::FACTS
                .plan(Solver::Newton, 1, 2, true);
            const QUADRATURE: Quadrature = Quadrature {
                stages: &[Stage::new([0.5, 0.5, 0.5], &[(0, 1.0)])],
                update: MomentumUpdate::Multiple(2.0),
                unknowns: Unknowns::Momenta,
                remembers: false,
                is_linear: false,
            };
            type Prepared = Reals<3>;
            type Memory<S: Scalar> = Extrapolation<S, 1>;
            type Carry<S: Scalar> = Plain;
            fn prepare<K: Constant>(
                &self,
                lift: Lift<'_, K>,
                h: K,
            ) -> Result<Of<Self::Prepared, K>, ConfigError> {
                let omega = lift(0, self.omega);
                if omega.magnitude().is_nan() {
                    return Err(ConfigError::Parameter);
                }
                let omega_squared = omega * omega;
                Ok([h * 0.5, omega_squared * 0.5 * h, h * h * (omega_squared * 0.25)])
            }
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn solve<S: Over<K>, K: Constant, C: Carry<S>, const CAREFUL: bool>(
                prepared: &Of<Self::Prepared, K>,
                t: K,
                h: K,
                q: [S; 1],
                p: [S; 1],
                dw: [S; 0],
                memory: &mut Self::Memory<S>,
                carry: &C,
                next: &mut Solution<S, 1>,
            ) -> Result<(), StepFailure> {
                let ([q], [p]) = (q, p);
                let [half_h, product, product2] = *prepared;
                let mut unknowns = memory.guess::<true>();
                let effort = wzvi::newton::<
                    S,
                    1,
                    false,
                    true,
                    { CAREFUL },
                >(
                    &mut unknowns,
                    Block {
                        evaluate: move |iterate: &[S; 1]| equations(
                            [q, p],
                            [half_h, product, product2],
                            *iterate,
                        ),
                        rounded: move |iterate: &[S; 1], lane| {
                            rounded(
                                [q.lane(lane), p.lane(lane)],
                                [
                                    half_h.lane(lane),
                                    product.lane(lane),
                                    product2.lane(lane),
                                ],
                                iterate.map(|number| number.lane(lane)),
                            )
                        },
                    },
                )?;
                let [delta_p] = unknowns;
                let node_p = p + delta_p;
                *next = Solution::new(
                    carry,
                    [[q], [p]],
                    [[node_p * h], [delta_p * 2.0]],
                    effort,
                );
                if !next.is_finite() {
                    if S::GOES_IN_PART {
                        let taken = next.are_finite();
                        memory.record_in_part::<true>(taken, [delta_p]);
                    }
                    return Err(next.failure());
                }
                memory.record::<true>([delta_p]);
                Ok(())
            }
        }
    };
    #[automatically_derived]
    impl Listed<Midpoint> for Pendulum {
        type Scheme = Straight<Midpoint, 1, 0>;
        const TEXT: &'static str = "Midpoint\n\nHamiltonians\n  H0 = p²/2 - omega² cos(q)\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (P²/2 - omega² cos(q_{i+1/2}))\n  Δq = q_{i+1} - q_i\n  q_{i+1/2} = Δq/2 + q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = P h\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -omega² h sin(q_{i+1/2})/2\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp\n\nStep\n  solve for δp: Newton (then Δq)\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²)\n  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)\n    H_pp(H_q,H_q) = omega^4 sin(q)²\n    H_qq(H_p,H_p) = p² omega² cos(q)\n";
    }
    #[automatically_derived]
    impl<W: Composes<Midpoint, General>> Listed<Composed<Midpoint, W>> for Pendulum {
        type Scheme = <General as Structure<
            Midpoint,
        >>::Steps<Many<Midpoint, General, W>>;
        const TEXT: &'static str = Equations::<
            Self,
            Midpoint,
            General,
            W,
            { 658 + ROOM },
        >::ALL;
    }
    #[automatically_derived]
    impl Conservative for Pendulum {}
    /// The names that are bound above, so that no constant around can stand for them.
    use ::wzvi::__private::{
        binding as at, binding as by_p, binding as by_q, binding as carry,
        binding as constants, binding as cos_stage_q, binding as degrees,
        binding as delta_p, binding as dw, binding as effort, binding as factor,
        binding as given, binding as h, binding as half_h, binding as index,
        binding as iterate, binding as lane, binding as lift, binding as memory,
        binding as next, binding as node_p, binding as number, binding as omega,
        binding as omega_squared, binding as p, binding as part, binding as prepared,
        binding as product, binding as product2, binding as q, binding as sin_stage_q,
        binding as stage_q, binding as t, binding as taken, binding as term,
        binding as total, binding as unknowns, binding as value, binding as wanted,
        binding as weight,
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
    impl ::wzvi::__private::checks::Checked for Pendulum {
        fn check(&self) {
            ::wzvi::__private::checks::is_same::<
                ::wzvi::embedding::DeltaPlus,
            >(::core::marker::PhantomData::<DeltaPlus>);
            ::wzvi::__private::checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(::core::marker::PhantomData::<Midpoint>);
            {
                let omega = self.omega;
                ::wzvi::__private::checks::of_state::<
                    ::core::primitive::f64,
                    _,
                >(|q, p| 0.5 * p * p - omega * omega * q.cos());
            }
        }
    }
};
