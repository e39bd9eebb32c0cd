//! Statistics as tables, and the tables as text.

use std::fmt::{self, Write as _};
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::histogram::Histogram;
use super::statistics::{Node, PathFailure, Statistics};

/// What the table of quantiles has.
const FRACTIONS: [f64; 11] = [0.0, 0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999, 1.0];

/// Columns of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    name: &'static str,
    columns: Vec<(String, Column)>,
}

/// Entries of one type.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Real numbers; NaN for none.
    Number(Vec<f64>),
    /// Counts and numbers of things.
    Count(Vec<u64>),
    /// Names and explanations.
    Text(Vec<String>),
}

/// A file that could not be written.
#[derive(Debug)]
pub struct FileError {
    /// Which.
    pub path: PathBuf,
    /// Why.
    pub cause: io::Error,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot write {}: {}", self.path.display(), self.cause)
    }
}

impl std::error::Error for FileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.cause)
    }
}

impl Column {
    fn len(&self) -> usize {
        match self {
            Self::Number(entries) => entries.len(),
            Self::Count(entries) => entries.len(),
            Self::Text(entries) => entries.len(),
        }
    }
}

impl Table {
    /// What the rows are about: the name of its file.
    pub fn name(&self) -> &str {
        self.name
    }

    /// The columns with their names, from left to right.
    pub fn columns(&self) -> &[(String, Column)] {
        &self.columns
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.len())
    }

    /// Comma-separated values as in RFC 4180, with the names in the first line. Numbers come back to the last bit; those that
    /// are none or infinite are `NaN`, `inf` and `-inf`.
    ///
    /// # Errors
    /// Those of `to`.
    pub fn write_csv(&self, to: &mut impl Write) -> io::Result<()> {
        let mut line = String::new();
        for (i, (name, _)) in self.columns.iter().enumerate() {
            separate(&mut line, i);
            quote(&mut line, name);
        }
        writeln!(to, "{line}")?;
        for row in 0..self.rows() {
            line.clear();
            for (i, (_, column)) in self.columns.iter().enumerate() {
                separate(&mut line, i);
                match column {
                    // Writing to a string cannot fail.
                    Column::Number(entries) => drop(write!(line, "{:?}", entries[row])),
                    Column::Count(entries) => drop(write!(line, "{}", entries[row])),
                    Column::Text(entries) => quote(&mut line, &entries[row]),
                }
            }
            writeln!(to, "{line}")?;
        }
        Ok(())
    }

    /// `{"column":[entries], ...}`; numbers come back to the last bit, but JSON has `null` for those that are none or
    /// infinite.
    fn write_json(&self, to: &mut impl Write) -> io::Result<()> {
        for (i, (name, column)) in self.columns.iter().enumerate() {
            write!(to, "{}{}:[", if i == 0 { "{" } else { "," }, escaped(name))?;
            for row in 0..column.len() {
                let comma = if row == 0 { "" } else { "," };
                match column {
                    Column::Number(entries) if entries[row].is_finite() => {
                        write!(to, "{comma}{:?}", entries[row])?;
                    }
                    Column::Number(_) => write!(to, "{comma}null")?,
                    Column::Count(entries) => write!(to, "{comma}{}", entries[row])?,
                    Column::Text(entries) => write!(to, "{comma}{}", escaped(&entries[row]))?,
                }
            }
            write!(to, "]")?;
        }
        write!(to, "}}")
    }
}

fn separate(line: &mut String, column: usize) {
    if column > 0 {
        line.push(',');
    }
}

fn quote(line: &mut String, text: &str) {
    if text.contains(['"', ',', '\n', '\r']) {
        line.push('"');
        line.push_str(&text.replace('"', "\"\""));
        line.push('"');
    } else {
        line.push_str(text);
    }
}

fn escaped(text: &str) -> String {
    let mut json = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => json.extend(['\\', c]),
            c if c < ' ' => drop(write!(json, "\\u{:04x}", u32::from(c))),
            c => json.push(c),
        }
    }
    json.push('"');
    json
}

/// Writes a file that appears complete or not at all.
pub(super) fn whole_file(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<fs::File>) -> io::Result<()>,
) -> Result<(), FileError> {
    let part = path.with_extension("part");
    let attempt = || {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut file = BufWriter::new(fs::File::create(&part)?);
        write(&mut file)?;
        file.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
        fs::rename(&part, path)
    };
    attempt().map_err(|cause| {
        // Nothing more can be done about a part that stays.
        drop(fs::remove_file(&part));
        FileError { path: path.into(), cause }
    })
}

impl Statistics {
    /// One file `<table>.csv` for each of [`Statistics::tables`] in a folder, which is made if it is not there.
    ///
    /// # Errors
    /// [`FileError`] for the first file that cannot be written.
    pub fn write_csv(&self, folder: impl AsRef<Path>) -> Result<(), FileError> {
        for table in self.tables() {
            let path = folder.as_ref().join(table.name).with_extension("csv");
            whole_file(&path, |file| table.write_csv(file))?;
        }
        Ok(())
    }

    /// One file with an object of all [`Statistics::tables`]: `{"moments":{"time":[0.0, ...], ...}, ...}`. Numbers that are
    /// none or infinite are `null`.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    pub fn write_json(&self, path: impl AsRef<Path>) -> Result<(), FileError> {
        whole_file(path.as_ref(), |file| {
            for (i, table) in self.tables().iter().enumerate() {
                write!(file, "{}{}:", if i == 0 { "{" } else { "," }, escaped(table.name))?;
                table.write_json(file)?;
            }
            writeln!(file, "}}")
        })
    }

    /// All that is known, as tables, for files and data frames.
    ///
    /// | table | one row for each | columns |
    /// |---|---|---|
    /// | `moments` | time, observable | `count`, `mean`, `standard_error`, `variance` |
    /// | `covariances` | time, pair of observables | `covariance` |
    /// | `quantiles` | time, observable, fraction | `quantile` |
    /// | `histograms` | time, observable, bin | `lower`, `upper`, `count`, `density` |
    /// | `passages` | event | `passed`, `censored`, `lost`, `mean`, `standard_error`, `rate`, `rate_error` |
    /// | `passage_times` | event, bin | `lower`, `upper`, `count`, `density` |
    /// | `failures` | path that failed | `step`, `time`, `cause` |
    /// | `paths` | path, time | each observable |
    ///
    /// A table that has nothing to say is not there. Histograms have a bin below the first one that begins at minus
    /// infinity, one above the last, and one without edges for what is not a number; their density is not a number.
    pub fn tables(&self) -> Vec<Table> {
        let mut tables = vec![self.moments(), self.covariances()];
        let all = [
            self.quantiles(),
            self.histograms(),
            self.passage_counts(),
            self.passage_times(),
            self.failure_list(),
            self.kept_paths(),
        ];
        tables.extend(all.into_iter().filter(|table| table.rows() > 0));
        tables
    }

    /// Every node with every observable.
    fn each(&self) -> impl Iterator<Item = (&Node, usize, &String)> {
        self.nodes().iter().flat_map(|node| {
            self.observables().iter().enumerate().map(move |(index, name)| (node, index, name))
        })
    }

    fn moments(&self) -> Table {
        let mut table = Table::new(
            "moments",
            [("time", NUMBER), ("observable", TEXT), ("count", COUNT)],
            ["mean", "standard_error", "variance"],
        );
        for (node, index, name) in self.each() {
            table.row([
                Number(node.time()),
                Text(name),
                Count(node.count()),
                Number(node.mean(index)),
                Number(node.standard_error(index)),
                Number(node.variance(index)),
            ]);
        }
        table
    }

    fn covariances(&self) -> Table {
        let columns = [("time", NUMBER), ("first", TEXT), ("second", TEXT)];
        let mut table = Table::new("covariances", columns, ["covariance"]);
        for (node, a, first) in self.each() {
            for (b, second) in self.observables().iter().enumerate().skip(a) {
                let covariance = node.covariance(a, b);
                table.row([Number(node.time()), Text(first), Text(second), Number(covariance)]);
            }
        }
        table
    }

    fn quantiles(&self) -> Table {
        let columns = [("time", NUMBER), ("observable", TEXT)];
        let mut table = Table::new("quantiles", columns, ["fraction", "quantile"]);
        for (node, index, name) in self.each() {
            let Some(quantiles) = node.quantiles(index) else { continue };
            for fraction in FRACTIONS {
                let quantile = quantiles.at(fraction);
                table.row([Number(node.time()), Text(name), Number(fraction), Number(quantile)]);
            }
        }
        table
    }

    fn histograms(&self) -> Table {
        let columns = [("time", NUMBER), ("observable", TEXT), ("count", COUNT)];
        let mut table = Table::new("histograms", columns, ["lower", "upper", "density"]);
        for node in self.nodes() {
            for (histogram, &observable) in node.histograms().iter().zip(self.histogrammed()) {
                let name = &self.observables()[observable];
                for Bin { lower, upper, count, density } in bins(histogram) {
                    let ends = [Number(lower), Number(upper), Number(density)];
                    table.row([Number(node.time()), Text(name), Count(count)].into_iter().chain(ends));
                }
            }
        }
        table
    }

    fn passage_counts(&self) -> Table {
        let columns = [("event", TEXT), ("passed", COUNT), ("censored", COUNT), ("lost", COUNT)];
        let mut table = Table::new("passages", columns, ["mean", "standard_error", "rate", "rate_error"]);
        for passages in self.passages() {
            table.row([
                Text(passages.name()),
                Count(passages.passed()),
                Count(passages.censored()),
                Count(passages.lost()),
                Number(passages.mean()),
                Number(passages.standard_error()),
                Number(passages.rate()),
                Number(passages.rate_error()),
            ]);
        }
        table
    }

    fn passage_times(&self) -> Table {
        let columns = [("event", TEXT), ("count", COUNT)];
        let mut table = Table::new("passage_times", columns, ["lower", "upper", "density"]);
        for passages in self.passages() {
            for Bin { lower, upper, count, density } in bins(passages.histogram()) {
                let ends = [Number(lower), Number(upper), Number(density)];
                table.row([Text(passages.name()), Count(count)].into_iter().chain(ends));
            }
        }
        table
    }

    fn failure_list(&self) -> Table {
        let columns = [("path", COUNT), ("step", COUNT), ("time", NUMBER), ("cause", TEXT)];
        let mut table = Table::new("failures", columns, []);
        for PathFailure { path, error } in self.failures() {
            let cause = error.cause.to_string();
            table.row([Count(*path), Count(error.step), Number(error.t), Text(&cause)]);
        }
        table
    }

    fn kept_paths(&self) -> Table {
        let names = self.observables().iter().map(String::as_str);
        let mut table = Table::new("paths", [("path", COUNT), ("time", NUMBER)], names);
        let Some(paths) = self.paths() else { return table };
        for path in 0..paths.count() {
            for (number, node) in self.nodes().iter().enumerate() {
                let values = paths.at(path, number).unwrap_or_default().iter();
                let values = values.map(|&value| Number(value));
                table.row([Count(path as u64), Number(node.time())].into_iter().chain(values));
            }
        }
        table
    }
}

struct Bin {
    lower: f64,
    upper: f64,
    count: u64,
    density: f64,
}

/// All bins, also those for what is below, above, and no number.
fn bins(histogram: &Histogram) -> impl Iterator<Item = Bin> {
    let last = histogram.counts().len();
    let outside = |lower, upper, count| Bin { lower, upper, count, density: f64::NAN };
    let inside = histogram.counts().iter().enumerate().map(|(bin, &count)| Bin {
        lower: histogram.edge(bin),
        upper: histogram.edge(bin + 1),
        count,
        density: histogram.density(bin),
    });
    let below = outside(f64::NEG_INFINITY, histogram.edge(0), histogram.below());
    let above = outside(histogram.edge(last), f64::INFINITY, histogram.above());
    let undefined = outside(f64::NAN, f64::NAN, histogram.undefined());
    std::iter::once(below).chain(inside).chain([above, undefined])
}

/// An entry of a row.
pub(super) enum Cell<'a> {
    Number(f64),
    Count(u64),
    Text(&'a str),
}
use Cell::{Count, Number, Text};

const NUMBER: Column = Column::Number(Vec::new());
const COUNT: Column = Column::Count(Vec::new());
const TEXT: Column = Column::Text(Vec::new());

impl Table {
    /// Without rows: columns of given types, and columns of numbers.
    pub(super) fn new<'n>(
        name: &'static str,
        columns: impl IntoIterator<Item = (&'n str, Column)>,
        numbers: impl IntoIterator<Item = &'n str>,
    ) -> Self {
        let columns = columns.into_iter().chain(numbers.into_iter().map(|name| (name, NUMBER)));
        Self { name, columns: columns.map(|(name, column)| (name.to_owned(), column)).collect() }
    }

    /// One more row, whose entries have the types of the columns.
    pub(super) fn row<'a>(&mut self, cells: impl IntoIterator<Item = Cell<'a>>) {
        for ((_, column), cell) in self.columns.iter_mut().zip(cells) {
            match (column, cell) {
                (Column::Number(entries), Number(entry)) => entries.push(entry),
                (Column::Count(entries), Count(entry)) => entries.push(entry),
                (Column::Text(entries), Text(entry)) => entries.push(entry.to_owned()),
                (Column::Number(_) | Column::Count(_) | Column::Text(_), _) => {
                    debug_assert!(false, "the types of the table `{}`", self.name);
                }
            }
        }
    }
}
