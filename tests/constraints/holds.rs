//! What holds at every node: constraints, their derivatives by the time, momenta of symmetries.

use fixtures::reference::{data, list, number, numbers};
use wzvi::constraints::{Constrained, ConstraintRows};
use wzvi::elements::EvaluationPoint;
use wzvi::nalgebra::{DVector, SVector};
use wzvi::prelude::*;
use wzvi::state::Vector;

use super::linkages::{self, Linkage};
use super::systems::{CarAxis, DoublePendulum, Sphere, Top};

/// A ring of rods in space, which nothing holds.
pub fn ring(n: usize) -> (Linkage, State<DVector<f64>>) {
    let angle = |i: usize| 2.0 * std::f64::consts::PI * i as f64 / n as f64;
    let side = 2.0 * (std::f64::consts::PI / n as f64).sin();
    let q: Vec<f64> = (0..n).flat_map(|i| [angle(i).cos(), angle(i).sin(), 0.0]).collect();
    let p: Vec<f64> = (0..n)
        .flat_map(|i| [0.1 - 0.3 * angle(i).sin(), 0.3 * angle(i).cos(), 0.2 * (i % 2) as f64])
        .collect();
    let linkage = Linkage {
        mass: vec![1.0; n],
        gravity: [0.0; 3],
        trap: vec![0.2; n],
        rods: (0..n).map(|i| [i, (i + 1) % n]).collect(),
        length: vec![side; n],
        pins: vec![],
        arm: vec![],
    };
    (linkage, State::new(DVector::from_vec(q), DVector::from_vec(p)))
}

/// A chain of rods that hangs on the origin.
pub fn chain(n: usize) -> (Linkage, State<DVector<f64>>) {
    let q: Vec<f64> = (0..n).flat_map(|i| [0.6 * (i + 1) as f64, 0.0, 0.8 * (i + 1) as f64]).collect();
    let linkage = Linkage {
        mass: vec![1.0; n],
        gravity: [0.0, 0.0, 1.0],
        trap: vec![0.0; n],
        rods: (1..n).map(|i| [i - 1, i]).collect(),
        length: vec![1.0; n - 1],
        pins: vec![0],
        arm: vec![1.0],
    };
    (linkage, State::new(DVector::from_vec(q), DVector::from_vec(vec![0.0; 3 * n])))
}

/// The constraints and their derivatives by the time, and the sizes of their terms.
struct Terms<'a> {
    q: &'a [f64],
    t: f64,
    velocity: &'a [f64],
    /// The largest velocities of the path.
    fastest: &'a [f64],
    values: Vec<[f64; 2]>,
    rates: Vec<[f64; 2]>,
}

impl ConstraintRows<f64> for Terms<'_> {
    fn value(&mut self, constraint: usize, value: f64) {
        self.values[constraint][0] += value;
    }

    fn slope(&mut self, constraint: usize, coordinate: usize, slope: f64) {
        self.values[constraint][1] += (slope * self.q[coordinate]).abs();
        self.rates[constraint][0] += slope * self.velocity[coordinate];
        self.rates[constraint][1] += (slope * self.fastest[coordinate]).abs();
    }

    fn rate(&mut self, constraint: usize, rate: f64) {
        // The time has a rounding, too.
        self.values[constraint][1] += (rate * self.t).abs();
        self.rates[constraint][0] += rate;
        self.rates[constraint][1] += rate.abs();
    }
}

/// Every node of so many steps is on the manifold to a rounding of the terms of the constraints. Coordinates are
/// accepted at four roundings of both ends of a drift. Momenta are sums of kicks and impulses: where a linkage
/// turns back these are larger than the momenta, so that the largest velocities of the path count.
fn stays_on_manifold<E, H, V: Vector>(system: &H, w: &[f64], start: State<V>, [h, steps]: [f64; 2])
where
    H: Discretized<E> + Hamiltonian<Vector = V> + Constrained,
{
    let path = system.simulate::<E>(h).start(start).project_start().steps(steps as u64).run().unwrap();
    let velocities: Vec<Vec<f64>> = path
        .states()
        .iter()
        .map(|node| node.p.components().iter().zip(w).map(|(p, w)| w * p).collect())
        .collect();
    let fastest: Vec<f64> =
        (0..w.len()).map(|i| velocities.iter().map(|v| v[i].abs()).fold(0.0, fixtures::larger)).collect();
    let mut worst = [0.0; 2];
    for (node, velocity) in path.states().iter().zip(&velocities) {
        let count = Constrained::constraints(system);
        let [values, rates] = [(); 2].map(|()| vec![[0.0; 2]; count]);
        let q = node.q.components();
        let mut terms = Terms { q, t: node.t, velocity, fastest: &fastest, values, rates };
        let (p, t, parameters, dw) = (&[][..], node.t, &[][..], &[][..]);
        let at = EvaluationPoint { q, p, t, h: 1.0, parameters, dw, acting: 0..0, scale: 1.0 };
        system.constrain(&at, &mut terms);
        for (worst, list) in worst.iter_mut().zip([&terms.values, &terms.rates]) {
            for [value, size] in list {
                let share = if *value == 0.0 { 0.0 } else { value.abs() / size };
                *worst = fixtures::larger(*worst, share);
            }
        }
    }
    let what = std::any::type_name::<(E, H)>();
    // The road is a function of sin(10 t), whose argument has two roundings: of the time, and of the product.
    let roundings = if H::READ_TIME { 2.0 * 10.0 * h * steps } else { 10.0 };
    assert!(worst.into_iter().all(|worst| worst <= roundings * f64::EPSILON), "{what}: {worst:?}");
}

#[test]
fn constraints_hold_at_every_node() {
    let all = data("constraints");
    fn start<V: Vector>(case: &serde_json::Value) -> State<V> {
        fixtures::extremes::state(&numbers(&case["q0"]), &numbers(&case["p0"]))
    }
    let (sphere, on_sphere) = (Sphere { g: 1.0 }, State::new([0.6, 0.0, 0.8], [0.0, 0.7, 0.0]));
    stays_on_manifold::<Rattle, _, _>(&sphere, &[1.0; 3], on_sphere, [0.1, 3000.0]);
    let (w, double) = ([1.0, 1.0, 0.5, 0.5], start(&all["double_pendulum"]));
    stays_on_manifold::<Composed<Rattle, Yoshida4>, _, _>(&DoublePendulum, &w, double, [0.05, 1000.0]);
    let (w, top) = ([1.0 / 0.75, 1.0 / 0.75, 4.0].repeat(3), start(&all["lagrange_top"]));
    stays_on_manifold::<Rattle, _, _>(&Top, &w, top, [0.05, 2000.0]);
    let car = start(&all["car_axis"]);
    stays_on_manifold::<Rattle, _, _>(&CarAxis, &[2000.0; 4], car, [0.005, 2000.0]);
    let (linkage, start) = ring(9);
    stays_on_manifold::<Rattle, _, _>(&linkage, &[1.0; 27], start, [0.05, 500.0]);
    let (linkage, start) = chain(12);
    stays_on_manifold::<Rattle, _, _>(&linkage, &[1.0; 36], start, [0.02, 500.0]);
    for case in list(&data("linkages")).iter().filter(|case| case["scheme"] == "Rattle").step_by(6) {
        let (linkage, h) = (Linkage::of(case, []), 0.25 * number(&case["h"]));
        let w: Vec<f64> = linkage.mass.iter().flat_map(|mass| [mass.recip(); 3]).collect();
        stays_on_manifold::<Rattle, _, _>(&linkage, &w, linkages::start(case), [h, 100.0]);
    }
}

/// Three bodies on a line of rods, in the three ways to write their number.
macro_rules! line {
    ($name:ident [$($generics:tt)*] [$($arguments:tt)*], $list:ty, $n:expr) => {
        #[hamiltonian(
            drift = |q: $list, p: $list| (0..$n)
                .map(|i| 0.5 * (p[i][0] * p[i][0] + p[i][1] * p[i][1]) / (1.0 + i as f64) + q[i][1] * (1.0 + i as f64))
                .sum::<f64>(),
            constraint = [
                |q| 0.5 * (q[0][0] * q[0][0] + q[0][1] * q[0][1] - 1.0),
                [|q, k| 0.5 * ((q[k + 1][0] - q[k][0]).powi(2) + (q[k + 1][1] - q[k][1]).powi(2) - 1.0); $n - 1],
            ],
            embedding = Rattle,
        )]
        #[derive(Clone, Debug)]
        pub struct $name $($generics)* $($arguments)*
    };
}

line!(Literal [] [;], [[f64; 2]; 3], 3);
line!(Generic [<const N: usize>] [;], [[f64; 2]; N], N);
line!(Slice [] [{ n: usize }], &[[f64; 2]], self.n);

#[test]
fn straight_lines_and_loops_agree() {
    let (q, p) = ([1.0, 0.0, 1.0, -1.0, 1.6, -1.8], [0.0, 0.1, 0.2, 0.2, 0.3, 0.3]);
    fn end<H: Discretized<Rattle>>(system: &H, q: &[f64], p: &[f64]) -> Vec<f64> {
        let start = fixtures::extremes::state(q, p);
        let run = system.simulate::<Rattle>(0.02).start(start).project_start().steps(50).unwatched();
        fixtures::steps::numbers(run.run().unwrap().last())
    }
    let [literal, generic, slice] =
        [end(&Literal, &q, &p), end(&Generic::<3>, &q, &p), end(&Slice { n: 3 }, &q, &p)];
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Fifty steps, each with some roundings of numbers of order one.
    assert!(apart(&literal, &generic) < 1e-13 && apart(&literal, &slice) < 1e-13);
}

/// Sums of momenta and of angular momenta, to the roundings of random walks.
#[test]
fn momenta_of_symmetries_are_kept() {
    let (linkage, start) = ring(8);
    let (free, h) = (Linkage { trap: vec![0.0; 8], ..linkage }, 0.05);
    let momenta = |state: &State<DVector<f64>>| -> [f64; 6] {
        let mut sums = [0.0; 6];
        for i in 0..8 {
            let at = |list: &DVector<f64>| SVector::<f64, 3>::from_fn(|c, _| list[3 * i + c]);
            let (q, p) = (at(&state.q), at(&state.p));
            let turn = q.cross(&p);
            (0..3).for_each(|c| {
                sums[c] += p[c];
                sums[3 + c] += turn[c];
            });
        }
        sums
    };
    let path = free.simulate::<Rattle>(h).start(start).project_start().steps(2000).run().unwrap();
    let first = momenta(&path.states()[0]);
    for node in path.states() {
        for (found, first) in momenta(node).iter().zip(first) {
            // The square root of 2000 steps, times roundings of sums of order one; coordinates reach to 10.
            assert!((found - first).abs() < 1e-13, "{found} {first}");
        }
    }
}
