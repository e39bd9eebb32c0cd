//! Contractions of derivatives of one function `H(q, p)`, as trees.
//!
//! A vertex stands for `H`, an edge for `Σ_i (∂/∂p_i of one end) (∂/∂q_i of the other)`: one vertex is `H`
//! itself, an edge `H_p · H_q`, and a vertex with two coordinates towards its neighbours `H_qq(H_p, H_p)`.
//! (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, section IX.10: elementary
//! Hamiltonians.)

use std::iter::once;

/// The half of the phase space by which an end of an edge differentiates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum PhaseHalf {
    Coordinates,
    Momenta,
}

impl PhaseHalf {
    pub(super) fn other(self) -> Self {
        match self {
            Self::Coordinates => Self::Momenta,
            Self::Momenta => Self::Coordinates,
        }
    }
}

/// An edge with its subtree: the half by which its near end is differentiated, and the tree at its far end.
pub(super) type Branch = (PhaseHalf, Tree);

/// A tree seen from one of its vertices, its root. Branches are sorted, so that equal trees compare equal.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Tree {
    pub(super) branches: Vec<Branch>,
}

impl Tree {
    pub(super) fn new(mut branches: Vec<Branch>) -> Self {
        branches.sort();
        Self { branches }
    }

    /// The number of vertices.
    #[cfg(test)]
    pub(super) fn size(&self) -> usize {
        1 + self.branches.iter().map(|(_, tree)| tree.size()).sum::<usize>()
    }

    /// The numbers of edges whose end towards the root is differentiated by coordinates, and by momenta.
    pub(super) fn edges(&self) -> [i32; 2] {
        let of_branch = |(half, tree): &Branch| {
            let [q, p] = tree.edges();
            if *half == PhaseHalf::Coordinates { [q + 1, p] } else { [q, p + 1] }
        };
        self.branches.iter().map(of_branch).fold([0, 0], |[q, p], [a, b]| [q + a, p + b])
    }

    fn with(&self, branch: Branch) -> Self {
        Self::new(self.branches.iter().cloned().chain(once(branch)).collect())
    }

    /// This tree seen from each of its vertices.
    pub(super) fn rootings(&self) -> Vec<Self> {
        let mut rootings = vec![self.clone()];
        for (at, (half, beyond)) in self.branches.iter().enumerate() {
            let mut rest = self.branches.clone();
            rest.remove(at);
            // This side becomes a branch of every vertex on the other side.
            let stub = (half.other(), Self { branches: rest });
            rootings.extend(beyond.rooted_with(&stub));
        }
        rootings
    }

    /// The tree with one more branch, seen from each of its original vertices.
    fn rooted_with(&self, stub: &Branch) -> Vec<Self> {
        let whole = self.with(stub.clone());
        let mut rootings = vec![whole];
        for (at, (half, beyond)) in self.branches.iter().enumerate() {
            let mut rest = self.branches.clone();
            rest.remove(at);
            let near = Self { branches: rest }.with(stub.clone());
            rootings.extend(beyond.rooted_with(&(half.other(), near)));
        }
        rootings
    }

    /// The canonical rooting: the first of least depth.
    pub(super) fn free(&self) -> Self {
        let rootings = self.rootings();
        rootings.into_iter().min_by(|a, b| (a.depth(), a).cmp(&(b.depth(), b))).unwrap_or_default()
    }

    fn depth(&self) -> usize {
        self.branches.iter().map(|(_, tree)| 1 + tree.depth()).max().unwrap_or(0)
    }

    /// Two trees joined by an edge between their roots, the first root being differentiated by `half`.
    pub(super) fn joined(&self, half: PhaseHalf, other: &Self) -> Self {
        self.with((half, other.clone()))
    }
}

/// All rooted trees of each size below `sizes`, from 0, each with the inverse of the number of its
/// symmetries.
pub(super) fn rooted(sizes: usize) -> Vec<Vec<(Tree, f64)>> {
    let mut trees: Vec<Vec<(Tree, f64)>> = vec![Vec::new()];
    for size in 1..sizes {
        let mut branches = Vec::new();
        for (size, trees) in trees.iter().enumerate() {
            for half in [PhaseHalf::Coordinates, PhaseHalf::Momenta] {
                branches.extend(trees.iter().map(|(tree, weight)| ((half, tree.clone()), size, *weight)));
            }
        }
        let mut of_size = Vec::new();
        grow(&branches, size - 1, &mut Vec::new(), 1.0, &mut of_size);
        trees.push(of_size);
    }
    trees
}

/// Adds the trees with the chosen branches and `left` more vertices in others of `branches`, which are sorted
/// by size.
fn grow(
    branches: &[(Branch, usize, f64)],
    left: usize,
    chosen: &mut Vec<Branch>,
    weight: f64,
    into: &mut Vec<(Tree, f64)>,
) {
    if left == 0 {
        into.push((Tree::new(chosen.clone()), weight));
        return;
    }
    let fitting = branches.iter().take_while(|(_, size, _)| *size <= left);
    for (i, (branch, size, factor)) in fitting.enumerate() {
        let (before, mut weight) = (chosen.len(), weight);
        for times in 1..=left / size {
            weight *= factor / times as f64;
            chosen.push(branch.clone());
            grow(&branches[i + 1..], left - times * size, chosen, weight, into);
        }
        chosen.truncate(before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_as_many_trees_as_are_counted() {
        // Rooted and free trees with oriented edges: sequences A000151 and A000238 of the encyclopedia of
        // integer sequences.
        let trees = rooted(6);
        let rooted: Vec<usize> = trees.iter().map(Vec::len).collect();
        assert_eq!(rooted, [0, 1, 2, 7, 26, 107]);
        let free = |trees: &Vec<(Tree, f64)>| {
            let mut free: Vec<Tree> = trees.iter().map(|(tree, _)| tree.free()).collect();
            free.sort();
            free.dedup();
            free.len()
        };
        assert_eq!(trees.iter().map(free).collect::<Vec<_>>(), [0, 1, 1, 3, 8, 27]);
    }

    #[test]
    fn a_tree_is_the_same_from_every_vertex() {
        for (tree, _) in rooted(6).into_iter().flatten() {
            let rootings = tree.rootings();
            assert_eq!(rootings.len(), tree.size());
            for other in rootings {
                assert_eq!((other.size(), other.free()), (tree.size(), tree.free()));
            }
        }
    }
}
