//! From closures to expressions: an abstract interpreter of `syn::Expr`. Local closures are inlined, values
//! that depend on the state or on parameters become symbolic, sums become symbols. Two other files read
//! expressions: `input/points.rs` the numbers of quadrature points, `functions/calls.rs` the calls in a body.
//! Tests: `lower/tests`, `tests/accepted`, and for messages `tests/compiler/ui`.

mod arrays;
mod calls;
mod control;
mod covectors;
mod floats;
mod integers;
mod interpreter;
mod loops;
mod matches;
mod methods;
mod names;
mod operators;
mod patterns;
mod scope;
mod sequences;
mod tables;
#[cfg(test)]
mod tests;
mod type_checks;
mod value;

use syn::ext::IdentExt;
use syn::visit::Visit;
use syn::{Expr as Syntax, ReturnType};

use crate::diagnostics::{Diagnostics, Extent, Located, expressions, messages};
use crate::input::{Container, Declaration, DeclaredClock, Hamiltonian, Labels, Length, PhaseSpace, Shape};
use crate::key::Key;
use crate::model::index::{Atom, Index, Loop};
use crate::model::symbols::Symbols;
use crate::model::{
    Clock, ClockKind, Collectives, Family, FamilyTerm, Form, Half, Noise, Slot, System, Term,
};
use crate::symbolic::{Expr, Graph, Symbol, SymbolKind};

use arrays::{Array, Origin};
use interpreter::Interpreter;
use sequences::Sequence;
use tables::Tables;
use value::Value;

pub(crate) use names::{is_constant_name, is_self, key, may_be_shared, type_of};
pub(crate) use patterns::BoundNames;

/// The most members of a family that become separate noises.
const MOST_MEMBERS: i128 = 10_000;

/// Reports each field that has the name of a closure variable, which is ambiguous.
fn check_names(container: &Container, declaration: &Declaration, diagnostics: &mut Diagnostics) {
    let mut names = patterns::BoundNames::default();
    for closure in declaration.in_order() {
        let variables = closure.closure.inputs.len() - usize::from(closure.family.is_some());
        closure.closure.inputs.iter().take(variables).for_each(|pattern| names.visit_pat(pattern));
    }
    for field in &container.fields {
        if let syn::Member::Named(name) = &field.member
            && let Some(variable) = names.0.iter().find(|variable| *variable == name)
        {
            diagnostics.report(messages::field_named_like_variable(variable));
        }
    }
}

/// Reports each observable with the name of another quantity of the system.
fn check_observables(declaration: &Declaration, phase_space: &PhaseSpace, diagnostics: &mut Diagnostics) {
    let mut known: Vec<(String, &str)> = Vec::new();
    for (labels, one, all) in [
        (&phase_space.labels[0], "a coordinate", "the coordinates"),
        (&phase_space.labels[1], "a momentum", "the momenta"),
    ] {
        match labels {
            Labels::Each(names) => known.extend(names.iter().map(|name| (name.clone(), one))),
            Labels::Array(name, _) => known.push((name.clone(), all)),
        }
    }
    known.extend([(phase_space.t.clone(), "the time"), ("energy".to_owned(), "the drift Hamiltonian")]);
    let integrals =
        declaration.of(Key::Invariant).enumerate().map(|(number, integral)| match &integral.name {
            Some(name) => name.unraw().to_string(),
            None => format!("invariant_{number}"),
        });
    known.extend(integrals.map(|name| (name, "a first integral")));
    for name in declaration.of(Key::Observe).filter_map(|observable| observable.name.as_ref()) {
        let text = name.unraw().to_string();
        match known.iter().find(|(taken, _)| *taken == text) {
            Some((_, of)) => diagnostics.report(messages::taken_name(name, of)),
            None => known.push((text, "another observable")),
        }
    }
}

/// Lowers every closure. `None` only after an error was reported.
pub(crate) fn lower(
    container: Container,
    declaration: Declaration,
    phase_space: &PhaseSpace,
    diagnostics: &mut Diagnostics,
) -> Option<System> {
    check_names(&container, &declaration, diagnostics);
    check_observables(&declaration, phase_space, diagnostics);
    if declaration.export.is_some()
        && let Some(lifetime) = container.item.generics.lifetimes().next()
    {
        diagnostics.report(messages::export_of_borrow(lifetime));
    }
    let mut graph = Graph::new();
    let mut symbols = Symbols::new(phase_space.names.clone());
    symbols.declare_phase(&mut graph, &phase_space.q, &phase_space.p);
    let t = graph.new_symbol(SymbolKind::Time, &phase_space.t);
    let mut tables = Tables::default();
    let space = ClosureSpace::new(&mut tables, &phase_space.shape, t);
    let library = &declaration.library;
    let mut interpreter = Interpreter::new(graph, symbols, tables, space, &container, library, diagnostics);

    let drift = interpreter.terms(declaration.of(Key::Drift));
    let noise = declaration.of(Key::Noise).chain(declaration.of(Key::NoiseForce));
    let noise: Vec<_> = noise.map(|noise| interpreter.noise(noise)).collect();
    let force = interpreter.terms(declaration.of(Key::Force));
    let friction = declaration.friction.as_ref().map(|given| interpreter.friction(given));
    let temperature = declaration.temperature.as_ref().map(|given| interpreter.temperature(given));
    let invariants = interpreter.terms(declaration.of(Key::Invariant));
    let constraints: Vec<_> =
        declaration.of(Key::Constraint).map(|constraint| interpreter.family(constraint)).collect();

    let clock = declaration.clock.as_ref().map(|given| interpreter.clock(given, declaration.of(Key::Clock)));
    // Last, so that what they read has no number before what moves the system.
    let observables = interpreter.terms(declaration.of(Key::Observe));

    let Interpreter { mut graph, symbols, tables, parameters, space, naturals, untyped, .. } = interpreter;
    let type_checks = type_checks::type_checks(&container, &declaration, &phase_space.shape, &untyped);
    let invariant_names = declaration
        .of(Key::Invariant)
        .map(|invariant| invariant.name.as_ref().map_or_else(String::new, |name| name.unraw().to_string()));
    let observable_names = declaration.of(Key::Observe).filter_map(|observable| observable.name.as_ref());
    let noise: Vec<Vec<Noise>> = noise.into_iter().collect::<Option<_>>()?;
    let constraints: Vec<Vec<FamilyTerm>> = constraints.into_iter().collect::<Option<_>>()?;
    let parts = drift?;
    let (drift, parts) = match parts.as_slice() {
        _ if !phase_space.is_of_drift => return None,
        [first, second] => {
            let expression = graph.sum(&[first.expression, second.expression]);
            (Term { expression, ..first.clone() }, parts)
        }
        parts => (parts.first()?.clone(), Vec::new()),
    };
    Some(System {
        graph,
        shape: phase_space.shape.clone(),
        size: space.size,
        components: space.inner.iter().product(),
        names: phase_space.names.clone(),
        labels: phase_space.labels.clone(),
        symbols,
        t,
        parameters: parameters.values,
        tables: tables.into_list(),
        naturals: naturals.values,
        drift,
        collectives: Collectives::default(),
        summands: parts,
        noise: noise.into_iter().flatten().collect(),
        force: force?.pop(),
        friction: required(friction)?,
        conformal: None,
        scale: None,
        temperature: required(temperature)?,
        ito: declaration.ito,
        conversion: None,
        invariants: invariants?,
        invariant_names: invariant_names.collect(),
        observables: observables?,
        observable_names: observable_names.map(|name| name.unraw().to_string()).collect(),
        first_observed: None,
        constraints: constraints.into_iter().flatten().collect(),
        embeddings: declaration.embeddings.into_iter().map(|(embedding, _)| embedding).collect(),
        clock: required(clock)?,
        clocked: declaration.clocked.into_iter().map(|(scheme, _)| scheme).collect(),
        item: container.item,
        crate_path: declaration.crate_path,
        form: Form::Loops,
        slopes: Form::Loops,
        line: None,
        type_checks,
    })
}

/// The term of an optional key, if it is declared; `None` if it was not understood.
fn required<T>(declared: Option<Option<T>>) -> Option<Option<T>> {
    declared.map_or(Some(None), |known| known.map(Some))
}

/// The phase space seen by closures.
struct ClosureSpace<'s> {
    shape: &'s Shape,
    /// The outermost size.
    size: Index,
    /// The lengths of the arrays inside of a point.
    inner: Vec<i128>,
    t: Symbol,
}

impl<'s> ClosureSpace<'s> {
    fn new(tables: &mut Tables, shape: &'s Shape, t: Symbol) -> Self {
        let (size, inner) = match shape {
            Shape::Real => (Index::integer(1), Vec::new()),
            Shape::Array(point, length) => {
                let size = match length {
                    Length::Literal(len) => Index::integer(*len as i128),
                    Length::Named(expr) => tables.size(&expr.0),
                    Length::RunTime => Index::atom(Atom::Size),
                };
                (size, point.lengths().into_iter().map(|length| length as i128).collect())
            }
        };
        Self { shape, size, inner, t }
    }

    /// The coordinates or the momenta.
    fn array(&self, half: Half) -> Array {
        Array::whole(Origin::State(half), Vec::new(), self.size.clone(), self.inner.clone())
    }
}

impl<'a, 'd> Interpreter<'a, 'd> {
    fn vector(&mut self, half: Half) -> Value {
        match self.space.shape {
            Shape::Real => Value::Real(self.local(Slot::State(half, Index::default()))),
            Shape::Array(..) => Value::sequence(Sequence::array(self.space.array(half))),
        }
    }

    fn noise(&mut self, noise: &'a Hamiltonian) -> Option<Vec<Noise>> {
        let is_force = noise.key.is_covector();
        let terms = self.family(noise)?.into_iter();
        Some(terms.map(|FamilyTerm { term, family }| Noise { term, family, is_force }).collect())
    }

    /// The clock: its closure, or the frequency that is added to a curvature.
    fn clock(
        &mut self,
        declared: &'a Located<DeclaredClock>,
        mut closures: impl Iterator<Item = &'a Hamiltonian>,
    ) -> Option<Clock> {
        let (kind, frequency) = match &declared.value {
            DeclaredClock::Function => (ClockKind::Function, None),
            DeclaredClock::Curvature(frequency) => (ClockKind::Curvature, frequency.as_deref()),
            DeclaredClock::Pairs => (ClockKind::Pairs, None),
        };
        let term = match (kind, frequency) {
            (ClockKind::Function, _) => self.term(closures.next()?, None)?,
            (_, Some(frequency)) => self.lowered(&frequency.value, |this| {
                this.now.advice = Some("a clock of the state is a closure, `clock = |q, p| ...`");
                let value = this.evaluate(&frequency.value);
                this.real(value, &frequency.value)
            })?,
            (_, None) => Term {
                expression: self.graph.integer(0),
                elements: Vec::new(),
                values: Vec::new(),
                extent: declared.extent,
            },
        };
        let term = Term { extent: declared.extent, ..term };
        Some(Clock { kind, term, rate: Vec::new(), text: String::new(), collectives: Vec::new() })
    }

    /// A term, or a family of them. Members that differ in more than a number become separate terms.
    fn family(&mut self, closure: &'a Hamiltonian) -> Option<Vec<FamilyTerm>> {
        let Some(count) = &closure.family else {
            let term = self.term(closure, None)?;
            return Some(vec![FamilyTerm { term, family: None }]);
        };
        let count = self.family_count(count)?;
        let variable = self.symbols.variable(0);
        let range = Loop { variable, start: Index::default(), end: count.clone() };
        let term = self.term(closure, Some((Index::atom(Atom::Loop(variable)), Some(&range))));
        if !self.is_unrolled(variable) {
            return Some(vec![FamilyTerm { term: term?, family: Some(Family { variable, count }) }]);
        }
        let count = count.as_integer()?;
        if count > MOST_MEMBERS {
            return self.refuse(expressions::too_many_members(&closure.family, MOST_MEMBERS));
        }
        let members = (0..count).map(|member| {
            let term = self.term(closure, Some((Index::integer(member), None)))?;
            Some(FamilyTerm { term, family: None })
        });
        members.collect()
    }

    /// Lowers closures independently.
    fn terms(&mut self, closures: impl Iterator<Item = &'a Hamiltonian>) -> Option<Vec<Term>> {
        let terms: Vec<Option<Term>> = closures.map(|closure| self.term(closure, None)).collect();
        terms.into_iter().collect()
    }

    /// One closure.
    fn term(&mut self, hamiltonian: &'a Hamiltonian, member: Option<Member<'_>>) -> Option<Term> {
        let closure = &hamiltonian.closure;
        if let ReturnType::Type(_, ty) = &closure.output
            && !hamiltonian.key.is_covector()
            && !names::is_real_type(ty)
        {
            return self.refuse(messages::return_type(ty));
        }
        self.lowered(&closure.body, |this| this.value(hamiltonian, member))
    }

    /// The result of `evaluate` for `body`.
    fn lowered(
        &mut self,
        body: &'a Syntax,
        evaluate: impl FnOnce(&mut Self) -> Option<Expr>,
    ) -> Option<Term> {
        let mistakes = self.mistakes();
        self.start();
        let value = evaluate(self);
        let is_explained = self.mistakes() > mistakes || self.awaits_definitions();
        if value.is_none() && !is_explained && !self.is_abandoned() {
            // Any other silent failure is index arithmetic.
            self.report(expressions::integer_arithmetic(interpreter::result_of(body)));
        }
        let extent = Extent::of(body);
        Some(Term { expression: value?, elements: Vec::new(), values: Vec::new(), extent })
    }

    fn value(&mut self, hamiltonian: &'a Hamiltonian, member: Option<Member<'_>>) -> Option<Expr> {
        let closure = &hamiltonian.closure;
        let (q, p) = (self.vector(Half::Coordinates), self.vector(Half::Momenta));
        let t = Value::Real(self.graph.symbol(self.space.t));
        let mut values = match hamiltonian.key {
            Key::Constraint => vec![q, t],
            _ => vec![q, p, t],
        };
        let (number, range) = member.unzip();
        if let Some(number) = number {
            values.truncate(closure.inputs.len().saturating_sub(1));
            values.push(Value::index(number).unsigned(true));
        }
        self.now.loops.active.extend(range.flatten().cloned());
        for (pattern, value) in closure.inputs.iter().zip(values) {
            self.bind(pattern, value);
        }
        let value = self.evaluate(&closure.body);
        let result = interpreter::result_of(&closure.body);
        let value = match hamiltonian.key.is_covector() {
            true => self.covector(value, result),
            false => self.energy(value, result),
        };
        self.now.loops.active.clear();
        value
    }

    /// The number of members of a family: an integer expression of literals, constants, sizes and fields.
    fn family_count(&mut self, count: &'a Syntax) -> Option<Index> {
        self.start();
        let value = self.evaluate(count).known()?;
        let is_count = matches!(value, Value::Index(..) | Value::Constant(_));
        let index = if is_count { self.as_index(&value, count) } else { None };
        let index = index.filter(|index| index.as_integer().is_none_or(|known| u32::try_from(known).is_ok()));
        index.or_else(|| self.refuse(expressions::family_count(count)))
    }
}

/// A member of a family: its number, and the loop over all members if the number is the variable of that
/// loop.
type Member<'l> = (Index, Option<&'l Loop>);
