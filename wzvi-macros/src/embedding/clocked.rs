//! Schemes whose steps have lengths of their own, by a clock: each lists the scheme that it is made of.

use std::fmt;

use proc_macro2::{Literal, TokenStream};
use quote::{ToTokens, quote};

use super::Embedding;

/// The schemes with lengths of their own, with the names of their arguments.
pub(crate) const CLOCKED: [(&str, &str); 3] =
    [("Clocked", "<E>"), ("Extended", "<E>"), ("Logarithmic", "<N, D>")];

/// A scheme with lengths of its own, as the user wrote it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum ClockedEmbedding {
    /// `Clocked<E>`: steps of the symmetric scheme `E`, with a density that follows the clock.
    Clocked(Embedding),
    /// `Extended<E>`: steps of the Hamiltonian `Q (H0 + p_t)`. `E` is `Verlet`, or `Gauss<S>` with several
    /// stages.
    Extended(Embedding),
    /// `Logarithmic<N, D>`: steps of `f(T + p_t) - f(-V)` with `f'(x) = x^(-N/D)`, both numbers above 0.
    Logarithmic(u32, u32),
}

impl ClockedEmbedding {
    /// The scheme that is generated for it, and that takes plain steps beside its own.
    pub(crate) fn base(&self) -> Embedding {
        match self {
            Self::Clocked(inner) | Self::Extended(inner) => inner.clone(),
            Self::Logarithmic(..) => Embedding::Verlet,
        }
    }

    /// The scheme as a type of the facade, by its path.
    pub(crate) fn path(&self, wzvi: &impl ToTokens) -> TokenStream {
        match self {
            Self::Clocked(inner) => {
                let inner = inner.path(wzvi);
                quote!(#wzvi::embedding::Clocked<#inner>)
            }
            Self::Extended(inner) => {
                let inner = inner.path(wzvi);
                quote!(#wzvi::embedding::Extended<#inner>)
            }
            Self::Logarithmic(n, d) => {
                let [n, d] = [n, d].map(|number| Literal::u32_unsuffixed(*number));
                quote!(#wzvi::embedding::Logarithmic<#n, #d>)
            }
        }
    }
}

impl fmt::Display for ClockedEmbedding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clocked(inner) => write!(f, "Clocked<{inner}>"),
            Self::Extended(inner) => write!(f, "Extended<{inner}>"),
            Self::Logarithmic(n, d) => write!(f, "Logarithmic<{n}, {d}>"),
        }
    }
}
