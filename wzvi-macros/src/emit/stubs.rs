//! What stands in for the integrators when there are errors: the struct, and implementations that type-check, so that
//! `rustc` does not add "trait not implemented" to what was reported.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{ItemStruct, Path};

use crate::input::Declaration;

/// What is known of the system so far.
pub(crate) struct Stubs {
    item: TokenStream,
    system: Option<(TokenStream, TokenStream)>,
    /// The generic parameters and the scheme of each implementation.
    schemes: Vec<(TokenStream, TokenStream)>,
    crate_path: Option<Path>,
    /// Known unless the state has as many as it likes.
    degrees: Option<usize>,
}

impl Stubs {
    /// Nothing but the tokens of the item.
    pub(crate) fn unrecognised(item: TokenStream) -> Self {
        Self { item, system: None, schemes: Vec::new(), crate_path: None, degrees: None }
    }

    /// The attribute was read.
    pub(crate) fn recognise(&mut self, item: &ItemStruct, declaration: &Declaration) {
        let (parameters, arguments, condition) = item.generics.split_for_impl();
        let name = &item.ident;
        self.system = Some((quote! { #parameters }, quote! { #name #arguments #condition }));
        let crate_path = &declaration.crate_path;
        self.schemes = if declaration.all_embeddings_known {
            let parameters = quote! { #parameters };
            let types = declaration.embeddings.iter().map(|known| known.value.path(crate_path));
            types.map(|ty| (parameters.clone(), ty)).collect()
        } else {
            // Whatever the program calls for may be what was misspelled.
            let mut generics = item.generics.clone();
            generics.params.push(syn::parse_quote!(__E));
            let (parameters, ..) = generics.split_for_impl();
            vec![(quote! { #parameters }, quote! { __E })]
        };
        self.crate_path = Some(crate_path.clone());
    }

    /// The phase space was read.
    pub(crate) fn set_degrees(&mut self, degrees: Option<usize>) {
        self.degrees = degrees;
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
        let discretized = discretized(wzvi);
        let (with_scheme, schemes): (Vec<_>, Vec<_>) = self.schemes.iter().cloned().unzip();
        Some(quote! {
            const _: () = {
                #[allow(warnings)]
                impl #parameters #wzvi::system::Hamiltonian for #system { #hamiltonian }
                #[allow(warnings)]
                impl #parameters #wzvi::modified::Conservative for #system {}
                #(
                    #[allow(warnings)]
                    impl #with_scheme #wzvi::system::Discretized<#schemes> for #system { #discretized }
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
            fn noises(&self) -> ::core::primitive::usize { ::core::unimplemented!() }
            fn invariants(&self) -> ::core::primitive::usize { ::core::unimplemented!() }
            fn evaluate<S: #wzvi::scalar::Scalar>(
                &self, _: ::core::primitive::usize, _: &[S], _: &[S], _: ::core::primitive::f64,
            ) -> S { ::core::unimplemented!() }
            fn differentiate<S: #wzvi::scalar::Scalar>(
                &self, _: ::core::primitive::usize, _: &[S], _: &[S], _: ::core::primitive::f64,
                _: &mut [S], _: &mut [S],
            ) { ::core::unimplemented!() }
            fn invariant(
                &self, _: ::core::primitive::usize, _: &#wzvi::state::State<Self::Vector>,
            ) -> ::core::primitive::f64 { ::core::unimplemented!() }
            fn energy_rate(
                &self, _: ::core::primitive::usize, _: &#wzvi::state::State<Self::Vector>,
            ) -> ::core::primitive::f64 { ::core::unimplemented!() }
        }
    }
}

/// The items of `Discretized`, the same for every scheme.
fn discretized(wzvi: &Path) -> TokenStream {
    let vector = quote! { <Self as #wzvi::system::Hamiltonian>::Vector };
    let segment = quote! { #wzvi::system::Segment<#vector> };
    let state = quote! { #wzvi::state::State<#vector> };
    let real = quote! { ::core::primitive::f64 };
    quote! {
        const PLAN: #wzvi::plan::Plan = #wzvi::plan::Plan {
            solver: #wzvi::plan::Solver::Explicit,
            unknowns: 0,
            order: 1,
            noise: #wzvi::plan::NoiseClass::None,
            consistent: false,
            conserves_energy: #wzvi::plan::Knowledge::Unknown,
            commuting: #wzvi::plan::Knowledge::Unknown,
        };
        const EQUATIONS: &'static ::core::primitive::str = "";
        type Prepared = ();
        type Memory<S: #wzvi::scalar::Scalar> = ();
        type Compensated<S: #wzvi::scalar::Scalar> = #wzvi::__private::Plain;
        type Carry<S: #wzvi::scalar::Scalar> = #wzvi::__private::Plain;
        fn prepare(&self, _: #real) -> ::core::result::Result<(), #wzvi::error::ConfigError> {
            ::core::unimplemented!()
        }
        fn advance_carrying<
            S: #wzvi::scalar::Scalar, C: #wzvi::__private::Carry<S>, const CAREFUL: ::core::primitive::bool,
        >(
            &self, _: &(), _: #real, _: #real, _: &mut [S], _: &mut [S], _: &[S], _: &mut (), _: &mut C,
        ) -> ::core::result::Result<#wzvi::__private::Effort, #wzvi::error::StepFailure> { ::core::unimplemented!() }
        #wzvi::__private::apart!(Self);
        fn discrete_lagrangian(&self, _: &#segment, _: &[#real]) -> #real { ::core::unimplemented!() }
        fn discrete_lagrangian_gradient(
            &self, _: &#segment, _: &[#real],
        ) -> #wzvi::system::LagrangianGradient<#vector> { ::core::unimplemented!() }
        fn step_momentum(&self, _: &#state, _: &#state, _: #real, _: &[#real]) -> #vector {
            ::core::unimplemented!()
        }
    }
}
