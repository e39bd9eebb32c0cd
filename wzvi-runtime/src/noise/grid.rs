//! Times as addresses in a fixed chain of nested grids.
//!
//! The half line t >= 0 is cut into the octaves [0, 1), [1, 2), [2, 4), [4, 8), ...; an octave into unit
//! cells by halving, four halvings to a page; a unit cell by pages of 20 = 5 x 2 x 2 cells, whose edges are
//! the decimal and the dyadic times, the fifth page of 12 = 2 x 2 x 3, so that thirds are met too. A time is
//! snapped to the coarsest grid on which it lies up to a few ulps: `3.0 * 0.02` and `0.06` are one time.
//! Negative times have a tree of their own, the mirror image.
//!
//! Tested by `wzvi-runtime/tests/runtime/noise_path.rs`.

use std::sync::LazyLock;

use super::bridge::Cut;
use super::stream::PAIRS;

/// Two times closer than this part of the larger of `BASE` and the time (in units of the tree) may be taken
/// for one.
const TOLERANCE: f64 = 1.0 / (1u64 << 50) as f64;
/// Times below have the rounding errors of this one, because a run from there computes `start + n h`.
const BASE: f64 = 1024.0;
/// Times from here on are too close to their neighbours in `f64`.
pub(super) const FARTHEST: f64 = (1u64 << 47) as f64;
/// Halvings in a page of an octave.
const HALVINGS: u32 = 4;
/// Cells of the pages within a unit.
const FINE: [u64; 10] = [20, 20, 20, 20, 12, 20, 20, 20, 20, 20];
/// Bound on the pages that lead to a time: 12 in an octave, 10 in a unit.
pub(super) const DEPTH: usize = 24;
/// Bits of a digit: cells of a page are numbered below 32.
const DIGIT: u32 = 5;
/// Bound on the nodes of a page.
pub(super) const NODES: usize = 2 * (PAIRS - 1) + 1;

/// The distance below which times near this one, all in units of the tree, may be taken for one.
pub(super) fn resolution(t: f64) -> f64 {
    TOLERANCE * t.abs().max(BASE)
}

/// A time on the grids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct GridTime {
    /// Whether the time is negative.
    pub(super) negative: bool,
    /// 0 for [0, 1), k for [2^(k-1), 2^k).
    pub(super) octave: u8,
    /// Pages down to the coarsest grid that has this time as the left edge of a cell.
    pub(super) pages: u8,
    /// The cell to enter in each page, the first in the topmost bits; zero beyond.
    digits: u128,
}

impl GridTime {
    pub(super) const ZERO: Self = Self { negative: false, octave: 0, pages: 0, digits: 0 };

    /// The point of a time in units of the tree; `None` if it is NaN or too far.
    pub(super) fn new(time: f64) -> Option<Self> {
        let t = time.abs();
        if t.is_nan() || t >= FARTHEST {
            return None;
        }
        let tolerance = resolution(t);
        let mut unit = t as i64;
        let fraction = t - unit as f64;
        // The coarsest grid: its number of cells in a unit, and the cell.
        let (mut cells, mut level) = (1.0, 0usize);
        let mut cell = (fraction + 0.5) as i64;
        while (fraction * cells - cell as f64).abs() > tolerance * cells && level < FINE.len() {
            cells *= FINE[level] as f64;
            level += 1;
            cell = (fraction * cells + 0.5) as i64;
        }
        if level == 0 {
            (unit, cell) = (unit + cell, 0);
        }
        let (unit, mut cell) = (unit as u64, cell as u64);
        let octave = u64::BITS - unit.leading_zeros();
        let halvings = octave.saturating_sub(1);
        let coarse = halvings.div_ceil(HALVINGS);
        let mut digits = 0;
        let mut put = |page: u32, digit: u64| digits |= u128::from(digit) << place(page);
        for fine in (0..level).rev() {
            // Constants divide by multiplication.
            let (rest, digit) =
                if FINE[fine] == 20 { (cell / 20, cell % 20) } else { (cell / 12, cell % 12) };
            put(coarse + fine as u32, digit);
            cell = rest;
        }
        let mut offset = if octave == 0 { 0 } else { unit ^ (1 << halvings) };
        for page in (0..coarse).rev() {
            put(page, offset & 15);
            offset >>= HALVINGS;
        }
        // Without the zeros at the end: the same edge is that of a larger cell.
        let pages = (u128::BITS - digits.trailing_zeros()).div_ceil(DIGIT);
        let mut point = Self { negative: false, octave: octave as u8, pages: pages as u8, digits };
        point.negative = time < 0.0 && (point.octave, point.pages) != (0, 0);
        Some(point)
    }

    /// The cell to enter in page `depth`, and whether its left edge is this point.
    #[inline]
    pub(super) fn digit(&self, depth: usize) -> (u8, bool) {
        ((self.digits >> place(depth as u32)) as u8 & 31, depth + 1 == usize::from(self.pages))
    }

    /// Whether this point is farther from zero than another on the same side of it.
    #[inline]
    pub(super) fn beyond(&self, other: &Self) -> bool {
        (self.octave, self.digits) > (other.octave, other.digits)
    }

    /// Whether this point is the later one.
    #[inline]
    pub(super) fn after(&self, other: &Self) -> bool {
        match (self.negative, other.negative) {
            (false, false) => self.beyond(other),
            (true, true) => other.beyond(self),
            (negative, _) => !negative,
        }
    }
}

/// Lowest bit of the digit of a page.
#[inline]
fn place(page: u32) -> u32 {
    u128::BITS - DIGIT * (page + 1)
}

/// Length of an octave, in units.
pub(super) fn octave_length(octave: u8) -> f64 {
    (1u64 << octave.saturating_sub(1)) as f64
}

/// The shape of the page at a depth of an octave.
#[inline]
pub(super) fn shape(octave: u8, depth: usize) -> &'static PageTree {
    let halvings = u32::from(octave.saturating_sub(1));
    let coarse = halvings.div_ceil(HALVINGS) as usize;
    let index = if depth < coarse {
        match halvings % HALVINGS {
            remainder @ 1.. if depth == 0 => remainder - 1,
            _ => HALVINGS - 1,
        }
    } else if FINE[(depth - coarse).min(FINE.len() - 1)] == 20 {
        HALVINGS
    } else {
        HALVINGS + 1
    };
    &SHAPES[index as usize]
}

/// Pages of 2, 4, 8, 16, 20 and 12 cells.
static SHAPES: LazyLock<[PageTree; 6]> = LazyLock::new(|| {
    [&[2][..], &[2, 2], &[2, 2, 2], &[2, 2, 2, 2], &[5, 2, 2], &[2, 2, 3]].map(PageTree::new)
});

/// How a page is cut in two, again and again, down to its cells.
#[derive(Debug)]
pub(super) struct PageTree {
    /// Number of cells.
    pub(super) cells: u64,
    /// The root first.
    pub(super) nodes: Vec<PageNode>,
}

/// An interval of a page: some adjacent cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct PageNode {
    /// The first of its cells.
    pub(super) first: u8,
    /// The first cell of the right part.
    pub(super) middle: u8,
    /// Index of the left part, the right part comes next; 0 for a cell.
    pub(super) left: u8,
    /// The number of the pair of normals that cuts the interval.
    pub(super) pair: u8,
    /// Length relative to the page.
    pub(super) part: f64,
    /// The cut of the interval.
    pub(super) cut: Cut,
}

impl PageTree {
    fn new(radices: &[u64]) -> Self {
        let cells: u64 = radices.iter().product();
        let mut nodes = vec![];
        let mut pending = std::collections::VecDeque::from([(0, cells)]);
        let mut next = 1;
        let mut pair = 0;
        while let Some((first, end)) = pending.pop_front() {
            let part = (end - first) as f64 / cells as f64;
            let mut branch =
                PageNode { first: first as u8, middle: 0, left: 0, pair: 0, part, cut: Cut::default() };
            if end - first > 1 {
                // The coarsest grid of the page with an edge inside; its edge nearest to the middle, the left
                // one of two.
                let mut width = cells;
                for radix in radices {
                    width /= radix;
                    if width < end - first {
                        break;
                    }
                }
                let middle = first + (end - first) / width / 2 * width;
                branch.middle = middle as u8;
                branch.left = next;
                branch.pair = pair;
                branch.cut = Cut::new((middle - first) as f64 / (end - first) as f64, part);
                pending.extend([(first, middle), (middle, end)]);
                next += 2;
                pair += 1;
            }
            nodes.push(branch);
        }
        Self { cells, nodes }
    }
}

/// The cut at which the descents to two points on the same side of zero separate.
#[derive(Clone, Copy, Debug)]
pub(super) enum SeparatingCut {
    /// In different octaves.
    Octaves,
    /// In page `page`, after `cuts` common turns. `stop`: there the nearer point is the left edge of the
    /// interval reached.
    Page {
        /// Depth of the page.
        page: usize,
        /// Common turns in that page.
        cuts: usize,
        /// Whether the descent to the nearer point ends.
        stop: bool,
    },
}

impl SeparatingCut {
    /// The cut between two different points.
    pub(super) fn new(p: &GridTime, q: &GridTime) -> Self {
        if p.octave != q.octave {
            return Self::Octaves;
        }
        // The first page in which they differ: in the digit, or because one descent ends there.
        let first = ((p.digits ^ q.digits).leading_zeros() / DIGIT) as usize;
        let Some(last) = usize::from(p.pages.min(q.pages)).checked_sub(1) else {
            // The left edge of the octave.
            return Self::Page { page: 0, cuts: 0, stop: true };
        };
        let page = first.min(last);
        let ((c, c_ends), (d, d_ends)) = (p.digit(page), q.digit(page));
        let nodes = &shape(p.octave, page).nodes;
        let (mut node, mut cuts) = (0, 0);
        loop {
            let branch = &nodes[node];
            if branch.left == 0 || (c_ends && c == branch.first) || (d_ends && d == branch.first) {
                return Self::Page { page, cuts, stop: true };
            }
            let right = c >= branch.middle;
            if right != (d >= branch.middle) {
                return Self::Page { page, cuts, stop: false };
            }
            node = usize::from(branch.left) + usize::from(right);
            cuts += 1;
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{FARTHEST, GridTime, PAIRS, SHAPES};

    #[test]
    fn pages_have_pairs_enough() {
        for shape in SHAPES.iter() {
            let leaves = shape.nodes.iter().filter(|branch| branch.left == 0).count();
            assert_eq!(leaves as u64, shape.cells);
            assert!(shape.cells as usize - 1 < PAIRS, "the last pair is the root's");
            assert_eq!(shape.nodes.len(), 2 * leaves - 1);
        }
    }

    #[test]
    fn decimal_dyadic_and_third_times_are_shallow() {
        for (h, pages) in
            [(0.5, 1), (0.1, 1), (0.05, 1), (0.02, 2), (0.01, 2), (0.0125, 2), (0.001, 3), (1e-4, 4)]
        {
            for n in 1..10_000 {
                let point = GridTime::new(n as f64 * h).unwrap();
                let coarse = point.octave.saturating_sub(1).div_ceil(4);
                assert!(point.pages <= coarse + pages, "{n} {h}: {point:?}");
            }
        }
        for (n, pages) in [(16.0, 2), (64.0, 3), (256.0, 4), (1024.0, 5), (3.0, 5), (30.0, 5), (48.0, 5)] {
            assert!(GridTime::new(1.0 / n).unwrap().pages <= pages, "1 / {n}");
        }
    }

    #[test]
    fn times_a_few_ulps_apart_are_one_time() {
        for n in 1..100_000i32 {
            for (h, reciprocal) in [(0.02, 50.0), (0.1, 10.0), (1e-3, 1000.0), (1.0 / 3.0, 3.0)] {
                let t = f64::from(n) / reciprocal;
                let point = GridTime::new(t);
                assert_eq!(point, GridTime::new(f64::from(n) * h));
                assert_eq!(point, GridTime::new(t.next_up().next_up()));
                assert_eq!(point, GridTime::new(t.next_down().next_down()));
                assert_ne!(point, GridTime::new(-t));
            }
        }
    }

    #[test]
    fn zero_has_one_sign_and_bad_times_none() {
        assert_eq!(GridTime::new(-0.0), Some(GridTime::ZERO));
        assert_eq!(GridTime::new(-1e-30), Some(GridTime::ZERO));
        for t in [f64::NAN, f64::INFINITY, -f64::INFINITY, FARTHEST, -FARTHEST] {
            assert_eq!(GridTime::new(t), None);
        }
        assert!(GridTime::new(FARTHEST.next_down()).is_some());
    }

    #[test]
    fn points_are_ordered_like_times() {
        let mut times: Vec<f64> = (-4000..4000).map(|i| f64::from(i) * 0.0371).collect();
        times.extend((-300..300).map(f64::from));
        times.sort_by(f64::total_cmp);
        for pair in times.windows(2) {
            let [p, q] = [GridTime::new(pair[0]).unwrap(), GridTime::new(pair[1]).unwrap()];
            assert!(p == q || q.after(&p) && !p.after(&q), "{pair:?}");
        }
    }
}
