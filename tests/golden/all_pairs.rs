// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[[f64; 2]], p: &[[f64; 2]]| { (0..q.len()).map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / mass[i]).sum::<f64>() - (0..q.len()).map(|i| (0..i).map(|j| { let (x, y) = (q[i][0] - q[j][0], q[i][1] - q[j][1]); g * mass[i] * mass[j] / (x * x + y * y).sqrt() }).sum::<f64>()).sum::<f64>() }, embedding = DeltaPlus)]
// pub struct Bodies { pub g: f64, pub mass: Vec<f64> }

use wzvi::prelude::*;

/**
# Discrete equations

```text
DeltaPlus

Hamiltonians, as sums of elements
  H0 = Σ_(i=0..n - 1) [p[2 i + 1]²/(2 mass[i]) + p[2 i]²/(2 mass[i])] + Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j]/√((q[2 i + 1] - q[2 j + 1])² + (q[2 i] - q[2 j])²)]

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = Σ_i P[i] Δq[i] - h H0(P, q)
  Δq = q' - q

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq[i][0] is the sum of
    P[i][0] h/mass[i]   for i = 0..n - 1
  p = -D1 L_d:  P[i][0] = p[i][0] + v[i][0], v[i][0] is the sum of
    Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[i][0] - q[j][0])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   for i = 0..n - 1
    Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[j][0] - q[i][0])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   at point j
  p' = D2 L_d:  p'[i][0] = P[i][0]
  ∂L_d/∂P = 0:  Δq[i][1] is the sum of
    P[i][1] h/mass[i]   for i = 0..n - 1
  p = -D1 L_d:  P[i][1] = p[i][1] + v[i][1], v[i][1] is the sum of
    Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[i][1] - q[j][1])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   for i = 0..n - 1
    Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[j][1] - q[i][1])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   at point j
  p' = D2 L_d:  p'[i][1] = P[i][1]

Step
  assign v, Δq

Facts
  H0 is a first integral: kept by the step nearly, within O(h)

```
*/
pub struct Bodies {
    pub g: f64,
    pub mass: Vec<f64>,
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
        self as wzvi, Carry, ConfigError, DVector, Discretized, Effort, Err, Hamiltonian,
        Knowledge, LagrangianGradient, NoiseClass, Option, Plain, Plan, Range, Result,
        Scalar, Segment, Solver, State, StepFailure, bool, f64, isize, str, usize,
        elements::{
            CompensationVec, Curvature, Elements, Memory, Point, Scheme, Terms, Unknowns,
        },
        elements::places::{Entries, Places},
        embedding::DeltaPlus,
    };
    #[automatically_derived]
    impl Hamiltonian for Bodies {
        type Vector = DVector<f64>;
        fn degrees(&self) -> usize {
            0
        }
        fn check(&self, degrees: usize) -> Result<(), StepFailure> {
            wzvi::elements::check(self, degrees)
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("g", self.g)].get(index).copied()
        }
        fn evaluate<S: Scalar>(&self, term: usize, q: &[S], p: &[S], t: f64) -> S {
            let nan = S::from_f64(f64::NAN);
            if !(q.len() == p.len() && wzvi::elements::check(self, q.len()).is_ok()) {
                return nan;
            }
            let a0: f64 = self.g;
            let size = (q.len() / 2) as isize;
            let at = Point { q, p, t, h: 1.0, dw: &[] };
            let mut total = S::from_f64(0.0);
            match term {
                0 => {
                    {
                        let mut b0 = S::from_f64(0.0);
                        let mut i0: isize = 0;
                        let end: isize = (size);
                        while i0 < end {
                            let low = i0;
                            let len = (end - low) as usize;
                            let points0 = ((2 * i0) as isize as usize);
                            let points0 = &at
                                .p[points0..points0 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            let s2 = ((i0) as isize as usize);
                            let s2 = &self.mass[s2..s2 + len];
                            for k in 0..len {
                                let i0 = low + k as isize;
                                let l0 = points0[k][0usize];
                                let l1 = points0[k][1usize];
                                let l2 = S::from_f64(s2[k]);
                                b0 = b0 + (l1 * l1 + l0 * l0) / l2 * 0.5;
                            }
                            i0 += len as isize;
                        }
                        total = total + b0;
                    }
                    {
                        for i1 in (0 as isize)..(size) {
                            let l0 = at.q[((2 * i1) as isize as usize)];
                            let l2 = at.q[((2 * i1 + 1) as isize as usize)];
                            let l4 = S::from_f64(self.mass[((i1) as isize as usize)]);
                            let mut b0 = S::from_f64(0.0);
                            let mut i2: isize = 0;
                            let end: isize = (i1);
                            while i2 < end {
                                let low = i2;
                                let len = (end - low) as usize;
                                let points0 = ((2 * i2) as isize as usize);
                                let points0 = &at
                                    .q[points0..points0 + 2 * len]
                                    .as_chunks::<2>()
                                    .0[..len];
                                let s5 = ((i2) as isize as usize);
                                let s5 = &self.mass[s5..s5 + len];
                                for k in 0..len {
                                    let i2 = low + k as isize;
                                    let l1 = points0[k][0usize];
                                    let l3 = points0[k][1usize];
                                    let l5 = S::from_f64(s5[k]);
                                    let difference = l0 - l1;
                                    let difference2 = l2 - l3;
                                    let sum = difference2 * difference2
                                        + difference * difference;
                                    b0 = b0 + -(l4 * l5 * (sum.recip() * sum.sqrt()) * a0);
                                }
                                i2 += len as isize;
                            }
                            total = total + b0;
                        }
                    }
                }
                _ => return nan,
            }
            total
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
            let nan = S::from_f64(f64::NAN);
            if !(q.len() == p.len() && wzvi::elements::check(self, q.len()).is_ok()
                && by_q.len() == q.len() && by_p.len() == q.len())
            {
                by_q.fill(nan);
                by_p.fill(nan);
                return;
            }
            by_q.fill(S::from_f64(0.0));
            by_p.fill(S::from_f64(0.0));
            let a0: f64 = self.g;
            let size = (q.len() / 2) as isize;
            let at = Point { q, p, t, h: 1.0, dw: &[] };
            match term {
                0 => {
                    {
                        let mut i0: isize = 0;
                        let end: isize = (size);
                        while i0 < end {
                            let low = i0;
                            let len = (end - low) as usize;
                            let points0 = ((2 * i0) as isize as usize);
                            let points0 = &at
                                .p[points0..points0 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            let s2 = ((i0) as isize as usize);
                            let s2 = &self.mass[s2..s2 + len];
                            let points1 = ((2 * i0) as isize as usize);
                            let points1 = &mut by_p[points1..points1 + 2 * len]
                                .as_chunks_mut::<2>()
                                .0[..len];
                            for k in 0..len {
                                let i0 = low + k as isize;
                                let l0 = points0[k][0usize];
                                let l1 = points0[k][1usize];
                                let l2 = S::from_f64(s2[k]);
                                points1[k][0usize] = points1[k][0usize] + l0 / l2;
                                points1[k][1usize] = points1[k][1usize] + l1 / l2;
                            }
                            i0 += len as isize;
                        }
                    }
                    {
                        for i1 in (0 as isize)..(size) {
                            let l0 = at.q[((2 * i1) as isize as usize)];
                            let l2 = at.q[((2 * i1 + 1) as isize as usize)];
                            let l4 = S::from_f64(self.mass[((i1) as isize as usize)]);
                            let mut b0 = S::from_f64(0.0);
                            let mut b2 = S::from_f64(0.0);
                            let mut i2: isize = 0;
                            let end: isize = (i1);
                            while i2 < end {
                                let low = i2;
                                let len = (end - low) as usize;
                                let points0 = ((2 * i2) as isize as usize);
                                let points0 = &at
                                    .q[points0..points0 + 2 * len]
                                    .as_chunks::<2>()
                                    .0[..len];
                                let s5 = ((i2) as isize as usize);
                                let s5 = &self.mass[s5..s5 + len];
                                let points1 = ((2 * i2) as isize as usize);
                                let points1 = &mut by_q[points1..points1 + 2 * len]
                                    .as_chunks_mut::<2>()
                                    .0[..len];
                                for k in 0..len {
                                    let i2 = low + k as isize;
                                    let l1 = points0[k][0usize];
                                    let l3 = points0[k][1usize];
                                    let l5 = S::from_f64(s5[k]);
                                    let difference = l2 - l3;
                                    let difference2 = l0 - l1;
                                    let sum = difference2 * difference2
                                        + difference * difference;
                                    let l4_l5 = l4 * l5;
                                    let inverse = sum.recip();
                                    let product = inverse * (inverse * sum.sqrt());
                                    let product2 = difference2 * l4_l5 * product * a0;
                                    let product3 = product * (difference * l4_l5) * a0;
                                    points1[k][0usize] = points1[k][0usize] + -product2;
                                    points1[k][1usize] = points1[k][1usize] + -product3;
                                    b0 = b0 + product2;
                                    b2 = b2 + product3;
                                }
                                i2 += len as isize;
                            }
                            let at_index = ((2 * i1) as isize as usize);
                            by_q[at_index] = by_q[at_index] + b0;
                            let at_index = ((2 * i1 + 1) as isize as usize);
                            by_q[at_index] = by_q[at_index] + b2;
                        }
                    }
                }
                _ => {
                    by_q.fill(nan);
                    by_p.fill(nan);
                }
            }
        }
    }
    #[automatically_derived]
    impl Elements for Bodies {
        const PLACES: Places = {
            use wzvi::elements::places as places;
            places::Places {
                components: 2usize,
                tables: &[
                    places::Name {
                        name: "",
                        suffix: "",
                    },
                    places::Name {
                        name: "mass",
                        suffix: "",
                    },
                ],
                nests: &[
                    places::Nest {
                        loops: &[
                            places::Loop {
                                start: places::Index {
                                    terms: &[],
                                    constant: 0,
                                    name: places::Name {
                                        name: "0",
                                        suffix: "",
                                    },
                                },
                                end: places::Index {
                                    terms: &[(places::Atom::Size, 1)],
                                    constant: 0,
                                    name: places::Name {
                                        name: "n",
                                        suffix: "",
                                    },
                                },
                            },
                        ],
                        slots: &[
                            places::Slot::Entry(
                                1usize,
                                &[
                                    places::Position {
                                        index: places::Index {
                                            terms: &[(places::Atom::Loop(0usize), 1)],
                                            constant: 0,
                                            name: places::Name {
                                                name: "i",
                                                suffix: "",
                                            },
                                        },
                                        is_inside: false,
                                    },
                                ],
                            ),
                        ],
                    },
                    places::Nest {
                        loops: &[
                            places::Loop {
                                start: places::Index {
                                    terms: &[],
                                    constant: 0,
                                    name: places::Name {
                                        name: "0",
                                        suffix: "",
                                    },
                                },
                                end: places::Index {
                                    terms: &[(places::Atom::Size, 1)],
                                    constant: 0,
                                    name: places::Name {
                                        name: "n",
                                        suffix: "",
                                    },
                                },
                            },
                            places::Loop {
                                start: places::Index {
                                    terms: &[],
                                    constant: 0,
                                    name: places::Name {
                                        name: "0",
                                        suffix: "",
                                    },
                                },
                                end: places::Index {
                                    terms: &[(places::Atom::Loop(0usize), 1)],
                                    constant: 0,
                                    name: places::Name {
                                        name: "i",
                                        suffix: "",
                                    },
                                },
                            },
                        ],
                        slots: &[
                            places::Slot::Entry(
                                1usize,
                                &[
                                    places::Position {
                                        index: places::Index {
                                            terms: &[(places::Atom::Loop(0usize), 1)],
                                            constant: 0,
                                            name: places::Name {
                                                name: "i",
                                                suffix: "",
                                            },
                                        },
                                        is_inside: false,
                                    },
                                ],
                            ),
                            places::Slot::Entry(
                                1usize,
                                &[
                                    places::Position {
                                        index: places::Index {
                                            terms: &[(places::Atom::Loop(1usize), 1)],
                                            constant: 0,
                                            name: places::Name {
                                                name: "j",
                                                suffix: "",
                                            },
                                        },
                                        is_inside: false,
                                    },
                                ],
                            ),
                        ],
                    },
                ],
            }
        };
        fn entries(
            &self,
            table: usize,
            outer: &[usize],
            range: Range<usize>,
        ) -> Entries {
            use wzvi::elements::places as places;
            match (table, outer) {
                (1usize, &[]) => {
                    let list = &self.mass[..];
                    places::Entries::of_length(list.len())
                }
                _ => places::Entries::of_length(0),
            }
        }
        fn slopes<S: Scalar>(
            &self,
            terms: Terms,
            at: &Point<'_, S>,
            by_q: &mut [S],
            by_p: &mut [S],
        ) {
            let a0: f64 = self.g;
            let size = (at.q.len() / 2) as isize;
            let t = at.t;
            if terms.drift {
                if terms.by_p {
                    {
                        let c = S::from_f64(at.h);
                        let mut i0: isize = 0;
                        let end: isize = (size);
                        while i0 < end {
                            let low = i0;
                            let len = (end - low) as usize;
                            let points0 = ((2 * i0) as isize as usize);
                            let points0 = &at
                                .p[points0..points0 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            let s2 = ((i0) as isize as usize);
                            let s2 = &self.mass[s2..s2 + len];
                            let points1 = ((2 * i0) as isize as usize);
                            let points1 = &mut by_p[points1..points1 + 2 * len]
                                .as_chunks_mut::<2>()
                                .0[..len];
                            for k in 0..len {
                                let i0 = low + k as isize;
                                let l0 = points0[k][0usize];
                                let l1 = points0[k][1usize];
                                let l2 = S::from_f64(s2[k]);
                                points1[k][0usize] = points1[k][0usize] + l0 * c / l2;
                                points1[k][1usize] = points1[k][1usize] + l1 * c / l2;
                            }
                            i0 += len as isize;
                        }
                    }
                }
                if terms.by_q {
                    {
                        for i1 in (0 as isize)..(size) {
                            let c = S::from_f64(at.h);
                            let l0 = at.q[((2 * i1) as isize as usize)];
                            let l2 = at.q[((2 * i1 + 1) as isize as usize)];
                            let l4 = S::from_f64(self.mass[((i1) as isize as usize)]);
                            let mut b0 = S::from_f64(0.0);
                            let mut b2 = S::from_f64(0.0);
                            let mut i2: isize = 0;
                            let end: isize = (i1);
                            while i2 < end {
                                let low = i2;
                                let len = (end - low) as usize;
                                let points0 = ((2 * i2) as isize as usize);
                                let points0 = &at
                                    .q[points0..points0 + 2 * len]
                                    .as_chunks::<2>()
                                    .0[..len];
                                let s5 = ((i2) as isize as usize);
                                let s5 = &self.mass[s5..s5 + len];
                                let points1 = ((2 * i2) as isize as usize);
                                let points1 = &mut by_q[points1..points1 + 2 * len]
                                    .as_chunks_mut::<2>()
                                    .0[..len];
                                for k in 0..len {
                                    let i2 = low + k as isize;
                                    let l1 = points0[k][0usize];
                                    let l3 = points0[k][1usize];
                                    let l5 = S::from_f64(s5[k]);
                                    let difference = l2 - l3;
                                    let difference2 = l0 - l1;
                                    let sum = difference2 * difference2
                                        + difference * difference;
                                    let product = c * (l4 * l5);
                                    let inverse = sum.recip();
                                    let product2 = inverse * (inverse * sum.sqrt());
                                    let product3 = difference2 * product * product2 * a0;
                                    let product4 = product2 * (difference * product) * a0;
                                    points1[k][0usize] = points1[k][0usize] + -product3;
                                    points1[k][1usize] = points1[k][1usize] + -product4;
                                    b0 = b0 + product3;
                                    b2 = b2 + product4;
                                }
                                i2 += len as isize;
                            }
                            let at_index = ((2 * i1) as isize as usize);
                            by_q[at_index] = by_q[at_index] + b0;
                            let at_index = ((2 * i1 + 1) as isize as usize);
                            by_q[at_index] = by_q[at_index] + b2;
                        }
                    }
                }
            }
        }
        fn curvature<S: Scalar, C: Curvature<S>>(
            &self,
            terms: Terms,
            at: &Point<'_, S>,
            into: &mut C,
        ) {
            let a0: f64 = self.g;
            let size = (at.q.len() / 2) as isize;
            let t = at.t;
            if terms.drift {
                if terms.by_p {
                    {
                        let c = S::from_f64(at.h);
                        let mut i0: isize = 0;
                        let end: isize = (size);
                        while i0 < end {
                            let low = i0;
                            let len = (end - low) as usize;
                            let points0 = ((2 * i0) as isize as usize);
                            let points0 = &at
                                .p[points0..points0 + 2 * len]
                                .as_chunks::<2>()
                                .0[..len];
                            let s2 = ((i0) as isize as usize);
                            let s2 = &self.mass[s2..s2 + len];
                            for k in 0..len {
                                let i0 = low + k as isize;
                                let l0 = points0[k][0usize];
                                let l1 = points0[k][1usize];
                                let l2 = S::from_f64(s2[k]);
                                let quotient = c / l2;
                                into.add_pp(
                                    ((2 * i0) as isize as usize),
                                    ((2 * i0) as isize as usize),
                                    true,
                                    quotient,
                                );
                                into.add_pp(
                                    ((2 * i0 + 1) as isize as usize),
                                    ((2 * i0 + 1) as isize as usize),
                                    true,
                                    quotient,
                                );
                            }
                            i0 += len as isize;
                        }
                    }
                }
                if terms.by_q {
                    {
                        let three_a0 = 3.0 * a0;
                        for i1 in (0 as isize)..(size) {
                            let c = S::from_f64(at.h);
                            let l0 = at.q[((2 * i1) as isize as usize)];
                            let l2 = at.q[((2 * i1 + 1) as isize as usize)];
                            let l4 = S::from_f64(self.mass[((i1) as isize as usize)]);
                            let mut b0 = S::from_f64(0.0);
                            let mut b2 = S::from_f64(0.0);
                            let mut b7 = S::from_f64(0.0);
                            let mut i2: isize = 0;
                            let end: isize = (i1);
                            while i2 < end {
                                let low = i2;
                                let len = (end - low) as usize;
                                let points0 = ((2 * i2) as isize as usize);
                                let points0 = &at
                                    .q[points0..points0 + 2 * len]
                                    .as_chunks::<2>()
                                    .0[..len];
                                let s5 = ((i2) as isize as usize);
                                let s5 = &self.mass[s5..s5 + len];
                                for k in 0..len {
                                    let i2 = low + k as isize;
                                    let l1 = points0[k][0usize];
                                    let l3 = points0[k][1usize];
                                    let l5 = S::from_f64(s5[k]);
                                    let difference = l2 - l3;
                                    let difference2 = l0 - l1;
                                    let product = difference2 * difference2;
                                    let product2 = difference * difference;
                                    let sum = product + product2;
                                    let inverse = sum.recip();
                                    let product3 = inverse * (inverse * sum.sqrt());
                                    let product4 = inverse * product3;
                                    let product5 = l4 * (l5 * c);
                                    let product6 = (product3 - product * product4 * 3.0)
                                        * product5 * a0;
                                    let product7 = product4
                                        * (difference * (difference2 * (c * (l4 * l5)))) * three_a0;
                                    let minus = -product7;
                                    let product8 = product5
                                        * (product3 - product2 * product4 * 3.0) * a0;
                                    b0 = b0 + product6;
                                    into.add_qq(
                                        ((2 * i1) as isize as usize),
                                        ((2 * i2) as isize as usize),
                                        false,
                                        -product6,
                                    );
                                    b2 = b2 + minus;
                                    into.add_qq(
                                        ((2 * i1) as isize as usize),
                                        ((2 * i2 + 1) as isize as usize),
                                        false,
                                        product7,
                                    );
                                    into.add_qq(
                                        ((2 * i2) as isize as usize),
                                        ((2 * i2) as isize as usize),
                                        true,
                                        product6,
                                    );
                                    into.add_qq(
                                        ((2 * i2) as isize as usize),
                                        ((2 * i1 + 1) as isize as usize),
                                        false,
                                        product7,
                                    );
                                    into.add_qq(
                                        ((2 * i2) as isize as usize),
                                        ((2 * i2 + 1) as isize as usize),
                                        false,
                                        minus,
                                    );
                                    b7 = b7 + product8;
                                    into.add_qq(
                                        ((2 * i1 + 1) as isize as usize),
                                        ((2 * i2 + 1) as isize as usize),
                                        false,
                                        -product8,
                                    );
                                    into.add_qq(
                                        ((2 * i2 + 1) as isize as usize),
                                        ((2 * i2 + 1) as isize as usize),
                                        true,
                                        product8,
                                    );
                                }
                                i2 += len as isize;
                            }
                            into.add_qq(
                                ((2 * i1) as isize as usize),
                                ((2 * i1) as isize as usize),
                                true,
                                b0,
                            );
                            into.add_qq(
                                ((2 * i1) as isize as usize),
                                ((2 * i1 + 1) as isize as usize),
                                false,
                                b2,
                            );
                            into.add_qq(
                                ((2 * i1 + 1) as isize as usize),
                                ((2 * i1 + 1) as isize as usize),
                                true,
                                b7,
                            );
                        }
                    }
                }
            }
        }
    }
    const _: () = {
        const SCHEME: Scheme = Scheme {
            drift_l: 0.0,
            noise_l: 0.0,
            counter: 0.0,
            unknowns: Unknowns::None,
            remembers: false,
            is_linear: false,
            has_noise: false,
        };
        #[automatically_derived]
        impl Discretized<DeltaPlus> for Bodies {
            const PLAN: Plan = Plan {
                solver: Solver::Explicit,
                unknowns: 0,
                order: 1,
                noise: NoiseClass::None,
                consistent: true,
                conserves_energy: Knowledge::Proven,
                commuting: Knowledge::Proven,
            };
            const EQUATIONS: &'static str = "DeltaPlus\n\nHamiltonians, as sums of elements\n  H0 = Σ_(i=0..n - 1) [p[2 i + 1]²/(2 mass[i]) + p[2 i]²/(2 mass[i])] + Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j]/√((q[2 i + 1] - q[2 j + 1])² + (q[2 i] - q[2 j])²)]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = Σ_i P[i] Δq[i] - h H0(P, q)\n  Δq = q' - q\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq[i][0] is the sum of\n    P[i][0] h/mass[i]   for i = 0..n - 1\n  p = -D1 L_d:  P[i][0] = p[i][0] + v[i][0], v[i][0] is the sum of\n    Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[i][0] - q[j][0])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   for i = 0..n - 1\n    Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[j][0] - q[i][0])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   at point j\n  p' = D2 L_d:  p'[i][0] = P[i][0]\n  ∂L_d/∂P = 0:  Δq[i][1] is the sum of\n    P[i][1] h/mass[i]   for i = 0..n - 1\n  p = -D1 L_d:  P[i][1] = p[i][1] + v[i][1], v[i][1] is the sum of\n    Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[i][1] - q[j][1])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   for i = 0..n - 1\n    Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[j][1] - q[i][1])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   at point j\n  p' = D2 L_d:  p'[i][1] = P[i][1]\n\nStep\n  assign v, Δq\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h)\n";
            const REMEMBERS: bool = false;
            const IN_LANES: bool = false;
            type Prepared = ();
            type Memory<S: Scalar> = Memory<S>;
            type Compensated<S: Scalar> = CompensationVec<S>;
            type Carry<S: Scalar> = Plain;
            fn memory(&self) -> Self::Memory<f64> {
                Memory::new(self, &SCHEME)
            }
            fn prepare(&self, h: f64) -> Result<Self::Prepared, ConfigError> {
                if f64::is_nan(self.g) {
                    return Err(ConfigError::Parameter);
                }
                wzvi::elements::prepare(self)
            }
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
                wzvi::elements::advance::<
                    _,
                    S,
                    C,
                    CAREFUL,
                >(self, &SCHEME, t, h, q, p, dw, memory, carry)
            }
            fn discrete_lagrangian(
                &self,
                segment: &Segment<Self::Vector>,
                dw: &[f64],
            ) -> f64 {
                wzvi::elements::discrete_lagrangian(self, &SCHEME, segment, dw)
            }
            fn discrete_lagrangian_gradient(
                &self,
                segment: &Segment<Self::Vector>,
                dw: &[f64],
            ) -> LagrangianGradient<Self::Vector> {
                wzvi::elements::discrete_lagrangian_gradient(self, &SCHEME, segment, dw)
            }
            fn step_momentum(
                &self,
                before: &State<Self::Vector>,
                after: &State<Self::Vector>,
                h: f64,
                dw: &[f64],
            ) -> Self::Vector {
                wzvi::elements::step_momentum(self, &SCHEME, before, h, dw)
            }
        }
    };
    /// The names that are bound above, so that no constant around can stand for them.
    use ::wzvi::__private::{
        binding as a0, binding as after, binding as at, binding as at_index,
        binding as b0, binding as b2, binding as b7, binding as before, binding as by_p,
        binding as by_q, binding as c, binding as carry, binding as degrees,
        binding as difference, binding as difference2, binding as dw, binding as end,
        binding as h, binding as i0, binding as i1, binding as i2, binding as index,
        binding as into, binding as inverse, binding as k, binding as l0, binding as l1,
        binding as l2, binding as l3, binding as l4, binding as l4_l5, binding as l5,
        binding as len, binding as list, binding as low, binding as memory,
        binding as minus, binding as nan, binding as outer, binding as p,
        binding as places, binding as points0, binding as points1, binding as prepared,
        binding as product, binding as product2, binding as product3,
        binding as product4, binding as product5, binding as product6,
        binding as product7, binding as product8, binding as q, binding as quotient,
        binding as range, binding as s2, binding as s5, binding as segment,
        binding as size, binding as sum, binding as t, binding as table, binding as term,
        binding as terms, binding as three_a0, binding as total,
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
    impl __WzviTypeChecks for Bodies {
        fn __wzvi_type_checks(&self) {
            fn __wzvi_hamiltonian<
                F: ::core::ops::Fn(
                        &[[::core::primitive::f64; 2usize]],
                        &[[::core::primitive::f64; 2usize]],
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_hamiltonian_of_time<
                F: ::core::ops::Fn(
                        &[[::core::primitive::f64; 2usize]],
                        &[[::core::primitive::f64; 2usize]],
                        ::core::primitive::f64,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family<
                F: ::core::ops::Fn(
                        &[[::core::primitive::f64; 2usize]],
                        &[[::core::primitive::f64; 2usize]],
                        ::core::primitive::usize,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family_of_time<
                F: ::core::ops::Fn(
                        &[[::core::primitive::f64; 2usize]],
                        &[[::core::primitive::f64; 2usize]],
                        ::core::primitive::f64,
                        ::core::primitive::usize,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_scheme<E>(
                _: ::core::marker::PhantomData<E>,
                _: ::core::marker::PhantomData<E>,
            ) {}
            __wzvi_scheme(
                ::core::marker::PhantomData::<::wzvi::embedding::DeltaPlus>,
                ::core::marker::PhantomData::<DeltaPlus>,
            );
            {
                let g = self.g;
                let mass = &self.mass;
                __wzvi_hamiltonian(|q: &[[f64; 2]], p: &[[f64; 2]]| {
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
