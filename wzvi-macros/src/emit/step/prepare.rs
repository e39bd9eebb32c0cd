//! The values computed once for all steps, and the code that computes them. Tests: `tests/steps/errors.rs`.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::memory::tuple;
use super::step_program::{Method, StepProgram};
use crate::emit::Printer;
use crate::emit::names::Namer;
use crate::emit::program::Op;
use crate::emit::system::{count, parameter_names};
use crate::model::Parameter;
use crate::symbolic::Graph;

/// The parts of `__Prepared` that a step reads, with their names in the step.
pub(super) struct Prepared {
    /// Numbers.
    pub(super) constants: Vec<(Op, Ident)>,
    pub(super) truths: Vec<(Op, Ident)>,
    /// One for each matrix that never changes, with its size.
    pub(super) factors: Vec<(usize, Ident)>,
    /// The method that computes them from `self` and `__h`, in constants `__K`.
    pub(super) method: TokenStream,
}

impl Prepared {
    /// Names the parts as in the step.
    pub(super) fn new(
        step_program: &StepProgram,
        graph: &Graph,
        parameters: &[Parameter],
        names: &mut Namer,
    ) -> Self {
        let is_truth = |&op: &Op| step_program.program.operation(op).is_truth();
        let (truths, constants): (Vec<Op>, Vec<Op>) =
            step_program.constants().into_iter().partition(is_truth);
        let read_by_step: Vec<Op> = constants.iter().chain(&truths).copied().collect();
        let used = step_program.program.uses(&step_program.prepared_roots(&read_by_step));

        let mut own = Namer::default();
        let own_names = parameter_names(&mut own, graph, parameters);
        let inverted = step_program.solves.iter().filter(|solve| solve.method == Method::Inverted);
        let inverses = inverted.map(|solve| solve.unknowns[0]);
        let varied: Vec<Op> =
            step_program.parameters.iter().copied().chain([step_program.h]).chain(inverses).collect();
        let constant = quote!(__K);
        let mut printer = Printer::new(&step_program.program, constant.clone(), &step_program.hints, own)
            .with_constants(&varied, constant);
        printer.set(step_program.h, format_ident!("__h"));
        let mut statements = TokenStream::new();
        let parameters = step_program.parameters.iter().zip(parameters).zip(own_names).enumerate();
        let read: Vec<_> = parameters.filter(|(_, ((op, _), _))| used[**op] > 0).collect();
        for (number, ((op, Parameter { tokens, .. }), name)) in &read {
            let number = count(*number);
            statements.extend(quote!(let #name = __lift(#number, #tokens);));
            printer.set(**op, name.clone());
        }
        if !read.is_empty() {
            let read = read.iter().map(|(_, (_, name))| name);
            statements.extend(quote! {
                if #(#read.magnitude().is_nan())||* {
                    return __wzvi::Err(__wzvi::ConfigError::Parameter);
                }
            });
        }
        let mut factors = Vec::new();
        for solve in step_program.solves.iter().filter(|solve| solve.is_prepared()) {
            statements.extend(printer.bind(&solve.entries(), &used, &|_| false));
            let (name, made) = if solve.method == Method::Inverted {
                let value = printer.constant_value(solve.matrix[0][0]);
                (printer.name(solve.unknowns[0]), quote!(__wzvi::usable::<__K>(#value).map(__K::recip)))
            } else {
                let (name, rows) =
                    (names.take("factor"), rows(&solve.matrix, |entry| printer.constant_value(entry)));
                factors.push((rows.len(), name.clone()));
                (name, quote!(<__K as __wzvi::Constant>::factor([#(#rows),*])))
            };
            statements.extend(quote!(let #name = __wzvi::prepared(__h, #made)?;));
        }
        statements.extend(printer.bind(&read_by_step, &used, &|_| false));
        let [numbers, flags] = [&constants, &truths].map(|ops| {
            let values = ops.iter().map(|&op| printer.constant_value(op));
            quote!([#(#values),*])
        });
        let mut named = |ops: Vec<Op>| -> Vec<(Op, Ident)> {
            ops.into_iter().map(|op| (op, names.take(&printer.wish_or_name(op)))).collect()
        };
        let (constants, truths) = (named(constants), named(truths));
        let mut prepared = Self { constants, truths, factors, method: TokenStream::new() };
        let made = prepared.factors.iter().map(|(_, name)| quote!(#name));
        let value = prepared.tuple_of(numbers, flags, made.collect());
        prepared.method = quote! {
            fn prepare<__K: __wzvi::Constant>(
                &self,
                __lift: __wzvi::LiftParameter<'_, __K>,
                __h: __K,
            ) -> __wzvi::Result<__wzvi::ConstantsIn<Self::Prepared, __K>, __wzvi::ConfigError> {
                #statements
                __wzvi::Ok(#value)
            }
        };
        prepared
    }

    /// The type for constants of any type.
    pub(super) fn ty(&self) -> TokenStream {
        let (constants, truths) = (count(self.constants.len()), count(self.truths.len()));
        let factors = self.factors.iter().map(|(size, _)| {
            let size = count(*size);
            quote!(__wzvi::Factored<#size>)
        });
        let (numbers, flags) = (quote!(__wzvi::Reals<#constants>), quote!(__wzvi::Truths<#truths>));
        self.tuple_of(numbers, flags, factors.collect())
    }

    /// `let` for all parts: numbers by value, factors by reference.
    pub(super) fn open(&self) -> TokenStream {
        let [numbers, flags] = [&self.constants, &self.truths].map(|parts| {
            let names = parts.iter().map(|(_, name)| name);
            quote!([#(#names),*])
        });
        let factors: Vec<TokenStream> = self.factors.iter().map(|(_, name)| quote!(ref #name)).collect();
        let pattern = self.tuple_of(numbers, flags, factors);
        match self.constants.is_empty() && self.truths.is_empty() && self.factors.is_empty() {
            true => TokenStream::new(),
            false => quote!(let #pattern = *__prepared;),
        }
    }

    /// The prepared data as a type, value or pattern: an array of numbers, or, if there are others, a tuple
    /// of numbers, truths and factors.
    fn tuple_of(&self, numbers: TokenStream, flags: TokenStream, factors: Vec<TokenStream>) -> TokenStream {
        if self.truths.is_empty() && factors.is_empty() {
            return numbers;
        }
        let numbers = (!self.constants.is_empty()).then_some(numbers);
        let flags = (!self.truths.is_empty()).then_some(flags);
        tuple(numbers.into_iter().chain(flags).chain(factors).collect())
    }
}

/// A matrix by rows.
pub(super) fn rows(matrix: &[Vec<Op>], value: impl Fn(Op) -> TokenStream) -> Vec<TokenStream> {
    let rows = matrix.iter().map(|row| {
        let entries = row.iter().map(|&entry| value(entry));
        quote!([#(#entries),*])
    });
    rows.collect()
}
