//! Points of phase space.

use std::fmt::{self, Debug};

use nalgebra::{DVector, SVector};

use crate::algebra::lanes::instructions::{InstructionSet, Kernel};
use crate::ground::digits::ShortestDecimal;

/// A vector of coordinates: `nalgebra::SVector<f64, D>` or `nalgebra::DVector<f64>`.
pub trait Vector: Clone + Debug + PartialEq + Send + Sync {
    /// The zero vector with `len` components (for a vector of fixed size, its own).
    fn zeros(len: usize) -> Self;
    /// The components.
    fn components(&self) -> &[f64];
    /// The components, to change.
    fn components_mut(&mut self) -> &mut [f64];
    /// Takes the numbers of a list of the same length; the list takes those of the vector where that copies
    /// nothing.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exchange(&mut self, list: &mut Vec<f64>) {
        self.components_mut().copy_from_slice(list);
    }
}

impl<const D: usize> Vector for SVector<f64, D> {
    fn zeros(_len: usize) -> Self {
        Self::zeros()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn components(&self) -> &[f64] {
        self.as_slice()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn components_mut(&mut self) -> &mut [f64] {
        self.as_mut_slice()
    }
}

impl Vector for DVector<f64> {
    fn zeros(len: usize) -> Self {
        Self::zeros(len)
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn components(&self) -> &[f64] {
        self.as_slice()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn components_mut(&mut self) -> &mut [f64] {
        self.as_mut_slice()
    }
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn exchange(&mut self, list: &mut Vec<f64>) {
        *list = std::mem::replace(self, std::mem::take(list).into()).data.into();
    }
}

/// `x · y`
pub(crate) fn dot<V: Vector>(x: &V, y: &V) -> f64 {
    x.components().iter().zip(y.components()).map(|(x, y)| x * y).sum()
}

/// Types for coordinates and momenta: arrays with one number for each degree of freedom, `Vec`s for systems
/// of any size, and vectors of nalgebra. Arrays and `Vec`s of points give their components point by point.
#[diagnostic::on_unimplemented(
    message = "`{Self}` are not the coordinates or momenta of this system",
    label = "the system has as many degrees of freedom as `{V}` has components",
    note = "a state holds one number for each degree of freedom: `State::new([q1, q2], [p1, p2])` for two; points in the plane or \
            in space are arrays of their own, `[[x1, y1], [x2, y2]]`, or follow one another, `[x1, y1, x2, y2]`",
    note = "systems of any size (`&[f64]`, `&[[f64; 3]]`) take a `Vec` of numbers or of points, or an array of any length; others take arrays: \
            `<[f64; 4]>::try_from(list)` makes one of a `Vec`, and is an error where the length differs"
)]
pub trait Components<V> {
    /// The numbers as a vector.
    fn into_vector(self) -> V;
}

impl<V: Vector> Components<V> for V {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn into_vector(self) -> V {
        self
    }
}

impl<const D: usize> Components<SVector<f64, D>> for [f64; D] {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn into_vector(self) -> SVector<f64, D> {
        self.into()
    }
}

impl<const D: usize> Components<DVector<f64>> for [f64; D] {
    fn into_vector(self) -> DVector<f64> {
        self.to_vec().into()
    }
}

impl Components<DVector<f64>> for Vec<f64> {
    fn into_vector(self) -> DVector<f64> {
        self.into()
    }
}

/// Another number of components than the system has is an error when the call is compiled.
impl<const D: usize, const N: usize, const M: usize> Components<SVector<f64, M>> for [[f64; D]; N] {
    fn into_vector(self) -> SVector<f64, M> {
        const { assert!(N * D == M, "the system has another number of degrees of freedom than these points") };
        SVector::from_fn(|i, _| self[i / D][i % D])
    }
}

impl<const D: usize, const N: usize> Components<DVector<f64>> for [[f64; D]; N] {
    fn into_vector(self) -> DVector<f64> {
        self.as_flattened().to_vec().into()
    }
}

impl<const D: usize> Components<DVector<f64>> for Vec<[f64; D]> {
    fn into_vector(self) -> DVector<f64> {
        self.into_flattened().into()
    }
}

/// A state: coordinates `q`, canonical momenta `p` and time `t`, in the units of the Hamiltonian.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State<V> {
    /// Coordinates.
    pub q: V,
    /// Canonical (node) momenta.
    pub p: V,
    /// Time.
    pub t: f64,
}

/// No type implements it: rustc says in its words what to write in the place of `state.energy()`.
#[doc(hidden)]
#[diagnostic::on_unimplemented(
    message = "a state has no energy of its own: the Hamiltonian belongs to the system",
    label = "write `system.energy(&state)`, where `system` is the value of the struct with `#[hamiltonian(...)]`",
    note = "an observer borrows the system, as in `.observe(\"energy\", |state| system.energy(state))`"
)]
pub trait EnergyOfItsOwn {}

impl<V> State<V> {
    #[doc(hidden)]
    pub fn energy(&self) -> f64
    where
        Self: EnergyOfItsOwn,
    {
        f64::NAN
    }
}

/// `q: [1, 2], p: [3, 4], t: 0`
impl<V: Vector> fmt::Display for State<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, vector) in [("q", &self.q), ("p", &self.p)] {
            write!(f, "{name}: [")?;
            for (i, x) in vector.components().iter().enumerate() {
                write!(f, "{}{}", if i == 0 { "" } else { ", " }, ShortestDecimal(*x))?;
            }
            f.write_str("], ")?;
        }
        write!(f, "t: {}", ShortestDecimal(self.t))
    }
}

impl<V: Vector> State<V> {
    /// The state with coordinates `q` and momenta `p` at `t = 0`, from arrays or `Vec`s of numbers or of
    /// points, or nalgebra vectors.
    ///
    /// ```
    /// use wzvi_runtime::nalgebra::{DVector, SVector};
    /// use wzvi_runtime::algebra::state::State;
    ///
    /// let points: State<SVector<f64, 4>> = State::new([[1.0, 2.0], [3.0, 4.0]], [0.0; 4]);
    /// assert_eq!(points.q.as_slice(), [1.0, 2.0, 3.0, 4.0]);
    /// let any_number: State<DVector<f64>> = State::new(vec![[1.0, 2.0], [3.0, 4.0]], [[0.0; 2]; 2]);
    /// assert_eq!(any_number.q.as_slice(), points.q.as_slice());
    /// assert_eq!(any_number.p.as_slice(), points.p.as_slice());
    /// ```
    pub fn new(q: impl Components<V>, p: impl Components<V>) -> Self {
        Self { q: q.into_vector(), p: p.into_vector(), t: 0.0 }
    }

    /// Coordinates and momenta by point, as a closure with `q: [[f64; 3]; N]` reads them, for observables and
    /// sections. There are no points if the number of degrees of freedom is not a multiple of `D`.
    ///
    /// ```
    /// use wzvi_runtime::nalgebra::SVector;
    /// use wzvi_runtime::algebra::state::State;
    ///
    /// let state: State<SVector<f64, 4>> = State::new([[1.0, 2.0], [3.0, 4.0]], [[0.0; 2], [5.0, 6.0]]);
    /// let [q, p] = state.points::<2>();
    /// assert_eq!((q[1][0], p[1][0]), (3.0, 5.0));
    /// assert!(state.points::<3>()[0].is_empty());
    /// ```
    pub fn points<const D: usize>(&self) -> [&[[f64; D]]; 2] {
        const { assert!(D > 0, "points have components") };
        [&self.q, &self.p].map(|vector| match vector.components().as_chunks() {
            (points, []) => points,
            _ => &[],
        })
    }

    /// The words of it.
    pub(crate) fn pass(&mut self, tape: &mut crate::ground::numbers::Tape) {
        tape.number(&mut self.t);
        tape.numbers(self.q.components_mut());
        tape.numbers(self.p.components_mut());
    }

    /// This point of phase space at time `t`.
    #[must_use]
    pub fn at(mut self, t: f64) -> Self {
        self.t = t;
        self
    }
}

/// Copies without allocating, unless the length changes.
#[inline]
pub(crate) fn copy<V: Vector>(into: &mut V, from: &V) {
    let (old, new) = (into.components_mut(), from.components());
    if old.len() == new.len() {
        old.copy_from_slice(new);
    } else {
        into.clone_from(from);
    }
}

/// From so many numbers on a comparison takes longer than the choice of its instructions.
const LONG: usize = 64;

/// Whether all numbers are equal.
#[cfg_attr(not(debug_assertions), inline(always))]
pub(crate) fn are_equal<V: Vector>(a: &V, b: &V) -> bool {
    let lists = AreEqual(a.components(), b.components());
    if lists.0.len() < LONG { lists.run::<1, 1>() } else { InstructionSet::best().run(lists) }
}

/// Compares two lists. No branch ends the loop, so that it is vectorised.
struct AreEqual<'a>(&'a [f64], &'a [f64]);

impl Kernel for AreEqual<'_> {
    type Output = bool;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<const L: usize, const HALF: usize>(self) -> bool {
        let Self(a, b) = self;
        let mut is_same = a.len() == b.len();
        for (a, b) in a.iter().zip(b) {
            is_same &= a == b;
        }
        is_same
    }
}

/// Copies a state without allocating, unless its length changes.
pub(crate) fn copy_state<V: Vector>(into: &mut State<V>, from: &State<V>) {
    into.t = from.t;
    copy(&mut into.q, &from.q);
    copy(&mut into.p, &from.p);
}
