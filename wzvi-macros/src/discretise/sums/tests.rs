//! Facts do not depend on how the size is given: as a literal, by a const generic, or by a slice.

#![allow(clippy::unwrap_used, clippy::panic)]

use crate::choose::choose;
use crate::diagnostics::Diagnostics;
use crate::discretise::facts::{Facts, NoiseClass};
use crate::embedding::Embedding;
use crate::input;
use crate::lower::lower;
use crate::passes::collect::collect;
use crate::passes::friction::friction;
use crate::passes::unroll::unroll;
use crate::symbolic::zero::Knowledge;
use crate::symbolic::{Graph, Rational};

use Knowledge::{Proven, Refuted};
use NoiseClass::{Additive, Multiplicative, Position};

const ITEM: &str = "struct Sites<const N: usize> { a: f64, sigma: f64, mass: Vec<f64>, sites: usize, \
                    bonds: Vec<(usize, usize)> }";

const LITERALS: [usize; 9] = [1, 2, 3, 8, 15, 16, 17, 18, 64];

/// The facts, derived as in the compiler.
fn facts_of(attribute: &str) -> (Graph, Facts) {
    let mut diagnostics = Diagnostics::new();
    let facts = find(attribute, &mut diagnostics);
    match diagnostics.finish() {
        Ok(()) => facts.unwrap(),
        Err(errors) => panic!("{attribute}: {errors}"),
    }
}

fn find(attribute: &str, diagnostics: &mut Diagnostics) -> Option<(Graph, Facts)> {
    let container = input::read_struct(ITEM.parse().unwrap(), diagnostics)?;
    let mut declaration = input::read_attribute(attribute.parse().unwrap(), diagnostics)?;
    let phase_space = input::read_phase_space(&mut declaration, diagnostics)?;
    let mut system = lower(container, declaration, &phase_space, diagnostics)?;
    let listed: Vec<_> = system.embeddings.iter().map(|known| known.value.clone()).collect();
    system.form = choose(&mut system, &listed).elements;
    unroll(&mut system);
    collect(&mut system, diagnostics);
    friction(&mut system, diagnostics);
    let facts = Facts::new(&mut system);
    Some((system.graph, facts))
}

/// Every spelling of a size that is at least `least`: a list of `point` and the number of points.
fn sizes(point: &str, least: usize) -> Vec<(String, String)> {
    let literals = LITERALS.into_iter().filter(|&n| n >= least);
    let mut sizes: Vec<(String, String)> =
        literals.map(|n| (format!("[{point}; {n}]"), n.to_string())).collect();
    sizes.push((format!("[{point}; N]"), "N".to_owned()));
    sizes.push((format!("&[{point}]"), "self.sites".to_owned()));
    sizes
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Is {
    Proven,
    Refuted,
    Unknown,
}

fn verdict(knowledge: &Knowledge) -> Is {
    match knowledge {
        Proven => Is::Proven,
        Refuted(_) => Is::Refuted,
        Knowledge::Unknown(_) => Is::Unknown,
    }
}

/// `$q` is the type of the state, `$n` the number of points, `$h` half of it.
fn at(text: &str, state: &str, n: &str) -> String {
    let half = n.parse::<usize>().map_or_else(|_| format!("{n} / 2"), |n| (n / 2).to_string());
    text.replace("$q", state).replace("$n", n).replace("$h", &half)
}

struct Expected {
    noise: NoiseClass,
    consistent: Is,
    energy: Is,
    commuting: Is,
}

fn check(point: &str, least: usize, drift: &str, noise: &str, expected: &Expected) {
    for (state, n) in sizes(point, least) {
        let attribute = at(
            &format!("drift = |q: $q, p: $q| {drift}, noise = [{noise}], embedding = Midpoint"),
            &state,
            &n,
        );
        let (_, facts) = facts_of(&attribute);
        let found = [&facts.noise_contraction.known, &facts.energy.is_conserved, &facts.commuting];
        let wanted = [expected.consistent, expected.energy, expected.commuting];
        assert_eq!(found.map(verdict), wanted, "{attribute}: {found:?}");
        assert_eq!(facts.noise, expected.noise, "{attribute}");
        let at_start = || Box::new(Embedding::DeltaPlus);
        let schemes = [Embedding::Uncorrected(at_start()), Embedding::Corrected(at_start())];
        let converge = schemes.map(|scheme| facts.converges(&scheme));
        assert_eq!(converge, [expected.consistent == Is::Proven, true], "{attribute}");
    }
}

const OSCILLATORS: &str = "(0..q.len()).map(|i| 0.5 * a * (q[i] * q[i] + p[i] * p[i])).sum::<f64>()";
const CHAIN: &str = "(0..q.len()).map(|i| 0.5 * p[i] * p[i]).sum::<f64>() \
                     + (1..q.len()).map(|i| (q[i] - q[i - 1]).powi(4)).sum::<f64>()";

#[test]
fn families_of_site_noises() {
    let [energy, commuting] = [Is::Proven; 2];
    // Every site rotates: its energy is conserved for all increments.
    let kubo = "|q, p, k| 0.5 * sigma * (q[k] * q[k] + p[k] * p[k]); $n";
    let expected = Expected { noise: Multiplicative, consistent: Is::Refuted, energy, commuting };
    check("f64", 1, OSCILLATORS, kubo, &expected);
    // Counted from the other end, and shifted around the ring.
    let reversed = "|q, p, k| 0.5 * sigma * (q[$n - 1 - k].powi(2) + p[$n - 1 - k].powi(2)); $n";
    check("f64", 1, OSCILLATORS, reversed, &expected);
    let expected = Expected { energy: Is::Refuted, ..expected };
    check("f64", 2, CHAIN, kubo, &expected);
    let forces = "|q, _p, k| sigma * q[k].sin(); $n";
    let expected = Expected { noise: Position, consistent: Is::Proven, ..expected };
    check("f64", 2, CHAIN, forces, &expected);
    let additive = "|q, p, k| q[k] - sigma * p[k]; $n";
    check("f64", 2, CHAIN, additive, &Expected { noise: Additive, ..expected });
}

#[test]
fn site_maps_that_never_share_a_site() {
    // 2 k and 2 k' + 1 are never one site; neither are n - 1 - 2 k and n - 2 - 2 k'.
    let pairs =
        "|q, p, k| sigma * q[2 * k] * p[2 * k] + 0.5 * (q[2 * k + 1].powi(2) + p[2 * k + 1].powi(2)); $h";
    let expected = Expected {
        noise: Multiplicative,
        consistent: Is::Refuted,
        energy: Is::Refuted,
        commuting: Is::Proven,
    };
    check("f64", 2, OSCILLATORS, pairs, &expected);
    let turned = "|q, p, k| 0.5 * (q[$n - 1 - 2 * k].powi(2) + p[$n - 1 - 2 * k].powi(2)) \
                  + 0.5 * sigma * (q[$n - 2 - 2 * k].powi(2) + p[$n - 2 - 2 * k].powi(2)); $h";
    check("f64", 2, OSCILLATORS, turned, &Expected { energy: Is::Proven, ..expected });
}

#[test]
fn families_beside_one_another_and_beside_single_noises() {
    let even = "[|q, p, k| sigma * q[2 * k] * p[2 * k]; $h]";
    let odd = "[|q, p, k| 0.5 * (q[2 * k + 1].powi(2) + p[2 * k + 1].powi(2)); $h]";
    let expected = Expected {
        noise: Multiplicative,
        consistent: Is::Refuted,
        energy: Is::Refuted,
        commuting: Is::Proven,
    };
    check("f64", 2, OSCILLATORS, &format!("{even}, {odd}"), &expected);
    // {q_0 p_0, q_0} is not constant.
    let expected = Expected { commuting: Is::Refuted, ..expected };
    check("f64", 2, OSCILLATORS, &format!("{even}, {odd}, |q, p| q[0]"), &expected);
}

#[test]
fn neighbours_that_do_not_commute() {
    // H_k = p_k q_(k+1): D = 0 and {H_k, H_(k+1)} = p_k q_(k+2).
    for (state, n) in sizes("f64", 3) {
        let Ok(n) = n.parse::<usize>() else { continue };
        let count = n - 1;
        let attribute = format!(
            "drift = |q: {state}, p: {state}| {CHAIN}, noise = [|q, p, k| p[k] * q[k + 1]; {count}], embedding = Midpoint"
        );
        let (_, facts) = facts_of(&attribute);
        assert_eq!(
            verdict(&facts.noise_contraction.known),
            Is::Proven,
            "{attribute}: {:?}",
            facts.noise_contraction.known
        );
        assert_eq!(verdict(&facts.commuting), Is::Refuted, "{attribute}");
    }
}

/// Whether each declared first integral is one.
fn integrals(point: &str, least: usize, drift: &str, noise: &str, declared: &[(&str, Is)]) {
    let closures: Vec<String> = declared.iter().map(|(f, _)| format!("|q: $q, p: $q| {f}")).collect();
    for (state, n) in sizes(point, least) {
        let attribute = format!(
            "drift = |q: $q, p: $q| {drift}, {noise} invariant = [{}], embedding = Midpoint",
            closures.join(", ")
        );
        let attribute = at(&attribute, &state, &n);
        let (mut graph, facts) = facts_of(&attribute);
        for (found, (integral, wanted)) in facts.invariants.iter().zip(declared) {
            let verdict = found.failure.as_ref().map_or(Is::Proven, |failure| verdict(&failure.found.known));
            let rate = found.failure.as_ref().map_or_else(String::new, |failure| {
                format!(
                    "{} {:?}",
                    facts.space.display(
                        &mut graph,
                        &failure.found.sum.clone().unwrap_or_default(),
                        Rational::ONE
                    ),
                    failure.found.known
                )
            });
            assert_eq!(verdict, *wanted, "{integral} of {attribute}: {rate}");
        }
    }
}

#[test]
fn first_integrals_of_chains() {
    let respelt = "q.iter().zip(q.iter().skip(1)).map(|(a, b)| (b - a).powi(4)).sum::<f64>() \
                   + 0.5 * p.iter().map(|p| p * p).sum::<f64>()";
    let sum = "p.iter().sum::<f64>()";
    let declared = [(respelt, Is::Proven), (sum, Is::Proven), ("q.iter().sum::<f64>()", Is::Refuted)];
    integrals("f64", 2, CHAIN, "", &declared);
}

#[test]
fn first_integrals_of_rings() {
    let toda = "(0..q.len()).map(|i| 0.5 * p[i] * p[i] + (q[i] - q[(i + 1) % q.len()]).exp()).sum::<f64>()";
    // Flaschka, Phys. Rev. B 9 (1974) 1924: the third integral; its rate cancels between neighbours only.
    let third = "(0..q.len()).map(|i| p[i].powi(3) / 3.0 + (p[i] + p[(i + 1) % q.len()]) \
                 * (q[i] - q[(i + 1) % q.len()]).exp()).sum::<f64>()";
    let energy = "(0..q.len()).map(|i| 0.5 * p[i] * p[i] + (q[(i + q.len() - 1) % q.len()] - q[i]).exp()).sum::<f64>()";
    let wrong = "(0..q.len()).map(|i| p[i].powi(3) / 3.0 + 2.0 * p[i] \
                 * (q[i] - q[(i + 1) % q.len()]).exp()).sum::<f64>()";
    let declared = [
        ("p.iter().sum::<f64>()", Is::Proven),
        (energy, Is::Proven),
        (third, Is::Proven),
        (wrong, Is::Refuted),
    ];
    integrals("f64", 3, toda, "", &declared);
}

#[test]
fn first_integrals_of_points() {
    let planets = "{ let n = q.len(); \
        let kinetic: f64 = (0..n).map(|i| (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / (2.0 * mass[i])).sum(); \
        let mut potential = 0.0; \
        for i in 0..n { for j in 0..i { \
            let r2: f64 = (0..2).map(|c| (q[i][c] - q[j][c]).powi(2)).sum(); \
            potential -= mass[i] * mass[j] / (r2 + 0.01).sqrt(); } } \
        kinetic + potential }";
    let energy = "{ let n = q.len(); \
        let kinetic: f64 = (0..n).map(|i| (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / (2.0 * mass[i])).sum(); \
        let mut potential = 0.0; \
        for i in 0..n { for j in 0..i { \
            potential -= mass[i] * mass[j] / ((q[i][0] - q[j][0]).powi(2) + (q[i][1] - q[j][1]).powi(2) + 0.01).sqrt(); } } \
        kinetic + potential }";
    let declared = [
        ("p.iter().map(|p| p[0]).sum::<f64>()", Is::Proven),
        ("q.iter().zip(p).map(|(q, p)| q[0] * p[1] - q[1] * p[0]).sum::<f64>()", Is::Proven),
        (energy, Is::Proven),
        ("q.iter().zip(p).map(|(q, p)| q[0] * p[1] + q[1] * p[0]).sum::<f64>()", Is::Refuted),
    ];
    integrals("[f64; 2]", 2, planets, "", &declared);
}

#[test]
fn first_integrals_of_mean_fields() {
    let total = "p.iter().sum::<f64>()";
    let kinetic = "p.iter().map(|p| 0.5 * p * p).sum::<f64>()";
    let rotors = format!(
        "{{ let c: f64 = q.iter().map(|q| q.cos()).sum(); let s: f64 = q.iter().map(|q| q.sin()).sum(); \
         {kinetic} - (1.0 + c * c + s * s).sqrt() }}"
    );
    let trap = format!(
        "{{ let m = q.iter().sum::<f64>() / q.len() as f64; {kinetic} + q.iter().map(|q| (q - m).powi(2)).sum::<f64>() }}"
    );
    let wrong = "{ let c: f64 = q.iter().map(|q| q.cos()).sum(); \
                 p.iter().map(|p| 0.5 * p * p).sum::<f64>() - (1.0 + c * c).sqrt() }";
    let chain = format!("{CHAIN} + p.iter().sum::<f64>().cosh()");
    let declared = [(total, Is::Proven), (rotors.as_str(), Is::Proven)];
    integrals("f64", 2, &rotors, "", &declared);
    integrals("f64", 2, &trap, "", &[(total, Is::Proven), (&trap, Is::Proven)]);
    integrals("f64", 2, &chain, "", &[(total, Is::Proven), (CHAIN, Is::Proven)]);
    // Slopes that are sums themselves: of a force that is not linear, with masses, and of a variance.
    for centred in [
        "let mean = q.iter().sum::<f64>() / q.len() as f64; kinetic + q.iter().map(|q| (q - mean).powi(4)).sum::<f64>()",
        "let masses = (0..q.len()).map(|i| 1.0 + 0.1 * i as f64).sum::<f64>(); \
         let mean = (0..q.len()).map(|i| (1.0 + 0.1 * i as f64) * q[i]).sum::<f64>() / masses; \
         kinetic + q.iter().map(|q| (q - mean).cosh() + a * (q - mean).powi(2)).sum::<f64>()",
        "let mean = q.iter().sum::<f64>() / q.len() as f64; \
         let variance = q.iter().map(|q| (q - mean) * (q - mean)).sum::<f64>() / q.len() as f64; \
         kinetic + a * (1.0 + variance).sqrt()",
    ] {
        let drift = format!("{{ let kinetic = p.iter().map(|p| 0.5 * p * p).sum::<f64>(); {centred} }}");
        integrals("f64", 2, &drift, "", &[(total, Is::Proven)]);
    }
    for (state, n) in sizes("f64", 2) {
        // A witness is looked for up to 32 sites.
        let attribute = at(
            &format!(
                "drift = |q: $q, p: $q| {wrong}, invariant = [|q: $q, p: $q| {total}], embedding = Midpoint"
            ),
            &state,
            &n,
        );
        let (_, facts) = facts_of(&attribute);
        let failure = facts.invariants[0].failure.as_ref().unwrap();
        let is_large = n.parse::<i128>().is_ok_and(|n| n > 32);
        let wanted = if is_large { Is::Unknown } else { Is::Refuted };
        assert_eq!(verdict(&failure.found.known), wanted, "{attribute}");
    }
    let plane = "{ let x: f64 = q.iter().map(|q| q[0]).sum(); let y: f64 = q.iter().map(|q| q[1]).sum(); \
        q.iter().zip(p).map(|(q, p)| 0.5 * (p[0] * p[0] + p[1] * p[1] + q[0] * q[0] + q[1] * q[1])).sum::<f64>() \
        + (1.0 + x * x + y * y).ln() }";
    let spin = "q.iter().zip(p).map(|(q, p)| q[0] * p[1] - q[1] * p[0]).sum::<f64>()";
    integrals("[f64; 2]", 2, plane, "", &[(spin, Is::Proven)]);
}

#[test]
fn bonds_of_a_table_keep_the_total_momentum() {
    let attribute = "drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>() \
        + (0..bonds.len()).map(|b| (q[bonds[b].0] - q[bonds[b].1]).powi(4)).sum::<f64>(), \
        invariant = [|q, p| p.iter().sum::<f64>()], embedding = Midpoint";
    let (_, facts) = facts_of(attribute);
    assert!(facts.invariants[0].failure.is_none());
}

#[test]
fn what_fails_at_a_small_size_only_is_refuted_where_the_size_is_free() {
    // D = Σ_k [k = k + 1 mod n] q_k p_k is not constant for one site only.
    let ring = "|q, p, k| p[k] * q[(k + 1) % q.len()]; $n";
    for (state, n) in sizes("f64", 1) {
        let attribute = at(
            &format!("drift = |q: $q, p: $q| {OSCILLATORS}, noise = [{ring}], embedding = Midpoint"),
            &state,
            &n,
        );
        let (_, facts) = facts_of(&attribute);
        let wanted = match n.as_str() {
            "1" | "N" => Is::Refuted,
            // The number of noises differs from the number of points.
            "self.sites" => Is::Unknown,
            _ => Is::Proven,
        };
        assert_eq!(
            verdict(&facts.noise_contraction.known),
            wanted,
            "{attribute}: {:?}",
            facts.noise_contraction.known
        );
    }
}

#[test]
fn what_only_the_running_program_knows_is_unknown_or_refuted() {
    // Two bonds may share a site.
    let attribute = "drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>(), \
        noise = [|q, p, k| q[bonds[k].0] * p[bonds[k].1]; self.bonds.len()], embedding = Midpoint";
    let (_, facts) = facts_of(attribute);
    assert_ne!(verdict(&facts.noise_contraction.known), Is::Proven);
    assert_ne!(verdict(&facts.commuting), Is::Proven);
}

/// `Σ_k {H_k, {H_k, H_0}}` is constant, or not, in one degree of freedom and in loops; what a force, friction
/// or a mixed noise needs beside it.
#[test]
fn weak_order_two_is_known_where_the_double_brackets_are_constant() {
    let cases = [
        ("drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, _| -sigma * q]", true),
        (
            "drift = |q, p, t| 0.5 * p * p - q.cos() + a * t * q, noise = [|q, _, t| -sigma * t.cos() * q]",
            true,
        ),
        // T'' depends on p.
        ("drift = |q, p| (1.0 + p * p).sqrt() - q.cos(), noise = [|q, _| -sigma * q]", false),
        ("drift = |q, p| 0.5 * p * p * (1.0 + q * q), noise = [|q, _| -sigma * q]", false),
        ("drift = |q, p| 0.5 * p * p + 0.5 * a * q * q, noise = [|_, p| sigma * p]", true),
        ("drift = |q, p| 0.5 * p * p - q.cos(), noise = [|_, p| sigma * p]", false),
        ("drift = |q, p| 0.5 * p * p + 0.5 * a * q * q, noise = [|_, p| sigma * p.sin()]", false),
        ("drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, _| sigma * q.cos()]", false),
        // cos² + sin² = 1: constant for both together.
        (
            "drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, _| sigma * q.cos(), |q, _| sigma * q.sin()]",
            true,
        ),
        ("drift = |q, p| 0.5 * (p * p + q * q), noise = [|q, p| a * q + sigma * p]", true),
        // D = 0, but a step that is made of kicks and drifts weighs its terms otherwise.
        ("drift = |q, p| 0.25 * (q - p).powi(4), noise = [|q, p| a * (q - p)]", false),
        ("drift = |q, p| 0.5 * a * (q * q + p * p), noise = [|q, p| 0.5 * sigma * (q * q + p * p)]", true),
        ("drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, p| 0.5 * sigma * (q * q + p * p)]", false),
        ("drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, p| sigma * q * p]", false),
        ("drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, _| -sigma * q], force = |q, p| -a * p", true),
        (
            "drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, _| -sigma * q], force = |q, p| -a * p * p * p",
            false,
        ),
        ("drift = |q, p| 0.5 * p * p - q.cos(), noise = [|q, _| -sigma * q], friction = a", true),
        ("drift = |q, p| 0.5 * p * p + 0.5 * q * q, noise = [|_, p| -sigma * p], friction = a", false),
        (
            "drift = |q: [f64; 2], p: [f64; 2]| 0.5 * (p[0] * p[0] + p[1] * p[1] / mass[1]) + (q[0] * q[1]).sin(), \
             noise = [|q, p, k| sigma * q[k]; 2]",
            true,
        ),
        (
            "drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * p[i] * p[i]).sum::<f64>() \
             + (1..q.len()).map(|i| (q[i] - q[i - 1]).powi(4)).sum::<f64>(), noise = [|q, p, k| mass[k] * q[k]; self.mass.len()]",
            true,
        ),
        (
            "drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * p[i] * p[i]).sum::<f64>() \
             + (1..q.len()).map(|i| (q[i] - q[i - 1]).powi(4)).sum::<f64>(), noise = [|q, p, k| sigma * q[k].sin(); self.sites]",
            false,
        ),
    ];
    for (system, expected) in cases {
        let (_, facts) = facts_of(&format!("{system}, embedding = Midpoint"));
        assert_eq!(facts.has_weak_order_two, expected, "{system}");
    }
}

#[test]
fn the_defect_is_printed_in_indices() {
    let attribute = "drift = |q: &[f64], p: &[f64]| p.iter().map(|p| 0.5 * p * p).sum::<f64>(), \
        noise = [|q, p, k| sigma * q[k] * p[k]; self.sites], embedding = Midpoint";
    let (mut graph, facts) = facts_of(attribute);
    let defect = facts.defect(&mut graph, &facts.noise_contraction, Rational::ZERO);
    assert_eq!(defect, "Σ_(i=0..sites - 1) [sigma² q[i] p[i]/2]");
}
