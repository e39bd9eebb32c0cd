//! A figure as data: what is drawn, what it shows, the numbers behind it.

use crate::persist::table::Cell::{Number, Text};
use crate::persist::table::{NUMBER, TEXT, Table};

/// One axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What is along it, with its unit.
    pub label: String,
    /// Whether its scale is logarithmic; then only positive values are drawn.
    pub logarithmic: bool,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), logarithmic: false }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { label: label.into(), logarithmic: true }
    }

    /// Where a value is along the axis, before scaling; `None` if it is nowhere.
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
}

/// Points with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// How it is drawn.
    pub look: Look,
    /// Its colour in the palette; series of one colour belong together.
    pub colour: usize,
    /// `(x, y)`.
    pub points: Vec<(f64, f64)>,
    /// What is said about each point besides its numbers; may be shorter.
    pub notes: Vec<String>,
}

impl Series {
    /// A series without notes.
    pub fn new(name: impl Into<String>, look: Look, colour: usize, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), look, colour, points, notes: vec![] }
    }

    /// Whether its points have marks.
    pub(crate) fn marked(&self) -> bool {
        matches!(self.look, Look::Marks | Look::Joined)
    }
}

/// A plot with its sentence.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Names its files: letters, digits and hyphens.
    pub id: String,
    /// Its heading.
    pub title: String,
    /// What it shows, in sentences.
    pub shows: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn, the first at the bottom.
    pub series: Vec<Series>,
}

impl Figure {
    /// An empty figure.
    pub fn new(id: impl Into<String>, title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self { id: id.into(), title: title.into(), shows: String::new(), x, y, series: vec![] }
    }

    /// Says what it shows.
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
        (headings, rows.collect())
    }

    /// The same as CSV.
    pub fn csv(&self) -> Vec<u8> {
        let columns =
            [("series", TEXT), (self.x.label.as_str(), NUMBER), (&self.y.label, NUMBER), ("note", TEXT)];
        let mut table = Table::new(self.id.as_str(), columns, []);
        for series in &self.series {
            for (index, &(x, y)) in series.points.iter().enumerate() {
                let note = series.notes.get(index).map_or("", String::as_str);
                table.row([Text(&series.name), Number(x), Number(y), Text(note)]);
            }
        }
        table.csv()
    }
}
