//! The unknowns on which a scheme iterates. With `u = Δq`, `v = P - p_i`, the discrete Euler-Lagrange
//! equations are
//!
//! ```text
//! u = Σ_m c_m ∂H_m/∂p(P, Q_m),   v = -Σ_m (1 - l_m) c_m ∂H_m/∂q(P, Q_m),   Q_m = q_i + l_m u,   P = p_i + v
//! ```
//!
//! | structure | unknowns |
//! |---|---|
//! | `H = T(p) + V(q)`, every `l_m` of a term whose `V'` reads `q` is 0 or 1 | none |
//! | `H = T(p) + V(q)`, `T''` diagonal | `v`: `u` follows from it |
//! | every `l_m` is 0 | `v`: it is read nowhere else |
//! | otherwise | `u` and `v` |

use crate::discretise::{
    Facts, Flows, Quadrature, Role, RoleElements, Scheme, Stage, StepGradient, discretise, elements_by_role,
    has_constant_forces, split,
};
use crate::embedding::Embedding;
use crate::model::{Element, Form, Half, System};
use crate::symbolic::{Rational, Symbol};

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Unknowns {
    None,
    Momenta,
    Both,
}

/// How the unknowns enter the equations: `elements::Linearity` of the run time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Linearity {
    Nonlinear,
    Affine,
    Constant,
}

/// The solution of steps in loops, for all unknowns at once.
#[derive(Clone, Copy)]
pub(crate) struct Strategy {
    pub(crate) unknowns: Unknowns,
    pub(crate) linearity: Linearity,
}

/// A scheme with one `P`: what its text and its code follow from.
pub(crate) struct SchemePlan {
    pub(crate) embedding: Embedding,
    pub(crate) quadrature: Quadrature,
    /// Whether its limit is the Stratonovich system.
    pub(crate) is_consistent: bool,
    pub(crate) step: Step,
}

/// The form of a step, with what is solved in it.
pub(crate) enum Step {
    StraightLine(Box<Scheme>),
    InLoops(Strategy),
}

/// The plans of a system, made once. The text and the code follow from them.
pub(crate) struct Plans {
    pub(crate) listed: Vec<Embedding>,
    /// The plans of the schemes with one `P` that listed schemes need, each once.
    pub(crate) schemes: Vec<SchemePlan>,
    /// The elements of the step Hamiltonian that the listed schemes use, by their roles.
    pub(crate) roles: Vec<RoleElements>,
    /// The flows that compose `Verlet` and its compositions.
    pub(crate) flows: Option<Flows>,
    /// The slopes in straight lines that `Gauss<S>` and flows take, where they take them in this form.
    pub(crate) gradient: Option<StepGradient>,
    /// The forms of the parts of the drift, where `Verlet` is listed and the user wrote the drift in two
    /// parts.
    pub(crate) forms: Option<[split::SummandForm; 2]>,
    /// Whether steps on a manifold of constraints are solved as a whole, and not as words of flows.
    pub(crate) is_general_on_manifold: bool,
}

impl Plans {
    /// `form` is the form of the step of a scheme.
    pub(crate) fn new(
        system: &mut System,
        facts: &Facts,
        listed: Vec<Embedding>,
        form: impl Fn(&Embedding) -> Form,
    ) -> Self {
        let mut schemes: Vec<SchemePlan> = Vec::new();
        for embedding in listed.iter().flat_map(Embedding::substeps) {
            if !schemes.iter().any(|known| known.embedding == embedding) {
                let form = form(&embedding);
                schemes.push(SchemePlan::new(system, facts, embedding, form));
            }
        }
        let flows = facts.flows.filter(|_| listed.iter().any(Embedding::takes_flows));
        let is_taken = flows.is_some() || listed.iter().any(|listed| listed.stages().is_some());
        let line = system.line_of_slopes().filter(|_| is_taken);
        let gradient = line.map(|line| StepGradient::new(&mut system.graph, line, facts.is_nystrom));
        let forms = facts.summands.known().filter(|_| listed.contains(&Embedding::Verlet));
        let roles = elements_by_role(system, facts);
        let is_general_on_manifold = !facts.constraints.is_empty() && !facts.has_squares;
        Self { listed, schemes, roles, flows, gradient, forms, is_general_on_manifold }
    }

    /// The schemes whose steps are emitted: not the halves of `Verlet` where it composes flows.
    pub(crate) fn stepped(&self) -> Vec<&SchemePlan> {
        let listed = self.listed.iter().filter(|listed| self.flows.is_none() || !listed.takes_flows());
        let needed: Vec<Embedding> = listed.flat_map(Embedding::substeps).collect();
        self.schemes.iter().filter(|scheme| needed.contains(&scheme.embedding)).collect()
    }

    /// Whether a step needs second derivatives: one on a manifold that is no word of flows, one that is
    /// solved in loops, or one whose momentum between its ends is solved for.
    pub(crate) fn needs_hessian(&self) -> bool {
        self.is_general_on_manifold
            || self.schemes.iter().any(|SchemePlan { quadrature, step, .. }| {
                let is_solved_in_loops =
                    matches!(step, Step::InLoops(strategy) if strategy.unknowns != Unknowns::None);
                is_solved_in_loops || !quadrature.gives_momentum()
            })
    }

    /// The listed schemes whose stages are solved together, with the number of their stages.
    pub(crate) fn staged(&self) -> impl Iterator<Item = (&Embedding, u32)> {
        self.listed.iter().filter_map(|listed| Some((listed, listed.stages()?)))
    }
}

impl SchemePlan {
    fn new(system: &mut System, facts: &Facts, embedding: Embedding, form: Form) -> Self {
        let quadrature = Quadrature::new(facts, &embedding);
        let line = system.line.clone().filter(|_| form == Form::StraightLines);
        let step = match line {
            Some(line) => Step::StraightLine(Box::new(discretise(&mut system.graph, line, &quadrature))),
            None => Step::InLoops(Strategy::of(system, facts, &quadrature)),
        };
        Self { is_consistent: facts.converges(&embedding), embedding, quadrature, step }
    }
}

impl Strategy {
    fn of(system: &mut System, facts: &Facts, quadrature: &Quadrature) -> Self {
        let unknowns = unknowns(system, facts, quadrature);
        let corrects = quadrature.weights_of(Role::CounterTerm).next().is_some();
        let linearity = match unknowns {
            Unknowns::None => Linearity::Nonlinear,
            _ if !corrects && facts.has_constant_curvature => Linearity::Constant,
            _ if is_affine(system, facts, quadrature) => Linearity::Affine,
            _ => Linearity::Nonlinear,
        };
        Self { unknowns, linearity }
    }
}

/// Whether the equations are affine in `u` and `v`: no second derivative in them reads what moves with these.
///
/// | equation | second derivatives | of points `l` |
/// |---|---|---|
/// | `u`, if `u` is read: some `l` is not 0 | `∂²H/∂p∂p`, `∂²H/∂p∂q` if `l ≠ 0` | all |
/// | `v` | `∂²H/∂q∂p`, `∂²H/∂q∂q` if `l ≠ 0` | not 1 |
///
/// `p` moves unless every `l` is 1, and `q` at points `l ≠ 0`.
fn is_affine(system: &mut System, facts: &Facts, Quadrature { stages }: &Quadrature) -> bool {
    let System { graph, drift, noise, force, .. } = system;
    let reads_u = stages.iter().any(|stage| !stage.l.is_zero());
    let moves_p = stages.iter().any(|stage| !stage.l.is_one());
    stages.iter().all(|Stage { l, roles }| {
        let mut elements: Vec<&Element> = Vec::new();
        for (role, _) in roles {
            match role {
                Role::Drift => elements.extend(&drift.elements),
                Role::Noise => elements.extend(noise.iter().flat_map(|noise| &noise.term.elements)),
                Role::Force => elements.extend(force.iter().flat_map(|force| &force.elements)),
                Role::CounterTerm => {
                    let products = facts.counter_term.sum.iter().flatten();
                    elements.extend(products.map(|weighted| &weighted.element));
                }
                // No quadrature evaluates these.
                Role::Summand(_)
                | Role::Friction
                | Role::Temperature
                | Role::Integral(_)
                | Role::Observable(_)
                | Role::Clock
                | Role::ClockRate => {}
            }
        }
        let symbols = |half: Half, element: &Element| -> Vec<Symbol> {
            element.of_half(half).map(|(symbol, _)| symbol).collect()
        };
        elements.into_iter().all(|element| {
            if element.is_collective() {
                return false;
            }
            let [q, p, along] =
                [Half::Coordinates, Half::Momenta, Half::Displacements].map(|half| symbols(half, element));
            let mut moving = if moves_p { p.clone() } else { Vec::new() };
            moving.extend(q.iter().filter(|_| !l.is_zero()));
            let of_u = p.iter().filter(|_| reads_u && !element.is_covector());
            let of_v = if element.is_covector() { &along } else { &q };
            let mut equations = of_u.chain(of_v.iter().filter(|_| !l.is_one()));
            equations.all(|&x| {
                let slope = graph.derivative(element.value, x);
                !graph.has_pieces(slope, &moving)
                    && moving.iter().all(|&y| {
                        let second = graph.derivative(slope, y);
                        !graph.depends_on(second, &moving)
                    })
            })
        })
    })
}

fn unknowns(model: &mut System, facts: &Facts, Quadrature { stages }: &Quadrature) -> Unknowns {
    let System { graph, drift, noise, force, .. } = model;
    let mut varies =
        |elements: &[Element]| !elements.iter().all(|element| has_constant_forces(graph, element));
    let varying_drift = varies(&drift.elements);
    let varying_noise = noise.iter().any(|noise| varies(&noise.term.elements));
    let varying_force = force.as_ref().is_some_and(|force| varies(&force.elements));
    let has_varying_forces = |(role, _): &(Role, Rational)| match role {
        Role::Drift => varying_drift,
        Role::Noise => varying_noise,
        Role::Force => varying_force,
        Role::CounterTerm => true,
        // No quadrature evaluates these.
        Role::Summand(_)
        | Role::Friction
        | Role::Temperature
        | Role::Integral(_)
        | Role::Observable(_)
        | Role::Clock
        | Role::ClockRate => false,
    };
    // The counter-term reads coordinates and momenta.
    let is_simple = |(role, _): &(Role, Rational)| *role != Role::CounterTerm;
    let is_separable = facts.is_separable && stages.iter().all(|stage| stage.roles.iter().all(is_simple));
    let is_at_node = |stage: &Stage| stage.l.is_zero() || stage.l.is_one();
    let is_assigned = |stage: &Stage| is_at_node(stage) || !stage.roles.iter().any(has_varying_forces);
    if is_separable && stages.iter().all(is_assigned) {
        Unknowns::None
    } else if (is_separable && facts.has_diagonal_kinetic_energy)
        || stages.iter().all(|stage| stage.l.is_zero())
    {
        Unknowns::Momenta
    } else {
        Unknowns::Both
    }
}
