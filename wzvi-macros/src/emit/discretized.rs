//! `impl Discretized<E>`: the signatures, around whatever takes the steps.

use proc_macro2::TokenStream;
use quote::quote;

use super::f64_type;
use crate::embedding::Embedding;

/// Steps of systems beside each other.
pub(crate) struct Beside {
    /// The type of what they read, of `__L` systems.
    pub(crate) ty: TokenStream,
    /// The bodies of `beside` and `advance_beside`.
    pub(crate) make: TokenStream,
    pub(crate) advance: TokenStream,
}

/// One scheme of a system as code. Bodies read the parameters of their methods by the names that these have here.
pub(crate) struct Discretized<'a> {
    pub(crate) item: &'a syn::ItemStruct,
    pub(crate) embedding: &'a Embedding,
    /// `EQUATIONS`
    pub(crate) text: &'a str,
    /// What stands beside the implementation: `__SCHEME`, and what else the bodies name.
    pub(crate) items: TokenStream,
    /// Constants that differ from those of the trait.
    pub(crate) constants: TokenStream,
    pub(crate) plan: TokenStream,
    /// The types, the last three for numbers `__S`.
    pub(crate) prepared: TokenStream,
    /// How systems go beside each other, if they do.
    pub(crate) beside: Option<Beside>,
    pub(crate) memory: TokenStream,
    pub(crate) compensated: TokenStream,
    pub(crate) carry: TokenStream,
    /// The body of `memory`, if that of the trait is not enough.
    pub(crate) new_memory: Option<TokenStream>,
    /// The bodies, by method.
    pub(crate) prepare: TokenStream,
    pub(crate) inline: TokenStream,
    pub(crate) advance: TokenStream,
    /// The body of `advance_vectors`, if that of the trait is not enough.
    pub(crate) advance_vectors: Option<TokenStream>,
}

impl Discretized<'_> {
    pub(crate) fn emit(&self) -> TokenStream {
        let Self {
            item, embedding, text, items, constants, plan, prepared, memory, compensated, carry, ..
        } = self;
        let Self { prepare, inline, advance, .. } = self;
        let name = &item.ident;
        let (generics, arguments, filter) = item.generics.split_for_impl();
        let (scheme, f64) = (embedding.path(&quote!(__wzvi)), f64_type());
        let new_memory = self.new_memory.as_ref().map(|body| {
            quote! {
                fn memory(&self) -> Self::Memory<#f64> {
                    #body
                }
            }
        });
        let advance_vectors = self.advance_vectors.as_ref().map(|body| {
            quote! {
                #[inline(always)]
                fn advance_vectors<__C: __wzvi::Carry<#f64>, const __CAREFUL: __wzvi::bool>(
                    &self,
                    __prepared: &Self::Prepared,
                    __t: #f64,
                    __h: #f64,
                    __q: &mut Self::Vector,
                    __p: &mut Self::Vector,
                    __dw: &[#f64],
                    __memory: &mut Self::Memory<#f64>,
                    __carry: &mut __C,
                ) -> __wzvi::Result<__wzvi::Effort, __wzvi::StepFailure> {
                    #body
                }
            }
        });
        // Other schemes keep what the trait says.
        let kept = match &embedding.points()[0] {
            points if !points.is_single() => Some(quote!(Nearly)),
            points if embedding.order() == 1 => {
                let l = points.mean().to_f64();
                Some(quote!(Point(#l)))
            }
            _ => None,
        };
        let kept =
            kept.map(|kept| quote!(const KEPT_ENERGY: __wzvi::KeptEnergy = __wzvi::KeptEnergy::#kept;));
        let beside = match &self.beside {
            Some(beside) => beside.emit(),
            None => quote!(__wzvi::apart!(Self);),
        };
        quote! {
            const _: () = {
                #items

                #[automatically_derived]
                impl #generics __wzvi::Discretized<#scheme> for #name #arguments #filter {
                    const PLAN: __wzvi::Plan = #plan;
                    const EQUATIONS: &'static __wzvi::str = #text;
                    #kept
                    #constants
                    type Prepared = #prepared;
                    type Memory<__S: __wzvi::Scalar> = #memory;
                    type Compensated<__S: __wzvi::Scalar> = #compensated;
                    type Carry<__S: __wzvi::Scalar> = #carry;

                    #new_memory

                    fn prepare(&self, __h: #f64) -> __wzvi::Result<Self::Prepared, __wzvi::ConfigError> {
                        #prepare
                    }

                    #inline
                    fn advance_carrying<__S: __wzvi::Scalar, __C: __wzvi::Carry<__S>, const __CAREFUL: __wzvi::bool>(
                        &self,
                        __prepared: &Self::Prepared,
                        __t: #f64,
                        __h: #f64,
                        __q: &mut [__S],
                        __p: &mut [__S],
                        __dw: &[__S],
                        __memory: &mut Self::Memory<__S>,
                        __carry: &mut __C,
                    ) -> __wzvi::Result<__wzvi::Effort, __wzvi::StepFailure> {
                        #advance
                    }

                    #advance_vectors

                    #beside

                    __wzvi::lagrangian!(__SCHEME);
                }
            };
        }
    }
}

impl Beside {
    fn emit(&self) -> TokenStream {
        let Self { ty, make, advance } = self;
        let (f64, lanes, usize) = (f64_type(), quote!(__wzvi::Lanes<__L>), quote!(__wzvi::usize));
        quote! {
            type Beside<const __L: #usize> = #ty;

            fn beside<const __L: #usize>(
                __systems: [&Self; __L],
                __prepared: [&Self::Prepared; __L],
            ) -> __wzvi::Option<Self::Beside<__L>> {
                #make
            }

            #[inline(always)]
            fn advance_beside<const __L: #usize>(
                __beside: &Self::Beside<__L>,
                __t: #f64,
                __h: #f64,
                __q: &mut [#lanes],
                __p: &mut [#lanes],
                __dw: &[#lanes],
                __memory: &mut Self::Memory<#lanes>,
            ) -> __wzvi::Result<__wzvi::Effort, __wzvi::StepFailure> {
                #advance
            }
        }
    }
}
