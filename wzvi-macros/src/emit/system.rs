//! `impl Hamiltonian`: the energies, their gradients, the first integrals and the energy rates.

use std::collections::HashMap;

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::print::{Printer, f64_type};
use super::program::{Level, Lowering, Op};
use crate::discretise::facts::Facts;
use crate::model::{Model, Parameter, Phase};
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

/// Emits the evaluation of `roots` in the scalar type `scalar`.
pub(crate) fn body(
    graph: &mut Graph,
    parameters: &[Parameter],
    inputs: &Inputs,
    scalar: &TokenStream,
    roots: &[Expr],
) -> Body {
    let mut lowering = Lowering::new(graph, inputs.definitions.clone());
    let mut bound: Vec<(Op, Ident)> = Vec::new();
    for (symbol, name, level) in &inputs.names {
        lowering.program.declare(*symbol, *level);
        bound.push((lowering.program.input(*symbol), name.clone()));
    }
    let mut reads = Vec::new();
    for (i, parameter) in parameters.iter().enumerate() {
        lowering.program.declare(parameter.symbol, Level::Prepared);
        let op = lowering.program.input(parameter.symbol);
        reads.push((op, format_ident!("__a{i}"), &parameter.tokens));
    }
    let roots: Vec<Op> = roots.iter().map(|&root| lowering.lower(root)).collect();
    let program = &lowering.program;
    let uses = program.uses(&roots);
    let hints = HashMap::new();
    let mut printer = Printer::new(program, scalar.clone(), &hints);
    for (op, name) in bound {
        printer.set(op, name);
    }
    let mut statements = TokenStream::new();
    let f64 = f64_type();
    for (op, name, tokens) in reads {
        if uses[op] > 0 {
            statements.extend(quote!(let #name: #f64 = #tokens;));
            printer.set(op, name);
        }
    }
    statements.extend(printer.bind(&roots, &uses, &|_| false));
    let values = roots.iter().map(|&root| printer.scalar_value(root)).collect();
    Body { statements, values }
}

/// Names `__q0...`, `__p0...` and `__t` for the phase space.
pub(crate) fn phase_inputs(phase: &Phase) -> Inputs {
    let mut inputs = Inputs::default();
    for (i, &symbol) in phase.q.iter().enumerate() {
        inputs.names.push((symbol, format_ident!("__q{i}"), Level::State));
    }
    for (i, &symbol) in phase.p.iter().enumerate() {
        inputs.names.push((symbol, format_ident!("__p{i}"), Level::State));
    }
    inputs.names.push((phase.t, format_ident!("__t"), Level::Time));
    inputs
}

/// `__q0, __q1, ...`
pub(crate) fn indexed(prefix: &str, n: usize) -> Vec<Ident> {
    (0..n).map(|i| format_ident!("__{prefix}{i}")).collect()
}

pub(crate) fn emit(model: &mut Model, facts: &Facts) -> TokenStream {
    let d = model.phase.q.len();
    let noises = model.noise.len();
    let invariants = model.invariants.len();
    let terms: Vec<Expr> = [model.drift].iter().chain(&model.noise).map(|term| term.value).collect();
    let integrals: Vec<Expr> = model.invariants.iter().map(|f| f.value).collect();
    let gradients: Vec<Vec<Expr>> = terms
        .iter()
        .map(|&term| {
            let symbols: Vec<Symbol> = model.phase.q.iter().chain(&model.phase.p).copied().collect();
            symbols.into_iter().map(|symbol| model.graph.derivative(term, symbol)).collect()
        })
        .collect();

    let scalar = quote!(__S);
    let f64 = f64_type();
    let evaluate = arms(model, &scalar, &terms.iter().map(|&e| vec![e]).collect::<Vec<_>>(), &value_arm);
    let differentiate = arms(model, &scalar, &gradients, &|values| {
        let (dq, dp) = values.split_at(d);
        quote!({
            *__dq = [#(#dq),*];
            *__dp = [#(#dp),*];
        })
    });
    let rates: Vec<Vec<Expr>> =
        facts.energy_rate_values(&mut model.graph).into_iter().map(|rate| vec![rate]).collect();
    let rates = arms(model, &f64, &rates, &value_arm);
    let integrals = arms(model, &f64, &integrals.iter().map(|&e| vec![e]).collect::<Vec<_>>(), &value_arm);
    let of_state = quote! {
        let (__q, __p, __t) =
            (__wzvi::Vector::components(&__state.q), __wzvi::Vector::components(&__state.p), __state.t);
    };

    let parameter = parameter(&model.graph, &model.parameters);

    let name = &model.item.ident;
    let (generics, arguments, filter) = model.item.generics.split_for_impl();
    let size = quote!(__wzvi::core::primitive::usize);
    quote! {
        #[automatically_derived]
        impl #generics __wzvi::Hamiltonian for #name #arguments #filter {
            type Vector = __wzvi::SVector<#f64, #d>;

            fn degrees(&self) -> #size { #d }

            fn noises(&self) -> #size { #noises }

            fn invariants(&self) -> #size { #invariants }

            #parameter

            fn evaluate<__S: __wzvi::Scalar>(&self, __term: #size, __q: &[__S], __p: &[__S], __t: #f64) -> __S {
                match (__term, __q, __p) {
                    #(#evaluate)*
                    _ => __S::from_f64(#f64::NAN),
                }
            }

            fn differentiate<__S: __wzvi::Scalar>(
                &self,
                __term: #size,
                __q: &[__S],
                __p: &[__S],
                __t: #f64,
                __dq: &mut [__S],
                __dp: &mut [__S],
            ) {
                if let (__wzvi::core::result::Result::Ok(__dq), __wzvi::core::result::Result::Ok(__dp)) =
                    (__wzvi::array_mut::<__S, #d>(__dq), __wzvi::array_mut::<__S, #d>(__dp))
                {
                    match (__term, __q, __p) {
                        #(#differentiate)*
                        _ => {
                            *__dq = [__S::from_f64(#f64::NAN); #d];
                            *__dp = [__S::from_f64(#f64::NAN); #d];
                        }
                    }
                } else {
                    __dq.fill(__S::from_f64(#f64::NAN));
                    __dp.fill(__S::from_f64(#f64::NAN));
                }
            }

            fn invariant(&self, __term: #size, __state: &__wzvi::State<Self::Vector>) -> #f64 {
                #of_state
                match (__term, __q, __p) {
                    #(#integrals)*
                    _ => #f64::NAN,
                }
            }

            fn energy_rate(&self, __term: #size, __state: &__wzvi::State<Self::Vector>) -> #f64 {
                #of_state
                match (__term, __q, __p) {
                    #(#rates)*
                    _ => #f64::NAN,
                }
            }
        }
    }
}

/// Names and values of the parameters; the default of the trait if there are none.
pub(crate) fn parameter(graph: &Graph, parameters: &[Parameter]) -> Option<TokenStream> {
    let (f64, option) = (f64_type(), quote!(__wzvi::core::option::Option));
    let arms = parameters.iter().enumerate().map(|(i, Parameter { symbol, tokens })| {
        let name = graph.symbol_name(*symbol);
        quote!(#i => #option::Some((#name, #tokens)),)
    });
    (!parameters.is_empty()).then(|| {
        quote! {
            fn parameter(
                &self,
                __index: __wzvi::core::primitive::usize,
            ) -> #option<(&'static __wzvi::core::primitive::str, #f64)> {
                match __index {
                    #(#arms)*
                    _ => #option::None,
                }
            }
        }
    })
}

fn value_arm(values: &[TokenStream]) -> TokenStream {
    let value = &values[0];
    quote!(#value)
}

/// One match arm per entry of `roots`, on (index, q, p).
fn arms(
    model: &mut Model,
    scalar: &TokenStream,
    roots: &[Vec<Expr>],
    finish: &dyn Fn(&[TokenStream]) -> TokenStream,
) -> Vec<TokenStream> {
    let d = model.phase.q.len();
    let (q, p) = (indexed("q", d), indexed("p", d));
    let inputs = phase_inputs(&model.phase);
    roots
        .iter()
        .enumerate()
        .map(|(i, roots)| {
            let Body { statements, values } =
                body(&mut model.graph, &model.parameters, &inputs, scalar, roots);
            let result = finish(&values);
            quote! {
                (#i, &[#(#q),*], &[#(#p),*]) => {
                    #statements
                    #result
                }
            }
        })
        .collect()
}
