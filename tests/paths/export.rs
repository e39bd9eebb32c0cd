//! Systems as programs in other languages see them, and make them.

use std::collections::HashMap;

use wzvi::embedding::{Composed, KahanLi8};
use wzvi::error::ConfigError;
use wzvi::exported::{Exported, FieldDescription, Given, GivenFields, GivenNumbers};
use wzvi::prelude::*;

/// A pendulum of length `length`.
///
/// Its drive is switched by a field.
#[hamiltonian(
    drift = |q, p, t| 0.5 * p * p - omega * omega * q.cos()
        - q * (0.3 * t).sin(),
    noise = [|q, p| sigma * q, [|q, p, k| sigma * (k as f64 + 1.0) * q; 2]],
    observe = [height = |q, _| 1.0 - q.cos()],
    friction = 0.1 * omega,
    temperature = kt,
    embedding = [Baoab, Thermostat<Midpoint>],
    export = [Gjf],
)]
#[derive(Debug, PartialEq)]
struct Pendulum {
    /// The frequency of small swings,
    /// in 1/time.
    omega: f64,
    sigma: f64,
    /// `kT`
    kt: f64,
}

/// GivenFields of all types.
#[hamiltonian(
    drift = |q: [f64; N], p: [f64; N]| (0..N).map(|i| 0.5 * p[i] * p[i] + q[i] * q[i]).sum::<f64>(),
    invariant = |q, p| (0..N).map(|i| 0.5 * p[i] * p[i] + q[i] * q[i]).sum::<f64>(),
    embedding = Verlet,
    export = [Composed<Verlet, KahanLi8>, Verlet],
)]
#[derive(Debug, PartialEq)]
struct Everything<const N: usize> {
    real: f64,
    flag: bool,
    small: i8,
    site: usize,
    pair: [f64; 2],
    bonds: Vec<[usize; 2]>,
    couplings: Vec<Vec<f64>>,
    boxed: Box<[i64]>,
    r#type: u32,
}

/// Without fields.
#[hamiltonian(
    drift = |q, p| 0.5 * p * p + 0.25 * q.powi(4),
    clock = curvature(1.0),
    embedding = [Verlet, Clocked<Verlet>],
    export = [],
)]
struct Oscillator;

#[hamiltonian(drift = |q, p| 0.5 * (self.0 * q * q + p * p), embedding = Verlet, export = [])]
struct Spring(f64);

/// Values by name, each with its shape.
#[derive(Default)]
struct Values {
    reals: HashMap<&'static str, (Vec<f64>, Vec<usize>)>,
    integers: HashMap<&'static str, (Vec<i64>, Vec<usize>)>,
}

impl Values {
    fn real(mut self, name: &'static str, values: &[f64], shape: &[usize]) -> Self {
        self.reals.insert(name, (values.to_vec(), shape.to_vec()));
        self.integers.remove(name);
        self
    }

    fn integer(mut self, name: &'static str, values: &[i64], shape: &[usize]) -> Self {
        self.integers.insert(name, (values.to_vec(), shape.to_vec()));
        self.reals.remove(name);
        self
    }
}

impl GivenFields for Values {
    fn given(&self, name: &str) -> Option<Given<'_>> {
        if let Some((values, shape)) = self.reals.get(name) {
            return Some(Given { values: GivenNumbers::Reals(values), shape });
        }
        let (values, shape) = self.integers.get(name)?;
        Some(Given { values: GivenNumbers::Integers(values), shape })
    }
}

#[test]
fn systems_describe_themselves() {
    assert_eq!(Pendulum::NAME, "Pendulum");
    assert_eq!(Pendulum::DOC, "A pendulum of length `length`.\n\nIts drive is switched by a field.");
    let fields = [
        FieldDescription { name: "omega", ty: "f64", doc: "The frequency of small swings,\nin 1/time." },
        FieldDescription { name: "sigma", ty: "f64", doc: "" },
        FieldDescription { name: "kt", ty: "f64", doc: "`kT`" },
    ];
    assert_eq!(Pendulum::FIELDS, fields);
    let closures = [
        ("drift", "|q, p, t| 0.5 * p * p - omega * omega * q.cos() - q * (0.3 * t).sin()"),
        ("noise", "|q, p| sigma * q"),
        ("noise", "[|q, p, k| sigma * (k as f64 + 1.0) * q; 2]"),
        ("observe", "height = |q, _| 1.0 - q.cos()"),
        ("friction", "0.1 * omega"),
        ("temperature", "kt"),
    ];
    assert_eq!(Pendulum::CLOSURES, closures);
    assert_eq!(Pendulum::SCHEMES, ["Baoab", "Thermostat<Midpoint>", "Gjf"]);

    assert_eq!(Everything::<2>::NAME, "Everything");
    let types: Vec<(&str, &str)> =
        Everything::<2>::FIELDS.iter().map(|field| (field.name, field.ty)).collect();
    assert_eq!(types[3..6], [("site", "usize"), ("pair", "[f64; 2]"), ("bonds", "Vec<[usize; 2]>")]);
    assert_eq!(types[6..], [("couplings", "Vec<Vec<f64>>"), ("boxed", "Box<[i64]>"), ("type", "u32")]);
    assert_eq!(Everything::<2>::SCHEMES, ["Verlet", "Composed<Verlet, KahanLi8>"]);
    assert_eq!(Oscillator::SCHEMES, ["Verlet", "Clocked<Verlet>"]);
    assert_eq!(Oscillator::CLOSURES[1], ("clock", "curvature(1.0)"));
    assert_eq!((Oscillator::DOC, Oscillator::FIELDS.len()), ("Without fields.", 0));
    assert_eq!(Spring::FIELDS[0].name, "0");
}

/// What is done with the schemes of a list.
trait Names {
    fn names() -> Vec<&'static str>;
}

impl Names for () {
    fn names() -> Vec<&'static str> {
        Vec::new()
    }
}

impl<E, R: Names> Names for (E, R) {
    fn names() -> Vec<&'static str> {
        let mut all = vec![std::any::type_name::<E>()];
        all.extend(R::names());
        all
    }
}

#[test]
fn schemes_are_a_list_of_types() {
    let names = <Everything<2> as Exported>::Schemes::names();
    let ends = ["::Verlet", "KahanLi8>"];
    assert_eq!(names.len(), ends.len());
    assert!(names.iter().zip(ends).all(|(name, end)| name.ends_with(end)), "{names:?}");
    assert_eq!(<Oscillator as Exported>::Schemes::names().len(), 2);
}

fn everything() -> Values {
    Values::default()
        .real("real", &[1.5], &[])
        .integer("flag", &[1], &[])
        .integer("small", &[-3], &[])
        .integer("site", &[7], &[])
        .real("pair", &[0.5, 0.25], &[2])
        .integer("bonds", &[0, 1, 1, 2, 2, 0], &[3, 2])
        .real("couplings", &[1.0, 2.0, 3.0, 4.0], &[2, 2])
        .integer("boxed", &[5, 6], &[2])
        .integer("type", &[9], &[])
}

#[test]
fn systems_are_made_of_named_numbers() {
    let expected = Everything::<2> {
        real: 1.5,
        flag: true,
        small: -3,
        site: 7,
        pair: [0.5, 0.25],
        bonds: vec![[0, 1], [1, 2], [2, 0]],
        couplings: vec![vec![1.0, 2.0], vec![3.0, 4.0]],
        boxed: Box::new([5, 6]),
        r#type: 9,
    };
    assert_eq!(Everything::<2>::from_fields(&everything()).unwrap(), expected);
    let whole = everything().integer("real", &[2], &[]).integer("pair", &[1, 2], &[2]);
    let whole = Everything::<2>::from_fields(&whole).unwrap();
    assert_eq!((whole.real, whole.pair), (2.0, [1.0, 2.0]));
    assert_eq!(Spring::from_fields(&Values::default().real("0", &[4.0], &[])).unwrap().0, 4.0);
    assert!(Oscillator::from_fields(&Values::default()).is_ok());
}

#[test]
fn fields_that_do_not_fit_are_errors() {
    let said = |values: Values| match Everything::<2>::from_fields(&values) {
        Err(ConfigError::Setting(text)) => text,
        other => panic!("{other:?}"),
    };
    let mut missing = everything();
    missing.reals.remove("pair");
    assert_eq!(said(missing), "the parameter `pair` is missing");
    let large = (1_i64 << 53) + 1;
    let cases = [
        (
            everything().real("real", &[1.0], &[1]),
            "`real` has to be a real number, not an array of shape [1]",
        ),
        (everything().integer("real", &[large], &[]), "`real` has to be a real number, not 9007199254740993"),
        (everything().integer("flag", &[2], &[]), "`flag` has to be true or false, 1 or 0, not 2"),
        (
            everything().integer("small", &[128], &[]),
            "`small` has to be an integer from -128 to 127, not 128",
        ),
        (everything().real("type", &[9.5], &[]), "`type` has to be an integer from 0 to 4294967295, not 9.5"),
        (everything().real("pair", &[0.5], &[]), "`pair` has to be an array, not 0.5"),
        (everything().real("pair", &[0.5; 3], &[3]), "`pair` has to be an array of length 2, not 3"),
        (
            everything().integer("bonds", &[0, -1], &[1, 2]),
            "`bonds` has to be an array with an array with an integer from 0 to 18446744073709551615, not -1 at index 1 at index 0",
        ),
        (
            everything().real("couplings", &[1.0], &[1, 2]),
            "`couplings` has to be an array with as many numbers as its shape says",
        ),
    ];
    for (values, expected) in cases {
        assert_eq!(said(values), format!("the parameter {expected}"));
    }
}
