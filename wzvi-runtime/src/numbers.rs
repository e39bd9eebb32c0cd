//! Things that consist of numbers, to take apart and to put together again.

use std::marker::PhantomData;

use crate::scalar::Scalar;

/// What a step leaves for the next one, as a list of numbers: a checkpoint keeps it to the last bit.
///
/// One method serves both directions, so that reading cannot disagree with writing.
pub trait Numbers<S> {
    /// Calls `visit` with every number, in an order that depends on nothing but the type and the numbers before. A
    /// number that `visit` replaces is taken over, so that the numbers of one value make another one equal to it.
    fn visit(&mut self, visit: &mut dyn FnMut(&mut S));
}

impl<S> Numbers<S> for () {
    fn visit(&mut self, _visit: &mut dyn FnMut(&mut S)) {}
}

impl<S> Numbers<S> for PhantomData<S> {
    fn visit(&mut self, _visit: &mut dyn FnMut(&mut S)) {}
}

/// Its length comes first, so that a vector of any other length becomes equal to it.
impl<S: Scalar> Numbers<S> for Vec<S> {
    fn visit(&mut self, visit: &mut dyn FnMut(&mut S)) {
        let mut length = S::from_f64(self.len() as f64);
        visit(&mut length);
        // Exact: lengths are below 2^53. One that does not fit in memory is not taken over, which whoever counts the
        // numbers finds out.
        let length = length.magnitude() as usize;
        if self.try_reserve_exact(length.saturating_sub(self.len())).is_ok() {
            self.resize(length, S::from_f64(0.0));
        }
        self.iter_mut().for_each(visit);
    }
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

#[cfg(test)]
mod tests {
    use super::Numbers;
    use crate::carry::{Carry, Compensation};
    use crate::solve::Extrapolation;

    fn numbers(value: &mut impl Numbers<f64>) -> Vec<u64> {
        let mut numbers = Vec::new();
        value.visit(&mut |number| numbers.push(number.to_bits()));
        numbers
    }

    /// The numbers of one value make another one equal to it.
    fn copied<T: Numbers<f64>>(mut value: T, mut other: T) -> T {
        let expected = numbers(&mut value);
        let mut list = expected.iter();
        other.visit(&mut |number| *number = f64::from_bits(*list.next().unwrap()));
        assert_eq!(list.len(), 0);
        assert_eq!(numbers(&mut other), expected);
        other
    }

    #[test]
    fn numbers_make_an_equal_value() {
        let (mut memory, mut carry) = (Extrapolation::<f64, 2>::default(), Compensation::<f64, 1>::default());
        for n in 0..4 {
            let copy = copied((memory, (carry, vec![0.5; n])), Default::default());
            assert_eq!(copy.0.guess::<true>(), memory.guess::<true>());
            assert_eq!((copy.1.0, copy.1.1), (carry, vec![0.5; n]));
            // What is known counts too: the next record must do the same to both.
            let (mut one, mut other) = (memory, copy.0);
            one.record::<true>([7.0, -0.0]);
            other.record::<true>([7.0, -0.0]);
            assert_eq!(one.guess::<true>(), other.guess::<true>());
            let x = f64::from(n as u32);
            memory.record::<true>([x * x, x.sin()]);
            carry.keep(&[x], &[-x]);
        }
        assert_eq!(copied(vec![1.0, -0.0], vec![3.0; 9]), [1.0, -0.0]);
    }
}
