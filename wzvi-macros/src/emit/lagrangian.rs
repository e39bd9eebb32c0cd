//! The discrete Lagrangian and its gradient as functions of one segment.

use std::collections::HashMap;

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::names::{Names, plain};
use super::print::f64_type;
use super::program::Level;
use super::step::increment_names;
use super::system::{Body, Inputs, Letters, body};
use crate::discretise::Scheme;
use crate::model::Model;
use crate::symbolic::{Expr, Rational, Symbol};

/// The bodies of `discrete_lagrangian` and `discrete_lagrangian_gradient`.
pub(crate) struct Bodies {
    pub(crate) value: TokenStream,
    pub(crate) gradient: TokenStream,
}

pub(crate) fn emit(model: &mut Model, scheme: &Scheme) -> Bodies {
    let d = scheme.lagrangian.symbols.u.len();
    let segment = Segment::new(model, scheme);
    let f64 = f64_type();
    let lagrangian = &scheme.lagrangian;
    let value = [lagrangian.value];
    let gradient: Vec<Expr> = [&lagrangian.by_start, &lagrangian.by_end, &lagrangian.by_momentum]
        .into_iter()
        .flatten()
        .copied()
        .collect();
    let (open_value, open_gradient) = (segment.open(model, &value), segment.open(model, &gradient));
    let value = body(model, &segment.letters, &segment.inputs, &f64, &value);
    let gradient = body(model, &segment.letters, &segment.inputs, &f64, &gradient);
    let (Body { statements, values }, gradient_statements) = (value, gradient.statements);
    let (by_start, rest) = gradient.values.split_at(d);
    let (by_end, by_momentum) = rest.split_at(d);
    Bodies {
        value: quote! {
            #open_value else {
                return #f64::NAN;
            };
            #statements
            #(#values)*
        },
        gradient: quote! {
            #open_gradient else {
                return __wzvi::LagrangianGradient::not_a_number();
            };
            #gradient_statements
            __wzvi::LagrangianGradient::from_components([#(#by_start),*], [#(#by_end),*], [#(#by_momentum),*])
        },
    }
}

/// What the functions of a segment read: `q_i`, `q_{i+1}`, `P`, `t`, `h` and `ΔW`; `u = q_{i+1} - q_i` and
/// `Q_l = (1-l) q_i + l q_{i+1}` follow.
struct Segment {
    inputs: Inputs,
    letters: Letters,
    start: Vec<Ident>,
    end: Vec<Ident>,
    dw: Vec<Ident>,
    h: Symbol,
    t: Symbol,
}

impl Segment {
    fn new(model: &mut Model, scheme: &Scheme) -> Self {
        let symbols = &scheme.lagrangian.symbols;
        let mut letters = Letters::of(model, Names::default());
        let dw = increment_names(&mut letters.names, symbols.dw.len());
        let [start, end] = ["start", "end"].map(|node| {
            let wishes = letters.q.iter().map(|q| format!("{}_{node}", plain(&q.to_string())));
            letters.names.take_all(wishes.collect::<Vec<_>>())
        });
        let graph = &mut model.graph;
        let mut names = Vec::new();
        let mut definitions = HashMap::new();
        for i in 0..symbols.u.len() {
            let symbol = graph.new_symbol("");
            names.push((symbols.q0[i], start[i].clone(), Level::State));
            names.push((symbol, end[i].clone(), Level::State));
            names.push((symbols.momentum[i], letters.p[i].clone(), Level::State));
            let (first, last) = (graph.symbol(symbols.q0[i]), graph.symbol(symbol));
            definitions.insert(symbols.u[i], graph.subtract(last, first));
            for stage in &symbols.stages {
                let point = graph.linear_combination(&[(first, stage.at.start()), (last, stage.at.end())]);
                definitions.insert(stage.q[i], point);
            }
        }
        names.extend(symbols.dw.iter().zip(&dw).map(|(&symbol, name)| (symbol, name.clone(), Level::State)));
        names.push((symbols.h, format_ident!("__h"), Level::Prepared));
        names.push((symbols.t, format_ident!("__t"), Level::Time));
        let (t, h) = (graph.symbol(symbols.t), graph.symbol(symbols.h));
        for stage in &symbols.stages {
            definitions.insert(stage.t, graph.linear_combination(&[(t, Rational::ONE), (h, stage.at.l)]));
        }
        let (h, t) = (symbols.h, symbols.t);
        Self { inputs: Inputs { names, definitions }, letters, start, end, dw, h, t }
    }

    /// Takes a segment apart for `values`; what follows is `else`.
    fn open(&self, model: &Model, values: &[Expr]) -> TokenStream {
        let Self { letters: Letters { p, .. }, start, end, dw, inputs, .. } = self;
        let reads = |symbol: Symbol| {
            let points =
                inputs.definitions.iter().filter(|(_, value)| model.graph.depends_on(**value, &[symbol]));
            let symbols: Vec<Symbol> = points.map(|(&point, _)| point).chain([symbol]).collect();
            values.iter().any(|&value| model.graph.depends_on(value, &symbols))
        };
        let t = reads(self.t).then(|| quote!(let __t = __segment.t;));
        let h = reads(self.h).then(|| quote!(let __h = __segment.h;));
        quote! {
            #t
            #h
            let (&[#(#start),*], &[#(#end),*], &[#(#p),*], &[#(#dw),*]) = (
                __wzvi::Vector::components(&__segment.q0),
                __wzvi::Vector::components(&__segment.q1),
                __wzvi::Vector::components(&__segment.p),
                __dw,
            )
        }
    }
}
