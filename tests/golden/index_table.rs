// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[f64], p: &[f64]| { p.iter().map(|p| 0.5 * p * p).sum::<f64>() + bonds.iter().map(|&(a, b, k)| 0.5 * k * (q[a] - q[b]).powi(2)).sum::<f64>() }, embedding = DeltaPlus)]
// pub struct Bonds { pub bonds: Vec<(usize, usize, f64)> }

use wzvi::prelude::*;

/**
# Discrete equations

```text
DeltaPlus

Hamiltonians, as sums of elements
  H0 = Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..bonds.len() - 1) [bonds.2[i] (q[bonds.0[i]] - q[bonds.1[i]])²/2]

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = Σ_i P[i] Δq[i] - h H0(P, q)
  Δq = q' - q

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq[i] is the sum of
    P[i] h   for i = 0..n - 1
  p = -D1 L_d:  P[i] = p[i] + v[i], v[i] is the sum of
    Σ_(i=0..bonds.len() - 1) [-bonds.2[i] h (q[bonds.0[i]] - q[bonds.1[i]])]   at point bonds.0[i]
    Σ_(i=0..bonds.len() - 1) [bonds.2[i] h (q[bonds.0[i]] - q[bonds.1[i]])]   at point bonds.1[i]
  p' = D2 L_d:  p'[i] = P[i]

Step
  assign v, Δq

Facts
  H0 is a first integral: kept by the step nearly, within O(h)

```
*/
pub struct Bonds {
    pub bonds: Vec<(usize, usize, f64)>,
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
    impl __wzvi::Hamiltonian for Bonds {
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
    impl __wzvi::elements::Elements for Bonds {
        const PLACES: __wzvi::elements::places::Places = {
            use __wzvi::elements::places as __places;
            __places::Places {
                components: 1usize,
                tables: &[
                    __places::Name {
                        name: "bonds.len()",
                        suffix: "",
                    },
                    __places::Name {
                        name: "",
                        suffix: "",
                    },
                    __places::Name {
                        name: "bonds",
                        suffix: ".0",
                    },
                    __places::Name {
                        name: "bonds",
                        suffix: ".1",
                    },
                    __places::Name {
                        name: "",
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
                                    terms: &[(__places::Atom::Given(0usize, &[]), 1)],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "bonds.len()",
                                        suffix: "",
                                    },
                                },
                            },
                        ],
                        slots: &[
                            __places::Slot::State {
                                index: __places::Index {
                                    terms: &[
                                        (
                                            __places::Atom::Given(
                                                2usize,
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
                                                        is_inside: true,
                                                    },
                                                ],
                                            ),
                                            1,
                                        ),
                                    ],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "bonds.0[i]",
                                        suffix: "",
                                    },
                                },
                                is_natural: false,
                            },
                            __places::Slot::State {
                                index: __places::Index {
                                    terms: &[
                                        (
                                            __places::Atom::Given(
                                                3usize,
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
                                                        is_inside: true,
                                                    },
                                                ],
                                            ),
                                            1,
                                        ),
                                    ],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "bonds.1[i]",
                                        suffix: "",
                                    },
                                },
                                is_natural: false,
                            },
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
                (0usize, []) => {
                    __places::Entries::of_integer(
                        (self.bonds.len()) as __wzvi::core::primitive::i128,
                    )
                }
                (2usize, &[]) => {
                    let __list = &self.bonds[..];
                    __places::Entries::of_list(
                        __list,
                        __range,
                        |__entry| (*__entry).0,
                        |__integer| __integer as __wzvi::core::primitive::i128,
                    )
                }
                (3usize, &[]) => {
                    let __list = &self.bonds[..];
                    __places::Entries::of_list(
                        __list,
                        __range,
                        |__entry| (*__entry).1,
                        |__integer| __integer as __wzvi::core::primitive::i128,
                    )
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
            let __size = (__at.q.len() / 1) as __wzvi::core::primitive::isize;
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
                            let __s0 = ((__i0) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize);
                            let __s0 = &__at.p[__s0..__s0 + __len];
                            for __k in 0..__len {
                                let __i0 = __low + __k as __wzvi::core::primitive::isize;
                                let __l0 = __s0[__k];
                                __b0 = __b0 + __l0 * __l0 * 0.5f64;
                            }
                            __i0 += __len as __wzvi::core::primitive::isize;
                        }
                        __total = __total + __b0;
                    }
                    {
                        let mut __b0 = <__S as __wzvi::Scalar>::from_f64(0.0);
                        let mut __i1: __wzvi::core::primitive::isize = 0;
                        let __end: __wzvi::core::primitive::isize = ((self.bonds.len()
                            as __wzvi::core::primitive::isize));
                        while __i1 < __end {
                            let __low = __i1;
                            let __len = (__end - __low)
                                as __wzvi::core::primitive::usize;
                            for __k in 0..__len {
                                let __i1 = __low + __k as __wzvi::core::primitive::isize;
                                let __l0 = <__S as __wzvi::Scalar>::from_f64(
                                    self
                                        .bonds[((__i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize)]
                                        .2,
                                );
                                let __l1 = __at
                                    .q[(((self
                                    .bonds[((__i1) as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize)]
                                    .0 as __wzvi::core::primitive::isize))
                                    as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize)];
                                let __l2 = __at
                                    .q[(((self
                                    .bonds[((__i1) as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize)]
                                    .1 as __wzvi::core::primitive::isize))
                                    as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize)];
                                let __x0 = __l1 - __l2;
                                __b0 = __b0 + __l0 * (__x0 * __x0) * 0.5f64;
                            }
                            __i1 += __len as __wzvi::core::primitive::isize;
                        }
                        __total = __total + __b0;
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
            let __size = (__at.q.len() / 1) as __wzvi::core::primitive::isize;
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
                                let __s0 = ((__i0) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s0 = &__at.p[__s0..__s0 + __len];
                                let __b0 = ((__i0) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __b0 = &mut __by_p[__b0..__b0 + __len];
                                for __k in 0..__len {
                                    let __i0 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = __s0[__k];
                                    __b0[__k] = __b0[__k] + __l0 * __c;
                                }
                                __i0 += __len as __wzvi::core::primitive::isize;
                            }
                        }
                    }
                    if __wanted.by_q {
                        {
                            let __c = <__S as __wzvi::Scalar>::from_f64(__at.h);
                            let mut __i1: __wzvi::core::primitive::isize = 0;
                            let __end: __wzvi::core::primitive::isize = ((self
                                .bonds
                                .len() as __wzvi::core::primitive::isize));
                            while __i1 < __end {
                                let __low = __i1;
                                let __len = (__end - __low)
                                    as __wzvi::core::primitive::usize;
                                for __k in 0..__len {
                                    let __i1 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = <__S as __wzvi::Scalar>::from_f64(
                                        self
                                            .bonds[((__i1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize)]
                                            .2,
                                    );
                                    let __l1 = __at
                                        .q[(((self
                                        .bonds[((__i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize)]
                                        .0 as __wzvi::core::primitive::isize))
                                        as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize)];
                                    let __l2 = __at
                                        .q[(((self
                                        .bonds[((__i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize)]
                                        .1 as __wzvi::core::primitive::isize))
                                        as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize)];
                                    let __x0 = (__l1 - __l2) * (__l0 * __c);
                                    let __at_index = (((self
                                        .bonds[((__i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize)]
                                        .0 as __wzvi::core::primitive::isize))
                                        as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize);
                                    __by_q[__at_index] = __by_q[__at_index] + __x0;
                                    let __at_index = (((self
                                        .bonds[((__i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize)]
                                        .1 as __wzvi::core::primitive::isize))
                                        as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize);
                                    __by_q[__at_index] = __by_q[__at_index] + -__x0;
                                }
                                __i1 += __len as __wzvi::core::primitive::isize;
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
            let __size = (__at.q.len() / 1) as __wzvi::core::primitive::isize;
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
                                let __s0 = ((__i0) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s0 = &__at.p[__s0..__s0 + __len];
                                for __k in 0..__len {
                                    let __i0 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = __s0[__k];
                                    __into
                                        .add_pp(
                                            ((__i0) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            ((__i0) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            true,
                                            __c,
                                        );
                                }
                                __i0 += __len as __wzvi::core::primitive::isize;
                            }
                        }
                    }
                    if __wanted.by_q {
                        {
                            let __c = <__S as __wzvi::Scalar>::from_f64(__at.h);
                            let mut __i1: __wzvi::core::primitive::isize = 0;
                            let __end: __wzvi::core::primitive::isize = ((self
                                .bonds
                                .len() as __wzvi::core::primitive::isize));
                            while __i1 < __end {
                                let __low = __i1;
                                let __len = (__end - __low)
                                    as __wzvi::core::primitive::usize;
                                for __k in 0..__len {
                                    let __i1 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = <__S as __wzvi::Scalar>::from_f64(
                                        self
                                            .bonds[((__i1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize)]
                                            .2,
                                    );
                                    let __l1 = __at
                                        .q[(((self
                                        .bonds[((__i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize)]
                                        .0 as __wzvi::core::primitive::isize))
                                        as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize)];
                                    let __l2 = __at
                                        .q[(((self
                                        .bonds[((__i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize)]
                                        .1 as __wzvi::core::primitive::isize))
                                        as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize)];
                                    let __x0 = __l0 * __c;
                                    __into
                                        .add_qq(
                                            (((self
                                                .bonds[((__i1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize)]
                                                .0 as __wzvi::core::primitive::isize))
                                                as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            (((self
                                                .bonds[((__i1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize)]
                                                .0 as __wzvi::core::primitive::isize))
                                                as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            true,
                                            __x0,
                                        );
                                    __into
                                        .add_qq(
                                            (((self
                                                .bonds[((__i1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize)]
                                                .0 as __wzvi::core::primitive::isize))
                                                as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            (((self
                                                .bonds[((__i1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize)]
                                                .1 as __wzvi::core::primitive::isize))
                                                as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            false,
                                            -__x0,
                                        );
                                    __into
                                        .add_qq(
                                            (((self
                                                .bonds[((__i1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize)]
                                                .1 as __wzvi::core::primitive::isize))
                                                as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            (((self
                                                .bonds[((__i1) as __wzvi::core::primitive::isize
                                                    as __wzvi::core::primitive::usize)]
                                                .1 as __wzvi::core::primitive::isize))
                                                as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            true,
                                            __x0,
                                        );
                                }
                                __i1 += __len as __wzvi::core::primitive::isize;
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
        impl __wzvi::Discretized<__wzvi::embedding::DeltaPlus> for Bonds {
            const PLAN: __wzvi::Plan = __wzvi::Plan {
                solver: __wzvi::Solver::Explicit,
                unknowns: 0,
                order: 1u32,
                noise: __wzvi::NoiseClass::None,
                consistent: true,
                conserves_energy: __wzvi::Knowledge::Proven,
                commuting: __wzvi::Knowledge::Proven,
            };
            const EQUATIONS: &'static __wzvi::core::primitive::str = "DeltaPlus\n\nHamiltonians, as sums of elements\n  H0 = Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..bonds.len() - 1) [bonds.2[i] (q[bonds.0[i]] - q[bonds.1[i]])²/2]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = Σ_i P[i] Δq[i] - h H0(P, q)\n  Δq = q' - q\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq[i] is the sum of\n    P[i] h   for i = 0..n - 1\n  p = -D1 L_d:  P[i] = p[i] + v[i], v[i] is the sum of\n    Σ_(i=0..bonds.len() - 1) [-bonds.2[i] h (q[bonds.0[i]] - q[bonds.1[i]])]   at point bonds.0[i]\n    Σ_(i=0..bonds.len() - 1) [bonds.2[i] h (q[bonds.0[i]] - q[bonds.1[i]])]   at point bonds.1[i]\n  p' = D2 L_d:  p'[i] = P[i]\n\nStep\n  assign v, Δq\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h)\n";
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
    impl __WzviTypeChecks for Bonds {
        fn __wzvi_type_checks(&self) {
            fn __wzvi_hamiltonian<
                F: ::core::ops::Fn(
                        &[::core::primitive::f64],
                        &[::core::primitive::f64],
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_hamiltonian_of_time<
                F: ::core::ops::Fn(
                        &[::core::primitive::f64],
                        &[::core::primitive::f64],
                        ::core::primitive::f64,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family<
                F: ::core::ops::Fn(
                        &[::core::primitive::f64],
                        &[::core::primitive::f64],
                        ::core::primitive::usize,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family_of_time<
                F: ::core::ops::Fn(
                        &[::core::primitive::f64],
                        &[::core::primitive::f64],
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
                let bonds = &self.bonds;
                __wzvi_hamiltonian(|q: &[f64], p: &[f64]| {
                    p.iter().map(|p| 0.5 * p * p).sum::<f64>()
                        + bonds
                            .iter()
                            .map(|&(a, b, k)| 0.5 * k * (q[a] - q[b]).powi(2))
                            .sum::<f64>()
                });
            }
        }
    }
};
