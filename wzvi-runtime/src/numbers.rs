//! Things that consist of numbers, to take apart and to put together again.

use std::marker::PhantomData;

/// What a step leaves for the next one, as a list of numbers: a checkpoint keeps it to the last bit.
///
/// One method serves both directions, so that reading cannot disagree with writing.
pub trait Numbers<S> {
    /// Calls `visit` with every number, in an order that depends on nothing but the type and the numbers before. A number that `visit`
    /// replaces is taken over, so that the numbers of one value make another one equal to it.
    fn visit(&mut self, visit: &mut dyn FnMut(&mut S));
}

impl<S> Numbers<S> for () {
    fn visit(&mut self, _visit: &mut dyn FnMut(&mut S)) {}
}

impl<S> Numbers<S> for PhantomData<S> {
    fn visit(&mut self, _visit: &mut dyn FnMut(&mut S)) {}
}

/// As long as those for which the standard library has `Default` and `Debug`, which a memory needs as well.
macro_rules! tuples {
    ($(($($part:ident)+))+) => {$(
        impl<Scalar, $($part: Numbers<Scalar>),+> Numbers<Scalar> for ($($part,)+) {
            fn visit(&mut self, visit: &mut dyn FnMut(&mut Scalar)) {
                #[allow(non_snake_case, reason = "each part is named like its type")]
                let ($($part,)+) = self;
                $($part.visit(visit);)+
            }
        }
    )+};
}

tuples! {
    (A)
    (A B)
    (A B C)
    (A B C D)
    (A B C D E)
    (A B C D E F)
    (A B C D E F G)
    (A B C D E F G H)
    (A B C D E F G H I)
    (A B C D E F G H I J)
    (A B C D E F G H I J K)
    (A B C D E F G H I J K L)
}
