//! Name resolution: variables, fields, constants. Tests: `tests/accepted/parameters.rs`,
//! `tests/steps/names.rs`.

use std::f64::consts;

use proc_macro2::TokenStream;
use quote::{ToTokens, quote};
use syn::ext::IdentExt;
use syn::{Expr as Syntax, ExprField, ExprPath, Ident, Member, Path, Type, UnOp};

use super::floats::is_real_method;
use super::interpreter::Interpreter;
use super::value::{Place, Value};
use crate::diagnostics::expressions;
use crate::input::{Field, FieldKind, is_integer_type, peeled};

impl<'a> Interpreter<'a, '_> {
    /// A path that is used as a value.
    pub(super) fn path(&mut self, path: &ExprPath) -> Option<Value> {
        match path.path.get_ident() {
            Some(name) if path.qself.is_none() => self.name(name),
            _ => self.long_path(path),
        }
    }

    /// The innermost meaning of a name: variable, field, const generic, constant.
    fn name(&mut self, name: &Ident) -> Option<Value> {
        if let Some(binding) = self.now.scope.find(name) {
            return Some(binding.value.borrow().clone());
        }
        if let Some(field) = self.find_field(|member| matches!(member, Member::Named(known) if known == name))
        {
            return self.read_field(field, name);
        }
        let tokens = name.to_token_stream();
        if self.system.sizes.contains(name) {
            return Some(Value::index(self.tables.size(&syn::parse_quote!(#tokens))).unsigned(true));
        }
        if let Some(binding) = self.now.scope.find_from_anywhere(name) {
            return Some(binding.value.borrow().clone());
        }
        if name == "self" {
            let remedy = "name the field, as in `self.a` or `a`";
            return self.refuse(expressions::unsupported(name, "the struct as a whole", remedy));
        }
        if is_constant_name(name) {
            return Some(Value::Constant(Place::new(name.to_string(), tokens, FieldKind::Constant).into()));
        }
        let fields = self.field_names();
        if let Some(advice) = self.now.advice {
            return self.refuse(expressions::unknown_name_of_key(name, &fields, advice));
        }
        let locals = self.now.scope.names();
        self.refuse(expressions::unknown_name(name, &fields, &locals))
    }

    /// `std::f64::consts::PI`, `Self::STIFFNESS`, `f64::sin`.
    fn long_path(&mut self, path: &ExprPath) -> Option<Value> {
        let segments: Vec<String> = path.path.segments.iter().map(|s| s.ident.unraw().to_string()).collect();
        let name = match segments.as_slice() {
            [.., outer, last] if outer == "Self" => format!("Self::{last}"),
            [.., last] => last.clone(),
            [] => return None,
        };
        if let Some(value) = standard_constant(&segments) {
            return Some(Value::Real(self.graph.float(value)));
        }
        if path.path.segments.last().is_some_and(|last| is_constant_name(&last.ident)) {
            let place = Place::new(name, path.to_token_stream(), FieldKind::Constant);
            return Some(Value::Constant(place.into()));
        }
        self.function_of_reals(path)
    }

    /// A call of a function of integers by its path.
    pub(super) fn refuse_integer_function(
        &mut self,
        path: &ExprPath,
        arguments: &[&Syntax],
    ) -> Option<Value> {
        let (ty, method) = integer_function(path)?;
        self.refuse(expressions::integer_function(path, &ty, &method, arguments))
    }

    /// `f64::sin`
    pub(super) fn function_of_reals(&mut self, path: &ExprPath) -> Option<Value> {
        let function = real_function(path).map(|function| Value::Function(function.into()));
        function.or_else(|| self.refuse(expressions::function_call(path)))
    }

    /// `self.a` or a part of a tuple.
    pub(super) fn field(&mut self, syntax: &'a ExprField) -> Option<Value> {
        if is_self(&syntax.base) {
            return match self.find_field(|member| *member == syntax.member) {
                Some(field) => self.read_field(field, &syntax.member),
                None => {
                    let fields = self.field_names();
                    self.refuse(expressions::unknown_field(&syntax.member, &fields))
                }
            };
        }
        let value = self.evaluate(&syntax.base).known()?;
        let part = match (&value, &syntax.member) {
            (Value::Tuple(tuple), Member::Unnamed(index)) => tuple.items.get(index.index as usize).cloned(),
            _ => None,
        };
        part.or_else(|| self.mismatch(&syntax.member, "a field of the struct or of a tuple", &value))
    }

    /// The wanted field. If there are several under different `#[cfg]`s, a readable one.
    fn find_field(&self, wanted: impl Fn(&Member) -> bool) -> Option<&'a Field> {
        let system = self.system;
        let mut fields = system.fields.iter().filter(|field| wanted(&field.member));
        let first = fields.next()?;
        Some(if first.is_readable() {
            first
        } else {
            fields.find(|field| field.is_readable()).unwrap_or(first)
        })
    }

    fn read_field(&mut self, field: &Field, at: &dyn ToTokens) -> Option<Value> {
        let (name, tokens) = displayed_and_read(field);
        self.place(Place::new(name, tokens, field.kind.clone()), at)
    }

    fn field_names(&self) -> Vec<String> {
        self.system.fields.iter().map(|field| field.member.to_token_stream().to_string()).collect()
    }
}

/// The number that a path from `std::f64::consts` or `core::f64::consts` names, if identities of logarithms
/// are known of it. Other constants, and imported names, may have any value.
fn standard_constant(segments: &[String]) -> Option<f64> {
    let [library, real, module, name] = segments else { return None };
    if !matches!(library.as_str(), "std" | "core") || real != "f64" || module != "consts" {
        return None;
    }
    match name.as_str() {
        "LN_2" => Some(consts::LN_2),
        "LN_10" => Some(consts::LN_10),
        "LOG2_E" => Some(consts::LOG2_E),
        "LOG2_10" => Some(consts::LOG2_10),
        "LOG10_E" => Some(consts::LOG10_E),
        "LOG10_2" => Some(consts::LOG10_2),
        _ => None,
    }
}

/// The displayed name of a field, and the tokens that read it in an emitted method.
fn displayed_and_read(field: &Field) -> (String, TokenStream) {
    let member = &field.member;
    let name = match member {
        Member::Named(name) => name.unraw().to_string(),
        Member::Unnamed(index) => format!("self.{}", index.index),
    };
    (name, quote! { self.#member })
}

/// `self`, in parentheses or not.
pub(crate) fn is_self(syntax: &Syntax) -> bool {
    match peeled(syntax) {
        Syntax::Path(path) => path.path.is_ident("self"),
        Syntax::Unary(inner) if matches!(inner.op, UnOp::Deref(_)) => is_self(&inner.expr),
        _ => false,
    }
}

/// The method behind a path such as `f64::sin`.
pub(crate) fn real_function(path: &ExprPath) -> Option<String> {
    let segments = &path.path.segments;
    let name = segments.last()?.ident.to_string();
    let of_f64 = match &path.qself {
        Some(qself) => is_real_type(&qself.ty) && segments.len() == 1,
        None => segments.len() > 1 && segments.iter().rev().nth(1).is_some_and(|outer| outer.ident == "f64"),
    };
    of_f64.then_some(name)
}

/// The type and the method behind a path such as `i32::pow`.
pub(crate) fn integer_function(path: &ExprPath) -> Option<(String, String)> {
    let mut segments = path.path.segments.iter().rev().map(|segment| segment.ident.to_string());
    let (method, ty) = (segments.next()?, segments.next()?);
    (path.qself.is_none() && is_integer_type(&ty)).then_some((ty, method))
}

/// A name in upper case: `rustc` tells whether there is such a constant.
pub(crate) fn is_constant_name(name: &Ident) -> bool {
    let name = name.unraw().to_string();
    name.chars().any(char::is_uppercase) && !name.chars().any(char::is_lowercase)
}

/// Whether a path may name a shared function: neither a function of `f64`, with or without its type, nor a
/// constructor.
pub(crate) fn may_be_shared(path: &ExprPath) -> bool {
    let segments = &path.path.segments;
    let Some(last) = segments.last().map(|last| last.ident.to_string()) else { return false };
    let is_bare_method = segments.len() == 1 && is_real_method(&last);
    let is_function = !last.starts_with(char::is_uppercase) && !is_bare_method;
    path.qself.is_none() && is_function && real_function(path).is_none() && integer_function(path).is_none()
}

/// The type in `Type::function`.
pub(crate) fn type_of(path: &Path) -> Option<&Ident> {
    let first = path.segments.first().filter(|_| path.segments.len() == 2 && path.leading_colon.is_none())?;
    first.ident.to_string().starts_with(char::is_uppercase).then_some(&first.ident)
}

/// A path without spaces, for comparison of calls.
pub(crate) fn key(path: &impl ToTokens) -> String {
    path.to_token_stream().to_string().replace(' ', "")
}

/// Whether `ty` is `f64`, by its name.
pub(super) fn is_real_type(ty: &Type) -> bool {
    match ty {
        Type::Path(path) => path.path.segments.last().is_some_and(|last| last.ident == "f64"),
        Type::Paren(inner) => is_real_type(&inner.elem),
        Type::Group(inner) => is_real_type(&inner.elem),
        _ => false,
    }
}
