//! The statements of a step, block by block, as a function of numbers: `__solve`.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::flow::{Flow, Solve};
use super::given::Given;
use super::memory::part;
use super::prepare::{Prepared, rows};
use crate::emit::Printer;
use crate::emit::names::Names;
use crate::emit::program::Op;
use crate::emit::system::count;

/// What the arguments of a step are called.
pub(super) struct Arguments {
    pub(super) q: Vec<Ident>,
    pub(super) p: Vec<Ident>,
    pub(super) dw: Vec<Ident>,
}

/// The equations of the Newton blocks, and the statements.
pub(super) struct Solution {
    pub(super) functions: TokenStream,
    pub(super) statements: TokenStream,
}

/// Prints all blocks.
pub(super) fn solution(
    flow: &Flow,
    prepared: &Prepared,
    Arguments { q, p, dw }: &Arguments,
    names: Names,
) -> Solution {
    let made = prepared.constants.iter().chain(&prepared.truths).map(|(op, _)| *op);
    let constants: Vec<Op> = made.chain([flow.h, flow.t]).collect();
    let mut printer =
        Printer::new(&flow.program, quote!(__S), &flow.hints, names).with_constants(&constants, quote!(__K));
    printer.set(flow.h, format_ident!("__h"));
    printer.set(flow.t, format_ident!("__t"));
    for (ops, names) in [(&flow.q0, q), (&flow.p0, p), (&flow.dw, dw)] {
        for (&op, name) in ops.iter().zip(names) {
            printer.set(op, name.clone());
        }
    }
    for (op, name) in prepared.constants.iter().chain(&prepared.truths) {
        printer.set(*op, name.clone());
    }
    let uses = flow.program.uses(&flow.roots());
    let factors = prepared.factors.iter().map(|(_, name)| name.clone()).collect();
    let mut body =
        SolveBody { flow, uses, printer, factors, records: Vec::new(), functions: TokenStream::new() };
    let statements = body.emit();
    Solution { functions: body.functions, statements }
}

struct SolveBody<'f> {
    flow: &'f Flow,
    uses: Vec<u32>,
    printer: Printer<'f>,
    /// Those of the matrices that never change, in their order.
    factors: Vec<Ident>,
    /// `memory.i.record_where(taken, solution)`, of the paths of which the whole step succeeds.
    records: Vec<TokenStream>,
    /// The equations of each Newton block.
    functions: TokenStream,
}

impl SolveBody<'_> {
    fn emit(&mut self) -> TokenStream {
        let mut statements = TokenStream::new();
        let mut efforts = Vec::new();
        let mut factors = self.factors.clone().into_iter();
        let flow = self.flow;
        for solve in &flow.solves {
            statements.extend(match solve {
                Solve::Inverted { .. } => TokenStream::new(),
                Solve::Reciprocal { pivot, inverse, is_safe } => self.reciprocal(*pivot, *inverse, *is_safe),
                Solve::Divided { pivot, rhs, unknown } => {
                    let shared = self.bind(&[*pivot, *rhs]);
                    let (rhs, pivot) = (self.printer.scalar_value(*rhs), self.printer.scalar_value(*pivot));
                    let name = self.printer.name(*unknown);
                    quote!(#shared let #name = __wzvi::quotient::<__S>(#rhs, #pivot)?;)
                }
                Solve::Factored { rhs, unknowns, .. } => {
                    let shared = self.bind(rhs);
                    let (factor, rhs) = (factors.next(), self.values(rhs));
                    let names = self.names(unknowns);
                    quote! {
                        #shared
                        let [#(#names),*] = <__S as __wzvi::Over<__K>>::solve_factored(#factor, [#(#rhs),*]);
                    }
                }
                Solve::Linear { matrix, rhs, unknowns } => {
                    let entries: Vec<Op> = matrix.iter().flatten().chain(rhs).copied().collect();
                    let shared = self.bind(&entries);
                    let (rows, rhs) =
                        (rows(matrix, |entry| self.printer.scalar_value(entry)), self.values(rhs));
                    let names = self.names(unknowns);
                    quote!(#shared let [#(#names),*] = __wzvi::linear::<__S, _>([#(#rows),*], [#(#rhs),*])?;)
                }
                Solve::Newton { residual, jacobian, unknowns, symmetric } => {
                    let (code, effort) = self.newton(residual, jacobian, unknowns, *symmetric);
                    efforts.push(quote!(#effort));
                    code
                }
            });
        }
        statements.extend(self.finish(efforts));
        statements
    }

    fn bind(&mut self, roots: &[Op]) -> TokenStream {
        self.printer.bind(roots, &self.uses, &|_| false)
    }

    fn values(&self, ops: &[Op]) -> Vec<TokenStream> {
        ops.iter().map(|&op| self.printer.scalar_value(op)).collect()
    }

    fn names(&mut self, ops: &[Op]) -> Vec<Ident> {
        ops.iter().map(|&op| self.printer.name(op)).collect()
    }

    fn reciprocal(&mut self, pivot: Op, inverse: Op, is_safe: bool) -> TokenStream {
        let shared = self.bind(&[pivot]);
        let (value, name) = (self.printer.scalar_value(pivot), self.printer.name(inverse));
        match is_safe {
            true => quote!(#shared let #name = __wzvi::reciprocal_above_one::<__S>(#value);),
            false => quote!(#shared let #name = __wzvi::reciprocal::<__S>(#value)?;),
        }
    }

    /// What does not read the iterates is computed before the iteration, once. Returns what was spent, too.
    fn newton(
        &mut self,
        residual: &[Op],
        jacobian: &[Vec<Op>],
        unknowns: &[Op],
        symmetric: bool,
    ) -> (TokenStream, Ident) {
        let program = &self.flow.program;
        let roots: Vec<Op> = residual.iter().chain(jacobian.iter().flatten()).copied().collect();
        let readers = program.readers_of(unknowns);
        let mut outer = program.frontier(&roots, &|op| !readers[op]);
        outer.retain(|&op| !program.operation(op).is_trivial());
        let statements = self.printer.bind(&outer, &self.uses, &|op| outer.contains(&op));

        let names = self.names(unknowns);
        let given = Given::new(program, &self.printer, &roots, unknowns);
        let equations = self.equations(&given, &names, &roots, residual, jacobian);
        let used = self.uses_memory();
        let memory = part(self.records.len(), self.flow.newton_sizes().len());
        self.records.push(quote!(#memory.record_where::<#used>(__taken, [#(#names),*]);));
        let (given, effort) = (given.tokens(), self.printer.other("effort"));
        let code = quote! {
            #statements
            use __wzvi::Block as _;
            let mut __unknowns = #memory.guess::<#used>();
            let #effort =
                #equations::newton::<__S, __K, #symmetric, #used, __CAREFUL>(#given, &mut __unknowns)?;
            let [#(#names),*] = __unknowns;
        };
        (code, effort)
    }

    /// Adds the equations of a block; returns the type that has them.
    fn equations(
        &mut self,
        given: &Given,
        names: &[Ident],
        roots: &[Op],
        residual: &[Op],
        jacobian: &[Vec<Op>],
    ) -> Ident {
        let mut inner = self.printer.clone();
        let shared = inner.bind(roots, &self.flow.program.uses(roots), &|_| false);
        let values: Vec<TokenStream> = residual.iter().map(|&op| inner.scalar_value(op)).collect();
        let rows = rows(jacobian, |entry| inner.scalar_value(entry));
        let name = match self.flow.newton_sizes().len() {
            1 => format_ident!("__Equations"),
            _ => format_ident!("__Equations{}", self.records.len()),
        };
        let (n, lengths, given) = (count(names.len()), given.lengths(), given.tokens());
        self.functions.extend(quote! {
            /// The equations of a block, and their Jacobian by rows.
            struct #name;

            impl __wzvi::Block<#(#lengths),*, #n> for #name {
                #[cfg_attr(not(debug_assertions), inline(always))]
                fn equations<__S: __wzvi::Over<__K>, __K: __wzvi::Constant>(
                    #given: __wzvi::Inputs<__S, __K, #(#lengths),*>,
                    [#(#names),*]: [__S; #n],
                ) -> ([__S; #n], [[__S; #n]; #n]) {
                    #shared
                    ([#(#values),*], [#(#rows),*])
                }
            }
        });
        name
    }

    /// Without noise the last steps are extrapolated; with it the increments decide, and zero is as good a start, but
    /// where a solution is followed along its step.
    fn uses_memory(&self) -> TokenStream {
        if self.flow.is_deterministic { quote!(true) } else { quote!(__CAREFUL) }
    }

    fn finish(&mut self, efforts: Vec<TokenStream>) -> TokenStream {
        let flow = self.flow;
        let roots: Vec<Op> = flow.dq.iter().chain(&flow.dp).copied().collect();
        let statements = self.bind(&roots);
        let (q, p) = (self.values(&flow.q0), self.values(&flow.p0));
        let (dq, dp) = (self.values(&flow.dq), self.values(&flow.dp));
        let isolated = self.values(&flow.isolated);
        let isolated =
            isolated.iter().map(|inverse| quote!(__wzvi::Effort::isolated::<__S, __CAREFUL>(#inverse)));
        let mut efforts: Vec<TokenStream> = efforts.into_iter().chain(isolated).collect();
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
