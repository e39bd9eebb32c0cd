// Written by generate.rs: do not edit.

macro_rules! random_systems {
    ($($arguments:tt)*) => {
#[hamiltonian(
    drift = |x, u, t| 0.5 * u * u + 0.5 * x * x + 0.3 * (0.5 * (0.5 * ((a * t) / (1.5 + x * x)).sin()).asin().sin()).tan() + 0.3 * (1.5 + (t / (1.5 + u * u)).atan2(2.0 + (t - 0.75_f64).cos()).sin()).ln(),
    noise = [
        |x, u, t| 0.3 * ((x * u) + u.atan()),
    ],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Random00 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * ((y.abs().powi(3).atan() * (0.125 - a * (1.0 + x * x).sqrt()).min(0.0).powi(3)) / (1.5 + (2.0 + (b + u).sin()).atan2((if x < b { (x - 0.5_f64) } else { (x - 0.5_f64) + (x - b).powi(3) })) * (2.0 + (b + u).sin()).atan2((if x < b { (x - 0.5_f64) } else { (x - 0.5_f64) + (x - b).powi(3) })))) + 0.3 * (1.0 + (if x < b { x } else { x + (x - b).powi(3) }) * (if x < b { x } else { x + (x - b).powi(3) })).sqrt().sin().hypot(1.0 + x * x),
    embedding = [Midpoint, Corrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Random01 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * ((((b + u) * v) * (((b + w) - (a * x)) - 0.25).max(0.0).powi(3)) / (1.5 + (1.0 + (z - 1.25_f64).sin().hypot(1.0 + v * v) * (z - 1.25_f64).sin().hypot(1.0 + v * v)).sqrt() * (1.0 + (z - 1.25_f64).sin().hypot(1.0 + v * v) * (z - 1.25_f64).sin().hypot(1.0 + v * v)).sqrt())) + 0.3 * (((if (b + u) < b { (a * x) } else { (a * x) + ((b + u) - b).powi(3) }) * (y / (1.5 + (z - 0.5_f64) * (z - 0.5_f64)))) * (((a * z).tanh() * (u / (1.5 + u * u))) - 0.25).max(0.0).powi(3)),
    noise = [
        |[x, y, z], [u, v, w]| 0.3 * ((if (x - 0.5_f64) < b { (b + u) } else { (b + u) + ((x - 0.5_f64) - b).powi(3) }) * ((b + v) * ((b + u) - 0.25).max(0.0).powi(3))),
    ],
    embedding = [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>],
    $($arguments)*
)]
pub(crate) struct Random02 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u, t| 0.5 * u * u + 0.5 * x * x + 0.3 * (2.0 + ((1.0 + (b + x) * (b + x)).powf(-0.75) + x.cos()).sin()).powf((x - 0.5_f64).tanh()) + 0.3 * (((t * (u - 0.5_f64)) + (0.5 * (b + t).cos()).exp_m1()) * (0.5 * ((t - 0.5_f64) - (b + u)).sin()).tan()),
    noise = [
        |x, u, t| 0.3 * ({ let s2 = ((a * u) * (0.125 - a * t).min(0.0).powi(3)); if s2 > 0.25 { (0.5 * (x - 1.25_f64).cos()).exp_m1() * (s2 - 0.25).powi(3) } else { 0.0 } }),
    ],
    embedding = [Midpoint, Uncorrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Random03 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * (((a * x).atan() * (x * v)) * ((2.0 + (x - 0.75_f64).sin()).powf((a * x).tanh()) * (if (a * v) < b { v } else { v + ((a * v) - b).powi(3) }))) + 0.3 * (y + (a * x)).sin().exp2().sin().sinh(),
    noise = [
        |[x, y], [u, v]| 0.3 * ((x - x) * (0.5 * y.sin()).asin()),
    ],
    embedding = [Midpoint, Corrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Random04 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w], t| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * ({ let s1 = (0.5 * ((b + x) - y) * ((b + x) - y)).ln_1p(); if s1 > 0.25 { ((0.5 * (a * u).tanh()).acos() / (1.5 + (u - 1.25_f64).atan2(2.0 + (y - 1.25_f64).cos()) * (u - 1.25_f64).atan2(2.0 + (y - 1.25_f64).cos()))) * (s1 - 0.25).powi(3) } else { 0.0 } }) + 0.3 * ((1.0 + x.tanh().cosh() * x.tanh().cosh()).log10() * (if (0.5 * x.cos()).exp_m1() < b { (0.5 * (a * x).sin()).tan() } else { (0.5 * (a * x).sin()).tan() + ((0.5 * x.cos()).exp_m1() - b).powi(3) })),
    noise = [
        |[x, y, z], [u, v, w], t| 0.3 * ((w * z) + ((b + w) * (b + w))),
    ],
    embedding = [Midpoint, Mixed<DeltaPlus, Midpoint>],
    $($arguments)*
)]
pub(crate) struct Random05 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u| 0.5 * u * u + 0.5 * x * x + 0.3 * (((u * x) + x.asinh()) - (x - (b + u)).tanh().exp()) + 0.3 * (u + (a * x)).cos().cos(),
    noise = [
        |x, u| 0.3 * ((0.5 * x.sin()).atanh() - ((x - 0.75_f64) - (a * u))),
    ],
    embedding = [Midpoint, Uncorrected<Lambda<2, 3>>],
    $($arguments)*
)]
pub(crate) struct Random06 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v], t| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * ((1.5 + (a * t).sin()).ln().abs().powi(3).atan() * (1.5 + (0.5 * (a * y).tanh()).acos().sin()).ln()) + 0.3 * (1.0 + (0.5 * (t * (a * u)).tanh()).acos() * (0.5 * (t * (a * u)).tanh()).acos()).powi(-2),
    embedding = [Midpoint, Corrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Random07 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * (((2.0 + x.sin()).recip() - y.cos()) / (1.5 + z.sin().powi(3).tanh() * z.sin().powi(3).tanh())) + 0.3 * (((v * (a * w)) + (1.0 + x * x).log10()) / (1.5 + (0.5 * (v * x).tanh()).acos() * (0.5 * (v * x).tanh()).acos())),
    noise = [
        |[x, y, z], [u, v, w]| 0.3 * (2.0 + (y - (b + u)).sin()).cbrt(),
        |[x, y, z], [u, v, w]| 0.3 * (0.5 * (a * v).tanh().cosh().sin()).asin(),
    ],
    embedding = [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>],
    $($arguments)*
)]
pub(crate) struct Random08 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u, t| 0.5 * u * u + 0.5 * x * x + 0.3 * ((0.5 * ((x - 0.75_f64) - x).sin()).asin() - (2.0 + (x / (1.5 + u * u)).sin()).cbrt()) + 0.3 * (if (1.0 + u * u).powf(-0.75).asinh() < b { ((b + t).sin().mul_add((a * t), b) - ((x - 1.25_f64) / (1.5 + (b + u) * (b + u)))) } else { ((b + t).sin().mul_add((a * t), b) - ((x - 1.25_f64) / (1.5 + (b + u) * (b + u)))) + ((1.0 + u * u).powf(-0.75).asinh() - b).powi(3) }),
    noise = [
        |x, u, t| 0.3 * (1.5 + (2.0 + (b + t).sin()).powf(t.tanh()).sin()).ln(),
        |x, u, t| 0.3 * (1.0 + ((a * x) - (a * x)) * ((a * x) - (a * x))).powf(-0.75),
    ],
    embedding = [Midpoint, Uncorrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Random09 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v], t| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * ((1.0 + (u - 0.75_f64) * (u - 0.75_f64)).log10().sin().powi(3) * (t + (t - 0.75_f64)).sin().hypot(1.0 + (t - 0.75_f64) * (t - 0.75_f64))) + 0.3 * ((v * (t - 0.5_f64)) - (if x < b { (b + y) } else { (b + y) + (x - b).powi(3) })).tanh().cosh(),
    noise = [
        |[x, y], [u, v], t| 0.3 * (((x - 0.75_f64) * y) + ((u - 1.25_f64) * x)),
        |[x, y], [u, v], t| 0.3 * (1.0 + ((y - 1.25_f64) * (b + y)) * ((y - 1.25_f64) * (b + y))).powi(-2),
    ],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Random10 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * (1.0 + (b + y) * (b + y)).powi(-2).sin().powi(3).asinh() + 0.3 * (if ((0.5 * w.cos()).exp_m1() * (0.125 - a * ((w - 1.25_f64) * (v - 0.25).max(0.0).powi(3))).min(0.0).powi(3)) < b { (((a * u) * (v - 0.75_f64)) + ((b + v) - (a * w))) } else { (((a * u) * (v - 0.75_f64)) + ((b + v) - (a * w))) + (((0.5 * w.cos()).exp_m1() * (0.125 - a * ((w - 1.25_f64) * (v - 0.25).max(0.0).powi(3))).min(0.0).powi(3)) - b).powi(3) }),
    embedding = [Midpoint, Corrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Random11 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u| 0.5 * u * u + 0.5 * x * x + 0.3 * (2.0 + (b + u).sin()).atan2((u + u).sin().exp2()) + 0.3 * (0.5 * ((x * (0.125 - a * x).min(0.0).powi(3)) + (0.5 * u * u).ln_1p()).tanh()).acos(),
    noise = [
        |x, u| 0.3 * ((x / (1.5 + u * u)) * ((x - 0.75_f64) + u)),
        |x, u| 0.3 * ((2.0 + (a * x).sin()).recip() / (1.5 + ((a * x) * (a * x)) * ((a * x) * (a * x)))),
        |x, u| 0.3 * ((if u < b { (b + u) } else { (b + u) + (u - b).powi(3) }) / (1.5 + ((u - 0.5_f64) + x) * ((u - 0.5_f64) + x))),
    ],
    embedding = [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>],
    $($arguments)*
)]
pub(crate) struct Random12 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v], t| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * ((t - 0.5_f64).tanh().sin().sinh() - ((x - 0.5_f64) * t).hypot(1.5)) + 0.3 * (((t + (t - 0.5_f64)) * (v * (b + y))) * (((x * u) * ((x - 0.75_f64) * (t - 1.25_f64))) - 0.25).max(0.0).powi(3)),
    noise = [
        |[x, y], [u, v], t| 0.3 * ((x - 0.75_f64).tanh() * (0.125 - a * y.abs().powi(3).atan()).min(0.0).powi(3)),
        |[x, y], [u, v], t| 0.3 * ((t * x) - ((b + v) * (0.125 - a * y).min(0.0).powi(3))),
    ],
    embedding = [Midpoint, Uncorrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Random13 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * ((({ let s1 = y; if s1 > 0.25 { (u - 1.25_f64) * (s1 - 0.25).powi(3) } else { 0.0 } }) - (0.5 * (x - 1.25_f64).cos()).exp_m1()) * (b + u).atan().tanh().cosh()) + 0.3 * ((if (x / (1.5 + w * w)) < b { ((b + v) * u) } else { ((b + v) * u) + ((x / (1.5 + w * w)) - b).powi(3) }) - (1.0 + u * u).log10().sin().mul_add((b + y), b)),
    noise = [
        |[x, y, z], [u, v, w]| 0.3 * ((x - 1.25_f64).sin().sinh() * ((x - 1.25_f64) * (0.125 - a * (a * z)).min(0.0).powi(3))),
        |[x, y, z], [u, v, w]| 0.3 * (2.5 + (y * v).cos()).acosh(),
    ],
    embedding = [Midpoint, Corrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Random14 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u| 0.5 * u * u + 0.5 * x * x + 0.3 * ({ let s2 = (if ((x - 0.5_f64) + x) < b { (x + (a * x)) } else { (x + (a * x)) + (((x - 0.5_f64) + x) - b).powi(3) }); if s2 > 0.25 { (0.5 * (x - x).cos()).exp_m1() * (s2 - 0.25).powi(3) } else { 0.0 } }) + 0.3 * ((((u - 0.5_f64) + u) * u.abs().powi(3).atan()) * (0.5 * u.cos()).exp_m1().sin().sinh()),
    noise = [
        |x, u| 0.3 * ({ let s3 = (1.0 + (b + u) * (b + u)).log10(); if s3 > 0.25 { (0.5 * u.sin()).asin() * (s3 - 0.25).powi(3) } else { 0.0 } }),
        |x, u| 0.3 * ((2.5 + (a * u).cos()).acosh() * ((a * x) * (b + x))),
    ],
    embedding = [Midpoint, Mixed<DeltaPlus, Midpoint>],
    $($arguments)*
)]
pub(crate) struct Random15 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * (0.5 * ({ let s1 = y; if s1 > 0.25 { v * (s1 - 0.25).powi(3) } else { 0.0 } }).cos()).exp_m1().atan2(2.0 + (v - 0.5_f64).cos()) + 0.3 * ((2.0 + ((a * y) * (v - 1.25_f64)).sin()).cbrt() * (((b + y) / (1.5 + u * u)) + (if u < b { (y - 0.75_f64) } else { (y - 0.75_f64) + (u - b).powi(3) }))),
    noise = [
        |[x, y], [u, v]| 0.3 * ({ let s3 = (x - 0.75_f64); if s3 > 0.25 { (a * v) * (s3 - 0.25).powi(3) } else { 0.0 } }).sin().hypot(1.0 + x * x),
        |[x, y], [u, v]| 0.3 * (a * y).asinh().tanh().cosh(),
        |[x, y], [u, v]| 0.3 * ({ let s5 = ((a * u) * ((b + x) - 0.25).max(0.0).powi(3)); if s5 > 0.25 { (1.5 + (b + x).sin()).ln() * (s5 - 0.25).powi(3) } else { 0.0 } }),
    ],
    embedding = [Midpoint, Uncorrected<Lambda<2, 3>>],
    $($arguments)*
)]
pub(crate) struct Random16 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * ((2.5 + (b + z).asinh().cos()).acosh() - ((z - 1.25_f64).sin().hypot(1.0 + (x - 0.5_f64) * (x - 0.5_f64)) * (2.0 + (z - 0.75_f64).sin()).cbrt())) + 0.3 * (((y - 1.25_f64) / (1.5 + (b + x) * (b + x))).sin().hypot(1.0 + v * v) + ((z - 1.25_f64) * (v - 0.75_f64)).tanh().exp()),
    noise = [
        |[x, y, z], [u, v, w]| 0.3 * (2.0 + (a * w).sin().exp2().cos()).log2(),
        |[x, y, z], [u, v, w]| 0.3 * ((w * (a * y)) * ((x - 0.75_f64) * v)),
        |[x, y, z], [u, v, w]| 0.3 * (w.sin().powi(3) - ({ let (s, c) = x.sin_cos(); s * c + a * s })),
    ],
    embedding = [Midpoint, Corrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Random17 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u, t| 0.5 * u * u + 0.5 * x * x + 0.3 * ((2.0 + x.cos()).log2() * ((u - 1.25_f64) * (a * u))).hypot(1.5) + 0.3 * ({ let s1 = (0.5 * (x * (a * u)).sin()).asin(); if s1 > 0.25 { (u.asinh() - (1.0 + u * u).powf(-0.75)) * (s1 - 0.25).powi(3) } else { 0.0 } }),
    noise = [
        |x, u, t| 0.3 * ((t * u) * (a * u).atan()),
        |x, u, t| 0.3 * (2.5 + ((a * u) * (0.125 - a * (a * x)).min(0.0).powi(3)).cos()).acosh(),
        |x, u, t| 0.3 * (((b + x) - (a * x)) / (1.5 + (2.0 + u.cos()).log2() * (2.0 + u.cos()).log2())),
    ],
    embedding = [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>],
    $($arguments)*
)]
pub(crate) struct Random18 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * (((x / (1.5 + (a * x) * (a * x))) * (0.125 - a * (x - (b + x))).min(0.0).powi(3)).signum() * ((x / (1.5 + (a * x) * (a * x))) * (0.125 - a * (x - (b + x))).min(0.0).powi(3)).powi(3)).tanh() + 0.3 * (0.5 * ((a * u).hypot(1.5) * ((v - v) - 0.25).max(0.0).powi(3)) * ((a * u).hypot(1.5) * ((v - v) - 0.25).max(0.0).powi(3))).ln_1p(),
    noise = [
        |[x, y], [u, v]| 0.3 * (x * x).sin().mul_add((x - 0.5_f64), b),
        |[x, y], [u, v]| 0.3 * u.sin().sinh().atan2(2.0 + u.cos()),
    ],
    embedding = [Midpoint, Uncorrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Random19 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * ((((a * w) * (u - 1.25_f64)) / (1.5 + ((a * w) - (a * x)) * ((a * w) - (a * x)))) * ((0.5 * (b + z).sin()).tan() / (1.5 + (w - 0.75_f64).sin().hypot(1.0 + y * y) * (w - 0.75_f64).sin().hypot(1.0 + y * y)))) + 0.3 * ((if w.sin().powi(3) < b { ((w - 0.75_f64) * (a * z)) } else { ((w - 0.75_f64) * (a * z)) + (w.sin().powi(3) - b).powi(3) }) * (0.5 * (u * ((a * x) - 0.25).max(0.0).powi(3)).sin()).asin()),
    noise = [
        |[x, y, z], [u, v, w]| 0.3 * (((a * u) * ((y - 1.25_f64) - 0.25).max(0.0).powi(3)) * (2.5 + x.cos()).acosh()),
    ],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Random20 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u| 0.5 * u * u + 0.5 * x * x + 0.3 * (((a * u) / (1.5 + x * x)).sin().sinh() * ((a * x) * (b + u)).sin().exp2()) + 0.3 * (0.5 * ((u - 0.5_f64).sin().hypot(1.0 + u * u) * ((u - 1.25_f64) - (x - 0.75_f64))).cos()).exp_m1(),
    noise = [
        |x, u| 0.3 * (0.5 * u.sin().powi(3).tanh()).acos(),
        |x, u| 0.3 * ((u * x) * ((x * (x - 0.75_f64)) - 0.25).max(0.0).powi(3)),
    ],
    embedding = [Midpoint, Corrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Random21 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * (((0.5 * v.cos()).exp_m1() * (0.125 - a * (u * (0.125 - a * u).min(0.0).powi(3))).min(0.0).powi(3)) * (2.0 + (b + u).atan().sin()).recip()) + 0.3 * ((0.5 * y.sin()).tan().tanh().exp() * ((x - (u - 1.25_f64)) * (x * ((v - 1.25_f64) - 0.25).max(0.0).powi(3)))),
    noise = [
        |[x, y], [u, v]| 0.3 * ((u + x) / (1.5 + ({ let (s, c) = (y - 1.25_f64).sin_cos(); s * c + a * s }) * ({ let (s, c) = (y - 1.25_f64).sin_cos(); s * c + a * s }))),
    ],
    embedding = [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>],
    $($arguments)*
)]
pub(crate) struct Random22 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w], t| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * (((a * x) * ((a * x) - 0.25).max(0.0).powi(3)).asinh() / (1.5 + (t - z).cos() * (t - z).cos())) + 0.3 * (0.5 * ((v * (0.125 - a * (a * v)).min(0.0).powi(3)) * ((b + t) * w)).sin()).atanh(),
    noise = [
        |[x, y, z], [u, v, w], t| 0.3 * (0.5 * u.asinh().sin()).asin(),
        |[x, y, z], [u, v, w], t| 0.3 * (((v - 0.75_f64) / (1.5 + v * v)) / (1.5 + (u - 0.5_f64).atan() * (u - 0.5_f64).atan())),
    ],
    embedding = [Midpoint, Uncorrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Random23 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u| 0.5 * u * u + 0.5 * x * x + 0.3 * (((u - 1.25_f64).sin().exp2() + ((u - 1.25_f64) - x)) * ((if (b + x) < b { u } else { u + ((b + x) - b).powi(3) }) + (u / (1.5 + (u - 1.25_f64) * (u - 1.25_f64))))) + 0.3 * (2.5 + ((if u < b { (a * u) } else { (a * u) + (u - b).powi(3) }) + ((b + x) - (a * x))).cos()).acosh(),
    noise = [
        |x, u| 0.3 * (2.0 + x.tanh().cosh().sin()).recip(),
        |x, u| 0.3 * ((u + u) + (0.5 * (u - 0.75_f64) * (u - 0.75_f64)).ln_1p()),
        |x, u| 0.3 * ((b + x) * (u - 0.25).max(0.0).powi(3)).tanh(),
    ],
    embedding = [Midpoint, Corrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Random24 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * (0.5 * ((1.0 + (a * v) * (a * v)).sqrt() / (1.5 + ((u - 0.75_f64) * v) * ((u - 0.75_f64) * v))).sin()).tan() + 0.3 * ((u.tanh().cosh() + (x - (x - 1.25_f64))) / (1.5 + (((y - 1.25_f64) + u) / (1.5 + ((b + v) - v) * ((b + v) - v))) * (((y - 1.25_f64) + u) / (1.5 + ((b + v) - v) * ((b + v) - v))))),
    noise = [
        |[x, y], [u, v]| 0.3 * (v * (b + v)).atan2(2.0 + (b + x).cos()),
        |[x, y], [u, v]| 0.3 * ((y * (0.125 - a * (a * u)).min(0.0).powi(3)) * ((a * y) - (x - 1.25_f64))),
        |[x, y], [u, v]| 0.3 * (if ({ let s2 = (x - 0.75_f64); if s2 > 0.25 { (y - 0.5_f64) * (s2 - 0.25).powi(3) } else { 0.0 } }) < b { (1.0 + y * y).log10() } else { (1.0 + y * y).log10() + (({ let s2 = (x - 0.75_f64); if s2 > 0.25 { (y - 0.5_f64) * (s2 - 0.25).powi(3) } else { 0.0 } }) - b).powi(3) }),
    ],
    embedding = [Midpoint, Mixed<DeltaPlus, Midpoint>],
    $($arguments)*
)]
pub(crate) struct Random25 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w], t| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * (2.0 + ((x + (u - 1.25_f64)) * (2.0 + (b + t).cos()).log2()).cos()).log2() + 0.3 * ((0.5 * w * w).ln_1p() - (w * ((b + t) - 0.25).max(0.0).powi(3))).sin().exp2(),
    noise = [
        |[x, y, z], [u, v, w], t| 0.3 * (2.5 + ((w - 0.5_f64) * t).cos()).acosh(),
        |[x, y, z], [u, v, w], t| 0.3 * (0.5 * (0.5 * (u - 1.25_f64).sin()).atanh().sin()).tan(),
        |[x, y, z], [u, v, w], t| 0.3 * (((a * v) * z) * ((a * v) + v)),
    ],
    embedding = [Midpoint, Uncorrected<Lambda<2, 3>>],
    $($arguments)*
)]
pub(crate) struct Random26 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u, t| 0.5 * u * u + 0.5 * x * x + 0.3 * (0.5 * (((a * t) + t) * (2.0 + (x - 0.75_f64).sin()).recip()).sin()).tan() + 0.3 * (((t * t) * (a * u).asinh()) + ((2.0 + t.cos()).log2() * (1.5 + (b + t).sin()).ln())),
    embedding = [Midpoint, Corrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Random27 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * ((v - 0.75_f64).sin().hypot(1.0 + (y - 1.25_f64) * (y - 1.25_f64)) * (0.125 - a * ((a * u) * (a * u))).min(0.0).powi(3)).tanh().exp() + 0.3 * (((u * (a * v)) - (0.5 * (a * v).sin()).atanh()).signum() * ((u * (a * v)) - (0.5 * (a * v).sin()).atanh()).powi(3)).tanh(),
    noise = [
        |[x, y], [u, v]| 0.3 * ((b + x).sin().powi(3) / (1.5 + (x / (1.5 + u * u)) * (x / (1.5 + u * u)))),
    ],
    embedding = [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>],
    $($arguments)*
)]
pub(crate) struct Random28 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * (0.5 * ({ let s1 = (a * u).abs().powi(3).atan(); if s1 > 0.25 { (u * z) * (s1 - 0.25).powi(3) } else { 0.0 } }).sin()).tan() + 0.3 * ((((v - 0.5_f64) * (0.125 - a * (v - 0.75_f64)).min(0.0).powi(3)) * ((a * y) / (1.5 + (b + v) * (b + v)))) - ((2.0 + u.sin()).powf((a * x).tanh()).signum() * (2.0 + u.sin()).powf((a * x).tanh()).powi(3)).tanh()),
    noise = [
        |[x, y, z], [u, v, w]| 0.3 * ((x * x) * ((y - 1.25_f64) * (b + x))),
        |[x, y, z], [u, v, w]| 0.3 * (((y - 1.25_f64) / (1.5 + (z - 1.25_f64) * (z - 1.25_f64))) * (u / (1.5 + w * w))),
    ],
    embedding = [Midpoint, Uncorrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Random29 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u| 0.5 * u * u + 0.5 * x * x + 0.3 * (u.tanh() / (1.5 + ((x - 1.25_f64) * (b + u)) * ((x - 1.25_f64) * (b + u)))).asinh() + 0.3 * (1.0 + (((a * x) - u) * ((u - 1.25_f64) * (x - 1.25_f64))) * (((a * x) - u) * ((u - 1.25_f64) * (x - 1.25_f64)))).powi(-2),
    noise = [
        |x, u| 0.3 * (((a * x) * (0.125 - a * x).min(0.0).powi(3)) / (1.5 + ((b + u) - u) * ((b + u) - u))),
    ],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Random30 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * (1.0 + (({ let s1 = x; if s1 > 0.25 { (x - 0.5_f64) * (s1 - 0.25).powi(3) } else { 0.0 } }) * x.hypot(1.5)) * (({ let s1 = x; if s1 > 0.25 { (x - 0.5_f64) * (s1 - 0.25).powi(3) } else { 0.0 } }) * x.hypot(1.5))).log10() + 0.3 * ((2.0 + v.tanh().cos()).log2() + v.hypot(1.5).abs().powi(3).atan()),
    noise = [
        |[x, y], [u, v]| 0.3 * (((b + v) - x) * (0.125 - a * (0.5 * v.cos()).exp_m1()).min(0.0).powi(3)),
        |[x, y], [u, v]| 0.3 * ((0.5 * (b + u) * (b + u)).ln_1p() * u.sin().hypot(1.0 + (b + v) * (b + v))),
    ],
    embedding = [Midpoint, Corrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Random31 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * (((u - 1.25_f64).signum() * (u - 1.25_f64).powi(3)).tanh() * (x - u)).sin().sinh() + 0.3 * ((((b + x) + (b + v)) * (u - (v - 1.25_f64))) / (1.5 + ((1.0 + (v - 0.75_f64) * (v - 0.75_f64)).powi(-2) / (1.5 + (w * (b + u)) * (w * (b + u)))) * ((1.0 + (v - 0.75_f64) * (v - 0.75_f64)).powi(-2) / (1.5 + (w * (b + u)) * (w * (b + u)))))),
    embedding = [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>],
    $($arguments)*
)]
pub(crate) struct Random32 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u| 0.5 * u * u + 0.5 * x * x + 0.3 * (0.5 * (0.5 * ((u - 1.25_f64) - u).sin()).atanh().sin()).tan() + 0.3 * ((((b + x) + x) + x.sin().powi(3)) / (1.5 + (1.0 + (1.5 + (a * u).sin()).ln() * (1.5 + (a * u).sin()).ln()).log10() * (1.0 + (1.5 + (a * u).sin()).ln() * (1.5 + (a * u).sin()).ln()).log10())),
    noise = [
        |x, u| 0.3 * (1.5 + ((a * u) - (u - 0.75_f64)).sin()).ln(),
        |x, u| 0.3 * (((x - 1.25_f64) * ((b + x) - 0.25).max(0.0).powi(3)) + ((x - 0.5_f64) * ((a * x) - 0.25).max(0.0).powi(3))),
        |x, u| 0.3 * (((u - 0.75_f64) + (a * u)) + x.atan2(2.0 + u.cos())),
    ],
    embedding = [Midpoint, Uncorrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Random33 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * ((({ let (s, c) = (x - 0.5_f64).sin_cos(); s * c + a * s }) * (0.125 - a * (u * (y - 0.25).max(0.0).powi(3))).min(0.0).powi(3)) * (y + u).sin()) + 0.3 * ((0.5 * ((b + v) / (1.5 + (b + y) * (b + y))).tanh()).acos() * ((0.5 * y.sin()).asin() - x.tanh().exp())),
    noise = [
        |[x, y], [u, v]| 0.3 * ((1.0 + (b + x) * (b + x)).sqrt() * ((a * y).sin().exp2() - 0.25).max(0.0).powi(3)),
    ],
    embedding = [Midpoint, Corrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Random34 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w], t| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * (2.5 + (1.0 + ((a * x) - t) * ((a * x) - t)).log10().cos()).acosh() + 0.3 * (1.0 + (if (2.5 + (a * v).cos()).acosh() < b { (t.signum() * t.powi(3)).tanh() } else { (t.signum() * t.powi(3)).tanh() + ((2.5 + (a * v).cos()).acosh() - b).powi(3) }) * (if (2.5 + (a * v).cos()).acosh() < b { (t.signum() * t.powi(3)).tanh() } else { (t.signum() * t.powi(3)).tanh() + ((2.5 + (a * v).cos()).acosh() - b).powi(3) })).log10(),
    noise = [
        |[x, y, z], [u, v, w], t| 0.3 * v.hypot(1.5).sin().powi(3),
        |[x, y, z], [u, v, w], t| 0.3 * (1.0 + (1.0 + u * u).log10() * (1.0 + u * u).log10()).powf(-0.75),
        |[x, y, z], [u, v, w], t| 0.3 * ((x * w) * (0.125 - a * ({ let s2 = t; if s2 > 0.25 { x * (s2 - 0.25).powi(3) } else { 0.0 } })).min(0.0).powi(3)),
    ],
    embedding = [Midpoint, Mixed<DeltaPlus, Midpoint>],
    $($arguments)*
)]
pub(crate) struct Random35 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u| 0.5 * u * u + 0.5 * x * x + 0.3 * (((if u < b { x } else { x + (u - b).powi(3) }) / (1.5 + (u.signum() * u.powi(3)).tanh() * (u.signum() * u.powi(3)).tanh())) + ((1.0 + (a * x) * (a * x)).sqrt() / (1.5 + ((b + x) / (1.5 + (a * x) * (a * x))) * ((b + x) / (1.5 + (a * x) * (a * x)))))) + 0.3 * (({ let (s, c) = (b + x).sin_cos(); s * c + a * s }) + (0.5 * (b + u).sin()).asin()).tanh().cosh(),
    embedding = [Midpoint, Uncorrected<Lambda<2, 3>>],
    $($arguments)*
)]
pub(crate) struct Random36 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * (y / (1.5 + (u - 0.5_f64) * (u - 0.5_f64))).abs().powi(3).atan().tanh() + 0.3 * ((x.cos() * ((u - 0.5_f64) - y)) * ((0.5 * (a * x).sin().mul_add((a * y), b).cos()).exp_m1() - 0.25).max(0.0).powi(3)),
    noise = [
        |[x, y], [u, v]| 0.3 * ((y / (1.5 + (a * u) * (a * u))) * (0.5 * (a * u).tanh()).acos()),
        |[x, y], [u, v]| 0.3 * ((1.0 + y * y).log10() - (a * u).sin().powi(3)),
        |[x, y], [u, v]| 0.3 * ((1.5 + y.sin()).ln() - ((a * v) - u)),
    ],
    embedding = [Midpoint, Corrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Random37 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w], t| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * (((2.0 + t.cos()).log2() * (0.5 * z.sin()).atanh()) * (0.5 * (u + u).sin()).asin()) + 0.3 * (((b + v) + (b + z)) - ((b + z) + (b + x))).hypot(1.5),
    noise = [
        |[x, y, z], [u, v, w], t| 0.3 * (if ((v - 1.25_f64) * (b + y)) < b { ({ let s1 = t; if s1 > 0.25 { z * (s1 - 0.25).powi(3) } else { 0.0 } }) } else { ({ let s1 = t; if s1 > 0.25 { z * (s1 - 0.25).powi(3) } else { 0.0 } }) + (((v - 1.25_f64) * (b + y)) - b).powi(3) }),
        |[x, y, z], [u, v, w], t| 0.3 * (z.tanh() * (b + v).sin().hypot(1.0 + z * z)),
    ],
    embedding = [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>],
    $($arguments)*
)]
pub(crate) struct Random38 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |x, u| 0.5 * u * u + 0.5 * x * x + 0.3 * (((x + (a * x)) * (2.0 + (a * x).sin()).atan2((a * x))) * ((x - (b + x)) / (1.5 + x.hypot(1.5) * x.hypot(1.5)))) + 0.3 * ((b + u).hypot(1.5) * (u + (b + u))).tanh().exp(),
    noise = [
        |x, u| 0.3 * (((x - 0.75_f64) / (1.5 + x * x)) / (1.5 + (a * x).sin().hypot(1.0 + x * x) * (a * x).sin().hypot(1.0 + x * x))),
    ],
    embedding = [Midpoint, Uncorrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Random39 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y], [u, v]| 0.5 * u * u + 0.5 * v * v + 0.5 * x * x + 0.5 * y * y + 0.3 * ((((b + y) / (1.5 + (b + v) * (b + v))) / (1.5 + ((u - 0.75_f64) * u) * ((u - 0.75_f64) * u))) * (y - 1.25_f64).sin().atan2(2.0 + v.cos())) + 0.3 * (({ let s1 = (u + (b + v)); if s1 > 0.25 { (b + v).sin() * (s1 - 0.25).powi(3) } else { 0.0 } }) / (1.5 + ((1.0 + (x - 0.75_f64) * (x - 0.75_f64)).powf(-0.75) - ((b + v) - v)) * ((1.0 + (x - 0.75_f64) * (x - 0.75_f64)).powf(-0.75) - ((b + v) - v)))),
    noise = [
        |[x, y], [u, v]| 0.3 * ((u - (a * u)) + (v - y)),
        |[x, y], [u, v]| 0.3 * (y + v).sin().hypot(1.0 + y * y),
        |[x, y], [u, v]| 0.3 * (1.0 + ((b + y) / (1.5 + u * u)) * ((b + y) / (1.5 + u * u))).sqrt(),
    ],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Random40 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |[x, y, z], [u, v, w]| 0.5 * u * u + 0.5 * v * v + 0.5 * w * w + 0.5 * x * x + 0.5 * y * y + 0.5 * z * z + 0.3 * (1.0 + (((b + w) * u) + (2.0 + y.sin()).atan2(w)) * (((b + w) * u) + (2.0 + y.sin()).atan2(w))).powf(-0.75) + 0.3 * ((((a * y) + (b + y)) - ((b + x) + w)) * (2.0 + (b + z).sin()).atan2((0.5 * (y - 1.25_f64) * (y - 1.25_f64)).ln_1p())),
    noise = [
        |[x, y, z], [u, v, w]| 0.3 * ((z + x) * ((u - 0.5_f64) / (1.5 + (a * u) * (a * u)))),
    ],
    embedding = [Midpoint, Corrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Random41 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}
    };
}
pub(crate) use random_systems;

/// `$check!(test, system, twice the degrees of freedom, [schemes])` for every system.
macro_rules! every_random_system {
    ($check:ident) => {
        $check!(random00, Random00 { a: 1.28125, b: 1.4375 }, 2, [Midpoint, Uncorrected<DeltaPlus>]);
        $check!(random01, Random01 { a: 1.109375, b: 1.34375 }, 4, [Midpoint, Corrected<Lambda<1, 4>>]);
        $check!(random02, Random02 { a: 1.34375, b: 1.015625 }, 6, [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>]);
        $check!(random03, Random03 { a: 1.359375, b: 1.125 }, 2, [Midpoint, Uncorrected<DeltaMinus>]);
        $check!(random04, Random04 { a: 0.78125, b: 0.515625 }, 4, [Midpoint, Corrected<DeltaPlus>]);
        $check!(random05, Random05 { a: 0.78125, b: 0.75 }, 6, [Midpoint, Mixed<DeltaPlus, Midpoint>]);
        $check!(random06, Random06 { a: 1.3125, b: 1.125 }, 2, [Midpoint, Uncorrected<Lambda<2, 3>>]);
        $check!(random07, Random07 { a: 1.015625, b: 0.5625 }, 4, [Midpoint, Corrected<DeltaMinus>]);
        $check!(random08, Random08 { a: 1.203125, b: 0.9375 }, 6, [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>]);
        $check!(random09, Random09 { a: 0.609375, b: 1.15625 }, 2, [Midpoint, Uncorrected<Lambda<1, 4>>]);
        $check!(random10, Random10 { a: 1.453125, b: 1.015625 }, 4, [Midpoint, Uncorrected<DeltaPlus>]);
        $check!(random11, Random11 { a: 0.828125, b: 1.390625 }, 6, [Midpoint, Corrected<Lambda<1, 4>>]);
        $check!(random12, Random12 { a: 0.875, b: 1.0 }, 2, [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>]);
        $check!(random13, Random13 { a: 0.859375, b: 0.625 }, 4, [Midpoint, Uncorrected<DeltaMinus>]);
        $check!(random14, Random14 { a: 1.28125, b: 1.03125 }, 6, [Midpoint, Corrected<DeltaPlus>]);
        $check!(random15, Random15 { a: 1.09375, b: 0.59375 }, 2, [Midpoint, Mixed<DeltaPlus, Midpoint>]);
        $check!(random16, Random16 { a: 1.421875, b: 0.515625 }, 4, [Midpoint, Uncorrected<Lambda<2, 3>>]);
        $check!(random17, Random17 { a: 1.078125, b: 1.265625 }, 6, [Midpoint, Corrected<DeltaMinus>]);
        $check!(random18, Random18 { a: 1.484375, b: 0.828125 }, 2, [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>]);
        $check!(random19, Random19 { a: 0.765625, b: 0.875 }, 4, [Midpoint, Uncorrected<Lambda<1, 4>>]);
        $check!(random20, Random20 { a: 1.46875, b: 1.34375 }, 6, [Midpoint, Uncorrected<DeltaPlus>]);
        $check!(random21, Random21 { a: 0.765625, b: 1.109375 }, 2, [Midpoint, Corrected<Lambda<1, 4>>]);
        $check!(random22, Random22 { a: 1.0, b: 1.4375 }, 4, [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>]);
        $check!(random23, Random23 { a: 1.234375, b: 1.046875 }, 6, [Midpoint, Uncorrected<DeltaMinus>]);
        $check!(random24, Random24 { a: 0.78125, b: 0.609375 }, 2, [Midpoint, Corrected<DeltaPlus>]);
        $check!(random25, Random25 { a: 0.859375, b: 1.21875 }, 4, [Midpoint, Mixed<DeltaPlus, Midpoint>]);
        $check!(random26, Random26 { a: 1.125, b: 1.0 }, 6, [Midpoint, Uncorrected<Lambda<2, 3>>]);
        $check!(random27, Random27 { a: 1.078125, b: 0.5625 }, 2, [Midpoint, Corrected<DeltaMinus>]);
        $check!(random28, Random28 { a: 0.90625, b: 1.46875 }, 4, [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>]);
        $check!(random29, Random29 { a: 0.546875, b: 1.34375 }, 6, [Midpoint, Uncorrected<Lambda<1, 4>>]);
        $check!(random30, Random30 { a: 1.25, b: 0.78125 }, 2, [Midpoint, Uncorrected<DeltaPlus>]);
        $check!(random31, Random31 { a: 0.984375, b: 0.953125 }, 4, [Midpoint, Corrected<Lambda<1, 4>>]);
        $check!(random32, Random32 { a: 0.75, b: 1.25 }, 6, [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>]);
        $check!(random33, Random33 { a: 0.765625, b: 0.546875 }, 2, [Midpoint, Uncorrected<DeltaMinus>]);
        $check!(random34, Random34 { a: 1.375, b: 1.40625 }, 4, [Midpoint, Corrected<DeltaPlus>]);
        $check!(random35, Random35 { a: 1.125, b: 1.234375 }, 6, [Midpoint, Mixed<DeltaPlus, Midpoint>]);
        $check!(random36, Random36 { a: 1.0625, b: 0.578125 }, 2, [Midpoint, Uncorrected<Lambda<2, 3>>]);
        $check!(random37, Random37 { a: 1.28125, b: 1.21875 }, 4, [Midpoint, Corrected<DeltaMinus>]);
        $check!(random38, Random38 { a: 1.390625, b: 0.796875 }, 6, [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>]);
        $check!(random39, Random39 { a: 1.171875, b: 0.921875 }, 2, [Midpoint, Uncorrected<Lambda<1, 4>>]);
        $check!(random40, Random40 { a: 0.640625, b: 1.28125 }, 4, [Midpoint, Uncorrected<DeltaPlus>]);
        $check!(random41, Random41 { a: 0.53125, b: 0.671875 }, 6, [Midpoint, Corrected<Lambda<1, 4>>]);
    };
}
pub(crate) use every_random_system;

macro_rules! random_arrays {
    ($($arguments:tt)*) => {
#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * (((2.0 + q[i].cos()).log2() * (q[i] - (b + q[i]))) * ((0.5 * (b + q[i]).sin()).tan() + p[i].asinh()))).sum::<f64>(),
    noise = [|q, p, k| 0.3 * (2.0 + (p[k] - (a * q[k])).sin()).powf(q[k].tanh()); 5],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Array00 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * ((q[i] * q[i]) * (2.0 + (a * q[i]).sin()).powf(q[i].tanh())) + 0.3 * (0.5 * (2.0 + p[i].cos()).log2().tanh()).acos()).sum::<f64>() + (0..4).map(|i| 0.3 * (q[i + 1].tanh() / (1.5 + ({ let s1 = (b + q[i + 1]); if s1 > 0.25 { q[i] * (s1 - 0.25).powi(3) } else { 0.0 } }) * ({ let s1 = (b + q[i + 1]); if s1 > 0.25 { q[i] * (s1 - 0.25).powi(3) } else { 0.0 } })))).sum::<f64>(),
    noise = [
        |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.3 * (((p[i] - 1.25_f64) / (1.5 + q[i] * q[i])) * (p[i] - 1.25_f64).sin().mul_add((b + q[i]), b))).sum::<f64>(),
    ],
    embedding = [Midpoint, Corrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Array01 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * ((q[i] * p[i]).sin().powi(3) * ((2.5 + p[i].cos()).acosh() * ({ let s1 = (b + p[i]); if s1 > 0.25 { p[i] * (s1 - 0.25).powi(3) } else { 0.0 } })))).sum::<f64>() + (0..4).map(|i| 0.3 * (0.5 * (if q[i + 1] < b { q[i + 1] } else { q[i + 1] + (q[i + 1] - b).powi(3) }).sin()).atanh()).sum::<f64>(),
    noise = [|q, p, k| 0.3 * ((2.0 + q[k].sin()).atan2(q[k]) - (p[k] * (0.125 - a * (a * p[k])).min(0.0).powi(3))); 5],
    embedding = [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>],
    $($arguments)*
)]
pub(crate) struct Array02 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * (2.0 + ((q[i] * p[i]) + (2.0 + q[i].sin()).cbrt()).sin()).powf(q[i].tanh())).sum::<f64>(),
    embedding = [Midpoint, Uncorrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Array03 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5], t| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * (1.0 + q[i] * q[i]).powf(-0.75).asinh() + 0.3 * (((b + p[i]) / (1.5 + p[i] * p[i])) - (p[i] - 0.5_f64).asinh())).sum::<f64>() + (0..4).map(|i| 0.3 * ({ let s2 = ((q[i] - 1.25_f64) * ((a * q[i]) - 0.25).max(0.0).powi(3)); if s2 > 0.25 { (b + q[i]).sin().exp2() * (s2 - 0.25).powi(3) } else { 0.0 } })).sum::<f64>(),
    noise = [|q, p, k| 0.3 * (((p[k] - 1.25_f64) * (a * p[k])) / (1.5 + ((a * q[k]) * (p[k] - 0.5_f64)) * ((a * q[k]) * (p[k] - 0.5_f64)))); 5],
    embedding = [Midpoint, Corrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Array04 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * (2.0 + (1.5 + (0.5 * q[i] * q[i]).ln_1p().sin()).ln().sin()).powf(p[i].tanh())).sum::<f64>() + (0..4).map(|i| 0.3 * ({ let s1 = (q[i] - 0.75_f64); if s1 > 0.25 { (b + p[i]) * (s1 - 0.25).powi(3) } else { 0.0 } }).atan()).sum::<f64>(),
    noise = [
        |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.3 * ((p[i] + (b + p[i])) * (0.125 - a * (p[i] - 0.75_f64).tanh().exp()).min(0.0).powi(3))).sum::<f64>(),
    ],
    embedding = [Midpoint, Mixed<DeltaPlus, Midpoint>],
    $($arguments)*
)]
pub(crate) struct Array05 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * ((0.5 * ((b + p[i]) + (p[i] - 1.25_f64)) * ((b + p[i]) + (p[i] - 1.25_f64))).ln_1p() - (1.5 + ((a * q[i]) * (b + p[i])).sin()).ln())).sum::<f64>(),
    noise = [|q, p, k| 0.3 * (((a * p[k]) + p[k]) + (b + p[k]).hypot(1.5)); 5],
    embedding = [Midpoint, Uncorrected<Lambda<2, 3>>],
    $($arguments)*
)]
pub(crate) struct Array06 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * (2.0 + (q[i] * q[i]).sin()).cbrt() + 0.3 * (1.0 + (p[i] / (1.5 + p[i] * p[i])) * (p[i] / (1.5 + p[i] * p[i]))).powi(-2)).sum::<f64>() + (0..4).map(|i| 0.3 * (2.0 + (a * q[i]).abs().powi(3).atan().sin()).powf((a * q[i + 1]).tanh())).sum::<f64>(),
    embedding = [Midpoint, Corrected<DeltaMinus>],
    $($arguments)*
)]
pub(crate) struct Array07 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * (((1.0 + p[i] * p[i]).powi(-2) * q[i].sin().hypot(1.0 + (b + q[i]) * (b + q[i]))) * (2.0 + (p[i] - (a * p[i])).cos()).log2())).sum::<f64>() + (0..4).map(|i| 0.3 * (if (1.0 + q[i + 1] * q[i + 1]).powi(-2) < b { (q[i + 1] / (1.5 + (b + q[i + 1]) * (b + q[i + 1]))) } else { (q[i + 1] / (1.5 + (b + q[i + 1]) * (b + q[i + 1]))) + ((1.0 + q[i + 1] * q[i + 1]).powi(-2) - b).powi(3) })).sum::<f64>(),
    noise = [|q, p, k| 0.3 * (0.5 * (b + q[k]).abs().powi(3).atan().sin()).atanh(); 5],
    embedding = [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>],
    $($arguments)*
)]
pub(crate) struct Array08 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5], t| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * (2.0 + ((t - 1.25_f64) - (b + p[i])).sin().powi(3).sin()).recip()).sum::<f64>(),
    noise = [
        |q: [f64; 5], p: [f64; 5], t| (0..5).map(|i| 0.3 * ((q[i] - t) * ((a * t) / (1.5 + (a * t) * (a * t))))).sum::<f64>(),
    ],
    embedding = [Midpoint, Uncorrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Array09 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * (q[i].sin().exp2() * (((q[i] - 1.25_f64) * q[i]) - 0.25).max(0.0).powi(3)) + 0.3 * ((p[i] * (p[i] - 0.75_f64)) / (1.5 + (2.0 + (p[i] - 0.75_f64).cos()).log2() * (2.0 + (p[i] - 0.75_f64).cos()).log2()))).sum::<f64>() + (0..4).map(|i| 0.3 * (0.5 * ((b + q[i + 1]) / (1.5 + q[i] * q[i])).sin()).tan()).sum::<f64>(),
    noise = [|q, p, k| 0.3 * ((q[k] * (0.125 - a * p[k]).min(0.0).powi(3)) * p[k].tanh().cosh()); 5],
    embedding = [Midpoint, Uncorrected<DeltaPlus>],
    $($arguments)*
)]
pub(crate) struct Array10 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[hamiltonian(
    drift = |q: [f64; 5], p: [f64; 5]| (0..5).map(|i| 0.5 * p[i] * p[i] + 0.5 * q[i] * q[i] + 0.3 * (0.5 * (b + p[i]).sin().hypot(1.5).tanh()).acos()).sum::<f64>() + (0..4).map(|i| 0.3 * (((a * p[i]) + (q[i + 1] - 0.5_f64)) * p[i].sin().exp2())).sum::<f64>(),
    embedding = [Midpoint, Corrected<Lambda<1, 4>>],
    $($arguments)*
)]
pub(crate) struct Array11 {
    pub(crate) a: f64,
    pub(crate) b: f64,
}
    };
}
pub(crate) use random_arrays;

/// `$check!(test, system, twice the degrees of freedom, [schemes])` for every system.
macro_rules! every_random_array {
    ($check:ident) => {
        $check!(array00, Array00 { a: 0.859375, b: 0.953125 }, 10, [Midpoint, Uncorrected<DeltaPlus>]);
        $check!(array01, Array01 { a: 1.109375, b: 0.515625 }, 10, [Midpoint, Corrected<Lambda<1, 4>>]);
        $check!(array02, Array02 { a: 0.6875, b: 0.8125 }, 10, [Midpoint, Uncorrected<Mixed<Midpoint, DeltaMinus>>]);
        $check!(array03, Array03 { a: 0.6875, b: 1.328125 }, 10, [Midpoint, Uncorrected<DeltaMinus>]);
        $check!(array04, Array04 { a: 0.671875, b: 1.28125 }, 10, [Midpoint, Corrected<DeltaPlus>]);
        $check!(array05, Array05 { a: 1.03125, b: 1.484375 }, 10, [Midpoint, Mixed<DeltaPlus, Midpoint>]);
        $check!(array06, Array06 { a: 0.5625, b: 1.125 }, 10, [Midpoint, Uncorrected<Lambda<2, 3>>]);
        $check!(array07, Array07 { a: 1.1875, b: 0.78125 }, 10, [Midpoint, Corrected<DeltaMinus>]);
        $check!(array08, Array08 { a: 1.25, b: 0.8125 }, 10, [Midpoint, Corrected<Mixed<Midpoint, DeltaPlus>>]);
        $check!(array09, Array09 { a: 0.671875, b: 0.921875 }, 10, [Midpoint, Uncorrected<Lambda<1, 4>>]);
        $check!(array10, Array10 { a: 0.640625, b: 1.28125 }, 10, [Midpoint, Uncorrected<DeltaPlus>]);
        $check!(array11, Array11 { a: 1.359375, b: 1.203125 }, 10, [Midpoint, Corrected<Lambda<1, 4>>]);
    };
}
pub(crate) use every_random_array;
