//! Fields are references if the user destructures the struct, but copies where the closures are type-checked. This
//! replaces `*a` by `a` wherever `a` is the field.

use proc_macro2::TokenStream;
use syn::visit::Visit;
use syn::visit_mut::{self, VisitMut};
use syn::{Block, Expr, ExprClosure, ExprForLoop, Ident, Pat, Stmt, UnOp};

use super::patterns::Names;
use crate::input::peeled;

/// The closure with `*a` replaced by `a` for `scalars`, if there is any. It is parsed again, as copying long sums takes more stack.
pub(super) fn dereferenced(closure: &TokenStream, scalars: &[&Ident]) -> Option<ExprClosure> {
    let mut closure = syn::parse2(closure.clone()).ok()?;
    let mut pass = Dereference { scalars, shadowed: Names::default(), is_needed: false };
    pass.visit_expr_closure_mut(&mut closure);
    pass.is_needed.then_some(closure)
}

struct Dereference<'a> {
    scalars: &'a [&'a Ident],
    /// Names that a pattern has taken, innermost last.
    shadowed: Names,
    is_needed: bool,
}

impl Dereference<'_> {
    fn is_scalar(&self, expr: &Expr) -> bool {
        let Expr::Path(path) = peeled(expr) else { return false };
        let name = path.path.get_ident();
        name.is_some_and(|name| self.scalars.contains(&name) && !self.shadowed.0.contains(name))
    }

    /// Visits code in the scope of these patterns.
    fn inside<'p>(&mut self, patterns: impl IntoIterator<Item = &'p Pat>, visit: impl FnOnce(&mut Self)) {
        let outer = self.shadowed.0.len();
        patterns.into_iter().for_each(|pattern| self.shadowed.visit_pat(pattern));
        visit(self);
        self.shadowed.0.truncate(outer);
    }
}

impl VisitMut for Dereference<'_> {
    fn visit_expr_mut(&mut self, expr: &mut Expr) {
        if let Expr::Unary(unary) = expr
            && matches!(unary.op, UnOp::Deref(_))
            && self.is_scalar(&unary.expr)
        {
            *expr = (*unary.expr).clone();
            self.is_needed = true;
            return;
        }
        visit_mut::visit_expr_mut(self, expr);
    }

    fn visit_expr_closure_mut(&mut self, closure: &mut ExprClosure) {
        let ExprClosure { inputs, body, .. } = closure;
        self.inside(&*inputs, |pass| pass.visit_expr_mut(body));
    }

    fn visit_expr_for_loop_mut(&mut self, repeat: &mut ExprForLoop) {
        self.visit_expr_mut(&mut repeat.expr);
        self.inside([&*repeat.pat], |pass| pass.visit_block_mut(&mut repeat.body));
    }

    fn visit_block_mut(&mut self, block: &mut Block) {
        self.inside([], |pass| {
            for statement in &mut block.stmts {
                visit_mut::visit_stmt_mut(pass, statement);
                if let Stmt::Local(local) = statement {
                    pass.shadowed.visit_pat(&local.pat);
                }
            }
        });
    }
}
