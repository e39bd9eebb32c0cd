// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px / m + py * py / n) + 0.5 * k * (x * x + y * y) + c * x * y, embedding = Midpoint)]
// pub struct Oscillators { pub m: f64, pub n: f64, pub k: f64, pub c: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = (px²/m + py²/n)/2 + c x y + k (x² + y²)/2

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P_{px} Δx + P_{py} Δy - h ((P_{px}²/m + P_{py}²/n)/2 + c x_{i+1/2} y_{i+1/2} + k (x_{i+1/2}² + y_{i+1/2}²)/2)
  Δx = x_{i+1} - x_i
  Δy = y_{i+1} - y_i
  x_{i+1/2} = x_i + Δx/2
  y_{i+1/2} = y_i + Δy/2

Discrete Euler-Lagrange equations
  ∂L_d/∂P_{px} = 0:  Δx = h P_{px}/m
  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (k x_{i+1/2} + c y_{i+1/2})/2
  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx
  ∂L_d/∂P_{py} = 0:  Δy = h P_{py}/n
  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (c x_{i+1/2} + k y_{i+1/2})/2
  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy

Step
  solve for δpx, δpy: linear (then Δx, Δy)

Facts
  H0 is a first integral: kept by the step to rounding
  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)
    H_pp(H_q,H_q) = (k x + c y)²/m + (c x + k y)²/n
    H_qq(H_p,H_p) = px (k px/m + c py/n)/m + py (c px/m + k py/n)/n

```
*/
pub struct Oscillators {
    pub m: f64,
    pub n: f64,
    pub k: f64,
    pub c: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, ComputesWith, ConfigError, Conservative, Constant, ConstantsIn,
        Discretized, Effort, Err, Factored, Facts, Labels, LiftParameter, Number, Ok,
        Option, PhantomData, PlainSum, Plan, Reals, Result, SVector, Scalar, Scheme,
        Sized, Solution, Solver, StateSum, StepFailure, Straight, StraightLine,
        Variables, bool, f64, str, usize, compose::General,
        elements::{
            ElementInput, Elements, EvaluationPoint, MomentumUpdate, Partials,
            Quadrature, QuadraturePoint, Role, Sums,
        },
        embedding::Midpoint, gauss::Fixed,
    };
    #[automatically_derived]
    impl Elements for Oscillators {
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
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("m", self.m), ("n", self.n), ("k", self.k), ("c", self.c)]
                .get(index)
                .copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let m = at.parameter(0, self.m);
            let n = at.parameter(1, self.n);
            let k = at.parameter(2, self.k);
            let c = at.parameter(3, self.c);
            match role {
                Role::Drift => {
                    let inverse_m = S::of_constant(m.recip());
                    let inverse_n = S::of_constant(n.recip());
                    let half_k = S::of_constant(k * 0.5);
                    let c = S::of_constant(c);
                    let x = at.q[0];
                    let y = at.q[1];
                    let px = at.p[0];
                    let py = at.p[1];
                    let sum = (x * x + y * y) * half_k
                        + ((inverse_m * (px * px) + inverse_n * (py * py)) * 0.5
                            + c * (x * y));
                    sum * S::of_constant(at.h)
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
            let m = at.parameter(0, self.m);
            let n = at.parameter(1, self.n);
            let k = at.parameter(2, self.k);
            let c = at.parameter(3, self.c);
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let inverse_m = T::of_constant(m.recip());
                        let inverse_n = T::of_constant(n.recip());
                        let factor_ = T::of_constant(at.h);
                        let px = T::of(at.p[0]);
                        let py = T::of(at.p[1]);
                        by_p.add(0, inverse_m * (px * factor_));
                        by_p.add(1, inverse_n * (py * factor_));
                    }
                    if partials.by_q {
                        let k = T::of_constant(k);
                        let c = T::of_constant(c);
                        let factor_ = T::of_constant(at.h);
                        let x = T::of(at.q[0]);
                        let y = T::of(at.q[1]);
                        by_q.add(0, factor_ * (x * k + y * c));
                        by_q.add(1, factor_ * (x * c + y * k));
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl StraightLine<Midpoint, 2, 0> for Oscillators {
        const PLAN: Plan = <Self as Elements>::FACTS.plan(Solver::Linear, 2, 2, true);
        const QUADRATURE: Quadrature = Quadrature::new(
            &[QuadraturePoint::new([0.5, 0.5, 0.5], &[Role::Drift.times(1.0)])],
            MomentumUpdate::Multiple(2.0),
        );
        type Prepared = (Reals<7>, Factored<2>);
        type Memory<S: Scalar> = PhantomData<S>;
        type Sum<S: Scalar> = PlainSum;
        fn prepare<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
            h: K,
        ) -> Result<ConstantsIn<Self::Prepared, K>, ConfigError> {
            let m = lift(0, self.m);
            let n = lift(1, self.n);
            let k = lift(2, self.k);
            let c = lift(3, self.c);
            if m.magnitude().is_nan() || n.magnitude().is_nan() || k.magnitude().is_nan()
                || c.magnitude().is_nan()
            {
                return Err(ConfigError::Parameter);
            }
            let product = h * h * 0.25;
            let product2 = product * k;
            let product3 = product * c;
            let factor = wzvi::prepared(
                h,
                <K as Constant>::factor([
                    [product2 / m + 1.0, product3 / n],
                    [product3 / m, product2 / n + 1.0],
                ]),
            )?;
            let half_h = h * 0.5;
            Ok(([k, c, half_h, half_h / m, half_h / n, h / m, h / n], factor))
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
            let (
                [k,
                c,
                half_h,
                quotient,
                quotient2,
                quotient3,
                quotient4,
                ],
                ref factor,
            ) = *prepared;
            let sum = x + px * quotient;
            let sum2 = y + py * quotient2;
            let [delta_px, delta_py] = <S as ComputesWith<
                K,
            >>::solve_factored(
                factor,
                [-((sum * k + sum2 * c) * half_h), -((sum * c + sum2 * k) * half_h)],
            );
            let node_px = px + delta_px;
            let delta_x = node_px * quotient3;
            let node_py = py + delta_py;
            let delta_y = node_py * quotient4;
            *next = Solution::new(
                carry,
                [[x, y], [px, py]],
                [[delta_x, delta_y], [delta_px * 2.0, delta_py * 2.0]],
                Effort::fast(0),
            );
            next.ensure_finite()
        }
    }
    #[automatically_derived]
    impl Discretized<Midpoint> for Oscillators {
        type Scheme = Straight<Midpoint, 2, 0>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = (px²/m + py²/n)/2 + c x y + k (x² + y²)/2\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P_{px} Δx + P_{py} Δy - h ((P_{px}²/m + P_{py}²/n)/2 + c x_{i+1/2} y_{i+1/2} + k (x_{i+1/2}² + y_{i+1/2}²)/2)\n  Δx = x_{i+1} - x_i\n  Δy = y_{i+1} - y_i\n  x_{i+1/2} = x_i + Δx/2\n  y_{i+1/2} = y_i + Δy/2\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P_{px} = 0:  Δx = h P_{px}/m\n  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (k x_{i+1/2} + c y_{i+1/2})/2\n  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx\n  ∂L_d/∂P_{py} = 0:  Δy = h P_{py}/n\n  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (c x_{i+1/2} + k y_{i+1/2})/2\n  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy\n\nStep\n  solve for δpx, δpy: linear (then Δx, Δy)\n\nFacts\n  H0 is a first integral: kept by the step to rounding\n  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)\n    H_pp(H_q,H_q) = (k x + c y)²/m + (c x + k y)²/n\n    H_qq(H_p,H_p) = px (k px/m + c py/n)/m + py (c px/m + k py/n)/n\n";
    }
    #[automatically_derived]
    impl Conservative for Oscillators {}
    wzvi::bindings! {
        at by_p by_q c carry coordinates delta_px delta_py delta_x delta_y factor factor_
        h half_h half_k increments index inverse_m inverse_n k lift m memory momenta n
        next node_px node_py partials prepared product product2 product3 px py quotient
        quotient2 quotient3 quotient4 role sum sum2 t weight x y
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Oscillators {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(checks::PhantomData::<Midpoint>);
            {
                let m = self.m;
                let n = self.n;
                let k = self.k;
                let c = self.c;
                checks::of_state::<
                    [::core::primitive::f64; 2usize],
                    _,
                >(|[x, y], [px, py]| {
                    0.5 * (px * px / m + py * py / n) + 0.5 * k * (x * x + y * y)
                        + c * x * y
                });
            }
        }
    }
};
