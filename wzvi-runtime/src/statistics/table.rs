//! Statistics as tables, and the tables as files.
//!
//! Tested by `tests/ensembles/statistics.rs`.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::results::Statistics;
use crate::ground::names::free;
use crate::saving::FileError;
use crate::saving::file::{self, Staged};
use crate::saving::table::{Table, TableChunks, TableRows, escaped};

impl Statistics {
    /// One file `<table>.csv` for each of [`Statistics::tables`] in a folder, which is made if it is not
    /// there.
    ///
    /// `run.csv` says that the set is complete: it goes before the first table is replaced and comes back
    /// after the last one, so that tables of two runs never lie beside a `run.csv`. Two programs that write
    /// into one folder at the same time need a folder each.
    ///
    /// # Errors
    /// [`FileError`] for the first file that cannot be written; unless that is in the middle of renaming, all
    /// files are as they were.
    pub fn write_csv(&self, folder: impl AsRef<Path>) -> Result<(), FileError> {
        self.write_tables(folder.as_ref(), "csv", |first, rest, file| first.write_csv_parts(rest, file))
    }

    /// One file with an object of all [`Statistics::tables`]: `{"run":{"system":["Kubo"], ...}, ...}`. NaN
    /// and infinite numbers are `null`. The folder is made if it is not there.
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

    /// One file `<table>.parquet` for each of [`Statistics::tables`] in a folder, which is made if it is not
    /// there. Real numbers are `DOUBLE`, counts `INT64` without a sign, text is UTF-8; no column has nulls.
    ///
    /// `run.parquet` says that the set is complete, as `run.csv` does ([`Statistics::write_csv`]).
    ///
    /// # Errors
    /// The errors of [`Statistics::write_csv`].
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
        write: impl Fn(&Table, TableChunks<'_>, &mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), FileError> {
        file::create_folder(folder)?;
        let stage = |mut parts: TableChunks<'_>| {
            let first = parts.next()?;
            let path = folder.join(first.name()).with_extension(extension);
            Some(Staged::write(&path, |file| write(&first, parts, file)))
        };
        // The first table is that of the run.
        let staged = self.in_parts().into_iter().filter_map(stage).collect::<Result<Vec<_>, _>>()?;
        file::publish_set(staged)
    }

    /// All statistics as tables, for files and data frames.
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
    /// | its own | [statistic](super::Statistic) that was added | its own |
    ///
    /// A parameter with the name of another column has `_` at its end.
    ///
    /// All tables are always there, some without rows: files of an earlier run are replaced, whatever that
    /// one had. Histograms have a bin below the first one that begins at minus infinity, one above the last,
    /// and one without edges for NaN; their density is NaN.
    pub fn tables(&self) -> Vec<Table> {
        let whole = |parts: TableChunks<'_>| {
            parts.reduce(|mut table, part| {
                table.append(part);
                table
            })
        };
        self.in_parts().into_iter().filter_map(whole).collect()
    }

    /// The tables, each in parts that are made on request: writing a file takes the memory of one part.
    fn in_parts(&self) -> Vec<TableChunks<'_>> {
        std::iter::once(self.run()).chain(self.rows()).collect()
    }

    fn run(&self) -> TableChunks<'_> {
        let targets = match self.met_targets() {
            Some(true) => "met",
            Some(false) => "missed",
            None => "none",
        };
        let mut rows = TableRows::of(&self.origin)
            .column("system", |origin| origin.system.clone())
            .column("scheme", |origin| origin.scheme.clone())
            .column("version", |_| env!("CARGO_PKG_VERSION").to_owned())
            .column("step_size", |origin| origin.h)
            .column("start", |origin| origin.start)
            .column("steps", |origin| origin.steps)
            .column("seed", |origin| origin.seed)
            .column("noise", |origin| origin.noise.clone())
            .column("paths_wanted", |origin| origin.paths)
            .column("paths", |_| self.begun())
            .column("failed", |_| self.failed())
            .column("extent", |_| if self.is_partial() { "partial" } else { "whole" }.to_owned())
            .column("targets", move |_| targets.to_owned());
        let parameters = self.origin.as_ref().map_or(&[][..], |origin| &origin.parameters);
        for (name, value) in parameters {
            let name = free(name, rows.names());
            rows = rows.column(name, |_| *value);
        }
        rows.parts("run")
    }
}

/// `"table":{"column":[entries], ...}` of a table whose parts are made anew for each column: one after the
/// other is in memory.
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
