//! Functions that Hamiltonians share: `#[hamiltonian_fn]`.
//!
//! An attribute sees the tokens of its own item only. So `#[hamiltonian_fn] fn morse` emits, beside the
//! function and under the same path, a macro `morse!` that passes the function's tokens to its caller; a path
//! that imports the one imports the other. `#[hamiltonian]` expands to a call of such a macro (a question)
//! for each function that it calls, and continues with the answers. The tokens of methods come from a macro
//! with the name of the struct, which `#[hamiltonian_fn] impl` emits. Functions that a shared function calls
//! are resolved where it is defined, so names have the meaning that its author saw.
//!
//! Tests: `tests/accepted/functions.rs`.

mod calls;
mod define;

use proc_macro2::{Delimiter, Ident, Span, TokenStream, TokenTree};
use quote::{ToTokens, format_ident, quote};
use syn::parse::{Parse, ParseStream, Parser};
use syn::{Block, ImplItem, Item, Path, Signature, braced};

use crate::diagnostics::{Diagnostics, messages};
use crate::input::{self, Function, Library};
use crate::lower::key;
use crate::tokens::{any_word, replaced};

pub(crate) use define::define;

/// An expansion that waits for definitions: `{kind} {crate path} {attribute} {item} {stand-ins} {asked paths}
/// {answers}`.
pub(crate) struct Question {
    pub(super) kind: Ident,
    pub(super) crate_path: Path,
    pub(super) attribute: TokenStream,
    pub(super) item: TokenStream,
    /// Stand-ins for the integrators of a struct, used if a definition is missing.
    pub(super) stand_ins: TokenStream,
    pub(super) asked: Vec<Path>,
    pub(super) answers: Vec<TokenStream>,
}

impl Question {
    /// The question for the next missing definition.
    pub(super) fn ask(&self) -> TokenStream {
        let position = self.answers.len();
        let Some(path) = self.asked.get(position) else { return TokenStream::new() };
        let Some(name) = path.segments.last().map(|last| &last.ident) else { return TokenStream::new() };
        let Self { kind, crate_path, attribute, item, stand_ins, asked, answers } = self;
        let state = quote! {
            {
                { #kind } { #crate_path } { #attribute } { #item } { #stand_ins } { #( { #asked } )* }
                { #( { #answers } )* }
            }
        };
        let callback = quote! { { #crate_path::__private::__continue } };
        let is_of_function = is_function(kind);
        if is_of_function && owner_of(path).is_some() {
            return quote! { #path! { #callback #state } };
        }
        let asker = asker(item).map_or_else(String::new, |asker| format!("_to_be_called_by_{asker}"));
        let alias =
            format_ident!("{name}_needs_the_attribute_hamiltonian_fn{asker}_{position}", span = name.span());
        if is_of_function {
            // The emitted items must be where the function is, and `rustc` can only say that the macro does
            // not exist: its name says what is missing.
            return quote! {
                #[allow(unused_imports)]
                use #path as #alias;
                #alias! { #callback #state }
            };
        }
        // Without the function's macro, one of the same name in an outer scope is found. Neither import may
        // be in the scope of the call, because `rustc` must assume that the call defines any name.
        let missing = format_ident!("__wzvi_missing_{position}");
        let error = owner_of(path).is_none().then(|| messages::unmarked_function(name).to_compile_error());
        quote! {
            const _: () = {
                #[allow(unused_macros)]
                macro_rules! #missing { ($($state:tt)*) => { #error #stand_ins } }
                #[allow(unused_imports)]
                use #missing as #alias;
                const _: () = {
                    #[allow(unused_imports)]
                    use #path as #alias;
                    const _: () = { #alias! { #callback #state } };
                };
            };
        }
    }
}

impl Parse for Question {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let kind = syn::parse2(group(input)?)?;
        let crate_path = path(group(input)?)?;
        let (attribute, item, stand_ins) = (group(input)?, group(input)?, group(input)?);
        let asked = paths(group(input)?)?;
        let mut answers: Vec<TokenStream> = groups(group(input)?).collect();
        if !input.is_empty() {
            answers.push(group(input)?);
        }
        Ok(Self { kind, crate_path, attribute, item, stand_ins, asked, answers })
    }
}

/// What `item` asked for, by the paths of the calls.
fn library(asked: &[Path], answers: &[TokenStream], item: &TokenStream) -> syn::Result<Library> {
    let own = asker(item);
    let mut library = Library::default();
    for (path, answer) in asked.iter().zip(answers) {
        let owner = owner_of(path);
        let is_own = owner.is_some() && own.as_ref().map(Ident::to_string) == owner;
        let other = owner.filter(|_| !is_own);
        for function in
            (|input: ParseStream<'_>| self::answer(input, other.as_deref())).parse2(answer.clone())?
        {
            let name = match &other {
                None if is_own => {
                    library.methods.push(function);
                    continue;
                }
                None => key(path),
                Some(_) if function.reads_self => continue,
                Some(other) => format!("{other}::{}", function.name),
            };
            library.functions.push(Function { name, ..function });
        }
    }
    Ok(library)
}

fn path(tokens: TokenStream) -> syn::Result<Path> {
    Path::parse_mod_style.parse2(tokens)
}

/// Paths in braces.
fn paths(tokens: TokenStream) -> syn::Result<Vec<Path>> {
    groups(tokens).map(path).collect()
}

fn group(input: ParseStream<'_>) -> syn::Result<TokenStream> {
    let content;
    braced!(content in input);
    content.parse()
}

fn groups(tokens: TokenStream) -> impl Iterator<Item = TokenStream> {
    tokens.into_iter().filter_map(|token| match token {
        TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => Some(group.stream()),
        _ => None,
    })
}

/// What a macro of a shared function, or of the methods of a type, hands over:
/// `{ item } { the paths it calls } { their definitions }`. `Self` is that type where it is another one than
/// the struct.
fn answer(input: ParseStream<'_>, other: Option<&str>) -> syn::Result<Vec<Function>> {
    let (item, asked, answers) = (group(input)?, group(input)?, group(input)?);
    let item = match other {
        Some(other) => replaced(item, &|token| match token {
            TokenTree::Ident(word) if word == "Self" => Ident::new(other, word.span()).into_token_stream(),
            token => token.into(),
        }),
        None => item,
    };
    let (asked, answers) = (paths(asked)?, groups(answers).collect::<Vec<_>>());
    let bodies: Vec<(Signature, Block)> = match syn::parse2(item)? {
        Item::Fn(function) => vec![(function.sig, *function.block)],
        Item::Impl(methods) => {
            let methods = methods.items.into_iter().filter_map(|item| match item {
                ImplItem::Fn(method) => Some((method.sig, method.block)),
                _ => None,
            });
            methods.collect()
        }
        _ => Vec::new(),
    };
    let functions = bodies.into_iter().map(|(signature, block)| {
        let name = signature.ident.to_string();
        let reads_self = any_word(quote! { #signature #block }, &mut |word| word == "self" || word == "Self");
        let library = library(&asked, &answers, &TokenStream::new())?;
        Ok(Function { name, signature, block, library, reads_self })
    });
    functions.collect()
}

/// The name of the item that asks.
fn asker(item: &TokenStream) -> Option<Ident> {
    match syn::parse2::<Item>(item.clone()).ok()? {
        Item::Struct(item) => Some(item.ident),
        Item::Fn(item) => Some(item.sig.ident),
        _ => None,
    }
}

const OWNER: &str = "_needs_an_impl_with_the_attribute_hamiltonian_fn";

/// The macro that has the methods of a struct: it is found in the module of both.
fn owner(name: &Ident, span: Span) -> Path {
    format_ident!("{name}{OWNER}", span = span).into()
}

/// The type whose functions a path asks for.
fn owner_of(path: &Path) -> Option<String> {
    path.get_ident()?.to_string().strip_suffix(OWNER).map(str::to_owned)
}

fn is_function(kind: &Ident) -> bool {
    kind == "function"
}

/// The questions of `#[hamiltonian(attribute)] item`, if it calls shared functions and what is read so far
/// has no mistakes.
pub(crate) fn questions(attribute: &TokenStream, item: &TokenStream) -> Option<Question> {
    let mut diagnostics = Diagnostics::new();
    let system = input::read_struct(item.clone(), &mut diagnostics);
    let declaration = input::read_attribute(attribute.clone(), &mut diagnostics);
    diagnostics.finish().ok()?;
    let (system, declaration) = (system?, declaration?);
    let closures = declaration.in_order().map(|hamiltonian| &hamiltonian.closure);
    let asked = calls::of_closures(closures, &system.item.ident);
    let kind = syn::parse_quote!(hamiltonian);
    let (crate_path, attribute, item) = (declaration.crate_path, attribute.clone(), item.clone());
    let (stand_ins, answers) = (TokenStream::new(), Vec::new());
    let question = Question { kind, crate_path, attribute, item, stand_ins, asked, answers };
    (!question.asked.is_empty()).then_some(question)
}

impl Question {
    /// The first question, beside the struct: the expansion of the answers has a scope of its own.
    pub(crate) fn beside_struct(self, stand_ins: TokenStream) -> TokenStream {
        let question = Self { stand_ins, ..self };
        let (item, asked) = (&question.item, question.ask());
        quote! { #item #asked }
    }
}

/// Continues after an answer: with the next question, or with the expansion of the system.
pub(crate) fn proceed(
    tokens: TokenStream,
    expand: impl FnOnce(TokenStream, TokenStream, Library) -> TokenStream,
) -> TokenStream {
    let question = match syn::parse2::<Question>(tokens) {
        Ok(question) => question,
        Err(error) => return error.to_compile_error(),
    };
    if question.answers.len() < question.asked.len() {
        return question.ask();
    }
    if is_function(&question.kind) {
        return define::carrier(&question);
    }
    match library(&question.asked, &question.answers, &question.item) {
        Ok(library) => expand(question.attribute, question.item, library),
        Err(error) => error.to_compile_error(),
    }
}
