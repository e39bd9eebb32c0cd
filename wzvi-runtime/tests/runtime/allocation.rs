//! Nothing in a step allocates.

use super::systems::{Kubo, Pendulum, Rotors, path};
use allocation_counter::measure;
use wzvi_runtime::algebra::state::State;
use wzvi_runtime::increments::Increments;
use wzvi_runtime::integrate::Integrate;
use wzvi_runtime::scheme::embedding::{DeltaPlus, Midpoint};

/// Allocations (and reallocations) of `f` on this thread, and its value.
fn count<T>(f: impl FnOnce() -> T) -> (u64, T) {
    let mut value = None;
    let counted = measure(|| value = Some(f()));
    (counted.count_total, value.unwrap())
}

#[test]
fn steps_allocate_nothing() {
    let (kubo, pendulum) = (Kubo { a: 1.5, sigma: 1.0 }, Pendulum { omega: 1.3 });
    let rotors = Rotors { count: 4, sigma: 0.5 };

    assert_ne!(count(|| vec![0; 10]).0, 0, "the counter counts");
    let mut stepper = kubo.stepper::<Midpoint>(0.02).unwrap();
    let mut state = State::new([0.0], [1.0]);
    assert_eq!(count(|| (0..100).for_each(|_| assert!(stepper.step(&mut state, &[0.1]).is_ok()))).0, 0);
    assert_eq!(count(|| stepper.step(&mut state, &[f64::NAN]).is_err()), (0, true));

    let mut stepper = pendulum.stepper::<Midpoint>(0.02).unwrap();
    assert_eq!(count(|| (0..100).for_each(|_| assert!(stepper.step(&mut state, &[]).is_ok()))).0, 0);

    let mut stepper = rotors.stepper::<DeltaPlus>(0.02).unwrap();
    let mut state = State::new(vec![0.0; 4], vec![1.0; 4]);
    assert_eq!(count(|| (0..100).for_each(|_| assert!(stepper.step(&mut state, &[0.1; 4]).is_ok()))).0, 0);

    // A run allocates the same for 10 steps and for 10000: its buffers, once, also where it records each step.
    let run = |steps: usize, every: u64| {
        let noise = Increments::from(path(steps, 0.02));
        let simulation = kubo.simulate::<Midpoint>(0.02).start(State::new([0.0], [1.0])).noise(noise);
        let simulation = simulation.steps(steps as u64).record_every(every);
        let mut seen = 0;
        let (allocations, path) = count(|| simulation.inspect(|_, _| seen += 1).run());
        assert_eq!(path.unwrap().last().t, steps as f64 * 0.02);
        (allocations, seen)
    };
    for every in [0, 1, 3] {
        let ((few, _), (many, seen)) = (run(10, every), run(10_000, every));
        assert_eq!(few, many, "record_every({every})");
        assert!(few < 20 && seen > 3000, "{few} {seen}");
    }
}
