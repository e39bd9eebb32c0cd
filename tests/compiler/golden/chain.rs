// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[f64], p: &[f64]| { let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4); p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (0..q.len() - 1).map(|i| v(q[i + 1] - q[i])).sum::<f64>() + v(q[0]) }, embedding = Midpoint)]
// pub struct Chain { pub beta: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = q[0]²/2 + beta q[0]^4/4 + Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..n - 2) [(q[i + 1] - q[i])²/2 + beta (q[i + 1] - q[i])^4/4]

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = P · Δq - h H0(P, q_{1/2})
  Δq = q' - q
  q_{1/2} = q + 1/2 Δq

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q_{1/2})
  p = -D1 L_d:  P = p + v,  v = -1/2 h ∂H0/∂q(P, q_{1/2})
  p' = D2 L_d:  p' = P - 1/2 h ∂H0/∂q(P, q_{1/2})
  with these contributions to the slopes
    ∂H0/∂p[i] += p[i]   for i=0..n - 1
    ∂H0/∂q[i + 1] += q[i + 1] - q[i] + beta (q[i + 1] - q[i])³   for i=0..n - 2
    ∂H0/∂q[i] += q[i] - q[i + 1] - beta (q[i + 1] - q[i])³   for i=0..n - 2
    ∂H0/∂q[0] += q[0] + beta q[0]³

Step
  solve for v (then Δq): by x <- φ(x) while that contracts, else Newton's method with the Jacobian in a band, or with GMRES where the band is wide

Facts
  H0 is a first integral: kept by the step nearly, within O(h²)
  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)
    H_pp(H_q,H_q) = (q[0] + beta q[0]³)² + (where min(1, n - 1) > 0) [2 (q[0] + beta q[0]³) (q[0] - q[1] - beta (q[1] - q[0])³)] + Σ_(i=0..n - 2) [(q[i + 1] - q[i] + beta (q[i + 1] - q[i])³)² + (q[i] - q[i + 1] - beta (q[i + 1] - q[i])³)²] + Σ_(i=0..n - 3) [2 (q[i + 1] - q[i] + beta (q[i + 1] - q[i])³) (q[i + 1] - q[i + 2] - beta (q[i + 2] - q[i + 1])³)]
    H_qq(H_p,H_p) = p[0]² (1 + 3 beta q[0]²) + Σ_(i=0..n - 2) [p[i + 1] (p[i + 1] (1 + 3 beta (q[i + 1] - q[i])²) + p[i] (-3 beta (q[i + 1] - q[i])² - 1)) + p[i] (p[i + 1] (-3 beta (q[i + 1] - q[i])² - 1) + p[i] (1 + 3 beta (q[i + 1] - q[i])²))]

```
*/
pub struct Chain {
    pub beta: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Conservative, DVector, Discretized, Facts, FnMut, Number, Option,
        Scalar, Scheme, Sized, Some, bool, f64, isize, str, usize, compose::General,
        elements::{
            AdjacentSums, ElementInput, Elements, EvaluationPoint, HessianBlock, InLoops,
            Loops, MomentumUpdate, Partials, Quadrature, QuadraturePoint, Role, Sums,
        },
        elements::places::{Index, Nest, Places, Slot},
        embedding::Midpoint, gauss::Dynamic,
    };
    #[automatically_derived]
    impl Elements for Chain {
        const FACTS: Facts = Facts {
            has_tiles: true,
            has_one_velocity: true,
            ..Facts::autonomous(usize::MAX)
        };
        type Shape = Dynamic;
        type Structure = General;
        type Vector = DVector<f64>;
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("beta", self.beta)].get(index).copied()
        }
        const PLACES: Places = Places {
            components: 1,
            tables: &[],
            nests: &[Nest::new(&[], &[Slot::Natural(Index::new(&[], 0, "0"))])],
        };
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let beta = at.parameter(0, self.beta);
            let size = at.degrees() as isize;
            match role {
                Role::Drift => {
                    let mut total = S::from_f64(0.0);
                    {
                        let mut b0 = S::from_f64(0.0);
                        if let (i0, len @ 1..) = wzvi::elements::stretch(0, size) {
                            let first0 = i0 as usize;
                            let s0 = &at.p[first0..first0 + len];
                            for place in 0..len {
                                let p_i = s0[place];
                                b0 = b0 + p_i * p_i * 0.5;
                            }
                        }
                        total = total + b0;
                    }
                    {
                        let quarter_beta = S::of_constant(beta * 0.25);
                        let mut b0 = S::from_f64(0.0);
                        if let (i1, len @ 1..) = wzvi::elements::stretch(0, size - 1) {
                            let first0 = (i1 + 1) as usize;
                            let first1 = i1 as usize;
                            let s0 = &at.q[first0..first0 + len];
                            let s1 = &at.q[first1..first1 + len];
                            for place in 0..len {
                                let q_i_plus_1 = s0[place];
                                let q_i = s1[place];
                                let difference = q_i_plus_1 - q_i;
                                let difference_squared = difference * difference;
                                b0 = b0
                                    + difference_squared
                                        * (quarter_beta * difference_squared + 0.5);
                            }
                        }
                        total = total + b0;
                    }
                    {
                        let quarter_beta = S::of_constant(beta * 0.25);
                        let q0 = at.q[0];
                        let q0_squared = q0 * q0;
                        total = total + q0_squared * (quarter_beta * q0_squared + 0.5);
                    }
                    total * S::of_constant(at.h)
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
            use AdjacentSums as _;
            let beta = at.parameter(0, self.beta);
            let size = at.degrees() as isize;
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        if let (i0, len @ 1..) = by_p.stretch::<1, _>(0, size, [0]) {
                            let first0 = i0 as usize;
                            let s0 = &at.p[first0..first0 + len];
                            let mut b0 = by_p.run(first0, len);
                            for place in 0..len {
                                let p_i = T::of(s0[place]);
                                b0.add(place, p_i * factor);
                            }
                        }
                    }
                    if partials.by_q {
                        let beta = T::of_constant(beta);
                        let factor = T::of_constant(at.h);
                        if let (i1, len @ 1..) = by_q
                            .stretch::<1, _>(0, size - 1, [1, 0])
                        {
                            let first0 = (i1 + 1) as usize;
                            let first1 = i1 as usize;
                            let s0 = &at.q[first0..first0 + len];
                            let s1 = &at.q[first1..first1 + len];
                            let at1 = first0 + (len - 1);
                            let mut carried1 = T::from_f64(0.0);
                            let mut b1 = by_q.run(first1, len);
                            for place in 0..len {
                                let q_i_plus_1 = T::of(s0[place]);
                                let q_i = T::of(s1[place]);
                                let difference = q_i_plus_1 - q_i;
                                let product = (beta * (difference * difference) + 1.0)
                                    * (factor * difference);
                                let ahead = product;
                                b1.add(place, -product + carried1);
                                carried1 = ahead;
                            }
                            wzvi::drop(b1);
                            by_q.add(at1, carried1);
                        }
                    }
                    if partials.by_q {
                        let beta = T::of_constant(beta);
                        let factor = T::of_constant(at.h);
                        if by_q.clip::<1, _>(1, [0]).1 > 0 {
                            let q0 = T::of(at.q[0]);
                            by_q.add(0, (beta * (q0 * q0) + 1.0) * (q0 * factor));
                        }
                    }
                }
                _ => {}
            }
        }
        fn hessian<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
            partials: Partials,
            into: &mut impl FnMut(HessianBlock, [usize; 2], bool, S),
        ) {
            let beta = at.parameter(0, self.beta);
            let size = at.degrees() as isize;
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let factor = S::of_constant(at.h);
                        if let (i0, len @ 1..) = wzvi::elements::stretch(0, size) {
                            for place in 0..len {
                                let i0 = i0 + place as isize;
                                into(
                                    HessianBlock::PP,
                                    [i0 as usize, i0 as usize],
                                    true,
                                    factor,
                                );
                            }
                        }
                    }
                    if partials.by_q {
                        let three_beta = S::of_constant(beta * 3.0);
                        let factor = S::of_constant(at.h);
                        if let (i1, len @ 1..) = wzvi::elements::stretch(0, size - 1) {
                            let first0 = (i1 + 1) as usize;
                            let first1 = i1 as usize;
                            let s0 = &at.q[first0..first0 + len];
                            let s1 = &at.q[first1..first1 + len];
                            for place in 0..len {
                                let i1 = i1 + place as isize;
                                let q_i_plus_1 = s0[place];
                                let q_i = s1[place];
                                let difference = q_i_plus_1 - q_i;
                                let product = factor
                                    * (three_beta * (difference * difference) + 1.0);
                                into(
                                    HessianBlock::QQ,
                                    [(i1 + 1) as usize, (i1 + 1) as usize],
                                    true,
                                    product,
                                );
                                into(
                                    HessianBlock::QQ,
                                    [(i1 + 1) as usize, i1 as usize],
                                    false,
                                    -product,
                                );
                                into(
                                    HessianBlock::QQ,
                                    [i1 as usize, i1 as usize],
                                    true,
                                    product,
                                );
                            }
                        }
                    }
                    if partials.by_q {
                        let three_beta = S::of_constant(beta * 3.0);
                        let factor = S::of_constant(at.h);
                        let q0 = at.q[0];
                        into(
                            HessianBlock::QQ,
                            [0, 0],
                            true,
                            factor * (three_beta * (q0 * q0) + 1.0),
                        );
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl Discretized<Midpoint> for Chain {
        type Scheme = Loops<Midpoint>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = q[0]²/2 + beta q[0]^4/4 + Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..n - 2) [(q[i + 1] - q[i])²/2 + beta (q[i + 1] - q[i])^4/4]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = P · Δq - h H0(P, q_{1/2})\n  Δq = q' - q\n  q_{1/2} = q + 1/2 Δq\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q_{1/2})\n  p = -D1 L_d:  P = p + v,  v = -1/2 h ∂H0/∂q(P, q_{1/2})\n  p' = D2 L_d:  p' = P - 1/2 h ∂H0/∂q(P, q_{1/2})\n  with these contributions to the slopes\n    ∂H0/∂p[i] += p[i]   for i=0..n - 1\n    ∂H0/∂q[i + 1] += q[i + 1] - q[i] + beta (q[i + 1] - q[i])³   for i=0..n - 2\n    ∂H0/∂q[i] += q[i] - q[i + 1] - beta (q[i + 1] - q[i])³   for i=0..n - 2\n    ∂H0/∂q[0] += q[0] + beta q[0]³\n\nStep\n  solve for v (then Δq): by x <- φ(x) while that contracts, else Newton's method with the Jacobian in a band, or with GMRES where the band is wide\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²)\n  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 - H_qq(H_p,H_p)/24)\n    H_pp(H_q,H_q) = (q[0] + beta q[0]³)² + (where min(1, n - 1) > 0) [2 (q[0] + beta q[0]³) (q[0] - q[1] - beta (q[1] - q[0])³)] + Σ_(i=0..n - 2) [(q[i + 1] - q[i] + beta (q[i + 1] - q[i])³)² + (q[i] - q[i + 1] - beta (q[i + 1] - q[i])³)²] + Σ_(i=0..n - 3) [2 (q[i + 1] - q[i] + beta (q[i + 1] - q[i])³) (q[i + 1] - q[i + 2] - beta (q[i + 2] - q[i + 1])³)]\n    H_qq(H_p,H_p) = p[0]² (1 + 3 beta q[0]²) + Σ_(i=0..n - 2) [p[i + 1] (p[i + 1] (1 + 3 beta (q[i + 1] - q[i])²) + p[i] (-3 beta (q[i + 1] - q[i])² - 1)) + p[i] (p[i + 1] (-3 beta (q[i + 1] - q[i])² - 1) + p[i] (1 + 3 beta (q[i + 1] - q[i])²))]\n";
        const IN_LOOPS: Option<InLoops> = Some(InLoops {
            order: 2,
            is_consistent: true,
            quadrature: Quadrature {
                remembers: true,
                ..Quadrature::new(
                    &[QuadraturePoint::new([0.5, 0.5, 0.5], &[Role::Drift.times(1.0)])],
                    MomentumUpdate::Multiple(2.0),
                )
            },
        });
    }
    #[automatically_derived]
    impl Conservative for Chain {}
    wzvi::bindings! {
        ahead at at1 b0 b1 beta by_p by_q carried1 difference difference_squared factor
        first0 first1 i0 i1 index into len p_i partials place product q0 q0_squared q_i
        q_i_plus_1 quarter_beta role s0 s1 size three_beta total weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Chain {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(checks::PhantomData::<Midpoint>);
            {
                let beta = self.beta;
                checks::of_state::<
                    &[::core::primitive::f64],
                    _,
                >(|q: &[f64], p: &[f64]| {
                    let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
                    p.iter().map(|p| 0.5 * p * p).sum::<f64>()
                        + (0..q.len() - 1).map(|i| v(q[i + 1] - q[i])).sum::<f64>()
                        + v(q[0])
                });
            }
        }
    }
};
