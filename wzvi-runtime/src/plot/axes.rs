//! The ranges of the axes of a figure.

use super::figure::{Axis, Figure};
use super::layout::Layout;

/// The ranges that the axes of a figure show, as places before scaling: from, to.
pub(super) fn ranges(figure: &Figure, layout: &Layout) -> [(f64, f64); 2] {
    let both = || {
        let points = figure.series.iter().flat_map(|series| &series.points).copied();
        let corners = figure.shades.iter().flat_map(|shades| {
            let [w, h] = [0.5 * shades.cell.0, 0.5 * shades.cell.1];
            shades.points.iter().flat_map(move |(x, y, _)| [(x - w, y - h), (x + w, y + h)])
        });
        points.chain(corners).filter_map(|(x, y)| Some([figure.x.place(x)?, figure.y.place(y)?]))
    };
    let x = range(&figure.x, &mut both().map(|[x, _]| x));
    let y = range(&figure.y, &mut both().map(|[_, y]| y));
    if figure.has_equal_axes { equal([x, y], layout) } else { [x, y] }
}

fn range(axis: &Axis, places: &mut dyn Iterator<Item = f64>) -> (f64, f64) {
    if let Some((from, to)) = axis.range
        && let Some(places) = axis.places(from, to)
    {
        return places;
    }
    let (low, high) = places
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), place| (low.min(place), high.max(place)));
    if low > high {
        return (0.0, 1.0);
    }
    let size = low.abs().max(high.abs());
    // A range at rounding level counts as empty.
    let pad = match high - low > 1e-12 * size {
        true => 0.05 * (high - low),
        false if axis.logarithmic || size == 0.0 => 0.5,
        false => 0.5 * size,
    };
    (low - pad, high + pad)
}

/// Both ranges, widened until one unit is as long up as across.
fn equal(ranges: [(f64, f64); 2], layout: &Layout) -> [(f64, f64); 2] {
    let lengths = layout.lengths();
    let units = [0, 1].map(|axis| (ranges[axis].1 - ranges[axis].0) / lengths[axis]);
    let unit = units[0].max(units[1]);
    [0, 1].map(|axis| {
        let (middle, half) = (0.5 * (ranges[axis].0 + ranges[axis].1), 0.5 * unit * lengths[axis]);
        (middle - half, middle + half)
    })
}
