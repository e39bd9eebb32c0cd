// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[[f64; 2]], p: &[[f64; 2]]| { (0..q.len()).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / mass[i]).sum::<f64>() - (0..q.len()).map(|i| (0..i).map(|j| { let (x, y) = (q[i][0] - q[j][0], q[i][1] - q[j][1]); g * mass[i] * mass[j] / (x * x + y * y).sqrt() }).sum::<f64>()).sum::<f64>() }, embedding = DeltaPlus)]
// pub struct Bodies { pub g: f64, pub mass: Vec<f64> }

use wzvi::prelude::*;

/**
# Discrete equations

```text
DeltaPlus

Hamiltonians
  H0 = Σ_(i=0..n - 1) [(p[2 i]² + p[2 i + 1]²)/(2 mass[i])] + Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j]/√((q[2 i] - q[2 j])² + (q[2 i + 1] - q[2 j + 1])²)]

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = P · Δq - h H0(P, q)
  Δq = q' - q

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q)
  p = -D1 L_d:  P = p + v,  v = -h ∂H0/∂q(P, q)
  p' = D2 L_d:  p' = P
  with these contributions to the slopes
    ∂H0/∂p[i][0] += p[i][0]/mass[i]   for i=0..n - 1
    ∂H0/∂p[i][1] += p[i][1]/mass[i]   for i=0..n - 1
    ∂H0/∂q[i][0] += g mass[i] mass[j] (q[i][0] - q[j][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)   for i=0..n - 1, j=0..i - 1
    ∂H0/∂q[j][0] += g mass[i] mass[j] (q[j][0] - q[i][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)   for i=0..n - 1, j=0..i - 1
    ∂H0/∂q[i][1] += g mass[i] mass[j] (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)   for i=0..n - 1, j=0..i - 1
    ∂H0/∂q[j][1] += g mass[i] mass[j] (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)   for i=0..n - 1, j=0..i - 1

Step
  assign v, Δq

Facts
  H0 is a first integral: kept by the step nearly, within O(h)
  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)
    H_p·H_q = Σ_(i=0..n - 1) Σ_(j=0..i - 1) [g mass[j] p[i][0] (q[i][0] - q[j][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) + g mass[j] p[i][1] (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) + g mass[i] p[j][0] (q[j][0] - q[i][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) + g mass[i] p[j][1] (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)]
    H_pp(H_q,H_q) = Σ_(i=0..n - 1) Σ_(j=0..i - 1) Σ_(k=0..i - 1) [g² mass[i] mass[j] mass[k] (q[i][0] - q[j][0]) (q[i][0] - q[k][0])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[i][0] - q[k][0])² + (q[i][1] - q[k][1])²)^(3/2)) + g² mass[i] mass[j] mass[k] (q[i][1] - q[j][1]) (q[i][1] - q[k][1])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[i][0] - q[k][0])² + (q[i][1] - q[k][1])²)^(3/2))] + Σ_(i=0..n - 1) Σ_(j=0..i - 1) Σ_(k=0..j - 1) [2 g² mass[i] mass[j] mass[k] (q[j][0] - q[i][0]) (q[j][0] - q[k][0])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[j][0] - q[k][0])² + (q[j][1] - q[k][1])²)^(3/2)) + 2 g² mass[i] mass[j] mass[k] (q[j][1] - q[i][1]) (q[j][1] - q[k][1])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[j][0] - q[k][0])² + (q[j][1] - q[k][1])²)^(3/2))] + Σ_(i=0..n - 1) Σ_(j=0..i - 1) Σ_(k=j + 1..n - 1) [g² mass[i] mass[j] mass[k] (q[j][0] - q[i][0]) (q[j][0] - q[k][0])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[k][0] - q[j][0])² + (q[k][1] - q[j][1])²)^(3/2)) + g² mass[i] mass[j] mass[k] (q[j][1] - q[i][1]) (q[j][1] - q[k][1])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[k][0] - q[j][0])² + (q[k][1] - q[j][1])²)^(3/2))]
    H_qq(H_p,H_p) = Σ_(i=0..n - 1) Σ_(j=0..i - 1) [p[i][0] (g mass[j] p[i][0]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[j] p[i][0] (q[i][0] - q[j][0])²/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[j] p[i][1] (q[i][0] - q[j][0]) (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][0] (q[i][0] - q[j][0]) (q[j][0] - q[i][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - g mass[i] p[j][0]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[i] p[j][1] (q[i][0] - q[j][0]) (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2))/mass[i] + p[i][1] (g mass[j] p[i][1]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[j] p[i][0] (q[i][0] - q[j][0]) (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[j] p[i][1] (q[i][1] - q[j][1])²/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][0] (q[j][0] - q[i][0]) (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][1] (q[i][1] - q[j][1]) (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - g mass[i] p[j][1]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2))/mass[i] + p[j][0] (g mass[i] p[j][0]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[j] p[i][0] (q[i][0] - q[j][0]) (q[j][0] - q[i][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - g mass[j] p[i][0]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[j] p[i][1] (q[j][0] - q[i][0]) (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][0] (q[j][0] - q[i][0])²/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][1] (q[j][0] - q[i][0]) (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2))/mass[j] + 1/mass[j]]

```
*/
pub struct Bodies {
    pub g: f64,
    pub mass: Vec<f64>,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Conservative, DVector, Discretized, Facts, Labels, Number, Option,
        Range, Scalar, Scheme, Sized, Some, Variables, f64, isize, str, usize,
        compose::General,
        elements::{
            AdjacentSums, ElementInput, Elements, EvaluationPoint, InLoops, Loops,
            MomentumUpdate, Pair, Partials, Quadrature, QuadraturePoint, Role, Row, Sums,
            Unknowns,
        },
        elements::places::{
            Atom, Entries, Index, Loop, Name, Nest, Places, Position, Slot,
        },
        embedding::DeltaPlus, gauss::Dynamic,
    };
    #[automatically_derived]
    impl Elements for Bodies {
        const FACTS: Facts = Facts {
            has_pairs: true,
            has_one_velocity: true,
            ..Facts::autonomous(usize::MAX)
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
            [("g", self.g)].get(index).copied()
        }
        const PLACES: Places = Places {
            components: 2,
            tables: &[Name::new("", ""), Name::new("mass", "")],
            nests: &[
                Nest::new(
                    &[
                        Loop(
                            Index::new(&[], 0, "0"),
                            Index::new(&[(Atom::Size, 1)], 0, "n"),
                        ),
                    ],
                    &[
                        Slot::Entry(
                            1,
                            &[
                                Position::new(
                                    Index::new(&[(Atom::Loop(0), 1)], 0, "i"),
                                    false,
                                ),
                            ],
                        ),
                    ],
                ),
                Nest::new(
                    &[
                        Loop(
                            Index::new(&[], 0, "0"),
                            Index::new(&[(Atom::Size, 1)], 0, "n"),
                        ),
                        Loop(
                            Index::new(&[], 0, "0"),
                            Index::new(&[(Atom::Loop(0), 1)], 0, "i"),
                        ),
                    ],
                    &[
                        Slot::Entry(
                            1,
                            &[
                                Position::new(
                                    Index::new(&[(Atom::Loop(0), 1)], 0, "i"),
                                    false,
                                ),
                            ],
                        ),
                        Slot::Entry(
                            1,
                            &[
                                Position::new(
                                    Index::new(&[(Atom::Loop(1), 1)], 0, "j"),
                                    false,
                                ),
                            ],
                        ),
                    ],
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
                (1usize, &[]) => {
                    let list = &self.mass[..];
                    Entries::of_length(list.len())
                }
                _ => Entries::of_length(0),
            }
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let g = at.parameter(0, self.g);
            let size = (at.degrees() / 2) as isize;
            match role {
                Role::Drift => {
                    let mut total = S::from_f64(0.0);
                    {
                        let mut b0 = S::from_f64(0.0);
                        if let (i0, len @ 1..) = wzvi::elements::stretch(0, size) {
                            let first0 = (2 * i0) as usize;
                            let first1 = i0 as usize;
                            let points0 = &at
                                .p[first0..first0 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            let s2 = &self.mass[first1..first1 + len];
                            for place in 0..len {
                                let p_2i = points0[place][0];
                                let p_2i_plus_1 = points0[place][1];
                                let mass_i = S::from_f64(s2[place]);
                                b0 = b0
                                    + (p_2i * p_2i + p_2i_plus_1 * p_2i_plus_1) / mass_i * 0.5;
                            }
                        }
                        total = total + b0;
                    }
                    {
                        let g = S::of_constant(g);
                        for i1 in 0 as isize..size {
                            let q_2i = at.q[(2 * i1) as usize];
                            let q_2i_plus_1 = at.q[(2 * i1 + 1) as usize];
                            let mass_i = S::from_f64(self.mass[i1 as usize]);
                            let mut b0 = S::from_f64(0.0);
                            if let (i2, len @ 1..) = wzvi::elements::stretch(0, i1) {
                                let first0 = (2 * i2) as usize;
                                let first1 = i2 as usize;
                                let points0 = &at
                                    .q[first0..first0 + 2 * len]
                                    .as_chunks::<2>()
                                    .0[..len];
                                let s5 = &self.mass[first1..first1 + len];
                                for place in 0..len {
                                    let q_2j = points0[place][0];
                                    let q_2j_plus_1 = points0[place][1];
                                    let mass_j = S::from_f64(s5[place]);
                                    let difference = q_2i - q_2j;
                                    let difference2 = q_2i_plus_1 - q_2j_plus_1;
                                    let sum = difference * difference
                                        + difference2 * difference2;
                                    b0 = b0
                                        + -(g * (mass_i * mass_j * (sum.recip() * sum.sqrt())));
                                }
                            }
                            total = total + b0;
                        }
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
            let g = at.parameter(0, self.g);
            let size = (at.degrees() / 2) as isize;
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        if let (i0, len @ 1..) = by_p.stretch::<2, _>(0, size, [0]) {
                            let first0 = (2 * i0) as usize;
                            let first1 = i0 as usize;
                            let points0 = &at
                                .p[first0..first0 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            let s2 = &self.mass[first1..first1 + len];
                            let mut points1 = by_p.points::<2>(first0, len);
                            for place in 0..len {
                                let p_2i = T::of(points0[place][0]);
                                let p_2i_plus_1 = T::of(points0[place][1]);
                                let mass_i = T::from_f64(s2[place]);
                                points1.add_part(place, 1, p_2i_plus_1 * factor / mass_i);
                                points1.add_part(place, 0, p_2i * factor / mass_i);
                            }
                        }
                    }
                    if partials.by_q {
                        let g = T::of_constant(g);
                        struct Interaction;
                        impl Pair<5, 2, 1, 2> for Interaction {
                            #[cfg_attr(not(debug_assertions), inline(always))]
                            fn gradient<T: Scalar>(
                                [g,
                                factor,
                                q_2i,
                                q_2i_plus_1,
                                mass_i,
                                ]: [T; 5],
                                [q_2j,
                                q_2j_plus_1,
                                ]: [T; 2],
                                [mass_j,
                                ]: [T; 1],
                            ) -> ([T; 2], [T; 2]) {
                                let difference = q_2i - q_2j;
                                let difference2 = q_2i_plus_1 - q_2j_plus_1;
                                let sum = difference * difference
                                    + difference2 * difference2;
                                let product = factor * (mass_i * mass_j);
                                let inverse = sum.recip();
                                let product2 = inverse * (inverse * sum.sqrt());
                                let product3 = g * (difference * product * product2);
                                let product4 = g * (product2 * (difference2 * product));
                                ([product3, product4], [-product3, -product4])
                            }
                        }
                        by_q.begin_rows::<2>(&at.q[0..at.degrees()]);
                        for i1 in by_q.outer(1, 0 as isize..size) {
                            let factor = T::of_constant(at.h);
                            let q_2i = T::of(at.q[(2 * i1) as usize]);
                            let q_2i_plus_1 = T::of(at.q[(2 * i1 + 1) as usize]);
                            let mass_i = T::from_f64(self.mass[i1 as usize]);
                            if let (i2, len @ 1..) = wzvi::elements::stretch(0, i1) {
                                by_q.row(
                                    Interaction,
                                    at.q,
                                    Row {
                                        first: (2 * i2) as usize,
                                        len,
                                        own: [g, factor, q_2i, q_2i_plus_1, mass_i],
                                        entries: [&self.mass[i2 as usize..]],
                                        places: [(2 * i1) as usize, (2 * i1 + 1) as usize],
                                    },
                                );
                            }
                        }
                        by_q.end_rows::<2>();
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl Discretized<DeltaPlus> for Bodies {
        type Scheme = Loops<DeltaPlus>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "DeltaPlus\n\nHamiltonians\n  H0 = Σ_(i=0..n - 1) [(p[2 i]² + p[2 i + 1]²)/(2 mass[i])] + Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j]/√((q[2 i] - q[2 j])² + (q[2 i + 1] - q[2 j + 1])²)]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = P · Δq - h H0(P, q)\n  Δq = q' - q\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q)\n  p = -D1 L_d:  P = p + v,  v = -h ∂H0/∂q(P, q)\n  p' = D2 L_d:  p' = P\n  with these contributions to the slopes\n    ∂H0/∂p[i][0] += p[i][0]/mass[i]   for i=0..n - 1\n    ∂H0/∂p[i][1] += p[i][1]/mass[i]   for i=0..n - 1\n    ∂H0/∂q[i][0] += g mass[i] mass[j] (q[i][0] - q[j][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)   for i=0..n - 1, j=0..i - 1\n    ∂H0/∂q[j][0] += g mass[i] mass[j] (q[j][0] - q[i][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)   for i=0..n - 1, j=0..i - 1\n    ∂H0/∂q[i][1] += g mass[i] mass[j] (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)   for i=0..n - 1, j=0..i - 1\n    ∂H0/∂q[j][1] += g mass[i] mass[j] (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)   for i=0..n - 1, j=0..i - 1\n\nStep\n  assign v, Δq\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h)\n  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)\n    H_p·H_q = Σ_(i=0..n - 1) Σ_(j=0..i - 1) [g mass[j] p[i][0] (q[i][0] - q[j][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) + g mass[j] p[i][1] (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) + g mass[i] p[j][0] (q[j][0] - q[i][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) + g mass[i] p[j][1] (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2)]\n    H_pp(H_q,H_q) = Σ_(i=0..n - 1) Σ_(j=0..i - 1) Σ_(k=0..i - 1) [g² mass[i] mass[j] mass[k] (q[i][0] - q[j][0]) (q[i][0] - q[k][0])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[i][0] - q[k][0])² + (q[i][1] - q[k][1])²)^(3/2)) + g² mass[i] mass[j] mass[k] (q[i][1] - q[j][1]) (q[i][1] - q[k][1])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[i][0] - q[k][0])² + (q[i][1] - q[k][1])²)^(3/2))] + Σ_(i=0..n - 1) Σ_(j=0..i - 1) Σ_(k=0..j - 1) [2 g² mass[i] mass[j] mass[k] (q[j][0] - q[i][0]) (q[j][0] - q[k][0])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[j][0] - q[k][0])² + (q[j][1] - q[k][1])²)^(3/2)) + 2 g² mass[i] mass[j] mass[k] (q[j][1] - q[i][1]) (q[j][1] - q[k][1])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[j][0] - q[k][0])² + (q[j][1] - q[k][1])²)^(3/2))] + Σ_(i=0..n - 1) Σ_(j=0..i - 1) Σ_(k=j + 1..n - 1) [g² mass[i] mass[j] mass[k] (q[j][0] - q[i][0]) (q[j][0] - q[k][0])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[k][0] - q[j][0])² + (q[k][1] - q[j][1])²)^(3/2)) + g² mass[i] mass[j] mass[k] (q[j][1] - q[i][1]) (q[j][1] - q[k][1])/(((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) ((q[k][0] - q[j][0])² + (q[k][1] - q[j][1])²)^(3/2))]\n    H_qq(H_p,H_p) = Σ_(i=0..n - 1) Σ_(j=0..i - 1) [p[i][0] (g mass[j] p[i][0]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[j] p[i][0] (q[i][0] - q[j][0])²/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[j] p[i][1] (q[i][0] - q[j][0]) (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][0] (q[i][0] - q[j][0]) (q[j][0] - q[i][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - g mass[i] p[j][0]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[i] p[j][1] (q[i][0] - q[j][0]) (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2))/mass[i] + p[i][1] (g mass[j] p[i][1]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[j] p[i][0] (q[i][0] - q[j][0]) (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[j] p[i][1] (q[i][1] - q[j][1])²/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][0] (q[j][0] - q[i][0]) (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][1] (q[i][1] - q[j][1]) (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - g mass[i] p[j][1]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2))/mass[i] + p[j][0] (g mass[i] p[j][0]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[j] p[i][0] (q[i][0] - q[j][0]) (q[j][0] - q[i][0])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - g mass[j] p[i][0]/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(3/2) - 3 g mass[j] p[i][1] (q[j][0] - q[i][0]) (q[i][1] - q[j][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][0] (q[j][0] - q[i][0])²/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2) - 3 g mass[i] p[j][1] (q[j][0] - q[i][0]) (q[j][1] - q[i][1])/((q[i][0] - q[j][0])² + (q[i][1] - q[j][1])²)^(5/2))/mass[j] + 1/mass[j]]\n";
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
    impl Conservative for Bodies {}
    wzvi::bindings! {
        at b0 by_p by_q difference difference2 factor first0 first1 g i0 i1 i2 index
        inverse len list mass_i mass_j outer p_2i p_2i_plus_1 partials place points0
        points1 product product2 product3 product4 q_2i q_2i_plus_1 q_2j q_2j_plus_1
        range role s2 s5 size sum table total weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Bodies {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::DeltaPlus,
            >(checks::PhantomData::<DeltaPlus>);
            {
                let g = self.g;
                let mass = &self.mass;
                checks::of_state::<
                    &[[::core::primitive::f64; 2usize]],
                    _,
                >(|q: &[[f64; 2]], p: &[[f64; 2]]| {
                    (0..q.len())
                        .map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / mass[i])
                        .sum::<f64>()
                        - (0..q.len())
                            .map(|i| {
                                (0..i)
                                    .map(|j| {
                                        let (x, y) = (q[i][0] - q[j][0], q[i][1] - q[j][1]);
                                        g * mass[i] * mass[j] / (x * x + y * y).sqrt()
                                    })
                                    .sum::<f64>()
                            })
                            .sum::<f64>()
                });
            }
        }
    }
};
