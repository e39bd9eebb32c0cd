//! Covectors: forces, rates of friction, matrices of damping. A covector `f` is lowered as the function `f · δq` of virtual displacements
//! `δq`, which is a sum like those of Hamiltonians; its components are the derivatives by `δq`. In the same way rates are
//! `Σ_i γ_i δq_i p_i`, and a matrix is `δq · Γ p`.

use syn::Expr as Syntax;

use super::Space;
use super::interpreter::{Interpreter, result_of};
use super::value::Value;
use crate::diagnostics::expressions;
use crate::input;
use crate::model::index::Index;
use crate::model::{Friction, Half, Slot, Term};
use crate::symbolic::Expr;

/// What is made of the entry for the component at an index.
type Leaf<'l, 'a, 'd> = &'l mut dyn FnMut(&mut Interpreter<'a, 'd>, Value, &Index) -> Option<Expr>;

impl Space<'_> {
    /// `f · δq` of one entry per degree of freedom, arranged as the coordinates are.
    pub(super) fn covector<'a, 'd>(
        &self,
        interpreter: &mut Interpreter<'a, 'd>,
        value: Value,
        at: &'a Syntax,
    ) -> Option<Expr> {
        self.entries(interpreter, value, false, at, |interpreter, entry, i| {
            let displacement = interpreter.local(Slot::State(Half::Displacements, i.clone()));
            interpreter.graph.multiply(entry, displacement)
        })
    }

    /// `Σ_i γ_i δq_i p_i` of one rate for all degrees of freedom, one for each point, or one for each.
    fn rates<'a>(&self, interpreter: &mut Interpreter<'a, '_>, value: Value, at: &'a Syntax) -> Option<Expr> {
        self.entries(interpreter, value, true, at, |interpreter, rate, i| bilinear(interpreter, rate, i, i))
    }

    /// The sum of what `term` makes of every entry of what is arranged as the coordinates are.
    fn entries<'a, 'd>(
        &self,
        interpreter: &mut Interpreter<'a, 'd>,
        value: Value,
        spread: bool,
        at: &'a Syntax,
        term: impl Fn(&mut Interpreter<'a, 'd>, Expr, &Index) -> Expr,
    ) -> Option<Expr> {
        let mut leaf = |interpreter: &mut Interpreter<'a, 'd>, value: Value, place: &Index| {
            let entry = interpreter.real(value, at)?;
            Some(term(interpreter, entry, place))
        };
        paired(interpreter, value, (&self.lengths(), spread), &Index::default(), at, &mut leaf)
    }

    /// `friction = ...` or `damping = ...`.
    pub(super) fn friction<'a>(
        &self,
        interpreter: &mut Interpreter<'a, '_>,
        declared: &'a input::Friction,
    ) -> Option<Friction> {
        let is_matrix = declared.is_matrix;
        let (body, coordinates) = match &declared.given.value {
            Syntax::Closure(closure) => {
                let (Some(pattern), 1) = (closure.inputs.first(), closure.inputs.len()) else {
                    return interpreter.refuse(match is_matrix {
                        true => expressions::damping_closure(closure),
                        false => expressions::friction_closure(closure),
                    });
                };
                (&*closure.body, Some(pattern))
            }
            body => (body, None),
        };
        let (mut uniform, mut is_one_rate) = (None, false);
        let term = self.lowered(interpreter, body, |interpreter| {
            if let Some(pattern) = coordinates {
                let q = self.vector(interpreter, Half::Coordinates);
                interpreter.bind(pattern, q);
            }
            let value = interpreter.evaluate(body);
            is_one_rate = !is_matrix && matches!(value, Value::Real(_) | Value::Constant(_));
            if is_one_rate && coordinates.is_none() {
                uniform = interpreter.real(value.clone(), body);
            }
            match is_matrix {
                true => self.matrix(interpreter, value, result_of(body)),
                false => self.rates(interpreter, value, result_of(body)),
            }
        })?;
        Some(Friction { term, is_matrix, is_one_rate, uniform })
    }

    /// `δq · Γ p` of rows of numbers, in the order of the state vector.
    fn matrix<'a, 'd>(
        &self,
        interpreter: &mut Interpreter<'a, 'd>,
        value: Value,
        at: &'a Syntax,
    ) -> Option<Expr> {
        let inner = self.inner.iter().product::<i128>();
        let degrees = [self.size.multiply(&Index::integer(inner))?];
        let mut row = |interpreter: &mut Interpreter<'a, 'd>, row: Value, i: &Index| {
            let mut leaf = |interpreter: &mut Interpreter<'a, 'd>, value: Value, j: &Index| {
                let entry = interpreter.real(value, at)?;
                Some(bilinear(interpreter, entry, i, j))
            };
            paired(interpreter, row, (&degrees, false), &Index::default(), at, &mut leaf)
        };
        paired(interpreter, value, (&degrees, false), &Index::default(), at, &mut row)
    }

    /// `temperature = ...`
    pub(super) fn temperature<'a>(
        &self,
        interpreter: &mut Interpreter<'a, '_>,
        declared: &'a input::Given,
    ) -> Option<Term> {
        let body = &declared.value;
        self.lowered(interpreter, body, |interpreter| {
            let value = interpreter.evaluate(body);
            interpreter.real(value, result_of(body))
        })
    }

    /// The lengths of the arrays that coordinates are arranged in, the outermost first.
    fn lengths(&self) -> Vec<Index> {
        match self.shape {
            input::Shape::Real => Vec::new(),
            input::Shape::Array(..) => {
                let inner = self.inner.iter().map(|&length| Index::integer(length));
                std::iter::once(self.size.clone()).chain(inner).collect()
            }
        }
    }
}

/// `entry · δq_i p_j`
fn bilinear(interpreter: &mut Interpreter<'_, '_>, entry: Expr, i: &Index, j: &Index) -> Expr {
    let displacement = interpreter.local(Slot::State(Half::Displacements, i.clone()));
    let momentum = interpreter.local(Slot::State(Half::Momenta, j.clone()));
    interpreter.graph.product(&[entry, displacement, momentum])
}

/// The sum of what `leaf` makes of every entry of `value`, which has these lengths; where numbers `spread`, one stands for the entries of
/// a whole array.
fn paired<'a, 'd>(
    interpreter: &mut Interpreter<'a, 'd>,
    value: Value,
    (lengths, spread): (&[Index], bool),
    offset: &Index,
    at: &'a Syntax,
    leaf: Leaf<'_, 'a, 'd>,
) -> Option<Expr> {
    let Some((length, inner)) = lengths.split_first() else { return leaf(interpreter, value, offset) };
    let stride = inner.iter().try_fold(Index::integer(1), |stride, length| stride.multiply(length))?;
    let is_number = matches!(value, Value::Real(_) | Value::Constant(_));
    if spread && is_number {
        return interpreter.sum_loop(length, at, &mut |interpreter, k| {
            let place = offset.add(&k.multiply(&stride)?)?;
            paired(interpreter, value.clone(), (inner, true), &place, at, leaf)
        });
    }
    if !matches!(value, Value::Sequence(_) | Value::Poison) {
        let expected = format!("a list of {} numbers", interpreter.display(length));
        return interpreter.refuse(expressions::expected(at, &expected, value.describe()));
    }
    let list = interpreter.as_sequence(&value, at)?;
    let found = list.length.clone();
    let excess = found.as_ref().and_then(|found| found.subtract(length)?.as_integer());
    if excess != Some(0) {
        let expected = interpreter.display(length);
        let found = found.map(|found| interpreter.display(&found));
        return interpreter.refuse(expressions::entries(at, &expected, found.as_deref()));
    }
    interpreter.sum_loop(length, at, &mut |interpreter, k| {
        let item = interpreter.item(&list, k, at)?;
        let place = offset.add(&k.multiply(&stride)?)?;
        paired(interpreter, item, (inner, spread), &place, at, leaf)
    })
}
