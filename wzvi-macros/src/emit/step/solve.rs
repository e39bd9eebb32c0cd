//! The statements of a step, block by block, as a function of numbers: `__solve`. Tests:
//! `tests/steps/reference.rs`.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::block_inputs::BlockInputs;
use super::memory::memory_of;
use super::prepare::{Prepared, rows};
use super::step_program::{Method, Solve, StepProgram};
use crate::emit::Printer;
use crate::emit::names::Namer;
use crate::emit::program::Op;
use crate::emit::system::count;

/// The equations of the Newton blocks, and the method that solves all blocks, with arguments by the names of
/// `q`, `p` and the increments.
pub(super) fn solution(
    step_program: &StepProgram,
    prepared: &Prepared,
    [q, p, dw]: [Vec<Ident>; 3],
    names: Namer,
) -> [TokenStream; 2] {
    let made = prepared.constants.iter().chain(&prepared.truths).map(|(op, _)| *op);
    let constants: Vec<Op> = made.chain([step_program.h, step_program.t]).collect();
    let mut printer = Printer::new(&step_program.program, quote!(__S), &step_program.hints, names)
        .with_constants(&constants, quote!(__K));
    printer.set(step_program.h, format_ident!("__h"));
    printer.set(step_program.t, format_ident!("__t"));
    let nodes = step_program.nodes.iter().flatten();
    for (&op, name) in nodes.chain(&step_program.dw).zip(q.iter().chain(&p).chain(&dw)) {
        printer.set(op, name.clone());
    }
    for (op, name) in prepared.constants.iter().chain(&prepared.truths) {
        printer.set(*op, name.clone());
    }
    let uses = step_program.program.uses(&step_program.roots());
    let factors: Vec<Ident> = prepared.factors.iter().map(|(_, name)| name.clone()).collect();
    let (efforts, records, functions) = (Vec::new(), Vec::new(), TokenStream::new());
    let mut body =
        SolveBody { step_program, uses, printer, factors: factors.into_iter(), efforts, records, functions };
    let mut statements: TokenStream = step_program.solves.iter().map(|solve| body.solved(solve)).collect();
    statements.extend(body.finish());
    let state = match dw.is_empty() {
        true => quote!(let ([#(#q),*], [#(#p),*]) = (__coordinates, __momenta);),
        false => quote!(let ([#(#q),*], [#(#p),*], [#(#dw),*]) = (__coordinates, __momenta, __increments);),
    };
    let (open, d, n) = (prepared.open(), count(q.len()), count(dw.len()));
    let solve = quote! {
            #[cfg_attr(not(debug_assertions), inline(always))]
            fn solve<
                __S: __wzvi::ComputesWith<__K>,
                __K: __wzvi::Constant,
                __C: __wzvi::StateSum<__S>,
                const __CAREFUL: __wzvi::bool,
            >(
                __prepared: &__wzvi::ConstantsIn<Self::Prepared, __K>,
                __t: __K,
                __h: __K,
                __coordinates: [__S; #d],
                __momenta: [__S; #d],
                __increments: [__S; #n],
                __memory: &mut Self::Memory<__S>,
                __carry: &__C,
                __next: &mut __wzvi::Solution<__S, #d>,
            ) -> __wzvi::Result<(), __wzvi::StepFailure> {
                #state
                #open
                #statements
            }
    };
    [body.functions, solve]
}

struct SolveBody<'f> {
    step_program: &'f StepProgram,
    uses: Vec<u32>,
    printer: Printer<'f>,
    /// The names of the constant matrices, in order.
    factors: std::vec::IntoIter<Ident>,
    /// The effort of each Newton block.
    efforts: Vec<TokenStream>,
    /// `memory.i.record_where(taken, solution)`, for paths whose whole step succeeds.
    records: Vec<TokenStream>,
    /// The equations of each Newton block.
    functions: TokenStream,
}

impl SolveBody<'_> {
    /// The statements of a block.
    fn solved(&mut self, solve: &Solve) -> TokenStream {
        match solve.method {
            Method::Inverted => TokenStream::new(),
            Method::Reciprocal { is_safe: true } => {
                self.linear(solve, |pivot, _| quote!(__wzvi::reciprocal_above_one::<__S>(#(#pivot)*)))
            }
            Method::Reciprocal { is_safe: false } => {
                self.linear(solve, |pivot, _| quote!(__wzvi::usable::<__S>(#(#pivot)*)?.recip()))
            }
            Method::Divided => {
                self.linear(solve, |pivot, rhs| quote!((#(#rhs)*) / __wzvi::usable::<__S>(#(#pivot)*)?))
            }
            Method::Factored => {
                let (factor, over) = (self.factors.next(), quote!(<__S as __wzvi::ComputesWith<__K>>));
                self.linear(solve, |_, rhs| quote!(#over::solve_factored(#factor, [#(#rhs),*])))
            }
            Method::Linear => self.linear(solve, |matrix, rhs| {
                let rows = matrix.chunks(rhs.len()).map(|row| quote!([#(#row),*]));
                quote!(__wzvi::linear::<__S, _>([#(#rows),*], [#(#rhs),*])?)
            }),
            Method::Newton { symmetric } => self.newton(solve, symmetric),
        }
    }

    /// The statements of a block without iteration, given the formula of its unknowns from matrix and right
    /// side.
    fn linear(
        &mut self,
        solve: &Solve,
        made: impl FnOnce(&[TokenStream], &[TokenStream]) -> TokenStream,
    ) -> TokenStream {
        let read = solve.read();
        let (shared, values) = (self.bind(&read), self.values(&read));
        let (matrix, rhs) = values.split_at(values.len() - solve.rhs.len());
        let (made, names) = (made(matrix, rhs), self.names(&solve.unknowns));
        let pattern = if let [only] = names.as_slice() { quote!(#only) } else { quote!([#(#names),*]) };
        quote!(#shared let #pattern = #made;)
    }

    /// `let` statements for shared values, and for those that formulas name, `P`, `Q_l`, `Δq` and `δp`.
    fn bind(&mut self, roots: &[Op]) -> TokenStream {
        let step_program = self.step_program;
        self.printer.bind(roots, &self.uses, &|op| step_program.hints.contains_key(&op))
    }

    fn values(&self, ops: &[Op]) -> Vec<TokenStream> {
        ops.iter().map(|&op| self.printer.scalar_value(op)).collect()
    }

    fn names(&mut self, ops: &[Op]) -> Vec<Ident> {
        ops.iter().map(|&op| self.printer.name(op)).collect()
    }

    /// Values that do not read the iterates are computed once, before the iteration.
    fn newton(&mut self, solve: &Solve, symmetric: bool) -> TokenStream {
        let (program, roots) = (&self.step_program.program, solve.read());
        let readers = program.readers_of(&solve.unknowns);
        let mut outer = program.frontier(&roots, &|op| !readers[op]);
        outer.retain(|&op| !program.operation(op).is_trivial());
        let statements = self.printer.bind(&outer, &self.uses, &|op| outer.contains(&op));

        let names = self.names(&solve.unknowns);
        let inputs = BlockInputs::new(program, &self.printer, &roots, &solve.unknowns);
        let equations = self.equations(&inputs, &names, solve);
        // Without noise the last steps are extrapolated. With noise the increments dominate, and zero is as
        // good a start, except when a solution is followed along its step.
        let used = if self.step_program.is_deterministic { quote!(true) } else { quote!(__CAREFUL) };
        let memory = memory_of(self.records.len(), self.step_program.newton_sizes().len());
        self.records.push(quote!(#memory.record_where::<#used>(__taken, [#(#names),*]);));
        let (inputs, effort) = (inputs.tokens(), self.printer.other("effort"));
        self.efforts.push(quote!(#effort));
        quote! {
            #statements
            use __wzvi::Block as _;
            let mut __unknowns = #memory.guess::<#used>();
            let #effort =
                #equations::newton::<__S, __K, #symmetric, #used, __CAREFUL>(#inputs, &mut __unknowns)?;
            let [#(#names),*] = __unknowns;
        }
    }

    /// Adds the equations of a block; returns the type that has them.
    fn equations(&mut self, inputs: &BlockInputs, names: &[Ident], solve: &Solve) -> Ident {
        let (mut inner, roots) = (self.printer.clone(), solve.read());
        let shared = inner.bind(&roots, &self.step_program.program.uses(&roots), &|_| false);
        let values: Vec<TokenStream> = solve.rhs.iter().map(|&op| inner.scalar_value(op)).collect();
        let rows = rows(&solve.matrix, |entry| inner.scalar_value(entry));
        let name = match self.step_program.newton_sizes().len() {
            1 => format_ident!("__Equations"),
            _ => format_ident!("__Equations{}", self.records.len()),
        };
        let (n, lengths, inputs) = (count(names.len()), inputs.lengths(), inputs.tokens());
        self.functions.extend(quote! {
            /// The equations of a block, and their Jacobian by rows.
            struct #name;

            impl __wzvi::Block<#(#lengths),*, #n> for #name {
                #[cfg_attr(not(debug_assertions), inline(always))]
                fn equations<__S: __wzvi::ComputesWith<__K>, __K: __wzvi::Constant>(
                    #inputs: __wzvi::Inputs<__S, __K, #(#lengths),*>,
                    [#(#names),*]: [__S; #n],
                ) -> ([__S; #n], [[__S; #n]; #n]) {
                    #shared
                    ([#(#values),*], [#(#rows),*])
                }
            }
        });
        name
    }

    fn finish(&mut self) -> TokenStream {
        let step_program = self.step_program;
        let statements = self.bind(&step_program.changes.concat());
        let [q, p] = step_program.nodes.each_ref().map(|nodes| self.values(nodes));
        let [dq, dp] = step_program.changes.each_ref().map(|changes| self.values(changes));
        let isolated = self.values(&step_program.isolated);
        let isolated =
            isolated.iter().map(|inverse| quote!(__wzvi::Effort::isolated::<__S, __CAREFUL>(#inverse)));
        let mut efforts: Vec<TokenStream> = self.efforts.iter().cloned().chain(isolated).collect();
        if efforts.is_empty() {
            efforts.push(quote!(__wzvi::Effort::fast(0)));
        }
        let records = &self.records;
        let end = match records.is_empty() {
            true => quote!(__next.ensure_finite()),
            false => quote! {
                let __taken = __next.are_finite();
                #(#records)*
                __next.ensure_taken(__taken)
            },
        };
        quote! {
            #statements
            *__next = __wzvi::Solution::new(
                __carry,
                [[#(#q),*], [#(#p),*]],
                [[#(#dq),*], [#(#dp),*]],
                #(#efforts)+*,
            );
            #end
        }
    }
}
