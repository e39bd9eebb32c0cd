//! Few constraints of few degrees of freedom: arrays, without index lists.

use super::Constrained;
use super::layout::{ConstraintLayout, is_pivot, truth};
use crate::algebra::scalar::Scalar;
use crate::algebra::shape::Fixed;
use crate::algebra::solve::{eliminate, substitute};

/// `M` constraints of `D` degrees of freedom, all of whose entries are stored.
#[derive(Clone, Copy, Debug)]
pub struct DenseConstraints<const D: usize, const M: usize>;

impl<const D: usize, const M: usize> ConstraintLayout for DenseConstraints<D, M> {
    type Multipliers = Fixed<M>;
    type Pattern = ();
    type Jacobian<S: Scalar> = [[S; D]; M];
    type Factors<S: Scalar> = [[S; M]; M];

    fn pattern<F: Constrained<Layout = Self>>(_: &F, _: usize) {}

    fn jacobian<S: Scalar>(_: &()) -> [[S; D]; M] {
        [[S::from_f64(0.0); D]; M]
    }

    fn factors<S: Scalar>(_: &()) -> [[S; M]; M] {
        [[S::from_f64(0.0); M]; M]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn clear<S: Scalar>(jacobian: &mut [[S; D]; M]) {
        *jacobian = [[S::from_f64(0.0); D]; M];
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add<S: Scalar>(
        _: &(),
        jacobian: &mut [[S; D]; M],
        _: usize,
        [constraint, coordinate]: [usize; 2],
        slope: S,
    ) {
        jacobian[constraint][coordinate] = jacobian[constraint][coordinate] + slope;
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn product<S: Scalar>(_: &(), jacobian: &[[S; D]; M], v: &[S], into: &mut [S]) {
        for k in 0..M {
            let mut sum = S::from_f64(0.0);
            for i in 0..D {
                sum = sum + jacobian[k][i] * v[i];
            }
            into[k] = sum;
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn absolute_product<S: Scalar>(_: &(), jacobian: &[[S; D]; M], v: &[S], into: &mut [S]) {
        for k in 0..M {
            let mut sum = S::from_f64(0.0);
            for i in 0..D {
                sum = sum + (jacobian[k][i] * v[i]).abs();
            }
            into[k] = sum;
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn transposed_product<S: Scalar>(_: &(), jacobian: &[[S; D]; M], nu: &[S], into: &mut [S]) {
        for i in 0..D {
            let mut sum = S::from_f64(0.0);
            for k in 0..M {
                sum = sum + jacobian[k][i] * nu[k];
            }
            into[i] = sum;
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn factor<S: Scalar>(
        _: &(),
        later: &[[S; D]; M],
        w: &[S],
        earlier: &[[S; D]; M],
        a: &mut [[S; M]; M],
    ) -> S::Mask {
        let zero = S::from_f64(0.0);
        let mut terms = [zero; M];
        for l in 0..M {
            let mut weighted = [zero; D];
            for i in 0..D {
                weighted[i] = w[i] * earlier[l][i];
            }
            for k in 0..M {
                let mut sum = zero;
                for i in 0..D {
                    let term = later[k][i] * weighted[i];
                    sum = sum + term;
                    if k == l {
                        terms[k] = terms[k] + term.abs();
                    }
                }
                a[k][l] = sum;
            }
        }
        let mut is_regular = truth::<S::Mask>();
        for k in 0..M {
            is_regular = is_regular & is_pivot(a[k][k], terms[k]);
            eliminate(a, k);
        }
        is_regular
    }

    fn diagonal<S: Scalar>(_: &(), jacobian: &[[S; D]; M], w: &[S], into: &mut [S]) {
        for k in 0..M {
            into[k] = S::from_f64(0.0);
            for i in 0..D {
                into[k] = into[k] + jacobian[k][i] * jacobian[k][i] * w[i];
            }
        }
    }

    fn pivots<S: Scalar>(_: &(), a: &[[S; M]; M], into: &mut [S]) {
        for k in 0..M {
            into[k] = a[k][k].recip();
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve<S: Scalar>(_: &(), a: &[[S; M]; M], b: &mut [S]) {
        let mut x = [S::from_f64(0.0); M];
        x.copy_from_slice(b);
        b.copy_from_slice(&substitute(a, x));
    }
}
