// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q, p| 0.5 * p * p + 0.5 * q * q + if q > edge && stiffness > 0.0 { 0.5 * stiffness * (q - edge).powi(2) } else { 0.0 }, embedding = Midpoint)]
// pub struct Wall { pub edge: f64, pub stiffness: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = p²/2 + q²/2 + (if edge < q and 0 < stiffness then stiffness (q - edge)²/2 else 0)

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (P²/2 + q_{i+1/2}²/2 + (if edge < q_{i+1/2} and 0 < stiffness then stiffness (q_{i+1/2} - edge)²/2 else 0))
  Δq = q_{i+1} - q_i
  q_{i+1/2} = q_i + Δq/2

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h P
  p_i = -D1 L_d:  P = p_i + δp,  δp = -h (q_{i+1/2} + (if edge < q_{i+1/2} and 0 < stiffness then stiffness (q_{i+1/2} - edge) else 0))/2
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp

Step
  solve for δp: Newton (then Δq)

Facts
  H0 is a first integral: kept by the step nearly, within O(h²) between the boundaries of its branches
  where q = edge, H0 is continuous, its slope, too: steps have at most order 2 across, unless second derivatives are continuous

```
*/
pub struct Wall {
    pub edge: f64,
    pub stiffness: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Block, ComputesWith, ConfigError, Conservative, Constant,
        ConstantsIn, Discretized, Err, Extrapolation, Facts, Inputs, LiftParameter, Mask,
        Number, Ok, Option, PlainSum, Plan, Reals, Result, SVector, Scalar, Scheme,
        Sized, Solution, Solver, StateSum, StepFailure, Straight, StraightLine, Truths,
        bool, f64, str, usize, compose::General,
        elements::{
            ElementInput, Elements, EvaluationPoint, MomentumUpdate, Partials,
            Quadrature, QuadraturePoint, Role, Sums,
        },
        embedding::Midpoint, gauss::Fixed,
    };
    #[automatically_derived]
    impl Elements for Wall {
        const FACTS: Facts = Facts::autonomous(1);
        type Shape = Fixed<1>;
        type Structure = General;
        type Vector = SVector<f64, 1>;
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("edge", self.edge), ("stiffness", self.stiffness)].get(index).copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let edge = at.parameter(0, self.edge);
            let stiffness = at.parameter(1, self.stiffness);
            match role {
                Role::Drift => {
                    let condition = Scalar::less(
                        <S::Constant as Scalar>::from_f64(0.0),
                        stiffness,
                    );
                    let half_stiffness = S::of_constant(stiffness * 0.5);
                    let edge = S::of_constant(edge);
                    let q = at.q[0];
                    let p = at.p[0];
                    let difference = q - edge;
                    (Scalar::select(
                        Scalar::less(edge, q)
                            & <<S as Scalar>::Mask as Mask>::from_bool(condition),
                        half_stiffness * (difference * difference),
                        S::from_f64(0.0),
                    ) + (p * p * 0.5 + q * q * 0.5)) * S::of_constant(at.h)
                }
                _ => S::from_f64(0.0),
            }
        }
        type CommonRange = f64;
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
            let edge = at.parameter(0, self.edge);
            let stiffness = at.parameter(1, self.stiffness);
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        let p = T::of(at.p[0]);
                        by_p.add(0, p * factor);
                    }
                    if partials.by_q {
                        let condition = Scalar::less(
                            <T::Constant as Scalar>::from_f64(0.0),
                            stiffness,
                        );
                        let edge = T::of_constant(edge);
                        let stiffness = T::of_constant(stiffness);
                        let factor = T::of_constant(at.h);
                        let q = T::of(at.q[0]);
                        by_q.add(
                            0,
                            factor
                                * (q
                                    + Scalar::select(
                                        Scalar::less(edge, q)
                                            & <<T as Scalar>::Mask as Mask>::from_bool(condition),
                                        stiffness * (q - edge),
                                        T::from_f64(0.0),
                                    )),
                        );
                    }
                }
                _ => {}
            }
        }
    }
    /// The equations of a block, and their Jacobian by rows.
    struct Equations;
    impl Block<2, 0, 4, 1, 1> for Equations {
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn equations<S: ComputesWith<K>, K: Constant>(
            (
                [q,
                p,
                ],
                [],
                [edge,
                stiffness,
                half_h,
                product,
                ],
                [condition,
                ],
            ): Inputs<S, K, 2, 0, 4, 1>,
            [delta_p,
            ]: [S; 1],
        ) -> ([S; 1], [[S; 1]; 1]) {
            let stage_q = q + (p + delta_p) * half_h;
            let condition2 = Scalar::less(
                <S as ComputesWith<K>>::constant(edge),
                stage_q,
            ) & <S as ComputesWith<K>>::truth(condition);
            (
                [
                    delta_p
                        + (stage_q
                            + Scalar::select(
                                condition2,
                                (stage_q - edge) * stiffness,
                                S::from_f64(0.0),
                            )) * half_h,
                ],
                [
                    [
                        (Scalar::select(
                            condition2,
                            <S as ComputesWith<K>>::constant(stiffness),
                            S::from_f64(0.0),
                        ) + 1.0) * product + 1.0,
                    ],
                ],
            )
        }
    }
    #[automatically_derived]
    impl StraightLine<Midpoint, 1, 0> for Wall {
        const PLAN: Plan = <Self as Elements>::FACTS.plan(Solver::Newton, 1, 2, true);
        const QUADRATURE: Quadrature = Quadrature::new(
            &[QuadraturePoint::new([0.5, 0.5, 0.5], &[Role::Drift.times(1.0)])],
            MomentumUpdate::Multiple(2.0),
        );
        type Prepared = (Reals<4>, Truths<1>);
        type Memory<S: Scalar> = Extrapolation<S, 1>;
        type Sum<S: Scalar> = PlainSum;
        fn prepare<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
            h: K,
        ) -> Result<ConstantsIn<Self::Prepared, K>, ConfigError> {
            let edge = lift(0, self.edge);
            let stiffness = lift(1, self.stiffness);
            if edge.magnitude().is_nan() || stiffness.magnitude().is_nan() {
                return Err(ConfigError::Parameter);
            }
            Ok((
                [edge, stiffness, h * 0.5, h * h * 0.25],
                [Scalar::less(<K as Scalar>::from_f64(0.0), stiffness)],
            ))
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
            let ([edge, stiffness, half_h, product], [condition]) = *prepared;
            use Block as _;
            let mut unknowns = memory.guess::<true>();
            let effort = Equations::newton::<
                S,
                K,
                false,
                true,
                { CAREFUL },
            >(
                ([q, p], [], [edge, stiffness, half_h, product], [condition]),
                &mut unknowns,
            )?;
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
    impl Discretized<Midpoint> for Wall {
        type Scheme = Straight<Midpoint, 1, 0>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = p²/2 + q²/2 + (if edge < q and 0 < stiffness then stiffness (q - edge)²/2 else 0)\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (P²/2 + q_{i+1/2}²/2 + (if edge < q_{i+1/2} and 0 < stiffness then stiffness (q_{i+1/2} - edge)²/2 else 0))\n  Δq = q_{i+1} - q_i\n  q_{i+1/2} = q_i + Δq/2\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h P\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -h (q_{i+1/2} + (if edge < q_{i+1/2} and 0 < stiffness then stiffness (q_{i+1/2} - edge) else 0))/2\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp\n\nStep\n  solve for δp: Newton (then Δq)\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²) between the boundaries of its branches\n  where q = edge, H0 is continuous, its slope, too: steps have at most order 2 across, unless second derivatives are continuous\n";
    }
    #[automatically_derived]
    impl Conservative for Wall {}
    wzvi::bindings! {
        at by_p by_q carry condition condition2 coordinates delta_p delta_q difference
        edge effort factor h half_h half_stiffness increments index lift memory momenta
        next node_p p partials prepared product q role stage_q stiffness t taken unknowns
        weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Wall {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(checks::PhantomData::<Midpoint>);
            {
                let edge = self.edge;
                let stiffness = self.stiffness;
                checks::of_state::<
                    checks::f64,
                    _,
                >(|q, p| {
                    0.5 * p * p + 0.5 * q * q
                        + if q > edge && stiffness > 0.0 {
                            0.5 * stiffness * (q - edge).powi(2)
                        } else {
                            0.0
                        }
                });
            }
        }
    }
};
