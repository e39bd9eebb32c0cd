//! From elements to Rust: `Hamiltonian`, `Elements` and the schemes that are solved in loops. Tests:
//! `tests/loops`, and the golden expansions (`compile/golden_tests.rs`).

mod beside_step;
mod chunk;
mod collective;
mod combine;
mod constraints;
mod hamiltonian;
mod in_loops;
mod kernel;
mod places;
mod tiles;
mod weighted;

use proc_macro2::{Literal, TokenStream};
use quote::{ToTokens, quote};

pub(crate) use self::constraints::emit as constraints;
pub(crate) use self::in_loops::{emit as step, in_tiles, quadrature};
use crate::diagnostics::promised;
use crate::discretise::{Facts, Plans, Role, RoleElements, scale_momenta};
use crate::emit::compose::structure;
use crate::emit::gauss::length_type;
use crate::emit::overrides::{self, holds};
use crate::emit::plan::degrees;
use crate::emit::{Namer, count, f64_type, implementation, parameter_names};
use crate::indices::Indices;
use crate::input::{Length, Shape};
use crate::model::{Form, Parameter, System};
use crate::tokens::mentions;

use self::weighted::ElementEmitter;

/// The expressions that read the struct and the constants around it.
pub(crate) fn user_tokens(model: &System) -> Vec<TokenStream> {
    let parameters = model.parameters.iter().map(|parameter| parameter.tokens.clone());
    let tables = model.tables.iter().flat_map(|table| [table.tokens.clone(), table.suffix.clone()]);
    let length = match &model.shape {
        Shape::Array(_, Length::Named(expr)) => Some(quote!(#expr)),
        _ => None,
    };
    parameters.chain(tables).chain(length).collect()
}

/// `SVector<f64, D>` if the type system can name `D`, else `DVector<f64>`.
fn vector_type(model: &System) -> TokenStream {
    let f64 = f64_type();
    let dynamic = quote!(__wzvi::DVector<#f64>);
    let Some(degrees) = degrees(model) else { return dynamic };
    let Shape::Array(_, Length::Named(expr)) = &model.shape else {
        return quote!(__wzvi::SVector<#f64, #degrees>);
    };
    let mut generics = model.item.generics.const_params();
    let is_generic = generics.any(|parameter| mentions(&quote!(#expr), &parameter.ident.to_string()));
    match (is_generic, model.components, &expr.0) {
        (false, ..) => quote!(__wzvi::SVector<#f64, { #degrees }>),
        (true, 1, syn::Expr::Path(_)) => quote!(__wzvi::SVector<#f64, #expr>),
        _ => dynamic,
    }
}

/// The outermost size and the degrees of freedom in a method whose state is `__q`.
fn sizes(model: &System, degrees: &TokenStream) -> TokenStream {
    if model.components == 1 {
        return quote!(let __size = #degrees as __wzvi::isize;);
    }
    let components = Literal::i128_unsuffixed(model.components);
    quote!(let __size = (#degrees / #components) as __wzvi::isize;)
}

/// The number of noises.
fn noise_count(model: &System) -> TokenStream {
    let all = promised(model.noise_offsets().pop(), "the last offset is the number of noises");
    match all.as_integer().and_then(|index| usize::try_from(index).ok()) {
        Some(known) => count(known).into_token_stream(),
        None => {
            let all = Indices::unchecked(&model.tables).value(&all);
            quote!(#all as __wzvi::usize)
        }
    }
}

/// `let a = self.a;` for every parameter that `code` reads.
fn parameters(model: &System, code: &TokenStream) -> TokenStream {
    let names = parameter_names(&mut Namer::default(), &model.graph, &model.parameters);
    let read = names.iter().zip(&model.parameters).filter(|(name, _)| mentions(code, &name.to_string()));
    let reads = read.map(|(name, Parameter { tokens, symbol, .. })| {
        let number = model.listed().iter().take_while(|known| known.symbol != *symbol).count();
        let number = count(number);
        quote!(let #name = __at.parameter(#number, #tokens);)
    });
    quote!(#(#reads)*)
}

/// The quantity computed of an element.
#[derive(Clone, Copy, PartialEq)]
enum Derivative {
    Value,
    Gradient,
    Hessian,
    /// Values and first derivatives of constraints, each with the number of the constraint.
    Rows,
}

impl Derivative {
    /// The type of its arithmetic.
    fn number(self) -> TokenStream {
        match self {
            Self::Gradient => quote!(__T),
            Self::Value | Self::Hessian | Self::Rows => quote!(__S),
        }
    }

    /// An `f64` in the type of the arithmetic.
    fn constant(self, value: &TokenStream) -> TokenStream {
        let number = self.number();
        quote!(#number::from_f64(#value))
    }

    /// The weight of the drift in the type of the arithmetic.
    fn step_size(self, factor: Option<TokenStream>) -> TokenStream {
        let number = self.number();
        quote!(#number::of_constant(__at.h #factor))
    }

    /// A number of a vector in the type of the arithmetic.
    fn lifted(self, kept: TokenStream) -> TokenStream {
        match self {
            Self::Gradient => quote!(__T::of(#kept)),
            Self::Value | Self::Hessian | Self::Rows => kept,
        }
    }
}

/// `impl Elements`: values and slopes of all terms, and `impl Hamiltonian`.
pub(crate) fn elements(model: &mut System, facts: &Facts, plans: &Plans) -> TokenStream {
    let declared = hamiltonian::emit(model);
    let mut roles = plans.roles.clone();
    if model.conformal.is_some() {
        scale_momenta(model, &mut roles);
    }
    let [values_beside, slopes_beside] =
        [Derivative::Value, Derivative::Gradient].map(|derivative| beside_step::arms(model, derivative));
    let [value, slopes] =
        [Derivative::Value, Derivative::Gradient].map(|derivative| arms(model, &roles, derivative));
    let (value, slopes) = (quote!(#value #values_beside), quote!(#slopes #slopes_beside));
    let [of_value, of_slopes] = [&value, &slopes].map(|code| opened(model, code));
    let curvature = hessian_method(model, &roles, plans.needs_hessian());
    let (collective_variables, of_collectives) = match plans.needs_hessian() {
        true => (collective::variables(model, &roles), collective::hessian_method(model, &roles)),
        false => (None, None),
    };
    let has_tiles = tiles::allows_tiles(model, &roles);
    // Read where a window takes a whole step at once.
    let is_constant = has_tiles.is_some() && facts.has_constant_curvature;
    let has_loops = model.form == Form::Loops || model.line.is_none();
    // Steps in straight lines count the unknowns of their blocks.
    let coupled = facts.coupled_degrees.filter(|_| has_loops).map(count);
    let of_elements = overrides::FactOverrides {
        kind: hamiltonian::kind(model),
        bath: beside_step::bath(model, facts),
        summands: beside_step::forms(plans),
        has_tiles,
        has_pairs: holds(tiles::has_pairs(model, &roles)),
        gathers: tiles::gathered(model, &roles),
        has_one_velocity: holds(tiles::has_uniform_velocity(model, &roles)),
        has_constant_curvature: holds(is_constant),
        coupled_degrees: coupled.map(|degrees| quote!(__wzvi::Some(#degrees))),
        collective_variables,
        ..Default::default()
    };
    let known = crate::emit::plan::facts(model, facts, of_elements);
    let (places, common_range) = (places::emit(model), tiles::common_range(model, &roles));
    let shape = length_type(model.line.as_ref().map(|line| line.phase.q.len()));
    let structure = structure(plans);
    let (f64, elements) = (f64_type(), quote!(__wzvi::elements));
    let runs = has_loops.then(|| quote!(use #elements::AdjacentSums as _;));
    // Steps in the extended phase space read values at all stages, in vector code.
    let at_stages = model.is_extended().then(|| quote!(#[cfg_attr(not(debug_assertions), inline(always))]));
    let body = quote! {
            const FACTS: __wzvi::Facts = #known;
            type Shape = #shape;
            type Structure = #structure;
            #declared
            #places

            #at_stages
            fn value<__S: __wzvi::Scalar>(
                &self,
                __role: #elements::Role,
                __weight: #f64,
                __at: &#elements::EvaluationPoint<'_, __S>,
            ) -> __S {
                #of_value
                match __role {
                    #value
                    _ => __S::from_f64(0.0),
                }
            }

            type CommonRange = #common_range;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn gradient<__S: __wzvi::Scalar, __T: __wzvi::Number<__S>>(
                &self,
                __role: #elements::Role,
                __weight: #f64,
                __at: &#elements::EvaluationPoint<'_, __S, impl #elements::ElementInput<__S> + ?__wzvi::Sized>,
                __partials: #elements::Partials,
                __by_q: &mut (impl #elements::Sums<__S> + ?__wzvi::Sized),
                __by_p: &mut (impl #elements::Sums<__S> + ?__wzvi::Sized),
            ) {
                #runs
                #of_slopes
                match __role {
                    #slopes
                    _ => {}
                }
            }

            #curvature

            #of_collectives
    };
    implementation(&model.item, &quote!(#elements::Elements), &body)
}

/// The code of the terms of the step Hamiltonian by their roles.
fn arms(model: &mut System, roles: &[RoleElements], derivative: Derivative) -> TokenStream {
    let mut nests = ElementEmitter { model, derivative };
    let arms = roles.iter().map(|known| {
        let (condition, code) = nests.role(known);
        arm(known.role, condition, &code)
    });
    arms.collect()
}

/// The code of a role, if any.
fn arm(role: Role, condition: Option<TokenStream>, code: &TokenStream) -> TokenStream {
    let (role, condition) = (role_path(role), condition.map(|condition| quote!(if #condition)));
    if code.is_empty() { TokenStream::new() } else { quote!(#role #condition => { #code }) }
}

/// A role of the run time, as a value or as a pattern.
fn role_path(role: Role) -> TokenStream {
    let role = match role {
        Role::Drift => quote!(Drift),
        Role::Noise => quote!(Noise),
        Role::CounterTerm => quote!(CounterTerm),
        Role::Force => quote!(Force),
        Role::Summand(number) => {
            let number = count(number);
            quote!(Summand(#number))
        }
        Role::Friction => quote!(Friction),
        Role::Temperature => quote!(Temperature),
        Role::Integral(number) => {
            let number = count(number);
            quote!(Integral(#number))
        }
        Role::Observable(number) => {
            let number = count(number);
            quote!(Observable(#number))
        }
        Role::Clock => quote!(Clock),
        Role::ClockRate => quote!(ClockRate),
    };
    quote!(__wzvi::elements::Role::#role)
}

/// `Elements::hessian`: of the roles whose steps are solved with it, and of damping by a matrix; `None` if
/// there is neither.
fn hessian_method(model: &mut System, roles: &[RoleElements], has_curvature: bool) -> Option<TokenStream> {
    let of_bath = self::beside_step::arms(model, Derivative::Hessian);
    let of_roles = has_curvature.then(|| arms(model, roles, Derivative::Hessian));
    let code = quote!(#of_roles #of_bath);
    let opened = opened(model, &code);
    let (f64, usize, elements) = (f64_type(), quote!(__wzvi::usize), quote!(__wzvi::elements));
    (!code.is_empty()).then(|| {
        quote! {
            fn hessian<__S: __wzvi::Scalar>(
                &self,
                __role: #elements::Role,
                __weight: #f64,
                __at: &__wzvi::elements::EvaluationPoint<'_, __S>,
                __partials: __wzvi::elements::Partials,
                __into: &mut impl __wzvi::FnMut(__wzvi::elements::HessianBlock, [#usize; 2], __wzvi::bool, __S),
            ) {
                #opened
                match __role {
                    #code
                    _ => {}
                }
            }
        }
    })
}

/// The reads by `code` of the struct and of `__at`.
fn opened(model: &System, code: &TokenStream) -> TokenStream {
    let read = parameters(model, code);
    let size = mentions(code, "__size").then(|| sizes(model, &quote!(__at.degrees())));
    let t = mentions(code, "__t").then(|| quote!(let __t = __at.t;));
    let scale = mentions(code, "__scale").then(|| quote!(let __scale = __at.scale;));
    quote!(#read #size #t #scale)
}
