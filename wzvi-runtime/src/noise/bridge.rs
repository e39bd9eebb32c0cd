//! A Brownian path over an interval, and how an interval splits.
//!
//! Over an interval of length L let `w = W(b) - W(a)` and `A = int_a^b (W(s) - W(a) - (s - a) w / L) ds`, the
//! area between the path and its chord: independent, `w ~ N(0, L)`, `A ~ N(0, L^3 / 12)`. Cut at the fraction
//! alpha, beta = 1 - alpha. With x the height of the path over its chord at the cut, the covariances of the
//! Brownian bridge give
//!
//! ```text
//! x   = 6 alpha beta A / L + sqrt(L alpha beta (1 - 3 alpha beta)) n_1          w_1 = alpha w + x,  w_2 = beta w - x
//! S   = A - L x / 2 = A_1 + A_2                                                 (the triangle under the cut is L x / 2)
//! A_1 = alpha^3 / (1 - 3 alpha beta) S + sqrt(L^3 alpha^3 beta^3 / (12 (1 - 3 alpha beta))) n_2,   A_2 = S - A_1
//! ```
//!
//! because `cov(x, A) = L^2 alpha beta / 2`, and, given x, A_1 and A_2 are independent with variances
//! `(alpha L)^3 / 12` and `(beta L)^3 / 12`, and only their sum S is given;
//! `alpha^3 + beta^3 = 1 - 3 alpha beta`. So two normals n_1, n_2 per cut give two intervals of the same law
//! as the whole: the tree can be refined for ever, and every integral of W is exact.
//!
//! Tested by `wzvi-runtime/tests/runtime/noise_path.rs` and `tests/laws/noise.rs`.

/// Increment and area over an interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BridgeInterval {
    /// `W(b) - W(a)`.
    pub(super) w: f64,
    /// Area between the path and its chord.
    pub(super) area: f64,
}

impl BridgeInterval {
    /// A fresh interval of the given length.
    pub(super) fn draw(length: f64, [n1, n2]: [f64; 2]) -> Self {
        Self { w: length.sqrt() * n1, area: length * (length / 12.0).sqrt() * n2 }
    }
}

/// Scales of an interval: its length and powers of it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct IntervalScale {
    pub(super) length: f64,
    root: f64,
    inverse: f64,
}

impl IntervalScale {
    pub(super) fn new(length: f64) -> Self {
        Self { length, root: length.sqrt(), inverse: 1.0 / length }
    }
}

/// The coefficients of a cut of an interval whose length is a given part of a page.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cut {
    alpha: f64,
    beta: f64,
    lean: f64,
    height: f64,
    half: f64,
    share: f64,
    spread: f64,
}

impl Cut {
    /// Cut at the fraction `alpha` of an interval that is the part `part` of its page.
    pub(super) fn new(alpha: f64, part: f64) -> Self {
        let beta = 1.0 - alpha;
        let product = alpha * beta;
        let rest = 1.0 - 3.0 * product;
        Self {
            alpha,
            beta,
            lean: 6.0 * product / part,
            height: (part * product * rest).sqrt(),
            half: 0.5 * part,
            share: alpha * alpha * alpha / rest,
            spread: part * product * (part * product / (12.0 * rest)).sqrt(),
        }
    }

    /// The two parts of `whole`; `page` has the scales of the page.
    #[inline]
    pub(super) fn apply(
        &self,
        whole: BridgeInterval,
        page: &IntervalScale,
        [n1, n2]: [f64; 2],
    ) -> [BridgeInterval; 2] {
        let x = self.lean * page.inverse * whole.area + self.height * page.root * n1;
        let sum = whole.area - self.half * page.length * x;
        let first = self.share * sum + self.spread * page.length * page.root * n2;
        [
            BridgeInterval { w: self.alpha * whole.w + x, area: first },
            BridgeInterval { w: self.beta * whole.w - x, area: sum - first },
        ]
    }
}

/// `W(b) - W(a)`, `int_a^b (W(s) - W(a)) ds` and `b - a`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PathIncrement {
    pub(super) w: f64,
    pub(super) integral: f64,
    pub(super) length: f64,
}

impl PathIncrement {
    /// The increment over an empty interval.
    pub(super) const EMPTY: Self = Self { w: 0.0, integral: 0.0, length: 0.0 };

    /// The increment over one interval of the tree.
    #[inline]
    pub(super) fn of(node: BridgeInterval, length: f64) -> Self {
        Self { w: node.w, integral: node.area + 0.5 * length * node.w, length }
    }

    /// The increment over this interval and the one that follows.
    #[inline]
    pub(super) fn then(self, next: Self) -> Self {
        Self {
            w: self.w + next.w,
            integral: self.integral + (next.integral + next.length * self.w),
            length: self.length + next.length,
        }
    }

    /// The increment over the same interval with time running backwards.
    #[inline]
    pub(super) fn mirrored(self) -> Self {
        Self { w: -self.w, integral: self.integral - self.length * self.w, length: self.length }
    }
}
