//! Variables in scope. Tests: `lower/tests/values.rs`, `tests/accepted/macros.rs`.

use std::cell::RefCell;
use std::rc::Rc;

use syn::Ident;

use super::value::Value;

/// A variable: shared with the closures that captured it.
#[derive(Clone)]
pub(super) struct Binding {
    pub(super) name: Ident,
    pub(super) value: RefCell<Value>,
    /// Number of undecided branches around its declaration: it may only be assigned there.
    pub(super) branch: u32,
    /// Number of loops around its declaration: an assignment inside more loops unrolls these.
    pub(super) loops: usize,
}

/// The variables, innermost last.
#[derive(Clone, Default)]
pub(super) struct Scope(Vec<Rc<Binding>>);

impl Scope {
    /// The innermost variable of this name with the same hygiene as the use: a name in the text of a
    /// `macro_rules!` never means the same name in its arguments.
    pub(super) fn find(&self, name: &Ident) -> Option<&Rc<Binding>> {
        let context = context(name);
        self.0.iter().rev().find(|binding| binding.name == *name && self::context(&binding.name) == context)
    }

    /// The innermost variable of this name from anywhere: a procedural macro may have mixed its own tokens
    /// with those that it was given. `rustc` decides whether they are the same.
    pub(super) fn find_from_anywhere(&self, name: &Ident) -> Option<&Rc<Binding>> {
        self.find(name).or_else(|| self.0.iter().rev().find(|binding| binding.name == *name))
    }

    pub(super) fn declare(&mut self, name: Ident, value: Value, branch: u32, loops: usize) {
        self.0.push(Rc::new(Binding { name, value: RefCell::new(value), branch, loops }));
    }

    /// Gives a variable a new value. A variable of the frame that starts at `frame` becomes a new one, so
    /// that expressions of the old one which are evaluated later keep its value. A captured variable is
    /// shared with the scopes around the closure.
    pub(super) fn assign(&mut self, variable: &Rc<Binding>, value: Value, frame: usize) {
        let own = self.0.get_mut(frame..).unwrap_or_default();
        match own.iter_mut().rev().find(|known| Rc::ptr_eq(known, variable)) {
            Some(slot) => {
                *slot = Rc::new(Binding { value: RefCell::new(value), ..(**variable).clone() });
            }
            None => drop(variable.value.replace(value)),
        }
    }

    /// The variable at a position.
    pub(super) fn get(&self, position: usize) -> Option<Rc<Binding>> {
        self.0.get(position).cloned()
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Forgets the variables declared since the scope had `len`.
    pub(super) fn leave(&mut self, len: usize) {
        self.0.truncate(len);
    }

    /// The scope as a `move` closure sees it: later assignments do not reach it.
    pub(super) fn snapshot(&self) -> Self {
        Self(self.0.iter().map(|binding| Rc::new((**binding).clone())).collect())
    }

    pub(super) fn names(&self) -> Vec<String> {
        self.0.iter().map(|binding| binding.name.to_string()).collect()
    }
}

/// The hygiene context, which distinguishes equal names of different macros: `rustc` prints a span as
/// `#context bytes(..)`. Empty if there is none.
pub(super) fn context(name: &Ident) -> String {
    let span = format!("{:?}", name.span());
    match span.split_once(' ') {
        Some((context, _)) if context.starts_with('#') => context.to_owned(),
        _ => String::new(),
    }
}
