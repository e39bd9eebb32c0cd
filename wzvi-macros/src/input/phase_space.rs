//! The phase space, declared by the patterns of the drift and repeated by all other closures. Tests:
//! `tests/accepted/phase_spaces.rs`.

use std::fmt;

use proc_macro2::TokenStream;
use quote::quote;
use syn::ext::IdentExt;
use syn::{Pat, Type};

use super::attribute::{Declaration, Hamiltonian};
use super::rotations::{are_rotations, declare_rotations, is_rotation};
use super::system::literal;
use crate::diagnostics::{Diagnostics, messages, source};
use crate::key::Key;
use crate::tokens::Written;

/// Degrees of freedom that are variables of their own in the symbolic graph.
const DEGREES: usize = 1024;

/// The arrangement of coordinates (and momenta).
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Shape {
    Real,
    Array(Box<Shape>, Length),
}

/// The number of elements of an array.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Length {
    Literal(usize),
    /// A constant or a const generic of the struct, as it was written.
    Named(Box<Written<syn::Expr>>),
    /// The length of the state: `&[f64]`.
    RunTime,
}

/// The displayed names of the components of coordinates or momenta.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum Labels {
    /// A name each.
    Each(Vec<String>),
    /// Elements of a named array, which are arrays of these lengths.
    Array(String, Vec<usize>),
}

/// The names that a pattern gives to coordinates or momenta.
enum Bound {
    /// An array or a number as a whole; without a name it is `_`.
    Whole(Option<String>),
    Each(Vec<Bound>),
}

impl Bound {
    /// The name of the whole.
    fn name(&self, fallback: &str) -> String {
        match self {
            Self::Whole(Some(name)) => name.clone(),
            _ => fallback.to_owned(),
        }
    }

    fn labels(&self, shape: &Shape, fallback: &str) -> Labels {
        match (self, shape) {
            (Self::Whole(_), Shape::Array(element, _)) => {
                Labels::Array(self.name(fallback), element.lengths())
            }
            _ => Labels::Each(self.components(shape, fallback)),
        }
    }

    /// A name for each number if the size is known, derived from `fallback` if there is none.
    fn components(&self, shape: &Shape, fallback: &str) -> Vec<String> {
        let name = self.name(fallback);
        let Shape::Array(element, Length::Literal(length)) = shape else { return vec![name] };
        let part = |i: usize| match self {
            Self::Whole(_) => Some(&Self::Whole(None)),
            Self::Each(parts) => parts.get(i),
        };
        let parts = (0..*length).filter_map(|i| Some((part(i)?, format!("{name}[{i}]"))));
        parts.flat_map(|(part, name)| part.components(element, &name)).collect()
    }
}

/// The arrangement and the names of coordinates, momenta and time.
pub(crate) struct PhaseSpace {
    /// Whether the drift declares it; otherwise the drift has a mistake.
    pub(crate) is_of_drift: bool,
    pub(crate) shape: Shape,
    /// Names of the coordinates and the momenta as a whole.
    pub(crate) names: [String; 2],
    /// Names in the order of the state vector (row-major), if the compiler knows the size.
    pub(crate) q: Vec<String>,
    pub(crate) p: Vec<String>,
    /// The displayed names, for any size.
    pub(crate) labels: [Labels; 2],
    pub(crate) t: String,
}

impl PhaseSpace {
    /// The number of degrees of freedom, if the compiler knows it.
    pub(crate) fn degrees(&self) -> Option<usize> {
        self.shape.size()
    }
}

impl Shape {
    /// Three rows of three numbers.
    fn matrix() -> Self {
        let three = |element| Self::Array(Box::new(element), Length::Literal(3));
        three(three(Self::Real))
    }

    /// Number of reals; `None` if it overflows or is no literal.
    fn size(&self) -> Option<usize> {
        match self {
            Self::Real => Some(1),
            Self::Array(element, Length::Literal(len)) => element.size()?.checked_mul(*len),
            Self::Array(..) => None,
        }
    }

    /// The lengths of arrays in arrays, from the outside in, as far as they are literals.
    pub(crate) fn lengths(&self) -> Vec<usize> {
        match self {
            Self::Array(element, Length::Literal(length)) => [vec![*length], element.lengths()].concat(),
            _ => Vec::new(),
        }
    }

    /// The Rust type, independent of the user's names.
    pub(crate) fn tokens(&self) -> TokenStream {
        match self {
            Self::Real => quote! { ::core::primitive::f64 },
            Self::Array(element, len) => {
                let element = element.tokens();
                match len {
                    Length::Literal(len) => quote! { [#element; #len] },
                    Length::Named(len) => quote! { [#element; #len] },
                    Length::RunTime => quote! { &[#element] },
                }
            }
        }
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Real => f.write_str("f64"),
            Self::Array(element, Length::Literal(len)) => write!(f, "[{element}; {len}]"),
            Self::Array(element, Length::Named(len)) => write!(f, "[{element}; {}]", source(len)),
            Self::Array(element, Length::RunTime) => write!(f, "&[{element}]"),
        }
    }
}

/// Reads the phase space from the drift and checks that the other closures agree with it. Closures that do
/// not are reported and removed, to avoid consequential errors in their bodies. If the drift declares none,
/// the next closure does, so that the others are still read.
pub(crate) fn read_phase_space(
    declaration: &mut Declaration,
    diagnostics: &mut Diagnostics,
) -> Option<PhaseSpace> {
    declare_rotations(declaration, diagnostics);
    let mut phase_space: Option<PhaseSpace> = None;
    let mut is_first = true;
    declaration.closures.sort_by_key(|closure| closure.key);
    declaration.closures.retain(|closure| {
        let is_drift = std::mem::take(&mut is_first) && closure.key == Key::Drift;
        match &phase_space {
            Some(known) if known.is_of_drift => diagnostics.accept(repeats(closure, known)).is_some(),
            Some(known) => {
                diagnostics.accept(declared(closure)).is_some_and(|found| found.shape == known.shape)
            }
            None => {
                let found = diagnostics.accept(declared(closure));
                phase_space = found.map(|found| PhaseSpace { is_of_drift: is_drift, ..found });
                phase_space.is_some()
            }
        }
    });
    check_times(declaration, diagnostics);
    phase_space
}

/// In a system with noise a third parameter with another name than the time's may be meant as a noise.
fn check_times(declaration: &Declaration, diagnostics: &mut Diagnostics) {
    let is_noise = |closure: &Hamiltonian| matches!(closure.key, Key::Noise | Key::NoiseForce);
    if !declaration.closures.iter().any(is_noise) {
        return;
    }
    for closure in &declaration.closures {
        if let Ok(ClosureParameters { t: Some(pattern), .. }) = parameters(closure)
            && time(pattern).is_ok_and(|name| !is_usual_time(&name))
        {
            diagnostics.report(messages::third_name(pattern));
        }
    }
}

/// The name of the time in a closure of it; `None` for a pattern of something else.
pub(crate) fn name_of_time(pattern: &Pat) -> Option<String> {
    time(pattern).ok()
}

/// Whether the time may have this name.
pub(crate) fn is_usual_time(name: &str) -> bool {
    let name = name.trim_matches('_').to_lowercase();
    let is_numbered = name.strip_prefix('t').is_some_and(|rest| !rest.starts_with(char::is_alphabetic));
    is_numbered || ["", "tau", "τ", "s", "now"].contains(&name.as_str()) || name.contains("time")
}

/// The phase space of the drift.
fn declared(drift: &Hamiltonian) -> syn::Result<PhaseSpace> {
    let ClosureParameters { q, p, t } = parameters(drift)?;
    let (q_shape, q_names) = bound(q)?;
    let (p_shape, p_names) = match p {
        // The type of the coordinates is not that of their momenta, which have the same shape.
        Some(p) if are_rotations(q) && bare_name(p).is_some() => (None, bound(p)?.1),
        Some(p) => bound(p)?,
        None => (None, Bound::Whole(None)),
    };
    let shape = match (q_shape, p_shape) {
        (Some(q_shape), Some(p_shape)) if q_shape != p_shape => {
            return Err(messages::momenta_disagree(p, &q_shape, &p_shape));
        }
        (Some(shape), _) | (None, Some(shape)) => shape,
        (None, None) => Shape::Real,
    };
    let has_names = shape.size().is_some_and(|size| size <= DEGREES);
    let are_arrays = [&q_names, &p_names].iter().all(|names| matches!(names, Bound::Whole(_)));
    if !(has_names || are_arrays) {
        return Err(messages::too_many_degrees(q, DEGREES));
    }
    let components = |names: &Bound, fallback| match has_names {
        true => names.components(&shape, fallback),
        false => Vec::new(),
    };
    Ok(PhaseSpace {
        is_of_drift: false,
        names: [q_names.name("q"), p_names.name("p")],
        q: components(&q_names, "q"),
        p: components(&p_names, "p"),
        labels: [q_names.labels(&shape, "q"), p_names.labels(&shape, "p")],
        t: t.map_or(Ok("t".to_owned()), time)?,
        shape,
    })
}

/// The pattern inside of parentheses.
fn peeled(mut pattern: &Pat) -> &Pat {
    while let Pat::Paren(inner) = pattern {
        pattern = &inner.pat;
    }
    pattern
}

/// Whether the patterns of another closure describe `expected`.
fn repeats(closure: &Hamiltonian, known: &PhaseSpace) -> syn::Result<()> {
    let ClosureParameters { q, p, t } = parameters(closure)?;
    let expected = &known.shape;
    for pattern in [q].into_iter().chain(p) {
        // One mention of an array is enough.
        if bare_name(pattern).is_some() {
            continue;
        }
        match bound(pattern)?.0 {
            Some(found) if found != *expected => {
                return Err(messages::shapes_disagree(pattern, &found, expected, *expected == Shape::Real));
            }
            _ => {}
        }
    }
    t.map_or(Ok(()), |t| time(t).map(|_| ()))
}

/// A name without a type.
fn bare_name(pattern: &Pat) -> Option<&syn::Ident> {
    match peeled(pattern) {
        Pat::Ident(ident) if ident.by_ref.is_none() && ident.mutability.is_none() => {
            ident.subpat.is_none().then_some(&ident.ident)
        }
        _ => None,
    }
}

/// The patterns of a closure; the index of a family comes after them.
struct ClosureParameters<'c> {
    q: &'c Pat,
    /// A constraint has none.
    p: Option<&'c Pat>,
    t: Option<&'c Pat>,
}

fn parameters(closure: &Hamiltonian) -> syn::Result<ClosureParameters<'_>> {
    let mut inputs: Vec<&Pat> = closure.closure.inputs.iter().collect();
    if closure.family.is_some() {
        inputs.pop();
    }
    let (begin, all, end) =
        (&closure.closure.inputs_begin, &closure.closure.inputs, &closure.closure.inputs_end);
    let patterns = || quote! { #begin #all #end };
    if closure.key == Key::Constraint {
        return match *inputs.as_slice() {
            [Pat::Tuple(tuple)] => Err(messages::tuple_phase_pattern(tuple, &tuple.elems)),
            [q] => Ok(ClosureParameters { q, p: None, t: None }),
            [q, t] if time(t).is_ok_and(|name| is_usual_time(&name)) => {
                Ok(ClosureParameters { q, p: None, t: Some(t) })
            }
            [_, p] | [_, p, _] => Err(messages::momenta_in_constraint(p)),
            _ => Err(messages::constraint_arity(patterns(), all.len())),
        };
    }
    match *inputs.as_slice() {
        [q, p] | [q, p, _] if are_swapped(q, p) => Err(messages::swapped_names(quote! { #q #p }, q, p)),
        [q, p] => Ok(ClosureParameters { q, p: Some(p), t: None }),
        [q, p, t] => Ok(ClosureParameters { q, p: Some(p), t: Some(t) }),
        [Pat::Tuple(tuple)] => Err(messages::tuple_phase_pattern(tuple, &tuple.elems)),
        _ => Err(messages::closure_arity(patterns(), all.len())),
    }
}

/// Whether the coordinates have the names of momenta and the momenta those of coordinates: `|p, q|`,
/// `|p1, q1|`, `|[px, py], [x, y]|`. The equations of motion would silently have the wrong sign.
fn are_swapped(q: &Pat, p: &Pat) -> bool {
    match (peeled(q), peeled(p)) {
        (Pat::Type(typed), p) => are_swapped(&typed.pat, p),
        (q, Pat::Type(typed)) => are_swapped(q, &typed.pat),
        (Pat::Slice(q), Pat::Slice(p)) => q.elems.iter().zip(&p.elems).any(|(q, p)| are_swapped(q, p)),
        (Pat::Ident(q), Pat::Ident(p)) => {
            let [q, p] = [q, p].map(|name| name.ident.unraw().to_string());
            let Some(coordinate) = q.strip_prefix('p') else { return false };
            let bare = coordinate.trim_start_matches('_');
            p.strip_prefix('q') == Some(coordinate) || (!bare.is_empty() && p == bare)
        }
        _ => false,
    }
}

/// The shape that a pattern declares, `None` if it fits any, and its names.
fn bound(pattern: &Pat) -> syn::Result<(Option<Shape>, Bound)> {
    match peeled(pattern) {
        Pat::Wild(_) => Ok((None, Bound::Whole(None))),
        Pat::Type(typed) => {
            let declared = type_shape(&typed.ty)?;
            let names = fitting(&typed.pat, &declared)?;
            Ok((Some(declared), names))
        }
        Pat::Slice(slice) => {
            let (mut element, mut parts) = (None, Vec::new());
            for inner in &slice.elems {
                let (found, names) = bound(inner)?;
                if let (Some(found), Some(expected)) = (&found, &element)
                    && found != expected
                {
                    return Err(messages::shapes_disagree_within(inner, found, expected));
                }
                element = found.or(element);
                parts.push(names);
            }
            let element = element.unwrap_or(Shape::Real);
            match slice.elems.len() {
                0 => Err(messages::no_degrees(slice)),
                _ if element.size().is_none() => Err(messages::size_not_literal(slice)),
                len => {
                    let shape = Shape::Array(Box::new(element), Length::Literal(len));
                    Ok((Some(shape), Bound::Each(parts)))
                }
            }
        }
        Pat::Tuple(tuple) => Err(messages::tuple_phase_pattern(tuple, &tuple.elems)),
        other => match bare_name(other) {
            Some(name) => Ok((Some(Shape::Real), Bound::Whole(Some(name.unraw().to_string())))),
            None => Err(messages::unsupported_phase_pattern(other)),
        },
    }
}

/// The names of a pattern that binds a value of shape `declared`.
fn fitting(pattern: &Pat, declared: &Shape) -> syn::Result<Bound> {
    match (peeled(pattern), declared) {
        (Pat::Slice(slice), Shape::Array(element, Length::Literal(len))) if slice.elems.len() == *len => {
            let parts = slice.elems.iter().map(|inner| fitting(inner, element));
            parts.collect::<syn::Result<_>>().map(Bound::Each)
        }
        (Pat::Ident(_) | Pat::Wild(_), _) => bound(pattern).map(|(_, names)| names),
        _ => match bound(pattern)? {
            (Some(found), _) if found != *declared => {
                Err(messages::shapes_disagree_within(pattern, &found, declared))
            }
            (_, names) => Ok(names),
        },
    }
}

/// The shape of a parameter's type.
fn type_shape(ty: &Type) -> syn::Result<Shape> {
    match ty {
        Type::Paren(inner) => type_shape(&inner.elem),
        Type::Group(inner) => type_shape(&inner.elem),
        Type::Path(path) if path.path.segments.last().is_some_and(|last| last.ident == "f64") => {
            Ok(Shape::Real)
        }
        _ if is_rotation(ty) => Ok(Shape::matrix()),
        Type::Array(array) => match literal(&array.len) {
            Some(0) => Err(messages::no_degrees(ty)),
            Some(len) => Ok(Shape::Array(Box::new(element_shape(&array.elem)?), Length::Literal(len))),
            None => Ok(Shape::Array(
                Box::new(element_shape(&array.elem)?),
                Length::Named(Box::new(Written(array.len.clone()))),
            )),
        },
        Type::Reference(reference) => match &*reference.elem {
            Type::Slice(slice) => Ok(Shape::Array(Box::new(element_shape(&slice.elem)?), Length::RunTime)),
            _ => Err(messages::unsupported_phase_type(ty)),
        },
        _ => Err(messages::unsupported_phase_type(ty)),
    }
}

/// The shape of an array's elements: of a size that the compiler knows.
fn element_shape(ty: &Type) -> syn::Result<Shape> {
    let shape = type_shape(ty)?;
    match shape.size() {
        Some(_) => Ok(shape),
        None => Err(messages::size_not_literal(ty)),
    }
}

/// The name of time.
fn time(pattern: &Pat) -> syn::Result<String> {
    if let Some(name) = bare_name(pattern) {
        return Ok(name.unraw().to_string());
    }
    match peeled(pattern) {
        Pat::Wild(_) => Ok("t".to_owned()),
        Pat::Type(typed) => match type_shape(&typed.ty)? {
            Shape::Real => time(&typed.pat),
            Shape::Array(..) => Err(messages::time_is_real(pattern)),
        },
        _ => Err(messages::time_is_real(pattern)),
    }
}
