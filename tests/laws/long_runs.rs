//! All steps of what other tests take a part of.

use fixtures::{extremes, rest, rounding, stiff};

#[test]
fn angular_momentum_over_ten_million_steps() {
    rounding::compensated_sums_keep_the_angular_momentum(10_000_000);
}

#[test]
fn rounding_does_not_add_up_in_gauss_methods() {
    rounding::gauss_methods_do_not_add_rounding_up(40_000);
}

#[test]
fn energies_of_chains_do_not_drift() {
    rounding::energies_of_chains_do_not_drift(20_000);
}

/// In loops over sites, and in windows.
#[test]
fn energies_of_chains_walk_at_random() {
    rounding::energies_of_chains_walk_at_random(24, 60);
    rounding::energies_of_chains_walk_at_random(100, 40);
}

#[test]
fn systems_at_rest_stay_there() {
    rest::wells_at_rest_stay_there(200_000);
    rest::small_amplitudes_in_a_well(20_000);
    rest::every_amplitude_at_every_scale(20_000);
    rest::pendula_at_rest_on_any_turn(200_000);
    rest::relative_equilibria(200_000);
    rest::atoms_at_their_distance(200_000);
    rest::cold_ensembles_lose_no_path(64);
}

/// 160 000 steps.
#[test]
fn steps_are_finite_or_errors() {
    extremes::steps_are_finite_or_errors(4000);
}

#[test]
fn another_solution_is_named() {
    assert!(stiff::another_solution_is_named_or_there_is_none(4000) > 10);
}

#[test]
fn subdivision_cures_the_stiffest_spring() {
    stiff::subdivision_cures(1e10, 4);
    stiff::subdivision_cures(1e16, 8);
}
