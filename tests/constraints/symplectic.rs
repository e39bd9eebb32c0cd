//! Steps keep the symplectic form of the manifold: of vectors that are tangent to it.

use fixtures::Uniform;
use fixtures::reference::{data, list};
use wzvi::nalgebra::{DMatrix, DVector};
use wzvi::prelude::*;
use wzvi::simulate::Simulation;
use wzvi::state::Vector;

use super::linkages::{self, DampedLinkage, Linkage};
use super::systems::{DoublePendulum, Sphere};

/// Rods of bodies with so many coordinates; one without a second body ends at the origin.
struct Rods<'a> {
    dimension: usize,
    rods: &'a [(usize, Option<usize>)],
    mass: Vec<f64>,
}

impl Rods<'_> {
    /// The derivatives of `g` and of `G W p` by coordinates and momenta: rows that vanish on tangent vectors.
    fn conditions<V: Vector>(&self, state: &State<V>) -> DMatrix<f64> {
        let (q, p) = (state.q.components(), state.p.components());
        let &Self { dimension, rods, ref mass } = self;
        let degrees = q.len();
        let mut rows = DMatrix::zeros(2 * rods.len(), 2 * degrees);
        for (k, &(a, b)) in rods.iter().enumerate() {
            for c in 0..dimension {
                let at = |list: &[f64], body: usize| list[dimension * body + c];
                let way = at(q, a) - b.map_or(0.0, |b| at(q, b));
                let speed = at(p, a) / mass[a] - b.map_or(0.0, |b| at(p, b) / mass[b]);
                for (body, sign) in [(Some(a), 1.0), (b, -1.0)] {
                    let Some(body) = body else { continue };
                    let i = dimension * body + c;
                    rows[(2 * k, i)] = sign * way;
                    rows[(2 * k + 1, i)] = sign * speed;
                    rows[(2 * k + 1, degrees + i)] = sign * way / mass[body];
                }
            }
        }
        rows
    }
}

fn form(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    let degrees = a.len() / 2;
    (0..degrees).map(|i| a[i] * b[degrees + i] - a[degrees + i] * b[i]).sum()
}

/// Tangent vectors at the start go to tangent vectors at the end, and the form of pairs of them is multiplied
/// by `factor`.
fn keeps_form<'a, H: Discretized<E> + 'a, E>(
    run: impl Fn() -> Simulation<'a, H, E>,
    rods: &Rods<'_>,
    factor: f64,
) {
    let start = run().steps(0).run().unwrap().last().clone();
    let tangent = run().steps(20).tangent().unwrap();
    let (before, after) = (rods.conditions(&start), rods.conditions(&tangent.end));
    let inverse = (&before * before.transpose()).try_inverse().unwrap();
    let mut random = Uniform(1);
    let vectors: Vec<DVector<f64>> = (0..4)
        .map(|_| {
            let v = DVector::from_fn(before.ncols(), |_, _| random.draw());
            &v - before.transpose() * (&inverse * (&before * &v))
        })
        .collect();
    let images: Vec<DVector<f64>> = vectors.iter().map(|v| &tangent.by_start * v).collect();
    // Roundings of products of twenty matrices, of the norm of the images.
    let largest = images.iter().map(|v| v.norm()).fold(1.0, f64::max);
    let bound = 1e-13 * largest * largest;
    for (v, image) in vectors.iter().zip(&images) {
        assert!((&after * image).amax() < bound, "{:e} {bound:e}", (&after * image).amax());
        for (w, other) in vectors.iter().zip(&images) {
            let apart = (form(image, other) - factor * form(v, w)).abs();
            assert!(apart < bound, "{apart:e} {bound:e}");
        }
    }
}

#[test]
fn steps_are_symplectic_on_the_manifold() {
    let sphere = Sphere { g: 1.0 };
    let of_sphere = Rods { dimension: 3, rods: &[(0, None)], mass: vec![1.0] };
    let start = || State::new([0.6, 0.0, 0.8], [0.0, 0.7, 0.0]);
    keeps_form(|| sphere.simulate::<Rattle>(0.1).start(start()), &of_sphere, 1.0);
    keeps_form(|| sphere.simulate::<Composed<Rattle, Yoshida4>>(0.1).start(start()), &of_sphere, 1.0);
    let of_double = Rods { dimension: 2, rods: &[(0, None), (1, Some(0))], mass: vec![1.0, 2.0] };
    let start = || State::new([1.0, 0.0, 1.0, -1.0], [0.0, 1.0 / 6.0, 0.5, 1.0 / 3.0]);
    keeps_form(|| DoublePendulum.simulate::<Rattle>(0.05).start(start()), &of_double, 1.0);
}

/// A sparse form of the matrices, too, and with friction the form falls with the momenta.
#[test]
fn steps_of_linkages_are_symplectic_and_conformal() {
    for case in list(&data("linkages")).iter().filter(|case| case["scheme"] == "Rattle").step_by(9) {
        let linkage = Linkage::of(case, []);
        let rods = linkage.rods.iter().map(|&[a, b]| (a, Some(b)));
        let rods: Vec<_> = rods.chain(linkage.pins.iter().map(|&a| (a, None))).collect();
        let rods = Rods { dimension: 3, rods: &rods, mass: linkage.mass.clone() };
        let (start, h) = (|| linkages::start(case), 0.25 * fixtures::reference::number(&case["h"]));
        keeps_form(|| linkage.simulate::<Rattle>(h).start(start()), &rods, 1.0);
        let damped = DampedLinkage::of(case, [0.3]);
        let factor = (-0.3 * 20.0 * h).exp();
        keeps_form(|| damped.simulate::<Rattle>(h).start(start()), &rods, factor);
    }
}
