//! Whether the package that is compiled depends on `wzvi`. A program that reaches the macros through another
//! crate has to name the path: `::wzvi`, which expansions name, does not exist there, and `rustc` cannot tell
//! what to write.

use std::path::Path;

use proc_macro2::{TokenStream, TokenTree};

use crate::diagnostics::messages;
use crate::tokens::is_punct;

/// The error of an attribute without the key `crate` in a package whose manifest does not name `wzvi`.
pub(crate) fn missing(attribute: &TokenStream) -> Option<syn::Error> {
    let tokens: Vec<TokenTree> = attribute.clone().into_iter().collect();
    let is_key = |pair: &[TokenTree]| match pair {
        [TokenTree::Ident(key), equals] => *key == "crate" && is_punct(equals, '='),
        _ => false,
    };
    if tokens.windows(2).any(is_key) {
        return None;
    }
    let folder = std::env::var_os("CARGO_MANIFEST_DIR")?;
    let manifest = std::fs::read_to_string(Path::new(&folder).join("Cargo.toml")).ok()?;
    (!names_crate(&manifest)).then(messages::no_dependency)
}

/// Whether `wzvi` is a word of a manifest. `wzvi-extras` is another one.
fn names_crate(manifest: &str) -> bool {
    let lines = manifest.lines().map(|line| line.split('#').next().unwrap_or_default());
    let is_of_name = |letter: char| letter.is_alphanumeric() || letter == '-' || letter == '_';
    lines.flat_map(|line| line.split(move |letter| !is_of_name(letter))).any(|word| word == "wzvi")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_is_a_word_of_the_manifest() {
        for manifest in [
            "[dependencies]\nwzvi = \"0.1\"",
            "wzvi.workspace = true",
            "[dependencies.wzvi]",
            "name = \"wzvi\"",
        ] {
            assert!(names_crate(manifest), "{manifest}");
        }
        for manifest in
            ["[dependencies]\nfacade = \"1\" # has wzvi", "wzvi-extras = \"1\"", "wzvi_own = \"1\""]
        {
            assert!(!names_crate(manifest), "{manifest}");
        }
    }

    /// The key is one, whatever the manifest says.
    #[test]
    fn a_path_is_no_mistake() {
        assert!(missing(&"drift = |q, p| p, crate = facade::wzvi".parse().unwrap_or_default()).is_none());
    }
}
