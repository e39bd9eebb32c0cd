//! The interpreter: its state, its budget, and the dispatch on expressions. Tests:
//! `lower/tests/robustness.rs`.

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::{BinOp, Block, Expr as Syntax, Stmt};

use super::ClosureSpace;
use super::loops::Loops;
use super::scope::Scope;
use super::sequences::Sequence;
use super::tables::Tables;
use super::type_checks::Untyped;
use super::value::{Place, Value};
use crate::diagnostics::{Diagnostics, expressions};
use crate::distinct::Distinct;
use crate::input::{Container, FieldKind, Library, SharedFunction, peeled};
use crate::model::symbols::Symbols;
use crate::model::{Index, Loop, Parameter};
use crate::symbolic::{Expr, Graph, SymbolKind};

/// The most steps of the interpreter in one Hamiltonian.
const MAX_STEPS: usize = 200_000;
/// The deepest nesting of expressions and calls, which nests stack frames.
const MAX_DEPTH: usize = 128;
/// The most variables in scope: every closure keeps the scope in which it was made.
const MAX_VARIABLES: usize = 1024;

/// The most integers in the expression of one integer.
const MAX_ATOMS: usize = 4096;

/// The name of `while` and `loop` in messages, and what to write instead.
const UNKNOWN_TURNS: (&str, &str) =
    ("a loop without a known number of iterations", "use `for i in a..b` or an iterator");

/// A closure with the variables it captured.
pub(super) struct Closure<'a> {
    pub(super) syntax: &'a syn::ExprClosure,
    pub(super) scope: Scope,
}

pub(super) struct Interpreter<'a, 'd> {
    pub(super) graph: Graph,
    pub(super) system: &'a Container,
    /// The parameters in the order of their first use, one per distinct expression.
    pub(super) parameters: Distinct<String, Parameter>,
    /// The shared functions of the declaration.
    pub(super) root: &'a Library,
    pub(super) symbols: Symbols,
    pub(super) tables: Tables,
    pub(super) space: ClosureSpace<'a>,
    /// Integers of unsigned types that may be negative, in their loops.
    pub(super) naturals: Distinct<(Vec<Loop>, Index), (Vec<Loop>, Index)>,
    pub(super) now: Evaluation<'a>,
    /// Sums and products of real numbers whose type is not written.
    pub(super) untyped: Untyped,
    diagnostics: &'d mut Diagnostics,
}

/// The state of the evaluation of one Hamiltonian.
#[derive(Default)]
pub(super) struct Evaluation<'a> {
    pub(super) scope: Scope,
    pub(super) closures: Vec<Closure<'a>>,
    /// The shared functions of the declaration, or of the shared function that is being evaluated.
    pub(super) library: Option<&'a Library>,
    /// The library that has the shared function under evaluation, with the other functions of its type.
    pub(super) library_of_type: Option<&'a Library>,
    /// The shared functions around the current expression.
    pub(super) calls: Vec<&'a SharedFunction>,
    /// The position in the scope of the first variable of the called closure, after the captured ones.
    pub(super) frame: usize,
    /// Whether a closure assigns to captured variables: then the items that it maps must be evaluated in
    /// order.
    pub(super) has_mutation: bool,
    /// The remedy for a name that no field has, in `friction`, `damping` and `temperature`.
    pub(super) advice: Option<&'static str>,
    /// Number of undecided branches around the current expression.
    pub(super) branch: u32,
    pub(super) loops: Loops,
    steps: usize,
    depth: usize,
    exhausted: bool,
}

impl<'a, 'd> Interpreter<'a, 'd> {
    pub(super) fn new(
        graph: Graph,
        symbols: Symbols,
        tables: Tables,
        space: ClosureSpace<'a>,
        system: &'a Container,
        root: &'a Library,
        diagnostics: &'d mut Diagnostics,
    ) -> Self {
        Self {
            graph,
            system,
            parameters: Distinct::default(),
            root,
            symbols,
            tables,
            space,
            naturals: Distinct::default(),
            now: Evaluation::default(),
            untyped: Untyped::default(),
            diagnostics,
        }
    }

    /// Starts the next Hamiltonian: clears everything but the graph and the meaning of its symbols.
    pub(super) fn start(&mut self) {
        self.now = Evaluation { library: Some(self.root), ..Evaluation::default() };
    }

    /// Reports a mistake, unless unrolling may resolve it: a loop of a known range is then evaluated again,
    /// iteration by iteration.
    pub(super) fn report(&mut self, error: syn::Error) {
        if !self.request_unrolling(|_| true) {
            self.diagnostics.report(error);
        }
    }

    /// Reports a mistake, and returns `None`.
    pub(super) fn refuse<T>(&mut self, error: syn::Error) -> Option<T> {
        self.report(error);
        None
    }

    /// Reports a mistake that no value of a loop variable resolves, and returns `None`.
    pub(super) fn refuse_at_once<T>(&mut self, error: syn::Error) -> Option<T> {
        if !self.is_abandoned() {
            self.diagnostics.report(error);
        }
        None
    }

    /// Reports a value of the wrong kind.
    pub(super) fn mismatch<T>(&mut self, at: &dyn ToTokens, expected: &str, found: &Value) -> Option<T> {
        self.refuse(expressions::expected(at, expected, found.describe()))
    }

    /// Number of mistakes so far.
    pub(super) fn mistakes(&self) -> usize {
        self.diagnostics.count()
    }

    /// Deducts `steps` from the budget; `false` once it is spent.
    pub(super) fn spend(&mut self, steps: usize, at: &dyn ToTokens) -> bool {
        self.now.steps = self.now.steps.saturating_add(steps);
        if self.now.steps > MAX_STEPS && !std::mem::replace(&mut self.now.exhausted, true) {
            self.diagnostics.report(expressions::too_many_steps(at, MAX_STEPS));
        }
        !self.now.exhausted
    }

    /// Deducts the cost of one more operand of a chain, whose terms are copied.
    pub(super) fn spend_on(&mut self, chain: &Value, at: &dyn ToTokens) -> bool {
        let operands = chain.as_real().map_or(0, |chain| self.graph.node(chain).operands().len());
        self.spend(operands / 16, at)
    }

    pub(super) fn declare(&mut self, name: syn::Ident, value: Value) {
        if self.now.scope.len() >= MAX_VARIABLES {
            self.report(expressions::too_many_variables(&name, MAX_VARIABLES));
            return;
        }
        let loops = self.loop_depth();
        self.now.scope.declare(name, value, self.now.branch, loops);
    }

    /// The value of an expression; an expression without a value has been reported.
    pub(super) fn evaluate(&mut self, syntax: &'a Syntax) -> Value {
        if self.is_abandoned() || !self.spend(1, syntax) {
            return Value::Poison;
        }
        if self.now.depth >= MAX_DEPTH {
            self.report(expressions::too_deep(syntax, MAX_DEPTH));
            return Value::Poison;
        }
        self.now.depth += 1;
        let value = self.read(syntax).unwrap_or_default();
        self.now.depth -= 1;
        self.within_limits(value, syntax).unwrap_or_default()
    }

    /// Dispatches on the kind of expression.
    fn read(&mut self, syntax: &'a Syntax) -> Option<Value> {
        match syntax {
            Syntax::Lit(literal) => self.literal(&literal.lit),
            Syntax::Path(path) => self.path(path),
            Syntax::Paren(inner) => Some(self.evaluate(&inner.expr)),
            Syntax::Group(inner) => Some(self.evaluate(&inner.expr)),
            Syntax::Reference(inner) if inner.mutability.is_none() => Some(self.evaluate(&inner.expr)),
            Syntax::Unary(unary) => self.unary(unary),
            Syntax::Binary(binary) => self.binary(binary),
            Syntax::Assign(assign) => {
                let value = self.evaluate(&assign.right);
                Some(self.store(&assign.left, value))
            }
            Syntax::Cast(cast) => self.cast(cast),
            Syntax::Block(block) if block.label.is_none() => Some(self.block(&block.block)),
            Syntax::If(branch) => self.branch(branch),
            Syntax::Match(choice) => self.match_arms(choice),
            Syntax::ForLoop(repeat) if repeat.label.is_none() => self.for_loop(repeat),
            Syntax::Closure(closure) => self.closure(closure),
            Syntax::Call(call) => self.call(call),
            Syntax::MethodCall(call) => self.method_call(call),
            Syntax::Field(field) => self.field(field),
            Syntax::Index(index) => self.index(index),
            Syntax::Range(range) => self.range(range),
            Syntax::Tuple(tuple) => Some(Value::tuple(self.elements(&tuple.elems))),
            Syntax::Array(array) => Some(Value::list(self.elements(&array.elems))),
            Syntax::Repeat(repeat) => self.repeat(repeat),
            _ => self.unsupported(syntax),
        }
    }

    pub(super) fn elements(
        &mut self,
        elements: &'a syn::punctuated::Punctuated<Syntax, syn::Token![,]>,
    ) -> Vec<Value> {
        elements.iter().map(|element| self.evaluate(element)).collect()
    }

    /// `value`, unless it is too deep to be dropped safely, or its integers double with each `let`.
    pub(super) fn within_limits(&mut self, value: Value, at: &dyn ToTokens) -> Option<Value> {
        let error = match &value {
            value if value.depth() as usize > MAX_DEPTH => expressions::too_deep(at, MAX_DEPTH),
            value if value.atoms() > MAX_ATOMS => expressions::long_integer(at, MAX_ATOMS),
            _ => return Some(value),
        };
        self.refuse(error)
    }

    fn unsupported(&mut self, syntax: &Syntax) -> Option<Value> {
        let (at, what, remedy): (&dyn ToTokens, _, _) = match syntax {
            Syntax::Let(_) => (syntax, "`if let`", "use conditions on numbers"),
            Syntax::While(syntax) => (&syntax.while_token, UNKNOWN_TURNS.0, UNKNOWN_TURNS.1),
            Syntax::Loop(syntax) => (&syntax.loop_token, UNKNOWN_TURNS.0, UNKNOWN_TURNS.1),
            Syntax::Break(_) | Syntax::Continue(_) => {
                (syntax, "leaving a loop early", "use `filter` or an `if` inside")
            }
            Syntax::Return(syntax) => {
                (&syntax.return_token, "`return`", "let the value be the last expression")
            }
            Syntax::Macro(_) => (syntax, "a macro call", "write out what it stands for"),
            Syntax::Reference(_) => (syntax, "`&mut`", "return new values instead"),
            Syntax::Struct(_) => (syntax, "a struct value", "use a tuple or an array"),
            Syntax::Try(syntax) => (&syntax.question_token, "`?`", "a Hamiltonian cannot fail"),
            Syntax::Block(_) | Syntax::ForLoop(_) => (syntax, "a labelled block", "leave out the label"),
            Syntax::Unsafe(syntax) => (&syntax.unsafe_token, "`unsafe`", "write safe arithmetic"),
            _ => {
                let remedy = "use arithmetic, `f64` methods, `let`, `if`, closures and iterators";
                (syntax, "this expression", remedy)
            }
        };
        self.refuse(expressions::unsupported(at, what, remedy))
    }

    /// The value of a Hamiltonian.
    pub(super) fn energy(&mut self, value: Value, at: &dyn ToTokens) -> Option<Expr> {
        let is_vector = match &value {
            Value::Tuple(parts) => !parts.items.is_empty(),
            Value::Sequence(sequence) => sequence.is_list(),
            _ => false,
        };
        if is_vector {
            return self.refuse(expressions::vector_as_energy(at, value.describe()));
        }
        self.real(value, at)
    }

    /// `value` as a real number; any other kind of value is reported at `at`.
    pub(super) fn real(&mut self, value: Value, at: &dyn ToTokens) -> Option<Expr> {
        match value {
            Value::Real(expr) => Some(expr),
            Value::Poison => None,
            Value::Constant(place) => Some(self.constant(&place)),
            Value::Index(..) => self.refuse(expressions::integer_not_real(at)),
            value => self.mismatch(at, "an `f64`", &value),
        }
    }

    /// A constant as a real number: arithmetic of constants is symbolic.
    fn constant(&mut self, place: &Place) -> Expr {
        let Some((left, operator, right)) = &place.made_of else {
            return self.parameter(&place.name, place.tokens.clone());
        };
        let left = left.as_ref().map_or(self.graph.integer(0), |left| self.constant(left));
        let right = self.constant(right);
        match operator {
            BinOp::Add(_) => self.graph.add(left, right),
            BinOp::Sub(_) => self.graph.subtract(left, right),
            BinOp::Mul(_) => self.graph.multiply(left, right),
            BinOp::Div(_) => self.graph.divide(left, right),
            _ => self.parameter(&place.name, place.tokens.clone()),
        }
    }

    /// A symbol that stands for the `f64` expression `tokens`.
    pub(super) fn parameter(&mut self, name: &str, tokens: TokenStream) -> Expr {
        self.new_parameter(name, tokens, false)
    }

    /// A symbol that stands for an integer as a real number; `tokens` are its cast.
    pub(super) fn integer_parameter(&mut self, name: &str, tokens: TokenStream) -> Expr {
        self.new_parameter(name, tokens, true)
    }

    fn new_parameter(&mut self, name: &str, tokens: TokenStream, is_integer: bool) -> Expr {
        let made = || {
            let symbol = self.graph.new_symbol(SymbolKind::Parameter, name);
            Parameter { symbol, tokens: tokens.clone(), is_integer }
        };
        let place = self.parameters.place(tokens.to_string(), made);
        self.graph.symbol(self.parameters.values[place].symbol)
    }

    /// The content of a place: a real number is read at once, anything else on use.
    pub(super) fn place(&mut self, place: Place, at: &dyn ToTokens) -> Option<Value> {
        Some(match &place.kind {
            FieldKind::Real => Value::Real(self.parameter(&place.name, place.tokens.clone())),
            &FieldKind::Integer(is_unsigned) => Value::index(self.given(&place)).unsigned(is_unsigned),
            FieldKind::List(element, length) => {
                Value::sequence(Sequence::array(self.table(&place, element, *length)))
            }
            FieldKind::Constant => Value::Constant(place.into()),
            FieldKind::Other(ty) | FieldKind::Tuple(_, ty) => {
                return self.refuse(expressions::field_type(at, &place.name, ty));
            }
        })
    }
}

/// The expression that gives a body its value, for messages.
pub(super) fn result_of(syntax: &Syntax) -> &Syntax {
    let result = peeled(syntax);
    match result {
        Syntax::Block(block) => last_expression(&block.block).map_or(result, result_of),
        _ => result,
    }
}

pub(super) fn last_expression(block: &Block) -> Option<&Syntax> {
    match block.stmts.last() {
        Some(Stmt::Expr(expr, None)) => Some(expr),
        _ => None,
    }
}
