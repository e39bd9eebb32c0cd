//! Variables in scope.

use std::cell::RefCell;
use std::rc::Rc;

use syn::Ident;

use super::value::Value;

/// A variable: shared with the closures that captured it.
pub(super) struct Binding {
    pub(super) name: Ident,
    pub(super) value: RefCell<Value>,
    /// Number of undecided branches around its declaration: it may only be assigned there.
    pub(super) branch: u32,
}

/// The variables, innermost last.
#[derive(Clone, Default)]
pub(super) struct Scope(Vec<Rc<Binding>>);

impl Scope {
    pub(super) fn find(&self, name: &Ident) -> Option<&Rc<Binding>> {
        self.0.iter().rev().find(|binding| binding.name == *name)
    }

    pub(super) fn declare(&mut self, name: Ident, value: Value, branch: u32) {
        self.0.push(Rc::new(Binding { name, value: RefCell::new(value), branch }));
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
        let copy = |binding: &Rc<Binding>| {
            let value = RefCell::new(binding.value.borrow().clone());
            Rc::new(Binding { name: binding.name.clone(), value, branch: binding.branch })
        };
        Self(self.0.iter().map(copy).collect())
    }

    pub(super) fn names(&self) -> Vec<String> {
        self.0.iter().map(|binding| binding.name.to_string()).collect()
    }
}
