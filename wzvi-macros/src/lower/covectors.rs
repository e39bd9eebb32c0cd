//! Covectors: forces, rates of friction, matrices of damping. A covector `f` is lowered as the function `f · δq` of virtual displacements
//! `δq`, which is a sum like those of Hamiltonians; its components are the derivatives by `δq`. In the same way rates are
//! `Σ_i γ_i δq_i p_i`, and a matrix is `δq · Γ p`.

use quote::quote;
use syn::Expr as Syntax;

use super::interpreter::{Interpreter, result_of};
use super::value::Value;
use crate::diagnostics::expressions;
use crate::input::{self, peeled};
use crate::model::{Friction, Half, Index, Slot, Term};
use crate::symbolic::Expr;

/// Maps the entry for the component at an index.
type Leaf<'l, 'a, 'd> = &'l mut dyn FnMut(&mut Interpreter<'a, 'd>, Value, &Index) -> Option<Expr>;

impl<'a, 'd> Interpreter<'a, 'd> {
    /// `f · δq` of one entry per degree of freedom, arranged as the coordinates are.
    pub(super) fn covector(&mut self, value: Value, at: &'a Syntax) -> Option<Expr> {
        let lengths = self.lengths();
        self.paired(value, (&lengths, false), &Index::default(), at, &mut |this, entry, i| {
            let entry = this.real(entry, at)?;
            let displacement = this.local(Slot::State(Half::Displacements, i.clone()));
            Some(this.graph.multiply(entry, displacement))
        })
    }

    /// `Σ_i γ_i δq_i p_i` of one rate for all degrees of freedom, one for each point, or one for each.
    fn rates(&mut self, value: Value, at: &'a Syntax) -> Option<Expr> {
        let lengths = self.lengths();
        self.paired(value, (&lengths, true), &Index::default(), at, &mut |this, rate, i| {
            this.bilinear(rate, [i, i], at)
        })
    }

    /// `friction = ...` or `damping = ...`.
    pub(super) fn friction(&mut self, declared: &'a input::Friction) -> Option<Friction> {
        let is_matrix = declared.is_matrix;
        let (body, coordinates) = match &declared.given.value {
            Syntax::Closure(closure) => {
                let (Some(pattern), 1) = (closure.inputs.first(), closure.inputs.len()) else {
                    return self.refuse(match is_matrix {
                        true => expressions::damping_closure(closure),
                        false => expressions::friction_closure(closure),
                    });
                };
                (&*closure.body, Some(pattern))
            }
            body => (body, None),
        };
        let advice = match (is_matrix, coordinates) {
            (_, Some(_)) => None,
            (true, None) => Some("a matrix of the coordinates is a closure, `damping = |q| [[...]]`"),
            (false, None) => Some("friction of the coordinates is a closure, `friction = |q| ...`"),
        };
        let (mut uniform, mut is_one_rate) = (None, false);
        let term = self.lowered(body, |this| {
            this.now.advice = advice;
            if let Some(pattern) = coordinates {
                let q = this.vector(Half::Coordinates);
                this.bind(pattern, q);
            }
            let value = this.evaluate(body);
            is_one_rate = !is_matrix && matches!(value, Value::Real(_) | Value::Constant(_));
            if is_one_rate && coordinates.is_none() {
                uniform = this.real(value.clone(), body);
            }
            match is_matrix {
                true => this.matrix(value, result_of(body)),
                false => this.rates(value, result_of(body)),
            }
        })?;
        Some(Friction { term, is_matrix, is_one_rate, uniform })
    }

    /// `δq · Γ p` of rows of numbers, in the order of the state vector.
    fn matrix(&mut self, value: Value, at: &'a Syntax) -> Option<Expr> {
        let inner = self.space.inner.iter().product::<i128>();
        let (degrees, start) = ([self.space.size.multiply(&Index::integer(inner))?], Index::default());
        self.paired(value, (&degrees, false), &start, at, &mut |this, row, i| {
            this.paired(row, (&degrees, false), &start, at, &mut |this, entry, j| {
                this.bilinear(entry, [i, j], at)
            })
        })
    }

    /// `temperature = ...`
    pub(super) fn temperature(&mut self, declared: &'a input::Given) -> Option<Term> {
        let body = &declared.value;
        if let Syntax::Closure(closure) = peeled(body) {
            let (begin, inputs, end) = (&closure.inputs_begin, &closure.inputs, &closure.inputs_end);
            return self.refuse(expressions::temperature_closure(quote!(#begin #inputs #end)));
        }
        self.lowered(body, |this| {
            this.now.advice = Some("a temperature is one number, of fields and constants");
            let value = this.evaluate(body);
            this.real(value, result_of(body))
        })
    }

    /// The lengths of the arrays that coordinates are arranged in, the outermost first.
    fn lengths(&self) -> Vec<Index> {
        match self.space.shape {
            input::Shape::Real => Vec::new(),
            input::Shape::Array(..) => {
                let inner = self.space.inner.iter().map(|&length| Index::integer(length));
                std::iter::once(self.space.size.clone()).chain(inner).collect()
            }
        }
    }

    /// `entry · δq_i p_j`
    fn bilinear(&mut self, entry: Value, [i, j]: [&Index; 2], at: &'a Syntax) -> Option<Expr> {
        let entry = self.real(entry, at)?;
        let displacement = self.local(Slot::State(Half::Displacements, i.clone()));
        let momentum = self.local(Slot::State(Half::Momenta, j.clone()));
        Some(self.graph.product(&[entry, displacement, momentum]))
    }

    /// The sum of `leaf` over the entries of `value`, which has these lengths; with `spread`, a single number applies to all entries of an
    /// array.
    fn paired(
        &mut self,
        value: Value,
        (lengths, spread): (&[Index], bool),
        offset: &Index,
        at: &'a Syntax,
        leaf: Leaf<'_, 'a, 'd>,
    ) -> Option<Expr> {
        let Some((length, inner)) = lengths.split_first() else { return leaf(self, value, offset) };
        let stride = inner.iter().try_fold(Index::integer(1), |stride, length| stride.multiply(length))?;
        let is_number = matches!(value, Value::Real(_) | Value::Constant(_));
        if spread && is_number {
            return self.sum_loop(length, at, &mut |this, k| {
                let place = offset.add(&k.multiply(&stride)?)?;
                this.paired(value.clone(), (inner, true), &place, at, leaf)
            });
        }
        if !matches!(value, Value::Sequence(_) | Value::Poison) {
            let expected = format!("a list of {} numbers", self.display(length));
            return self.mismatch(at, &expected, &value);
        }
        let list = self.as_sequence(&value, at)?;
        let found = list.length.clone();
        let excess = found.as_ref().and_then(|found| found.subtract(length)?.as_integer());
        if excess != Some(0) {
            let (expected, found) = (self.display(length), found.map(|found| self.display(&found)));
            return self.refuse(expressions::entries(at, &expected, found.as_deref()));
        }
        self.sum_loop(length, at, &mut |this, k| {
            let item = this.item(&list, k, at)?;
            let place = offset.add(&k.multiply(&stride)?)?;
            this.paired(item, (inner, spread), &place, at, leaf)
        })
    }
}
