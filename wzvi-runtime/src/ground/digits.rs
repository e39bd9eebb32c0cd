//! Numbers as people read them.

use std::fmt;

/// A number to its last digit, with a power of ten where it would have many zeros.
pub(crate) struct ShortestDecimal(pub(crate) f64);

impl fmt::Display for ShortestDecimal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        // As `Debug` of numbers, but for a whole number's `.0`.
        if size == 0.0 || !size.is_finite() || (1e-5..1e16).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// A time or a size that was computed: by 15 digits where these are within two roundings of it, as 0.9 for
/// `3.0 * 0.3`.
pub(crate) fn computed(x: f64) -> ShortestDecimal {
    let short = format!("{x:.14e}").parse().unwrap_or(x);
    ShortestDecimal(if (short - x).abs() <= 2.0 * f64::EPSILON * x.abs() { short } else { x })
}

/// Digits of a number that are written one by one up to the first uncertain one.
const MOST_DIGITS: i32 = 10;

/// A number with three significant digits, for people.
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-4..1e5).contains(&size) {
        let text = format!("{value:.2e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{mantissa}·{}", power_of_ten(exponent.parse().unwrap_or(0)));
    }
    // Rounding first: 0.99996 has as many decimals as 1.
    let exponent = format!("{size:.2e}").split_once('e').and_then(|parts| parts.1.parse::<i32>().ok());
    let decimals = (2 - exponent.unwrap_or(0)).max(0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// `10⁻³`
pub(crate) fn power_of_ten(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised =
        |letter: char| letter.to_digit(10).and_then(|digit| DIGITS.get(digit as usize)).unwrap_or(&'⁻');
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}

/// `value ± uncertainty` to the first digit of the uncertainty, with one power of ten for both where they are
/// large or small; a dash for none.
#[expect(clippy::disallowed_methods, reason = "a power of ten for a text")]
pub(crate) fn estimate(value: f64, uncertainty: f64) -> String {
    if value.is_nan() {
        return "-".to_owned();
    }
    // By their texts, which are rounded: 0.096 is 0.1 to one digit.
    let exponent =
        |text: String| text.split_once('e').and_then(|parts| parts.1.parse::<i32>().ok()).unwrap_or(0);
    let last = exponent(format!("{uncertainty:.0e}"));
    let size = exponent(format!("{:.2e}", value.abs().max(uncertainty)));
    if uncertainty == 0.0 || !uncertainty.is_finite() || !value.is_finite() {
        return number(value);
    }
    if size - last >= MOST_DIGITS {
        return format!("{value} ± {}", number(uncertainty));
    }
    let power = if (-3..5).contains(&size) { 0 } else { size };
    let unit = 10f64.powi(power);
    let decimals = usize::try_from(power - last).unwrap_or(0);
    let text = format!("{:.decimals$} ± {:.decimals$}", value / unit, uncertainty / unit);
    if power == 0 { text } else { format!("({text})·{}", power_of_ten(power)) }
}

#[cfg(all(test, feature = "ensemble"))]
mod tests {
    use super::{computed, estimate, number};

    #[test]
    fn a_computed_number_has_no_digits_of_its_rounding() {
        let texts =
            [0.3 * 3.0, 0.1 * 3.0, 1.0 / 3.0, -7.0 * 0.1, 0.0, 1e20 / 3.0].map(|x| computed(x).to_string());
        assert_eq!(texts, ["0.9", "0.3", "0.3333333333333333", "-0.7", "0", "3.333333333333333e19"]);
    }

    #[test]
    fn an_estimate_has_the_digits_that_are_known() {
        assert_eq!(estimate(0.0167, 0.0005), "0.0167 ± 0.0005");
        assert_eq!(estimate(9.7312e-4, 3.4e-5), "(9.7 ± 0.3)·10⁻⁴");
        assert_eq!(estimate(-1.2e-7, 0.96e-7), "(-1 ± 1)·10⁻⁷");
        assert_eq!(estimate(1234.5, 12.0), "1234 ± 12");
        assert_eq!(estimate(3e-9, 0.02), "0.00 ± 0.02");
        assert_eq!(estimate(2.5e8, 3e6), "(2.50 ± 0.03)·10⁸");
        assert_eq!(estimate(1.0, 7e-17), "1 ± 7.00·10⁻¹⁷");
        assert_eq!((estimate(0.25, 0.0), estimate(f64::NAN, 0.1)), ("0.25".into(), "-".into()));
    }

    #[test]
    fn a_number_has_three_digits() {
        let texts = [0.99996, 12345.6, 2e-5, -3.14159e7, 0.0, f64::INFINITY].map(number);
        assert_eq!(texts, ["1", "12346", "2.00·10⁻⁵", "-3.14·10⁷", "0", "inf"]);
    }
}
