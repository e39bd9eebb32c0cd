//! The shared functions that a body calls. Tests: `tests/accepted/functions.rs`.

use std::collections::HashSet;

use proc_macro2::{Ident, Span};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Expr, ExprCall, ExprClosure, ExprMethodCall, ExprPath, Path};

use crate::lower::{BoundNames, is_constant_name, is_self, key, may_be_shared, type_of};

/// Calls of names that are neither variables nor functions of `f64`.
#[derive(Default)]
pub(super) struct Calls {
    bound: BoundNames,
    pub(super) called: Vec<ExprPath>,
    /// The struct whose closures are read.
    own: Option<Ident>,
    /// The place of the first call of a method of the struct.
    pub(super) method: Option<Span>,
    /// Other types of which a function is called.
    pub(super) types: Vec<Ident>,
    /// Constants by paths that mean something else elsewhere.
    pub(super) constants: Vec<ExprPath>,
}

impl Calls {
    /// The distinct paths, with the path of the methods of the struct `name`.
    pub(super) fn paths(self, name: Option<&Ident>) -> Vec<Path> {
        let mut seen = HashSet::new();
        let methods = name.zip(self.method).map(|(name, span)| super::owner(name, span));
        let paths = self.called.into_iter().map(|call| call.path);
        let types = self.types.iter().map(|name| super::owner(name, name.span()));
        paths.chain(methods).chain(types).filter(|path| seen.insert(key(path))).collect()
    }

    fn is_bound(&self, path: &Path) -> bool {
        path.get_ident().is_some_and(|name| self.bound.0.contains(name))
    }
}

pub(super) fn of_closures<'a>(closures: impl Iterator<Item = &'a ExprClosure>, name: &Ident) -> Vec<Path> {
    let mut calls = Calls { own: Some(name.clone()), ..Calls::default() };
    for closure in closures {
        calls.bound = BoundNames::default();
        calls.bound.visit_expr_closure(closure);
        calls.visit_expr_closure(closure);
    }
    calls.paths(Some(name))
}

/// The calls of a function with these parameters, which may be one of the type `own`.
pub(super) fn of_function(own: Option<&Ident>, signature: &syn::Signature, block: &syn::Block) -> Calls {
    let mut calls = Calls { own: own.cloned(), ..Calls::default() };
    calls.bound.visit_signature(signature);
    calls.bound.visit_block(block);
    calls.visit_block(block);
    calls
}

impl<'s> Visit<'s> for Calls {
    fn visit_expr_call(&mut self, call: &'s ExprCall) {
        match &*call.func {
            Expr::Path(path) if may_be_shared(path) && !self.is_bound(&path.path) => {
                match type_of(&path.path) {
                    Some(name) if *name == "Self" || self.own.as_ref() == Some(name) => {
                        self.method.get_or_insert(path.path.span());
                    }
                    Some(name) => self.types.push(name.clone()),
                    None => self.called.push(path.clone()),
                }
            }
            Expr::Path(_) => {}
            other => self.visit_expr(other),
        }
        call.args.iter().for_each(|argument| self.visit_expr(argument));
    }

    fn visit_expr_method_call(&mut self, call: &'s ExprMethodCall) {
        if is_self(&call.receiver) {
            self.method.get_or_insert(call.method.span());
        }
        visit::visit_expr_method_call(self, call);
    }

    fn visit_expr_path(&mut self, path: &'s ExprPath) {
        let segments = &path.path.segments;
        let is_constant = segments.last().is_some_and(|last| is_constant_name(&last.ident));
        let from_the_root = path.path.leading_colon.is_some()
            || segments.len() > 1
                && segments.first().is_some_and(|first| {
                    ["crate", "$crate", "std", "core", "f64", "Self"].iter().any(|root| first.ident == root)
                });
        if is_constant && !from_the_root && !self.is_bound(&path.path) {
            self.constants.push(path.clone());
        }
    }
}
