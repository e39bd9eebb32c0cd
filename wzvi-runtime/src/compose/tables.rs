//! The tables of coefficients.
//!
//! The decimals are those of the published tables, polished until the order conditions hold to many more digits than `f64` has, and
//! rounded.

use super::{Partitioned, Weights};

/// Order 4 in 3 steps: H. Yoshida, "Construction of higher order symplectic integrators", Phys. Lett. A 150, 1990.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Yoshida4;

impl Weights for Yoshida4 {
    const ORDER: u32 = 4;
    const GAMMA: &'static [f64] = &[1.3512071919596575, -1.7024143839193153, 1.3512071919596575];
}

/// Order 4 in 5 steps: M. Suzuki, "Fractal decomposition of exponential operators", Phys. Lett. A 146, 1990.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Suzuki4;

impl Weights for Suzuki4 {
    const ORDER: u32 = 4;
    const GAMMA: &'static [f64] =
        &[0.4144907717943757, 0.4144907717943757, -0.657963087177503, 0.4144907717943757, 0.4144907717943757];
}

/// Order 6 in 7 steps: H. Yoshida, the paper of [`Yoshida4`], solution A.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Yoshida6;

impl Weights for Yoshida6 {
    const ORDER: u32 = 6;
    const GAMMA: &'static [f64] = &[
        0.7845136104775573,
        0.23557321335935813,
        -1.177679984178871,
        1.3151863206839112,
        -1.177679984178871,
        0.23557321335935813,
        0.7845136104775573,
    ];
}

/// Order 6 in 9 steps: W. Kahan and R.-C. Li, "Composition constants for raising the orders of unconventional schemes
/// for ordinary differential equations", Math. Comp. 66, 1997, s9odr6a.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KahanLi6;

impl Weights for KahanLi6 {
    const ORDER: u32 = 6;
    const GAMMA: &'static [f64] = &[
        0.3921614440073141,
        0.33259913678935943,
        -0.7062461725576393,
        0.0822135962935508,
        0.79854399093483,
        0.0822135962935508,
        -0.7062461725576393,
        0.33259913678935943,
        0.3921614440073141,
    ];
}

/// Order 8 in 15 steps: M. Suzuki and K. Umeno, in "Computer Simulation Studies in Condensed Matter Physics VI", 1993.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SuzukiUmeno8;

impl Weights for SuzukiUmeno8 {
    const ORDER: u32 = 8;
    const GAMMA: &'static [f64] = &[
        0.741670364350613,
        -0.4091008258000316,
        0.1907547102962384,
        -0.5738624711160822,
        0.2990641813036559,
        0.33462491824529816,
        0.3152930923967666,
        -0.7968879393529164,
        0.3152930923967666,
        0.33462491824529816,
        0.2990641813036559,
        -0.5738624711160822,
        0.1907547102962384,
        -0.4091008258000316,
        0.741670364350613,
    ];
}

/// Order 8 in 17 steps: W. Kahan and R.-C. Li, the paper of [`KahanLi6`], s17odr8a.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KahanLi8;

impl Weights for KahanLi8 {
    const ORDER: u32 = 8;
    const GAMMA: &'static [f64] = &[
        0.13020248308889007,
        0.5611629817751084,
        -0.38947496264484727,
        0.1588419065551556,
        -0.39590389413323757,
        0.1845396409783157,
        0.25837438768632204,
        0.2950117236093103,
        -0.6055085338300346,
        0.2950117236093103,
        0.25837438768632204,
        0.1845396409783157,
        -0.39590389413323757,
        0.1588419065551556,
        -0.38947496264484727,
        0.5611629817751084,
        0.13020248308889007,
    ];
}

/// Order 4 in 6 stages: S. Blanes and P. C. Moan, "Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nyström
/// methods", J. Comput. Appl. Math. 142, 2002, S6.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlanesMoan4;

impl Partitioned for BlanesMoan4 {
    const ORDER: u32 = 4;
    const STARTS_WITH_DRIFT: bool = true;
    const SEQUENCE: &'static [f64] = &[
        0.07920369643119568,
        0.20951510661336206,
        0.353172906049774,
        -0.14385177317981804,
        -0.04206508035771953,
        0.434336666566456,
        0.21937695575349964,
        0.434336666566456,
        -0.04206508035771953,
        -0.14385177317981804,
        0.353172906049774,
        0.20951510661336206,
        0.07920369643119568,
    ];
}

/// Order 6 in 10 stages: S. Blanes and P. C. Moan, the paper of [`BlanesMoan4`], S10.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlanesMoan6;

impl Partitioned for BlanesMoan6 {
    const ORDER: u32 = 6;
    const STARTS_WITH_DRIFT: bool = true;
    const SEQUENCE: &'static [f64] = &[
        0.05026276440039273,
        0.1488164479010433,
        0.4135143004283434,
        -0.13238586576778377,
        0.04507988979439812,
        0.06730760469218439,
        -0.18805485381956855,
        0.43266640257817374,
        0.54196067845078,
        -0.016404589403617633,
        -0.7255255585086914,
        -0.016404589403617633,
        0.54196067845078,
        0.43266640257817374,
        -0.18805485381956855,
        0.06730760469218439,
        0.04507988979439812,
        -0.13238586576778377,
        0.4135143004283434,
        0.1488164479010433,
        0.05026276440039273,
    ];
}
