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
  H_k = Σ_(i=0..self . sites - 1) [sigma q[i]]

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P · Δq - h H0(P, q_{i+1/2}) - Σ_k ΔW_k H_k(P, q_{i+1/2})
  q_{i+l} = q_i + l Δq

Discrete Euler-Lagrange equations
  ∂L_d/∂P = 0:  Δq = Σ_m c_m ∂H_m/∂p
  p_i = -D1 L_d:  P = p_i + v,  v = -Σ_m (1 - l_m) c_m ∂H_m/∂q
  p_{i+1} = D2 L_d:  p_{i+1} - p_i = v - Σ_m l_m c_m ∂H_m/∂q

Step
  solve for v (then Δq): fixed-point iteration while it contracts, else Newton with a banded Jacobian

Facts
  converges to the Stratonovich system; D = 0
  {H_k, H0} = Σ_(i=0..self . sites - 1) [-sigma p[i]]
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
            let __nan = <__S as __wzvi::Scalar>::from_f64(
                __wzvi::core::primitive::f64::NAN,
            );
            if !(__q.len() == __p.len()
                && __wzvi::elements::check(self, __q.len()).is_ok())
            {
                return __nan;
            }
            let __a0: __wzvi::core::primitive::f64 = self.sigma;
            let __size = (__q.len() / 1) as __wzvi::core::primitive::isize;
            let __at = __wzvi::elements::Point {
                q: __q,
                p: __p,
                t: __t,
                h: 1.0,
                dw: &[],
            };
            let mut __total = <__S as __wzvi::Scalar>::from_f64(0.0);
            match __term {
                0 => {
                    let mut __b0 = <__S as __wzvi::Scalar>::from_f64(0.0);
                    let mut __i0: __wzvi::core::primitive::isize = 0;
                    let __end: __wzvi::core::primitive::isize = (__size);
                    while __i0 < __end {
                        let __low = __i0;
                        let __len = (__end - __low) as __wzvi::core::primitive::usize;
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
                __member if __member as __wzvi::core::primitive::isize > 0
                    && __member as __wzvi::core::primitive::isize
                        <= ((self.sites as __wzvi::core::primitive::isize)) => {
                    let __i1 = __member as __wzvi::core::primitive::isize - 1 - 0;
                    {
                        {
                            let __l0 = __at
                                .q[((__i1) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize)];
                            __total = __total + __l0 * __a0;
                        }
                    }
                }
                _ => return __nan,
            }
            __total
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
            let __nan = <__S as __wzvi::Scalar>::from_f64(
                __wzvi::core::primitive::f64::NAN,
            );
            if !(__q.len() == __p.len()
                && __wzvi::elements::check(self, __q.len()).is_ok()
                && __by_q.len() == __q.len() && __by_p.len() == __q.len())
            {
                __by_q.fill(__nan);
                __by_p.fill(__nan);
                return;
            }
            __by_q.fill(<__S as __wzvi::Scalar>::from_f64(0.0));
            __by_p.fill(<__S as __wzvi::Scalar>::from_f64(0.0));
            let __a0: __wzvi::core::primitive::f64 = self.sigma;
            let __size = (__q.len() / 1) as __wzvi::core::primitive::isize;
            let __at = __wzvi::elements::Point {
                q: __q,
                p: __p,
                t: __t,
                h: 1.0,
                dw: &[],
            };
            match __term {
                0 => {
                    {
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
                                __b0[__k] = __b0[__k] + __l0;
                            }
                            __i0 += __len as __wzvi::core::primitive::isize;
                        }
                    }
                    {
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
                                __b0[__k] = __b0[__k] + __l0;
                            }
                            __i0 += __len as __wzvi::core::primitive::isize;
                        }
                    }
                }
                __member if __member as __wzvi::core::primitive::isize > 0
                    && __member as __wzvi::core::primitive::isize
                        <= ((self.sites as __wzvi::core::primitive::isize)) => {
                    let __i1 = __member as __wzvi::core::primitive::isize - 1 - 0;
                    {
                        {
                            let __l0 = __at
                                .q[((__i1) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize)];
                            let __at_index = ((__i1) as __wzvi::core::primitive::isize
                                as __wzvi::core::primitive::usize);
                            __by_q[__at_index] = __by_q[__at_index]
                                + <__S as __wzvi::Scalar>::from_f64(__a0);
                        }
                    }
                }
                _ => {
                    __by_q.fill(__nan);
                    __by_p.fill(__nan);
                }
            }
        }
        fn invariant(
            &self,
            _: __wzvi::core::primitive::usize,
            _: &__wzvi::State<Self::Vector>,
        ) -> __wzvi::core::primitive::f64 {
            __wzvi::core::primitive::f64::NAN
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
        fn required(
            &self,
            __degrees: __wzvi::core::primitive::usize,
        ) -> __wzvi::core::option::Option<__wzvi::core::primitive::usize> {
            let __size = (__degrees / 1) as __wzvi::core::primitive::isize;
            let mut __required = 1usize;
            if __degrees % 1usize != 0 {
                return __wzvi::core::option::Option::Some(
                    (__size as __wzvi::core::primitive::usize + 1) * 1usize,
                );
            }
            for __i1 in (0
                as __wzvi::core::primitive::isize)..((self.sites
                as __wzvi::core::primitive::isize))
            {
                __required = __wzvi::core::cmp::Ord::max(
                    __required,
                    __wzvi::core::convert::TryInto::<
                        __wzvi::core::primitive::usize,
                    >::try_into((__i1) as __wzvi::core::primitive::isize)
                        .ok()?
                        .checked_add(1)?,
                );
            }
            __wzvi::core::option::Option::Some(__required)
        }
        fn slopes<__S: __wzvi::Scalar>(
            &self,
            __terms: __wzvi::elements::Terms,
            __at: &__wzvi::elements::Point<'_, __S>,
            __by_q: &mut [__S],
            __by_p: &mut [__S],
        ) {
            let __a0: __wzvi::core::primitive::f64 = self.sigma;
            let __size = (__at.q.len() / 1) as __wzvi::core::primitive::isize;
            let __t = __at.t;
            if __terms.drift {
                if __terms.by_q {
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
                if __terms.by_p {
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
            if __terms.noise {
                if __terms.by_q {
                    {
                        let mut __i1: __wzvi::core::primitive::isize = 0;
                        let __end: __wzvi::core::primitive::isize = ((self.sites
                            as __wzvi::core::primitive::isize));
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
                                    .dw[((__i1) as __wzvi::core::primitive::isize
                                    as __wzvi::core::primitive::usize)];
                                __b0[__k] = __b0[__k] + __c * __a0;
                            }
                            __i1 += __len as __wzvi::core::primitive::isize;
                        }
                    }
                }
            }
        }
        fn curvature<__S: __wzvi::Scalar, __C: __wzvi::elements::Curvature<__S>>(
            &self,
            __terms: __wzvi::elements::Terms,
            __at: &__wzvi::elements::Point<'_, __S>,
            __into: &mut __C,
        ) {
            let __a0: __wzvi::core::primitive::f64 = self.sigma;
            let __size = (__at.q.len() / 1) as __wzvi::core::primitive::isize;
            let __t = __at.t;
            if __terms.drift {
                if __terms.by_q {
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
                if __terms.by_p {
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
            if __terms.noise {
                if __terms.by_q {}
            }
        }
    }
    const _: () = {
        const __SCHEME: __wzvi::elements::Scheme = __wzvi::elements::Scheme {
            drift_l: 0.5f64,
            noise_l: 0.5f64,
            counter: 0f64,
            unknowns: __wzvi::elements::Unknowns::Momenta,
            remembers: false,
            has_noise: true,
        };
        #[automatically_derived]
        impl __wzvi::Discretized<__wzvi::embedding::Midpoint> for Bath {
            const PLAN: __wzvi::Plan = __wzvi::Plan {
                solver: __wzvi::Solver::Newton,
                unknowns: __wzvi::core::primitive::usize::MAX,
                noise: __wzvi::NoiseClass::Additive,
                consistent: true,
                conserves_energy: __wzvi::Knowledge::Refuted,
                commuting: __wzvi::Knowledge::Proven,
            };
            const EQUATIONS: &'static __wzvi::core::primitive::str = "Midpoint\n\nHamiltonians, as sums of elements\n  H0 = Σ_(i=0..n - 1) [q[i]²/2] + Σ_(i=0..n - 1) [p[i]²/2]\n  H_k = Σ_(i=0..self . sites - 1) [sigma q[i]]\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P · Δq - h H0(P, q_{i+1/2}) - Σ_k ΔW_k H_k(P, q_{i+1/2})\n  q_{i+l} = q_i + l Δq\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P = 0:  Δq = Σ_m c_m ∂H_m/∂p\n  p_i = -D1 L_d:  P = p_i + v,  v = -Σ_m (1 - l_m) c_m ∂H_m/∂q\n  p_{i+1} = D2 L_d:  p_{i+1} - p_i = v - Σ_m l_m c_m ∂H_m/∂q\n\nStep\n  solve for v (then Δq): fixed-point iteration while it contracts, else Newton with a banded Jacobian\n\nFacts\n  converges to the Stratonovich system; D = 0\n  {H_k, H0} = Σ_(i=0..self . sites - 1) [-sigma p[i]]\n  the noises commute up to a constant\n  H0 is not a first integral\n";
            const REMEMBERS: __wzvi::core::primitive::bool = false;
            const IN_LANES: __wzvi::core::primitive::bool = false;
            type Prepared = ();
            type Memory<__S: __wzvi::Scalar> = __wzvi::elements::Memory<__S>;
            type Compensated<__S: __wzvi::Scalar> = __wzvi::elements::CompensationVec<
                __S,
            >;
            type Carry<__S: __wzvi::Scalar> = __wzvi::Plain;
            fn memory(&self) -> __wzvi::elements::Memory<__wzvi::core::primitive::f64> {
                __wzvi::elements::Memory::new(self, &__SCHEME)
            }
            fn forget(
                __memory: &mut __wzvi::elements::Memory<__wzvi::core::primitive::f64>,
            ) {
                __memory.forget();
            }
            fn pin(
                __memory: &mut __wzvi::elements::Memory<__wzvi::core::primitive::f64>,
                __iteration: __wzvi::elements::Iteration,
            ) {
                __memory.pin(__iteration);
            }
            fn pinned(
                __memory: &__wzvi::elements::Memory<__wzvi::core::primitive::f64>,
            ) -> __wzvi::elements::Iteration {
                __memory.pinned()
            }
            fn adopt(
                __memory: &mut __wzvi::elements::Memory<__wzvi::core::primitive::f64>,
                __left: __wzvi::elements::Memory<__wzvi::core::primitive::f64>,
            ) {
                __memory.adopt(__left);
            }
            fn method(
                __memory: &__wzvi::elements::Memory<__wzvi::core::primitive::f64>,
            ) -> __wzvi::core::option::Option<__wzvi::elements::Method> {
                __wzvi::core::option::Option::Some(__memory.method())
            }
            fn prepare(
                &self,
                __h: __wzvi::core::primitive::f64,
            ) -> __wzvi::core::result::Result<(), __wzvi::ConfigError> {
                if __wzvi::core::primitive::f64::is_nan(self.sigma) {
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
                _: &__wzvi::State<Self::Vector>,
                __h: __wzvi::core::primitive::f64,
                __dw: &[__wzvi::core::primitive::f64],
            ) -> Self::Vector {
                __wzvi::elements::step_momentum(self, &__SCHEME, __before, __h, __dw)
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
