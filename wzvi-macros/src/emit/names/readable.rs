//! Emitted code with unmarked names, and with imports instead of paths.
//!
//! The complete code of a struct is scanned first. An emitted name loses its mark, and a type is imported,
//! unless the word occurs among the user's tokens in the code: generics of the struct, constants and fields
//! that it reads. So neither side captures a name of the other, and names stay distinct. Items around the
//! struct, which its tokens do not show, could still interfere. A pattern `h` would match a constant `h`, so
//! all bound names are imported as functions, which patterns may shadow. An argument `L` would be read as a
//! type `L`, so numbers among the arguments of types are in braces.
//!
//! Tests: `tests/compiler/hygiene.rs`.

use std::collections::{BTreeMap, HashSet};

use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};
use quote::quote;

use super::{MARK, OF_FORMULA, plain};
use crate::distinct::Distinct;
use crate::tokens::regrouped;

/// The first segment of every emitted path: the module for generated code.
const ROOT: &str = "__wzvi";
/// Types whose names do not start with a capital.
const PRIMITIVES: [&str; 7] = ["bool", "f64", "i128", "isize", "str", "u32", "usize"];
/// Keywords before the name of an item.
const DECLARING: [&str; 4] = ["const", "fn", "struct", "type"];

/// `generated` with readable names and its imports. `crate_path` names the facade crate in the user's crate.
/// The user's tokens in the code are `in_code`, the user's other tokens `elsewhere`.
pub(crate) fn readable(
    generated: TokenStream,
    crate_path: &syn::Path,
    in_code: TokenStream,
    elsewhere: &TokenStream,
    generics: &syn::Generics,
) -> TokenStream {
    let mut of_user = HashSet::new();
    listen(in_code, &mut of_user, &|word| !word.starts_with(MARK));
    listen(elsewhere.clone(), &mut of_user, &|word| word.starts_with(MARK) && !word.starts_with(ROOT));
    if crate_path.leading_colon.is_none() {
        listen(quote!(#crate_path), &mut of_user, &|_| true);
    }
    let numbers = generics.const_params().map(|number| number.ident.to_string());
    let mut survey = Survey { of_user, generic_numbers: numbers.collect(), ..Survey::default() };
    let code = survey.read(generated);
    let decided = survey.decide();
    let body = decided.written(code, false);
    let (root, imports, bindings) = (&decided.root, decided.imports(), &decided.bindings);
    let bindings = (!bindings.is_empty()).then(|| {
        quote! {
            #root::bindings! { #(#bindings)* }
        }
    });
    quote! {
        use #crate_path::__private::{self as #root, #(#imports),*};
        #body
        #bindings
    }
}

/// Collects the words of the user that stand alone: neither fields nor the ends of paths.
fn listen(tokens: TokenStream, heard: &mut HashSet<String>, is_wanted: &dyn Fn(&str) -> bool) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    for (i, token) in tokens.iter().enumerate() {
        match token {
            TokenTree::Ident(ident) if !is_field(&tokens, i) && !ends_path(&tokens, i) => {
                let word = ident.to_string();
                let word = word.strip_prefix("r#").unwrap_or(&word);
                if is_wanted(word) {
                    heard.insert(word.to_owned());
                }
            }
            TokenTree::Group(group) => listen(group.stream(), heard, is_wanted),
            _ => {}
        }
    }
}

/// A part of the code; words that may be renamed are known by their number.
enum MarkedTree {
    /// A marked word.
    Word(usize, Ident),
    /// A path to a type, with its full form after [`ROOT`].
    Path(usize, Ident, Vec<TokenTree>),
    Group(Group, Vec<MarkedTree>),
    Other(TokenTree),
}

/// A marked word.
struct MarkedWord {
    text: String,
    /// Whether patterns bind it.
    is_bound: bool,
    /// Whether it is a number among the generics of a function or type.
    is_generic_number: bool,
}

/// The words of the code.
#[derive(Default)]
struct Survey {
    /// The user's words, and the const generics of the struct among them.
    of_user: HashSet<String>,
    generic_numbers: HashSet<String>,
    words: Distinct<String, MarkedWord>,
    paths: Distinct<String, Vec<String>>,
}

impl Survey {
    fn read(&mut self, tokens: TokenStream) -> Vec<MarkedTree> {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut code = Vec::with_capacity(tokens.len());
        let mut i = 0;
        while let Some(token) = tokens.get(i) {
            let mut next = i + 1;
            code.push(match token {
                TokenTree::Group(group) => MarkedTree::Group(group.clone(), self.read(group.stream())),
                TokenTree::Ident(ident) => {
                    let word = ident.to_string();
                    if !word.starts_with(MARK) || is_field(&tokens, i) || self.of_user.contains(&word) {
                        let is_argument = self.generic_numbers.contains(&word) && is_argument(&tokens, i);
                        braced(MarkedTree::Other(token.clone()), is_argument)
                    } else if word == ROOT
                        && let Some((path, end)) = path_to_type(&tokens, i)
                    {
                        next = end;
                        let number = self.paths.place(path.concat(), || path);
                        MarkedTree::Path(number, ident.clone(), tokens[i + 1..end].to_vec())
                    } else {
                        let number = self.word(word, &tokens, i);
                        let is_argument =
                            self.words.values[number].is_generic_number && is_argument(&tokens, i);
                        braced(MarkedTree::Word(number, ident.clone()), is_argument)
                    }
                }
                other => MarkedTree::Other(other.clone()),
            });
            i = next;
        }
        code
    }

    /// The number of the word that is token `i`.
    fn word(&mut self, word: String, tokens: &[TokenTree], i: usize) -> usize {
        let declares = |keyword: &TokenTree| matches!(keyword, TokenTree::Ident(keyword) if DECLARING.contains(&keyword.to_string().as_str()));
        let is_declared = before(tokens, i, 1).is_some_and(declares);
        let is_generic = is_declared && [',', '<'].iter().any(|&c| is(before(tokens, i, 2), c));
        let is_capital = plain(&word).starts_with(char::is_uppercase) && !is_of_formula(&word);
        let is_item = is_declared || is_capital || word == ROOT;
        let made = || MarkedWord { text: word.clone(), is_bound: true, is_generic_number: false };
        let number = self.words.place(word.clone(), made);
        let known = &mut self.words.values[number];
        known.is_bound &= !is_item;
        known.is_generic_number |= is_generic;
        number
    }

    /// Words are assigned to items first, then to types, then to bound names: those of formulas before those
    /// of emitters.
    fn decide(self) -> Decided {
        let Self { of_user, words: Distinct { values: words, .. }, paths, .. } = self;
        let paths = paths.values;
        let mut taken = of_user;
        let root = free(ROOT, &mut taken);
        let mut names: Vec<String> = vec![String::new(); words.len()];
        for (name, word) in names.iter_mut().zip(&words).filter(|(_, word)| !word.is_bound) {
            *name = if word.text == ROOT { root.clone() } else { free(&word.text, &mut taken) };
        }
        let is_new = |path: &Vec<String>| path.last().is_some_and(|last| taken.insert(last.clone()));
        let is_imported = paths.iter().map(is_new).collect();
        let mut bound = Vec::new();
        for is_of_formula in [true, false] {
            let own = |word: &MarkedWord| word.is_bound && self::is_of_formula(&word.text) == is_of_formula;
            for (name, word) in names.iter_mut().zip(&words).filter(|(_, word)| own(word)) {
                *name = free(&word.text, &mut taken);
                bound.push(name.clone());
            }
        }
        bound.sort_unstable();
        let bindings = bound.iter().map(|name| Ident::new(name, Span::call_site())).collect();
        let root = Ident::new(&root, Span::call_site());
        Decided { root, names, paths, is_imported, bindings }
    }
}

fn is_of_formula(word: &str) -> bool {
    word.starts_with(OF_FORMULA)
}

/// A free word, as close as possible to the unmarked one.
fn free(word: &str, taken: &mut HashSet<String>) -> String {
    let mut name = plain(word).to_owned();
    // `syn` accepts all editions, and `gen` is no keyword in older ones.
    let is_keyword = |name: &str| syn::parse_str::<Ident>(name).is_err() || name == "gen";
    while is_keyword(&name) || !taken.insert(name.clone()) {
        name.push('_');
    }
    name
}

/// The new form of every emitted word.
struct Decided {
    root: Ident,
    names: Vec<String>,
    paths: Vec<Vec<String>>,
    is_imported: Vec<bool>,
    bindings: Vec<Ident>,
}

impl Decided {
    /// The imports by module.
    fn imports(&self) -> Vec<TokenStream> {
        let ident = |segment: &String| Ident::new(segment, Span::call_site());
        let mut modules: BTreeMap<&[String], Vec<Ident>> = BTreeMap::new();
        for (path, _) in self.paths.iter().zip(&self.is_imported).filter(|(_, is_imported)| **is_imported) {
            if let Some((last, module)) = path.split_last() {
                modules.entry(module).or_default().push(ident(last));
            }
        }
        let import = |(module, mut types): (&[String], Vec<Ident>)| {
            types.sort();
            let module = module.iter().map(ident);
            match types.as_slice() {
                [only] => quote!(#(#module::)* #only),
                types if module.len() == 0 => quote!(#(#types),*),
                types => quote!(#(#module::)* {#(#types),*}),
            }
        };
        modules.into_iter().map(import).collect()
    }

    fn written(&self, code: Vec<MarkedTree>, is_braced: bool) -> TokenStream {
        let mut written: Vec<TokenTree> = Vec::with_capacity(code.len());
        for node in code {
            match node {
                MarkedTree::Word(number, ident) => written.push(named(&self.names[number], &ident)),
                MarkedTree::Path(number, ident, rest) => match self.paths[number].last() {
                    Some(last) if self.is_imported[number] => written.push(named(last, &ident)),
                    _ => {
                        let mut root = self.root.clone();
                        root.set_span(ident.span());
                        written.push(root.into());
                        written.extend(rest);
                    }
                },
                MarkedTree::Group(group, inner) => {
                    let inner = self.written(inner, group.delimiter() == Delimiter::Brace);
                    written.push(regrouped(&group, inner));
                }
                MarkedTree::Other(token) => {
                    if is_braced && is(Some(&token), ',') {
                        shorten_field(&mut written);
                    }
                    written.push(token);
                }
            }
        }
        if is_braced {
            shorten_field(&mut written);
        }
        written.into_iter().collect()
    }
}

fn named(name: &str, like: &Ident) -> TokenTree {
    Ident::new(name, like.span()).into()
}

/// `q` at the end instead of `q: q`, as in `Point { q, p }`.
fn shorten_field(written: &mut Vec<TokenTree>) {
    let [before @ .., TokenTree::Ident(field), colon, TokenTree::Ident(value)] = written.as_slice() else {
        return;
    };
    let is_field = is(Some(colon), ':') && before.last().is_none_or(|last| is(Some(last), ','));
    if is_field && field == value {
        written.truncate(written.len() - 2);
    }
}

fn is(token: Option<&TokenTree>, c: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == c)
}

fn before(tokens: &[TokenTree], i: usize, distance: usize) -> Option<&TokenTree> {
    i.checked_sub(distance).and_then(|before| tokens.get(before))
}

/// Whether token `i` is a field or a method: it comes after one dot.
fn is_field(tokens: &[TokenTree], i: usize) -> bool {
    is(before(tokens, i, 1), '.') && !is(before(tokens, i, 2), '.')
}

/// Whether token `i` comes after `::`.
fn ends_path(tokens: &[TokenTree], i: usize) -> bool {
    is(before(tokens, i, 1), ':') && is(before(tokens, i, 2), ':')
}

fn braced(node: MarkedTree, is_braced: bool) -> MarkedTree {
    match is_braced {
        true => MarkedTree::Group(Group::new(Delimiter::Brace, TokenStream::new()), vec![node]),
        false => node,
    }
}

/// Whether token `i` stands between `<`, `,` and `,`, `>`.
fn is_argument(tokens: &[TokenTree], i: usize) -> bool {
    let is_any = |token: Option<&TokenTree>, of: [char; 2]| of.iter().any(|&c| is(token, c));
    is_any(before(tokens, i, 1), ['<', ',']) && is_any(tokens.get(i + 1), [',', '>'])
}

/// The path from [`ROOT`] at `i` to its first type, and where it ends.
fn path_to_type(tokens: &[TokenTree], i: usize) -> Option<(Vec<String>, usize)> {
    let mut path = Vec::new();
    let mut at = i + 1;
    while is(tokens.get(at), ':') && is(tokens.get(at + 1), ':') {
        let Some(TokenTree::Ident(segment)) = tokens.get(at + 2) else { return None };
        let segment = segment.to_string();
        let is_type = segment.starts_with(char::is_uppercase) || PRIMITIVES.contains(&segment.as_str());
        path.push(segment);
        at += 3;
        if is_type {
            return Some((path, at));
        }
    }
    None
}
