// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(), noise = [|q, p, k| sigma * q[k]; self.sites], embedding = Midpoint)]
// pub struct Bath { pub sigma: f64, pub sites: usize }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = Σ_(i=0..n - 1) [(p[i]² + q[i]²)/2]
  H_k = sigma q[k]   for k=0..sites - 1

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = P · Δq - h H0(P, q_{1/2}) - H_W(P, q_{1/2})
  H_W = Σ_k ΔW[k] H_k
  Δq = q' - q
  q_{1/2} = q + 1/2 Δq

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q_{1/2})
  p = -D1 L_d:  P = p + v,  v = -1/2 h ∂H0/∂q(P, q_{1/2}) - 1/2 ∂H_W/∂q(P, q_{1/2})
  p' = D2 L_d:  p' = P - 1/2 h ∂H0/∂q(P, q_{1/2}) - 1/2 ∂H_W/∂q(P, q_{1/2})
  with these contributions to the slopes
    ∂H0/∂p[i] += p[i]   for i=0..n - 1
    ∂H0/∂q[i] += q[i]   for i=0..n - 1
    ∂H_W/∂q[i] += sigma ΔW[i]   for i=0..sites - 1

Step
  solve for v (then Δq): linear; a band is factored once, a wide matrix is iterated

Facts
  converges to the Stratonovich system; D = 0
  h → 0, then ε → 0: X_{ε,n} → X_ε → X
  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving
  Σ_k {H_k, H0} = Σ_(i=0..sites - 1) [-sigma p[i]]
  the noises commute up to a constant
  H0 is not a first integral

```
*/
pub struct Bath {
    pub sigma: f64,
    pub sites: usize,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, DVector, Discretized, Facts, FnMut, Knowledge, NoiseClass, Number,
        Option, Ord, Range, Scalar, Scheme, Sized, Some, bool, f64, i128, isize, str,
        usize, compose::General,
        elements::{
            AdjacentSums, ElementInput, Elements, EvaluationPoint, HessianBlock, InLoops,
            Linearity, Loops, MomentumUpdate, Partials, Quadrature, QuadraturePoint,
            Role, Sums,
        },
        elements::places::{Atom, Entries, Index, Loop, Name, Nest, Places, Slot},
        embedding::Midpoint, gauss::Dynamic,
    };
    #[automatically_derived]
    impl Elements for Bath {
        const FACTS: Facts = Facts {
            noise: NoiseClass::Additive,
            conserves_energy: Knowledge::Refuted,
            has_tiles: true,
            has_one_velocity: true,
            has_constant_curvature: true,
            coupled_degrees: Some(1),
            ..Facts::autonomous(usize::MAX)
        };
        type Shape = Dynamic;
        type Structure = General;
        type Vector = DVector<f64>;
        fn noises(&self) -> usize {
            (self.sites as isize) as usize
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("sigma", self.sigma)].get(index).copied()
        }
        const PLACES: Places = Places {
            components: 1,
            tables: &[Name::new("sites", "")],
            nests: &[
                Nest::new(
                    &[
                        Loop(
                            Index::new(&[], 0, "0"),
                            Index::new(&[(Atom::Given(0, &[]), 1)], 0, "sites"),
                        ),
                    ],
                    &[Slot::Natural(Index::new(&[(Atom::Loop(0), 1)], 0, "i"))],
                ),
            ],
        };
        fn entries(
            &self,
            table: usize,
            outer: &[usize],
            range: Range<usize>,
        ) -> Entries {
            match (table, outer) {
                (0usize, []) => Entries::of_integer((self.sites) as i128),
                _ => Entries::of_length(0),
            }
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let sigma = at.parameter(0, self.sigma);
            let size = at.degrees() as isize;
            match role {
                Role::Drift => {
                    let mut b0 = S::from_f64(0.0);
                    if let (i0, len @ 1..) = wzvi::elements::stretch(0, size) {
                        let first0 = i0 as usize;
                        let s0 = &at.p[first0..first0 + len];
                        let s1 = &at.q[first0..first0 + len];
                        for place in 0..len {
                            let p_i = s0[place];
                            let q_i = s1[place];
                            b0 = b0 + (p_i * p_i + q_i * q_i) * 0.5;
                        }
                    }
                    b0 * S::of_constant(at.h)
                }
                Role::Noise => {
                    let sigma = S::of_constant(sigma);
                    let mut b0 = S::from_f64(0.0);
                    if let (i1, len @ 1..) = wzvi::elements::stretch(
                        Ord::max(0, at.acting.start as isize),
                        Ord::min((self.sites as isize), at.acting.end as isize),
                    ) {
                        let first0 = i1 as usize;
                        let s0 = &at.q[first0..first0 + len];
                        for place in 0..len {
                            let i1 = i1 + place as isize;
                            let q_i = s0[place];
                            let factor = at.increment(i1 as usize);
                            b0 = b0 + sigma * (q_i * factor);
                        }
                    }
                    b0
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
            let sigma = at.parameter(0, self.sigma);
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
                        let factor = T::of_constant(at.h);
                        if let (i0, len @ 1..) = by_q.stretch::<1, _>(0, size, [0]) {
                            let first0 = i0 as usize;
                            let s0 = &at.q[first0..first0 + len];
                            let mut b0 = by_q.run(first0, len);
                            for place in 0..len {
                                let q_i = T::of(s0[place]);
                                b0.add(place, q_i * factor);
                            }
                        }
                    }
                }
                Role::Noise => {
                    if partials.by_q {
                        let sigma = T::of_constant(sigma);
                        let i1: isize = Ord::max(0, at.acting.start as isize);
                        if let (i1, len @ 1..) = by_q
                            .stretch::<
                                1,
                                _,
                            >(
                                i1,
                                Ord::min((self.sites as isize), at.acting.end as isize),
                                [i1 as usize],
                            )
                        {
                            let first0 = i1 as usize;
                            let mut b0 = by_q.run(first0, len);
                            for place in 0..len {
                                let i1 = i1 + place as isize;
                                let factor = T::of(at.increment(i1 as usize));
                                b0.add(place, factor * sigma);
                            }
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
                        let factor = S::of_constant(at.h);
                        if let (i0, len @ 1..) = wzvi::elements::stretch(0, size) {
                            for place in 0..len {
                                let i0 = i0 + place as isize;
                                into(
                                    HessianBlock::QQ,
                                    [i0 as usize, i0 as usize],
                                    true,
                                    factor,
                                );
                            }
                        }
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl Discretized<Midpoint> for Bath {
        type Scheme = Loops<Midpoint>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Midpoint\n\nHamiltonians\n  H0 = Σ_(i=0..n - 1) [(p[i]² + q[i]²)/2]\n  H_k = sigma q[k]   for k=0..sites - 1\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = P · Δq - h H0(P, q_{1/2}) - H_W(P, q_{1/2})\n  H_W = Σ_k ΔW[k] H_k\n  Δq = q' - q\n  q_{1/2} = q + 1/2 Δq\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q_{1/2})\n  p = -D1 L_d:  P = p + v,  v = -1/2 h ∂H0/∂q(P, q_{1/2}) - 1/2 ∂H_W/∂q(P, q_{1/2})\n  p' = D2 L_d:  p' = P - 1/2 h ∂H0/∂q(P, q_{1/2}) - 1/2 ∂H_W/∂q(P, q_{1/2})\n  with these contributions to the slopes\n    ∂H0/∂p[i] += p[i]   for i=0..n - 1\n    ∂H0/∂q[i] += q[i]   for i=0..n - 1\n    ∂H_W/∂q[i] += sigma ΔW[i]   for i=0..sites - 1\n\nStep\n  solve for v (then Δq): linear; a band is factored once, a wide matrix is iterated\n\nFacts\n  converges to the Stratonovich system; D = 0\n  h → 0, then ε → 0: X_{ε,n} → X_ε → X\n  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving\n  Σ_k {H_k, H0} = Σ_(i=0..sites - 1) [-sigma p[i]]\n  the noises commute up to a constant\n  H0 is not a first integral\n";
        const IN_LOOPS: Option<InLoops> = Some(InLoops {
            order: 2,
            is_consistent: true,
            quadrature: Quadrature {
                linearity: Linearity::Constant,
                ..Quadrature::new(
                    &[
                        QuadraturePoint::new(
                            [0.5, 0.5, 0.5],
                            &[Role::Drift.times(1.0), Role::Noise.times(1.0)],
                        ),
                    ],
                    MomentumUpdate::Multiple(2.0),
                )
            },
        });
    }
    wzvi::bindings! {
        at b0 by_p by_q factor first0 i0 i1 index into len outer p_i partials place q_i
        range role s0 s1 sigma size table weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Bath {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Midpoint,
            >(checks::PhantomData::<Midpoint>);
            checks::of_state::<
                &[::core::primitive::f64],
                _,
            >(|q: &[f64], p: &[f64]| {
                (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>()
            });
            {
                let sigma = self.sigma;
                checks::family::<&[::core::primitive::f64], _>(|q, p, k| sigma * q[k]);
            }
        }
    }
};
