//! `impl Hamiltonian`: the energies, their gradients, the first integrals and the energy rates.

use std::collections::HashMap;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::names::Names;
use super::print::{Printer, f64_type};
use super::program::{Level, Lowering, Op};
use crate::diagnostics::Located;
use crate::embedding::Embedding;
use crate::input::Labels;
use crate::model::{Model, Parameter};
use crate::symbolic::{Expr, Graph, Symbol};

/// A function body that evaluates expressions of symbols which are bound to names before it.
pub(crate) struct Body {
    /// Reads the parameters that are used, then computes what is shared.
    pub(crate) statements: TokenStream,
    /// One expression per root.
    pub(crate) values: Vec<TokenStream>,
}

/// Where the symbols of a [`Body`] come from.
#[derive(Default)]
pub(crate) struct Inputs {
    pub(crate) names: Vec<(Symbol, Ident, Level)>,
    pub(crate) definitions: HashMap<Symbol, Expr>,
}

/// What the numbers that a step is made of are called in a body.
pub(crate) struct Letters {
    pub(crate) q: Vec<Ident>,
    pub(crate) p: Vec<Ident>,
    pub(crate) parameters: Vec<Ident>,
    /// All that is taken.
    pub(crate) names: Names,
}

impl Letters {
    /// The user's names, beside `names`.
    pub(crate) fn of(model: &Model, names: Names) -> Self {
        let mut letters = Self::of_state(model, names);
        letters.parameters = parameter_names(&mut letters.names, &model.graph, &model.parameters);
        letters
    }

    /// The same without parameters.
    pub(crate) fn of_state(model: &Model, mut names: Names) -> Self {
        let of_symbols = |names: &mut Names, symbols: &[Symbol]| {
            names.take_all(symbols.iter().map(|&symbol| model.graph.symbol_name(symbol)))
        };
        let (q, p) = (of_symbols(&mut names, &model.phase.q), of_symbols(&mut names, &model.phase.p));
        Self { q, p, parameters: Vec::new(), names }
    }
}

/// Names of parameters: those of the fields, and those of constants in the letters of variables.
pub(crate) fn parameter_names(names: &mut Names, graph: &Graph, parameters: &[Parameter]) -> Vec<Ident> {
    let wish = |Parameter { symbol, tokens }: &Parameter| {
        let name = graph.symbol_name(*symbol);
        let is_field = tokens.to_string().contains("self");
        if is_field { name.to_owned() } else { format!("constant_{}", name.to_lowercase()) }
    };
    names.take_all(parameters.iter().map(wish))
}

/// Emits the evaluation of `roots` in the scalar type `scalar`.
pub(crate) fn body(
    model: &mut Model,
    letters: &Letters,
    inputs: &Inputs,
    scalar: &TokenStream,
    roots: &[Expr],
) -> Body {
    evaluation((&mut model.graph, &model.parameters), letters, inputs, scalar, roots)
}

/// The same with a graph and the parameters that it reads.
pub(crate) fn evaluation(
    model: (&mut Graph, &[Parameter]),
    letters: &Letters,
    inputs: &Inputs,
    scalar: &TokenStream,
    roots: &[Expr],
) -> Body {
    let (body, reads) = evaluation_over(model, letters, inputs, (scalar, None), roots);
    let f64 = f64_type();
    let reads = reads.iter().map(|(name, tokens)| quote!(let #name: #f64 = #tokens;));
    let statements = body.statements;
    Body { statements: quote!(#(#reads)* #statements), ..body }
}

/// The same without its beginning, where parameters of the system are bound to names: these, and what they are in the system. They are numbers
/// of a type of their own, if there is one.
pub(crate) fn evaluation_over(
    (graph, parameters): (&mut Graph, &[Parameter]),
    letters: &Letters,
    inputs: &Inputs,
    (scalar, constant): (&TokenStream, Option<TokenStream>),
    roots: &[Expr],
) -> (Body, Vec<(Ident, TokenStream)>) {
    let mut lowering = Lowering::new(graph, inputs.definitions.clone());
    let mut bound: Vec<(Op, Ident)> = Vec::new();
    for (symbol, name, level) in &inputs.names {
        lowering.program.declare(*symbol, *level);
        bound.push((lowering.program.input(*symbol), name.clone()));
    }
    let mut reads = Vec::new();
    for (name, parameter) in letters.parameters.iter().zip(parameters) {
        lowering.program.declare(parameter.symbol, Level::Prepared);
        let op = lowering.program.input(parameter.symbol);
        reads.push((op, name.clone(), &parameter.tokens));
    }
    let roots: Vec<Op> = roots.iter().map(|&root| lowering.lower(root)).collect();
    let program = &lowering.program;
    let uses = program.uses(&roots);
    let hints = HashMap::new();
    let mut printer = Printer::new(program, scalar.clone(), &hints, letters.names.clone());
    if let Some(constant) = constant {
        let constants: Vec<Op> = reads.iter().map(|(op, ..)| *op).collect();
        printer = printer.with_constants(&constants, constant);
    }
    for (op, name) in bound {
        printer.set(op, name);
    }
    reads.retain(|(op, ..)| uses[*op] > 0);
    for (op, name, _) in &reads {
        printer.set(*op, name.clone());
    }
    let statements = printer.bind(&roots, &uses, &|_| false);
    let values = roots.iter().map(|&root| printer.scalar_value(root)).collect();
    let reads = reads.into_iter().map(|(_, name, tokens)| (name, tokens.clone()));
    (Body { statements, values }, reads.collect())
}

/// `impl Hamiltonian`
pub(crate) fn emit(model: &mut Model) -> TokenStream {
    let (f64, degrees) = (f64_type(), count(model.phase.q.len()));
    let noises = (model.noises() > 0).then(|| {
        let noises = count(model.noises());
        number_of("noises", &quote!(#noises))
    });
    let invariants = invariants(&model.invariant_names);
    let reads_time = model.graph.depends_on(model.drift.value, &[model.phase.t]).then(reads_time);
    let parameter = parameter(&model.graph, &model.parameters);
    let variables = variables(&model.labels, model.graph.symbol_name(model.phase.t));
    let mut terms: Vec<Expr> = [model.drift].iter().chain(&model.noise).map(|term| term.value).collect();
    // Noise forces have no energy.
    terms.extend(model.noise_forces.iter().map(|_| model.graph.integer(0)));
    let evaluate = evaluate(model, &terms);
    let differentiate = differentiate(model, &terms);
    let (force, friction, validate) =
        (force(model), friction(model), validate(&model.embeddings, model.bath.is_some()));
    let invariant = invariant(model);

    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::Hamiltonian for #name #arguments #filter {
            type Vector = __wzvi::SVector<#f64, #degrees>;

            #reads_time

            fn degrees(&self) -> __wzvi::usize {
                #degrees
            }

            #friction

            #noises

            #invariants

            #variables

            #parameter

            #evaluate

            #differentiate

            #force

            #validate

            #invariant
        }
    }
}

/// What a system says of itself whose drift reads the time.
pub(crate) fn reads_time() -> TokenStream {
    quote!(
        const READS_TIME: __wzvi::bool = true;
    )
}

/// `Hamiltonian::force`; nothing if there is none.
fn force(model: &mut Model) -> Option<TokenStream> {
    let components = vec![model.force.clone()?];
    let arms =
        arms(model, &quote!(__S), &components, &|values| quote!(__wzvi::covector(__into, [#(#values),*])));
    let f64 = f64_type();
    Some(quote! {
        const IS_FORCED: __wzvi::bool = true;

        fn force<__S: __wzvi::Scalar>(&self, __q: &[__S], __p: &[__S], __t: #f64, __into: &mut [__S]) {
            match (0, __q, __p) {
                #(#arms)*
                _ => __into.fill(__S::from_f64(#f64::NAN)),
            }
        }
    })
}

/// The rate of friction that steps take in; nothing if there is none.
fn friction(model: &mut Model) -> Option<TokenStream> {
    let rate = model.conformal?;
    Some(friction_rate(&mut model.graph, &model.parameters, rate))
}

/// `Hamiltonian::validate` of a system whose steps have friction and no bath; with a bath that is done where its steps are prepared.
pub(crate) fn validate(embeddings: &[Located<Embedding>], has_friction: bool) -> Option<TokenStream> {
    let is_bare = embeddings.iter().all(|known| !known.value.is_thermostat());
    (has_friction && is_bare).then(|| {
        quote! {
            fn validate(&self) -> __wzvi::Result<(), __wzvi::ConfigError> {
                __wzvi::bath::validate(self)
            }
        }
    })
}

/// What a system with friction that steps take in says of itself.
pub(crate) fn friction_rate(graph: &mut Graph, parameters: &[Parameter], rate: Expr) -> TokenStream {
    let f64 = f64_type();
    let mut names = Names::default();
    let own = parameter_names(&mut names, graph, parameters);
    let letters = Letters { q: Vec::new(), p: Vec::new(), parameters: own, names };
    let Body { statements, values } =
        evaluation((graph, parameters), &letters, &Inputs::default(), &f64, &[rate]);
    let rate = quote!(#statements #(#values)*);
    quote! {
        const IS_CONFORMAL: __wzvi::bool = true;

        fn friction_rate(&self) -> #f64 {
            #rate
        }
    }
}

/// A number where a `usize` is expected.
pub(crate) fn count(number: usize) -> Literal {
    Literal::usize_unsuffixed(number)
}

/// A method that says how many there are; the trait says none.
pub(crate) fn number_of(name: &str, number: &TokenStream) -> TokenStream {
    let name = format_ident!("{name}");
    quote! {
        fn #name(&self) -> __wzvi::usize {
            #number
        }
    }
}

/// `Hamiltonian::evaluate`
fn evaluate(model: &mut Model, terms: &[Expr]) -> TokenStream {
    let roots: Vec<Vec<Expr>> = terms.iter().map(|&term| vec![term]).collect();
    let arms = arms(model, &quote!(__S), &roots, &|values| quote!(#(#values)*));
    let f64 = f64_type();
    quote! {
        fn evaluate<__S: __wzvi::Scalar>(&self, __term: __wzvi::usize, __q: &[__S], __p: &[__S], __t: #f64) -> __S {
            match (__term, __q, __p) {
                #(#arms)*
                _ => __S::from_f64(#f64::NAN),
            }
        }
    }
}

/// `Hamiltonian::differentiate`
fn differentiate(model: &mut Model, terms: &[Expr]) -> TokenStream {
    let symbols: Vec<Symbol> = model.phase.q.iter().chain(&model.phase.p).copied().collect();
    let mut gradients: Vec<Vec<Expr>> = terms
        .iter()
        .map(|&term| symbols.iter().map(|&symbol| model.graph.derivative(term, symbol)).collect())
        .collect();
    let first = gradients.len() - model.noise_forces.len();
    for (gradient, force) in gradients[first..].iter_mut().zip(&model.noise_forces) {
        for (slope, &component) in gradient.iter_mut().zip(force) {
            *slope = model.graph.negate(component);
        }
    }
    let d = model.phase.q.len();
    let arms = arms(model, &quote!(__S), &gradients, &|values| {
        let (by_q, by_p) = values.split_at(d);
        quote!(__wzvi::gradient(__by_q, __by_p, [#(#by_q),*], [#(#by_p),*]))
    });
    let f64 = f64_type();
    quote! {
        fn differentiate<__S: __wzvi::Scalar>(
            &self,
            __term: __wzvi::usize,
            __q: &[__S],
            __p: &[__S],
            __t: #f64,
            __by_q: &mut [__S],
            __by_p: &mut [__S],
        ) {
            match (__term, __q, __p) {
                #(#arms)*
                _ => {
                    __by_q.fill(__S::from_f64(#f64::NAN));
                    __by_p.fill(__S::from_f64(#f64::NAN));
                }
            }
        }
    }
}

/// `Hamiltonian::invariant`; nothing if there are no first integrals, which the trait says itself.
fn invariant(model: &mut Model) -> Option<TokenStream> {
    let roots: Vec<Vec<Expr>> = model.invariants.iter().map(|integral| vec![integral.value]).collect();
    if roots.is_empty() {
        return None;
    }
    let f64 = f64_type();
    let arms = arms(model, &f64, &roots, &|values| quote!(#(#values)*));
    let reads_time = roots.iter().flatten().any(|&value| model.graph.depends_on(value, &[model.phase.t]));
    let t = reads_time.then(|| quote!(let __t = __state.t;));
    Some(quote! {
        fn invariant(&self, __index: __wzvi::usize, __state: &__wzvi::State<Self::Vector>) -> #f64 {
            #t
            match (__index, __wzvi::Vector::components(&__state.q), __wzvi::Vector::components(&__state.p)) {
                #(#arms)*
                _ => #f64::NAN,
            }
        }
    })
}

/// Names and values of the parameters; the default of the trait if there are none.
pub(crate) fn parameter(graph: &Graph, parameters: &[Parameter]) -> Option<TokenStream> {
    let (f64, option) = (f64_type(), quote!(__wzvi::Option));
    let entries = parameters.iter().map(|Parameter { symbol, tokens }| {
        let name = graph.symbol_name(*symbol);
        quote!((#name, #tokens))
    });
    (!parameters.is_empty()).then(|| {
        quote! {
            fn parameter(&self, __index: __wzvi::usize) -> #option<(&'static __wzvi::str, #f64)> {
                [#(#entries),*].get(__index).copied()
            }
        }
    })
}

/// How many first integrals there are, and their names; the defaults of the trait if there are none.
pub(crate) fn invariants(names: &[String]) -> Option<TokenStream> {
    let number = count(names.len());
    let number = (!names.is_empty()).then(|| number_of("invariants", &quote!(#number)))?;
    let str = quote!(&'static __wzvi::str);
    let names = names.iter().any(|name| !name.is_empty()).then(|| {
        quote! {
            fn invariant_names(&self) -> &'static [#str] {
                &[#(#names),*]
            }
        }
    });
    Some(quote!(#number #names))
}

/// What people are told that the variables are called; the default of the trait if that is the same.
pub(crate) fn variables(labels: &[Labels; 2], t: &str) -> Option<TokenStream> {
    let is_default = |labels: &Labels, name: &str| match labels {
        Labels::Each(names) => *names == [name],
        Labels::Array(array, inner) => array == name && inner.is_empty(),
    };
    let [q, p] = labels;
    if t == "t" && is_default(q, "q") && is_default(p, "p") {
        return None;
    }
    let [q, p] = labels.each_ref().map(|labels| match labels {
        Labels::Each(names) => quote!(__wzvi::Labels::Each(&[#(#names),*])),
        Labels::Array(name, inner) => {
            let inner = inner.iter().map(|&length| count(length));
            quote!(__wzvi::Labels::Array { name: #name, inner: &[#(#inner),*] })
        }
    });
    Some(quote! {
        fn variables(&self) -> __wzvi::Variables {
            __wzvi::Variables { q: #q, p: #p, t: #t }
        }
    })
}

/// One match arm per entry of `roots`, on (index, q, p); `t` is in scope.
fn arms(
    model: &mut Model,
    scalar: &TokenStream,
    roots: &[Vec<Expr>],
    finish: &dyn Fn(&[TokenStream]) -> TokenStream,
) -> Vec<TokenStream> {
    let letters = Letters::of(model, Names::default());
    let (q, p) = (&letters.q, &letters.p);
    let state = model.phase.q.iter().zip(q).chain(model.phase.p.iter().zip(p));
    let mut names: Vec<_> = state.map(|(&symbol, name)| (symbol, name.clone(), Level::State)).collect();
    names.push((model.phase.t, format_ident!("__t"), Level::Time));
    let inputs = Inputs { names, definitions: HashMap::new() };
    roots
        .iter()
        .enumerate()
        .map(|(i, roots)| {
            let Body { statements, values } = body(model, &letters, &inputs, scalar, roots);
            let (i, result) = (count(i), finish(&values));
            let result = if statements.is_empty() { result } else { quote!({ #statements #result }) };
            quote!((#i, &[#(#q),*], &[#(#p),*]) => #result,)
        })
        .collect()
}
