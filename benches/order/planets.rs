//! The outer solar system.

/// Masses, positions and momenta of the sun with the inner planets, Jupiter, Saturn, Uranus, Neptune and Pluto, in astronomical units, days and solar masses, seen
/// from the centre of mass: initial values of E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, section I.2.4.
pub(crate) fn outer() -> ([f64; 6], [f64; 18], [f64; 18]) {
    let mass = [
        1.000_005_976_82,
        0.000_954_786_104_043,
        0.000_285_583_733_151,
        0.000_043_727_316_454_6,
        0.000_051_775_913_844_9,
        1.0 / 1.3e8,
    ];
    let positions = [
        [0.0, 0.0, 0.0],
        [-3.502_365_3, -3.816_984_7, -1.550_796_3],
        [9.075_531_4, -3.045_835_3, -1.648_370_8],
        [8.310_142, -16.290_108_6, -7.252_127_8],
        [11.470_766_6, -25.729_482_9, -10.816_945_6],
        [-15.538_735_7, -25.222_559_4, -3.190_238_2],
    ];
    let velocities = [
        [0.0, 0.0, 0.0],
        [0.005_654_29, -0.004_124_9, -0.001_905_89],
        [0.001_683_18, 0.004_835_25, 0.001_924_62],
        [0.003_541_78, 0.001_371_02, 0.000_550_29],
        [0.002_889_3, 0.001_145_27, 0.000_396_77],
        [0.002_767_25, -0.001_707_02, -0.001_365_04],
    ];
    let total: f64 = mass.iter().sum();
    let centre = |of: &[[f64; 3]; 6], k: usize| (0..6).map(|i| mass[i] * of[i][k]).sum::<f64>() / total;
    let q: [f64; 18] = std::array::from_fn(|n| positions[n / 3][n % 3] - centre(&positions, n % 3));
    let p: [f64; 18] =
        std::array::from_fn(|n| mass[n / 3] * (velocities[n / 3][n % 3] - centre(&velocities, n % 3)));
    (mass, q, p)
}
