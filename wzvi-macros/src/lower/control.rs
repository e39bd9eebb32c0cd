//! Blocks, variables, branches and loops.

use syn::visit::Visit;
use syn::{BinOp, Block, Expr as Syntax, ExprBinary, ExprForLoop, ExprIf, ExprRepeat, Ident, Item, Stmt};

use super::interpreter::{Interpreter, last_expression};
use super::patterns::Names;
use super::streams::Stream;
use super::value::{Sequence, Value};
use crate::diagnostics::expressions;
use crate::symbolic::{Expr, Symbol};

impl<'a> Interpreter<'a, '_> {
    pub(super) fn block(&mut self, block: &'a Block) -> Value {
        let outer = self.scope.len();
        let mut value = Value::unit();
        for statement in &block.stmts {
            value = self.statement(statement);
        }
        self.scope.leave(outer);
        value
    }

    fn statement(&mut self, statement: &'a Stmt) -> Value {
        match statement {
            Stmt::Local(local) => {
                let value = match &local.init {
                    Some(init) if init.diverge.is_none() => self.evaluate(&init.expr),
                    Some(_) => {
                        let remedy = "use `let` without `else`";
                        self.report(expressions::unsupported(local.let_token, "`let ... else`", remedy))
                    }
                    // Assigned before it is read, or `rustc` says so.
                    None => Value::Poison,
                };
                if local.init.is_none() {
                    let remedy = "give the variable its value where it is declared";
                    self.report(expressions::unsupported(local, "a `let` without a value", remedy));
                }
                self.bind(&local.pat, value);
                Value::unit()
            }
            Stmt::Expr(syntax, semicolon) => {
                let value = self.evaluate(syntax);
                if semicolon.is_some() { Value::unit() } else { value }
            }
            Stmt::Item(Item::Const(item)) => {
                let value = self.evaluate(&item.expr);
                self.declare(item.ident.clone(), value);
                Value::unit()
            }
            Stmt::Item(item) => {
                let remedy = "move it out of the closure";
                self.report(expressions::unsupported(item, "an item inside a Hamiltonian", remedy))
            }
            Stmt::Macro(call) => {
                let remedy = "write out what it stands for";
                self.report(expressions::unsupported(call, "a macro call", remedy))
            }
        }
    }

    pub(super) fn assign(&mut self, target: &'a Syntax, value: &'a Syntax) -> Value {
        let value = self.evaluate(value);
        self.store(target, value);
        Value::unit()
    }

    /// `target op= value`
    pub(super) fn assign_compound(&mut self, syntax: &'a ExprBinary, operator: BinOp) -> Value {
        let left = self.evaluate(&syntax.left);
        let right = self.evaluate(&syntax.right);
        let value = self.operate(left, operator, right, syntax);
        self.store(&syntax.left, value);
        Value::unit()
    }

    fn store(&mut self, target: &Syntax, value: Value) {
        let name = match target {
            Syntax::Path(path) => path.path.get_ident(),
            Syntax::Unary(unary) if matches!(unary.op, syn::UnOp::Deref(_)) => {
                return self.store(&unary.expr, value);
            }
            Syntax::Paren(inner) => return self.store(&inner.expr, value),
            _ => None,
        };
        let error = match name.and_then(|name| self.scope.find_from_anywhere(name)) {
            Some(binding) if binding.branch == self.branch => {
                *binding.value.borrow_mut() = value;
                return;
            }
            Some(_) => expressions::assignment_in_branch(target),
            None => expressions::assignment_target(target),
        };
        self.report(error);
    }

    pub(super) fn branch(&mut self, syntax: &'a ExprIf) -> Value {
        match self.evaluate(&syntax.cond) {
            Value::Known(true) => self.block(&syntax.then_branch),
            Value::Known(false) => match &syntax.else_branch {
                Some((_, otherwise)) => self.evaluate(otherwise),
                None => Value::unit(),
            },
            Value::Condition(condition) => self.undecided(syntax, Some(condition)),
            // The branches may have mistakes of their own.
            Value::Poison => self.undecided(syntax, None),
            other => self.report(expressions::expected(&syntax.cond, "a condition", other.describe())),
        }
    }

    /// Both branches, and a choice between their values.
    fn undecided(&mut self, syntax: &'a ExprIf, condition: Option<Expr>) -> Value {
        self.branch += 1;
        let outer = self.scope.len();
        if condition.is_none() {
            // `if let` was reported.
            let mut names = Names::default();
            names.visit_expr(&syntax.cond);
            names.0.into_iter().for_each(|name| self.declare(name, Value::Poison));
        }
        let then = self.block(&syntax.then_branch);
        self.scope.leave(outer);
        let otherwise = syntax.else_branch.as_ref().map(|(_, otherwise)| self.evaluate(otherwise));
        self.branch -= 1;
        match (condition, otherwise) {
            (None, _) => Value::Poison,
            (_, None) => match &then {
                Value::Poison => Value::Poison,
                Value::Tuple(tuple) if tuple.items.is_empty() => Value::unit(),
                _ => self.report(expressions::missing_else(syntax.if_token)),
            },
            (Some(condition), Some(otherwise)) => match self.select(condition, &then, &otherwise) {
                Some(value) => value,
                None => {
                    let at = last_expression(&syntax.then_branch);
                    let error = match at {
                        Some(at) => expressions::branches_differ(at),
                        None => expressions::branches_differ(syntax.if_token),
                    };
                    self.report(error)
                }
            },
        }
    }

    /// `if condition { then } else { otherwise }`, element by element; `None` if the two do not match.
    fn select(&mut self, condition: Expr, then: &Value, otherwise: &Value) -> Option<Value> {
        Some(match (then, otherwise) {
            (Value::Poison, _) | (_, Value::Poison) => Value::Poison,
            (Value::Integer(a), Value::Integer(b)) if a == b => Value::Integer(*a),
            (Value::Known(a), Value::Known(b)) if a == b => Value::Known(*a),
            (Value::Known(true), Value::Known(false)) => Value::Condition(condition),
            (Value::Known(false), Value::Known(true)) => Value::Condition(self.graph.not(condition)),
            (Value::Condition(a), Value::Condition(b)) => {
                let negated = self.graph.not(condition);
                let (then, otherwise) = (self.graph.and(condition, *a), self.graph.and(negated, *b));
                Value::Condition(self.graph.or(then, otherwise))
            }
            (Value::List(a), Value::List(b)) => Value::List(self.select_all(condition, a, b)?),
            (Value::Tuple(a), Value::Tuple(b)) => Value::Tuple(self.select_all(condition, a, b)?),
            _ => {
                let (then, otherwise) = (self.as_constant(then)?, self.as_constant(otherwise)?);
                Value::Real(self.graph.select(condition, then, otherwise))
            }
        })
    }

    /// A real number or a constant that may be one.
    fn as_constant(&mut self, value: &Value) -> Option<Expr> {
        match value {
            Value::Real(expr) => Some(*expr),
            Value::Place(place) if place.kind == crate::input::Kind::Constant => {
                Some(self.parameter(&place.name, place.value()))
            }
            _ => None,
        }
    }

    fn select_all(&mut self, condition: Expr, a: &Sequence, b: &Sequence) -> Option<Sequence> {
        if a.items.len() != b.items.len() {
            return None;
        }
        let pairs = a.items.iter().zip(b.items.iter());
        let items: Option<Vec<_>> = pairs.map(|(a, b)| self.select(condition, a, b)).collect();
        items.map(Sequence::new)
    }

    pub(super) fn for_loop(&mut self, syntax: &'a ExprForLoop) -> Value {
        let value = self.evaluate(&syntax.expr);
        if let Some(stream) = self.as_stream(&value) {
            return self.summing_loop(&stream, syntax).unwrap_or(Value::Poison);
        }
        let Some(items) = self.items(&value, None, &syntax.expr) else { return Value::Poison };
        for item in items {
            if !self.spend(1, &syntax.for_token) {
                return Value::Poison;
            }
            let outer = self.scope.len();
            self.bind(&syntax.pat, item);
            self.block(&syntax.body);
            self.scope.leave(outer);
        }
        Value::unit()
    }

    /// A loop whose length only the running program knows: what it adds to each variable is a sum.
    fn summing_loop(&mut self, stream: &Stream, syntax: &'a ExprForLoop) -> Option<Value> {
        let mut targets = Assigned::default();
        targets.visit_block(&syntax.body);
        let mut totals: Vec<(Ident, Expr)> = Vec::new();
        for name in targets.0 {
            let Some(binding) = self.scope.find_from_anywhere(&name) else { continue };
            let value = binding.value.borrow().clone();
            if !totals.iter().any(|(known, _)| *known == name) {
                totals.push((name.clone(), self.real(value, &name)?));
            }
        }
        let placeholders: Vec<Symbol> =
            totals.iter().map(|(name, _)| self.graph.new_symbol(name.to_string())).collect();
        let mut added = Vec::new();
        // One pass for each total, so that each has sums of its own.
        for (wanted, &placeholder) in placeholders.iter().enumerate() {
            let at = &syntax.for_token;
            added.push(self.accumulate(stream, at, &mut |this, item| {
                for ((name, _), &placeholder) in totals.iter().zip(&placeholders) {
                    let total = Value::Real(this.graph.symbol(placeholder));
                    this.scope.find_from_anywhere(name)?.value.replace(total);
                }
                let outer = this.scope.len();
                this.bind(&syntax.pat, item);
                this.block(&syntax.body);
                this.scope.leave(outer);
                let name = &totals[wanted].0;
                let value = this.scope.find_from_anywhere(name)?.value.borrow().clone();
                let next = this.real(value, name)?;
                let total = this.graph.symbol(placeholder);
                let added = this.graph.subtract(next, total);
                if this.graph.depends_on(added, &placeholders) {
                    this.report(expressions::long_for_loop(at));
                    return None;
                }
                Some(added)
            })?);
        }
        for ((name, before), added) in totals.iter().zip(added) {
            let total = self.graph.add(*before, added);
            self.scope.find_from_anywhere(name)?.value.replace(Value::Real(total));
        }
        Some(Value::unit())
    }

    /// `[value; n]`
    pub(super) fn repeat(&mut self, syntax: &'a ExprRepeat) -> Value {
        let value = self.evaluate(&syntax.expr);
        let len = self.evaluate(&syntax.len);
        let Some(len) = self.known_integer(len, &syntax.len) else { return Value::Poison };
        let Ok(len) = usize::try_from(len) else {
            return self.report(expressions::index_out_of_range(&syntax.len, len, 0));
        };
        if !self.spend(len, &syntax.len) {
            return Value::Poison;
        }
        self.bounded(Value::list(vec![value; len]), syntax)
    }
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
        let is_assignment = matches!(
            syntax.op,
            BinOp::AddAssign(_)
                | BinOp::SubAssign(_)
                | BinOp::MulAssign(_)
                | BinOp::DivAssign(_)
                | BinOp::RemAssign(_)
        );
        if is_assignment {
            self.take(&syntax.left);
        }
        syn::visit::visit_expr_binary(self, syntax);
    }
}
