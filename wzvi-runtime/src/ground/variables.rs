//! The names of coordinates, momenta and time in the closure of the drift.
//!
//! Tested by `tests/paths/results.rs`.

use std::fmt::Write as _;

/// The names of a phase space, as the closure of the drift has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variables {
    /// Names of the coordinates.
    pub q: Labels,
    /// Names of the momenta.
    pub p: Labels,
    /// The name of time.
    pub t: &'static str,
    /// The names of the first integrals, in the order of `invariant`; empty for one without a name, and no
    /// entries where none has one.
    pub invariants: &'static [&'static str],
    /// The names of the observables, in the order of `observe`.
    pub observables: &'static [&'static str],
}

/// The names of the components of a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Labels {
    /// One name each: `|[x, y], [px, py]|`.
    Each(&'static [&'static str]),
    /// Elements of an array: `|q: [[f64; 3]; N], p|` has `q[0][0]`, `q[0][1]`, ...
    Array {
        /// The name of the array.
        name: &'static str,
        /// The lengths of the arrays inside, from the outside in.
        inner: &'static [usize],
    },
}

impl Variables {
    /// `q`, `p` and `t`: the names of a system that gives none.
    pub const fn unnamed(degrees: usize) -> Self {
        match degrees {
            1 => Self {
                q: Labels::Each(&["q"]),
                p: Labels::Each(&["p"]),
                t: "t",
                invariants: &[],
                observables: &[],
            },
            _ => Self {
                q: Labels::Array { name: "q", inner: &[] },
                p: Labels::Array { name: "p", inner: &[] },
                t: "t",
                invariants: &[],
                observables: &[],
            },
        }
    }

    /// The name of an observable that the system declares; `observable_0` and so on if there is none.
    pub fn observable(&self, index: usize) -> String {
        self.observables.get(index).map_or_else(|| format!("observable_{index}"), |name| (*name).to_owned())
    }

    /// The name of a first integral, and `invariant_0` and so on for those without one.
    pub fn invariant(&self, index: usize) -> String {
        match self.invariants.get(index) {
            Some(name) if !name.is_empty() => (*name).to_owned(),
            _ => format!("invariant_{index}"),
        }
    }
}

impl Labels {
    /// The name of a component; they count from 0, as in the state.
    pub fn name(&self, index: usize) -> String {
        match self {
            Self::Each(names) => names.get(index).map_or_else(|| index.to_string(), |&name| name.to_owned()),
            Self::Array { name, inner } => {
                let lengths = || inner.iter().map(|&length| length.max(1));
                let (mut block, mut rest) = (lengths().product::<usize>(), index);
                let mut text = format!("{name}[{}]", rest / block);
                for length in lengths() {
                    (rest, block) = (rest % block, block / length);
                    // Writing to a string cannot fail.
                    let _ = write!(text, "[{}]", rest / block);
                }
                text
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_are_called_as_rust_indexes_them() {
        let each = Labels::Each(&["x", "y"]);
        assert_eq!([0, 1, 2].map(|index| each.name(index)), ["x", "y", "2"]);
        let sites = Labels::Array { name: "u", inner: &[] };
        assert_eq!([0, 17].map(|index| sites.name(index)), ["u[0]", "u[17]"]);
        let points = Labels::Array { name: "q", inner: &[3] };
        assert_eq!(
            [0, 2, 3, 10].map(|index| points.name(index)),
            ["q[0][0]", "q[0][2]", "q[1][0]", "q[3][1]"]
        );
        let matrices = Labels::Array { name: "m", inner: &[2, 3] };
        assert_eq!([5, 6, 11].map(|index| matrices.name(index)), ["m[0][1][2]", "m[1][0][0]", "m[1][1][2]"]);
    }

    #[test]
    fn one_degree_of_freedom_has_no_index() {
        assert_eq!(Variables::unnamed(1).q.name(0), "q");
        assert_eq!(Variables::unnamed(2).p.name(1), "p[1]");
    }
}
