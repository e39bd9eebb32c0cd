//! The implementation of a composition, which is the same for all.

/// Names are marked: those of constants and of sizes around the implementation may be any.
///
/// What follows the header `impl Discretized<$scheme> for ...` of a scheme with the parts `$first` and `$second`.
#[doc(hidden)]
#[macro_export]
macro_rules! __composition {
    ([$($header:tt)*] $scheme:ty, [$first:ty, $second:ty], $order:expr, $text:expr, $substeps:expr) => {
        #[automatically_derived]
        $($header)* {
            const PLAN: $crate::plan::Plan = $crate::compose::plan(
                <Self as $crate::system::Discretized<$first>>::PLAN,
                <Self as $crate::system::Discretized<$second>>::PLAN,
                $order,
            );
            const EQUATIONS: &'static $crate::core::primitive::str = $text;
            const REMEMBERS: $crate::core::primitive::bool = <Self as $crate::system::Discretized<$first>>::REMEMBERS
                || <Self as $crate::system::Discretized<$second>>::REMEMBERS;
            const IN_LANES: $crate::core::primitive::bool = <Self as $crate::system::Discretized<$first>>::IN_LANES;
            type Prepared = $crate::compose::Prepared<
                <Self as $crate::system::Discretized<$first>>::Prepared,
                <Self as $crate::system::Discretized<$second>>::Prepared,
            >;
            type Memory<__S: $crate::scalar::Scalar> = $crate::compose::Memory<
                __S,
                <Self as $crate::system::Discretized<$first>>::Memory<__S>,
                <Self as $crate::system::Discretized<$second>>::Memory<__S>,
            >;
            type Compensated<__S: $crate::scalar::Scalar> =
                <Self as $crate::system::Discretized<$first>>::Compensated<__S>;
            type Carry<__S: $crate::scalar::Scalar> = <Self as $crate::system::Discretized<$first>>::Carry<__S>;

            fn memory(&self) -> Self::Memory<$crate::core::primitive::f64> {
                $crate::compose::memory::<Self, $first, $second>(self, &$substeps)
            }

            fn prepare(&self, __h: $crate::core::primitive::f64) -> $crate::core::result::Result<Self::Prepared, $crate::error::ConfigError> {
                $crate::compose::prepare::<Self, $first, $second>(self, __h, $substeps)
            }

            #[inline(always)]
            fn advance_carrying<__S: $crate::scalar::Scalar, __C: $crate::carry::Carry<__S>, const __CAREFUL: $crate::core::primitive::bool>(
                &self,
                __prepared: &Self::Prepared,
                __t: $crate::core::primitive::f64,
                __h: $crate::core::primitive::f64,
                __q: &mut [__S],
                __p: &mut [__S],
                __dw: &[__S],
                __memory: &mut Self::Memory<__S>,
                __carry: &mut __C,
            ) -> $crate::core::result::Result<$crate::solve::Effort, $crate::error::StepFailure> {
                $crate::compose::advance::<Self, $first, $second, __S, __C, __CAREFUL>(
                    self, __prepared, __t, __h, __q, __p, __dw, __memory, __carry,
                )
            }

            fn discrete_lagrangian(&self, __segment: &$crate::system::Segment<Self::Vector>, __dw: &[$crate::core::primitive::f64]) -> $crate::core::primitive::f64 {
                $crate::compose::value::<Self, $first, $second>(self, __segment, __dw, &$substeps)
            }

            fn discrete_lagrangian_gradient(
                &self,
                __segment: &$crate::system::Segment<Self::Vector>,
                __dw: &[$crate::core::primitive::f64],
            ) -> $crate::system::LagrangianGradient<Self::Vector> {
                $crate::compose::gradient::<Self, $scheme>(self, __segment, __dw)
            }

            fn step_momentum(
                &self,
                __before: &$crate::state::State<Self::Vector>,
                _: &$crate::state::State<Self::Vector>,
                _: $crate::core::primitive::f64,
                _: &[$crate::core::primitive::f64],
            ) -> Self::Vector {
                $crate::core::clone::Clone::clone(&__before.p)
            }
        }
    };
}
