// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + 0.5 * k * (x * x + y * y) + c * x * y, embedding = Midpoint)]
// pub struct Oscillators { pub k: f64, pub c: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = (py² + px²)/2 + k (y² + x²)/2 + x y c

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P_{px} Δx - h ((P_{py}² + P_{px}²)/2 + k (y_{i+1/2}² + x_{i+1/2}²)/2 + c x_{i+1/2} y_{i+1/2}) + P_{py} Δy
  Δx = x_{i+1} - x_i
  Δy = y_{i+1} - y_i
  x_{i+1/2} = Δx/2 + x_i
  y_{i+1/2} = Δy/2 + y_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P_{px} = 0:  Δx = P_{px} h
  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (k x_{i+1/2} + c y_{i+1/2})/2
  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx
  ∂L_d/∂P_{py} = 0:  Δy = P_{py} h
  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (k y_{i+1/2} + c x_{i+1/2})/2
  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy

Step
  solve for δpx, δpy: linear (then Δx, Δy)

Facts
  H0 is a first integral: kept by the step to rounding

```
*/
pub struct Oscillators {
    pub k: f64,
    pub c: f64,
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
    impl __wzvi::Hamiltonian for Oscillators {
        type Vector = __wzvi::SVector<__wzvi::core::primitive::f64, 2usize>;
        fn degrees(&self) -> __wzvi::core::primitive::usize {
            2usize
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
                0usize => __wzvi::core::option::Option::Some(("k", self.k)),
                1usize => __wzvi::core::option::Option::Some(("c", self.c)),
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
            match (__term, __q, __p) {
                (0usize, &[__q0, __q1], &[__p0, __p1]) => {
                    let __a0: __wzvi::core::primitive::f64 = self.k;
                    let __a1: __wzvi::core::primitive::f64 = self.c;
                    let __x0 = __q0 * __q1 * __a1
                        + ((__p1 * __p1 + __p0 * __p0) * 0.5f64
                            + (__q1 * __q1 + __q0 * __q0) * (0.5f64 * __a0));
                    __x0
                }
                _ => __S::from_f64(__wzvi::core::primitive::f64::NAN),
            }
        }
        fn differentiate<__S: __wzvi::Scalar>(
            &self,
            __term: __wzvi::core::primitive::usize,
            __q: &[__S],
            __p: &[__S],
            __t: __wzvi::core::primitive::f64,
            __dq: &mut [__S],
            __dp: &mut [__S],
        ) {
            if let (
                __wzvi::core::result::Result::Ok(__dq),
                __wzvi::core::result::Result::Ok(__dp),
            ) = (
                __wzvi::array_mut::<__S, 2usize>(__dq),
                __wzvi::array_mut::<__S, 2usize>(__dp),
            ) {
                match (__term, __q, __p) {
                    (0usize, &[__q0, __q1], &[__p0, __p1]) => {
                        let __a0: __wzvi::core::primitive::f64 = self.k;
                        let __a1: __wzvi::core::primitive::f64 = self.c;
                        {
                            *__dq = [
                                __q0 * __a0 + __q1 * __a1,
                                __q1 * __a0 + __q0 * __a1,
                            ];
                            *__dp = [__p0, __p1];
                        }
                    }
                    _ => {
                        *__dq = [__S::from_f64(
                            __wzvi::core::primitive::f64::NAN,
                        ); 2usize];
                        *__dp = [__S::from_f64(
                            __wzvi::core::primitive::f64::NAN,
                        ); 2usize];
                    }
                }
            } else {
                __dq.fill(__S::from_f64(__wzvi::core::primitive::f64::NAN));
                __dp.fill(__S::from_f64(__wzvi::core::primitive::f64::NAN));
            }
        }
        fn invariant(
            &self,
            __term: __wzvi::core::primitive::usize,
            __state: &__wzvi::State<Self::Vector>,
        ) -> __wzvi::core::primitive::f64 {
            let (__q, __p, __t) = (
                __wzvi::Vector::components(&__state.q),
                __wzvi::Vector::components(&__state.p),
                __state.t,
            );
            match (__term, __q, __p) {
                _ => __wzvi::core::primitive::f64::NAN,
            }
        }
        fn energy_rate(
            &self,
            __term: __wzvi::core::primitive::usize,
            __state: &__wzvi::State<Self::Vector>,
        ) -> __wzvi::core::primitive::f64 {
            let (__q, __p, __t) = (
                __wzvi::Vector::components(&__state.q),
                __wzvi::Vector::components(&__state.p),
                __state.t,
            );
            match (__term, __q, __p) {
                _ => __wzvi::core::primitive::f64::NAN,
            }
        }
    }
    const _: () = {
        type __Prepared = (
            [__wzvi::core::primitive::f64; 3usize],
            __wzvi::Factor<__wzvi::core::primitive::f64, 2usize>,
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
            __q1,
            ]: [__S; 2usize],
            [__p0,
            __p1,
            ]: [__S; 2usize],
            []: [__S; 0usize],
            __memory: &mut __Memory<__S>,
            __carry: &__C,
        ) -> __wzvi::core::result::Result<
            __wzvi::Solution<__S, 2usize>,
            __wzvi::StepFailure,
        > {
            let [__c0, __c1, __c2] = __prepared.0;
            let __x0 = __q1 + __p1 * __c2;
            let __x1 = __q0 + __p0 * __c2;
            let [__v0, __v1] = __prepared
                .1
                .apply::<
                    __S,
                >([
                    -((__x1 * __c0 + __x0 * __c1) * __c2),
                    -((__x0 * __c0 + __x1 * __c1) * __c2),
                ]);
            let __momentum0 = __p0 + __v0;
            let __momentum1 = __p1 + __v1;
            let __next = __wzvi::Solution::new(
                __carry,
                [[__q0, __q1], [__p0, __p1]],
                [[__momentum0 * __h, __momentum1 * __h], [__v0 * 2f64, __v1 * 2f64]],
                [__momentum0, __momentum1],
                __wzvi::Effort::fast(0),
            );
            if !__next.is_finite() {
                return __wzvi::core::result::Result::Err(__wzvi::StepFailure::NonFinite);
            }
            __wzvi::core::result::Result::Ok(__next)
        }
        #[automatically_derived]
        impl __wzvi::Discretized<__wzvi::embedding::Midpoint> for Oscillators {
            const PLAN: __wzvi::Plan = __wzvi::Plan {
                solver: __wzvi::Solver::Linear,
                unknowns: 2usize,
                order: 2u32,
                noise: __wzvi::NoiseClass::None,
                consistent: true,
                conserves_energy: __wzvi::Knowledge::Proven,
                commuting: __wzvi::Knowledge::Proven,
            };
            const EQUATIONS: &'static __wzvi::core::primitive::str = "Midpoint\n\nHamiltonians\n  H0 = (py² + px²)/2 + k (y² + x²)/2 + x y c\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P_{px} Δx - h ((P_{py}² + P_{px}²)/2 + k (y_{i+1/2}² + x_{i+1/2}²)/2 + c x_{i+1/2} y_{i+1/2}) + P_{py} Δy\n  Δx = x_{i+1} - x_i\n  Δy = y_{i+1} - y_i\n  x_{i+1/2} = Δx/2 + x_i\n  y_{i+1/2} = Δy/2 + y_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P_{px} = 0:  Δx = P_{px} h\n  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h (k x_{i+1/2} + c y_{i+1/2})/2\n  px_{i+1} = D2 L_d:  px_{i+1} - px_i = 2 δpx\n  ∂L_d/∂P_{py} = 0:  Δy = P_{py} h\n  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h (k y_{i+1/2} + c x_{i+1/2})/2\n  py_{i+1} = D2 L_d:  py_{i+1} - py_i = 2 δpy\n\nStep\n  solve for δpx, δpy: linear (then Δx, Δy)\n\nFacts\n  H0 is a first integral: kept by the step to rounding\n";
            type Prepared = __Prepared;
            type Memory<__S: __wzvi::Scalar> = __Memory<__S>;
            type Compensated<__S: __wzvi::Scalar> = __wzvi::Compensation<__S, 2usize>;
            type Carry<__S: __wzvi::Scalar> = __wzvi::Plain;
            fn prepare(
                &self,
                __h: __wzvi::core::primitive::f64,
            ) -> __wzvi::core::result::Result<Self::Prepared, __wzvi::ConfigError> {
                let __a0: __wzvi::core::primitive::f64 = self.k;
                let __a1: __wzvi::core::primitive::f64 = self.c;
                if __a0.is_nan() || __a1.is_nan() {
                    return __wzvi::core::result::Result::Err(
                        __wzvi::ConfigError::Parameter,
                    );
                }
                let __x0 = __h * __h;
                let __x1 = 1f64 + __x0 * (0.25f64 * __a0);
                let __x2 = 0.25f64 * __a1 * __x0;
                let __factor0 = __wzvi::prepared(
                    __h,
                    __wzvi::Factor::new([[__x1, __x2], [__x2, __x1]]),
                )?;
                __wzvi::core::result::Result::Ok(([__a0, __a1, 0.5f64 * __h], __factor0))
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
                let __q = __wzvi::array_mut::<__S, 2usize>(__q)?;
                let __p = __wzvi::array_mut::<__S, 2usize>(__p)?;
                let __dw = __wzvi::increments::<__S, 0usize>(__dw)?;
                let __next = __solve::<
                    __S,
                    __C,
                    __CAREFUL,
                >(__prepared, __t, __h, *__q, *__p, __dw, __memory, __carry)?;
                __wzvi::core::result::Result::Ok(__next.store(__q, __p, __carry))
            }
            fn discrete_lagrangian(
                &self,
                __segment: &__wzvi::Segment<Self::Vector>,
                __dw: &[__wzvi::core::primitive::f64],
            ) -> __wzvi::core::primitive::f64 {
                let (__h, __t) = (__segment.h, __segment.t);
                let (&[__b0, __b1], &[__e0, __e1], &[__p0, __p1], &[]) = (
                    __wzvi::Vector::components(&__segment.q0),
                    __wzvi::Vector::components(&__segment.q1),
                    __wzvi::Vector::components(&__segment.p),
                    __dw,
                ) else {
                    return __wzvi::core::primitive::f64::NAN;
                };
                let __a0: __wzvi::core::primitive::f64 = self.k;
                let __a1: __wzvi::core::primitive::f64 = self.c;
                let __x0 = (__b1 + __e1) * 0.5f64;
                let __x1 = (__b0 + __e0) * 0.5f64;
                let __x2 = __x0 * __x1 * __a1
                    + ((__p1 * __p1 + __p0 * __p0) * 0.5f64
                        + (__x0 * __x0 + __x1 * __x1) * (0.5f64 * __a0));
                __p1 * (__e1 - __b1) + (__p0 * (__e0 - __b0) - __x2 * __h)
            }
            fn discrete_lagrangian_gradient(
                &self,
                __segment: &__wzvi::Segment<Self::Vector>,
                __dw: &[__wzvi::core::primitive::f64],
            ) -> __wzvi::LagrangianGradient<Self::Vector> {
                let (__h, __t) = (__segment.h, __segment.t);
                let (&[__b0, __b1], &[__e0, __e1], &[__p0, __p1], &[]) = (
                    __wzvi::Vector::components(&__segment.q0),
                    __wzvi::Vector::components(&__segment.q1),
                    __wzvi::Vector::components(&__segment.p),
                    __dw,
                ) else {
                    let __nan = __wzvi::SVector::repeat(
                        __wzvi::core::primitive::f64::NAN,
                    );
                    return __wzvi::LagrangianGradient {
                        q0: __nan,
                        q1: __nan,
                        p: __nan,
                    };
                };
                let __a0: __wzvi::core::primitive::f64 = self.k;
                let __a1: __wzvi::core::primitive::f64 = self.c;
                let __x0 = (__b1 + __e1) * 0.5f64;
                let __x1 = (__b0 + __e0) * 0.5f64;
                let __x2 = 0.5f64 * __h;
                let __x3 = (__x1 * __a0 + __x0 * __a1) * __x2;
                let __x4 = (__x0 * __a0 + __x1 * __a1) * __x2;
                __wzvi::LagrangianGradient {
                    q0: __wzvi::core::convert::From::from([
                        -(__p0 + __x3),
                        -(__p1 + __x4),
                    ]),
                    q1: __wzvi::core::convert::From::from([__p0 - __x3, __p1 - __x4]),
                    p: __wzvi::core::convert::From::from([
                        __e0 - __b0 - __p0 * __h,
                        __e1 - __b1 - __p1 * __h,
                    ]),
                }
            }
            fn step_momentum(
                &self,
                __before: &__wzvi::State<Self::Vector>,
                __after: &__wzvi::State<Self::Vector>,
                __h: __wzvi::core::primitive::f64,
                __dw: &[__wzvi::core::primitive::f64],
            ) -> Self::Vector {
                __wzvi::core::convert::From::from([
                    __before.p[0usize]
                        + (__after.p[0usize] - __before.p[0usize]) * 0.5f64,
                    __before.p[1usize]
                        + (__after.p[1usize] - __before.p[1usize]) * 0.5f64,
                ])
            }
        }
    };
    __wzvi::composition! {
        [impl < __W : __wzvi::compose::Composes < __wzvi::embedding::Midpoint > >
        __wzvi::Discretized < __wzvi::embedding::Composed < __wzvi::embedding::Midpoint,
        __W > > for Oscillators] __wzvi::embedding::Composed <
        __wzvi::embedding::Midpoint, __W >, [__wzvi::embedding::Midpoint,
        __wzvi::embedding::Midpoint], < __W as __wzvi::compose::Composes <
        __wzvi::embedding::Midpoint > > ::ORDER, < Self as __wzvi::Discretized <
        __wzvi::embedding::Midpoint >> ::EQUATIONS, < __W as __wzvi::compose::Composes <
        __wzvi::embedding::Midpoint > > ::substeps()
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
    impl __WzviTypeChecks for Oscillators {
        fn __wzvi_type_checks(&self) {
            fn __wzvi_hamiltonian<
                F: ::core::ops::Fn(
                        [::core::primitive::f64; 2usize],
                        [::core::primitive::f64; 2usize],
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_hamiltonian_of_time<
                F: ::core::ops::Fn(
                        [::core::primitive::f64; 2usize],
                        [::core::primitive::f64; 2usize],
                        ::core::primitive::f64,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family<
                F: ::core::ops::Fn(
                        [::core::primitive::f64; 2usize],
                        [::core::primitive::f64; 2usize],
                        ::core::primitive::usize,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family_of_time<
                F: ::core::ops::Fn(
                        [::core::primitive::f64; 2usize],
                        [::core::primitive::f64; 2usize],
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
                let k = self.k;
                let c = self.c;
                __wzvi_hamiltonian(|[x, y], [px, py]| {
                    0.5 * (px * px + py * py) + 0.5 * k * (x * x + y * y) + c * x * y
                });
            }
        }
    }
};
