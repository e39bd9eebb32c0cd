//! Events: closed forms of what acts on a path, and what stays as it was.

use fixtures::folder;
use wzvi::error::StepFailure;
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

/// A body above a floor. Steps of Verlet are exact in a constant field.
#[hamiltonian(drift = |q, p| 0.5 * p * p + g * q, embedding = [Verlet, Gauss<2>])]
struct Ball {
    g: f64,
}

#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = [Verlet, Gauss<8>])]
struct Pendulum;

/// A free body that is pushed about: `p` is the Wiener path itself.
#[hamiltonian(drift = |q, p| 0.5 * p * p, noise = [|q, p| -s * q], embedding = [Verlet, Midpoint])]
struct Pushed {
    s: f64,
}

type Start = State<SVector<f64, 1>>;

fn ball() -> Ball {
    Ball { g: 2.0 }
}

/// At the height `height`, at rest.
fn at_rest(height: f64) -> Start {
    State::new([height], [0.0])
}

/// The times of the bounces of a ball that falls from a height and keeps the fraction `kept` of its speed:
/// `t_1 = √(2 height/g)`, and then the flights of `2 v/g` each.
fn bounces(height: f64, kept: f64, number: usize) -> Vec<f64> {
    let (mut t, mut v) = (height.sqrt(), 2.0 * height.sqrt());
    (0..number)
        .map(|_| {
            let bounce = t;
            v *= kept;
            t += v;
            bounce
        })
        .collect()
}

#[test]
fn a_ball_bounces_in_closed_form() {
    for h in [0.3, 0.05] {
        let ball = ball();
        let run = ball.simulate::<Verlet>(h).start(at_rest(1.0)).until(8.0);
        let run = run.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -0.9).run().unwrap();
        let expected = bounces(1.0, 0.9, 5);
        assert_eq!(run.events().len(), expected.len());
        for (event, t) in run.events().iter().zip(expected) {
            // A unit in the last place of the state in each step, over the speed, which is about 1.
            assert!((event.before.t - t).abs() < 1e-14 * 8.0 / h, "{h}: {} {t}", event.before.t);
            assert!(event.before.q[0].abs() < 1e-14, "{h}: {}", event.before.q[0]);
            assert_eq!(event.after.p[0], -0.9 * event.before.p[0]);
            assert_eq!((event.event, event.after.t), (0, event.before.t));
        }
        // Each bounce keeps 0.81 of the energy, and the work is what is lost.
        let energy = 2.0 * 0.81_f64.powi(5);
        assert!((ball.energy(run.last()) - energy).abs() < 1e-13);
        assert!((run.work() - (energy - 2.0)).abs() < 1e-13);
        assert_eq!(run.last().t, 8.0);
        // The nodes are those of a run without events.
        let free = ball.simulate::<Verlet>(h).start(at_rest(1.0)).until(8.0).run().unwrap();
        assert!(run.times().eq(free.times()));
        assert!(run.iter().all(|state| state.q[0] > -1e-14));
        // Before the first bounce, states are those of that run.
        let first = run.iter().take_while(|state| state.t < 1.0);
        assert!(first.zip(free.iter()).all(|(bounced, free)| bounced == free));
    }
}

/// Infinitely many bounces in finite time: the run ends where they accumulate, and its remedy works.
#[test]
fn bounces_that_accumulate_end_the_run() {
    let ball = ball();
    let run = || ball.simulate::<Verlet>(0.3).start(at_rest(1.0)).until(8.0);
    let bouncing = run().on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -0.5);
    let (path, error) = bouncing.run_partial().unwrap();
    // `1 + 2 (1/2 + 1/4 + ...) = 3`
    let Some(wzvi::Error::Step(error)) = error else { panic!("{error:?}") };
    assert!(matches!(error.cause, StepFailure::TooManyEvents { t, .. } if (t - 3.0).abs() < 1e-7), "{error}");
    // All bounces but the last few, which are as short as the rounding of their time, are those of the form.
    for (event, t) in path.events().iter().zip(bounces(1.0, 0.5, 20)) {
        assert!((event.before.t - t).abs() < 1e-13, "{} {t}", event.before.t);
    }
    let stopped = run().on_towards(
        Direction::Falling,
        |s| s.q[0],
        |s| {
            s.p[0] *= -0.5;
            (s.p[0] < 1e-3).then_some(Terminal)
        },
    );
    let stopped = stopped.run().unwrap();
    assert!(stopped.last().p[0] < 1e-3 && stopped.last().p[0] > 4e-4);
    assert_eq!(stopped.last(), &stopped.events().last().unwrap().after);
}

/// Whatever its step, a ball whose bounces accumulate is above the floor up to there, within the rounding of its last
/// bounces, and the run says that it ends.
#[test]
fn no_ball_falls_through_the_floor() {
    let ball = ball();
    for (number, kept) in [0.2, 0.27, 0.35, 0.5, 0.61, 0.7].into_iter().enumerate() {
        for h in [0.01, 0.1, 0.13, 0.2, 0.29, 0.3, 0.42, 0.5] {
            let start = at_rest(0.2 + 0.16 * number as f64);
            let run = ball.simulate::<Verlet>(h).start(start).until(12.0);
            let run = run.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -kept);
            let (path, error) = run.run_partial().unwrap();
            let Some(wzvi::Error::Step(error)) = error else { panic!("{kept} {h}: {:?}", path.last()) };
            assert!(matches!(error.cause, StepFailure::TooManyEvents { .. }), "{error}");
            assert!(path.iter().all(|state| state.q[0] > -1e-12), "{kept} {h}");
        }
    }
}

/// A quarter of the period of a pendulum, `K(sin²(a/2))`, by the arithmetic-geometric mean.
fn quarter(amplitude: f64) -> f64 {
    let (mut a, mut g) = (1.0_f64, (0.5 * amplitude).cos());
    for _ in 0..6 {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    std::f64::consts::FRAC_PI_2 / a
}

#[test]
fn a_terminal_event_ends_the_run_at_its_time() {
    let amplitude = 1.0_f64;
    let quarter = quarter(amplitude);
    for h in [0.5, 0.11] {
        let run = Pendulum.simulate::<Gauss<8>>(h).start(State::new([amplitude], [0.0])).until(10.0);
        let run = run.on(|s| s.q[0], |_| Terminal).run().unwrap();
        // The scheme is exact to rounding here: a few units in the last place.
        assert!((run.last().t - quarter).abs() < 1e-14, "{h}: {} {quarter}", run.last().t);
        assert!(run.last().q[0].abs() < 1e-15);
        assert_eq!(run.steps(), (quarter / h).ceil() as u64);
        assert_eq!(run.events().len(), 1);
        let back = Pendulum.simulate::<Gauss<8>>(-h).start(*run.last()).until(-10.0);
        let back = back.on_towards(Direction::Falling, |s| s.p[0], |_| Terminal).run_partial().unwrap().0;
        assert!((back.last().t - 0.0).abs() < 1e-7 || back.last().t < 0.0, "{}", back.last().t);
    }
}

/// A kicked rotor is the standard map: between kicks the motion is free, and exact.
#[test]
fn kicks_make_the_standard_map() {
    #[hamiltonian(drift = |q, p| 0.5 * p * p, embedding = Verlet)]
    struct Rotor;
    let (k, kicks) = (0.7_f64, 40);
    let mut run = Rotor.simulate::<Verlet>(0.3).start(State::new([1.0], [0.2])).until(f64::from(kicks));
    for kick in 0..kicks {
        run = run.on_time(f64::from(kick), move |s| s.p[0] += k * s.q[0].sin());
    }
    let path = run.run().unwrap();
    let free = Rotor.simulate::<Verlet>(0.3).start(State::new([1.0], [0.2])).until(f64::from(kicks));
    assert!(path.times().eq(free.run().unwrap().times()));
    let (mut q, mut p) = (1.0_f64, 0.2);
    for event in path.events() {
        // Regular motion: errors grow with the number of kicks, not exponentially.
        assert!((event.before.q[0] - q).abs() < 1e-12 && (event.before.p[0] - p).abs() < 1e-12);
        p += k * q.sin();
        q += p;
    }
    assert_eq!(path.events().len(), kicks as usize);
    // Backwards, with the kicks taken back.
    let mut back = Rotor.simulate::<Verlet>(-0.3).start(*path.last()).until(0.0);
    for kick in 0..kicks {
        back = back.on_time(f64::from(kick), move |s| s.p[0] -= k * s.q[0].sin());
    }
    let back = back.run().unwrap();
    assert!((back.last().q[0] - 1.0).abs() < 1e-11 && (back.last().p[0] - 0.2).abs() < 1e-11);
}

/// States between nodes, recorded times and sections know of events.
#[test]
fn what_is_between_nodes_knows_of_events() {
    let ball = ball();
    let bouncing = |h: f64| {
        let run = ball.simulate::<Verlet>(h).start(at_rest(1.0)).until(8.0);
        run.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -0.9)
    };
    let height = |t: f64| {
        let before: Vec<f64> = bounces(1.0, 0.9, 6).into_iter().take_while(|&bounce| bounce <= t).collect();
        let speed = 2.0 * 0.9_f64.powi(before.len() as i32);
        before.last().map_or(1.0 - t * t, |last| speed * (t - last) - (t - last).powi(2))
    };
    let times = [0.95, 1.05, 2.75, 2.85, 4.5];
    let path = bouncing(0.3).record_every(1).run().unwrap();
    let recorded = bouncing(0.3).record_at(times).section(|s| s.q[0] - 0.1).run().unwrap();
    for (t, state) in times.into_iter().zip(&recorded.states()[1..]) {
        assert!((state.q[0] - height(t)).abs() < 1e-13, "{t}: {}", state.q[0]);
        let between = path.state_at(&ball, t).unwrap();
        assert!((between.q[0] - height(t)).abs() < 1e-13, "{t}: {}", between.q[0]);
    }
    // The first fall, two crossings for each flight that is over, and one for the last, which is still high.
    assert!(recorded.last().q[0] > 0.1);
    assert_eq!(recorded.crossings().len(), 1 + 2 * (recorded.events().len() - 1) + 1);
    for crossing in recorded.crossings() {
        assert!((height(crossing.state.t) - 0.1).abs() < 1e-13);
    }
}

/// An event that changes nothing leaves a path of noise what it is: `p` is the Wiener path at any division.
#[test]
fn events_divide_the_increments_of_a_step() {
    let pushed = Pushed { s: 0.7 };
    let run =
        || pushed.simulate::<Verlet>(0.25).start(State::new([0.0], [0.0])).until(31.1).noise(Wiener::seed(5));
    let (free, path) =
        (run().run().unwrap(), run().on_time(0.33, |_| ()).on(|s| s.p[0] - 0.1, |_| ()).run().unwrap());
    // Each change of sign between nodes, once.
    let changes =
        free.states().windows(2).filter(|ends| (ends[0].p[0] < 0.1) != (ends[1].p[0] < 0.1)).count();
    assert!(changes > 2 && path.events().len() == changes + 1, "{changes} {}", path.events().len());
    for (free, path) in free.iter().zip(path.iter()) {
        // 125 roundings of numbers below 4.
        assert!((free.p[0] - path.p[0]).abs() < 6e-14, "{}", free.t);
    }
    for (free, path) in free.increments().zip(path.increments()) {
        assert!((free[0] - path[0]).abs() < 1e-15);
    }
    let w = |t: f64| 0.7 * Wiener::seed(5).value(0, t).unwrap();
    for event in path.events() {
        assert!((event.before.p[0] - w(event.before.t)).abs() < 6e-14, "{}", event.before.t);
    }
    // Crossings of the path itself, up to what it does within the resolution of its times, some 2e-14 here:
    // `0.7 √(2e-14) = 1e-7`, of which ten are never seen.
    assert!(
        path.events()
            .iter()
            .filter(|event| event.event == 1)
            .all(|event| (event.before.p[0] - 0.1).abs() < 1e-6)
    );
}

/// A run that stops and resumes has the bits of one that does not.
#[test]
fn a_run_with_events_resumes() {
    let file = folder!("events").join("ball.checkpoint");
    let ball = ball();
    let run = |end: f64| {
        let run = ball.simulate::<Verlet>(0.05).start(at_rest(1.0)).until(end);
        let run = run.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -0.9);
        run.on_time(3.33, |s| s.p[0] += 0.5).section(|s| s.p[0])
    };
    let whole = run(8.0).run().unwrap();
    run(4.0).checkpoint(Checkpoint::to(&file).every_steps(20)).run().unwrap();
    let resumed = run(8.0).checkpoint(Checkpoint::to(&file).every_steps(20)).run().unwrap();
    assert_eq!(resumed.states(), whole.states());
    assert_eq!(resumed.events(), whole.events());
    assert_eq!(resumed.crossings(), whole.crossings());
}

/// 64 balls from different heights, each against its closed form, on any number of threads; and a path of
/// the ensemble is a run.
#[test]
fn an_ensemble_of_balls_bounces_in_closed_form() {
    let ball = ball();
    let heights = || (0..64).map(|i| 0.5 + 0.02 * f64::from(i));
    let balls = |threads: usize| {
        let run =
            ball.ensemble::<Verlet>(0.1).starts_from(heights().map(at_rest)).until(4.0).threads(threads);
        let run = run.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -0.9);
        run.observe("height", |s| s.q[0]).record_at([1.5, 2.5]).run().unwrap()
    };
    let (one, two) = (balls(1), balls(2));
    let form = |height: f64, t: f64| {
        let all = bounces(height, 0.9, 9);
        let before = all.iter().take_while(|&&bounce| bounce <= t).count();
        let speed = 2.0 * height.sqrt() * 0.9_f64.powi(before as i32);
        before.checked_sub(1).map_or(height - t * t, |last| speed * (t - all[last]) - (t - all[last]).powi(2))
    };
    for (node, t) in [0.0, 1.5, 2.5, 4.0].into_iter().enumerate() {
        let mean = heights().map(|height| form(height, t)).sum::<f64>() / 64.0;
        let [found, again] = [&one, &two].map(|many| many.nodes()[node].mean(0));
        assert!((found - mean).abs() < 1e-13, "{t}: {found} {mean}");
        assert_eq!(found, again);
    }
    let replayed = ball.ensemble::<Verlet>(0.1).starts_from(heights().map(at_rest)).until(4.0);
    let replayed = replayed.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -0.9);
    let replayed = replayed.record_every(1).replay(17).unwrap().0;
    let alone = ball.simulate::<Verlet>(0.1).start(at_rest(0.5 + 0.02 * 17.0)).until(4.0).plain_sums();
    let alone = alone.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -0.9).run().unwrap();
    assert_eq!(replayed.states(), alone.states());
    assert_eq!(replayed.events(), alone.events());
}

/// Events at the ends of a run, and at nodes that only rounding tells from their times.
#[test]
fn events_at_the_ends_of_a_run_happen() {
    #[hamiltonian(drift = |q, p| 0.5 * p * p, embedding = Verlet)]
    struct Free;
    let start: Start = State::new([0.0], [1.0]);
    // Three steps of 0.1 end at 0.30000000000000004.
    let run = |end: f64| Free.simulate::<Verlet>(0.1).start(start).until(end);
    let path = run(0.3).on_time(0.0, |s| s.p[0] += 1.0).on_time(0.3, |s| s.p[0] += 1.0).run().unwrap();
    assert_eq!(path.events().len(), 2);
    assert_eq!((path.last().p[0], path.last().t, path.steps()), (3.0, 0.3, 3));
    assert!((path.last().q[0] - 0.6).abs() < 1e-15);
    // At a node on the way, once.
    let path = run(1.0).on_time(0.3, |s| s.p[0] = 0.0).run().unwrap();
    assert_eq!(path.events().len(), 1);
    assert!((path.last().q[0] - 0.3).abs() < 1e-15 && path.steps() == 10);
    // Two at one time, in the order of the calls.
    let path = run(1.0).on_time(0.25, |s| s.p[0] = 5.0).on_time(0.25, |s| s.p[0] *= 2.0).run().unwrap();
    assert_eq!((path.last().p[0], path.events().len()), (10.0, 2));
    // An event that ends the run before its first step.
    let path = run(1.0).on_time(0.0, |_| Terminal).run().unwrap();
    assert_eq!((path.steps(), path.last().t, path.len()), (0, 0.0, 1));
    // A crossing at a node, from which states between nodes go on.
    let path = Free.simulate::<Verlet>(0.25).start(start).until(1.0).on(|s| s.q[0] - 0.5, |s| s.p[0] = -1.0);
    let path = path.run().unwrap();
    assert_eq!(path.events()[0].before.t, 0.5);
    assert_eq!(path.last().q[0], 0.0);
    assert!((path.state_at(&Free, 0.6).unwrap().q[0] - 0.4).abs() < 1e-15);
}

/// The heat of a step that an event divides is that of its parts: all energy is heat, or goes at the floor.
#[test]
fn parts_of_a_step_have_their_heat() {
    #[hamiltonian(drift = |q, p| 0.5 * p * p + 2.0 * q, friction = gamma, embedding = Gauss<4>)]
    struct Dropped {
        gamma: f64,
    }
    let ball = Dropped { gamma: 0.3 };
    let run = ball.simulate::<Gauss<4>>(0.4).start(at_rest(1.0)).until(4.0);
    let path = run.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -0.9).run().unwrap();
    let at_floor: f64 =
        path.events().iter().map(|event| ball.energy(&event.after) - ball.energy(&event.before)).sum();
    let lost = ball.energy(path.last()) - ball.energy(&at_rest(1.0));
    // The quadrature along the parts is of order 4 for a polynomial of order 4 between the nodes: (γ h)^4 / 100.
    assert!((path.heat() + at_floor - lost).abs() < 3e-6, "{} {at_floor} {lost}", path.heat());
    assert!(path.events().len() > 1 && path.heat() < -0.5);
}

/// What has no meaning with events is refused in words.
#[test]
fn settings_that_events_exclude_are_refused() {
    let ball = ball();
    let run = || ball.simulate::<Verlet>(0.1).start(at_rest(1.0)).until(1.0).on(|s| s.q[0], |_| ());
    let refused = [
        run().retry(Retry::halving(3)).run().unwrap_err().to_string(),
        run().tangent().map(drop).unwrap_err().to_string(),
        run().time_averages().run().map(drop).unwrap_err().to_string(),
    ];
    for said in refused {
        assert!(said.contains("`on`") && said.contains("leave") || said.contains("smaller step"), "{said}");
    }
    let many = ball.ensemble::<Verlet>(0.1).start(at_rest(1.0)).paths(4).until(1.0).on(|s| s.q[0], |_| ());
    let said = many.first_passage("floor", |s| s.q[0]).run().map(drop).unwrap_err().to_string();
    assert!(said.contains("`first_passage`") && said.contains("Terminal"), "{said}");
}

/// A path is on the side of a wall on which it was, whatever happens meanwhile.
#[test]
fn walls_hold() {
    let ball = ball();
    // The node at t = 1 is on the floor, to the last bit, and something else happens there.
    let run = ball.simulate::<Verlet>(0.25).start(at_rest(1.0)).until(3.0).on_time(1.0, |_| ());
    let run = run.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] *= -1.0).run().unwrap();
    let happened: Vec<_> = run.events().iter().map(|event| (event.event, event.before.t)).collect();
    assert_eq!(happened, [(0, 1.0), (1, 1.0), (1, 3.0)][..happened.len()]);
    assert!(happened.len() >= 2 && run.iter().all(|state| state.q[0] >= 0.0));
    // A ball that keeps no speed rests on the floor, and does not fall through it.
    let run = ball.simulate::<Verlet>(0.3).start(at_rest(1.0)).until(3.0);
    let run = run.on_towards(Direction::Falling, |s| s.q[0], |s| s.p[0] = 0.0);
    let (path, error) = run.run_partial().unwrap();
    let Some(wzvi::Error::Step(error)) = error else { panic!("{error:?} {:?}", path.last()) };
    assert!(matches!(error.cause, StepFailure::TooManyEvents { .. }), "{error}");

    // A corner: both walls are hit at one time, up to rounding.
    #[hamiltonian(drift = |q: [f64; 2], p: [f64; 2]| 0.5 * (p[0] * p[0] + p[1] * p[1]), embedding = [Verlet, Midpoint])]
    struct Puck;
    for (q, p) in [([0.5, 0.5], [1.0, 1.0]), ([0.3, 0.6], [-0.1, -0.2]), ([0.7, 0.1], [-0.7, -0.1])] {
        let run = Puck.simulate::<Midpoint>(0.13).start(State::new(q, p)).until(9.0);
        let run = run.on(|s| s.q[0], |s| s.p[0] *= -1.0).on(|s| s.q[1], |s| s.p[1] *= -1.0);
        let run = run.on(|s| s.q[0] - 1.0, |s| s.p[0] *= -1.0).on(|s| s.q[1] - 1.0, |s| s.p[1] *= -1.0);
        let path = run.run().unwrap();
        for i in 0..2 {
            // Unfolded, the motion is a straight line.
            let straight = (q[i] + 9.0 * p[i]).rem_euclid(2.0);
            let expected = straight.min(2.0 - straight);
            assert!((path.last().q[i] - expected).abs() < 1e-13, "{:?} {expected}", path.last());
        }
        assert!(path.iter().all(|state| state.q.iter().all(|q| (-1e-14..1.0 + 1e-14).contains(q))));
    }
}

/// An event that changes nothing counts each crossing once, and leaves the path what it is.
#[test]
fn events_that_change_nothing_count_crossings() {
    let start = State::new([1.0], [0.0]);
    for h in [0.5, 0.37, -0.11] {
        let run = || Pendulum.simulate::<Gauss<8>>(h).start(start).until(100.0_f64.copysign(h));
        let free = run().section(|s| s.q[0]).run().unwrap();
        let counted = run().on(|s| s.q[0], |_| ()).run().unwrap();
        // A side step from each event: a few units in the last place for each.
        for (number, event) in counted.events().iter().enumerate() {
            let t = (quarter(1.0) * (2 * number + 1) as f64).copysign(h);
            assert!(
                (event.before.t - t).abs() < 1e-14 * (number + 1) as f64 * 4.0,
                "{h}: {} {t}",
                event.before.t
            );
        }
        let crossings = (50.0 / quarter(1.0) + 0.5) as usize;
        assert_eq!((free.crossings().len(), counted.events().len()), (crossings, crossings));
    }
}

/// Nothing is recorded after the end, sections do not see what an event does, and the state at the time of
/// an event is the one after it.
#[test]
fn records_know_when_an_event_happens() {
    let ball = ball();
    let run = |end: f64| ball.simulate::<Verlet>(0.3).start(at_rest(1.0)).until(end);
    let path = run(3.0).on_time(0.7, |_| Terminal).record_at([0.65, 0.7, 0.72, 2.0]).run().unwrap();
    assert!(path.times().eq([0.0, 0.65, 0.7, 0.7]), "{:?}", path.times().collect::<Vec<_>>());
    let path = run(3.0).on_time(0.7, |s| s.p[0] = 0.0).record_at([0.7]).run().unwrap();
    assert_eq!(path.states()[1], path.events()[0].after);
    assert_eq!(path.states()[1].p[0], 0.0);
    let path = run(3.0).on_time(0.7, |s| s.p[0] = 0.0).run().unwrap();
    assert_eq!(path.state_at(&ball, 0.7).unwrap(), path.events()[0].after);
    // Lifted past the section at 0.9, from where it falls through it.
    let lifted = run(1.2).on_time(0.7, |s| s.q[0] = 1.0).section(|s| s.q[0] - 0.9).run().unwrap();
    let directions: Vec<_> = lifted.crossings().iter().map(|crossing| crossing.direction).collect();
    assert_eq!(directions, [Direction::Falling, Direction::Falling]);
}

/// A step that an event ends has the noise of the whole step.
#[test]
fn a_step_that_an_event_ends_keeps_its_noise() {
    let pushed = Pushed { s: 0.7 };
    let run = pushed.simulate::<Verlet>(0.25).start(State::new([0.0], [0.0])).until(3.1);
    let path = run.noise(Wiener::seed(5)).on_time(1.1, |_| Terminal).run().unwrap();
    let mut states = path.at(&pushed).noise(Wiener::seed(5));
    for t in [1.02, 1.07, 1.1] {
        let p = 0.7 * Wiener::seed(5).value(0, t).unwrap();
        assert!((states.state(t).unwrap().p[0] - p).abs() < 1e-14, "{t}");
    }
    assert!((path.last().p[0] - 0.7 * path.wiener(0).last().unwrap()).abs() < 1e-14);
}

/// A kick across a rod is what its component along the motion is: the rod takes the rest.
#[test]
fn events_lead_to_the_manifold() {
    #[hamiltonian(
        drift = |q: [f64; 2], p: [f64; 2]| 0.5 * (p[0] * p[0] + p[1] * p[1]) + q[1],
        constraint = [|[x, y]| 0.5 * (x * x + y * y - 1.0)],
        embedding = Rattle,
    )]
    struct Rod;
    let run = Rod.simulate::<Rattle>(0.05).start(State::new([0.6, -0.8], [0.0, 0.0])).until(2.0);
    let run = run.on_time(0.52, |s| {
        s.p[0] += 3.0;
        s.p[1] += 4.0;
    });
    let path = run.run().unwrap();
    let (before, after) = (&path.events()[0].before, &path.events()[0].after);
    let tangent = [-after.q[1], after.q[0]];
    let along = |p: [f64; 2]| p[0] * tangent[0] + p[1] * tangent[1];
    let gained = along([after.p[0], after.p[1]]) - along([before.p[0], before.p[1]]);
    assert!((gained - along([3.0, 4.0])).abs() < 1e-14);
    assert!((after.p[0] * after.q[0] + after.p[1] * after.q[1]).abs() < 1e-14);
    assert_eq!(after.q, before.q);
    assert!(path.iter().all(|state| (state.q[0].hypot(state.q[1]) - 1.0).abs() < 1e-14));
}

/// At a corner that is a node up to rounding, where something else happens, too, the second wall holds.
#[test]
fn walls_hold_at_nodes() {
    #[hamiltonian(drift = |q: [f64; 2], p: [f64; 2]| 0.5 * (p[0] * p[0] + p[1] * p[1]), embedding = Gauss<4>)]
    struct Puck;
    for (q, p, end) in [
        ([0.5, 0.25], [-0.75, -0.125], [0.5, 0.25]),
        ([0.75, 0.5], [1.125, 1.25], [0.75, 0.5]),
        ([0.75, 0.5], [0.875, -1.75], [0.25, 0.5]),
    ] {
        let run = Puck.simulate::<Gauss<4>>(0.125).start(State::new(q, p)).until(20.0).on_time(10.0, |_| ());
        let run = run.on(|s| s.q[0], |s| s.p[0] *= -1.0).on(|s| s.q[1], |s| s.p[1] *= -1.0);
        let run = run.on(|s| s.q[0] - 1.0, |s| s.p[0] *= -1.0).on(|s| s.q[1] - 1.0, |s| s.p[1] *= -1.0);
        let path = run.on(|s| s.q[0] - s.q[1], |_| ()).run().unwrap();
        for i in 0..2 {
            // A few units in the last place for each of some sixty events.
            assert!((path.last().q[i] - end[i]).abs() < 1e-13, "{:?}", path.last());
        }
    }
}
