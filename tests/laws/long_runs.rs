//! All steps of what other tests take a part of.

use fixtures::{extremes, rounding, stiff};

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
fn wells_at_rest_stay_there() {
    rounding::wells_at_rest_stay_there(200_000);
}

/// 160 000 steps.
#[test]
fn steps_are_finite_or_errors() {
    extremes::steps_are_finite_or_errors(4000);
}

#[test]
fn subdivision_cures_the_stiffest_spring() {
    stiff::subdivision_cures(1e10, 4);
    stiff::subdivision_cures(1e16, 8);
}
