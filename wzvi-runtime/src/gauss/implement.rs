//! The implementation of a Gauss method, which is the same for all systems.

/// What follows the header `impl Discretized<Gauss<$stages>> for ...`.
#[doc(hidden)]
#[macro_export]
macro_rules! __gauss {
    ([$($header:tt)*] $scheme:ty, $stages:literal, $midpoint:expr, $text:expr) => {
        #[automatically_derived]
        $($header)* {
            const PLAN: $crate::plan::Plan = $crate::gauss::plan(
                $midpoint,
                $stages,
                <Self as $crate::gauss::Field>::IS_NYSTROM,
            );
            const EQUATIONS: &'static $crate::core::primitive::str = $text;
            const IN_LANES: $crate::core::primitive::bool =
                <<Self as $crate::gauss::Field>::Shape as $crate::gauss::Shape>::IS_FIXED;
            type Prepared = $crate::gauss::Prepared<$stages>;
            type Memory<__S: $crate::scalar::Scalar> =
                $crate::gauss::Memory<
                    __S,
                    <Self as $crate::gauss::Field>::Shape,
                    <Self as $crate::gauss::Field>::Noises,
                    $stages,
                >;
            type Compensated<__S: $crate::scalar::Scalar> =
                <<Self as $crate::gauss::Field>::Shape as $crate::gauss::Shape>::Compensation<__S>;
            type Carry<__S: $crate::scalar::Scalar> = Self::Compensated<__S>;

            // That of a step with friction is one of the momentum that friction leaves alone.
            const HAS_POLYNOMIAL: $crate::core::primitive::bool =
                $stages > 1 && !<Self as $crate::system::Hamiltonian>::IS_CONFORMAL;
            const DENSE_ORDER: $crate::core::primitive::u32 = $crate::gauss::dense_order(
                if <Self as $crate::system::Hamiltonian>::IS_CONFORMAL { 1 } else { $stages },
                &<Self as $crate::system::Discretized<$scheme>>::PLAN,
            );

            fn slopes_between(
                &self,
                __prepared: &Self::Prepared,
                __memory: &Self::Memory<$crate::core::primitive::f64>,
                __before: &$crate::state::State<Self::Vector>,
                __h: $crate::core::primitive::f64,
                __dw: &[$crate::core::primitive::f64],
                __slopes: &mut $crate::dense::Slopes,
            ) {
                $crate::gauss::slopes_between(self, __prepared, __memory, __before, __h, __dw, __slopes)
            }

            fn memory(&self) -> Self::Memory<$crate::core::primitive::f64> {
                $crate::gauss::memory(self)
            }

            fn prepare(
                &self,
                __h: $crate::core::primitive::f64,
            ) -> $crate::core::result::Result<Self::Prepared, $crate::error::ConfigError> {
                $crate::gauss::prepare(self, __h)
            }

            #[inline(always)]
            fn advance_carrying<
                __S: $crate::scalar::Scalar,
                __C: $crate::carry::Carry<__S>,
                const __CAREFUL: $crate::core::primitive::bool,
            >(
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
                $crate::gauss::advance::<Self, __S, __C, $stages, __CAREFUL>(
                    self, __prepared, __t, __h, __q, __p, __dw, __memory, __carry,
                )
            }

            type Beside<const __L: $crate::core::primitive::usize> = $crate::gauss::Systems<Self, __L, $stages>;

            fn beside<const __L: $crate::core::primitive::usize>(
                __systems: [&Self; __L],
                __prepared: [&Self::Prepared; __L],
            ) -> $crate::core::option::Option<Self::Beside<__L>> {
                $crate::gauss::beside::<Self, __L, $stages>(__systems, __prepared)
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
                $crate::gauss::advance_beside::<Self, __L, $stages>(
                    __beside, __t, __h, __q, __p, __dw, __memory,
                )
            }

            fn discrete_lagrangian(
                &self,
                __segment: &$crate::system::Segment<Self::Vector>,
                __dw: &[$crate::core::primitive::f64],
            ) -> $crate::core::primitive::f64 {
                $crate::gauss::prepare::<Self, $stages>(self, __segment.h).map_or(
                    $crate::core::primitive::f64::NAN,
                    |__prepared| $crate::gauss::value(self, &__prepared, __segment, __dw),
                )
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
