// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[f64], p: &[f64]| { p.iter().map(|p| 0.5 * p * p).sum::<f64>() + bonds.iter().zip(strength).map(|(&[a, b], k)| k * (1.0 - (q[a] - q[b]).cos())).sum::<f64>() }, embedding = DeltaPlus)]
// pub struct Network { pub bonds: Vec<[usize; 2]>, pub strength: Vec<f64> }

use wzvi::prelude::*;

/**
# Discrete equations

```text
DeltaPlus

Hamiltonians
  H0 = Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) [strength[i] (1 - cos(q[bonds[i][0]] - q[bonds[i][1]]))]

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = P · Δq - h H0(P, q)
  Δq = q' - q

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q)
  p = -D1 L_d:  P = p + v,  v = -h ∂H0/∂q(P, q)
  p' = D2 L_d:  p' = P
  with these contributions to the slopes
    ∂H0/∂p[i] += p[i]   for i=0..n - 1
    ∂H0/∂q[bonds[i][0]] += strength[i] sin(q[bonds[i][0]] - q[bonds[i][1]])   for i=0..min(bonds.len(), strength.len()) - 1
    ∂H0/∂q[bonds[i][1]] += -strength[i] sin(q[bonds[i][0]] - q[bonds[i][1]])   for i=0..min(bonds.len(), strength.len()) - 1

Step
  assign v, Δq

Facts
  H0 is a first integral: kept by the step nearly, within O(h)
  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)
    H_p·H_q = Σ_(i=0..min(bonds.len(), strength.len()) - 1) [strength[i] p[bonds[i][0]] sin(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][1]] sin(q[bonds[i][0]] - q[bonds[i][1]])]
    H_pp(H_q,H_q) = Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][0] + bonds[j][0] + 1, min(1, bonds[i][0] - bonds[j][0] + 1)) > 0) [strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][0] + bonds[j][1] + 1, min(1, bonds[i][0] - bonds[j][1] + 1)) > 0) [-strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][1] + bonds[j][0] + 1, min(1, bonds[i][1] - bonds[j][0] + 1)) > 0) [-strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][1] + bonds[j][1] + 1, min(1, bonds[i][1] - bonds[j][1] + 1)) > 0) [strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])]
    H_qq(H_p,H_p) = Σ_(i=0..min(bonds.len(), strength.len()) - 1) [p[bonds[i][0]] (strength[i] p[bonds[i][0]] cos(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][1]] cos(q[bonds[i][0]] - q[bonds[i][1]])) + p[bonds[i][1]] (strength[i] p[bonds[i][1]] cos(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][0]] cos(q[bonds[i][0]] - q[bonds[i][1]]))]

```
*/
pub struct Network {
    pub bonds: Vec<[usize; 2]>,
    pub strength: Vec<f64>,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Conservative, DVector, Discretized, Facts, None, Number, Option,
        Ord, Range, Scalar, Scheme, Sized, Some, f64, i128, isize, str, usize,
        compose::General,
        elements::{
            AdjacentSums, CommonRange, ElementInput, Elements, EvaluationPoint, InLoops,
            Loops, MomentumUpdate, Pair, Partials, Placements, Quadrature,
            QuadraturePoint, Role, Sums, Unknowns,
        },
        elements::places::{
            Atom, Entries, Index, Loop, Name, Nest, Places, Position, Slot,
        },
        embedding::DeltaPlus, gauss::Dynamic,
    };
    #[automatically_derived]
    impl Elements for Network {
        const FACTS: Facts = Facts {
            gathers: Partials {
                by_q: true,
                by_p: false,
            },
            has_one_velocity: true,
            ..Facts::autonomous(usize::MAX)
        };
        type Shape = Dynamic;
        type Structure = General;
        type Vector = DVector<f64>;
        const PLACES: Places = Places {
            components: 1,
            tables: &[
                Name::new("bonds.len()", ""),
                Name::new("bonds", ""),
                Name::new("strength.len()", ""),
                Name::new("", ""),
            ],
            nests: &[
                Nest::new(
                    &[
                        Loop(
                            Index::new(&[], 0, "0"),
                            Index::new(
                                &[
                                    (
                                        Atom::Minimum(
                                            &[
                                                Index::new(&[(Atom::Given(0, &[]), 1)], 0, "bonds.len()"),
                                                Index::new(&[(Atom::Given(2, &[]), 1)], 0, "strength.len()"),
                                            ],
                                        ),
                                        1,
                                    ),
                                ],
                                0,
                                "min(bonds.len(), strength.len())",
                            ),
                        ),
                    ],
                    &[
                        Slot::State(
                            Index::new(
                                &[
                                    (
                                        Atom::Given(
                                            1,
                                            &[
                                                Position::new(
                                                    Index::new(&[(Atom::Loop(0), 1)], 0, "i"),
                                                    true,
                                                ),
                                                Position::new(Index::new(&[], 0, "0"), false),
                                            ],
                                        ),
                                        1,
                                    ),
                                ],
                                0,
                                "bonds[i][0]",
                            ),
                        ),
                        Slot::State(
                            Index::new(
                                &[
                                    (
                                        Atom::Given(
                                            1,
                                            &[
                                                Position::new(
                                                    Index::new(&[(Atom::Loop(0), 1)], 0, "i"),
                                                    true,
                                                ),
                                                Position::new(Index::new(&[], 1, "1"), false),
                                            ],
                                        ),
                                        1,
                                    ),
                                ],
                                0,
                                "bonds[i][1]",
                            ),
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
                (0usize, []) => Entries::of_integer((self.bonds.len()) as i128),
                (1usize, &[]) => {
                    let list = &self.bonds[..];
                    Entries::of_length(list.len())
                }
                (1usize, &[o0]) => {
                    let list = match (&self.bonds[..]).get(o0) {
                        Some(inner) => &inner[..],
                        None => return Entries::of_length(0),
                    };
                    Entries::of_list(
                        list,
                        range,
                        |entry| (*entry),
                        |integer| integer as i128,
                    )
                }
                (2usize, []) => Entries::of_integer((self.strength.len()) as i128),
                _ => Entries::of_length(0),
            }
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
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
                        let mut b0 = S::from_f64(0.0);
                        if let (i1, len @ 1..) = wzvi::elements::stretch(
                            0,
                            Ord::min(
                                (self.bonds.len() as isize),
                                (self.strength.len() as isize),
                            ),
                        ) {
                            let first0 = i1 as usize;
                            let s0 = &self.strength[first0..first0 + len];
                            for place in 0..len {
                                let i1 = i1 + place as isize;
                                let strength_i = S::from_f64(s0[place]);
                                let q_bonds_i_0 = at.q[self.bonds[i1 as usize][0] as usize];
                                let q_bonds_i_1 = at.q[self.bonds[i1 as usize][1] as usize];
                                let sin = ((q_bonds_i_0 - q_bonds_i_1) * 0.5).sin();
                                b0 = b0 + strength_i * (sin * sin) * 2.0;
                            }
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
                        struct Interaction;
                        impl Pair<1, 0, 3, 2> for Interaction {
                            #[cfg_attr(not(debug_assertions), inline(always))]
                            fn gradient<T: Scalar>(
                                [factor,
                                ]: [T; 1],
                                []: [T; 0],
                                [strength_i,
                                q_bonds_i_0,
                                q_bonds_i_1,
                                ]: [T; 3],
                            ) -> ([T; 2], [T; 0]) {
                                let product = (q_bonds_i_0 - q_bonds_i_1).sin()
                                    * (strength_i * factor);
                                ([product, -product], [])
                            }
                        }
                        let mut block = Placements::<
                            S,
                            T,
                            S::OfElements<Self::CommonRange>,
                            3,
                            2,
                        >::new();
                        let factor = T::of_constant(at.h);
                        if by_q
                            .gathers(
                                0,
                                Ord::min(
                                    (self.bonds.len() as isize),
                                    (self.strength.len() as isize),
                                ),
                            )
                        {
                            if let (i1, len @ 1..) = wzvi::elements::stretch(
                                0,
                                Ord::min(
                                    (self.bonds.len() as isize),
                                    (self.strength.len() as isize),
                                ),
                            ) {
                                let list0 = i1 as usize;
                                let list0 = &self.strength[list0..list0 + len];
                                let list1 = i1 as usize;
                                let list1 = &self.bonds[list1..list1 + len];
                                let mut first = 0;
                                while first < len {
                                    let few = block.few(len - first);
                                    let list0 = &list0[first..first + few];
                                    let list1 = &list1[first..first + few];
                                    for lane in 0..few {
                                        let place = first + lane;
                                        let strength_i = T::from_f64(list0[lane]);
                                        let q_bonds_i_0 = T::of(at.q[list1[lane][0] as usize]);
                                        let q_bonds_i_1 = T::of(at.q[list1[lane][1] as usize]);
                                        block.read(lane, [strength_i, q_bonds_i_0, q_bonds_i_1]);
                                    }
                                    block.take::<Interaction, 1>(few, [factor]);
                                    for lane in 0..few {
                                        let place = first + lane;
                                        let [slope0, slope1] = block.gradient(lane);
                                        by_q.add(list1[lane][0] as usize, slope0);
                                        by_q.add(list1[lane][1] as usize, slope1);
                                    }
                                    first += few;
                                }
                            }
                        } else {
                            if let (i1, len @ 1..) = wzvi::elements::stretch(
                                0,
                                Ord::min(
                                    (self.bonds.len() as isize),
                                    (self.strength.len() as isize),
                                ),
                            ) {
                                let first0 = i1 as usize;
                                let s0 = &self.strength[first0..first0 + len];
                                for place in 0..len {
                                    let i1 = i1 + place as isize;
                                    let strength_i = T::from_f64(s0[place]);
                                    let q_bonds_i_0 = T::of(
                                        at.q[self.bonds[i1 as usize][0] as usize],
                                    );
                                    let q_bonds_i_1 = T::of(
                                        at.q[self.bonds[i1 as usize][1] as usize],
                                    );
                                    let product = (q_bonds_i_0 - q_bonds_i_1).sin()
                                        * (strength_i * factor);
                                    by_q.add(self.bonds[i1 as usize][0] as usize, product);
                                    by_q.add(self.bonds[i1 as usize][1] as usize, -product);
                                }
                            }
                        }
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl Discretized<DeltaPlus> for Network {
        type Scheme = Loops<DeltaPlus>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "DeltaPlus\n\nHamiltonians\n  H0 = Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) [strength[i] (1 - cos(q[bonds[i][0]] - q[bonds[i][1]]))]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = P · Δq - h H0(P, q)\n  Δq = q' - q\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = h ∂H0/∂p(P, q)\n  p = -D1 L_d:  P = p + v,  v = -h ∂H0/∂q(P, q)\n  p' = D2 L_d:  p' = P\n  with these contributions to the slopes\n    ∂H0/∂p[i] += p[i]   for i=0..n - 1\n    ∂H0/∂q[bonds[i][0]] += strength[i] sin(q[bonds[i][0]] - q[bonds[i][1]])   for i=0..min(bonds.len(), strength.len()) - 1\n    ∂H0/∂q[bonds[i][1]] += -strength[i] sin(q[bonds[i][0]] - q[bonds[i][1]])   for i=0..min(bonds.len(), strength.len()) - 1\n\nStep\n  assign v, Δq\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h)\n  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)\n    H_p·H_q = Σ_(i=0..min(bonds.len(), strength.len()) - 1) [strength[i] p[bonds[i][0]] sin(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][1]] sin(q[bonds[i][0]] - q[bonds[i][1]])]\n    H_pp(H_q,H_q) = Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][0] + bonds[j][0] + 1, min(1, bonds[i][0] - bonds[j][0] + 1)) > 0) [strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][0] + bonds[j][1] + 1, min(1, bonds[i][0] - bonds[j][1] + 1)) > 0) [-strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][1] + bonds[j][0] + 1, min(1, bonds[i][1] - bonds[j][0] + 1)) > 0) [-strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][1] + bonds[j][1] + 1, min(1, bonds[i][1] - bonds[j][1] + 1)) > 0) [strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])]\n    H_qq(H_p,H_p) = Σ_(i=0..min(bonds.len(), strength.len()) - 1) [p[bonds[i][0]] (strength[i] p[bonds[i][0]] cos(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][1]] cos(q[bonds[i][0]] - q[bonds[i][1]])) + p[bonds[i][1]] (strength[i] p[bonds[i][1]] cos(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][0]] cos(q[bonds[i][0]] - q[bonds[i][1]]))]\n";
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
    impl Conservative for Network {}
    wzvi::bindings! {
        at b0 block by_p by_q entry factor few first first0 i0 i1 inner integer lane len
        list list0 list1 o0 outer p_i partials place product q_bonds_i_0 q_bonds_i_1
        range role s0 sin size slope0 slope1 strength_i table total weight
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Network {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::DeltaPlus,
            >(checks::PhantomData::<DeltaPlus>);
            {
                let bonds = &self.bonds;
                let strength = &self.strength;
                checks::of_state::<
                    &[::core::primitive::f64],
                    _,
                >(|q: &[f64], p: &[f64]| {
                    p.iter().map(|p| 0.5 * p * p).sum::<f64>()
                        + bonds
                            .iter()
                            .zip(strength)
                            .map(|(&[a, b], k)| k * (1.0 - (q[a] - q[b]).cos()))
                            .sum::<f64>()
                });
            }
        }
    }
};
