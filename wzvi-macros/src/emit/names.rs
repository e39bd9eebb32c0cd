//! Names in emitted code: unique during assembly, readable in the result.
//!
//! An emitter marks each of its own names with two underscores, and names items of this library by path.
//! Names of variables and of parts of formulas come from [`Names`] and have another mark, so that no name of
//! the user clashes with one of an emitter. When the code of a struct is complete, [`readable`] removes the
//! marks.

use std::collections::HashSet;

use proc_macro2::{Ident, Span};

mod readable;

pub(crate) use readable::readable;

/// The prefix of emitted names.
const MARK: &str = "__";
/// The prefix of names made by [`Names`]: no emitter starts one with a digit.
const OF_FORMULA: &str = "__0";

/// A name without its mark.
pub(crate) fn plain(name: &str) -> &str {
    name.strip_prefix(OF_FORMULA).or_else(|| name.strip_prefix(MARK)).unwrap_or(name)
}

/// Gives the distinct names of one function body.
#[derive(Clone, Default)]
pub(crate) struct Namer {
    taken: HashSet<String>,
}

impl Namer {
    /// Reserves `name`.
    pub(crate) fn avoid(&mut self, name: &Ident) {
        self.taken.insert(name.to_string());
    }

    /// A free name as close to `wish` as possible, for a variable of the user or a part of a formula.
    pub(crate) fn take(&mut self, wish: &str) -> Ident {
        let word = as_word(wish);
        let separator = if word.ends_with(|last: char| last.is_ascii_digit()) { "_" } else { "" };
        let mut name = format!("{OF_FORMULA}{word}");
        let mut number = 2_u32;
        while !self.taken.insert(name.clone()) {
            name = format!("{OF_FORMULA}{word}{separator}{number}");
            number += 1;
        }
        Ident::new(&name, Span::call_site())
    }

    /// Names for `wishes`, in their order.
    pub(crate) fn take_all<W: AsRef<str>>(&mut self, wishes: impl IntoIterator<Item = W>) -> Vec<Ident> {
        wishes.into_iter().map(|wish| self.take(wish.as_ref())).collect()
    }
}

/// The words for `+`, `-` and `%`.
const OPERATORS: [&str; 3] = ["plus", "minus", "mod"];

/// `q[0]` is `q0`, `q[i + 1]` is `q_i_plus_1`, `2 i` is `index_2i`, `self.0` is `field0`; words are
/// unchanged.
fn as_word(wish: &str) -> String {
    let is_of_word = |c: char| c.is_alphanumeric() || c == '_';
    let is_word = |word: &str| {
        let starts_well = !word.starts_with(|c: char| c.is_ascii_digit());
        starts_well && word.chars().any(|c| c != '_') && word.chars().all(is_of_word)
    };
    if is_word(wish) {
        return wish.to_owned();
    }
    let wish = wish.strip_prefix("self.").map_or_else(|| wish.to_owned(), |field| format!("field[{field}]"));
    let spelled = wish.replace('+', " plus ").replace('-', " minus ").replace('%', " mod ");
    let mut word = String::new();
    let mut rest = spelled.as_str();
    while let Some(start) = rest.find(is_of_word) {
        let gap = &rest[..start];
        let end = rest[start..].find(|c| !is_of_word(c)).map_or(rest.len(), |length| start + length);
        let (part, after) = (&rest[start..end], &rest[end..]);
        let is_number = |text: &str| text.ends_with(|c: char| c.is_ascii_digit());
        let is_component = gap == "[" && after.starts_with(']') && is_number(part);
        let is_multiple = gap == " " && is_number(&word) && !is_number(part) && !OPERATORS.contains(&part);
        if !(word.is_empty() || is_component && !is_number(&word) || is_multiple) {
            word.push('_');
        }
        word.push_str(part);
        rest = after;
    }
    if word.starts_with(|c: char| c.is_ascii_digit()) {
        word.insert_str(0, "index_");
    }
    if is_word(&word) { word } else { "x".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_keep_their_names() {
        let cases = [
            ("sigma", "__0sigma"),
            ("θ", "__0θ"),
            ("q[0]", "__0q0"),
            ("q[1][2]", "__0q1_2"),
            ("q[i + 1]", "__0q_i_plus_1"),
            ("q[2 i + 1]", "__0q_2i_plus_1"),
            ("2 i + 1", "__0index_2i_plus_1"),
            ("2 i - j", "__0index_2i_minus_j"),
            ("mass[0][i]", "__0mass0_i"),
            ("self.0", "__0field0"),
            ("_", "__0x"),
            ("", "__0x"),
        ];
        for (wish, name) in cases {
            assert_eq!(Namer::default().take(wish).to_string(), name);
        }
    }

    #[test]
    fn no_two_names_are_the_same() {
        let taken = Namer::default().take_all(["q", "q", "q0", "q[0]", "q"]);
        let taken: Vec<String> = taken.iter().map(ToString::to_string).collect();
        assert_eq!(taken, ["__0q", "__0q2", "__0q0", "__0q0_2", "__0q3"]);
    }
}
