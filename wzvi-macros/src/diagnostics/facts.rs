//! The messages about the mathematics: what was derived contradicts what was declared. Tests:
//! `tests/compiler/ui/messages`.

use std::fmt::Display;

use crate::symbolic::{Graph, Knowledge, Witness};

messages! {
    /// A bare scheme whose noise forces change the limit.
    inconsistent_forces(found, scheme: &impl Display, hamiltonian: &str, force: &str) = "`{scheme}` does not \
        converge to this Stratonovich system as h -> 0: noise forces depend on the momenta that they change, and the \
        limit has a further force d, d·δq = {force}{hamiltonian}; write `Midpoint`, `Gauss<2>` or `Verlet`, which \
        are consistent with every noise, or `Uncorrected<{scheme}>` to keep the scheme as it is";
    /// A counter-term of noise forces, which has no Hamiltonian.
    correction_of_forces(found, scheme: &impl Display) = "`{scheme}` adds a counter-term for noise Hamiltonians, \
        and there is none for noise forces that depend on momenta; use `Midpoint`, `Gauss<2>` or `Verlet`, which are \
        consistent with every noise";
    /// `Baoab` or another splitting, for a system that is not `T(p) + V(q, t)`.
    word_without_flows(found, scheme: &impl Display, converted: &str) = "`{scheme}` alternates drifts by T(p) and kicks by \
        V(q, t): here a Hamiltonian contains momenta with coordinates (or the time), or a force depends on momenta{converted}; write \
        `Thermostat<Midpoint>`";
    /// A part of a drift whose flow is not known.
    part_without_flow(found, reason: &str) = "this part of the drift has no known flow: {reason}; flows \
        are known for functions of the coordinates (and the time), for functions of the momenta (and the time), \
        for polynomials of degree two in both with constant coefficients, and for Kepler problems, sums over bodies of \
        |p|²/(2 m) - k/|q| with constants m and k; for the last two the size must be known; write one \
        Hamiltonian if no scheme needs the parts";
    /// A force or friction that fits neither part of a drift.
    acts_in_no_part(found, reason: &str, converted: &str) = "this belongs to neither part of the drift: {reason}{converted}; write the drift \
        as one Hamiltonian, whose schemes take any force at their stages, or `drift = [|q, p| ..., |q, _| ...]` \
        with a part that contains coordinates only";
    /// A counter-term whose indices the compiler cannot write.
    counter_term_of_elements(found, scheme: &impl Display) = "the counter-term of `{scheme}` cannot be written: \
        its indices exceed 128 bits, or a noise is a nonlinear function of a sum over sites; use `Midpoint`, which is consistent with every noise";
    thermostat_without_friction(found, scheme: &impl Display) = "`{scheme}` is for systems with friction: add \
        `friction = ...` (1/time) and `temperature = ...` (energy)";
    temperatures_of_coupled_momenta(found) = "temperatures that differ need a friction and masses that do not couple \
        momenta: write a diagonal `damping` (mass/time) or one rate of `friction` (1/time) for each degree of freedom, and a kinetic \
        energy without products of different momenta";
    temperature_without_friction(found) = "a temperature acts through friction: add `friction = ...` (1/time) or \
        `damping = [[...]]` (mass/time)";
    /// A scheme that cannot include friction and its noise, listed beside schemes that can.
    friction_needs_thermostat(found, scheme: &impl Display, reason: &str, keeps_constraints: bool) {
        remedy = match keeps_constraints {
            true => "`GBaoab`".to_owned(),
            false => format!("`Thermostat<{scheme}>`, or `Baoab`"),
        };
    } = "{reason}: write {remedy}";
    bath_on_manifold(found) = "`GBaoab` takes one rate of friction, `friction = gamma` (1/time), and one temperature: with others, friction \
        and noise in the tangent plane have no closed form";
    friction_without_masses(found) = "friction needs masses: a kinetic energy that is a quadratic form of the \
        momenta with constant coefficients, as in `p * p / (2.0 * m)`; write friction of other momenta as a \
        force, as in `force = |q, p| -gamma * p`";
    rates_of_coupled_momenta(found) = "rates of single degrees of freedom need a kinetic energy without products of \
        two momenta; write one rate for all of them, or the symmetric matrix `damping = [[...]]` (mass/time)";
    asymmetric_damping(found) = "a damping matrix is symmetric: entries across the diagonal are equal; write \
        a part that is not symmetric as `force = |q, p| [...]`";
    damping_of_place(found) = "a damping matrix does not depend on the coordinates; write rates by degree of freedom, which \
        may, as `friction = |q| [...]` (1/time), or, without a temperature, the matrix as a force, `force = |q, p| [...]` with the \
        value `-Γ(q) M⁻¹ p`";
    /// A product with inverse masses whose indices the compiler cannot write.
    damping_of_elements(found) = "this damping cannot be written as a force: its indices exceed 128 bits; write it \
        as `force`";
    /// A bare scheme whose limit is not the Stratonovich system.
    inconsistent(found, scheme: &impl Display, defect: &str, constant: &Knowledge) {
        finding = match constant {
            Knowledge::Unknown(reason) => {
                format!("whose defect D = {defect} could not be shown to be constant: {reason}")
            }
            _ => format!("with drift Hamiltonian H0 - D, where D = {defect}"),
        };
    } = "`{scheme}` does not converge to this Stratonovich system as h -> 0, but to the one {finding}; write \
        `Corrected<{scheme}>` to add the counter-term, or `Uncorrected<{scheme}>` to keep the scheme as it is \
        (`Midpoint` is consistent with every noise)";
    leaves_constraints(found, scheme: &impl Display) = "`{scheme}` would leave the manifold of the constraints; write \
        `Rattle`, whose compositions `Composed<Rattle, Yoshida4>` and others have higher orders";
    keeps_no_constraints(found, scheme: &impl Display) = "`{scheme}` is for systems with constraints: add `constraint = [|q| ...]`, or \
        write `Verlet`, which it is without them";
    bath_without_masses(found, converted: &str) = "`GBaoab` needs masses: a kinetic energy that is a sum of squares of the momenta with \
        constant coefficients, as in `p * p / (2.0 * m)`, and no other term, noise or force that reads momenta{converted}";
    constraint_of_nothing(found) = "this constraint reads no coordinate: it holds at every state, or at none";
    constraint_without_points(found) = "no state satisfies this constraint: it has one sign everywhere";
    affine_constraint(found) = "this constraint is affine in the coordinates: it leaves a plane, which needs no multipliers; choose coordinates \
        in the plane, as `x` alone where `y = 2.0 * x + 1.0`, with the kinetic energy of these";
    constraint_again(found, other: &str) = "this constraint is a multiple of constraint g{other}, and adds nothing; leave one of them out";
    constraint_before(found, other: &str) = "constraint g{other} is a multiple of this one";
    noise_off_manifold(found, constraint: &str, noise: &str, bracket: &str) = "noise H{noise} moves the system off the manifold of this constraint: \
        {{g{constraint}, H{noise}}} = {bracket} does not vanish, and a multiplier that grows as 1/√h would bring it back; take a noise \
        that reads coordinates, or one whose flow keeps the constraint, as a rotation keeps a length";
    no_clock(found, scheme: &str) = "`{scheme}` needs a clock: add `clock = curvature`, or the wanted length of a step up to a factor, \
        `clock = |q, p| ...`";
    clock_on_manifold(found) = "there is no clock on a manifold of constraints: leave it out, or choose coordinates without constraints";
    clock_is_zero(found) = "this clock is zero: it is the wanted length of a step up to a factor, and positive";
    /// A clock whose indices the compiler cannot write.
    clock_of_elements(found) = "the rate of this clock cannot be written: its indices exceed 128 bits";
    clock_of_bath(found) = "a bath acts on every momentum, by noise and friction that are no part of this clock's rate: let it read \
        coordinates only, `clock = |q, _| ...`";
    /// `{{H_k, Q}}` of a noise does not vanish.
    noise_of_clock(found, along: &str, rate: &str, knowledge: &Knowledge) {
        finding = match knowledge {
            Knowledge::Unknown(reason) => format!("may change this clock: {along} = {rate} could not be proven to vanish ({reason}), and then"),
            _ => format!("changes this clock: {along} = {rate} does not vanish, and"),
        };
    } = "a noise {finding} the length of a step would depend on its own noise; take a clock that noises leave as it is: one that reads coordinates only, where noises read \
        coordinates only or are forces";
    frequency_in_loops(found) = "the frequency of `curvature(w0)` is one number of fields, such as `curvature(self.w0)`";
    curvature_of_many(found, most: usize) = "`curvature` has a term for each pair of coordinates, and is derived for up to {most} of them, whose \
        number and places are known when this compiles: write `clock = pairs` if the potential is a sum over pairs, or a clock of \
        your own, `clock = |q, p| ...`";
    curvature_of_linear(found) = "V'' = 0, constant steps are exact: leave the clock out, or write one of your own, `clock = |q, p| ...`";
    /// A clock that is infinite at a point.
    curvature_vanishes(found, place: &str) = "V'' vanishes where {place}, and this clock is infinite there: write \
        `curvature(w0)`, which adds the fourth power of a frequency `w0` of the system, a field or a number";
    pairs_without_masses(found) = "`pairs` needs masses: a kinetic energy that is a sum of squares of the momenta with constant coefficients, as in \
        `p * p / (2.0 * m)`; write `clock = curvature`, or a clock of your own, `clock = |q, p| ...`";
    no_pairs(found) = "the potential is no sum over pairs: no term reads two points; write `clock = curvature`, or a clock of your own, \
        `clock = |q, p| ...`";
    no_pair(found, term: &str) = "`pairs` needs a potential that is a sum over pairs, each a function of the distance of two points, and \
        {term} is none; write `clock = curvature`, or a clock of your own, `clock = |q, p| ...`";
    masses_of_components(found) = "`pairs` needs one mass for all components of a point; write `clock = curvature`, or a clock of your own, \
        `clock = |q, p| ...`";
    /// A scheme in the extended phase space beside something that is no part of `Q (H0 + p_t)`.
    not_extended(found, scheme: &str, inner: &str, reason: &str) = "`{scheme}` takes steps of the Hamiltonian Q (H0 + p_t), and {reason}; write \
        `Clocked<{inner}>`";
    extended_verlet(found, reason: &str) = "`Extended<Verlet>` is explicit for p · M⁻¹ p/2 + V(q, t) with a clock of the coordinates, and {reason}; \
        write `Extended<Gauss<8>>` or `Clocked<Verlet>`";
    logarithmic_of_other(found, scheme: &str, reason: &str) = "`{scheme}` takes steps of f(T(p) + p_t) - f(-V(q)): {reason}; write `Clocked<Verlet>` \
        with `clock = curvature`";
    /// A potential that is not proven to be negative.
    potential_not_negative(found, scheme: &str, term: &str) = "`{scheme}` needs V < 0, and the term {term} of V is not proven to be negative \
        where all parameters are positive; write `Clocked<Verlet>` with `clock = curvature`";
    /// A declared first integral that changes, or may change, along the flow of the drift or of a noise. At
    /// the boundary of a branch and for a bath there is no `rate`.
    no_invariant(found, along: &str, rate: Option<&str>, knowledge: &Knowledge, graph: &Graph) {
        of = rate.map_or_else(|| along.to_owned(), |rate| format!("{along} = {rate}"));
        finding = match knowledge {
            Knowledge::Refuted(witness) => {
                let is = if rate.is_some() { ", which is" } else { ": it jumps by" };
                format!("is not a first integral of {of}{is} {}", at_witness(witness, graph))
            }
            Knowledge::Unknown(reason) => format!(
                "could not be proven to be a first integral of {of}: {reason}; leave it out and evaluate it \
                 with an observer, or write both sides in the same functions"
            ),
            Knowledge::Proven => format!("is a first integral of {of}"),
        };
    } = "this {finding}";
}

fn at_witness(witness: &Witness, graph: &Graph) -> String {
    let Witness { point, value } = witness;
    let known = |&(symbol, value): &(_, f64)| format!("{} = {value}", graph.symbol_name(symbol));
    match point.is_empty() {
        true => value.to_string(),
        false => format!("{value} at {}", point.iter().map(known).collect::<Vec<_>>().join(", ")),
    }
}
