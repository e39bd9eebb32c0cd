//! Splittings with letters of one's own.

use fixtures::bath::Oscillator;
use wzvi::bath::{A, B, HarmonicLaw, Letters, O};
use wzvi::prelude::*;

#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.5 * k * q * q,
    friction = gamma,
    temperature = kt,
    embedding = [
        Baoab, Obabo, Splitting<(B, A, O, A, B)>, Splitting<(O, B, A, B, O)>, Splitting<(B, A, O, A)>,
        Splitting<(O, B<1, 4>, A<1, 2>, B<1, 2>, A, B<1, 4>, O)>,
        Splitting<(O, A, O, A, B)>, Splitting<(B, A<1, 4>, O, A<3, 4>, B)>, Splitting<(O, B, A, O, A, B, O)>,
    ],
)]
#[derive(Clone)]
struct Spring {
    k: f64,
    gamma: f64,
    kt: f64,
}

type Uneven = Splitting<(O, B<1, 4>, A<1, 2>, B<1, 2>, A, B<1, 4>, O)>;

/// `k <q²>`, `<q p>`, `<p²>`, and the factors of diffusion and mobility, to 18 digits, for `m = kT = 1`, `h = 0.3`, `γ = 1.3`, `k = 2`.
#[test]
#[allow(clippy::excessive_precision, reason = "as the reference has them")]
fn harmonic_laws_are_those_of_the_reference() {
    fn row<W: Letters>(exact: [f64; 5]) -> (&'static str, HarmonicLaw, [f64; 5]) {
        (std::any::type_name::<W>(), HarmonicLaw::of::<W>(2.0_f64.sqrt() * 0.3, 1.3 * 0.3), exact)
    }
    // Of drifts that are together, and of friction that acts twice.
    let (coth, twice) = (1.012642984794805959, 0.993690502447383570);
    let rows = [
        row::<(B, A, O, A, B)>([1.0, 0.0, 0.955, coth, coth]),
        row::<(A, B, O, B, A)>([1.0, 0.0, 1.047120418848167539, coth, coth]),
        row::<(O, B, A, B, O)>([1.047120418848167539, 0.0, 1.0, coth, coth]),
        row::<(O, A, B, A, O)>([0.955, 0.0, 1.0, coth, coth]),
        row::<(B, O, A, O, B)>([
            1.066151722282911735,
            -0.03079558970439541,
            1.001779049501905335,
            coth,
            twice,
        ]),
        row::<(A, O, B, O, A)>([1.019072822272874579, 0.0, 1.046197778000825692, coth, twice]),
        row::<(B, A, O, A)>([1.0, 0.15, 1.0, coth, coth]),
        row::<(O, B, A, B)>([1.047120418848167539, 0.0, 1.0, coth, coth]),
        row::<Gjf>([1.0, 0.0, 0.955, 1.0, 1.0]),
        row::<GjI>([1.0, 0.0, 0.955561831093790229, 1.0, 1.0]),
    ];
    for (word, law, exact) in rows {
        let HarmonicLaw { q, qp, p, diffusion, mobility } = law;
        let ours = [q, qp / 2.0_f64.sqrt(), p, diffusion, mobility];
        for (ours, exact) in ours.into_iter().zip(exact) {
            // A system of three equations with a condition below ten.
            assert!((ours - exact).abs() < 1e-14, "{word}: {ours} {exact}");
        }
    }
    let unstable = HarmonicLaw::of::<Baoab>(2.1, 0.3);
    assert!(unstable.q.is_nan() && unstable.p.is_nan());
}

#[test]
fn orders_and_symmetry_are_found() {
    assert_eq!(
        <Spring as Discretized<Splitting<(B, A, O, A, B)>>>::PLAN,
        <Spring as Discretized<Baoab>>::PLAN
    );
    assert_eq!(<Spring as Discretized<Splitting<(B, A, O, A)>>>::PLAN.order, 1);
    assert_eq!(<Spring as Discretized<Uneven>>::PLAN.order, 2);
    let text = <Spring as Discretized<Uneven>>::EQUATIONS;
    for line in [
        "Splitting<(O, B<1, 4>, A<1, 2>, B<1, 2>, A, B<1, 4>, O)>",
        "  kick of h/4:  p <- p - h/4 ∂V/∂q",
        "  of order 2, symmetric",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
    let text = <Spring as Discretized<Splitting<(B, A, O, A)>>>::EQUATIONS;
    assert!(text.contains("of order 1, not symmetric"), "{text}");
}

/// What the equations say of the diffusion is what `HarmonicLaw` computes: `coth` where drifts are together, with another coefficient of `(γh)²` where friction is
/// between them.
#[test]
fn words_say_how_fast_a_free_particle_diffuses() {
    fn check<W: Letters>(said: &str, coefficient: f64)
    where
        Spring: Discretized<Splitting<W>>,
    {
        let text = <Spring as Discretized<Splitting<W>>>::EQUATIONS;
        let line = text.lines().find(|line| line.contains("diffuses")).expect("a fact");
        // The next power of the series is x² = 1e-4 of it, times less than one.
        let excess = (HarmonicLaw::of::<W>(0.1, 0.01).diffusion - 1.0) / 1e-4;
        assert!(line.contains(said) && (excess / coefficient - 1.0).abs() < 1e-3, "{line} {excess}");
    }
    check::<(B, A, O, A, B)>("(γh/2) coth(γh/2)", 1.0 / 12.0);
    check::<(O, A, O, A, B)>("HarmonicLaw::of", 1.0 / 48.0);
    check::<(O, B, A, O, A, B, O)>("HarmonicLaw::of", 1.0 / 36.0);
}

/// The named words are words.
#[test]
fn words_have_the_bits_of_their_names() {
    let spring = Spring { k: 1.3, gamma: 0.7, kt: 0.4 };
    let start = State::new([0.3], [0.8]);
    let seed = || StepNormals::seed(11);
    let baoab = spring.simulate::<Baoab>(0.1).start(start).noise(seed()).steps(100).run().unwrap();
    let word = spring.simulate::<Splitting<(B, A, O, A, B)>>(0.1).start(start).noise(seed()).steps(100);
    assert_eq!(word.run().unwrap().states(), baoab.states());
    let obabo = spring.simulate::<Obabo>(0.1).start(start).noise(seed()).steps(100).run().unwrap();
    let word = spring.simulate::<Splitting<(O, B, A, B, O)>>(0.1).start(start).noise(seed()).steps(100);
    assert_eq!(word.run().unwrap().states(), obabo.states());
    let paths = spring.ensemble::<Uneven>(0.1).start(start).paths(9).seed(11).steps(30).keep_paths(1 << 20);
    let paths = paths.run().unwrap();
    for path in 0..9 {
        let single = spring.simulate::<Uneven>(0.1).start(start).noise(seed().path(path)).steps(30);
        let last = *single.run().unwrap().last();
        let kept = paths.paths().unwrap().at(path as usize, 1).unwrap();
        // Exponentials of lanes differ from those of single numbers in the last digit.
        assert!((kept[0] - last.q[0]).abs() + (kept[1] - last.p[0]).abs() < 1e-13, "{path}");
    }
}

/// An O part between two drifts is one of several, or the drifts are of different lengths.
#[test]
fn letters_are_taken_one_after_the_other() {
    fn check<W>(letters: &[(char, f64)])
    where
        Spring: Discretized<W>,
    {
        let (h, spring) = (0.3_f64, Spring { k: 1.3, gamma: 0.7, kt: 0.4 });
        let normals = [0.6, -1.1, 0.4];
        let parts = letters.iter().filter(|letter| letter.0 == 'O').count();
        let mut state = State::new([0.3], [0.8]);
        spring.stepper::<W>(h).unwrap().plain().step(&mut state, &normals[..parts]).unwrap();
        let (mut q, mut p, mut normals) = (0.3, 0.8, normals.into_iter());
        for &(letter, share) in letters {
            match letter {
                'A' => q += share * h * p,
                'B' => p -= share * h * spring.k * q,
                _ => {
                    let decay = (-spring.gamma * h / parts as f64).exp();
                    // Increments are those of a Wiener process.
                    let normal = normals.next().unwrap() / h.sqrt();
                    p = decay * p + ((1.0 - decay * decay) * spring.kt).sqrt() * normal;
                }
            }
        }
        // A dozen roundings of numbers of size one.
        assert!(
            (state.q[0] - q).abs() < 1e-14 && (state.p[0] - p).abs() < 1e-14,
            "{letters:?}: {state} {q} {p}"
        );
    }
    let (half, o) = (0.5, ('O', 0.0));
    check::<Splitting<(O, A, O, A, B)>>(&[o, ('A', half), o, ('A', half), ('B', 1.0)]);
    check::<Splitting<(B, A<1, 4>, O, A<3, 4>, B)>>(&[('B', half), ('A', 0.25), o, ('A', 0.75), ('B', half)]);
    check::<Splitting<(O, B, A, O, A, B, O)>>(&[o, ('B', half), ('A', half), o, ('A', half), ('B', half), o]);
}

/// The law of the steps is the one that is computed.
#[test]
fn paths_of_a_word_have_its_law() {
    let (h, spring) = (0.6, Spring { k: 2.0, gamma: 0.9, kt: 0.4 });
    let law = HarmonicLaw::of::<(O, B<1, 4>, A<1, 2>, B<1, 2>, A, B<1, 4>, O)>(
        spring.k.sqrt() * h,
        spring.gamma * h,
    );
    let found = fixtures::bath::stationary::<Uneven, _>(&spring, h);
    for (found, exact) in [(found.m11 * spring.k, law.q), (found.m22, law.p)] {
        // Sums of some hundred terms.
        assert!((found / spring.kt - exact).abs() < 1e-12, "{found} {exact}");
    }
    // It is not the Gibbs measure: the test sees the difference.
    assert!((law.p - 1.0).abs() > 0.02 || (law.q - 1.0).abs() > 0.02, "{law:?}");
}

/// What the O parts need is read by their number, wherever they stand.
#[test]
fn a_system_with_a_word_is_one_with_friction() {
    assert_eq!(<(O, B, A, B, O) as Letters>::LETTERS.len(), 5);
    let spring = Spring { k: 1.0, gamma: 0.5, kt: 0.2 };
    assert_eq!(Discretized::<Uneven>::increments(&spring, 1), 2);
    let oscillator = Oscillator { m: 1.0, k: 1.0, b: 0.0, gamma: 0.5, kt: 0.2 };
    assert_eq!(Discretized::<Baoab>::increments(&oscillator, 1), 1);
}
