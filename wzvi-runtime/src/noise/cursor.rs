//! A position in the tree of one process. It keeps the pages that lead to a time, so that a time nearby costs
//! only a few draws.
//!
//! The descent to a time is a list of turns at cuts. A turn to the right passes an interval before the time,
//! a turn to the left one after it. The increment between two times is the sum over the intervals passed
//! after the two descents separate, and all of these lie between the two times. Nothing cancels, so that
//! small increments at large times keep their digits. The sum is a function of the two times alone: the order
//! of the queries changes nothing.
//!
//! Tested by `wzvi-runtime/tests/runtime/noise_path.rs`.

use super::bridge::{BridgeInterval, IntervalScale, PathIncrement};
use super::grid::{self, DEPTH, GridTime, NODES, SeparatingCut};
use super::stream::{PAIRS, PageAddress, ProcessId, Words};

/// One cell of a grid and the cuts inside it that were needed.
#[derive(Clone, Debug)]
struct Page {
    address: PageAddress,
    scale: IntervalScale,
    words: Words,
    nodes: [BridgeInterval; NODES],
    /// Bit `i` is set once node `i` has been cut.
    cut: u64,
}

impl Page {
    fn load(&mut self, source: &ProcessId, address: PageAddress, length: f64, root: BridgeInterval) {
        self.words.fill(source, &address);
        self.address = address;
        self.scale = IntervalScale::new(length);
        self.nodes[0] = root;
        self.cut = 0;
    }

    #[inline]
    fn cut(&mut self, index: usize, branch: &grid::PageNode) {
        if self.cut & (1 << index) == 0 {
            let normals = self.words.normals(usize::from(branch.pair));
            let left = usize::from(branch.left);
            let parts = branch.cut.apply(self.nodes[index], &self.scale, normals);
            self.nodes[left..left + 2].copy_from_slice(&parts);
            self.cut |= 1 << index;
        }
    }
}

/// An interval passed in the descent to a time.
#[derive(Clone, Copy, Debug)]
struct DescentStep {
    /// Whether the turn was to the right, so that the interval lies before the time.
    right: bool,
    node: BridgeInterval,
    length: f64,
}

/// The descent to a time in the tree of one process.
#[derive(Clone, Debug)]
pub(super) struct Cursor {
    source: ProcessId,
    pages: Vec<Page>,
    /// Whole octaves, on both sides of zero.
    octaves: [Vec<Option<BridgeInterval>>; 2],
    point: GridTime,
    turns: Vec<DescentStep>,
    /// Number of turns before each page.
    starts: [u8; DEPTH + 1],
    /// The interval that starts at the time.
    last: DescentStep,
}

/// Enough for any time: at most 47 halvings, and five cuts for each of ten pages.
const TURNS: usize = 104;

impl Cursor {
    pub(super) fn new(source: ProcessId) -> Self {
        let mut cursor = Self {
            source,
            pages: Vec::with_capacity(4),
            octaves: [vec![], vec![]],
            point: GridTime::ZERO,
            turns: Vec::with_capacity(TURNS),
            starts: [0; DEPTH + 1],
            last: DescentStep { right: false, node: BridgeInterval::default(), length: 1.0 },
        };
        cursor.descend(&GridTime::ZERO, 0);
        cursor
    }

    /// Starts again on another path, keeping the memory.
    pub(super) fn set_path(&mut self, path: u64) {
        self.source.path = path;
        for page in &mut self.pages {
            page.address.depth = u8::MAX;
        }
        self.octaves.iter_mut().for_each(Vec::clear);
        self.descend(&GridTime::ZERO, 0);
    }

    /// Goes to a point and measures the interval in between, as time goes forward.
    #[inline]
    pub(super) fn increment_to(&mut self, to: &GridTime) -> PathIncrement {
        let from = self.point;
        if from == *to {
            return PathIncrement::EMPTY;
        }
        if from.negative != to.negative {
            let before = self.since_zero();
            self.descend(to, 0);
            return across(before, self.since_zero(), to.negative);
        }
        let parting = SeparatingCut::new(&from, to);
        let outward = to.beyond(&from);
        let behind = self.side(&parting, outward);
        self.descend(to, if let SeparatingCut::Page { page, .. } = parting { page } else { 0 });
        let ahead = self.side(&parting, !outward);
        self.join(&from, behind, ahead, outward)
    }

    /// Goes to a point.
    #[inline]
    pub(super) fn seek(&mut self, to: &GridTime) {
        if self.point != *to {
            let page = match SeparatingCut::new(&self.point, to) {
                SeparatingCut::Page { page, .. } if self.point.negative == to.negative => page,
                _ => 0,
            };
            self.descend(to, page);
        }
    }

    /// Measures the interval between two cursors of one process, as time goes forward.
    pub(super) fn between(&mut self, other: &mut Self) -> PathIncrement {
        let (from, to) = (self.point, other.point);
        if from == to {
            return PathIncrement::EMPTY;
        }
        if from.negative != to.negative {
            return across(self.since_zero(), other.since_zero(), to.negative);
        }
        let parting = SeparatingCut::new(&from, &to);
        let outward = to.beyond(&from);
        let (behind, ahead) = (self.side(&parting, outward), other.side(&parting, !outward));
        other.join(&from, behind, ahead, outward)
    }

    /// Measures the interval between zero and this time, away from zero.
    fn since_zero(&mut self) -> PathIncrement {
        let mut sum = PathIncrement::EMPTY;
        for octave in 0..self.point.octave {
            sum = sum.then(self.octave(self.point.negative, octave));
        }
        sum.then(self.side(&SeparatingCut::Octaves, false))
    }

    /// The part of the interval between two points on this cursor's side of the cut where their descents
    /// separate.
    #[inline]
    fn side(&self, parting: &SeparatingCut, near: bool) -> PathIncrement {
        let start = match *parting {
            SeparatingCut::Octaves => 0,
            SeparatingCut::Page { stop: true, .. } if near => return PathIncrement::EMPTY,
            // If both descents continue, each interval of the cut contains one of the points: neither was
            // passed.
            SeparatingCut::Page { page, cuts, stop } => {
                usize::from(self.starts[page]) + cuts + usize::from(!stop)
            }
        };
        let turns = self.turns[start..].iter();
        let measure =
            |sum: PathIncrement, turn: &DescentStep| sum.then(PathIncrement::of(turn.node, turn.length));
        if near {
            turns
                .rev()
                .filter(|turn| !turn.right)
                .fold(PathIncrement::of(self.last.node, self.last.length), measure)
        } else {
            turns.filter(|turn| turn.right).fold(PathIncrement::EMPTY, measure)
        }
    }

    /// Puts the two sides together; `from` is where `behind` was measured, this cursor is at the other end.
    #[inline]
    fn join(
        &mut self,
        from: &GridTime,
        behind: PathIncrement,
        ahead: PathIncrement,
        outward: bool,
    ) -> PathIncrement {
        let (near, far) = if outward { (behind, ahead) } else { (ahead, behind) };
        let (o, to) = (from.octave.min(self.point.octave), from.octave.max(self.point.octave));
        let mut sum = near;
        for octave in o + 1..to {
            sum = sum.then(self.octave(from.negative, octave));
        }
        sum = sum.then(far);
        if from.negative { sum.mirrored() } else { sum }
    }

    fn octave(&mut self, negative: bool, octave: u8) -> PathIncrement {
        PathIncrement::of(self.octave_node(negative, octave), grid::octave_length(octave))
    }

    fn octave_node(&mut self, negative: bool, octave: u8) -> BridgeInterval {
        let index = usize::from(octave);
        let known = &mut self.octaves[usize::from(negative)];
        if known.len() <= index {
            known.resize(index + 1, None);
        }
        *known[index].get_or_insert_with(|| {
            // The last pair of the octave's first page: its cuts use the others.
            let mut words = Words::EMPTY;
            words.fill(&self.source, &PageAddress { negative, octave, depth: 0, cell: 0 });
            BridgeInterval::draw(grid::octave_length(octave), words.normals(PAIRS - 1))
        })
    }

    /// Descends to `to` from page `from` on; the pages before are shared with the present point.
    fn descend(&mut self, to: &GridTime, from: usize) {
        let mut length = grid::octave_length(to.octave);
        let mut root =
            if from == 0 { self.octave_node(to.negative, to.octave) } else { self.pages[from].nodes[0] };
        let mut cell = 0;
        for page in 0..from {
            let cells = grid::shape(to.octave, page).cells;
            length /= cells as f64;
            cell = cell * cells + u64::from(to.digit(page).0);
        }
        self.turns.truncate(usize::from(self.starts[from]));
        self.last = DescentStep { right: false, node: root, length };
        for depth in from..usize::from(to.pages) {
            self.starts[depth] = self.turns.len() as u8;
            let address = PageAddress { negative: to.negative, octave: to.octave, depth: depth as u8, cell };
            let page = page_at(&mut self.pages, depth);
            if page.address != address {
                page.load(&self.source, address, length, root);
            }
            let shape = grid::shape(to.octave, depth);
            let (digit, ends) = to.digit(depth);
            let mut index = 0;
            let mut branch = &shape.nodes[0];
            while branch.left != 0 && !(ends && digit == branch.first) {
                page.cut(index, branch);
                let left = usize::from(branch.left);
                let right = digit >= branch.middle;
                index = left + usize::from(right);
                let other = left + usize::from(!right);
                let length = length * shape.nodes[other].part;
                self.turns.push(DescentStep { right, node: page.nodes[other], length });
                branch = &shape.nodes[index];
            }
            root = page.nodes[index];
            self.last = DescentStep { right: false, node: root, length: length * branch.part };
            length /= shape.cells as f64;
            cell = cell * shape.cells + u64::from(digit);
        }
        self.point = *to;
    }
}

/// The interval between two points on different sides of zero, from their distances to it.
fn across(from: PathIncrement, to: PathIncrement, backward: bool) -> PathIncrement {
    let (negative, positive) = if backward { (to, from) } else { (from, to) };
    negative.mirrored().then(positive)
}

/// The page of a depth; pages are made once, when a time first needs them.
#[inline]
fn page_at(pages: &mut Vec<Page>, depth: usize) -> &mut Page {
    if pages.len() <= depth {
        let none = PageAddress { negative: false, octave: 0, depth: u8::MAX, cell: 0 };
        let empty = Page {
            address: none,
            scale: IntervalScale::default(),
            words: Words::EMPTY,
            nodes: [BridgeInterval::default(); NODES],
            cut: 0,
        };
        pages.resize(depth + 1, empty);
    }
    &mut pages[depth]
}
