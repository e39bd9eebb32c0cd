//! Facts about the continuous system: consistency, first integrals, commuting noises, the class of the noise.
//! They are proven for sums of elements, at all sizes. Tests: `tests/steps/plan.rs`,
//! `discretise/sums/tests.rs`.

use self::clock::{ClockFacts, clock_facts};
use self::constraints::Constraint;
use self::flows::{Flows, is_nystrom};
use self::forces::{Forces, commuting_forces};
use self::form::{PreservedForm, coupled_degrees, has_constant_curvature};
use self::invariants::invariant;
use self::kinetic::{Kinetic, is_diagonal};
use self::split::Summands;
use super::branches::{Boundary, Crossing, boundaries};
use super::sums::{Calculus, Increments, KnownSum, Space, Sum, unweighted, weighted};
use crate::diagnostics::{Extent, promised};
use crate::embedding::{Correction, Embedding};
use crate::model::{Atom, Element, Half, Index, Reads, System, Term};
use crate::symbolic::{Graph, Knowledge, Rational, Symbol};

pub(crate) mod clock;
pub(crate) mod constraints;
pub(crate) mod flows;
mod forces;
mod form;
mod invariants;
mod kepler;
pub(crate) mod kinetic;
pub(crate) mod split;
mod weak;

pub(crate) use self::form::{has_constant_forces, is_quadratic};
pub(crate) use self::invariants::{Failure, Invariant};

/// How the noise enters; see `wzvi::plan::NoiseClass`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum NoiseClass {
    None,
    Additive,
    Position,
    Momentum,
    Multiplicative,
}

/// Every Hamiltonian as a sum of elements, noises times their increments: the subject of the facts.
struct Hamiltonians {
    t: Symbol,
    drift: Sum,
    noise: Vec<Sum>,
    forces: Forces,
    /// The suffix of `H` for each noise.
    numbers: Vec<String>,
    constraints: Vec<NumberedSum>,
}

/// A function with the suffix of its name.
struct NumberedSum {
    number: String,
    sum: Sum,
}

/// Facts about one system, shared by all its schemes.
pub(crate) struct Facts {
    pub(crate) space: Space,
    pub(crate) drift: Sum,
    pub(crate) noise: NoiseClass,
    /// Whether the drift has a force beside it.
    pub(crate) has_force: bool,
    /// Whether no element reads coordinates and momenta, and no force reads momenta.
    pub(crate) is_separable: bool,
    /// The kinetic energy, if it is a constant quadratic form.
    pub(crate) kinetic: Option<Kinetic>,
    /// Whether the step Hamiltonian is a constant quadratic form of the momenta plus a function of
    /// coordinates and time, and forces read no more.
    pub(crate) is_nystrom: bool,
    /// Whether the drift is a sum of squares of momenta with constant coefficients plus a function of
    /// coordinates and time, and neither noise nor force reads momenta.
    pub(crate) has_squares: bool,
    /// The flows of `T(p)` and `V(q, t)`, if the step Hamiltonian is their sum.
    pub(crate) flows: Option<Flows>,
    /// The parts of `drift = [H_A, H_B]`.
    pub(crate) summands: Summands,
    /// Whether no element couples two momenta.
    pub(crate) has_diagonal_kinetic_energy: bool,
    /// `Σ_k ∂H_k/∂q · ∂H_k/∂p`, and whether it is constant on phase space. The defect of a scheme is `D`,
    /// `1/2 - l` times this contraction.
    pub(crate) noise_contraction: KnownSum,
    /// `Σ_k (f_k · ∂/∂p) f_k · δq` of the noise forces, and whether it vanishes: their defect is `1/2 - l`
    /// times it.
    pub(crate) force_contraction: KnownSum,
    /// `Σ_jk ΔW_j ΔW_k ∂H_j/∂q · ∂H_k/∂p`, of which `Corrected` adds `1/2 - l` times, and whether it is
    /// constant for all increments: then the counter-term has no effect.
    pub(crate) counter_term: KnownSum,
    pub(crate) energy: Energy,
    /// The form of the drift.
    pub(crate) energy_form: PreservedForm,
    /// The boundaries between branches, of the drift and of each noise.
    pub(crate) boundaries: Vec<Vec<Boundary>>,
    pub(crate) commuting: Knowledge,
    /// Whether centred steps of order two, for multiplicative noise of order four, are proven to have weak
    /// order two.
    pub(crate) has_weak_order_two: bool,
    /// The suffix of `H` for each noise or family.
    pub(crate) numbers: Vec<String>,
    /// Whether there is more than one noise, or a family of them.
    pub(crate) has_several_noises: bool,
    pub(crate) invariants: Vec<Invariant>,
    pub(crate) constraints: Vec<Constraint>,
    pub(crate) clock: ClockFacts,
    /// Whether the second derivatives of the step Hamiltonian read neither the state nor the time nor
    /// increments.
    pub(crate) has_constant_curvature: bool,
    /// The most degrees of freedom of one point that depend on each other, if elements couple no points.
    pub(crate) coupled_degrees: Option<usize>,
}

impl Hamiltonians {
    /// Built from the elements that `of` selects in each term.
    fn of(system: &System, of: impl Fn(&Term) -> &Vec<Element> + Copy) -> Self {
        let noise = system.noise.iter().zip(system.noise_offsets()).map(|(noise, offset)| {
            let number = match &noise.family {
                Some(family) => {
                    let own = Index::atom(Atom::Loop(family.variable));
                    promised(offset.add(&own), "numbers of noises are integers")
                }
                None => offset,
            };
            weighted(of(&noise.term), &[number])
        });
        let mut noise: Vec<Sum> = noise.collect();
        let mut numbers = system.noise_numbers();
        let hamiltonians = system.noise.iter().filter(|noise| !noise.is_force).count();
        let is_drawn = system.conformal.is_some() || system.has_thermostat();
        let friction = system.friction.as_ref().filter(|_| is_drawn);
        let forces = Forces {
            force: system.force.as_ref().map(|force| unweighted(of(force))).unwrap_or_default(),
            friction: friction.map(|friction| unweighted(of(&friction.term))).unwrap_or_default(),
            is_matrix: friction.is_some_and(|friction| friction.is_matrix),
            is_warm: system.temperature.is_some(),
            noise: noise.split_off(hamiltonians),
            numbers: numbers.split_off(hamiltonians),
        };
        let constraints = constraints::constraints(system).into_iter();
        let constraints =
            constraints.map(|Constraint { number, value, .. }| NumberedSum { number, sum: value });
        let constraints = constraints.collect();
        Self { t: system.t, drift: unweighted(of(&system.drift)), noise, forces, numbers, constraints }
    }
}

/// The drift, the noises and noise forces times their increments, and the force, with the elements of each
/// term that `of` picks.
pub(crate) fn summed(system: &System, of: impl Fn(&Term) -> &Vec<Element> + Copy) -> [Sum; 3] {
    let Hamiltonians { drift, noise, forces, .. } = Hamiltonians::of(system, of);
    [drift, [noise.concat(), forces.noise.concat()].concat(), forces.force]
}

/// The energy `H_0` along the motion: its rates, and whether it is a first integral.
pub(crate) struct Energy {
    /// `{H_k, H_0}` per noise or family.
    pub(crate) rates: Vec<Sum>,
    /// `f · ∂H_0/∂p` of the forces, with what is said of it.
    pub(crate) powers: Vec<(String, Sum)>,
    /// Whether it is a first integral.
    pub(crate) is_conserved: Knowledge,
    /// Whether jumps of `H_0` are the only known reason why it is not.
    pub(crate) only_jumps: bool,
    /// Whether there is no noise, force, friction or constraint, and the drift does not read the time: then
    /// symplectic steps keep a modified energy, whose terms are known.
    pub(crate) is_conservative: bool,
}

impl Energy {
    /// The facts on the energy, and the boundaries of branches.
    fn of(sums: &mut Calculus<'_>, of: &Hamiltonians) -> (Self, Vec<Vec<Boundary>>) {
        let Hamiltonians { drift, noise, forces, constraints, t, .. } = of;
        let explicit = sums.partial(drift, *t);
        let explicit = sums.vanishes(Some(explicit), Increments::Each).known;
        let is_forced = !(forces.force.is_empty() && forces.friction.is_empty() && forces.noise.is_empty());
        let is_free = constraints.is_empty();
        let is_conservative = noise.is_empty() && !is_forced && is_free && explicit.is_proven();
        let powers = forces.powers(sums, drift);
        let rates = noise.iter().map(|one| {
            let rate = sums.bracket(one, drift);
            sums.vanishes(rate, Increments::Each)
        });
        let rates: Vec<KnownSum> = rates.collect();
        let found = powers.iter().map(|(_, power)| power).chain(&rates).map(|judged| judged.known.clone());
        let of_sums = [drift].into_iter().chain(noise);
        let boundaries: Vec<_> = of_sums.map(|sum| boundaries_of(sums.graph, sum, *t)).collect();
        let jumps = boundaries[0].iter().map(|boundary| kept_across("H0", boundary));
        let on_pieces = all([explicit].into_iter().chain(found));
        let across = all(jumps);
        let only_jumps =
            matches!(across, Knowledge::Refuted(_)) && !matches!(on_pieces, Knowledge::Refuted(_));
        let at_rest = constraints::are_at_rest(sums, constraints, *t);
        let is_conserved = all([on_pieces, across, at_rest]);
        let said =
            powers.into_iter().filter_map(|(said, power)| Some((said?, power.sum.unwrap_or_default())));
        // A vanishing rate is printed as zero, not as a difference of equal terms.
        let printed = |rate: KnownSum| rate.sum.filter(|_| !rate.known.is_proven()).unwrap_or_default();
        let rates = rates.into_iter().map(printed).collect();
        (Self { rates, powers: said.collect(), is_conserved, only_jumps, is_conservative }, boundaries)
    }
}

impl Facts {
    pub(crate) fn new(system: &mut System) -> Self {
        let (mut space, hamiltonians) = (Space::of(system), Hamiltonians::of(system, |term| &term.values));
        let Hamiltonians { drift, noise, forces, .. } = &hamiltonians;
        let acting: Vec<Element> = system.acting().cloned().collect();
        let noises = system.noise.iter().flat_map(|noise| &noise.term.elements).cloned();
        let noises: Vec<Element> = noises.collect();
        let declared = system.invariants.iter().zip(&system.invariant_names);
        let declared = declared.map(|(term, name)| (term.extent, name.clone(), unweighted(&term.values)));
        let declared: Vec<(Extent, String, Sum)> = declared.collect();
        let clock = system.clock.as_ref().map(|clock| unweighted(&clock.term.values));
        let sums = &mut Calculus { space: &mut space, graph: &mut system.graph };
        let driven: Sum = noise.concat();
        let [noise_contraction, counter_term] =
            [Increments::Diagonal, Increments::Together].map(|increments| {
                let product =
                    sums.contract((&driven, Half::Coordinates), (&driven, Half::Momenta), increments);
                sums.is_constant(product, increments)
            });
        // The derivatives of a counter-term by collective variables are not emitted.
        let is_of_sites = |sum: &Sum| !sum.iter().any(|weighted| weighted.element.is_collective());
        let counter_term = KnownSum { sum: counter_term.sum.filter(is_of_sites), ..counter_term };
        let (energy, boundaries) = Energy::of(sums, &hamiltonians);
        let class = noise_class(sums.graph, &noises);
        let mut constraints = constraints::constraints(system);
        let sums = &mut Calculus { space: &mut space, graph: &mut system.graph };
        constraints::examine(sums, &hamiltonians, &mut constraints);
        let clock = clock_facts(sums, &hamiltonians, clock);
        let energy_form = match energy.is_conserved {
            Knowledge::Proven if constraints.is_empty() => invariants::form_of(sums, &hamiltonians, drift),
            _ => PreservedForm::NONE,
        };
        let has_several_noises = system.noise.len() > 1 || noise.iter().chain(&forces.noise).any(is_family);
        // The brackets of piecewise noises are the brackets of their pieces.
        let jumps = hamiltonians.numbers.iter().zip(&boundaries[1..]).flat_map(|(number, boundaries)| {
            boundaries.iter().map(move |boundary| kept_across(&format!("H{number}"), boundary))
        });
        let jumps = if has_several_noises { all(jumps) } else { Knowledge::Proven };
        let commuting =
            all([commuting_hamiltonians(sums, noise), commuting_forces(sums, noise, &forces.noise), jumps]);
        let has_weak_order_two =
            commuting.is_proven() && weak::has_order_two(sums, &hamiltonians, class, &energy.is_conserved);
        let force_contraction = forces.defect(sums);
        let invariants = declared.into_iter();
        let invariants =
            invariants.map(|(extent, name, value)| invariant(sums, &hamiltonians, extent, name, value));
        let invariants: Vec<Invariant> = invariants.collect();
        let has_diagonal_kinetic_energy = acting
            .iter()
            .all(|element| element.reads().q || element.is_covector() || is_diagonal(sums.graph, element));
        let is_separable = acting.iter().all(|element| {
            let Reads { q, p } = element.reads();
            !p || !q && !element.is_covector()
        });
        let kinetic = Kinetic::of(system);
        let is_nystrom = is_nystrom(system, is_separable, kinetic);
        let is_noisy = system.noise.iter().flat_map(|noise| &noise.term.elements).any(|e| e.reads().p);
        let has_squares = is_separable && !is_noisy && kinetic.is_some_and(|kinetic| kinetic.is_diagonal);
        Self {
            noise: class,
            has_force: system.force.is_some(),
            is_separable,
            has_diagonal_kinetic_energy,
            noise_contraction,
            force_contraction,
            counter_term,
            energy,
            energy_form,
            boundaries,
            commuting,
            has_weak_order_two,
            has_several_noises,
            invariants,
            constraints,
            clock,
            numbers: hamiltonians.numbers,
            drift: hamiltonians.drift,
            space,
            coupled_degrees: coupled_degrees(system),
            has_constant_curvature: has_constant_curvature(system),
            kinetic,
            has_squares,
            is_nystrom,
            flows: Flows::of(system, is_separable, is_nystrom),
            summands: Summands::of(system),
        }
    }

    /// Whether noises at a quadrature point `l`, or at several with this mean, give the Stratonovich limit:
    /// `D` is constant.
    pub(crate) fn is_consistent(&self, l: Rational) -> bool {
        l == Rational::HALF
            || self.noise_contraction.known.is_proven() && self.force_contraction.known.is_proven()
    }

    /// Whether noise forces at quadrature point `l` need a correction.
    pub(crate) fn force_defect_acts(&self, l: Rational) -> bool {
        l != Rational::HALF && !self.force_contraction.known.is_proven()
    }

    /// Whether the limit of the scheme is the Stratonovich system.
    pub(crate) fn converges(&self, embedding: &Embedding) -> bool {
        embedding.correction() == Correction::Corrected || self.is_consistent(embedding.means()[1])
    }

    /// Whether the counter-term changes a scheme whose noises are at `l`. It may even if `D` is constant: its
    /// mixed products do not affect the limit, but without them commuting noises lose half an order.
    pub(crate) fn counter_term_acts(&self, l: Rational) -> bool {
        l != Rational::HALF && !self.counter_term.known.is_proven()
    }

    /// A defect as text: `1/2 - l` times one of these sums.
    pub(crate) fn defect(&self, graph: &mut Graph, half: &KnownSum, l: Rational) -> String {
        let weight = promised(Rational::HALF.add(l.negate()), "quadrature points are fractions of 32 bits");
        match &half.sum {
            Some(half) if !weight.is_zero() => self.space.display(graph, half, weight),
            _ => "0".to_owned(),
        }
    }
}

/// Whether all statements hold; one refuted statement refutes the conjunction.
fn all(statements: impl IntoIterator<Item = Knowledge>) -> Knowledge {
    let mut known = Knowledge::Proven;
    for statement in statements {
        match statement {
            Knowledge::Proven => {}
            Knowledge::Refuted(witness) => return Knowledge::Refuted(witness),
            Knowledge::Unknown(reason) => known = Knowledge::Unknown(reason),
        }
    }
    known
}

/// Whether every `{H_j, H_k}` is constant.
fn commuting_hamiltonians(sums: &mut Calculus<'_>, noise: &[Sum]) -> Knowledge {
    let mut statements = Vec::new();
    for (k, first) in noise.iter().enumerate() {
        for second in noise[..k].iter().chain(is_family(first).then_some(first)) {
            let bracket = sums.bracket(second, first);
            statements.push(sums.is_constant(bracket, Increments::Each).known);
        }
    }
    all(statements)
}

/// Whether a sum belongs to every member of a family of noises: its increment is numbered by a loop variable.
fn is_family(noise: &Sum) -> bool {
    noise.iter().any(|weighted| weighted.increments.iter().any(|number| !number.loops().is_empty()))
}

/// The boundaries of branches that the state or time can reach.
fn boundaries_of(graph: &mut Graph, hamiltonian: &Sum, t: Symbol) -> Vec<Boundary> {
    hamiltonian.iter().flat_map(|weighted| boundaries_in(graph, &weighted.element, t)).collect()
}

fn boundaries_in(graph: &mut Graph, element: &Element, t: Symbol) -> Vec<Boundary> {
    let mut state = element.moving();
    state.push(t);
    boundaries(graph, element.value, &state)
}

/// Whether a function with this name has the same value on both sides of its boundary.
fn kept_across(name: &str, boundary: &Boundary) -> Knowledge {
    match &boundary.crossing {
        Crossing::Smooth | Crossing::Kink => Knowledge::Proven,
        Crossing::Jump(witness) => Knowledge::Refuted(witness.clone()),
        Crossing::JumpUnless(jump) => {
            Knowledge::Unknown(format!("{name} jumps where {}, unless {jump} = 0", boundary.place))
        }
        Crossing::Undecided => Knowledge::Unknown(format!("{name} may jump where {}", boundary.place)),
    }
}

fn noise_class(graph: &mut Graph, noises: &[Element]) -> NoiseClass {
    if noises.is_empty() {
        return NoiseClass::None;
    }
    let (forces, noise): (Vec<&Element>, Vec<&Element>) =
        noises.iter().partition(|element| element.is_covector());
    let read_q = |elements: &[&Element]| elements.iter().any(|element| element.reads().q);
    let read_p = |elements: &[&Element]| elements.iter().any(|element| element.reads().p);
    let is_affine = noise.iter().all(|element| is_affine(graph, element));
    if is_affine && !read_q(&forces) && !read_p(&forces) {
        NoiseClass::Additive
    } else if !read_p(&noise) && !read_p(&forces) {
        NoiseClass::Position
    } else if !read_q(&noise) && forces.is_empty() {
        NoiseClass::Momentum
    } else {
        NoiseClass::Multiplicative
    }
}

fn is_affine(graph: &mut Graph, element: &Element) -> bool {
    let state = element.state();
    !element.is_collective()
        && !graph.has_pieces(element.value, &state)
        && state.iter().all(|&symbol| {
            let slope = graph.derivative(element.value, symbol);
            !graph.depends_on(slope, &state)
        })
}
