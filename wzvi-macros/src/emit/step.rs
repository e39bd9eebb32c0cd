//! `impl Discretized<E>`: what is prepared once, the step, the discrete Lagrangian and the plan.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::embedding_type;
use super::lagrangian;
use super::plan::Plan;
use super::print::{Printer, f64_type};
use super::program::{Level, Op, Program};
use super::system::indexed;
use crate::discretise::Scheme;
use crate::discretise::facts::{Facts, NoiseClass};
use crate::discretise::structure::Solution;
use crate::model::Model;

mod flow;

use flow::{Flow, Solve};

/// A step as code that reads no system but what is prepared of it.
pub(crate) struct Kernel {
    /// `__Prepared`, `__Memory<__S>` and the function `__solve`.
    pub(crate) items: TokenStream,
    /// The body of a method that makes a `__Prepared` of `self` and `__h`.
    pub(crate) prepare: TokenStream,
    /// `(P - p_i) / (p_{i+1} - p_i)` of each degree of freedom, if that is a number.
    pub(crate) momentum_factors: Option<Vec<f64>>,
    affords_compensation: bool,
}

impl Kernel {
    pub(crate) fn new(model: &mut Model, facts: &Facts, scheme: &Scheme) -> Self {
        let flow = Flow::new(&mut model.graph, &model.parameters, scheme, facts.noise == NoiseClass::None);
        let step = Step::new(&flow, scheme);
        let (prepared_type, memory_type) = (step.prepared_type(), step.memory_type());
        let (prepare, solve) = (step.prepare(model), step.solve());
        let items = quote! {
            type __Prepared = #prepared_type;
            type __Memory<__S> = #memory_type;

            #solve
        };
        Self {
            items,
            prepare,
            momentum_factors: flow.momentum_factors(scheme),
            affords_compensation: flow.affords_compensation(),
        }
    }
}

/// The implementation of one scheme.
pub(crate) fn emit(model: &mut Model, facts: &Facts, scheme: &Scheme, text: &str) -> TokenStream {
    let lagrangian = lagrangian::emit(model, scheme);
    let plan = plan(facts, scheme);
    let kernel = Kernel::new(model, facts, scheme);
    let momentum = momentum(&kernel, scheme);
    let Kernel { items, prepare, affords_compensation, .. } = kernel;
    let carry = if affords_compensation { quote!(Self::Compensated<__S>) } else { quote!(__wzvi::Plain) };

    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let embedding = embedding_type(&scheme.embedding, &quote!(__wzvi));
    let f64 = f64_type();
    let d = scheme.lagrangian.symbols.u.len();
    let noises = scheme.lagrangian.symbols.dw.len();
    quote! {
        const _: () = {
            #items

            #[automatically_derived]
            impl #generics __wzvi::Discretized<#embedding> for #name #arguments #filter {
                const PLAN: __wzvi::Plan = #plan;
                const EQUATIONS: &'static __wzvi::core::primitive::str = #text;
                type Prepared = __Prepared;
                type Memory<__S: __wzvi::Scalar> = __Memory<__S>;
                type Compensated<__S: __wzvi::Scalar> = __wzvi::Compensation<__S, #d>;
                type Carry<__S: __wzvi::Scalar> = #carry;

                fn prepare(
                    &self,
                    __h: #f64,
                ) -> __wzvi::core::result::Result<Self::Prepared, __wzvi::ConfigError> {
                    #prepare
                }

                #[inline(always)]
                fn advance_carrying<
                    __S: __wzvi::Scalar,
                    __C: __wzvi::Carry<__S>,
                    const __CAREFUL: __wzvi::core::primitive::bool,
                >(
                    &self,
                    __prepared: &Self::Prepared,
                    __t: #f64,
                    __h: #f64,
                    __q: &mut [__S],
                    __p: &mut [__S],
                    __dw: &[__S],
                    __memory: &mut Self::Memory<__S>,
                    __carry: &mut __C,
                ) -> __wzvi::core::result::Result<__wzvi::Effort, __wzvi::StepFailure> {
                    let __q = __wzvi::array_mut::<__S, #d>(__q)?;
                    let __p = __wzvi::array_mut::<__S, #d>(__p)?;
                    let __dw = __wzvi::increments::<__S, #noises>(__dw)?;
                    let __next = __solve::<__S, __C, __CAREFUL>(
                        __prepared, __t, __h, *__q, *__p, __dw, __memory, __carry,
                    )?;
                    __wzvi::core::result::Result::Ok(__next.store(__q, __p, __carry))
                }

                #lagrangian

                #momentum
            }
        };
    }
}

/// `step_momentum`: `P = p_i + (p_{i+1} - p_i) / factor` where the update is a multiple of `v`, else from the step.
fn momentum(kernel: &Kernel, scheme: &Scheme) -> TokenStream {
    let f64 = f64_type();
    let signature = quote! {
        fn step_momentum(
            &self,
            __before: &__wzvi::State<Self::Vector>,
            __after: &__wzvi::State<Self::Vector>,
            __h: #f64,
            __dw: &[#f64],
        ) -> Self::Vector
    };
    if let Some(factors) = &kernel.momentum_factors {
        let components = factors
            .iter()
            .enumerate()
            .map(|(i, factor)| quote!(__before.p[#i] + (__after.p[#i] - __before.p[#i]) * #factor));
        return quote!(#signature { __wzvi::core::convert::From::from([#(#components),*]) });
    }
    let noises = scheme.lagrangian.symbols.dw.len();
    let embedding = embedding_type(&scheme.embedding, &quote!(__wzvi));
    quote! {
        #signature {
            let __solved = __wzvi::increments::<#f64, #noises>(__dw).and_then(|__dw| {
                let __prepared = <Self as __wzvi::Discretized<#embedding>>::prepare(self, __h)
                    .map_err(|_| __wzvi::StepFailure::NonFinite)?;
                let (__q, __p) = (__wzvi::core::convert::Into::into(__before.q), __wzvi::core::convert::Into::into(__before.p));
                let mut __memory = __wzvi::core::default::Default::default();
                __solve::<#f64, __wzvi::Plain, true>(
                    &__prepared, __before.t, __h, __q, __p, __dw, &mut __memory, &__wzvi::Plain,
                )
            });
            match __solved {
                __wzvi::core::result::Result::Ok(__solved) => __wzvi::core::convert::From::from(__solved.momentum),
                __wzvi::core::result::Result::Err(_) => __wzvi::SVector::repeat(#f64::NAN),
            }
        }
    }
}

/// `PLAN` of a step that is solved block by block.
pub(crate) fn plan(facts: &Facts, scheme: &Scheme) -> TokenStream {
    let hardest = scheme.structure.blocks.iter().map(|block| match block.solution {
        Solution::Assigned | Solution::Isolated(_) => 0,
        Solution::Linear { .. } => 1,
        Solution::Newton { .. } => 2,
    });
    let solver = match hardest.max() {
        Some(2) => quote!(Newton),
        Some(1) => quote!(Linear),
        _ => quote!(Explicit),
    };
    let unknowns = scheme.structure.unknowns();
    Plan {
        solver,
        unknowns: quote!(#unknowns),
        order: scheme.embedding.order(),
        noise: facts.noise,
        consistent: scheme.consistent,
        conserves_energy: &facts.conserves_energy,
        commuting: &facts.commuting,
    }
    .emit()
}

/// One step as tokens.
struct Step<'f> {
    flow: &'f Flow,
    scheme: &'f Scheme,
    /// Numbers of level `Prepared` that the step reads.
    constants: Vec<Op>,
    /// Truths of level `Prepared` that the step reads.
    truths: Vec<Op>,
}

impl<'f> Step<'f> {
    fn new(flow: &'f Flow, scheme: &'f Scheme) -> Self {
        let is_truth = |&op: &Op| flow.program.operation(op).is_truth();
        let (truths, constants) = flow.constants().into_iter().partition(is_truth);
        Self { flow, scheme, constants, truths }
    }

    /// `[f64; constants]`, with one factor per matrix that never changes, then `[bool; truths]` if there are any.
    fn prepared_type(&self) -> TokenStream {
        let (f64, count) = (f64_type(), self.constants.len());
        let factors = self.flow.solves.iter().filter_map(|solve| match solve {
            Solve::Factored { matrix, .. } => {
                let n = matrix.len();
                Some(quote!(__wzvi::Factor<#f64, #n>))
            }
            _ => None,
        });
        let truths = self.truths.len();
        let truths = (truths > 0).then(|| quote!([__wzvi::core::primitive::bool; #truths]));
        quote!(([#f64; #count], #(#factors,)* #truths))
    }

    /// One extrapolation per Newton block.
    fn memory_type(&self) -> TokenStream {
        let sizes = self.flow.newton_sizes();
        match sizes.is_empty() {
            // The parameter of the alias must be used.
            true => quote!(__wzvi::core::marker::PhantomData<__S>),
            false => tuple(sizes.iter().map(|size| quote!(__wzvi::Extrapolation<__S, #size>)).collect()),
        }
    }

    fn prepare(&self, model: &Model) -> TokenStream {
        let flow = self.flow;
        let f64 = f64_type();
        let mut printer = Printer::new(&flow.program, f64.clone(), &flow.hints);
        printer.set(flow.h, format_ident!("__h"));
        let mut statements = TokenStream::new();
        let mut read = Vec::new();
        let read_by_step: Vec<Op> = self.constants.iter().chain(&self.truths).copied().collect();
        let wanted = flow.prepared_roots(&read_by_step);
        let used = flow.program.uses(&wanted);
        for (i, (op, parameter)) in flow.parameters.iter().zip(&model.parameters).enumerate() {
            if used[*op] > 0 {
                let (name, tokens) = (format_ident!("__a{i}"), &parameter.tokens);
                statements.extend(quote!(let #name: #f64 = #tokens;));
                printer.set(*op, name.clone());
                read.push(name);
            }
        }
        if !read.is_empty() {
            statements.extend(quote! {
                if #(#read.is_nan())||* {
                    return __wzvi::core::result::Result::Err(__wzvi::ConfigError::Parameter);
                }
            });
        }
        let mut factors = Vec::new();
        for (i, solve) in flow.solves.iter().enumerate() {
            match solve {
                Solve::Inverted { pivot, inverse } => {
                    statements.extend(printer.bind(&[*pivot], &used, &|_| false));
                    let (name, value) = (printer.name(*inverse), printer.value(*pivot));
                    statements
                        .extend(quote!(let #name = __wzvi::prepared(__h, __wzvi::reciprocal(#value))?;));
                }
                Solve::Factored { matrix, .. } => {
                    let entries: Vec<Op> = matrix.iter().flatten().copied().collect();
                    statements.extend(printer.bind(&entries, &used, &|_| false));
                    let rows = rows(&printer, matrix);
                    let name = format_ident!("__factor{i}");
                    statements.extend(
                        quote!(let #name = __wzvi::prepared(__h, __wzvi::Factor::new([#(#rows),*]))?;),
                    );
                    factors.push(name);
                }
                _ => {}
            }
        }
        statements.extend(printer.bind(&read_by_step, &used, &|_| false));
        let constants = self.constants.iter().map(|&op| printer.value(op));
        let truths = self.truths.iter().map(|&op| printer.value(op));
        let truths = (!self.truths.is_empty()).then(|| quote!([#(#truths),*]));
        quote! {
            #statements
            __wzvi::core::result::Result::Ok(([#(#constants),*], #(#factors,)* #truths))
        }
    }

    fn solve(&self) -> TokenStream {
        let flow = self.flow;
        let symbols = &self.scheme.lagrangian.symbols;
        let (d, noises) = (symbols.u.len(), symbols.dw.len());
        let f64 = f64_type();
        let mut printer = Printer::new(&flow.program, quote!(__S), &flow.hints);
        printer.set(flow.h, format_ident!("__h"));
        printer.set(flow.t, format_ident!("__t"));
        let (q, p, dw) = (indexed("q", d), indexed("p", d), indexed("dw", noises));
        for (ops, names) in [(&flow.q0, &q), (&flow.p0, &p), (&flow.dw, &dw)] {
            for (&op, name) in ops.iter().zip(names) {
                printer.set(op, name.clone());
            }
        }
        let constants: Vec<Ident> = indexed("c", self.constants.len());
        for (&op, name) in self.constants.iter().zip(&constants) {
            printer.set(op, name.clone());
        }
        let open =
            if constants.is_empty() { quote!() } else { quote!(let [#(#constants),*] = __prepared.0;) };
        let truths: Vec<Ident> = indexed("b", self.truths.len());
        for (&op, name) in self.truths.iter().zip(&truths) {
            printer.set(op, name.clone());
        }
        let factors = flow.solves.iter().filter(|solve| matches!(solve, Solve::Factored { .. })).count();
        let last = proc_macro2::Literal::usize_unsuffixed(factors + 1);
        let truths = (!truths.is_empty()).then(|| quote!(let [#(#truths),*] = __prepared.#last;));
        let uses = flow.program.uses(&flow.roots());
        let (functions, body) =
            SolveBody { flow, uses, printer, records: Vec::new(), functions: TokenStream::new() }.emit();
        quote! {
            #functions

            #[inline(always)]
            fn __solve<
                __S: __wzvi::Scalar,
                __C: __wzvi::Carry<__S>,
                const __CAREFUL: __wzvi::core::primitive::bool,
            >(
                __prepared: &__Prepared,
                __t: #f64,
                __h: #f64,
                [#(#q),*]: [__S; #d],
                [#(#p),*]: [__S; #d],
                [#(#dw),*]: [__S; #noises],
                __memory: &mut __Memory<__S>,
                __carry: &__C,
            ) -> __wzvi::core::result::Result<__wzvi::Solution<__S, #d>, __wzvi::StepFailure> {
                #open
                #truths
                #body
            }
        }
    }
}

fn rows(printer: &Printer<'_>, matrix: &[Vec<Op>]) -> Vec<TokenStream> {
    matrix
        .iter()
        .map(|row| {
            let entries = row.iter().map(|&entry| printer.scalar_value(entry));
            quote!([#(#entries),*])
        })
        .collect()
}

/// The values that the equations of a block read besides its unknowns, by type: numbers and truths of the state, numbers
/// and truths that the state does not enter.
struct Given {
    numbers: Vec<Ident>,
    masks: Vec<Ident>,
    constants: Vec<Ident>,
    truths: Vec<Ident>,
}

impl Given {
    fn new(program: &Program, printer: &Printer<'_>, roots: &[Op], unknowns: &[Op]) -> Self {
        let mut read: Vec<Op> = program
            .needed(roots, &|op| printer.is_bound(op))
            .into_iter()
            .filter(|&op| !printer.is_bound(op))
            .flat_map(|op| program.operation(op).operands())
            .chain(roots.iter().copied())
            .filter(|op| !unknowns.contains(op))
            .collect();
        read.sort_unstable();
        read.dedup();
        let mut given =
            Self { numbers: Vec::new(), masks: Vec::new(), constants: Vec::new(), truths: Vec::new() };
        for op in read {
            let Some(name) = printer.bound(op) else { continue };
            let list = match (program.level(op) >= Level::Increments, program.operation(op).is_truth()) {
                (true, false) => &mut given.numbers,
                (true, true) => &mut given.masks,
                (false, false) => &mut given.constants,
                (false, true) => &mut given.truths,
            };
            list.push(name.clone());
        }
        given
    }

    fn lengths(&self) -> [usize; 4] {
        [&self.numbers, &self.masks, &self.constants, &self.truths].map(Vec::len)
    }

    /// The type for numbers `__S`.
    fn types(&self) -> TokenStream {
        let ([numbers, masks, constants, truths], f64) = (self.lengths(), f64_type());
        let bool = quote!(__wzvi::core::primitive::bool);
        quote!(([__S; #numbers], [__S::Mask; #masks], [#f64; #constants], [#bool; #truths]))
    }

    /// The type for one lane.
    fn types_of_one(&self) -> TokenStream {
        let ([numbers, masks, constants, truths], f64) = (self.lengths(), f64_type());
        let bool = quote!(__wzvi::core::primitive::bool);
        quote!(([#f64; #numbers], [#bool; #masks], [#f64; #constants], [#bool; #truths]))
    }

    fn patterns(&self) -> TokenStream {
        let Self { numbers, masks, constants, truths } = self;
        quote!(([#(#numbers),*], [#(#masks),*], [#(#constants),*], [#(#truths),*]))
    }

    fn of_lane(&self) -> TokenStream {
        let Self { numbers, masks, constants, truths } = self;
        quote!((
            [#(__wzvi::Scalar::lane(#numbers, __lane)),*],
            [#(__wzvi::Mask::lane(#masks, __lane)),*],
            [#(#constants),*],
            [#(#truths),*],
        ))
    }

    /// What is given has no error in the equations that it makes.
    fn lifted(&self) -> TokenStream {
        let Self { numbers, masks, constants, truths } = self;
        quote!((
            [#(__wzvi::Rounded::exact(#numbers)),*],
            [#(#masks),*],
            [#(#constants),*],
            [#(#truths),*],
        ))
    }
}

/// The standard library knows tuples of up to so many parts.
const PARTS: usize = 12;

/// A tuple of any number of types, in tuples of tuples.
fn tuple(types: Vec<TokenStream>) -> TokenStream {
    if types.len() <= PARTS {
        return quote!((#(#types,)*));
    }
    tuple(types.chunks(PARTS).map(|part| tuple(part.to_vec())).collect())
}

/// `.0.3`: part `index` of a [`tuple`] of `count` types.
fn place_in_tuple(index: usize, count: usize) -> TokenStream {
    let digit = proc_macro2::Literal::usize_unsuffixed(index % PARTS);
    let outer = if count <= PARTS {
        TokenStream::new()
    } else {
        place_in_tuple(index / PARTS, count.div_ceil(PARTS))
    };
    quote!(#outer . #digit)
}

/// The statements of a step, block by block.
struct SolveBody<'f> {
    flow: &'f Flow,
    uses: Vec<u32>,
    printer: Printer<'f>,
    /// `memory.i.record(solution)`, done only if the whole step succeeds.
    records: Vec<TokenStream>,
    /// The equations of each Newton block.
    functions: TokenStream,
}

impl SolveBody<'_> {
    /// The functions that the step calls, and its statements.
    fn emit(mut self) -> (TokenStream, TokenStream) {
        let mut statements = TokenStream::new();
        let mut counts = Vec::new();
        let mut factors = 0_usize;
        for (i, solve) in self.flow.solves.iter().enumerate() {
            match solve {
                Solve::Inverted { .. } => {}
                Solve::Reciprocal { pivot, inverse, is_safe } => {
                    statements.extend(self.bind(&[*pivot]));
                    let (value, name) = (self.printer.scalar_value(*pivot), self.printer.name(*inverse));
                    statements.extend(match is_safe {
                        true => quote!(let #name = __wzvi::reciprocal_above_one::<__S>(#value);),
                        false => quote!(let #name = __wzvi::reciprocal::<__S>(#value)?;),
                    });
                }
                Solve::Divided { pivot, rhs, unknown } => {
                    statements.extend(self.bind(&[*pivot, *rhs]));
                    let (rhs, pivot) = (self.printer.scalar_value(*rhs), self.printer.scalar_value(*pivot));
                    let name = self.printer.name(*unknown);
                    statements.extend(quote!(let #name = __wzvi::quotient::<__S>(#rhs, #pivot)?;));
                }
                Solve::Factored { rhs, unknowns, .. } => {
                    factors += 1;
                    let index = proc_macro2::Literal::usize_unsuffixed(factors);
                    statements.extend(self.bind(rhs));
                    let rhs: Vec<_> = rhs.iter().map(|&op| self.printer.scalar_value(op)).collect();
                    let names: Vec<_> = unknowns.iter().map(|&op| self.printer.name(op)).collect();
                    statements
                        .extend(quote!(let [#(#names),*] = __prepared.#index.apply::<__S>([#(#rhs),*]);));
                }
                Solve::Linear { matrix, rhs, unknowns } => {
                    let entries: Vec<Op> = matrix.iter().flatten().chain(rhs).copied().collect();
                    statements.extend(self.bind(&entries));
                    let rows = rows(&self.printer, matrix);
                    let rhs: Vec<_> = rhs.iter().map(|&op| self.printer.scalar_value(op)).collect();
                    let names: Vec<_> = unknowns.iter().map(|&op| self.printer.name(op)).collect();
                    statements.extend(quote! {
                        let [#(#names),*] = __wzvi::linear::<__S, _>([#(#rows),*], [#(#rhs),*])?;
                    });
                }
                Solve::Newton { .. } => {
                    let count = format_ident!("__effort{i}");
                    statements.extend(self.newton(solve, &count));
                    counts.push(count);
                }
            }
        }
        statements.extend(self.finish(&counts));
        (self.functions, statements)
    }

    fn bind(&mut self, roots: &[Op]) -> TokenStream {
        self.printer.bind(roots, &self.uses, &|_| false)
    }

    /// What does not read the iterates is computed before the iteration, once.
    fn newton(&mut self, solve: &Solve, count: &Ident) -> TokenStream {
        let Solve::Newton { residual, jacobian, unknowns, symmetric } = solve else {
            return TokenStream::new();
        };
        let program = &self.flow.program;
        let roots: Vec<Op> = residual.iter().chain(jacobian.iter().flatten()).copied().collect();
        let readers = program.readers_of(unknowns);
        let outer: Vec<Op> = program
            .needed(&roots, &|op| !readers[op])
            .into_iter()
            .flat_map(|op| program.operation(op).operands())
            .chain(roots.iter().copied())
            .filter(|&op| !readers[op] && !program.operation(op).is_trivial())
            .collect();
        let statements = self.printer.bind(&outer, &self.uses, &|op| outer.contains(&op));

        let mut inner = self.printer.clone();
        let names: Vec<Ident> = unknowns.iter().map(|&op| inner.name(op)).collect();
        let given = Given::new(program, &inner, &roots, unknowns);
        let inner_uses = program.uses(&roots);
        let shared = inner.bind(&roots, &inner_uses, &|_| false);
        let values: Vec<TokenStream> = residual.iter().map(|&op| inner.scalar_value(op)).collect();
        let rows = rows(&inner, jacobian);
        let (n, index) = (names.len(), self.records.len());
        let (equations, rounded) = (format_ident!("__equations{index}"), format_ident!("__rounded{index}"));
        let (types, patterns, lifted) = (given.types(), given.patterns(), given.lifted());
        let (passed, by_lane) = (given.patterns(), given.of_lane());
        let (types_of_one, f64) = (given.types_of_one(), f64_type());
        self.functions.extend(quote! {
            /// The equations of a block, and their Jacobian by rows.
            #[inline(always)]
            fn #equations<__S: __wzvi::Scalar>(
                #patterns: #types,
                [#(#names),*]: [__S; #n],
            ) -> ([__S; #n], [[__S; #n]; #n]) {
                #shared
                ([#(#values),*], [#(#rows),*])
            }

            /// The equations of a block at all numbers that round to `__x`.
            #[cold]
            #[inline(never)]
            fn #rounded(#patterns: #types_of_one, __x: [#f64; #n]) -> [__wzvi::Rounded; #n] {
                #equations::<__wzvi::Rounded>(#lifted, __x.map(__wzvi::Rounded::nearest)).0
            }
        });
        let used = self.uses_memory();
        let place = place_in_tuple(index, self.flow.newton_sizes().len());
        self.records.push(quote!(__memory #place.record::<#used>([#(#names),*]);));
        for (&op, name) in unknowns.iter().zip(&names) {
            self.printer.set(op, name.clone());
        }
        quote! {
            #statements
            let ([#(#names),*], #count) = __wzvi::newton::<__S, #n, #symmetric, #used, __CAREFUL>(
                __memory #place.guess::<#used>(),
                __wzvi::Block {
                    evaluate: move |__x: &[__S; #n]| #equations::<__S>(#passed, *__x),
                    rounded: move |__x: &[__S; #n], __lane: __wzvi::core::primitive::usize| {
                        #rounded(#by_lane, __x.map(|__x| __wzvi::Scalar::lane(__x, __lane)))
                    },
                },
            )?;
        }
    }

    /// Without noise the last steps are extrapolated; with it the increments decide, and zero is as good a start, but
    /// where a solution is followed along its step.
    fn uses_memory(&self) -> TokenStream {
        if self.flow.is_deterministic { quote!(true) } else { quote!(__CAREFUL) }
    }

    fn finish(&mut self, counts: &[Ident]) -> TokenStream {
        let flow = self.flow;
        let roots: Vec<Op> = flow.dq.iter().chain(&flow.dp).chain(&flow.momentum).copied().collect();
        let statements = self.bind(&roots);
        let values = |ops: &[Op]| -> Vec<TokenStream> {
            ops.iter().map(|&op| self.printer.scalar_value(op)).collect()
        };
        let (q, p) = (values(&flow.q0), values(&flow.p0));
        let (dq, dp, momentum) = (values(&flow.dq), values(&flow.dp), values(&flow.momentum));
        let isolated = flow.isolated.iter().map(|&inverse| {
            let inverse = self.printer.scalar_value(inverse);
            quote!(__wzvi::Effort::isolated::<__S, __CAREFUL>(#inverse))
        });
        let counts = counts.iter().map(|count| quote!(#count)).chain(isolated);
        let effort = quote!(__wzvi::Effort::fast(0) #(+ #counts)*);
        let records = &self.records;
        quote! {
            #statements
            let __next = __wzvi::Solution::new(
                __carry,
                [[#(#q),*], [#(#p),*]],
                [[#(#dq),*], [#(#dp),*]],
                [#(#momentum),*],
                #effort,
            );
            if !__next.is_finite() {
                return __wzvi::core::result::Result::Err(__wzvi::StepFailure::NonFinite);
            }
            #(#records)*
            __wzvi::core::result::Result::Ok(__next)
        }
    }
}
