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
  H0 = (py² + px² + x² + y²)/2 + x² y - y³/3

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P_{px} Δx - h ((P_{py}² + P_{px}² + x_{i+1/2}² + y_{i+1/2}²)/2 + x_{i+1/2}² y_{i+1/2} - y_{i+1/2}³/3) + P_{py} Δy
  Δx = x_{i+1} - x_i
  Δy = y_{i+1} - y_i
  x_{i+1/2} = Δx/2 + x_i
  y_{i+1/2} = Δy/2 + y_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P_{px} = 0:  Δx = P_{px} h
  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (x_{i+1/2} + 2 x_{i+1/2} y_{i+1/2})/2
  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx
  ∂L_d/∂P_{py} = 0:  Δy = P_{py} h
  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (y_{i+1/2} + x_{i+1/2}² - y_{i+1/2}²)/2
  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy

Step
  solve for δpx, δpy: Newton, symmetric Jacobian (then Δx, Δy)

Facts
  H0 is a first integral: kept by the step nearly, within O(h²)
  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)
    H_pp(H_q,H_q) = (x + 2 x y)² + (y + x² - y²)²
    H_qq(H_p,H_p) = px (px (1 + 2 y) + 2 x py) + py (2 x px + py (1 - 2 y))

```
*/
pub struct HenonHeiles;
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
        self as wzvi, Beside, Block, Carry, Compensation, ConfigError, Conservative,
        Constant, Discretized, Effort, Err, Extrapolation, Hamiltonian, Knowledge,
        Labels, LagrangianGradient, Lanes, NoiseClass, Ok, Option, Over, Plain, Plan,
        Result, Rounded, SVector, Scalar, Segment, Solution, Solver, Some, State,
        StepFailure, Variables, Vector, bool, f64, str, usize,
        compose::{Composes, Equations, General, ROOM, Structure},
        embedding::{Composed, Midpoint},
    };
    #[automatically_derived]
    impl Hamiltonian for HenonHeiles {
        type Vector = SVector<f64, 2>;
        fn degrees(&self) -> usize {
            2
        }
        fn variables(&self) -> Variables {
            Variables {
                q: Labels::Each(&["x", "y"]),
                p: Labels::Each(&["px", "py"]),
                t: "t",
            }
        }
        fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
            match (term, q, p) {
                (0, &[x, y], &[px, py]) => {
                    let x_squared = x * x;
                    let y_squared = y * y;
                    y * (x_squared - y_squared * 0.3333333333333333)
                        + (y_squared + (x_squared + (py * py + px * px))) * 0.5
                }
                _ => S::from_f64(f64::NAN),
            }
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
            match (term, q, p) {
                (0, &[x, y], &[px, py]) => {
                    wzvi::gradient(
                        by_q,
                        by_p,
                        [x * (y * 2.0 + 1.0), y * (-y + 1.0) + x * x],
                        [px, py],
                    )
                }
                _ => {
                    by_q.fill(S::from_f64(f64::NAN));
                    by_p.fill(S::from_f64(f64::NAN));
                }
            }
        }
    }
    const _: () = {
        type Prepared<K> = [K; 3];
        type Memory<S> = Extrapolation<S, 2>;
        /// The equations of a block, and their Jacobian by rows.
        #[inline(always)]
        fn equations<S: Over<K>, K: Constant>(
            given: [S; 4],
            constants: [K; 3],
            iterate: [S; 2],
        ) -> ([S; 2], [[S; 2]; 2]) {
            let (
                [x,
                y,
                px,
                py,
                ],
                [half_h,
                quarter_h_squared,
                half_h_squared,
                ],
                [delta_px,
                delta_py,
                ],
            ) = (given, constants, iterate);
            let stage_y = y + (py + delta_py) * half_h;
            let twice_stage_y = stage_y * 2.0;
            let sum = twice_stage_y + 1.0;
            let stage_x = x + (px + delta_px) * half_h;
            let product = stage_x * half_h_squared;
            (
                [
                    delta_px + sum * stage_x * half_h,
                    delta_py + (stage_y * (-stage_y + 1.0) + stage_x * stage_x) * half_h,
                ],
                [
                    [sum * quarter_h_squared + 1.0, product],
                    [product, (-twice_stage_y + 1.0) * quarter_h_squared + 1.0],
                ],
            )
        }
        /// The equations of a block at all numbers that round to `iterate`.
        #[cold]
        #[inline(never)]
        fn rounded(
            given: [f64; 4],
            constants: [f64; 3],
            iterate: [f64; 2],
        ) -> [Rounded; 2] {
            equations(
                    given.map(Rounded::exact),
                    constants,
                    iterate.map(Rounded::nearest),
                )
                .0
        }
        #[inline(always)]
        fn solve<S: Over<K>, K: Constant, C: Carry<S>, const CAREFUL: bool>(
            prepared: &Prepared<K>,
            h: f64,
            q: [S; 2],
            p: [S; 2],
            memory: &mut Memory<S>,
            carry: &C,
            next: &mut Solution<S, 2>,
        ) -> Result<(), StepFailure> {
            let ([x, y], [px, py]) = (q, p);
            let [half_h, quarter_h_squared, half_h_squared] = *prepared;
            let mut unknowns = memory.guess::<true>();
            let effort = wzvi::newton::<
                S,
                2,
                true,
                true,
                { CAREFUL },
            >(
                &mut unknowns,
                Block {
                    evaluate: move |iterate: &[S; 2]| equations(
                        [x, y, px, py],
                        [half_h, quarter_h_squared, half_h_squared],
                        *iterate,
                    ),
                    rounded: move |iterate: &[S; 2], lane| {
                        rounded(
                            [x.lane(lane), y.lane(lane), px.lane(lane), py.lane(lane)],
                            [
                                half_h.lane(lane),
                                quarter_h_squared.lane(lane),
                                half_h_squared.lane(lane),
                            ],
                            iterate.map(|number| number.lane(lane)),
                        )
                    },
                },
            )?;
            let [delta_px, delta_py] = unknowns;
            let node_py = py + delta_py;
            let node_px = px + delta_px;
            *next = Solution::new(
                carry,
                [[x, y], [px, py]],
                [[node_px * h, node_py * h], [delta_px * 2.0, delta_py * 2.0]],
                [node_px, node_py],
                effort,
            );
            if !next.is_finite() {
                if S::GOES_IN_PART {
                    let taken = next.are_finite();
                    memory.record_in_part::<true>(taken, [delta_px, delta_py]);
                }
                return Err(next.failure());
            }
            memory.record::<true>([delta_px, delta_py]);
            Ok(())
        }
        #[automatically_derived]
        impl Discretized<Midpoint> for HenonHeiles {
            const PLAN: Plan = Plan {
                solver: Solver::Newton,
                unknowns: 2,
                order: 2,
                noise: NoiseClass::None,
                consistent: true,
                conserves_energy: Knowledge::Proven,
                commuting: Knowledge::Proven,
            };
            const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = (py² + px² + x² + y²)/2 + x² y - y³/3\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P_{px} Δx - h ((P_{py}² + P_{px}² + x_{i+1/2}² + y_{i+1/2}²)/2 + x_{i+1/2}² y_{i+1/2} - y_{i+1/2}³/3) + P_{py} Δy\n  Δx = x_{i+1} - x_i\n  Δy = y_{i+1} - y_i\n  x_{i+1/2} = Δx/2 + x_i\n  y_{i+1/2} = Δy/2 + y_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P_{px} = 0:  Δx = P_{px} h\n  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (x_{i+1/2} + 2 x_{i+1/2} y_{i+1/2})/2\n  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx\n  ∂L_d/∂P_{py} = 0:  Δy = P_{py} h\n  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (y_{i+1/2} + x_{i+1/2}² - y_{i+1/2}²)/2\n  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy\n\nStep\n  solve for δpx, δpy: Newton, symmetric Jacobian (then Δx, Δy)\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²)\n  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)\n    H_pp(H_q,H_q) = (x + 2 x y)² + (y + x² - y²)²\n    H_qq(H_p,H_p) = px (px (1 + 2 y) + 2 x py) + py (2 x px + py (1 - 2 y))\n";
            type Prepared = Prepared<f64>;
            type Memory<S: Scalar> = Memory<S>;
            type Compensated<S: Scalar> = Compensation<S, 2>;
            type Carry<S: Scalar> = Plain;
            fn prepare(&self, h: f64) -> Result<Self::Prepared, ConfigError> {
                let h_squared = h * h;
                Ok([0.5 * h, h_squared * 0.25, h_squared * 0.5])
            }
            #[inline(always)]
            fn advance_carrying<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
                &self,
                prepared: &Self::Prepared,
                t: f64,
                h: f64,
                q: &mut [S],
                p: &mut [S],
                dw: &[S],
                memory: &mut Self::Memory<S>,
                carry: &mut C,
            ) -> Result<Effort, StepFailure> {
                let (q, p) = (wzvi::array_mut(q)?, wzvi::array_mut(p)?);
                wzvi::increments::<_, 0>(dw)?;
                let mut next = Solution::nowhere();
                let solved = solve::<
                    S,
                    f64,
                    C,
                    { CAREFUL },
                >(prepared, h, *q, *p, memory, carry, &mut next);
                next.arrive(solved, q, p, carry)
            }
            type Beside<const L: usize> = Prepared<Lanes<{ L }>>;
            fn beside<const L: usize>(
                systems: [&Self; L],
                prepared: [&Self::Prepared; L],
            ) -> Option<Self::Beside<{ L }>> {
                Some(Beside::beside(prepared))
            }
            #[inline(always)]
            fn advance_beside<const L: usize>(
                beside: &Self::Beside<{ L }>,
                t: f64,
                h: f64,
                q: &mut [Lanes<{ L }>],
                p: &mut [Lanes<{ L }>],
                dw: &[Lanes<{ L }>],
                memory: &mut Self::Memory<Lanes<{ L }>>,
            ) -> Result<Effort, StepFailure> {
                let (prepared, carry) = (beside, &mut Plain);
                let (q, p) = (wzvi::array_mut(q)?, wzvi::array_mut(p)?);
                wzvi::increments::<_, 0>(dw)?;
                let mut next = Solution::nowhere();
                let solved = solve::<
                    Lanes<{ L }>,
                    Lanes<{ L }>,
                    Plain,
                    false,
                >(prepared, h, *q, *p, memory, carry, &mut next);
                next.arrive(solved, q, p, carry)
            }
            fn discrete_lagrangian(
                &self,
                segment: &Segment<Self::Vector>,
                dw: &[f64],
            ) -> f64 {
                let h = segment.h;
                let (&[x_start, y_start], &[x_end, y_end], &[px, py], &[]) = (
                    Vector::components(&segment.q0),
                    Vector::components(&segment.q1),
                    Vector::components(&segment.p),
                    dw,
                ) else {
                    return f64::NAN;
                };
                let product = (y_start + y_end) * 0.5;
                let product2 = (x_start + x_end) * 0.5;
                let product2_squared = product2 * product2;
                let product_squared = product * product;
                let difference = px * (x_end - x_start)
                    - (product
                        * (product2_squared - product_squared * 0.3333333333333333)
                        + (product_squared + (product2_squared + (py * py + px * px)))
                            * 0.5) * h;
                py * (y_end - y_start) + difference
            }
            fn discrete_lagrangian_gradient(
                &self,
                segment: &Segment<Self::Vector>,
                dw: &[f64],
            ) -> LagrangianGradient<Self::Vector> {
                let h = segment.h;
                let (&[x_start, y_start], &[x_end, y_end], &[px, py], &[]) = (
                    Vector::components(&segment.q0),
                    Vector::components(&segment.q1),
                    Vector::components(&segment.p),
                    dw,
                ) else {
                    return LagrangianGradient::not_a_number();
                };
                let product = (y_start + y_end) * 0.5;
                let product2 = (x_start + x_end) * 0.5;
                let half_h = 0.5 * h;
                let product3 = (product * 2.0 + 1.0) * product2 * half_h;
                let product4 = (product * (-product + 1.0) + product2 * product2)
                    * half_h;
                LagrangianGradient::from_components(
                    [-(px + product3), -(py + product4)],
                    [px - product3, py - product4],
                    [x_end - x_start - px * h, y_end - y_start - py * h],
                )
            }
            fn step_momentum(
                &self,
                before: &State<Self::Vector>,
                after: &State<Self::Vector>,
                h: f64,
                dw: &[f64],
            ) -> Self::Vector {
                before.p + (after.p - before.p) * 0.5
            }
        }
    };
    wzvi::composition! {
        [impl < W : Composes < Midpoint, General > > Discretized < Composed < Midpoint, W
        > > for HenonHeiles] Composed < Midpoint, W >, < General as Structure < Midpoint
        >> ::Sequence, < W as Composes < Midpoint, General > > ::ORDER, Equations:: <
        Self, Midpoint, General, W, { 1109 + ROOM } > ::ALL, < W as Composes < Midpoint,
        General > > ::substeps()
    }
    #[automatically_derived]
    impl Conservative for HenonHeiles {}
    /// The names that are bound above, so that no constant around can stand for them.
    use ::wzvi::__private::{
        binding as after, binding as before, binding as beside, binding as by_p,
        binding as by_q, binding as carry, binding as constants, binding as delta_px,
        binding as delta_py, binding as difference, binding as dw, binding as effort,
        binding as given, binding as h, binding as h_squared, binding as half_h,
        binding as half_h_squared, binding as iterate, binding as lane,
        binding as memory, binding as next, binding as node_px, binding as node_py,
        binding as number, binding as p, binding as prepared, binding as product,
        binding as product2, binding as product2_squared, binding as product3,
        binding as product4, binding as product_squared, binding as px, binding as py,
        binding as q, binding as quarter_h_squared, binding as segment,
        binding as solved, binding as stage_x, binding as stage_y, binding as sum,
        binding as systems, binding as t, binding as taken, binding as term,
        binding as twice_stage_y, binding as unknowns, binding as x, binding as x_end,
        binding as x_squared, binding as x_start, binding as y, binding as y_end,
        binding as y_squared, binding as y_start,
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
    impl ::wzvi::__private::checks::Checked for HenonHeiles {
        fn check(&self) {
            ::wzvi::__private::checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(::core::marker::PhantomData::<Midpoint>);
            {
                ::wzvi::__private::checks::of_state::<
                    [::core::primitive::f64; 2usize],
                    _,
                >(|[x, y], [px, py]| {
                    0.5 * (px * px + py * py + x * x + y * y) + x * x * y
                        - y.powi(3) / 3.0
                });
            }
        }
    }
};
