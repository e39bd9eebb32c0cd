//! Blocks, variables, branches and loops. Tests: `lower/tests/values.rs`, `tests/steps/values.rs`.

use std::rc::Rc;

use quote::ToTokens;
use syn::visit::Visit;
use syn::{Block, Expr as Syntax, ExprBinary, ExprForLoop, ExprIf, ExprRepeat, Ident, Item, Local, Stmt};

use super::interpreter::{Interpreter, last_expression};
use super::operators::{Operand, compound};
use super::patterns::BoundNames;
use super::scope::Binding;
use super::sequences::Sequence;
use super::value::{Items, Value};
use crate::diagnostics::expressions;
use crate::symbolic::{Expr, Junction, Symbol, SymbolKind};

/// A variable that a loop adds to, with its value.
type Total = (Rc<Binding>, Expr);

impl<'a> Interpreter<'a, '_> {
    pub(super) fn block(&mut self, block: &'a Block) -> Value {
        let outer = self.now.scope.len();
        let mut value = Value::unit();
        for statement in &block.stmts {
            value = self.statement(statement);
        }
        self.now.scope.leave(outer);
        value
    }

    fn statement(&mut self, statement: &'a Stmt) -> Value {
        let (pattern, value) = match statement {
            Stmt::Local(Local { init: Some(init), pat, .. }) if init.diverge.is_none() => (pat, &*init.expr),
            Stmt::Expr(syntax, None) => return self.evaluate(syntax),
            Stmt::Expr(syntax, Some(_)) => {
                self.evaluate(syntax);
                return Value::unit();
            }
            Stmt::Item(Item::Const(item)) => {
                let value = self.evaluate(&item.expr);
                self.declare(item.ident.clone(), value);
                return Value::unit();
            }
            _ => return self.unsupported_statement(statement),
        };
        let value = self.evaluate(value);
        self.bind(pattern, value);
        Value::unit()
    }

    fn unsupported_statement(&mut self, statement: &'a Stmt) -> Value {
        let (at, what, remedy): (&dyn ToTokens, _, _) = match statement {
            Stmt::Local(Local { init: Some(_), let_token, .. }) => {
                (let_token, "`let ... else`", "use `let` without `else`")
            }
            Stmt::Local(local) => {
                (local, "a `let` without a value", "give the variable its value where it is declared")
            }
            Stmt::Macro(call) => (call, "a macro call", "write out what it stands for"),
            item => (item, "an item inside a Hamiltonian", "move it out of the closure"),
        };
        self.report(expressions::unsupported(at, what, remedy));
        if let Stmt::Local(local) = statement {
            self.poison(&local.pat);
        }
        Value::Poison
    }

    /// `target = value`
    pub(super) fn store(&mut self, target: &Syntax, value: Value) -> Value {
        let name = match target {
            Syntax::Path(path) => path.path.get_ident(),
            Syntax::Unary(unary) if matches!(unary.op, syn::UnOp::Deref(_)) => {
                return self.store(&unary.expr, value);
            }
            Syntax::Paren(inner) => return self.store(&inner.expr, value),
            _ => None,
        };
        match name.and_then(|name| self.now.scope.find_from_anywhere(name)).cloned() {
            Some(binding) if binding.branch == self.now.branch => {
                if self.is_abandoned() {
                } else if binding.loops == self.loop_depth() || value.is_poison() {
                    self.now.scope.assign(&binding, value, self.now.frame);
                } else if !self.request_unrolling(|_| true) {
                    self.report(expressions::long_for_loop(target));
                }
            }
            Some(_) => self.report(expressions::assignment_in_branch(target)),
            None => self.report(expressions::assignment_target(target)),
        }
        Value::unit()
    }

    pub(super) fn branch(&mut self, syntax: &'a ExprIf) -> Option<Value> {
        match self.evaluate(&syntax.cond) {
            Value::Known(true) => Some(self.block(&syntax.then_branch)),
            Value::Known(false) => Some(match &syntax.else_branch {
                Some((_, otherwise)) => self.evaluate(otherwise),
                None => Value::unit(),
            }),
            Value::Condition(condition) => self.undecided(syntax, Some(condition)),
            // Report mistakes in the branches, too.
            Value::Poison => self.undecided(syntax, None),
            other => self.mismatch(&syntax.cond, "a condition", &other),
        }
    }

    /// Evaluates both branches, and selects between their values.
    fn undecided(&mut self, syntax: &'a ExprIf, condition: Option<Expr>) -> Option<Value> {
        self.now.branch += 1;
        let outer = self.now.scope.len();
        if condition.is_none() {
            // `if let` was reported.
            let mut names = BoundNames::default();
            names.visit_expr(&syntax.cond);
            names.0.into_iter().for_each(|name| self.declare(name, Value::Poison));
        }
        let then = self.block(&syntax.then_branch);
        self.now.scope.leave(outer);
        let otherwise = syntax.else_branch.as_ref().map(|(_, otherwise)| self.evaluate(otherwise));
        self.now.branch -= 1;
        let condition = condition?;
        let otherwise = match (otherwise, &then) {
            (Some(otherwise), _) => otherwise,
            (None, Value::Poison) => return None,
            (None, Value::Tuple(tuple)) if tuple.items.is_empty() => return Some(then),
            (None, _) => return self.refuse(expressions::missing_else(syntax.if_token)),
        };
        self.select(condition, &then, &otherwise).or_else(|| {
            let last = last_expression(&syntax.then_branch);
            let at: &dyn ToTokens = last.map_or(&syntax.if_token, |last| last);
            self.refuse(expressions::branches_differ(at))
        })
    }

    /// `if condition { then } else { otherwise }`, element by element; `None` if the two do not match.
    pub(super) fn select(&mut self, condition: Expr, then: &Value, otherwise: &Value) -> Option<Value> {
        let at = proc_macro2::TokenStream::new();
        Some(match (then, otherwise) {
            (Value::Poison, _) | (_, Value::Poison) => Value::Poison,
            (Value::Index(a, sign), Value::Index(b, _)) if a == b => Value::Index(a.clone(), *sign),
            (Value::Known(a), Value::Known(b)) if a == b => Value::Known(*a),
            (Value::Known(_) | Value::Condition(_), Value::Known(_) | Value::Condition(_)) => {
                let holds = Value::Condition(condition);
                let fails = self.denied(&holds)?;
                let operand = |value: Value| Operand::new(value, &at);
                let then = self.combine(Junction::And, operand(holds), operand(then.clone()))?;
                let otherwise = self.combine(Junction::And, operand(fails), operand(otherwise.clone()))?;
                self.combine(Junction::Or, operand(then), operand(otherwise))?
            }
            (Value::Sequence(a), Value::Sequence(b)) => {
                let (a, b) = (self.known_list(a, &at)?, self.known_list(b, &at)?);
                Value::list(self.select_all(condition, &a, &b)?.items.to_vec())
            }
            (Value::Tuple(a), Value::Tuple(b)) => Value::Tuple(self.select_all(condition, a, b)?),
            (Value::Real(_) | Value::Constant(_), Value::Real(_) | Value::Constant(_)) => {
                let (then, otherwise) = (self.real(then.clone(), &at)?, self.real(otherwise.clone(), &at)?);
                Value::Real(self.graph.select(condition, then, otherwise))
            }
            _ => return None,
        })
    }

    fn select_all(&mut self, condition: Expr, a: &Items, b: &Items) -> Option<Items> {
        if a.items.len() != b.items.len() {
            return None;
        }
        let pairs = a.items.iter().zip(b.items.iter());
        let items: Option<Vec<_>> = pairs.map(|(a, b)| self.select(condition, a, b)).collect();
        items.map(Items::new)
    }

    /// A loop that only adds to its variables becomes a sum for each of them; any other is evaluated item by
    /// item.
    pub(super) fn for_loop(&mut self, syntax: &'a ExprForLoop) -> Option<Value> {
        let value = self.evaluate(&syntax.expr);
        let sequence = self.as_sequence(&value, &syntax.expr)?;
        let totals = self.totals(&syntax.body)?;
        // Assignments in closures are not seen here.
        let goes_by_items = self.now.has_mutation && self.has_known_items(&sequence);
        if let Some(totals) = totals.as_ref().filter(|_| !goes_by_items) {
            match self.summing_loop(&sequence, totals, syntax) {
                LoopSums::All(values) => {
                    for ((binding, before), added) in totals.iter().zip(values) {
                        let total = self.graph.add(*before, added);
                        self.now.scope.assign(binding, Value::Real(total), self.now.frame);
                    }
                    return Some(Value::unit());
                }
                LoopSums::Failed => return None,
                LoopSums::NoSum => {}
            }
        }
        if !self.has_known_items(&sequence) {
            return self.refuse(expressions::long_for_loop(syntax.for_token));
        }
        for item in self.items(&sequence, &syntax.expr)? {
            if !self.spend(1, &syntax.for_token) {
                return None;
            }
            self.iteration(syntax, item);
        }
        Some(Value::unit())
    }

    fn iteration(&mut self, syntax: &'a ExprForLoop, item: Value) {
        let outer = self.now.scope.len();
        self.bind(&syntax.pat, item);
        self.block(&syntax.body);
        self.now.scope.leave(outer);
    }

    /// The outer variables that a block assigns to, with their values: `Some(None)` if some are not real
    /// numbers.
    fn totals(&mut self, body: &Block) -> Option<Option<Vec<Total>>> {
        let mut targets = Assigned::default();
        targets.visit_block(body);
        let mut totals: Vec<Total> = Vec::new();
        for name in targets.0 {
            let Some(binding) = self.now.scope.find_from_anywhere(&name).cloned() else { continue };
            if totals.iter().any(|(known, _)| Rc::ptr_eq(known, &binding)) {
                continue;
            }
            let value = match &*binding.value.borrow() {
                Value::Real(value) => *value,
                Value::Poison => return None,
                _ => return Some(None),
            };
            totals.push((binding, value));
        }
        Some(Some(totals))
    }

    /// The sums that a loop adds to each of `totals`.
    fn summing_loop(
        &mut self,
        sequence: &Sequence,
        totals: &[(Rc<Binding>, Expr)],
        syntax: &'a ExprForLoop,
    ) -> LoopSums {
        let placeholders: Vec<Symbol> = totals
            .iter()
            .map(|(binding, _)| self.graph.new_symbol(SymbolKind::Auxiliary, binding.name.to_string()))
            .collect();
        let mut added = Vec::new();
        // One pass per total, so that each has its own sums; without totals one pass, to report mistakes.
        for wanted in 0..totals.len().max(1) {
            let mut is_sum = true;
            let sum = self.sum_over(sequence, false, &syntax.for_token, &mut |this, item| {
                let outer = this.now.scope.len();
                // The body gets its own copies of the totals.
                for ((binding, _), &placeholder) in totals.iter().zip(&placeholders) {
                    let total = Value::Real(this.graph.symbol(placeholder));
                    this.declare(binding.name.clone(), total);
                }
                this.iteration(syntax, item);
                let own = this.now.scope.get(outer + wanted).filter(|_| wanted < totals.len());
                this.now.scope.leave(outer);
                let (Some(own), Some(&placeholder)) = (own, placeholders.get(wanted)) else {
                    return Some(this.graph.integer(0));
                };
                let value = own.value.borrow().clone();
                let Value::Real(next) = value else {
                    is_sum &= value.is_poison();
                    return None;
                };
                let total = this.graph.symbol(placeholder);
                let added = this.graph.subtract(next, total);
                is_sum &= !this.graph.depends_on(added, &placeholders);
                is_sum.then_some(added)
            });
            match sum {
                Some(sum) => added.push(sum),
                None if is_sum => return LoopSums::Failed,
                None => return LoopSums::NoSum,
            }
        }
        LoopSums::All(added)
    }

    /// `[value; n]`
    pub(super) fn repeat(&mut self, syntax: &'a ExprRepeat) -> Option<Value> {
        let value = self.evaluate(&syntax.expr);
        let len = self.evaluate(&syntax.len);
        let len = self.known_integer(len, &syntax.len)?;
        let Ok(len) = usize::try_from(len) else {
            return self.refuse(expressions::index_out_of_range(&syntax.len, len, 0));
        };
        if !self.spend(len, &syntax.len) {
            return None;
        }
        Some(Value::list(vec![value; len]))
    }
}

/// The effect of a loop on its variables.
enum LoopSums {
    All(Vec<Expr>),
    /// The loop does something else.
    NoSum,
    /// A mistake was reported.
    Failed,
}

/// Whether a closure assigns to a variable that is not its own.
pub(super) fn assigns_captured(closure: &syn::ExprClosure) -> bool {
    let (mut assigned, mut own) = (Assigned::default(), BoundNames::default());
    assigned.visit_expr(&closure.body);
    if assigned.0.is_empty() {
        return false;
    }
    own.visit_expr_closure(closure);
    assigned.0.iter().any(|name| !own.0.contains(name))
}

/// The variables that a block assigns to.
#[derive(Default)]
struct Assigned(Vec<Ident>);

impl Assigned {
    fn take(&mut self, target: &Syntax) {
        match target {
            Syntax::Path(path) => self.0.extend(path.path.get_ident().cloned()),
            Syntax::Paren(inner) => self.take(&inner.expr),
            Syntax::Unary(inner) => self.take(&inner.expr),
            _ => {}
        }
    }
}

impl<'s> Visit<'s> for Assigned {
    fn visit_expr_assign(&mut self, syntax: &'s syn::ExprAssign) {
        self.take(&syntax.left);
        syn::visit::visit_expr_assign(self, syntax);
    }
    fn visit_expr_binary(&mut self, syntax: &'s ExprBinary) {
        if compound(&syntax.op).is_some() {
            self.take(&syntax.left);
        }
        syn::visit::visit_expr_binary(self, syntax);
    }
}
