//! No judgement of a solver depends on the units that a system is written in: those of each coordinate with its momentum, of energy and of time.
//!
//! A system is written in other units by powers of two: `H'(q, p) = 2^(e - τ) H(2^-a_i q_i, 2^(a_i - e) p_i)` with steps of `2^τ h` has the coordinates
//! `2^a_i q_i` and the momenta `2^(e - a_i) p_i`. Powers of two round nothing, so that a step has to have exactly the same bits, and is refused exactly where
//! that in units of one is.

use fixtures::Uniform;
use wzvi::nalgebra::{DVector, SVector};
use wzvi::prelude::*;

/// Coupled quartic wells, whose mass depends on the place: unknowns of both kinds, in units `x`, `y` of the coordinates, `px`, `py` of the momenta and `e` of
/// the energy, each by its inverse.
#[hamiltonian(
    drift = |[x, y], [px, py]| {
        let (x, y, px, py) = (x * ux, y * uy, px * upx, py * upy);
        energy * (0.5 * px * px * (1.0 + 0.25 * x * x) + 0.5 * py * py + 0.2 * px * y + 0.25 * x.powi(4) + 0.25 * y.powi(4) + 0.3 * x * y * y)
    },
    embedding = [Midpoint, Lambda<1, 3>, Gauss<2>, Gauss<4>],
)]
struct Coupled {
    ux: f64,
    uy: f64,
    upx: f64,
    upy: f64,
    energy: f64,
}

/// A charge in a uniform field: a linear step, in any units.
#[hamiltonian(
    drift = |[x, y], [px, py]| {
        let (vx, vy) = (px + 0.5 * charge * field * y, py - 0.5 * charge * field * x);
        (vx * vx + vy * vy) / (2.0 * mass)
    },
    embedding = Midpoint,
)]
struct Charge {
    mass: f64,
    charge: f64,
    field: f64,
}

/// A mass that depends on the place, in any units of mass.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p / mass * (1.0 + q * q) + 0.5 * stiffness * q * q,
    embedding = Midpoint,
)]
struct Metric {
    mass: f64,
    stiffness: f64,
}

/// A chain whose masses depend on the place: its matrix is a band, in both unknowns.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| energy * ((0..q.len()).map(|i| 0.5 * momentum * momentum * p[i] * p[i] * (1.0 + place * place * q[i] * q[i])).sum::<f64>()
        + (0..q.len() - 1).map(|i| (place * (q[i + 1] - q[i])).powi(2) + 0.25 * (place * q[i]).powi(4)).sum::<f64>()),
    embedding = Midpoint,
)]
struct Chain {
    place: f64,
    momentum: f64,
    energy: f64,
}

fn power(exponent: i32) -> f64 {
    2.0_f64.powi(exponent)
}

fn exponent(random: &mut Uniform) -> i32 {
    (100.0 * random.draw()) as i32
}

/// Units of both coordinates, of energy and of time, as powers of two.
type Units = [i32; 4];

type Plane = State<SVector<f64, 2>>;

fn coupled([a, b, e, tau]: Units) -> Coupled {
    Coupled { ux: power(-a), uy: power(-b), upx: power(a - e), upy: power(b - e), energy: power(e - tau) }
}

fn in_units([x, y, px, py]: [f64; 4], [a, b, e, _]: Units) -> Plane {
    State::new([x * power(a), y * power(b)], [px * power(e - a), py * power(e - b)])
}

/// In units of one.
fn bits(state: &Plane, [a, b, e, _]: Units) -> [u64; 4] {
    let (q, p) = (state.q, state.p);
    [q[0] * power(-a), q[1] * power(-b), p[0] * power(a - e), p[1] * power(b - e)].map(f64::to_bits)
}

/// Four steps of one scheme in units of one and in others: the bits of both, in units of one.
fn in_both_units<E>(units: Units, h: f64, start: [f64; 4])
where
    Coupled: Discretized<E> + Hamiltonian<Vector = SVector<f64, 2>>,
{
    let run = |units: Units| {
        let (system, mut state) = (coupled(units), in_units(start, units));
        let mut stepper = wzvi::step::Stepper::<_, E>::new(&system, h * power(units[3])).unwrap();
        let outcome: Vec<_> = (0..4).map(|_| stepper.step(&mut state, &[]).map_err(|_| ())).collect();
        (outcome, bits(&state, units))
    };
    assert_eq!(run([0; 4]), run(units), "units 2^{units:?}, h = {h}, start {start:?}");
}

#[test]
fn small_steps_have_the_same_bits_in_all_units() {
    let mut random = Uniform(11);
    for _ in 0..40 {
        let exponents = std::array::from_fn(|_| exponent(&mut random));
        let h = 0.5 + 0.49 * random.draw();
        let start = std::array::from_fn(|_| 2.0 * random.draw());
        in_both_units::<Midpoint>(exponents, h, start);
        in_both_units::<Lambda<1, 3>>(exponents, h, start);
        in_both_units::<Gauss<2>>(exponents, h, start);
        in_both_units::<Gauss<4>>(exponents, h, start);
    }
}

/// The proton of SI units, and each number apart.
#[test]
fn a_charge_moves_in_all_units() {
    for exponents in [[-89, -62, 0], [0, 0, 0], [100, -100, 90], [-100, 40, 0]] {
        let [mass, charge, field] = exponents.map(power);
        // An angle of 0.1 in each step.
        let h = 0.1 * mass / (charge * field);
        let mut state = State::new([1.0, 0.0], [0.0, 0.5 * charge * field]);
        let system = Charge { mass, charge, field };
        let taken = system.stepper::<Midpoint>(h).unwrap().step(&mut state, &[]);
        assert!(taken.is_ok(), "{exponents:?}: {taken:?}");
    }
    let proton = Charge { mass: 1.67e-27, charge: 1.6e-19, field: 1.0 };
    let mut state = State::new([0.0, 0.0], [1.67e-22, 0.0]);
    proton.stepper::<Midpoint>(1e-9).unwrap().step(&mut state, &[]).unwrap();
}

#[test]
fn a_mass_has_no_smallest_value() {
    let run = |exponent: i32| {
        let system = Metric { mass: power(exponent), stiffness: power(exponent) };
        let mut state = State::new([0.7], [0.4 * power(exponent)]);
        let mut stepper = system.stepper::<Midpoint>(0.1).unwrap();
        let taken: Vec<_> =
            (0..10).map(|_| stepper.step(&mut state, &[]).map_err(|error| error.to_string())).collect();
        (taken, state.q[0], state.p[0] * power(-exponent))
    };
    for exponent in [-60, -100, -300, 300] {
        assert_eq!(run(exponent), run(0), "{exponent}");
    }
}

#[test]
fn a_chain_has_the_same_bits_in_all_units() {
    let mut random = Uniform(5);
    for _ in 0..20 {
        let [a, e, tau]: [i32; 3] = std::array::from_fn(|_| exponent(&mut random));
        let start: Vec<f64> = (0..24).map(|_| random.draw()).collect();
        let run = |a: i32, e: i32, tau: i32| {
            let system = Chain { place: power(-a), momentum: power(a - e), energy: power(e - tau) };
            let q: Vec<f64> = start[..12].iter().map(|x| x * power(a)).collect();
            let p: Vec<f64> = start[12..].iter().map(|x| x * power(e - a)).collect();
            let mut state = State::<DVector<f64>>::new(q, p);
            let mut stepper = system.stepper::<Midpoint>(0.4 * power(tau)).unwrap();
            let outcome: Vec<_> =
                (0..5).map(|_| stepper.step(&mut state, &[]).map_err(|error| error.cause)).collect();
            let q = state.q.iter().map(|x| (x * power(-a)).to_bits());
            let p = state.p.iter().map(|x| (x * power(a - e)).to_bits());
            (outcome, q.chain(p).collect::<Vec<_>>())
        };
        assert_eq!(run(0, 0, 0), run(a, e, tau), "{a} {e} {tau}");
    }
}

/// In lanes beside each other, each with units of its own.
#[test]
fn lanes_have_the_same_bits_in_all_units() {
    fn run<E>(units: &[Units], h: f64, starts: &[[f64; 4]]) -> Vec<Option<[u64; 4]>>
    where
        Coupled: Discretized<E> + Hamiltonian<Vector = SVector<f64, 2>>,
    {
        let systems = || units.iter().map(|&units| coupled(units));
        let starts: Vec<Plane> =
            starts.iter().zip(units).map(|(start, &units)| in_units(*start, units)).collect();
        let ends = std::sync::Mutex::new(vec![None; units.len()]);
        let see = |path: u64, state: &Plane| {
            if state.t != 0.0 {
                ends.lock().unwrap()[path as usize] = Some(bits(state, units[path as usize]));
            }
        };
        let (first, h) = (coupled(units[0]), h * power(units[0][3]));
        let run = wzvi::ensemble::Ensemble::<Coupled, E>::new(&first, h).steps(4);
        let run = run.systems_from(systems()).starts_from(starts).allow_losses(1.0).inspect(see);
        match run.run_in::<8>() {
            Ok(_) | Err(wzvi::Error::Step(_)) => {}
            Err(error) => panic!("{error}"),
        }
        ends.into_inner().unwrap()
    }
    let mut random = Uniform(29);
    for _ in 0..8 {
        let mut units: Vec<Units> = (0..8).map(|_| std::array::from_fn(|_| exponent(&mut random))).collect();
        // One time for all.
        let tau = units[0][3];
        units.iter_mut().for_each(|units| units[3] = tau);
        let starts: Vec<[f64; 4]> = (0..8).map(|_| std::array::from_fn(|_| 2.0 * random.draw())).collect();
        let h = 0.5 + 0.49 * random.draw();
        let ones = [[0; 4]; 8];
        assert_eq!(run::<Midpoint>(&ones, h, &starts), run::<Midpoint>(&units, h, &starts), "{units:?}");
        assert_eq!(run::<Gauss<2>>(&ones, h, &starts), run::<Gauss<2>>(&units, h, &starts), "{units:?}");
    }
}
