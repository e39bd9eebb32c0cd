//! The step of one scheme as straight-line code.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::discretized::{Beside, Discretized};
use super::names::Names;
use super::plan::Plan;
use super::print::f64_type;
use super::system::{Letters, count};
use super::terms;
use crate::discretise::Scheme;
use crate::discretise::facts::{Facts, NoiseClass};
use crate::discretise::structure::Solution;
use crate::elements::plan::{Strategy, Unknowns};
use crate::model::StraightLine;
use crate::symbolic::Graph;

mod flow;
mod given;
mod memory;
mod prepare;
mod solve;

use flow::Flow;
use prepare::Prepared;
use solve::Arguments;

/// A step as code that reads no system but what is prepared of it.
pub(crate) struct Kernel {
    /// `__Prepared<__K>`, `__Memory<__S>` and the function `__solve`.
    pub(crate) items: TokenStream,
    /// The body of a method that makes a `__Prepared` of numbers of `self` and `__h`.
    pub(crate) prepare: TokenStream,
    affords_compensation: bool,
    /// What `__solve` reads of `__t`, `__h`, `__dw` and `__memory`.
    reads: [bool; 4],
}

impl Kernel {
    pub(crate) fn new(graph: &mut Graph, line: &StraightLine, facts: &Facts, scheme: &Scheme) -> Self {
        let flow = Flow::new(graph, &line.parameters, scheme, facts.noise == NoiseClass::None);
        let noises = scheme.lagrangian.symbols.dw.len();
        let Letters { q, p, mut names, .. } = Letters::of_state(graph, line, Names::default());
        let arguments = Arguments { q, p, dw: increment_names(&mut names, noises) };
        let prepared = Prepared::new(&flow, graph, &line.parameters, &mut names);
        let solve::Solution { functions, statements } = solve::solution(&flow, &prepared, &arguments, names);
        let sizes = flow.newton_sizes();
        let reads =
            [mentions(&statements, "__t"), mentions(&statements, "__h"), noises > 0, !sizes.is_empty()];
        let Arguments { q, p, dw } = arguments;
        let (degrees, noises) = (count(q.len()), count(noises));
        let parameters = chosen(
            reads,
            [
                quote!(__t: __wzvi::f64),
                quote!(__h: __wzvi::f64),
                quote!(__dw: [__S; #noises]),
                quote!(__memory: &mut __Memory<__S>),
            ],
        );
        let [t, h, dw_list, memory] = parameters;
        let state = match dw.is_empty() {
            true => quote!(let ([#(#q),*], [#(#p),*]) = (__q, __p);),
            false => quote!(let ([#(#q),*], [#(#p),*], [#(#dw),*]) = (__q, __p, __dw);),
        };
        let (open, prepared_type, memory_type) =
            (prepared.open(), prepared.ty(), memory::memory_type(&sizes));
        let items = quote! {
            type __Prepared<__K> = #prepared_type;
            type __Memory<__S> = #memory_type;

            #functions

            #[inline(always)]
            fn __solve<
                __S: __wzvi::Over<__K>,
                __K: __wzvi::Constant,
                __C: __wzvi::Carry<__S>,
                const __CAREFUL: __wzvi::bool,
            >(
                __prepared: &__Prepared<__K>,
                #t
                #h
                __q: [__S; #degrees],
                __p: [__S; #degrees],
                #dw_list
                #memory
                __carry: &__C,
                __next: &mut __wzvi::Solution<__S, #degrees>,
            ) -> __wzvi::Result<(), __wzvi::StepFailure> {
                #state
                #open
                #statements
            }
        };
        Self { items, prepare: prepared.body, affords_compensation: flow.affords_compensation(), reads }
    }

    /// Whether there is something to iterate on.
    fn is_iterated(&self) -> bool {
        self.reads[3]
    }

    /// A call of `__solve` with arguments of these values, generic parameters first: those of numbers, constants, carry and care.
    pub(crate) fn call(
        &self,
        [number, constant, carried, careful]: [&TokenStream; 4],
        [prepared, t, h, q, p, dw, memory, carry]: [TokenStream; 8],
    ) -> TokenStream {
        let [t, h, dw, memory] = chosen(self.reads, [t, h, dw, memory]);
        quote!(__solve::<#number, #constant, #carried, #careful>(#prepared, #t #h #q, #p, #dw #memory #carry, &mut __next))
    }
}

/// The arguments that are read, each with a comma.
fn chosen(reads: [bool; 4], arguments: [TokenStream; 4]) -> [Option<TokenStream>; 4] {
    let mut reads = reads.into_iter();
    arguments.map(|argument| reads.next().is_some_and(|is_read| is_read).then(|| quote!(#argument,)))
}

/// Whether `name` occurs.
pub(crate) fn mentions(tokens: &TokenStream, name: &str) -> bool {
    tokens.clone().into_iter().any(|token| match token {
        proc_macro2::TokenTree::Ident(ident) => ident == name,
        proc_macro2::TokenTree::Group(group) => mentions(&group.stream(), name),
        _ => false,
    })
}

/// `dw`, or `dw1`, `dw2` as in the equations.
pub(crate) fn increment_names(names: &mut Names, noises: usize) -> Vec<Ident> {
    match noises {
        1 => vec![names.take("dw")],
        _ => names.take_all((1..=noises).map(|k| format!("dw{k}"))),
    }
}

/// The implementation of one scheme.
pub(crate) fn emit(
    item: &syn::ItemStruct,
    (graph, line): (&mut Graph, &StraightLine),
    facts: &Facts,
    scheme: &Scheme,
    text: &str,
) -> TokenStream {
    let plan = plan(facts, scheme);
    let kernel = Kernel::new(graph, line, facts, scheme);
    let advance = advance(&kernel, scheme, [&quote!(__S), &f64_type(), &quote!(__C), &quote!(__CAREFUL)]);
    let beside = Beside {
        ty: quote!(__Prepared<__wzvi::Lanes<__L>>),
        make: quote!(__wzvi::Some(__wzvi::Beside::beside(__prepared))),
        advance: advance_beside(&kernel, scheme),
    };
    let d = count(scheme.lagrangian.symbols.u.len());
    let carry =
        if kernel.affords_compensation { quote!(Self::Compensated<__S>) } else { quote!(__wzvi::Plain) };
    let Kernel { items, prepare, .. } = kernel;
    // Of what is solved in loops only the momentum between two ends, if that.
    let strategy = Strategy { unknowns: Unknowns::Momenta, is_linear: false };
    let data = terms::scheme(facts, &scheme.embedding, strategy, false);
    Discretized {
        item,
        embedding: &scheme.embedding,
        text,
        items: quote!(#data #items),
        constants: TokenStream::new(),
        plan,
        prepared: quote!(__Prepared<__wzvi::f64>),
        beside: Some(beside),
        memory: quote!(__Memory<__S>),
        compensated: quote!(__wzvi::Compensation<__S, #d>),
        carry,
        new_memory: None,
        prepare,
        inline: quote!(#[inline(always)]),
        advance,
        advance_vectors: None,
    }
    .emit()
}

/// The body of `advance_carrying`, or one with other generic parameters of `__solve`.
fn advance(kernel: &Kernel, scheme: &Scheme, generics: [&TokenStream; 4]) -> TokenStream {
    let increments = match scheme.lagrangian.symbols.dw.len() {
        0 => quote!(__wzvi::increments::<_, 0>(__dw)?;),
        _ => quote!(let __dw = __wzvi::increments(__dw)?;),
    };
    let [prepared, t, h, dw, memory, carry] = ["prepared", "t", "h", "dw", "memory", "carry"].map(|name| {
        let name = format_ident!("__{name}");
        quote!(#name)
    });
    let solve = kernel.call(generics, [prepared, t, h, quote!(*__q), quote!(*__p), dw, memory, carry]);
    let store = match kernel.is_iterated() {
        true => quote! {
            let __solved = #solve;
            __next.arrive(__solved, __q, __p, __carry)
        },
        false => quote! {
            #solve?;
            __wzvi::Ok(__next.store(__q, __p, __carry))
        },
    };
    quote! {
        let (__q, __p) = (__wzvi::array_mut(__q)?, __wzvi::array_mut(__p)?);
        #increments
        let mut __next = __wzvi::Solution::nowhere();
        #store
    }
}

/// The body of `advance_beside`.
fn advance_beside(kernel: &Kernel, scheme: &Scheme) -> TokenStream {
    let lanes = quote!(__wzvi::Lanes<__L>);
    let advance = advance(kernel, scheme, [&lanes, &lanes, &quote!(__wzvi::Plain), &quote!(false)]);
    quote! {
        let (__prepared, __carry) = (__beside, &mut __wzvi::Plain);
        #advance
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
    let unknowns = count(scheme.structure.unknowns());
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
