//! Maps of chaos.
//!
//! Tested by `tests/ensembles/chaos.rs`.

use super::figure::{Figure, Shades};
use crate::algebra::state::Vector;
use crate::ensemble::ChaosMap;
use crate::error::UnknownName;

/// The mean of MEGNO from which a path is drawn as a chaotic one: regular ones have 2.
const CHAOTIC: f64 = 4.0;
/// The decimal logarithm of SALI below which a path is chaotic: rounding leaves -16.
const ALIGNED: f64 = -12.0;

/// Figures of a map of chaos: [`ChaosMap::plot`] begins them. Each method returns a [`Figure`] with a cell
/// for each start, in the plane of two variables by name.
#[derive(Clone, Copy, Debug)]
#[must_use = "nothing is drawn before `write`"]
pub struct ChaosMapPlot<'a, V> {
    map: &'a ChaosMap<V>,
}

impl<V: Vector> ChaosMap<V> {
    /// The map as figures.
    ///
    /// `map.plot().megno("y", "py")?.write("map.png")?` draws one.
    pub fn plot(&self) -> ChaosMapPlot<'_, V> {
        ChaosMapPlot { map: self }
    }
}

impl<V: Vector> ChaosMapPlot<'_, V> {
    /// The mean of MEGNO, from 0 to 4: near 2 in islands of regular motion, and at the end of the bar in the
    /// chaotic sea.
    ///
    /// # Errors
    /// [`UnknownName`] for a variable that is not there.
    pub fn megno(&self, x: &str, y: &str) -> Result<Figure, UnknownName> {
        self.shaded("mean MEGNO", (0.0, CHAOTIC), [x, y], &self.map.megno_mean)
    }

    /// The decimal logarithm of SALI, from -12 to 0: low in the chaotic sea.
    ///
    /// # Errors
    /// [`UnknownName`] for a variable that is not there.
    pub fn sali(&self, x: &str, y: &str) -> Result<Figure, UnknownName> {
        let logarithms: Vec<f64> = self.map.sali.iter().map(|sali| sali.log10()).collect();
        self.shaded("lg SALI", (ALIGNED, 0.0), [x, y], &logarithms)
    }

    fn shaded(
        &self,
        label: &str,
        range: (f64, f64),
        names: [&str; 2],
        values: &[f64],
    ) -> Result<Figure, UnknownName> {
        let [x, y] = [self.starts(names[0])?, self.starts(names[1])?];
        let cell = (width(&x), width(&y));
        let points = x.into_iter().zip(y).zip(values).map(|((x, y), value)| (x, y, *value)).collect();
        let title = format!("{label} to t = {}", super::number(self.map.time));
        let shades = Shades { label: label.to_owned(), range, cell, points };
        Ok(Figure::panel(title, names[0], names[1]).shaded(shades))
    }

    /// A variable at each start.
    fn starts(&self, name: &str) -> Result<Vec<f64>, UnknownName> {
        let (map, variables) = (self.map, self.map.variables);
        let degrees = map.starts.first().map_or(0, |start| start.q.components().len());
        let all = (0..2 * degrees).map(|place| match place.checked_sub(degrees) {
            None => (variables.q.name(place), place),
            Some(momentum) => (variables.p.name(momentum), place),
        });
        let place = UnknownName::find("variable", name, all)?;
        let of = |start: &crate::algebra::state::State<V>| match place.checked_sub(degrees) {
            None => start.q.components()[place],
            Some(momentum) => start.p.components()[momentum],
        };
        Ok(map.starts.iter().map(of).collect())
    }
}

/// The distance of neighbours: of a grid its spacing, else that of as many points in equal distances as there
/// are in a row of so many.
fn width(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else { return 1.0 };
    let extent = last - first;
    // Values of a grid are the same up to rounding.
    sorted.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * extent);
    let in_a_row = (values.len() as f64).sqrt();
    let number = (sorted.len() as f64).min(2.0 * in_a_row).max(2.0);
    if extent > 0.0 { extent / (number - 1.0) } else { 1.0 }
}
