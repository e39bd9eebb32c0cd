//! Fields are references where a user destructures the struct, and copies where the closures are type-checked. This
//! turns the `*a` of the first spelling into the `a` of the second, wherever `a` is the field.

use proc_macro2::TokenStream;
use syn::visit::Visit;
use syn::visit_mut::{self, VisitMut};
use syn::{Expr, ExprClosure, Ident, UnOp};

use super::patterns::Names;
use crate::input::peeled;

/// The closure with `*a` written `a` for `scalars`, if there is such a thing: what the closure binds itself is left alone. It is read again: copies
/// of long sums take more of the stack.
pub(super) fn dereferenced(
    closure: &TokenStream,
    scalars: impl Iterator<Item = Ident>,
) -> Option<ExprClosure> {
    let mut closure = syn::parse2(closure.clone()).ok()?;
    let mut bound = Names::default();
    bound.visit_expr_closure(&closure);
    let scalars = scalars.filter(|name| !bound.0.contains(name)).collect();
    let mut pass = Dereference { scalars, is_needed: false };
    pass.visit_expr_closure_mut(&mut closure);
    pass.is_needed.then_some(closure)
}

struct Dereference {
    scalars: Vec<Ident>,
    is_needed: bool,
}

impl VisitMut for Dereference {
    fn visit_expr_mut(&mut self, expr: &mut Expr) {
        if let Expr::Unary(unary) = expr
            && matches!(unary.op, UnOp::Deref(_))
            && let Expr::Path(path) = peeled(&unary.expr)
            && path.path.get_ident().is_some_and(|name| self.scalars.contains(name))
        {
            *expr = (*unary.expr).clone();
            self.is_needed = true;
            return;
        }
        visit_mut::visit_expr_mut(self, expr);
    }
}
