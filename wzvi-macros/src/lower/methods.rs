//! The methods of lists, ranges and iterators.

use std::rc::Rc;

use syn::{Expr as Syntax, ExprMethodCall, GenericArgument, Type};

use super::interpreter::Interpreter;
use super::sequences::Stream;
use super::value::{Sequence, Value};
use crate::diagnostics::expressions;
use crate::input::is_integer_type;
use crate::symbolic::Expr;

/// Each method with its number of arguments.
const METHODS: [(&str, usize); 26] = [
    ("iter", 0),
    ("into_iter", 0),
    ("map", 1),
    ("sum", 0),
    ("product", 0),
    ("zip", 1),
    ("enumerate", 0),
    ("rev", 0),
    ("skip", 1),
    ("take", 1),
    ("step_by", 1),
    ("windows", 1),
    ("chunks", 1),
    ("chain", 1),
    ("filter", 1),
    ("flat_map", 1),
    ("flatten", 0),
    ("fold", 2),
    ("copied", 0),
    ("cloned", 0),
    ("len", 0),
    ("count", 0),
    ("collect", 0),
    ("to_vec", 0),
    ("clone", 0),
    ("as_slice", 0),
];

impl<'a> Interpreter<'a, '_> {
    /// A method of a list, a range or an iterator.
    pub(super) fn sequence_method(
        &mut self,
        stream: Rc<Stream>,
        arguments: Vec<Value>,
        syntax: &'a ExprMethodCall,
    ) -> Value {
        let name = syntax.method.to_string();
        let Some(&(name, expected)) = METHODS.iter().find(|(known, _)| *known == name) else {
            let known: Vec<&str> = METHODS.iter().map(|(known, _)| *known).collect();
            return self.report(expressions::unknown_method(&syntax.method, "lists and iterators", &known));
        };
        if arguments.len() != expected {
            return self.report(expressions::argument_count(&syntax.method, expected, arguments.len()));
        }
        // Lists are made at once; where no order can tell, their items are made when they are asked for.
        let makes_list =
            matches!(name, "collect" | "to_vec") || name == "map" && stream.describe() == "a list";
        let value = match (name, arguments.as_slice()) {
            ("sum" | "product" | "fold" | "len" | "count", arguments) => {
                self.reduce(name, &stream, arguments, syntax)
            }
            (_, []) => Some(Value::Stream(match name {
                "enumerate" => Stream::Enumerate(stream).into(),
                "rev" => Stream::Reversed(stream).into(),
                "flatten" => Stream::FlatMap(stream, None).into(),
                _ => stream,
            })),
            (_, [argument, ..]) => {
                self.adapt(name, stream, argument, syntax).map(|stream| Value::Stream(stream.into()))
            }
        };
        let value = match value {
            Some(Value::Stream(list)) if makes_list && self.has_mutation => {
                self.items(&list, None, origin(&syntax.receiver)).map(Value::list)
            }
            value => value,
        };
        self.bounded(value.unwrap_or(Value::Poison), syntax)
    }

    /// What becomes another sequence by an argument.
    fn adapt(
        &mut self,
        name: &str,
        stream: Rc<Stream>,
        argument: &Value,
        syntax: &'a ExprMethodCall,
    ) -> Option<Stream> {
        let at = &syntax.args;
        Some(match name {
            "map" => Stream::Map(stream, argument.clone()),
            "filter" => Stream::Filter(stream, argument.clone()),
            "flat_map" => Stream::FlatMap(stream, Some(argument.clone())),
            "zip" => Stream::Zip(stream, self.as_stream(argument, at)?),
            "chain" => Stream::Chain(stream, self.as_stream(argument, at)?),
            "skip" | "take" => {
                let number = self.as_index(argument, at)?;
                if number.as_integer().is_some_and(|number| number < 0) {
                    self.report(expressions::integer_arithmetic(at));
                    return None;
                }
                match (name, &*stream) {
                    ("skip", Stream::Range(start, None)) => Stream::Range(start.add(&number)?, None),
                    ("skip", _) => Stream::Skip(stream, number),
                    _ => Stream::Take(stream, number),
                }
            }
            _ => {
                let number = self.known_integer(argument.clone(), at)?;
                if number < 1 {
                    self.report(expressions::integer_arithmetic(at));
                    return None;
                }
                match name {
                    "step_by" => Stream::StepBy(stream, number),
                    "windows" => Stream::Windows(stream, number),
                    _ => Stream::Chunks(stream, number),
                }
            }
        })
    }

    /// Everything that reads the whole sequence.
    fn reduce(
        &mut self,
        name: &str,
        stream: &Stream,
        arguments: &[Value],
        syntax: &'a ExprMethodCall,
    ) -> Option<Value> {
        let receiver = origin(&syntax.receiver);
        match (name, arguments) {
            ("fold", [start, function]) => self.fold(stream, start, function, syntax),
            ("sum", _) => self.sum(stream, syntax),
            ("product", _) => {
                let items = self.items(stream, None, receiver)?;
                self.total(true, items, syntax)
            }
            _ => match self.length_of(stream) {
                Some(length) => Some(Value::index(length)),
                None => self.items(stream, None, receiver).map(|items| Value::integer(items.len() as i128)),
            },
        }
    }

    /// `sum`: of real numbers a loop, of integers term by term.
    fn sum(&mut self, stream: &Stream, syntax: &'a ExprMethodCall) -> Option<Value> {
        let receiver = origin(&syntax.receiver);
        let mut has_integers = asks_for_integers(syntax);
        if !has_integers {
            let sum = self.accumulate(stream, receiver, &mut |this, item| {
                has_integers |= item.is_integer() && !asks_for_reals(syntax);
                if has_integers { None } else { this.real(item, receiver) }
            });
            if !has_integers || self.is_abandoned() {
                return sum.map(Value::Real);
            }
        }
        let items = self.items(stream, None, receiver)?;
        self.total(false, items, syntax)
    }

    /// `sum` and `product` term by term, of real numbers or of integers.
    fn total(&mut self, product: bool, items: Vec<Value>, syntax: &'a ExprMethodCall) -> Option<Value> {
        let are_integers = items.iter().all(Value::is_integer);
        if are_integers && (!items.is_empty() || asks_for_integers(syntax)) {
            let mut total = crate::model::index::Index::integer(i128::from(product));
            for item in &items {
                let item = self.as_index(item, &syntax.receiver)?;
                match if product { total.multiply(&item) } else { total.add(&item) } {
                    Some(next) => total = next,
                    None => {
                        self.report(expressions::integer_arithmetic(&syntax.method));
                        return None;
                    }
                }
            }
            return Some(Value::index(total));
        }
        let reals: Vec<Option<Expr>> =
            items.into_iter().map(|item| self.real(item, &syntax.receiver)).collect();
        let reals = reals.into_iter().collect::<Option<Vec<_>>>()?;
        Some(Value::Real(if product { self.graph.product(&reals) } else { self.graph.sum(&reals) }))
    }

    /// `fold(start, |total, x| ...)`: a sum written by hand is a loop, anything else goes item by item.
    fn fold(
        &mut self,
        stream: &Stream,
        start: &Value,
        function: &Value,
        syntax: &'a ExprMethodCall,
    ) -> Option<Value> {
        let method = &syntax.method;
        if let Value::Real(start) = start
            && !matches!(stream, Stream::Known(_))
        {
            let placeholder = self.graph.new_symbol("");
            let total = self.graph.symbol(placeholder);
            let mut is_sum = true;
            let added = self.accumulate(stream, method, &mut |this, item| {
                let next = this.apply(function, vec![Value::Real(total), item], method);
                let next = this.real(next, method)?;
                let added = this.graph.subtract(next, total);
                is_sum &= !this.graph.depends_on(added, &[placeholder]);
                is_sum.then_some(added)
            });
            if is_sum {
                return added.map(|added| Value::Real(self.graph.add(*start, added)));
            }
            if !self.has_known_items(stream) {
                self.report(expressions::no_sum(method));
                return None;
            }
        }
        let mut total = start.clone();
        for item in self.items(stream, None, origin(&syntax.receiver))? {
            // Accumulating n terms one by one copies n² of them.
            let size = match &total {
                Value::Real(total) => self.graph.node(*total).operands().len(),
                _ => 0,
            };
            if !self.spend(size / 16, method) {
                return None;
            }
            total = self.apply(function, vec![total, item], &syntax.args);
        }
        Some(total)
    }

    /// Whether the items can be had one by one, now or in turns of the loops around.
    pub(super) fn has_known_items(&self, stream: &Stream) -> bool {
        self.length_of(stream).is_none_or(|length| length.is_closed())
    }

    /// A list of what a sequence has now.
    pub(super) fn known_list(&mut self, stream: &Stream, at: &dyn quote::ToTokens) -> Option<Sequence> {
        self.items(stream, None, at).map(Sequence::new)
    }
}

/// The list or range that a chain of methods begins with.
fn origin(mut syntax: &Syntax) -> &Syntax {
    while let Syntax::MethodCall(call) = syntax {
        syntax = &call.receiver;
    }
    syntax
}

/// `sum::<usize>()`
fn asks_for_integers(syntax: &ExprMethodCall) -> bool {
    names_type(syntax, is_integer_type)
}

/// `sum::<f64>()`
fn asks_for_reals(syntax: &ExprMethodCall) -> bool {
    names_type(syntax, |name| name == "f64")
}

fn names_type(syntax: &ExprMethodCall, is_wanted: impl Fn(&str) -> bool) -> bool {
    let argument = syntax.turbofish.as_ref().and_then(|turbofish| turbofish.args.first());
    match argument {
        Some(GenericArgument::Type(Type::Path(path))) => {
            path.path.segments.last().is_some_and(|last| is_wanted(&last.ident.to_string()))
        }
        _ => false,
    }
}
