//! Expressions on one line, spaced as `rustfmt` does, from their tokens alone: the tokens of an attribute
//! keep neither their spaces nor their lines.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// The operators of several characters, longer ones first.
const OPERATORS: [&str; 21] = [
    "..=", "<<=", ">>=", "&&", "||", "==", "!=", "<=", ">=", "->", "=>", "+=", "-=", "*=", "/=", "%=", "<<",
    ">>", "::", "..", "|=",
];

/// The words after which an operand follows.
const KEYWORDS: [&str; 13] =
    ["as", "const", "else", "for", "if", "in", "let", "loop", "match", "move", "mut", "ref", "return"];

/// The expression as text.
pub(super) fn one_line(tokens: &TokenStream) -> String {
    let mut line = Line { text: String::new(), end: End::Open, is_in_bars: false, angles: 0 };
    line.push_all(tokens.clone());
    line.text
}

/// The end of a line: it decides whether a space follows, and whether the next operator has an operand on its
/// left.
#[derive(Clone, Copy, PartialEq)]
enum End {
    /// An opening bracket, an operator in front of its operand, or the dot of a method: no space follows.
    Open,
    /// An operator between two operands, a comma or a keyword: a space and an operand follow.
    Operator,
    Operand,
}

struct Line {
    text: String,
    end: End,
    /// Whether the line is between the bars of a closure.
    is_in_bars: bool,
    /// How many angle brackets of generic arguments are open.
    angles: usize,
}

impl Line {
    fn push_all(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut rest = tokens.as_slice();
        while let Some((token, after)) = rest.split_first() {
            rest = after;
            match token {
                TokenTree::Group(group) => self.push_group(group.delimiter(), group.stream()),
                TokenTree::Ident(word) => {
                    let word = word.to_string();
                    let is_keyword = KEYWORDS.contains(&word.as_str());
                    self.push_word(&word, if is_keyword { End::Operator } else { End::Operand });
                }
                TokenTree::Literal(literal) => self.push_word(&literal.to_string(), End::Operand),
                TokenTree::Punct(first) => {
                    let joined = joined(token, after);
                    let known = OPERATORS.iter().find(|known| {
                        let is_of_angle = self.angles > 0 && known.starts_with('>');
                        joined.starts_with(*known) && !is_of_angle
                    });
                    let operator =
                        known.map_or_else(|| first.as_char().to_string(), |known| (*known).to_owned());
                    rest = after.get(operator.len() - 1..).unwrap_or_default();
                    self.push_operator(&operator, matches!(rest.first(), Some(TokenTree::Group(_))));
                }
            }
        }
    }

    /// A space, where operands and operators are apart.
    fn push_space(&mut self, is_apart: bool) {
        if is_apart {
            self.text.push(' ');
        }
    }

    fn push_word(&mut self, word: &str, end: End) {
        self.push_space(self.end != End::Open);
        self.text.push_str(word);
        self.end = end;
    }

    fn push_group(&mut self, delimiter: Delimiter, content: TokenStream) {
        let [open, close] = match delimiter {
            Delimiter::Parenthesis => ["(", ")"],
            Delimiter::Bracket => ["[", "]"],
            Delimiter::Brace if content.is_empty() => ["{", "}"],
            Delimiter::Brace => ["{ ", " }"],
            Delimiter::None => return self.push_all(content),
        };
        // After an operand it is a call or an index.
        self.push_space(
            self.end == End::Operator || self.end == End::Operand && delimiter == Delimiter::Brace,
        );
        self.text.push_str(open);
        let outside = (std::mem::take(&mut self.is_in_bars), std::mem::take(&mut self.angles));
        self.end = End::Open;
        self.push_all(content);
        (self.is_in_bars, self.angles) = outside;
        self.text.push_str(close);
        self.end = End::Operand;
    }

    fn push_operator(&mut self, operator: &str, is_before_group: bool) {
        let is_after_operand = self.end == End::Operand;
        let (is_apart, end) = match operator {
            "|" if self.is_in_bars => {
                self.is_in_bars = false;
                (false, End::Operator)
            }
            "," | ";" | ":" => (false, End::Operator),
            ">" if self.angles > 0 => {
                self.angles -= 1;
                (false, End::Operand)
            }
            "." | "::" | ".." | "..=" => (self.end == End::Operator, End::Open),
            "?" => (false, End::Operand),
            // The name of a macro, or of a type.
            "!" if is_after_operand && is_before_group => (false, End::Operand),
            "<" if !is_after_operand || self.ends_with_type() => {
                self.angles += 1;
                (self.end == End::Operator, End::Open)
            }
            _ if is_after_operand => (true, End::Operator),
            "|" => {
                self.is_in_bars = true;
                (self.end == End::Operator, End::Open)
            }
            "-" | "!" | "&" | "*" | "&&" | "'" | "#" => (self.end == End::Operator, End::Open),
            _ => (self.end == End::Operator, End::Operator),
        };
        self.push_space(is_apart);
        self.text.push_str(operator);
        self.end = end;
    }

    /// Whether the last word is a type with generic arguments, such as `Vec`; constants have no lowercase
    /// letters.
    fn ends_with_type(&self) -> bool {
        let word = self.text.rsplit(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default();
        word.starts_with(char::is_uppercase) && word.contains(char::is_lowercase)
    }
}

/// The characters of an operator, as far as they are joined.
fn joined(first: &TokenTree, after: &[TokenTree]) -> String {
    let mut text = String::new();
    for token in std::iter::once(first).chain(after) {
        let TokenTree::Punct(punct) = token else { break };
        text.push(punct.as_char());
        if punct.spacing() == Spacing::Alone {
            break;
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::one_line;

    #[test]
    fn closures_are_spaced_as_they_were_written() {
        let written = [
            "|q, p| 0.5 * p * p - omega * omega * q.cos()",
            "|q, p, t| (-q).exp() - -p * (0.3 * t).sin()",
            "|[x, y], [px, py]| x * py - y * px",
            "|q: [[f64; 2]; N], p: [[f64; 2]; N]| (0..N).map(|i| 0.5 * p[i][0] / mass[i]).sum::<f64>()",
            "|q: &[f64], _| q.windows(2).map(|w| 1.0 - (w[1] - w[0]).cos()).sum::<f64>()",
            "|q, p| { let r = q.hypot(p); if r > 1.0 && q <= 2.0 { r } else { -r } }",
            "|q, _| match kind { 0 => q, 1 | 2 => -q, _ => q * q }",
            "|q, p| -> f64 { q.iter().zip(p).map(|(&q, &p)| q * p).fold(0.0, |a: f64, b| a.max(b)) }",
            "|q, _, k| sigma * (k as f64 + 1.0) * q[(k + 1) % q.len()]",
            "|q, _| self.wall(q) + crate::morse::<Wall>(q, std::f64::consts::PI) + !flag as f64",
            "move |q, p| *scale * [q, p].iter().map(|x| x * x).sum::<f64>()",
        ];
        for text in written {
            let tokens: proc_macro2::TokenStream = text.parse().expect("tokens");
            assert_eq!(one_line(&tokens), text);
        }
    }
}
