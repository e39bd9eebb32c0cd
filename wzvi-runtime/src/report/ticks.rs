//! Where an axis has its marks.

/// One mark of an axis.
pub(crate) struct Tick {
    /// Along the axis; the decadic logarithm of the value if that is logarithmic.
    pub(crate) place: f64,
    pub(crate) label: String,
}

/// Marks within a range of places.
pub(crate) fn ticks((low, high): (f64, f64), logarithmic: bool) -> Vec<Tick> {
    if logarithmic { decades(low, high) } else { linear(low, high) }
}

/// Powers of ten; with 2 and 5 times those where there would be few.
fn decades(low: f64, high: f64) -> Vec<Tick> {
    let within = |place: &f64| (low..=high).contains(place);
    let powers = || low.floor() as i32..=high.ceil() as i32;
    let whole = powers().filter(|k| within(&f64::from(*k))).count();
    let stride = whole.div_ceil(9).max(1) as i32;
    let factors: &[f64] = if whole <= 2 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let mut marks = vec![];
    for k in powers().filter(|k| k.rem_euclid(stride) == 0) {
        for factor in factors {
            let place = f64::from(k) + factor.log10();
            if within(&place) {
                let value = factor * 10f64.powi(k);
                let label = if (-3..4).contains(&k) { super::number(value) } else { format!("{factor}e{k}") };
                marks.push(Tick { place, label });
            }
        }
    }
    marks
}

/// Multiples of 1, 2 or 5 times a power of ten, about six of them.
fn linear(low: f64, high: f64) -> Vec<Tick> {
    let rough = (high - low) / 6.0;
    let power = 10f64.powi(rough.log10().floor() as i32);
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= rough);
    let step = step.unwrap_or(rough);
    let decimals = (-(step.log10() + 1e-9).floor()).clamp(0.0, 17.0) as usize;
    let size = low.abs().max(high.abs());
    let label = |value: f64| match value {
        0.0 => "0".to_owned(),
        _ if !(1e-3..1e5).contains(&size) => format!("{value:.1e}"),
        _ => format!("{value:.decimals$}"),
    };
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last.min(first.saturating_add(20)))
        .map(|n| Tick { place: n as f64 * step, label: label(n as f64 * step) })
        .collect()
}
