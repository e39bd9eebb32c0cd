//! Covectors: forces, rates of friction, matrices of damping. A covector `f` is lowered as the function
//! `f · δq` of virtual displacements `δq`, which is a sum like those of Hamiltonians; its components are the
//! derivatives by `δq`. In the same way rates are `Σ_i γ_i δq_i p_i`, and a matrix is `δq · Γ p`.
//!
//! Tests: `tests/forces`.

use quote::quote;
use syn::{Expr as Syntax, ExprClosure, ExprRepeat, Pat};

use super::interpreter::{Interpreter, result_of};
use super::value::Value;
use crate::diagnostics::expressions;
use crate::input::{self, is_usual_time, name_of_time, peeled};
use crate::model::{Friction, Half, Index, Slot, Temperature};
use crate::symbolic::Expr;

/// Maps the entry for the component at an index.
type Leaf<'l, 'a, 'd> = &'l mut dyn FnMut(&mut Interpreter<'a, 'd>, Value, &Index) -> Option<Expr>;

fn is_closure(syntax: &Syntax) -> bool {
    matches!(peeled(syntax), Syntax::Closure(_))
}

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
    pub(super) fn friction(&mut self, declared: &'a input::DeclaredFriction) -> Option<Friction> {
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
            (true, None) => Some(
                "a damping matrix is constant; rates of the coordinates are a closure, `friction = |q| [...]`",
            ),
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

    /// `temperature = ...`: one number, or `Σ_i T_i δq_i p_i` of one number for each point or degree of
    /// freedom.
    pub(super) fn temperature(&mut self, declared: &'a input::DeclaredValue) -> Option<Temperature> {
        let body = peeled(&declared.value);
        let family = match body {
            Syntax::Repeat(ExprRepeat { expr, len, .. }) => match peeled(expr) {
                Syntax::Closure(closure) => Some((closure, len, self.number_of_sites(len)?)),
                _ => None,
            },
            _ => None,
        };
        let (mut entries, mut is_list) = (Vec::new(), false);
        let mut term = self.lowered(body, |this| {
            this.now.advice = Some("a temperature of the time is a closure, `temperature = |t| ...`");
            let mut leaf = |this: &mut Self, entry, i: &Index| {
                let entry = this.real(entry, result_of(body))?;
                entries.push(entry);
                this.bilinear(Value::Real(entry), [i, i], body)
            };
            let lengths = this.lengths();
            is_list = true;
            if let Some((closure, length, count)) = &family {
                this.check_sites(count, length)?;
                let mut value = |this: &mut Self, i: &Index| this.temperature_at(closure, Some(i));
                return this.by_site(&lengths, body, &mut leaf, &mut value);
            }
            match body {
                Syntax::Array(array) if array.elems.iter().any(is_closure) => {
                    this.check_sites(&Index::integer(array.elems.len() as i128), body)?;
                    let elements = array.elems.iter().enumerate();
                    let terms = elements.map(|(i, element)| {
                        let value = match peeled(element) {
                            Syntax::Closure(closure) => this.temperature_at(closure, None)?,
                            other => this.evaluate(other),
                        };
                        this.of_site(&lengths, &Index::integer(i as i128), value, element, &mut leaf)
                    });
                    let terms: Vec<Expr> = terms.collect::<Option<_>>()?;
                    Some(this.graph.sum(&terms))
                }
                _ => {
                    let value = match body {
                        Syntax::Closure(closure) => this.temperature_at(closure, None)?,
                        _ => this.evaluate(body),
                    };
                    if matches!(value, Value::Real(_) | Value::Constant(_) | Value::Index(..)) {
                        is_list = false;
                        return this.real(value, result_of(body));
                    }
                    this.paired(value, (&lengths, true), &Index::default(), result_of(body), &mut leaf)
                }
            }
        })?;
        // Sites of one temperature have an equilibrium.
        if is_list && let [first, others @ ..] = &entries[..] {
            let reads = self.graph.symbols_in(*first).into_iter();
            let is_of_fields = self.symbols.locals_among(reads).is_empty();
            if is_of_fields && others.iter().all(|other| other == first) {
                (term.expression, is_list) = (*first, false);
            }
        }
        let reads_time = self.graph.depends_on(term.expression, &[self.space.t])
            || entries.iter().any(|entry| self.graph.depends_on(*entry, &[self.space.t]));
        Some(Temperature { term, is_list, reads_time })
    }

    /// A temperature of the time and, if there is one, of the index of a site.
    fn temperature_at(&mut self, closure: &'a ExprClosure, site: Option<&Index>) -> Option<Value> {
        let (begin, inputs, end) = (&closure.inputs_begin, &closure.inputs, &closure.inputs_end);
        let mut inputs = inputs.iter();
        let site = site.map(|site| (inputs.next(), site));
        let (time, is_last) = (inputs.next(), inputs.next().is_none());
        let declared = self.graph.symbol_name(self.space.t).to_owned();
        let is_time = |pattern: &Pat| {
            name_of_time(pattern).is_some_and(|name| name == declared || is_usual_time(&name))
        };
        let is_known = match (&site, time) {
            (None, None) | (Some((None, _)), _) => false,
            (_, time) => time.is_none_or(is_time),
        };
        if !is_last || !is_known {
            let inputs = &closure.inputs;
            return self.refuse(expressions::temperature_closure(quote!(#begin #inputs #end)));
        }
        let outer = self.now.scope.len();
        if let Some((Some(pattern), site)) = site {
            self.bind(pattern, Value::index(site.clone()).unsigned(true));
        }
        if let Some(pattern) = time {
            let t = Value::Real(self.graph.symbol(self.space.t));
            self.bind(pattern, t);
        }
        let value = self.evaluate(&closure.body);
        self.now.scope.leave(outer);
        Some(value)
    }

    /// The number of sites in `[|i| ...; N]`.
    fn number_of_sites(&mut self, length: &'a Syntax) -> Option<Index> {
        self.start();
        let value = self.evaluate(length).known()?;
        let is_number = matches!(value, Value::Index(..) | Value::Constant(_));
        let number = if is_number { self.as_index(&value, length) } else { None };
        number.or_else(|| self.refuse(expressions::number_of_sites(length)))
    }

    /// Refuses a number of sites that is known to be another than that of points.
    fn check_sites(&mut self, found: &Index, at: &'a Syntax) -> Option<()> {
        let expected = self.lengths().into_iter().next().unwrap_or(Index::integer(1));
        // Lengths of fields are known at run time only; their entries are read within them.
        if found.subtract(&expected)?.as_integer().is_none_or(|excess| excess == 0) {
            return Some(());
        }
        let (expected, found) = (self.display(&expected), self.display(found));
        self.refuse(expressions::entries(at, &expected, Some(&found)))
    }

    /// The sum of `leaf` over the values of all sites.
    fn by_site(
        &mut self,
        lengths: &[Index],
        at: &'a Syntax,
        leaf: Leaf<'_, 'a, 'd>,
        value: &mut dyn FnMut(&mut Self, &Index) -> Option<Value>,
    ) -> Option<Expr> {
        let Some(length) = lengths.first() else {
            let first = value(self, &Index::default())?;
            return self.of_site(lengths, &Index::default(), first, at, leaf);
        };
        self.sum_loop(length, at, &mut |this, i| {
            let own = value(this, i)?;
            this.of_site(lengths, i, own, at, leaf)
        })
    }

    /// The sum of `leaf` over the degrees of freedom of a site with this value.
    fn of_site(
        &mut self,
        lengths: &[Index],
        site: &Index,
        value: Value,
        at: &'a Syntax,
        leaf: Leaf<'_, 'a, 'd>,
    ) -> Option<Expr> {
        let inner = lengths.get(1..).unwrap_or_default();
        let stride = inner.iter().try_fold(Index::integer(1), |stride, length| stride.multiply(length))?;
        self.paired(value, (inner, true), &site.multiply(&stride)?, at, leaf)
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

    /// The sum of `leaf` over the entries of `value`, which has these lengths; with `spread`, a single number
    /// applies to all entries of an array.
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
