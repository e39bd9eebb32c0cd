//! Systems whose sites are not coupled: the step of one site as straight-line code, and a loop of the run time around it.

use proc_macro2::TokenStream;
use quote::quote;

use super::discretized::Road;
use super::indices::{Indices, variable};
use super::sizes;
use crate::discretise::Scheme;
use crate::discretise::equations::{Equations, MomentumUpdate};
use crate::discretise::facts::Facts;
use crate::discretise::sites::{Entry, Increment, Site};
use crate::discretise::structure::{Block, Solution};
use crate::elements::plan::Unknowns;
use crate::emit::step::{self, Kernel};
use crate::emit::{embedding_type, f64_type};
use crate::model::{Slot, System};
use crate::symbolic::{Expr, Graph, Node};

/// How an entry of a field is read at a site: that of the nearest site where it is not there.
pub(crate) fn site_entry(system: &System, site: &Site, entry: &Entry) -> TokenStream {
    let (indices, f64) = (Indices { tables: &system.tables, checked: false }, f64_type());
    let value = match &entry.slot {
        Slot::Entry(table, at) => indices.entry(*table, at),
        Slot::Number(index) | Slot::Coordinate(index) | Slot::Momentum(index) => {
            let value = indices.value(index);
            quote!((#value as __wzvi::core::primitive::isize as #f64))
        }
    };
    let Some((first, end)) = &entry.exists else { return value };
    let (own, first, end) = (variable(site.variable), indices.value(first), indices.value(end));
    let isize = quote!(__wzvi::core::primitive::isize);
    quote! {
        match (#first as #isize, #end as #isize) {
            (__first, __end) if __first < __end => {
                let #own = __wzvi::core::cmp::Ord::clamp(#own, __first, __end - 1);
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
    let Kernel { items, prepare, momentum_factors, .. } =
        site.with_model(system, site_entry, |model| Kernel::new(model, facts, scheme));
    let indices = Indices { tables: &system.tables, checked: false };
    let own = variable(site.variable);
    let option = quote!(__wzvi::core::option::Option);
    let increments = site.increments().map(|Increment { number, acts }| {
        let number = indices.position(number);
        match acts {
            None => quote!(#option::Some(#number)),
            Some((first, end)) => {
                let (first, end) = (indices.value(first), indices.value(end));
                quote!(if #own >= #first && #own < #end { #option::Some(#number) } else { #option::None })
            }
        }
    });
    let increments: Vec<TokenStream> = increments.collect();
    let (degrees, noises) = (scheme.lagrangian.symbols.u.len(), increments.len());
    let is_uniform = site.entries.is_empty();
    let is_exact = is_exact_in_lanes(&system.graph, scheme);
    let size = sizes(system, &quote!((__sites * #degrees)));
    let embedding = embedding_type(&scheme.embedding, &quote!(__wzvi));
    let name = &system.item.ident;
    let (generics, arguments, filter) = system.item.generics.split_for_impl();
    let (f64, usize, isize) =
        (f64_type(), quote!(__wzvi::core::primitive::usize), quote!(__wzvi::core::primitive::isize));
    let (result, sites) = (quote!(__wzvi::core::result::Result), quote!(__wzvi::elements::sites));
    let placed = quote!(#sites::Sites<#embedding, #degrees, #noises>);
    let items = quote! {
        #items

        #[automatically_derived]
        impl #generics #placed for #name #arguments #filter {
            const IS_UNIFORM: __wzvi::core::primitive::bool = #is_uniform;
            const IS_EXACT_IN_LANES: __wzvi::core::primitive::bool = #is_exact;
            type SitePrepared = __Prepared;
            type SiteMemory<__S: __wzvi::Scalar> = __Memory<__S>;

            fn prepare_site(
                &self,
                __h: #f64,
                __site: #usize,
                __sites: #usize,
            ) -> #result<__Prepared, __wzvi::ConfigError> {
                let #own = __site as #isize;
                #size
                #prepare
            }

            #[inline(always)]
            fn increments(&self, __site: #usize, __sites: #usize) -> [#option<#usize>; #noises] {
                let #own = __site as #isize;
                #size
                [#(#increments),*]
            }

            #[inline(always)]
            fn solve_site<
                __S: __wzvi::Scalar,
                __C: __wzvi::Carry<__S>,
                const __CAREFUL: __wzvi::core::primitive::bool,
            >(
                __prepared: &__Prepared,
                __t: #f64,
                __h: #f64,
                __q: [__S; #degrees],
                __p: [__S; #degrees],
                __dw: [__S; #noises],
                __memory: &mut __Memory<__S>,
                __carry: &__C,
            ) -> #result<__wzvi::Solution<__S, #degrees>, __wzvi::StepFailure> {
                __solve::<__S, __C, __CAREFUL>(__prepared, __t, __h, __q, __p, __dw, __memory, __carry)
            }
        }
    };
    let step = quote! {
        type Prepared = #sites::Prepared<__Prepared>;
        type Memory<__S: __wzvi::Scalar> = #sites::Memory<__S, __Memory<__S>, __Prepared>;

        fn memory(&self) -> Self::Memory<#f64> {
            #sites::Memory::new(self, #degrees)
        }

        fn prepare(&self, __h: #f64) -> #result<Self::Prepared, __wzvi::ConfigError> {
            #sites::prepare::<_, #embedding, #degrees, #noises>(self, __h)
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
        ) -> #result<__wzvi::Effort, __wzvi::StepFailure> {
            #sites::advance::<_, #embedding, __S, __C, __CAREFUL, #degrees, #noises>(
                self, __prepared, __t, __h, __q, __p, __dw, __memory, __carry,
            )
        }
    };
    let momentum = match momentum_factors {
        Some(factors) => quote!(#sites::step_momentum(&__before.p, &__after.p, [#(#factors),*])),
        None => quote!(__wzvi::elements::step_momentum(self, &__SCHEME, __before, __after, __h, __dw)),
    };
    Road {
        items,
        plan: step::plan(facts, scheme),
        unknowns: Unknowns::Both,
        is_linear: false,
        in_lanes: !system.noise.is_empty(),
        step,
        momentum,
    }
}
