//! Stubs after errors: the struct, and implementations that type-check, so that `rustc` does not add "trait
//! not implemented" to the reported errors. Tests: `tests/compiler/ui/fail`.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{ItemStruct, Path};

use crate::input::Declaration;

/// The system, as far as it is known.
pub(crate) struct Stubs {
    item: TokenStream,
    system: Option<(TokenStream, TokenStream)>,
    /// The generic parameters and the scheme of each implementation.
    schemes: Vec<(TokenStream, TokenStream)>,
    crate_path: Option<Path>,
    is_exported: bool,
    /// The degrees of freedom; `None` if the number depends on the state.
    pub(crate) degrees: Option<usize>,
}

impl Stubs {
    /// Stubs from the tokens of the item alone.
    pub(crate) fn unrecognised(item: TokenStream) -> Self {
        Self { item, system: None, schemes: Vec::new(), crate_path: None, is_exported: false, degrees: None }
    }

    /// Adds what the attribute declares.
    pub(crate) fn recognise(&mut self, item: &ItemStruct, declaration: &Declaration) {
        let (parameters, arguments, condition) = item.generics.split_for_impl();
        let name = &item.ident;
        self.system = Some((quote! { #parameters }, quote! { #name #arguments #condition }));
        let crate_path = &declaration.crate_path;
        self.schemes = if declaration.all_embeddings_known {
            let parameters = quote! { #parameters };
            let types = declaration.embeddings.iter().map(|(known, _)| known.value.path(crate_path));
            let clocked = declaration.clocked.iter().map(|(known, _)| known.value.path(crate_path));
            types.chain(clocked).map(|ty| (parameters.clone(), ty)).collect()
        } else {
            // The program may use the misspelled name.
            let mut generics = item.generics.clone();
            generics.params.push(syn::parse_quote!(__E));
            let (parameters, ..) = generics.split_for_impl();
            vec![(quote! { #parameters }, quote! { __E })]
        };
        self.crate_path = Some(crate_path.clone());
        self.is_exported = declaration.export.is_some();
    }

    /// The expansion that reports `errors`.
    pub(crate) fn with_errors(&self, errors: &TokenStream) -> TokenStream {
        let item = &self.item;
        let implementations = self.implementations();
        quote! { #item #errors #implementations }
    }

    fn implementations(&self) -> Option<TokenStream> {
        let (parameters, system) = self.system.as_ref()?;
        let wzvi = self.crate_path.as_ref()?;
        let hamiltonian = self.hamiltonian(wzvi);
        let exported = self.is_exported.then(|| {
            let str = quote!(&'static ::core::primitive::str);
            quote! {
                #[allow(warnings)]
                impl #parameters #wzvi::exported::Exported for #system {
                    const NAME: #str = "";
                    const DOC: #str = "";
                    const FIELDS: &'static [#wzvi::exported::FieldDescription] = &[];
                    const CLOSURES: &'static [(#str, #str)] = &[];
                    const SCHEMES: &'static [#str] = &[];
                    type Schemes = ();
                    fn from_fields(
                        _: &dyn #wzvi::exported::GivenFields,
                    ) -> ::core::result::Result<Self, #wzvi::error::ConfigError> {
                        ::core::result::Result::Err(#wzvi::error::ConfigError::Parameter)
                    }
                }
            }
        });
        let (with_scheme, schemes): (Vec<_>, Vec<_>) = self.schemes.iter().cloned().unzip();
        Some(quote! {
            const _: () = {
                #[allow(warnings)]
                impl #parameters #wzvi::system::Hamiltonian for #system { #hamiltonian }
                #[allow(warnings)]
                impl #parameters #wzvi::modified::Conservative for #system {}
                #exported
                #(
                    #[allow(warnings)]
                    impl #with_scheme #wzvi::system::Discretized<#schemes> for #system {
                        type Scheme = #wzvi::__private::checks::NoSteps;
                        type Prepared = ();
                        const EQUATIONS: &'static ::core::primitive::str = "";
                    }
                )*
            };
        })
    }

    fn hamiltonian(&self, wzvi: &Path) -> TokenStream {
        let vector = match self.degrees {
            Some(degrees) => quote!(#wzvi::__private::SVector<::core::primitive::f64, #degrees>),
            None => quote!(#wzvi::__private::DVector<::core::primitive::f64>),
        };
        quote! {
            type Vector = #vector;
            fn degrees(&self) -> ::core::primitive::usize { ::core::unimplemented!() }
            fn evaluate<S: #wzvi::scalar::Scalar>(
                &self, _: ::core::primitive::usize, _: &[S], _: &[S], _: ::core::primitive::f64,
            ) -> S { ::core::unimplemented!() }
            fn differentiate<S: #wzvi::scalar::Scalar>(
                &self, _: ::core::primitive::usize, _: &[S], _: &[S], _: ::core::primitive::f64,
                _: &mut [S], _: &mut [S],
            ) { ::core::unimplemented!() }
        }
    }
}
