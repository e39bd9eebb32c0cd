//! The interpreter: its state, its budget, and which rule reads which expression.

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::{Block, Expr as Syntax, Stmt};

use super::names::Parameters;
use super::scope::Scope;
use super::sized::Loops;
use super::value::{Place, Value};
use crate::diagnostics::{Diagnostics, expressions};
use crate::functions::{Function, Library};
use crate::input::{Container, Kind};
use crate::model::Parameter;
use crate::symbolic::{Expr, Graph, Rational};

/// Operations that one Hamiltonian may unroll to.
const MAX_STEPS: usize = 200_000;
/// Nesting of expressions and calls, which is nesting of stack frames here.
const MAX_DEPTH: usize = 128;
/// Variables in scope: every closure keeps the scope it was made in.
const MAX_VARIABLES: usize = 1024;

/// A closure with the variables it captured.
pub(super) struct Closure<'a> {
    pub(super) syntax: &'a syn::ExprClosure,
    pub(super) scope: Scope,
}

pub(super) struct Interpreter<'a, 'd> {
    pub(super) graph: Graph,
    pub(super) system: &'a Container,
    pub(super) parameters: Parameters,
    pub(super) scope: Scope,
    pub(super) closures: Vec<Closure<'a>>,
    /// The shared functions of the declaration, and of the shared function that is being evaluated.
    pub(super) root: Option<&'a Library>,
    pub(super) library: Option<&'a Library>,
    /// The shared functions around the current expression.
    pub(super) calls: Vec<&'a Function>,
    /// Number of undecided branches around the current expression.
    pub(super) branch: u32,
    /// In a system of elements: its loops, tables and local variables.
    pub(super) sized: Option<Loops>,
    /// Names of coordinates and momenta, for display.
    pub(super) names: [String; 2],
    diagnostics: &'d mut Diagnostics,
    steps: usize,
    depth: usize,
    exhausted: bool,
}

impl<'a, 'd> Interpreter<'a, 'd> {
    pub(super) fn new(graph: Graph, system: &'a Container, diagnostics: &'d mut Diagnostics) -> Self {
        Self {
            graph,
            system,
            parameters: Parameters::default(),
            scope: Scope::default(),
            closures: Vec::new(),
            root: None,
            library: None,
            calls: Vec::new(),
            branch: 0,
            sized: None,
            names: ["q".to_owned(), "p".to_owned()],
            diagnostics,
            steps: 0,
            depth: 0,
            exhausted: false,
        }
    }

    /// Forgets everything but the graph and the parameters: the next Hamiltonian starts.
    pub(super) fn start(&mut self) {
        self.scope = Scope::default();
        self.closures.clear();
        self.calls.clear();
        self.library = self.root;
        (self.branch, self.steps, self.depth, self.exhausted) = (0, 0, 0, false);
    }

    pub(super) fn into_parts(self) -> (Graph, Vec<Parameter>) {
        (self.graph, self.parameters.into_list())
    }

    pub(super) fn report(&mut self, error: syn::Error) -> Value {
        self.diagnostics.report(error);
        Value::Poison
    }

    /// Takes `steps` from the budget; `false` once it is spent.
    pub(super) fn spend(&mut self, steps: usize, at: &dyn ToTokens) -> bool {
        self.steps = self.steps.saturating_add(steps);
        if self.steps > MAX_STEPS && !std::mem::replace(&mut self.exhausted, true) {
            self.report(expressions::too_many_steps(at.to_token_stream(), MAX_STEPS));
        }
        !self.exhausted
    }

    pub(super) fn declare(&mut self, name: syn::Ident, value: Value) {
        if self.scope.len() >= MAX_VARIABLES {
            self.report(expressions::too_many_variables(&name, MAX_VARIABLES));
            return;
        }
        self.scope.declare(name, value, self.branch);
    }

    pub(super) fn evaluate(&mut self, syntax: &'a Syntax) -> Value {
        if !self.spend(1, syntax) {
            return Value::Poison;
        }
        if self.depth >= MAX_DEPTH {
            return self.report(expressions::too_deep(syntax, MAX_DEPTH));
        }
        self.depth += 1;
        let value = self.read(syntax);
        self.depth -= 1;
        value
    }

    /// Which rule reads which expression.
    fn read(&mut self, syntax: &'a Syntax) -> Value {
        match syntax {
            Syntax::Lit(literal) => self.literal(&literal.lit),
            Syntax::Path(path) => self.path(path),
            Syntax::Paren(inner) => self.evaluate(&inner.expr),
            Syntax::Group(inner) => self.evaluate(&inner.expr),
            Syntax::Reference(inner) if inner.mutability.is_none() => self.evaluate(&inner.expr),
            Syntax::Unary(unary) => self.unary(unary),
            Syntax::Binary(binary) => self.binary(binary),
            Syntax::Assign(assign) => self.assign(&assign.left, &assign.right),
            Syntax::Cast(cast) => self.cast(cast),
            Syntax::Block(block) if block.label.is_none() => self.block(&block.block),
            Syntax::If(branch) => self.branch(branch),
            Syntax::ForLoop(repeat) if repeat.label.is_none() => self.for_loop(repeat),
            Syntax::Closure(closure) => self.closure(closure),
            Syntax::Call(call) => self.call(call),
            Syntax::MethodCall(call) => self.method_call(call),
            Syntax::Field(field) => self.field(field),
            Syntax::Index(index) => self.index(index),
            Syntax::Range(range) => self.range(range),
            Syntax::Tuple(tuple) => {
                let items = self.elements(&tuple.elems);
                self.bounded(Value::tuple(items), syntax)
            }
            Syntax::Array(array) => {
                let items = self.elements(&array.elems);
                self.bounded(Value::list(items), syntax)
            }
            Syntax::Repeat(repeat) => self.repeat(repeat),
            _ => self.unsupported(syntax),
        }
    }

    fn elements(&mut self, elements: &'a syn::punctuated::Punctuated<Syntax, syn::Token![,]>) -> Vec<Value> {
        elements.iter().map(|element| self.evaluate(element)).collect()
    }

    /// `value`, unless it is a list too deep to be dropped safely.
    pub(super) fn bounded(&mut self, value: Value, at: &dyn ToTokens) -> Value {
        let depth = match &value {
            Value::List(sequence) | Value::Tuple(sequence) | Value::Iterator(sequence) => sequence.depth,
            _ => 0,
        };
        match depth as usize > MAX_DEPTH {
            true => self.report(expressions::too_deep(at.to_token_stream(), MAX_DEPTH)),
            false => value,
        }
    }

    fn unsupported(&mut self, syntax: &Syntax) -> Value {
        let (what, remedy) = match syntax {
            Syntax::Match(_) => ("`match`", "use `if` and `else`"),
            Syntax::Let(_) => ("`if let`", "use conditions on numbers"),
            Syntax::While(_) | Syntax::Loop(_) => {
                ("a loop without a known number of turns", "use `for i in a..b` or an iterator")
            }
            Syntax::Break(_) | Syntax::Continue(_) => {
                ("leaving a loop early", "use `filter` or an `if` inside")
            }
            Syntax::Return(_) => ("`return`", "let the value be the last expression"),
            Syntax::Macro(_) => ("a macro call", "write out what it stands for"),
            Syntax::Reference(_) => ("`&mut`", "return new values instead"),
            Syntax::Struct(_) => ("a struct value", "use a tuple or an array"),
            Syntax::Try(_) => ("`?`", "a Hamiltonian cannot fail"),
            Syntax::Block(_) | Syntax::ForLoop(_) => ("a labelled block", "leave out the label"),
            Syntax::Unsafe(_) => ("`unsafe`", "write safe arithmetic"),
            _ => ("this expression", "use arithmetic, `f64` methods, `let`, `if`, closures and iterators"),
        };
        let at = match syntax {
            Syntax::Match(syntax) => syntax.match_token.to_token_stream(),
            Syntax::While(syntax) => syntax.while_token.to_token_stream(),
            Syntax::Loop(syntax) => syntax.loop_token.to_token_stream(),
            Syntax::Return(syntax) => syntax.return_token.to_token_stream(),
            Syntax::Unsafe(syntax) => syntax.unsafe_token.to_token_stream(),
            Syntax::Try(syntax) => syntax.question_token.to_token_stream(),
            _ => syntax.to_token_stream(),
        };
        self.report(expressions::unsupported(at, what, remedy))
    }

    /// The value of a Hamiltonian.
    pub(super) fn energy(&mut self, value: Value, at: &dyn ToTokens) -> Option<Expr> {
        match value {
            Value::Tuple(ref parts) if parts.items.is_empty() => self.real(value, at),
            Value::List(_) | Value::Tuple(_) | Value::Array(_) => {
                self.report(expressions::vector_as_energy(at.to_token_stream(), value.describe()));
                None
            }
            value => self.real(value, at),
        }
    }

    /// `value` as a real number; what it is instead is reported at `at`.
    pub(super) fn real(&mut self, value: Value, at: &dyn ToTokens) -> Option<Expr> {
        let error = match value {
            Value::Real(expr) => return Some(expr),
            Value::Poison => return None,
            Value::Index(_) => expressions::integer_not_real(at.to_token_stream()),
            Value::Place(place) if matches!(place.kind, Kind::Constant | Kind::Real) => {
                return Some(self.parameter(&place.name, place.value()));
            }
            value if value.is_integer() => expressions::integer_not_real(at.to_token_stream()),
            value => expressions::expected(at.to_token_stream(), "an `f64`", value.describe()),
        };
        self.report(error);
        None
    }

    /// `value` as an integer that is known, for an index or a bound.
    pub(super) fn known_integer(&mut self, value: Value, at: &dyn ToTokens) -> Option<i128> {
        let error = match value {
            Value::Integer(value) => return Some(value),
            Value::Poison => return None,
            Value::Place(_) | Value::Index(_) => expressions::index_not_known(at.to_token_stream()),
            value => expressions::expected(at.to_token_stream(), "an integer", value.describe()),
        };
        self.report(error);
        None
    }

    /// The exact real number of an integer.
    pub(super) fn integer_as_real(&mut self, value: i128) -> Value {
        Value::Real(match Rational::new(value, 1) {
            Some(exact) => self.graph.number(exact),
            None => self.graph.float(value as f64),
        })
    }

    /// A symbol that stands for the `f64` expression `tokens`.
    pub(super) fn parameter(&mut self, name: &str, tokens: TokenStream) -> Expr {
        let symbol = self.parameters.symbol(&mut self.graph, name, tokens);
        self.graph.symbol(symbol)
    }

    /// What a place holds: a real number is read at once, the rest waits for its use.
    pub(super) fn place(&mut self, place: Place, at: &dyn ToTokens) -> Value {
        match &place.kind {
            Kind::Real => Value::Real(self.parameter(&place.name, place.value())),
            Kind::Other(ty) | Kind::Tuple(_, ty) => {
                self.report(expressions::field_type(at.to_token_stream(), &place.name, ty))
            }
            _ => Value::Place(place.into()),
        }
    }
}

/// The expression that gives a body its value, for messages.
pub(super) fn result_of(mut syntax: &Syntax) -> &Syntax {
    loop {
        syntax = match syntax {
            Syntax::Paren(inner) => &inner.expr,
            Syntax::Group(inner) => &inner.expr,
            Syntax::Block(block) => match last_expression(&block.block) {
                Some(inner) => inner,
                None => return syntax,
            },
            _ => return syntax,
        };
    }
}

pub(super) fn last_expression(block: &Block) -> Option<&Syntax> {
    match block.stmts.last() {
        Some(Stmt::Expr(expr, None)) => Some(expr),
        _ => None,
    }
}
