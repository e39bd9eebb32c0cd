//! How the linear equations of Newton's method are solved: in a band, or by iteration with what is known of the inverse.

use super::jacobian::pattern;
use super::{Elements, Quadrature};
use crate::algebra::memory::Method;
use crate::algebra::scalar::Scalar;
use crate::algebra::solve::{Banded, Krylov, Sparse, reverse_cuthill_mckee};

/// Numbers that a factorisation may hold: 2 GiB of `f64`.
const MOST_NUMBERS: usize = 1 << 28;

/// A band is taken if it is this narrow, or if it is factored by [`FEW_OPERATIONS`].
const NARROW: usize = 16;
/// Half a bandwidth up to which the order of the unknowns is kept.
const NARROW_AS_IT_IS: usize = 4;
/// Multiplications that are about as many as some iterations on products with the matrix need.
const FEW_OPERATIONS: usize = 1 << 22;
/// Entries per unknown of a pattern that is worth a renumbering.
const SPARSE: usize = 64;
/// Iterations that take about as many multiplications as factors may that have all of their entries. These serve many steps.
const MANY_ITERATIONS: u64 = 512;
/// How many solutions take as long as the second derivatives of all elements, entry by entry: a choice of cost.
const ASSEMBLY: u64 = 2;

/// How the linear equations of Newton's method are solved.
#[derive(Clone, Debug)]
pub(super) enum Linear<S> {
    Band(Banded<S>),
    /// From products with the matrix, which is not stored.
    Krylov(Box<Wide<S>>),
}

/// An iteration, and factors of a matrix that is about its own.
#[derive(Clone, Debug)]
pub(super) struct Wide<S> {
    pub(super) krylov: Krylov<S>,
    /// A vector in the units of the system, where the iteration has another for each kind of unknown.
    pub(super) room: Vec<S>,
    /// Allocated when they are needed for the first time, and whether all of their entries were asked for.
    pub(super) factors: Option<(Sparse<S>, bool)>,
}

impl<S: Scalar> Wide<S> {
    /// Room for factors, with all of their entries if these are asked for and are few.
    pub(super) fn room<H: Elements>(
        &mut self,
        system: &H,
        scheme: &Quadrature,
        degrees: usize,
        all: bool,
    ) -> &mut Sparse<S> {
        let known = self.factors.take().filter(|&(_, known)| known == all);
        &mut self.factors.insert(known.unwrap_or_else(|| (factors(system, scheme, degrees, all), all))).0
    }
}

impl<S: Scalar> Linear<S> {
    /// A band if it is narrow or small, after a renumbering where that pays; else products with the matrix.
    pub(super) fn new<H: Elements>(system: &H, scheme: &Quadrature, degrees: usize) -> Self {
        let unknowns = scheme.unknowns.count(degrees);
        let (mut natural, mut entries) = (0_usize, 0_usize);
        pattern(system, scheme, degrees, |row, column| {
            natural = natural.max(row.abs_diff(column));
            entries += 1;
        });
        if natural <= NARROW_AS_IT_IS || is_dense(entries, unknowns) {
            let (size, mut is_parted) = (natural + 1, natural > 0 && natural <= NARROW_AS_IT_IS);
            if is_parted {
                pattern(system, scheme, degrees, |row, column| is_parted &= row / size == column / size);
            }
            return match Self::of_band(unknowns, natural, Vec::new()) {
                Self::Band(band) => Self::Band(band.parted(is_parted)),
                wide => wide,
            };
        }
        let (half, position) = rearranged(unknowns, &pairs(system, scheme, degrees, entries));
        if half < natural {
            Self::of_band(unknowns, half, position)
        } else {
            Self::of_band(unknowns, natural, Vec::new())
        }
    }

    /// With a matrix of this band, or without it where that costs too much.
    fn of_band(unknowns: usize, half: usize, position: Vec<usize>) -> Self {
        // Derivatives that a number carries are not orthogonal to anything.
        let is_plain = size_of::<S>() == size_of::<f64>();
        let is_cheap = half <= NARROW
            || unknowns.saturating_mul(half).saturating_mul(half) <= FEW_OPERATIONS
            || !is_plain;
        match if is_cheap { Banded::new(unknowns, half, position, MOST_NUMBERS) } else { None } {
            Some(band) => Self::Band(band),
            None => Self::Krylov(Box::new(Wide {
                krylov: Krylov::new(unknowns),
                room: Vec::new(),
                factors: None,
            })),
        }
    }

    pub(super) fn method(&self) -> Method {
        match self {
            Self::Band(band) => Method::Band { half_width: band.half_width() },
            Self::Krylov(_) => Method::Krylov,
        }
    }

    /// How many iterations of Newton's method take as long as new factors do; of those by products, how many of these.
    pub(super) fn cost(&self) -> u64 {
        let factors = match self {
            Self::Band(band) => 2 * band.half_width() as u64 / 3,
            Self::Krylov(wide) => wide.factors.as_ref().map_or(0, |(factors, _)| factors.cost()),
        };
        factors + ASSEMBLY
    }

    /// Whether the determinant of the factored matrix is negative; not where it is not known.
    pub(super) fn is_reversed(&self) -> bool {
        match self {
            Self::Band(band) => band.is_reversed(),
            Self::Krylov(wide) => {
                wide.factors.as_ref().and_then(|(factors, _)| factors.is_reversed()).unwrap_or(false)
            }
        }
    }
}

/// Room for factors with entries at the places of the matrix, or with all entries where these are asked for and few, or with a diagonal
/// where the matrix has many.
fn factors<H: Elements, S: Scalar>(system: &H, scheme: &Quadrature, degrees: usize, all: bool) -> Sparse<S> {
    let unknowns = scheme.unknowns.count(degrees);
    let mut entries = 0;
    pattern(system, scheme, degrees, |_, _| entries += 1);
    if is_dense(entries, unknowns) {
        return Sparse::diagonal(unknowns);
    }
    let pairs = pairs(system, scheme, degrees, entries);
    // An iteration takes a product, and as many sums as there are vectors, twice.
    let iteration = (2 * pairs.len() + Krylov::<S>::BASIS * unknowns) as u64;
    let most = if all { Some(MANY_ITERATIONS * iteration) } else { None };
    factors_of(unknowns, &pairs, most)
}

/// Complete factors if they take at most so many operations, else incomplete ones.
fn factors_of<S: Scalar>(unknowns: usize, pairs: &[(usize, usize)], most: Option<u64>) -> Sparse<S> {
    most.and_then(|most| Sparse::complete(unknowns, pairs, most))
        .or_else(|| Sparse::incomplete(unknowns, pairs))
        .unwrap_or_else(|| Sparse::diagonal(unknowns))
}

fn is_dense(entries: usize, unknowns: usize) -> bool {
    entries > SPARSE.saturating_mul(unknowns)
}

/// The places above the diagonal that the Jacobian, or its transpose, may fill.
fn pairs<H: Elements>(
    system: &H,
    scheme: &Quadrature,
    degrees: usize,
    entries: usize,
) -> Vec<(usize, usize)> {
    let mut pairs = Vec::with_capacity(entries);
    pattern(system, scheme, degrees, |row, column| pairs.push((row.min(column), row.max(column))));
    sorted(pairs)
}

fn sorted(mut pairs: Vec<(usize, usize)>) -> Vec<(usize, usize)> {
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// The half of the band after unknowns were rearranged, and their places then.
fn rearranged(unknowns: usize, pairs: &[(usize, usize)]) -> (usize, Vec<usize>) {
    let position = reverse_cuthill_mckee(unknowns, pairs);
    let half = pairs.iter().map(|&(a, b)| position[a].abs_diff(position[b])).max().unwrap_or(0);
    (half, position)
}
