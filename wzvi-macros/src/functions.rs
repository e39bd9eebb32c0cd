//! Functions that Hamiltonians share: `#[hamiltonian_fn]`.
//!
//! An attribute sees the tokens of its own item only. So `#[hamiltonian_fn] fn morse` emits, beside the
//! function and under the same path, a macro `morse!` that passes the function's tokens to its caller; a path
//! that imports the one imports the other. `#[hamiltonian]` expands to a call of such a macro (a request) for
//! each function that it calls, and resumes with the definitions. The tokens of methods come from a macro
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
use crate::input::{self, Library, SharedFunction};
use crate::lower::key;
use crate::tokens::{any_word, replaced};

pub(crate) use define::define;

/// An expansion that waits for definitions: `{kind} {crate path} {attribute} {item} {stubs} {requested paths}
/// {definitions}`.
pub(crate) struct Pending {
    pub(super) kind: Ident,
    pub(super) crate_path: Path,
    pub(super) attribute: TokenStream,
    pub(super) item: TokenStream,
    /// The stubs for the integrators of a struct, expanded if a definition is missing.
    pub(super) stubs: TokenStream,
    pub(super) requested: Vec<Path>,
    pub(super) definitions: Vec<TokenStream>,
}

impl Pending {
    /// The request for the next missing definition.
    pub(super) fn request(&self) -> TokenStream {
        let position = self.definitions.len();
        let Some(path) = self.requested.get(position) else { return TokenStream::new() };
        let Some(name) = path.segments.last().map(|last| &last.ident) else { return TokenStream::new() };
        let Self { kind, crate_path, attribute, item, stubs, requested, definitions } = self;
        let state = quote! {
            {
                { #kind } { #crate_path } { #attribute } { #item } { #stubs } { #( { #requested } )* }
                { #( { #definitions } )* }
            }
        };
        let callback = quote! { { #crate_path::__private::__continue } };
        let is_of_function = is_function(kind);
        if is_of_function && owner_of(path).is_some() {
            return quote! { #path! { #callback #state } };
        }
        let requester =
            requester(item).map_or_else(String::new, |requester| format!("_to_be_called_by_{requester}"));
        let alias = format_ident!(
            "{name}_needs_the_attribute_hamiltonian_fn{requester}_{position}",
            span = name.span()
        );
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
                macro_rules! #missing { ($($state:tt)*) => { #error #stubs } }
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

impl Parse for Pending {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let kind = syn::parse2(group(input)?)?;
        let crate_path = path(group(input)?)?;
        let (attribute, item, stubs) = (group(input)?, group(input)?, group(input)?);
        let requested = paths(group(input)?)?;
        let mut definitions: Vec<TokenStream> = groups(group(input)?).collect();
        if !input.is_empty() {
            definitions.push(group(input)?);
        }
        Ok(Self { kind, crate_path, attribute, item, stubs, requested, definitions })
    }
}

/// The functions that `item` requested, by the paths of its calls.
fn library(requested: &[Path], definitions: &[TokenStream], item: &TokenStream) -> syn::Result<Library> {
    let own = requester(item);
    let mut library = Library::default();
    for (path, definition) in requested.iter().zip(definitions) {
        let owner = owner_of(path);
        let is_own = owner.is_some() && own.as_ref().map(Ident::to_string) == owner;
        let other = owner.filter(|_| !is_own);
        for function in
            (|input: ParseStream<'_>| self::definition(input, other.as_deref())).parse2(definition.clone())?
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
            library.functions.push(SharedFunction { name, ..function });
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

/// Parses the tokens that a macro exports: `{ item } { the paths it calls } { their definitions }`. `Self`
/// becomes `other`, the type of the functions if it is not the struct.
fn definition(input: ParseStream<'_>, other: Option<&str>) -> syn::Result<Vec<SharedFunction>> {
    let (item, requested, definitions) = (group(input)?, group(input)?, group(input)?);
    let item = match other {
        Some(other) => replaced(item, &|token| match token {
            TokenTree::Ident(word) if word == "Self" => Ident::new(other, word.span()).into_token_stream(),
            token => token.into(),
        }),
        None => item,
    };
    let (requested, definitions) = (paths(requested)?, groups(definitions).collect::<Vec<_>>());
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
        let library = library(&requested, &definitions, &TokenStream::new())?;
        Ok(SharedFunction { name, signature, block, library, reads_self })
    });
    functions.collect()
}

/// The name of the item that requests definitions.
fn requester(item: &TokenStream) -> Option<Ident> {
    match syn::parse2::<Item>(item.clone()).ok()? {
        Item::Struct(item) => Some(item.ident),
        Item::Fn(item) => Some(item.sig.ident),
        _ => None,
    }
}

const OWNER: &str = "_needs_an_impl_with_the_attribute_hamiltonian_fn";

/// The path of the macro that exports the methods of a struct, in the module of the struct.
fn owner(name: &Ident, span: Span) -> Path {
    format_ident!("{name}{OWNER}", span = span).into()
}

/// The type whose functions a path requests.
fn owner_of(path: &Path) -> Option<String> {
    path.get_ident()?.to_string().strip_suffix(OWNER).map(str::to_owned)
}

fn is_function(kind: &Ident) -> bool {
    kind == "function"
}

/// The pending expansion of `#[hamiltonian(attribute)] item`; `None` if it calls no shared functions or has
/// mistakes.
pub(crate) fn pending(attribute: &TokenStream, item: &TokenStream) -> Option<Pending> {
    let mut diagnostics = Diagnostics::new();
    let system = input::read_struct(item.clone(), &mut diagnostics);
    let declaration = input::read_attribute(attribute.clone(), &mut diagnostics);
    diagnostics.finish().ok()?;
    let (system, declaration) = (system?, declaration?);
    let closures = declaration.in_order().map(|hamiltonian| &hamiltonian.closure);
    let requested = calls::of_closures(closures, &system.item.ident);
    let kind = syn::parse_quote!(hamiltonian);
    let (crate_path, attribute, item) = (declaration.crate_path, attribute.clone(), item.clone());
    let (stubs, definitions) = (TokenStream::new(), Vec::new());
    let pending_expansion = Pending { kind, crate_path, attribute, item, stubs, requested, definitions };
    (!pending_expansion.requested.is_empty()).then_some(pending_expansion)
}

impl Pending {
    /// The struct with the first request. The expansion with definitions has a scope of its own.
    pub(crate) fn with_struct(self, stubs: TokenStream) -> TokenStream {
        let pending_expansion = Self { stubs, ..self };
        let (item, requested) = (&pending_expansion.item, pending_expansion.request());
        quote! { #item #requested }
    }
}

/// Resumes with one more definition: requests the next one, or expands the system.
pub(crate) fn resume(
    tokens: TokenStream,
    expand: impl FnOnce(TokenStream, TokenStream, Library) -> TokenStream,
) -> TokenStream {
    let pending_expansion = match syn::parse2::<Pending>(tokens) {
        Ok(pending_expansion) => pending_expansion,
        Err(error) => return error.to_compile_error(),
    };
    if pending_expansion.definitions.len() < pending_expansion.requested.len() {
        return pending_expansion.request();
    }
    if is_function(&pending_expansion.kind) {
        return define::exporting_macro(&pending_expansion);
    }
    match library(&pending_expansion.requested, &pending_expansion.definitions, &pending_expansion.item) {
        Ok(library) => expand(pending_expansion.attribute, pending_expansion.item, library),
        Err(error) => error.to_compile_error(),
    }
}
