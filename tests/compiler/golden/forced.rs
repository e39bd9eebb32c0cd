// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), force = |_q, _p, t| push * (2.0 * t).cos(), friction = gamma, embedding = Midpoint)]
// pub struct Driven { pub push: f64, pub gamma: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = p²/2 - cos(q)

Forces
  F0 = push cos(2 t)

Friction
  γ = gamma

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h exp(h gamma/2) (P²/(2 exp(h gamma/2)²) - cos(q_{i+1/2}))
  Δq = q_{i+1} - q_i
  q_{i+1/2} = q_i + Δq/2

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h P/exp(h gamma/2)
  p_i = -D1 L_d:  P = p_i + δp,  δp = h push cos(2 t_{i+1/2}) exp(h gamma/2)/2 - h exp(h gamma/2) sin(q_{i+1/2})/2
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = h push cos(2 t_{i+1/2}) exp(h gamma/2)/2 + δp + exp_m1(-h gamma) (h push cos(2 t_{i+1/2}) exp(h gamma/2)/2 + P - h exp(h gamma/2) sin(q_{i+1/2})/2) - h exp(h gamma/2) sin(q_{i+1/2})/2

Step
  solve for δp: Newton (then Δq)

Facts
  F0 · ∂H0/∂p = push p cos(2 t)
  friction takes from H0 per unit of time: gamma p²
  H0 is not a first integral

```
*/
pub struct Driven {
    pub push: f64,
    pub gamma: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Block, ComputesWith, ConfigError, Constant, ConstantsIn,
        Discretized, Err, Extrapolation, Facts, FixedCompensatedSum, Inputs, Kind,
        Knowledge, LiftParameter, Number, Ok, Option, Plan, Reals, Result, SVector,
        Scalar, Scheme, Sized, Solution, Solver, Some, StateSum, StepFailure, Straight,
        StraightLine, bool, f64, str, usize, bath::Friction, compose::General,
        elements::{
            CommonRange, ElementInput, Elements, EvaluationPoint, MomentumUpdate,
            Partials, Quadrature, QuadraturePoint, Role, Sums,
        },
        embedding::Midpoint, gauss::Fixed,
    };
    #[automatically_derived]
    impl Elements for Driven {
        const FACTS: Facts = Facts {
            conserves_energy: Knowledge::Refuted,
            is_damped: true,
            kind: Kind {
                is_conformal: true,
                is_forced: true,
                ..Kind::AUTONOMOUS
            },
            bath: Some(Friction::ALONE),
            ..Facts::autonomous(1)
        };
        type Shape = Fixed<1>;
        type Structure = General;
        type Vector = SVector<f64, 1>;
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("push", self.push), ("gamma", self.gamma)].get(index).copied()
        }
        fn friction_rate<K: Constant>(&self, parameters: &[K]) -> K {
            let gamma = K::parameter(parameters, 1, self.gamma);
            gamma
        }
        fn validate(&self) -> Result<(), ConfigError> {
            wzvi::bath::validate(self)
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let scale = at.scale;
            match role {
                Role::Drift => {
                    let inverse_scale = scale.recip();
                    let product = S::of_constant(inverse_scale * inverse_scale * 0.5);
                    let scale = S::of_constant(scale);
                    let q = at.q[0];
                    let p = at.p[0];
                    scale * (product * (p * p) - q.cos()) * S::of_constant(at.h)
                }
                Role::Force => S::from_f64(0.0),
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
            let push = at.parameter(0, self.push);
            let gamma = at.parameter(1, self.gamma);
            let t = at.t;
            let scale = at.scale;
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let inverse_scale = scale.recip();
                        let product = T::of_constant(
                            inverse_scale * inverse_scale * scale,
                        );
                        let factor = T::of_constant(at.h);
                        let p = T::of(at.p[0]);
                        by_p.add(0, product * (p * factor));
                    }
                    if partials.by_q {
                        let scale = T::of_constant(scale);
                        let factor = T::of_constant(at.h);
                        let q = T::of(at.q[0]);
                        by_q.add(0, scale * (factor * q.sin()));
                    }
                }
                Role::Force => {
                    if partials.by_q {
                        let product = T::of_constant((t * 2.0).cos() * scale * push);
                        let factor = T::of_constant(at.h);
                        by_q.add(0, -(factor * product));
                    }
                }
                Role::Friction => {
                    if partials.by_q {
                        let gamma = T::of_constant(gamma);
                        let factor = T::of_constant(at.h);
                        by_q.add(0, -(factor * gamma));
                    }
                }
                _ => {}
            }
        }
    }
    /// The equations of a block, and their Jacobian by rows.
    struct Equations;
    impl Block<2, 0, 4, 0, 1> for Equations {
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn equations<S: ComputesWith<K>, K: Constant>(
            (
                [q,
                p,
                ],
                [],
                [quotient,
                product5,
                product,
                product2,
                ],
                [],
            ): Inputs<S, K, 2, 0, 4, 0>,
            [delta_p,
            ]: [S; 1],
        ) -> ([S; 1], [[S; 1]; 1]) {
            let stage_q = q + (p + delta_p) * quotient;
            let (sin_stage_q, cos_stage_q) = stage_q.sin_cos();
            (
                [delta_p + (sin_stage_q - product5) * product],
                [[cos_stage_q * product2 + 1.0]],
            )
        }
    }
    #[automatically_derived]
    impl StraightLine<Midpoint, 1, 0> for Driven {
        const PLAN: Plan = <Self as Elements>::FACTS.plan(Solver::Newton, 1, 2, true);
        const QUADRATURE: Quadrature = Quadrature::new(
            &[
                QuadraturePoint::new(
                    [0.5, 0.5, 0.5],
                    &[Role::Drift.times(1.0), Role::Force.times(1.0)],
                ),
            ],
            MomentumUpdate::Multiple(2.0),
        );
        type Prepared = Reals<9>;
        type Memory<S: Scalar> = Extrapolation<S, 1>;
        type Sum<S: Scalar> = FixedCompensatedSum<S, 1>;
        fn prepare<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
            h: K,
        ) -> Result<ConstantsIn<Self::Prepared, K>, ConfigError> {
            let push = lift(0, self.push);
            let gamma = lift(1, self.gamma);
            if push.magnitude().is_nan() || gamma.magnitude().is_nan() {
                return Err(ConfigError::Parameter);
            }
            let half_h = h * 0.5;
            let exp = (half_h * gamma).exp();
            Ok([
                push,
                half_h,
                half_h / exp,
                exp * 0.5 * h,
                h * h * 0.25,
                h / exp,
                (-(h * gamma)).exp_m1(),
                half_h * push * exp,
                exp * half_h,
            ])
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
            let [push, half_h, quotient, product, product2, quotient2, exp_m1, product3,
            product4] = *prepared;
            let cos = ((half_h + t) * 2.0).cos();
            let product5 = cos * push;
            use Block as _;
            let mut unknowns = memory.guess::<true>();
            let effort = Equations::newton::<
                S,
                K,
                false,
                true,
                { CAREFUL },
            >(([q, p], [], [quotient, product5, product, product2], []), &mut unknowns)?;
            let [delta_p] = unknowns;
            let node_p = p + delta_p;
            let stage_q = q + node_p * quotient;
            let sin_stage_q = stage_q.sin();
            let delta_q = node_p * quotient2;
            *next = Solution::new(
                carry,
                [[q], [p]],
                [
                    [delta_q],
                    [
                        delta_p + (node_p + (-sin_stage_q + product5) * product) * exp_m1
                            - sin_stage_q * product4 + product3 * cos,
                    ],
                ],
                effort,
            );
            let taken = next.are_finite();
            memory.record_where::<true>(taken, [delta_p]);
            next.ensure_taken(taken)
        }
    }
    #[automatically_derived]
    impl Discretized<Midpoint> for Driven {
        type Scheme = Straight<Midpoint, 1, 0>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = p²/2 - cos(q)\n\nForces\n  F0 = push cos(2 t)\n\nFriction\n  γ = gamma\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h exp(h gamma/2) (P²/(2 exp(h gamma/2)²) - cos(q_{i+1/2}))\n  Δq = q_{i+1} - q_i\n  q_{i+1/2} = q_i + Δq/2\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h P/exp(h gamma/2)\n  p_i = -D1 L_d:  P = p_i + δp,  δp = h push cos(2 t_{i+1/2}) exp(h gamma/2)/2 - h exp(h gamma/2) sin(q_{i+1/2})/2\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = h push cos(2 t_{i+1/2}) exp(h gamma/2)/2 + δp + exp_m1(-h gamma) (h push cos(2 t_{i+1/2}) exp(h gamma/2)/2 + P - h exp(h gamma/2) sin(q_{i+1/2})/2) - h exp(h gamma/2) sin(q_{i+1/2})/2\n\nStep\n  solve for δp: Newton (then Δq)\n\nFacts\n  F0 · ∂H0/∂p = push p cos(2 t)\n  friction takes from H0 per unit of time: gamma p²\n  H0 is not a first integral\n";
    }
    wzvi::bindings! {
        at by_p by_q carry coordinates cos cos_stage_q delta_p delta_q effort exp exp_m1
        factor gamma h half_h increments index inverse_scale lift memory momenta next
        node_p p parameters partials prepared product product2 product3 product4 product5
        push q quotient quotient2 role scale sin_stage_q stage_q t taken unknowns weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Driven {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(checks::PhantomData::<Midpoint>);
            checks::of_state::<checks::f64, _>(|q, p| 0.5 * p * p - q.cos());
            {
                let push = self.push;
                checks::of_time::<
                    checks::f64,
                    _,
                >(|_q, _p, t| { checks::entry(push * (2.0 * t).cos()) });
            }
            {
                let gamma = self.gamma;
                let _ = gamma;
            }
        }
    }
};
