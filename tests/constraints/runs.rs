//! Ensembles, threads, checkpoints and retries: the bits of single steps.

use std::slice::from_ref;

use fixtures::folder;
use fixtures::reference::{data, list};
use fixtures::stepped::{every_split, failed, paths_are_steppers};
use fixtures::{Uniform, wave};
use wzvi::checkpoint::Checkpoint;
use wzvi::nalgebra::{DVector, SVector};
use wzvi::prelude::*;

use super::holds::{chain, ring};
use super::linkages::{self, WarmLinkage};
use super::systems::{DoublePendulum, Sphere, WarmSphere};

/// Points on the sphere with tangent momenta up to the given size.
fn on_sphere(paths: u64, size: f64) -> Vec<State<SVector<f64, 3>>> {
    let mut random = Uniform(7);
    (0..paths)
        .map(|_| {
            let q = SVector::<f64, 3>::from_fn(|_, _| random.draw()).normalize();
            let p = SVector::<f64, 3>::from_fn(|_, _| size * random.draw());
            State { q, p: p - q * q.dot(&p), t: 0.0 }
        })
        .collect()
}

/// Some of these steps have no end.
#[test]
fn paths_of_ensembles_are_those_of_steppers() {
    let sphere = Sphere { g: 1.0 };
    let starts = on_sphere(45, 3.0);
    let run = || sphere.ensemble::<Rattle>(0.4).unwatched().starts_from(starts.clone());
    let all = paths_are_steppers(run, from_ref(&sphere), (0.4, 20), (45, 1));
    assert!((3..42).contains(&failed(&all)), "{}", failed(&all));
    let run = || sphere.ensemble::<Composed<Rattle, Yoshida4>>(0.4).unwatched().starts_from(starts.clone());
    let all = paths_are_steppers(run, from_ref(&sphere), (0.4, 20), (45, 1));
    assert!((3..42).contains(&failed(&all)), "{}", failed(&all));
    let warm = WarmSphere { gamma: 0.7, kt: 0.8 };
    let starts = on_sphere(45, 1.0);
    let run = || warm.ensemble::<GBaoab>(0.8).unwatched().starts_from(starts.clone());
    let all = paths_are_steppers(run, from_ref(&warm), (0.8, 20), (45, 1));
    assert!((3..42).contains(&failed(&all)), "{}", failed(&all));
    let systems: Vec<Sphere> = (0..12).map(|path| Sphere { g: 0.3 * f64::from(path) }).collect();
    let starts = on_sphere(12, 1.5);
    let sweep = || systems[0].ensemble::<Rattle>(0.2).systems_from(systems.clone());
    let sweep = || sweep().unwatched().starts_from(starts.clone());
    let all = paths_are_steppers(sweep, &systems, (0.2, 20), (12, 1));
    assert!(failed(&all) < 12, "{}", failed(&all));
}

#[test]
fn paths_of_linkages_are_those_of_steppers() {
    let (linkage, start) = ring(7);
    let start = linkage.simulate::<Rattle>(0.1).start(start).project_start().steps(0).run().unwrap();
    let run = || linkage.ensemble::<Rattle>(0.1).unwatched().start(start.last().clone());
    assert_eq!(failed(&paths_are_steppers(run, from_ref(&linkage), (0.1, 20), (9, 1))), 0);
    let cases = data("linkages");
    let case = &list(&cases)[1];
    let warm = WarmLinkage::of(case, [0.5, 0.2]);
    let h = 0.25 * fixtures::reference::number(&case["h"]);
    let run = || warm.ensemble::<GBaoab>(h).unwatched().start(linkages::start(case));
    assert_eq!(failed(&paths_are_steppers(run, from_ref(&warm), (h, 20), (9, 1))), 0);
}

#[test]
fn bits_do_not_depend_on_lanes_and_threads() {
    let warm = WarmSphere { gamma: 0.7, kt: 0.8 };
    let start = || State::new([0.0, 0.0, -1.0], [0.3, 0.0, 0.0]);
    every_split(|| {
        let run = warm.ensemble::<GBaoab>(0.5).unwatched().start(start()).seed(4).paths(200).steps(20);
        run.allow_losses(1.0).observe("z", |state| state.q[2])
    });
    every_split(|| {
        let run = warm.ensemble::<GBaoab>(0.5).unwatched().start(start()).seed(4).paths(200).steps(20);
        run.retry(Retry::halving(4)).observe("z", |state| state.q[2])
    });
}

/// A run that stops after any number of steps goes on with the same bits: guesses of impulses are stored.
#[test]
fn runs_go_on_from_checkpoints() {
    let (linkage, start) = chain(5);
    let whole =
        |steps: u64| linkage.simulate::<Rattle>(0.05).start(start.clone()).project_start().steps(steps);
    let expected = format!("{:?}", whole(12).run().unwrap().states());
    let folder = folder!("chain");
    for stop in [0, 1, 2, 5, 11] {
        let to = || Checkpoint::to(folder.join(format!("{stop}")));
        whole(stop).checkpoint(to()).run().unwrap();
        assert_eq!(format!("{:?}", whole(12).checkpoint(to()).run().unwrap().states()), expected, "{stop}");
    }
    let warm = WarmSphere { gamma: 0.7, kt: 0.4 };
    let start = State::new([0.0, 0.0, -1.0], [0.3, 0.0, 0.0]);
    let run = |paths: u64| {
        let run = warm.ensemble::<GBaoab>(0.1).start(start).seed(4).paths(paths).steps(20);
        run.unwatched().observe("z", |state| state.q[2])
    };
    let to = || Checkpoint::to(folder.join("warm"));
    run(512).checkpoint(to()).run().unwrap();
    let resumed = run(1100).checkpoint(to()).run().unwrap();
    assert_eq!(format!("{resumed:?}"), format!("{:?}", run(1100).run().unwrap()));
}

fn allocates_nothing<E, H: Discretized<E>>(system: &H, start: State<H::Vector>, h: f64) {
    let mut state = start;
    let degrees = wzvi::state::Vector::components(&state.q).len();
    let dw = wave(system.increments(degrees), 0.1 * h.sqrt(), 0.2);
    let mut stepper = system.stepper::<E>(h).unwrap();
    let mut go_on = |steps: u32| {
        for _ in 0..steps {
            stepper.step(&mut state, &dw).unwrap();
        }
    };
    go_on(5);
    let counted = allocation_counter::measure(|| go_on(100));
    assert_eq!(counted.count_total, 0, "{}", std::any::type_name::<(E, H)>());
}

#[test]
fn steps_allocate_nothing() {
    let start = State::new([0.6, 0.0, 0.8], [0.0, 0.7, 0.0]);
    allocates_nothing::<Rattle, _>(&Sphere { g: 1.0 }, start, 0.1);
    allocates_nothing::<GBaoab, _>(&WarmSphere { gamma: 0.7, kt: 0.4 }, start, 0.1);
    let start = State::new([1.0, 0.0, 1.0, -1.0], [0.0, 1.0 / 6.0, 0.5, 1.0 / 3.0]);
    allocates_nothing::<Composed<Rattle, Yoshida4>, _>(&DoublePendulum, start, 0.05);
    let (linkage, start) = chain(30);
    allocates_nothing::<Rattle, _>(&linkage, start, 0.01);
    // A constraint on many coordinates.
    let many = ManySites { k: wave(1000, 0.01, 0.3), radius: 1.0 };
    let start =
        State::new(DVector::from_vec(wave(1000, 1.0, 0.0)).normalize(), DVector::from_element(1000, 0.01));
    let start = many.simulate::<Rattle>(0.1).start(start).project_start().steps(0).run().unwrap();
    allocates_nothing::<Rattle, _>(&many, start.last().clone(), 0.1);
}

/// A sphere in as many dimensions as there are sites.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| (0..q.len()).map(|i| 0.5 * p[i] * p[i] + self.k[i] * q[i]).sum::<f64>(),
    constraint = [|q| (0..q.len()).map(|i| 0.5 * q[i] * q[i]).sum::<f64>() - 0.5 * radius * radius],
    embedding = Rattle,
)]
struct ManySites {
    k: Vec<f64>,
    radius: f64,
}
