//! `#[hamiltonian_fn]`: the item as it was written, and the macro that exports its tokens. Tests:
//! `tests/accepted/functions.rs`, `tests/compiler/ui`.

use std::hash::{DefaultHasher, Hash, Hasher};

use proc_macro2::{Ident, Punct, Spacing, Span, TokenStream, TokenTree};
use quote::{ToTokens, format_ident, quote};
use syn::{FnArg, GenericParam, ImplItem, Item, ItemFn, ItemImpl, Path, Signature, Token, Type, Visibility};

use super::{Pending, calls};
use crate::diagnostics::{Diagnostics, messages};
use crate::input::{MacroKind, check_attributes};
use crate::lower::key;
use crate::tokens;

/// The expansion of `#[hamiltonian_fn(attribute)] item`.
pub(crate) fn define(attribute: TokenStream, item: TokenStream) -> TokenStream {
    let mut diagnostics = Diagnostics::new();
    let pending = read(attribute, &item, &mut diagnostics);
    let item = match &pending {
        Some(pending) => with_error_functions(item, &pending.crate_path),
        None => item,
    };
    match diagnostics.finish() {
        Ok(()) => {
            let exported = pending.map(|pending| match pending.requested.is_empty() {
                true => exporting_macro(&pending),
                false => pending.request(),
            });
            quote! { #item #exported }
        }
        Err(errors) => quote! { #item #errors },
    }
}

fn read(attribute: TokenStream, item: &TokenStream, diagnostics: &mut Diagnostics) -> Option<Pending> {
    let crate_path = match attribute.is_empty() {
        true => syn::parse_quote!(::wzvi),
        false => diagnostics.accept(syn::parse::Parser::parse2(crate_argument, attribute.clone()))?,
    };
    crate::input::check_nesting(item, diagnostics)?;
    let requested = match diagnostics.accept(syn::parse2::<Item>(item.clone()))? {
        Item::Fn(function) => of_function(&function, diagnostics),
        Item::Impl(methods) => of_impl(&methods, diagnostics),
        other => {
            diagnostics.report(messages::not_a_function(&other));
            Vec::new()
        }
    };
    let (kind, item, stubs) = (syn::parse_quote!(function), item.clone(), TokenStream::new());
    Some(Pending { kind, crate_path, attribute, item, stubs, requested, definitions: Vec::new() })
}

/// The item as `rustc` reads it: where it calls `erf` or `erfc` as methods, they are in scope. `f64` has
/// unstable ones, about which `rustc` would warn.
fn with_error_functions(item: TokenStream, crate_path: &Path) -> TokenStream {
    if !["erf", "erfc"].iter().any(|name| tokens::mentions(&item, name)) {
        return item;
    }
    let import = |block: &mut syn::Block| {
        let import = syn::parse_quote! {
            #[allow(unused_imports)]
            use #crate_path::__private::ErrorFunctions as _;
        };
        block.stmts.insert(0, syn::Stmt::Item(import));
    };
    let lint = || syn::parse_quote!(#[allow(unstable_name_collisions)]);
    match syn::parse2::<Item>(item.clone()) {
        Ok(Item::Fn(mut function)) => {
            import(&mut function.block);
            function.attrs.push(lint());
            function.into_token_stream()
        }
        Ok(Item::Impl(mut methods)) => {
            methods.attrs.push(lint());
            for method in &mut methods.items {
                if let ImplItem::Fn(method) = method {
                    import(&mut method.block);
                }
            }
            methods.into_token_stream()
        }
        _ => item,
    }
}

fn crate_argument(input: syn::parse::ParseStream<'_>) -> syn::Result<Path> {
    input.parse::<Token![crate]>()?;
    input.parse::<Token![=]>()?;
    Path::parse_mod_style(input)
}

fn of_function(function: &ItemFn, diagnostics: &mut Diagnostics) -> Vec<Path> {
    check_attributes(function, MacroKind::Function, diagnostics);
    check_signature(&function.sig, diagnostics);
    let found = calls::of_function(None, &function.sig, &function.block);
    for constant in &found.constants {
        diagnostics.report(messages::relative_constant(constant));
    }
    for call in found.called.iter().filter(|call| call.path.is_ident(&function.sig.ident)) {
        diagnostics.report(messages::recursion(call));
    }
    found.paths(None)
}

fn of_impl(methods: &ItemImpl, diagnostics: &mut Diagnostics) -> Vec<Path> {
    if let Some((path, _)) = &methods.trait_ {
        diagnostics.report(messages::methods_of_trait(path));
    }
    for attribute in &methods.attrs {
        check_attributes(attribute, MacroKind::Function, diagnostics);
    }
    let own = own_type(methods);
    let mut requested: Vec<Path> = Vec::new();
    for item in &methods.items {
        let ImplItem::Fn(method) = item else { continue };
        check_attributes(method, MacroKind::Function, diagnostics);
        check_signature(&method.sig, diagnostics);
        for path in calls::of_function(own, &method.sig, &method.block).paths(None) {
            if !requested.iter().any(|known| key(known) == key(&path)) {
                requested.push(path);
            }
        }
    }
    requested
}

/// The name of the type that has the methods.
fn own_type(methods: &ItemImpl) -> Option<&Ident> {
    match &*methods.self_ty {
        Type::Path(path) => path.path.segments.last().map(|last| &last.ident),
        _ => None,
    }
}

fn check_signature(signature: &Signature, diagnostics: &mut Diagnostics) {
    for parameter in &signature.generics.params {
        if !matches!(parameter, GenericParam::Lifetime(_)) {
            diagnostics.report(messages::generic_function(parameter));
        }
    }
    if let Some(token) = &signature.asyncness {
        diagnostics.report(messages::special_function(token));
    }
    if let Some(FnArg::Receiver(receiver)) = signature.inputs.first()
        && receiver.mutability.is_some()
    {
        diagnostics.report(messages::special_function(receiver));
    }
}

/// The macro that exports the tokens, under the path of the function or of the struct.
pub(super) fn exporting_macro(pending: &Pending) -> TokenStream {
    let Pending { requested, definitions, .. } = pending;
    let (name, visibility, item) = match syn::parse2::<Item>(pending.item.clone()) {
        Ok(Item::Fn(ItemFn { vis, sig, block, .. })) => (sig.ident.clone(), vis, quote! { #sig #block }),
        Ok(Item::Impl(methods)) => {
            let Some(own) = own_type(&methods) else { return TokenStream::new() };
            let name = format_ident!("{own}{}", super::OWNER, span = Span::call_site());
            (name, Visibility::Inherited, methods.to_token_stream())
        }
        _ => return TokenStream::new(),
    };
    let hidden = hidden_name(&name, &pending.item);
    let export = matches!(visibility, Visibility::Public(_)).then(|| quote! { #[macro_export] });
    let item = with_dollar_crate(item);
    quote! {
        #[doc(hidden)]
        #[allow(unused_macros)]
        #export
        macro_rules! #hidden {
            ({ $($callback:tt)* } { $($state:tt)* }) => {
                $($callback)*! { $($state)* { { #item } { #( { #requested } )* } { #( { #definitions } )* } } }
            };
        }
        #[doc(hidden)]
        #[allow(unused_imports)]
        #visibility use #hidden as #name;
    }
}

/// A name that no other function of the crate has: exported macros live at its root.
fn hidden_name(name: &Ident, item: &TokenStream) -> Ident {
    let mut hasher = DefaultHasher::new();
    format!("{:?}", name.span()).hash(&mut hasher);
    item.to_string().hash(&mut hasher);
    format_ident!("__wzvi_{}_{:016x}", name, hasher.finish(), span = Span::call_site())
}

/// `crate::..` as it is written in a macro that other crates call.
fn with_dollar_crate(tokens: TokenStream) -> TokenStream {
    tokens::replaced(tokens, &|token| match &token {
        TokenTree::Ident(name) if name == "crate" => {
            let dollar = Punct::new('$', Spacing::Alone);
            quote! { #dollar #token }
        }
        _ => token.into(),
    })
}
