//! One element in its loops, with loop-invariant values hoisted. [`Chunk`] is the innermost one. Tests:
//! `tests/loops`.

use std::collections::HashMap;

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::Derivative;
use super::chunk::{Chunk, EmittedLoop, InnerLoop, gathers, open_lists, partners};
use super::weighted::{ElementEmitter, Outputs, Weight};
use crate::diagnostics::promised;
use crate::discretise::{Weighted, family_of};
use crate::emit::{Level, Lowering, Namer, Op, Printer, Rank, count, parameter_names};
use crate::indices::{Indices, variable};
use crate::model::{Atom, Half, Index, Loop, System};
use crate::symbolic::{Expr, Symbol};

/// The target of a computed value.
#[derive(Clone)]
pub(super) enum Target {
    /// The value itself, times a factor.
    Value { factor: Option<TokenStream> },
    /// `sum += value`
    Total { sum: Ident },
    /// `vector[index] += value`
    Gradient { vector: Ident, index: Index },
    /// `into(by, [row, column], is_alone, value)`, where both variables of a pair may coincide.
    Hessian { by: Ident, row: Index, column: Index, is_alone: bool },
    /// `into.value(constraint, value)`, or `into.rate(constraint, value)`.
    Constraint { method: Ident, constraint: Index },
    /// `into.slope(constraint, coordinate, value)`
    Slope { constraint: Index, coordinate: Index },
}

impl Target {
    /// The sum of the values of elements.
    pub(super) fn total() -> Self {
        Self::Total { sum: format_ident!("__total") }
    }

    /// The target of the slope by the place `index` of a half of the state.
    pub(super) fn gradient(half: Half, index: Index) -> Self {
        let by = if half == Half::Momenta { "p" } else { "q" };
        Self::Gradient { vector: format_ident!("__by_{by}"), index }
    }
}

/// The arithmetic of one placement of an element.
pub(super) struct Arithmetic {
    /// Values independent of the state, computed before the loops.
    before: TokenStream,
    pub(super) inside: TokenStream,
    /// One for each output.
    pub(super) values: Vec<TokenStream>,
    /// The names of the local variables.
    pub(super) locals: Vec<Ident>,
    /// Names of values that no loop changes.
    pub(super) constants: Vec<Ident>,
}

impl ElementEmitter<'_> {
    /// The loops of an element around the computation of its nonzero `outputs`.
    pub(super) fn computed(
        &mut self,
        weighted: &Weighted,
        weight: Weight<'_>,
        outputs: Outputs,
    ) -> TokenStream {
        let Outputs { mut values, definitions } = outputs;
        values.retain(|(value, _)| !self.model.graph.is_zero(*value));
        if values.is_empty() {
            return TokenStream::new();
        }
        let arithmetic = self.arithmetic(weighted, weight, &values, definitions);
        self.in_loops(weighted, weight, &values, &arithmetic)
    }

    fn arithmetic(
        &mut self,
        weighted: &Weighted,
        weight: Weight<'_>,
        outputs: &[(Expr, Target)],
        definitions: HashMap<Symbol, Expr>,
    ) -> Arithmetic {
        let System { graph, parameters, t, scale, tables, components, .. } = &mut *self.model;
        let element = &weighted.element;
        let mut taken = Namer::default();
        let own = parameter_names(&mut taken, graph, parameters);
        let slots = element.locals.iter().map(|local| graph.symbol_name(local.symbol));
        let locals = taken.take_all(slots);
        let symbols = element.locals.iter().map(|local| local.symbol);
        let factor = weight.map(|(symbol, _)| (symbol, format_ident!("__factor")));
        let of_state = symbols.zip(locals.iter().cloned()).chain(factor);
        let of_time = [(*t, format_ident!("__t"))].into_iter();
        let of_time = of_time.chain(scale.map(|scale| (scale, format_ident!("__scale"))));
        let of_system = parameters.iter().map(|parameter| parameter.symbol).zip(own);
        let of_state = of_state.map(|named| (named, Level::State));
        let of_time = of_time.map(|named| (named, Level::Time));
        let of_system = of_system.map(|named| (named, Level::Prepared));
        let mut lowering = Lowering::new(graph, definitions);
        let inputs = of_state.chain(of_time).chain(of_system);
        let inputs: Vec<(Op, Ident)> =
            inputs.map(|((symbol, name), level)| (lowering.input(symbol, level), name)).collect();
        let ops: Vec<Op> = outputs.iter().map(|&(root, _)| lowering.lower(root)).collect();
        let program = &lowering.program;
        let (uses, hints) = (program.uses(&ops), HashMap::new());
        let number = self.derivative.number();
        let printer = Printer::new(program, number.clone(), &hints, taken);
        let is_fixed = |op: Op| program.level(op) < Level::Increments;
        let own: Vec<Op> = inputs.iter().map(|(op, _)| *op).filter(|&op| is_fixed(op)).collect();
        let mut printer = printer.with_constants(&own, quote!(#number::Constant));
        inputs.into_iter().for_each(|(op, name)| printer.set(op, name));
        // In functions of their own, all constants are numbers.
        let is_apart = self.derivative == Derivative::Gradient
            && (partners(weighted, &Indices::unchecked(tables), *components).is_some() && !is_total(outputs)
                || gathers(graph, element, outputs, *components));
        let mut fixed =
            program.frontier(&ops, &|op| is_fixed(op) && !(is_apart && program.operation(op).is_truth()));
        fixed.retain(|&op| printer.rank(op) == Rank::Constant);
        let before = printer.lift(&fixed);
        let constants = fixed.iter().filter_map(|&op| printer.bound(op).cloned()).collect();
        let inside = printer.bind(&ops, &uses, &|_| false);
        let value = |(&op, (_, target)): (&Op, &(Expr, Target))| match target {
            Target::Value { factor: Some(_) } => printer.scalar_factor(op),
            _ => printer.scalar_value(op),
        };
        let values = ops.iter().zip(outputs).map(value).collect();
        Arithmetic { before, inside, values, locals, constants }
    }

    fn in_loops(
        &self,
        weighted: &Weighted,
        weight: Weight<'_>,
        outputs: &[(Expr, Target)],
        arithmetic: &Arithmetic,
    ) -> TokenStream {
        let loops = &weighted.element.loops;
        // If the innermost loop runs over the members of a family, its increments change with
        // the loop.
        let is_own = |inner: &Loop| weighted.increments.iter().any(|k| k.loops().contains(&inner.variable));
        let bound = weight.map(|(_, weight)| quote!(let __factor = #weight;));
        let (fixed_weight, own_weight) =
            if loops.last().is_some_and(is_own) { (None, bound) } else { (bound, None) };
        let EmittedLoop { buffers, body, after } =
            self.innermost(weighted, &quote!(#own_weight), outputs, arithmetic);
        let outer = loops.split_last().map_or(&[][..], |(_, outer)| outer);
        let mut nest = quote! { #fixed_weight #body };
        for (depth, known) in outer.iter().enumerate().rev() {
            let (name, [start, end]) = (variable(known.variable), self.range_of(weighted, known));
            // Literals alone have no type.
            let is_typed = !known.start.terms.is_empty() || self.is_acting(weighted, known);
            let start = if is_typed { start } else { quote!(#start as __wzvi::isize) };
            let range = match (depth, self.derivative == Derivative::Gradient) {
                (0, true) => {
                    let (number, sums) = (count(known.variable as usize), written(outputs));
                    quote!(#sums.outer(#number, #start..#end))
                }
                _ => quote!(#start..#end),
            };
            nest = quote! {
                for #name in #range {
                    #nest
                }
            };
        }
        let before = &arithmetic.before;
        quote!(#before #buffers #nest #after)
    }

    /// The innermost loop: in rows of pairs, in lanes of gathered placements where the sums allow it, or in
    /// chunks.
    fn innermost(
        &self,
        weighted: &Weighted,
        weight: &TokenStream,
        outputs: &[(Expr, Target)],
        arithmetic: &Arithmetic,
    ) -> EmittedLoop {
        let (element, System { graph, tables, components, .. }) = (&weighted.element, &*self.model);
        let (inner, indices) = (element.loops.last(), Indices::unchecked(tables));
        let inner_loop =
            InnerLoop { variable: inner.map_or(u32::MAX, |known| known.variable), components: *components };
        let fixed = inner.filter(|known| !self.is_acting(weighted, known));
        let chunk = Chunk {
            indices,
            element,
            inner: inner_loop,
            range: inner.map(|known| self.range_of(weighted, known)),
            start: fixed.map(|known| known.start.clone()),
            outputs,
            arithmetic,
            weight,
            has_tiles: self.model.degrees_in_straight_lines().is_none(),
            derivative: self.derivative,
            gathered: None,
        };
        if self.derivative != Derivative::Gradient {
            return chunk.emit();
        }
        if let Some(first) = partners(weighted, &indices, *components)
            && !is_total(outputs)
        {
            return chunk.row(&first);
        }
        match &chunk.range {
            Some([start, end]) if gathers(graph, element, outputs, *components) => {
                let (one_by_one, sums) = (chunk.emit().body, written(outputs));
                let gathered = Chunk { gathered: Some(&open_lists(element, tables)), ..chunk.clone() };
                let EmittedLoop { buffers, body, after } = gathered.emit();
                let body = quote! {
                    if #sums.gathers(#start, #end) {
                        #body
                    } else {
                        #one_by_one
                    }
                };
                EmittedLoop { buffers, body, after }
            }
            _ => chunk.emit(),
        }
    }

    /// Whether a loop runs over the active members of a family of noises.
    fn is_acting(&self, weighted: &Weighted, known: &Loop) -> bool {
        !matches!(self.derivative, Derivative::Hessian | Derivative::Rows)
            && family_of(weighted) == Some(known.variable)
    }

    /// The start and the end of a loop.
    fn range_of(&self, weighted: &Weighted, known: &Loop) -> [TokenStream; 2] {
        let indices = Indices::unchecked(&self.model.tables);
        if !self.is_acting(weighted, known) {
            return [indices.sum(&known.start), indices.sum(&known.end)];
        }
        let [start, end] = [indices.value(&known.start), indices.value(&known.end)];
        let number = weighted.increments.first().cloned().unwrap_or_default();
        let before = number.subtract(&Index::atom(Atom::Loop(known.variable)));
        let before = promised(before, "the number of a member is an offset and its own number");
        let own = |number: TokenStream| match before == Index::default() {
            true => quote!(#number as __wzvi::isize),
            false => {
                let before = indices.value(&before);
                quote!(#number as __wzvi::isize - #before)
            }
        };
        let (first, last) = (own(quote!(__at.acting.start)), own(quote!(__at.acting.end)));
        [quote!(__wzvi::Ord::max(#start, #first)), quote!(__wzvi::Ord::min(#end, #last))]
    }
}

/// Whether outputs are terms of collective variables.
pub(super) fn is_total(outputs: &[(Expr, Target)]) -> bool {
    outputs.iter().any(|(_, target)| matches!(target, Target::Total { .. }))
}

/// The vector of slopes that an element adds to; either, if it adds to both or to none.
pub(super) fn written(outputs: &[(Expr, Target)]) -> TokenStream {
    let vector = outputs.iter().find_map(|(_, target)| match target {
        Target::Gradient { vector, .. } => Some(quote!(#vector)),
        _ => None,
    });
    vector.unwrap_or_else(|| quote!(__by_q))
}
