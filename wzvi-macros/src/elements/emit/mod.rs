//! From elements to Rust: `Hamiltonian`, `Elements` and one `Discretized<E>` per scheme.

mod chunk;
mod combine;
mod indices;
mod kernel;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use self::combine::Combined;
use self::indices::{Indices, variable};
use self::kernel::{Context, Target};
use super::counter::{Counter, Weight};
use super::facts::{Facts, is_consistent};
use super::index::{Atom, Bounds, Index};
use super::model::{Element, Model, Noises, Reads, Slot, Term};
use super::plan::{Unknowns, unknowns};
use crate::discretise::embedding::Embedding;
use crate::discretise::facts::{Knowledge, NoiseClass};
use crate::emit::{embedding_type, f64_type, parameter, wrapped};
use crate::input::{Length, Shape};
use crate::symbolic::{Expr, Graph, Symbol};

/// Everything that `#[hamiltonian]` stands for. `equations` has the text of each scheme, in their order.
pub(crate) fn emit(model: &mut Model, facts: &Facts, equations: &[String]) -> TokenStream {
    let mut generated = hamiltonian(model);
    generated.extend(elements(model, facts));
    let embeddings: Vec<Embedding> = model.embeddings.iter().map(|known| known.value.clone()).collect();
    for (embedding, text) in embeddings.iter().zip(equations) {
        generated.extend(discretized(model, facts, embedding, text));
    }
    let Model { item, crate_path, type_checks, .. } = model;
    wrapped(item, crate_path, &generated, type_checks, equations)
}

/// `SVector<f64, D>` where the type system can name `D`, else `DVector<f64>`.
fn vector_type(model: &Model) -> TokenStream {
    let f64 = f64_type();
    let dynamic = quote!(__wzvi::DVector<#f64>);
    let Shape::Array(_, length) = &model.shape else { return dynamic };
    let components = usize::try_from(model.components).unwrap_or(1);
    match length {
        Length::Literal(len) => {
            let degrees = len * components;
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
fn sizes(model: &Model, degrees: &TokenStream) -> TokenStream {
    let components = proc_macro2::Literal::i128_unsuffixed(model.components);
    quote! { let __size = (#degrees / #components) as __wzvi::core::primitive::isize; }
}

/// The number of degrees of freedom; 0 if only the state knows it.
fn degrees(model: &Model) -> TokenStream {
    if model.size == Index::atom(Atom::Size) {
        return quote!(0);
    }
    let indices = Indices { tables: &model.tables, checked: false };
    let (size, components) = (indices.value(&model.size), usize::try_from(model.components).unwrap_or(1));
    quote!((#size as __wzvi::core::primitive::usize) * #components)
}

fn noise_count(model: &Model) -> TokenStream {
    match &model.noises {
        Noises::List(terms) => {
            let count = terms.len();
            quote!(#count)
        }
        Noises::Family { count, .. } => {
            let count = Indices { tables: &model.tables, checked: false }.value(count);
            quote!((#count as __wzvi::core::primitive::isize as __wzvi::core::primitive::usize))
        }
    }
}

/// `let __a0 = self.a;` for every parameter.
fn parameters(model: &Model) -> TokenStream {
    let f64 = f64_type();
    let reads = model.parameters.iter().enumerate().map(|(k, parameter)| {
        let (name, tokens) = (format_ident!("__a{k}"), &parameter.tokens);
        quote!(let #name: #f64 = #tokens;)
    });
    quote!(#(#reads)*)
}

/// What is computed of an element.
#[derive(Clone, Copy, PartialEq)]
enum Wanted {
    Value,
    Slopes,
    Curvature,
}

/// The code of one element: `c H_e`, or its first or second derivatives.
fn element_code(
    model: &mut Model,
    element: &Element,
    wanted: Wanted,
    weight_symbol: Symbol,
    weight: &TokenStream,
) -> TokenStream {
    let graph = &mut model.graph;
    let c = graph.symbol(weight_symbol);
    let value = graph.multiply(c, element.value);
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
        weight: weight_symbol,
        components: model.components,
        definitions: combined.map(|combined| combined.definitions).unwrap_or_default(),
    };
    kernel::emit(&mut context, element, weight, &outputs)
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
fn noise_elements(model: &Model) -> Vec<(Element, TokenStream)> {
    match &model.noises {
        Noises::List(terms) => terms
            .iter()
            .enumerate()
            .flat_map(|(k, term)| term.elements.iter().map(move |e| (e.clone(), quote!(__at.dw[#k]))))
            .collect(),
        Noises::Family { term, variable: id, .. } => {
            let name = variable(*id);
            let weight = quote!(__at.dw[#name as __wzvi::core::primitive::usize]);
            // Where the family is the innermost loop, its increments are an input like any other.
            term.elements.iter().map(|element| (element.clone(), weight.clone())).collect()
        }
    }
}

/// The elements of the counter-term, if a scheme adds it, with their weights.
fn counter_elements(model: &Model, facts: &Facts) -> Vec<(Element, TokenStream)> {
    let schemes = model.embeddings.iter();
    let used = schemes.map(|known| facts.counter_of(&known.value)).find(|counter| !counter.is_empty());
    let weigh = |Counter { element, weight }: &Counter| {
        let weight = match weight {
            Weight::Pair(j, k) => quote!(__at.dw[#j] * __at.dw[#k] * __terms.counter),
            Weight::Member => {
                let member = element.loops.first().map(|known| variable(known.variable));
                let increment = quote!(__at.dw[#member as __wzvi::core::primitive::usize]);
                quote!(#increment * #increment * __terms.counter)
            }
        };
        (element.clone(), weight)
    };
    used.unwrap_or_default().iter().map(weigh).collect()
}

/// `impl Elements`
fn elements(model: &mut Model, facts: &Facts) -> TokenStream {
    let slopes = sweep(model, facts, Wanted::Slopes);
    let curvature = sweep(model, facts, Wanted::Curvature);
    let required = required(model);
    let read = parameters(model);
    let size = sizes(model, &quote!(__at.q.len()));
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::elements::Elements for #name #arguments #filter {
            #required

            fn slopes<__S: __wzvi::Scalar>(
                &self,
                __terms: __wzvi::elements::Terms,
                __at: &__wzvi::elements::Point<'_, __S>,
                __by_q: &mut [__S],
                __by_p: &mut [__S],
            ) {
                #read
                #size
                let __t = __at.t;
                #slopes
            }

            fn curvature<__S: __wzvi::Scalar, __C: __wzvi::elements::Curvature<__S>>(
                &self,
                __terms: __wzvi::elements::Terms,
                __at: &__wzvi::elements::Point<'_, __S>,
                __into: &mut __C,
            ) {
                #read
                #size
                let __t = __at.t;
                #curvature
            }
        }
    }
}

/// Every element of the drift and the noises, under the conditions of `__terms`.
fn sweep(model: &mut Model, facts: &Facts, wanted: Wanted) -> TokenStream {
    let drift: Vec<(Element, TokenStream)> = model
        .drift
        .elements
        .iter()
        .map(|element| (element.clone(), quote!(<__S as __wzvi::Scalar>::from_f64(__at.h))))
        .collect();
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
            let symbol = model.graph.new_symbol("c");
            let body = element_code(model, element, wanted, symbol, weight);
            parts.extend(quote!(if #condition { #body }));
        }
        if !parts.is_empty() {
            code.extend(quote!(if #group { #parts }));
        }
    }
    code
}

/// The check of the indices that the compiler could not prove.
fn required(model: &Model) -> TokenStream {
    let indices = Indices { tables: &model.tables, checked: true };
    let isize = quote!(__wzvi::core::primitive::isize);
    let mut checks = TokenStream::new();
    let family = match &model.noises {
        Noises::Family { .. } => model.noises.terms(),
        Noises::List(list) => list.as_slice(),
    };
    let terms = [&model.drift].into_iter().chain(family).chain(model.invariants.iter().map(|i| &i.term));
    for element in terms.flat_map(|term: &Term| &term.elements) {
        let is_unsigned = |table: u32| model.tables.get(table as usize).is_some_and(|t| t.is_unsigned);
        let bounds = Bounds { loops: &element.loops, is_unsigned: &is_unsigned };
        let components = Index::integer(model.components);
        let total = model.size.multiply(&components).unwrap_or_default();
        let mut body = TokenStream::new();
        for local in &element.locals {
            match &local.slot {
                Slot::Coordinate(index) | Slot::Momentum(index) => {
                    let rest = total.subtract(index).and_then(|rest| rest.shifted(-1));
                    let proven =
                        bounds.is_nonnegative(index) && rest.is_some_and(|rest| bounds.is_nonnegative(&rest));
                    if !proven {
                        let position = indices.position(index);
                        body.extend(quote! {
                            __required = __wzvi::core::cmp::Ord::max(__required, #position.checked_add(1)?);
                        });
                    }
                }
                Slot::Entry(table, entries) => {
                    let entry = indices.entry(*table, entries);
                    body.extend(quote!(let _ = #entry;));
                }
                Slot::Number(index) => {
                    let value = indices.value(index);
                    body.extend(quote!(let _ = #value;));
                }
            }
        }
        if body.is_empty() {
            continue;
        }
        for known in element.loops.iter().rev() {
            let (name, start, end) =
                (variable(known.variable), indices.value(&known.start), indices.value(&known.end));
            body = quote!(for #name in (#start as #isize)..#end { #body });
        }
        checks.extend(body);
    }
    let components = usize::try_from(model.components).unwrap_or(1);
    let size = sizes(model, &quote!(__degrees));
    quote! {
        fn required(
            &self,
            __degrees: __wzvi::core::primitive::usize,
        ) -> __wzvi::core::option::Option<__wzvi::core::primitive::usize> {
            #size
            let mut __required = #components;
            if __degrees % #components != 0 {
                return __wzvi::core::option::Option::Some((__size as __wzvi::core::primitive::usize + 1) * #components);
            }
            #checks
            __wzvi::core::option::Option::Some(__required)
        }
    }
}

/// `impl Hamiltonian`
fn hamiltonian(model: &mut Model) -> TokenStream {
    let vector = vector_type(model);
    let (degrees, noises) = (degrees(model), noise_count(model));
    let (values, slopes) = (arms(model, Wanted::Value), arms(model, Wanted::Slopes));
    let read = parameters(model);
    let size = sizes(model, &quote!(__q.len()));
    let (invariants, invariant) = (model.invariants.len(), invariant(model));
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let (usize, f64) = (quote!(__wzvi::core::primitive::usize), f64_type());
    let parameter = parameter(&model.graph, &model.parameters);
    let fits = quote! {
        __q.len() == __p.len() && __wzvi::elements::check(self, __q.len()).is_ok()
    };
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::Hamiltonian for #name #arguments #filter {
            type Vector = #vector;

            fn degrees(&self) -> #usize { #degrees }

            fn noises(&self) -> #usize { #noises }

            fn invariants(&self) -> #usize { #invariants }

            #parameter

            fn evaluate<__S: __wzvi::Scalar>(&self, __term: #usize, __q: &[__S], __p: &[__S], __t: #f64) -> __S {
                let __nan = <__S as __wzvi::Scalar>::from_f64(#f64::NAN);
                if !(#fits) {
                    return __nan;
                }
                #read
                #size
                let __at = __wzvi::elements::Point { q: __q, p: __p, t: __t, h: 1.0, dw: &[] };
                let mut __total = <__S as __wzvi::Scalar>::from_f64(0.0);
                match __term {
                    #values
                    _ => return __nan,
                }
                __total
            }

            fn differentiate<__S: __wzvi::Scalar>(
                &self,
                __term: #usize,
                __q: &[__S],
                __p: &[__S],
                __t: #f64,
                __by_q: &mut [__S],
                __by_p: &mut [__S],
            ) {
                let __nan = <__S as __wzvi::Scalar>::from_f64(#f64::NAN);
                if !(#fits && __by_q.len() == __q.len() && __by_p.len() == __q.len()) {
                    __by_q.fill(__nan);
                    __by_p.fill(__nan);
                    return;
                }
                __by_q.fill(<__S as __wzvi::Scalar>::from_f64(0.0));
                __by_p.fill(<__S as __wzvi::Scalar>::from_f64(0.0));
                #read
                #size
                let __at = __wzvi::elements::Point { q: __q, p: __p, t: __t, h: 1.0, dw: &[] };
                match __term {
                    #slopes
                    _ => {
                        __by_q.fill(__nan);
                        __by_p.fill(__nan);
                    }
                }
            }

            #invariant

            fn energy_rate(&self, __k: #usize, __state: &__wzvi::State<Self::Vector>) -> #f64 {
                __wzvi::elements::energy_rate(self, __k, __state)
            }
        }
    }
}

/// `Hamiltonian::invariant`
fn invariant(model: &mut Model) -> TokenStream {
    let (usize, f64) = (quote!(__wzvi::core::primitive::usize), f64_type());
    if model.invariants.is_empty() {
        return quote!(fn invariant(&self, _: #usize, _: &__wzvi::State<Self::Vector>) -> #f64 { #f64::NAN });
    }
    let one = quote!(<__S as __wzvi::Scalar>::from_f64(1.0));
    let integrals: Vec<Vec<Element>> =
        model.invariants.iter().map(|invariant| invariant.term.elements.clone()).collect();
    let mut arms = TokenStream::new();
    for (number, elements) in integrals.iter().enumerate() {
        let body = terms_code(model, elements, Wanted::Value, &one);
        arms.extend(quote!(#number => { #body }));
    }
    let (read, size) = (parameters(model), sizes(model, &quote!(__at.q.len())));
    quote! {
        fn invariant(&self, __number: #usize, __state: &__wzvi::State<Self::Vector>) -> #f64 {
            type __S = #f64;
            let (__q, __p) = (__wzvi::Vector::components(&__state.q), __wzvi::Vector::components(&__state.p));
            if __q.len() != __p.len() || __wzvi::elements::check(self, __q.len()).is_err() {
                return #f64::NAN;
            }
            let __at = __wzvi::elements::Point::<#f64> { q: __q, p: __p, t: __state.t, h: 1.0, dw: &[] };
            let __t = __at.t;
            #read
            #size
            let mut __total: #f64 = 0.0;
            match __number {
                #arms
                _ => return #f64::NAN,
            }
            __total
        }
    }
}

/// The code of several elements, one after the other.
fn terms_code(model: &mut Model, elements: &[Element], wanted: Wanted, weight: &TokenStream) -> TokenStream {
    let mut parts = TokenStream::new();
    for element in elements {
        let symbol = model.graph.new_symbol("c");
        parts.extend(element_code(model, element, wanted, symbol, weight));
    }
    parts
}

/// One match arm per term, on its number.
fn arms(model: &mut Model, wanted: Wanted) -> TokenStream {
    let one = quote!(<__S as __wzvi::Scalar>::from_f64(1.0));
    let code = |model: &mut Model, elements: &[Element]| terms_code(model, elements, wanted, &one);
    let drift = model.drift.elements.clone();
    let drift = code(model, &drift);
    let mut arms = quote!(0 => { #drift });
    match &model.noises {
        Noises::List(terms) => {
            for (k, term) in terms.clone().iter().enumerate() {
                let (number, body) = (k + 1, code(model, &term.elements));
                arms.extend(quote!(#number => { #body }));
            }
        }
        Noises::Family { term, variable: id, count } => {
            let name = variable(*id);
            let count = Indices { tables: &model.tables, checked: false }.value(count);
            // The member is given: its loop goes once.
            let elements: Vec<Element> = term
                .elements
                .iter()
                .map(|element| Element { loops: element.loops[1..].to_vec(), ..element.clone() })
                .collect();
            let isize = quote!(__wzvi::core::primitive::isize);
            let body = code(model, &elements);
            arms.extend(quote! {
                __member if __member <= (#count as #isize as __wzvi::core::primitive::usize) => {
                    let #name = __member as #isize - 1;
                    #body
                }
            });
        }
    }
    arms
}

/// `impl Discretized<E>`
fn discretized(model: &Model, facts: &Facts, embedding: &Embedding, text: &str) -> TokenStream {
    let chosen = unknowns(model, facts, embedding);
    let plan = plan(model, facts, embedding, chosen);
    let scheme = embedding_type(embedding, &quote!(__wzvi));
    let (drift_l, noise_l) = embedding.quadrature();
    let (drift_l, noise_l) = (drift_l.to_f64(), noise_l.to_f64());
    let has_noise = !model.noises.is_empty();
    let remembers = !has_noise && chosen != Unknowns::None;
    let chosen = match chosen {
        Unknowns::None => quote!(None),
        Unknowns::Momenta => quote!(Momenta),
        Unknowns::Both => quote!(Both),
    };
    let counter = if facts.counter_of(embedding).is_empty() { 0.0 } else { 0.5 - noise_l };
    let nan_checks = model.parameters.iter().map(|parameter| &parameter.tokens);
    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let f64 = f64_type();
    let elements = quote!(__wzvi::elements);
    quote! {
        const _: () = {
            const __SCHEME: #elements::Scheme = #elements::Scheme {
                drift_l: #drift_l,
                noise_l: #noise_l,
                counter: #counter,
                unknowns: #elements::Unknowns::#chosen,
                remembers: #remembers,
                has_noise: #has_noise,
            };

            #[automatically_derived]
            impl #generics __wzvi::Discretized<#scheme> for #name #arguments #filter {
                const PLAN: __wzvi::Plan = #plan;
                const EQUATIONS: &'static __wzvi::core::primitive::str = #text;
                // A start that is no guide costs iterations, not digits.
                const REMEMBERS: __wzvi::core::primitive::bool = false;
                const IN_LANES: __wzvi::core::primitive::bool = false;
                type Prepared = ();
                type Memory<__S: __wzvi::Scalar> = #elements::Memory<__S>;
                type Compensated<__S: __wzvi::Scalar> = #elements::CompensationVec<__S>;
                type Carry<__S: __wzvi::Scalar> = __wzvi::Plain;

                fn memory(&self) -> #elements::Memory<#f64> {
                    #elements::Memory::new(self, &__SCHEME)
                }

                fn forget(__memory: &mut #elements::Memory<#f64>) {
                    __memory.forget();
                }

                fn pin(__memory: &mut #elements::Memory<#f64>, __iteration: #elements::Iteration) {
                    __memory.pin(__iteration);
                }

                fn pinned(__memory: &#elements::Memory<#f64>) -> #elements::Iteration {
                    __memory.pinned()
                }

                fn adopt(__memory: &mut #elements::Memory<#f64>, __left: #elements::Memory<#f64>) {
                    __memory.adopt(__left);
                }

                fn method(__memory: &#elements::Memory<#f64>) -> __wzvi::core::option::Option<#elements::Method> {
                    __wzvi::core::option::Option::Some(__memory.method())
                }

                fn prepare(&self, __h: #f64) -> __wzvi::core::result::Result<(), __wzvi::ConfigError> {
                    #(
                        if #f64::is_nan(#nan_checks) {
                            return __wzvi::core::result::Result::Err(__wzvi::ConfigError::Parameter);
                        }
                    )*
                    #elements::prepare(self)
                }

                fn advance_carrying<
                    __S: __wzvi::Scalar,
                    __C: __wzvi::Carry<__S>,
                    const __CAREFUL: __wzvi::core::primitive::bool,
                >(
                    &self,
                    __prepared: &(),
                    __t: #f64,
                    __h: #f64,
                    __q: &mut [__S],
                    __p: &mut [__S],
                    __dw: &[__S],
                    __memory: &mut #elements::Memory<__S>,
                    __carry: &mut __C,
                ) -> __wzvi::core::result::Result<__wzvi::Effort, __wzvi::StepFailure> {
                    #elements::advance::<_, __S, __C, __CAREFUL>(
                        self, &__SCHEME, __t, __h, __q, __p, __dw, __memory, __carry,
                    )
                }

                fn discrete_lagrangian(
                    &self,
                    __segment: &__wzvi::Segment<Self::Vector>,
                    __dw: &[#f64],
                ) -> #f64 {
                    #elements::discrete_lagrangian(self, &__SCHEME, __segment, __dw)
                }

                fn discrete_lagrangian_gradient(
                    &self,
                    __segment: &__wzvi::Segment<Self::Vector>,
                    __dw: &[#f64],
                ) -> __wzvi::LagrangianGradient<Self::Vector> {
                    #elements::discrete_lagrangian_gradient(self, &__SCHEME, __segment, __dw)
                }

                fn step_momentum(
                    &self,
                    __before: &__wzvi::State<Self::Vector>,
                    _: &__wzvi::State<Self::Vector>,
                    __h: #f64,
                    __dw: &[#f64],
                ) -> Self::Vector {
                    #elements::step_momentum(self, &__SCHEME, __before, __h, __dw)
                }
            }
        };
    }
}

fn plan(model: &Model, facts: &Facts, embedding: &Embedding, chosen: Unknowns) -> TokenStream {
    let noise = match facts.noise {
        NoiseClass::None => quote!(None),
        NoiseClass::Additive => quote!(Additive),
        NoiseClass::Position => quote!(Position),
        NoiseClass::Momentum => quote!(Momentum),
        NoiseClass::Multiplicative => quote!(Multiplicative),
    };
    let knowledge = |known: &Knowledge| match known {
        Knowledge::Proven => quote!(Proven),
        Knowledge::Refuted(_) => quote!(Refuted),
        Knowledge::Unknown => quote!(Unknown),
    };
    let solver = if chosen == Unknowns::None { quote!(Explicit) } else { quote!(Newton) };
    let per_degree: usize = match chosen {
        Unknowns::None => 0,
        Unknowns::Momenta => 1,
        Unknowns::Both => 2,
    };
    let components = usize::try_from(model.components).unwrap_or(1);
    let unknowns = match (&model.shape, per_degree) {
        (_, 0) => quote!(0),
        (Shape::Array(_, Length::Literal(len)), _) => {
            let unknowns = len * components * per_degree;
            quote!(#unknowns)
        }
        (Shape::Array(_, Length::Named(expr)), _) => quote!((#expr) * #components * #per_degree),
        _ => quote!(__wzvi::core::primitive::usize::MAX),
    };
    let consistent = is_consistent(facts, embedding);
    let (energy, commuting) = (knowledge(&facts.conserves_energy), knowledge(&facts.commuting));
    quote! {
        __wzvi::Plan {
            solver: __wzvi::Solver::#solver,
            unknowns: #unknowns,
            noise: __wzvi::NoiseClass::#noise,
            consistent: #consistent,
            conserves_energy: __wzvi::Knowledge::#energy,
            commuting: __wzvi::Knowledge::#commuting,
        }
    }
}
