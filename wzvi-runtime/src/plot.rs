//! Plots: figures as data, drawn as SVG and PNG without a font or a display on the machine (feature `plot`).
//!
//! ```ignore
//! let path = kubo.simulate::<Midpoint>(0.02)./* ... */run()?;
//! path.plot().phase_portrait().write("portrait.svg")?;
//! path.plot().energy_drift(&kubo).write("drift.png")?;
//! ```
//!
//! [`Trajectory::plot`](crate::trajectory::Trajectory::plot) makes the figures that a path is looked at with; a [`Figure`] of your own takes any points, and a [`Sheet`] puts
//! several into one file. Colours are those of Okabe and Ito, which every kind of colour vision tells apart.

mod axes;
mod drawing;
mod error;
mod figure;
mod layout;
mod path;
mod sheet;
mod ticks;

#[cfg(feature = "report")]
pub(crate) use drawing::Plot;
pub use error::PlotError;
pub use figure::{Axis, Colour, Figure, Look, Series};
#[cfg(feature = "report")]
pub(crate) use layout::Layout;
pub use path::PathPlot;
pub use sheet::Sheet;

/// A number with three significant digits, for people.
pub fn number(value: f64) -> String {
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
