//! Systems whose sites are not coupled: the step of one site as straight-line code, and a loop of the run time around it.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::discretized::Road;
use super::indices::{Indices, variable};
use super::sizes;
use crate::discretise::Scheme;
use crate::discretise::equations::{Equations, MomentumUpdate};
use crate::discretise::facts::Facts;
use crate::discretise::sites::{Entry, Increment, Site};
use crate::discretise::structure::{Block, Solution};
use crate::elements::plan::Unknowns;
use crate::emit::step::{self, Kernel, mentions};
use crate::emit::{count, f64_type};
use crate::model::{Slot, System};
use crate::symbolic::{Expr, Graph, Node};

/// How an entry of a field is read at a site: that of the nearest site where it is not there.
pub(crate) fn site_entry(system: &System, site: &Site, entry: &Entry) -> TokenStream {
    let (indices, f64) = (Indices::unchecked(&system.tables), f64_type());
    let value = match &entry.slot {
        Slot::Entry(table, at) => indices.entry(*table, at),
        Slot::Number(index) | Slot::State(_, index) => {
            let value = indices.value(index);
            quote!((#value as __wzvi::isize as #f64))
        }
    };
    let Some((first, end)) = &entry.exists else { return value };
    let (own, first, end) = (variable(site.variable), indices.value(first), indices.value(end));
    let isize = quote!(__wzvi::isize);
    quote! {
        match (#first as #isize, #end as #isize) {
            (__first, __end) if __first < __end => {
                let #own = __wzvi::Ord::clamp(#own, __first, __end - 1);
                #value
            }
            _ => 1.0,
        }
    }
}

/// Whether the step is arithmetic alone, without iterations: then it has the same bits in lanes, and no memory.
fn is_exact_in_lanes(graph: &Graph, scheme: &Scheme) -> bool {
    let is_iterated = |block: &Block| matches!(block.solution, Solution::Newton { .. });
    let Equations { phi_u, phi_v, update } = &scheme.equations;
    let updates = update.iter().filter_map(|update| match update {
        MomentumUpdate::Multiple(_) => None,
        MomentumUpdate::Sum(rest) => Some(*rest),
    });
    let roots: Vec<Expr> = phi_u.iter().chain(phi_v).copied().chain(updates).collect();
    let is_arithmetic = |&expr: &Expr| match graph.node(expr) {
        Node::Apply(..) => false,
        Node::Product(factors) => factors.iter().all(|(_, exponent)| exponent.is_integer()),
        _ => true,
    };
    !scheme.structure.blocks.iter().any(is_iterated) && graph.reachable(&roots).iter().all(is_arithmetic)
}

pub(super) fn emit(system: &mut System, facts: &Facts, site: &Site, scheme: &Scheme) -> Road {
    let kernel = site.with_model(system, site_entry, |model| Kernel::new(model, facts, scheme));
    let indices = Indices::unchecked(&system.tables);
    let own = variable(site.variable);
    let option = quote!(__wzvi::Option);
    let increments = site.increments().map(|Increment { number, acts }| {
        let number = indices.position(number);
        match acts {
            None => quote!(__wzvi::Some(#number)),
            Some((first, end)) => {
                let (first, end) = (indices.value(first), indices.value(end));
                quote!(if #own >= #first && #own < #end { __wzvi::Some(#number) } else { __wzvi::None })
            }
        }
    });
    let increments: Vec<TokenStream> = increments.collect();
    let (degrees, noises) = (count(scheme.lagrangian.symbols.u.len()), count(increments.len()));
    let is_uniform = site.entries.is_empty();
    let is_exact = is_exact_in_lanes(&system.graph, scheme);
    let all = match scheme.lagrangian.symbols.u.len() {
        1 => quote!(__sites),
        _ => quote!((__sites * #degrees)),
    };
    let opened = |code: &TokenStream| {
        let size = mentions(code, "__size").then(|| sizes(system, &all));
        let own = mentions(code, &own.to_string()).then(|| quote!(let #own = __site as __wzvi::isize;));
        quote!(#own #size)
    };
    let embedding = scheme.embedding.path(&quote!(__wzvi));
    let name = &system.item.ident;
    let (generics, arguments, filter) = system.item.generics.split_for_impl();
    let (f64, usize) = (f64_type(), quote!(__wzvi::usize));
    let (result, sites) = (quote!(__wzvi::Result), quote!(__wzvi::elements::sites));
    let solve = kernel.call(
        [&quote!(__S), &f64, &quote!(__C), &quote!(__CAREFUL)],
        ["prepared", "t", "h", "q", "p", "dw", "memory", "carry"].map(|name| {
            let name = format_ident!("__{name}");
            quote!(#name)
        }),
    );
    let Kernel { items, prepare, momentum_factors, .. } = kernel;
    let [opened_for_prepare, opened_for_increments] = [&prepare, &quote!(#(#increments)*)].map(opened);
    let items = quote! {
        #items

        #[automatically_derived]
        impl #generics #sites::Sites<#embedding, #degrees, #noises> for #name #arguments #filter {
            const IS_UNIFORM: __wzvi::bool = #is_uniform;
            const IS_EXACT_IN_LANES: __wzvi::bool = #is_exact;
            type SitePrepared = __Prepared<#f64>;
            type SiteMemory<__S: __wzvi::Scalar> = __Memory<__S>;

            fn prepare_site(
                &self,
                __h: #f64,
                __site: #usize,
                __sites: #usize,
            ) -> #result<__Prepared<#f64>, __wzvi::ConfigError> {
                #opened_for_prepare
                #prepare
            }

            #[inline(always)]
            fn increments(&self, __site: #usize, __sites: #usize) -> [#option<#usize>; #noises] {
                #opened_for_increments
                [#(#increments),*]
            }

            #[inline(always)]
            fn solve_site<__S: __wzvi::Scalar, __C: __wzvi::Carry<__S>, const __CAREFUL: __wzvi::bool>(
                __prepared: &__Prepared<#f64>,
                __t: #f64,
                __h: #f64,
                __q: [__S; #degrees],
                __p: [__S; #degrees],
                __dw: [__S; #noises],
                __memory: &mut __Memory<__S>,
                __carry: &__C,
            ) -> #result<__wzvi::Solution<__S, #degrees>, __wzvi::StepFailure> {
                let mut __next = __wzvi::Solution::nowhere();
                #solve?;
                __wzvi::Ok(__next)
            }
        }
    };
    let momentum = match momentum_factors {
        Some(factors) => {
            let factors = factors.into_iter().map(Literal::f64_unsuffixed);
            quote!(#sites::step_momentum(&__before.p, &__after.p, [#(#factors),*]))
        }
        None => quote!(__wzvi::elements::step_momentum(self, &__SCHEME, __before, __after, __h, __dw)),
    };
    Road {
        items,
        plan: step::plan(facts, scheme),
        unknowns: Unknowns::Both,
        is_linear: false,
        in_lanes: !system.noise.is_empty(),
        prepared: quote!(#sites::Prepared<__Prepared<#f64>>),
        memory: quote!(#sites::Memory<__S, __Memory<__S>, __Prepared<#f64>>),
        new_memory: quote!(#sites::Memory::new(self, #degrees)),
        prepare: quote!(#sites::prepare::<_, #embedding, #degrees, #noises>(self, __h)),
        inline: quote!(#[inline(always)]),
        advance: quote! {
            #sites::advance::<_, #embedding, __S, __C, __CAREFUL, #degrees, #noises>(
                self, __prepared, __t, __h, __q, __p, __dw, __memory, __carry,
            )
        },
        advance_vectors: None,
        momentum,
    }
}
