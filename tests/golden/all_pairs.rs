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
    use ::wzvi::__private as __wzvi;
    #[automatically_derived]
    impl __wzvi::Hamiltonian for Bodies {
        type Vector = __wzvi::DVector<__wzvi::core::primitive::f64>;
        fn degrees(&self) -> __wzvi::core::primitive::usize {
            0
        }
        fn check(
            &self,
            __degrees: __wzvi::core::primitive::usize,
        ) -> __wzvi::core::result::Result<(), __wzvi::StepFailure> {
            __wzvi::elements::check(self, __degrees)
        }
        fn noises(&self) -> __wzvi::core::primitive::usize {
            0usize
        }
        fn invariants(&self) -> __wzvi::core::primitive::usize {
            0usize
        }
        fn parameter(
            &self,
            __index: __wzvi::core::primitive::usize,
        ) -> __wzvi::core::option::Option<
            (&'static __wzvi::core::primitive::str, __wzvi::core::primitive::f64),
        > {
            match __index {
                0usize => __wzvi::core::option::Option::Some(("g", self.g)),
                _ => __wzvi::core::option::Option::None,
            }
        }
        fn evaluate<__S: __wzvi::Scalar>(
            &self,
            __term: __wzvi::core::primitive::usize,
            __q: &[__S],
            __p: &[__S],
            __t: __wzvi::core::primitive::f64,
        ) -> __S {
            __wzvi::elements::evaluate(self, __term, __q, __p, __t)
        }
        fn differentiate<__S: __wzvi::Scalar>(
            &self,
            __term: __wzvi::core::primitive::usize,
            __q: &[__S],
            __p: &[__S],
            __t: __wzvi::core::primitive::f64,
            __by_q: &mut [__S],
            __by_p: &mut [__S],
        ) {
            __wzvi::elements::differentiate(self, __term, __q, __p, __t, __by_q, __by_p);
        }
        fn invariant(
            &self,
            __number: __wzvi::core::primitive::usize,
            __state: &__wzvi::State<Self::Vector>,
        ) -> __wzvi::core::primitive::f64 {
            __wzvi::elements::invariant(self, __number, __state)
        }
        fn energy_rate(
            &self,
            __k: __wzvi::core::primitive::usize,
            __state: &__wzvi::State<Self::Vector>,
        ) -> __wzvi::core::primitive::f64 {
            __wzvi::elements::energy_rate(self, __k, __state)
        }
    }
    #[automatically_derived]
    impl __wzvi::elements::Elements for Bodies {
        const PLACES: __wzvi::elements::places::Places = {
            use __wzvi::elements::places as __places;
            __places::Places {
                components: 2usize,
                tables: &[
                    __places::Name {
                        name: "",
                        suffix: "",
                    },
                    __places::Name {
                        name: "mass",
                        suffix: "",
                    },
                ],
                nests: &[
                    __places::Nest {
                        loops: &[
                            __places::Loop {
                                start: __places::Index {
                                    terms: &[],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "0",
                                        suffix: "",
                                    },
                                },
                                end: __places::Index {
                                    terms: &[(__places::Atom::Size, 1)],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "n",
                                        suffix: "",
                                    },
                                },
                            },
                        ],
                        slots: &[
                            __places::Slot::Entry(
                                1usize,
                                &[
                                    __places::Position {
                                        index: __places::Index {
                                            terms: &[(__places::Atom::Loop(0usize), 1)],
                                            constant: 0,
                                            name: __places::Name {
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
                    __places::Nest {
                        loops: &[
                            __places::Loop {
                                start: __places::Index {
                                    terms: &[],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "0",
                                        suffix: "",
                                    },
                                },
                                end: __places::Index {
                                    terms: &[(__places::Atom::Size, 1)],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "n",
                                        suffix: "",
                                    },
                                },
                            },
                            __places::Loop {
                                start: __places::Index {
                                    terms: &[],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "0",
                                        suffix: "",
                                    },
                                },
                                end: __places::Index {
                                    terms: &[(__places::Atom::Loop(0usize), 1)],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "i",
                                        suffix: "",
                                    },
                                },
                            },
                        ],
                        slots: &[
                            __places::Slot::Entry(
                                1usize,
                                &[
                                    __places::Position {
                                        index: __places::Index {
                                            terms: &[(__places::Atom::Loop(0usize), 1)],
                                            constant: 0,
                                            name: __places::Name {
                                                name: "i",
                                                suffix: "",
                                            },
                                        },
                                        is_inside: false,
                                    },
                                ],
                            ),
                            __places::Slot::Entry(
                                1usize,
                                &[
                                    __places::Position {
                                        index: __places::Index {
                                            terms: &[(__places::Atom::Loop(1usize), 1)],
                                            constant: 0,
                                            name: __places::Name {
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
            __table: __wzvi::core::primitive::usize,
            __outer: &[__wzvi::core::primitive::usize],
            __range: __wzvi::core::ops::Range<__wzvi::core::primitive::usize>,
        ) -> __wzvi::elements::places::Entries {
            use __wzvi::elements::places as __places;
            match (__table, __outer) {
                (1usize, &[]) => {
                    let __list = &self.mass[..];
                    __places::Entries::of_length(__list.len())
                }
                _ => __places::Entries::of_length(0),
            }
        }
        const INTEGRALS: __wzvi::core::primitive::usize = 3usize;
        fn value<__S: __wzvi::Scalar>(
            &self,
            __part: __wzvi::core::primitive::usize,
            __weight: __wzvi::core::primitive::f64,
            __at: &__wzvi::elements::Point<'_, __S>,
        ) -> __S {
            let __a0: __wzvi::core::primitive::f64 = self.g;
            let __size = (__at.q.len() / 2) as __wzvi::core::primitive::isize;
            let __t = __at.t;
            let mut __value = <__S as __wzvi::Scalar>::from_f64(0.0);
            match __part {
                0usize => {
                    let mut __total = <__S as __wzvi::Scalar>::from_f64(0.0);
                    {
                        let mut __b0 = <__S as __wzvi::Scalar>::from_f64(0.0);
                        let mut __i0: __wzvi::core::primitive::isize = 0;
                        let __end: __wzvi::core::primitive::isize = (__size);
                        while __i0 < __end {
                            let __low = __i0;
                            let __len = (__end - __low)
                                as __wzvi::core::primitive::usize;
                            let __points0 = ((2 * __i0) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize);
                            let __points0 = &__at
                                .p[__points0..__points0 + 2 * __len]
                                .as_chunks::<2>()
                                .0[..__len];
                            let __s2 = ((__i0) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize);
                            let __s2 = &self.mass[__s2..__s2 + __len];
                            for __k in 0..__len {
                                let __i0 = __low + __k as __wzvi::core::primitive::isize;
                                let __l0 = __points0[__k][0usize];
                                let __l1 = __points0[__k][1usize];
                                let __l2 = <__S as __wzvi::Scalar>::from_f64(__s2[__k]);
                                __b0 = __b0 + (__l1 * __l1 + __l0 * __l0) / __l2 * 0.5f64;
                            }
                            __i0 += __len as __wzvi::core::primitive::isize;
                        }
                        __total = __total + __b0;
                    }
                    {
                        for __i1 in (0 as __wzvi::core::primitive::isize)..(__size) {
                            let __l0 = __at
                                .q[((2 * __i1) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize)];
                            let __l2 = __at
                                .q[((2 * __i1 + 1) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize)];
                            let __l4 = <__S as __wzvi::Scalar>::from_f64(
                                self
                                    .mass[((__i1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize)],
                            );
                            let mut __b0 = <__S as __wzvi::Scalar>::from_f64(0.0);
                            let mut __i2: __wzvi::core::primitive::isize = 0;
                            let __end: __wzvi::core::primitive::isize = (__i1);
                            while __i2 < __end {
                                let __low = __i2;
                                let __len = (__end - __low)
                                    as __wzvi::core::primitive::usize;
                                let __points0 = ((2 * __i2)
                                    as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __points0 = &__at
                                    .q[__points0..__points0 + 2 * __len]
                                    .as_chunks::<2>()
                                    .0[..__len];
                                let __s5 = ((__i2) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s5 = &self.mass[__s5..__s5 + __len];
                                for __k in 0..__len {
                                    let __i2 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l1 = __points0[__k][0usize];
                                    let __l3 = __points0[__k][1usize];
                                    let __l5 = <__S as __wzvi::Scalar>::from_f64(__s5[__k]);
                                    let __x0 = __l0 - __l1;
                                    let __x1 = __l2 - __l3;
                                    let __x2 = __x1 * __x1 + __x0 * __x0;
                                    __b0 = __b0
                                        + -(__l4 * __l5 * (__x2.recip() * __x2.sqrt()) * __a0);
                                }
                                __i2 += __len as __wzvi::core::primitive::isize;
                            }
                            __total = __total + __b0;
                        }
                    }
                    __value = __value
                        + __total * <__S as __wzvi::Scalar>::from_f64(__at.h);
                }
                _ => {}
            }
            __value
        }
        fn slopes<__S: __wzvi::Scalar>(
            &self,
            __part: __wzvi::core::primitive::usize,
            __weight: __wzvi::core::primitive::f64,
            __at: &__wzvi::elements::Point<'_, __S>,
            __wanted: __wzvi::elements::Slopes,
            __by_q: &mut [__S],
            __by_p: &mut [__S],
        ) {
            let __a0: __wzvi::core::primitive::f64 = self.g;
            let __size = (__at.q.len() / 2) as __wzvi::core::primitive::isize;
            let __t = __at.t;
            match __part {
                0usize => {
                    if __wanted.by_p {
                        {
                            let __c = <__S as __wzvi::Scalar>::from_f64(__at.h);
                            let mut __i0: __wzvi::core::primitive::isize = 0;
                            let __end: __wzvi::core::primitive::isize = (__size);
                            while __i0 < __end {
                                let __low = __i0;
                                let __len = (__end - __low)
                                    as __wzvi::core::primitive::usize;
                                let __points0 = ((2 * __i0)
                                    as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __points0 = &__at
                                    .p[__points0..__points0 + 2 * __len]
                                    .as_chunks::<2>()
                                    .0[..__len];
                                let __s2 = ((__i0) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s2 = &self.mass[__s2..__s2 + __len];
                                let __points1 = ((2 * __i0)
                                    as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __points1 = &mut __by_p[__points1..__points1
                                        + 2 * __len]
                                    .as_chunks_mut::<2>()
                                    .0[..__len];
                                for __k in 0..__len {
                                    let __i0 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = __points0[__k][0usize];
                                    let __l1 = __points0[__k][1usize];
                                    let __l2 = <__S as __wzvi::Scalar>::from_f64(__s2[__k]);
                                    __points1[__k][0usize] = __points1[__k][0usize]
                                        + __l0 * __c / __l2;
                                    __points1[__k][1usize] = __points1[__k][1usize]
                                        + __l1 * __c / __l2;
                                }
                                __i0 += __len as __wzvi::core::primitive::isize;
                            }
                        }
                    }
                    if __wanted.by_q {
                        {
                            for __i1 in (0 as __wzvi::core::primitive::isize)..(__size) {
                                let __c = <__S as __wzvi::Scalar>::from_f64(__at.h);
                                let __l0 = __at
                                    .q[((2 * __i1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize)];
                                let __l2 = __at
                                    .q[((2 * __i1 + 1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize)];
                                let __l4 = <__S as __wzvi::Scalar>::from_f64(
                                    self
                                        .mass[((__i1) as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize)],
                                );
                                let mut __b0 = <__S as __wzvi::Scalar>::from_f64(0.0);
                                let mut __b2 = <__S as __wzvi::Scalar>::from_f64(0.0);
                                let mut __i2: __wzvi::core::primitive::isize = 0;
                                let __end: __wzvi::core::primitive::isize = (__i1);
                                while __i2 < __end {
                                    let __low = __i2;
                                    let __len = (__end - __low)
                                        as __wzvi::core::primitive::usize;
                                    let __points0 = ((2 * __i2)
                                        as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize);
                                    let __points0 = &__at
                                        .q[__points0..__points0 + 2 * __len]
                                        .as_chunks::<2>()
                                        .0[..__len];
                                    let __s5 = ((__i2) as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize);
                                    let __s5 = &self.mass[__s5..__s5 + __len];
                                    let __points1 = ((2 * __i2)
                                        as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize);
                                    let __points1 = &mut __by_q[__points1..__points1
                                            + 2 * __len]
                                        .as_chunks_mut::<2>()
                                        .0[..__len];
                                    for __k in 0..__len {
                                        let __i2 = __low + __k as __wzvi::core::primitive::isize;
                                        let __l1 = __points0[__k][0usize];
                                        let __l3 = __points0[__k][1usize];
                                        let __l5 = <__S as __wzvi::Scalar>::from_f64(__s5[__k]);
                                        let __x0 = __l2 - __l3;
                                        let __x1 = __l0 - __l1;
                                        let __x2 = __x1 * __x1 + __x0 * __x0;
                                        let __x3 = __c * (__l4 * __l5);
                                        let __x4 = __x2.recip();
                                        let __x5 = __x4 * (__x4 * __x2.sqrt());
                                        let __x6 = __x1 * __x3 * __x5 * __a0;
                                        let __x7 = __x5 * (__x0 * __x3) * __a0;
                                        __points1[__k][0usize] = __points1[__k][0usize] + -__x6;
                                        __points1[__k][1usize] = __points1[__k][1usize] + -__x7;
                                        __b0 = __b0 + __x6;
                                        __b2 = __b2 + __x7;
                                    }
                                    __i2 += __len as __wzvi::core::primitive::isize;
                                }
                                let __at_index = ((2 * __i1)
                                    as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                __by_q[__at_index] = __by_q[__at_index] + __b0;
                                let __at_index = ((2 * __i1 + 1)
                                    as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                __by_q[__at_index] = __by_q[__at_index] + __b2;
                            }
                        }
                    }
                }
                _ => {}
            }
        }
        fn curvature<__S: __wzvi::Scalar, __C: __wzvi::elements::Curvature<__S>>(
            &self,
            __part: __wzvi::core::primitive::usize,
            __weight: __wzvi::core::primitive::f64,
            __at: &__wzvi::elements::Point<'_, __S>,
            __wanted: __wzvi::elements::Slopes,
            __into: &mut __C,
        ) {
            let __a0: __wzvi::core::primitive::f64 = self.g;
            let __size = (__at.q.len() / 2) as __wzvi::core::primitive::isize;
            let __t = __at.t;
            match __part {
                0usize => {
                    if __wanted.by_p {
                        {
                            let __c = <__S as __wzvi::Scalar>::from_f64(__at.h);
                            let mut __i0: __wzvi::core::primitive::isize = 0;
                            let __end: __wzvi::core::primitive::isize = (__size);
                            while __i0 < __end {
                                let __low = __i0;
                                let __len = (__end - __low)
                                    as __wzvi::core::primitive::usize;
                                let __points0 = ((2 * __i0)
                                    as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __points0 = &__at
                                    .p[__points0..__points0 + 2 * __len]
                                    .as_chunks::<2>()
                                    .0[..__len];
                                let __s2 = ((__i0) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s2 = &self.mass[__s2..__s2 + __len];
                                for __k in 0..__len {
                                    let __i0 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = __points0[__k][0usize];
                                    let __l1 = __points0[__k][1usize];
                                    let __l2 = <__S as __wzvi::Scalar>::from_f64(__s2[__k]);
                                    let __x0 = __c / __l2;
                                    __into
                                        .add_pp(
                                            ((2 * __i0) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            ((2 * __i0) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            true,
                                            __x0,
                                        );
                                    __into
                                        .add_pp(
                                            ((2 * __i0 + 1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            ((2 * __i0 + 1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            true,
                                            __x0,
                                        );
                                }
                                __i0 += __len as __wzvi::core::primitive::isize;
                            }
                        }
                    }
                    if __wanted.by_q {
                        {
                            let __x0 = 3f64 * __a0;
                            for __i1 in (0 as __wzvi::core::primitive::isize)..(__size) {
                                let __c = <__S as __wzvi::Scalar>::from_f64(__at.h);
                                let __l0 = __at
                                    .q[((2 * __i1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize)];
                                let __l2 = __at
                                    .q[((2 * __i1 + 1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize)];
                                let __l4 = <__S as __wzvi::Scalar>::from_f64(
                                    self
                                        .mass[((__i1) as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize)],
                                );
                                let mut __b0 = <__S as __wzvi::Scalar>::from_f64(0.0);
                                let mut __b2 = <__S as __wzvi::Scalar>::from_f64(0.0);
                                let mut __b7 = <__S as __wzvi::Scalar>::from_f64(0.0);
                                let mut __i2: __wzvi::core::primitive::isize = 0;
                                let __end: __wzvi::core::primitive::isize = (__i1);
                                while __i2 < __end {
                                    let __low = __i2;
                                    let __len = (__end - __low)
                                        as __wzvi::core::primitive::usize;
                                    let __points0 = ((2 * __i2)
                                        as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize);
                                    let __points0 = &__at
                                        .q[__points0..__points0 + 2 * __len]
                                        .as_chunks::<2>()
                                        .0[..__len];
                                    let __s5 = ((__i2) as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize);
                                    let __s5 = &self.mass[__s5..__s5 + __len];
                                    for __k in 0..__len {
                                        let __i2 = __low + __k as __wzvi::core::primitive::isize;
                                        let __l1 = __points0[__k][0usize];
                                        let __l3 = __points0[__k][1usize];
                                        let __l5 = <__S as __wzvi::Scalar>::from_f64(__s5[__k]);
                                        let __x1 = __l2 - __l3;
                                        let __x2 = __l0 - __l1;
                                        let __x3 = __x2 * __x2;
                                        let __x4 = __x1 * __x1;
                                        let __x5 = __x3 + __x4;
                                        let __x6 = __x5.recip();
                                        let __x7 = __x6 * (__x6 * __x5.sqrt());
                                        let __x8 = __x6 * __x7;
                                        let __x9 = __l4 * (__l5 * __c);
                                        let __x10 = (__x7 - __x3 * __x8 * 3f64) * __x9 * __a0;
                                        let __x11 = __x8 * (__x1 * (__x2 * (__c * (__l4 * __l5))))
                                            * __x0;
                                        let __x12 = -__x11;
                                        let __x13 = __x9 * (__x7 - __x4 * __x8 * 3f64) * __a0;
                                        __b0 = __b0 + __x10;
                                        __into
                                            .add_qq(
                                                ((2 * __i1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                ((2 * __i2) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                false,
                                                -__x10,
                                            );
                                        __b2 = __b2 + __x12;
                                        __into
                                            .add_qq(
                                                ((2 * __i1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                ((2 * __i2 + 1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                false,
                                                __x11,
                                            );
                                        __into
                                            .add_qq(
                                                ((2 * __i2) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                ((2 * __i2) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                true,
                                                __x10,
                                            );
                                        __into
                                            .add_qq(
                                                ((2 * __i2) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                ((2 * __i1 + 1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                false,
                                                __x11,
                                            );
                                        __into
                                            .add_qq(
                                                ((2 * __i2) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                ((2 * __i2 + 1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                false,
                                                __x12,
                                            );
                                        __b7 = __b7 + __x13;
                                        __into
                                            .add_qq(
                                                ((2 * __i1 + 1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                ((2 * __i2 + 1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                false,
                                                -__x13,
                                            );
                                        __into
                                            .add_qq(
                                                ((2 * __i2 + 1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                ((2 * __i2 + 1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize),
                                                true,
                                                __x13,
                                            );
                                    }
                                    __i2 += __len as __wzvi::core::primitive::isize;
                                }
                                __into
                                    .add_qq(
                                        ((2 * __i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize),
                                        ((2 * __i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize),
                                        true,
                                        __b0,
                                    );
                                __into
                                    .add_qq(
                                        ((2 * __i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize),
                                        ((2 * __i1 + 1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize),
                                        false,
                                        __b2,
                                    );
                                __into
                                    .add_qq(
                                        ((2 * __i1 + 1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize),
                                        ((2 * __i1 + 1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize),
                                        true,
                                        __b7,
                                    );
                            }
                        }
                    }
                }
                _ => {}
            }
        }
    }
    const _: () = {
        const __SCHEME: __wzvi::elements::Scheme = __wzvi::elements::Scheme {
            stages: &[
                __wzvi::elements::Stage {
                    point: 0f64,
                    start: 1f64,
                    end: 0f64,
                    parts: &[(0usize, 1f64)],
                },
            ],
            update: __wzvi::elements::MomentumUpdate::Multiple(1f64),
            unknowns: __wzvi::elements::Unknowns::None,
            remembers: false,
            is_linear: false,
        };
        #[automatically_derived]
        impl __wzvi::Discretized<__wzvi::embedding::DeltaPlus> for Bodies {
            const PLAN: __wzvi::Plan = __wzvi::Plan {
                solver: __wzvi::Solver::Explicit,
                unknowns: 0,
                order: 1u32,
                noise: __wzvi::NoiseClass::None,
                consistent: true,
                conserves_energy: __wzvi::Knowledge::Proven,
                commuting: __wzvi::Knowledge::Proven,
            };
            const EQUATIONS: &'static __wzvi::core::primitive::str = "DeltaPlus\n\nHamiltonians, as sums of elements\n  H0 = Σ_(i=0..n - 1) [p[2 i + 1]²/(2 mass[i]) + p[2 i]²/(2 mass[i])] + Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j]/√((q[2 i + 1] - q[2 j + 1])² + (q[2 i] - q[2 j])²)]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = Σ_i P[i] Δq[i] - h H0(P, q)\n  Δq = q' - q\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq[i][0] is the sum of\n    P[i][0] h/mass[i]   for i = 0..n - 1\n  p = -D1 L_d:  P[i][0] = p[i][0] + v[i][0], v[i][0] is the sum of\n    Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[i][0] - q[j][0])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   for i = 0..n - 1\n    Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[j][0] - q[i][0])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   at point j\n  p' = D2 L_d:  p'[i][0] = P[i][0]\n  ∂L_d/∂P = 0:  Δq[i][1] is the sum of\n    P[i][1] h/mass[i]   for i = 0..n - 1\n  p = -D1 L_d:  P[i][1] = p[i][1] + v[i][1], v[i][1] is the sum of\n    Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[i][1] - q[j][1])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   for i = 0..n - 1\n    Σ_(i=0..n - 1) Σ_(j=0..i - 1) [-g mass[i] mass[j] h (q[j][1] - q[i][1])/((q[i][1] - q[j][1])² + (q[i][0] - q[j][0])²)^(3/2)]   at point j\n  p' = D2 L_d:  p'[i][1] = P[i][1]\n\nStep\n  assign v, Δq\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h)\n";
            const REMEMBERS: __wzvi::core::primitive::bool = false;
            const IN_LANES: __wzvi::core::primitive::bool = false;
            type Compensated<__S: __wzvi::Scalar> = __wzvi::elements::CompensationVec<
                __S,
            >;
            type Carry<__S: __wzvi::Scalar> = __wzvi::Plain;
            type Prepared = ();
            type Memory<__S: __wzvi::Scalar> = __wzvi::elements::Memory<__S>;
            fn memory(&self) -> __wzvi::elements::Memory<__wzvi::core::primitive::f64> {
                __wzvi::elements::Memory::new(self, &__SCHEME)
            }
            fn prepare(
                &self,
                __h: __wzvi::core::primitive::f64,
            ) -> __wzvi::core::result::Result<(), __wzvi::ConfigError> {
                if __wzvi::core::primitive::f64::is_nan(self.g) {
                    return __wzvi::core::result::Result::Err(
                        __wzvi::ConfigError::Parameter,
                    );
                }
                __wzvi::elements::prepare(self)
            }
            fn advance_carrying<
                __S: __wzvi::Scalar,
                __C: __wzvi::Carry<__S>,
                const __CAREFUL: __wzvi::core::primitive::bool,
            >(
                &self,
                __prepared: &(),
                __t: __wzvi::core::primitive::f64,
                __h: __wzvi::core::primitive::f64,
                __q: &mut [__S],
                __p: &mut [__S],
                __dw: &[__S],
                __memory: &mut __wzvi::elements::Memory<__S>,
                __carry: &mut __C,
            ) -> __wzvi::core::result::Result<__wzvi::Effort, __wzvi::StepFailure> {
                __wzvi::elements::advance::<
                    _,
                    __S,
                    __C,
                    __CAREFUL,
                >(self, &__SCHEME, __t, __h, __q, __p, __dw, __memory, __carry)
            }
            fn discrete_lagrangian(
                &self,
                __segment: &__wzvi::Segment<Self::Vector>,
                __dw: &[__wzvi::core::primitive::f64],
            ) -> __wzvi::core::primitive::f64 {
                __wzvi::elements::discrete_lagrangian(self, &__SCHEME, __segment, __dw)
            }
            fn discrete_lagrangian_gradient(
                &self,
                __segment: &__wzvi::Segment<Self::Vector>,
                __dw: &[__wzvi::core::primitive::f64],
            ) -> __wzvi::LagrangianGradient<Self::Vector> {
                __wzvi::elements::discrete_lagrangian_gradient(
                    self,
                    &__SCHEME,
                    __segment,
                    __dw,
                )
            }
            fn step_momentum(
                &self,
                __before: &__wzvi::State<Self::Vector>,
                __after: &__wzvi::State<Self::Vector>,
                __h: __wzvi::core::primitive::f64,
                __dw: &[__wzvi::core::primitive::f64],
            ) -> Self::Vector {
                __wzvi::elements::step_momentum(
                    self,
                    &__SCHEME,
                    __before,
                    __after,
                    __h,
                    __dw,
                )
            }
        }
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
