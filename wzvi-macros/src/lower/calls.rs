//! Calls: local closures and the functions of `f64`. Tests: `tests/accepted/functions.rs`.

use quote::ToTokens;
use syn::punctuated::Punctuated;
use syn::{Expr as Syntax, ExprCall, ExprClosure, ExprMethodCall, ExprPath, FnArg, Pat, Token};

use super::floats::meant_method;
use super::integers::may_be_integer;
use super::interpreter::{Closure, Interpreter};
use super::names::{integer_function, is_self, key, may_be_shared, type_of};
use super::scope::Scope;
use super::value::Value;
use crate::diagnostics::{expressions, messages};
use crate::input::{Library, SharedFunction};

impl<'a> Interpreter<'a, '_> {
    pub(super) fn closure(&mut self, syntax: &'a ExprClosure) -> Option<Value> {
        if !self.spend(1 + self.now.scope.len() / 16, &syntax.inputs_begin) {
            return None;
        }
        let scope = match syntax.capture {
            Some(_) => self.now.scope.snapshot(),
            None => self.now.scope.clone(),
        };
        self.now.has_mutation |= super::control::assigns_captured(syntax);
        self.now.closures.push(Closure { syntax, scope });
        Some(Value::Closure(self.now.closures.len() - 1))
    }

    pub(super) fn call(&mut self, syntax: &'a ExprCall) -> Option<Value> {
        if self.is_pending(&syntax.func) {
            return None;
        }
        if let Some((function, library_of_type)) = self.shared(&syntax.func) {
            return self.apply_shared(function, library_of_type, &syntax.args, syntax);
        }
        let function = match &*syntax.func {
            // A single name is a variable; as a function it is opaque.
            Syntax::Path(path) => match path.path.get_ident() {
                Some(name) => match self.now.scope.find_from_anywhere(name) {
                    Some(binding) => binding.value.borrow().clone().known(),
                    None => {
                        let arguments: Vec<&Syntax> = syntax.args.iter().collect();
                        self.refuse(match meant_method(&name.to_string()) {
                            Some(method) => expressions::function_as_method(name, method, &arguments),
                            None => expressions::function_call(path),
                        })
                    }
                },
                None if integer_function(path).is_some() => {
                    let arguments: Vec<&Syntax> = syntax.args.iter().collect();
                    return self.refuse_integer_function(path, &arguments);
                }
                None => self.function_of_reals(path),
            },
            other => self.evaluate(other).known(),
        };
        let arguments = self.elements(&syntax.args);
        match function? {
            Value::Function(name) => {
                let places: Vec<&Syntax> = syntax.args.iter().collect();
                self.real_call(&name, arguments, &places, &syntax.func)
            }
            function => self.apply(&function, arguments, syntax),
        }
    }

    /// A path that does not name a variable.
    fn path_of_function<'s>(&self, function: &'s Syntax) -> Option<&'s ExprPath> {
        let Syntax::Path(path) = function else { return None };
        let variable = path.path.get_ident().and_then(|name| self.now.scope.find_from_anywhere(name));
        variable.is_none().then_some(path)
    }

    /// The shared function of a path that does not name a variable, and the library that has it.
    fn shared(&self, function: &Syntax) -> Option<(&'a SharedFunction, &'a Library)> {
        let path = self.path_of_function(function)?;
        let name = key(&path.path);
        let is_own = |known: &&syn::Ident| **known == "Self" || **known == self.system.item.ident;
        match type_of(&path.path).filter(is_own).and(path.path.segments.last()) {
            Some(method) => Some((self.method(&method.ident.to_string())?, self.root)),
            None => [self.now.library, self.siblings(&path.path)].into_iter().flatten().find_map(|library| {
                library.functions.iter().find(|function| function.name == name).zip(Some(library))
            }),
        }
    }

    /// The library of the type in `Type::f`, while a function of that type is evaluated.
    fn siblings(&self, path: &syn::Path) -> Option<&'a Library> {
        let (owner, _) = self.now.calls.last()?.name.split_once("::")?;
        self.now.library_of_type.filter(|_| type_of(path).is_some_and(|name| name == owner))
    }

    /// Whether the path names a function that is yet to be defined.
    fn is_pending(&self, function: &Syntax) -> bool {
        let path = self.path_of_function(function);
        self.awaits_definitions() && path.is_some_and(may_be_shared)
    }

    /// Whether calls of unknown functions are allowed for now.
    pub(super) fn awaits_definitions(&self) -> bool {
        self.root.is_pending
    }

    fn method(&self, name: &str) -> Option<&'a SharedFunction> {
        self.root.methods.iter().find(|function| function.name == name)
    }

    /// Inlines the body of a shared function: it sees its parameters and the names at its definition.
    fn apply_shared(
        &mut self,
        function: &'a SharedFunction,
        library_of_type: &'a Library,
        arguments: &'a Punctuated<Syntax, Token![,]>,
        at: &dyn ToTokens,
    ) -> Option<Value> {
        let mut arguments = self.elements(arguments);
        let inputs = &function.signature.inputs;
        // A method by its path gets `self` as an argument.
        let has_receiver = matches!(inputs.first(), Some(FnArg::Receiver(_)));
        let parameters = inputs.iter().filter_map(|input| match input {
            FnArg::Typed(typed) => Some(&*typed.pat),
            FnArg::Receiver(_) => None,
        });
        let parameters: Vec<&'a Pat> = parameters.collect();
        if has_receiver && arguments.len() == parameters.len() + 1 {
            arguments.remove(0);
        }
        if parameters.len() != arguments.len() {
            return self.refuse(expressions::argument_count(at, parameters.len(), arguments.len()));
        }
        if self.now.calls.iter().any(|active| std::ptr::eq(*active, function)) {
            return self.refuse(messages::recursion(at.to_token_stream()));
        }
        if !self.spend(1, &at.to_token_stream()) {
            return None;
        }
        let (library, caller) =
            (self.now.library.replace(&function.library), self.now.library_of_type.replace(library_of_type));
        self.now.calls.push(function);
        let body = |this: &mut Self| this.block(&function.block);
        let value = self.inside_function(Scope::default(), parameters.into_iter().zip(arguments), body);
        self.now.calls.pop();
        (self.now.library, self.now.library_of_type) = (library, caller);
        value
    }

    /// The value of `body` with these parameters and this captured scope.
    fn inside_function(
        &mut self,
        captured: Scope,
        parameters: impl Iterator<Item = (&'a Pat, Value)>,
        body: impl FnOnce(&mut Self) -> Value,
    ) -> Option<Value> {
        let frame = std::mem::replace(&mut self.now.frame, captured.len());
        let caller = std::mem::replace(&mut self.now.scope, captured);
        parameters.for_each(|(pattern, argument)| self.bind(pattern, argument));
        let value = body(self);
        (self.now.scope, self.now.frame) = (caller, frame);
        value.known()
    }

    /// The value of a function at `arguments`.
    pub(super) fn apply(
        &mut self,
        function: &Value,
        arguments: Vec<Value>,
        at: &dyn ToTokens,
    ) -> Option<Value> {
        let id = match function {
            Value::Poison => return None,
            Value::Function(name) => return self.real_call(name, arguments, &[], at),
            Value::Closure(id) => *id,
            other => return self.refuse(expressions::not_callable(at, other.describe())),
        };
        let Closure { syntax, scope } = self.now.closures.get(id)?;
        let (syntax, captured) = (*syntax, scope.clone());
        if syntax.inputs.len() != arguments.len() {
            return self.refuse(expressions::argument_count(at, syntax.inputs.len(), arguments.len()));
        }
        if !self.spend(1 + captured.len() / 16, &at.to_token_stream()) {
            return None;
        }
        let parameters = syntax.inputs.iter().zip(arguments);
        self.inside_function(captured, parameters, |this| this.evaluate(&syntax.body))
    }

    pub(super) fn method_call(&mut self, syntax: &'a ExprMethodCall) -> Option<Value> {
        if is_self(&syntax.receiver) {
            if let Some(method) = self.method(&syntax.method.to_string()) {
                return self.apply_shared(method, self.root, &syntax.args, syntax);
            }
            if self.awaits_definitions() {
                return None;
            }
            return self.refuse(expressions::function_call(&syntax.method));
        }
        let receiver = self.evaluate(&syntax.receiver);
        let arguments = self.elements(&syntax.args);
        match receiver.known()? {
            Value::Sequence(sequence) => self.sequence_method(sequence, &arguments, syntax),
            Value::Index(index, is_unsigned) => {
                self.integer_method(&index, &arguments, syntax).map(|value| value.unsigned(is_unsigned))
            }
            Value::Constant(place) if may_be_integer(syntax, &arguments) => {
                let index = self.given(&place);
                self.integer_method(&index, &arguments, syntax)
            }
            // Any other constant that is not a list is a real number: integers have to be cast first.
            receiver @ (Value::Real(_) | Value::Constant(_)) => {
                let values = [vec![receiver], arguments].concat();
                let places: Vec<&Syntax> = [&*syntax.receiver].into_iter().chain(&syntax.args).collect();
                self.real_call(&syntax.method.to_string(), values, &places, &syntax.method)
            }
            other => match syntax.method.to_string().as_str() {
                "clone" | "to_owned" if arguments.is_empty() => Some(other),
                name => {
                    let known = ["clone"];
                    self.refuse(expressions::unknown_method(&syntax.method, name, other.describe(), &known))
                }
            },
        }
    }
}
