//! The rule by which sections and first passages count crossings, from one point of a path to the next.

/// On which side of zero a function is along a path.
///
/// A crossing is a change of sign. Where the function is zero at a point, the next value that is not zero
/// decides: the path has crossed there if the sign is another one than before, and has touched zero
/// otherwise. A path that starts at zero has no side before its first value that is not zero, and one whose
/// function is NaN has none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SignSide<P> {
    /// The value at the last point.
    pub(super) value: f64,
    pub(super) sign: f64,
    /// The first point since then at which the value was zero.
    pub(super) touched: Option<P>,
    /// The number added to the function until it is larger than this on its side: where a path goes on from a
    /// zero of the function, its rounding is no crossing.
    offset: f64,
}

/// The place of a change of sign of a function.
pub(crate) enum SignChange<P> {
    /// At a point before, where the function was zero.
    At(P),
    /// Between the last two points.
    Between,
}

impl<P> SignSide<P> {
    /// A path that starts with this value.
    pub(crate) fn at(value: f64) -> Self {
        let sign = if value.is_nan() { 0.0 } else { sign(value) };
        Self { value, sign, touched: None, offset: 0.0 }
    }

    /// A path on the side of this sign, where the function has this value: one of another sign is zero up to
    /// rounding.
    pub(crate) fn on(sign: f64, value: f64) -> Self {
        let is_there = sign * value > 0.0 || sign == 0.0;
        Self::at(if is_there { value } else { f64::MIN_POSITIVE.copysign(sign) })
    }

    /// A path on the side of this sign that goes on from a zero, where the function has this value: a value
    /// of the other sign up to the size `rounding` is none.
    pub(crate) fn from_zero(sign: f64, value: f64, rounding: f64) -> Self {
        // Twice, so that the path is not on the edge.
        let offset = 2.0 * rounding * sign;
        Self { offset, ..Self::at(value + offset) }
    }

    /// The number added to the function.
    pub(crate) fn offset(&self) -> f64 {
        self.offset
    }

    /// Adds the offset to a value of the function, unless it is larger than that by itself.
    pub(crate) fn shifted(&mut self, value: f64) -> f64 {
        if self.sign * value > self.offset.abs() {
            self.offset = 0.0;
        }
        value + self.offset
    }

    /// This side, with an offset.
    pub(crate) fn with_offset(self, offset: f64) -> Self {
        Self { offset, ..self }
    }

    /// The sign of the last value that was not zero; 0 before there is one, and after NaN.
    pub(crate) fn sign(&self) -> f64 {
        self.sign
    }

    /// The value at the last point.
    pub(crate) fn value(&self) -> f64 {
        self.value
    }

    /// Goes on to the next point, `here`, where the function has this value. Returns where its sign has
    /// changed, if it has.
    pub(crate) fn advance_to(&mut self, value: f64, here: impl FnOnce() -> P) -> Option<SignChange<P>> {
        self.value = value;
        let (before, after) = (self.sign, sign(value));
        if after.is_nan() {
            (self.sign, self.touched) = (0.0, None);
            None
        } else if after == 0.0 {
            if before != 0.0 && self.touched.is_none() {
                self.touched = Some(here());
            }
            None
        } else {
            self.sign = after;
            if before != after {
                self.offset = 0.0;
            }
            let touched = self.touched.take();
            (before == -after).then(|| touched.map_or(SignChange::Between, SignChange::At))
        }
    }
}

/// -1, 0 or 1; NaN of NaN.
pub(crate) fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// The time at which a straight line crosses zero that has values of different signs at the two `times`.
pub(crate) fn crossing_of_chord([start, end]: [f64; 2], [before, after]: [f64; 2]) -> f64 {
    // By halves, so that the difference does not overflow.
    let fraction = 0.5 * before / (0.5 * before - 0.5 * after);
    // Only the sign of an infinite value is known.
    if fraction.is_nan() { end } else { start + (end - start) * fraction }
}

#[cfg(test)]
mod tests {
    use super::{SignChange, SignSide, crossing_of_chord};

    /// The places where a function with these values at 0, 1, 2, ... changes its sign; a place between `n`
    /// and `n + 1` is `n + 1/2`.
    fn changes(values: &[f64]) -> Vec<f64> {
        let mut side = SignSide::at(values[0]);
        let next = (1..).zip(&values[1..]).filter_map(|(i, &value)| {
            side.advance_to(value, || f64::from(i)).map(|change| match change {
                SignChange::At(point) => point,
                SignChange::Between => f64::from(i) - 0.5,
            })
        });
        next.collect()
    }

    #[test]
    fn changes_of_sign_count() {
        for (values, expected) in [
            (&[-1.0, 1.0, -1.0][..], &[0.5, 1.5][..]),
            (&[-1.0, 0.0, 0.0, 2.0], &[1.0]),
            (&[-1.0, 0.0, -0.0, -2.0, 1.0], &[3.5]),
            (&[0.0, 1.0, -1.0], &[1.5]),
            (&[-1.0, 0.0], &[]),
            (&[-1.0, f64::NAN, 1.0, -1.0], &[2.5]),
            (&[-1.0, 0.0, f64::NAN, 1.0], &[]),
            (&[f64::NAN, 1.0, f64::NEG_INFINITY], &[1.5]),
        ] {
            assert_eq!(changes(values), expected, "{values:?}");
        }
    }

    #[test]
    fn crossings_of_chords_are_interpolated() {
        let between = |before, after| crossing_of_chord([1.0, 2.0], [before, after]);
        assert_eq!(between(-1.0, 3.0), 1.25);
        assert_eq!(between(3.0, -1.0), 1.75);
        assert_eq!(between(-f64::MAX, f64::MAX), 1.5);
        assert_eq!(between(-1.0, f64::INFINITY), 1.0);
        assert_eq!(between(f64::NEG_INFINITY, 1.0), 2.0);
    }
}
