//! How many paths go beside each other.

/// How many paths of states of type `V` go beside each other where one degree of freedom goes with `width` of them: half as many if there are
/// more, so that the registers hold the states and what is computed of them (measured: 1.8 ns for a step of two degrees of freedom with 16,
/// 7.1 with 32). A state of unknown size is a large one.
pub(super) const fn paths_beside<V>(width: usize) -> usize {
    if size_of::<V>() > size_of::<f64>() { width / 2 } else { width }
}

/// Calls a method with as many paths as suit states of a type: `beside!(V, L, width => expression)`. What is not taken is not compiled.
macro_rules! beside {
    ($state:ty, $width:expr, $narrow:ident => $run:expr) => {{
        macro_rules! of {
            ($paths:literal) => {{
                const $narrow: usize = $paths;
                $run
            }};
        }
        if const { crate::ensemble::width::paths_beside::<$state>($width) == 32 } {
            of!(32)
        } else if const { crate::ensemble::width::paths_beside::<$state>($width) == 16 } {
            of!(16)
        } else if const { crate::ensemble::width::paths_beside::<$state>($width) == 8 } {
            of!(8)
        } else if const { crate::ensemble::width::paths_beside::<$state>($width) == 4 } {
            of!(4)
        } else {
            of!(2)
        }
    }};
}
pub(super) use beside;
