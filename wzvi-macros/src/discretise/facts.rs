//! Facts about the continuous system: consistency, first integrals, commuting noises, the class of the noise.
//! They are proven for sums of elements, at all sizes.

use self::forces::{Forces, commuting_forces};
use self::form::Form;
use self::invariants::invariant;
use self::kinetic::is_diagonal;
use super::branches::{Boundary, Crossing, boundaries};
use super::sums::{Increments, Space, Sum, Weighted};
use crate::diagnostics::{Extent, Promised};
use crate::embedding::{Correction, Embedding};
use crate::model::{Atom, Element, Half, Index, Reads, System, Term};
use crate::symbolic::{Graph, Knowledge, Rational, Symbol};

pub(crate) mod flows;
mod forces;
mod form;
mod invariants;
pub(crate) mod kinetic;
pub(crate) mod split;

pub(crate) use self::form::is_quadratic;
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
    space: Space,
    t: Symbol,
    drift: Sum,
    noise: Vec<Sum>,
    forces: Forces,
    /// The suffix of `H` for each noise.
    numbers: Vec<String>,
    invariants: Vec<(Extent, String, Sum)>,
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
    /// Whether no element couples two momenta.
    pub(crate) has_diagonal_kinetic_energy: bool,
    /// `Σ_k ∂H_k/∂q · ∂H_k/∂p`: the defect of a scheme is `D = (1/2 - l)` times it.
    pub(crate) half_defect_sum: Sum,
    /// Whether that sum is constant on phase space.
    pub(crate) defect_is_constant: Knowledge,
    /// `Σ_k (f_k · ∂/∂p) f_k · δq` of the noise forces: their defect is `1/2 - l` times it.
    pub(crate) half_force_defect: Sum,
    pub(crate) force_defect_vanishes: Knowledge,
    /// `Σ_jk ΔW_j ΔW_k ∂H_j/∂q · ∂H_k/∂p`: `Corrected` adds `1/2 - l` times it.
    /// `None` if its indices exceed the arithmetic of indices.
    pub(crate) counter_term: Option<Sum>,
    /// Whether it is constant for all increments: then the counter-term has no effect.
    pub(crate) counter_term_is_constant: Knowledge,
    /// `{H_k, H_0}` per noise or family.
    pub(crate) energy_rates: Vec<Sum>,
    /// `f · ∂H_0/∂p` of every force, with its name.
    pub(crate) powers: Vec<(String, Sum)>,
    pub(crate) conserves_energy: Knowledge,
    /// Whether there is no noise, and the drift does not read the time: then symplectic steps keep a modified energy.
    pub(crate) is_conservative: bool,
    /// The form of the drift.
    pub(crate) energy_form: Form,
    /// Where branches of the drift and of each noise meet.
    pub(crate) boundaries: Vec<Vec<Boundary>>,
    pub(crate) commuting: Knowledge,
    /// The suffix of `H` for each noise or family.
    pub(crate) numbers: Vec<String>,
    /// Whether there is more than one noise, or a family of them.
    pub(crate) has_several_noises: bool,
    pub(crate) invariants: Vec<Invariant>,
}

impl Hamiltonians {
    /// Built from the elements that `of` selects in each term.
    fn of(system: &System, of: impl Fn(&Term) -> &Vec<Element> + Copy) -> Self {
        let space = Space::of(system);
        let noise = system.noise.iter().zip(system.noise_offsets()).map(|(noise, offset)| {
            let number = match &noise.family {
                Some(family) => offset
                    .add(&Index::atom(Atom::Loop(family.variable)))
                    .promised("numbers of noises are integers"),
                None => offset,
            };
            sum_of(of(&noise.term), &[number])
        });
        let mut noise: Vec<Sum> = noise.collect();
        let mut numbers = system.noise_numbers();
        let hamiltonians = system.noise.iter().filter(|noise| !noise.is_force).count();
        let friction = system.friction.as_ref().filter(|_| {
            system.conformal.is_some() || system.embeddings.iter().any(|known| known.value.is_thermostat())
        });
        let forces = Forces {
            force: system.force.as_ref().map(|force| sum_of(of(force), &[])).unwrap_or_default(),
            friction: friction.map(|friction| sum_of(of(&friction.term), &[])).unwrap_or_default(),
            is_matrix: friction.is_some_and(|friction| friction.is_matrix),
            is_warm: system.temperature.is_some(),
            noise: noise.split_off(hamiltonians),
            numbers: numbers.split_off(hamiltonians),
        };
        Self {
            space,
            t: system.t,
            drift: sum_of(of(&system.drift), &[]),
            noise,
            forces,
            numbers,
            invariants: system
                .invariants
                .iter()
                .zip(&system.invariant_names)
                .map(|(term, name)| (term.extent, name.clone(), sum_of(of(term), &[])))
                .collect(),
        }
    }
}

/// The drift, the noises and noise forces times their increments, and the force, with the elements of each term that `of` picks.
pub(crate) fn summed(system: &System, of: impl Fn(&Term) -> &Vec<Element> + Copy) -> [Sum; 3] {
    let Hamiltonians { drift, noise, forces, .. } = Hamiltonians::of(system, of);
    [drift, [noise.concat(), forces.noise.concat()].concat(), forces.force]
}

fn sum_of(elements: &[Element], increments: &[Index]) -> Sum {
    let weigh = |element: &Element| Weighted { element: element.clone(), increments: increments.to_vec() };
    elements.iter().map(weigh).collect()
}

impl Facts {
    pub(crate) fn new(system: &mut System) -> Self {
        let Hamiltonians { mut space, t, drift, noise, forces, numbers, invariants } =
            Hamiltonians::of(system, |term| &term.values);
        let acting: Vec<Element> = system.acting().cloned().collect();
        let noises: Vec<Element> =
            system.noise.iter().flat_map(|noise| &noise.term.elements).cloned().collect();
        let System { graph, noise: declared, force, .. } = system;
        let all_noise: Sum = noise.concat();
        let (q, p) = (Half::Coordinates, Half::Momenta);
        let half_defect_sum = space.contract(graph, (&all_noise, q), (&all_noise, p), Increments::Diagonal);
        let defect_is_constant =
            known(&half_defect_sum, |sum| space.is_constant(graph, sum, Increments::Diagonal));
        let counter_term = space.contract(graph, (&all_noise, q), (&all_noise, p), Increments::Together);
        let counter_term_is_constant =
            known(&counter_term, |sum| space.is_constant(graph, sum, Increments::Together));

        let explicit_rate = space.partial(graph, &drift, t);
        let mut conserves_energy = vec![space.vanishes(graph, &explicit_rate, Increments::Each)];
        let is_conservative =
            noise.is_empty() && forces.are_absent() && matches!(conserves_energy[..], [Knowledge::Proven]);
        let powers = forces.powers(graph, &mut space, &drift);
        conserves_energy.extend(
            powers.iter().map(|(_, rate)| known(rate, |sum| space.vanishes(graph, sum, Increments::Each))),
        );
        let half_force_defect = forces.defect(graph, &mut space);
        let force_defect_vanishes =
            known(&half_force_defect, |sum| space.vanishes(graph, sum, Increments::Diagonal));
        let mut energy_rates = Vec::new();
        for one in &noise {
            let rate = space.bracket(graph, one, &drift);
            let verdict = known(&rate, |sum| space.vanishes(graph, sum, Increments::Each));
            // A vanishing rate is printed and evaluated as zero, not as a difference of equal terms.
            energy_rates.push(if let Knowledge::Proven = verdict {
                Sum::new()
            } else {
                rate.unwrap_or_default()
            });
            conserves_energy.push(verdict);
        }
        let boundaries: Vec<Vec<Boundary>> =
            [&drift].into_iter().chain(&noise).map(|sum| boundaries_of(graph, sum, t)).collect();
        conserves_energy.extend(boundaries[0].iter().map(|boundary| kept_across("H0", boundary)));
        Self {
            noise: if declared.is_empty() { NoiseClass::None } else { noise_class(graph, &noises) },
            has_force: force.is_some(),
            is_separable: acting.iter().all(|element| {
                let Reads { q, p } = element.reads();
                !p || !q && !element.is_covector()
            }),
            has_diagonal_kinetic_energy: acting
                .iter()
                .filter(|element| !element.reads().q && !element.is_covector())
                .all(|element| is_diagonal(graph, element)),
            half_defect_sum: half_defect_sum.unwrap_or_default(),
            defect_is_constant,
            half_force_defect: half_force_defect.unwrap_or_default(),
            force_defect_vanishes,
            counter_term,
            counter_term_is_constant,
            conserves_energy: all(conserves_energy),
            is_conservative,
            energy_form: Form::of(graph, &drift),
            boundaries,
            energy_rates,
            powers: powers.into_iter().map(|(name, rate)| (name, rate.unwrap_or_default())).collect(),
            commuting: all([
                commuting_hamiltonians(graph, &mut space, &noise),
                commuting_forces(graph, &mut space, &noise, &forces.noise),
            ]),
            has_several_noises: declared.len() > 1 || noise.iter().chain(&forces.noise).any(is_family),
            invariants: invariants
                .into_iter()
                .map(|declared| {
                    let noise: Vec<_> = numbers.iter().cloned().zip(&noise).collect();
                    invariant(graph, &mut space, (&drift, &noise, &forces, t), declared)
                })
                .collect(),
            numbers,
            space,
            drift,
        }
    }

    /// Whether noises at a quadrature point `l`, or at several with this mean, give the Stratonovich limit: `D` is constant.
    pub(crate) fn is_consistent(&self, l: Rational) -> bool {
        l == Rational::HALF
            || matches!(
                (&self.defect_is_constant, &self.force_defect_vanishes),
                (Knowledge::Proven, Knowledge::Proven)
            )
    }

    /// Whether noise forces at quadrature point `l` need a correction.
    pub(crate) fn force_defect_acts(&self, l: Rational) -> bool {
        l != Rational::HALF && !matches!(self.force_defect_vanishes, Knowledge::Proven)
    }

    /// Whether the limit of the scheme is the Stratonovich system.
    pub(crate) fn converges(&self, embedding: &Embedding) -> bool {
        embedding.correction() == Correction::Corrected || self.is_consistent(embedding.means()[1])
    }

    /// Whether the counter-term changes a scheme whose noises are at `l`. It may even if `D` is constant: its mixed
    /// products do not affect the limit, but without them commuting noises lose half an order.
    pub(crate) fn counter_term_acts(&self, l: Rational) -> bool {
        l != Rational::HALF && !matches!(self.counter_term_is_constant, Knowledge::Proven)
    }

    /// A defect as text: `1/2 - l` times one of these sums.
    pub(crate) fn defect(&self, graph: &mut Graph, half: &Sum, l: Rational) -> String {
        let weight = Rational::HALF.add(l.negate()).promised("quadrature points are fractions of 32 bits");
        match weight.is_zero() {
            true => "0".to_owned(),
            false => self.space.display(graph, half, weight),
        }
    }
}

/// What is known of a sum, which is absent where its indices exceeded the arithmetic of indices.
fn known(sum: &Option<Sum>, judge: impl FnOnce(&Sum) -> Knowledge) -> Knowledge {
    let beyond = || Knowledge::Unknown("its indices exceed 128 bits".to_owned());
    sum.as_ref().map_or_else(beyond, judge)
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
fn commuting_hamiltonians(graph: &mut Graph, space: &mut Space, noise: &[Sum]) -> Knowledge {
    let mut statements = Vec::new();
    for (k, first) in noise.iter().enumerate() {
        for second in &noise[..k] {
            statements.push((first, second));
        }
        if is_family(first) {
            statements.push((first, first));
        }
    }
    all(statements.into_iter().map(|(first, second)| {
        let bracket = space.bracket(graph, second, first);
        known(&bracket, |sum| space.is_constant(graph, sum, Increments::Each))
    }))
}

/// Whether a sum belongs to every member of a family of noises: its increment is numbered by a loop variable.
fn is_family(noise: &Sum) -> bool {
    noise.iter().any(|weighted| weighted.increments.iter().any(|number| !number.loops().is_empty()))
}

/// The boundaries of branches that the state or time can reach.
fn boundaries_of(graph: &mut Graph, hamiltonian: &Sum, t: Symbol) -> Vec<Boundary> {
    let of_element = |Weighted { element, .. }: &Weighted| {
        let mut state = element.state();
        state.push(t);
        boundaries(graph, element.value, &state)
    };
    hamiltonian.iter().flat_map(of_element).collect()
}

/// Whether a function with this name has the same value on both sides of its boundary.
fn kept_across(name: &str, boundary: &Boundary) -> Knowledge {
    match &boundary.crossing {
        Crossing::Smooth | Crossing::Kink => Knowledge::Proven,
        Crossing::Jump(witness) => Knowledge::Refuted(witness.clone()),
        Crossing::Undecided => Knowledge::Unknown(format!("{name} may jump where {}", boundary.place)),
    }
}

fn noise_class(graph: &mut Graph, noises: &[Element]) -> NoiseClass {
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
    !graph.has_pieces(element.value, &state)
        && state.iter().all(|&symbol| {
            let slope = graph.derivative(element.value, symbol);
            !graph.depends_on(slope, &state)
        })
}
