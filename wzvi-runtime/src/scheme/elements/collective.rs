//! Second derivatives of functions of collective variables: numbers that all sites determine together.
//!
//! The first derivatives `F_x(x, c)` of a role read the state and the collective variables `c_m(x)`. So
//!
//! ```text
//! d²F/dx dx = ∂F_x/∂x + Σ_m b_m a_mᵀ,   b_m = ∂F_x/∂c_m,   a_m = dc_m/dx
//! ```
//!
//! with a sparse first term, which [`Elements::hessian`](super::Elements::hessian) gives, and a term of rank
//! one for each variable that `F_x` reads. Other variables are read by these, and have gradients `a` alone.

use super::role::Role;
use crate::algebra::scalar::Scalar;

/// The collective variables of a role: sums over sites that stand in nonlinear functions, and slopes by
/// these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CollectiveVariables {
    /// The role whose terms follow them.
    pub role: Role,
    /// The number of variables on which its first derivatives depend.
    pub count: usize,
    /// The variables that its first derivatives read themselves, by number.
    pub read: &'static [usize],
}

/// The terms of rank one of the second derivatives of a role: `a` of each variable and `b` of each that is
/// read, by coordinates and then by momenta.
#[derive(Clone, Debug, Default)]
pub struct CollectiveHessian<S> {
    degrees: usize,
    read: &'static [usize],
    gradients: Vec<S>,
    slopes: Vec<S>,
}

impl<S: Scalar> CollectiveHessian<S> {
    /// Clears the terms, for these variables of a system of `degrees` degrees of freedom.
    pub(super) fn begin(&mut self, degrees: usize, variables: &CollectiveVariables) {
        (self.degrees, self.read) = (degrees, variables.read);
        let lists = [(&mut self.gradients, variables.count), (&mut self.slopes, variables.read.len())];
        for (list, count) in lists {
            list.clear();
            list.resize(2 * degrees * count, S::from_f64(0.0));
        }
    }

    /// `a` of a variable.
    pub fn gradient(&mut self, variable: usize) -> [&mut [S]; 2] {
        halves(&mut self.gradients, variable, self.degrees)
    }

    /// `b` of the variable of a term.
    pub fn slopes(&mut self, term: usize) -> [&mut [S]; 2] {
        halves(&mut self.slopes, term, self.degrees)
    }

    /// Adds `slope` times `a` of the variable `inner` to that of `outer`, which reads it.
    pub fn chain(&mut self, outer: usize, inner: usize, slope: S) {
        let size = 2 * self.degrees;
        // A variable reads others with lower numbers only, and both are below the count given to `begin`.
        let (before, after) = self.gradients.split_at_mut(outer * size);
        for (own, &inner) in after[..size].iter_mut().zip(&before[inner * size..]) {
            *own = *own + slope * inner;
        }
    }

    /// `a` and `b` of each term, both by coordinates and by momenta.
    pub(super) fn terms(&self) -> impl Iterator<Item = [[&[S]; 2]; 2]> {
        let size = 2 * self.degrees;
        self.read.iter().enumerate().map(move |(term, &variable)| {
            let (a, b) = (&self.gradients[variable * size..][..size], &self.slopes[term * size..][..size]);
            [a, b].map(|list| list.split_at(self.degrees).into())
        })
    }
}

/// The slopes of a variable by coordinates and by momenta. `begin` made room for all variables.
fn halves<S>(lists: &mut [S], variable: usize, degrees: usize) -> [&mut [S]; 2] {
    let size = 2 * degrees;
    lists[variable * size..(variable + 1) * size].split_at_mut(degrees).into()
}
