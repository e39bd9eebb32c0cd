// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[[f64; 2]], p: &[[f64; 2]]| (0..N).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) + g * q[i][1]).sum(), noise = [|q, p, k| sigma * q[k][0]; N], constraint = [|q| 0.5 * (q[0][0] * q[0][0] + q[0][1] * q[0][1] - l * l), [|q, k| 0.5 * ((q[k + 1][0] - q[k][0]).powi(2) + (q[k + 1][1] - q[k][1]).powi(2) - l * l); N - 1]], embedding = Rattle)]
// pub struct Rods<const N: usize> { pub g: f64, pub l: f64, pub sigma: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Rattle

Hamiltonians
  H0 = Σ_(i=0..N - 1) [g q[2 i + 1] + (p[2 i]² + p[2 i + 1]²)/2]
  H_k = sigma q[k][0]   for k=0..N - 1

Constraints
  0 = g1 = (q[0]² - l² + q[1]²)/2
  0 = g_(k + 2) = ((q[k + 1][0] - q[k][0])² - l² + (q[k + 1][1] - q[k][1])²)/2   for k=0..N - 2

Discrete Lagrangian of the step from t_i to t_i + h, with F = h H0 + Σ_k ΔW_k H_k
  L_d = P · (q_{i+1} - q_i) - F(q_i, P, t_i)/2 - F(q_{i+1}, P, t_{i+1})/2
        - h/2 λ · g(q_i, t_i) - h/2 μ · g(q_{i+1}, t_{i+1})

Discrete Euler-Lagrange equations, with G = ∂g/∂q
  p_i = -D1 L_d:      P = p_i - 1/2 ∂F/∂q(q_i, t_i) - h/2 G(q_i, t_i)ᵀ λ
  ∂L_d/∂P = 0:        q_{i+1} = q_i + h ∂H0/∂p(P)
  ∂L_d/∂λ of the next step = 0:  g(q_{i+1}, t_{i+1}) = 0
  p_{i+1} = D2 L_d:   p_{i+1} = P - 1/2 ∂F/∂q(q_{i+1}, t_{i+1}) - h/2 G(q_{i+1}, t_{i+1})ᵀ μ
  0 = dg/dt:          0 = G(q_{i+1}, t_{i+1}) ∂H0/∂p(p_{i+1})

Step
  solve for λ: Newton, matrix h²/2 G(q_{i+1}) W G(q_i)ᵀ with W = ∂²H0/∂p², sparse: one unknown for each constraint, coupled where they share a coordinate
  solve for μ: linear, matrix h/2 G W Gᵀ at q_{i+1}; degrees of freedom left: all but one for each constraint that does not follow from others

Facts
  converges to the Stratonovich system; D = 0
  h → 0, then ε → 0: X_{ε,n} → X_ε → X
  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving
  Σ_k {H_k, H0} = Σ_(i=0..N - 1) [-sigma p[i][0]]
  the noises commute up to a constant
  H0 is not a first integral

```
*/
pub struct Rods<const N: usize> {
    pub g: f64,
    pub l: f64,
    pub sigma: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, DVector, Discretized, Facts, Knowledge, Labels, NoiseClass, Number,
        Option, Ord, Range, Scalar, Scheme, Sized, Some, Variables, bool, f64, i128,
        isize, str, usize, compose::{Nystrom, WholeOf},
        constraints::{Constrained, ConstraintRows, Manifold, SparseConstraints},
        elements::{
            AdjacentSums, ElementInput, Elements, EvaluationPoint, Partials, Role, Sums,
        },
        elements::places::{Atom, Entries, Index, Loop, Name, Nest, Places, Slot},
        embedding::Rattle, gauss::Dynamic,
    };
    #[automatically_derived]
    impl<const N: usize> Elements for Rods<{ N }> {
        const FACTS: Facts = Facts {
            noise: NoiseClass::Additive,
            conserves_energy: Knowledge::Refuted,
            has_tiles: true,
            has_constant_curvature: true,
            coupled_degrees: Some(2),
            ..Facts::autonomous(usize::MAX)
        };
        type Shape = Dynamic;
        type Structure = Nystrom;
        type Vector = DVector<f64>;
        fn noises(&self) -> usize {
            (N as isize) as usize
        }
        fn manifold(&self) -> Option<&dyn Manifold> {
            Some(self)
        }
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
            [("g", self.g), ("sigma", self.sigma), ("l", self.l)].get(index).copied()
        }
        const PLACES: Places = Places {
            components: 2,
            tables: &[Name::new("N", "")],
            nests: &[
                Nest::new(
                    &[
                        Loop(
                            Index::new(&[], 0, "0"),
                            Index::new(&[(Atom::Given(0, &[]), 1)], 0, "N"),
                        ),
                    ],
                    &[
                        Slot::Natural(Index::new(&[(Atom::Loop(0), 2)], 0, "2 i")),
                        Slot::Natural(Index::new(&[(Atom::Loop(0), 2)], 1, "2 i + 1")),
                        Slot::Natural(Index::new(&[(Atom::Loop(0), 2)], 1, "2 i + 1")),
                    ],
                ),
                Nest::new(
                    &[
                        Loop(
                            Index::new(&[], 0, "0"),
                            Index::new(&[(Atom::Given(0, &[]), 1)], 0, "N"),
                        ),
                    ],
                    &[Slot::Natural(Index::new(&[(Atom::Loop(0), 2)], 0, "2 i"))],
                ),
                Nest::new(
                    &[],
                    &[
                        Slot::Natural(Index::new(&[], 0, "0")),
                        Slot::Natural(Index::new(&[], 1, "1")),
                    ],
                ),
                Nest::new(
                    &[
                        Loop(
                            Index::new(&[], 0, "0"),
                            Index::new(&[(Atom::Given(0, &[]), 1)], -1, "N - 1"),
                        ),
                    ],
                    &[
                        Slot::Natural(Index::new(&[(Atom::Loop(0), 2)], 2, "2 i + 2")),
                        Slot::Natural(Index::new(&[(Atom::Loop(0), 2)], 0, "2 i")),
                        Slot::Natural(Index::new(&[(Atom::Loop(0), 2)], 3, "2 i + 3")),
                        Slot::Natural(Index::new(&[(Atom::Loop(0), 2)], 1, "2 i + 1")),
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
                (0usize, []) => Entries::of_integer((N) as i128),
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
            let sigma = at.parameter(1, self.sigma);
            match role {
                Role::Drift => {
                    let g = S::of_constant(g);
                    let mut b0 = S::from_f64(0.0);
                    if let (i0, len @ 1..) = wzvi::elements::stretch(0, N as isize) {
                        let first0 = (2 * i0) as usize;
                        let points0 = &at
                            .p[first0..first0 + 2 * len]
                            .as_chunks::<2>()
                            .0[..len];
                        let points1 = &at
                            .q[first0..first0 + 2 * len]
                            .as_chunks::<2>()
                            .0[..len];
                        for place in 0..len {
                            let p_2i = points0[place][0];
                            let p_2i_plus_1 = points0[place][1];
                            let q_2i_plus_1 = points1[place][1];
                            b0 = b0
                                + (q_2i_plus_1 * g
                                    + (p_2i * p_2i + p_2i_plus_1 * p_2i_plus_1) * 0.5);
                        }
                    }
                    b0 * S::of_constant(at.h)
                }
                Role::Noise => {
                    let sigma = S::of_constant(sigma);
                    let mut b0 = S::from_f64(0.0);
                    if let (i1, len @ 1..) = wzvi::elements::stretch(
                        Ord::max(0, at.acting.start as isize),
                        Ord::min((N as isize), at.acting.end as isize),
                    ) {
                        let first0 = (2 * i1) as usize;
                        let points0 = &at
                            .q[first0..first0 + 2 * len]
                            .as_chunks::<2>()
                            .0[..len];
                        for place in 0..len {
                            let i1 = i1 + place as isize;
                            let q_2i = points0[place][0];
                            let factor = at.increment(i1 as usize);
                            b0 = b0 + sigma * (q_2i * factor);
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
            let g = at.parameter(0, self.g);
            let sigma = at.parameter(1, self.sigma);
            match role {
                Role::Drift => {
                    if partials.by_q {
                        let g = T::of_constant(g);
                        let factor = T::of_constant(at.h);
                        if let (i0, len @ 1..) = by_q.stretch::<2, _>(0, N as isize, [0])
                        {
                            let first0 = (2 * i0) as usize;
                            let mut points0 = by_q.points::<2>(first0, len);
                            for place in 0..len {
                                points0.add_part(place, 1, factor * g);
                            }
                        }
                    }
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
                }
                Role::Noise => {
                    if partials.by_q {
                        let sigma = T::of_constant(sigma);
                        let i1: isize = Ord::max(0, at.acting.start as isize);
                        if let (i1, len @ 1..) = by_q
                            .stretch::<
                                2,
                                _,
                            >(
                                i1,
                                Ord::min((N as isize), at.acting.end as isize),
                                [(2 * i1) as usize],
                            )
                        {
                            let first0 = (2 * i1) as usize;
                            let mut points0 = by_q.points::<2>(first0, len);
                            for place in 0..len {
                                let i1 = i1 + place as isize;
                                let factor = T::of(at.increment(i1 as usize));
                                points0.add_part(place, 0, factor * sigma);
                            }
                        }
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl<const N: usize> Constrained for Rods<{ N }> {
        type Layout = SparseConstraints;
        const READ_TIME: bool = false;
        const HAS_SQUARES: bool = true;
        const CONSTRAINTS: usize = usize::MAX;
        fn constraints(&self) -> usize {
            (N as isize) as usize
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn constrain<S: Scalar>(
            &self,
            at: &EvaluationPoint<'_, S>,
            into: &mut impl ConstraintRows<S>,
        ) {
            let l = at.parameter(2, self.l);
            let l_squared = S::of_constant(l * l);
            let q0 = at.q[0];
            let q1 = at.q[1];
            into.value(0, (q0 * q0 + q1 * q1 - l_squared) * 0.5);
            into.slope(0, 0, q0);
            into.slope(0, 1, q1);
            let l_squared = S::of_constant(l * l);
            if let (i2, len @ 1..) = wzvi::elements::stretch(0, (N as isize) - 1) {
                let first0 = (2 * i2 + 2) as usize;
                let first1 = (2 * i2) as usize;
                let points0 = &at.q[first0..first0 + 2 * len].as_chunks::<2>().0[..len];
                let points1 = &at.q[first1..first1 + 2 * len].as_chunks::<2>().0[..len];
                for place in 0..len {
                    let i2 = i2 + place as isize;
                    let q_2i_plus_2 = points0[place][0];
                    let q_2i = points1[place][0];
                    let q_2i_plus_3 = points0[place][1];
                    let q_2i_plus_1 = points1[place][1];
                    let difference = q_2i_plus_2 - q_2i;
                    let difference2 = q_2i_plus_3 - q_2i_plus_1;
                    into.value(
                        (i2 + 1) as usize,
                        (difference * difference + difference2 * difference2 - l_squared)
                            * 0.5,
                    );
                    into.slope((i2 + 1) as usize, (2 * i2 + 2) as usize, difference);
                    into.slope((i2 + 1) as usize, (2 * i2) as usize, q_2i - q_2i_plus_2);
                    into.slope((i2 + 1) as usize, (2 * i2 + 3) as usize, difference2);
                    into.slope(
                        (i2 + 1) as usize,
                        (2 * i2 + 1) as usize,
                        q_2i_plus_1 - q_2i_plus_3,
                    );
                }
            }
        }
    }
    #[automatically_derived]
    impl<const N: usize> Discretized<Rattle> for Rods<{ N }> {
        type Scheme = WholeOf<Self, Rattle>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Rattle\n\nHamiltonians\n  H0 = Σ_(i=0..N - 1) [g q[2 i + 1] + (p[2 i]² + p[2 i + 1]²)/2]\n  H_k = sigma q[k][0]   for k=0..N - 1\n\nConstraints\n  0 = g1 = (q[0]² - l² + q[1]²)/2\n  0 = g_(k + 2) = ((q[k + 1][0] - q[k][0])² - l² + (q[k + 1][1] - q[k][1])²)/2   for k=0..N - 2\n\nDiscrete Lagrangian of the step from t_i to t_i + h, with F = h H0 + Σ_k ΔW_k H_k\n  L_d = P · (q_{i+1} - q_i) - F(q_i, P, t_i)/2 - F(q_{i+1}, P, t_{i+1})/2\n        - h/2 λ · g(q_i, t_i) - h/2 μ · g(q_{i+1}, t_{i+1})\n\nDiscrete Euler-Lagrange equations, with G = ∂g/∂q\n  p_i = -D1 L_d:      P = p_i - 1/2 ∂F/∂q(q_i, t_i) - h/2 G(q_i, t_i)ᵀ λ\n  ∂L_d/∂P = 0:        q_{i+1} = q_i + h ∂H0/∂p(P)\n  ∂L_d/∂λ of the next step = 0:  g(q_{i+1}, t_{i+1}) = 0\n  p_{i+1} = D2 L_d:   p_{i+1} = P - 1/2 ∂F/∂q(q_{i+1}, t_{i+1}) - h/2 G(q_{i+1}, t_{i+1})ᵀ μ\n  0 = dg/dt:          0 = G(q_{i+1}, t_{i+1}) ∂H0/∂p(p_{i+1})\n\nStep\n  solve for λ: Newton, matrix h²/2 G(q_{i+1}) W G(q_i)ᵀ with W = ∂²H0/∂p², sparse: one unknown for each constraint, coupled where they share a coordinate\n  solve for μ: linear, matrix h/2 G W Gᵀ at q_{i+1}; degrees of freedom left: all but one for each constraint that does not follow from others\n\nFacts\n  converges to the Stratonovich system; D = 0\n  h → 0, then ε → 0: X_{ε,n} → X_ε → X\n  ε → 0, then h → 0: X_{ε,n} → X_n → X: asymptotically preserving\n  Σ_k {H_k, H0} = Σ_(i=0..N - 1) [-sigma p[i][0]]\n  the noises commute up to a constant\n  H0 is not a first integral\n";
    }
    wzvi::bindings! {
        at b0 by_p by_q difference difference2 factor first0 first1 g i0 i1 i2 index into
        l l_squared len outer p_2i p_2i_plus_1 partials place points0 points1 q0 q1 q_2i
        q_2i_plus_1 q_2i_plus_2 q_2i_plus_3 range role sigma table weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl<const N: usize> Rods<{ N }> {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<::wzvi::embedding::Rattle>(checks::PhantomData::<Rattle>);
            {
                let g = self.g;
                checks::of_state::<
                    &[[::core::primitive::f64; 2usize]],
                    _,
                >(|q: &[[f64; 2]], p: &[[f64; 2]]| {
                    (0..N)
                        .map(|i| {
                            0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) + g * q[i][1]
                        })
                        .sum::<checks::f64>()
                });
            }
            {
                let sigma = self.sigma;
                checks::family::<
                    &[[::core::primitive::f64; 2usize]],
                    _,
                >(|q, p, k| sigma * q[k][0]);
            }
            {
                let l = self.l;
                checks::of_coordinates::<
                    &[[::core::primitive::f64; 2usize]],
                    _,
                >(|q| 0.5 * (q[0][0] * q[0][0] + q[0][1] * q[0][1] - l * l));
            }
            {
                let l = self.l;
                checks::constraint_family::<
                    &[[::core::primitive::f64; 2usize]],
                    _,
                >(|q, k| {
                    0.5
                        * ((q[k + 1][0] - q[k][0]).powi(2)
                            + (q[k + 1][1] - q[k][1]).powi(2) - l * l)
                });
            }
        }
    }
};
