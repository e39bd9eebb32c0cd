//! Expressions as text for messages and documentation, in the notation of the paper: `p²/2 + a (1 - cos(q))`.
//!
//! Text is generated from the root down with a budget: parts that are too deep or too long are elided as `…`.

use super::{Expr, Function, Graph, Junction, Node, Rational, Special};

const DEPTH: usize = 32;
const NODES: usize = 300;

/// The precedence of a text, loosest first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum TextPrecedence {
    Select,
    Or,
    And,
    Compare,
    Sum,
    Product,
    Power,
    Atom,
}

struct Text {
    text: String,
    binding: TextPrecedence,
}

impl Text {
    fn new(text: impl Into<String>, binding: TextPrecedence) -> Self {
        Self { text: text.into(), binding }
    }

    /// The text as an operand of at least the precedence `least`.
    fn within(self, least: TextPrecedence) -> String {
        if self.binding >= least { self.text } else { format!("({})", self.text) }
    }
}

impl Graph {
    /// `expr` as text.
    pub(crate) fn display(&self, expr: Expr) -> String {
        TextWriter { graph: self, nodes_left: NODES }.write(expr, DEPTH).text
    }
}

struct TextWriter<'a> {
    graph: &'a Graph,
    nodes_left: usize,
}

impl TextWriter<'_> {
    /// The recursion is bounded by `depth`.
    fn write(&mut self, expr: Expr, depth: usize) -> Text {
        if depth == 0 || self.nodes_left == 0 {
            return Text::new("…", TextPrecedence::Atom);
        }
        self.nodes_left -= 1;
        let graph = self.graph;
        let depth = depth - 1;
        match graph.node(expr) {
            Node::Number(value) => number(*value),
            Node::Float(bits) => float(f64::from_bits(*bits)),
            Node::Symbol(symbol) => Text::new(graph.symbol_name(*symbol), TextPrecedence::Atom),
            Node::Sum { terms, constant } => self.sum(terms, *constant, depth),
            Node::Product(factors) => self.quotient(Rational::ONE, factors, depth),
            Node::Apply(Function::Special(Special::Bessel(_)), _) => {
                self.quotient(Rational::ONE, &[(expr, Rational::ONE)], depth)
            }
            Node::Apply(function, arguments) => self.function(*function, arguments, depth),
            Node::Select { condition, then, otherwise } => {
                let [condition, then, otherwise] = [*condition, *then, *otherwise]
                    .map(|part| self.write(part, depth).within(TextPrecedence::Or));
                Text::new(format!("if {condition} then {then} else {otherwise}"), TextPrecedence::Select)
            }
            Node::Compare(relation, a, b) => self.comparison(relation.spelled()[2], *a, *b, depth),
            Node::Not(a) => match *graph.node(*a) {
                Node::Compare(relation, a, b) => self.comparison(relation.spelled()[3], a, b, depth),
                _ => Text::new(
                    format!("not {}", self.write(*a, depth).within(TextPrecedence::Atom)),
                    TextPrecedence::Compare,
                ),
            },
            Node::Join(junction, a, b) => {
                let (word, binding) = match junction {
                    Junction::And => ("and", TextPrecedence::And),
                    Junction::Or => ("or", TextPrecedence::Or),
                };
                let [a, b] = [*a, *b].map(|part| self.write(part, depth).within(binding));
                Text::new(format!("{a} {word} {b}"), binding)
            }
        }
    }

    fn comparison(&mut self, sign: &str, a: Expr, b: Expr, depth: usize) -> Text {
        let [a, b] = [a, b].map(|part| self.write(part, depth).within(TextPrecedence::Sum));
        Text::new(format!("{a} {sign} {b}"), TextPrecedence::Compare)
    }

    /// Terms in their order, except that the text starts with a positive one if there is any.
    fn sum(&mut self, terms: &[(Expr, Rational)], constant: Rational, depth: usize) -> Text {
        if let (&[(term, coefficient)], true) = (terms, constant.is_zero()) {
            return self.multiple(coefficient, term, depth);
        }
        let mut summands: Vec<(bool, String)> = Vec::with_capacity(terms.len() + 1);
        for (written, &(term, coefficient)) in terms.iter().enumerate() {
            if self.nodes_left == 0 {
                let further = terms.len() - written;
                let noun = if further == 1 { "term" } else { "terms" };
                summands.push((false, format!("… {further} further {noun}")));
                break;
            }
            let magnitude = if coefficient.is_negative() { coefficient.negate() } else { coefficient };
            let text = if magnitude.is_one() {
                self.write(term, depth)
            } else {
                self.multiple(magnitude, term, depth)
            };
            summands.push((coefficient.is_negative(), text.within(TextPrecedence::Product)));
        }
        if constant.is_negative() {
            summands.push((true, constant.negate().to_string()));
        } else if !constant.is_zero() {
            summands.insert(0, (false, constant.to_string()));
        }
        if let Some(first) = summands.iter().position(|&(negative, _)| !negative) {
            summands[..=first].rotate_right(1);
        }
        Text::new(signed(summands), TextPrecedence::Sum)
    }

    /// `coefficient · term`
    fn multiple(&mut self, coefficient: Rational, term: Expr, depth: usize) -> Text {
        let factors = match self.graph.node(term) {
            Node::Product(factors) => factors,
            _ => &Box::from([(term, Rational::ONE)]),
        };
        if coefficient.is_negative() {
            let positive =
                self.quotient(coefficient.negate(), factors, depth).within(TextPrecedence::Product);
            return Text::new(format!("-{positive}"), TextPrecedence::Sum);
        }
        self.quotient(coefficient, factors, depth)
    }

    /// `coefficient · Π base^exponent` for a positive coefficient, as one fraction.
    fn quotient(&mut self, coefficient: Rational, factors: &[(Expr, Rational)], depth: usize) -> Text {
        let (mut above, mut below) = (Vec::new(), Vec::new());
        // Constants, variables, then factors in brackets: `a (p² + q²)`.
        let mut ordered = self.with_bessel_functions(factors);
        ordered.sort_by_key(|&(base, _)| match self.graph.node(base) {
            Node::Number(_) | Node::Float(_) => 0,
            Node::Symbol(_) => 1,
            _ => 2,
        });
        for (base, exponent) in ordered {
            let (side, exponent) =
                if exponent.is_negative() { (&mut below, exponent.negate()) } else { (&mut above, exponent) };
            side.push(self.power(base, exponent, depth));
            if self.nodes_left == 0 {
                break;
            }
        }
        if coefficient.numerator() != 1 || above.is_empty() {
            above.insert(0, Text::new(coefficient.numerator().to_string(), TextPrecedence::Atom));
        }
        if coefficient.denominator() != 1 {
            below.insert(0, Text::new(coefficient.denominator().to_string(), TextPrecedence::Atom));
        }
        let above = juxtapose(above);
        if below.is_empty() {
            return above;
        }
        let above = above.within(TextPrecedence::Product);
        // `a/b c` would be ambiguous.
        let below = juxtapose(below).within(TextPrecedence::Power);
        Text::new(format!("{above}/{below}"), TextPrecedence::Product)
    }

    /// The factors with `J_n(x)` for each `J_n(x)/xⁿ`, whose denominator is one more factor.
    fn with_bessel_functions(&self, factors: &[(Expr, Rational)]) -> Vec<(Expr, Rational)> {
        let mut opened = factors.to_vec();
        for &(base, exponent) in factors {
            let Node::Apply(Function::Special(Special::Bessel(order)), arguments) = self.graph.node(base)
            else {
                continue;
            };
            let order = i32::try_from(*order).unwrap_or(i32::MAX);
            let Some(lost) = exponent.multiply(Rational::integer(-order)) else { continue };
            let parts: &[(Expr, Rational)] = match self.graph.node(arguments[0]) {
                Node::Product(parts) => parts,
                _ => &[(arguments[0], Rational::ONE)],
            };
            for &(part, power) in parts {
                let Some(lost) = power.multiply(lost) else { continue };
                match opened.iter_mut().find(|(known, _)| *known == part) {
                    Some((_, power)) => *power = power.add(lost).unwrap_or(*power),
                    None => opened.push((part, lost)),
                }
            }
        }
        opened.retain(|(_, exponent)| !exponent.is_zero());
        opened
    }

    /// `base^exponent` for a positive exponent.
    fn power(&mut self, base: Expr, exponent: Rational, depth: usize) -> Text {
        let base = match self.graph.node(base) {
            Node::Apply(Function::Special(Special::Bessel(order)), arguments) => {
                let argument = self.write(arguments[0], depth);
                Text::new(format!("j{order}({})", argument.text), TextPrecedence::Atom)
            }
            _ => self.write(base, depth),
        };
        if exponent.is_one() {
            return base;
        }
        if exponent == Rational::HALF {
            return root(base);
        }
        let exponent = match (exponent.numerator(), exponent.denominator()) {
            (2, 1) => "²".into(),
            (3, 1) => "³".into(),
            (n, 1) => format!("^{n}"),
            _ => format!("^({exponent})"),
        };
        Text::new(base.within(TextPrecedence::Atom) + &exponent, TextPrecedence::Power)
    }

    fn function(&mut self, function: Function, arguments: &[Expr], depth: usize) -> Text {
        let mut written: Vec<Text> = arguments.iter().map(|&argument| self.write(argument, depth)).collect();
        match function {
            Function::Sqrt if written.len() == 1 => return root(written.remove(0)),
            // Opening and closing bars look the same.
            Function::Abs if written.iter().all(|x| !x.text.contains('|')) => {
                return Text::new(format!("|{}|", join(written)), TextPrecedence::Atom);
            }
            Function::Powf if written.len() == 2 => {
                let exponent = written.remove(1).within(TextPrecedence::Atom);
                return Text::new(
                    written.remove(0).within(TextPrecedence::Atom) + "^" + &exponent,
                    TextPrecedence::Power,
                );
            }
            Function::Special(special) if special.order() > 0 => {
                let name = format!("{}_{}", special.name(), special.order());
                return Text::new(format!("{name}({})", join(written)), TextPrecedence::Atom);
            }
            _ => {}
        }
        Text::new(format!("{}({})", function.method(), join(written)), TextPrecedence::Atom)
    }
}

/// A sum of terms, each with whether it is subtracted.
pub(crate) fn signed(terms: impl IntoIterator<Item = (bool, String)>) -> String {
    let mut text = String::new();
    for (is_negative, term) in terms {
        text.push_str(match (text.is_empty(), is_negative) {
            (true, false) => "",
            (true, true) => "-",
            (false, false) => " + ",
            (false, true) => " - ",
        });
        text.push_str(&term);
    }
    text
}

fn join(texts: Vec<Text>) -> String {
    texts.into_iter().map(|argument| argument.text).collect::<Vec<_>>().join(", ")
}

fn root(base: Text) -> Text {
    Text::new(format!("√{}", base.within(TextPrecedence::Atom)), TextPrecedence::Power)
}

/// Factors separated by spaces, or by a dot before a number.
fn juxtapose(mut factors: Vec<Text>) -> Text {
    if factors.len() == 1 {
        return factors.remove(0);
    }
    let mut text = String::new();
    for factor in factors {
        // A quotient inside a product: `(a/b) c`.
        let factor = factor.within(TextPrecedence::Power);
        if !text.is_empty() {
            text.push_str(if factor.starts_with(|first: char| first.is_ascii_digit()) { "·" } else { " " });
        }
        text.push_str(&factor);
    }
    Text::new(text, TextPrecedence::Product)
}

fn number(value: Rational) -> Text {
    let binding = match value {
        value if value.is_negative() => TextPrecedence::Sum,
        value if value.is_integer() => TextPrecedence::Atom,
        _ => TextPrecedence::Product,
    };
    Text::new(value.to_string(), binding)
}

fn float(value: f64) -> Text {
    use std::f64::consts;
    let known = [
        (consts::PI, "π", TextPrecedence::Atom),
        (consts::TAU, "2 π", TextPrecedence::Product),
        (consts::FRAC_PI_2, "π/2", TextPrecedence::Product),
        (consts::FRAC_PI_3, "π/3", TextPrecedence::Product),
        (consts::FRAC_PI_4, "π/4", TextPrecedence::Product),
        (consts::FRAC_PI_6, "π/6", TextPrecedence::Product),
        (consts::E, "e", TextPrecedence::Atom),
        (consts::LN_2, "ln(2)", TextPrecedence::Atom),
        (consts::LN_10, "ln(10)", TextPrecedence::Atom),
        (consts::SQRT_2, "√2", TextPrecedence::Power),
        (consts::FRAC_1_SQRT_2, "1/√2", TextPrecedence::Product),
    ];
    match known.into_iter().find(|&(constant, ..)| constant == value) {
        Some((_, text, binding)) => Text::new(text, binding),
        None if value < 0.0 => Text::new(format!("{value:?}"), TextPrecedence::Sum),
        None => Text::new(format!("{value:?}"), TextPrecedence::Atom),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symbolic::{Relation, SymbolKind};

    #[test]
    fn reads_like_the_paper() {
        let mut g = Graph::new();
        let [q, p, a] = ["q", "p", "a"]
            .map(|name| g.new_symbol(SymbolKind::Coordinate, name))
            .map(|symbol| g.symbol(symbol));
        let (one, two) = (g.integer(1), Rational::integer(2));
        let (qq, pp) = (g.power(q, two), g.power(p, two));
        let kinetic = g.scale(pp, Rational::HALF);
        let cosine = g.apply(Function::Cos, &[q]);
        let well = g.subtract(one, cosine);
        let potential = g.multiply(a, well);
        let pendulum = g.add(kinetic, potential);
        assert_eq!(g.display(pendulum), "p²/2 + a (1 - cos(q))");

        let squares = g.add(qq, pp);
        let radius = g.apply(Function::Sqrt, &[squares]);
        let gravity = g.divide(a, radius);
        let gravity = g.negate(gravity);
        assert_eq!(g.display(gravity), "-a/√(q² + p²)");
        let kubo = g.scale(squares, Rational::HALF);
        let kubo = g.multiply(a, kubo);
        assert_eq!(g.display(kubo), "a (q² + p²)/2");
        let cubed = g.power(squares, Rational::new(-3, 2).unwrap_or(two));
        assert_eq!(g.display(cubed), "1/(q² + p²)^(3/2)");

        let pi = g.float(std::f64::consts::PI);
        let two_thirds = g.number(Rational::new(2, 3).unwrap_or(two));
        let (turn, difference) = (g.product(&[pi, q, two_thirds]), g.subtract(q, p));
        assert_eq!(g.display(turn), "2 π q/3");
        let difference = g.negate(difference);
        let magnitude = g.apply(Function::Abs, &[difference]);
        assert_eq!(g.display(difference), "p - q");
        assert_eq!(g.display(magnitude), "|q - p|");
        let less = g.compare(Relation::Less, q, p);
        let chosen = g.select(less, q, pp);
        let fifth = g.power(chosen, Rational::integer(5));
        assert_eq!(g.display(fifth), "(if q < p then q else p²)^5");
        let not = g.not(less);
        assert_eq!(g.display(not), "q ≥ p");
    }

    #[test]
    fn elides_what_is_deep() {
        let mut g = Graph::new();
        let x = g.new_symbol(SymbolKind::Coordinate, "x");
        let mut x = g.symbol(x);
        for _ in 0..100_000 {
            x = g.apply(Function::Sin, &[x]);
        }
        let text = g.display(x);
        assert!(text.contains('…') && text.len() < 1000, "{text}");
    }
}
