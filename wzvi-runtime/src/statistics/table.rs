//! Statistics as tables, and the tables as files.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::crossings::{Crossings, PathCrossing};
use super::histogram::Histogram;
use super::origin::Origin;
use super::passage::Passage;
use super::run::{PathFailure, Statistics, StatisticsNode};
use crate::algebra::crossing::Direction;
use crate::error::FileError;
use crate::saving::file::{self, Staged};
use crate::saving::table::Cell::{Count, Number, Text};
use crate::saving::table::{COUNT, NUMBER, TEXT, Table, escaped};

/// What the table of quantiles has.
const FRACTIONS: [f64; 11] = [0.0, 0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999, 1.0];

impl Statistics {
    /// One file `<table>.csv` for each of [`Statistics::tables`] in a folder, which is made if it is not there.
    ///
    /// `run.csv` says that the set is complete: it goes before the first table is replaced and comes back after the last one, so that
    /// tables of two runs never lie beside a `run.csv`. Two programs that write into one folder at the same time need a folder each.
    ///
    /// # Errors
    /// [`FileError`] for the first file that cannot be written; unless that is in the middle of renaming, all files are as they were.
    pub fn write_csv(&self, folder: impl AsRef<Path>) -> Result<(), FileError> {
        self.write_tables(folder.as_ref(), "csv", |first, rest, file| first.write_csv_parts(rest, file))
    }

    /// One file with an object of all [`Statistics::tables`]: `{"run":{"system":["Kubo"], ...}, ...}`. Numbers that are
    /// none or infinite are `null`. The folder is made if it is not there.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    pub fn write_json(&self, path: impl AsRef<Path>) -> Result<(), FileError> {
        file::replace_in_folder(path.as_ref(), |file| {
            for i in 0..self.in_parts().len() {
                write!(file, "{}", if i == 0 { "{" } else { "," })?;
                write_json(|| self.in_parts().into_iter().nth(i).into_iter().flatten(), file)?;
            }
            writeln!(file, "}}")
        })
    }

    /// One file `<table>.parquet` for each of [`Statistics::tables`] in a folder, which is made if it is not there. Real
    /// numbers are `DOUBLE`, counts `INT64` without a sign, text is UTF-8; no column has nulls.
    ///
    /// `run.parquet` says that the set is complete, as `run.csv` does ([`Statistics::write_csv`]).
    ///
    /// # Errors
    /// Those of [`Statistics::write_csv`].
    #[cfg(feature = "columnar")]
    pub fn write_parquet(&self, folder: impl AsRef<Path>) -> Result<(), FileError> {
        self.write_tables(folder.as_ref(), "parquet", |first, rest, file| {
            first.write_parquet_parts(rest, file)
        })
    }

    /// All tables in files of one kind: all are on the disk before the first one is replaced.
    pub(crate) fn write_tables(
        &self,
        folder: &Path,
        extension: &str,
        write: impl Fn(&Table, Parts<'_>, &mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), FileError> {
        file::create_folder(folder)?;
        let stage = |mut parts: Parts<'_>| {
            let first = parts.next()?;
            let path = folder.join(first.name()).with_extension(extension);
            Some(Staged::write(&path, |file| write(&first, parts, file)))
        };
        // The first one is that of the run.
        let staged = self.in_parts().into_iter().filter_map(stage).collect::<Result<Vec<_>, _>>()?;
        file::publish_set(staged)
    }

    /// All that is known, as tables, for files and data frames.
    ///
    /// | table | one row for each | columns |
    /// |---|---|---|
    /// | `run` | run | `system`, `scheme`, `version`, `step_size`, `start`, `steps`, `seed`, `noise`, `paths_wanted`, `paths`, `failed`, `extent` (`whole` or `partial`), `targets` (`met`, `missed` or `none`), each parameter that is the same for all paths |
    /// | `moments` | time, observable | `count`, `lost`, `not_finite`, `mean`, `standard_error`, `error_bound`, `largest_share`, `variance` |
    /// | `covariances` | time, pair of observables | `covariance` |
    /// | `quantiles` | time, observable, fraction | `quantile` |
    /// | `histograms` | time, observable, bin | `lower`, `upper`, `count`, `density` |
    /// | `passages` | event | `passed`, `censored`, `lost`, `mean`, `standard_error`, `rate`, `rate_error` |
    /// | `passage_times` | event, bin | `lower`, `upper`, `count`, `density` |
    /// | `path_passages` | path, event (of paths that are kept) | `outcome` (`passed`, `censored` or `lost`), `time` |
    /// | `crossings` | section | `count`, `rising`, `falling`, `mean`, `standard_error`, `variance` (of the number of crossings of a path) |
    /// | `crossing_states` | crossing that is kept | `section`, `path`, `direction` (`rising` or `falling`), `time`, `q0`, ..., `p0`, ... |
    /// | `failures` | path that failed | `step`, `time`, `cause` |
    /// | `paths` | path, time | each parameter that differs between paths, each observable |
    ///
    /// A parameter with the name of another column has `_` at its end.
    ///
    /// All tables are always there, some without rows: files of an earlier run are replaced, whatever that one had. Histograms have a bin below the first one that begins at minus
    /// infinity, one above the last, and one without edges for what is not a number; their density is not a number.
    pub fn tables(&self) -> Vec<Table> {
        let whole = |parts: Parts<'_>| {
            parts.reduce(|mut table, part| {
                table.append(part);
                table
            })
        };
        self.in_parts().into_iter().filter_map(whole).collect()
    }

    /// A table that is small.
    fn whole(&self, table: fn(&Self) -> Table) -> Parts<'_> {
        Box::new(std::iter::once_with(move || table(self)))
    }

    /// The tables, each part by part and made when it is asked for: files take the memory of a part.
    fn in_parts(&self) -> [Parts<'_>; 12] {
        [
            self.whole(Self::run),
            self.whole(Self::moments),
            self.whole(Self::covariances),
            self.whole(Self::quantiles),
            self.whole(Self::histograms),
            self.whole(Self::passage_counts),
            self.whole(Self::passage_times),
            self.path_passages(),
            self.whole(Self::crossing_counts),
            self.crossing_states(),
            self.whole(Self::failure_list),
            self.kept_paths(),
        ]
    }

    fn run(&self) -> Table {
        let columns = [
            ("system", TEXT),
            ("scheme", TEXT),
            ("version", TEXT),
            ("step_size", NUMBER),
            ("start", NUMBER),
            ("steps", COUNT),
            ("seed", COUNT),
            ("noise", TEXT),
            ("paths_wanted", COUNT),
            ("paths", COUNT),
            ("failed", COUNT),
            ("extent", TEXT),
            ("targets", TEXT),
        ];
        let Some(origin) = &self.origin else { return Table::new("run", columns, []) };
        let Origin { system, scheme, h, start, steps, seed, noise, paths, parameters, varying: _ } = origin;
        let known = columns.iter().map(|(name, _)| (*name).to_owned());
        let names = beside(known, parameters.iter().map(|(name, _)| name));
        let mut table = Table::new("run", columns, names.iter().map(String::as_str));
        let targets = match self.met_targets() {
            Some(true) => "met",
            Some(false) => "missed",
            None => "none",
        };
        let own = [
            Text(system),
            Text(scheme),
            Text(env!("CARGO_PKG_VERSION")),
            Number(*h),
            Number(*start),
            Count(*steps),
            Count(*seed),
            Text(noise),
            Count(*paths),
            Count(self.begun()),
            Count(self.failed()),
            Text(if self.is_partial() { "partial" } else { "whole" }),
            Text(targets),
        ];
        table.row(own.into_iter().chain(parameters.iter().map(|(_, value)| Number(*value))));
        table
    }

    /// Every node with every observable.
    fn each(&self) -> impl Iterator<Item = (&StatisticsNode, usize, &String)> {
        self.nodes().iter().flat_map(|node| {
            self.observables().iter().enumerate().map(move |(index, name)| (node, index, name))
        })
    }

    fn moments(&self) -> Table {
        let mut table = Table::new(
            "moments",
            [
                ("time", NUMBER),
                ("observable", TEXT),
                ("count", COUNT),
                ("lost", COUNT),
                ("not_finite", COUNT),
            ],
            ["mean", "standard_error", "error_bound", "largest_share", "variance"],
        );
        for (node, index, name) in self.each() {
            table.row([
                Number(node.time()),
                Text(name),
                Count(node.count()),
                Count(node.lost()),
                Count(node.not_finite(index)),
                Number(node.mean(index)),
                Number(node.standard_error(index)),
                Number(node.error_bound(index)),
                Number(node.largest_share(index)),
                Number(node.variance(index)),
            ]);
        }
        table
    }

    fn covariances(&self) -> Table {
        let columns = [("time", NUMBER), ("first", TEXT), ("second", TEXT)];
        let mut table = Table::new("covariances", columns, ["covariance"]);
        for (node, a, first) in self.each() {
            let partners = if node.has_covariances() { self.observables().len() } else { a + 1 };
            for (b, second) in self.observables().iter().enumerate().take(partners).skip(a) {
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

    fn path_passages(&self) -> Parts<'_> {
        let empty = || {
            let columns = [("path", COUNT), ("event", TEXT), ("outcome", TEXT), ("time", NUMBER)];
            Table::new("path_passages", columns, [])
        };
        let each = self.passages().iter().flat_map(|passages| {
            let kept = (0..).zip(passages.by_path().unwrap_or_default());
            kept.map(move |(path, passage)| (path, passages.name(), *passage))
        });
        parts(empty, each, |table, (path, event, passage)| {
            let (outcome, time) = match passage {
                Passage::At(time) => ("passed", time),
                Passage::Censored => ("censored", f64::NAN),
                Passage::Lost(time) => ("lost", time),
            };
            table.row([Count(path), Text(event), Text(outcome), Number(time)]);
        })
    }

    fn crossing_counts(&self) -> Table {
        let columns = [("section", COUNT), ("count", COUNT), ("rising", COUNT), ("falling", COUNT)];
        let mut table = Table::new("crossings", columns, ["mean", "standard_error", "variance"]);
        for (section, crossings) in (0..).zip(self.crossings()) {
            table.row([
                Count(section),
                Count(crossings.count()),
                Count(crossings.count_towards(Direction::Rising)),
                Count(crossings.count_towards(Direction::Falling)),
                Number(crossings.mean()),
                Number(crossings.standard_error()),
                Number(crossings.variance()),
            ]);
        }
        table
    }

    fn crossing_states(&self) -> Parts<'_> {
        let degrees = self.crossings().first().map_or(0, Crossings::degrees);
        let empty = move || {
            let columns = [("section", COUNT), ("path", COUNT), ("direction", TEXT), ("time", NUMBER)];
            let letters = ["q", "p"].iter();
            let names: Vec<String> =
                letters.flat_map(|letter| (0..degrees).map(move |i| format!("{letter}{i}"))).collect();
            Table::new("crossing_states", columns, names.iter().map(String::as_str))
        };
        let each = (0..).zip(self.crossings());
        let each =
            each.flat_map(|(section, crossings)| crossings.iter().map(move |crossing| (section, crossing)));
        parts(empty, each, |table, (section, PathCrossing { path, direction, t, q, p })| {
            let direction = match direction {
                Direction::Rising => "rising",
                Direction::Falling => "falling",
            };
            let place = [Count(section), Count(path), Text(direction), Number(t)];
            table.row(place.into_iter().chain(q.iter().chain(p).map(|&x| Number(x))));
        })
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

    fn kept_paths(&self) -> Parts<'_> {
        let varying = self.origin.as_ref().map_or(&[][..], |origin| &origin.varying);
        let empty = move || {
            let columns = [("path", COUNT), ("time", NUMBER)];
            let known = columns.iter().map(|(name, _)| (*name).to_owned());
            let known = known.chain(self.observables().iter().cloned());
            let parameters = beside(known, varying.iter().map(|(name, _)| name));
            Table::new("paths", columns, parameters.iter().chain(self.observables()).map(String::as_str))
        };
        let each = self.paths().into_iter().flat_map(move |paths| {
            let nodes = move |path| self.nodes().iter().enumerate().map(move |node| (paths, path, node));
            (0..paths.count()).flat_map(nodes)
        });
        parts(empty, each, move |table, (paths, path, (number, node))| {
            let values = paths.at(path, number).unwrap_or_default().iter();
            let values = values.map(|&value| Number(value));
            let own = varying.iter().map(|(_, own)| Number(own.get(path).copied().unwrap_or(f64::NAN)));
            table.row([Count(path as u64), Number(node.time())].into_iter().chain(own).chain(values));
        })
    }
}

/// `"table":{"column":[entries], ...}` of a table whose parts are made anew for each column: one after the other is in memory.
fn write_json<P: Iterator<Item = Table>>(parts: impl Fn() -> P, to: &mut impl Write) -> io::Result<()> {
    let Some(first) = parts().next() else { return Ok(()) };
    write!(to, "{}:{{", escaped(first.name()))?;
    for (i, (name, _)) in first.columns().iter().enumerate() {
        write!(to, "{}{}:[", if i == 0 { "" } else { "," }, escaped(name))?;
        let mut is_first = true;
        for part in parts() {
            part.write_json_entries(i, is_first, to)?;
            is_first = false;
        }
        write!(to, "]")?;
    }
    write!(to, "}}")
}

/// Names of columns beside those that are known.
fn beside<'n>(known: impl Iterator<Item = String>, names: impl Iterator<Item = &'n String>) -> Vec<String> {
    let mut all: Vec<String> = known.collect();
    let first = all.len();
    for name in names {
        let mut name = name.clone();
        while all.contains(&name) {
            name.push('_');
        }
        all.push(name);
    }
    all.split_off(first)
}

/// The rows of a table, some at a time; the first part is always there.
type Parts<'a> = Box<dyn Iterator<Item = Table> + 'a>;

/// Rows of a part: some megabytes of numbers.
const PART: usize = 1 << 15;

/// The table of a row for each of these, in parts.
fn parts<'a, T>(
    empty: impl Fn() -> Table + 'a,
    rows: impl Iterator<Item = T> + 'a,
    write: impl Fn(&mut Table, T) + 'a,
) -> Parts<'a> {
    let (mut rows, mut is_first) = (rows.peekable(), true);
    Box::new(std::iter::from_fn(move || {
        let is_wanted = std::mem::take(&mut is_first) || rows.peek().is_some();
        is_wanted.then(|| {
            let mut table = empty();
            rows.by_ref().take(PART).for_each(|row| write(&mut table, row));
            table
        })
    }))
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
