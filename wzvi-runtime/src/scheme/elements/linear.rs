//! The linear equations of Newton's method, solved by elimination in a band or by a preconditioned Krylov
//! iteration.
//!
//! Each of the ways is faster than the others by more than 1.3 somewhere. In ms for a solution to twelve
//! digits and a tenth of a factorisation, with `ω h / 2` of the fastest motion
//! (`cargo bench --workspace --bench linear`; `-` for bands of more than 2 10^10 multiplications, which were
//! not tried):
//!
//! | matrix | `ω h / 2` | band | complete sparse factors | GMRES, incomplete factors |
//! |---|---|---|---|---|
//! | chain of 10^5 sites | 20 | **2.0** | 3.0 | 14 |
//! | chain of 10^5 sites | 2000 | **1.9** | 3.1 | 9.7 |
//! | lattice of 256^2 sites | 2 | - | 253 | **116** |
//! | lattice of 256^2 sites | 20 | - | **309** | 1587 |
//! | lattice of 256^2 sites | 2000 | - | **199** | does not converge |
//! | lattice of 32^3 sites | 20 | - | 6220 | **239** |
//! | lattice of 32^3 sites | 200 | - | 4862 | **440** |

use super::costs::Costs;
use super::jacobian::VisitEntry;
use super::low_rank::{Bordered, RankOneTerms};
use crate::algebra::memory::Method;
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::{Banded, Krylov, Sparse, reverse_cuthill_mckee};

/// Largest number of entries of a factorisation: 2 GiB of `f64`.
pub(super) const MOST_NUMBERS: usize = 1 << 28;

/// Half-bandwidth up to which a band is always used; a wider one if it takes at most [`FEW_OPERATIONS`] to
/// factor.
const NARROW: usize = 16;
/// Half-bandwidth up to which the unknowns are not renumbered.
const NARROW_AS_IT_IS: usize = 4;
/// Multiplications, about as many as a few Krylov iterations take.
const FEW_OPERATIONS: usize = 1 << 22;
/// Entries per unknown up to which a renumbering pays.
const SPARSE: usize = 64;
/// Limit on the multiplications of complete factors, in Krylov iterations. The factors serve many steps.
const MANY_ITERATIONS: u64 = 512;
/// Cost of the second derivatives of all elements, in solutions of the linear equations: a tuning parameter.
const ASSEMBLY: u64 = 2;

/// Visits all positions off the diagonal where the matrix may have an entry, some more than once.
type Pattern<'p> = &'p dyn Fn(VisitEntry<'_>);

/// The solver of the linear equations of Newton's method.
#[derive(Clone, Debug)]
pub(super) enum LinearSolver<S> {
    Band(Banded<S>),
    /// A band, and terms of rank one.
    Bordered(Box<Bordered<S>>),
    /// Uses products with the matrix, which is not stored.
    Krylov(Box<KrylovSolver<S>>),
}

/// A Krylov iteration, and factors of a nearby matrix as its preconditioner.
#[derive(Clone, Debug)]
pub(super) struct KrylovSolver<S> {
    pub(super) krylov: Krylov<S>,
    /// The terms of rank one of the matrix.
    pub(super) terms: RankOneTerms<S>,
    /// A vector in the units of the system; the iteration scales each kind of unknown.
    pub(super) room: Vec<S>,
    /// The factors, allocated at their first use, and whether complete ones were requested.
    pub(super) factors: Option<(Sparse<S>, bool)>,
    /// Whether products with the matrix leave out entries that are not finite.
    pub(super) leaves_out: bool,
}

impl<S: Scalar> KrylovSolver<S> {
    /// Storage for factors; complete if `all` and cheap enough.
    pub(super) fn room(&mut self, pattern: Pattern<'_>, unknowns: usize, all: bool) -> &mut Sparse<S> {
        let known = self.factors.take().filter(|&(_, known)| known == all);
        &mut self.factors.insert(known.unwrap_or_else(|| (factors(pattern, unknowns, all), all))).0
    }
}

impl<S: Scalar> LinearSolver<S> {
    /// A band if it is narrow or small, after a renumbering where that pays; otherwise Krylov's method.
    pub(super) fn new(pattern: Pattern<'_>, unknowns: usize, terms: RankOneTerms<S>) -> Self {
        match band_of(pattern, unknowns) {
            Some(band) if terms.count() == 0 => Self::Band(band),
            Some(band) => Self::Bordered(Box::new(Bordered::new(band, terms))),
            None => Self::Krylov(Box::new(KrylovSolver {
                krylov: Krylov::new(unknowns),
                terms,
                room: Vec::with_capacity(unknowns),
                factors: None,
                leaves_out: false,
            })),
        }
    }

    pub(super) fn method(&self) -> Method {
        match self {
            Self::Bordered(bordered) => Method::Band { half_width: bordered.band.half_width() },
            Self::Band(band) => Method::Band { half_width: band.half_width() },
            Self::Krylov(_) => Method::Krylov,
        }
    }

    /// Cost of new factors: in Newton iterations for a band, in Jacobian products for Krylov's method.
    pub(super) fn cost(&self, costs: Costs) -> u64 {
        match self {
            Self::Band(_) | Self::Bordered(_) => costs.factors(),
            Self::Krylov(wide) => wide.factors.as_ref().map_or(0, |(factors, _)| factors.cost()) + ASSEMBLY,
        }
    }

    /// Whether the determinant of the factored matrix is known to be negative.
    pub(super) fn is_reversed(&self) -> bool {
        match self {
            Self::Band(band) => band.is_reversed(),
            Self::Bordered(bordered) => bordered.is_reversed(),
            Self::Krylov(wide) => {
                wide.factors.as_ref().and_then(|(factors, _)| factors.is_reversed()).unwrap_or(false)
            }
        }
    }
}

/// The band of a matrix, after a renumbering where that pays; `None` if it costs too much.
fn band_of<S: Scalar>(pattern: Pattern<'_>, unknowns: usize) -> Option<Banded<S>> {
    let (mut natural, mut entries) = (0_usize, 0_usize);
    pattern(&mut |row, column| {
        natural = natural.max(row.abs_diff(column));
        entries += 1;
    });
    if natural <= NARROW_AS_IT_IS || is_dense(entries, unknowns) {
        let (size, mut is_parted) = (natural + 1, natural > 0 && natural <= NARROW_AS_IT_IS);
        if is_parted {
            pattern(&mut |row, column| is_parted &= row / size == column / size);
        }
        let band = of_half_width(unknowns, natural, Vec::new())?;
        return Some(if is_parted { band.parted(true) } else { band });
    }
    let (half, position) = rearranged(unknowns, &pairs(pattern, entries));
    if half < natural {
        of_half_width(unknowns, half, position)
    } else {
        of_half_width(unknowns, natural, Vec::new())
    }
}

/// A band of this half-width, or the whole matrix where that is eliminated faster; `None` if it costs too
/// much.
fn of_half_width<S: Scalar>(unknowns: usize, half: usize, position: Vec<usize>) -> Option<Banded<S>> {
    // Krylov's method cannot orthogonalise the derivatives that numbers carry.
    let is_plain = size_of::<S>() == size_of::<f64>();
    let is_cheap =
        half <= NARROW || unknowns.saturating_mul(half).saturating_mul(half) <= FEW_OPERATIONS || !is_plain;
    let is_dense = half > NARROW_AS_IT_IS && Banded::<S>::is_dense(unknowns, half);
    let (half, position) = if is_dense { (unknowns - 1, Vec::new()) } else { (half, position) };
    let band = if is_cheap { Banded::new(unknowns, half, position, MOST_NUMBERS) } else { None };
    band.map(|band| band.parted(is_dense))
}

/// Storage for factors: incomplete, with the pattern of the matrix; complete if `all` and cheap enough;
/// diagonal for a dense matrix.
fn factors<S: Scalar>(pattern: Pattern<'_>, unknowns: usize, all: bool) -> Sparse<S> {
    let mut entries = 0;
    pattern(&mut |_, _| entries += 1);
    if is_dense(entries, unknowns) {
        return Sparse::diagonal(unknowns);
    }
    let pairs = pairs(pattern, entries);
    // An iteration takes a product, and a dot product and an update with each vector of the basis so far.
    let iteration = (2 * pairs.len() + Krylov::<S>::BASIS * unknowns) as u64;
    let most = if all { Some(MANY_ITERATIONS * iteration) } else { None };
    factors_of(unknowns, &pairs, most)
}

/// Complete factors if they take at most `most` operations, otherwise incomplete ones.
fn factors_of<S: Scalar>(unknowns: usize, pairs: &[(usize, usize)], most: Option<u64>) -> Sparse<S> {
    most.and_then(|most| Sparse::complete(unknowns, pairs, most))
        .or_else(|| Sparse::incomplete(unknowns, pairs))
        .unwrap_or_else(|| Sparse::diagonal(unknowns))
}

fn is_dense(entries: usize, unknowns: usize) -> bool {
    entries > SPARSE.saturating_mul(unknowns)
}

/// The positions above the diagonal where the Jacobian or its transpose may have entries.
fn pairs(pattern: Pattern<'_>, entries: usize) -> Vec<(usize, usize)> {
    let mut pairs = Vec::with_capacity(entries);
    pattern(&mut |row, column| pairs.push((row.min(column), row.max(column))));
    sorted(pairs)
}

fn sorted(mut pairs: Vec<(usize, usize)>) -> Vec<(usize, usize)> {
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// The half-bandwidth after renumbering, and the new position of each unknown.
fn rearranged(unknowns: usize, pairs: &[(usize, usize)]) -> (usize, Vec<usize>) {
    let position = reverse_cuthill_mckee(unknowns, pairs);
    let half = pairs.iter().map(|&(a, b)| position[a].abs_diff(position[b])).max().unwrap_or(0);
    (half, position)
}
