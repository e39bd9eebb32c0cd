//! `match` on integers and conditions: a chain of `if`, whose last arm covers the rest, as checked by
//! `rustc`. Tests: `lower/tests/values.rs`.

use quote::ToTokens;
use syn::{BinOp, Expr as Syntax, ExprMatch, Pat, RangeLimits};

use super::interpreter::{Interpreter, result_of};
use super::operators::Operand;
use super::value::Value;
use crate::diagnostics::expressions;
use crate::symbolic::{Expr, Junction};

/// An arm with its condition. The condition of the last arm is not used.
struct MatchArm<'a> {
    condition: Option<Expr>,
    value: Value,
    body: &'a Syntax,
}

impl<'a> Interpreter<'a, '_> {
    pub(super) fn match_arms(&mut self, syntax: &'a ExprMatch) -> Option<Value> {
        let scrutinee = self.evaluate(&syntax.expr);
        if !matches!(
            scrutinee,
            Value::Index(..) | Value::Constant(_) | Value::Known(_) | Value::Condition(_) | Value::Poison
        ) {
            return self.refuse(expressions::match_on(&syntax.expr, scrutinee.describe()));
        }
        let outer = self.now.branch;
        let value = self.choose_arm(&scrutinee, syntax);
        self.now.branch = outer;
        value
    }

    /// The value of the arm known to be taken, or a choice between the possible arms.
    fn choose_arm(&mut self, scrutinee: &Value, syntax: &'a ExprMatch) -> Option<Value> {
        let mut choices: Vec<MatchArm<'a>> = Vec::new();
        for arm in &syntax.arms {
            let condition = match self.pattern_condition(scrutinee, &arm.pat) {
                Some(Value::Known(false)) => continue,
                Some(Value::Known(true)) => None,
                Some(Value::Condition(condition)) => Some(condition),
                // Report mistakes in the arms, too.
                _ => {
                    let outer = self.now.scope.len();
                    self.now.branch += 1;
                    self.poison(&arm.pat);
                    self.evaluate(&arm.body);
                    self.now.branch -= 1;
                    self.now.scope.leave(outer);
                    choices.push(MatchArm { condition: None, value: Value::Poison, body: &arm.body });
                    continue;
                }
            };
            if choices.is_empty() && condition.is_some() {
                self.now.branch += 1;
            }
            let value = self.evaluate(&arm.body);
            choices.push(MatchArm { condition, value, body: &arm.body });
            if condition.is_none() {
                break;
            }
        }
        // Without arms, `rustc` reports the missing values.
        let last = choices.pop()?;
        choices.into_iter().rev().try_fold(last.value, |otherwise, choice| {
            self.select(choice.condition?, &choice.value, &otherwise)
                .or_else(|| self.refuse(expressions::branches_differ(result_of(choice.body))))
        })
    }

    /// Whether `scrutinee` matches a pattern.
    fn pattern_condition(&mut self, scrutinee: &Value, pattern: &'a Pat) -> Option<Value> {
        match pattern {
            Pat::Wild(_) => Some(Value::Known(true)),
            Pat::Guard(guarded) => match self.pattern_condition(scrutinee, &guarded.pat) {
                Some(Value::Known(false)) => Some(Value::Known(false)),
                fits => {
                    let holds = self.evaluate(&guarded.guard);
                    let fits = Operand::new(fits.unwrap_or_default(), &guarded.pat);
                    self.combine(Junction::And, fits, Operand::new(holds, &guarded.guard))
                }
            },
            Pat::Paren(inner) => self.pattern_condition(scrutinee, &inner.pat),
            Pat::Lit(literal) => {
                let value = self.literal(&literal.lit)?;
                self.relates(scrutinee, BinOp::Eq(Default::default()), value, pattern)
            }
            Pat::Path(path) => {
                let value = self.path(path)?;
                self.relates(scrutinee, BinOp::Eq(Default::default()), value, pattern)
            }
            Pat::Or(alternatives) => {
                let mut any = Value::Known(false);
                for alternative in &alternatives.cases {
                    let fits = self.pattern_condition(scrutinee, alternative).unwrap_or_default();
                    let (known, fits) = (Operand::new(any, pattern), Operand::new(fits, alternative));
                    any = self.combine(Junction::Or, known, fits).unwrap_or_default();
                }
                Some(any)
            }
            Pat::Range(range) => {
                let below = match range.limits {
                    RangeLimits::HalfOpen(_) => BinOp::Lt(Default::default()),
                    RangeLimits::Closed(_) => BinOp::Le(Default::default()),
                };
                let bounds = [(&range.start, BinOp::Ge(Default::default())), (&range.end, below)];
                let mut within = Value::Known(true);
                for (bound, operator) in bounds {
                    let Some(bound) = bound else { continue };
                    let bound = self.evaluate(bound);
                    let fits = self.relates(scrutinee, operator, bound, pattern).unwrap_or_default();
                    let (known, fits) = (Operand::new(within, pattern), Operand::new(fits, pattern));
                    within = self.combine(Junction::And, known, fits).unwrap_or_default();
                }
                Some(within)
            }
            _ => self.refuse(expressions::match_pattern(pattern)),
        }
    }

    /// `scrutinee operator value` for the value of a pattern.
    fn relates(
        &mut self,
        scrutinee: &Value,
        operator: BinOp,
        value: Value,
        pattern: &dyn ToTokens,
    ) -> Option<Value> {
        match (scrutinee, value) {
            (Value::Poison, _) | (_, Value::Poison) => None,
            (Value::Known(_) | Value::Condition(_), value @ Value::Known(_)) => {
                let (own, value) = (Operand::new(scrutinee.clone(), pattern), Operand::new(value, pattern));
                self.compared(&operator, own, value, pattern)
            }
            (Value::Index(..) | Value::Constant(_), value @ (Value::Index(..) | Value::Constant(_))) => {
                let own = Value::index(self.checked_index(scrutinee, pattern)?);
                self.compared(&operator, Operand::new(own, pattern), Operand::new(value, pattern), pattern)
            }
            _ => {
                let pattern = pattern.to_token_stream();
                self.refuse(expressions::pattern_mismatch(pattern, scrutinee.describe()))
            }
        }
    }
}
