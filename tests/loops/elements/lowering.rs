//! One lowering: what may be written does not depend on the size of the system. Every closure is compiled at sizes on both
//! sides of where loops begin, and gives the energy that Rust gives.

use wzvi::prelude::*;

fn wave(n: usize, phase: f64) -> Vec<f64> {
    (0..n).map(|i| 0.3 + 0.8 * (1.3 * i as f64 + phase).sin().abs()).collect()
}

/// The energies of one closure at 3 and 17 sites against the closure itself. Each is a sum of a few dozen terms of
/// order one, in another order: 1e-13 of it is dozens of roundings.
macro_rules! at_every_size {
    ($name:ident, $mass:ident, $sites:ident, |$q:ident, $p:ident| $body:expr) => {
        at_every_size!($name, 3, $mass, $sites, |$q, $p| $body);
        at_every_size!($name, 17, $mass, $sites, |$q, $p| $body);
    };
    ($name:ident, $n:literal, $mass:ident, $sites:ident, |$q:ident, $p:ident| $body:expr) => {
        const _: () = {
            #[hamiltonian(drift = |$q: [f64; $n], $p: [f64; $n]| $body, embedding = DeltaPlus)]
            struct System {
                $mass: [f64; 3],
                $sites: usize,
            }

            impl AtSize<$n> for $name {
                fn energies() -> [f64; 2] {
                    let system = System { $mass: [1.0, 2.0, 0.5], $sites: 3 };
                    let (q, p) = (wave($n, 0.2), wave($n, 1.1));
                    let state = State::new(
                        <[f64; $n]>::try_from(q.clone()).unwrap(),
                        <[f64; $n]>::try_from(p.clone()).unwrap(),
                    );
                    let ours = system.energy(&state);
                    let System { $mass, $sites } = system;
                    let _ = ($mass, $sites);
                    #[allow(unused)]
                    let theirs = |$q: [f64; $n], $p: [f64; $n]| -> f64 { $body };
                    [ours, theirs(q.try_into().unwrap(), p.try_into().unwrap())]
                }
            }
        };
    };
}

trait AtSize<const N: usize> {
    fn energies() -> [f64; 2];
}

fn check<S: AtSize<3> + AtSize<17>>() {
    for [ours, theirs] in [<S as AtSize<3>>::energies(), <S as AtSize<17>>::energies()] {
        let name = std::any::type_name::<S>();
        assert!((ours - theirs).abs() <= 1e-13 * theirs.abs().max(1.0), "{name}: {ours} {theirs}");
    }
}

macro_rules! systems {
    ($mass:ident, $sites:ident; $($name:ident: |$q:ident, $p:ident| $body:expr;)*) => {
        $( struct $name; at_every_size!($name, $mass, $sites, |$q, $p| $body); )*

        #[test]
        fn closures_mean_the_same_at_every_size() {
            $( check::<$name>(); )*
        }
    };
}

systems! {
    mass, sites;
    Roots: |q, p| p.iter().map(|p| p * p).sum::<f64>().sqrt() + (q[0] * q.iter().map(|x| x * x).sum::<f64>()).sin();
    Products: |q, p| q.iter().product::<f64>() + p.iter().fold(1.0, |a, x| a * (1.0 + 0.1 * x)) + q.len() as f64;
    Exponents: |q, p| (0..q.len()).map(|i| p[i].powi(i as i32 % 4) * q[i]).sum::<f64>();
    Parity: |q, p| (0..q.len()).map(|i| if i % 2 == 0 { q[i] * p[i] } else { q[i - 1] + p[i] }).sum::<f64>();
    Steps: |q, p| q.iter().enumerate().skip(1).step_by(2).map(|(i, x)| i as f64 * x.cos()).sum::<f64>() + 0.5 * p[0] * p[0];
    Multiples: |q, p| (1..q.len()).map(|i| (0..i).map(|j| (2 * i - j) as f64 * q[i] * p[j]).sum::<f64>()).sum::<f64>();
    Choices: |q, p| (0..q.len()).map(|i| [q[i], p[i], q[i] * p[i]][i % 3]).sum::<f64>();
    Walks: |q, p| {
        let mut total = 0.0;
        for i in 0..q.len() {
            total = 0.5 * total + q[i] * p[i];
        }
        total
    };
    Counts: |q, p| {
        let mut count = 0;
        let mut total = 0.0;
        for (i, x) in q.iter().enumerate() {
            count += 1;
            total += x * (count + i) as f64 * p[0];
        }
        total
    };
    Running: |q, p| {
        let mut sum = 0.0;
        q.iter().zip(p.iter()).map(|(q, p)| { sum += q; sum * p }).sum::<f64>()
    };
    Lists: |q, p| {
        let d: Vec<f64> = q.windows(2).map(|w| w[1] - w[0]).collect();
        d.iter().map(|d| d * d).sum::<f64>() + d[0] * d[1] + d.iter().rev().skip(1).step_by(2).zip(&p).map(|(d, p)| d * p).sum::<f64>()
    };
    Chained: |q, p| q.iter().chain(p.iter()).enumerate().map(|(i, x)| x / (1 + i) as f64).sum::<f64>();
    Integers: |q, p| {
        let squares: usize = (0..q.len()).map(|i| i * i).sum();
        let count = (0..q.len()).filter(|i| i % 3 == 1).count();
        squares as f64 * q[0] * p[0] + (q.len().pow(2) - count) as f64 * p[1]
    };
    Fields: |q, p| q[sites - 1] * p[sites % 2] + (0..sites).map(|i| mass[i] * p[i] * p[i]).sum::<f64>() + (sites + 1) as f64;
    Nested: |q, p| (0..q.len()).map(|i| (0..i).map(|j| (q[i] - q[j]).powi(2)).sum::<f64>() * p[i]).sum::<f64>();
    Powers: |q, p| (0..q.len()).map(|i| (0..3).map(|k| mass[k] * q[i].powi(k as i32)).sum::<f64>() + p[i]).sum::<f64>();
    Patterns: |q, p| {
        let [first, .., last] = q;
        let (a, b) = q.iter().zip(p.iter()).fold((0.0, 1.0), |(a, b), (q, p)| (a + q * b, 0.5 * b + p));
        first * last + a + b
    };
}

/// A family beside single noises, and two families, count their increments in the order of the list, at every size and
/// with every kind of count.
macro_rules! mixed_noises {
    ($name:ident, [$($generics:tt)*], $space:ty, $three:expr, $two:expr) => {
        #[hamiltonian(
            drift = |q: $space, p: $space| p.iter().map(|p| 0.25 * two as f64 * p * p).sum::<f64>(),
            noise = [|q, _| a * q[0], [|q, _, k| q[k] * q[k] * (k + 1) as f64; $three], |_, p| p[1], [|q, p, k| q[k] - 2.0 * p[k]; $two]],
            embedding = [Midpoint, DeltaPlus],
        )]
        struct $name $($generics)* {
            a: f64,
            two: usize,
        }
    };
}

const THREE: usize = 3;

mixed_noises!(MixedLiteral, [], [f64; 3], 3, 2);
mixed_noises!(MixedLong, [], [f64; 20], 3, 2);
mixed_noises!(MixedGeneric, [<const N: usize>], [f64; N], 3, 2);
mixed_noises!(MixedSlice, [], &[f64], 3, 2);
mixed_noises!(MixedAtRunTime, [], &[f64], self.two + 1, self.two);
mixed_noises!(MixedConstant, [], [f64; 20], THREE, self.two);
mixed_noises!(MixedCounts, [<const M: usize>], &[f64], M, 2);

#[test]
fn families_stand_beside_other_noises() {
    macro_rules! energies {
        ($system:expr, $n:expr, $vector:expr) => {{
            let system = $system;
            let state = State::new($vector(wave($n, 0.2)).unwrap(), $vector(wave($n, 1.1)).unwrap());
            let mut moved = state.clone();
            assert_eq!(system.noises(), 7);
            system.stepper::<Midpoint>(0.01).unwrap().step(&mut moved, &[0.01; 7]).unwrap();
            // Each increment drives its own noise: the coordinates move by its slopes in the momenta,
            // and by h / dW = 1e-3 times the momenta.
            for k in 0..7 {
                let (mut moved, mut dw) = (state.clone(), [0.0; 7]);
                dw[k] = 1e-6;
                system.stepper::<DeltaPlus>(1e-9).unwrap().step(&mut moved, &dw).unwrap();
                let slopes = [[0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2], [0.0, 1.0], [-2.0, 0.0], [0.0, -2.0]];
                for i in 0..2 {
                    let rate = (moved.q[i] - state.q[i]) / 1e-6;
                    assert!((rate - slopes[k][i]).abs() < 0.01, "noise {k}: {rate}");
                }
            }
            (0..7).map(|k| system.noise_energy(k, &state)).collect::<Vec<f64>>()
        }};
    }
    let a = 0.7;
    let expected = |n: usize| {
        let (q, p) = (wave(n, 0.2), wave(n, 1.1));
        let mut expected = vec![a * q[0]];
        expected.extend((0..3).map(|k| q[k] * q[k] * (k + 1) as f64));
        expected.push(p[1]);
        expected.extend((0..2).map(|k| q[k] - 2.0 * p[k]));
        expected
    };
    let two = 2;
    let slice = Ok::<Vec<f64>, Vec<f64>>;
    assert_eq!(energies!(MixedLiteral { a, two }, 3, <[f64; 3]>::try_from), expected(3));
    assert_eq!(energies!(MixedLong { a, two }, 20, <[f64; 20]>::try_from), expected(20));
    assert_eq!(energies!(MixedGeneric::<5> { a, two }, 5, <[f64; 5]>::try_from), expected(5));
    assert_eq!(energies!(MixedSlice { a, two }, 5, slice), expected(5));
    assert_eq!(energies!(MixedAtRunTime { a, two }, 5, slice), expected(5));
    assert_eq!(energies!(MixedConstant { a, two }, 20, <[f64; 20]>::try_from), expected(20));
    assert_eq!(energies!(MixedCounts::<3> { a, two }, 5, slice), expected(5));
}
