//! The graph of a sparse matrix (unknowns that share an equation), and two orders of the unknowns: one that
//! makes the matrix narrow, and one in which elimination fills few entries.
//!
//! E. Cuthill, J. McKee, "Reducing the bandwidth of sparse symmetric matrices", ACM 1969. A. George, "Nested
//! dissection of a regular finite element mesh", SIAM J. Numer. Anal. 10, 1973, with the separators of A.
//! George, J. W. H. Liu, "An automatic nested dissection algorithm for irregular finite element problems",
//! SIAM J. Numer. Anal. 15, 1978: the middle of a level structure.

/// Parts of at most so many unknowns are not dissected: all entries among them are few.
const LEAF: usize = 16;

/// Where each of `n` lists starts that lie one after the other, and where the last one ends, from the list
/// that each entry belongs to.
pub(super) fn starts(n: usize, entries: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut starts = vec![0; n + 1];
    entries.for_each(|list| starts[list + 1] += 1);
    (0..n).for_each(|list| starts[list + 1] += starts[list]);
    starts
}

/// The lists of a graph, one after the other.
pub(super) struct Neighbours {
    starts: Vec<usize>,
    lists: Vec<usize>,
}

impl Neighbours {
    pub(super) fn new(n: usize, pairs: &[(usize, usize)]) -> Self {
        let starts = starts(n, pairs.iter().flat_map(|&(a, b)| [a, b]));
        let mut ends = starts.clone();
        let mut lists = vec![0; starts[n]];
        for &(a, b) in pairs {
            for (from, to) in [(a, b), (b, a)] {
                lists[ends[from]] = to;
                ends[from] += 1;
            }
        }
        Self { starts, lists }
    }

    pub(super) fn of(&self, unknown: usize) -> &[usize] {
        &self.lists[self.starts[unknown]..self.starts[unknown + 1]]
    }
}

/// The position of each unknown in an order where neighbours are near each other. No pair twice.
pub fn reverse_cuthill_mckee(n: usize, pairs: &[(usize, usize)]) -> Vec<usize> {
    let neighbours = Neighbours::new(n, pairs);
    let mut order = Vec::with_capacity(n);
    let mut met = vec![false; n];
    let (mut swept, mut sweep) = (vec![0; n], 0);
    for seed in 0..n {
        if met[seed] {
            continue;
        }
        // Two sweeps lead to an end of the component.
        let mut start = seed;
        for _ in 0..2 {
            sweep += 1;
            start = farthest(&neighbours, start, &mut swept, sweep);
        }
        met[start] = true;
        let mut next = order.len();
        order.push(start);
        while next < order.len() {
            let mut ring: Vec<usize> =
                neighbours.of(order[next]).iter().copied().filter(|&other| !met[other]).collect();
            ring.sort_by_key(|&other| neighbours.of(other).len());
            for &other in &ring {
                met[other] = true;
            }
            order.extend(ring);
            next += 1;
        }
    }
    let mut position = vec![0; n];
    for (at, &unknown) in order.iter().rev().enumerate() {
        position[unknown] = at;
    }
    position
}

/// The last unknown that a breadth-first search from `start` meets; `met` is marked with `sweep`.
fn farthest(neighbours: &Neighbours, start: usize, met: &mut [usize], sweep: usize) -> usize {
    let (mut ring, mut last) = (vec![start], start);
    met[start] = sweep;
    while !ring.is_empty() {
        let mut next = Vec::new();
        for &unknown in &ring {
            last = unknown;
            for &other in neighbours.of(unknown) {
                if met[other] != sweep {
                    met[other] = sweep;
                    next.push(other);
                }
            }
        }
        ring = next;
    }
    last
}

/// The position of each unknown in an order in which elimination fills few entries. The separator of the two
/// halves comes last; each half is ordered in the same way.
pub(super) fn nested_dissection(n: usize, neighbours: &Neighbours) -> Vec<usize> {
    let mut dissection = Dissection { neighbours, part: vec![0; n], level: vec![0; n], parts: 0 };
    let mut position = vec![0; n];
    let mut left = vec![((0..n).collect::<Vec<_>>(), 0)];
    while let Some((unknowns, mut first)) = left.pop() {
        if unknowns.len() <= LEAF {
            unknowns.iter().enumerate().for_each(|(k, &unknown)| position[unknown] = first + k);
            continue;
        }
        for component in dissection.components(unknowns) {
            let end = first + component.len();
            let [below, above, between] = dissection.separate(component);
            let last = end - between.len();
            between.iter().enumerate().for_each(|(k, &unknown)| position[unknown] = last + k);
            left.push((above, first + below.len()));
            left.push((below, first));
            first = end;
        }
    }
    position
}

/// Parts of a graph that no edge joins any more.
struct Dissection<'a> {
    neighbours: &'a Neighbours,
    /// The part that each unknown belonged to last.
    part: Vec<usize>,
    /// Its distance from where the last search of its part began.
    level: Vec<usize>,
    parts: usize,
}

impl Dissection<'_> {
    /// The connected components of these unknowns, each by distance from one end of it.
    fn components(&mut self, unknowns: Vec<usize>) -> Vec<Vec<usize>> {
        self.parts += 1;
        let all = self.parts;
        unknowns.iter().for_each(|&unknown| self.part[unknown] = all);
        let mut components = Vec::new();
        for unknown in unknowns {
            if self.part[unknown] == all {
                // Two sweeps lead to an end.
                let mut order = self.search(unknown);
                for _ in 0..2 {
                    order = order.last().map_or(Vec::new(), |&end| self.search(end));
                }
                components.push(order);
            }
        }
        components
    }

    /// Two parts of a component that only the third joins.
    fn separate(&self, order: Vec<usize>) -> [Vec<usize>; 3] {
        let Some(&half) = order.get(order.len() / 2) else { return Default::default() };
        let part = self.part[half];
        let middle = self.level[half];
        let (mut below, mut above, mut between) = (Vec::new(), Vec::new(), Vec::new());
        for unknown in order {
            let joins = |&other: &usize| self.part[other] == part && self.level[other] > middle;
            match self.level[unknown].cmp(&middle) {
                std::cmp::Ordering::Greater => above.push(unknown),
                std::cmp::Ordering::Equal if self.neighbours.of(unknown).iter().any(joins) => {
                    between.push(unknown);
                }
                _ => below.push(unknown),
            }
        }
        // A part without a level behind the middle comes last as a whole.
        if above.is_empty() { [Vec::new(), Vec::new(), below] } else { [below, above, between] }
    }

    /// The unknowns that are connected with this one in its part, by distance from it.
    fn search(&mut self, start: usize) -> Vec<usize> {
        let part = self.part[start];
        self.parts += 1;
        self.part[start] = self.parts;
        self.level[start] = 0;
        let (mut order, mut next) = (vec![start], 0);
        while next < order.len() {
            let unknown = order[next];
            for &other in self.neighbours.of(unknown) {
                if self.part[other] == part {
                    self.part[other] = self.parts;
                    self.level[other] = self.level[unknown] + 1;
                    order.push(other);
                }
            }
            next += 1;
        }
        order
    }
}
