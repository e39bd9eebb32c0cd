//! Elements in reduced variables. A bond `V(q[i + 1] - q[i])` has two locals and is a function of one number
//! `d`: its slopes are `V'(d)` and `-V'(d)`, its curvatures `±V''(d)`. Derivatives by such combinations are
//! fewer than those by the locals, and those by the locals are sums of them by the chain rule
//!
//! ```text
//! d_k = Σ_j a_kj x_j,   ∂f/∂x_j = Σ_k a_kj ∂F/∂d_k,   ∂²f/∂x_i ∂x_j = Σ_kl a_ki a_lj ∂²F/∂d_k ∂d_l
//! ```

use std::collections::HashMap;

use crate::symbolic::{Expr, Graph, Node, Rational, Symbol, SymbolKind};

/// A variable and its definition: a linear combination of locals.
type Variable = (Symbol, Vec<(Symbol, Rational)>);

/// A function of fewer variables than locals.
pub(super) struct Combined {
    value: Expr,
    variables: Vec<Variable>,
    /// The definitions of the symbols of variables and derivatives.
    pub(super) definitions: HashMap<Symbol, Expr>,
}

impl Combined {
    /// `value` in combinations of `locals`; `None` if these are not fewer.
    pub(super) fn new(graph: &mut Graph, value: Expr, locals: &[Symbol]) -> Option<Self> {
        let mut value = value;
        let mut variables: Vec<Variable> = locals.iter().map(|&x| (x, vec![(x, Rational::ONE)])).collect();
        while let Some((terms, chosen)) = combination(graph, value, &variables, locals) {
            let scale = terms.iter().find(|(s, _)| *s == chosen)?.1.recip()?;
            let d = graph.new_symbol_like(chosen, "d");
            let (mut row, mut inverse) = (Vec::new(), vec![(graph.symbol(d), Rational::ONE)]);
            for (symbol, coefficient) in terms {
                let coefficient = coefficient.multiply(scale)?;
                let (_, of_locals) = variables.iter().find(|(known, _)| *known == symbol)?;
                add(&mut row, of_locals, coefficient)?;
                if symbol != chosen {
                    inverse.push((graph.symbol(symbol), coefficient.negate()));
                }
            }
            let inverse = graph.linear_combination(&inverse);
            value = graph.substitute(&[value], &HashMap::from([(chosen, inverse)]))[0];
            variables.retain(|(known, _)| *known != chosen);
            variables.push((d, row));
        }
        variables.retain(|(symbol, _)| graph.depends_on(value, &[*symbol]));
        // A remaining sum of variables may cancel terms of their definitions.
        let is_simple = reachable_sums(graph, value, &variables).is_empty();
        if variables.len() >= locals.len() || !is_simple {
            return None;
        }
        let mut definitions = HashMap::new();
        for (symbol, row) in &variables {
            if !locals.contains(symbol) {
                let terms: Vec<_> = row.iter().map(|&(x, a)| (graph.symbol(x), a)).collect();
                definitions.insert(*symbol, graph.linear_combination(&terms));
            }
        }
        Some(Self { value, variables, definitions })
    }

    /// The first derivatives by `locals`.
    pub(super) fn gradient(&mut self, graph: &mut Graph, locals: &[Symbol]) -> Vec<Expr> {
        let slopes: Vec<Expr> =
            self.variables.iter().map(|(s, _)| graph.derivative(self.value, *s)).collect();
        let slopes: Vec<Expr> = slopes.into_iter().map(|slope| self.named(graph, slope)).collect();
        let by_local = |graph: &mut Graph, x: Symbol| {
            let rows = self.variables.iter().zip(&slopes);
            let terms: Vec<_> = rows.map(|((_, row), &slope)| (slope, of(row, x))).collect();
            graph.linear_combination(&terms)
        };
        locals.iter().map(|&x| by_local(graph, x)).collect()
    }

    /// The second derivatives by each pair of `locals` with the first not after the second, row by row.
    pub(super) fn hessian(&mut self, graph: &mut Graph, locals: &[Symbol]) -> Option<Vec<Expr>> {
        let variables = self.variables.clone();
        let mut entries = Vec::new();
        for (a, (first, row)) in variables.iter().enumerate() {
            let slope = graph.derivative(self.value, *first);
            for (second, column) in &variables[a..] {
                let curvature = graph.hessian_entry(slope, *second);
                entries.push((self.named(graph, curvature), row, column, first == second));
            }
        }
        let mut all = Vec::new();
        for (a, &x) in locals.iter().enumerate() {
            for &y in &locals[a..] {
                let mut terms = Vec::new();
                for &(entry, row, column, is_square) in &entries {
                    let once = of(row, x).multiply(of(column, y))?;
                    let twice = of(column, x).multiply(of(row, y))?;
                    terms.push((entry, if is_square { once } else { once.add(twice)? }));
                }
                all.push(graph.linear_combination(&terms));
            }
        }
        Some(all)
    }

    /// A symbol for `value`, which keeps it from being expanded in sums: it is computed once.
    fn named(&mut self, graph: &mut Graph, value: Expr) -> Expr {
        if matches!(graph.node(value), Node::Number(_) | Node::Symbol(_)) {
            return value;
        }
        let known = self.definitions.iter().find(|&(_, &known)| known == value);
        let symbol =
            known.map_or_else(|| graph.new_symbol(SymbolKind::Auxiliary, "g"), |(&symbol, _)| symbol);
        self.definitions.insert(symbol, value);
        graph.symbol(symbol)
    }
}

/// The second derivatives of `value` by pairs of symbols, without combinations.
pub(super) fn hessian_of(graph: &mut Graph, value: Expr, symbols: &[Symbol]) -> Vec<Expr> {
    let mut all = Vec::new();
    for (a, &first) in symbols.iter().enumerate() {
        let slope = graph.derivative(value, first);
        all.extend(symbols[a..].iter().map(|&second| graph.hessian_entry(slope, second)));
    }
    all
}

/// The coefficient of `x`.
fn of(row: &[(Symbol, Rational)], x: Symbol) -> Rational {
    row.iter().find(|(known, _)| *known == x).map_or(Rational::ZERO, |&(_, coefficient)| coefficient)
}

/// `row += coefficient · other`
fn add(row: &mut Vec<(Symbol, Rational)>, other: &[(Symbol, Rational)], coefficient: Rational) -> Option<()> {
    for &(x, a) in other {
        let term = a.multiply(coefficient)?;
        match row.iter_mut().find(|(known, _)| *known == x) {
            Some((_, sum)) => *sum = sum.add(term)?,
            None => row.push((x, term)),
        }
    }
    row.retain(|(_, a)| !a.is_zero());
    Some(())
}

type LinearForm = Vec<(Symbol, Rational)>;

/// The variables that are terms of one sum, for every sum with more than one.
fn reachable_sums(graph: &Graph, value: Expr, variables: &[Variable]) -> Vec<LinearForm> {
    let terms_of = |part: Expr| {
        let Node::Sum { terms, .. } = graph.node(part) else { return None };
        let linear = terms.iter().filter_map(|&(term, coefficient)| {
            let symbol = graph.as_symbol(term)?;
            variables.iter().any(|(known, _)| *known == symbol).then_some((symbol, coefficient))
        });
        Some(linear.collect::<LinearForm>()).filter(|terms| terms.len() > 1)
    };
    graph.reachable(&[value]).into_iter().filter_map(terms_of).collect()
}

/// A combination of variables that `value` reads, and the local that it can replace.
fn combination(
    graph: &Graph,
    value: Expr,
    variables: &[Variable],
    locals: &[Symbol],
) -> Option<(LinearForm, Symbol)> {
    let is_unit = |a: Rational| a.is_one() || a == Rational::MINUS_ONE;
    reachable_sums(graph, value, variables).into_iter().find_map(|terms| {
        let candidates = terms.iter().filter(|(symbol, a)| locals.contains(symbol) && is_unit(*a));
        let chosen = candidates.max_by_key(|(_, a)| a.is_one())?.0;
        Some((terms, chosen))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expressions with all definitions followed.
    fn followed(graph: &mut Graph, combined: &Combined, of: &[Expr]) -> Vec<Expr> {
        let symbols: Vec<Symbol> = combined.definitions.keys().copied().collect();
        let mut of = of.to_vec();
        while of.iter().any(|&expr| graph.depends_on(expr, &symbols)) {
            of = graph.substitute(&of, &combined.definitions);
        }
        of
    }

    /// `d² + d⁴` of `d = x_a - x_b` for every given pair, summed.
    fn bonds(graph: &mut Graph, x: &[Symbol], pairs: &[(usize, usize)]) -> Expr {
        let terms: Vec<Expr> = pairs
            .iter()
            .map(|&(a, b)| {
                let (a, b) = (graph.symbol(x[a]), graph.symbol(x[b]));
                let d = graph.subtract(a, b);
                let square = graph.multiply(d, d);
                let fourth = graph.multiply(square, square);
                graph.add(square, fourth)
            })
            .collect();
        graph.sum(&terms)
    }

    fn check(pairs: &[(usize, usize)], locals: usize, variables: usize) {
        let mut graph = Graph::new();
        let x: Vec<Symbol> =
            (0..locals).map(|i| graph.new_symbol(SymbolKind::Coordinate, format!("x{i}"))).collect();
        let value = bonds(&mut graph, &x, pairs);
        let mut combined = Combined::new(&mut graph, value, &x).unwrap();
        assert_eq!(combined.variables.len(), variables);
        let slopes = combined.gradient(&mut graph, &x);
        let curvatures = combined.hessian(&mut graph, &x).unwrap();
        let slopes = followed(&mut graph, &combined, &slopes);
        let curvatures = followed(&mut graph, &combined, &curvatures);
        // At a point with small integer coordinates, where arithmetic is exact.
        let at: HashMap<Symbol, Expr> = x
            .iter()
            .enumerate()
            .map(|(i, &x)| (x, graph.integer(i32::try_from(i * i).unwrap() + 1)))
            .collect();
        let mut k = 0;
        for (a, &first) in x.iter().enumerate() {
            let slope = graph.derivative(value, first);
            let both = graph.substitute(&[slope, slopes[a]], &at);
            assert_eq!(graph.as_number(both[0]), graph.as_number(both[1]));
            assert!(graph.as_number(both[0]).is_some());
            for &second in &x[a..] {
                let curvature = graph.derivative(slope, second);
                let both = graph.substitute(&[curvature, curvatures[k]], &at);
                assert_eq!(graph.as_number(both[0]), graph.as_number(both[1]));
                assert!(graph.as_number(both[0]).is_some());
                k += 1;
            }
        }
        assert_eq!(k, curvatures.len());
    }

    #[test]
    fn derivatives_by_differences_are_those_by_locals() {
        check(&[(1, 0)], 2, 1);
        check(&[(0, 1), (2, 1)], 3, 2);
        check(&[(0, 1), (1, 2), (2, 3)], 4, 3);
        check(&[(0, 3), (1, 4), (2, 5)], 6, 3);
    }

    #[test]
    fn what_reads_its_locals_otherwise_is_left_alone() {
        let mut graph = Graph::new();
        let x: Vec<Symbol> =
            (0..2).map(|i| graph.new_symbol(SymbolKind::Coordinate, format!("x{i}"))).collect();
        let bond = bonds(&mut graph, &x, &[(1, 0)]);
        let own = graph.symbol(x[0]);
        let own = graph.power(own, Rational::integer(3));
        let value = graph.add(bond, own);
        assert!(Combined::new(&mut graph, value, &x).is_none());
        // Sums and differences of the same locals: expressing one by the other would cancel.
        let (a, b) = (graph.symbol(x[0]), graph.symbol(x[1]));
        let (sum, difference) = (graph.add(a, b), graph.subtract(a, b));
        let value = graph.multiply(sum, difference);
        assert!(Combined::new(&mut graph, value, &x).is_none());
    }
}
