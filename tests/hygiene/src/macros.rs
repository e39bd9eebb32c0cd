//! Systems that come out of macros.

use ::renamed::embedding::{DeltaPlus, Midpoint};

macro_rules! oscillator {
    ($name:ident, $frequency:ident, $value:expr, $scheme:ty) => {
        #[::renamed::hamiltonian(
            drift = |q, p| {
                let half = 0.5;
                half * p * p + half * $frequency * self.$frequency * q * q + $value * mass + mass
            },
            noise = [|q, _| mass * q],
            embedding = [$scheme, DeltaPlus],
            crate = ::renamed,
        )]
        struct $name {
            $frequency: f64,
            mass: f64,
        }
    };
}

oscillator!(Slow, omega, 1.0 + 2.0, Midpoint);
oscillator!(Fast, half, 1.0, Midpoint);

macro_rules! with_drift {
    ($name:ident { $($field:ident),* } $drift:expr) => {
        #[::renamed::hamiltonian(drift = $drift, embedding = Midpoint, crate = ::renamed)]
        struct $name { $($field: f64),* }
    };
}

with_drift!(Pendulum { g, l } |q, p| 0.5 * p * p / (l * l) - g * l * f64::cos(q));

macro_rules! local {
    ($q:ident, $p:ident, $body:expr) => {
        #[::renamed::hamiltonian(drift = |$q, $p| $body, embedding = Midpoint, crate = ::renamed)]
        struct Local;
    };
}

local!(x, y, x * y);

pub(crate) fn run() {
    use ::renamed::integrate::Integrate as _;
    let _ = Slow { omega: 1.0, mass: 1.0 }.stepper::<Midpoint>(0.1).is_ok();
    let _ = Fast { half: 1.0, mass: 1.0 }.stepper::<DeltaPlus>(0.1).is_ok();
    let _ = Pendulum { g: 1.0, l: 1.0 }.stepper::<Midpoint>(0.1).is_ok();
    let _ = Local.stepper::<Midpoint>(0.1).is_ok();
}
