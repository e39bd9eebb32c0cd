//! Functions on time scales, their derivatives and means.
//!
//! Tested by `wzvi-runtime/src/calculus/tests.rs`.

use std::marker::PhantomData;
use std::ops::{Add, Div, Mul, Sub};

use super::{DomainError, Interior, Lambda, Midpoints, Minus, Nodes, Plus, Point, Scale, TimeScale, Whole};

/// A function on the time scale `S`: the paper's `C(S, V)`. Its values are real numbers, vectors of
/// `nalgebra`, dual numbers: what has the operations that an operator takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Function<S, V> {
    scale: TimeScale,
    values: Vec<V>,
    kind: PhantomData<fn() -> S>,
}

impl<S: Scale, V> Function<S, V> {
    /// The function with these values, in the order of the points.
    ///
    /// # Errors
    /// [`DomainError::Length`] unless there is one value per point.
    pub fn new(scale: TimeScale, values: Vec<V>) -> Result<Self, DomainError> {
        let (expected, got) = (scale.size::<S>(), values.len());
        if expected == got {
            Ok(Self::raw(scale, values))
        } else {
            Err(DomainError::Length { expected, got })
        }
    }

    /// The function with the value `f(point)` at each point.
    pub fn over(scale: TimeScale, f: impl FnMut(Point) -> V) -> Self {
        Self::raw(scale, scale.points::<S>().map(f).collect())
    }

    pub(super) fn raw(scale: TimeScale, values: Vec<V>) -> Self {
        Self { scale, values, kind: PhantomData }
    }

    fn neighbours(&self, f: impl Fn(&V, &V) -> V) -> Vec<V> {
        self.values.iter().zip(self.values.iter().skip(1)).map(|(before, after)| f(before, after)).collect()
    }

    /// Interval and steps.
    pub fn scale(&self) -> TimeScale {
        self.scale
    }

    /// The values in the order of the points.
    pub fn values(&self) -> &[V] {
        &self.values
    }

    /// Points and values.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (Point, &V)> {
        self.scale.points::<S>().zip(&self.values)
    }

    /// The value at a point.
    ///
    /// # Errors
    /// [`DomainError::Point`] if it is not on `S`.
    pub fn at(&self, point: Point) -> Result<&V, DomainError> {
        let index = self.scale.index::<S>(point)?;
        self.values.get(index).ok_or(DomainError::Length { expected: index + 1, got: self.values.len() })
    }

    /// `f ∘ self`
    pub fn map<W>(&self, f: impl FnMut(&V) -> W) -> Function<S, W> {
        Function::raw(self.scale, self.values.iter().map(f).collect())
    }

    /// `f(self, other)` point by point: products, sums, scalar products.
    ///
    /// # Errors
    /// [`DomainError::Different`] unless both are on the same interval in the same steps.
    pub fn zip_with<W, X>(
        &self,
        other: &Function<S, W>,
        mut f: impl FnMut(&V, &W) -> X,
    ) -> Result<Function<S, X>, DomainError> {
        if self.scale != other.scale {
            return Err(DomainError::Different);
        }
        let values = self.values.iter().zip(&other.values).map(|(v, w)| f(v, w));
        Ok(Function::raw(self.scale, values.collect()))
    }
}

impl<S: Scale, V: Clone> Function<S, V> {
    /// The restriction to `R`, a part of `S`.
    ///
    /// # Errors
    /// [`DomainError::Point`] with the first point of `R` that is not on `S`.
    pub fn restrict<R: Scale>(&self) -> Result<Function<R, V>, DomainError> {
        let values: Result<_, _> = self.scale.points::<R>().map(|point| self.at(point).cloned()).collect();
        Ok(Function::raw(self.scale, values?))
    }
}

impl<S: Scale, V: Clone + Sub<Output = V> + Div<f64, Output = V>> Function<S, V> {
    /// `Δ₊ f(t) = (f(σ(t)) - f(t)) / (σ(t) - t)` on `S` without its last point: the paper's `Δ₊`, `Δ_{∘,+}`
    /// and `Δ_{½,+}`.
    pub fn delta_plus(&self) -> Function<Plus<S>, V> {
        Function::raw(self.scale, self.slopes())
    }

    /// `Δ₋ f(t) = (f(t) - f(ρ(t))) / (t - ρ(t))` on `S` without its first point: the paper's `Δ₋`, `Δ_{∘,-}`
    /// and `Δ_{½,-}`.
    pub fn delta_minus(&self) -> Function<Minus<S>, V> {
        Function::raw(self.scale, self.slopes())
    }

    fn slopes(&self) -> Vec<V> {
        let step = self.scale.step_size() * (S::STRIDE as f64 / 2.0);
        self.neighbours(|before, after| (after.clone() - before.clone()) / step)
    }
}

fn mean<V: Clone + Add<Output = V> + Mul<f64, Output = V>>(one: &V, other: &V) -> V {
    (one.clone() + other.clone()) * 0.5
}

impl<V: Clone + Add<Output = V> + Mul<f64, Output = V>> Function<Nodes, V> {
    /// `f_∘`: `f` on T, the mean of the two neighbours on T_½.
    pub fn extension(&self) -> Function<Whole, V> {
        let means = self.neighbours(mean);
        let pairs = self.values.iter().zip(means).flat_map(|(node, mean)| [node.clone(), mean]);
        Function::raw(self.scale, pairs.chain(self.values.last().cloned()).collect())
    }
}

impl<V: Clone + Add<Output = V> + Mul<f64, Output = V>> Function<Midpoints, V> {
    /// `[f]_{½,-}(t) = (f(t) + f(ρ_½(t))) / 2` on T_½⁻.
    pub fn mean_minus(&self) -> Function<Minus<Midpoints>, V> {
        Function::raw(self.scale, self.neighbours(mean))
    }

    /// `[f]_∘(t_i) = (f(t_{i+1/2}) + f(t_{i-1/2})) / 2` on T^±, which reads `f` on T_½ only.
    pub fn mean_around(&self) -> Function<Interior, V> {
        Function::raw(self.scale, self.neighbours(mean))
    }
}

impl<V: Clone + Add<Output = V> + Mul<f64, Output = V>> Function<Whole, V> {
    /// `[f]_∘(t_i) = (f(t_{i+1/2}) + f(t_{i-1/2})) / 2` on T^±.
    pub fn mean_around(&self) -> Function<Interior, V> {
        let around = self.values.iter().skip(1).step_by(2).zip(self.values.iter().skip(3).step_by(2));
        Function::raw(self.scale, around.map(|(before, after)| mean(before, after)).collect())
    }
}

/// Functions on scales with one point `t_{i,λ}` per step.
macro_rules! integrals {
    ($($function:ty;)+) => {$(
        impl<V: Clone + Add<Output = V> + Mul<f64, Output = V>> $function {
            /// `∫_a^b f Δ_λ t = h Σ f(t_{i,λ})`: the paper's `∫ f Δt` on T⁺ and `∫ f Δ_½ t` on T_½.
            ///
            /// # Errors
            /// [`DomainError::Length`] without values, which no [`TimeScale`] allows.
            pub fn integral(&self) -> Result<V, DomainError> {
                let sum = self.values().iter().cloned().reduce(|sum, value| sum + value);
                let no_values = DomainError::Length { expected: 1, got: 0 };
                sum.map(|sum| sum * self.scale().step_size()).ok_or(no_values)
            }

            /// `t ↦ at_start + ∫_a^t f Δ_λ` on T.
            pub fn antiderivative(&self, at_start: V) -> Function<Nodes, V> {
                let (mut total, h) = (at_start.clone(), self.scale().step_size());
                let sums = self.values().iter().map(|value| {
                    total = total.clone() + value.clone() * h;
                    total.clone()
                });
                Function::raw(self.scale(), std::iter::once(at_start).chain(sums).collect())
            }
        }
    )+};
}

integrals! {
    Function<Plus<Nodes>, V>;
    Function<Midpoints, V>;
    Function<Minus<Nodes>, V>;
    Lambda<V>;
}
