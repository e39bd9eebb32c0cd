//! The places of the parts of a drawing: title, legend, axes. All in units of a drawing of scale 1.

use super::figure::{Figure, Series};

/// Letters of the legend are about so wide, pixels for a letter.
const LETTER: f64 = 7.6;
/// Length of the line beside a name.
pub(super) const KEY: i32 = 26;
/// Distance from the start of a key to its name.
pub(super) const INDENT: i32 = 36;
/// Between the rows of a legend.
const ROW: i32 = 20;
/// From the edge to the title and to the legend.
const MARGIN: i32 = 10;

/// From the frame to the bar of colours, which is as wide.
pub(super) const BAR: i32 = 14;

/// A name in the legend.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// The number of the series.
    pub(super) series: usize,
    /// The middle of the left end of its line.
    pub(super) at: (i32, i32),
}

/// The places of the parts of a drawing.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Width and height of the whole.
    pub(super) size: (i32, i32),
    /// The edges of the axes: left, top, right, bottom.
    pub(super) frame: [i32; 4],
    /// The start of the title, if it is drawn.
    pub(super) title: Option<(i32, i32)>,
    pub(super) legend: Vec<Entry>,
}

impl Layout {
    /// The title on top, then the legend in rows, then the axes.
    pub(super) fn titled(figure: &Figure, size: (i32, i32)) -> Self {
        Self::below(figure, size, 38, Some((MARGIN, 8)))
    }

    /// The layout for a page, which has the title above the drawing: a legend of several rows makes it
    /// higher.
    pub(crate) fn untitled(figure: &Figure, (width, height): (i32, i32)) -> Self {
        let top = 12;
        let rows = Self::below(figure, (width, height), top, None).frame[1] - top;
        Self::below(figure, (width, height + rows), top, None)
    }

    /// The legend and the axes below a height.
    fn below(figure: &Figure, (width, height): (i32, i32), top: i32, title: Option<(i32, i32)>) -> Self {
        let (mut x, mut y) = (MARGIN, top);
        let mut legend = Vec::new();
        for (series, entry) in named(figure) {
            let length = INDENT + (entry.name.chars().count() as f64 * LETTER).ceil() as i32;
            if x > MARGIN && x + length > width {
                (x, y) = (MARGIN, y + ROW);
            }
            legend.push(Entry { series, at: (x, y) });
            x += length + 14;
        }
        let top = if legend.is_empty() { y - 4 } else { y + ROW };
        let name = |name: &String| (name.chars().count() as f64 * LETTER).ceil() as i32 + 30;
        let left = figure.y.names.iter().map(name).max().unwrap_or(70);
        let left = left.min(width / 2).max(70);
        let beside = if figure.shades.is_some() { BAR + 84 } else { 20 };
        let frame = [left, top, (width - beside).max(left + 20), (height - 56).max(top + 20)];
        Self { size: (width, height), frame, title, legend }
    }

    /// Pixels along the axes.
    pub(super) fn lengths(&self) -> [f64; 2] {
        let [left, top, right, bottom] = self.frame.map(f64::from);
        [right - left, bottom - top]
    }

    /// About so many marks fit along each axis.
    pub(super) fn marks(&self) -> [usize; 2] {
        let [across, along] = self.lengths();
        [(across / 65.0) as usize, (along / 45.0) as usize].map(|marks| marks.clamp(2, 9))
    }
}

/// The series of the legend: those with a name, and of several with one name and one look the first.
fn named(figure: &Figure) -> impl Iterator<Item = (usize, &Series)> {
    let all = &figure.series;
    let is_new = move |number: usize, series: &Series| {
        !all.iter().take(number).any(|other| (&other.name, other.look) == (&series.name, series.look))
    };
    all.iter().enumerate().filter(move |(number, series)| !series.name.is_empty() && is_new(*number, series))
}
