//! The tables of coefficients.
//!
//! The decimals are those of the published tables, refined until the order conditions hold to many more
//! digits than `f64` has, and then rounded.

use super::{Partitioned, Weights};

/// The palindrome of `N` numbers that begins with `half`, up to its middle.
const fn mirrored<const H: usize, const N: usize>(half: [f64; H]) -> [f64; N] {
    assert!(N + 1 == 2 * H);
    let (mut all, mut at) = ([0.0; N], 0);
    while at < N {
        all[at] = half[if at < H { at } else { N - 1 - at }];
        at += 1;
    }
    all
}

/// Order 4 in 3 steps: H. Yoshida, "Construction of higher order symplectic integrators", Phys. Lett. A
/// 150, 1990.
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
    const GAMMA: &'static [f64] =
        &mirrored::<_, 7>([0.7845136104775573, 0.23557321335935813, -1.177679984178871, 1.3151863206839112]);
}

/// Order 6 in 9 steps: W. Kahan and R.-C. Li, "Composition constants for raising the orders of unconventional
/// schemes for ordinary differential equations", Math. Comp. 66, 1997, s9odr6a.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KahanLi6;

impl Weights for KahanLi6 {
    const ORDER: u32 = 6;
    const GAMMA: &'static [f64] = &mirrored::<_, 9>([
        0.3921614440073141,
        0.33259913678935943,
        -0.7062461725576393,
        0.0822135962935508,
        0.79854399093483,
    ]);
}

/// Order 8 in 15 steps: M. Suzuki and K. Umeno, in "Computer Simulation Studies in Condensed Matter Physics
/// VI", 1993.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SuzukiUmeno8;

impl Weights for SuzukiUmeno8 {
    const ORDER: u32 = 8;
    const GAMMA: &'static [f64] = &mirrored::<_, 15>([
        0.741670364350613,
        -0.4091008258000316,
        0.1907547102962384,
        -0.5738624711160822,
        0.2990641813036559,
        0.33462491824529816,
        0.3152930923967666,
        -0.7968879393529164,
    ]);
}

/// Order 8 in 17 steps: W. Kahan and R.-C. Li, the paper of [`KahanLi6`], s17odr8a.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KahanLi8;

impl Weights for KahanLi8 {
    const ORDER: u32 = 8;
    const GAMMA: &'static [f64] = &mirrored::<_, 17>([
        0.13020248308889007,
        0.5611629817751084,
        -0.38947496264484727,
        0.1588419065551556,
        -0.39590389413323757,
        0.1845396409783157,
        0.25837438768632204,
        0.2950117236093103,
        -0.6055085338300346,
    ]);
}

/// Order 4 in 6 stages: S. Blanes and P. C. Moan, "Practical symplectic partitioned Runge-Kutta and
/// Runge-Kutta-Nyström methods", J. Comput. Appl. Math. 142, 2002, S6.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlanesMoan4;

impl Partitioned for BlanesMoan4 {
    const ORDER: u32 = 4;
    const STARTS_WITH_DRIFT: bool = true;
    const SEQUENCE: &'static [f64] = &mirrored::<_, 13>([
        0.07920369643119568,
        0.20951510661336206,
        0.353172906049774,
        -0.14385177317981804,
        -0.04206508035771953,
        0.434336666566456,
        0.21937695575349964,
    ]);
}

/// Order 6 in 10 stages: S. Blanes and P. C. Moan, the paper of [`BlanesMoan4`], S10.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlanesMoan6;

impl Partitioned for BlanesMoan6 {
    const ORDER: u32 = 6;
    const STARTS_WITH_DRIFT: bool = true;
    const SEQUENCE: &'static [f64] = &mirrored::<_, 21>([
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
    ]);
}

/// Order 6 in 14 stages, for `T(p) + V(q, t)` with a quadratic `T`: S. Blanes and P. C. Moan, the paper of
/// [`BlanesMoan4`], SRKN 14a.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Srkn6;

impl Partitioned for Srkn6 {
    const ORDER: u32 = 6;
    const STARTS_WITH_DRIFT: bool = true;
    const SEQUENCE: &'static [f64] = &mirrored::<_, 29>([
        0.037859319840611035,
        0.0917191526244622,
        0.1026356331024366,
        0.1839831700050049,
        -0.025867888266558343,
        -0.05653436583288919,
        0.3142414030714464,
        0.004914688774711812,
        -0.1301444595174152,
        0.14376112716836184,
        0.10641770036954182,
        0.32856769374680345,
        -0.008794243128510173,
        -0.196411466486455,
        0.20730506905689572,
    ]);
}

/// Order 4 in 7 stages, with errors `ε h^8 + ε² h^6 + ε³ h^4` where the Hamiltonian is `H_A + ε H_B`, and
/// `drift = [H_A, H_B]`: S. Blanes, F. Casas, A. Farrés, J. Laskar, J. Makazaga, A. Murua, "New families of
/// symplectic splitting methods for numerical integration in dynamical astronomy", Appl. Numer. Math.
/// 68, 2013.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Aba864;

impl Partitioned for Aba864 {
    const ORDER: u32 = 4;
    const STARTS_WITH_DRIFT: bool = true;
    const SEQUENCE: &'static [f64] = &mirrored::<_, 15>([
        0.07113342649822312,
        0.18308368747219722,
        0.2411534279566401,
        0.31078285989857485,
        0.5214117617728148,
        -0.0265646185119588,
        -0.333698616227678,
        0.06539614228237342,
    ]);
}

/// Order 4 in 8 stages, with errors `ε h^10 + ε² h^6 + ε³ h^4`, otherwise as [`Aba864`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Aba1064;

impl Partitioned for Aba1064 {
    const ORDER: u32 = 4;
    const STARTS_WITH_DRIFT: bool = true;
    const SEQUENCE: &'static [f64] = &mirrored::<_, 17>([
        0.038094497422412193,
        0.09585888083707521,
        0.14529871611691375,
        0.20444615314299877,
        0.20762769572554124,
        0.2170703479789911,
        0.43590970365152615,
        -0.017375381959065093,
        -0.6538612258327867,
    ]);
}

/// Order 4 with three forces, one of them with its derivative along the force, and no step backwards, for
/// `T(p) + V(q, t)` with a quadratic `T`: S. A. Chin, "Symplectic integrators from composite operator
/// factorizations", Phys. Lett. A 226, 1997, algorithm A. The kick in the middle is by
/// `2/3 (V - h²/48 |V'|²)`, with the square in the metric of the inverse masses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chin4;

impl Partitioned for Chin4 {
    const ORDER: u32 = 4;
    const STARTS_WITH_DRIFT: bool = false;
    const SEQUENCE: &'static [f64] = &[1.0 / 6.0, 0.5, 2.0 / 3.0, 0.5, 1.0 / 6.0];
}

impl Chin4 {
    /// The factors of the square of the force, one for each drift and kick.
    pub(super) const GRADIENT: &'static [f64] = &[0.0, 0.0, 1.0 / 72.0, 0.0, 0.0];
    /// The remark in `EQUATIONS`.
    pub(super) const NOTE: &'static str = " (the second kick by V - h²/48 V'·M⁻¹V')";
}

/// One kick, by `V - h²/24 |V'|²`, for `T(p) + V(q, t)` with a quadratic `T`: of order 2 and of effective
/// order 4, that is, conjugate to a scheme of order 4 by a map near the identity. Frequencies, rotation
/// numbers, Poincaré sections and averages of long runs have errors `O(h⁴)`; states have errors `O(h²)` that
/// do not grow. M. Takahashi and M. Imada, "Monte Carlo calculation of quantum systems. II", J. Phys. Soc.
/// Japan 53, 1984; G. Rowlands, "A numerical algorithm for Hamiltonian systems", J. Comput. Phys. 97, 1991.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TakahashiImada4;

impl Partitioned for TakahashiImada4 {
    const ORDER: u32 = 2;
    const STARTS_WITH_DRIFT: bool = true;
    const SEQUENCE: &'static [f64] = &[0.5, 1.0, 0.5];
}

impl TakahashiImada4 {
    /// The factors of the square of the force, one for each drift and kick.
    pub(super) const GRADIENT: &'static [f64] = &[0.0, 1.0 / 24.0, 0.0];
    /// The remark in `EQUATIONS`.
    pub(super) const NOTE: &'static str = " (the kick by V - h²/24 V'·M⁻¹V')";
}
