//! Spins as pairs of oscillators: what `docs/guide/cookbook-spins.md` says of the lift and of its steps.

use fixtures::spins::{self, InField, Ring, Spins, lift, product, spin_of};
use fixtures::{Uniform, larger};
use wzvi::nalgebra::{DVector, Rotation3, Unit, Vector3};
use wzvi::prelude::*;

/// The gradients of the noise Hamiltonians of [`InField`], the components of a spin, by `q` and `p`.
fn gradients(system: &InField, [q, p]: [[f64; 2]; 2]) -> [[[f64; 2]; 2]; 3] {
    [1, 2, 3].map(|term| {
        let (mut by_q, mut by_p) = ([0.0; 2], [0.0; 2]);
        system.differentiate(term, &q, &p, 0.0, &mut by_q, &mut by_p);
        [by_q, by_p]
    })
}

/// `{s_x, s_y} = s_z` and its permutations, with the bracket `f_q · g_p - f_p · g_q` of textbooks, whose sign is opposite to
/// that of `EQUATIONS`; the length `|z|²/4`; the motion `s' = ∇H × s`. All are polynomials of degree four with a few terms.
#[test]
fn the_lift_has_the_brackets_of_a_spin() {
    let mut random = Uniform(1);
    let system = InField { field: [0.3, -1.1, 0.7] };
    for _ in 0..50 {
        let [q, p] = [0, 1].map(|_| [0, 1].map(|_| 2.0 * random.draw()));
        let s = Vector3::from(spins::spin(q, p));
        let of = gradients(&system, [q, p]);
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let bracket = |f: [[f64; 2]; 2], g: [[f64; 2]; 2]| dot(f[0], g[1]) - dot(f[1], g[0]);
        let length = 0.25 * (dot(q, q) + dot(p, p));
        let rounding = 16.0 * f64::EPSILON * length;
        for axis in 0..3 {
            let third = bracket(of[axis], of[(axis + 1) % 3]);
            assert!((third - s[(axis + 2) % 3]).abs() < rounding, "{axis}: {third} {s}");
        }
        assert!((s.norm() - length).abs() < rounding);
        let (mut by_q, mut by_p) = ([0.0; 2], [0.0; 2]);
        system.differentiate(0, &q, &p, 0.0, &mut by_q, &mut by_p);
        let moved = Vector3::from_fn(|axis, _| bracket(of[axis], [by_q, by_p]));
        assert!((moved - Vector3::from(system.field).cross(&s)).norm() < 4.0 * rounding);
    }
}

/// In a field `B` along which there is noise, too, each step turns the spin about `B` by exactly `4 atan(|h B + ΔW|/4)`: the
/// oscillators have the frequencies `±|B|/2`, and the mid-point turns them by `2 atan` of half of that. The error of a step is
/// a rounding or two of components up to 2, and all have the same sign at most.
#[test]
fn a_spin_in_a_field_turns_by_a_known_angle() {
    let field = Vector3::new(0.6, -0.48, 0.64) * 1.3;
    let (h, steps, mut random) = (0.7, 500, Uniform(2));
    let system = InField { field: field.into() };
    let mut stepper = system.stepper::<Midpoint>(h).unwrap();
    let first = Vector3::new(0.36, 0.48, -0.8);
    let (q, p) = lift(first);
    let (mut state, mut angle) = (State::new(q, p), 0.0);
    for step in 1..=steps {
        let share = random.draw();
        let dw = field * share;
        stepper.step(&mut state, dw.as_slice()).unwrap();
        angle += 4.0 * (0.25 * (h + share) * field.norm()).atan();
        let expected = Rotation3::from_axis_angle(&Unit::new_normalize(field), angle) * first;
        let error = (spin_of(&state.q, &state.p) - expected).norm();
        assert!(error < 8.0 * f64::EPSILON * f64::from(step + 4), "{step}: {error:.1e}");
    }
}

/// Two spins with the energy `-2 J s_1 · s_2` turn about their sum with the rate `2 J |s_1 + s_2|`: order two, and the sum is
/// conserved as lengths are.
#[test]
fn two_spins_turn_about_their_sum() {
    let ring = Ring::new(2, 0.0);
    let start = spins::some_start(2);
    let of = |state: &Spins| spins::spins(state).into_iter().map(Vector3::from).collect::<Vec<_>>();
    let first = of(&start);
    let total = first[0] + first[1];
    let error = |h: f64| {
        let path = ring
            .simulate::<Midpoint>(h)
            .start(start.clone())
            .noise(Wiener::seed(1))
            .until(4.0)
            .run()
            .unwrap();
        let last = of(path.last());
        assert!((last[0] + last[1] - total).norm() < 1e-14 * (1.0 + path.len() as f64));
        // `s_1' = -2 J s_2 × s_1`
        let turn = Rotation3::from_axis_angle(&Unit::new_normalize(total), -2.0 * total.norm() * 4.0);
        (last[0] - turn * first[0]).norm()
    };
    let (coarse, fine) = (error(0.05), error(0.025));
    // The next order is `h²` relative.
    assert!((coarse / fine - 4.0).abs() < 0.1 && fine < 1e-2, "{coarse:.2e} {fine:.2e}");
}

#[test]
fn lengths_hold_with_and_without_noise() {
    spins::energies_with_constant_lengths(0.0, 1000);
    spins::energies_with_constant_lengths(0.3, 1000);
}

/// One axis of a ring in random fields is as good as another: a step commutes with rotations of all spins, which are linear
/// in the oscillators. Turned by `π` about `z`, `(q_2, p_2)` changes its sign, and noises along `x` and `y` do.
#[test]
fn steps_commute_with_rotations() {
    let ring = Ring::new(3, 0.4);
    let mut stepper = ring.stepper::<Midpoint>(0.2).unwrap();
    let turned = |state: &Spins| {
        let sign =
            |list: &DVector<f64>| DVector::from_fn(6, |i, _| if i % 2 == 1 { -list[i] } else { list[i] });
        State { q: sign(&state.q), p: sign(&state.p), t: state.t }
    };
    let (mut state, mut random) = (spins::some_start(3), Uniform(3));
    let mut image = turned(&state);
    for _ in 0..20 {
        let dw: Vec<f64> = (0..9).map(|_| 0.5 * random.draw()).collect();
        let of_image: Vec<f64> = dw.iter().enumerate().map(|(k, dw)| if k < 6 { -dw } else { *dw }).collect();
        stepper.step(&mut state, &dw).unwrap();
        ring.stepper::<Midpoint>(0.2).unwrap().step(&mut image, &of_image).unwrap();
    }
    let ends = spins::spins(&turned(&state)).into_iter().zip(spins::spins(&image));
    let worst = ends.map(|(a, b)| (product(a, a) - product(a, b)).abs()).fold(0.0, larger);
    // The solver stops at a rounding of the state, from other starts.
    assert!(worst < 1e-13, "{worst:.1e}");
}
