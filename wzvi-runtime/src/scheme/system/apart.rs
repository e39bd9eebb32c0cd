//! Systems that do not go in lanes beside each other.

/// Where systems do not go in lanes beside each other, nothing of them is prepared for it.
#[derive(Clone, Copy, Debug)]
pub enum Apart {}

/// What a [`Scheme`](crate::scheme::system::Scheme) says of systems `$system` that do not go beside each other.
#[doc(hidden)]
#[macro_export]
macro_rules! __apart {
    ($system:ty) => {
        type Beside<const L: usize> = $crate::scheme::system::Apart;

        fn beside<const L: usize>(
            _: [&$system; L],
            _: [&Self::Prepared; L],
        ) -> Option<$crate::scheme::system::Apart> {
            None
        }

        fn advance_beside<const L: usize>(
            beside: &$crate::scheme::system::Apart,
            _: $crate::scheme::system::At<'_, $crate::algebra::lanes::Lanes<L>>,
            _: &mut Self::Memory<$crate::algebra::lanes::Lanes<L>>,
        ) -> Result<$crate::algebra::solve::Effort, $crate::error::StepFailure> {
            match *beside {}
        }
    };
}
