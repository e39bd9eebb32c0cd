//! The marks of an axis.

use super::figure::Axis;
use crate::ground::digits::{number, power_of_ten};

/// One mark of an axis.
pub(crate) struct Tick {
    /// Along the axis; the decadic logarithm of the value if that is logarithmic.
    pub(crate) place: f64,
    pub(crate) label: String,
}

/// Marks of an axis within a range of places: those with a name, or about so many numbers.
pub(crate) fn ticks((low, high): (f64, f64), axis: &Axis, wanted: usize) -> Vec<Tick> {
    let mut ticks = match axis {
        Axis { names, .. } if !names.is_empty() => {
            let named =
                names.iter().enumerate().map(|(n, name)| Tick { place: n as f64, label: name.clone() });
            return named.filter(|tick| (low..=high).contains(&tick.place)).collect();
        }
        Axis { logarithmic: true, .. } => decades(low, high, wanted),
        _ => linear(low, high, wanted),
    };
    // The sign, not the hyphen.
    ticks.iter_mut().for_each(|tick| tick.label = tick.label.replace('-', "−"));
    ticks
}

/// Powers of ten; with 2 and 5 times those where there would be few.
fn decades(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    let within = |place: &f64| (low..=high).contains(place);
    let powers = || low.floor() as i32..=high.ceil() as i32;
    let whole = powers().filter(|k| within(&f64::from(*k))).count();
    let stride = whole.div_ceil(wanted + 2).max(1) as i32;
    let factors: &[f64] = if whole <= 2 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let mut marks = vec![];
    for k in powers().filter(|k| k.rem_euclid(stride) == 0) {
        for factor in factors {
            let place = f64::from(k) + factor.log10();
            if within(&place) {
                let value = factor * 10f64.powi(k);
                let label = match (-3..4).contains(&k) {
                    true => number(value),
                    false if *factor == 1.0 => power_of_ten(k),
                    false => format!("{factor}·{}", power_of_ten(k)),
                };
                marks.push(Tick { place, label });
            }
        }
    }
    marks
}

/// Multiples of 1, 2 or 5 times a power of ten.
fn linear(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    let rough = (high - low) / wanted.max(1) as f64;
    let power = 10f64.powi(rough.log10().floor() as i32);
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|factor| factor * power)
        .into_iter()
        .find(|step| *step >= (1.0 - 1e-9) * rough);
    let step = step.unwrap_or(rough);
    let size = low.abs().max(high.abs());
    // All labels of an axis have the same power of ten and as many decimals as tell them apart.
    let exponent = if (1e-3..1e5).contains(&size) { 0 } else { size.log10().floor() as i32 };
    let unit = 10f64.powi(exponent);
    let decimals = (-((step / unit).log10() + 1e-9).floor()).clamp(0.0, 17.0) as usize;
    let label = |value: f64| match (value, exponent) {
        (0.0, _) => "0".to_owned(),
        (value, 0) => format!("{value:.decimals$}"),
        (value, exponent) => format!("{:.decimals$}·{}", value / unit, power_of_ten(exponent)),
    };
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last.min(first.saturating_add(20)))
        .map(|n| Tick { place: n as f64 * step, label: label(n as f64 * step) })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(range: (f64, f64), logarithmic: bool, wanted: usize) -> Vec<String> {
        let axis = Axis { logarithmic, ..Axis::linear("") };
        ticks(range, &axis, wanted).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn labels_tell_marks_apart() {
        assert_eq!(labels((-0.1, 1.1), false, 6), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels((0.0, 3.1e-16), false, 3), ["0", "2·10⁻¹⁶"]);
        assert_eq!(labels((-2e6, 2.1e6), false, 4), ["−2·10⁶", "0", "2·10⁶"]);
        assert_eq!(labels((-4.2, 1.1), true, 6), ["10⁻⁴", "0.001", "0.01", "0.1", "1", "10"]);
        assert_eq!(labels((-5.1, -4.2), true, 6), ["10⁻⁵", "2·10⁻⁵", "5·10⁻⁵"]);
        let named = Axis { names: ["a-b", "c", "d"].map(str::to_owned).to_vec(), ..Axis::linear("") };
        let places = ticks((-0.5, 1.5), &named, 6).into_iter().map(|tick| (tick.place, tick.label));
        assert_eq!(places.collect::<Vec<_>>(), [(0.0, "a-b".to_owned()), (1.0, "c".to_owned())]);
    }
}
