//! The lists that the state and the struct hold, their entries, and ranges. Tests: `lower/tests/values.rs`,
//! `tests/accepted/parameters.rs`.

use std::rc::Rc;

use quote::{ToTokens, quote};
use syn::{Expr as Syntax, ExprIndex, ExprRange, RangeLimits};

use super::interpreter::Interpreter;
use super::sequences::{Sequence, Source};
use super::value::{Place, Value};
use crate::diagnostics::expressions;
use crate::input::FieldKind;
use crate::model::{Atom, Half, Index, Outlier, Slot};
use crate::symbolic::Expr;

/// The storage of the numbers of an [`Array`].
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Origin {
    State(Half),
    /// A list of the struct, by its table number, with the kind of its elements.
    Table(u32, Rc<FieldKind>),
}

/// A list, or a part of one.
#[derive(Clone, Debug)]
pub(super) struct Array {
    pub(super) origin: Origin,
    /// The indices so far. The phase space has one, the position in the state vector.
    pub(super) indices: Vec<Index>,
    /// Index of the first element.
    pub(super) start: Index,
    pub(super) length: Index,
    /// For the phase space: the lengths of the lists inside.
    pub(super) inner: Vec<i128>,
}

impl Array {
    pub(super) fn whole(origin: Origin, indices: Vec<Index>, length: Index, inner: Vec<i128>) -> Self {
        Self { origin, indices, start: Index::default(), length, inner }
    }
}

impl<'a> Interpreter<'a, '_> {
    /// An integer of the struct or a constant.
    pub(super) fn given(&mut self, place: &Place) -> Index {
        let id = self.tables.add(&place.name, &place.tokens, false, Vec::new());
        Index::atom(Atom::Given(id, Vec::new()))
    }

    /// A list of the struct.
    pub(super) fn table(&mut self, place: &Place, element: &Rc<FieldKind>, length: Option<usize>) -> Array {
        let tokens = &place.tokens;
        let known_length = match length {
            Some(length) => Index::integer(length as i128),
            None => {
                let (name, tokens) = (format!("{}.len()", place.name), quote! { #tokens.len() });
                Index::atom(Atom::Given(self.tables.add(&name, &tokens, true, Vec::new()), Vec::new()))
            }
        };
        let mut lengths = vec![length];
        let mut inner = &**element;
        while let FieldKind::List(element, length) = inner {
            lengths.push(*length);
            inner = element;
        }
        let id = self.tables.add(&place.name, tokens, false, lengths);
        Array::whole(Origin::Table(id, element.clone()), Vec::new(), known_length, Vec::new())
    }

    /// Element `k` of a list.
    pub(super) fn array_element(&mut self, array: &Array, k: &Index, at: &dyn ToTokens) -> Option<Value> {
        self.check_range(array, k, at)?;
        let position = array.start.add(k)?;
        let half = match &array.origin {
            Origin::Table(id, kind) => {
                let mut indices = array.indices.clone();
                indices.push(position);
                return self.entry(*id, kind, indices, at);
            }
            Origin::State(half) => *half,
        };
        let stride = array.inner.iter().product::<i128>();
        let offset = array.indices.first().cloned().unwrap_or_default();
        let offset = offset.plus(&position, stride)?;
        let Some((&length, inner)) = array.inner.split_first() else {
            return Some(Value::Real(self.local(Slot::State(half, offset))));
        };
        let length = Index::integer(length);
        Some(list(Array::whole(array.origin.clone(), vec![offset], length, inner.to_vec())))
    }

    /// The entry of a list of the struct at `indices`.
    fn entry(&mut self, id: u32, kind: &FieldKind, indices: Vec<Index>, at: &dyn ToTokens) -> Option<Value> {
        match kind {
            FieldKind::Real | FieldKind::Constant => Some(Value::Real(self.local(Slot::Entry(id, indices)))),
            &FieldKind::Integer(is_unsigned) => {
                Some(Value::index(Index::atom(Atom::Given(id, indices))).unsigned(is_unsigned))
            }
            FieldKind::List(inner, length) => {
                let length = match length {
                    Some(length) => Index::integer(*length as i128),
                    None => {
                        let length = self.tables.suffixed(id, quote!(.len()), true);
                        Index::atom(Atom::Given(length, indices.clone()))
                    }
                };
                Some(list(Array::whole(Origin::Table(id, inner.clone()), indices, length, Vec::new())))
            }
            FieldKind::Tuple(kinds, _) => {
                let mut parts = Vec::new();
                for (k, kind) in kinds.iter().enumerate() {
                    let k = proc_macro2::Literal::usize_unsuffixed(k);
                    let id = self.tables.suffixed(id, quote!(.#k), false);
                    parts.push(self.entry(id, kind, indices.clone(), at)?);
                }
                Some(Value::tuple(parts))
            }
            FieldKind::Other(ty) => {
                let name = self.tables.name(id);
                self.refuse(expressions::field_type(at, &name, ty))
            }
        }
    }

    /// An index that is certainly out of range is a mistake; others are checked when a stepper is made.
    fn check_range(&mut self, array: &Array, k: &Index, at: &dyn ToTokens) -> Option<()> {
        if let (Some(k), Some(length)) = (k.as_integer(), array.length.as_integer()) {
            if (0..length).contains(&k) {
                return Some(());
            }
            return self.refuse(expressions::index_out_of_range(at, k, length));
        }
        if self.bounded(|bounds| bounds.is_below(k, &array.length)) {
            return Some(());
        }
        let error = match self.bounded(|bounds| bounds.outlier(k, Some(&array.length))) {
            None => return Some(()),
            Some(Outlier::Negative(value)) => expressions::index_negative(at, &self.display(k), value),
            Some(Outlier::Beyond(excess)) => {
                expressions::index_beyond(at, &self.display(k), &self.display(&array.length), excess)
            }
        };
        // If no condition guards the index, the mistake is certain for every value of loop variables.
        if self.now.branch == 0 { self.refuse_at_once(error) } else { self.refuse(error) }
    }

    /// `list[start..end]` of a stored list.
    pub(super) fn subarray(
        &mut self,
        array: &Array,
        start: &Index,
        end: Option<&Index>,
        at: &dyn ToTokens,
    ) -> Option<Value> {
        let end = end.unwrap_or(&array.length);
        let length = end.subtract(start)?;
        let rest = array.length.subtract(end)?.as_integer();
        let is_negative = |number: Option<i128>| number.is_some_and(|number| number < 0);
        if is_negative(rest) || is_negative(start.as_integer()) || is_negative(length.as_integer()) {
            let error = match (end.as_integer(), array.length.as_integer()) {
                (Some(end), Some(length)) => expressions::index_out_of_range(at, end, length),
                _ => expressions::index_beyond(at, &self.display(end), &self.display(&array.length), 0),
            };
            return self.refuse(error);
        }
        Some(list(Array { start: array.start.add(start)?, length, ..array.clone() }))
    }

    /// The variable at `slot`, one per slot.
    pub(super) fn local(&mut self, slot: Slot) -> Expr {
        let symbol = self.symbols.local(&mut self.graph, slot, self.tables.as_list());
        self.graph.symbol(symbol)
    }

    /// An index as text.
    pub(super) fn display(&self, index: &Index) -> String {
        self.symbols.reader(self.tables.as_list(), |names| names.index(index))
    }

    pub(super) fn index(&mut self, syntax: &'a ExprIndex) -> Option<Value> {
        let base = self.evaluate(&syntax.expr);
        let index = self.evaluate(&syntax.index);
        let at = &*syntax.index;
        match (base.known()?, index.known()?) {
            (Value::Sequence(list), Value::Sequence(range)) => self.slice_of_list(&list, &range, at),
            (Value::Sequence(list), index) => {
                let k = self.as_index(&index, at)?;
                self.item(&list, &k, at)
            }
            (Value::Constant(place), index) => {
                let k = self.known_integer(index, at)?;
                self.constant_element(&place, k, at)
            }
            (base, _) => self.mismatch(&syntax.expr, "a list", &base),
        }
    }

    /// `list[range]`
    fn slice_of_list(&mut self, list: &Sequence, range: &Sequence, at: &dyn ToTokens) -> Option<Value> {
        let Source::Range(start, end) = &range.source else {
            return self.refuse(expressions::expected(at, "an integer or a range", range.describe()));
        };
        if let Source::Array(array) = &list.source {
            return self.subarray(array, start, end.as_ref(), at);
        }
        let items = self.items(list, at)?;
        let length = items.len() as i128;
        let start = self.known_integer(Value::index(start.clone()), at)?;
        let end = match end {
            Some(end) => self.known_integer(Value::index(end.clone()), at)?,
            None => length,
        };
        match (usize::try_from(start), usize::try_from(end)) {
            (Ok(start), Ok(end)) if start <= end && end <= items.len() => {
                Some(Value::list(items[start..end].to_vec()))
            }
            _ => self.refuse(expressions::index_out_of_range(at, end, items.len())),
        }
    }

    /// Element `k` of a constant, which is a list if it can be indexed.
    fn constant_element(&mut self, place: &Place, k: i128, at: &dyn ToTokens) -> Option<Value> {
        let Ok(k) = usize::try_from(k) else {
            return self.refuse(expressions::index_out_of_range(at, k, 0));
        };
        let (tokens, literal) = (&place.tokens, proc_macro2::Literal::usize_unsuffixed(k));
        let (name, tokens) = (format!("{}[{k}]", place.name), quote! { #tokens[#literal] });
        Some(Value::Constant(Place::new(name, tokens, FieldKind::Constant).into()))
    }

    pub(super) fn range(&mut self, syntax: &'a ExprRange) -> Option<Value> {
        let mut is_unsigned = false;
        let mut bound = |bound: &'a Option<Box<Syntax>>| match bound {
            Some(bound) => {
                let value = self.evaluate(bound);
                is_unsigned |= matches!(value, Value::Index(_, true));
                self.checked_index(&value, bound).map(Some)
            }
            None => Some(None),
        };
        let (start, end) = (bound(&syntax.start), bound(&syntax.end));
        let start = start?.unwrap_or_default();
        let inclusive = i128::from(matches!(syntax.limits, RangeLimits::Closed(_)));
        let range = match end?.map(|end| end.shifted(inclusive)) {
            Some(None) => None,
            end => Sequence::range(start, end.flatten(), is_unsigned),
        };
        match range {
            Some(range) => Some(Value::sequence(range)),
            None => self.refuse(expressions::integer_arithmetic(syntax)),
        }
    }
}

fn list(array: Array) -> Value {
    Value::sequence(Sequence::array(array))
}
