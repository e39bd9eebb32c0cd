// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q, p| 0.5 * p * p - omega * omega * q.cos(), embedding = Midpoint)]
// pub struct Pendulum { pub omega: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = p²/2 - omega² cos(q)

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (P²/2 - omega² cos(q_{i+1/2}))
  Δq = q_{i+1} - q_i
  q_{i+1/2} = q_i + Δq/2

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h P
  p_i = -D1 L_d:  P = p_i + δp,  δp = -h omega² sin(q_{i+1/2})/2
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp

Step
  solve for δp: Newton (then Δq)

Facts
  H0 is a first integral: kept by the step nearly, within O(h²)
  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)
    H_pp(H_q,H_q) = omega^4 sin(q)²
    H_qq(H_p,H_p) = omega² p² cos(q)

```
*/
pub struct Pendulum {
    pub omega: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Block, ComputesWith, ConfigError, Conservative, Constant,
        ConstantsIn, Discretized, Err, Extrapolation, Facts, Inputs, LiftParameter,
        Number, Ok, Option, PlainSum, Plan, Reals, Result, SVector, Scalar, Scheme,
        Sized, Solution, Solver, StateSum, StepFailure, Straight, StraightLine, bool,
        f64, str, usize, compose::General,
        elements::{
            CommonRange, ElementInput, Elements, EvaluationPoint, MomentumUpdate,
            Partials, Quadrature, QuadraturePoint, Role, Sums,
        },
        embedding::Midpoint, gauss::Fixed,
    };
    #[automatically_derived]
    impl Elements for Pendulum {
        const FACTS: Facts = Facts::autonomous(1);
        type Shape = Fixed<1>;
        type Structure = General;
        type Vector = SVector<f64, 1>;
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("omega", self.omega)].get(index).copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let omega = at.parameter(0, self.omega);
            match role {
                Role::Drift => {
                    let omega_squared = S::of_constant(omega * omega);
                    let q = at.q[0];
                    let p = at.p[0];
                    (p * p * 0.5 - q.cos() * omega_squared) * S::of_constant(at.h)
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
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        let p = T::of(at.p[0]);
                        by_p.add(0, p * factor);
                    }
                    if partials.by_q {
                        let omega_squared = T::of_constant(omega * omega);
                        let factor = T::of_constant(at.h);
                        let q = T::of(at.q[0]);
                        by_q.add(0, omega_squared * (factor * q.sin()));
                    }
                }
                _ => {}
            }
        }
    }
    /// The equations of a block, and their Jacobian by rows.
    struct Equations;
    impl Block<2, 0, 3, 0, 1> for Equations {
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn equations<S: ComputesWith<K>, K: Constant>(
            (
                [q,
                p,
                ],
                [],
                [half_h,
                half_h_omega_squared,
                product,
                ],
                [],
            ): Inputs<S, K, 2, 0, 3, 0>,
            [delta_p,
            ]: [S; 1],
        ) -> ([S; 1], [[S; 1]; 1]) {
            let stage_q = q + (p + delta_p) * half_h;
            let (sin_stage_q, cos_stage_q) = stage_q.sin_cos();
            (
                [delta_p + sin_stage_q * half_h_omega_squared],
                [[cos_stage_q * product + 1.0]],
            )
        }
    }
    #[automatically_derived]
    impl StraightLine<Midpoint, 1, 0> for Pendulum {
        const PLAN: Plan = <Self as Elements>::FACTS.plan(Solver::Newton, 1, 2, true);
        const QUADRATURE: Quadrature = Quadrature::new(
            &[QuadraturePoint::new([0.5, 0.5, 0.5], &[Role::Drift.times(1.0)])],
            MomentumUpdate::Multiple(2.0),
        );
        type Prepared = Reals<3>;
        type Memory<S: Scalar> = Extrapolation<S, 1>;
        type Sum<S: Scalar> = PlainSum;
        fn prepare<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
            h: K,
        ) -> Result<ConstantsIn<Self::Prepared, K>, ConfigError> {
            let omega = lift(0, self.omega);
            if omega.magnitude().is_nan() {
                return Err(ConfigError::Parameter);
            }
            let half_h = h * 0.5;
            let omega_squared = omega * omega;
            Ok([half_h, omega_squared * half_h, h * h * 0.25 * omega_squared])
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn solve<S: ComputesWith<K>, K: Constant, C: StateSum<S>, const CAREFUL: bool>(
            prepared: &ConstantsIn<Self::Prepared, K>,
            t: K,
            h: K,
            coordinates: [S; 1],
            momenta: [S; 1],
            increments: [S; 0],
            memory: &mut Self::Memory<S>,
            carry: &C,
            next: &mut Solution<S, 1>,
        ) -> Result<(), StepFailure> {
            let ([q], [p]) = (coordinates, momenta);
            let [half_h, half_h_omega_squared, product] = *prepared;
            use Block as _;
            let mut unknowns = memory.guess::<true>();
            let effort = Equations::newton::<
                S,
                K,
                false,
                true,
                { CAREFUL },
            >(([q, p], [], [half_h, half_h_omega_squared, product], []), &mut unknowns)?;
            let [delta_p] = unknowns;
            let node_p = p + delta_p;
            let delta_q = node_p * h;
            *next = Solution::new(
                carry,
                [[q], [p]],
                [[delta_q], [delta_p * 2.0]],
                effort,
            );
            let taken = next.are_finite();
            memory.record_where::<true>(taken, [delta_p]);
            next.ensure_taken(taken)
        }
    }
    #[automatically_derived]
    impl Discretized<Midpoint> for Pendulum {
        type Scheme = Straight<Midpoint, 1, 0>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = p²/2 - omega² cos(q)\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (P²/2 - omega² cos(q_{i+1/2}))\n  Δq = q_{i+1} - q_i\n  q_{i+1/2} = q_i + Δq/2\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h P\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -h omega² sin(q_{i+1/2})/2\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp\n\nStep\n  solve for δp: Newton (then Δq)\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²)\n  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)\n    H_pp(H_q,H_q) = omega^4 sin(q)²\n    H_qq(H_p,H_p) = omega² p² cos(q)\n";
    }
    #[automatically_derived]
    impl Conservative for Pendulum {}
    wzvi::bindings! {
        at by_p by_q carry coordinates cos_stage_q delta_p delta_q effort factor h half_h
        half_h_omega_squared increments index lift memory momenta next node_p omega
        omega_squared p partials prepared product q role sin_stage_q stage_q t taken
        unknowns weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Pendulum {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(checks::PhantomData::<Midpoint>);
            {
                let omega = self.omega;
                checks::of_state::<
                    checks::f64,
                    _,
                >(|q, p| 0.5 * p * p - omega * omega * q.cos());
            }
        }
    }
};
