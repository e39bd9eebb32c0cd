//! Indices and slots for a reader.

use super::index::{Atom, Index, IndexOperation};
use super::{Family, Half, Loop, Slot, System, Table};
use crate::diagnostics::promised;
use crate::symbolic::signed;

/// Names of loop variables, by nesting; deeper ones repeat the last.
const LETTERS: [&str; 6] = ["i", "j", "k", "l", "m", "n"];

/// The name of the loop variable inside of `depth` loops.
pub(crate) fn letter_at(depth: usize) -> &'static str {
    LETTERS[depth.min(LETTERS.len() - 1)]
}

/// The names of the parts of an index.
pub(crate) struct IndexNames<'a> {
    pub(crate) tables: &'a [Table],
    /// The letter of a loop variable.
    pub(crate) letter: &'a dyn Fn(u32) -> &'static str,
}

impl IndexNames<'_> {
    fn table(&self, id: u32) -> &str {
        self.tables.get(id as usize).map_or("?", |table| table.name.as_str())
    }

    pub(crate) fn index(&self, index: &Index) -> String {
        let terms = index.terms.iter().map(|(atom, coefficient)| {
            let (atom, size) = (self.atom(atom), coefficient.unsigned_abs());
            (*coefficient < 0, if size == 1 { atom } else { format!("{size} {atom}") })
        });
        let is_there = index.constant != 0 || index.terms.is_empty();
        let constant = is_there.then(|| (index.constant < 0, index.constant.unsigned_abs().to_string()));
        signed(terms.chain(constant))
    }

    fn atom(&self, atom: &Atom) -> String {
        let operand = |part: &Index| match (part.terms.as_slice(), part.constant) {
            ([(_, 1)], 0) | ([], 0..) => self.index(part),
            _ => format!("({})", self.index(part)),
        };
        let two =
            |both: &(Index, Index), sign: &str| format!("{}{sign}{}", operand(&both.0), operand(&both.1));
        let two_of = |both: &(Index, Index), name: &str| {
            format!("{name}({}, {})", self.index(&both.0), self.index(&both.1))
        };
        match atom {
            Atom::Loop(variable) => (self.letter)(*variable).to_owned(),
            Atom::Size => "n".to_owned(),
            Atom::Given(id, indices) => self.entry(*id, indices),
            Atom::Of(operation, both) => match operation {
                IndexOperation::Product => two(both, " * "),
                IndexOperation::Quotient => format!("({})", two(both, " / ")),
                IndexOperation::Remainder => format!("({})", two(both, " mod ")),
                IndexOperation::Minimum => two_of(both, "min"),
                IndexOperation::Maximum => two_of(both, "max"),
            },
        }
    }

    fn entry(&self, table: u32, indices: &[Index]) -> String {
        let indices = indices.iter().map(|index| format!("[{}]", self.index(index)));
        format!("{}{}", self.table(table), indices.collect::<String>())
    }

    /// The displayed name of a slot. A point has `components` numbers.
    pub(crate) fn slot(&self, slot: &Slot, [q, p]: &[String; 2], components: i128) -> String {
        // `[point]`, or `[point][component]` for points of several components.
        let at = |index: &Index| match index.divided(components) {
            Some((point, component)) if components > 1 => format!("[{}][{component}]", self.index(&point)),
            _ => format!("[{}]", self.index(index)),
        };
        match slot {
            Slot::State(half, index) => {
                let name = match half {
                    Half::Coordinates => q.clone(),
                    Half::Momenta => p.clone(),
                    Half::Displacements => format!("δ{q}"),
                };
                format!("{name}{}", at(index))
            }
            Slot::Number(index) if index.terms.len() == 1 && index.constant == 0 => self.index(index),
            Slot::Number(index) => format!("({})", self.index(index)),
            Slot::Entry(table, indices) => self.entry(*table, indices),
            // It has a name from the start.
            Slot::Collective(slot) => format!("S{}", slot.number + 1),
        }
    }
}

impl System {
    /// An index in `loops`, whose variables are called by their nesting.
    pub(crate) fn index_in(&self, loops: &[Loop], index: &Index) -> String {
        let letter = |variable: u32| {
            let depth = loops.iter().position(|known| known.variable == variable);
            depth.map_or("k", letter_at)
        };
        IndexNames { tables: &self.tables, letter: &letter }.index(index)
    }

    /// The number of each noise as it is written behind `H`, from 1. Member `k` of a family, from 0, is
    /// `_(k + 3)` after two noises, and `_k` if the family is the first.
    pub(crate) fn noise_numbers(&self) -> Vec<String> {
        let families = self.noise.iter().map(|noise| noise.family.as_ref());
        self.numbers(families, self.noise_offsets(), "_k")
    }

    /// The number of each constraint as it is written behind `g`, from 1, as errors of steps count them.
    pub(crate) fn constraint_numbers(&self) -> Vec<String> {
        let families = self.constraints.iter().map(|constraint| constraint.family.as_ref());
        self.numbers(families, self.constraint_offsets(), "_(k + 1)")
    }

    fn numbers<'f>(
        &self,
        families: impl Iterator<Item = Option<&'f Family>>,
        offsets: Vec<Index>,
        first_family: &str,
    ) -> Vec<String> {
        let names = IndexNames { tables: &self.tables, letter: &|_| "k" };
        let numbers = families.zip(offsets).map(|(family, offset)| {
            let first = promised(offset.shifted(1), "numbers of members are integers");
            match (family, offset.as_integer()) {
                (None, Some(_)) => names.index(&first),
                (None, None) => format!("_({})", names.index(&first)),
                (Some(_), Some(0)) => first_family.to_owned(),
                (Some(_), _) => format!("_(k + {})", names.index(&first)),
            }
        });
        numbers.collect()
    }
}
