//! Steps of paths beside each other that some of them cannot take.

use wzvi::__private::Plain;
use wzvi::error::StepFailure;
use wzvi::lanes::Lanes;
use wzvi::system::Discretized;

const L: usize = 4;

/// Numbers between -1 and 1 that have nothing to do with each other.
pub(crate) fn numbers() -> impl FnMut() -> f64 {
    let mut state = 7_u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 2_f64.powi(52) - 1.0
    }
}

/// Steps of four paths of one degree of freedom, the short way: lanes fail where they do alone, with state and memory as before the step, and
/// the others take theirs. A lane that fails goes on from another state. In how many steps some lanes failed, and not all.
pub(crate) fn steps_in_part<E, H: Discretized<E>>(
    system: &H,
    h: f64,
    mut start: impl FnMut() -> [f64; 2],
    mut increment: impl FnMut() -> f64,
) -> u32 {
    const STEPS: usize = 400;
    let prepared = system.prepare(h).expect("a step");
    let mut memory = H::Memory::<Lanes<L>>::default();
    let mut alone: [_; L] = std::array::from_fn(|_| (start(), H::Memory::<Lanes<1>>::default()));
    let lanes =
        |i: usize, alone: &[([f64; 2], _); L]| vec![Lanes::new(std::array::from_fn(|lane| alone[lane].0[i]))];
    let mut in_part = 0;
    for step in 0..STEPS {
        let t = step as f64 * h;
        let dw: Vec<Lanes<L>> =
            (0..system.increments(1)).map(|_| Lanes::new(std::array::from_fn(|_| increment()))).collect();
        let (mut q, mut p) = (lanes(0, &alone), lanes(1, &alone));
        let outcome = system.advance_carrying::<_, Plain, false>(
            &prepared,
            t,
            h,
            &mut q,
            &mut p,
            &dw,
            &mut memory,
            &mut Plain,
        );
        let mut failed = Vec::new();
        for (lane, (state, memory)) in alone.iter_mut().enumerate() {
            let [mut q, mut p] = state.map(|x| [Lanes::new([x])]);
            let dw: Vec<_> = dw.iter().map(|dw| Lanes::new([dw[lane]])).collect();
            let taken = system.advance_carrying::<_, Plain, false>(
                &prepared, t, h, &mut q, &mut p, &dw, memory, &mut Plain,
            );
            *state = [q[0][0], p[0][0]];
            if taken.is_err() {
                failed.push(lane);
            }
        }
        for (i, numbers) in [(0, &q), (1, &p)] {
            assert_eq!(*numbers, lanes(i, &alone), "step {step}: {failed:?} failed");
        }
        match outcome {
            Ok(_) => assert_eq!(failed, [0; 0], "step {step}"),
            Err(StepFailure::Lanes(lanes)) => {
                assert_eq!(lanes.lanes().collect::<Vec<_>>(), failed, "step {step}")
            }
            Err(failure) => panic!("step {step}: {failure:?}"),
        }
        in_part += u32::from(!failed.is_empty() && failed.len() < L);
        failed.into_iter().for_each(|lane| alone[lane].0 = start());
    }
    in_part
}

/// Steps of four paths by [`Discretized::advance`], all of which move or none: how many steps the short way could not take, split into those that
/// were taken with care and those that were not.
pub(crate) fn steps_together<E, H: Discretized<E>>(
    system: &H,
    h: f64,
    mut start: impl FnMut() -> [f64; 2],
) -> [u32; 2] {
    let prepared = system.prepare(h).expect("a step");
    let (mut memory, mut hard) = (H::Memory::<Lanes<L>>::default(), [0, 0]);
    for step in 0..400 {
        let starts: [[f64; 2]; L] = std::array::from_fn(|_| start());
        let lanes = |i: usize| [Lanes::new(starts.map(|state| state[i]))];
        let (mut q, mut p, before) = (lanes(0), lanes(1), format!("{memory:?}"));
        let short = system.advance_carrying::<_, Plain, false>(
            &prepared,
            0.0,
            h,
            &mut q,
            &mut p,
            &[],
            &mut memory.clone(),
            &mut Plain,
        );
        (q, p) = (lanes(0), lanes(1));
        let taken = system.advance(&prepared, 0.0, h, &mut q, &mut p, &[], &mut memory);
        if taken.is_err() {
            assert_eq!((q, p, format!("{memory:?}")), (lanes(0), lanes(1), before), "step {step}");
        } else {
            let has_moved =
                |lane: usize| [q[0][lane], p[0][lane]] != starts[lane] && (q[0] + p[0])[lane].is_finite();
            assert!((0..L).all(has_moved), "step {step}: {starts:?} to {q:?}, {p:?}");
        }
        if short.is_err() {
            hard[usize::from(taken.is_err())] += 1;
        }
    }
    hard
}
