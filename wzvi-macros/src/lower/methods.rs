//! The methods of lists, ranges and iterators. Tests: `tests/steps/values.rs`.

use std::rc::Rc;

use quote::ToTokens;
use syn::{BinOp, Expr as Syntax, ExprMethodCall, GenericArgument, Ident, Type};

use super::interpreter::Interpreter;
use super::sequences::{Sequence, Source};
use super::value::{Items, Value};
use crate::diagnostics::expressions;
use crate::input::is_integer_type;
use crate::model::Index;
use crate::symbolic::{Expr, SymbolKind};

/// Methods by their number of arguments: names with spaces between them.
pub(super) type Methods = [(usize, &'static str)];

const OF_SEQUENCES: &Methods = &[
    (
        0,
        "iter into_iter sum product enumerate rev flatten copied cloned len count collect to_vec clone as_slice",
    ),
    (1, "map zip skip take step_by windows chunks chain filter flat_map"),
    (2, "fold"),
];

/// The methods, with their numbers of arguments.
fn named(methods: &Methods) -> impl Iterator<Item = (&'static str, usize)> {
    methods.iter().flat_map(|&(arguments, names)| names.split(' ').map(move |name| (name, arguments)))
}

/// Whether there is a method of this name.
pub(super) fn are_known(methods: &Methods, name: &Ident) -> bool {
    named(methods).any(|(known, _)| name == known)
}

impl<'a> Interpreter<'a, '_> {
    /// The name of the called method; reports a wrong call.
    pub(super) fn known_method(
        &mut self,
        methods: &Methods,
        receivers: &str,
        syntax: &ExprMethodCall,
    ) -> Option<&'static str> {
        let error = match named(methods).find(|(known, _)| syntax.method == known) {
            Some((name, arguments)) if arguments == syntax.args.len() => return Some(name),
            Some((_, arguments)) => expressions::argument_count(&syntax.method, arguments, syntax.args.len()),
            None => {
                let names: Vec<&str> = named(methods).map(|(name, _)| name).collect();
                let name = syntax.method.to_string();
                expressions::unknown_method(&syntax.method, &name, receivers, &names)
            }
        };
        self.refuse(error)
    }

    /// A method of a list, a range or an iterator.
    pub(super) fn sequence_method(
        &mut self,
        sequence: Rc<Sequence>,
        arguments: &[Value],
        syntax: &'a ExprMethodCall,
    ) -> Option<Value> {
        let name = self.known_method(OF_SEQUENCES, "lists and iterators", syntax)?;
        // Lists are evaluated at once; if order does not matter, items are evaluated on demand.
        let makes_list = matches!(name, "collect" | "to_vec") || name == "map" && sequence.is_list();
        let from = origin(&syntax.receiver);
        let value = match (name, arguments) {
            ("sum", _) => self.sum(&sequence, syntax)?,
            ("product", _) => {
                let items = self.items(&sequence, from)?;
                self.total(true, items, syntax)?
            }
            ("fold", [start, function]) => self.fold(&sequence, start, function, syntax)?,
            ("len" | "count", _) => match self.length(&sequence) {
                Some(length) => Value::index(length).unsigned(true),
                None => Value::integer(self.items(&sequence, from)?.len() as i128),
            },
            ("iter" | "into_iter" | "copied" | "cloned" | "collect" | "to_vec" | "clone" | "as_slice", _) => {
                Value::Sequence(sequence)
            }
            _ => {
                let argument = arguments.first().unwrap_or(&Value::Poison);
                Value::sequence(self.adapted(name, sequence, argument, from, &syntax.args)?)
            }
        };
        if matches!((name, &value), ("sum" | "product", Value::Real(_))) && syntax.turbofish.is_none() {
            self.untyped.insert(&syntax.method);
        }
        Some(match value {
            Value::Sequence(list) if makes_list && self.now.has_mutation => {
                Value::list(self.items(&list, from)?)
            }
            value => value,
        })
    }

    /// `sum`: a loop adds real numbers, integers are added term by term.
    fn sum(&mut self, sequence: &Sequence, syntax: &'a ExprMethodCall) -> Option<Value> {
        let receiver = origin(&syntax.receiver);
        let mut has_integers = asks_for(syntax, is_integer_type);
        if !has_integers {
            let sum = self.sum_over(sequence, false, receiver, &mut |this, item| {
                has_integers |= item.is_integer() && !asks_for(syntax, |name| name == "f64");
                if has_integers { None } else { this.real(item, receiver) }
            });
            if !has_integers || self.is_abandoned() {
                return sum.map(Value::Real);
            }
        }
        let items = self.items(sequence, receiver)?;
        self.total(false, items, syntax)
    }

    /// `sum` and `product` term by term, of real numbers or of integers.
    fn total(&mut self, product: bool, items: Vec<Value>, syntax: &'a ExprMethodCall) -> Option<Value> {
        let are_integers = items.iter().all(Value::is_integer);
        if are_integers && (!items.is_empty() || asks_for(syntax, is_integer_type)) {
            let operator =
                if product { BinOp::Mul(Default::default()) } else { BinOp::Add(Default::default()) };
            return items.iter().try_fold(Value::integer(product.into()), |total, item| {
                let total = self.integer_operation(&total, &operator, item, &syntax.method)?;
                self.within_limits(total, syntax)
            });
        }
        let reals: Vec<Option<Expr>> =
            items.into_iter().map(|item| self.real(item, &syntax.receiver)).collect();
        let reals = reals.into_iter().collect::<Option<Vec<_>>>()?;
        Some(Value::Real(if product { self.graph.product(&reals) } else { self.graph.sum(&reals) }))
    }

    /// `fold(start, |total, x| ...)`: a sum written by hand becomes a loop, anything else is evaluated
    /// item by item.
    fn fold(
        &mut self,
        sequence: &Sequence,
        start: &Value,
        function: &Value,
        syntax: &'a ExprMethodCall,
    ) -> Option<Value> {
        let method = &syntax.method;
        if let Value::Real(start) = start
            && !matches!(sequence.source, Source::Known(_))
        {
            let placeholder = self.graph.new_symbol(SymbolKind::Auxiliary, "");
            let total = self.graph.symbol(placeholder);
            let mut is_sum = true;
            let added = self.sum_over(sequence, false, method, &mut |this, item| {
                let next = this.apply(function, vec![Value::Real(total), item], method)?;
                let next = this.real(next, method)?;
                let added = this.graph.subtract(next, total);
                is_sum &= !this.graph.depends_on(added, &[placeholder]);
                is_sum.then_some(added)
            });
            if is_sum {
                return added.map(|added| Value::Real(self.graph.add(*start, added)));
            }
            if !self.has_known_items(sequence) {
                return self.refuse(expressions::no_sum(method));
            }
        }
        let mut total = start.clone();
        for item in self.items(sequence, origin(&syntax.receiver))? {
            // Accumulating n terms one by one copies n² of them.
            if !self.spend_on(&total, method) {
                return None;
            }
            total = self.apply(function, vec![total, item], &syntax.args).unwrap_or_default();
        }
        Some(total)
    }

    /// Whether the items can be evaluated one by one, now or when the surrounding loops are unrolled.
    pub(super) fn has_known_items(&self, sequence: &Sequence) -> bool {
        sequence.length.as_ref().is_none_or(Index::is_closed)
    }

    /// The current items of a sequence as a list.
    pub(super) fn known_list(&mut self, sequence: &Sequence, at: &dyn ToTokens) -> Option<Items> {
        self.items(sequence, at).map(Items::new)
    }
}

/// The list or range that a chain of methods begins with.
fn origin(mut syntax: &Syntax) -> &Syntax {
    while let Syntax::MethodCall(call) = syntax {
        syntax = &call.receiver;
    }
    syntax
}

/// Whether the call is `sum::<T>()` with such a type.
fn asks_for(syntax: &ExprMethodCall, is_wanted: impl Fn(&str) -> bool) -> bool {
    let argument = syntax.turbofish.as_ref().and_then(|turbofish| turbofish.args.first());
    match argument {
        Some(GenericArgument::Type(Type::Path(path))) => {
            path.path.segments.last().is_some_and(|last| is_wanted(&last.ident.to_string()))
        }
        _ => false,
    }
}
