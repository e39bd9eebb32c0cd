//! Time scales and their points.
//!
//! All of them are parts of T_∘, whose points `a + j h/2` are counted by the integer `j`: nodes are even,
//! mid-points odd. A scale is then where it begins, its stride in `j` (2, but 1 for T_∘ itself) and how many
//! points it has. The operators `σ` and `ρ` add and subtract the stride, and no index arithmetic rounds.
//!
//! Tested by `wzvi-runtime/src/calculus/tests.rs`.

use std::fmt;
use std::marker::PhantomData;

use super::{DomainError, Function};

/// A point of T_∘.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Point {
    halves: usize,
}

impl Point {
    /// `t_i`
    pub const fn node(i: usize) -> Self {
        Self::half(i.saturating_mul(2))
    }

    /// `t_{i+1/2}`
    pub const fn midpoint(i: usize) -> Self {
        Self::half(i.saturating_mul(2).saturating_add(1))
    }

    /// `a + j h/2`
    pub const fn half(j: usize) -> Self {
        Self { halves: j }
    }

    /// Its distance from `a` in half steps.
    pub const fn halves(self) -> usize {
        self.halves
    }
}

impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.halves / 2, self.halves % 2) {
            (i, 0) => write!(f, "t_{i}"),
            (i, _) => write!(f, "t_{{{i}+1/2}}"),
        }
    }
}

/// A kind of time scale; a [`TimeScale`] has the interval.
pub trait Scale {
    /// The symbol of the paper.
    const NAME: &'static str;
    /// The first point, in half steps from `a`.
    const FIRST: usize;
    /// The distance from one point to the next, in half steps.
    const STRIDE: usize;
    /// Number of points for `steps` steps.
    fn size(steps: usize) -> usize;
}

/// T: the nodes `t_0 … t_N`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Nodes;

/// T_½: the mid-points `t_{1/2} … t_{N-1/2}`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Midpoints;

/// T_∘ = T ∪ T_½.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Whole;

/// `S` without its last point: where `Δ₊` is defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plus<S>(PhantomData<S>);

/// `S` without its first point: where `Δ₋` is defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Minus<S>(PhantomData<S>);

/// T^± = T⁺ ∩ T⁻: the interior nodes `t_1 … t_{N-1}`.
pub type Interior = Minus<Plus<Nodes>>;

impl Scale for Nodes {
    const NAME: &'static str = "T";
    const FIRST: usize = 0;
    const STRIDE: usize = 2;
    fn size(steps: usize) -> usize {
        steps.saturating_add(1)
    }
}

impl Scale for Midpoints {
    const NAME: &'static str = "T_½";
    const FIRST: usize = 1;
    const STRIDE: usize = 2;
    fn size(steps: usize) -> usize {
        steps
    }
}

impl Scale for Whole {
    const NAME: &'static str = "T_∘";
    const FIRST: usize = 0;
    const STRIDE: usize = 1;
    fn size(steps: usize) -> usize {
        steps.saturating_mul(2).saturating_add(1)
    }
}

impl<S: Scale> Scale for Plus<S> {
    const NAME: &'static str = "the time scale without its end";
    const FIRST: usize = S::FIRST;
    const STRIDE: usize = S::STRIDE;
    fn size(steps: usize) -> usize {
        S::size(steps).saturating_sub(1)
    }
}

impl<S: Scale> Scale for Minus<S> {
    const NAME: &'static str = "the time scale without its start";
    const FIRST: usize = S::FIRST + S::STRIDE;
    const STRIDE: usize = S::STRIDE;
    fn size(steps: usize) -> usize {
        S::size(steps).saturating_sub(1)
    }
}

/// `[a, b]` in `N` steps of `h = (b - a)/N`; `b < a` runs backwards, with `h < 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeScale {
    a: f64,
    b: f64,
    steps: usize,
}

impl TimeScale {
    /// `[a, b]` in `steps` steps.
    ///
    /// # Errors
    /// [`DomainError::Interval`] unless `a` and `b` are finite, `steps > 0` and `h` is finite and not zero.
    pub fn new(a: f64, b: f64, steps: usize) -> Result<Self, DomainError> {
        let scale = Self { a, b, steps };
        let usable = a.is_finite() && b.is_finite() && steps > 0 && steps <= usize::MAX / 4;
        let h = scale.step_size();
        if usable && h.is_finite() && h != 0.0 {
            Ok(scale)
        } else {
            Err(DomainError::Interval { a, b, steps })
        }
    }

    /// `a`
    pub fn start(&self) -> f64 {
        self.a
    }

    /// `b`
    pub fn end(&self) -> f64 {
        self.b
    }

    /// `N`
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// `h = (b - a)/N`
    pub fn step_size(&self) -> f64 {
        (self.b - self.a) / self.steps as f64
    }

    /// Number of points of `S`.
    pub fn size<S: Scale>(&self) -> usize {
        S::size(self.steps)
    }

    /// The points of `S` in order.
    pub fn points<S: Scale>(&self) -> impl ExactSizeIterator<Item = Point> + use<S> {
        (0..S::size(self.steps)).map(|index| Point::half(S::FIRST + index * S::STRIDE))
    }

    /// The position of `point` in `S`, from 0.
    ///
    /// # Errors
    /// [`DomainError::Point`] if it is not on `S`.
    pub fn index<S: Scale>(&self, point: Point) -> Result<usize, DomainError> {
        let beyond = point.halves.checked_sub(S::FIRST).filter(|beyond| beyond % S::STRIDE == 0);
        beyond
            .map(|beyond| beyond / S::STRIDE)
            .filter(|&index| index < self.size::<S>())
            .ok_or(DomainError::Point { point, scale: S::NAME, steps: self.steps })
    }

    /// The time of a point: `a + j (b - a)/2N`, and `b` itself at the end.
    ///
    /// # Errors
    /// [`DomainError::Point`] beyond `b`.
    pub fn time(&self, point: Point) -> Result<f64, DomainError> {
        self.index::<Whole>(point).map(|_| self.time_of(point))
    }

    fn time_of(&self, point: Point) -> f64 {
        let last = 2 * self.steps;
        if point.halves == last {
            self.b
        } else {
            self.a + point.halves as f64 * (self.b - self.a) / last as f64
        }
    }

    /// `σ(t)`: the point of `S` after `point`.
    ///
    /// # Errors
    /// [`DomainError::Point`] if either is not on `S`.
    pub fn sigma<S: Scale>(&self, point: Point) -> Result<Point, DomainError> {
        self.index::<S>(point)?;
        let next = Point::half(point.halves + S::STRIDE);
        self.index::<S>(next).map(|_| next)
    }

    /// `ρ(t)`: the point of `S` before `point`.
    ///
    /// # Errors
    /// [`DomainError::Point`] if either is not on `S`.
    pub fn rho<S: Scale>(&self, point: Point) -> Result<Point, DomainError> {
        let index = self.index::<S>(point)?;
        let before = point.halves.checked_sub(S::STRIDE).filter(|_| index > 0);
        before.map(Point::half).ok_or(DomainError::Point {
            point,
            scale: Minus::<S>::NAME,
            steps: self.steps,
        })
    }

    /// The restriction `π_S f` of a function of time to `S`.
    pub fn sample<S: Scale, V>(&self, mut f: impl FnMut(f64) -> V) -> Function<S, V> {
        Function::over(*self, |point| f(self.time_of(point)))
    }
}
