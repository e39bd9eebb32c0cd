//! The schemes of `embedding = ...`. Tests: `tests/accepted/embeddings.rs`.

use syn::parse::{Parse, ParseStream};
use syn::{Expr, GenericArgument, Path, PathArguments, Token, Type, TypeTuple};

use super::points::read_points;
use super::system::literal;
use crate::diagnostics::{Diagnostics, Extent, Located, messages};
use crate::embedding::{
    ClockedEmbedding, Declared, Embedding, Letter, LetterKind, MOST_LETTERS, Word, listed, meant, names,
};
use crate::tokens::Written;

/// `Midpoint`, or `Trapezoidal = [(0, 1/2), (1, 1/2)]`.
pub(super) struct DeclaredScheme {
    ty: Type,
    points: Option<Expr>,
}

impl Parse for DeclaredScheme {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let ty = input.parse()?;
        let is_given = input.parse::<Option<Token![=]>>()?.is_some();
        Ok(Self { ty, points: if is_given { Some(input.parse()?) } else { None } })
    }
}

/// The schemes, and those with lengths of their own, with the types as written. The schemes that the latter
/// are made of are among the former.
pub(super) type Listed = (Vec<(Located<Embedding>, Option<Type>)>, Vec<(Located<ClockedEmbedding>, Type)>);

/// The schemes, each once; mistakes are reported.
pub(super) fn read_embeddings(schemes: Vec<DeclaredScheme>, diagnostics: &mut Diagnostics) -> Listed {
    let (declared, schemes) = read_declared(schemes, diagnostics);
    let (mut embeddings, mut clocked): Listed = Default::default();
    for ty in schemes {
        let extent = Extent::of(&ty);
        match diagnostics.accept(scheme_of_list(&ty, &declared)) {
            Some(ListedScheme::Plain(value)) if embeddings.iter().any(|(known, _)| known.value == value) => {
                diagnostics.report(messages::duplicate_embedding(&ty, &value));
            }
            Some(ListedScheme::Plain(value)) => embeddings.push((Located { value, extent }, Some(ty))),
            Some(ListedScheme::Clocked(value)) if clocked.iter().any(|(known, _)| known.value == value) => {
                diagnostics.report(messages::duplicate_embedding(&ty, &value));
            }
            Some(ListedScheme::Clocked(value)) => clocked.push((Located { value, extent }, ty)),
            None => {}
        }
    }
    for (Located { value, extent }, _) in &clocked {
        let base = value.base();
        if embeddings.iter().all(|(known, _)| known.value != base) {
            embeddings.push((Located { value: base, extent: *extent }, None));
        }
    }
    (embeddings, clocked)
}

/// An entry of the list of schemes.
enum ListedScheme {
    Plain(Embedding),
    Clocked(ClockedEmbedding),
}

/// The scheme of an entry of the list.
fn scheme_of_list(ty: &Type, declared: &[Declared]) -> syn::Result<ListedScheme> {
    let Ok((name, arguments)) = name_and_arguments(ty) else {
        return embedding(ty, Inside::List, declared).map(ListedScheme::Plain);
    };
    let text = name.to_string();
    Ok(match (text.as_str(), arguments.as_deref()) {
        ("Clocked" | "Extended", Some([GenericArgument::Type(inner)])) => {
            ListedScheme::Clocked(clocked_inside(ty, &text, inner, declared)?)
        }
        ("Clocked", _) => return Err(messages::scheme_arguments(ty, "Clocked<Verlet>")),
        ("Extended", _) => return Err(messages::scheme_arguments(ty, "Extended<Gauss<8>>")),
        ("Logarithmic", Some([n, d])) => match (share(n), share(d)) {
            (Some(n), Some(d)) => ListedScheme::Clocked(ClockedEmbedding::Logarithmic(n, d)),
            _ => return Err(messages::logarithmic_exponent(ty)),
        },
        ("Logarithmic", _) => return Err(messages::scheme_arguments(ty, "Logarithmic<1, 1>")),
        _ => ListedScheme::Plain(embedding(ty, Inside::List, declared)?),
    })
}

/// `Clocked<E>` of a symmetric scheme, or `Extended<E>` of one whose step in the extended phase space is
/// known.
fn clocked_inside(
    whole: &Type,
    name: &str,
    inner: &Type,
    declared: &[Declared],
) -> syn::Result<ClockedEmbedding> {
    if let Ok((of_inner, arguments)) = name_and_arguments(inner) {
        let text = of_inner.to_string();
        match arguments.as_deref() {
            Some([GenericArgument::Type(base), _]) if text == "Composed" => {
                return Err(messages::clocked_composition(whole, name, base));
            }
            _ if ["Clocked", "Extended", "Logarithmic"].contains(&text.as_str()) => {
                return Err(messages::clock_inside_clock(inner));
            }
            _ => {}
        }
    }
    let scheme = embedding(inner, Inside::List, declared)?;
    match (name, &scheme) {
        ("Extended", Embedding::Verlet | Embedding::Gauss(2..)) => Ok(ClockedEmbedding::Extended(scheme)),
        ("Extended", _) => Err(messages::extended_of_other(inner, &scheme)),
        _ if scheme.keeps_constraints() => Err(messages::clocked_constraints(whole, &scheme)),
        _ if !scheme.is_symmetric() => Err(messages::unsymmetric_clocked(inner, &scheme)),
        _ if !scheme.takes_clocks() => Err(messages::clock_around_other(inner, &scheme)),
        _ => Ok(ClockedEmbedding::Clocked(scheme)),
    }
}

/// The types with points of the user's, and the schemes; without those whose points were wrong, which has
/// been reported.
fn read_declared(schemes: Vec<DeclaredScheme>, diagnostics: &mut Diagnostics) -> (Vec<Declared>, Vec<Type>) {
    let mut declared: Vec<Declared> = Vec::new();
    let (mut mistaken, mut types): (Vec<Written<Path>>, _) = (Vec::new(), Vec::new());
    for DeclaredScheme { ty, points } in schemes {
        let Some(points) = points else {
            types.push(ty);
            continue;
        };
        let path = diagnostics.accept(of_program(&ty));
        match (diagnostics.accept(read_points(&points)), path) {
            (_, Some(path)) if declared.iter().any(|known| known.path == path) => {
                diagnostics.report(messages::points_twice(ty));
            }
            (Some(points), Some(path)) => {
                declared.push(Declared { path, points });
                types.push(ty);
            }
            (None, path) => mistaken.extend(path),
            (_, None) => {}
        }
    }
    types.retain(|ty| !of_program(ty).is_ok_and(|path| mistaken.contains(&path)));
    (declared, types)
}

/// The user's type `Rule` in `Rule` or `Corrected<Rule>`.
fn of_program(ty: &Type) -> syn::Result<Written<Path>> {
    let (name, arguments) = name_and_arguments(ty)?;
    match (name.to_string().as_str(), arguments.as_deref(), ty) {
        ("Corrected" | "Uncorrected" | "Thermostat", Some([GenericArgument::Type(inner)]), _) => {
            of_program(inner)
        }
        (name, None, Type::Path(path)) if names().all(|known| known != name) => {
            Ok(Written(path.path.clone()))
        }
        _ => Err(messages::points_of_other(ty)),
    }
}

/// The wrapper around a scheme.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Inside {
    /// The list, or a thermostat.
    List,
    /// `Corrected` or `Uncorrected`.
    Wrapper,
    Mixed,
}

/// Checks that the scheme inside a wrapper has quadrature points for each term.
fn embedding(ty: &Type, inside: Inside, declared: &[Declared]) -> syn::Result<Embedding> {
    if let Type::Path(path) = ty
        && let path = Written(path.path.clone())
        && let Some(known) = declared.iter().find(|known| known.path == path)
    {
        return Ok(Embedding::Declared(known.clone()));
    }
    let (name, arguments) = name_and_arguments(ty)?;
    let text = name.to_string();
    let is_whole = inside == Inside::List;
    let plain = Embedding::PLAIN.into_iter().find(|plain| plain.name() == text);
    let is_quadrature =
        |of: &_| matches!(of, Embedding::DeltaPlus | Embedding::Midpoint | Embedding::DeltaMinus);
    let plain = plain.filter(|plain| is_whole || is_quadrature(plain));
    let inner = |argument, inside| scheme(argument, inside, declared).map(Box::new);
    Ok(match (text.as_str(), arguments.as_deref(), plain) {
        (_, None, Some(plain)) => plain,
        (_, Some(_), Some(plain)) => return Err(messages::scheme_arguments(ty, &plain.name())),
        ("Lambda", Some([n, d]), _) => match (number(n)?, number(d)?) {
            (n, d) if d == 0 || n > d => return Err(messages::lambda_range(ty)),
            (n, d) => Embedding::Lambda(n, d),
        },
        ("Lambda", ..) => return Err(messages::scheme_arguments(ty, "Lambda<1, 3>")),
        ("Mixed", ..) if inside == Inside::Mixed => return Err(messages::mixed_inside_mixed(ty)),
        ("Mixed", Some([drift, noise]), _) => {
            Embedding::Mixed(inner(drift, Inside::Mixed)?, inner(noise, Inside::Mixed)?)
        }
        ("Mixed", ..) => return Err(messages::scheme_arguments(ty, "Mixed<Midpoint, DeltaPlus>")),
        ("Corrected" | "Uncorrected", ..) if !is_whole => return Err(messages::wrapper_inside(ty)),
        ("Corrected", Some([whole]), _) => Embedding::Corrected(inner(whole, Inside::Wrapper)?),
        ("Uncorrected", Some([whole]), _) => Embedding::Uncorrected(inner(whole, Inside::Wrapper)?),
        ("Corrected" | "Uncorrected", ..) => {
            return Err(messages::scheme_arguments(ty, "Corrected<Midpoint>"));
        }
        ("Gauss", Some([stages]), _) if is_whole => match stages_of(stages) {
            Some(stages @ 1..=16) => Embedding::Gauss(stages),
            _ => return Err(messages::gauss_stages(ty)),
        },
        ("Gauss", ..) if is_whole => return Err(messages::scheme_arguments(ty, "Gauss<4>")),
        ("Composed", Some([GenericArgument::Type(base), _]), _) if is_whole => {
            return Err(messages::composed(ty, base));
        }
        ("Composed", ..) if is_whole => return Err(messages::composed_alone(ty)),
        ("Splitting", Some([GenericArgument::Type(Type::Tuple(word))]), _) if is_whole => {
            Embedding::Splitting(splitting(word)?)
        }
        ("Splitting", ..) if is_whole => {
            return Err(messages::scheme_arguments(ty, "Splitting<(B, A, O, A, B)>"));
        }
        ("Thermostat", Some([GenericArgument::Type(whole)]), _) if is_whole => {
            match embedding(whole, Inside::List, declared)? {
                inner if inner.is_thermostat() => return Err(messages::thermostat_inside(whole)),
                inner => Embedding::Thermostat(Box::new(inner)),
            }
        }
        ("Thermostat", ..) if is_whole => {
            return Err(messages::scheme_arguments(ty, "Thermostat<Midpoint>"));
        }
        ("Clocked" | "Extended" | "Logarithmic", ..) if is_whole => {
            return Err(messages::clock_inside(ty));
        }
        _ if !is_whole && names().any(|known| known == text) => return Err(messages::whole_inside(ty)),
        _ if messages::is_composition(&text) => return Err(messages::weights_alone(ty)),
        _ if messages::is_of_ito(name) => return Err(messages::embedding_of_ito(name)),
        _ => return Err(messages::unknown_embedding(name, meant(&text), &listed())),
    })
}

/// The letters of a splitting: drifts that add to one step, kicks that do, and friction.
fn splitting(tuple: &TypeTuple) -> syn::Result<Word> {
    let letters = tuple.elems.iter().map(letter).collect::<syn::Result<Vec<_>>>()?;
    let word = Word(letters);
    if word.0.len() > MOST_LETTERS {
        return Err(messages::long_word(tuple, MOST_LETTERS, tuple.elems.len()));
    }
    for kind in LetterKind::ALL {
        match word.total(kind) {
            Some(total) if total.is_one() => {}
            Some(total) if total.is_zero() => return Err(messages::missing_letter(tuple, kind.letter())),
            total => return Err(messages::shares_of_letters(tuple, kind.letter(), total)),
        }
    }
    Ok(word)
}

/// `A`, `B`, `O`, and `A<1, 4>`, `B<1, 4>` with a share of the step.
fn letter(ty: &Type) -> syn::Result<Letter> {
    let (name, arguments) = name_and_arguments(ty)?;
    let kind = LetterKind::ALL.into_iter().find(|kind| name == kind.letter());
    let kind = kind.ok_or_else(|| messages::unknown_letter(ty))?;
    let share = match (arguments.as_deref(), kind) {
        (None, _) => None,
        (Some([n, d]), LetterKind::Drift | LetterKind::Kick) => match (share(n), share(d)) {
            (Some(n), Some(d)) => Some((n, d)),
            _ => return Err(messages::share_of_letter(ty)),
        },
        _ => return Err(messages::unknown_letter(ty)),
    };
    Ok(Letter { kind, share })
}

/// The number of stages of a Gauss method.
fn stages_of(argument: &GenericArgument) -> Option<u32> {
    literal(argument).and_then(|number| u32::try_from(number).ok())
}

/// A part of a share: an integer above 0.
fn share(argument: &GenericArgument) -> Option<u32> {
    literal(argument).and_then(|number| u32::try_from(number).ok()).filter(|&number| number > 0)
}

fn scheme(argument: &GenericArgument, inside: Inside, declared: &[Declared]) -> syn::Result<Embedding> {
    match argument {
        GenericArgument::Type(ty) => embedding(ty, inside, declared),
        _ => Err(messages::not_a_scheme(argument, &listed())),
    }
}

fn number(argument: &GenericArgument) -> syn::Result<u32> {
    let number = literal(argument).and_then(|number| u32::try_from(number).ok());
    number.ok_or_else(|| messages::lambda_literal(argument))
}

/// The last segment's name and generic arguments.
fn name_and_arguments(ty: &Type) -> syn::Result<(&syn::Ident, Option<Vec<&GenericArgument>>)> {
    let segment = match ty {
        Type::Path(path) if path.qself.is_none() => path.path.segments.last(),
        Type::Group(group) => return name_and_arguments(&group.elem),
        _ => None,
    };
    let segment = segment.ok_or_else(|| messages::not_a_scheme(ty, &listed()))?;
    match &segment.arguments {
        PathArguments::None => Ok((&segment.ident, None)),
        PathArguments::AngleBracketed(arguments) => {
            Ok((&segment.ident, Some(arguments.args.iter().collect())))
        }
        PathArguments::Parenthesized(_) => Err(messages::not_a_scheme(ty, &listed())),
    }
}
