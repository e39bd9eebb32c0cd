//! Any number of constraints: the Jacobian by rows, and the factors of `G_1 W G_0ᵀ` at the places that
//! elimination fills, in an order of least degree (D. J. Rose, "A graph-theoretic study of the numerical
//! solution of sparse positive definite systems of linear equations", 1972). Trees and chains of rods fill
//! none.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::sync::Arc;

use super::layout::{ConstraintLayout, is_pivot, truth};
use super::{Constrained, ConstraintRows};
use crate::algebra::scalar::Scalar;
use crate::algebra::shape::Dynamic;
use crate::scheme::elements::EvaluationPoint;

/// Constraints whose matrices have entries at the places of a graph.
#[derive(Clone, Copy, Debug)]
pub struct SparseConstraints;

/// The places of entries.
#[derive(Debug, Default)]
pub struct SparsePattern {
    /// The entry of the Jacobian that each slope of an evaluation adds to.
    slots: Vec<u32>,
    /// Where each row of the Jacobian starts, and where the last one ends.
    rows: Vec<u32>,
    /// The coordinate of each entry.
    coordinates: Vec<u32>,
    elimination: Elimination,
    /// Where the terms of each entry of the matrix start, and where the last ones end.
    term_starts: Vec<u32>,
    terms: Vec<Term>,
}

/// A term `G_ki W_i G_li` of an entry of `G W Gᵀ`.
#[derive(Clone, Copy, Debug)]
struct Term {
    /// The entries of the Jacobian.
    later: u32,
    earlier: u32,
    /// The coordinate `i`.
    coordinate: u32,
}

/// The elimination of constraints, one after the other. The matrix has an entry for each constraint on its
/// diagonal, and then, for each neighbour of each pivot, the entry of the row of the pivot and that of its
/// column.
#[derive(Debug, Default)]
struct Elimination {
    pivots: Vec<Pivot>,
    /// The constraints that each pivot is coupled with when its turn comes.
    neighbours: Vec<u32>,
    /// The entries that the products of pairs of neighbours are subtracted from.
    targets: Vec<u32>,
}

/// A constraint to be eliminated.
#[derive(Clone, Copy, Debug)]
struct Pivot {
    constraint: u32,
    /// The first of its neighbours, and their number.
    first: u32,
    count: u32,
}

impl Elimination {
    /// The constraints of least degree first; `coupled`: those that share a coordinate with each.
    fn new(mut coupled: Vec<BTreeSet<u32>>) -> Self {
        let n = coupled.len();
        let mut waiting: BinaryHeap<Reverse<(usize, u32)>> =
            coupled.iter().zip(0..).map(|(others, k)| Reverse((others.len(), k))).collect();
        let (mut all, mut position) = (Self::default(), vec![usize::MAX; n]);
        while let Some(Reverse((degree, constraint))) = waiting.pop() {
            let own = constraint as usize;
            if position[own] != usize::MAX || coupled[own].len() != degree {
                continue;
            }
            position[own] = all.pivots.len();
            let neighbours = std::mem::take(&mut coupled[own]);
            let first = all.neighbours.len() as u32;
            all.pivots.push(Pivot { constraint, first, count: neighbours.len() as u32 });
            for &neighbour in &neighbours {
                let others = &mut coupled[neighbour as usize];
                others.extend(&neighbours);
                others.remove(&neighbour);
                others.remove(&constraint);
                waiting.push(Reverse((others.len(), neighbour)));
            }
            all.neighbours.extend(&neighbours);
        }
        // Every neighbour is eliminated later, so that its own neighbours are known now.
        let mut targets = Vec::new();
        for pivot in &all.pivots {
            let neighbours = all.neighbours_of(*pivot);
            for &row in neighbours {
                targets.extend(neighbours.iter().map(|&column| all.entry(&position, row, column)));
            }
        }
        Self { targets, ..all }
    }

    fn neighbours_of(&self, pivot: Pivot) -> &[u32] {
        &self.neighbours[pivot.first as usize..][..pivot.count as usize]
    }

    /// The number of entries of the matrix.
    fn entries(&self) -> usize {
        self.pivots.len() + 2 * self.neighbours.len()
    }

    /// The entry of the row of the pivot for its neighbour `number` of all; that of the column comes next.
    fn beside(&self, number: usize) -> usize {
        self.pivots.len() + 2 * number
    }

    /// The entry at a row and a column, which the elimination fills.
    fn entry(&self, position: &[usize], row: u32, column: u32) -> u32 {
        if row == column {
            return row;
        }
        let is_lower = position[row as usize] > position[column as usize];
        let (pivot, other) = if is_lower { (column, row) } else { (row, column) };
        let pivot = self.pivots[position[pivot as usize]];
        let place = self.neighbours_of(pivot).partition_point(|&known| known < other);
        (self.beside(pivot.first as usize + place) + usize::from(is_lower)) as u32
    }
}

/// Collects the places of the slopes: their constraints and coordinates.
#[derive(Default)]
struct SlopePlaces {
    slopes: Vec<[u32; 2]>,
}

impl ConstraintRows<f64> for SlopePlaces {
    fn value(&mut self, _: usize, _: f64) {}

    fn slope(&mut self, constraint: usize, coordinate: usize, _: f64) {
        self.slopes.push([constraint as u32, coordinate as u32]);
    }

    fn rate(&mut self, _: usize, _: f64) {}
}

impl SparsePattern {
    fn new(constraints: usize, slopes: &[[u32; 2]]) -> Self {
        let places: BTreeSet<[u32; 2]> = slopes.iter().copied().collect();
        let places: Vec<[u32; 2]> = places.into_iter().collect();
        let slot = |slope: &[u32; 2]| places.partition_point(|known| known < slope) as u32;
        let slots = slopes.iter().map(slot).collect();
        let start = |k: usize| places.partition_point(|&[row, _]| (row as usize) < k) as u32;
        let rows: Vec<u32> = (0..=constraints).map(start).collect();
        // The entries of each coordinate.
        let mut by_coordinate: Vec<(u32, u32, u32)> =
            (0..).zip(&places).map(|(entry, &[row, coordinate])| (coordinate, row, entry)).collect();
        by_coordinate.sort_unstable();
        let mut coupled = vec![BTreeSet::new(); constraints];
        let mut products: Vec<([u32; 2], Term)> = Vec::new();
        for together in by_coordinate.chunk_by(|a, b| a.0 == b.0) {
            for &(coordinate, row, later) in together {
                for &(_, column, earlier) in together {
                    products.push(([row, column], Term { later, earlier, coordinate }));
                    if row != column {
                        coupled[row as usize].insert(column);
                    }
                }
            }
        }
        let elimination = Elimination::new(coupled);
        let mut position = vec![0; constraints];
        elimination
            .pivots
            .iter()
            .enumerate()
            .for_each(|(at, pivot)| position[pivot.constraint as usize] = at);
        let mut terms: Vec<(u32, Term)> = products
            .into_iter()
            .map(|([row, column], term)| (elimination.entry(&position, row, column), term))
            .collect();
        terms.sort_by_key(|(entry, _)| *entry);
        let start = |entry: usize| terms.partition_point(|&(own, _)| (own as usize) < entry) as u32;
        let term_starts = (0..=elimination.entries()).map(start).collect();
        Self {
            slots,
            rows,
            coordinates: places.iter().map(|&[_, coordinate]| coordinate).collect(),
            elimination,
            term_starts,
            terms: terms.into_iter().map(|(_, term)| term).collect(),
        }
    }

    /// The coordinates and the entries of each row.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rows<'r, S>(&'r self, jacobian: &'r [S]) -> impl Iterator<Item = (&'r [u32], &'r [S])> {
        self.rows.windows(2).map(|ends| {
            let range = ends[0] as usize..ends[1] as usize;
            (&self.coordinates[range.clone()], &jacobian[range])
        })
    }
}

impl ConstraintLayout for SparseConstraints {
    type Multipliers = Dynamic;
    type Pattern = Arc<SparsePattern>;
    type Jacobian<S: Scalar> = Vec<S>;
    type Factors<S: Scalar> = Vec<S>;

    fn pattern<F: Constrained<Layout = Self>>(system: &F, degrees: usize) -> Arc<SparsePattern> {
        let mut places = SlopePlaces::default();
        let q = vec![0.0; degrees];
        system.constrain(&EvaluationPoint::new([&q[..], &[][..]], 0.0, &[], &[]), &mut places);
        Arc::new(SparsePattern::new(system.constraints(), &places.slopes))
    }

    fn jacobian<S: Scalar>(pattern: &Arc<SparsePattern>) -> Vec<S> {
        vec![S::from_f64(0.0); pattern.coordinates.len()]
    }

    fn factors<S: Scalar>(pattern: &Arc<SparsePattern>) -> Vec<S> {
        // Behind the entries, the sums of the absolute terms of those on the diagonal.
        vec![S::from_f64(0.0); pattern.elimination.entries() + pattern.elimination.pivots.len()]
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn clear<S: Scalar>(jacobian: &mut Vec<S>) {
        jacobian.fill(S::from_f64(0.0));
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn add<S: Scalar>(
        pattern: &Arc<SparsePattern>,
        jacobian: &mut Vec<S>,
        number: usize,
        _: [usize; 2],
        slope: S,
    ) {
        let entry = &mut jacobian[pattern.slots[number] as usize];
        *entry = *entry + slope;
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn product<S: Scalar>(pattern: &Arc<SparsePattern>, jacobian: &Vec<S>, v: &[S], into: &mut [S]) {
        for ((coordinates, entries), into) in pattern.rows(jacobian).zip(into) {
            let mut sum = S::from_f64(0.0);
            for (&i, &entry) in coordinates.iter().zip(entries) {
                sum = sum + entry * v[i as usize];
            }
            *into = sum;
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn absolute_product<S: Scalar>(pattern: &Arc<SparsePattern>, jacobian: &Vec<S>, v: &[S], into: &mut [S]) {
        for ((coordinates, entries), into) in pattern.rows(jacobian).zip(into) {
            let mut sum = S::from_f64(0.0);
            for (&i, &entry) in coordinates.iter().zip(entries) {
                sum = sum + (entry * v[i as usize]).abs();
            }
            *into = sum;
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn transposed_product<S: Scalar>(
        pattern: &Arc<SparsePattern>,
        jacobian: &Vec<S>,
        nu: &[S],
        into: &mut [S],
    ) {
        into.fill(S::from_f64(0.0));
        for ((coordinates, entries), &nu) in pattern.rows(jacobian).zip(nu) {
            for (&i, &entry) in coordinates.iter().zip(entries) {
                let sum = &mut into[i as usize];
                *sum = *sum + entry * nu;
            }
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn factor<S: Scalar>(
        pattern: &Arc<SparsePattern>,
        later: &Vec<S>,
        w: &[S],
        earlier: &Vec<S>,
        a: &mut Vec<S>,
    ) -> S::Mask {
        let SparsePattern { elimination, term_starts, terms, .. } = &**pattern;
        let term = |term: &Term| {
            later[term.later as usize] * (w[term.coordinate as usize] * earlier[term.earlier as usize])
        };
        let n = elimination.pivots.len();
        let (a, sizes) = a.split_at_mut(elimination.entries());
        let (diagonal, others) = a.split_at_mut(n);
        let (own_starts, other_starts) = (&term_starts[..n + 1], &term_starts[n..]);
        for (ends, (entry, size)) in own_starts.windows(2).zip(diagonal.iter_mut().zip(&mut *sizes)) {
            let (mut sum, mut absolute) = (S::from_f64(0.0), S::from_f64(0.0));
            for known in &terms[ends[0] as usize..ends[1] as usize] {
                let term = term(known);
                (sum, absolute) = (sum + term, absolute + term.abs());
            }
            (*entry, *size) = (sum, absolute);
        }
        for (ends, entry) in other_starts.windows(2).zip(others) {
            let mut sum = S::from_f64(0.0);
            for known in &terms[ends[0] as usize..ends[1] as usize] {
                sum = sum + term(known);
            }
            *entry = sum;
        }
        let mut is_regular = truth::<S::Mask>();
        let mut targets = elimination.targets.iter();
        for &Pivot { constraint, first, count } in &elimination.pivots {
            let own = constraint as usize;
            is_regular = is_regular & is_pivot(a[own], sizes[own]);
            let inverse = a[own].recip();
            a[own] = inverse;
            for row in first..first + count {
                let below = elimination.beside(row as usize) + 1;
                let factor = a[below] * inverse;
                a[below] = factor;
                for (column, &target) in (first..first + count).zip(&mut targets) {
                    let right = a[elimination.beside(column as usize)];
                    a[target as usize] = a[target as usize] - factor * right;
                }
            }
        }
        is_regular
    }

    fn diagonal<S: Scalar>(pattern: &Arc<SparsePattern>, jacobian: &Vec<S>, w: &[S], into: &mut [S]) {
        for ((coordinates, entries), into) in pattern.rows(jacobian).zip(into) {
            *into = S::from_f64(0.0);
            for (&i, &entry) in coordinates.iter().zip(entries) {
                *into = *into + entry * entry * w[i as usize];
            }
        }
    }

    fn pivots<S: Scalar>(_: &Arc<SparsePattern>, a: &Vec<S>, into: &mut [S]) {
        into.iter_mut().zip(a).for_each(|(into, &inverse)| *into = inverse.recip());
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn solve<S: Scalar>(pattern: &Arc<SparsePattern>, a: &Vec<S>, b: &mut [S]) {
        let elimination = &pattern.elimination;
        for &Pivot { constraint, first, count } in &elimination.pivots {
            let own = b[constraint as usize];
            for number in first..first + count {
                let row = elimination.neighbours[number as usize] as usize;
                b[row] = b[row] - a[elimination.beside(number as usize) + 1] * own;
            }
        }
        for &Pivot { constraint, first, count } in elimination.pivots.iter().rev() {
            let own = constraint as usize;
            let mut rest = b[own];
            for number in first..first + count {
                let column = elimination.neighbours[number as usize] as usize;
                rest = rest - a[elimination.beside(number as usize)] * b[column];
            }
            b[own] = rest * a[own];
        }
    }
}
