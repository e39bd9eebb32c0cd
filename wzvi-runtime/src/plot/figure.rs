//! A figure as data: what is drawn, what it shows, the numbers behind it.
//!
//! Tested by `tests/paths/results.rs`.

use std::ops::Range;

use crate::saving::table::TableRows;

/// One axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Its label, with the unit.
    pub label: String,
    /// Whether the scale is logarithmic; then only positive values are drawn.
    pub logarithmic: bool,
    /// Its limits; `None` for all points and a margin.
    pub range: Option<(f64, f64)>,
    /// Names at 0, 1, 2, ... instead of numbers; empty for an axis of numbers.
    pub names: Vec<String>,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), logarithmic: false, range: None, names: vec![] }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { logarithmic: true, ..Self::linear(label) }
    }

    /// The places of the limits of a range, if it is one.
    pub(crate) fn places(&self, from: f64, to: f64) -> Option<(f64, f64)> {
        let places = (self.place(from)?, self.place(to)?);
        (places.0 < places.1).then_some(places)
    }

    /// The place of a value along the axis, before scaling; `None` if it has none.
    pub(crate) fn place(&self, value: f64) -> Option<f64> {
        let place = if self.logarithmic { value.log10() } else { value };
        place.is_finite().then_some(place)
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Marks, each with its numbers.
    Marks,
    /// Marks joined by a line.
    Joined,
    /// A line.
    Line,
    /// A dashed line: a prediction, a fit, a limit.
    Dashed,
    /// A broad line, to lie under others.
    Broad,
    /// Points.
    Dots,
    /// Small points, of which there may be many.
    FineDots,
}

/// Colours by number; further numbers begin anew.
#[derive(Clone, Copy, Debug)]
pub enum Colour {}

impl Colour {
    /// Blue.
    pub const BLUE: usize = 0;
    /// Red of cinnabar.
    pub const VERMILION: usize = 1;
    /// Green.
    pub const GREEN: usize = 2;
    /// Reddish purple.
    pub const PURPLE: usize = 3;
    /// Dark yellow.
    pub const OCHRE: usize = 4;
    /// Violet.
    pub const VIOLET: usize = 5;
    /// Grey.
    pub const GREY: usize = 6;
    /// The colour of axes and text.
    pub const INK: usize = usize::MAX;
}

/// Points with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// The look of the points.
    pub look: Look,
    /// The number of the colour in the palette; series of one colour belong together.
    pub colour: usize,
    /// `(x, y)`.
    pub points: Vec<(f64, f64)>,
    /// A note for each point; the list may be shorter.
    pub notes: Vec<String>,
}

impl Series {
    /// A series without notes.
    pub fn new(name: impl Into<String>, look: Look, colour: usize, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), look, colour, points, notes: vec![] }
    }

    /// Whether the points have marks with numbers.
    pub(crate) fn marked(&self) -> bool {
        matches!(self.look, Look::Marks | Look::Joined)
    }

    /// Whether the series is nothing but a line.
    pub(crate) fn joined(&self) -> bool {
        matches!(self.look, Look::Line | Look::Dashed | Look::Broad)
    }
}

/// Values over the plane as colours, with a bar beside the axes that tells them.
#[derive(Clone, Debug, PartialEq)]
pub struct Shades {
    /// The label of the bar.
    pub label: String,
    /// The values at the ends of the bar; values beyond have the colours of the ends.
    pub range: (f64, f64),
    /// Width and height of the cell around each point, in the units of the axes.
    pub cell: (f64, f64),
    /// `(x, y, value)`; where the value is NaN nothing is drawn.
    pub points: Vec<(f64, f64, f64)>,
}

/// A plot with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The name of the files of the figure: letters, digits and hyphens.
    pub id: String,
    /// Its heading.
    pub title: String,
    /// The caption, in sentences.
    pub shows: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Colours below everything else.
    pub shades: Option<Box<Shades>>,
    /// The lines and points, the first at the bottom.
    pub series: Vec<Series>,
    /// Whether both axes have the same scale.
    pub has_equal_axes: bool,
}

impl Figure {
    /// An empty figure.
    pub fn new(id: impl Into<String>, title: impl Into<String>, x: Axis, y: Axis) -> Self {
        let (id, title) = (id.into(), title.into());
        Self { id, title, shows: String::new(), x, y, shades: None, series: vec![], has_equal_axes: false }
    }

    /// An empty figure with linear axes, for a [`Sheet`](super::Sheet). Labels carry the unit:
    /// `"time t [1/ω]"`.
    pub fn panel(title: impl Into<String>, x: impl Into<String>, y: impl Into<String>) -> Self {
        Self::new("", title, Axis::linear(x), Axis::linear(y))
    }

    /// Sets the caption.
    #[must_use]
    pub fn shows(mut self, sentence: impl Into<String>) -> Self {
        self.shows = sentence.into();
        self
    }

    /// Adds a series.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Puts colours below everything else.
    #[must_use]
    pub fn shaded(mut self, shades: Shades) -> Self {
        self.shades = Some(Box::new(shades));
        self
    }

    /// With logarithmic axes.
    #[must_use]
    pub fn log_log(mut self) -> Self {
        (self.x.logarithmic, self.y.logarithmic) = (true, true);
        self
    }

    /// With a logarithmic vertical axis.
    #[must_use]
    pub fn log_y(mut self) -> Self {
        self.y.logarithmic = true;
        self
    }

    /// Puts names at 0, 1, 2, ... of the vertical axis instead of numbers.
    #[must_use]
    pub fn y_names(mut self, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.y.names = names.into_iter().map(Into::into).collect();
        self
    }

    /// Gives both axes the same scale.
    #[must_use]
    pub fn equal_axes(mut self) -> Self {
        self.has_equal_axes = true;
        self
    }

    /// Sets the limits of the horizontal axis; lines are interrupted where they leave it. Limits that are no
    /// range are an error when the figure is drawn ([`PlotError::Range`](crate::plot::PlotError::Range)).
    #[must_use]
    pub fn x_range(mut self, range: Range<f64>) -> Self {
        self.x.range = Some((range.start, range.end));
        self
    }

    /// Sets the limits of the vertical axis, as [`Figure::x_range`] those of the horizontal one.
    #[must_use]
    pub fn y_range(mut self, range: Range<f64>) -> Self {
        self.y.range = Some((range.start, range.end));
        self
    }

    /// Adds points by name and colour; without a name they are not in the legend.
    #[must_use]
    pub fn points(
        self,
        look: Look,
        name: impl Into<String>,
        colour: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.with(Series::new(name, look, colour, points.into_iter().collect()))
    }

    /// Adds a line.
    #[must_use]
    pub fn line(
        self,
        name: impl Into<String>,
        colour: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.points(Look::Line, name, colour, points)
    }

    /// Adds the dashed line `y = c x^order` between two abscissae: a straight one where both axes are
    /// logarithmic.
    #[must_use]
    pub fn slope(self, name: impl Into<String>, order: f64, c: f64, ends: [f64; 2]) -> Self {
        self.points(Look::Dashed, name, Colour::GREY, ends.map(|x| (x, c * x.powf(order))))
    }

    /// Headings and rows of the numbers behind it.
    pub fn table(&self) -> (Vec<String>, Vec<Vec<String>>) {
        let headings =
            vec!["series".to_owned(), self.x.label.clone(), self.y.label.clone(), "note".to_owned()];
        let row = |series: &Series, index: usize, (x, y): (f64, f64)| {
            let note = series.notes.get(index).cloned().unwrap_or_default();
            vec![series.name.clone(), x.to_string(), y.to_string(), note]
        };
        let rows = self.series.iter().flat_map(|series| {
            series.points.iter().enumerate().map(move |(index, point)| row(series, index, *point))
        });
        let shaded = self.shades.iter().flat_map(|shades| {
            let row = |(x, y, value): &(f64, f64, f64)| {
                vec![shades.label.clone(), x.to_string(), y.to_string(), value.to_string()]
            };
            shades.points.iter().map(row)
        });
        (headings, rows.chain(shaded).collect())
    }

    /// The points as CSV.
    pub fn csv(&self) -> Vec<u8> {
        let rows = self.series.iter().flat_map(|series| {
            let note = |index: usize| series.notes.get(index).cloned().unwrap_or_default();
            let points = series.points.iter().enumerate();
            points.map(move |(index, (x, y))| (series.name.clone(), *x, *y, note(index)))
        });
        let shaded = self.shades.iter().flat_map(|shades| {
            shades.points.iter().map(|(x, y, value)| (shades.label.clone(), *x, *y, format!("{value:?}")))
        });
        TableRows::of(rows.chain(shaded))
            .column("series", |(name, ..)| name.clone())
            .column(&self.x.label, |(_, x, ..)| *x)
            .column(&self.y.label, |(_, _, y, _)| *y)
            .column("note", |(.., note)| note.clone())
            .table(&self.id)
            .csv()
    }
}
