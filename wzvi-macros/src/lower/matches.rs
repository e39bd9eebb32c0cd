//! `match` on integers and conditions: a chain of `if`, whose last arm stands for all that is left, as `rustc` checks.

use quote::ToTokens;
use syn::{BinOp, Expr as Syntax, ExprMatch, Pat, RangeLimits};

use super::interpreter::{Interpreter, result_of};
use super::value::Value;
use crate::diagnostics::expressions;
use crate::symbolic::Expr;

/// An arm that is taken under a condition; the condition of the last one is not asked for.
struct Choice<'a> {
    condition: Option<Expr>,
    value: Value,
    body: &'a Syntax,
}

impl<'a> Interpreter<'a, '_> {
    pub(super) fn match_arms(&mut self, syntax: &'a ExprMatch) -> Value {
        let scrutinee = self.evaluate(&syntax.expr);
        if !matches!(
            scrutinee,
            Value::Index(_) | Value::Constant(_) | Value::Known(_) | Value::Condition(_) | Value::Poison
        ) {
            return self.report(expressions::match_on(&syntax.expr, scrutinee.describe()));
        }
        let outer = self.branch;
        let value = self.choose_arm(&scrutinee, syntax);
        self.branch = outer;
        value
    }

    /// The value of the arm that is known to be taken, or a choice between those that may be.
    fn choose_arm(&mut self, scrutinee: &Value, syntax: &'a ExprMatch) -> Value {
        let mut choices: Vec<Choice<'a>> = Vec::new();
        for arm in &syntax.arms {
            let condition = match self.pattern_condition(scrutinee, &arm.pat) {
                Value::Known(false) => continue,
                Value::Known(true) => None,
                Value::Condition(condition) => Some(condition),
                // The arms may have mistakes of their own.
                _ => {
                    let outer = self.scope.len();
                    self.branch += 1;
                    self.poison(&arm.pat);
                    self.evaluate(&arm.body);
                    self.branch -= 1;
                    self.scope.leave(outer);
                    choices.push(Choice { condition: None, value: Value::Poison, body: &arm.body });
                    continue;
                }
            };
            if choices.is_empty() && condition.is_some() {
                self.branch += 1;
            }
            let value = self.evaluate(&arm.body);
            choices.push(Choice { condition, value, body: &arm.body });
            if condition.is_none() {
                break;
            }
        }
        let Some(last) = choices.pop() else {
            // `rustc` says which values no arm takes.
            return Value::Poison;
        };
        choices.into_iter().rev().fold(last.value, |otherwise, choice| {
            let Some(condition) = choice.condition else { return Value::Poison };
            match self.select(condition, &choice.value, &otherwise) {
                Some(value) => value,
                None => self.report(expressions::branches_differ(result_of(choice.body))),
            }
        })
    }

    /// Whether `scrutinee` is what a pattern stands for.
    fn pattern_condition(&mut self, scrutinee: &Value, pattern: &'a Pat) -> Value {
        match pattern {
            Pat::Wild(_) => Value::Known(true),
            Pat::Guard(guarded) => match self.pattern_condition(scrutinee, &guarded.pat) {
                Value::Known(false) => Value::Known(false),
                fits => {
                    let holds = self.evaluate(&guarded.guard);
                    self.combine(true, (fits, &guarded.pat), (holds, &guarded.guard))
                }
            },
            Pat::Paren(inner) => self.pattern_condition(scrutinee, &inner.pat),
            Pat::Lit(literal) => {
                let value = self.literal(&literal.lit);
                self.relates(scrutinee, BinOp::Eq(Default::default()), value, pattern)
            }
            Pat::Path(path) => {
                let value = self.path(path);
                self.relates(scrutinee, BinOp::Eq(Default::default()), value, pattern)
            }
            Pat::Or(alternatives) => {
                let mut any = Value::Known(false);
                for alternative in &alternatives.cases {
                    let fits = self.pattern_condition(scrutinee, alternative);
                    any = self.combine(false, (any, pattern), (fits, alternative));
                }
                any
            }
            Pat::Range(range) => {
                let mut within = Value::Known(true);
                if let Some(start) = &range.start {
                    let start = self.evaluate(start);
                    within = self.relates(scrutinee, BinOp::Ge(Default::default()), start, pattern);
                }
                if let Some(end) = &range.end {
                    let end = self.evaluate(end);
                    let operator = match range.limits {
                        RangeLimits::HalfOpen(_) => BinOp::Lt(Default::default()),
                        RangeLimits::Closed(_) => BinOp::Le(Default::default()),
                    };
                    let below = self.relates(scrutinee, operator, end, pattern);
                    within = self.combine(true, (within, pattern), (below, pattern));
                }
                within
            }
            _ => self.report(expressions::match_pattern(pattern)),
        }
    }

    /// `scrutinee operator value` for the value of a pattern.
    fn relates(&mut self, scrutinee: &Value, operator: BinOp, value: Value, pattern: &dyn ToTokens) -> Value {
        match (scrutinee, &value) {
            (Value::Poison, _) | (_, Value::Poison) => Value::Poison,
            (Value::Known(known), Value::Known(wanted)) => Value::Known(known == wanted),
            (Value::Condition(_), Value::Known(true)) => scrutinee.clone(),
            (Value::Condition(condition), Value::Known(false)) => {
                Value::Condition(self.graph.not(*condition))
            }
            (Value::Index(_) | Value::Constant(_), Value::Index(_) | Value::Constant(_)) => {
                let (own, wanted) = (self.as_index(scrutinee, pattern), self.as_index(&value, pattern));
                let (Some(own), Some(wanted)) = (own, wanted) else { return Value::Poison };
                match self.compare_indices(&operator, &own, &wanted) {
                    Some(value) => value,
                    None => self.report(expressions::integer_arithmetic(pattern)),
                }
            }
            _ => {
                let pattern = pattern.to_token_stream();
                self.report(expressions::pattern_mismatch(pattern, scrutinee.describe()))
            }
        }
    }
}
