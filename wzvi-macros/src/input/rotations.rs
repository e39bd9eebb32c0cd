//! Rotation matrices as coordinates: `q: Rotation` declares nine numbers and the six constraints
//! `(QᵀQ)_ab = δ_ab` that make them a rotation matrix. Tests: `tests/accepted/phase_spaces.rs`,
//! `tests/constraints/rigid_bodies.rs`.

use quote::{ToTokens, quote_spanned};
use syn::{Expr, ExprClosure, Pat, Type};

use super::attribute::{Declaration, Hamiltonian};
use crate::diagnostics::{Diagnostics, messages};
use crate::key::Key;
use crate::tokens::mentions;

/// The type of a rotation matrix in a closure.
const ROTATION: &str = "Rotation";

/// The rotation matrices of a type.
struct Rotations<'t> {
    /// `Rotation`.
    name: &'t syn::Ident,
    /// `Rotation` or `[Rotation; N]`.
    ty: &'t Type,
    /// The length of an array of them.
    number: Option<&'t Expr>,
}

/// Adds the constraints of rotation matrices before those of the user. Closures that name the type elsewhere
/// are reported and removed.
pub(super) fn declare_rotations(declaration: &mut Declaration, diagnostics: &mut Diagnostics) {
    let mut constraints = None;
    declaration.closures.retain(|closure| {
        let patterns = &closure.closure.inputs;
        let of_coordinates = patterns.first().and_then(rotations);
        let others = patterns.iter().skip(usize::from(of_coordinates.is_some()));
        let misplaced = others.map(ToTokens::to_token_stream).find(|other| mentions(other, ROTATION));
        if let Some(rotations) = of_coordinates {
            constraints.get_or_insert_with(|| orthonormality(&rotations));
        }
        match misplaced {
            Some(pattern) => diagnostics.report(messages::misplaced_rotation(pattern)),
            None => return true,
        }
        false
    });
    declaration.closures.splice(0..0, constraints.into_iter().flatten());
}

/// Whether a pattern declares rotation matrices.
pub(super) fn are_rotations(pattern: &Pat) -> bool {
    rotations(pattern).is_some()
}

/// Whether a type is that of a rotation matrix.
pub(super) fn is_rotation(ty: &Type) -> bool {
    name(ty).is_some()
}

/// The rotation matrices that a pattern declares as a whole.
fn rotations(pattern: &Pat) -> Option<Rotations<'_>> {
    match pattern {
        Pat::Paren(inner) => rotations(&inner.pat),
        Pat::Type(typed) => match &*typed.ty {
            ty @ Type::Array(array) => {
                Some(Rotations { name: name(&array.elem)?, ty, number: Some(&array.len) })
            }
            ty => Some(Rotations { name: name(ty)?, ty, number: None }),
        },
        _ => None,
    }
}

fn name(ty: &Type) -> Option<&syn::Ident> {
    match ty {
        Type::Paren(inner) => name(&inner.elem),
        Type::Group(inner) => name(&inner.elem),
        Type::Path(path) => Some(&path.path.segments.last()?.ident).filter(|name| *name == ROTATION),
        _ => None,
    }
}

/// `(c_a · c_b - δ_ab) = 0` for the columns `c_a` of the matrix, the images of the axes of the body; half of
/// it for `a = b`, whose gradient is then `c_a`. One constraint, or one for each matrix.
fn orthonormality(rotations: &Rotations<'_>) -> Vec<Hamiltonian> {
    const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];
    let (span, ty) = (rotations.name.span(), rotations.ty);
    let matrix =
        if rotations.number.is_some() { quote_spanned!(span=> q[k]) } else { quote_spanned!(span=> q) };
    let constraint = |[a, b]: [usize; 2]| {
        let product = quote_spanned! { span=>
            #matrix[0][#a] * #matrix[0][#b] + #matrix[1][#a] * #matrix[1][#b] + #matrix[2][#a] * #matrix[2][#b]
        };
        let value = if a == b { quote_spanned!(span=> 0.5 * (#product - 1.0)) } else { product };
        let closure: ExprClosure = match rotations.number {
            Some(_) => syn::parse_quote_spanned!(span=> |q: #ty, k| #value),
            None => syn::parse_quote_spanned!(span=> |q: #ty| #value),
        };
        Hamiltonian {
            key: Key::Constraint,
            tokens: closure.to_token_stream(),
            closure,
            family: rotations.number.cloned(),
            name: None,
        }
    };
    PAIRS.into_iter().map(constraint).collect()
}
