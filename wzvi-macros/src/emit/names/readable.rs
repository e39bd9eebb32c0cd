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
const TYPE_PARAMETERS: [&str; 3] = ["__S", "__C", "__W"];
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
    let code = nodes(generated);
    survey.read(&code);
    let decided = survey.decide();
    let body = decided.rewritten(code, false);
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
        self.listen_to(&nodes(tokens), is_wanted);
    }

    fn listen_to(&mut self, code: &[Node], is_wanted: &dyn Fn(&str) -> bool) {
        for (i, node) in code.iter().enumerate() {
            match node {
                Node::Word(word, _) if !is_field(code, i) && !ends_path(code, i) => {
                    let word = word.strip_prefix("r#").unwrap_or(word);
                    if is_wanted(word) {
                        self.of_user.insert(word.to_owned());
                    }
                }
                Node::Group(_, inner) => self.listen_to(inner, is_wanted),
                _ => {}
            }
        }
    }

    fn read(&mut self, code: &[Node]) {
        for (i, node) in code.iter().enumerate() {
            match node {
                Node::Group(_, inner) => self.read(inner),
                Node::Word(word, _) if is_marked(code, i) && !self.of_user.contains(word) => {
                    self.read_own(word, code, i);
                }
                _ => {}
            }
        }
    }

    /// The marked `word` at `i`.
    fn read_own(&mut self, word: &str, code: &[Node], i: usize) {
        if word == ROOT {
            self.paths.extend(path_to_type(code, i).map(|(path, _)| path));
        }
        let is_declared = matches!(before(code, i, 1), Some(Node::Word(before, _))
            if DECLARING.contains(&before.as_str()));
        let is_item = is_declared || word == ROOT || TYPE_PARAMETERS.contains(&word);
        match self.own.get_mut(word) {
            Some(is_bound) => *is_bound &= !is_item,
            None => drop(self.own.insert(word.to_owned(), !is_item)),
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

    fn rewritten(&self, code: Vec<Node>, is_braced: bool) -> TokenStream {
        let names: Vec<Option<(String, usize)>> =
            (0..code.len()).map(|i| is_marked(&code, i).then(|| self.rename(&code, i)).flatten()).collect();
        let mut written: Vec<TokenTree> = Vec::with_capacity(code.len());
        let mut next = 0;
        for (i, (node, name)) in code.into_iter().zip(names).enumerate() {
            if i < next {
                continue;
            }
            match (node, name) {
                (Node::Word(_, ident), Some((name, end))) => {
                    written.push(Ident::new(&name, ident.span()).into());
                    next = end;
                }
                (Node::Word(_, ident), None) => written.push(ident.into()),
                (Node::Group(group, inner), _) => {
                    let inner = self.rewritten(inner, group.delimiter() == Delimiter::Brace);
                    let mut new = Group::new(group.delimiter(), inner);
                    new.set_span(group.span());
                    written.push(new.into());
                }
                (Node::Other(token), _) => {
                    if is_braced && is(&token, ',') {
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

    /// What the marked word at `i` becomes, and where that ends.
    fn rename(&self, code: &[Node], i: usize) -> Option<(String, usize)> {
        let Node::Word(word, _) = &code[i] else { return None };
        if word == ROOT
            && let Some((path, end)) = path_to_type(code, i)
            && self.imports.contains(&path)
        {
            return path.into_iter().next_back().map(|name| (name, end));
        }
        self.names.get(word).map(|name| (name.clone(), i + 1))
    }
}

/// `q` at the end instead of `q: q`, as in `Point { q, p }`.
fn shorten_field(written: &mut Vec<TokenTree>) {
    let [before @ .., TokenTree::Ident(field), colon, TokenTree::Ident(value)] = written.as_slice() else {
        return;
    };
    let is_field = is(colon, ':') && before.last().is_none_or(|last| is(last, ','));
    if is_field && field == value {
        written.truncate(written.len() - 2);
    }
}

/// A token, with its words spelled: they are looked at more than once.
enum Node {
    Word(String, Ident),
    Group(Group, Vec<Node>),
    Other(TokenTree),
}

fn nodes(tokens: TokenStream) -> Vec<Node> {
    let node = |token| match token {
        TokenTree::Ident(ident) => Node::Word(ident.to_string(), ident),
        TokenTree::Group(group) => {
            let inner = nodes(group.stream());
            Node::Group(group, inner)
        }
        other => Node::Other(other),
    };
    tokens.into_iter().map(node).collect()
}

fn is(token: &TokenTree, c: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == c)
}

fn is_punct(node: Option<&Node>, c: char) -> bool {
    matches!(node, Some(Node::Other(token)) if is(token, c))
}

fn before(code: &[Node], i: usize, distance: usize) -> Option<&Node> {
    i.checked_sub(distance).and_then(|before| code.get(before))
}

/// Whether node `i` is a word with a mark, and no field.
fn is_marked(code: &[Node], i: usize) -> bool {
    matches!(&code[i], Node::Word(word, _) if word.starts_with(MARK)) && !is_field(code, i)
}

/// Whether node `i` is a field or a method: it comes after one dot.
fn is_field(code: &[Node], i: usize) -> bool {
    is_punct(before(code, i, 1), '.') && !is_punct(before(code, i, 2), '.')
}

/// Whether node `i` comes after `::`.
fn ends_path(code: &[Node], i: usize) -> bool {
    is_punct(before(code, i, 1), ':') && is_punct(before(code, i, 2), ':')
}

/// The path from [`ROOT`] at `i` to its first type, and where it ends.
fn path_to_type(code: &[Node], i: usize) -> Option<(Vec<String>, usize)> {
    let mut path = Vec::new();
    let mut at = i + 1;
    while is_punct(code.get(at), ':') && is_punct(code.get(at + 1), ':') {
        let Some(Node::Word(segment, _)) = code.get(at + 2) else { return None };
        let is_type = segment.starts_with(char::is_uppercase) || PRIMITIVES.contains(&segment.as_str());
        path.push(segment.clone());
        at += 3;
        if is_type {
            return Some((path, at));
        }
    }
    None
}
