//! Random linkages: trees and rings with chords, planar and spatial, some with a fixed point.

use fixtures::reference::{data, list, number, numbers, text};
use serde_json::Value;
use wzvi::nalgebra::DVector;
use wzvi::prelude::*;

/// Bodies with rods between them, and pins from bodies to the origin.
macro_rules! linkage {
    ($name:ident { $($field:ident),* }, $($key:ident = $value:ident),*) => {
        #[hamiltonian(
            drift = |q: &[[f64; 3]], p: &[[f64; 3]]| (0..q.len())
                .map(|i| {
                    let kinetic: f64 = (0..3).map(|c| 0.5 * p[i][c] * p[i][c] / self.mass[i]).sum();
                    let weight: f64 = (0..3).map(|c| self.mass[i] * self.gravity[c] * q[i][c]).sum();
                    let square = q[i][0] * q[i][0] + q[i][1] * q[i][1] + q[i][2] * q[i][2];
                    kinetic + weight + 0.25 * self.trap[i] * square * square
                })
                .sum::<f64>(),
            constraint = [
                [|q, k| {
                    let [a, b] = self.rods[k];
                    let square: f64 = (0..3).map(|c| (q[a][c] - q[b][c]) * (q[a][c] - q[b][c])).sum();
                    0.5 * (square - self.length[k] * self.length[k])
                }; self.rods.len()],
                [|q, k| {
                    let square: f64 = (0..3).map(|c| q[self.pins[k]][c] * q[self.pins[k]][c]).sum();
                    0.5 * (square - self.arm[k] * self.arm[k])
                }; self.pins.len()],
            ],
            $($key = $value),*
        )]
        #[derive(Clone, Debug)]
        pub struct $name {
            pub mass: Vec<f64>,
            pub gravity: [f64; 3],
            pub trap: Vec<f64>,
            pub rods: Vec<[usize; 2]>,
            pub length: Vec<f64>,
            pub pins: Vec<usize>,
            pub arm: Vec<f64>,
            $(pub $field: f64),*
        }

        impl $name {
            pub fn of(case: &Value, [$($field),*]: [f64; linkage!(@count $($field)*)]) -> Self {
                let places = |value: &Value| numbers(value).iter().map(|&place| place as usize).collect::<Vec<_>>();
                let gravity = numbers(&case["gravity"]);
                Self {
                    mass: numbers(&case["mass"]),
                    gravity: [gravity[0], gravity[1], gravity[2]],
                    trap: numbers(&case["trap"]),
                    rods: list(&case["rods"]).iter().map(|rod| [places(rod)[0], places(rod)[1]]).collect(),
                    length: numbers(&case["length"]),
                    pins: places(&case["pins"]),
                    arm: numbers(&case["arm"]),
                    $($field),*
                }
            }
        }
    };
    (@count) => { 0 };
    (@count $first:ident $($rest:ident)*) => { 1 + linkage!(@count $($rest)*) };
}

linkage!(Linkage {}, embedding = Rattle);
linkage!(DampedLinkage { gamma }, friction = gamma, embedding = Rattle);
linkage!(WarmLinkage { gamma, kt }, friction = gamma, temperature = kt, embedding = GBaoab);

pub fn start(case: &Value) -> State<DVector<f64>> {
    State::new(DVector::from_vec(numbers(&case["q0"])), DVector::from_vec(numbers(&case["p0"])))
}

/// The largest difference relative to the bound of the test.
fn apart<E, H: Discretized<E, Vector = DVector<f64>>>(system: &H, case: &Value) -> f64 {
    let (h, mut state) = (number(&case["h"]), start(case));
    let normals = case.get("normals").map(numbers).unwrap_or_default();
    let dw: Vec<f64> = normals.iter().map(|normal| h.sqrt() * normal).collect();
    system.stepper::<E>(h).unwrap().step(&mut state, &dw).unwrap();
    let (q, p) = (numbers(&case["q1"]), numbers(&case["p1"]));
    let largest = |numbers: &[f64]| numbers.iter().fold(0.0_f64, |most, number| most.max(number.abs()));
    // Roundings of the coordinates and of the largest momentum, magnified by the solutions.
    let rounding = f64::EPSILON * number(&case["condition"]);
    let [of_q, of_p] = [rounding * largest(&q), rounding * largest(&p)];
    let pairs = |found: &[f64], exact: &[f64], bound: f64| {
        let apart = found.iter().zip(exact).map(|(found, exact)| (found - exact).abs() / bound);
        apart.fold(0.0, f64::max)
    };
    // A plane stays a plane, to the bit.
    if q.iter().skip(2).step_by(3).all(|z| *z == 0.0) {
        assert!(state.q.iter().skip(2).step_by(3).all(|z| *z == 0.0));
    }
    pairs(state.q.as_slice(), &q, of_q).max(pairs(state.p.as_slice(), &p, of_p))
}

/// A hundred linkages, with masses over four orders: a step of each against 40 digits.
#[test]
fn steps_of_random_linkages_are_those_of_the_references() {
    let cases = data("linkages");
    assert_eq!(list(&cases).len(), 100);
    for (i, case) in list(&cases).iter().enumerate() {
        let apart = match text(&case["scheme"]) {
            "Rattle" => apart::<Rattle, _>(&Linkage::of(case, []), case),
            "Rattle4" => apart::<Composed<Rattle, Yoshida4>, _>(&Linkage::of(case, []), case),
            _ => {
                let bath = [number(&case["friction"]), number(&case["kT"])];
                apart::<GBaoab, _>(&WarmLinkage::of(case, bath), case)
            }
        };
        assert!(apart < 4.0, "linkage {i}: {apart}");
    }
}
