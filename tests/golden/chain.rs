// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q: &[f64], p: &[f64]| { let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4); p.iter().map(|p| 0.5 * p * p).sum::<f64>() + (0..q.len() - 1).map(|i| v(q[i + 1] - q[i])).sum::<f64>() + v(q[0]) }, embedding = Midpoint)]
// pub struct Chain { pub beta: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians, as sums of elements
  H0 = Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..n - 2) [beta (q[i + 1] - q[i])^4/4 + (q[i + 1] - q[i])²/2] + [beta q[0]^4/4 + q[0]²/2]

Discrete Lagrangian of the step from t to t + h, from q, p to q', p'
  L_d = Σ_i P[i] Δq[i] - h H0(P, q_{1/2})
  Δq = q' - q
  q_{1/2} = q + 1/2 Δq

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq[i] is the sum of
    P[i] h   for i = 0..n - 1
  p = -D1 L_d:  P[i] = p[i] + v[i], v[i] is the sum of
    -h (q_{1/2}[i] - q_{1/2}[i + 1] - beta (q_{1/2}[i + 1] - q_{1/2}[i])³)/2   for i = 0..n - 2
    -h (q_{1/2}[i] - q_{1/2}[i - 1] + beta (q_{1/2}[i] - q_{1/2}[i - 1])³)/2   for i = 1..n - 1
    -h (q_{1/2}[0] + beta q_{1/2}[0]³)/2   at point 0
  p' = D2 L_d:  p'[i] = P[i] + the sum of
    -h (q_{1/2}[i] - q_{1/2}[i + 1] - beta (q_{1/2}[i + 1] - q_{1/2}[i])³)/2   for i = 0..n - 2
    -h (q_{1/2}[i] - q_{1/2}[i - 1] + beta (q_{1/2}[i] - q_{1/2}[i - 1])³)/2   for i = 1..n - 1
    -h (q_{1/2}[0] + beta q_{1/2}[0]³)/2   at point 0

Step
  solve for v (then Δq): by x <- φ(x) while that contracts, else Newton's method with the Jacobian in a band, or with GMRES where the band is wide

Facts
  H0 is a first integral: kept by the step nearly, within O(h²)

```
*/
pub struct Chain {
    pub beta: f64,
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
    impl __wzvi::Hamiltonian for Chain {
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
                0usize => __wzvi::core::option::Option::Some(("beta", self.beta)),
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
    impl __wzvi::elements::Elements for Chain {
        const PLACES: __wzvi::elements::places::Places = {
            use __wzvi::elements::places as __places;
            __places::Places {
                components: 1usize,
                tables: &[],
                nests: &[
                    __places::Nest {
                        loops: &[],
                        slots: &[
                            __places::Slot::State {
                                index: __places::Index {
                                    terms: &[],
                                    constant: 0,
                                    name: __places::Name {
                                        name: "0",
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
            let __a0: __wzvi::core::primitive::f64 = self.beta;
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
                        let __x0 = 0.25f64 * __a0;
                        let mut __b0 = <__S as __wzvi::Scalar>::from_f64(0.0);
                        let mut __i1: __wzvi::core::primitive::isize = 0;
                        let __end: __wzvi::core::primitive::isize = (__size - 1);
                        while __i1 < __end {
                            let __low = __i1;
                            let __len = (__end - __low)
                                as __wzvi::core::primitive::usize;
                            let __s0 = ((__i1 + 1) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize);
                            let __s0 = &__at.q[__s0..__s0 + __len];
                            let __s1 = ((__i1) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize);
                            let __s1 = &__at.q[__s1..__s1 + __len];
                            for __k in 0..__len {
                                let __i1 = __low + __k as __wzvi::core::primitive::isize;
                                let __l0 = __s0[__k];
                                let __l1 = __s1[__k];
                                let __x1 = __l0 - __l1;
                                let __x2 = __x1 * __x1;
                                __b0 = __b0 + __x2 * (__x2 * __x0 + 0.5f64);
                            }
                            __i1 += __len as __wzvi::core::primitive::isize;
                        }
                        __total = __total + __b0;
                    }
                    {
                        let __x0 = 0.25f64 * __a0;
                        {
                            let __l0 = __at.q[0];
                            let __x1 = __l0 * __l0;
                            __total = __total + __x1 * (__x1 * __x0 + 0.5f64);
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
            let __a0: __wzvi::core::primitive::f64 = self.beta;
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
                            let __end: __wzvi::core::primitive::isize = (__size - 1);
                            while __i1 < __end {
                                let __low = __i1;
                                let mut __len = (__end - __low)
                                    as __wzvi::core::primitive::usize;
                                if ((__i1 + 1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize)
                                    != ((__i1) as __wzvi::core::primitive::isize
                                        as __wzvi::core::primitive::usize) + 1
                                {
                                    __len = 1;
                                }
                                let __s0 = ((__i1 + 1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s0 = &__at.q[__s0..__s0 + __len];
                                let __s1 = ((__i1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s1 = &__at.q[__s1..__s1 + __len];
                                let __at1 = ((__i1 + 1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize) + (__len - 1);
                                let mut __carried1 = <__S as __wzvi::Scalar>::from_f64(0.0);
                                let __b1 = ((__i1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __b1 = &mut __by_q[__b1..__b1 + __len];
                                for __k in 0..__len {
                                    let __i1 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = __s0[__k];
                                    let __l1 = __s1[__k];
                                    let __x0 = __l0 - __l1;
                                    let __x1 = (__x0 * __x0 * __a0 + 1f64) * (__c * __x0);
                                    let __ahead = __x1;
                                    __b1[__k] = __b1[__k] + (-__x1 + __carried1);
                                    __carried1 = __ahead;
                                }
                                __by_q[__at1] = __by_q[__at1] + __carried1;
                                __i1 += __len as __wzvi::core::primitive::isize;
                            }
                        }
                    }
                    if __wanted.by_q {
                        {
                            let __c = <__S as __wzvi::Scalar>::from_f64(__at.h);
                            {
                                let __l0 = __at.q[0];
                                let __at_index = 0;
                                __by_q[__at_index] = __by_q[__at_index]
                                    + __c * (__l0 * (__l0 * __l0 * __a0 + 1f64));
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
            let __a0: __wzvi::core::primitive::f64 = self.beta;
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
                            let __x0 = 3f64 * __a0;
                            let __c = <__S as __wzvi::Scalar>::from_f64(__at.h);
                            let mut __i1: __wzvi::core::primitive::isize = 0;
                            let __end: __wzvi::core::primitive::isize = (__size - 1);
                            while __i1 < __end {
                                let __low = __i1;
                                let __len = (__end - __low)
                                    as __wzvi::core::primitive::usize;
                                let __s0 = ((__i1 + 1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s0 = &__at.q[__s0..__s0 + __len];
                                let __s1 = ((__i1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize);
                                let __s1 = &__at.q[__s1..__s1 + __len];
                                for __k in 0..__len {
                                    let __i1 = __low + __k as __wzvi::core::primitive::isize;
                                    let __l0 = __s0[__k];
                                    let __l1 = __s1[__k];
                                    let __x1 = __l0 - __l1;
                                    let __x2 = __c * (__x1 * __x1 * __x0 + 1f64);
                                    __into
                                        .add_qq(
                                            ((__i1 + 1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            ((__i1 + 1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            true,
                                            __x2,
                                        );
                                    __into
                                        .add_qq(
                                            ((__i1 + 1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            ((__i1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            false,
                                            -__x2,
                                        );
                                    __into
                                        .add_qq(
                                            ((__i1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            ((__i1) as __wzvi::core::primitive::isize
                                                as __wzvi::core::primitive::usize),
                                            true,
                                            __x2,
                                        );
                                }
                                __i1 += __len as __wzvi::core::primitive::isize;
                            }
                        }
                    }
                    if __wanted.by_q {
                        {
                            let __x0 = 3f64 * __a0;
                            let __c = <__S as __wzvi::Scalar>::from_f64(__at.h);
                            {
                                let __l0 = __at.q[0];
                                __into
                                    .add_qq(0, 0, true, __c * (__l0 * __l0 * __x0 + 1f64));
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
                    point: 0.5f64,
                    start: 0.5f64,
                    end: 0.5f64,
                    parts: &[(0usize, 1f64)],
                },
            ],
            update: __wzvi::elements::MomentumUpdate::Multiple(2f64),
            unknowns: __wzvi::elements::Unknowns::Momenta,
            remembers: true,
            is_linear: false,
        };
        #[automatically_derived]
        impl __wzvi::Discretized<__wzvi::embedding::Midpoint> for Chain {
            const PLAN: __wzvi::Plan = __wzvi::Plan {
                solver: __wzvi::Solver::Newton,
                unknowns: __wzvi::core::primitive::usize::MAX,
                order: 2u32,
                noise: __wzvi::NoiseClass::None,
                consistent: true,
                conserves_energy: __wzvi::Knowledge::Proven,
                commuting: __wzvi::Knowledge::Proven,
            };
            const EQUATIONS: &'static __wzvi::core::primitive::str = "Midpoint\n\nHamiltonians, as sums of elements\n  H0 = Σ_(i=0..n - 1) [p[i]²/2] + Σ_(i=0..n - 2) [beta (q[i + 1] - q[i])^4/4 + (q[i + 1] - q[i])²/2] + [beta q[0]^4/4 + q[0]²/2]\n\nDiscrete Lagrangian of the step from t to t + h, from q, p to q', p'\n  L_d = Σ_i P[i] Δq[i] - h H0(P, q_{1/2})\n  Δq = q' - q\n  q_{1/2} = q + 1/2 Δq\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq[i] is the sum of\n    P[i] h   for i = 0..n - 1\n  p = -D1 L_d:  P[i] = p[i] + v[i], v[i] is the sum of\n    -h (q_{1/2}[i] - q_{1/2}[i + 1] - beta (q_{1/2}[i + 1] - q_{1/2}[i])³)/2   for i = 0..n - 2\n    -h (q_{1/2}[i] - q_{1/2}[i - 1] + beta (q_{1/2}[i] - q_{1/2}[i - 1])³)/2   for i = 1..n - 1\n    -h (q_{1/2}[0] + beta q_{1/2}[0]³)/2   at point 0\n  p' = D2 L_d:  p'[i] = P[i] + the sum of\n    -h (q_{1/2}[i] - q_{1/2}[i + 1] - beta (q_{1/2}[i + 1] - q_{1/2}[i])³)/2   for i = 0..n - 2\n    -h (q_{1/2}[i] - q_{1/2}[i - 1] + beta (q_{1/2}[i] - q_{1/2}[i - 1])³)/2   for i = 1..n - 1\n    -h (q_{1/2}[0] + beta q_{1/2}[0]³)/2   at point 0\n\nStep\n  solve for v (then Δq): by x <- φ(x) while that contracts, else Newton's method with the Jacobian in a band, or with GMRES where the band is wide\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²)\n";
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
                if __wzvi::core::primitive::f64::is_nan(self.beta) {
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
    __wzvi::composition! {
        [impl < __W : __wzvi::compose::Composes < __wzvi::embedding::Midpoint > >
        __wzvi::Discretized < __wzvi::embedding::Composed < __wzvi::embedding::Midpoint,
        __W > > for Chain] __wzvi::embedding::Composed < __wzvi::embedding::Midpoint, __W
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
    impl __WzviTypeChecks for Chain {
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
                let beta = self.beta;
                __wzvi_hamiltonian(|q: &[f64], p: &[f64]| {
                    let v = |d: f64| 0.5 * d * d + 0.25 * beta * d.powi(4);
                    p.iter().map(|p| 0.5 * p * p).sum::<f64>()
                        + (0..q.len() - 1).map(|i| v(q[i + 1] - q[i])).sum::<f64>()
                        + v(q[0])
                });
            }
        }
    }
};
