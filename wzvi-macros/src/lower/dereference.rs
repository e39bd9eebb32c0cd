//! Fields are references where a user destructures the struct, and copies where the closures are type-checked. This
//! turns the `*a` of the first spelling into the `a` of the second, wherever `a` is the field.

use syn::visit_mut::{self, VisitMut};
use syn::{Block, Expr, ExprClosure, ExprForLoop, Ident, Pat, Stmt, UnOp};

pub(super) struct Dereference<'a> {
    scalars: &'a [&'a Ident],
    /// Names that a pattern has taken, innermost last.
    shadowed: Vec<Ident>,
}

impl<'a> Dereference<'a> {
    pub(super) fn new(scalars: &'a [&'a Ident]) -> Self {
        Self { scalars, shadowed: Vec::new() }
    }

    fn is_scalar(&self, expr: &Expr) -> bool {
        match expr {
            Expr::Path(path) => path
                .path
                .get_ident()
                .is_some_and(|name| self.scalars.contains(&name) && !self.shadowed.contains(name)),
            Expr::Paren(inner) => self.is_scalar(&inner.expr),
            Expr::Group(inner) => self.is_scalar(&inner.expr),
            _ => false,
        }
    }

    fn shadow(&mut self, pattern: &Pat) {
        match pattern {
            Pat::Ident(ident) => {
                self.shadowed.push(ident.ident.clone());
                if let Some((_, inner)) = &ident.subpat {
                    self.shadow(inner);
                }
            }
            Pat::Type(typed) => self.shadow(&typed.pat),
            Pat::Paren(inner) => self.shadow(&inner.pat),
            Pat::Reference(inner) => self.shadow(&inner.pat),
            Pat::Tuple(tuple) => tuple.elems.iter().for_each(|inner| self.shadow(inner)),
            Pat::Slice(slice) => slice.elems.iter().for_each(|inner| self.shadow(inner)),
            _ => {}
        }
    }
}

impl VisitMut for Dereference<'_> {
    fn visit_expr_mut(&mut self, expr: &mut Expr) {
        if let Expr::Unary(unary) = expr
            && matches!(unary.op, UnOp::Deref(_))
            && self.is_scalar(&unary.expr)
        {
            *expr = (*unary.expr).clone();
            return;
        }
        visit_mut::visit_expr_mut(self, expr);
    }

    fn visit_expr_closure_mut(&mut self, closure: &mut ExprClosure) {
        let outer = self.shadowed.len();
        closure.inputs.iter().for_each(|input| self.shadow(input));
        self.visit_expr_mut(&mut closure.body);
        self.shadowed.truncate(outer);
    }

    fn visit_expr_for_loop_mut(&mut self, repeat: &mut ExprForLoop) {
        self.visit_expr_mut(&mut repeat.expr);
        let outer = self.shadowed.len();
        self.shadow(&repeat.pat);
        self.visit_block_mut(&mut repeat.body);
        self.shadowed.truncate(outer);
    }

    fn visit_block_mut(&mut self, block: &mut Block) {
        let outer = self.shadowed.len();
        for statement in &mut block.stmts {
            visit_mut::visit_stmt_mut(self, statement);
            if let Stmt::Local(local) = statement {
                self.shadow(&local.pat);
            }
        }
        self.shadowed.truncate(outer);
    }
}
