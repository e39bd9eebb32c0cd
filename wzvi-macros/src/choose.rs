//! The form of every step, chosen before anything is written out: straight-line code with a variable for each
//! degree of freedom, or loops over elements. Elements that are refused in loops are written out all the
//! same, if they are few: see `analyse` in `compile.rs`.
//!
//! The choice reads a sketch of the system, made of its elements in loops: the second derivatives of each
//! element, placed at every turn of its loops, and the operations of all placements together. The sketch
//! gives the blocks that a step solves. A block is a set of unknowns that read each other, and an equation
//! reads what its slope reads:
//!
//! | slope | equation | of points `l` | reads |
//! |---|---|---|---|
//! | `∂F/∂p_i` | `u_i` | all | `v_j`; `u_j` if `l ≠ 0` |
//! | `∂F/∂q_i`, `f_i` | `v_i` | `l ≠ 1` | `v_j`; `u_j` if `l ≠ 0` |
//!
//! No derivative of the whole system is taken, and no sum is written out.

use std::collections::BTreeMap;

use crate::discretise::structure::MOST_ISOLATED;
use crate::discretise::{ByUnknown, Dependencies, Unknown};
use crate::embedding::{Correction, Embedding, Points};
use crate::model::{Element, Form, Half, Index, Loop, Slot, System};
use crate::passes::collect::sketched;
use crate::symbolic::{Expr, Graph, Node, Symbol};

/// The most unknowns of a block of a step in straight lines: six sites of which one half of the phase space
/// is unknown, three where both are. For chains, rings and pairs with the mid-point a step of six sites takes
/// 0.7 to 1.0 of the time of elements without loops, alone and in ensembles, and at eight 0.9 to 1.2. Where
/// both halves are unknown, three sites take 0.9 to 1.2 of the time of loops, and four 1.4 to 1.7. (Both
/// forms were forced by setting this constant. `cargo bench --workspace --bench seam` shows the chosen one
/// beside loops of a const generic size.)
const MOST_UNKNOWNS: usize = 6;

/// How many operations straight lines may have beyond those of the elements in loops, by what a step does
/// with them. Code and expansion grow with these, and what straight lines gain in speed falls.
/// (`cargo bench --workspace --bench choose`.)
struct MostAdded;

impl MostAdded {
    /// For explicit steps, which evaluate each slope once: chains to 7 sites, 3 bodies in space. At 8 sites
    /// straight lines take 0.8 of the time of loops, at 4 bodies 0.83, for more than twice the code.
    const EXPLICIT: usize = 60;
    /// For stages, whose slopes fill the lanes of a register: chains to 9 sites, 3 bodies in space. At 8
    /// sites they take 0.65 of the time of loops, at 16 sites and 4 bodies 0.83.
    const STAGES: usize = 80;
    /// For steps that solve blocks, each by its own elimination.
    const SOLVED: usize = 150;
}

/// The most constraints of a system in straight lines, whose matrices are arrays.
const MOST_CONSTRAINTS: i128 = 6;

/// The most placements of elements in a sketch. A system with more is not written out.
const MOST_PLACEMENTS: usize = 4096;

/// The most terms of a sum that a sketch writes out: a nonlinear function of more is in loops.
const MOST_WRITTEN: i128 = 16;

/// The forms of everything that is emitted.
pub(crate) struct Choice {
    /// The forms of the steps with one `P`.
    steps: Vec<(Embedding, Form)>,
    /// The form of the slopes of the step Hamiltonian, which `Gauss<S>` and flows take.
    pub(crate) slopes: Form,
    /// The form of the elements, which all schemes share: straight lines if every listed scheme takes these.
    pub(crate) elements: Form,
}

impl Choice {
    fn all(form: Form) -> Self {
        Self { steps: Vec::new(), slopes: form, elements: form }
    }

    /// The form of a step with one `P`.
    pub(crate) fn of(&self, step: &Embedding) -> Form {
        self.steps.iter().find(|(known, _)| known == step).map_or(self.elements, |(_, form)| *form)
    }

    /// Whether anything is in straight lines.
    pub(crate) fn has_straight_lines(&self) -> bool {
        [self.slopes, self.elements].contains(&Form::StraightLines)
            || self.steps.iter().any(|(_, form)| *form == Form::StraightLines)
    }
}

/// Chooses the forms of the listed schemes.
pub(crate) fn choose(system: &mut System, listed: &[Embedding]) -> Choice {
    let Some(sketch) = Sketch::of(system) else { return Choice::all(Form::Loops) };
    if !system.constraints.is_empty() {
        let constraints = system.constraint_offsets().last().and_then(Index::as_integer);
        let are_few = constraints.is_some_and(|number| number <= MOST_CONSTRAINTS);
        let is_straight = are_few && sketch.operations <= sketch.in_loops + MostAdded::EXPLICIT;
        return Choice::all(if is_straight { Form::StraightLines } else { Form::Loops });
    }
    let of = |is_straight: bool| if is_straight { Form::StraightLines } else { Form::Loops };
    let adds_at_most = |most: usize| sketch.operations <= sketch.in_loops + most;
    let takes_stages = listed.iter().any(|embedding| embedding.stages().is_some());
    let takes_flows = listed.iter().any(Embedding::takes_flows);
    let are_slopes_straight = (takes_stages && adds_at_most(MostAdded::STAGES))
        || (takes_flows && adds_at_most(MostAdded::EXPLICIT));
    let mut are_straight = are_slopes_straight || !(takes_stages || takes_flows);
    let mut steps: Vec<(Embedding, Form)> = Vec::new();
    for embedding in listed {
        let is_of_slopes = embedding.stages().is_some() || sketch.has_flows && embedding.takes_flows();
        for step in embedding.substeps() {
            let is_straight = match is_of_slopes {
                true => are_slopes_straight,
                false => match sketch.largest_block(&step) {
                    None => adds_at_most(MostAdded::EXPLICIT),
                    Some(unknowns) => unknowns <= MOST_UNKNOWNS && adds_at_most(MostAdded::SOLVED),
                },
            };
            are_straight &= is_straight;
            if !steps.iter().any(|(known, _)| *known == step) {
                steps.push((step, of(is_straight)));
            }
        }
    }
    Choice { steps, slopes: of(are_slopes_straight), elements: of(are_straight) }
}

/// An equation, named by the unknown that it is for, that reads an unknown.
struct Coupling {
    equation: Unknown,
    unknown: Unknown,
    /// The unknowns on which the derivative of the equation by this one depends.
    varies_with: Vec<Unknown>,
}

/// The blocks and the operations of a system, by which the forms are chosen.
struct Sketch {
    degrees: usize,
    /// Operations of all placements together.
    operations: usize,
    /// Operations of each element once.
    in_loops: usize,
    drift: Vec<Coupling>,
    noise: Vec<Coupling>,
    /// Whether noises read coordinates, and whether momenta.
    noise_reads: [bool; 2],
    has_flows: bool,
    /// Whether products of noises join the drift, from Ito to Stratonovich.
    has_correction: bool,
}

impl Sketch {
    /// `None` if the size or a place is known at run time only, or if elements have more than
    /// [`MOST_PLACEMENTS`].
    fn of(system: &mut System) -> Option<Self> {
        let points = system.size.as_integer()?;
        let degrees = usize::try_from(points.checked_mul(system.components)?).ok()?;
        let has_phase = !system.symbols.phase()[0].is_empty();
        let [drift, noise] = sketched(system, MOST_WRITTEN).filter(|_| has_phase)?;
        let is_drawn = system.friction.is_some() && !system.has_thermostat();
        let has_correction = system.ito.is_some();
        let mut placer =
            Placer { graph: &mut system.graph, degrees, left: MOST_PLACEMENTS, operations: 0, in_loops: 0 };
        let has_flows =
            !is_drawn && drift.iter().chain(&noise).all(|element| placer.is_flow(element, system.t));
        let noise_reads = [Half::Coordinates, Half::Momenta]
            .map(|half| noise.iter().any(|element| element.of_half(half).next().is_some()));
        let [drift, noise] = [drift, noise].map(|elements| placer.couplings(&elements));
        let (drift, noise, operations, in_loops) = (drift?, noise?, placer.operations, placer.in_loops);
        Some(Self { degrees, operations, in_loops, drift, noise, noise_reads, has_flows, has_correction })
    }

    /// The most unknowns that a step iterates on together by Newton's method; `None` if it is explicit.
    fn largest_block(&self, step: &Embedding) -> Option<usize> {
        let [of_drift, of_noise] = step.points();
        let mut couplings: Vec<Coupling> =
            self.drift.iter().filter_map(|known| self.taken(known, &of_drift)).collect();
        couplings.extend(self.noise.iter().filter_map(|known| self.taken(known, &of_noise)));
        if self.has_correction || step.correction() == Correction::Corrected {
            couplings.extend(self.products().iter().filter_map(|known| self.taken(known, &of_noise)));
        }
        let mut reads = ByUnknown::of(self.degrees, |_| Vec::new());
        for Coupling { equation, unknown, .. } in &couplings {
            if !reads[*equation].contains(unknown) {
                reads[*equation].push(*unknown);
            }
        }
        let components = Dependencies::of(reads.clone()).components();
        let mut block_of = ByUnknown::of(self.degrees, |_| 0);
        for (block, component) in components.iter().enumerate() {
            component.iter().for_each(|&unknown| block_of[unknown] = block);
        }
        let is_assigned =
            |component: &Vec<Unknown>| component.len() == 1 && !reads[component[0]].contains(&component[0]);
        if components.iter().all(is_assigned) {
            return None;
        }
        let mut is_newton = vec![false; components.len()];
        for Coupling { equation, unknown, varies_with } in &couplings {
            let block = block_of[*equation];
            is_newton[block] |=
                block_of[*unknown] == block && varies_with.iter().any(|&other| block_of[other] == block);
        }
        // An equation that is affine in its own unknown is solved for it.
        let own: Vec<&Coupling> = couplings.iter().filter(|known| known.equation == known.unknown).collect();
        for Coupling { unknown, .. } in &own {
            let is_affine = own
                .iter()
                .filter(|other| other.unknown == *unknown)
                .all(|other| other.varies_with.is_empty());
            if is_affine && components[block_of[*unknown]].len() <= MOST_ISOLATED {
                reads[*unknown].retain(|known| known != unknown);
            }
        }
        let dependencies = Dependencies::of(reads);
        let hard = components.iter().zip(is_newton).filter(|(_, is_newton)| *is_newton);
        let iterates = hard.map(|(component, _)| dependencies.split(component).0.len());
        Some(iterates.max().unwrap_or(0))
    }

    /// The couplings of products `∂H_j/∂q · ∂H_k/∂p` of noises: everything that noises at one place read.
    fn products(&self) -> Vec<Coupling> {
        let mut products = Vec::new();
        for place in 0..self.degrees {
            let there = self.noise.iter().filter(|known| known.equation.degree() == place);
            let mut read: Vec<Unknown> = there.map(|known| known.unknown).collect();
            read.sort_unstable();
            read.dedup();
            let equations = read.iter().map(|unknown| unknown.conjugate());
            for equation in equations.filter(|_| self.noise_reads == [true, true]) {
                products.extend(read.iter().map(|&unknown| Coupling {
                    equation,
                    unknown,
                    varies_with: read.clone(),
                }));
            }
        }
        products
    }

    /// The coupling in steps with these points, if it is there.
    fn taken(&self, known: &Coupling, points: &Points) -> Option<Coupling> {
        let is_of_q = |unknown: Unknown| matches!(unknown, Unknown::Q(_));
        let taken = points.iter().filter(|(l, _)| is_of_q(known.equation) || !l.is_one());
        let taken: Vec<_> = taken.collect();
        let moves = taken.iter().any(|(l, _)| !l.is_zero());
        let is_there = if is_of_q(known.unknown) { moves } else { !taken.is_empty() };
        let varies_with = known.varies_with.iter().copied().filter(|&unknown| moves || !is_of_q(unknown));
        is_there.then(|| Coupling { varies_with: varies_with.collect(), ..*known })
    }
}

/// Places elements at the turns of their loops.
struct Placer<'g> {
    graph: &'g mut Graph,
    degrees: usize,
    /// How many more placements may be looked at.
    left: usize,
    operations: usize,
    in_loops: usize,
}

/// Two locals of an element, by their numbers: the slope by the first reads the second.
struct Pair {
    slope: usize,
    read: usize,
    /// The locals on which the derivative of that slope by `read` depends.
    varies_with: Vec<usize>,
}

impl Placer<'_> {
    fn couplings(&mut self, elements: &[Element]) -> Option<Vec<Coupling>> {
        let mut couplings = Vec::new();
        for element in elements {
            let (pairs, nodes) = (self.pairs(element), self.graph.reachable(&[element.value]).len());
            self.in_loops += nodes;
            let mut values = BTreeMap::new();
            self.place(element, &pairs, nodes, &element.loops, &mut values, &mut couplings)?;
        }
        Some(couplings)
    }

    /// Whether no term of an element reads momenta together with coordinates, the time or a displacement.
    fn is_flow(&self, element: &Element, t: Symbol) -> bool {
        terms(self.graph, element.value).iter().all(|&term| {
            let reads =
                |half| element.of_half(half).any(|(symbol, _)| self.graph.depends_on(term, &[symbol]));
            !reads(Half::Momenta)
                || !(reads(Half::Coordinates)
                    || reads(Half::Displacements)
                    || self.graph.depends_on(term, &[t]))
        })
    }

    /// The pairs of an element's variables that its slopes couple, term by term.
    fn pairs(&mut self, element: &Element) -> Vec<Pair> {
        let symbol_of = |local: usize| element.locals[local].symbol;
        let displacements: Vec<Symbol> = element.displacements().map(|(symbol, _)| symbol).collect();
        let mut pairs = Vec::new();
        for term in terms(self.graph, element.value) {
            let is_state_of_term = |&local: &usize| {
                matches!(element.locals[local].slot, Slot::State(..))
                    && self.graph.depends_on(term, &[symbol_of(local)])
            };
            let (displaced, moving): (Vec<usize>, Vec<usize>) = (0..element.locals.len())
                .filter(is_state_of_term)
                .partition(|&local| displacements.contains(&symbol_of(local)));
            // A force is linear in its displacements; its components are the slopes by these.
            let directions = if displaced.is_empty() { &moving } else { &displaced };
            for &direction in directions {
                let slope = self.graph.derivative(term, symbol_of(direction));
                for &read in &moving {
                    if self.graph.depends_on(slope, &[symbol_of(read)]) {
                        let varies_with = self.varying(element, &moving, slope, symbol_of(read));
                        pairs.push(Pair { slope: direction, read, varies_with });
                    }
                }
            }
        }
        pairs
    }

    /// The locals among `moving` on which the derivative of a slope by `symbol` depends. All of them if the
    /// slope has pieces.
    fn varying(&mut self, element: &Element, moving: &[usize], slope: Expr, symbol: Symbol) -> Vec<usize> {
        if self.graph.has_pieces(slope, &[symbol]) {
            return moving.to_vec();
        }
        let derivative = self.graph.derivative(slope, symbol);
        let is_read = |&&local: &&usize| self.graph.depends_on(derivative, &[element.locals[local].symbol]);
        moving.iter().filter(is_read).copied().collect()
    }

    /// Adds the couplings of every placement of an element; `None` if a place or a bound is unknown, or if
    /// they are too many.
    fn place(
        &mut self,
        element: &Element,
        pairs: &[Pair],
        nodes: usize,
        loops: &[Loop],
        values: &mut BTreeMap<u32, i128>,
        couplings: &mut Vec<Coupling>,
    ) -> Option<()> {
        let known = |index: &Index, values: &BTreeMap<u32, i128>| {
            index.at(values).and_then(|index| index.as_integer())
        };
        if let Some((outermost, inner)) = loops.split_first() {
            for turn in known(&outermost.start, values)?..known(&outermost.end, values)? {
                values.insert(outermost.variable, turn);
                self.place(element, pairs, nodes, inner, values, couplings)?;
            }
            values.remove(&outermost.variable);
            return Some(());
        }
        self.left = self.left.checked_sub(1)?;
        self.operations += nodes;
        let mut unknowns = Vec::with_capacity(element.locals.len());
        for local in &element.locals {
            unknowns.push(match &local.slot {
                Slot::State(half, index) => {
                    let place =
                        usize::try_from(known(index, values)?).ok().filter(|place| *place < self.degrees)?;
                    Some(if *half == Half::Momenta { Unknown::P(place) } else { Unknown::Q(place) })
                }
                _ => None,
            });
        }
        // Pairs are of locals of the state.
        for pair in pairs {
            couplings.push(Coupling {
                equation: unknowns[pair.slope]?.conjugate(),
                unknown: unknowns[pair.read]?,
                varies_with: pair.varies_with.iter().map(|&local| unknowns[local]).collect::<Option<_>>()?,
            });
        }
        Some(())
    }
}

/// The terms of a sum.
fn terms(graph: &Graph, value: Expr) -> Vec<Expr> {
    match graph.node(value) {
        Node::Sum { terms, .. } => terms.iter().map(|(term, _)| *term).collect(),
        _ => vec![value],
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop")]

    use std::rc::Rc;

    use super::*;
    use crate::diagnostics::Diagnostics;
    use crate::discretise::{Facts, Quadrature, Solution, discretise};
    use crate::input;
    use crate::lower::lower;
    use crate::passes::collect::collect;
    use crate::passes::unroll::{unroll, written_out};

    const ITEM: &str = "struct S { a: f64, k: [f64; 16] }";

    fn lowered(attribute: &str) -> System {
        let mut diagnostics = Diagnostics::new();
        let container = input::read_struct(ITEM.parse().unwrap(), &mut diagnostics).unwrap();
        let mut declaration = input::read_attribute(attribute.parse().unwrap(), &mut diagnostics).unwrap();
        let phase_space = input::read_phase_space(&mut declaration, &mut diagnostics).unwrap();
        let system = lower(container, declaration, &phase_space, &mut diagnostics).unwrap();
        assert!(diagnostics.finish().is_ok(), "{attribute}");
        system
    }

    fn listed(system: &System) -> Vec<Embedding> {
        system.embeddings.iter().map(|known| known.value.clone()).collect()
    }

    /// The blocks that the equations have, and those of the sketch.
    fn blocks(attribute: &str) -> Vec<[usize; 2]> {
        let mut system = lowered(attribute);
        let (steps, sketch) = (listed(&system), Sketch::of(&mut system).unwrap());
        system.form = Form::StraightLines;
        unroll(&mut system);
        let mut diagnostics = Diagnostics::new();
        collect(&mut system, &mut diagnostics);
        assert!(diagnostics.finish().is_ok(), "{attribute}");
        let facts = Facts::new(&mut system);
        let line = Rc::new(written_out(&mut system).unwrap());
        let of_step = |step: &Embedding| {
            let scheme = discretise(&mut system.graph, line.clone(), &Quadrature::new(&facts, step));
            let is_newton = |solution: &Solution| matches!(solution, Solution::Newton { .. });
            let blocks = scheme.structure.blocks.iter().filter(|block| is_newton(&block.solution));
            [
                blocks.map(|block| block.iterates.len()).max().unwrap_or(0),
                sketch.largest_block(step).unwrap_or(0),
            ]
        };
        steps.iter().map(of_step).collect()
    }

    #[test]
    fn the_sketch_has_the_blocks_of_the_equations() {
        let schemes = "embedding = [Uncorrected<DeltaPlus>, Uncorrected<DeltaMinus>, Uncorrected<Lambda<1, 4>>, Midpoint, \
             Uncorrected<Mixed<DeltaPlus, Midpoint>>]";
        let drifts = [
            "|q: [f64; 4], p: [f64; 4]| (0..4).map(|i| 0.5 * p[i] * p[i] - k[i] * q[i].cos()).sum::<f64>()",
            "|q: [f64; 4], p: [f64; 4]| (0..4).map(|i| 0.5 * p[i] * p[i]).sum::<f64>() + (1..4).map(|i| (q[i] - q[i - 1]).powi(4)).sum::<f64>()",
            "|q: [f64; 4], p: [f64; 4]| (0..4).map(|i| 0.5 * (p[i] * p[i] + k[i] * q[i] * q[i])).sum::<f64>() + q[0] * q[3]",
            "|q: [f64; 4], p: [f64; 4]| (0..4).map(|i| 0.5 * p[i] * p[i] / (1.0 + q[i] * q[i])).sum::<f64>()",
            "|q: [f64; 4], p: [f64; 4]| (0..3).map(|i| p[i] * p[i + 1]).sum::<f64>() + (0..4).map(|i| q[i].powi(4)).sum::<f64>()",
            "|[x, y, z], [px, py, pz]| 0.5 * (px * px + py * py + a * pz * pz) + x * x * y - z.cos() + x * py - y * px",
            "|q: [[f64; 2]; 2], p: [[f64; 2]; 2]| 0.5 * (p[0][0] * p[0][0] + p[0][1] * p[0][1] + p[1][0] * p[1][0] + p[1][1] * p[1][1]) \
                 - a / ((q[0][0] - q[1][0]).powi(2) + (q[0][1] - q[1][1]).powi(2)).sqrt()",
            "|q: [f64; 4], p: [f64; 4]| (0..4).map(|i| 0.5 * p[i] * p[i] + if q[i] > 0.0 { q[i] * q[i] } else { 0.0 }).sum::<f64>()",
        ];
        let noises = [
            "",
            "noise = [|q, p| a * q[0]], ",
            "noise = [|q, p, i| a * q[i] * p[i]; 4], ",
            "noise = [|q, p| a * q[0].powi(3) * p[1]], ",
        ];
        let mut compared = 0;
        for drift in drifts {
            for noise in noises.iter().filter(|noise| noise.is_empty() || drift.contains("f64; 4]")) {
                let attribute = format!("drift = {drift}, {noise}{schemes}");
                for (place, [found, sketched]) in blocks(&attribute).into_iter().enumerate() {
                    assert_eq!(found, sketched, "scheme {place} of {attribute}");
                    compared += 1;
                }
            }
        }
        assert_eq!(compared, 5 * (6 * 4 + 2));
    }

    #[test]
    fn forms_follow_from_blocks_and_operations() {
        let chain = |n: usize| {
            format!(
                "drift = |q: [f64; {n}], p: [f64; {n}]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() \
                 + (1..{n}).map(|i| a * (q[i] - q[i - 1]).powi(4)).sum::<f64>(), embedding = [Midpoint, Verlet]"
            )
        };
        let bodies = |n: usize| {
            format!(
                "drift = |q: [[f64; 3]; {n}], p: [[f64; 3]; {n}]| p.iter().map(|p| 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])).sum::<f64>() \
                 - (0..{n}).map(|i| (0..i).map(|j| a / ((q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2) + (q[i][2] - q[j][2]).powi(2)).sqrt()) \
                 .sum::<f64>()).sum::<f64>(), embedding = [Midpoint, Verlet]"
            )
        };
        let pendulums = "drift = |q: [f64; 16], p: [f64; 16]| (0..16).map(|i| 0.5 * p[i] * p[i] - k[i] * q[i].cos()).sum::<f64>(), \
                         embedding = [Midpoint, Verlet]";
        use Form::{Loops, StraightLines};
        let forms = |attribute: &str| {
            let mut system = lowered(attribute);
            let embeddings = listed(&system);
            let choice = choose(&mut system, &embeddings);
            [choice.of(&Embedding::Midpoint), choice.slopes, choice.elements]
        };
        assert_eq!(forms(&chain(6)), [StraightLines; 3]);
        assert_eq!(forms(&chain(7))[0], Loops);
        assert_eq!(forms(&chain(16)), [Loops; 3]);
        assert_eq!(forms(&bodies(2)), [StraightLines; 3]);
        assert_eq!(forms(&bodies(3)), [Loops, StraightLines, Loops]);
        assert_eq!(forms(&bodies(4)), [Loops; 3]);
        assert_eq!(forms(&bodies(16)), [Loops; 3]);
        assert_eq!(forms(pendulums), [StraightLines, Loops, Loops]);
    }
}
