// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y.powi(3) / 3.0, embedding = Midpoint)]
// pub struct HenonHeiles;

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = (px² + py² + x² + y²)/2 + x² y - y³/3

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P_{px} Δx + P_{py} Δy - h ((P_{px}² + P_{py}² + x_{i+1/2}² + y_{i+1/2}²)/2 + x_{i+1/2}² y_{i+1/2} - y_{i+1/2}³/3)
  Δx = x_{i+1} - x_i
  Δy = y_{i+1} - y_i
  x_{i+1/2} = x_i + Δx/2
  y_{i+1/2} = y_i + Δy/2

Discrete Euler-Lagrange equations
  ∂L_d/∂P_{px} = 0:  Δx = h P_{px}
  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (x_{i+1/2} + 2 x_{i+1/2} y_{i+1/2})/2
  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx
  ∂L_d/∂P_{py} = 0:  Δy = h P_{py}
  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (y_{i+1/2} + x_{i+1/2}² - y_{i+1/2}²)/2
  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy

Step
  solve for δpx, δpy: Newton, symmetric Jacobian (then Δx, Δy)

Facts
  H0 is a first integral: kept by the step nearly, within O(h²)
  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)
    H_pp(H_q,H_q) = (x + 2 x y)² + (y + x² - y²)²
    H_qq(H_p,H_p) = px (2 x py + px (1 + 2 y)) + py (2 x px + py (1 - 2 y))

```
*/
pub struct HenonHeiles;
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Block, ComputesWith, ConfigError, Conservative, Constant,
        ConstantsIn, Discretized, Extrapolation, Facts, Inputs, Labels, LiftParameter,
        Number, Ok, PlainSum, Plan, Reals, Result, SVector, Scalar, Scheme, Sized,
        Solution, Solver, StateSum, StepFailure, Straight, StraightLine, Variables, bool,
        f64, str, compose::General,
        elements::{
            ElementInput, Elements, EvaluationPoint, MomentumUpdate, Partials,
            Quadrature, QuadraturePoint, Role, Sums,
        },
        embedding::Midpoint, gauss::Fixed,
    };
    #[automatically_derived]
    impl Elements for HenonHeiles {
        const FACTS: Facts = Facts::autonomous(2);
        type Shape = Fixed<2>;
        type Structure = General;
        type Vector = SVector<f64, 2>;
        fn variables(&self) -> Variables {
            Variables {
                q: Labels::Each(&["x", "y"]),
                p: Labels::Each(&["px", "py"]),
                t: "t",
                invariants: &[],
                observables: &[],
            }
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            match role {
                Role::Drift => {
                    let x = at.q[0];
                    let y = at.q[1];
                    let px = at.p[0];
                    let py = at.p[1];
                    let x_squared = x * x;
                    let y_squared = y * y;
                    (y * (x_squared - y_squared * 0.3333333333333333)
                        + (y_squared + (x_squared + (px * px + py * py))) * 0.5)
                        * S::of_constant(at.h)
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
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        let px = T::of(at.p[0]);
                        let py = T::of(at.p[1]);
                        by_p.add(0, px * factor);
                        by_p.add(1, py * factor);
                    }
                    if partials.by_q {
                        let factor = T::of_constant(at.h);
                        let x = T::of(at.q[0]);
                        let y = T::of(at.q[1]);
                        by_q.add(0, (y * 2.0 + 1.0) * (x * factor));
                        by_q.add(1, factor * (y * (-y + 1.0) + x * x));
                    }
                }
                _ => {}
            }
        }
    }
    /// The equations of a block, and their Jacobian by rows.
    struct Equations;
    impl Block<4, 0, 3, 0, 2> for Equations {
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn equations<S: ComputesWith<K>, K: Constant>(
            (
                [x,
                y,
                px,
                py,
                ],
                [],
                [half_h,
                quarter_h_squared,
                half_h_squared,
                ],
                [],
            ): Inputs<S, K, 4, 0, 3, 0>,
            [delta_px,
            delta_py,
            ]: [S; 2],
        ) -> ([S; 2], [[S; 2]; 2]) {
            let stage_x = x + (px + delta_px) * half_h;
            let stage_y = y + (py + delta_py) * half_h;
            let twice_stage_y = stage_y * 2.0;
            let sum = twice_stage_y + 1.0;
            let product = stage_x * half_h_squared;
            (
                [
                    delta_px + stage_x * sum * half_h,
                    delta_py + (stage_y * (-stage_y + 1.0) + stage_x * stage_x) * half_h,
                ],
                [
                    [sum * quarter_h_squared + 1.0, product],
                    [product, (-twice_stage_y + 1.0) * quarter_h_squared + 1.0],
                ],
            )
        }
    }
    #[automatically_derived]
    impl StraightLine<Midpoint, 2, 0> for HenonHeiles {
        const PLAN: Plan = <Self as Elements>::FACTS.plan(Solver::Newton, 2, 2, true);
        const QUADRATURE: Quadrature = Quadrature::new(
            &[QuadraturePoint::new([0.5, 0.5, 0.5], &[Role::Drift.times(1.0)])],
            MomentumUpdate::Multiple(2.0),
        );
        type Prepared = Reals<3>;
        type Memory<S: Scalar> = Extrapolation<S, 2>;
        type Sum<S: Scalar> = PlainSum;
        fn prepare<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
            h: K,
        ) -> Result<ConstantsIn<Self::Prepared, K>, ConfigError> {
            let h_squared = h * h;
            Ok([h * 0.5, h_squared * 0.25, h_squared * 0.5])
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn solve<S: ComputesWith<K>, K: Constant, C: StateSum<S>, const CAREFUL: bool>(
            prepared: &ConstantsIn<Self::Prepared, K>,
            t: K,
            h: K,
            coordinates: [S; 2],
            momenta: [S; 2],
            increments: [S; 0],
            memory: &mut Self::Memory<S>,
            carry: &C,
            next: &mut Solution<S, 2>,
        ) -> Result<(), StepFailure> {
            let ([x, y], [px, py]) = (coordinates, momenta);
            let [half_h, quarter_h_squared, half_h_squared] = *prepared;
            use Block as _;
            let mut unknowns = memory.guess::<true>();
            let effort = Equations::newton::<
                S,
                K,
                true,
                true,
                { CAREFUL },
            >(
                ([x, y, px, py], [], [half_h, quarter_h_squared, half_h_squared], []),
                &mut unknowns,
            )?;
            let [delta_px, delta_py] = unknowns;
            let node_px = px + delta_px;
            let node_py = py + delta_py;
            let delta_x = node_px * h;
            let delta_y = node_py * h;
            *next = Solution::new(
                carry,
                [[x, y], [px, py]],
                [[delta_x, delta_y], [delta_px * 2.0, delta_py * 2.0]],
                effort,
            );
            let taken = next.are_finite();
            memory.record_where::<true>(taken, [delta_px, delta_py]);
            next.ensure_taken(taken)
        }
    }
    #[automatically_derived]
    impl Discretized<Midpoint> for HenonHeiles {
        type Scheme = Straight<Midpoint, 2, 0>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = (px² + py² + x² + y²)/2 + x² y - y³/3\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P_{px} Δx + P_{py} Δy - h ((P_{px}² + P_{py}² + x_{i+1/2}² + y_{i+1/2}²)/2 + x_{i+1/2}² y_{i+1/2} - y_{i+1/2}³/3)\n  Δx = x_{i+1} - x_i\n  Δy = y_{i+1} - y_i\n  x_{i+1/2} = x_i + Δx/2\n  y_{i+1/2} = y_i + Δy/2\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P_{px} = 0:  Δx = h P_{px}\n  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (x_{i+1/2} + 2 x_{i+1/2} y_{i+1/2})/2\n  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx\n  ∂L_d/∂P_{py} = 0:  Δy = h P_{py}\n  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (y_{i+1/2} + x_{i+1/2}² - y_{i+1/2}²)/2\n  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy\n\nStep\n  solve for δpx, δpy: Newton, symmetric Jacobian (then Δx, Δy)\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²)\n  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)\n    H_pp(H_q,H_q) = (x + 2 x y)² + (y + x² - y²)²\n    H_qq(H_p,H_p) = px (2 x py + px (1 + 2 y)) + py (2 x px + py (1 - 2 y))\n";
    }
    #[automatically_derived]
    impl Conservative for HenonHeiles {}
    wzvi::bindings! {
        at by_p by_q carry coordinates delta_px delta_py delta_x delta_y effort factor h
        h_squared half_h half_h_squared increments lift memory momenta next node_px
        node_py partials prepared product px py quarter_h_squared role stage_x stage_y
        sum t taken twice_stage_y unknowns weight x x_squared y y_squared
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl HenonHeiles {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(checks::PhantomData::<Midpoint>);
            checks::of_state::<
                [::core::primitive::f64; 2usize],
                _,
            >(|[x, y], [px, py]| {
                0.5 * (px * px + py * py + x * x + y * y) + x * x * y - y.powi(3) / 3.0
            });
        }
    }
};
