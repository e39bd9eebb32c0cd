//! From elements to Rust: `Hamiltonian`, `Elements` and one `Discretized<E>` per scheme.

mod chunk;
mod combine;
mod discretized;
mod hamiltonian;
mod indices;
mod kernel;
mod places;
mod sites;

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use self::combine::Combined;
pub(crate) use self::indices::Indices;
use self::kernel::{Context, Target};
use crate::describe::Texts;
use crate::diagnostics::internal::Promised;
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::Facts;
use crate::discretise::sums::Weighted;
use crate::elements::plan::Strategy;
use crate::emit::step::mentions;
use crate::emit::{Surroundings, count, f64_type, with_header, wrapped};
use crate::input::{Length, Shape};
use crate::model::index::{Atom, Index};
use crate::model::{Element, Noise, Parameter, Reads, System};
use crate::symbolic::{Expr, Graph, Symbol};

pub(crate) use self::sites::site_entry;

/// Everything that `#[hamiltonian]` stands for. `texts` has those of each scheme, in their order.
pub(crate) fn emit(
    model: &mut System,
    facts: &Facts,
    schemes: &[(Embedding, Strategy)],
    texts: &Texts,
) -> TokenStream {
    let mut generated = hamiltonian::emit(model);
    generated.extend(elements(model, facts));
    for ((embedding, strategy), text) in schemes.iter().zip(&texts.of_parts) {
        let road = match strategy {
            Strategy::Sites(site, scheme) => sites::emit(model, facts, site, scheme),
            Strategy::Sweep { unknowns, is_linear } => {
                discretized::sweep(model, facts, embedding, *unknowns, *is_linear)
            }
        };
        generated.extend(discretized::emit(model, facts, embedding, road, text));
    }
    let surroundings = Surroundings {
        crate_path: &model.crate_path,
        tokens: with_header(&model.item, user_tokens(model).iter()),
        spelled: &model.type_checks,
    };
    wrapped(&model.item, generated, &surroundings, texts)
}

/// What is read of the struct and of the constants around it.
fn user_tokens(model: &System) -> Vec<TokenStream> {
    let parameters = model.parameters.iter().map(|parameter| parameter.tokens.clone());
    let tables = model.tables.iter().flat_map(|table| [table.tokens.clone(), table.suffix.clone()]);
    let length = match &model.shape {
        Shape::Array(_, Length::Named(expr)) => Some(quote!(#expr)),
        _ => None,
    };
    parameters.chain(tables).chain(length).collect()
}

/// `SVector<f64, D>` where the type system can name `D`, else `DVector<f64>`.
fn vector_type(model: &System) -> TokenStream {
    let f64 = f64_type();
    let dynamic = quote!(__wzvi::DVector<#f64>);
    let Shape::Array(_, length) = &model.shape else { return quote!(__wzvi::SVector<#f64, 1>) };
    let components = usize::try_from(model.components).unwrap_or(1);
    match length {
        Length::Literal(len) => {
            let degrees = count(len * components);
            quote!(__wzvi::SVector<#f64, #degrees>)
        }
        Length::RunTime => dynamic,
        Length::Named(expr) => {
            let is_generic = model.item.generics.const_params().any(|parameter| {
                let name = parameter.ident.to_string();
                expr_mentions(expr, &name)
            });
            match (is_generic, components, &**expr) {
                (false, ..) => quote!(__wzvi::SVector<#f64, { (#expr) * #components }>),
                (true, 1, syn::Expr::Path(_)) => quote!(__wzvi::SVector<#f64, #expr>),
                _ => dynamic,
            }
        }
    }
}

fn expr_mentions(expr: &syn::Expr, name: &str) -> bool {
    quote!(#expr).to_string().split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name)
}

/// The outermost size and the degrees of freedom in a method whose state is `__q`.
fn sizes(model: &System, degrees: &TokenStream) -> TokenStream {
    if model.components == 1 {
        return quote!(let __size = #degrees as __wzvi::isize;);
    }
    let components = Literal::i128_unsuffixed(model.components);
    quote!(let __size = (#degrees / #components) as __wzvi::isize;)
}

/// The number of degrees of freedom; 0 if only the state knows it.
fn degrees(model: &System) -> TokenStream {
    if model.size == Index::atom(Atom::Size) {
        return quote!(0);
    }
    let indices = Indices { tables: &model.tables, checked: false };
    let (size, components) = (indices.value(&model.size), usize::try_from(model.components).unwrap_or(1));
    match components {
        1 => quote!(#size as __wzvi::usize),
        _ => {
            let components = count(components);
            quote!(#size as __wzvi::usize * #components)
        }
    }
}

fn noise_count(model: &System) -> TokenStream {
    let all = model.noise_offsets().pop().promised("the last offset is the number of noises");
    match all.as_integer().and_then(|count| usize::try_from(count).ok()) {
        Some(known) => {
            let known = count(known);
            quote!(#known)
        }
        None => {
            let count = Indices { tables: &model.tables, checked: false }.value(&all);
            quote!(#count as __wzvi::usize)
        }
    }
}

/// `let a = self.a;` for every parameter that `code` reads.
fn parameters(model: &System, code: &TokenStream) -> TokenStream {
    let f64 = f64_type();
    let names = kernel::parameters(&model.graph, &model.parameters);
    let read = names.iter().zip(&model.parameters).filter(|(name, _)| mentions(code, &name.to_string()));
    let reads = read.map(|(name, Parameter { tokens, .. })| quote!(let #name: #f64 = #tokens;));
    quote!(#(#reads)*)
}

/// What is computed of an element.
#[derive(Clone, Copy, PartialEq)]
enum Wanted {
    Value,
    Slopes,
    Curvature,
}

/// The code of one element: `c H_e` with the weight `c`, one if there is none, or its first or second derivatives.
fn element_code(
    model: &mut System,
    element: &Element,
    wanted: Wanted,
    weight: Option<&TokenStream>,
) -> TokenStream {
    let graph = &mut model.graph;
    let weight = weight.map(|weight| (graph.new_symbol("c"), weight));
    let value = match weight {
        Some((symbol, _)) => {
            let c = graph.symbol(symbol);
            graph.multiply(c, element.value)
        }
        None => element.value,
    };
    let all: Vec<(Symbol, Index, bool)> = element
        .coordinates()
        .map(|(s, index)| (s, index.clone(), false))
        .chain(element.momenta().map(|(s, index)| (s, index.clone(), true)))
        .collect();
    let symbols: Vec<Symbol> = all.iter().map(|(symbol, ..)| *symbol).collect();
    let mut combined = match wanted {
        Wanted::Value => None,
        Wanted::Slopes | Wanted::Curvature => Combined::new(graph, value, &symbols),
    };
    let mut outputs: Vec<(Expr, Target)> = Vec::new();
    match wanted {
        Wanted::Value => outputs.push((value, Target::Total)),
        Wanted::Slopes => {
            let slopes = match &mut combined {
                Some(combined) => combined.slopes(graph, &symbols),
                None => symbols.iter().map(|symbol| graph.derivative(value, *symbol)).collect(),
            };
            for (slope, (_, index, is_p)) in slopes.into_iter().zip(&all) {
                let vector = if *is_p { format_ident!("__by_p") } else { format_ident!("__by_q") };
                outputs.push((slope, Target::Slope { vector, index: index.clone() }));
            }
        }
        Wanted::Curvature => {
            let curvatures = match combined.as_mut().and_then(|c| c.curvatures(graph, &symbols)) {
                Some(curvatures) => curvatures,
                None => curvatures(graph, value, &symbols),
            };
            let pairs =
                all.iter().enumerate().flat_map(|(a, first)| all[a..].iter().map(move |b| (first, b)));
            for (curvature, ((first, row, first_is_p), (second, column, second_is_p))) in
                curvatures.into_iter().zip(pairs)
            {
                let method = match (first_is_p, second_is_p) {
                    (false, false) => format_ident!("add_qq"),
                    (true, true) => format_ident!("add_pp"),
                    _ => format_ident!("add_qp"),
                };
                let (row, column) = (row.clone(), column.clone());
                let is_diagonal = first == second;
                outputs.push((curvature, Target::Curvature { method, row, column, is_diagonal }));
            }
        }
    }
    outputs.retain(|(value, _)| !graph.is_zero(*value));
    let mut context = Context {
        graph,
        parameters: &model.parameters,
        tables: &model.tables,
        t: model.t,
        weight,
        components: model.components,
        definitions: combined.map(|combined| combined.definitions).unwrap_or_default(),
    };
    kernel::emit(&mut context, element, &outputs)
}

/// The second derivatives by each pair of `symbols` with the first not after the second, row by row.
fn curvatures(graph: &mut Graph, value: Expr, symbols: &[Symbol]) -> Vec<Expr> {
    let mut all = Vec::new();
    for (a, &first) in symbols.iter().enumerate() {
        let slope = graph.derivative(value, first);
        all.extend(symbols[a..].iter().map(|&second| graph.derivative(slope, second)));
    }
    all
}

/// The elements of every noise with the increment that weighs it.
fn noise_elements(model: &System) -> Vec<(Element, TokenStream)> {
    let indices = Indices { tables: &model.tables, checked: false };
    let weigh = |(noise, offset): (&Noise, Index)| {
        // Where the family is the innermost loop, its increments are an input like any other.
        let number = match &noise.family {
            Some(family) => offset
                .add(&Index::atom(Atom::Loop(family.variable)))
                .promised("numbers of noises are integers"),
            None => offset,
        };
        let position = match number.as_integer().and_then(|number| usize::try_from(number).ok()) {
            Some(number) => {
                let number = count(number);
                quote!(#number)
            }
            None => indices.position(&number),
        };
        let weight = quote!(__at.dw[#position]);
        noise.term.elements.iter().map(|e| (e.clone(), weight.clone())).collect::<Vec<_>>()
    };
    model.noise.iter().zip(model.noise_offsets()).flat_map(weigh).collect()
}

/// The elements of the counter-term, if a scheme adds it, with their weights.
fn counter_elements(model: &System, facts: &Facts) -> Vec<(Element, TokenStream)> {
    let indices = Indices { tables: &model.tables, checked: false };
    let increment = |number: &Index| {
        let position = match number.as_integer().and_then(|number| usize::try_from(number).ok()) {
            Some(number) => {
                let number = count(number);
                quote!(#number)
            }
            None => indices.position(number),
        };
        quote!(__at.dw[#position])
    };
    let schemes = model.embeddings.iter();
    let used = schemes.map(|known| facts.counter_of(&known.value)).find(|counter| !counter.is_empty());
    let weigh = |Weighted { element, increments }: &Weighted| {
        let increments = increments.iter().map(increment);
        (element.clone(), quote!(#(#increments *)* __terms.counter))
    };
    used.unwrap_or_default().iter().map(weigh).collect()
}

/// `impl Elements`
fn elements(model: &mut System, facts: &Facts) -> TokenStream {
    let slopes = sweep(model, facts, Wanted::Slopes);
    let curvature = sweep(model, facts, Wanted::Curvature);
    let places = places::emit(model);
    let [opened_for_slopes, opened_for_curvature] = [&slopes, &curvature].map(|code| opened(model, code));
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::elements::Elements for #name #arguments #filter {
            #places

            fn slopes<__S: __wzvi::Scalar>(
                &self,
                __terms: __wzvi::elements::Terms,
                __at: &__wzvi::elements::Point<'_, __S>,
                __by_q: &mut [__S],
                __by_p: &mut [__S],
            ) {
                #opened_for_slopes
                #slopes
            }

            fn curvature<__S: __wzvi::Scalar, __C: __wzvi::elements::Curvature<__S>>(
                &self,
                __terms: __wzvi::elements::Terms,
                __at: &__wzvi::elements::Point<'_, __S>,
                __into: &mut __C,
            ) {
                #opened_for_curvature
                #curvature
            }
        }
    }
}

/// What `code` reads of the struct and of `__at`.
fn opened(model: &System, code: &TokenStream) -> TokenStream {
    let read = parameters(model, code);
    let size = mentions(code, "__size").then(|| sizes(model, &quote!(__at.q.len())));
    let t = mentions(code, "__t").then(|| quote!(let __t = __at.t;));
    quote!(#read #size #t)
}

/// Every element of the drift and the noises, under the conditions of `__terms`.
fn sweep(model: &mut System, facts: &Facts, wanted: Wanted) -> TokenStream {
    let drift: Vec<(Element, TokenStream)> =
        model.drift.elements.iter().map(|element| (element.clone(), quote!(__S::from_f64(__at.h)))).collect();
    let noise = noise_elements(model);
    let counter = counter_elements(model, facts);
    let mut code = TokenStream::new();
    let groups = [
        (quote!(__terms.drift), drift),
        (quote!(__terms.noise), noise),
        (quote!(__terms.counter != 0.0), counter),
    ];
    for (group, list) in groups {
        let mut parts = TokenStream::new();
        for (element, weight) in &list {
            let condition = match element.reads() {
                Reads::Nothing => continue,
                Reads::Coordinates => quote!(__terms.by_q),
                Reads::Momenta => quote!(__terms.by_p),
                Reads::Both => quote!((__terms.by_q || __terms.by_p)),
            };
            let body = element_code(model, element, wanted, Some(weight));
            if !body.is_empty() {
                parts.extend(quote!(if #condition { #body }));
            }
        }
        if !parts.is_empty() {
            code.extend(quote!(if #group { #parts }));
        }
    }
    code
}
