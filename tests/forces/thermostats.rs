//! What the attribute says of friction and temperature is what thermostats are given.

use wzvi::elements::Elements;
use wzvi::prelude::*;

/// Three masses in a row, whose friction and temperature are fields, in straight lines and in loops.
macro_rules! row {
    ($name:ident, $bath:tt, $loops:ident, $in_loops:ident, $general:tt) => {
        row!(@of $name, [], [f64; 3], $bath);
        row!(@of $in_loops, [<const N: usize>], [f64; N], $general);
        type $loops = $in_loops<3>;
    };
    (@of $name:ident, [$($generics:tt)*], $state:ty, { $($bath:tt)* }) => {
        #[hamiltonian(
            drift = |q: $state, p: $state| (0..q.len()).map(|i| 0.5 * p[i] * p[i] / self.mass[i] + 0.25 * q[i].powi(4)).sum::<f64>()
                + (0..q.len() - 1).map(|i| 0.5 * (q[i + 1] - q[i]).powi(2)).sum::<f64>(),
            $($bath)*,
            temperature = self.kt,
            embedding = [Baoab, Obabo, Thermostat<Midpoint>, Thermostat<Verlet>, Thermostat<Gauss<2>>],
        )]
        #[derive(Clone, Debug)]
        pub(crate) struct $name$($generics)* {
            pub(crate) mass: [f64; 3],
            pub(crate) gamma: f64,
            pub(crate) kt: f64,
        }
    };
}

row!(UniformInline, { friction = self.gamma }, UniformLoops, UniformInLoops, { friction = self.gamma });
row!(ListInline, { friction = [self.gamma, 0.0, 2.0 * self.gamma] }, ListLoops, ListInLoops, {
    friction = (0..N).map(|i| match i {
        0 => self.gamma,
        1 => 0.0,
        _ => 2.0 * self.gamma,
    })
});
row!(
    PlaceInline,
    { friction = |q: [f64; 3]| q.map(|x| self.gamma * (1.0 + x * x)) },
    PlaceLoops,
    PlaceInLoops,
    { friction = |q: [f64; N]| q.map(|x| self.gamma * (1.0 + x * x)) }
);
row!(
    MatrixInline,
    { damping = [[self.gamma, 0.1, 0.0], [0.1, 0.5, -0.2], [0.0, -0.2, 0.7]] },
    MatrixLoops,
    MatrixInLoops,
    {
        damping = (0..N).map(move |i| {
            (0..N).map(move |j| match i + 10 * j {
                0 => self.gamma,
                11 => 0.5,
                22 => 0.7,
                1 | 10 => 0.1,
                12 | 21 => -0.2,
                _ => 0.0,
            })
        })
    }
);

fn same<E, A: Discretized<E>, B: Discretized<E>>(a: &A, b: &B) {
    let (normals, others) = (a.increments(3), b.increments(3));
    assert_eq!(normals, others);
    let start: [&[f64]; 2] = [&[0.3, -0.5, 0.8], &[0.2, 0.1, -0.4]];
    // A dozen roundings of numbers of size one.
    assert!(fixtures::steps::apart::<E, _, _>((a, b), start, (0.1, 20), &vec![0.3; normals]) < 1e-14);
}

const MASS: [f64; 3] = [1.0, 2.0, 0.5];

#[test]
fn loops_have_the_friction_of_straight_lines() {
    let (mass, gamma, kt) = (MASS, 0.8, 1.3);
    macro_rules! same {
        ($a:ident, $b:ident, $($scheme:ty),*) => {
            $(same::<$scheme, _, _>(&$a { mass, gamma, kt }, &$b { mass, gamma, kt });)*
        };
    }
    same!(UniformInline, UniformLoops, Baoab, Obabo, Thermostat<Verlet>, Thermostat<Gauss<2>>);
    same!(UniformInline, UniformLoops, Thermostat<Midpoint>);
    // The maps are the same in all of them.
    same!(ListInline, ListLoops, Baoab, Thermostat<Midpoint>);
    same!(PlaceInline, PlaceLoops, Baoab, Thermostat<Midpoint>);
    same!(MatrixInline, MatrixLoops, Baoab, Thermostat<Midpoint>);
}

/// What a thermostat reads of a system: a damping of these numbers, which is a matrix or not, and depends on the state or not.
fn reads<H: Elements>(system: &H, expected: &[f64], is_matrix: bool, is_per_state: bool) {
    let (mut damping, mut inverse) = (vec![0.0; expected.len()], vec![0.0; 3]);
    let bath = H::FACTS.bath.unwrap();
    bath.damping((system, &[]), &[0.5, 0.0, 2.0], &mut damping, &mut Default::default());
    bath.inverse_mass((system, &[]), &mut inverse);
    assert_eq!((&damping[..], &inverse[..]), (expected, &[1.0, 0.5, 2.0][..]));
    let mut temperature = [0.0];
    bath.temperatures((system, &[]), 0.0, &mut temperature).unwrap();
    assert_eq!(temperature, [1.3]);
    assert_eq!(
        [bath.is_matrix, bath.is_per_state, bath.has_diagonal_masses],
        [is_matrix, is_per_state, true]
    );
}

#[test]
fn thermostats_read_what_was_declared() {
    let (mass, gamma, kt) = (MASS, 0.8, 1.3);
    macro_rules! read {
        ($($a:ident $b:ident: $damping:expr, $is_matrix:expr, $is_per_state:expr;)*) => {$(
            reads(&$a { mass, gamma, kt }, &$damping, $is_matrix, $is_per_state);
            reads(&$b { mass, gamma, kt }, &$damping, $is_matrix, $is_per_state);
        )*};
    }
    read! {
        UniformInline UniformLoops: [0.8; 3], false, false;
        ListInline ListLoops: [0.8, 0.0, 1.6], false, false;
        PlaceInline PlaceLoops: [1.0, 0.8, 4.0], false, true;
        MatrixInline MatrixLoops: [0.8, 0.1, 0.0, 0.1, 0.5, -0.2, 0.0, -0.2, 0.7], true, false;
    }
}

row!(ForcedInline, {
    friction = self.gamma, force = |_q: [f64; 3], _p: [f64; 3]| [1.0, 0.0, 0.0]
}, ForcedLoops, ForcedInLoops, {
    friction = self.gamma, force = |_q: [f64; N], _p: [f64; N]| (0..N).map(|i| if i == 0 { 1.0 } else { 0.0 })
});

#[test]
fn kicks_are_written_with_the_forces_there_are() {
    let kick = |text: &str, slope: &str| text.matches(&format!("p <- p - h/2 {slope}\n")).count();
    for text in
        [<UniformInline as Discretized<Baoab>>::EQUATIONS, <UniformLoops as Discretized<Obabo>>::EQUATIONS]
    {
        assert_eq!((kick(text, "∂V/∂q"), kick(text, "(∂V/∂q - F)")), (2, 0), "{text}");
    }
    for text in
        [<ForcedInline as Discretized<Baoab>>::EQUATIONS, <ForcedLoops as Discretized<Obabo>>::EQUATIONS]
    {
        assert_eq!((kick(text, "∂V/∂q"), kick(text, "(∂V/∂q - F)")), (0, 2), "{text}");
    }
}
