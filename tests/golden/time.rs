// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |q, p, t| 0.5 * p * p - f * (omega * t).cos() * q + 0.25 * q.powi(4), embedding = DeltaPlus)]
// pub struct Driven { pub f: f64, pub omega: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
DeltaPlus

Hamiltonians
  H0 = p²/2 - q f cos(t omega) + q^4/4

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P Δq - h (P²/2 - f q_i cos(omega t_i) + q_i^4/4)
  Δq = q_{i+1} - q_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = P h
  p_i = -D1 L_d:  P = p_i + δp,  δp = -h (q_i³ - f cos(omega t_i))
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp

Step
  assign δp
  assign Δq

Facts
  H0 is not a first integral

```
*/
pub struct Driven {
    pub f: f64,
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
    impl __wzvi::Hamiltonian for Driven {
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
                0usize => __wzvi::core::option::Option::Some(("f", self.f)),
                1usize => __wzvi::core::option::Option::Some(("omega", self.omega)),
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
                    let __a0: __wzvi::core::primitive::f64 = self.f;
                    let __a1: __wzvi::core::primitive::f64 = self.omega;
                    __q0 * (__q0 * (__q0 * __q0) * 0.25f64 - (__a1 * __t).cos() * __a0)
                        + __p0 * __p0 * 0.5f64
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
                        let __a0: __wzvi::core::primitive::f64 = self.f;
                        let __a1: __wzvi::core::primitive::f64 = self.omega;
                        {
                            *__dq = [__q0 * (__q0 * __q0) - (__a1 * __t).cos() * __a0];
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
        type __Prepared = ([__wzvi::core::primitive::f64; 2usize],);
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
            []: [__S; 0usize],
            __memory: &mut __Memory<__S>,
            __carry: &__C,
        ) -> __wzvi::core::result::Result<
            __wzvi::Solution<__S, 1usize>,
            __wzvi::StepFailure,
        > {
            let [__c0, __c1] = __prepared.0;
            let __x0 = (__q0 * (__q0 * __q0) - (__t * __c1).cos() * __c0) * __h;
            let __momentum0 = __p0 - __x0;
            let __next = __wzvi::Solution::new(
                __carry,
                [[__q0], [__p0]],
                [[__momentum0 * __h], [-__x0]],
                [__momentum0],
                __wzvi::Effort::fast(0),
            );
            if !__next.is_finite() {
                return __wzvi::core::result::Result::Err(__wzvi::StepFailure::NonFinite);
            }
            __wzvi::core::result::Result::Ok(__next)
        }
        #[automatically_derived]
        impl __wzvi::Discretized<__wzvi::embedding::DeltaPlus> for Driven {
            const PLAN: __wzvi::Plan = __wzvi::Plan {
                solver: __wzvi::Solver::Explicit,
                unknowns: 0usize,
                order: 1u32,
                noise: __wzvi::NoiseClass::None,
                consistent: true,
                conserves_energy: __wzvi::Knowledge::Refuted,
                commuting: __wzvi::Knowledge::Proven,
            };
            const EQUATIONS: &'static __wzvi::core::primitive::str = "DeltaPlus\n\nHamiltonians\n  H0 = p²/2 - q f cos(t omega) + q^4/4\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P Δq - h (P²/2 - f q_i cos(omega t_i) + q_i^4/4)\n  Δq = q_{i+1} - q_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = P h\n  p_i = -D1 L_d:  P = p_i + δp,  δp = -h (q_i³ - f cos(omega t_i))\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = δp\n\nStep\n  assign δp\n  assign Δq\n\nFacts\n  H0 is not a first integral\n";
            type Prepared = __Prepared;
            type Memory<__S: __wzvi::Scalar> = __Memory<__S>;
            type Compensated<__S: __wzvi::Scalar> = __wzvi::Compensation<__S, 1usize>;
            type Carry<__S: __wzvi::Scalar> = __wzvi::Plain;
            fn prepare(
                &self,
                __h: __wzvi::core::primitive::f64,
            ) -> __wzvi::core::result::Result<Self::Prepared, __wzvi::ConfigError> {
                let __a0: __wzvi::core::primitive::f64 = self.f;
                let __a1: __wzvi::core::primitive::f64 = self.omega;
                if __a0.is_nan() || __a1.is_nan() {
                    return __wzvi::core::result::Result::Err(
                        __wzvi::ConfigError::Parameter,
                    );
                }
                __wzvi::core::result::Result::Ok(([__a0, __a1],))
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
                let __a0: __wzvi::core::primitive::f64 = self.f;
                let __a1: __wzvi::core::primitive::f64 = self.omega;
                let __x0 = __p0 * (__e0 - __b0)
                    - (__b0
                        * (__b0 * (__b0 * __b0) * 0.25f64 - (__a1 * __t).cos() * __a0)
                        + __p0 * __p0 * 0.5f64) * __h;
                __x0
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
                let __a0: __wzvi::core::primitive::f64 = self.f;
                let __a1: __wzvi::core::primitive::f64 = self.omega;
                __wzvi::LagrangianGradient {
                    q0: __wzvi::core::convert::From::from([
                        -(__p0
                            + (__b0 * (__b0 * __b0) - (__a1 * __t).cos() * __a0) * __h),
                    ]),
                    q1: __wzvi::core::convert::From::from([__p0]),
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
                    __before.p[0usize] + (__after.p[0usize] - __before.p[0usize]) * 1f64,
                ])
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
    impl __WzviTypeChecks for Driven {
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
                ::core::marker::PhantomData::<::wzvi::embedding::DeltaPlus>,
                ::core::marker::PhantomData::<DeltaPlus>,
            );
            {
                let f = self.f;
                let omega = self.omega;
                __wzvi_hamiltonian_of_time(|q, p, t| {
                    0.5 * p * p - f * (omega * t).cos() * q + 0.25 * q.powi(4)
                });
            }
        }
    }
};
