//! Messages of the compiler and the tokens they point at, for the systems in `tests/compiler/ui/messages`, to
//! be reviewed as differences. `GOLDEN=overwrite cargo test -p wzvi-macros messages` renews the files. What
//! `rustc` makes of messages is shown by `tests/compiler/ui/fail`.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use proc_macro2::{Delimiter, Span, TokenStream, TokenTree};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/compiler/ui/messages");

/// Expands each item with an attribute of the crate, those in bodies of functions too: the messages, one a
/// line.
fn expand_all(stream: TokenStream, found: &mut String) {
    let mut tokens = stream.into_iter();
    let mut hash = Span::call_site();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Punct(punct) if punct.as_char() == '#' => hash = punct.span(),
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                expand_all(group.stream(), found)
            }
            TokenTree::Group(group) => {
                let mut attribute = group.stream().into_iter();
                let name = attribute.next().map_or(String::new(), |name| name.to_string());
                if !name.starts_with("hamiltonian") {
                    continue;
                }
                let arguments = match attribute.next() {
                    Some(TokenTree::Group(arguments)) => arguments.stream(),
                    _ => TokenStream::new(),
                };
                let expand = if name == "hamiltonian" { super::expand } else { crate::functions::define };
                collect(expand(arguments, item(&mut tokens)), hash, found);
            }
            _ => {}
        }
    }
}

/// The next item: to a semicolon, or the first group in braces.
fn item(tokens: &mut impl Iterator<Item = TokenTree>) -> TokenStream {
    let mut item = Vec::new();
    for token in tokens {
        let is_last = match &token {
            TokenTree::Punct(punct) => punct.as_char() == ';',
            TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
            _ => false,
        };
        item.push(token);
        if is_last {
            break;
        }
    }
    item.into_iter().collect()
}

/// The text of each `compile_error!`, with where and at what it is; those at no token are at the attribute.
fn collect(stream: TokenStream, attribute: Span, found: &mut String) {
    let tokens: Vec<_> = stream.into_iter().collect();
    for (i, token) in tokens.iter().enumerate() {
        match (token, tokens.get(i + 2)) {
            (TokenTree::Ident(name), Some(TokenTree::Group(group))) if *name == "compile_error" => {
                let text: syn::LitStr = syn::parse2(group.stream()).unwrap();
                let own = name.span().join(group.span()).and_then(|span| span.source_text());
                let of = own.unwrap_or_default();
                let at = if of.is_empty() { attribute.start() } else { name.span().start() };
                *found += &format!("{}:{} `{of}`: {}\n", at.line, at.column + 1, text.value());
            }
            (TokenTree::Group(group), _) => collect(group.stream(), attribute, found),
            _ => {}
        }
    }
}

#[test]
fn messages_are_what_was_reviewed() {
    let overwrite = std::env::var("GOLDEN").is_ok_and(|wish| wish == "overwrite");
    let (mut changed, mut scenes) = (String::new(), 0);
    for file in std::fs::read_dir(FOLDER).unwrap() {
        let file = file.unwrap().path();
        if file.extension().is_none_or(|ending| ending != "rs") {
            continue;
        }
        let (source, path) = (std::fs::read_to_string(&file).unwrap(), file.with_extension("txt"));
        let mut now = String::new();
        expand_all(source.parse().unwrap(), &mut now);
        let before = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(!now.is_empty(), "{} has no mistake", file.display());
        scenes += 1;
        if now != before && overwrite {
            std::fs::write(&path, now).unwrap();
        } else if now != before {
            let name = Path::new(file.file_name().unwrap()).display();
            let gone = before.lines().filter(|line| !now.contains(line)).map(|line| format!("- {line}\n"));
            let new = now.lines().filter(|line| !before.contains(line)).map(|line| format!("+ {line}\n"));
            changed += &format!("{name}\n{}", gone.chain(new).collect::<String>());
        }
    }
    assert!(scenes > 20);
    assert!(changed.is_empty(), "{changed}`GOLDEN=overwrite cargo test -p wzvi-macros messages` renews them");
}
