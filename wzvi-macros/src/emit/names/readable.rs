//! Emitted code with the marks taken off its names, and with imports instead of paths.
//!
//! The whole code of a struct is looked at first. A name of ours loses its mark, and a type is imported, unless one of the
//! user's tokens in the code could mean something else by the word: the generics of the struct, the constants and fields
//! that it reads. So neither side can capture a name of the other. What is left are constants around the struct, of which
//! no token tells: a pattern `h` means the constant `h` if there is one. Hence all names that are bound are imported as
//! functions, which patterns may shadow.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use proc_macro2::{Delimiter, Group, Ident, Span, TokenStream, TokenTree};
use quote::quote;

use super::MARK;

/// What every path of ours starts with: the module that generated code may name.
const ROOT: &str = "__wzvi";
/// Types whose names do not start with a capital.
const PRIMITIVES: [&str; 6] = ["bool", "f64", "i128", "isize", "str", "usize"];
/// The parameters of emitted functions that are types.
const TYPE_PARAMETERS: [&str; 2] = ["__S", "__C"];
const DECLARING: [&str; 4] = ["const", "fn", "struct", "type"];
const KEYWORDS: [&str; 53] = [
    "Self", "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate", "do",
    "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop",
    "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return", "self", "static",
    "struct", "super", "trait", "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual",
    "where", "while", "yield", "_",
];

/// Where the code will stand.
pub(crate) struct Surroundings<'s> {
    /// The facade as the user's crate knows it.
    pub(crate) crate_path: &'s syn::Path,
    /// The user's tokens in the code.
    pub(crate) tokens: TokenStream,
    /// Everything else that the user wrote.
    pub(crate) spelled: &'s TokenStream,
}

/// `generated` as a person would write it, with its imports.
pub(crate) fn readable(generated: TokenStream, surroundings: &Surroundings<'_>) -> TokenStream {
    let Surroundings { crate_path, tokens, spelled } = surroundings;
    let mut survey = Survey::default();
    survey.listen((*spelled).clone(), &|word| word.starts_with(MARK) && !word.starts_with(ROOT));
    survey.listen(tokens.clone(), &|word| !word.starts_with(MARK));
    if crate_path.leading_colon.is_none() {
        survey.listen(quote!(#crate_path), &|_| true);
    }
    survey.read(generated.clone());
    let decided = survey.decide();
    let body = decided.rewritten(generated);
    let (root, imports, bindings) = (decided.name(ROOT), decided.imports(), decided.bindings());
    let bindings = (!bindings.is_empty()).then(|| {
        quote! {
            /// The names that are bound above, so that no constant around can stand for them.
            use #crate_path::__private::{#(binding as #bindings),*};
        }
    });
    quote! {
        use #crate_path::__private::{self as #root, #(#imports),*};
        #body
        #bindings
    }
}

/// The words of the code.
#[derive(Default)]
struct Survey {
    /// Those that are not ours.
    of_user: HashSet<String>,
    /// Marked ones, and whether patterns bind them.
    own: BTreeMap<String, bool>,
    /// Paths to types.
    paths: BTreeSet<Vec<String>>,
}

impl Survey {
    /// Remembers the words of the user that can be meant by themselves: not fields, not the end of paths.
    fn listen(&mut self, tokens: TokenStream, is_wanted: &dyn Fn(&str) -> bool) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        for (i, token) in tokens.iter().enumerate() {
            match token {
                TokenTree::Ident(ident) if !is_field(&tokens, i) && !ends_path(&tokens, i) => {
                    let word = ident.to_string();
                    let word = word.strip_prefix("r#").unwrap_or(&word);
                    if is_wanted(word) {
                        self.of_user.insert(word.to_owned());
                    }
                }
                TokenTree::Group(group) => self.listen(group.stream(), is_wanted),
                _ => {}
            }
        }
    }

    fn read(&mut self, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        for (i, token) in tokens.iter().enumerate() {
            match token {
                TokenTree::Group(group) => self.read(group.stream()),
                TokenTree::Ident(ident) if !is_field(&tokens, i) => {
                    let word = ident.to_string();
                    if word.starts_with(MARK) && !self.of_user.contains(&word) {
                        let before = i.checked_sub(1).map(|before| &tokens[before]);
                        let is_declared = matches!(before, Some(TokenTree::Ident(before))
                            if DECLARING.iter().any(|keyword| before == keyword));
                        let is_item = is_declared || word == ROOT || TYPE_PARAMETERS.contains(&word.as_str());
                        *self.own.entry(word.clone()).or_insert(true) &= !is_item;
                        if word == ROOT
                            && let Some((path, _)) = path_to_type(&tokens, i)
                        {
                            self.paths.insert(path);
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// Items have the first choice of words, then types, then what is bound.
    fn decide(self) -> Decided {
        let Self { of_user, own, paths } = self;
        let mut taken = of_user;
        taken.extend(KEYWORDS.map(str::to_owned));
        let mut decided = Decided::default();
        let choose = |decided: &mut Decided, taken: &mut HashSet<String>, wanted: bool| {
            for (word, &is_bound) in own.iter().filter(|(_, is_bound)| **is_bound == wanted) {
                let mut name = word.strip_prefix(MARK).unwrap_or(word).to_owned();
                while !taken.insert(name.clone()) {
                    name.push('_');
                }
                decided.names.insert(word.clone(), name);
                if is_bound {
                    decided.bound.push(word.clone());
                }
            }
        };
        choose(&mut decided, &mut taken, false);
        for path in paths {
            if path.last().is_some_and(|last| taken.insert(last.clone())) {
                decided.imports.insert(path);
            }
        }
        choose(&mut decided, &mut taken, true);
        decided
    }
}

/// What every word of ours becomes.
#[derive(Default)]
struct Decided {
    names: BTreeMap<String, String>,
    bound: Vec<String>,
    imports: BTreeSet<Vec<String>>,
}

impl Decided {
    fn name(&self, word: &str) -> Ident {
        Ident::new(self.names.get(word).map_or(word, String::as_str), Span::call_site())
    }

    fn bindings(&self) -> Vec<Ident> {
        self.bound.iter().map(|word| self.name(word)).collect()
    }

    /// What is imported, by module.
    fn imports(&self) -> Vec<TokenStream> {
        let ident = |segment: &String| Ident::new(segment, Span::call_site());
        let mut modules: BTreeMap<&[String], Vec<Ident>> = BTreeMap::new();
        for path in &self.imports {
            if let Some((last, module)) = path.split_last() {
                modules.entry(module).or_default().push(ident(last));
            }
        }
        let import = |(module, types): (&[String], Vec<Ident>)| {
            let module = module.iter().map(ident);
            match types.as_slice() {
                [only] => quote!(#(#module::)* #only),
                types if module.len() == 0 => quote!(#(#types),*),
                types => quote!(#(#module::)* {#(#types),*}),
            }
        };
        modules.into_iter().map(import).collect()
    }

    fn rewritten(&self, tokens: TokenStream) -> TokenStream {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut written: Vec<TokenTree> = Vec::with_capacity(tokens.len());
        let mut i = 0;
        while i < tokens.len() {
            let mut length = 1;
            written.push(match &tokens[i] {
                TokenTree::Group(group) => {
                    let inner = self.rewritten(group.stream());
                    let is_braced = group.delimiter() == Delimiter::Brace;
                    let inner = if is_braced { with_short_fields(inner) } else { inner };
                    let mut new = Group::new(group.delimiter(), inner);
                    new.set_span(group.span());
                    new.into()
                }
                TokenTree::Ident(ident) if !is_field(&tokens, i) => {
                    let mut word = ident.to_string();
                    if word == ROOT
                        && let Some((path, end)) = path_to_type(&tokens, i)
                        && self.imports.contains(&path)
                    {
                        length = end - i;
                        word = path.last().cloned().unwrap_or(word);
                    } else if let Some(name) = self.names.get(&word) {
                        word.clone_from(name);
                    }
                    match *ident == word {
                        true => ident.clone().into(),
                        false => Ident::new(&word, ident.span()).into(),
                    }
                }
                other => other.clone(),
            });
            i += length;
        }
        written.into_iter().collect()
    }
}

/// `Point { q, p }` instead of `Point { q: q, p: p }`.
fn with_short_fields(tokens: TokenStream) -> TokenStream {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let is =
        |i: usize, c: char| matches!(tokens.get(i), Some(TokenTree::Punct(punct)) if punct.as_char() == c);
    let mut written: Vec<TokenTree> = Vec::with_capacity(tokens.len());
    let mut i = 0;
    while i < tokens.len() {
        written.push(tokens[i].clone());
        let starts = i == 0 || is(i - 1, ',');
        let is_twice = match (&tokens[i], tokens.get(i + 2)) {
            (TokenTree::Ident(field), Some(TokenTree::Ident(value))) => is(i + 1, ':') && field == value,
            _ => false,
        };
        let ends = i + 3 == tokens.len() || is(i + 3, ',');
        i += if starts && is_twice && ends { 3 } else { 1 };
    }
    written.into_iter().collect()
}

fn is_punct(token: Option<&TokenTree>, c: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == c)
}

fn before(tokens: &[TokenTree], i: usize, distance: usize) -> Option<&TokenTree> {
    i.checked_sub(distance).and_then(|before| tokens.get(before))
}

/// Whether token `i` is a field or a method: it comes after one dot.
fn is_field(tokens: &[TokenTree], i: usize) -> bool {
    is_punct(before(tokens, i, 1), '.') && !is_punct(before(tokens, i, 2), '.')
}

/// Whether token `i` comes after `::`.
fn ends_path(tokens: &[TokenTree], i: usize) -> bool {
    is_punct(before(tokens, i, 1), ':') && is_punct(before(tokens, i, 2), ':')
}

/// The path from [`ROOT`] at `i` to its first type, and where it ends.
fn path_to_type(tokens: &[TokenTree], i: usize) -> Option<(Vec<String>, usize)> {
    let mut path = Vec::new();
    let mut at = i + 1;
    while is_punct(tokens.get(at), ':') && is_punct(tokens.get(at + 1), ':') {
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
