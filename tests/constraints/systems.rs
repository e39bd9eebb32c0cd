//! Systems of several tests.

use wzvi::prelude::*;

/// A point on the unit sphere in the field `g`.
#[hamiltonian(
    drift = |[x, y, z], [px, py, pz]| 0.5 * (px * px + py * py + pz * pz) + g * z,
    constraint = [|[x, y, z]| 0.5 * (x * x + y * y + z * z - 1.0)],
    embedding = Rattle,
    invariant = [|[x, y, _], [px, py, _]| x * py - y * px],
)]
#[derive(Clone, Debug)]
pub struct Sphere {
    pub g: f64,
}

/// The sphere in a bath.
#[hamiltonian(
    drift = |[x, y, z], [px, py, pz]| 0.5 * (px * px + py * py + pz * pz) + z,
    constraint = [|[x, y, z]| 0.5 * (x * x + y * y + z * z - 1.0)],
    friction = gamma,
    temperature = kt,
    embedding = GBaoab,
)]
#[derive(Clone, Debug)]
pub struct WarmSphere {
    pub gamma: f64,
    pub kt: f64,
}

/// Two rods of length 1 with masses 1 and 2 at their ends.
#[hamiltonian(
    drift = |[x1, y1, x2, y2], [px1, py1, px2, py2]|
        0.5 * (px1 * px1 + py1 * py1) + 0.25 * (px2 * px2 + py2 * py2) + y1 + 2.0 * y2,
    constraint = [
        |[x1, y1, _, _]| 0.5 * (x1 * x1 + y1 * y1 - 1.0),
        |[x1, y1, x2, y2]| 0.5 * ((x2 - x1).powi(2) + (y2 - y1).powi(2) - 1.0),
    ],
    embedding = Rattle,
)]
#[derive(Clone, Debug)]
pub struct DoublePendulum;

/// Lagrange's top: two moments are equal, and the weight is on the axis of the third.
#[hamiltonian(
    drift = |q: Rotation, p| (0..3)
        .map(|i| 0.5 * (p[i][0] * p[i][0] / 0.75 + p[i][1] * p[i][1] / 0.75 + p[i][2] * p[i][2] / 0.25))
        .sum::<f64>()
        + 2.0 * q[2][2],
    embedding = Rattle,
    // The vertical angular momentum in space, and that along the axis of the body.
    invariant = [
        |q, p| (0..3).map(|j| q[0][j] * p[1][j] - q[1][j] * p[0][j]).sum::<f64>(),
        |q, p| (0..3).map(|i| q[i][0] * p[i][1] - q[i][1] * p[i][0]).sum::<f64>(),
    ],
)]
#[derive(Clone, Debug)]
pub struct Top;

/// The car axis of the IVP test set: springs between an axle and a road that moves.
#[hamiltonian(
    drift = |[xl, yl, xr, yr], [pxl, pyl, pxr, pyr], t| {
        let yb = 0.1 * (10.0 * t).sin();
        let xb = (1.0 - yb * yb).sqrt();
        let left = (xl * xl + yl * yl).sqrt() - 0.5;
        let right = ((xr - xb).powi(2) + (yr - yb).powi(2)).sqrt() - 0.5;
        (pxl * pxl + pyl * pyl + pxr * pxr + pyr * pyr) / (2.0 * M)
            + 0.5 * (left * left + right * right) + M * (yl + yr)
    },
    constraint = [
        |[xl, yl, _, _], t| {
            let yb = 0.1 * (10.0 * t).sin();
            xl * (1.0 - yb * yb).sqrt() + yl * yb
        },
        |[xl, yl, xr, yr]| (xl - xr).powi(2) + (yl - yr).powi(2) - 1.0,
    ],
    embedding = Rattle,
)]
#[derive(Clone, Debug)]
pub struct CarAxis;

/// `ε² m / 2` of the test set.
const M: f64 = 5e-4;

/// A point on the sphere with a mass that depends on where it is, in a random rotation about the vertical.
#[hamiltonian(
    drift = |[x, y, z], [px, py, pz]| 0.5 * (px * px + py * py + pz * pz) / (1.0 + 0.3 * z * z) + z,
    noise = [|[x, y, _], [px, py, _]| sigma * (x * py - y * px)],
    constraint = [|[x, y, z]| 0.5 * (x * x + y * y + z * z - 1.0)],
    embedding = Rattle,
    invariant = [|[x, y, _], [px, py, _]| x * py - y * px],
)]
#[derive(Clone, Debug)]
pub struct Turned {
    pub sigma: f64,
}

/// The sphere of [`Sphere`], with a term that no step takes for squares of the momenta and that vanishes.
#[hamiltonian(
    drift = |[x, y, z], [px, py, pz]| 0.5 * (px * px + py * py + pz * pz) + g * z
        + nothing * px * px * x * x,
    constraint = [|[x, y, z]| 0.5 * (x * x + y * y + z * z - 1.0)],
    embedding = Rattle,
)]
#[derive(Clone, Debug)]
pub struct GeneralSphere {
    pub g: f64,
    pub nothing: f64,
}

/// The moving road of [`CarAxis`] with masses that do not couple but read coordinates, by nothing.
#[hamiltonian(
    drift = |[xl, yl, xr, yr], [pxl, pyl, pxr, pyr], t| {
        let yb = 0.1 * (10.0 * t).sin();
        let xb = (1.0 - yb * yb).sqrt();
        let left = (xl * xl + yl * yl).sqrt() - 0.5;
        let right = ((xr - xb).powi(2) + (yr - yb).powi(2)).sqrt() - 0.5;
        (pxl * pxl + pyl * pyl + pxr * pxr + pyr * pyr) / (2.0 * M)
            + 0.5 * (left * left + right * right) + M * (yl + yr) + nothing * pxl * xl
    },
    constraint = [
        |[xl, yl, _, _], t| {
            let yb = 0.1 * (10.0 * t).sin();
            xl * (1.0 - yb * yb).sqrt() + yl * yb
        },
        |[xl, yl, xr, yr]| (xl - xr).powi(2) + (yl - yr).powi(2) - 1.0,
    ],
    embedding = Rattle,
)]
#[derive(Clone, Debug)]
pub struct GeneralAxis {
    pub nothing: f64,
}
