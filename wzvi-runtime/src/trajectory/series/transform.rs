//! Power spectra by Fourier transforms, and sums of lagged products from them.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// `|Σ_i x_i e^{-iωt}|²`, added up over series of the same length, at the `P` frequencies `2π k/P`: padded
/// with as many zeros or more, so that no lagged product wraps.
pub(super) fn spectrum<'s>(series: impl IntoIterator<Item = &'s [f64]>, length: usize) -> Vec<f64> {
    let padded = (2 * length).next_power_of_two();
    let zero = Complex::new(0.0, 0.0);
    let forward = FftPlanner::<f64>::new().plan_fft_forward(padded);
    let (mut buffer, mut power) = (vec![zero; padded], vec![0.0; padded]);
    for series in series {
        buffer.fill(zero);
        buffer.iter_mut().zip(series).for_each(|(to, &x)| to.re = x);
        forward.process(&mut buffer);
        power.iter_mut().zip(&buffer).for_each(|(sum, z)| *sum += z.norm_sqr());
    }
    power
}

/// `Σ_i x_i x_{i+t}` for `t` from 0 to `N - 1`, added up over series, from their [`spectrum`].
pub(super) fn lagged_products(spectrum: &[f64], length: usize) -> Vec<f64> {
    let mut buffer: Vec<_> = spectrum.iter().map(|&power| Complex::new(power, 0.0)).collect();
    FftPlanner::<f64>::new().plan_fft_inverse(spectrum.len()).process(&mut buffer);
    buffer.iter().take(length).map(|z| z.re / spectrum.len() as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::{lagged_products, spectrum};

    #[test]
    fn they_are_the_sums() {
        let series = [[1.0, -2.0, 3.5, 0.25, 7.0], [0.5, 0.5, -1.0, 2.0, 0.0]];
        let products = lagged_products(&spectrum(series.iter().map(|list| &list[..]), 5), 5);
        for (lag, product) in products.iter().enumerate() {
            let sum: f64 = series.iter().map(|x| (0..5 - lag).map(|i| x[i] * x[i + lag]).sum::<f64>()).sum();
            // Rounding of sums of the size of the squares.
            assert!((product - sum).abs() < 100.0 * 16.0 * f64::EPSILON, "{lag}");
        }
    }
}
