//! Operations as Rust tokens: shared values get a name, the rest is inlined. Tests:
//! `tests/steps/accuracy.rs`, and the golden expansions (`compile/golden_tests.rs`).

use std::collections::{HashMap, HashSet};

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::quote;

use super::names::{Namer, plain};
use super::program::{Level, Op, Operation, Program};
use crate::diagnostics::internal::broken;
use crate::symbolic::{Function, Junction};

/// The most operations in one expression; beyond, a value is named even if it is used once.
const LONGEST_EXPRESSION: u32 = 14;
/// The longest formula used as a name; other values are named by their kind.
const LONGEST_NAME: usize = 20;

/// The precedence of an expression.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Precedence {
    /// An `if` or a comparison.
    Whole,
    Sum,
    Product,
    Prefix,
    Atom,
}

/// The type that holds a value.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Rank {
    /// `f64`: literals, the step size, the time.
    Number,
    /// The type of constants, where it differs from `f64`: the parameters of the system, and prepared values.
    Constant,
    /// The type of the state.
    Scalar,
}

/// Prints operations of one program for one scalar type, and records the names bound so far.
#[derive(Clone)]
pub(crate) struct Printer<'p> {
    program: &'p Program,
    /// The type of state-level values.
    scalar: TokenStream,
    /// The type of values computed from constants, where it differs from `f64`.
    constant: TokenStream,
    /// The operations that read such a constant.
    readers: Vec<bool>,
    /// The types of values that [`Printer::lift`] has bound.
    lifted: HashMap<Op, Rank>,
    bound: HashMap<Op, Ident>,
    hints: &'p HashMap<Op, String>,
    names: Namer,
    /// Operations named by their kind, which is not used within other names.
    plain: HashSet<Op>,
}

impl<'p> Printer<'p> {
    /// A printer for a body in which `names` are already taken.
    pub(crate) fn new(
        program: &'p Program,
        scalar: TokenStream,
        hints: &'p HashMap<Op, String>,
        names: Namer,
    ) -> Self {
        let (readers, bound, lifted, plain) = Default::default();
        Self { program, scalar, constant: f64_type(), readers, lifted, bound, hints, names, plain }
    }

    /// The printer with `constants` of the type `constant`, and values computed from them before the state is
    /// known.
    pub(crate) fn with_constants(mut self, constants: &[Op], constant: TokenStream) -> Self {
        (self.constant, self.readers) = (constant, self.program.readers_of(constants));
        self
    }

    /// Binds values that do not read the state: computed as constants, then converted to the scalar type.
    /// Truths are `bool`.
    pub(crate) fn lift(&mut self, ops: &[Op]) -> TokenStream {
        let mut statements = self.bind(ops, &self.program.uses(ops), &|_| false);
        let lift = |&op: &Op| match (self.value(op), &self.scalar) {
            (value, _) if self.program.operation(op).is_truth() => (op, value, Rank::Number),
            (value, scalar) => (op, quote!(#scalar::of_constant(#value)), Rank::Scalar),
        };
        // Names that are bound again come last.
        let (bound, new): (Vec<Op>, Vec<Op>) = ops.iter().partition(|&&op| self.is_bound(op));
        for (op, value, rank) in new.iter().chain(&bound).map(lift).collect::<Vec<_>>() {
            let name = self.bound(op).cloned().unwrap_or_else(|| self.name(op));
            statements.extend(quote!(let #name = #value;));
            self.lifted.insert(op, rank);
        }
        statements
    }

    /// Binds `op` to `name`.
    pub(crate) fn set(&mut self, op: Op, name: Ident) {
        self.names.avoid(&name);
        self.bound.insert(op, name);
    }

    pub(crate) fn is_bound(&self, op: Op) -> bool {
        self.bound.contains_key(&op)
    }

    /// The name of `op`, if it has one.
    pub(crate) fn bound(&self, op: Op) -> Option<&Ident> {
        self.bound.get(&op)
    }

    /// A new name for `op`.
    pub(crate) fn name(&mut self, op: Op) -> Ident {
        let (wish, is_plain) = self.spelled(op);
        let name = self.names.take(&wish);
        self.bound.insert(op, name.clone());
        if is_plain {
            self.plain.insert(op);
        }
        name
    }

    /// A new name for something else.
    pub(crate) fn other(&mut self, wish: &str) -> Ident {
        self.names.take(wish)
    }

    /// The name of `op`, or a readable candidate.
    pub(crate) fn wish_or_name(&self, op: Op) -> String {
        self.word(op).unwrap_or_else(|| self.spelled(op).0)
    }

    /// The name of `op` without its mark, if it has one.
    fn word(&self, op: Op) -> Option<String> {
        self.bound.get(&op).map(|name| plain(&name.to_string()).to_owned())
    }

    /// A readable name for the value, and whether it is only its kind.
    fn spelled(&self, op: Op) -> (String, bool) {
        if let Some(hint) = self.hints.get(&op) {
            return (hint.clone(), false);
        }
        let words = |op: Op| match self.program.operation(op) {
            Operation::Constant(bits) => fraction(f64::from_bits(*bits)).map(str::to_owned),
            _ if self.plain.contains(&op) => None,
            _ => self.word(op),
        };
        let (spelled, kind) = match self.program.operation(op) {
            Operation::Multiply(a, b) if a == b => (self.word(*a).map(squared), "product"),
            Operation::Multiply(a, b) => {
                let (a, b) = if self.program.is_literal(*b) { (b, a) } else { (a, b) };
                (words(*a).zip(words(*b)).map(|(a, b)| format!("{a}_{b}")), "product")
            }
            Operation::Reciprocal(a) => (words(*a).map(|a| format!("inverse_{a}")), "inverse"),
            Operation::Negate(a) => (words(*a).map(|a| format!("minus_{a}")), "minus"),
            Operation::Call(function, arguments) => {
                let argument = arguments.first().filter(|_| arguments.len() == 1);
                let spelled = argument.and_then(|&a| words(a)).map(|a| format!("{}_{a}", function.method()));
                (spelled, function.method())
            }
            Operation::Power(..) => (None, "power"),
            Operation::Add(..) => (None, "sum"),
            Operation::Subtract(..) => (None, "difference"),
            Operation::Divide(..) => (None, "quotient"),
            Operation::Select(..) => (None, "choice"),
            Operation::Constant(_) | Operation::Input(_) => (None, "value"),
            Operation::Compare(..) | Operation::Not(_) | Operation::Join(..) => (None, "condition"),
        };
        match spelled.filter(|name| name.len() <= LONGEST_NAME) {
            Some(name) => (name, false),
            None => (kind.to_owned(), true),
        }
    }

    /// `let` statements for shared values of `roots`; `uses` counts operands, and `forced` operations always
    /// get a name.
    pub(crate) fn bind(&mut self, roots: &[Op], uses: &[u32], forced: &dyn Fn(Op) -> bool) -> TokenStream {
        let needed = {
            let bound = &self.bound;
            self.program.needed(roots, &|op| bound.contains_key(&op))
        };
        let mut length: HashMap<Op, u32> = HashMap::new();
        let mut statements = TokenStream::new();
        for &op in &needed {
            if self.is_bound(op) {
                continue;
            }
            let operation = self.program.operation(op);
            let own: u32 =
                1 + operation.operands().iter().map(|a| length.get(a).copied().unwrap_or(0)).sum::<u32>();
            let is_shared = uses.get(op).copied().unwrap_or(0) > 1 || forced(op) || own > LONGEST_EXPRESSION;
            if let Some((sine, cosine)) = self.sine_and_cosine(op, &needed) {
                let both = self.method(self.program.operation(sine).operands()[0], "sin_cos", None);
                let (sine, cosine) = (self.name(sine), self.name(cosine));
                statements.extend(quote!(let (#sine, #cosine) = #both;));
            } else if is_shared && !operation.is_trivial() {
                let value = self.value(op);
                let name = self.name(op);
                statements.extend(quote!(let #name = #value;));
            } else {
                length.insert(op, own);
            }
        }
        statements
    }

    /// The sine and the cosine of one argument, if both are needed.
    fn sine_and_cosine(&self, op: Op, needed: &[Op]) -> Option<(Op, Op)> {
        let Operation::Call(function @ (Function::Sin | Function::Cos), argument) =
            self.program.operation(op)
        else {
            return None;
        };
        let other = if *function == Function::Sin { Function::Cos } else { Function::Sin };
        let partner = self.program.find(&Operation::Call(other, argument.clone()))?;
        if needed.binary_search(&partner).is_err() || self.is_bound(partner) {
            return None;
        }
        Some(if *function == Function::Sin { (op, partner) } else { (partner, op) })
    }

    /// The value of `op` as an expression.
    pub(crate) fn value(&self, op: Op) -> TokenStream {
        self.print(op).0
    }

    /// The value of `op` as an expression of the scalar type.
    pub(crate) fn scalar_value(&self, op: Op) -> TokenStream {
        self.lifted(op, Rank::Scalar)
    }

    /// The value of `op` in the scalar type, as a factor of a product.
    pub(crate) fn scalar_factor(&self, op: Op) -> TokenStream {
        if self.is_scalar(op) { self.at_least(op, Precedence::Product) } else { self.scalar_value(op) }
    }

    /// The value of `op`, which does not read the state, as an expression of the type of constants.
    pub(crate) fn constant_value(&self, op: Op) -> TokenStream {
        match self.program.operation(op).is_truth() {
            true => self.truth(op, Rank::Constant),
            false => self.lifted(op, Rank::Constant),
        }
    }

    /// The value of `op` as an expression of the type of a rank, which is at least its own.
    fn lifted(&self, op: Op, rank: Rank) -> TokenStream {
        let (value, Self { scalar, constant, .. }) = (self.value(op), self);
        match (self.rank(op), rank) {
            (own, wanted) if own == wanted => value,
            (Rank::Number, Rank::Constant) => quote!(<#constant as __wzvi::Scalar>::from_f64(#value)),
            (Rank::Constant, _) => quote!(<#scalar as __wzvi::ComputesWith<#constant>>::constant(#value)),
            _ => quote!(#scalar::from_f64(#value)),
        }
    }

    fn is_scalar(&self, op: Op) -> bool {
        self.rank(op) == Rank::Scalar
    }

    /// The type of a value.
    pub(crate) fn rank(&self, op: Op) -> Rank {
        match (self.lifted.get(&op), self.program.operation(op)) {
            (Some(lifted), _) => *lifted,
            (_, truth) if truth.is_truth() && !self.lifted.is_empty() => {
                truth.operands().iter().map(|&operand| self.rank(operand)).max().unwrap_or(Rank::Number)
            }
            _ if self.program.level(op) >= Level::Increments => Rank::Scalar,
            _ if self.readers.get(op) == Some(&true) => Rank::Constant,
            _ => Rank::Number,
        }
    }

    /// The type of a rank.
    fn ty(&self, rank: Rank) -> TokenStream {
        match rank {
            Rank::Scalar => self.scalar.clone(),
            Rank::Constant => self.constant.clone(),
            Rank::Number => f64_type(),
        }
    }

    fn atom(&self, op: Op) -> TokenStream {
        self.at_least(op, Precedence::Atom)
    }

    /// The receiver of a method: literals get a type suffix there.
    fn receiver(&self, op: Op) -> TokenStream {
        match self.program.operation(op) {
            Operation::Constant(bits) if !self.is_bound(op) && f64::from_bits(*bits).is_finite() => {
                let (magnitude, sign) =
                    (f64::from_bits(*bits).abs(), f64::from_bits(*bits).is_sign_negative());
                let literal = Literal::f64_suffixed(magnitude);
                if sign { quote!((-#literal)) } else { quote!(#literal) }
            }
            _ => self.atom(op),
        }
    }

    fn at_least(&self, op: Op, binding: Precedence) -> TokenStream {
        let (value, own) = self.print(op);
        if own >= binding { value } else { quote!((#value)) }
    }

    fn print(&self, op: Op) -> (TokenStream, Precedence) {
        if let Some(name) = self.bound.get(&op) {
            return (quote!(#name), Precedence::Atom);
        }
        match self.program.operation(op) {
            Operation::Constant(bits) => constant(f64::from_bits(*bits)),
            Operation::Input(_) => {
                broken("inputs are bound before they are read");
                (quote!(()), Precedence::Atom)
            }
            Operation::Add(a, b) => {
                let (a, b) = self.highest_first(*a, *b);
                let (a, b) = (self.at_least(a, Precedence::Sum), self.at_least(b, Precedence::Product));
                (quote!(#a + #b), Precedence::Sum)
            }
            Operation::Subtract(a, b) if self.rank(*a) < self.rank(*b) => {
                let (a, b) = (self.at_least(*a, Precedence::Product), self.atom(*b));
                (quote!(-#b + #a), Precedence::Sum)
            }
            Operation::Subtract(a, b) => {
                let (a, b) = (self.at_least(*a, Precedence::Sum), self.at_least(*b, Precedence::Product));
                (quote!(#a - #b), Precedence::Sum)
            }
            Operation::Multiply(a, b) => {
                let (a, b) = self.highest_first(*a, *b);
                let (a, b) = (self.at_least(a, Precedence::Product), self.at_least(b, Precedence::Prefix));
                (quote!(#a * #b), Precedence::Product)
            }
            Operation::Divide(a, b) => {
                let rank = self.rank(*b);
                let mixed = self.rank(*a) < rank;
                let a = if mixed { self.lifted(*a, rank) } else { self.at_least(*a, Precedence::Product) };
                let b = self.at_least(*b, Precedence::Prefix);
                (quote!(#a / #b), Precedence::Product)
            }
            Operation::Negate(a) => {
                let a = self.atom(*a);
                (quote!(-#a), Precedence::Prefix)
            }
            Operation::Reciprocal(a) => {
                let a = self.receiver(*a);
                (quote!(#a.recip()), Precedence::Atom)
            }
            Operation::Power(a, exponent) => {
                (self.method(*a, "powi", Some(Literal::i32_unsuffixed(*exponent))), Precedence::Atom)
            }
            Operation::Call(function, arguments) => (self.call(op, *function, arguments), Precedence::Atom),
            Operation::Select(condition, then, otherwise) => self.select(op, *condition, *then, *otherwise),
            logical => self.condition(op, logical),
        }
    }

    fn call(&self, op: Op, function: Function, arguments: &[Op]) -> TokenStream {
        if let (Function::Special(special), &[argument]) = (function, arguments) {
            let argument = self.argument(argument);
            // The variant as Rust writes it: `Sinc(1)`.
            let special: TokenStream = format!("{special:?}").parse().unwrap_or_default();
            return quote!(__wzvi::Scalar::special(#argument, __wzvi::Special::#special));
        }
        if let &[argument] = arguments {
            return self.method(argument, function.method(), None);
        }
        let method = Ident::new(function.method(), Span::call_site());
        let (rank, scalar) = (self.rank(op), self.ty(self.rank(op)));
        let arguments = arguments.iter().map(|&a| self.lifted(a, rank));
        match rank == Rank::Scalar {
            true => quote!(#scalar::#method(#(#arguments),*)),
            false => quote!(<#scalar as __wzvi::Scalar>::#method(#(#arguments),*)),
        }
    }

    /// A method of `Scalar`. Numbers have methods of that name of their own, which are those of the platform.
    fn method(&self, receiver: Op, name: &str, exponent: Option<Literal>) -> TokenStream {
        let method = Ident::new(name, Span::call_site());
        if self.rank(receiver) == Rank::Number {
            let receiver = self.argument(receiver);
            let exponent = exponent.map(|exponent| quote!(, #exponent));
            return quote!(__wzvi::Scalar::#method(#receiver #exponent));
        }
        let receiver = self.receiver(receiver);
        quote!(#receiver.#method(#exponent))
    }

    /// An argument of a function of any number type: literals get a type suffix there.
    fn argument(&self, op: Op) -> TokenStream {
        if self.program.is_literal(op) { self.receiver(op) } else { self.value(op) }
    }

    /// The operand of higher rank comes first: only its type implements the operation.
    fn highest_first(&self, a: Op, b: Op) -> (Op, Op) {
        if self.is_scalar(a) || self.rank(a) > self.rank(b) { (a, b) } else { (b, a) }
    }

    fn select(&self, op: Op, condition: Op, then: Op, otherwise: Op) -> (TokenStream, Precedence) {
        let branch = |a: Op| self.lifted(a, self.rank(op));
        let (then, otherwise) = (branch(then), branch(otherwise));
        if self.rank(condition) > Rank::Number {
            let is_mask = self.rank(condition) == self.rank(op);
            if !is_mask && self.rank(condition) == Rank::Constant {
                // The condition is the same for all steps: only one branch is computed.
                let (ty, value, constant) = (self.ty(self.rank(op)), self.value(condition), &self.constant);
                let choice =
                    quote!(<#ty as __wzvi::ComputesWith<#constant>>::choose(#value, || #then, || #otherwise));
                return (choice, Precedence::Atom);
            }
            let value = if is_mask { self.value(condition) } else { self.truth(condition, self.rank(op)) };
            (quote!(__wzvi::Scalar::select(#value, #then, #otherwise)), Precedence::Atom)
        } else {
            let value = self.value(condition);
            (quote!(if #value { #then } else { #otherwise }), Precedence::Whole)
        }
    }

    /// A truth as the mask of a rank, which is at least its own.
    fn truth(&self, op: Op, rank: Rank) -> TokenStream {
        let (value, ty, constant) = (self.atom(op), self.ty(rank), &self.constant);
        match self.rank(op) {
            own if own == rank => value,
            Rank::Constant => quote!(<#ty as __wzvi::ComputesWith<#constant>>::truth(#value)),
            _ => quote!(<<#ty as __wzvi::Scalar>::Mask as __wzvi::Mask>::from_bool(#value)),
        }
    }

    /// A comparison or a combination of truths: a mask of the type of what it reads.
    fn condition(&self, op: Op, operation: &Operation) -> (TokenStream, Precedence) {
        let rank = self.rank(op);
        let truth = |a: Op| self.truth(a, rank);
        match *operation {
            Operation::Compare(relation, a, b) if rank > Rank::Number => {
                let (a, b) = (self.lifted(a, rank), self.lifted(b, rank));
                let method = Ident::new(relation.spelled()[0], Span::call_site());
                (quote!(__wzvi::Scalar::#method(#a, #b)), Precedence::Atom)
            }
            Operation::Compare(relation, a, b) => {
                let (a, b) = (self.at_least(a, Precedence::Sum), self.at_least(b, Precedence::Sum));
                let operator: TokenStream = relation.spelled()[1].parse().unwrap_or_default();
                (quote!(#a #operator #b), Precedence::Whole)
            }
            Operation::Not(a) => {
                let a = truth(a);
                (quote!(!#a), Precedence::Prefix)
            }
            Operation::Join(junction, a, b) => {
                let (a, b) = (truth(a), truth(b));
                let joined = match junction {
                    Junction::And => quote!(#a & #b),
                    Junction::Or => quote!(#a | #b),
                };
                (joined, Precedence::Whole)
            }
            _ => {
                broken("conditions are made of comparisons");
                (quote!(()), Precedence::Atom)
            }
        }
    }
}

/// `f64`, even if the user redefines the name.
pub(crate) fn f64_type() -> TokenStream {
    quote!(__wzvi::f64)
}

/// A literal as it is written: `0.5`, `1e300`.
fn constant(value: f64) -> (TokenStream, Precedence) {
    let f64 = f64_type();
    if !value.is_finite() {
        let bits = Literal::u64_unsuffixed(value.to_bits());
        return (quote!(#f64::from_bits(#bits)), Precedence::Atom);
    }
    let magnitude = value.abs();
    let literal =
        format!("{magnitude:?}").parse::<Literal>().unwrap_or_else(|_| Literal::f64_suffixed(magnitude));
    if value.is_sign_negative() {
        (quote!(-#literal), Precedence::Prefix)
    } else {
        (quote!(#literal), Precedence::Atom)
    }
}

/// Factors that have a name.
fn fraction(value: f64) -> Option<&'static str> {
    let names = [(0.25, "quarter"), (0.5, "half"), (1.5, "three_halves"), (2.0, "twice"), (3.0, "three")];
    names.iter().find(|(known, _)| *known == value).map(|(_, name)| *name)
}

fn squared(name: String) -> String {
    match name.strip_suffix("_squared") {
        Some(root) => format!("{root}_fourth"),
        None => format!("{name}_squared"),
    }
}
