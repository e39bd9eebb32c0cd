//! The texts of the schemes, composed from the texts of the schemes with one `P`.

use crate::discretise::describe::{constrained, derivation, hamiltonians, properties, staged, sweep};
use crate::discretise::{Facts, Plans, SchemePlan, Step};
use crate::embedding::{Embedding, LetterKind};
use crate::model::{System, Temperature};
use crate::symbolic::Rational;

/// The texts of `EQUATIONS` and of the documentation.
pub(crate) struct Texts {
    of_schemes: Vec<(Embedding, String)>,
}

impl Texts {
    pub(crate) fn new(system: &mut System, facts: &Facts, plans: &Plans) -> Self {
        let declared = hamiltonians(system, facts);
        let whole = |system: &mut System, embedding: &Embedding, derivation: &str| {
            let mut text = format!("{embedding}\n{declared}{derivation}");
            properties(&mut system.graph, facts, embedding, &mut text);
            text
        };
        let (mut derivations, mut texts) = (Vec::new(), Self { of_schemes: Vec::new() });
        for plan in &plans.schemes {
            let SchemePlan { embedding, step, .. } = plan;
            let derivation = match step {
                Step::StraightLine(scheme) => derivation(&mut system.graph, scheme),
                Step::InLoops(strategy) => sweep::derivation(system, facts, plans, plan, *strategy),
            };
            texts.of_schemes.push((embedding.clone(), whole(system, embedding, &derivation)));
            derivations.push((embedding, derivation));
        }
        for embedding in &plans.listed {
            let text = match embedding.substeps().as_slice() {
                _ if embedding.keeps_constraints() => {
                    let step = constrained::derivation(system, facts, embedding);
                    whole(system, embedding, &step)
                }
                _ if embedding.is_thermostat() => {
                    let bath = thermostat(embedding, system.has_forces(), system.temperature.as_ref());
                    whole(system, embedding, &bath)
                }
                [step] if step == embedding => continue,
                [step] => texts.of(step).to_owned(),
                [] => {
                    let stages = embedding.stages();
                    let stages =
                        stages.map_or_else(String::new, |n| staged::derivation(system, facts, plans, n));
                    whole(system, embedding, &stages)
                }
                halves => {
                    let halves = derivations.iter().filter(|(known, _)| halves.contains(known));
                    let halves = halves.map(|(half, derivation)| (*half, derivation.as_str()));
                    whole(system, embedding, &of_halves(halves, plans.flows.is_some()))
                }
            };
            texts.of_schemes.push((embedding.clone(), text));
        }
        texts
    }

    /// The text of a listed scheme, or of one with one `P` that a listed scheme needs.
    pub(crate) fn of(&self, embedding: &Embedding) -> &str {
        let known = self.of_schemes.iter().find(|(known, _)| known == embedding);
        known.map_or("", |(_, text)| text)
    }
}

/// The text of a step in two halves; `has_flows`: the halves are flows.
fn of_halves<'e>(halves: impl Iterator<Item = (&'e Embedding, &'e str)>, has_flows: bool) -> String {
    // A half needs no correction: the other makes up for it.
    let halves = halves.map(|(half, derivation)| match half {
        Embedding::Uncorrected(bare) => format!("\n{bare}\n{derivation}"),
        half => format!("\n{half}\n{derivation}"),
    });
    let (halves, flows) = (halves.collect::<String>(), if has_flows { FLOWS } else { "" });
    format!("\nA step of size h is two of size h/2, with half of the increments each:\n{halves}{flows}")
}

/// How a step with a bath is taken.
fn thermostat(embedding: &Embedding, has_force: bool, temperature: Option<&Temperature>) -> String {
    let (is_shortened, is_cayley) = (*embedding == Embedding::GjI, *embedding == Embedding::Gjf);
    let (is_list, is_timed) = temperature.map_or((false, false), |known| (known.is_list, known.reads_time));
    let noise = match (is_timed, is_cayley) {
        (true, false) => {
            "R Rᵀ = (T1 - c² T0 - (T1 - T0) (1 - c²)/(2 γ s)) M, c = e^{-γ s} of each rate γ and the time s of this part"
        }
        (true, true) => "R Rᵀ = T (M - E M Eᵀ), T at the middle of the step",
        (false, _) if is_list => "R Rᵀ = T (M - E M Eᵀ), T the diagonal matrix of the temperatures",
        (false, _) => "R Rᵀ = kT (M - E M Eᵀ)",
    };
    let slope = if has_force { "(∂V/∂q - F)" } else { "∂V/∂q" };
    let relax = |time: &str| {
        let decay = match is_cayley {
            true => "(1 + h/2 Γ M⁻¹)⁻¹ (1 - h/2 Γ M⁻¹)".to_owned(),
            false => format!("exp(-{time} Γ M⁻¹)"),
        };
        format!("  friction and noise of {time}: p <- E p + R ξ, E = {decay}, {noise}\n")
    };
    let flow = |(kind, share): (LetterKind, Rational)| {
        let time = times(if is_shortened && kind != LetterKind::Bath { "s h" } else { "h" }, share);
        match kind {
            LetterKind::Drift => format!("  drift of {time}:  q <- q + {time} M⁻¹ p\n"),
            LetterKind::Kick => format!("  kick of {time}:  p <- p - {time} {slope}\n"),
            LetterKind::Bath => relax(&time),
        }
    };
    let step = match embedding {
        Embedding::Thermostat(inner) => {
            let inner = format!("  a step of {inner} of the system without friction and noise of the bath\n");
            format!("{0}{inner}{0}", relax("h/2"))
        }
        word => word.letters().map_or(String::new(), |word| word.shares().into_iter().map(flow).collect()),
    };
    let factor = "  with s = √(tanh(γh/2)/(γh/2)), γ the rate of the friction\n";
    let factor = if is_shortened { factor } else { "" };
    let order = match embedding {
        Embedding::Splitting(word) => {
            let symmetry = if word.is_symmetric() { "symmetric" } else { "not symmetric" };
            let order = word.order();
            format!(
                "  of order {order}, {symmetry}; HarmonicLaw::of says what it makes of a harmonic force\n"
            )
        }
        _ => String::new(),
    };
    let equilibrium = match (is_list, is_timed, is_cayley) {
        (false, false, _) => "",
        (true, false, _) => {
            "  no equilibrium: the temperatures of the degrees of freedom differ, and no Boltzmann law is stationary\n"
        }
        (_, true, true) => {
            "  no equilibrium: the temperature depends on the time, and no Boltzmann law is stationary\n"
        }
        (_, true, false) => {
            "  T0 and T1 are the temperatures at the start and at the end of each part with friction, which takes them as linear between\n  \
             no equilibrium: the temperature depends on the time, and no Boltzmann law is stationary\n"
        }
    };
    let driven = "the increments of the noises, then √h times the normals ξ of each part with friction";
    let diffusion = diffusion(embedding);
    let end = match equilibrium {
        "" => format!("  a free particle diffuses with {diffusion}\n"),
        none => none.to_owned(),
    };
    format!("\nStep\n{step}{factor}{order}  driven by {driven}\n{end}")
}

/// How fast a free particle diffuses in these steps.
fn diffusion(embedding: &Embedding) -> &'static str {
    let one_drift = "D = kT/(m γ) (γh/2) coth(γh/2), too fast by (γh)²/12, and so is a slow passage where friction is large; Gjf has it right";
    match embedding {
        Embedding::Gjf | Embedding::GjI => "D = kT/(m γ), that of the equation, for any h",
        Embedding::Splitting(word) if !word.has_drifts_together() => {
            "D = kT/(m γ) times `diffusion` of HarmonicLaw::of, which differs from that of one drift"
        }
        _ => one_drift,
    }
}

/// `h/2`, `3 h/4`
fn times(h: &str, share: Rational) -> String {
    let (n, d) = (share.numerator(), share.denominator());
    let factor = if n == 1 { String::new() } else { format!("{n} ") };
    if d == 1 { format!("{factor}{h}") } else { format!("{factor}{h}/{d}") }
}

/// How a step of `Verlet` is taken of `T(p) + V(q, t)`.
const FLOWS: &str = "
Step, by the flows of H = T(p) + V(q), which are exact
  kick of h/2 at t:      p <- p - h/2 ∂V/∂q
  drift of h:            q <- q + h ∂T/∂p
  kick of h/2 at t + h:  p <- p - h/2 ∂V/∂q, whose force is that of the first kick of the next step
  (in compositions drifts and kicks that meet are one)
";
