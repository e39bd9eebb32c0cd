//! Literals, operators, casts, comparisons, indices.

use quote::{ToTokens, quote};
use syn::{BinOp, Expr as Syntax, ExprBinary, ExprCast, ExprUnary, Lit, Type, UnOp};

use super::interpreter::Interpreter;
use super::names::is_real_type;
use super::value::{Place, Value};
use crate::diagnostics::expressions;
use crate::input::{Kind, is_integer_type, peeled};
use crate::model::index::Index;
use crate::symbolic::{Expr, Rational, Relation};

/// The value of a chain of operators so far. Sums and products are collected before the graph sees them, so that a
/// sum of n terms costs n and not n².
enum Chain {
    Value(Value),
    Sum(Vec<(Expr, Rational)>),
    Product(Vec<Expr>),
}

impl<'a> Interpreter<'a, '_> {
    pub(super) fn literal(&mut self, literal: &Lit) -> Value {
        match literal {
            Lit::Float(float) => self.real_literal(float.base10_digits(), float.suffix(), literal),
            Lit::Int(int) if matches!(int.suffix(), "f64" | "f32") => {
                self.real_literal(int.base10_digits(), int.suffix(), literal)
            }
            Lit::Int(int) => match int.base10_parse::<i128>() {
                Ok(value) => Value::integer(value),
                Err(_) => self.report(expressions::integer_arithmetic(literal)),
            },
            Lit::Bool(value) => Value::Known(value.value),
            _ => self.report(expressions::expected(literal, "a number", "another literal")),
        }
    }

    fn real_literal(&mut self, digits: &str, suffix: &str, at: &Lit) -> Value {
        if suffix == "f32" {
            return self.report(expressions::single_precision(at));
        }
        match (Rational::from_decimal(digits), digits.parse::<f64>()) {
            (Some(exact), _) => Value::Real(self.graph.number(exact)),
            (None, Ok(value)) => Value::Real(self.graph.float(value)),
            (None, Err(_)) => self.report(expressions::expected(at, "a number", "another literal")),
        }
    }

    pub(super) fn unary(&mut self, syntax: &'a ExprUnary) -> Value {
        let value = self.evaluate(&syntax.expr);
        match (syntax.op, value) {
            (_, Value::Poison) => Value::Poison,
            (UnOp::Deref(_), value) => value,
            (UnOp::Not(_), Value::Known(value)) => Value::Known(!value),
            (UnOp::Not(_), Value::Condition(value)) => Value::Condition(self.graph.not(value)),
            (UnOp::Neg(_), value) if value.is_integer() => {
                let minus = BinOp::Sub(Default::default());
                self.integer_operation(&Value::integer(0), &minus, &value, syntax)
            }
            (UnOp::Neg(_), value) => match self.real(value, &syntax.expr) {
                Some(value) => Value::Real(self.graph.negate(value)),
                None => Value::Poison,
            },
            (_, value) => self.report(expressions::expected(&syntax.expr, "a condition", value.describe())),
        }
    }

    /// A binary operator. Long chains lean left: they are walked, not recursed into.
    pub(super) fn binary(&mut self, syntax: &'a ExprBinary) -> Value {
        if is_logical(&syntax.op) {
            return self.logical(syntax);
        }
        if let Some(operator) = compound(&syntax.op) {
            return self.assign_compound(syntax, operator);
        }
        if matches!(syntax.op, BinOp::BitXor(_)) {
            let (base, exponent) = (last_operand(&syntax.left), first_operand(&syntax.right));
            self.report(expressions::power(base, exponent));
            // The left side may have others.
            let _ = matches!(&*syntax.left, Syntax::Binary(_)).then(|| self.evaluate(&syntax.left));
            return Value::Poison;
        }
        if !is_arithmetic(&syntax.op) {
            return self.comparison(syntax);
        }
        let mut spine = vec![syntax];
        let mut first = &*syntax.left;
        while let Syntax::Binary(inner) = first
            && is_arithmetic(&inner.op)
        {
            spine.push(inner);
            first = &inner.left;
        }
        let mut chain = Chain::Value(self.evaluate(first));
        for &link in spine.iter().rev() {
            let right = match power_of(link) {
                Some(exponent) => self.report(expressions::power(last_operand(&link.left), exponent)),
                None => self.evaluate(&link.right),
            };
            chain = self.extend(chain, &link.op, right, link);
        }
        self.close(chain)
    }

    /// `chain operator right`, where `link` was written.
    fn extend(&mut self, chain: Chain, operator: &BinOp, right: Value, link: &'a ExprBinary) -> Chain {
        match (chain, right) {
            (Chain::Value(Value::Poison), right) => {
                // An integer may be right; anything else that is no number is wrong by itself.
                if !right.is_integer() {
                    self.real(right, &link.right);
                }
                Chain::Value(Value::Poison)
            }
            (_, Value::Poison) => Chain::Value(Value::Poison),
            (Chain::Value(left), right) if self.are_integers(&left, &right) => {
                Chain::Value(self.integer_operation(&left, operator, &right, link))
            }
            (chain, right) => {
                self.extend_real(chain, operator, right, link).unwrap_or(Chain::Value(Value::Poison))
            }
        }
    }

    fn extend_real(
        &mut self,
        chain: Chain,
        operator: &BinOp,
        right: Value,
        link: &'a ExprBinary,
    ) -> Option<Chain> {
        // Both sides are read first: each may be wrong on its own.
        let chain = match chain {
            Chain::Value(left) => self.real(left, &link.left).map(|left| Chain::Value(Value::Real(left))),
            chain => Some(chain),
        };
        let right = self.real(right, &link.right);
        let (chain, right) = (chain?, right?);
        let sign = match operator {
            BinOp::Add(_) => Rational::ONE,
            BinOp::Sub(_) => Rational::MINUS_ONE,
            BinOp::Mul(_) => return Some(Chain::Product(self.factors(chain, right)?)),
            BinOp::Div(_) if self.graph.is_zero(right) => {
                return self.refuse(expressions::division_by_zero(&link.right));
            }
            BinOp::Div(_) => {
                let inverse = self.graph.power(right, Rational::MINUS_ONE);
                return Some(Chain::Product(self.factors(chain, inverse)?));
            }
            _ => {
                let remedy = "only `+ - * /` are differentiable";
                return self.refuse(expressions::unsupported(link, "`%` on real numbers", remedy));
            }
        };
        let mut terms = match chain {
            Chain::Sum(terms) => terms,
            chain => match self.close(chain) {
                Value::Real(left) => vec![(left, Rational::ONE)],
                _ => return None,
            },
        };
        terms.push((right, sign));
        Some(Chain::Sum(terms))
    }

    fn factors(&mut self, chain: Chain, right: Expr) -> Option<Vec<Expr>> {
        let mut factors = match chain {
            Chain::Product(factors) => factors,
            chain => match self.close(chain) {
                Value::Real(left) => vec![left],
                _ => return None,
            },
        };
        factors.push(right);
        Some(factors)
    }

    fn close(&mut self, chain: Chain) -> Value {
        match chain {
            Chain::Value(value) => value,
            Chain::Sum(terms) => Value::Real(self.graph.linear_combination(&terms)),
            Chain::Product(factors) => Value::Real(self.graph.product(&factors)),
        }
    }

    /// `left operator right` for one compound assignment.
    pub(super) fn operate(
        &mut self,
        left: Value,
        operator: BinOp,
        right: Value,
        at: &'a ExprBinary,
    ) -> Value {
        // Accumulating n terms one by one copies n² of them.
        let size = match &left {
            Value::Real(left) => self.graph.node(*left).operands().len(),
            _ => 0,
        };
        if left.is_poison() || !self.spend(size / 16, at) {
            return Value::Poison;
        }
        let chain = self.extend(Chain::Value(left), &operator, right, at);
        self.close(chain)
    }

    /// Whether both are integers: a constant beside an integer is one.
    fn are_integers(&self, left: &Value, right: &Value) -> bool {
        let may_be = |value: &Value| value.is_integer() || matches!(value, Value::Constant(_));
        may_be(left) && may_be(right) && (left.is_integer() || right.is_integer())
    }

    fn comparison(&mut self, syntax: &'a ExprBinary) -> Value {
        let left = self.evaluate(&syntax.left);
        let right = self.evaluate(&syntax.right);
        match (&left, &right) {
            (Value::Poison, _) | (_, Value::Poison) => return Value::Poison,
            (&Value::Known(a), &Value::Known(b)) => {
                let [a, b] = [a, b].map(|holds| Index::integer(holds.into()));
                return self.integer_comparison(&a, &b, syntax);
            }
            _ if self.are_integers(&left, &right) => {
                let (left, right) =
                    (self.as_index(&left, &syntax.left), self.as_index(&right, &syntax.right));
                return match (left, right) {
                    (Some(left), Some(right)) => self.integer_comparison(&left, &right, syntax),
                    _ => Value::Poison,
                };
            }
            _ => {}
        }
        let (left, right) = (self.real(left, &syntax.left), self.real(right, &syntax.right));
        let (Some(left), Some(right)) = (left, right) else { return Value::Poison };
        self.compare(left, right, syntax)
    }

    fn integer_comparison(&mut self, left: &Index, right: &Index, syntax: &ExprBinary) -> Value {
        match self.compare_indices(&syntax.op, left, right) {
            Some(value) => value,
            None => self.unsupported_operator(syntax),
        }
    }

    fn compare(&mut self, left: Expr, right: Expr, syntax: &ExprBinary) -> Value {
        let (relation, left, right) = match syntax.op {
            BinOp::Lt(_) => (Relation::Less, left, right),
            BinOp::Le(_) => (Relation::LessEqual, left, right),
            BinOp::Gt(_) => (Relation::Less, right, left),
            BinOp::Ge(_) => (Relation::LessEqual, right, left),
            BinOp::Eq(_) | BinOp::Ne(_) => (Relation::Equal, left, right),
            _ => return self.unsupported_operator(syntax),
        };
        let negated = matches!(syntax.op, BinOp::Ne(_));
        if let (Some(a), Some(b)) = (self.graph.as_number(left), self.graph.as_number(right)) {
            let holds = match relation {
                Relation::Less => a < b,
                Relation::LessEqual => a <= b,
                Relation::Equal => a == b,
            };
            return Value::Known(holds != negated);
        }
        let condition = self.graph.compare(relation, left, right);
        Value::Condition(if negated { self.graph.not(condition) } else { condition })
    }

    fn unsupported_operator(&mut self, syntax: &ExprBinary) -> Value {
        let remedy = "there are `+ - * / %`, comparisons, `&&`, `||` and `!`";
        self.report(expressions::unsupported(syntax.op, "this operator", remedy))
    }

    fn logical(&mut self, syntax: &'a ExprBinary) -> Value {
        let and = matches!(syntax.op, BinOp::And(_));
        let left = self.evaluate(&syntax.left);
        // As in Rust, the right side is not looked at when the left decides.
        if let Value::Known(known) = left
            && known != and
        {
            return Value::Known(known);
        }
        let right = self.evaluate(&syntax.right);
        self.combine(and, (left, &*syntax.left), (right, &*syntax.right))
    }

    /// `left && right`, or `left || right`.
    pub(super) fn combine(
        &mut self,
        and: bool,
        (left, at_left): (Value, &dyn ToTokens),
        (right, at_right): (Value, &dyn ToTokens),
    ) -> Value {
        match (left, right) {
            (Value::Poison, _) | (_, Value::Poison) => Value::Poison,
            (Value::Known(known), _) if known != and => Value::Known(known),
            (Value::Known(_), right @ (Value::Known(_) | Value::Condition(_))) => right,
            (Value::Condition(_), Value::Known(known)) if known != and => Value::Known(known),
            (Value::Condition(left), Value::Known(_)) => Value::Condition(left),
            (Value::Condition(left), Value::Condition(right)) => Value::Condition(match and {
                true => self.graph.and(left, right),
                false => self.graph.or(left, right),
            }),
            (Value::Known(_) | Value::Condition(_), other) => {
                self.report(expressions::expected(at_right, "a condition", other.describe()))
            }
            (other, _) => self.report(expressions::expected(at_left, "a condition", other.describe())),
        }
    }

    pub(super) fn cast(&mut self, syntax: &'a ExprCast) -> Value {
        let value = self.evaluate(&syntax.expr);
        if value.is_poison() {
            return Value::Poison;
        }
        if is_real_type(&syntax.ty) {
            return self.cast_to_real(value, &syntax.expr);
        }
        let name = match &*syntax.ty {
            Type::Path(path) => {
                path.path.segments.last().map(|last| last.ident.to_string()).unwrap_or_default()
            }
            _ => String::new(),
        };
        match value {
            _ if name == "f32" => self.report(expressions::single_precision(&syntax.ty)),
            _ if !is_integer_type(&name) => self.report(expressions::unknown_cast(&syntax.ty)),
            Value::Index(index) => match index.as_integer() {
                Some(value) if !fits(value, &name) => self.report(expressions::integer_arithmetic(syntax)),
                _ => Value::Index(index),
            },
            Value::Constant(place) => {
                let (name, tokens, ty) = (place.name.clone(), &place.tokens, &syntax.ty);
                Value::index(self.given(&Place::new(name, quote! { (#tokens as #ty) }, Kind::Integer)))
            }
            Value::Real(_) => self.report(expressions::truncation(syntax)),
            other => self.report(expressions::expected(&syntax.expr, "a number", other.describe())),
        }
    }

    /// `value as f64`
    pub(super) fn cast_to_real(&mut self, value: Value, at: &Syntax) -> Value {
        match value {
            Value::Index(index) => Value::Real(self.index_as_real(&index)),
            Value::Constant(place) => Value::Real(self.parameter(&place.name, place.as_real())),
            value => self.real(value, at).map_or(Value::Poison, Value::Real),
        }
    }
}

fn is_arithmetic(operator: &BinOp) -> bool {
    matches!(operator, BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_) | BinOp::Rem(_))
}

fn is_logical(operator: &BinOp) -> bool {
    matches!(operator, BinOp::And(_) | BinOp::Or(_))
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

/// The operand before an operator, whatever binds tighter than it in other languages.
fn last_operand(syntax: &Syntax) -> &Syntax {
    match syntax {
        Syntax::Binary(binary) => last_operand(&binary.right),
        Syntax::Unary(unary) => last_operand(&unary.expr),
        other => other,
    }
}

/// The operand after one.
fn first_operand(syntax: &Syntax) -> &Syntax {
    match syntax {
        Syntax::Binary(binary) => first_operand(&binary.left),
        other => other,
    }
}

/// The operator of a compound assignment.
fn compound(operator: &BinOp) -> Option<BinOp> {
    Some(match operator {
        BinOp::AddAssign(_) => BinOp::Add(Default::default()),
        BinOp::SubAssign(_) => BinOp::Sub(Default::default()),
        BinOp::MulAssign(_) => BinOp::Mul(Default::default()),
        BinOp::DivAssign(_) => BinOp::Div(Default::default()),
        BinOp::RemAssign(_) => BinOp::Rem(Default::default()),
        _ => return None,
    })
}

/// Whether an integer type holds `value`.
fn fits(value: i128, ty: &str) -> bool {
    let unsigned = ty.starts_with('u');
    let bits = match ty.trim_start_matches(['i', 'u']) {
        "8" => 8,
        "16" => 16,
        "32" => 32,
        "128" => return !unsigned || value >= 0,
        _ => 64,
    };
    let (low, high) = match unsigned {
        true => (0, (1i128 << bits) - 1),
        false => (-(1i128 << (bits - 1)), (1i128 << (bits - 1)) - 1),
    };
    (low..=high).contains(&value)
}
