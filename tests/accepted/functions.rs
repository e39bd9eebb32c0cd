//! Functions and methods that Hamiltonians share: the compiler sees through their calls.

use wzvi::prelude::*;

mod potentials {
    use wzvi::hamiltonian_fn;

    pub mod units {
        pub const SCALE: f64 = 2.0;
    }

    /// Depth `d`, width 1.
    #[hamiltonian_fn]
    pub fn morse(r: f64, d: f64) -> f64 {
        let e = 1.0 - (-r).exp();
        d * square(e)
    }

    #[hamiltonian_fn]
    fn square(x: f64) -> f64 {
        x * x
    }

    #[hamiltonian_fn]
    pub fn kinetic(p: [f64; 2], masses: &[f64; 2]) -> f64 {
        const HALF: f64 = 0.5;
        HALF * p.iter().zip(masses).map(|(p, m)| square(*p) / m).sum::<f64>()
            * crate::functions::potentials::units::SCALE
            / 2.0
    }
}

use potentials::morse;

#[hamiltonian(drift = |q, p| 0.5 * p * p + morse(q, d) + self.wall(q), embedding = [Midpoint, DeltaPlus])]
#[derive(Clone, Debug)]
struct Molecule {
    d: f64,
    stiffness: f64,
}

#[wzvi::hamiltonian_fn]
impl Molecule {
    fn wall(&self, q: f64) -> f64 {
        Self::quartic(q) * self.stiffness
    }

    fn quartic(q: f64) -> f64 {
        q.powi(4)
    }
}

/// The same, written out.
#[hamiltonian(
    drift = |q, p| {
        let e = 1.0 - (-q).exp();
        0.5 * p * p + d * (e * e) + q.powi(4) * stiffness
    },
    embedding = [Midpoint, DeltaPlus],
)]
struct Inline {
    d: f64,
    stiffness: f64,
}

/// An array and a list of the struct as arguments.
#[hamiltonian(drift = |q: [f64; 2], p: [f64; 2]| potentials::kinetic(p, masses) + central(q[0], q[1]), embedding = Midpoint)]
struct Masses {
    masses: [f64; 2],
}

/// Facts are those of the inlined expressions: the angular momentum is proven.
#[hamiltonian(
    drift = |q: [f64; 2], p: [f64; 2]| 0.5 * (p[0] * p[0] + p[1] * p[1]) + central(q[0], q[1]),
    invariant = |[x, y], [px, py]| x * py - y * px,
    embedding = Midpoint,
)]
struct Kepler;

#[hamiltonian_fn]
fn central(x: f64, y: f64) -> f64 {
    -1.0 / (x * x + y * y).sqrt()
}

/// In sums that stay loops.
#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| {
        (0..q.len()).map(|i| 0.5 * p[i] * p[i]).sum::<f64>()
            + (1..q.len()).map(|i| morse(q[i] - q[i - 1], d)).sum::<f64>()
    },
    embedding = Midpoint,
)]
struct Chain {
    d: f64,
}

#[test]
fn compiles_and_runs() -> Result<(), wzvi::Error> {
    let (molecule, inline) = (Molecule { d: 1.5, stiffness: 0.2 }, Inline { d: 1.5, stiffness: 0.2 });
    assert_eq!(<Molecule as Discretized<Midpoint>>::PLAN, <Inline as Discretized<Midpoint>>::PLAN);
    let mut shared = State::new([0.3], [0.1]);
    let mut written = State::new([0.3], [0.1]);
    let (mut one, mut two) = (molecule.stepper::<Midpoint>(0.1)?, inline.stepper::<Midpoint>(0.1)?);
    for _ in 0..100 {
        one.step(&mut shared, &[])?;
        two.step(&mut written, &[])?;
        assert_eq!(shared.q[0].to_bits(), written.q[0].to_bits());
        assert_eq!(shared.p[0].to_bits(), written.p[0].to_bits());
    }
    assert_eq!(molecule.energy(&shared), inline.energy(&written));
    assert!(
        (molecule.energy(&shared)
            - (0.5 * shared.p[0].powi(2) + morse(shared.q[0], 1.5) + molecule.wall(shared.q[0])))
        .abs()
            < 1e-15
    );
    assert_eq!(<Kepler as Discretized<Midpoint>>::PLAN.conserves_energy, Knowledge::Proven);
    let masses = Masses { masses: [1.0, 2.0] };
    let state = State::new([1.0, 0.0], [1.0, 2.0]);
    assert!((masses.energy(&state) - (0.5 + 1.0 - 1.0)).abs() < 1e-15);
    let chain = Chain { d: 1.0 };
    let mut state = State::new(vec![0.0, 0.1, 0.3], vec![0.0; 3]);
    chain.stepper::<Midpoint>(0.1)?.step(&mut state, &[])?;
    Ok(())
}

mod special {
    use wzvi::functions::{self, erf, erfc as complement};
    use wzvi::prelude::*;

    /// By name, by another name, by path and as methods.
    #[hamiltonian(
        drift = |q, p| 0.5 * p * p + a * erf(q) + complement(q) - functions::sinc(q) + wzvi::functions::j0(q) + q.j1(),
        embedding = [Midpoint, Gauss<2>],
    )]
    struct Named {
        a: f64,
    }

    #[hamiltonian(
        drift = |q, p| 0.5 * p * p + a * q.erf() + q.erfc() - q.sinc() + q.j0() + functions::j1(q),
        embedding = [Midpoint, Gauss<2>],
    )]
    struct Methods {
        a: f64,
    }

    #[hamiltonian_fn]
    fn shared(q: f64, a: f64) -> f64 {
        a * q.erf() + q.erfc() - q.sinc() + functions::j0(q) + q.j1()
    }

    /// A function of the program's own, whose name is one of the library's.
    #[hamiltonian_fn]
    fn sinc(x: f64) -> f64 {
        2.0 * x
    }

    #[hamiltonian(drift = |q, p| 0.5 * p * p + shared(q, a), embedding = [Midpoint, Gauss<2>])]
    struct Shared {
        a: f64,
    }

    #[hamiltonian(drift = |q, p| p * p + sinc(q), embedding = Midpoint)]
    struct Own;

    #[test]
    fn functions_beyond_those_of_f64_have_one_meaning_in_each_spelling() -> Result<(), wzvi::Error> {
        let (named, methods, through) = (Named { a: 0.7 }, Methods { a: 0.7 }, Shared { a: 0.7 });
        for q in [0.0, 1e-9, -0.4, 2.5, 9.0] {
            let state = State::new([q], [0.3]);
            let energy = 0.045 + shared(q, 0.7);
            for found in [named.energy(&state), methods.energy(&state), through.energy(&state)] {
                assert!((found - energy).abs() <= 1e-15 * (1.0 + energy.abs()), "{q}: {found} {energy}");
            }
            assert_eq!(Own.energy(&state), 0.09 + 2.0 * q);
        }
        let mut states = [State::new([0.2], [0.3]); 3];
        named.stepper::<Gauss<2>>(0.1)?.step(&mut states[0], &[])?;
        methods.stepper::<Gauss<2>>(0.1)?.step(&mut states[1], &[])?;
        through.stepper::<Gauss<2>>(0.1)?.step(&mut states[2], &[])?;
        assert_eq!(states[0], states[1]);
        assert_eq!(states[0], states[2]);
        Ok(())
    }
}
