use super::*;

/// The coefficients of trees with up to three vertices: `H`, `H_p · H_q`, and `H_pp(H_q, H_q)`,
/// `H_qq(H_p, H_p)`, `H_pq(H_q, H_p)`.
fn leading(series: &series::TreeSeries) -> [f64; 5] {
    use tree::{PhaseHalf, Tree};
    let leaf = Tree::default();
    let pair = |a: PhaseHalf, b: PhaseHalf| Tree::new(vec![(a, leaf.clone()), (b, leaf.clone())]).free();
    let (q, p) = (PhaseHalf::Coordinates, PhaseHalf::Momenta);
    let wanted = [leaf.clone(), leaf.joined(p, &leaf).free(), pair(p, p), pair(q, q), pair(q, p)];
    wanted.map(|tree| {
        series.terms().filter(|(_, (own, _))| *own == tree).map(|(coefficient, _)| coefficient).sum()
    })
}

/// A few roundings of numbers below one.
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-15
}

#[test]
fn schemes_with_one_quadrature_point_have_the_terms_of_the_formula() {
    for l in [0.0, 0.5, 1.0, 1.0 / 3.0, 0.9] {
        let [h, edge, by_p, by_q, mixed] = leading(&modified(&[(l, 1.0)], 1));
        let s = l * (1.0 - l);
        assert!(close(h, 1.0) && close(edge, l - 0.5), "{l}");
        assert!(close(by_p, 1.0 / 12.0 - s / 2.0) && close(by_q, by_p) && close(mixed, 1.0 / 3.0 - s), "{l}");
    }
    let [_, edge, by_p, by_q, mixed] = leading(&modified(&Verlet::parts(), 2));
    assert!(close(edge, 0.0));
    assert!(close(by_p, -1.0 / 24.0) && close(by_q, 1.0 / 12.0) && close(mixed, 1.0 / 12.0));
}

/// The adjoint of a step is its inverse with `-h`: terms with an odd power of `h` change their sign.
#[test]
fn adjoint_schemes_have_adjoint_series_and_symmetric_ones_even_powers() {
    let of = |parts: &[(f64, f64)]| modified(parts, 6);
    for ((plus, (_, size)), (minus, _)) in of(&[(0.2, 1.0)]).terms().zip(of(&[(0.8, 1.0)]).terms()) {
        let sign = if size % 2 == 1 { 1.0 } else { -1.0 };
        assert!(close(plus, sign * minus));
    }
    for parts in
        [Midpoint::parts(), Verlet::parts(), Composed::<Verlet, crate::scheme::compose::BlanesMoan4>::parts()]
    {
        for (coefficient, (_, size)) in of(&parts).terms() {
            assert!(size % 2 == 1 || close(coefficient, 0.0), "{size}: {coefficient}");
        }
    }
}

/// Steps backwards undo steps forwards; successive steps of the exact flow add up to `H` alone.
#[test]
fn inverse_steps_leave_nothing() {
    for l in [0.0, 0.3] {
        let left = modified(&[(l, 0.7), (1.0 - l, -0.7)], 6);
        assert!(left.coefficients.iter().all(|c| close(*c, 0.0)), "{:?}", left.coefficients);
    }
}

/// Terms below the order vanish for every Hamiltonian, and the next does not.
#[test]
fn compositions_have_the_order_that_they_say() {
    fn check<E: ModifiedBy>(name: &str) {
        let of_size = |wanted: usize| {
            let series = modified(&E::parts(), E::ORDER);
            let of_size = series.terms().filter(|(_, (_, size))| *size == wanted);
            of_size.map(|(c, _)| c.abs()).fold(0.0, f64::max)
        };
        for size in 2..=E::ORDER as usize {
            assert!(of_size(size) < 1e-14, "{name}, {size}: {}", of_size(size));
        }
        assert!(of_size(E::ORDER as usize + 1) > 1e-7, "{name}: {}", of_size(E::ORDER as usize + 1));
    }
    use crate::scheme::compose::{BlanesMoan4, BlanesMoan6, KahanLi6, Suzuki4, Yoshida4, Yoshida6};
    macro_rules! check {
        ($($scheme:ty),+ $(,)?) => {$(check::<$scheme>(stringify!($scheme));)+};
    }
    check!(
        DeltaPlus, DeltaMinus, Lambda<1, 3>, Midpoint, Verlet, Composed<Midpoint, Yoshida4>, Composed<Verlet, Yoshida4>,
        Composed<Verlet, Suzuki4>, Composed<Verlet, BlanesMoan4>, Composed<Midpoint, Yoshida6>, Composed<Verlet, BlanesMoan6>,
        Composed<Midpoint, KahanLi6>,
    );
}
