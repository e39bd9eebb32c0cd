//! The discrete Lagrangian and its gradient as functions of one segment.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::print::f64_type;
use super::program::Level;
use super::system::{Body, Inputs, body, indexed};
use crate::discretise::Scheme;
use crate::model::Model;
use crate::symbolic::{Expr, Rational};

/// The methods `discrete_lagrangian` and `discrete_lagrangian_gradient`.
pub(crate) fn emit(model: &mut Model, scheme: &Scheme) -> TokenStream {
    let symbols = &scheme.lagrangian.symbols;
    let d = symbols.u.len();
    let noises = symbols.dw.len();
    let inputs = segment_inputs(model, scheme);
    let f64 = f64_type();
    let lagrangian = &scheme.lagrangian;
    let value = body(&mut model.graph, &model.parameters, &inputs, &f64, &[lagrangian.value]);
    let gradient: Vec<Expr> = [&lagrangian.by_start, &lagrangian.by_end, &lagrangian.by_momentum]
        .into_iter()
        .flatten()
        .copied()
        .collect();
    let gradient = body(&mut model.graph, &model.parameters, &inputs, &f64, &gradient);

    let (q0, q1, p, dw) = (indexed("b", d), indexed("e", d), indexed("p", d), indexed("w", noises));
    let segment = quote! {
        let (__h, __t) = (__segment.h, __segment.t);
        let (&[#(#q0),*], &[#(#q1),*], &[#(#p),*], &[#(#dw),*]) = (
            __wzvi::Vector::components(&__segment.q0),
            __wzvi::Vector::components(&__segment.q1),
            __wzvi::Vector::components(&__segment.p),
            __dw,
        )
    };
    let Body { statements: value_statements, values } = value;
    let value = &values[0];
    let Body { statements: gradient_statements, values: slopes } = gradient;
    let (by_start, rest) = slopes.split_at(d);
    let (by_end, by_momentum) = rest.split_at(d);
    quote! {
        fn discrete_lagrangian(&self, __segment: &__wzvi::Segment<Self::Vector>, __dw: &[#f64]) -> #f64 {
            #segment else {
                return #f64::NAN;
            };
            #value_statements
            #value
        }

        fn discrete_lagrangian_gradient(
            &self,
            __segment: &__wzvi::Segment<Self::Vector>,
            __dw: &[#f64],
        ) -> __wzvi::LagrangianGradient<Self::Vector> {
            #segment else {
                let __nan = __wzvi::SVector::repeat(#f64::NAN);
                return __wzvi::LagrangianGradient { q0: __nan, q1: __nan, p: __nan };
            };
            #gradient_statements
            __wzvi::LagrangianGradient {
                q0: __wzvi::core::convert::From::from([#(#by_start),*]),
                q1: __wzvi::core::convert::From::from([#(#by_end),*]),
                p: __wzvi::core::convert::From::from([#(#by_momentum),*]),
            }
        }
    }
}

/// `q_i`, `q_{i+1}`, `P`, `t`, `h` and `ΔW` are given; `u = q_{i+1} - q_i`, `Q_l = (1-l) q_i + l q_{i+1}`.
fn segment_inputs(model: &mut Model, scheme: &Scheme) -> Inputs {
    let symbols = &scheme.lagrangian.symbols;
    let graph = &mut model.graph;
    let mut names = Vec::new();
    let mut definitions = HashMap::new();
    for i in 0..symbols.u.len() {
        let end = graph.new_symbol("");
        names.push((symbols.q0[i], format_ident!("__b{i}"), Level::State));
        names.push((end, format_ident!("__e{i}"), Level::State));
        names.push((symbols.momentum[i], format_ident!("__p{i}"), Level::State));
        let (start, end) = (graph.symbol(symbols.q0[i]), graph.symbol(end));
        definitions.insert(symbols.u[i], graph.subtract(end, start));
        for stage in &symbols.stages {
            let point = graph.linear_combination(&[(start, stage.at.start()), (end, stage.at.end())]);
            definitions.insert(stage.q[i], point);
        }
    }
    for (k, &dw) in symbols.dw.iter().enumerate() {
        names.push((dw, format_ident!("__w{k}"), Level::State));
    }
    names.push((symbols.h, format_ident!("__h"), Level::Prepared));
    names.push((symbols.t, format_ident!("__t"), Level::Time));
    let (t, h) = (graph.symbol(symbols.t), graph.symbol(symbols.h));
    for stage in &symbols.stages {
        definitions.insert(stage.t, graph.linear_combination(&[(t, Rational::ONE), (h, stage.at.l)]));
    }
    Inputs { names, definitions }
}
