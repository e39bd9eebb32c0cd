//! The derivation as text, for `EQUATIONS` and the rustdoc of the struct. Tests: the golden expansions
//! (`compile/golden_tests.rs`).

/// Adds a line to a text.
macro_rules! say {
    ($text:expr, $($content:tt)*) => {{
        $text.push_str(&format!($($content)*));
        $text.push('\n');
    }};
}

pub(crate) mod constrained;
pub(crate) mod staged;
pub(crate) mod sweep;

use crate::discretise::branches::{Boundary, Crossing};
use crate::discretise::split::SummandForm;
use crate::discretise::{
    Block, Facts, NoiseClass, Scheme, Solution, StepSymbols, Unknown, family_of, modified, unweighted,
};
use crate::embedding::{Embedding, Points};
use crate::model::{Collective, CollectiveRole, Conversion, Family, FamilyTerm, Form, Noise, System, Term};
use crate::symbolic::{Graph, Knowledge, Rational};

/// The text of one scheme, from the discrete Lagrangian to the step.
pub(crate) fn derivation(graph: &mut Graph, scheme: &Scheme) -> String {
    let mut text = String::new();
    lagrangian(graph, scheme, &mut text);
    equations(graph, scheme, &mut text);
    step(graph, scheme, &mut text);
    text
}

/// Every Hamiltonian and force, as sums of elements.
pub(crate) fn hamiltonians(system: &mut System, facts: &Facts) -> String {
    let (numbers, constraint_numbers) = (system.noise_numbers(), system.constraint_numbers());
    let line = system.line.clone().filter(|_| system.form == Form::StraightLines);
    let System {
        graph,
        drift,
        summands: parts,
        noise,
        constraints,
        force,
        conformal,
        conversion,
        clock,
        names,
        ..
    } = system;
    let text = &mut String::new();
    let value =
        |graph: &mut Graph, term: &Term| facts.space.display(graph, &unweighted(&term.values), Rational::ONE);
    say!(text, "\nHamiltonians");
    say!(text, "  H0 = {}", value(graph, drift));
    for ((name, part), form) in ["H_A", "H_B"].iter().zip(parts).zip(&facts.summands.forms) {
        say!(text, "  {name} = {}, a part of H0", value(graph, part));
        if let Ok(SummandForm::Kepler(components)) = form {
            say!(
                text,
                "    flow of {name} over a h: Kepler's, by universal variables, for each body of {components} coordinates"
            );
        }
    }
    let (forces, noise): (Vec<_>, Vec<_>) = numbers.iter().zip(noise).partition(|(_, noise)| noise.is_force);
    for (number, Noise { term, family, .. }) in noise {
        say!(text, "  H{number} = {}", facts.space.display_member(graph, &term.values, family.as_ref()));
    }
    let forces =
        forces.into_iter().map(|(number, force)| (number.as_str(), &force.term, force.family.as_ref()));
    let forces: Vec<(&str, &Term, Option<&Family>)> =
        force.iter().map(|force| ("0", force, None)).chain(forces).collect();
    if !forces.is_empty() {
        let of_work = if line.is_some() { "" } else { ", as virtual work" };
        say!(text, "\nForces{of_work}");
    }
    let mut components = line.iter().flat_map(|line| line.force.iter().chain(&line.noise_forces));
    for (number, force, family) in forces {
        let components = components.next().map(|components| -> Vec<String> {
            components.iter().map(|&component| graph.display(component)).collect()
        });
        match components.as_deref() {
            Some([only]) => say!(text, "  F{number} = {only}"),
            Some(components) => say!(text, "  F{number} = [{}]", components.join(", ")),
            None => {
                let work = facts.space.display_member(graph, &force.values, family);
                say!(text, "  F{number} · δ{} = {work}", names[0]);
            }
        }
    }
    if !constraints.is_empty() {
        say!(text, "\nConstraints");
        for (FamilyTerm { term, family }, number) in constraints.iter().zip(constraint_numbers) {
            let member = facts.space.display_member(graph, &term.values, family.as_ref());
            say!(text, "  0 = g{number} = {member}");
        }
    }
    let collectives = facts.space.collectives();
    let of_clock = |number: u32| clock.as_ref().is_some_and(|clock| clock.collectives.contains(&number));
    let of_system = collectives.all().iter().filter(|known| !of_clock(known.slot.number));
    let of_system: Vec<&Collective> = of_system.collect();
    if !of_system.is_empty() {
        say!(text, "\nCollective variables, and the slopes by these");
        for known in of_system {
            let name = graph.symbol_name(known.symbol).to_owned();
            let of = match known.role {
                CollectiveRole::Sum => String::new(),
                CollectiveRole::Slope(number) => {
                    let sum = collectives.numbered(number);
                    format!(" = ∂H/∂{}", graph.symbol_name(sum.symbol))
                }
            };
            let value = facts.space.display(graph, &unweighted(&known.elements), Rational::ONE);
            say!(text, "  {name}{of} = {value}");
        }
    }
    if let Some(rate) = *conformal {
        say!(text, "\nFriction");
        say!(text, "  γ = {}", graph.display(rate));
    }
    if let Some(Conversion { drift, force, .. }) = &*conversion {
        say!(
            text,
            "\nConversion from Ito to Stratonovich: what -1/2 Σ_k (X_k · ∇) X_k adds to the terms above"
        );
        match (drift, force) {
            (None, None) => say!(text, "  nothing: both senses are the same"),
            _ => {
                drift.iter().for_each(|drift| say!(text, "  to H0: {drift}"));
                force.iter().for_each(|force| say!(text, "  to F0 · δ{}: {force}", names[0]));
            }
        }
    }
    std::mem::take(text)
}

/// The noises of the step Hamiltonian, or of forces: ` + ΔW1 H1`, ` + Σ_k ΔW_k H_k` for a family.
fn noise_terms(system: &System, are_forces: bool) -> String {
    let name = if are_forces { "F" } else { "H" };
    let noises = system.noise.iter().zip(system.noise_numbers());
    let terms = noises.filter(|(noise, _)| noise.is_force == are_forces).map(|(noise, number)| {
        let sum = if noise.family.is_some() { "Σ_k " } else { "" };
        format!(" + {sum}ΔW{number} {name}{number}")
    });
    terms.collect()
}

fn lagrangian(graph: &mut Graph, scheme: &Scheme, text: &mut String) {
    let symbols = &scheme.lagrangian.symbols;
    say!(text, "\nDiscrete Lagrangian of the step from t_i to t_i + h");
    say!(text, "  L_d = {}", graph.display(scheme.lagrangian.value));
    for_each(symbols.degrees(), DEGREES, text, |i, text| {
        let (q0, u) = (symbols.nodes.q[i], symbols.unknowns.q[i]);
        let (node, increment) = (graph.symbol_name(q0).to_owned(), graph.symbol_name(u).to_owned());
        let end = node.strip_suffix("_i").map_or_else(|| node.clone(), |name| format!("{name}_{{i+1}}"));
        say!(text, "  {increment} = {end} - {node}");
    });
    for stage in symbols.stages.iter().filter(|stage| !stage.at.l.is_zero()) {
        for_each(symbols.degrees(), DEGREES, text, |i, text| {
            let increment = graph.symbol(symbols.unknowns.q[i]);
            let value = graph.shifted(symbols.nodes.q[i], increment, stage.at.l);
            say!(text, "  {} = {}", graph.symbol_name(stage.q[i]), graph.display(value));
        });
    }
}

/// The most characters of a derivation before lines for further degrees of freedom are left out.
const MOST: usize = 6_000;

const DEGREES: &str = "degrees of freedom";

/// Adds lines for each of `count` subjects until the text is long, and then says how many are left.
fn for_each(count: usize, subjects: &str, text: &mut String, mut lines: impl FnMut(usize, &mut String)) {
    for i in 0..count {
        if text.len() > MOST && i + 1 < count {
            say!(text, "  … and so on for {} further {subjects}", count - i);
            return;
        }
        lines(i, text);
    }
}

fn equations(graph: &mut Graph, scheme: &Scheme, text: &mut String) {
    let StepSymbols { nodes, unknowns, momentum, .. } = &scheme.lagrangian.symbols;
    say!(text, "\nDiscrete Euler-Lagrange equations");
    for_each(momentum.len(), DEGREES, text, |i, text| {
        let symbols = [momentum[i], unknowns.q[i], nodes.p[i], unknowns.p[i]];
        let [momentum, u, p0, v] = symbols.map(|symbol| graph.symbol_name(symbol).to_owned());
        let equations = &scheme.equations;
        say!(text, "  ∂L_d/∂{momentum} = 0:  {u} = {}", graph.display(equations.phi.q[i]));
        say!(
            text,
            "  {p0} = -D1 L_d:  {momentum} = {p0} + {v},  {v} = {}",
            graph.display(equations.phi.p[i])
        );
        let v = graph.symbol(unknowns.p[i]);
        let change = equations.update[i].change(graph, v);
        let end = p0.strip_suffix("_i").map_or_else(|| p0.clone(), |name| format!("{name}_{{i+1}}"));
        say!(text, "  {end} = D2 L_d:  {end} - {p0} = {}", graph.display(change));
    });
}

fn step(graph: &Graph, scheme: &Scheme, text: &mut String) {
    let symbols = &scheme.lagrangian.symbols;
    say!(text, "\nStep");
    for block in &scheme.structure.blocks {
        let Block { iterates, assigned, solution } = block;
        let method = match solution {
            Solution::Assigned => format!("assign {}", names(graph, symbols, assigned)),
            Solution::Isolated(pivot) => {
                format!("isolate: {} = 1/({})", graph.symbol_name(pivot.inverse), graph.display(pivot.value))
            }
            Solution::Linear { .. } => format!("solve for {}: linear", names(graph, symbols, iterates)),
            Solution::Newton { symmetric: true, .. } => {
                format!("solve for {}: Newton, symmetric Jacobian", names(graph, symbols, iterates))
            }
            Solution::Newton { .. } => format!("solve for {}: Newton", names(graph, symbols, iterates)),
        };
        let also = match solution {
            Solution::Linear { .. } | Solution::Newton { .. } if !assigned.is_empty() => {
                format!(" (then {})", names(graph, symbols, assigned))
            }
            _ => String::new(),
        };
        say!(text, "  {method}{also}");
    }
}

fn names(graph: &Graph, symbols: &StepSymbols, unknowns: &[Unknown]) -> String {
    let names: Vec<&str> = unknowns.iter().map(|&x| graph.symbol_name(symbols.unknowns[x])).collect();
    names.join(", ")
}

/// The known facts of the system and the scheme.
pub(crate) fn properties(graph: &mut Graph, facts: &Facts, embedding: &Embedding, text: &mut String) {
    say!(text, "\nFacts");
    quadrature(embedding, text);
    let [_, noise_l] = embedding.means();
    let has_noise = facts.noise != NoiseClass::None;
    if has_noise {
        let defect = facts.defect(graph, &facts.noise_contraction, noise_l);
        let verdict = if facts.converges(embedding) {
            "converges to the Stratonovich system"
        } else {
            match facts.noise_contraction.known {
                Knowledge::Unknown(_) => "is not known to converge to the Stratonovich system",
                _ => "converges to another system, with drift Hamiltonian H0 - D",
            }
        };
        say!(text, "  {verdict}; D = {defect}");
        if facts.force_defect_acts(noise_l) {
            let defect = facts.defect(graph, &facts.force_contraction, noise_l);
            say!(text, "  noise forces add the force d, d·δq = {defect}");
        }
        if !embedding.is_thermostat() {
            limits(facts, embedding, text);
        }
        for (number, rate) in facts.numbers.iter().zip(&facts.energy.rates) {
            // The brackets of a family are summed over its members.
            let sum = if rate.iter().any(|weighted| family_of(weighted).is_some()) { "Σ_k " } else { "" };
            let rate = facts.space.display(graph, rate, Rational::ONE);
            say!(text, "  {sum}{{H{number}, H0}} = {rate}");
        }
        if facts.has_several_noises {
            let commuting = match &facts.commuting {
                Knowledge::Proven => "the noises commute up to a constant",
                Knowledge::Refuted(_) => "the noises do not commute",
                Knowledge::Unknown(reason) => {
                    &format!("whether the noises commute could not be decided ({reason})")
                }
            };
            say!(text, "  {commuting}");
        }
    }
    for (name, power) in &facts.energy.powers {
        say!(text, "  {name} {}", facts.space.display(graph, power, Rational::ONE));
    }
    energy(facts, embedding, text);
    text.extend(modified::text(graph, facts, embedding));
    crossings(facts, text);
    for invariant in &facts.invariants {
        let is_kept = invariant.form.is_kept(embedding, has_noise);
        let keeps = if is_kept { "kept by the step to rounding" } else { followed(facts, embedding) };
        let value = facts.space.display(graph, &invariant.value, Rational::ONE);
        let name = if invariant.name.is_empty() { String::new() } else { format!("{} = ", invariant.name) };
        say!(text, "  first integral {name}{value}: {keeps}");
    }
    let has_integrals = !facts.invariants.is_empty() || facts.energy.is_conserved.is_proven();
    if has_noise && has_integrals {
        say!(
            text,
            "  each first integral of X is one of every X_ε: its rates along H0 and each noise vanish one by one"
        );
    }
}

/// The diagram of the Wong-Zakai approximation: `X` is the Stratonovich system, `X_ε` that of
/// `H0 + Σ_k H_k dW_{ε,k}/dt`, and `n` marks the scheme, driven by the increments of `W_ε` or of `W`. For a
/// smooth `W_ε` every scheme is consistent, and at fixed `h` the increments converge: only the last arrow
/// depends on the quadrature.
fn limits(facts: &Facts, embedding: &Embedding, text: &mut String) {
    let last = match (facts.converges(embedding), &facts.noise_contraction.known) {
        (true, _) => "X: asymptotically preserving",
        (false, Knowledge::Unknown(_)) => "X is not known",
        (false, _) => "the system with H0 - D, not X: not asymptotically preserving",
    };
    say!(text, "  h → 0, then ε → 0: X_{{ε,n}} → X_ε → X");
    say!(text, "  ε → 0, then h → 0: X_{{ε,n}} → X_n → {last}");
}

/// The user's quadrature points, and their known properties.
fn quadrature(embedding: &Embedding, text: &mut String) {
    let [drift, noise] = embedding.points();
    let mut say = |points: &Points, role: &str| {
        if points.is_single() {
            return;
        }
        let list: Vec<String> = points.iter().map(|(l, weight)| format!("({l}, {weight})")).collect();
        let symmetry = if points.are_symmetric() { ", symmetric" } else { "" };
        let (list, mean) = (list.join(", "), points.mean());
        say!(text, "  quadrature points and weights{role}: {list}; Σ w l = {mean}{symmetry}");
    };
    if drift == noise {
        say(&drift, "");
    } else {
        say(&drift, " of the drift");
        say(&noise, " of the noises");
    }
    if !drift.is_single() {
        let condition = if embedding.order() == 1 { "is not" } else { "is" };
        say!(text, "  order {}, as Σ w l of the drift {condition} 1/2", embedding.order());
    }
}

/// The change of the energy along the motion and along steps. Symplectic steps without noise follow the flow
/// of a Hamiltonian that differs by the order of the scheme (Hairer, Lubich, Wanner, Geometric Numerical
/// Integration, IX.8): its error does not grow.
fn energy(facts: &Facts, embedding: &Embedding, text: &mut String) {
    let has_noise = facts.noise != NoiseClass::None;
    let is_watched = !has_noise && !embedding.is_thermostat();
    let order = match embedding.order() {
        1 => "O(h)".to_owned(),
        2 => "O(h²)".to_owned(),
        order => format!("O(h^{order})"),
    };
    match &facts.energy.is_conserved {
        Knowledge::Proven => {
            // Steps with noise or a force follow no modified energy, also where these have no power.
            let keeps = if facts.energy_form.is_kept(embedding, has_noise) {
                "kept by the step to rounding".to_owned()
            } else if !facts.energy.is_conservative {
                followed(facts, embedding).to_owned()
            } else if facts.boundaries[0].is_empty() {
                format!("kept by the step nearly, within {order}")
            } else {
                // A modified energy is an expansion in derivatives of one piece.
                format!("kept by the step nearly, within {order} between the boundaries of its branches")
            };
            say!(text, "  H0 is a first integral: {keeps}");
        }
        Knowledge::Refuted(_) if facts.energy.only_jumps => {
            say!(text, "  H0 is not a first integral: it jumps, and is kept between its jumps");
            if is_watched {
                say!(text, "  runs do not compare H0 with its value at the start");
            }
        }
        Knowledge::Refuted(_) => say!(text, "  H0 is not a first integral"),
        Knowledge::Unknown(reason) => {
            say!(text, "  whether H0 is conserved could not be decided ({reason})");
            if is_watched {
                say!(text, "  runs compare H0 with its value at the start, as if it were");
            }
        }
    }
}

/// The conservation of a first integral that steps do not keep exactly.
fn followed(facts: &Facts, embedding: &Embedding) -> &'static str {
    match facts.noise == NoiseClass::None || facts.converges(embedding) {
        true => "kept by the step up to its order",
        false => "of the system, and not kept by what the step converges to in general",
    }
}

/// Adds a line for each boundary between branches.
fn crossings(facts: &Facts, text: &mut String) {
    let numbers = std::iter::once("0").chain(facts.numbers.iter().map(String::as_str));
    for (number, boundaries) in numbers.zip(&facts.boundaries) {
        for Boundary { place, crossing, .. } in boundaries {
            let finding = match crossing {
                // Where second derivatives jump, the step that crosses adds an error of O(h²) to the momenta.
                Crossing::Smooth => {
                    "is continuous, its slope, too: steps have at most order 2 across, unless second derivatives are continuous"
                }
                Crossing::Kink => "is continuous, its slope jumps: the step has order 1 across",
                Crossing::Jump(_) if number == "0" => "jumps: energy is kept on each side only",
                Crossing::Jump(_) => "jumps: its derivatives are those of either side",
                Crossing::JumpUnless(jump) => &format!("jumps unless {jump} = 0"),
                Crossing::Undecided => "was not decided to be continuous",
            };
            say!(text, "  where {place}, H{number} {finding}");
        }
    }
}
