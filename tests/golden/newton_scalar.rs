// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q, p| 0.5 * p * p - omega * omega * q.cos(), embedding = Midpoint)]
// pub struct Pendulum { pub omega: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Midpoint

Hamiltonians
  H0 = p²/2 - omega² cos(q)

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (P²/2 - omega² cos(q_{i+1/2}))
  Δq = q_{i+1} - q_i
  q_{i+1/2} = Δq/2 + q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = P h
  p_i = -D1 L_d:  P = p_i + δp,  δp = -omega² h sin(q_{i+1/2})/2
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp

Step
  solve for δp: Newton (then Δq)

Facts
  H0 is a first integral: kept by the step nearly, within O(h²)

```
*/
pub struct Pendulum {
    pub omega: f64,
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
    impl __wzvi::Hamiltonian for Pendulum {
        type Vector = __wzvi::SVector<__wzvi::core::primitive::f64, 1usize>;
        fn degrees(&self) -> __wzvi::core::primitive::usize {
            1usize
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
                0usize => __wzvi::core::option::Option::Some(("omega", self.omega)),
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
                (0usize, &[__q0], &[__p0]) => {
                    let __a0: __wzvi::core::primitive::f64 = self.omega;
                    __p0 * __p0 * 0.5f64 - __q0.cos() * (__a0 * __a0)
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
                __wzvi::array_mut::<__S, 1usize>(__dq),
                __wzvi::array_mut::<__S, 1usize>(__dp),
            ) {
                match (__term, __q, __p) {
                    (0usize, &[__q0], &[__p0]) => {
                        let __a0: __wzvi::core::primitive::f64 = self.omega;
                        {
                            *__dq = [__q0.sin() * (__a0 * __a0)];
                            *__dp = [__p0];
                        }
                    }
                    _ => {
                        *__dq = [__S::from_f64(
                            __wzvi::core::primitive::f64::NAN,
                        ); 1usize];
                        *__dp = [__S::from_f64(
                            __wzvi::core::primitive::f64::NAN,
                        ); 1usize];
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
        type __Prepared = ([__wzvi::core::primitive::f64; 3usize],);
        type __Memory<__S> = (__wzvi::Extrapolation<__S, 1usize>,);
        /// The equations of a block, and their Jacobian by rows.
        #[inline(always)]
        fn __equations0<__S: __wzvi::Scalar>(
            (
                [__q0,
                __p0,
                ],
                [],
                [__c0,
                __c1,
                __c2,
                ],
                [],
            ): (
                [__S; 2usize],
                [__S::Mask; 0usize],
                [__wzvi::core::primitive::f64; 3usize],
                [__wzvi::core::primitive::bool; 0usize],
            ),
            [__v0,
            ]: [__S; 1usize],
        ) -> ([__S; 1usize], [[__S; 1usize]; 1usize]) {
            let __stage_q0 = __q0 + (__p0 + __v0) * __c0;
            let (__x0, __x1) = __stage_q0.sin_cos();
            ([__v0 + __x0 * __c1], [[__x1 * __c2 + 1f64]])
        }
        /// The equations of a block at all numbers that round to `__x`.
        #[cold]
        #[inline(never)]
        fn __rounded0(
            (
                [__q0,
                __p0,
                ],
                [],
                [__c0,
                __c1,
                __c2,
                ],
                [],
            ): (
                [__wzvi::core::primitive::f64; 2usize],
                [__wzvi::core::primitive::bool; 0usize],
                [__wzvi::core::primitive::f64; 3usize],
                [__wzvi::core::primitive::bool; 0usize],
            ),
            __x: [__wzvi::core::primitive::f64; 1usize],
        ) -> [__wzvi::Rounded; 1usize] {
            __equations0::<
                __wzvi::Rounded,
            >(
                    (
                        [__wzvi::Rounded::exact(__q0), __wzvi::Rounded::exact(__p0)],
                        [],
                        [__c0, __c1, __c2],
                        [],
                    ),
                    __x.map(__wzvi::Rounded::nearest),
                )
                .0
        }
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
            []: [__S; 0usize],
            __memory: &mut __Memory<__S>,
            __carry: &__C,
        ) -> __wzvi::core::result::Result<
            __wzvi::Solution<__S, 1usize>,
            __wzvi::StepFailure,
        > {
            let [__c0, __c1, __c2] = __prepared.0;
            let ([__v0], __effort0) = __wzvi::newton::<
                __S,
                1usize,
                false,
                true,
                __CAREFUL,
            >(
                __memory.0.guess::<true>(),
                __wzvi::Block {
                    evaluate: move |__x: &[__S; 1usize]| __equations0::<
                        __S,
                    >(([__q0, __p0], [], [__c0, __c1, __c2], []), *__x),
                    rounded: move |
                        __x: &[__S; 1usize],
                        __lane: __wzvi::core::primitive::usize|
                    {
                        __rounded0(
                            (
                                [
                                    __wzvi::Scalar::lane(__q0, __lane),
                                    __wzvi::Scalar::lane(__p0, __lane),
                                ],
                                [],
                                [__c0, __c1, __c2],
                                [],
                            ),
                            __x.map(|__x| __wzvi::Scalar::lane(__x, __lane)),
                        )
                    },
                },
            )?;
            let __momentum0 = __p0 + __v0;
            let __next = __wzvi::Solution::new(
                __carry,
                [[__q0], [__p0]],
                [[__momentum0 * __h], [__v0 * 2f64]],
                [__momentum0],
                __wzvi::Effort::fast(0) + __effort0,
            );
            if !__next.is_finite() {
                return __wzvi::core::result::Result::Err(__wzvi::StepFailure::NonFinite);
            }
            __memory.0.record::<true>([__v0]);
            __wzvi::core::result::Result::Ok(__next)
        }
        #[automatically_derived]
        impl __wzvi::Discretized<__wzvi::embedding::Midpoint> for Pendulum {
            const PLAN: __wzvi::Plan = __wzvi::Plan {
                solver: __wzvi::Solver::Newton,
                unknowns: 1usize,
                order: 2u32,
                noise: __wzvi::NoiseClass::None,
                consistent: true,
                conserves_energy: __wzvi::Knowledge::Proven,
                commuting: __wzvi::Knowledge::Proven,
            };
            const EQUATIONS: &'static __wzvi::core::primitive::str = "Midpoint\n\nHamiltonians\n  H0 = p²/2 - omega² cos(q)\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (P²/2 - omega² cos(q_{i+1/2}))\n  Δq = q_{i+1} - q_i\n  q_{i+1/2} = Δq/2 + q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = P h\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -omega² h sin(q_{i+1/2})/2\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = 2 δp\n\nStep\n  solve for δp: Newton (then Δq)\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²)\n";
            type Prepared = __Prepared;
            type Memory<__S: __wzvi::Scalar> = __Memory<__S>;
            type Compensated<__S: __wzvi::Scalar> = __wzvi::Compensation<__S, 1usize>;
            type Carry<__S: __wzvi::Scalar> = __wzvi::Plain;
            fn prepare(
                &self,
                __h: __wzvi::core::primitive::f64,
            ) -> __wzvi::core::result::Result<Self::Prepared, __wzvi::ConfigError> {
                let __a0: __wzvi::core::primitive::f64 = self.omega;
                if __a0.is_nan() {
                    return __wzvi::core::result::Result::Err(
                        __wzvi::ConfigError::Parameter,
                    );
                }
                let __x0 = __a0 * __a0;
                __wzvi::core::result::Result::Ok((
                    [0.5f64 * __h, __x0 * 0.5f64 * __h, __h * __h * (0.25f64 * __x0)],
                ))
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
                let __q = __wzvi::array_mut::<__S, 1usize>(__q)?;
                let __p = __wzvi::array_mut::<__S, 1usize>(__p)?;
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
                let (&[__b0], &[__e0], &[__p0], &[]) = (
                    __wzvi::Vector::components(&__segment.q0),
                    __wzvi::Vector::components(&__segment.q1),
                    __wzvi::Vector::components(&__segment.p),
                    __dw,
                ) else {
                    return __wzvi::core::primitive::f64::NAN;
                };
                let __a0: __wzvi::core::primitive::f64 = self.omega;
                __p0 * (__e0 - __b0)
                    - (__p0 * __p0 * 0.5f64
                        - ((__b0 + __e0) * 0.5f64).cos() * (__a0 * __a0)) * __h
            }
            fn discrete_lagrangian_gradient(
                &self,
                __segment: &__wzvi::Segment<Self::Vector>,
                __dw: &[__wzvi::core::primitive::f64],
            ) -> __wzvi::LagrangianGradient<Self::Vector> {
                let (__h, __t) = (__segment.h, __segment.t);
                let (&[__b0], &[__e0], &[__p0], &[]) = (
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
                let __a0: __wzvi::core::primitive::f64 = self.omega;
                let __x0 = ((__b0 + __e0) * 0.5f64).sin() * (__a0 * __a0 * 0.5f64 * __h);
                __wzvi::LagrangianGradient {
                    q0: __wzvi::core::convert::From::from([-(__p0 + __x0)]),
                    q1: __wzvi::core::convert::From::from([__p0 - __x0]),
                    p: __wzvi::core::convert::From::from([__e0 - __b0 - __p0 * __h]),
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
                ])
            }
        }
    };
    __wzvi::composition! {
        [impl < __W : __wzvi::compose::Composes < __wzvi::embedding::Midpoint > >
        __wzvi::Discretized < __wzvi::embedding::Composed < __wzvi::embedding::Midpoint,
        __W > > for Pendulum] __wzvi::embedding::Composed < __wzvi::embedding::Midpoint,
        __W >, [__wzvi::embedding::Midpoint, __wzvi::embedding::Midpoint], < __W as
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
    impl __WzviTypeChecks for Pendulum {
        fn __wzvi_type_checks(&self) {
            fn __wzvi_hamiltonian<
                F: ::core::ops::Fn(
                        ::core::primitive::f64,
                        ::core::primitive::f64,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_hamiltonian_of_time<
                F: ::core::ops::Fn(
                        ::core::primitive::f64,
                        ::core::primitive::f64,
                        ::core::primitive::f64,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family<
                F: ::core::ops::Fn(
                        ::core::primitive::f64,
                        ::core::primitive::f64,
                        ::core::primitive::usize,
                    ) -> ::core::primitive::f64,
            >(_: F) {}
            fn __wzvi_family_of_time<
                F: ::core::ops::Fn(
                        ::core::primitive::f64,
                        ::core::primitive::f64,
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
                let omega = self.omega;
                __wzvi_hamiltonian(|q, p| 0.5 * p * p - omega * omega * q.cos());
            }
        }
    }
};
