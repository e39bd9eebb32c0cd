// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: [[f64; 2]; N], p: [[f64; 2]; N]| { p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum::<f64>() + (0..N).map(|i| { let [x, y] = [q[(i + 1) % N][0] - q[i][0], q[(i + 1) % N][1] - q[i][1]]; 1.0 - (k * x).cos() + 0.5 * y * y }).sum::<f64>() }, embedding = DeltaPlus)]
// pub struct Lattice<const N: usize> { pub k: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
DeltaPlus

Hamiltonians
  H0 = Σ_(i=0..N - 1) [(p[2 i]² + p[2 i + 1]²)/2] + Σ_(i=0..N - 1) [1 + (q[2 ((i + 1) mod N) + 1] - q[2 i + 1])²/2 - cos(k (q[2 ((i + 1) mod N)] - q[2 i]))]

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = P · Δq - h H0(P, q)
  Δq = q' - q

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q)
  p = -D1 L_d:  P = p + v,  v = -h ∂H0/∂q(P, q)
  p' = D2 L_d:  p' = P
  with these contributions to the slopes
    ∂H0/∂p[i][0] += p[i][0]   for i=0..N - 1
    ∂H0/∂p[i][1] += p[i][1]   for i=0..N - 1
    ∂H0/∂q[((i + 1) mod N)][0] += k sin(k (q[((i + 1) mod N)][0] - q[i][0]))   for i=0..N - 1
    ∂H0/∂q[i][0] += -k sin(k (q[((i + 1) mod N)][0] - q[i][0]))   for i=0..N - 1
    ∂H0/∂q[((i + 1) mod N)][1] += q[((i + 1) mod N)][1] - q[i][1]   for i=0..N - 1
    ∂H0/∂q[i][1] += q[i][1] - q[((i + 1) mod N)][1]   for i=0..N - 1

Step
  assign v, Δq

Facts
  H0 is a first integral: kept by the step nearly, within O(h)
  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)
    H_p·H_q = Σ_(i=0..N - 1) [p[((i + 1) mod N)][1] (q[((i + 1) mod N)][1] - q[i][1]) + p[i][1] (q[i][1] - q[((i + 1) mod N)][1]) + k p[((i + 1) mod N)][0] sin(k (q[((i + 1) mod N)][0] - q[i][0])) - k p[i][0] sin(k (q[((i + 1) mod N)][0] - q[i][0]))]
    H_pp(H_q,H_q) = Σ_(i=0..N - 1) [(q[((i + 1) mod N)][1] - q[i][1])² + 2 (q[((i + 1) mod N)][1] - q[i][1]) (q[((i + 1) mod N)][1] - q[((i + 2) mod N)][1]) + (q[i][1] - q[((i + 1) mod N)][1])² + 2 k² sin(k (q[((i + 1) mod N)][0] - q[i][0]))² - 2 k² sin(k (q[((i + 1) mod N)][0] - q[i][0])) sin(k (q[((i + 2) mod N)][0] - q[((i + 1) mod N)][0]))]
    H_qq(H_p,H_p) = Σ_(i=0..N - 1) [p[((i + 1) mod N)][1] (p[((i + 1) mod N)][1] - p[i][1]) + p[i][1] (p[i][1] - p[((i + 1) mod N)][1]) + p[((i + 1) mod N)][0] (k² p[((i + 1) mod N)][0] cos(k (q[((i + 1) mod N)][0] - q[i][0])) - k² p[i][0] cos(k (q[((i + 1) mod N)][0] - q[i][0]))) + p[i][0] (k² p[i][0] cos(k (q[((i + 1) mod N)][0] - q[i][0])) - k² p[((i + 1) mod N)][0] cos(k (q[((i + 1) mod N)][0] - q[i][0])))]

```
*/
pub struct Lattice<const N: usize> {
    pub k: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Conservative, DVector, Discretized, Facts, Labels, Number, Option,
        Ord, Scalar, Scheme, Sized, Some, Variables, f64, isize, str, usize,
        compose::General,
        elements::{
            AdjacentSums, CommonRange, ElementInput, Elements, EvaluationPoint, InLoops,
            LEAST_IN_TILES, Loops, MomentumUpdate, Partials, Quadrature, QuadraturePoint,
            Role, Sums, Unknowns,
        },
        embedding::DeltaPlus, gauss::Dynamic,
    };
    #[automatically_derived]
    impl<const N: usize> Elements for Lattice<{ N }> {
        const FACTS: Facts = Facts {
            has_tiles: (N) * 2 >= LEAST_IN_TILES,
            has_one_velocity: true,
            ..Facts::autonomous((N) * 2)
        };
        type Shape = Dynamic;
        type Structure = General;
        type Vector = DVector<f64>;
        fn variables(&self) -> Variables {
            Variables {
                q: Labels::Array {
                    name: "q",
                    inner: &[2],
                },
                p: Labels::Array {
                    name: "p",
                    inner: &[2],
                },
                t: "t",
                invariants: &[],
                observables: &[],
            }
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("k", self.k)].get(index).copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let k = at.parameter(0, self.k);
            match role {
                Role::Drift => {
                    let mut total = S::from_f64(0.0);
                    {
                        let mut b0 = S::from_f64(0.0);
                        if let (i0, len @ 1..) = wzvi::elements::stretch(0, N as isize) {
                            let first0 = (2 * i0) as usize;
                            let points0 = &at
                                .p[first0..first0 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            for place in 0..len {
                                let p_2i = points0[place][0];
                                let p_2i_plus_1 = points0[place][1];
                                b0 = b0 + (p_2i * p_2i + p_2i_plus_1 * p_2i_plus_1) * 0.5;
                            }
                        }
                        total = total + b0;
                    }
                    {
                        let half_k = S::of_constant(k * 0.5);
                        let mut b0 = S::from_f64(0.0);
                        let mut i1: isize = 0;
                        let end: isize = N as isize;
                        while i1 < end {
                            let mut len = (end - i1) as usize;
                            len = Ord::min(
                                len,
                                ((N as isize) - (i1 + 1) % (N as isize)) as usize,
                            );
                            let first0 = (2 * ((i1 + 1) % (N as isize))) as usize;
                            let first1 = (2 * i1) as usize;
                            let points0 = &at
                                .q[first0..first0 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            let points1 = &at
                                .q[first1..first1 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            for place in 0..len {
                                let q_2_i_plus_1_mod_N = points0[place][0];
                                let q_2i = points1[place][0];
                                let q_2_i_plus_1_mod_N_plus_1 = points0[place][1];
                                let q_2i_plus_1 = points1[place][1];
                                let difference = q_2_i_plus_1_mod_N_plus_1 - q_2i_plus_1;
                                let sin = ((q_2_i_plus_1_mod_N - q_2i) * half_k).sin();
                                b0 = b0 + difference * difference * 0.5 + sin * sin * 2.0;
                            }
                            i1 += len as isize;
                        }
                        total = total + b0;
                    }
                    total * S::of_constant(at.h)
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
            use AdjacentSums as _;
            let k = at.parameter(0, self.k);
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        if let (i0, len @ 1..) = by_p.stretch::<2, _>(0, N as isize, [0])
                        {
                            let first0 = (2 * i0) as usize;
                            let points0 = &at
                                .p[first0..first0 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            let mut points1 = by_p.points::<2>(first0, len);
                            for place in 0..len {
                                let p_2i = T::of(points0[place][0]);
                                let p_2i_plus_1 = T::of(points0[place][1]);
                                points1.add_part(place, 1, p_2i_plus_1 * factor);
                                points1.add_part(place, 0, p_2i * factor);
                            }
                        }
                    }
                    if partials.by_q {
                        let k = T::of_constant(k);
                        let mut b3 = [T::from_f64(0.0); 256];
                        let mut b1 = [T::from_f64(0.0); 256];
                        let factor = T::of_constant(at.h);
                        let mut i1: isize = 0;
                        let end: isize = N as isize;
                        while i1 < end {
                            let mut len = (end - i1) as usize;
                            len = Ord::min(
                                len,
                                ((N as isize) - (i1 + 1) % (N as isize)) as usize,
                            );
                            let next = i1 + len as isize;
                            let (skipped, taken) = by_q
                                .clip::<
                                    2,
                                    _,
                                >(
                                    len,
                                    [
                                        (2 * ((i1 + 1) % (N as isize))) as usize,
                                        (2 * i1) as usize,
                                    ],
                                );
                            let until = skipped + taken;
                            let mut len: usize = 256;
                            len = wzvi::elements::disjoint_placements(
                                len,
                                (2 * ((i1 + 1) % (N as isize))) as usize / 2,
                                (2 * i1) as usize / 2,
                            );
                            let most = len;
                            let first0 = (2 * ((i1 + 1) % (N as isize))) as usize;
                            let first1 = (2 * i1) as usize;
                            let mut from = if skipped < most {
                                0
                            } else {
                                skipped / most * most
                            };
                            while from < until {
                                let skip = Ord::max(from, skipped);
                                from += most;
                                let len = Ord::min(from, until) - skip;
                                let first0 = first0 + 2 * skip;
                                let first1 = first1 + 2 * skip;
                                let points0 = &at
                                    .q[first0..first0 + 2 * len]
                                    .as_chunks::<2>()
                                    .0[..len];
                                let points1 = &at
                                    .q[first1..first1 + 2 * len]
                                    .as_chunks::<2>()
                                    .0[..len];
                                let mut points2 = by_q.points::<2>(first0, len);
                                let b3 = &mut b3[..len];
                                let b1 = &mut b1[..len];
                                for place in 0..len {
                                    let q_2_i_plus_1_mod_N = T::of(points0[place][0]);
                                    let q_2i = T::of(points1[place][0]);
                                    let q_2_i_plus_1_mod_N_plus_1 = T::of(points0[place][1]);
                                    let q_2i_plus_1 = T::of(points1[place][1]);
                                    let product = k
                                        * (factor * (k * (q_2_i_plus_1_mod_N - q_2i)).sin());
                                    let product2 = factor
                                        * (q_2_i_plus_1_mod_N_plus_1 - q_2i_plus_1);
                                    points2.add_part(place, 1, product2);
                                    points2.add_part(place, 0, product);
                                    b3[place] = -product2;
                                    b1[place] = -product;
                                }
                                wzvi::drop(points2);
                                {
                                    let mut run = by_q.points::<2>(first1, len);
                                    for place in 0..len {
                                        run.add_part(place, 1, b3[place]);
                                        run.add_part(place, 0, b1[place]);
                                    }
                                }
                            }
                            i1 = next;
                        }
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl<const N: usize> Discretized<DeltaPlus> for Lattice<{ N }> {
        type Scheme = Loops<DeltaPlus>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "DeltaPlus\n\nHamiltonians\n  H0 = Σ_(i=0..N - 1) [(p[2 i]² + p[2 i + 1]²)/2] + Σ_(i=0..N - 1) [1 + (q[2 ((i + 1) mod N) + 1] - q[2 i + 1])²/2 - cos(k (q[2 ((i + 1) mod N)] - q[2 i]))]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = P · Δq - h H0(P, q)\n  Δq = q' - q\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q)\n  p = -D1 L_d:  P = p + v,  v = -h ∂H0/∂q(P, q)\n  p' = D2 L_d:  p' = P\n  with these contributions to the slopes\n    ∂H0/∂p[i][0] += p[i][0]   for i=0..N - 1\n    ∂H0/∂p[i][1] += p[i][1]   for i=0..N - 1\n    ∂H0/∂q[((i + 1) mod N)][0] += k sin(k (q[((i + 1) mod N)][0] - q[i][0]))   for i=0..N - 1\n    ∂H0/∂q[i][0] += -k sin(k (q[((i + 1) mod N)][0] - q[i][0]))   for i=0..N - 1\n    ∂H0/∂q[((i + 1) mod N)][1] += q[((i + 1) mod N)][1] - q[i][1]   for i=0..N - 1\n    ∂H0/∂q[i][1] += q[i][1] - q[((i + 1) mod N)][1]   for i=0..N - 1\n\nStep\n  assign v, Δq\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h)\n  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)\n    H_p·H_q = Σ_(i=0..N - 1) [p[((i + 1) mod N)][1] (q[((i + 1) mod N)][1] - q[i][1]) + p[i][1] (q[i][1] - q[((i + 1) mod N)][1]) + k p[((i + 1) mod N)][0] sin(k (q[((i + 1) mod N)][0] - q[i][0])) - k p[i][0] sin(k (q[((i + 1) mod N)][0] - q[i][0]))]\n    H_pp(H_q,H_q) = Σ_(i=0..N - 1) [(q[((i + 1) mod N)][1] - q[i][1])² + 2 (q[((i + 1) mod N)][1] - q[i][1]) (q[((i + 1) mod N)][1] - q[((i + 2) mod N)][1]) + (q[i][1] - q[((i + 1) mod N)][1])² + 2 k² sin(k (q[((i + 1) mod N)][0] - q[i][0]))² - 2 k² sin(k (q[((i + 1) mod N)][0] - q[i][0])) sin(k (q[((i + 2) mod N)][0] - q[((i + 1) mod N)][0]))]\n    H_qq(H_p,H_p) = Σ_(i=0..N - 1) [p[((i + 1) mod N)][1] (p[((i + 1) mod N)][1] - p[i][1]) + p[i][1] (p[i][1] - p[((i + 1) mod N)][1]) + p[((i + 1) mod N)][0] (k² p[((i + 1) mod N)][0] cos(k (q[((i + 1) mod N)][0] - q[i][0])) - k² p[i][0] cos(k (q[((i + 1) mod N)][0] - q[i][0]))) + p[i][0] (k² p[i][0] cos(k (q[((i + 1) mod N)][0] - q[i][0])) - k² p[((i + 1) mod N)][0] cos(k (q[((i + 1) mod N)][0] - q[i][0])))]\n";
        const IN_LOOPS: Option<InLoops> = Some(InLoops {
            order: 1,
            is_consistent: true,
            quadrature: Quadrature {
                unknowns: Unknowns::None,
                ..Quadrature::new(
                    &[QuadraturePoint::new([0.0, 1.0, 0.0], &[Role::Drift.times(1.0)])],
                    MomentumUpdate::Multiple(1.0),
                )
            },
        });
    }
    #[automatically_derived]
    impl<const N: usize> Conservative for Lattice<{ N }> {}
    wzvi::bindings! {
        at b0 b1 b3 by_p by_q difference end factor first0 first1 from half_k i0 i1 index
        k len most next p_2i p_2i_plus_1 partials place points0 points1 points2 product
        product2 q_2_i_plus_1_mod_N q_2_i_plus_1_mod_N_plus_1 q_2i q_2i_plus_1 role run
        sin skip skipped taken total until weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl<const N: usize> Lattice<{ N }> {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::DeltaPlus,
            >(checks::PhantomData::<DeltaPlus>);
            {
                let k = self.k;
                checks::of_state::<
                    [[::core::primitive::f64; 2usize]; N],
                    _,
                >(|q: [[f64; 2]; N], p: [[f64; 2]; N]| {
                    p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1])).sum::<f64>()
                        + (0..N)
                            .map(|i| {
                                let [x, y] = [
                                    q[(i + 1) % N][0] - q[i][0],
                                    q[(i + 1) % N][1] - q[i][1],
                                ];
                                1.0 - (k * x).cos() + 0.5 * y * y
                            })
                            .sum::<f64>()
                });
            }
        }
    }
};
