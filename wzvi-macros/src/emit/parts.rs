//! `impl Parts`: the slopes and the values of the parts of `drift = [H_A, H_B]`.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::ItemStruct;

use super::compose::explicit_plan;
use super::names::Names;
use super::print::f64_type;
use super::program::Level;
use super::system::{Body, Inputs, Letters, body, count};
use crate::describe::Texts;
use crate::discretise::facts::Facts;
use crate::discretise::facts::split::Form;
use crate::model::Model;
use crate::symbolic::{Expr, Symbol};

/// The parts of the drift, if the user has parted it.
pub(super) fn emit(model: &mut Model, facts: &Facts, texts: &Texts) -> TokenStream {
    let Some(forms) = texts.parts else { return TokenStream::new() };
    let degrees = model.phase.q.len();
    let h = model.graph.new_symbol("h");
    let parts: Vec<Expr> = model.parts.iter().map(|part| part.value).collect();
    let slopes: Vec<TokenStream> = parts
        .iter()
        .map(|&part| {
            let symbols = model.phase.q.iter().chain(&model.phase.p);
            let roots: Vec<Expr> = symbols
                .map(|&symbol| {
                    let (slope, h) = (model.graph.derivative(part, symbol), model.graph.symbol(h));
                    model.graph.multiply(h, slope)
                })
                .collect();
            statements(model, &roots, Some(h), |values| {
                let (by_q, by_p) = values.split_at(degrees);
                quote! {
                    if __BY_Q {
                        __by_q.copy_from_slice(&[#(#by_q),*]);
                    }
                    if __BY_P {
                        __by_p.copy_from_slice(&[#(#by_p),*]);
                    }
                }
            })
        })
        .collect();
    let values: Vec<TokenStream> =
        parts.iter().map(|&part| statements(model, &[part], None, |values| quote!(#(#values)*))).collect();
    let degrees = count(degrees);
    let code = Parts { forms, shape: quote!(__wzvi::gauss::Fixed<#degrees>), slopes, values };
    code.emit(&model.item, facts)
}

/// The code of `roots` in the letters of the phase space, which are bound from `__q` and `__p`.
fn statements(
    model: &mut Model,
    roots: &[Expr],
    h: Option<Symbol>,
    finish: impl Fn(&[TokenStream]) -> TokenStream,
) -> TokenStream {
    let letters = Letters::of(model, Names::default());
    let (q, p) = (&letters.q, &letters.p);
    let of_state = model.phase.q.iter().zip(q).chain(model.phase.p.iter().zip(p));
    let mut names: Vec<_> = of_state.map(|(&symbol, name)| (symbol, name.clone(), Level::State)).collect();
    names.push((model.phase.t, format_ident!("__t"), Level::Prepared));
    names.extend(h.map(|h| (h, format_ident!("__h"), Level::Prepared)));
    let scalar = if h.is_some() { quote!(__S) } else { f64_type() };
    let inputs = Inputs { names, definitions: HashMap::new() };
    let Body { statements, values } = body(model, &letters, &inputs, &scalar, roots);
    let finished = finish(&values);
    let unfit = match h {
        Some(_) => quote!(__wzvi::gauss::unfit(__by_q, __by_p)),
        None => quote!(#scalar::NAN),
    };
    quote! {
        (&[#(#q),*], &[#(#p),*]) => {
            #statements
            #finished
        }
        _ => #unfit,
    }
}

/// The implementation for any system.
pub(crate) struct Parts {
    pub(crate) forms: [Form; 2],
    pub(crate) shape: TokenStream,
    /// Arms of a match over the coordinates and the momenta, for each part; all there are.
    pub(crate) slopes: Vec<TokenStream>,
    pub(crate) values: Vec<TokenStream>,
}

impl Parts {
    pub(crate) fn emit(&self, item: &ItemStruct, facts: &Facts) -> TokenStream {
        let Self { forms, shape, slopes, values } = self;
        let forms = forms.map(|form| match form {
            Form::Coordinates => quote!(__wzvi::compose::Form::Coordinates),
            Form::Momenta => quote!(__wzvi::compose::Form::Momenta),
            Form::Quadratic => quote!(__wzvi::compose::Form::Quadratic),
        });
        let halves = [quote!(First), quote!(Second)];
        let arms = |code: &[TokenStream]| {
            let arms = halves.iter().zip(code);
            arms.map(|(half, code)| quote!(__wzvi::compose::Half::#half => match (__q, __p) { #code }))
                .collect::<TokenStream>()
        };
        let f64 = f64_type();
        let (slopes, values) = (arms(slopes), arms(values));
        let (plan, bool) = (explicit_plan(facts), quote!(__wzvi::bool));
        let name = &item.ident;
        let (generics, arguments, filter) = item.generics.split_for_impl();
        quote! {
            #[automatically_derived]
            impl #generics __wzvi::compose::Parts for #name #arguments #filter {
                const PLAN: __wzvi::Plan = #plan;
                const FORMS: [__wzvi::compose::Form; 2] = [#(#forms),*];
                type Shape = #shape;

                #[inline(always)]
                fn slopes_of_part<__S: __wzvi::Scalar, const __BY_Q: #bool, const __BY_P: #bool>(
                    &self,
                    __part: __wzvi::compose::Half,
                    __t: #f64,
                    __h: #f64,
                    __q: &[__S],
                    __p: &[__S],
                    __by_q: &mut [__S],
                    __by_p: &mut [__S],
                ) {
                    match __part {
                        #slopes
                    }
                }

                fn value_of_part(
                    &self,
                    __part: __wzvi::compose::Half,
                    __t: #f64,
                    __q: &[#f64],
                    __p: &[#f64],
                ) -> #f64 {
                    match __part {
                        #values
                    }
                }
            }
        }
    }
}
