//! The model: the user's Hamiltonians as sums of elements.
//!
//! ```text
//! H = Σ_e Σ_(loops of e) H_e(locals of e)
//! ```
//!
//! An element is a scalar expression without loops, in a few local variables, and the loops that place it. A
//! local variable is a component of `q` or `p`, an entry of a field, or a number made of loop variables; its
//! index is an [`Index`]. The element of a small system has no loops, and locals with constant indices; that
//! is the only difference.

use std::rc::Rc;

use proc_macro2::TokenStream;

pub(crate) use self::collective::{Collective, CollectiveRole, CollectiveSlot, Collectives, Variables};
pub(crate) use self::index::{Atom, Bounds, Index, IndexOperation, Loop, Outlier};
use self::symbols::Symbols;
use crate::diagnostics::{Extent, Located, promised};
use crate::embedding::{ClockedEmbedding, Embedding};
use crate::input::{Labels, Shape};
use crate::symbolic::{Expr, Graph, Symbol};

pub(crate) mod collective;
pub(crate) mod display;
pub(crate) mod index;
pub(crate) mod symbols;

/// The phase space: one symbol per coordinate and momentum, in the order of the state vector, and time.
#[derive(Clone)]
pub(crate) struct Phase {
    pub(crate) q: Vec<Symbol>,
    pub(crate) p: Vec<Symbol>,
    /// `δq`
    pub(crate) displacements: Vec<Symbol>,
    pub(crate) t: Symbol,
}

impl Phase {
    /// The components of a covector from `f · δq`.
    pub(crate) fn components(&self, graph: &mut Graph, work: Expr) -> Vec<Expr> {
        self.displacements.iter().map(|&displacement| graph.derivative(work, displacement)).collect()
    }
}

/// A real number that a step reads from the struct or its surroundings.
#[derive(Clone)]
pub(crate) struct Parameter {
    pub(crate) symbol: Symbol,
    /// An `f64` expression in which `self` is a reference to the struct.
    pub(crate) tokens: TokenStream,
    /// Whether it is an integer as a real number, by which nothing has a derivative.
    pub(crate) is_integer: bool,
}

/// A list or an integer that the struct or a constant holds.
#[derive(Clone, Default)]
pub(crate) struct Table {
    /// The displayed name.
    pub(crate) name: String,
    /// The tokens that read it in a method of the struct.
    pub(crate) tokens: TokenStream,
    /// The tokens after the indices: the part of a tuple, or the length of a list inside.
    pub(crate) suffix: TokenStream,
    /// Whether its entries are known not to be negative.
    pub(crate) is_unsigned: bool,
    /// Whether the Hamiltonian divides by its entries: see `passes/divisors.rs`.
    pub(crate) is_nonzero: bool,
    /// The lengths of the list and of those inside of it, where they are literals.
    pub(crate) lengths: Vec<Option<usize>>,
}

/// The conjugate halves of the phase space, and the virtual displacements `δq` of the coordinates: a covector
/// `f` is the function `f · δq`.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Half {
    Coordinates,
    Momenta,
    Displacements,
}

/// The place of the value of a local variable.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Slot {
    /// Component of one half, counted as in the state vector.
    State(Half, Index),
    /// Entry of a list of real numbers.
    Entry(u32, Vec<Index>),
    /// An integer as a real number.
    Number(Index),
    /// A collective variable.
    Collective(CollectiveSlot),
}

/// A local variable.
#[derive(Clone)]
pub(crate) struct Local {
    pub(crate) symbol: Symbol,
    pub(crate) slot: Slot,
}

/// A scalar function and the loops that place it, outermost first.
#[derive(Clone)]
pub(crate) struct Element {
    pub(crate) loops: Vec<Loop>,
    pub(crate) value: Expr,
    /// The variables that `value` reads, in order of creation.
    pub(crate) locals: Vec<Local>,
}

/// Whether an element reads coordinates, and whether momenta.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct Reads {
    pub(crate) q: bool,
    pub(crate) p: bool,
}

impl Reads {
    pub(crate) fn or(self, other: Self) -> Self {
        Self { q: self.q || other.q, p: self.p || other.p }
    }
}

impl Element {
    /// The variables in one half of the state.
    pub(crate) fn of_half(&self, half: Half) -> impl Iterator<Item = (Symbol, &Index)> {
        self.locals.iter().filter_map(move |local| match &local.slot {
            Slot::State(own, index) if *own == half => Some((local.symbol, index)),
            _ => None,
        })
    }

    pub(crate) fn coordinates(&self) -> impl Iterator<Item = (Symbol, &Index)> {
        self.of_half(Half::Coordinates)
    }

    pub(crate) fn momenta(&self) -> impl Iterator<Item = (Symbol, &Index)> {
        self.of_half(Half::Momenta)
    }

    pub(crate) fn displacements(&self) -> impl Iterator<Item = (Symbol, &Index)> {
        self.of_half(Half::Displacements)
    }

    /// Whether it is a part of a covector: a Hamiltonian has no displacements.
    pub(crate) fn is_covector(&self) -> bool {
        self.displacements().next().is_some()
    }

    /// The variables of the state: coordinates, then momenta.
    pub(crate) fn state(&self) -> Vec<Symbol> {
        self.coordinates().chain(self.momenta()).map(|(symbol, _)| symbol).collect()
    }

    /// Whether an element reads coordinates, and whether momenta, by itself or by collective variables.
    pub(crate) fn reads(&self) -> Reads {
        let own = Reads { q: self.coordinates().next().is_some(), p: self.momenta().next().is_some() };
        self.collectives().map(|(_, slot)| slot.reads).fold(own, Reads::or)
    }
}

/// A Hamiltonian, or a covector as a function that is linear in displacements.
#[derive(Clone)]
pub(crate) struct Term {
    /// As the user wrote it, with a symbol for each sum: until elements are made of it.
    pub(crate) expression: Expr,
    /// Each reads only coordinates, only momenta, or what cannot be parted: for derivatives.
    pub(crate) elements: Vec<Element>,
    /// The elements as the user wrote them: for values, which keep their digits.
    pub(crate) values: Vec<Element>,
    pub(crate) extent: Extent,
}

/// A noise, or a family of them: one closure for several noises that differ in a number.
#[derive(Clone)]
pub(crate) struct Noise {
    pub(crate) term: Term,
    pub(crate) family: Option<Family>,
    /// Whether it is a covector.
    pub(crate) is_force: bool,
}

/// The correction that the conversion added to a system in the sense of Ito, as text.
#[derive(Clone)]
pub(crate) struct Conversion {
    /// To the Hamiltonian of the drift.
    pub(crate) drift: Option<String>,
    /// To the force, as virtual work.
    pub(crate) force: Option<String>,
    /// Whether that force reads momenta.
    pub(crate) reads_momenta: bool,
}

/// Linear friction: `-G p` with rates on the diagonal of `G`, or `-Γ M⁻¹ p`.
#[derive(Clone)]
pub(crate) struct Friction {
    /// `δq · G p` or `δq · Γ p`
    pub(crate) term: Term,
    pub(crate) is_matrix: bool,
    /// Whether all degrees of freedom have the same rate.
    pub(crate) is_one_rate: bool,
    /// The rate, where it is one number for all degrees of freedom, whatever the state.
    pub(crate) uniform: Option<Expr>,
}

impl Friction {
    /// Whether it depends on the coordinates.
    pub(crate) fn is_per_place(&self) -> bool {
        self.term.elements.iter().any(|element| element.coordinates().next().is_some())
    }
}

/// `kT` of a bath.
#[derive(Clone)]
pub(crate) struct Temperature {
    /// A number, or `Σ_i T_i δq_i p_i`.
    pub(crate) term: Term,
    /// Whether degrees of freedom have temperatures of their own.
    pub(crate) is_list: bool,
    pub(crate) reads_time: bool,
}

/// How a clock is found.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum ClockKind {
    /// By the closure of the user.
    Function,
    /// From the second derivatives of the drift.
    Curvature,
    /// From the bonds of pairs.
    Pairs,
}

/// The clock `Q`: a step has the length `Q` times a constant.
#[derive(Clone)]
pub(crate) struct Clock {
    pub(crate) kind: ClockKind,
    /// `Q`. Until the pass on clocks derives it, of a curvature the frequency that is added, zero if there is
    /// none.
    pub(crate) term: Term,
    /// `G = -d ln Q/dt` along the drift with its forces and friction.
    pub(crate) rate: Vec<Element>,
    /// `Q` and `G` as text.
    pub(crate) text: String,
    /// The numbers of the collective variables that were made for it.
    pub(crate) collectives: Vec<u32>,
}

/// The members `0..count` of a family of noises or constraints; `variable` is the loop variable that counts
/// them. It is the outermost loop of every element of the family.
#[derive(Clone)]
pub(crate) struct Family {
    pub(crate) variable: u32,
    pub(crate) count: Index,
}

/// A term, or a family of terms: a constraint `g(q, t) = 0`.
#[derive(Clone)]
pub(crate) struct FamilyTerm {
    pub(crate) term: Term,
    pub(crate) family: Option<Family>,
}

/// The form of code: with a variable for each degree of freedom, or with loops over elements.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Form {
    StraightLines,
    Loops,
}

/// The declaration after lowering: every Hamiltonian as a sum of elements.
#[derive(Clone)]
pub(crate) struct System {
    pub(crate) graph: Graph,
    pub(crate) shape: Shape,
    /// The outermost size: the number of points.
    pub(crate) size: Index,
    /// Components of a point.
    pub(crate) components: i128,
    /// Names of coordinates and momenta.
    pub(crate) names: [String; 2],
    /// The displayed names of their components.
    pub(crate) labels: [Labels; 2],
    /// The meanings of the symbols other than time and parameters.
    pub(crate) symbols: Symbols,
    pub(crate) t: Symbol,
    /// The sums of which Hamiltonians are nonlinear functions, and the slopes by these.
    pub(crate) collectives: Collectives,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) tables: Vec<Table>,
    /// Integers of unsigned types that may be negative, in their loops.
    pub(crate) naturals: Vec<(Vec<Loop>, Index)>,
    pub(crate) drift: Term,
    /// The parts of the drift, where the user has parted it: `drift = [H_A, H_B]`.
    pub(crate) summands: Vec<Term>,
    /// In the order of their increments: Hamiltonians, then covectors.
    pub(crate) noise: Vec<Noise>,
    /// The covector beside the drift.
    pub(crate) force: Option<Term>,
    pub(crate) friction: Option<Friction>,
    /// The rate of friction that steps take in exactly: one for all degrees of freedom, without a
    /// temperature.
    pub(crate) conformal: Option<Expr>,
    /// `e^{γ (t - t_i)}` with this rate, where elements are emitted in loops.
    pub(crate) scale: Option<Symbol>,
    pub(crate) temperature: Option<Temperature>,
    /// The place of `Ito` in the source, if noises are in that sense.
    pub(crate) ito: Option<Extent>,
    /// The correction by which this system in the sense of Ito is one in the sense of Stratonovich.
    pub(crate) conversion: Option<Conversion>,
    pub(crate) invariants: Vec<Term>,
    /// The names of the first integrals; empty where there is none.
    pub(crate) invariant_names: Vec<String>,
    /// Functions of the state for results alone. They are no [`terms`](System::terms): nothing that is known
    /// of the system depends on them.
    pub(crate) observables: Vec<Term>,
    pub(crate) observable_names: Vec<String>,
    /// The number of the first collective variable that observables alone read, if there is one.
    pub(crate) first_observed: Option<u32>,
    /// In the order of their multipliers.
    pub(crate) constraints: Vec<FamilyTerm>,
    pub(crate) embeddings: Vec<Located<Embedding>>,
    pub(crate) clock: Option<Clock>,
    /// The schemes with steps of lengths of their own.
    pub(crate) clocked: Vec<Located<ClockedEmbedding>>,
    /// The struct: attributes, visibility, name, generics and fields, to be emitted unchanged.
    pub(crate) item: syn::ItemStruct,
    /// Path of the facade crate as the user's crate knows it, `::wzvi` by default.
    pub(crate) crate_path: syn::Path,
    /// The form of the elements.
    pub(crate) form: Form,
    /// The form of the slopes of the step Hamiltonian.
    pub(crate) slopes: Form,
    /// The system with each degree of freedom a variable of its own, where a step or the slopes are in
    /// straight lines.
    pub(crate) line: Option<Rc<StraightLine>>,
    /// Functions that repeat the user's closures for `rustc` to type-check at the user's spans; never called.
    pub(crate) type_checks: TokenStream,
}

impl System {
    /// The parameters of the system as it is emitted.
    pub(crate) fn listed(&self) -> &[Parameter] {
        self.line.as_ref().map_or(&self.parameters, |line| &line.parameters)
    }

    /// The straight lines that the slopes of the step Hamiltonian are taken of, where these are in that form.
    pub(crate) fn line_of_slopes(&self) -> Option<Rc<StraightLine>> {
        self.line.clone().filter(|_| self.slopes == Form::StraightLines)
    }

    /// The collective variables of terms: all but those that observables alone read.
    pub(crate) fn collectives_of_terms(&self) -> impl Iterator<Item = &Collective> {
        let is_of_terms =
            |known: &&Collective| self.first_observed.is_none_or(|first| known.slot.number < first);
        self.collectives.all().iter().filter(is_of_terms)
    }

    /// Every term but the two parts of a drift that is declared in parts.
    pub(crate) fn terms(&self) -> impl Iterator<Item = &Term> {
        let noise = self.noise.iter().map(|noise| &noise.term);
        let bath = self.friction.iter().map(|friction| &friction.term);
        let bath = bath.chain(self.temperature.iter().map(|temperature| &temperature.term));
        let constraints = self.constraints.iter().map(|constraint| &constraint.term);
        let clock = self.clock.iter().map(|clock| &clock.term);
        let all = [&self.drift].into_iter().chain(noise).chain(&self.invariants).chain(&self.force);
        all.chain(bath).chain(constraints).chain(clock)
    }

    /// The elements of what moves the system, for derivatives: the drift, the force beside it, the noises.
    pub(crate) fn acting(&self) -> impl Iterator<Item = &Element> {
        let noise = self.noise.iter().map(|noise| &noise.term);
        let terms = [&self.drift].into_iter().chain(&self.force).chain(noise);
        terms.flat_map(|term| &term.elements)
    }

    /// The degrees of freedom, where they are known and no element has loops.
    pub(crate) fn degrees_in_straight_lines(&self) -> Option<usize> {
        let mut elements = self.terms().chain(&self.summands).flat_map(|term| &term.values);
        let is_straight =
            self.collectives_of_terms().next().is_none() && elements.all(|element| element.loops.is_empty());
        let degrees = self.size.as_integer().filter(|_| is_straight)?.checked_mul(self.components)?;
        usize::try_from(degrees).ok()
    }

    /// Whether a scheme takes friction in by a flow of its own.
    pub(crate) fn has_thermostat(&self) -> bool {
        self.embeddings.iter().any(|known| known.value.is_thermostat())
    }

    /// The sentence on a force that reads momenta, if the conversion from Ito added this force.
    pub(crate) fn converted_force(&self) -> String {
        let conversion = self.conversion.as_ref().filter(|conversion| conversion.reads_momenta);
        let force = conversion.and_then(|conversion| conversion.force.as_ref());
        let said = |force| {
            format!(" (the conversion from Ito to Stratonovich adds the force {force}, as virtual work)")
        };
        force.map_or_else(String::new, said)
    }

    /// Whether a scheme steps in the extended phase space.
    pub(crate) fn is_extended(&self) -> bool {
        self.clocked.iter().any(|known| matches!(known.value, ClockedEmbedding::Extended(_)))
    }

    /// Whether a scheme steps by logarithms of the energies, which it takes from both parts of the drift.
    pub(crate) fn is_logarithmic(&self) -> bool {
        self.clocked.iter().any(|known| matches!(known.value, ClockedEmbedding::Logarithmic(..)))
    }

    /// Whether covectors stand beside the Hamiltonians, with noise or without.
    pub(crate) fn has_forces(&self) -> bool {
        self.force.is_some() || self.noise.iter().any(|noise| noise.is_force)
    }

    /// For each noise the number of noises before it, members of families counted one by one; at last the
    /// number of all.
    pub(crate) fn noise_offsets(&self) -> Vec<Index> {
        offsets(self.noise.iter().map(|noise| noise.family.as_ref()))
    }

    /// For each constraint the number of constraints before it, and at last the number of all, likewise.
    pub(crate) fn constraint_offsets(&self) -> Vec<Index> {
        offsets(self.constraints.iter().map(|constraint| constraint.family.as_ref()))
    }
}

/// For each term or family the number of members before it; at last the number of all.
fn offsets<'f>(families: impl Iterator<Item = Option<&'f Family>>) -> Vec<Index> {
    let mut offsets = vec![Index::default()];
    let mut total = Index::default();
    for family in families {
        let count = family.map_or(Index::integer(1), |family| family.count.clone());
        let all = total.add(&count);
        total = promised(all, "counts of members beyond all integers are refused where they are lowered");
        offsets.push(total.clone());
    }
    offsets
}

/// A [`System`] without loops whose degrees of freedom are variables of their own: every Hamiltonian as one
/// expression in the graph of the system.
pub(crate) struct StraightLine {
    pub(crate) phase: Phase,
    /// The parameters of the system, and entries of lists.
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) drift: Expr,
    pub(crate) noise: Vec<Expr>,
    /// One component per degree of freedom.
    pub(crate) force: Option<Vec<Expr>>,
    /// Forces driven by the increments after those of the noise Hamiltonians, one component per degree of
    /// freedom.
    pub(crate) noise_forces: Vec<Vec<Expr>>,
    /// The rate of friction that steps take in exactly.
    pub(crate) conformal: Option<Expr>,
}

impl StraightLine {
    /// The number of increments.
    pub(crate) fn noises(&self) -> usize {
        self.noise.len() + self.noise_forces.len()
    }
}
