// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.5 * k * (x * x + y * y) + c * x * y, embedding = Midpoint)]
// pub struct Oscillators { pub k: f64, pub c: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = (py² + px²)/2 + k (y² + x²)/2 + x y c

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P_{px} Δx - h ((P_{py}² + P_{px}²)/2 + k (y_{i+1/2}² + x_{i+1/2}²)/2 + c x_{i+1/2} y_{i+1/2}) + P_{py} Δy
  Δx = x_{i+1} - x_i
  Δy = y_{i+1} - y_i
  x_{i+1/2} = Δx/2 + x_i
  y_{i+1/2} = Δy/2 + y_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P_{px} = 0:  Δx = P_{px} h
  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (k x_{i+1/2} + c y_{i+1/2})/2
  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx
  ∂L_d/∂P_{py} = 0:  Δy = P_{py} h
  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (k y_{i+1/2} + c x_{i+1/2})/2
  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy

Step
  solve for δpx, δpy: linear (then Δx, Δy)

Facts
  H0 is a first integral: kept by the step to rounding
  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)
    H_pp(H_q,H_q) = (x k + y c)² + (y k + x c)²
    H_qq(H_p,H_p) = px (px k + py c) + py (px c + py k)

```
*/
pub struct Oscillators {
    pub k: f64,
    pub c: f64,
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
        self as wzvi, Beside, Carry, Compensation, ConfigError, Conservative, Constant,
        Discretized, Effort, Err, Factor, Hamiltonian, Knowledge, Labels,
        LagrangianGradient, Lanes, NoiseClass, Ok, Option, Over, PhantomData, Plain,
        Plan, Result, SVector, Scalar, Segment, Solution, Solver, Some, State,
        StepFailure, Variables, Vector, bool, f64, str, usize,
        compose::{Composes, Equations, General, ROOM, Structure},
        embedding::{Composed, Midpoint},
    };
    #[automatically_derived]
    impl Hamiltonian for Oscillators {
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
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("k", self.k), ("c", self.c)].get(index).copied()
        }
        fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
            match (term, q, p) {
                (0, &[x, y], &[px, py]) => {
                    let k: f64 = self.k;
                    let c: f64 = self.c;
                    let sum = x * y * c
                        + ((py * py + px * px) * 0.5 + (y * y + x * x) * (0.5 * k));
                    sum
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
                    let k: f64 = self.k;
                    let c: f64 = self.c;
                    wzvi::gradient(by_q, by_p, [x * k + y * c, y * k + x * c], [px, py])
                }
                _ => {
                    by_q.fill(S::from_f64(f64::NAN));
                    by_p.fill(S::from_f64(f64::NAN));
                }
            }
        }
    }
    const _: () = {
        type Prepared<K> = ([K; 3], <K as Constant>::Factor<2>);
        type Memory<S> = PhantomData<S>;
        #[inline(always)]
        fn solve<S: Over<K>, K: Constant, C: Carry<S>, const CAREFUL: bool>(
            prepared: &Prepared<K>,
            h: f64,
            q: [S; 2],
            p: [S; 2],
            carry: &C,
            next: &mut Solution<S, 2>,
        ) -> Result<(), StepFailure> {
            let ([x, y], [px, py]) = (q, p);
            let ([k, c, half_h], ref factor) = *prepared;
            let sum = y + py * half_h;
            let sum2 = x + px * half_h;
            let [delta_px, delta_py] = <S as Over<
                K,
            >>::solve_factored(
                factor,
                [-((sum2 * k + sum * c) * half_h), -((sum * k + sum2 * c) * half_h)],
            );
            let node_px = px + delta_px;
            let node_py = py + delta_py;
            *next = Solution::new(
                carry,
                [[x, y], [px, py]],
                [[node_px * h, node_py * h], [delta_px * 2.0, delta_py * 2.0]],
                [node_px, node_py],
                Effort::fast(0),
            );
            if !next.is_finite() {
                return Err(StepFailure::NonFinite);
            }
            Ok(())
        }
        #[automatically_derived]
        impl Discretized<Midpoint> for Oscillators {
            const PLAN: Plan = Plan {
                solver: Solver::Linear,
                unknowns: 2,
                order: 2,
                noise: NoiseClass::None,
                consistent: true,
                conserves_energy: Knowledge::Proven,
                commuting: Knowledge::Proven,
            };
            const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = (py² + px²)/2 + k (y² + x²)/2 + x y c\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P_{px} Δx - h ((P_{py}² + P_{px}²)/2 + k (y_{i+1/2}² + x_{i+1/2}²)/2 + c x_{i+1/2} y_{i+1/2}) + P_{py} Δy\n  Δx = x_{i+1} - x_i\n  Δy = y_{i+1} - y_i\n  x_{i+1/2} = Δx/2 + x_i\n  y_{i+1/2} = Δy/2 + y_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P_{px} = 0:  Δx = P_{px} h\n  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (k x_{i+1/2} + c y_{i+1/2})/2\n  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx\n  ∂L_d/∂P_{py} = 0:  Δy = P_{py} h\n  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (k y_{i+1/2} + c x_{i+1/2})/2\n  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy\n\nStep\n  solve for δpx, δpy: linear (then Δx, Δy)\n\nFacts\n  H0 is a first integral: kept by the step to rounding\n  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)\n    H_pp(H_q,H_q) = (x k + y c)² + (y k + x c)²\n    H_qq(H_p,H_p) = px (px k + py c) + py (px c + py k)\n";
            type Prepared = Prepared<f64>;
            type Memory<S: Scalar> = Memory<S>;
            type Compensated<S: Scalar> = Compensation<S, 2>;
            type Carry<S: Scalar> = Plain;
            fn prepare(&self, h: f64) -> Result<Self::Prepared, ConfigError> {
                let k: f64 = self.k;
                let c: f64 = self.c;
                if k.is_nan() || c.is_nan() {
                    return Err(ConfigError::Parameter);
                }
                let h_squared = h * h;
                let sum = 1.0 + h_squared * (0.25 * k);
                let product = 0.25 * c * h_squared;
                let factor = wzvi::prepared(
                    h,
                    Factor::new([[sum, product], [product, sum]]),
                )?;
                Ok(([k, c, 0.5 * h], factor))
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
                solve::<S, f64, C, { CAREFUL }>(prepared, h, *q, *p, carry, &mut next)?;
                Ok(next.store(q, p, carry))
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
                solve::<
                    Lanes<{ L }>,
                    Lanes<{ L }>,
                    Plain,
                    false,
                >(prepared, h, *q, *p, carry, &mut next)?;
                Ok(next.store(q, p, carry))
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
                let k: f64 = self.k;
                let c: f64 = self.c;
                let product = (y_start + y_end) * 0.5;
                let product2 = (x_start + x_end) * 0.5;
                let sum = product * product2 * c
                    + ((py * py + px * px) * 0.5
                        + (product * product + product2 * product2) * (0.5 * k));
                py * (y_end - y_start) + (px * (x_end - x_start) - sum * h)
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
                let k: f64 = self.k;
                let c: f64 = self.c;
                let product = (y_start + y_end) * 0.5;
                let product2 = (x_start + x_end) * 0.5;
                let half_h = 0.5 * h;
                let product3 = (product2 * k + product * c) * half_h;
                let product4 = (product * k + product2 * c) * half_h;
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
        > > for Oscillators] Composed < Midpoint, W >, < General as Structure < Midpoint
        >> ::Sequence, < W as Composes < Midpoint, General > > ::ORDER, Equations:: <
        Self, Midpoint, General, W, { 1023 + ROOM } > ::ALL, < W as Composes < Midpoint,
        General > > ::substeps()
    }
    #[automatically_derived]
    impl Conservative for Oscillators {}
    /// The names that are bound above, so that no constant around can stand for them.
    use ::wzvi::__private::{
        binding as after, binding as before, binding as beside, binding as by_p,
        binding as by_q, binding as c, binding as carry, binding as delta_px,
        binding as delta_py, binding as dw, binding as factor, binding as h,
        binding as h_squared, binding as half_h, binding as index, binding as k,
        binding as memory, binding as next, binding as node_px, binding as node_py,
        binding as p, binding as prepared, binding as product, binding as product2,
        binding as product3, binding as product4, binding as px, binding as py,
        binding as q, binding as segment, binding as sum, binding as sum2,
        binding as systems, binding as t, binding as term, binding as x,
        binding as x_end, binding as x_start, binding as y, binding as y_end,
        binding as y_start,
    };
};
const _: () = {
    #[allow(
        warnings,
        unused,
        clippy::all,
        clippy::pedantic,
        clippy::nursery,
        clippy::restriction,
        clippy::cargo
    )]
    trait __WzviTypeChecks {
        fn __wzvi_type_checks(&self);
    }
    #[automatically_derived]
    #[allow(
        warnings,
        unused,
        clippy::all,
        clippy::pedantic,
        clippy::nursery,
        clippy::restriction,
        clippy::cargo
    )]
    impl __WzviTypeChecks for Oscillators {
        fn __wzvi_type_checks(&self) {
            fn __wzvi_hamiltonian<
                F: ::core::ops::Fn(
                        [::core::primitive::f64; 2usize],
                        [::core::primitive::f64; 2usize],
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_hamiltonian_of_time<
                F: ::core::ops::Fn(
                        [::core::primitive::f64; 2usize],
                        [::core::primitive::f64; 2usize],
                        ::core::primitive::f64,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family<
                F: ::core::ops::Fn(
                        [::core::primitive::f64; 2usize],
                        [::core::primitive::f64; 2usize],
                        ::core::primitive::usize,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family_of_time<
                F: ::core::ops::Fn(
                        [::core::primitive::f64; 2usize],
                        [::core::primitive::f64; 2usize],
                        ::core::primitive::f64,
                        ::core::primitive::usize,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_scheme<E>(
                _: ::core::marker::PhantomData<E>,
                _: ::core::marker::PhantomData<E>,
            ) {}
            __wzvi_scheme(
                ::core::marker::PhantomData::<::wzvi::embedding::Midpoint>,
                ::core::marker::PhantomData::<Midpoint>,
            );
            {
                let k = self.k;
                let c = self.c;
                __wzvi_hamiltonian(|[x, y], [px, py]| {
                    0.5 * (px * px + py * py) + 0.5 * k * (x * x + y * y) + c * x * y
                });
            }
        }
    }
};
