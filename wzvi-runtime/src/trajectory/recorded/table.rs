//! A path as a table: columns named as in the closure of the drift, for files and data frames.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

use super::Trajectory;
use crate::algebra::state::{State, Vector};
use crate::saving::FileError;
use crate::saving::file;
use crate::saving::table::Table;
use crate::scheme::system::Hamiltonian;

/// The recorded nodes of a path in columns, one row each: [`Trajectory::table`] begins it.
///
/// | column | what | from |
/// |---|---|---|
/// | `t`, `x`, `y`, `px`, `py` | time, coordinates and momenta, as the closure of the drift calls them; `q[0]`, `q[1][2]` of arrays | [`Trajectory::table`] |
/// | the observables | under their own names; `q_` if another column is called `q` | [`Trajectory::table`] |
/// | `energy` | the drift Hamiltonian `H_0` | [`PathTable::energies`] |
/// | `invariant_0`, ... | the proven first integrals, in the order of the attribute; under their names where they have some | [`PathTable::energies`] |
/// | the observables of `observe = [...]` | under their names in the attribute | [`PathTable::energies`] |
/// | `dw_0`, ... | the increment of each noise since the row before; 0 in the first row | [`PathTable::increments`] |
///
/// All columns are real numbers.
#[derive(Debug)]
#[must_use = "nothing is written before `write_csv`, `write_json` or `write_parquet`"]
pub struct PathTable<'a, V, E> {
    path: &'a Trajectory<V, E>,
    table: Table,
}

impl<V: Vector, E> Trajectory<V, E> {
    /// The recorded nodes as a table with time, coordinates, momenta and observables.
    ///
    /// `path.table().energies(&kubo).write_csv("path.csv")?` writes them with the energies.
    pub fn table(&self) -> PathTable<'_, V, E> {
        let mut table = PathTable { path: self, table: Table::named("path") };
        let (names, degrees) = (self.variables(), self.last().q.components().len());
        table.push(names.t, |state| state.t);
        for i in 0..degrees {
            table.push(&names.q.name(i), |state| component(&state.q, i));
        }
        for i in 0..degrees {
            table.push(&names.p.name(i), |state| component(&state.p, i));
        }
        for (name, values) in &self.path.observed {
            table.table.push(name, values.clone());
        }
        table
    }
}

impl<V: Vector, E> PathTable<'_, V, E> {
    /// Adds the drift Hamiltonian, the proven first integrals and the declared observables of the system at
    /// each node, in their own units.
    pub fn energies<H: Hamiltonian<Vector = V>>(mut self, system: &H) -> Self {
        self.push("energy", |state| system.energy(state));
        let names = system.variables();
        for index in 0..system.invariants() {
            self.push(&names.invariant(index), |state| system.invariant(index, state));
        }
        for index in 0..system.observables() {
            self.push(&names.observable(index), |state| system.observable(index, state));
        }
        self
    }

    /// Adds the increment of each noise from the row before to this one: their sums are `W_k(t) - W_k(t_0)`.
    pub fn increments(mut self) -> Self {
        for k in 0..self.path.processes() {
            let increments = self.path.increments().map(|row| row.get(k).copied().unwrap_or(0.0));
            self.table.push(&format!("dw_{k}"), std::iter::once(0.0).chain(increments).collect::<Vec<_>>());
        }
        self
    }

    fn push(&mut self, name: &str, value: impl Fn(&State<V>) -> f64) {
        self.table.push(name, self.path.iter().map(value).collect::<Vec<_>>());
    }

    /// The columns in memory.
    pub fn into_table(self) -> Table {
        self.table
    }

    /// Comma-separated values with the names in the first line; numbers come back to the last bit. The folder
    /// of the file is made if it is not there, and the file appears complete or not at all.
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    pub fn write_csv(&self, file: impl AsRef<Path>) -> Result<(), FileError> {
        self.write(file.as_ref(), |table, file| table.write_csv(file))
    }

    /// JSON records, an object for each node: `[{"t":0.0,"q":0.0,"p":1.0}, ...]`. Observables and energies
    /// that are NaN or infinite are `null`, as data frames expect; CSV and Parquet files have their values.
    /// The folder and the file as with [`PathTable::write_csv`].
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    pub fn write_json(&self, file: impl AsRef<Path>) -> Result<(), FileError> {
        self.write(file.as_ref(), |table, file| table.write_json_records(file))
    }

    /// A Parquet file with a column of `DOUBLE`s each. The folder and the file as with
    /// [`PathTable::write_csv`].
    ///
    /// # Errors
    /// [`FileError`] if it cannot be written.
    #[cfg(feature = "columnar")]
    pub fn write_parquet(&self, file: impl AsRef<Path>) -> Result<(), FileError> {
        self.write(file.as_ref(), |table, file| table.write_parquet(file))
    }

    fn write(
        &self,
        path: &Path,
        write: impl FnOnce(&Table, &mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), FileError> {
        file::replace_in_folder(path, |file| write(&self.table, file))
    }
}

fn component<V: Vector>(vector: &V, index: usize) -> f64 {
    vector.components().get(index).copied().unwrap_or(f64::NAN)
}
