// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>(), noise = [|q, p, k| sigma * q[k]; self.sites], embedding = Midpoint)]
// pub struct Bath { pub sigma: f64, pub sites: usize }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians, as sums of elements
  H0 = Σ_(i=0..n - 1) [q[i]²/2] + Σ_(i=0..n - 1) [p[i]²/2]
  H_k = Σ_(i=0..sites - 1) [sigma q[i]]

The sites k = 0..n - 1 are not coupled: each is a system of its own

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq[k] - h (q[k]_{i+1/2}²/2 + P²/2) - sigma q[k]_{i+1/2} ΔW
  Δq[k] = q[k]_{i+1} - q[k]_i
  q[k]_{i+1/2} = Δq[k]/2 + q[k]_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq[k] = P h
  p[k]_i = -D1 L_d:  P = p[k]_i + δp[k],  δp[k] = (-q[k]_{i+1/2} h - sigma ΔW)/2
  p[k]_{i+1} = D2 L_d:  p[k]_{i+1} - p[k]_i = 2 δp[k]

Step
  solve for δp[k]: linear (then Δq[k])

Facts
  converges to the Stratonovich system; D = 0
  {H_k, H0} = Σ_(i=0..sites - 1) [-sigma p[i]]
  the noises commute up to a constant
  H0 is not a first integral

```
*/
pub struct Bath {
    pub sigma: f64,
    pub sites: usize,
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
    impl __wzvi::Hamiltonian for Bath {
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
            (((self.sites as __wzvi::core::primitive::isize))
                as __wzvi::core::primitive::isize as __wzvi::core::primitive::usize)
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
                0usize => __wzvi::core::option::Option::Some(("sigma", self.sigma)),
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
    impl __wzvi::elements::Elements for Bath {
        const PLACES: __wzvi::elements::places::Places = {
            use __wzvi::elements::places as __places;
            __places::Places {
                components: 1usize,
                tables: &[
                    __places::Name {
                        name: "sites",
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
                                        name: "sites",
                                        suffix: "",
                                    },
                                },
                            },
                        ],
                        slots: &[
                            __places::Slot::State {
                                index: __places::Index {
                                    terms: &[(__places::Atom::Loop(0usize), 1)],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "i",
                                        suffix: "",
                                    },
                                },
                                is_natural: true,
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
                        (self.sites) as __wzvi::core::primitive::i128,
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
            let __a0: __wzvi::core::primitive::f64 = self.sigma;
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
                            let __s1 = ((__i0) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize);
                            let __s1 = &__at.q[__s1..__s1 + __len];
                            for __k in 0..__len {
                                let __i0 = __low + __k as __wzvi::core::primitive::isize;
                                let __l0 = __s0[__k];
                                let __l1 = __s1[__k];
                                __b0 = __b0 + (__l1 * __l1 + __l0 * __l0) * 0.5f64;
                            }
                            __i0 += __len as __wzvi::core::primitive::isize;
                        }
                        __total = __total + __b0;
                    }
                    __value = __value
                        + __total * <__S as __wzvi::Scalar>::from_f64(__at.h);
                }
                1usize => {
                    let mut __total = <__S as __wzvi::Scalar>::from_f64(0.0);
                    {
                        let mut __b0 = <__S as __wzvi::Scalar>::from_f64(0.0);
                        let mut __i1: __wzvi::core::primitive::isize = __wzvi::core::cmp::Ord::max(
                            0,
                            __at.acting.start as __wzvi::core::primitive::isize,
                        );
                        let __end: __wzvi::core::primitive::isize = __wzvi::core::cmp::Ord::min(
                            ((self.sites as __wzvi::core::primitive::isize)),
                            __at.acting.end as __wzvi::core::primitive::isize,
                        );
                        while __i1 < __end {
                            let __low = __i1;
                            let __len = (__end - __low)
                                as __wzvi::core::primitive::usize;
                            let __s0 = ((__i1) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize);
                            let __s0 = &__at.q[__s0..__s0 + __len];
                            for __k in 0..__len {
                                let __i1 = __low + __k as __wzvi::core::primitive::isize;
                                let __l0 = __s0[__k];
                                let __c = __at
                                    .increment(
                                        ((__i1) as __wzvi::core::primitive::isize
                                            as __wzvi::core::primitive::usize),
                                    );
                                __b0 = __b0 + __l0 * __c * __a0;
                            }
                            __i1 += __len as __wzvi::core::primitive::isize;
                        }
                        __total = __total + __b0;
                    }
                    __value = __value + __total;
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
            let __a0: __wzvi::core::primitive::f64 = self.sigma;
            let __size = (__at.q.len() / 1) as __wzvi::core::primitive::isize;
            let __t = __at.t;
            match __part {
                0usize => {
                    if __wanted.by_q {
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
                                let __s0 = &__at.q[__s0..__s0 + __len];
                                let __b0 = ((__i0) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __b0 = &mut __by_q[__b0..__b0 + __len];
                                for __k in 0..__len {
                                    let __i0 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = __s0[__k];
                                    __b0[__k] = __b0[__k] + __l0 * __c;
                                }
                                __i0 += __len as __wzvi::core::primitive::isize;
                            }
                        }
                    }
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
                }
                1usize => {
                    if __wanted.by_q {
                        {
                            let mut __i1: __wzvi::core::primitive::isize = __wzvi::core::cmp::Ord::max(
                                0,
                                __at.acting.start as __wzvi::core::primitive::isize,
                            );
                            let __end: __wzvi::core::primitive::isize = __wzvi::core::cmp::Ord::min(
                                ((self.sites as __wzvi::core::primitive::isize)),
                                __at.acting.end as __wzvi::core::primitive::isize,
                            );
                            while __i1 < __end {
                                let __low = __i1;
                                let __len = (__end - __low)
                                    as __wzvi::core::primitive::usize;
                                let __s0 = ((__i1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s0 = &__at.q[__s0..__s0 + __len];
                                let __b0 = ((__i1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __b0 = &mut __by_q[__b0..__b0 + __len];
                                for __k in 0..__len {
                                    let __i1 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = __s0[__k];
                                    let __c = __at
                                        .increment(
                                            ((__i1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                        );
                                    __b0[__k] = __b0[__k] + __c * __a0;
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
            let __a0: __wzvi::core::primitive::f64 = self.sigma;
            let __size = (__at.q.len() / 1) as __wzvi::core::primitive::isize;
            let __t = __at.t;
            match __part {
                0usize => {
                    if __wanted.by_q {
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
                                let __s0 = &__at.q[__s0..__s0 + __len];
                                for __k in 0..__len {
                                    let __i0 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = __s0[__k];
                                    __into
                                        .add_qq(
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
                }
                1usize => if __wanted.by_q {}
                _ => {}
            }
        }
    }
    const _: () = {
        const __SCHEME: __wzvi::elements::Scheme = __wzvi::elements::Scheme {
            stages: &[
                __wzvi::elements::Stage {
                    point: 0.5f64,
                    start: 0.5f64,
                    end: 0.5f64,
                    parts: &[(0usize, 1f64), (1usize, 1f64)],
                },
            ],
            update: __wzvi::elements::MomentumUpdate::Multiple(2f64),
            unknowns: __wzvi::elements::Unknowns::Both,
            remembers: false,
            is_linear: false,
        };
        type __Prepared = (
            [__wzvi::core::primitive::f64; 4usize],
            [__wzvi::core::primitive::bool; 1usize],
        );
        type __Memory<__S> = __wzvi::core::marker::PhantomData<__S>;
        #[inline(always)]
        fn __solve<
            __S: __wzvi::Scalar,
            __C: __wzvi::Carry<__S>,
            const __CAREFUL: __wzvi::core::primitive::bool,
        >(
            __prepared: &__Prepared,
            __t: __wzvi::core::primitive::f64,
            __h: __wzvi::core::primitive::f64,
            [__q0,
            ]: [__S; 1usize],
            [__p0,
            ]: [__S; 1usize],
            [__dw0,
            ]: [__S; 1usize],
            __memory: &mut __Memory<__S>,
            __carry: &__C,
        ) -> __wzvi::core::result::Result<
            __wzvi::Solution<__S, 1usize>,
            __wzvi::StepFailure,
        > {
            let [__c0, __c1, __c2, __c3] = __prepared.0;
            let [__b0] = __prepared.1;
            let __x0 = __dw0 * __c0;
            let __x1 = __x0 + (__q0 + __p0 * __c2) * __h;
            let __momentum0 = (if __b0 {
                (__p0 - (__x0 + __q0 * __h) * 0.5f64) * __c1
            } else {
                __p0 - __x1 * __c3
            });
            let __next = __wzvi::Solution::new(
                __carry,
                [[__q0], [__p0]],
                [[__momentum0 * __h], [-(__x1 * __c1)]],
                [__momentum0],
                __wzvi::Effort::fast(0),
            );
            if !__next.is_finite() {
                return __wzvi::core::result::Result::Err(__wzvi::StepFailure::NonFinite);
            }
            __wzvi::core::result::Result::Ok(__next)
        }
        #[automatically_derived]
        impl __wzvi::elements::sites::Sites<__wzvi::embedding::Midpoint, 1usize, 1usize>
        for Bath {
            const IS_UNIFORM: __wzvi::core::primitive::bool = true;
            const IS_EXACT_IN_LANES: __wzvi::core::primitive::bool = true;
            type SitePrepared = __Prepared;
            type SiteMemory<__S: __wzvi::Scalar> = __Memory<__S>;
            fn prepare_site(
                &self,
                __h: __wzvi::core::primitive::f64,
                __site: __wzvi::core::primitive::usize,
                __sites: __wzvi::core::primitive::usize,
            ) -> __wzvi::core::result::Result<__Prepared, __wzvi::ConfigError> {
                let __i2 = __site as __wzvi::core::primitive::isize;
                let __size = ((__sites * 1usize) / 1) as __wzvi::core::primitive::isize;
                let __a0: __wzvi::core::primitive::f64 = self.sigma;
                if __a0.is_nan() {
                    return __wzvi::core::result::Result::Err(
                        __wzvi::ConfigError::Parameter,
                    );
                }
                let __x0 = 1f64 + __h * __h * 0.25f64;
                let __x1 = __wzvi::prepared(__h, __wzvi::reciprocal(__x0))?;
                __wzvi::core::result::Result::Ok((
                    [__a0, __x1, 0.5f64 * __h, 0.5f64 * __x1],
                    [(2f64 < __x0)],
                ))
            }
            #[inline(always)]
            fn increments(
                &self,
                __site: __wzvi::core::primitive::usize,
                __sites: __wzvi::core::primitive::usize,
            ) -> [__wzvi::core::option::Option<__wzvi::core::primitive::usize>; 1usize] {
                let __i2 = __site as __wzvi::core::primitive::isize;
                let __size = ((__sites * 1usize) / 1) as __wzvi::core::primitive::isize;
                [
                    if __i2 >= 0
                        && __i2 < ((self.sites as __wzvi::core::primitive::isize))
                    {
                        __wzvi::core::option::Option::Some(
                            ((__i2) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize),
                        )
                    } else {
                        __wzvi::core::option::Option::None
                    },
                ]
            }
            #[inline(always)]
            fn solve_site<
                __S: __wzvi::Scalar,
                __C: __wzvi::Carry<__S>,
                const __CAREFUL: __wzvi::core::primitive::bool,
            >(
                __prepared: &__Prepared,
                __t: __wzvi::core::primitive::f64,
                __h: __wzvi::core::primitive::f64,
                __q: [__S; 1usize],
                __p: [__S; 1usize],
                __dw: [__S; 1usize],
                __memory: &mut __Memory<__S>,
                __carry: &__C,
            ) -> __wzvi::core::result::Result<
                __wzvi::Solution<__S, 1usize>,
                __wzvi::StepFailure,
            > {
                __solve::<
                    __S,
                    __C,
                    __CAREFUL,
                >(__prepared, __t, __h, __q, __p, __dw, __memory, __carry)
            }
        }
        #[automatically_derived]
        impl __wzvi::Discretized<__wzvi::embedding::Midpoint> for Bath {
            const PLAN: __wzvi::Plan = __wzvi::Plan {
                solver: __wzvi::Solver::Linear,
                unknowns: 1usize,
                order: 2u32,
                noise: __wzvi::NoiseClass::Additive,
                consistent: true,
                conserves_energy: __wzvi::Knowledge::Refuted,
                commuting: __wzvi::Knowledge::Proven,
            };
            const EQUATIONS: &'static __wzvi::core::primitive::str = "Midpoint\n\nHamiltonians, as sums of elements\n  H0 = Σ_(i=0..n - 1) [q[i]²/2] + Σ_(i=0..n - 1) [p[i]²/2]\n  H_k = Σ_(i=0..sites - 1) [sigma q[i]]\n\nThe sites k = 0..n - 1 are not coupled: each is a system of its own\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq[k] - h (q[k]_{i+1/2}²/2 + P²/2) - sigma q[k]_{i+1/2} ΔW\n  Δq[k] = q[k]_{i+1} - q[k]_i\n  q[k]_{i+1/2} = Δq[k]/2 + q[k]_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq[k] = P h\n  p[k]_i = -D1 L_d:  P = p[k]_i + δp[k],  δp[k] = (-q[k]_{i+1/2} h - sigma ΔW)/2\n  p[k]_{i+1} = D2 L_d:  p[k]_{i+1} - p[k]_i = 2 δp[k]\n\nStep\n  solve for δp[k]: linear (then Δq[k])\n\nFacts\n  converges to the Stratonovich system; D = 0\n  {H_k, H0} = Σ_(i=0..sites - 1) [-sigma p[i]]\n  the noises commute up to a constant\n  H0 is not a first integral\n";
            const REMEMBERS: __wzvi::core::primitive::bool = false;
            const IN_LANES: __wzvi::core::primitive::bool = true;
            type Compensated<__S: __wzvi::Scalar> = __wzvi::elements::CompensationVec<
                __S,
            >;
            type Carry<__S: __wzvi::Scalar> = __wzvi::Plain;
            type Prepared = __wzvi::elements::sites::Prepared<__Prepared>;
            type Memory<__S: __wzvi::Scalar> = __wzvi::elements::sites::Memory<
                __S,
                __Memory<__S>,
                __Prepared,
            >;
            fn memory(&self) -> Self::Memory<__wzvi::core::primitive::f64> {
                __wzvi::elements::sites::Memory::new(self, 1usize)
            }
            fn prepare(
                &self,
                __h: __wzvi::core::primitive::f64,
            ) -> __wzvi::core::result::Result<Self::Prepared, __wzvi::ConfigError> {
                __wzvi::elements::sites::prepare::<
                    _,
                    __wzvi::embedding::Midpoint,
                    1usize,
                    1usize,
                >(self, __h)
            }
            #[inline(always)]
            fn advance_carrying<
                __S: __wzvi::Scalar,
                __C: __wzvi::Carry<__S>,
                const __CAREFUL: __wzvi::core::primitive::bool,
            >(
                &self,
                __prepared: &Self::Prepared,
                __t: __wzvi::core::primitive::f64,
                __h: __wzvi::core::primitive::f64,
                __q: &mut [__S],
                __p: &mut [__S],
                __dw: &[__S],
                __memory: &mut Self::Memory<__S>,
                __carry: &mut __C,
            ) -> __wzvi::core::result::Result<__wzvi::Effort, __wzvi::StepFailure> {
                __wzvi::elements::sites::advance::<
                    _,
                    __wzvi::embedding::Midpoint,
                    __S,
                    __C,
                    __CAREFUL,
                    1usize,
                    1usize,
                >(self, __prepared, __t, __h, __q, __p, __dw, __memory, __carry)
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
                __wzvi::elements::sites::step_momentum(&__before.p, &__after.p, [0.5f64])
            }
        }
    };
    __wzvi::composition! {
        [impl < __W : __wzvi::compose::Composes < __wzvi::embedding::Midpoint > >
        __wzvi::Discretized < __wzvi::embedding::Composed < __wzvi::embedding::Midpoint,
        __W > > for Bath] __wzvi::embedding::Composed < __wzvi::embedding::Midpoint, __W
        >, [__wzvi::embedding::Midpoint, __wzvi::embedding::Midpoint], < __W as
        __wzvi::compose::Composes < __wzvi::embedding::Midpoint > > ::ORDER, < Self as
        __wzvi::Discretized < __wzvi::embedding::Midpoint >> ::EQUATIONS, < __W as
        __wzvi::compose::Composes < __wzvi::embedding::Midpoint > > ::substeps()
    }
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
    impl __WzviTypeChecks for Bath {
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
                ::core::marker::PhantomData::<::wzvi::embedding::Midpoint>,
                ::core::marker::PhantomData::<Midpoint>,
            );
            {
                __wzvi_hamiltonian(|q: &[f64], p: &[f64]| {
                    (0..q.len()).map(|i| 0.5 * (p[i] * p[i] + q[i] * q[i])).sum::<f64>()
                });
            }
            {
                let sigma = self.sigma;
                __wzvi_family(|q, p, k| sigma * q[k]);
            }
        }
    }
};
