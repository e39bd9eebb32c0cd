//! Literals, operators, casts, comparisons. Tests: `lower/tests/values.rs`, `tests/steps/values.rs`.

use quote::{ToTokens, quote};
use syn::{BinOp, Expr as Syntax, ExprBinary, ExprCast, ExprUnary, Lit, UnOp};

use super::interpreter::Interpreter;
use super::names::{is_real_type, key};
use super::value::{Place, Value};
use crate::diagnostics::expressions;
use crate::input::{FieldKind, is_integer_type, peeled};
use crate::model::Index;
use crate::symbolic::{Expr, Junction, Rational, Relation};

const OPERATORS: &str = "there are `+ - * / %`, comparisons, `&&`, `||` and `!`";

/// The value of a chain of operators so far. Sums and products are collected before the graph sees them, so
/// that a sum of n terms costs n and not n².
enum Chain {
    Value(Value),
    Sum(Vec<(Expr, Rational)>),
    Product(Vec<Expr>),
}

/// An operand of a comparison or a connective, with its place for messages.
pub(super) struct Operand<'t> {
    pub(super) value: Value,
    pub(super) at: &'t dyn ToTokens,
}

impl<'t> Operand<'t> {
    pub(super) fn new(value: Value, at: &'t dyn ToTokens) -> Self {
        Self { value, at }
    }
}

impl<'a> Interpreter<'a, '_> {
    pub(super) fn literal(&mut self, literal: &Lit) -> Option<Value> {
        match literal {
            Lit::Float(float) => self.real_literal(float.base10_digits(), float.suffix(), literal),
            Lit::Int(int) if matches!(int.suffix(), "f64" | "f32") => {
                self.real_literal(int.base10_digits(), int.suffix(), literal)
            }
            Lit::Int(int) => self.integer(int.base10_parse().ok().map(Index::integer), literal),
            Lit::Bool(value) => Some(Value::Known(value.value)),
            _ => self.refuse(expressions::expected(literal, "a number", "another literal")),
        }
    }

    fn real_literal(&mut self, digits: &str, suffix: &str, at: &Lit) -> Option<Value> {
        if suffix == "f32" {
            return self.refuse(expressions::single_precision(at));
        }
        Some(Value::Real(match (Rational::from_decimal(digits), digits.parse::<f64>()) {
            (Some(exact), _) => self.graph.number(exact),
            (None, Ok(value)) => self.graph.float(value),
            (None, Err(_)) => return self.refuse(expressions::expected(at, "a number", "another literal")),
        }))
    }

    pub(super) fn unary(&mut self, syntax: &'a ExprUnary) -> Option<Value> {
        let value = self.evaluate(&syntax.expr).known()?;
        match syntax.op {
            UnOp::Deref(_) => Some(value),
            UnOp::Neg(_) if value.is_integer() => {
                let minus = BinOp::Sub(Default::default());
                self.integer_operation(&Value::integer(0), &minus, &value, syntax)
            }
            UnOp::Neg(_) => Value::operation(None, &BinOp::Sub(Default::default()), &value).or_else(|| {
                let value = self.real(value, &syntax.expr)?;
                Some(Value::Real(self.graph.negate(value)))
            }),
            _ => self.denied(&value).or_else(|| self.mismatch(&syntax.expr, "a condition", &value)),
        }
    }

    /// The negation of a condition; `None` for other values.
    pub(super) fn denied(&mut self, condition: &Value) -> Option<Value> {
        match *condition {
            Value::Known(holds) => Some(Value::Known(!holds)),
            Value::Condition(holds) => Some(Value::Condition(self.graph.not(holds))),
            _ => None,
        }
    }

    /// A binary operator. Long chains are left-associative: they are traversed without recursion.
    pub(super) fn binary(&mut self, syntax: &'a ExprBinary) -> Option<Value> {
        if matches!(syntax.op, BinOp::And(_) | BinOp::Or(_)) {
            return self.logical(syntax);
        }
        if let Some(operator) = compound(&syntax.op) {
            return Some(self.assign_compound(syntax, operator));
        }
        if matches!(syntax.op, BinOp::BitXor(_)) {
            return self.exclusive_or(syntax);
        }
        if let BinOp::BitAnd(_) | BinOp::BitOr(_) = syntax.op {
            return self.conditions(syntax);
        }
        if !is_arithmetic(&syntax.op) {
            let (left, right) = (self.evaluate(&syntax.left), self.evaluate(&syntax.right));
            let (left, right) = (left.known()?, right.known()?);
            let (left, right) = (Operand::new(left, &syntax.left), Operand::new(right, &syntax.right));
            return self.compared(&syntax.op, left, right, syntax);
        }
        let mut spine = vec![syntax];
        let mut first = &*syntax.left;
        while let Syntax::Binary(inner) = first
            && is_arithmetic(&inner.op)
        {
            spine.push(inner);
            first = &inner.left;
        }
        let mut chain = self.evaluate(first).known().map(Chain::Value);
        for &link in spine.iter().rev() {
            let right = match power_of(link) {
                Some(exponent) => {
                    let base = last_operand(&link.left);
                    self.refuse(expressions::power(quote!(#base #exponent), base, exponent, false))
                }
                None => self.evaluate(&link.right).known(),
            };
            chain = self.extend(chain, &link.op, right, link);
        }
        chain.map(|chain| self.close(chain))
    }

    /// `chain operator right`, where `link` was written.
    fn extend(
        &mut self,
        chain: Option<Chain>,
        operator: &BinOp,
        right: Option<Value>,
        link: &'a ExprBinary,
    ) -> Option<Chain> {
        let Some(chain) = chain else {
            // An integer may be valid; any other non-number is a mistake by itself.
            right.filter(|right| !right.is_integer()).and_then(|right| self.real(right, &link.right));
            return None;
        };
        let right = right?;
        // Both sides are read first, to report mistakes in each.
        let chain = match chain {
            Chain::Value(left) if self.are_integers(&left, &right) => {
                return self.integer_operation(&left, operator, &right, link).map(Chain::Value);
            }
            Chain::Value(left) => match Value::operation(Some(&left), operator, &right) {
                Some(constant) => return Some(Chain::Value(constant)),
                None => self.real(left, &link.left).map(|left| Chain::Value(Value::Real(left))),
            },
            chain => Some(chain),
        };
        let is_integer = right.is_integer();
        let right = self.real(right, &link.right);
        let Some(right) = right else {
            // The chain is one of real numbers, and its other integers are mistakes, too.
            return chain.filter(|_| is_integer);
        };
        let chain = chain?;
        let factor = match operator {
            BinOp::Add(_) => return self.add_term(chain, right, Rational::ONE),
            BinOp::Sub(_) => return self.add_term(chain, right, Rational::MINUS_ONE),
            BinOp::Mul(_) => right,
            BinOp::Div(_) if self.graph.is_zero(right) => {
                return self.refuse(expressions::division_by_zero(&link.right));
            }
            BinOp::Div(_) => self.graph.power(right, Rational::MINUS_ONE),
            _ => {
                let remedy = "only `+ - * /` are differentiable";
                return self.refuse(expressions::unsupported(link, "`%` on real numbers", remedy));
            }
        };
        let mut factors = match chain {
            Chain::Product(factors) => factors,
            chain => vec![self.close(chain).as_real()?],
        };
        factors.push(factor);
        Some(Chain::Product(factors))
    }

    fn add_term(&mut self, chain: Chain, term: Expr, coefficient: Rational) -> Option<Chain> {
        let mut terms = match chain {
            Chain::Sum(terms) => terms,
            chain => vec![(self.close(chain).as_real()?, Rational::ONE)],
        };
        terms.push((term, coefficient));
        Some(Chain::Sum(terms))
    }

    fn close(&mut self, chain: Chain) -> Value {
        match chain {
            Chain::Value(value) => value,
            Chain::Sum(terms) => Value::Real(self.graph.linear_combination(&terms)),
            Chain::Product(factors) => Value::Real(self.graph.product(&factors)),
        }
    }

    /// `target op= value`
    fn assign_compound(&mut self, syntax: &'a ExprBinary, operator: BinOp) -> Value {
        let left = self.evaluate(&syntax.left);
        let right = self.evaluate(&syntax.right);
        let value = match left.known() {
            // Accumulating n terms one by one copies n² of them.
            Some(left) if self.spend_on(&left, syntax) => {
                self.extend(Some(Chain::Value(left)), &operator, right.known(), syntax)
            }
            _ => None,
        };
        let value = value.map(|chain| self.close(chain)).unwrap_or_default();
        self.store(&syntax.left, value);
        Value::unit()
    }

    /// Whether both are integers: a constant beside an integer is one.
    fn are_integers(&self, left: &Value, right: &Value) -> bool {
        let may_be = |value: &Value| value.is_integer() || matches!(value, Value::Constant(_));
        may_be(left) && may_be(right) && (left.is_integer() || right.is_integer())
    }

    /// `left operator right` of numbers, or of conditions that are known.
    pub(super) fn compared(
        &mut self,
        operator: &BinOp,
        left: Operand<'_>,
        right: Operand<'_>,
        at: &dyn ToTokens,
    ) -> Option<Value> {
        let Operand { value: left, at: at_left } = left;
        let Operand { value: right, at: at_right } = right;
        let (relation, is_turned) = match operator {
            BinOp::Lt(_) => (Relation::Less, false),
            BinOp::Le(_) => (Relation::LessEqual, false),
            BinOp::Gt(_) => (Relation::Less, true),
            BinOp::Ge(_) => (Relation::LessEqual, true),
            BinOp::Eq(_) | BinOp::Ne(_) => (Relation::Equal, false),
            _ => {
                return self.refuse(expressions::unsupported(operator, "this operator", OPERATORS));
            }
        };
        if let (&Value::Condition(condition), other) | (other, &Value::Condition(condition)) = (&left, &right)
            && relation == Relation::Equal
            && let Some(opposite) = self.denied(other)
        {
            let is_same = self.select(condition, other, &opposite)?;
            return if matches!(operator, BinOp::Ne(_)) { self.denied(&is_same) } else { Some(is_same) };
        }
        let integers = match (&left, &right) {
            (&Value::Known(a), &Value::Known(b)) => {
                Some([a, b].map(|holds| Some(Index::integer(holds.into()))))
            }
            _ if self.are_integers(&left, &right) => {
                Some([self.checked_index(&left, at_left), self.checked_index(&right, at_right)])
            }
            _ => None,
        };
        let holds = match integers {
            Some([left, right]) => {
                let (left, right) = in_order(is_turned, left?, right?);
                match right.subtract(&left).and(left.subtract(&right)) {
                    Some(difference) => self.relates_to_zero(relation, &difference),
                    None => return self.refuse(expressions::integer_arithmetic(at)),
                }
            }
            None => {
                // Constants are integers or real numbers: a cast reads both.
                let read = match (&left, &right) {
                    (Value::Constant(_), Value::Constant(_)) => Self::cast_to_real,
                    _ => Self::real,
                };
                let (left, right) = (read(self, left, at_left), read(self, right, at_right));
                let (left, right) = in_order(is_turned, left?, right?);
                match (self.graph.as_number(left), self.graph.as_number(right)) {
                    (Some(a), Some(b)) => Value::Known(relation.holds(&a, &b)),
                    _ => Value::Condition(self.graph.compare(relation, left, right)),
                }
            }
        };
        if matches!(operator, BinOp::Ne(_)) { self.denied(&holds) } else { Some(holds) }
    }

    /// `a ^ b` of conditions; of numbers it is no power.
    fn exclusive_or(&mut self, syntax: &'a ExprBinary) -> Option<Value> {
        let left = self.evaluate(&syntax.left);
        if let Value::Known(_) | Value::Condition(_) = left {
            let right = self.evaluate(&syntax.right).known()?;
            if self.denied(&right).is_none() {
                return self.mismatch(&syntax.right, "a condition", &right);
            }
            let differ = BinOp::Ne(Default::default());
            let (left, right) = (Operand::new(left, &syntax.left), Operand::new(right, &syntax.right));
            return self.compared(&differ, left, right, syntax);
        }
        let (base, exponent) = (last_operand(&syntax.left), first_operand(&syntax.right));
        self.refuse(expressions::power(quote!(#base #exponent), base, exponent, left.is_integer()))
    }

    /// `a & b` and `a | b` of conditions.
    fn conditions(&mut self, syntax: &'a ExprBinary) -> Option<Value> {
        let junction = if matches!(syntax.op, BinOp::BitAnd(_)) { Junction::And } else { Junction::Or };
        let (left, right) = (self.evaluate(&syntax.left), self.evaluate(&syntax.right));
        if let (Value::Index(..) | Value::Real(_), _) | (_, Value::Index(..) | Value::Real(_)) =
            (&left, &right)
        {
            return self.refuse(expressions::unsupported(syntax.op, "this operator on numbers", OPERATORS));
        }
        self.combine(junction, Operand::new(left, &syntax.left), Operand::new(right, &syntax.right))
    }

    fn logical(&mut self, syntax: &'a ExprBinary) -> Option<Value> {
        let junction = if matches!(syntax.op, BinOp::And(_)) { Junction::And } else { Junction::Or };
        let left = self.evaluate(&syntax.left);
        // As in Rust, the right side is not evaluated if the left side decides.
        if let Value::Known(known) = left
            && known == (junction == Junction::Or)
        {
            return Some(left);
        }
        self.now.branch += 1;
        let right = self.evaluate(&syntax.right);
        self.now.branch -= 1;
        self.combine(junction, Operand::new(left, &syntax.left), Operand::new(right, &syntax.right))
    }

    /// `left && right`, or `left || right`.
    pub(super) fn combine(
        &mut self,
        junction: Junction,
        left: Operand<'_>,
        right: Operand<'_>,
    ) -> Option<Value> {
        let decisive = junction == Junction::Or;
        match (left.value.known()?, right.value.known()?) {
            (Value::Known(known), _) if known == decisive => Some(Value::Known(known)),
            (Value::Known(_), right @ (Value::Known(_) | Value::Condition(_))) => Some(right),
            (Value::Condition(_), Value::Known(known)) if known == decisive => Some(Value::Known(known)),
            (left @ Value::Condition(_), Value::Known(_)) => Some(left),
            (Value::Condition(left), Value::Condition(right)) => {
                Some(Value::Condition(self.graph.join(junction, left, right)))
            }
            (Value::Known(_) | Value::Condition(_), other) => self.mismatch(right.at, "a condition", &other),
            (other, _) => self.mismatch(left.at, "a condition", &other),
        }
    }

    pub(super) fn cast(&mut self, syntax: &'a ExprCast) -> Option<Value> {
        let value = self.evaluate(&syntax.expr).known()?;
        if is_real_type(&syntax.ty) {
            return self.cast_to_real(value, &syntax.expr).map(Value::Real);
        }
        let written = key(&syntax.ty);
        let name = written.rsplit("::").next().unwrap_or_default();
        let is_unsigned = name.starts_with('u');
        match value {
            _ if name == "f32" => self.refuse(expressions::single_precision(&syntax.ty)),
            _ if !is_integer_type(name) => self.refuse(expressions::unknown_cast(&syntax.ty)),
            Value::Index(index, was_unsigned) => {
                let (least, most) = limits(name);
                if index.as_integer().is_some_and(|value| !(least..=most).contains(&value)) {
                    return self.refuse(expressions::integer_arithmetic(syntax));
                }
                // The type holds every size.
                let is_wide = most > i128::from(u32::MAX);
                if !is_wide || (is_unsigned && !was_unsigned) {
                    self.require_natural(&index.shifted(-least)?, syntax)?;
                }
                if !is_wide {
                    self.require_natural(&Index::integer(most).subtract(&index)?, syntax)?;
                }
                Some(Value::Index(index, is_unsigned))
            }
            Value::Constant(place) => {
                let (name, tokens, ty) = (place.name.clone(), &place.tokens, &syntax.ty);
                let cast = Place::new(name, quote! { (#tokens as #ty) }, FieldKind::Constant);
                Some(Value::index(self.given(&cast)).unsigned(is_unsigned))
            }
            Value::Real(_) => self.refuse(expressions::truncation(syntax)),
            other => self.mismatch(&syntax.expr, "a number", &other),
        }
    }

    /// `value as f64`
    pub(super) fn cast_to_real(&mut self, value: Value, at: &dyn ToTokens) -> Option<Expr> {
        match value {
            Value::Index(..) => self.checked_index(&value, at).map(|index| self.index_as_real(&index)),
            Value::Constant(place) => Some(self.integer_parameter(&place.name, place.as_real())),
            value => self.real(value, at),
        }
    }
}

/// `(a, b)`, or `(b, a)` if `is_turned`.
fn in_order<T>(is_turned: bool, a: T, b: T) -> (T, T) {
    if is_turned { (b, a) } else { (a, b) }
}

fn is_arithmetic(operator: &BinOp) -> bool {
    matches!(operator, BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_) | BinOp::Rem(_))
}

/// The exponent of `p**2`, which is `p * (*2)` in Rust.
fn power_of(link: &ExprBinary) -> Option<&Syntax> {
    match (&link.op, &*link.right) {
        (BinOp::Mul(_), Syntax::Unary(ExprUnary { op: UnOp::Deref(_), expr, .. })) => {
            matches!(peeled(expr), Syntax::Lit(_) | Syntax::Unary(_)).then_some(&**expr)
        }
        _ => None,
    }
}

/// The operand directly before an operator, as if the operator bound most tightly.
fn last_operand(syntax: &Syntax) -> &Syntax {
    match syntax {
        Syntax::Binary(binary) => last_operand(&binary.right),
        Syntax::Unary(unary) => last_operand(&unary.expr),
        other => other,
    }
}

/// The operand directly after an operator.
fn first_operand(syntax: &Syntax) -> &Syntax {
    match syntax {
        Syntax::Binary(binary) => first_operand(&binary.left),
        other => other,
    }
}

/// The operator of a compound assignment.
pub(super) fn compound(operator: &BinOp) -> Option<BinOp> {
    Some(match operator {
        BinOp::AddAssign(_) => BinOp::Add(Default::default()),
        BinOp::SubAssign(_) => BinOp::Sub(Default::default()),
        BinOp::MulAssign(_) => BinOp::Mul(Default::default()),
        BinOp::DivAssign(_) => BinOp::Div(Default::default()),
        BinOp::RemAssign(_) => BinOp::Rem(Default::default()),
        _ => return None,
    })
}

/// The least and the largest number of an integer type.
fn limits(ty: &str) -> (i128, i128) {
    let is_unsigned = ty.starts_with('u');
    // `usize` and `isize` have 64 on some machine.
    let bits: u32 = ty.trim_start_matches(['i', 'u']).parse().unwrap_or(64);
    let of_value = if is_unsigned { bits } else { bits - 1 };
    // An `i128` holds no larger value of `u128`.
    let most = i128::MAX >> 127_u32.saturating_sub(of_value);
    (if is_unsigned { 0 } else { -most - 1 }, most)
}
