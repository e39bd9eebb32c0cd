//! Integers: exact arithmetic on known values, loop variables, sizes and integers of the struct. Tests:
//! `lower/tests/values.rs`, `lower/tests/robustness.rs`.

use quote::ToTokens;
use syn::{BinOp, ExprMethodCall};

use super::floats::is_real_method;
use super::interpreter::Interpreter;
use super::methods::{Methods, are_known};
use super::value::Value;
use crate::diagnostics::expressions;
use crate::model::{Bounds, Index, Loop, Outlier};
use crate::symbolic::Relation;

const METHODS: &Methods = &[(0, "abs clone"), (1, "pow abs_diff rem_euclid div_euclid min max")];

impl<'a> Interpreter<'a, '_> {
    /// `value` as an integer. A constant beside an integer is an integer, too.
    pub(super) fn as_index(&mut self, value: &Value, at: &dyn ToTokens) -> Option<Index> {
        match value {
            Value::Index(index, _) => Some((**index).clone()),
            Value::Constant(place) => Some(self.given(place)),
            Value::Poison => None,
            other => self.mismatch(at, "an integer", other),
        }
    }

    /// `value` as an integer whose value matters: a negative integer of an unsigned type has overflowed.
    pub(super) fn checked_index(&mut self, value: &Value, at: &dyn ToTokens) -> Option<Index> {
        let index = self.as_index(value, at)?;
        let may_be_negative = index.constant < 0 || index.terms.iter().any(|(_, multiple)| *multiple < 0);
        if may_be_negative && matches!(value, Value::Index(_, true)) {
            self.require_natural(&index, at)?;
        }
        Some(index)
    }

    /// Has an index that may be negative checked when a stepper is made, unless a condition guards it.
    pub(super) fn require_natural(&mut self, index: &Index, at: &dyn ToTokens) -> Option<()> {
        let loops = self.bounded(|bounds| bounds.loops.to_vec());
        // The state is not empty.
        let state = Loop { variable: u32::MAX, start: Index::default(), end: self.space.size.clone() };
        let known = [&[state], loops.as_slice()].concat();
        let bounds = Bounds { loops: &known, tables: self.tables.as_list() };
        if self.now.branch > 0 || bounds.is_nonnegative(index) {
            return Some(());
        }
        if let Some(Outlier::Negative(value)) = bounds.outlier(index, None) {
            return self.refuse(expressions::natural_negative(at, &self.display(index), value));
        }
        let natural = (loops, index.clone());
        self.naturals.place(natural.clone(), || natural);
        Some(())
    }

    /// `value` as a known integer: for an exponent, a number of items, a position in a heterogeneous list. If
    /// it contains a loop variable, the loop is evaluated iteration by iteration.
    pub(super) fn known_integer(&mut self, value: Value, at: &dyn ToTokens) -> Option<i128> {
        match &value {
            Value::Poison => None,
            Value::Index(index, _) => match index.as_integer() {
                Some(known) => Some(known),
                None if index.is_closed() && self.request_unrolling_of(index) => None,
                None => self.refuse(expressions::index_not_known(at)),
            },
            Value::Constant(_) => self.refuse(expressions::index_not_known(at)),
            value => self.mismatch(at, "an integer", value),
        }
    }

    /// `a op b`
    pub(super) fn integer_operation(
        &mut self,
        a: &Value,
        operator: &BinOp,
        b: &Value,
        at: &dyn ToTokens,
    ) -> Option<Value> {
        let is_unsigned = [a, b].iter().any(|value| matches!(value, Value::Index(_, true)));
        let is_linear = matches!(operator, BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_));
        let read = if is_linear { Self::as_index } else { Self::checked_index };
        let (a, b) = (read(self, a, at)?, read(self, b, at)?);
        let result = match operator {
            BinOp::Add(_) => a.add(&b),
            BinOp::Sub(_) => a.subtract(&b),
            BinOp::Mul(_) => a.multiply(&b),
            BinOp::Div(_) => a.divide(&b),
            // A value known to be below the modulus does not wrap.
            _ if a.as_integer().is_none() && self.bounded(|bounds| bounds.is_below(&a, &b)) => Some(a),
            _ => a.remainder(&b),
        };
        self.integer(result, at).map(|value| value.unsigned(is_unsigned))
    }

    /// The result of integer arithmetic, if it did not overflow.
    pub(super) fn integer(&mut self, result: Option<Index>, at: &dyn ToTokens) -> Option<Value> {
        match result {
            Some(index) => Some(Value::index(index)),
            None => self.refuse(expressions::integer_arithmetic(at)),
        }
    }

    /// `difference relation 0`
    pub(super) fn relates_to_zero(&mut self, relation: Relation, difference: &Index) -> Value {
        match relation {
            Relation::Less => self.is_less(difference, false),
            Relation::LessEqual => self.is_less(difference, true),
            Relation::Equal => match self.is_less(difference, false) {
                Value::Known(true) => Value::Known(false),
                Value::Known(false) => self.is_less(difference, true),
                _ => Value::Condition(self.compare_with_zero(relation, difference)),
            },
        }
    }

    pub(super) fn integer_method(
        &mut self,
        own: &Index,
        arguments: &[Value],
        syntax: &ExprMethodCall,
    ) -> Option<Value> {
        if !are_known(METHODS, &syntax.method) && is_real_method(&syntax.method.to_string()) {
            return self.refuse(expressions::integer_receiver(&syntax.receiver));
        }
        let result = match (self.known_method(METHODS, "integers", syntax)?, arguments.first()) {
            ("abs", _) => Index::default().subtract(own).map(|negated| own.maximum(&negated)),
            ("pow", Some(exponent)) => power(own, self.known_integer(exponent.clone(), &syntax.args)?),
            (name, Some(argument)) => {
                let other = self.as_index(argument, &syntax.args)?;
                self.binary_method(name, own, &other)
            }
            (_, None) => Some(own.clone()),
        };
        self.integer(result, syntax)
    }

    fn binary_method(&mut self, name: &str, own: &Index, other: &Index) -> Option<Index> {
        match name {
            "min" => Some(own.minimum(other)),
            "max" => Some(own.maximum(other)),
            "abs_diff" => Some(own.subtract(other)?.maximum(&other.subtract(own)?)),
            "rem_euclid" if self.is_nonnegative(own) => own.remainder(other),
            "rem_euclid" => {
                // Stencils reach back over one end: `a mod n` for `a` down to `-n`.
                let shifted = own.add(other)?;
                if self.is_nonnegative(&shifted) && self.is_nonnegative(other) {
                    return shifted.remainder(other);
                }
                let size = other.maximum(&Index::integer(0).subtract(other)?);
                own.remainder(&size)?.add(&size)?.remainder(&size)
            }
            // For nonnegative values, rounding towards zero is rounding down.
            _ if self.is_nonnegative(own) => own.divide(other),
            _ => own.subtract(&self.binary_method("rem_euclid", own, other)?)?.divide(other),
        }
    }
}

/// Whether the receiver of a method with these arguments is an integer, if it is a constant.
pub(super) fn may_be_integer(syntax: &ExprMethodCall, arguments: &[Value]) -> bool {
    let is_real = is_real_method(&syntax.method.to_string()) && !arguments.iter().any(Value::is_integer);
    are_known(METHODS, &syntax.method) && !is_real
}

fn power(base: &Index, exponent: i128) -> Option<Index> {
    let exponent = u32::try_from(exponent).ok()?;
    match base.as_integer() {
        Some(base) => base.checked_pow(exponent).map(Index::integer),
        // Every factor is written out; a higher power overflows anyway.
        None if exponent > 64 => None,
        None => (0..exponent).try_fold(Index::integer(1), |power, _| power.multiply(base)),
    }
}
