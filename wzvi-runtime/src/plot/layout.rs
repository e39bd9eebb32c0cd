//! Where the parts of a drawing are: axes, title, legend. All in units of a drawing of scale 1.

use super::figure::{Figure, Series};

/// Letters of the legend are about so wide, pixels for a letter.
const LETTER: f64 = 7.6;
/// Length of the line beside a name.
pub(super) const KEY: i32 = 26;
/// From the start of a key to its name.
pub(super) const INDENT: i32 = 36;
/// Between the lines of a name, and between the rows of a legend.
const LINE: i32 = 17;
const ROW: i32 = 24;

/// A name in the legend.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// The number of the series.
    pub(super) series: usize,
    /// The middle of the left end of its line.
    pub(super) at: (i32, i32),
    pub(super) lines: Vec<String>,
}

/// Where the parts of a drawing are.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Width and height of the whole.
    pub(super) size: (i32, i32),
    /// Where the axes are: left, top, right, bottom.
    pub(super) frame: [i32; 4],
    /// Where the title begins, if it is drawn.
    pub(super) title: Option<(i32, i32)>,
    pub(super) legend: Vec<Entry>,
    /// About so many marks fit along each axis.
    pub(super) marks: [usize; 2],
}

impl Layout {
    /// For a page with room: the legend beside the axes.
    #[cfg(feature = "report")]
    pub(crate) fn wide(figure: &Figure) -> Self {
        let frame = [84, 16, 640, 402];
        let (left, mut y) = (frame[2] + 22, frame[1] + 10);
        let mut legend = Vec::new();
        for (series, entry) in named(figure) {
            let lines = wrapped(&entry.name, 25);
            let more = lines.len().saturating_sub(1) as i32;
            legend.push(Entry { series, at: (left, y), lines });
            y += ROW + LINE * more;
        }
        Self { size: (900, 460.max(y + ROW)), frame, title: None, legend, marks: [6, 6] }
    }

    /// For a page as narrow as a hand: the legend below the axes, one name in a row.
    #[cfg(feature = "report")]
    pub(crate) fn narrow(figure: &Figure) -> Self {
        let frame = [66, 12, 408, 300];
        let mut y = frame[3] + 74;
        let mut legend = Vec::new();
        for (series, entry) in named(figure) {
            let lines = wrapped(&entry.name, 46);
            let more = lines.len().saturating_sub(1) as i32;
            legend.push(Entry { series, at: (12, y), lines });
            y += ROW + LINE * more;
        }
        Self { size: (420, y), frame, title: None, legend, marks: [4, 5] }
    }

    /// One of several drawings of this size: the title on top, then the legend in rows, then the axes.
    pub(super) fn panel(figure: &Figure, (width, height): (i32, i32)) -> Self {
        const MARGIN: i32 = 10;
        let (mut x, mut y) = (MARGIN, 38);
        let mut legend = Vec::new();
        for (series, entry) in named(figure) {
            let length = INDENT + (entry.name.chars().count() as f64 * LETTER).ceil() as i32;
            if x > MARGIN && x + length > width {
                (x, y) = (MARGIN, y + ROW - 4);
            }
            legend.push(Entry { series, at: (x, y), lines: vec![entry.name.clone()] });
            x += length + 14;
        }
        let top = if legend.is_empty() { y - 4 } else { y + 20 };
        let frame = [70, top, width - 20, (height - 56).max(top + 20)];
        Self { size: (width, height), frame, title: Some((MARGIN, 8)), legend, marks: [8, 7] }
    }

    /// Pixels along the axes.
    pub(super) fn lengths(&self) -> [f64; 2] {
        let [left, top, right, bottom] = self.frame.map(f64::from);
        [right - left, bottom - top]
    }

    /// From one line of a name in the legend to the next.
    pub(super) const fn line() -> i32 {
        LINE
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

/// Text in lines of about so many characters, broken at spaces.
#[cfg(feature = "report")]
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![];
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
