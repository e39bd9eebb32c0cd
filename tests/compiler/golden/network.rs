// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[f64], p: &[f64]| { p.iter().map(|p| 0.5 * p * p).sum::<f64>() + bonds.iter().zip(strength).map(|(&[a, b], k)| k * (1.0 - (q[a] - q[b]).cos())).sum::<f64>() }, embedding = DeltaPlus)]
// pub struct Network { pub bonds: Vec<[usize; 2]>, pub strength: Vec<f64> }

use wzvi::prelude::*;

/**
# Discrete equations

```text
DeltaPlus

Hamiltonians, as sums of elements
  H0 = Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) [-strength[i] cos(q[bonds[i][0]] - q[bonds[i][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) [strength[i]]

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = Σ_i P[i] Δq[i] - h H0(P, q)
  Δq = q' - q

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq[i] is the sum of
    P[i] h   for i = 0..n - 1
  p = -D1 L_d:  P[i] = p[i] + v[i], v[i] is the sum of
    Σ_(i=0..min(bonds.len(), strength.len()) - 1) [-strength[i] h sin(q[bonds[i][0]] - q[bonds[i][1]])]   at point bonds[i][0]
    Σ_(i=0..min(bonds.len(), strength.len()) - 1) [strength[i] h sin(q[bonds[i][0]] - q[bonds[i][1]])]   at point bonds[i][1]
  p' = D2 L_d:  p'[i] = P[i]

Step
  assign v, Δq

Facts
  H0 is a first integral: kept by the step nearly, within O(h)
  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)
    H_p·H_q = Σ_(i=0..min(bonds.len(), strength.len()) - 1) [p[bonds[i][0]] strength[i] sin(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][1]] sin(q[bonds[i][0]] - q[bonds[i][1]])]
    H_pp(H_q,H_q) = Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][0] + bonds[j][0] + 1, min(1, bonds[i][0] - bonds[j][0] + 1)) > 0) [strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][0] + bonds[j][1] + 1, min(1, bonds[i][0] - bonds[j][1] + 1)) > 0) [-strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][1] + bonds[j][0] + 1, min(1, bonds[i][1] - bonds[j][0] + 1)) > 0) [-strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][1] + bonds[j][1] + 1, min(1, bonds[i][1] - bonds[j][1] + 1)) > 0) [strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])]
    H_qq(H_p,H_p) = Σ_(i=0..min(bonds.len(), strength.len()) - 1) [p[bonds[i][0]] (p[bonds[i][0]] strength[i] cos(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][1]] cos(q[bonds[i][0]] - q[bonds[i][1]])) + p[bonds[i][1]] (strength[i] p[bonds[i][1]] cos(q[bonds[i][0]] - q[bonds[i][1]]) - p[bonds[i][0]] strength[i] cos(q[bonds[i][0]] - q[bonds[i][1]]))]

```
*/
pub struct Network {
    pub bonds: Vec<[usize; 2]>,
    pub strength: Vec<f64>,
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
        self as wzvi, Conservative, DVector, Facts, Hamiltonian, Knowledge, Listed,
        NoiseClass, None, Number, Ord, Range, Result, Scalar, Sized, Some, StepFailure,
        bool, f64, i128, isize, str, u32, usize,
        elements::{
            Alone, Elements, Given, InLoops, Loops, MomentumUpdate, Pair, Placements,
            Point, Quadrature, Run, Slopes, Stage, Sums, Unknowns, Usual,
        },
        elements::places::{
            Atom, Entries, Index, Loop, Name, Nest, Places, Position, Slot,
        },
        embedding::DeltaPlus,
    };
    #[automatically_derived]
    impl Hamiltonian for Network {
        type Vector = DVector<f64>;
        fn degrees(&self) -> usize {
            0
        }
        fn check(&self, degrees: usize) -> Result<(), StepFailure> {
            wzvi::elements::check(self, degrees)
        }
        fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
            wzvi::elements::evaluate(self, term, q, p, t)
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
            wzvi::elements::differentiate(self, term, q, p, t, by_q, by_p);
        }
    }
    #[automatically_derived]
    impl Elements for Network {
        const PLACES: Places = Places {
            components: 1,
            tables: &[
                Name {
                    name: "bonds.len()",
                    suffix: "",
                },
                Name { name: "bonds", suffix: "" },
                Name {
                    name: "strength.len()",
                    suffix: "",
                },
                Name { name: "", suffix: "" },
            ],
            nests: &[
                Nest {
                    loops: &[
                        Loop {
                            start: Index {
                                terms: &[],
                                constant: 0,
                                name: Name { name: "0", suffix: "" },
                            },
                            end: Index {
                                terms: &[
                                    (
                                        Atom::Minimum(
                                            &[
                                                Index {
                                                    terms: &[(Atom::Given(0, &[]), 1)],
                                                    constant: 0,
                                                    name: Name {
                                                        name: "bonds.len()",
                                                        suffix: "",
                                                    },
                                                },
                                                Index {
                                                    terms: &[(Atom::Given(2, &[]), 1)],
                                                    constant: 0,
                                                    name: Name {
                                                        name: "strength.len()",
                                                        suffix: "",
                                                    },
                                                },
                                            ],
                                        ),
                                        1,
                                    ),
                                ],
                                constant: 0,
                                name: Name {
                                    name: "min(bonds.len(), strength.len())",
                                    suffix: "",
                                },
                            },
                        },
                    ],
                    slots: &[
                        Slot::State {
                            index: Index {
                                terms: &[
                                    (
                                        Atom::Given(
                                            1,
                                            &[
                                                Position {
                                                    index: Index {
                                                        terms: &[(Atom::Loop(0), 1)],
                                                        constant: 0,
                                                        name: Name { name: "i", suffix: "" },
                                                    },
                                                    is_inside: true,
                                                },
                                                Position {
                                                    index: Index {
                                                        terms: &[],
                                                        constant: 0,
                                                        name: Name { name: "0", suffix: "" },
                                                    },
                                                    is_inside: false,
                                                },
                                            ],
                                        ),
                                        1,
                                    ),
                                ],
                                constant: 0,
                                name: Name {
                                    name: "bonds[i][0]",
                                    suffix: "",
                                },
                            },
                            is_natural: false,
                        },
                        Slot::State {
                            index: Index {
                                terms: &[
                                    (
                                        Atom::Given(
                                            1,
                                            &[
                                                Position {
                                                    index: Index {
                                                        terms: &[(Atom::Loop(0), 1)],
                                                        constant: 0,
                                                        name: Name { name: "i", suffix: "" },
                                                    },
                                                    is_inside: true,
                                                },
                                                Position {
                                                    index: Index {
                                                        terms: &[],
                                                        constant: 1,
                                                        name: Name { name: "1", suffix: "" },
                                                    },
                                                    is_inside: false,
                                                },
                                            ],
                                        ),
                                        1,
                                    ),
                                ],
                                constant: 0,
                                name: Name {
                                    name: "bonds[i][1]",
                                    suffix: "",
                                },
                            },
                            is_natural: false,
                        },
                    ],
                },
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
        const FACTS: Facts = Facts {
            degrees: usize::MAX,
            noise: NoiseClass::None,
            conserves_energy: Knowledge::Proven,
            commuting: Knowledge::Proven,
            is_damped: false,
            has_pieces: false,
        };
        const INTEGRALS: usize = 3;
        fn value<S: Scalar>(&self, part: usize, weight: f64, at: &Point<'_, S>) -> S {
            let size = at.degrees() as isize;
            let mut value = S::from_f64(0.0);
            match part {
                0 => {
                    let mut total = S::from_f64(0.0);
                    {
                        let mut b0 = S::from_f64(0.0);
                        let (low, end): (isize, isize) = (0, size);
                        if low < end {
                            let i0 = low;
                            let len = (end - low) as usize;
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
                        let (low, end): (isize, isize) = (
                            0,
                            Ord::min(
                                (self.bonds.len() as isize),
                                (self.strength.len() as isize),
                            ),
                        );
                        if low < end {
                            let i1 = low;
                            let len = (end - low) as usize;
                            let first0 = i1 as usize;
                            let s0 = &self.strength[first0..first0 + len];
                            for place in 0..len {
                                let i1 = low + place as isize;
                                let strength_i = S::from_f64(s0[place]);
                                let q_bonds_i_0 = at.q[self.bonds[i1 as usize][0] as usize];
                                let q_bonds_i_1 = at.q[self.bonds[i1 as usize][1] as usize];
                                let sin = ((q_bonds_i_0 - q_bonds_i_1) * 0.5).sin();
                                b0 = b0 + strength_i * (sin * sin) * 2.0;
                            }
                        }
                        total = total + b0;
                    }
                    value = value + total * S::from_f64(at.h);
                }
                _ => {}
            }
            value
        }
        const GATHERS: Slopes = Slopes { by_q: true, by_p: false };
        const HAS_ONE_VELOCITY: bool = true;
        type Exact = Alone;
        type Usual = Usual;
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn slopes<
            S: Scalar,
            T: Number<S>,
            V: Given<S> + ?Sized,
            Q: Sums<S> + ?Sized,
            P: Sums<S> + ?Sized,
        >(
            &self,
            part: usize,
            weight: f64,
            at: &Point<'_, S, V>,
            wanted: Slopes,
            by_q: &mut Q,
            by_p: &mut P,
        ) {
            use Run as _;
            let size = at.degrees() as isize;
            match part {
                0 => {
                    if wanted.by_p {
                        {
                            let factor = T::from_f64(at.h);
                            let (low, end): (isize, isize) = (0, size);
                            if low < end {
                                let i0 = low;
                                let len = (end - low) as usize;
                                let (skipped, len) = by_p.clip::<1, _>(len, [i0 as usize]);
                                if len > 0 {
                                    let low = low + skipped as isize;
                                    let i0 = low;
                                    let first0 = i0 as usize;
                                    let s0 = &at.p[first0..first0 + len];
                                    let mut b0 = by_p.run(first0, len);
                                    for place in 0..len {
                                        let p_i = T::of(s0[place]);
                                        b0.add(place, p_i * factor);
                                    }
                                }
                            }
                        }
                    }
                    if wanted.by_q {
                        {
                            use Placements as _;
                            struct Interaction;
                            impl Pair<1, 0, 0, 3, 2> for Interaction {
                                #[cfg_attr(not(debug_assertions), inline(always))]
                                fn slopes<T: Scalar>(
                                    [factor,
                                    ]: [T; 1],
                                    []: [f64; 0],
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
                            let mut block = by_q.beside::<T, 3, 2>();
                            let factor = T::from_f64(at.h);
                            let (low, end): (isize, isize) = (
                                0,
                                Ord::min(
                                    (self.bonds.len() as isize),
                                    (self.strength.len() as isize),
                                ),
                            );
                            if by_q.gathers(low, end) {
                                let (low, end): (isize, isize) = (
                                    0,
                                    Ord::min(
                                        (self.bonds.len() as isize),
                                        (self.strength.len() as isize),
                                    ),
                                );
                                if low < end {
                                    let i1 = low;
                                    let len = (end - low) as usize;
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
                                        block.take::<Interaction, 1, 0>(few, [factor], []);
                                        for lane in 0..few {
                                            let place = first + lane;
                                            let [slope0, slope1] = block.slopes(lane);
                                            by_q.add(list1[lane][0] as usize, slope0);
                                            by_q.add(list1[lane][1] as usize, slope1);
                                        }
                                        first += few;
                                    }
                                }
                            } else {
                                let (low, end): (isize, isize) = (
                                    0,
                                    Ord::min(
                                        (self.bonds.len() as isize),
                                        (self.strength.len() as isize),
                                    ),
                                );
                                if low < end {
                                    let i1 = low;
                                    let len = (end - low) as usize;
                                    let first0 = i1 as usize;
                                    let s0 = &self.strength[first0..first0 + len];
                                    for place in 0..len {
                                        let i1 = low + place as isize;
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
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl InLoops<DeltaPlus> for Network {
        const ORDER: u32 = 1;
        const IS_CONSISTENT: bool = true;
        const QUADRATURE: Quadrature = Quadrature {
            stages: &[Stage::new([0.0, 1.0, 0.0], &[(0, 1.0)])],
            update: MomentumUpdate::Multiple(1.0),
            unknowns: Unknowns::None,
            remembers: false,
            is_linear: false,
        };
    }
    #[automatically_derived]
    impl Listed<DeltaPlus> for Network {
        type Scheme = Loops<DeltaPlus>;
        const TEXT: &'static str = "DeltaPlus\n\nHamiltonians, as sums of elements\n  H0 = Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) [-strength[i] cos(q[bonds[i][0]] - q[bonds[i][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) [strength[i]]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = Σ_i P[i] Δq[i] - h H0(P, q)\n  Δq = q' - q\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq[i] is the sum of\n    P[i] h   for i = 0..n - 1\n  p = -D1 L_d:  P[i] = p[i] + v[i], v[i] is the sum of\n    Σ_(i=0..min(bonds.len(), strength.len()) - 1) [-strength[i] h sin(q[bonds[i][0]] - q[bonds[i][1]])]   at point bonds[i][0]\n    Σ_(i=0..min(bonds.len(), strength.len()) - 1) [strength[i] h sin(q[bonds[i][0]] - q[bonds[i][1]])]   at point bonds[i][1]\n  p' = D2 L_d:  p'[i] = P[i]\n\nStep\n  assign v, Δq\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h)\n  modified energy, kept within O(h³): H0 - h H_p·H_q/2 + h² (H_pp(H_q,H_q)/12 + H_qq(H_p,H_p)/12)\n    H_p·H_q = Σ_(i=0..min(bonds.len(), strength.len()) - 1) [p[bonds[i][0]] strength[i] sin(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][1]] sin(q[bonds[i][0]] - q[bonds[i][1]])]\n    H_pp(H_q,H_q) = Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][0] + bonds[j][0] + 1, min(1, bonds[i][0] - bonds[j][0] + 1)) > 0) [strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][0] + bonds[j][1] + 1, min(1, bonds[i][0] - bonds[j][1] + 1)) > 0) [-strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][1] + bonds[j][0] + 1, min(1, bonds[i][1] - bonds[j][0] + 1)) > 0) [-strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])] + Σ_(i=0..min(bonds.len(), strength.len()) - 1) Σ_(j=0..min(bonds.len(), strength.len()) - 1) (where min(-bonds[i][1] + bonds[j][1] + 1, min(1, bonds[i][1] - bonds[j][1] + 1)) > 0) [strength[i] strength[j] sin(q[bonds[i][0]] - q[bonds[i][1]]) sin(q[bonds[j][0]] - q[bonds[j][1]])]\n    H_qq(H_p,H_p) = Σ_(i=0..min(bonds.len(), strength.len()) - 1) [p[bonds[i][0]] (p[bonds[i][0]] strength[i] cos(q[bonds[i][0]] - q[bonds[i][1]]) - strength[i] p[bonds[i][1]] cos(q[bonds[i][0]] - q[bonds[i][1]])) + p[bonds[i][1]] (strength[i] p[bonds[i][1]] cos(q[bonds[i][0]] - q[bonds[i][1]]) - p[bonds[i][0]] strength[i] cos(q[bonds[i][0]] - q[bonds[i][1]]))]\n";
    }
    #[automatically_derived]
    impl Conservative for Network {}
    /// The names that are bound above, so that no constant around can stand for them.
    use ::wzvi::__private::{
        binding as at, binding as b0, binding as block, binding as by_p, binding as by_q,
        binding as degrees, binding as end, binding as entry, binding as factor,
        binding as few, binding as first, binding as first0, binding as i0,
        binding as i1, binding as inner, binding as integer, binding as lane,
        binding as len, binding as list, binding as list0, binding as list1,
        binding as low, binding as o0, binding as outer, binding as p, binding as p_i,
        binding as part, binding as place, binding as product, binding as q,
        binding as q_bonds_i_0, binding as q_bonds_i_1, binding as range, binding as s0,
        binding as sin, binding as size, binding as skipped, binding as slope0,
        binding as slope1, binding as strength_i, binding as t, binding as table,
        binding as term, binding as total, binding as value, binding as wanted,
        binding as weight,
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
    impl ::wzvi::__private::checks::Checked for Network {
        fn check(&self) {
            ::wzvi::__private::checks::is_same::<
                ::wzvi::embedding::DeltaPlus,
            >(::core::marker::PhantomData::<DeltaPlus>);
            {
                let bonds = &self.bonds;
                let strength = &self.strength;
                ::wzvi::__private::checks::of_state::<
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
