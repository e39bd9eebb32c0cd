//! One system, one set of facts: in straight lines and in loops at literal sizes, with a const generic, and on slices.

use fixtures::steps::{advance, distance};
use wzvi::prelude::*;

use Solver::{Explicit, Linear, Newton};

/// How each scheme solves its steps: the solver and the largest block of unknowns.
fn solver<E, H: Discretized<E>>() -> (Solver, usize) {
    (H::PLAN.solver, H::PLAN.unknowns)
}

const K: [f64; 3] = [0.5, 1.25, -2.0];
const Q: [f64; 3] = [0.75, 0.125, -0.5];
const P: [f64; 3] = [0.25, -1.5, 1.0];
const DW: [f64; 3] = [0.25, -0.5, 0.125];

/// A sum over sites `i` and, if there is one, a family of noises `k`; by each scheme it is solved in the same way in each spelling, with the same end.
macro_rules! solves {
    ($test:ident: |$q:ident, $p:ident, $i:ident| $site:expr $(, |$k:ident| $noise:expr)?; $($scheme:ty => $expected:expr),*) => {
        #[test]
        fn $test() {
            solves!(@ Three [f64; 3], 3, [], [Three { k: [f64; 3] }]; $q $p $i $site; $($k $noise)?; [$($scheme),*]);
            solves!(@ Sixteen [f64; 16], 16, [], [Sixteen { k: [f64; 16] }]; $q $p $i $site; $($k $noise)?; [$($scheme),*]);
            solves!(@ Seventeen [f64; 17], 17, [], [Seventeen { k: [f64; 17] }]; $q $p $i $site; $($k $noise)?; [$($scheme),*]);
            solves!(@ Any [f64; N], N, [], [Any<const N: usize> { k: [f64; N] }]; $q $p $i $site; $($k $noise)?; [$($scheme),*]);
            solves!(@ Slice &[f64], self.k.len(), [], [Slice { k: Vec<f64> }]; $q $p $i $site; $($k $noise)?; [$($scheme),*]);
            $(
                let expected: (Solver, usize) = $expected;
                let what = stringify!($scheme);
                assert_eq!(solver::<$scheme, Three>(), expected, "{what}, 3 sites");
                assert_eq!(solver::<$scheme, Sixteen>(), expected, "{what}, 16 sites");
                assert_eq!(solver::<$scheme, Seventeen>(), expected, "{what}, 17 sites");
                assert_eq!(solver::<$scheme, Any<5>>(), expected, "{what}, const generic");
                assert_eq!(solver::<$scheme, Slice>(), expected, "{what}, slices");
                let (three, slice) = (Three { k: K }, Slice { k: K.to_vec() });
                let dw = &DW[..<Slice as Discretized<$scheme>>::increments(&slice, 3)];
                let written = advance::<$scheme, f64, _>(&three, [&Q, &P], [0.0, 0.25], dw);
                let looped = advance::<$scheme, f64, _>(&slice, [&Q, &P], [0.0, 0.25], dw);
                // Some roundings of numbers up to 2.
                let gap = distance(&written, &looped);
                assert!(gap < 1e-14, "{what}: {gap:e}");
            )*
        }
    };
    (@ $name:ident $vector:ty, $n:expr, [], [$($struct:tt)*]; $q:ident $p:ident $i:ident $site:expr; ; [$($scheme:ty),*]) => {
        #[hamiltonian(
            drift = |$q: $vector, $p: $vector| (0..$q.len()).map(|$i| $site).sum::<f64>(),
            embedding = [$($scheme),*],
        )]
        struct $($struct)*
    };
    (@ $name:ident $vector:ty, $n:expr, [], [$($struct:tt)*]; $q:ident $p:ident $i:ident $site:expr; $k:ident $noise:expr; [$($scheme:ty),*]) => {
        #[hamiltonian(
            drift = |$q: $vector, $p: $vector| (0..$q.len()).map(|$i| $site).sum::<f64>(),
            noise = [|$q, $p, $k| $noise; $n],
            embedding = [$($scheme),*],
        )]
        struct $($struct)*
    };
}

solves!(pendulums: |q, p, i| 0.5 * p[i] * p[i] - k[i] * q[i].cos();
    DeltaPlus => (Explicit, 0), Verlet => (Explicit, 0), Midpoint => (Newton, 1), Lambda<1, 4> => (Newton, 1));
solves!(oscillators: |q, p, i| 0.5 * (p[i] * p[i] + k[i] * q[i] * q[i]);
    Verlet => (Explicit, 0), Midpoint => (Linear, 1));
solves!(uniform_force: |q, p, i| 0.5 * p[i] * p[i] + k[i] * q[i];
    DeltaPlus => (Explicit, 0), Verlet => (Explicit, 0), Midpoint => (Explicit, 0), Lambda<1, 3> => (Explicit, 0));
solves!(jumps: |q, p, i| 0.5 * p[i] * p[i] + if q[i] > 0.25 { k[i] } else { 0.0 };
    Verlet => (Explicit, 0), Midpoint => (Explicit, 0));
solves!(rotating: |q, p, i| q[i].cos() * p[i] * p[i] + k[i] * q[i] * q[i];
    DeltaPlus => (Newton, 1));
solves!(additive_noise: |q, p, i| 0.5 * p[i] * p[i] - k[i] * q[i].cos(), |j| 0.3 * q[j];
    Verlet => (Explicit, 0), Midpoint => (Newton, 1));
solves!(noise_of_coordinates: |q, p, i| 0.5 * (p[i] * p[i] + k[i] * q[i] * q[i]), |j| 0.3 * q[j] * q[j];
    Verlet => (Explicit, 0), Midpoint => (Linear, 1), Lambda<1, 4> => (Linear, 1));
solves!(dilations: |q, p, i| 0.5 * (p[i] * p[i] + k[i] * q[i] * q[i]), |j| 0.3 * q[j] * p[j];
    Verlet => (Linear, 1), Midpoint => (Linear, 2), Uncorrected<DeltaPlus> => (Linear, 1), Uncorrected<DeltaMinus> => (Linear, 1));
solves!(moving_frame: |q, p, i| 0.5 * p[i] * p[i] + p[i] * (k[i] * q[i]).sin();
    DeltaPlus => (Linear, 1));
solves!(branches: |q, p, i| 0.5 * (p[i] * p[i] + k[i] * q[i] * q[i]), |j| if j == 0 { 0.3 * q[0] * q[0] } else { 0.2 * p[j] };
    DeltaPlus => (Explicit, 0));
