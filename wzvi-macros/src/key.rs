//! The keys of the attribute. [`read_attribute`](crate::input::read_attribute) has an arm for each.

/// Defines [`Key`] with the name that users write for each.
macro_rules! keys {
    ($($(#[doc = $doc:literal])* $key:ident = $name:literal,)+) => {
        /// A key of the attribute. Closures over phase space are checked in this order.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
        pub(crate) enum Key {
            $($(#[doc = $doc])* $key,)+
        }

        impl Key {
            /// All keys, in the order in which messages list them.
            pub(crate) const ALL: &[Self] = &[$(Self::$key),+];

            /// As users write it.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$key => $name,)+
                }
            }
        }
    };
}

keys! {
    /// One, or the two parts of `drift = [H_A, H_B]`.
    Drift = "drift",
    Noise = "noise",
    /// A force beside the drift, a covector.
    Force = "force",
    /// A covector that drives a Wiener process.
    NoiseForce = "noise_force",
    /// Rates.
    Friction = "friction",
    /// A matrix in their place.
    Damping = "damping",
    /// `kT`
    Temperature = "temperature",
    /// The sense of the noises.
    Calculus = "calculus",
    Embedding = "embedding",
    Invariant = "invariant",
    /// A named function of the state, for results alone.
    Observe = "observe",
    /// A function of coordinates and time that is zero along every path.
    Constraint = "constraint",
    /// The wanted length of a step, up to a factor: a function of the state, or how it is derived.
    Clock = "clock",
    /// Schemes beside the embeddings, for programs in other languages.
    Export = "export",
    /// The path of the facade.
    Crate = "crate",
}

impl Key {
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|key| key.name() == name)
    }

    /// Whether its closures may have names.
    pub(crate) fn has_names(self) -> bool {
        matches!(self, Self::Invariant | Self::Observe)
    }

    /// Whether its value is a covector, not a number.
    pub(crate) fn is_covector(self) -> bool {
        matches!(self, Self::Force | Self::NoiseForce)
    }
}
