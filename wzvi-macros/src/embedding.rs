//! Embeddings as data: where each term of the discrete Lagrangian takes its coordinates. Tests:
//! `tests/accepted/embeddings.rs`, `tests/steps/plan.rs`.

use std::fmt;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{ToTokens, quote};

use crate::diagnostics::{closest, promised, quoted};
use crate::symbolic::Rational;

mod clocked;
mod points;
mod word;

/// The schemes that users know, with the names of their arguments.
const SCHEMES: [(&str, &str); 9] = [
    ("DeltaPlus", ""),
    ("Midpoint", ""),
    ("DeltaMinus", ""),
    ("Lambda", "<N, D>"),
    ("Mixed", "<Drift, Noise>"),
    ("Verlet", ""),
    ("Gauss", "<S>"),
    ("Corrected", "<E>"),
    ("Uncorrected", "<E>"),
];
/// The schemes for systems with friction.
const THERMOSTATS: [(&str, &str); 5] =
    [("Baoab", ""), ("Obabo", ""), ("Gjf", ""), ("GjI", ""), ("Thermostat", "<E>")];

/// The schemes for systems with constraints.
const CONSTRAINED: [(&str, &str); 2] = [("Rattle", ""), ("GBaoab", "")];

/// The schemes as a list in a message.
pub(crate) fn listed() -> String {
    let listed = |schemes: &[(&str, &str)]| quoted(schemes.iter().map(|(name, of)| format!("{name}{of}")));
    let [thermostats @ .., last] = THERMOSTATS;
    let (schemes, thermostats) = (listed(&SCHEMES), listed(&thermostats));
    let [first, second] = CONSTRAINED.map(|scheme| listed(&[scheme]));
    let last = listed(&[last]);
    let [clocked @ .., last_clocked] = CLOCKED;
    let (clocked, last_clocked) = (listed(&clocked), listed(&[last_clocked]));
    format!(
        "{schemes}, with friction {thermostats} and {last}, with constraints {first} and {second}, and with a clock \
         {clocked} and {last_clocked}"
    )
}

/// The names of schemes, which are no types of the program.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    let all = SCHEMES.into_iter().chain(THERMOSTATS).chain(CONSTRAINED).chain(CLOCKED);
    all.map(|(name, _)| name).chain(["Splitting"])
}

/// The scheme that a user means by an unknown word: what other texts call it, or what is spelled like it.
pub(crate) fn meant(word: &str) -> Option<&'static str> {
    Some(match word {
        "ImplicitMidpoint" | "MidPoint" | "ImplicitMidpointRule" => "Midpoint",
        "SymplecticEuler" | "SymplecticEulerA" | "SemiImplicitEuler" | "EulerA" => "DeltaPlus",
        "SymplecticEulerB" | "EulerB" => "DeltaMinus",
        "Langevin" | "BAOAB" => "Baoab",
        "OBABO" => "Obabo",
        "GJF" => "Gjf",
        "GJI" => "GjI",
        "RATTLE" | "SHAKE" | "Shake" => "Rattle",
        "GBAOAB" | "gBAOAB" | "GeodesicBaoab" => "GBaoab",
        "Adaptive" | "Density" | "TimeTransformed" => "Clocked",
        "Poincare" | "ExtendedPhaseSpace" => "Extended",
        "LogarithmicHamiltonian" | "LogH" => "Logarithmic",
        _ => return closest(word, names()),
    })
}

use clocked::CLOCKED;

pub(crate) use clocked::ClockedEmbedding;
pub(crate) use points::{Declared, Points};
pub(crate) use word::{Letter, LetterKind, MOST_LETTERS, Word};

/// A scheme as the user wrote it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Embedding {
    DeltaPlus,
    Midpoint,
    DeltaMinus,
    /// `Lambda<N, D>` with `0 <= N <= D` and `D > 0`, which the parser checks.
    Lambda(u32, u32),
    /// A type of the program, with the points that the attribute gives it.
    Declared(Declared),
    /// `Mixed<Drift, Noise>`; neither is itself mixed or wrapped, which the parser checks.
    Mixed(Box<Embedding>, Box<Embedding>),
    /// `Gauss<S>` with `1 <= S <= 16`, which the parser checks.
    Gauss(u32),
    /// Half a step of `DeltaPlus`, then half a step of `DeltaMinus`.
    Verlet,
    /// `Corrected<E>`; `E` is not wrapped.
    Corrected(Box<Embedding>),
    /// `Uncorrected<E>`; `E` is not wrapped.
    Uncorrected(Box<Embedding>),
    /// `Verlet` on the manifold of constraints.
    Rattle,
    /// `Baoab` on the manifold of constraints.
    GBaoab,
    /// Kicks, drifts and the flow of the bath in turn.
    Baoab,
    Obabo,
    Gjf,
    GjI,
    /// A splitting by the user's letters. The shares of drifts add up to one step, as do those of kicks, and
    /// there is friction.
    Splitting(Word),
    /// Half of the flow of the bath, a step of `E`, the other half; `E` is no thermostat.
    Thermostat(Box<Embedding>),
    /// `E` of the system without its bath, inside of a thermostat; users have no name for it.
    Isolated(Box<Embedding>),
}

/// The treatment of an inconsistent limit.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Correction {
    /// Refuse it.
    Bare,
    /// Add the counter-term.
    Corrected,
    /// Keep it.
    Uncorrected,
}

impl Embedding {
    /// The quadrature points of the drift and of every noise. For a composed step, the mean over its
    /// substeps.
    pub(crate) fn points(&self) -> [Points; 2] {
        let single = |l| [Points::one(l), Points::one(l)];
        match self {
            Self::DeltaPlus => single(Rational::ZERO),
            Self::DeltaMinus => single(Rational::ONE),
            &Self::Lambda(n, d) => single(promised(
                Rational::new(n.into(), d.into()),
                "quadrature points are fractions of 32 bits",
            )),
            Self::Declared(Declared { points, .. }) => [points.clone(), points.clone()],
            Self::Mixed(drift, noise) => {
                let ([of_drift, _], [_, of_noise]) = (drift.points(), noise.points());
                [of_drift, of_noise]
            }
            Self::Corrected(inner)
            | Self::Uncorrected(inner)
            | Self::Thermostat(inner)
            | Self::Isolated(inner) => inner.points(),
            Self::Midpoint
            | Self::Verlet
            | Self::Rattle
            | Self::GBaoab
            | Self::Gauss(_)
            | Self::Baoab
            | Self::Obabo
            | Self::Gjf
            | Self::GjI
            | Self::Splitting(_) => single(Rational::HALF),
        }
    }

    /// The means of the points of the drift and of the noises.
    pub(crate) fn means(&self) -> [Rational; 2] {
        self.points().map(|points| points.mean())
    }

    /// The one-point substeps of this scheme, in order; empty for stages that are solved together and for
    /// splittings.
    pub(crate) fn substeps(&self) -> Vec<Self> {
        let uncorrected = |half: Self| Self::Uncorrected(Box::new(half));
        match self {
            Self::Verlet => vec![uncorrected(Self::DeltaPlus), uncorrected(Self::DeltaMinus)],
            Self::Gauss(1) => vec![Self::Midpoint],
            Self::Isolated(inner) if **inner == Self::Verlet => inner.substeps(),
            Self::Isolated(inner) if inner.stages().is_some() => Vec::new(),
            Self::Gauss(_) | Self::Thermostat(_) | Self::Rattle | Self::GBaoab => Vec::new(),
            word if word.is_word() => Vec::new(),
            whole => vec![whole.clone()],
        }
    }

    /// The number of stages that are solved at once, if there are several.
    pub(crate) fn stages(&self) -> Option<u32> {
        match self {
            Self::Gauss(1) => None,
            Self::Gauss(stages) => Some(*stages),
            Self::Isolated(inner) => inner.stages(),
            _ => None,
        }
    }

    /// The order in `h` without noise.
    pub(crate) fn order(&self) -> u32 {
        match self {
            Self::Gauss(stages) => 2 * stages,
            // Two halves of another flow around it.
            Self::Thermostat(inner) => inner.order().min(2),
            Self::Isolated(inner) => inner.order(),
            Self::Splitting(word) => word.order(),
            _ if self.means()[0] == Rational::HALF => 2,
            _ => 1,
        }
    }

    /// Whether it is a splitting into kicks, drifts and the flow of the bath.
    pub(crate) fn is_word(&self) -> bool {
        self.letters().is_some()
    }

    /// The word of a splitting: its kicks, drifts and flows of the bath, in order.
    pub(crate) fn letters(&self) -> Option<Word> {
        match self {
            Self::Baoab | Self::Gjf | Self::GjI => Some(Word::of("BAOAB")),
            Self::Obabo => Some(Word::of("OBABO")),
            Self::Splitting(word) => Some(word.clone()),
            _ => None,
        }
    }

    /// Whether friction is taken in by a flow of its own.
    pub(crate) fn is_thermostat(&self) -> bool {
        self.is_word() || matches!(self, Self::Thermostat(_) | Self::GBaoab)
    }

    /// Whether steps are made of the flows of `T(p)` and `V(q, t)`, where these are known.
    pub(crate) fn takes_flows(&self) -> bool {
        match self {
            Self::Thermostat(inner) | Self::Isolated(inner) => inner.takes_flows(),
            _ => *self == Self::Verlet || self.is_word(),
        }
    }

    /// Whether its steps stay on the manifold of constraints.
    pub(crate) fn keeps_constraints(&self) -> bool {
        matches!(self, Self::Rattle | Self::GBaoab)
    }

    /// Whether a step backwards undoes a step, however long both are.
    pub(crate) fn is_symmetric(&self) -> bool {
        match self {
            Self::Thermostat(inner) | Self::Isolated(inner) => inner.is_symmetric(),
            word if word.is_word() => word.letters().is_some_and(|word| word.is_symmetric()),
            _ => self.points().iter().all(Points::are_symmetric),
        }
    }

    /// Whether its steps may differ in length, by a clock around it.
    pub(crate) fn takes_clocks(&self) -> bool {
        matches!(self, Self::Midpoint | Self::Verlet | Self::Gauss(_))
    }

    pub(crate) fn correction(&self) -> Correction {
        match self {
            Self::Corrected(_) => Correction::Corrected,
            Self::Uncorrected(_) => Correction::Uncorrected,
            Self::Thermostat(inner) | Self::Isolated(inner) => inner.correction(),
            _ => Correction::Bare,
        }
    }
}

/// A generic argument of a scheme.
enum Argument<'e> {
    Number(u32),
    Letters(&'e Word),
    Scheme(&'e Embedding),
}

impl Embedding {
    /// The schemes without arguments.
    pub(crate) const PLAIN: [Self; 10] = [
        Self::DeltaPlus,
        Self::Midpoint,
        Self::DeltaMinus,
        Self::Verlet,
        Self::Rattle,
        Self::GBaoab,
        Self::Baoab,
        Self::Obabo,
        Self::Gjf,
        Self::GjI,
    ];

    /// The name and the arguments, as users write them. `Isolated`, for which users have no name, is written
    /// as the scheme inside.
    fn spelling(&self) -> (String, Vec<Argument<'_>>) {
        use Argument::{Letters, Number, Scheme};
        let (name, arguments) = match self {
            Self::Splitting(word) => ("Splitting", vec![Letters(word)]),
            Self::Lambda(n, d) => ("Lambda", vec![Number(*n), Number(*d)]),
            Self::Gauss(stages) => ("Gauss", vec![Number(*stages)]),
            Self::Mixed(drift, noise) => ("Mixed", vec![Scheme(drift), Scheme(noise)]),
            Self::Corrected(inner) => ("Corrected", vec![Scheme(inner)]),
            Self::Uncorrected(inner) => ("Uncorrected", vec![Scheme(inner)]),
            Self::Thermostat(inner) => ("Thermostat", vec![Scheme(inner)]),
            Self::Declared(declared) => return (declared.name(), Vec::new()),
            Self::Isolated(inner) => return inner.spelling(),
            plain => return (format!("{plain:?}"), Vec::new()),
        };
        (name.to_owned(), arguments)
    }

    pub(crate) fn name(&self) -> String {
        self.spelling().0
    }

    /// The scheme as a type of the facade or of what stands for it, by its path.
    pub(crate) fn path(&self, wzvi: &impl ToTokens) -> TokenStream {
        match self {
            Self::Isolated(inner) => {
                let inner = inner.path(wzvi);
                return quote!(#wzvi::bath::Isolated<#inner>);
            }
            Self::Declared(Declared { path, .. }) => return path.to_token_stream(),
            _ => {}
        }
        let (name, arguments) = self.spelling();
        let name = Ident::new(&name, Span::call_site());
        let arguments = arguments.iter().map(|argument| match argument {
            Argument::Number(number) => Literal::u32_unsuffixed(*number).into_token_stream(),
            Argument::Letters(word) => word.types(wzvi),
            Argument::Scheme(scheme) => scheme.path(wzvi),
        });
        let arguments: Vec<TokenStream> = arguments.collect();
        let list = (!arguments.is_empty()).then(|| quote!(<#(#arguments),*>));
        quote!(#wzvi::embedding::#name #list)
    }
}

impl fmt::Display for Embedding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, arguments) = self.spelling();
        let arguments = arguments.iter().map(|argument| match argument {
            Argument::Number(number) => number.to_string(),
            Argument::Letters(word) => word.to_string(),
            Argument::Scheme(scheme) => scheme.to_string(),
        });
        let arguments = arguments.collect::<Vec<_>>().join(", ");
        if arguments.is_empty() { f.write_str(&name) } else { write!(f, "{name}<{arguments}>") }
    }
}
