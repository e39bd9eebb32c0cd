//! The attribute's arguments, `key = value, ...`. Tests: `tests/compiler/ui/messages`,
//! `lower/tests/robustness.rs`.

use proc_macro2::{Delimiter, Group, Ident, Spacing, Span, TokenStream, TokenTree};
use quote::ToTokens;
use syn::ext::IdentExt;
use syn::parse::{ParseStream, Parser};
use syn::punctuated::Punctuated;
use syn::{ExprClosure, Path, Token, token};

use super::attributes::{self, MacroKind};
use super::{Library, embeddings, groups, nesting};
use crate::diagnostics::{Diagnostics, Extent, Located, messages};
use crate::embedding::{ClockedEmbedding, Embedding, listed};
use crate::key::Key;
use crate::tokens::is_punct;

/// The parsed attribute; missing and wrong parts have been reported.
pub(crate) struct Declaration {
    pub(crate) closures: Vec<Hamiltonian>,
    pub(crate) friction: Option<DeclaredFriction>,
    /// `kT`
    pub(crate) temperature: Option<DeclaredValue>,
    /// How the clock is given; a closure is among `closures`.
    pub(crate) clock: Option<Located<DeclaredClock>>,
    /// The embeddings, with the types as written; without one where only a clock around it is listed.
    pub(crate) embeddings: Vec<(Located<Embedding>, Option<syn::Type>)>,
    /// The schemes with steps of other lengths, whose embeddings are among `embeddings`.
    pub(crate) clocked: Vec<(Located<ClockedEmbedding>, syn::Type)>,
    /// Whether `embeddings` is complete: none was misspelled.
    pub(crate) all_embeddings_known: bool,
    /// The place of `Ito` in the source, if noises are in that sense.
    pub(crate) ito: Option<Extent>,
    /// The schemes of `export = [...]` beside the embeddings, as written; `None` without this key.
    pub(crate) export: Option<Vec<syn::Type>>,
    pub(crate) crate_path: Path,
    /// The shared functions that the closures call.
    pub(crate) library: Library,
}

impl Declaration {
    /// The closures of one key, as they were listed.
    pub(crate) fn of(&self, key: Key) -> impl Iterator<Item = &Hamiltonian> {
        self.closures.iter().filter(move |closure| closure.key == key)
    }

    /// Every closure over phase space, the drift first, those with numbers as values before covectors.
    pub(crate) fn in_order(&self) -> impl Iterator<Item = &Hamiltonian> {
        let of_values = [Key::Drift, Key::Noise, Key::Invariant, Key::Observe];
        let others = [Key::Force, Key::NoiseForce, Key::Constraint, Key::Clock];
        of_values.into_iter().chain(others).flat_map(|key| self.of(key))
    }

    /// The schemes as types of the facade, each with the type as which it was written.
    pub(crate) fn written_schemes(&self) -> Vec<(TokenStream, &syn::Type)> {
        let root = &self.crate_path;
        let clocked = self.clocked.iter().map(|(known, written)| (known.value.path(root), written));
        let plain = self
            .embeddings
            .iter()
            .filter_map(|(known, written)| Some((known.value.path(root), written.as_ref()?)));
        plain.chain(clocked).collect()
    }

    /// The expressions of fields, of the time or of coordinates alone.
    pub(crate) fn given(&self) -> impl Iterator<Item = &DeclaredValue> {
        let friction = self.friction.iter().map(|friction| &friction.given);
        friction.chain(&self.temperature).chain(self.frequency())
    }

    /// The frequency in `clock = curvature(w0)`.
    pub(crate) fn frequency(&self) -> Option<&DeclaredValue> {
        match &self.clock.as_ref()?.value {
            DeclaredClock::Curvature(frequency) => frequency.as_deref(),
            DeclaredClock::Function | DeclaredClock::Pairs => None,
        }
    }
}

/// How a clock is given.
pub(crate) enum DeclaredClock {
    /// By a closure.
    Function,
    /// From the second derivatives of the drift, and a frequency that is added to them.
    Curvature(Option<Box<DeclaredValue>>),
    /// From the bonds of pairs.
    Pairs,
}

/// `friction` or `damping`.
pub(crate) struct DeclaredFriction {
    /// Whether it is `damping`, a matrix.
    pub(crate) is_matrix: bool,
    pub(crate) given: DeclaredValue,
}

/// An expression of fields, or a closure of the coordinates.
pub(crate) struct DeclaredValue {
    pub(crate) value: syn::Expr,
    /// The tokens as they were written.
    pub(crate) tokens: TokenStream,
}

/// A closure over phase space.
pub(crate) struct Hamiltonian {
    pub(crate) key: Key,
    pub(crate) closure: ExprClosure,
    /// The closure's tokens as they were written.
    pub(crate) tokens: TokenStream,
    /// `[|q, p, k| ...; count]`: one noise or constraint per `k`, the closure's last parameter.
    pub(crate) family: Option<syn::Expr>,
    /// The name of a first integral or an observable, `[name = |q, p| ...]`.
    pub(crate) name: Option<Ident>,
}

/// One `name = value`.
struct Entry {
    name: Ident,
    value: TokenStream,
}

/// Reads the arguments of the attribute independently, so that a mistake in one does not hide others.
pub(crate) fn read_attribute(attribute: TokenStream, diagnostics: &mut Diagnostics) -> Option<Declaration> {
    nesting::check(&attribute, diagnostics)?;
    let attribute = attributes::without_refused(attribute, MacroKind::Hamiltonian, diagnostics);
    let attribute = groups::without_single(attribute);
    let mut declaration = Declaration {
        closures: Vec::new(),
        friction: None,
        temperature: None,
        clock: None,
        embeddings: Vec::new(),
        clocked: Vec::new(),
        all_embeddings_known: false,
        ito: None,
        export: None,
        crate_path: syn::parse_quote!(::wzvi),
        library: Library::default(),
    };
    let mut seen: Vec<Key> = Vec::new();
    for entry in split_entries(attribute, diagnostics) {
        let Some(key) = known_key(&entry.name, &seen, diagnostics) else { continue };
        read_entry(&mut declaration, key, &entry, diagnostics);
        seen.push(key);
    }
    for required in [Key::Drift, Key::Embedding] {
        if !seen.contains(&required) {
            diagnostics.report(messages::missing_key(required));
        }
    }
    Some(declaration)
}

/// The key with this name, or the one that a misspelled name may stand for, so that it is not reported as
/// missing, too, and the mistakes of its value are found.
fn known_key(name: &Ident, seen: &[Key], diagnostics: &mut Diagnostics) -> Option<Key> {
    let Some(key) = Key::named(&name.unraw().to_string()) else {
        diagnostics.report(match messages::is_of_ito(name) {
            true => messages::key_of_ito(name),
            false => messages::unknown_key(name),
        });
        return messages::intended_key(&name.to_string()).filter(|intended| !seen.contains(intended));
    };
    if seen.contains(&key) {
        diagnostics.report(messages::duplicate_key(name));
        return None;
    }
    Some(key)
}

fn read_entry(declaration: &mut Declaration, key: Key, entry: &Entry, diagnostics: &mut Diagnostics) {
    if entry.value.is_empty() {
        diagnostics.report(messages::missing_value(&entry.name));
        return;
    }
    match key {
        Key::Drift => declaration.closures.extend(entry.closures(key, drift, diagnostics)),
        Key::Force => {
            let only = |input: ParseStream<'_>| Ok(vec![hamiltonian(input)?]);
            declaration.closures.extend(entry.closures(key, only, diagnostics));
        }
        Key::Noise | Key::NoiseForce | Key::Invariant | Key::Observe | Key::Constraint => {
            declaration.closures.extend(entry.closures(key, hamiltonian_list, diagnostics));
        }
        Key::Friction | Key::Damping if declaration.friction.is_some() => {
            diagnostics.report(messages::friction_and_damping(&entry.name));
        }
        Key::Friction | Key::Damping => {
            let is_matrix = key == Key::Damping;
            let given = diagnostics.accept(entry.given());
            declaration.friction = given.map(|given| DeclaredFriction { is_matrix, given });
        }
        Key::Temperature => declaration.temperature = diagnostics.accept(entry.given()),
        Key::Clock => {
            let extent = Extent::of(&entry.value);
            let is_closure = |input: ParseStream<'_>| {
                let is_closure = is_closure(input);
                input.parse::<TokenStream>().map(|_| is_closure)
            };
            let value = match is_closure.parse2(entry.value.clone()) {
                Ok(true) => {
                    let only = |input: ParseStream<'_>| Ok(vec![hamiltonian(input)?]);
                    declaration.closures.extend(entry.closures(key, only, diagnostics));
                    Some(DeclaredClock::Function)
                }
                _ => diagnostics.accept(entry.parse(clock)),
            };
            declaration.clock = value.map(|value| Located { value, extent });
        }
        Key::Embedding => {
            let before = diagnostics.count();
            (declaration.embeddings, declaration.clocked) = entry.embeddings(diagnostics);
            declaration.all_embeddings_known = diagnostics.count() == before;
        }
        Key::Calculus => declaration.ito = diagnostics.accept(entry.parse(calculus)).flatten(),
        Key::Export => declaration.export = entry.exported(diagnostics),
        Key::Crate => {
            let path = entry.parse(Path::parse_mod_style);
            let path = path.map_err(|_| messages::not_a_path(&entry.value));
            if let Some(path) = diagnostics.accept(path) {
                declaration.crate_path = path;
            }
        }
    }
}

impl Entry {
    /// Parses the whole value. An unexpected end is reported at the last token, not at the attribute.
    fn parse<T>(&self, parser: fn(ParseStream<'_>) -> syn::Result<T>) -> syn::Result<T> {
        let end = self.value.clone().into_iter().last().map_or_else(Span::call_site, |token| token.span());
        let mut group = Group::new(Delimiter::Brace, self.value.clone());
        group.set_span(end);
        let whole = |input: ParseStream<'_>| {
            let content;
            syn::braced!(content in input);
            let value = parser(&content)?;
            if content.is_empty() {
                Ok(value)
            } else {
                Err(messages::unexpected_after_value(content.parse::<TokenStream>()?))
            }
        };
        whole.parse2(TokenTree::Group(group).into())
    }

    fn given(&self) -> syn::Result<DeclaredValue> {
        Ok(DeclaredValue { value: self.parse(|input| input.parse())?, tokens: self.value.clone() })
    }

    fn closures(
        &self,
        key: Key,
        parser: fn(ParseStream<'_>) -> syn::Result<Vec<Hamiltonian>>,
        diagnostics: &mut Diagnostics,
    ) -> Vec<Hamiltonian> {
        let Some(mut list) = diagnostics.accept(self.parse(parser)) else { return Vec::new() };
        if list.is_empty() {
            diagnostics.report(messages::empty_list(&self.value, &self.name));
        }
        if !key.has_names()
            && let Some(name) = list.iter().find_map(|hamiltonian| hamiltonian.name.as_ref())
        {
            diagnostics.report(messages::name_of_other(name));
        }
        list.retain(|closure| match &closure.family {
            Some(count) if key == Key::Invariant => {
                diagnostics.report(messages::family_of_invariants(count));
                false
            }
            Some(count) if key == Key::Observe => {
                diagnostics.report(messages::family_of_observables(count));
                false
            }
            _ if key == Key::Observe && closure.name.is_none() => {
                diagnostics.report(messages::unnamed_observable(&closure.tokens));
                false
            }
            _ => true,
        });
        list.iter_mut().for_each(|closure| closure.key = key);
        list
    }

    fn embeddings(&self, diagnostics: &mut Diagnostics) -> embeddings::Listed {
        let Some(schemes) = diagnostics.accept(self.parse(scheme_list)) else { return Default::default() };
        if schemes.is_empty() {
            diagnostics.report(messages::no_scheme(&self.value, &listed()));
        }
        embeddings::read_embeddings(schemes, diagnostics)
    }

    /// The schemes of `export = [...]`, which may be none.
    fn exported(&self, diagnostics: &mut Diagnostics) -> Option<Vec<syn::Type>> {
        let schemes = self.parse(type_list).map_err(|_| messages::not_exported(&self.value));
        diagnostics.accept(schemes)
    }
}

/// Whether a value starts as a closure.
fn is_closure(input: ParseStream<'_>) -> bool {
    input.peek(Token![|])
        || input.peek(Token![||])
        || input.peek(Token![move])
        || input.peek(Token![async])
        || input.peek(Token![for])
}

fn hamiltonian(input: ParseStream<'_>) -> syn::Result<Hamiltonian> {
    if !is_closure(input) {
        let found: TokenTree = input.parse()?;
        input.parse::<TokenStream>()?;
        return Err(messages::not_a_closure(found));
    }
    let mut cursor = input.cursor();
    let closure: ExprClosure = input.parse()?;
    let end = input.cursor();
    let mut tokens = TokenStream::new();
    while cursor != end {
        let Some((token, next)) = cursor.token_tree() else { break };
        tokens.extend([token]);
        cursor = next;
    }
    if closure.asyncness.is_some() {
        return Err(messages::async_closure(closure.asyncness.to_token_stream()));
    }
    Ok(Hamiltonian { key: Key::Drift, closure, tokens, family: None, name: None })
}

/// One Hamiltonian, or `[H_A, H_B]`.
fn drift(input: ParseStream<'_>) -> syn::Result<Vec<Hamiltonian>> {
    let brackets: Option<TokenTree> =
        if input.peek(token::Bracket) { Some(input.fork().parse()?) } else { None };
    let list = hamiltonian_list(input)?;
    match brackets {
        Some(brackets) if list.len() != 2 || list.iter().any(|part| part.family.is_some()) => {
            Err(messages::parts_of_drift(brackets))
        }
        _ => Ok(list),
    }
}

fn hamiltonian_list(input: ParseStream<'_>) -> syn::Result<Vec<Hamiltonian>> {
    if !input.peek(token::Bracket) {
        return Ok(vec![hamiltonian(input)?]);
    }
    let content;
    syn::bracketed!(content in input);
    let mut list = Vec::new();
    while !content.is_empty() {
        list.push(match content.peek(token::Bracket) {
            true => {
                // A family beside others.
                let family;
                syn::bracketed!(family in content);
                let member = member(&family, true)?;
                if member.family.is_none() {
                    family.parse::<Token![;]>()?;
                }
                member
            }
            false => member(&content, list.is_empty())?,
        });
        if !content.is_empty() {
            content.parse::<Token![,]>()?;
        }
    }
    Ok(list)
}

/// `closure`, `name = closure`, or `closure; count` if it is the only entry.
fn member(input: ParseStream<'_>, may_be_family: bool) -> syn::Result<Hamiltonian> {
    let mut name: Option<Ident> = None;
    if input.peek(syn::Ident) && input.peek2(Token![=]) {
        name = Some(input.parse()?);
        input.parse::<Token![=]>()?;
    }
    let mut member = Hamiltonian { name, ..hamiltonian(input)? };
    if input.peek(Token![;]) {
        if may_be_family {
            input.parse::<Token![;]>()?;
            member.family = Some(input.parse()?);
        }
        if !input.is_empty() {
            return Err(messages::family_in_list(input.parse::<TokenStream>()?));
        }
    }
    Ok(member)
}

/// `curvature`, `curvature(w0)` or `pairs`.
fn clock(input: ParseStream<'_>) -> syn::Result<DeclaredClock> {
    let tokens: TokenStream = input.fork().parse()?;
    let name: Ident = input.parse().map_err(|_| messages::not_a_clock(&tokens))?;
    let clock = match name.to_string().as_str() {
        "pairs" => DeclaredClock::Pairs,
        "curvature" if !input.peek(token::Paren) => DeclaredClock::Curvature(None),
        "curvature" => {
            let content;
            syn::parenthesized!(content in input);
            let given: TokenStream = content.fork().parse()?;
            let value = content.parse().map_err(|_| messages::not_a_clock(&tokens))?;
            if !content.is_empty() {
                return Err(messages::not_a_clock(&tokens));
            }
            DeclaredClock::Curvature(Some(Box::new(DeclaredValue { value, tokens: given })))
        }
        _ => return Err(messages::not_a_clock(&tokens)),
    };
    if input.is_empty() { Ok(clock) } else { Err(messages::not_a_clock(input.parse::<TokenStream>()?)) }
}

/// The sense of the stochastic integral: the place of `Ito`.
fn calculus(input: ParseStream<'_>) -> syn::Result<Option<Extent>> {
    let name: Ident = input.parse().map_err(|error| messages::unknown_calculus_at(error.span()))?;
    match name.to_string().as_str() {
        "Ito" => Ok(Some(Extent::of(&name))),
        "Stratonovich" => Ok(None),
        _ => Err(messages::unknown_calculus_at(name.span())),
    }
}

fn scheme_list(input: ParseStream<'_>) -> syn::Result<Vec<embeddings::DeclaredScheme>> {
    if !input.peek(token::Bracket) {
        return Ok(vec![input.parse()?]);
    }
    let content;
    syn::bracketed!(content in input);
    Ok(Punctuated::<embeddings::DeclaredScheme, Token![,]>::parse_terminated(&content)?.into_iter().collect())
}

fn type_list(input: ParseStream<'_>) -> syn::Result<Vec<syn::Type>> {
    if !input.peek(token::Bracket) {
        return Ok(vec![input.parse()?]);
    }
    let content;
    syn::bracketed!(content in input);
    Ok(Punctuated::<syn::Type, Token![,]>::parse_terminated(&content)?.into_iter().collect())
}

/// Splits at `, key =`, which no value contains at its top level.
fn split_entries(attribute: TokenStream, diagnostics: &mut Diagnostics) -> Vec<Entry> {
    let tokens: Vec<TokenTree> = attribute.into_iter().collect();
    let mut entries: Vec<Entry> = Vec::new();
    let mut position = 0;
    let mut stray = TokenStream::new();
    while position < tokens.len() {
        let before = position.checked_sub(1).map(|before| &tokens[before]);
        let mut at_start = before.is_none_or(|before| is_punct(before, ','));
        if let (TokenTree::Ident(key), Some(before)) = (&tokens[position], before)
            && Key::named(&key.to_string()).is_some()
            && ends_operand(before)
            && is_assignment(&tokens[position + 1..])
        {
            diagnostics.report(messages::missing_comma(key));
            at_start = true;
        }
        match &tokens[position] {
            TokenTree::Ident(key) if at_start && is_assignment(&tokens[position + 1..]) => {
                entries.push(Entry { name: key.clone(), value: TokenStream::new() });
                position += 2;
                continue;
            }
            // The comma between two entries, or after the last.
            token if is_punct(token, ',') && ends_entry(&tokens[position + 1..]) && !entries.is_empty() => {}
            token => match entries.last_mut() {
                Some(entry) => entry.value.extend([token.clone()]),
                None => stray.extend([token.clone()]),
            },
        }
        position += 1;
    }
    if !stray.is_empty() {
        diagnostics.report(messages::expected_key(stray));
    }
    entries
}

/// Whether nothing or the next `key =` follows.
fn ends_entry(rest: &[TokenTree]) -> bool {
    match rest {
        [] => true,
        [TokenTree::Ident(_), rest @ ..] => is_assignment(rest),
        _ => false,
    }
}

/// Whether no expression goes on with a name after `token`.
fn ends_operand(token: &TokenTree) -> bool {
    match token {
        TokenTree::Ident(name) => syn::parse2::<Ident>(name.to_token_stream()).is_ok(),
        TokenTree::Punct(punct) => punct.as_char() == '>',
        TokenTree::Group(_) | TokenTree::Literal(_) => true,
    }
}

/// Whether `tokens` start with `=`, and neither `==` nor `=>`.
fn is_assignment(tokens: &[TokenTree]) -> bool {
    match tokens {
        [TokenTree::Punct(equals), rest @ ..] if equals.as_char() == '=' => {
            let joint = equals.spacing() == Spacing::Joint;
            !(joint && rest.first().is_some_and(|next| is_punct(next, '=') || is_punct(next, '>')))
        }
        _ => false,
    }
}
