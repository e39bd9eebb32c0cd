//! The implementation of a composition, which is the same for all.

/// Names are marked: those of constants and of sizes around the implementation may be any.
///
/// What follows the header `impl Discretized<$scheme> for ...` of a scheme whose steps are a `$sequence`.
#[doc(hidden)]
#[macro_export]
macro_rules! __composition {
    ([$($header:tt)*] $scheme:ty, $sequence:ty, $order:expr, $text:expr, $substeps:expr) => {
        #[automatically_derived]
        $($header)* {
            const PLAN: $crate::plan::Plan = $crate::compose::plan(
                <$sequence as $crate::compose::Sequence<Self>>::PLAN,
                $order,
                <$sequence as $crate::compose::Sequence<Self>>::IS_SYMMETRIC,
            );
            const EQUATIONS: &'static $crate::core::primitive::str = $text;
            const REMEMBERS: $crate::core::primitive::bool =
                <$sequence as $crate::compose::Sequence<Self>>::REMEMBERS;
            const IN_LANES: $crate::core::primitive::bool =
                <$sequence as $crate::compose::Sequence<Self>>::IN_LANES;
            const FILLS_REGISTERS_FROM: $crate::core::primitive::usize =
                <$sequence as $crate::compose::Sequence<Self>>::FILLS_REGISTERS_FROM;
            const KEPT_ENERGY: $crate::plan::KeptEnergy = $crate::compose::kept_energy(
                <$sequence as $crate::compose::Sequence<Self>>::KEPT_ENERGY,
                $order,
            );
            const EXCHANGES: $crate::core::primitive::bool =
                <$sequence as $crate::compose::Sequence<Self>>::EXCHANGES;
            type Prepared = <$sequence as $crate::compose::Sequence<Self>>::Prepared;
            type Memory<__S: $crate::scalar::Scalar> =
                <$sequence as $crate::compose::Sequence<Self>>::Memory<__S>;
            type Compensated<__S: $crate::scalar::Scalar> =
                <$sequence as $crate::compose::Sequence<Self>>::Compensated<__S>;
            type Carry<__S: $crate::scalar::Scalar> =
                <$sequence as $crate::compose::Sequence<Self>>::Carry<__S>;

            fn increments(&self, __degrees: $crate::core::primitive::usize) -> $crate::core::primitive::usize {
                <$sequence as $crate::compose::Sequence<Self>>::increments(self, __degrees)
            }

            fn exchanged(&self, __memory: &Self::Memory<$crate::core::primitive::f64>) -> $crate::system::Exchange {
                <$sequence as $crate::compose::Sequence<Self>>::exchanged(self, __memory)
            }

            fn memory(&self) -> Self::Memory<$crate::core::primitive::f64> {
                <$sequence as $crate::compose::Sequence<Self>>::memory(self, &$substeps)
            }

            fn prepare(&self, __h: $crate::core::primitive::f64) -> $crate::core::result::Result<Self::Prepared, $crate::error::ConfigError> {
                <$sequence as $crate::compose::Sequence<Self>>::prepare(self, __h, &$substeps)
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
                <$sequence as $crate::compose::Sequence<Self>>::advance::<__S, __C, __CAREFUL>(
                    self, __prepared, __t, __h, __q, __p, __dw, __memory, __carry,
                )
            }

            type Beside<const __L: $crate::core::primitive::usize> =
                <$sequence as $crate::compose::Sequence<Self>>::Beside<__L>;

            fn beside<const __L: $crate::core::primitive::usize>(
                __systems: [&Self; __L],
                __prepared: [&Self::Prepared; __L],
            ) -> $crate::core::option::Option<Self::Beside<__L>> {
                <$sequence as $crate::compose::Sequence<Self>>::beside(__systems, __prepared)
            }

            #[inline(always)]
            fn advance_beside<const __L: $crate::core::primitive::usize>(
                __beside: &Self::Beside<__L>,
                __t: $crate::core::primitive::f64,
                __h: $crate::core::primitive::f64,
                __q: &mut [$crate::lanes::Lanes<__L>],
                __p: &mut [$crate::lanes::Lanes<__L>],
                __dw: &[$crate::lanes::Lanes<__L>],
                __memory: &mut Self::Memory<$crate::lanes::Lanes<__L>>,
            ) -> $crate::core::result::Result<$crate::solve::Effort, $crate::error::StepFailure> {
                <$sequence as $crate::compose::Sequence<Self>>::advance_beside(
                    __beside, __t, __h, __q, __p, __dw, __memory,
                )
            }

            #[inline(always)]
            fn advance_vectors<__C: $crate::carry::Carry<$crate::core::primitive::f64>, const __CAREFUL: $crate::core::primitive::bool>(
                &self,
                __prepared: &Self::Prepared,
                __t: $crate::core::primitive::f64,
                __h: $crate::core::primitive::f64,
                __q: &mut Self::Vector,
                __p: &mut Self::Vector,
                __dw: &[$crate::core::primitive::f64],
                __memory: &mut Self::Memory<$crate::core::primitive::f64>,
                __carry: &mut __C,
            ) -> $crate::core::result::Result<$crate::solve::Effort, $crate::error::StepFailure> {
                <$sequence as $crate::compose::Sequence<Self>>::advance_vectors::<__C, __CAREFUL>(
                    self, __prepared, __t, __h, __q, __p, __dw, __memory, __carry,
                )
            }

            fn discrete_lagrangian(&self, __segment: &$crate::system::Segment<Self::Vector>, __dw: &[$crate::core::primitive::f64]) -> $crate::core::primitive::f64 {
                $crate::compose::value::<Self, $sequence>(self, __segment, __dw, &$substeps)
            }

            fn discrete_lagrangian_gradient(
                &self,
                __segment: &$crate::system::Segment<Self::Vector>,
                __dw: &[$crate::core::primitive::f64],
            ) -> $crate::system::LagrangianGradient<Self::Vector> {
                $crate::compose::gradient_of::<Self, $scheme, $sequence>(self, __segment, __dw)
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
