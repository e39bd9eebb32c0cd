//! Friction without a temperature: exact in the steps where it has one rate, a force otherwise.

use fixtures::reference::{data, list, numbers};
use fixtures::steps::{apart, asymmetry, distance, numbers as components};
use wzvi::nalgebra::SVector;
use wzvi::prelude::*;

use crate::principle::same_by;

/// Two coupled masses with one rate: with a literal size in straight lines, with a const generic in loops.
macro_rules! coupled {
    ($name:ident, [$($generics:tt)*], $state:ty) => {
        #[hamiltonian(
            drift = |q: $state, p: $state| 0.5 * p[0] * p[0] / self.m + 0.5 * p[1] * p[1] + 0.2 * p[0] * p[1]
                - (q[1] - q[0]).cos() + 0.25 * q[0].powi(4),
            friction = self.gamma,
            embedding = [DeltaPlus, DeltaMinus, Midpoint, Lambda<1, 3>, Verlet, Gauss<2>, Gauss<3>],
        )]
        #[derive(Clone, Debug)]
        pub(crate) struct $name$($generics)* {
            pub(crate) m: f64,
            pub(crate) gamma: f64,
        }
    };
}

coupled!(CoupledInline, [], [f64; 2]);
coupled!(CoupledInLoops, [<const N: usize>], [f64; N]);
type CoupledLoops = CoupledInLoops<2>;

#[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), friction = gamma, embedding = [Midpoint, Gauss<1>, Gauss<2>])]
struct Pendulum {
    gamma: f64,
}

#[hamiltonian(drift = |q: [f64; N], p: [f64; N]| 0.5 * p[0] * p[0] - q[0].cos(), friction = gamma, embedding = [Midpoint, Gauss<2>])]
struct PendulumInLoops<const N: usize> {
    gamma: f64,
}
type PendulumLoops = PendulumInLoops<1>;

fn reference<E, H: Discretized<E, Vector = SVector<f64, 1>>>(system: &H, scheme: &str) {
    let data = data("langevin_steps");
    let case = list(&data["cases"]).iter().find(|case| case["scheme"] == scheme).unwrap();
    let mut state = State::new([2.0], [0.0]);
    let mut stepper = system.stepper::<E>(0.5).unwrap();
    for expected in list(&case["trajectory_qp"]).iter().map(numbers) {
        stepper.step(&mut state, &[]).unwrap();
        // Some ten roundings of numbers below 2.
        assert!(distance(&components(&state), &expected) < 1e-14, "{scheme} {state:?}");
    }
}

#[test]
fn conformal_steps_are_those_of_the_reference() {
    let (inline, loops) = (Pendulum { gamma: 0.3 }, PendulumLoops { gamma: 0.3 });
    reference::<Midpoint, _>(&inline, "conformal Gauss s=1");
    reference::<Gauss<1>, _>(&inline, "conformal Gauss s=1");
    reference::<Midpoint, _>(&loops, "conformal Gauss s=1");
    reference::<Gauss<2>, _>(&inline, "conformal Gauss s=2");
    reference::<Gauss<2>, _>(&loops, "conformal Gauss s=2");
}

/// `Mᵀ J M = e^{-γ h} J` for the Jacobian `M` of a step, which has the determinant `e^{-γ h d}` then.
fn conformal<E, H: Discretized<E>>(system: &H, gamma: f64) {
    let (start, h): ([&[f64]; 2], _) = ([&[0.6, -0.3], &[0.4, 0.9]], 0.15);
    let gap = asymmetry::<E, _>(system, start, [0.3, h], &[], (-gamma * h).exp());
    // A few roundings of products of entries below 2.
    assert!(gap < 1e-14, "{}: {gap:e}", std::any::type_name::<E>());
}

macro_rules! every_scheme {
    ($check:ident, $system:expr, $gamma:expr) => {
        $check::<DeltaPlus, _>($system, $gamma);
        $check::<DeltaMinus, _>($system, $gamma);
        $check::<Midpoint, _>($system, $gamma);
        $check::<Lambda<1, 3>, _>($system, $gamma);
        $check::<Verlet, _>($system, $gamma);
        $check::<Gauss<2>, _>($system, $gamma);
        $check::<Gauss<3>, _>($system, $gamma);
        $check::<Composed<Verlet, Yoshida4>, _>($system, $gamma);
        $check::<Composed<Gauss<2>, Suzuki4>, _>($system, $gamma);
    };
}

/// In loops one of each kind.
macro_rules! schemes_in_loops {
    ($check:ident, $system:expr, $gamma:expr) => {
        $check::<Midpoint, _>($system, $gamma);
        $check::<Verlet, _>($system, $gamma);
        $check::<Gauss<2>, _>($system, $gamma);
        $check::<Composed<Verlet, Yoshida4>, _>($system, $gamma);
    };
}

#[test]
fn friction_of_one_rate_scales_the_symplectic_form() {
    for gamma in [0.0, 0.7, 12.0] {
        every_scheme!(conformal, &CoupledInline { m: 1.4, gamma }, gamma);
        schemes_in_loops!(conformal, &CoupledLoops { m: 1.4, gamma }, gamma);
    }
}

/// The residual of the equations between two steps, and the momenta that these give.
fn residual<E, H: Discretized<E, Vector = SVector<f64, 2>>>(system: &H, _: f64) {
    crate::principle::residual::<E, H>(system, State::new([0.6, -0.3], [0.4, 0.9]), &[]);
}

#[test]
fn conformal_steps_solve_their_equations() {
    every_scheme!(residual, &CoupledInline { m: 1.4, gamma: 0.7 }, 0.7);
    schemes_in_loops!(residual, &CoupledLoops { m: 1.4, gamma: 0.7 }, 0.7);
}

#[test]
fn conformal_loops_do_what_straight_lines_do() {
    let (a, b) = (CoupledInline { m: 1.4, gamma: 0.7 }, CoupledLoops { m: 1.4, gamma: 0.7 });
    let start: [&[f64]; 2] = [&[0.6, -0.3], &[0.4, 0.9]];
    same_by!(&a, &b, start, &[], DeltaPlus, DeltaMinus, Midpoint, Lambda<1, 3>, Verlet, Gauss<2>, Gauss<3>);
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q,
    force = |_q, _p, t| push * (2.0 * t).cos(),
    friction = drag,
    embedding = [DeltaPlus, DeltaMinus, Midpoint, Verlet, Gauss<2>, Gauss<3>, Gauss<4>],
)]
struct Oscillator {
    drag: f64,
    push: f64,
}

#[test]
fn friction_keeps_the_order_of_the_scheme() {
    crate::orders::orders(&Oscillator { drag: crate::orders::DRAG, push: crate::orders::PUSH });
}

/// Rates by degree of freedom, by place, and a matrix, in straight lines and in loops, and the forces that they are.
macro_rules! drawn {
    ($name:ident, $friction:tt, $loops:ident, $in_loops:ident, $general:tt, $forced:ident, $force:tt) => {
        drawn!(@of $name, [], [f64; 2], $friction);
        drawn!(@of $in_loops, [<const N: usize>], [f64; N], $general);
        type $loops = $in_loops<2>;
        drawn!(@of $forced, [], [f64; 2], $force);
    };
    (@of $name:ident, [$($generics:tt)*], $state:ty, { $($friction:tt)* }) => {
        #[hamiltonian(
            drift = |q: $state, p: $state| 0.5 * p[0] * p[0] / self.m + 0.5 * p[1] * p[1] - (q[1] - q[0]).cos(),
            $($friction)*,
            embedding = [DeltaPlus, Midpoint, Gauss<2>],
        )]
        #[derive(Clone, Debug)]
        struct $name$($generics)* {
            m: f64,
            gamma: f64,
        }
    };
}

drawn!(
    List,
    { friction = [self.gamma, 0.5] },
    ListLoops,
    ListInLoops,
    { friction = (0..N).map(|i| if i == 0 { self.gamma } else { 0.5 }) },
    ListForce,
    { force = |_q: [f64; 2], p: [f64; 2]| [-self.gamma * p[0], -0.5 * p[1]] }
);
drawn!(
    Place,
    { friction = |q: [f64; 2]| [self.gamma * q[0] * q[0], self.gamma * q[1] * q[1]] },
    PlaceLoops,
    PlaceInLoops,
    { friction = |q: [f64; N]| q.map(|x| self.gamma * x * x) },
    PlaceForce,
    {
        force =
            |q: [f64; 2], p: [f64; 2]| [-self.gamma * q[0] * q[0] * p[0], -self.gamma * q[1] * q[1] * p[1]]
    }
);
drawn!(
    Matrix,
    { damping = [[self.gamma, 0.2], [0.2, 0.5]] },
    MatrixLoops,
    MatrixInLoops,
    {
        damping = (0..N).map(move |i| {
            (0..N).map(move |j| {
                if i != j {
                    0.2
                } else if i == 0 {
                    self.gamma
                } else {
                    0.5
                }
            })
        })
    },
    MatrixForce,
    {
        force = |_q: [f64; 2], p: [f64; 2]| {
            [-self.gamma * p[0] / self.m - 0.2 * p[1], -0.2 * p[0] / self.m - 0.5 * p[1]]
        }
    }
);

/// A constant matrix whose size only the state knows.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| 0.5 * p[0] * p[0] / self.m + 0.5 * p[1] * p[1] - (q[1] - q[0]).cos(),
    damping = |q: &[f64]| {
        let n = q.len();
        (0..n).map(move |i| (0..n).map(move |j| self.matrix[i][j]))
    },
    embedding = [DeltaPlus, Midpoint, Gauss<2>],
)]
struct MatrixOfState {
    m: f64,
    matrix: Vec<Vec<f64>>,
}

#[test]
fn other_friction_is_the_force_that_it_is() {
    let start: [&[f64]; 2] = [&[0.6, -0.3], &[0.4, 0.9]];
    macro_rules! same {
        ($($a:ident $b:ident),*) => {$(
            let (a, b) = ($a { m: 1.4, gamma: 0.7 }, $b { m: 1.4, gamma: 0.7 });
            same_by!(&a, &b, start, &[], DeltaPlus, Midpoint, Gauss<2>);
        )*};
    }
    same!(List ListForce, ListLoops ListForce, Place PlaceForce, PlaceLoops PlaceForce, Matrix MatrixForce, MatrixLoops MatrixForce);
    let of_state = MatrixOfState { m: 1.4, matrix: vec![vec![0.7, 0.2], vec![0.2, 0.5]] };
    same_by!(&of_state, &MatrixForce { m: 1.4, gamma: 0.7 }, start, &[], DeltaPlus, Midpoint, Gauss<2>);
}

#[test]
fn dense_output_knows_of_friction() {
    // Between nodes of the exact solution to fourth order, as without friction.
    let system = Oscillator { drag: crate::orders::DRAG, push: crate::orders::PUSH };
    let path = system
        .simulate::<Gauss<4>>(0.2)
        .start(State::new([1.1], [-0.4]))
        .record_at([1.0, 1.07, 1.13, 2.51])
        .until(4.0)
        .run()
        .unwrap();
    let inner = path.states().iter().filter(|state| [1.07, 1.13, 2.51].contains(&state.t));
    for state in inner {
        let [q, p] = crate::orders::exact(state.t, 1.1, -0.4);
        assert!((state.q[0] - q).abs() < 2e-5 && (state.p[0] - p).abs() < 2e-5, "{state:?} {q} {p}");
    }
}

#[test]
fn friction_that_makes_no_sense_is_refused_by_steppers() {
    use wzvi::error::{BathError, ConfigError};
    let refused = |error: Option<ConfigError>| match error {
        Some(ConfigError::Bath(error)) => error,
        other => panic!("{other:?}"),
    };
    let of = |gamma: f64| refused(Pendulum { gamma }.stepper::<Midpoint>(0.1).err());
    assert_eq!(of(-0.1), BathError::Friction { rate: -0.1 });
    assert!(matches!(of(f64::INFINITY), BathError::Friction { .. }));
    let loops = refused(PendulumLoops { gamma: -0.1 }.stepper::<Gauss<2>>(0.1).err());
    assert_eq!(loops, BathError::Friction { rate: -0.1 });
    for error in [
        List { m: 1.4, gamma: -0.7 }.stepper::<Midpoint>(0.1).err(),
        ListLoops { m: 1.4, gamma: -0.7 }.stepper::<Midpoint>(0.1).err(),
        // The determinant of the matrix is 0.05 - 0.04, then 0.005 - 0.04.
        Matrix { m: 1.4, gamma: 0.01 }.stepper::<Midpoint>(0.1).err(),
        MatrixLoops { m: 1.4, gamma: 0.01 }.stepper::<Midpoint>(0.1).err(),
    ] {
        assert!(matches!(refused(error), BathError::Friction { rate } if rate < 0.0));
    }
    assert!(Matrix { m: 1.4, gamma: 0.1 }.stepper::<Midpoint>(0.1).is_ok());
}

#[test]
fn no_friction_is_the_bare_scheme() {
    #[hamiltonian(drift = |q, p| 0.5 * p * p - q.cos(), embedding = [Midpoint, Gauss<2>])]
    struct Bare;
    macro_rules! same {
        ($($scheme:ty),*) => {
            // Sums in another order.
            $(assert!(apart::<$scheme, _, _>((&Pendulum { gamma: 0.0 }, &Bare), [&[2.0], &[0.3]], (0.1, 20), &[]) < 1e-14);)*
        };
    }
    same!(Midpoint, Gauss<2>);
}

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * q * q, embedding = [Midpoint, DeltaPlus],
    invariant = [|q, p, t| q * t.cos() - p * t.sin()],
)]
struct Turning;

#[hamiltonian(
    drift = |_q, p| 0.5 * p * p, friction = g, embedding = [Midpoint, DeltaPlus],
    invariant = [|q, p| q + p / g],
)]
struct Stopping {
    g: f64,
}

#[hamiltonian(
    drift = |[x, y], [a, b]| 0.5 * (a * a + b * b + x * x + y * y), friction = [0.0, g],
    embedding = [Baoab, Thermostat<Verlet>, Thermostat<Midpoint>],
    invariant = [|[x, _y], [a, _b]| x * x + a * a],
)]
struct Beside {
    g: f64,
}

/// A first integral is called kept to rounding where it is: with explicit time, friction and baths.
#[test]
fn integrals_that_are_kept_to_rounding_are_said_to_be() {
    fn check<E, H: Discretized<E>>(system: &H, start: State<H::Vector>, expected: bool) {
        let path = system.simulate::<E>(0.1).start(start).steps(100).run().unwrap();
        let drift = path.invariant_drift(system, 0).unwrap();
        // A hundred steps of a few roundings, and a step that is not exact.
        assert_eq!(drift < 1e-13, expected, "{drift}: {}", H::EQUATIONS);
        let said = H::EQUATIONS.lines().find(|line| line.starts_with("  first integral")).unwrap();
        assert_eq!(said.ends_with(": kept by the step to rounding"), expected, "{said}");
    }
    let line = || State::new([0.8], [0.3]);
    check::<Midpoint, _>(&Turning, line(), false);
    check::<DeltaPlus, _>(&Turning, line(), false);
    check::<Midpoint, _>(&Stopping { g: 0.8 }, line(), false);
    check::<DeltaPlus, _>(&Stopping { g: 0.8 }, line(), false);
    let plane = || State::new([0.8, 0.1], [0.3, 0.2]);
    check::<Baoab, _>(&Beside { g: 0.8 }, plane(), false);
    check::<Thermostat<Verlet>, _>(&Beside { g: 0.8 }, plane(), false);
    check::<Thermostat<Midpoint>, _>(&Beside { g: 0.8 }, plane(), true);
}
