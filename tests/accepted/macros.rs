//! Names inside a `macro_rules!` and in its arguments stay apart, as they do in Rust.

use wzvi::prelude::*;

#[rustfmt::skip]
macro_rules! oscillator {
    ($name:ident, $frequency:ident, $body:expr) => {
        #[hamiltonian(
            drift = |q, p| {
                let early = $frequency;
                let half = 0.5;
                let twice = |x: f64| 2.0 * x;
                half * twice(p * p) + $frequency * early * q * q + $body + 2.0 * mass
            },
            embedding = [DeltaPlus],
        )]
        struct $name {
            $frequency: f64,
            mass: f64,
        }
    };
}

oscillator!(Plain, omega, omega);
// The field has the name of a variable of the macro, and so has a variable of the argument.
oscillator!(Shadowing, half, {
    let twice = half + 1.0;
    twice + mass
});

macro_rules! closure {
    ($name:ident, $drift:expr) => {
        #[hamiltonian(drift = $drift, embedding = DeltaPlus)]
        struct $name {
            k: f64,
        }
    };
}

closure!(Whole, |k_q, p| 3.0 * k_q
    + {
        let p = 2.0 * p;
        p
    }
    + self.k
    + k);

#[test]
fn compiles_and_runs() {
    let state = State::new([0.5], [4.0]);
    let plain = Plain { omega: 3.0, mass: 1.25 };
    assert_eq!(plain.energy(&state), 0.5 * 2.0 * 16.0 + 9.0 * 0.25 + 3.0 + 2.5);
    let shadowing = Shadowing { half: 3.0, mass: 1.25 };
    assert_eq!(shadowing.energy(&state), 0.5 * 2.0 * 16.0 + 9.0 * 0.25 + 4.0 + 1.25 + 2.5);
    assert_eq!(Whole { k: 1.0 }.energy(&state), 1.5 + 8.0 + 2.0);
}
