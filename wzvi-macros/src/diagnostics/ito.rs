//! The messages about `calculus = Ito`. One function per mistake. Tests: `tests/compiler/ui/messages`.

messages! {
    /// A correction that is neither a force nor the field of a Hamiltonian.
    no_force(found, of_q: &str, of_p: &str, rate: &str) {
        why = match rate {
            "" => String::new(),
            rate => format!(", and changes volumes of phase space at the rate {rate}, which no Hamiltonian does"),
        };
    } = "in the sense of Ito this noise has no equivalent of a Hamiltonian and forces: the Stratonovich drift has the further term c = -1/2 \
        Σ_k (X_k · ∇) X_k, with c_q · δq = {of_q}, c_p · δq = {of_p}; it acts on the coordinates, too{why}; if the model is in the sense of \
        Stratonovich, leave `calculus` out";
    /// A Hamiltonian correction beside a drift in two parts.
    parted_drift(found, hamiltonian: &str) = "the conversion from Ito to Stratonovich adds {hamiltonian} to the drift, which is written in two \
        parts: write it as one Hamiltonian, or leave `calculus` out and add this term to the part that it fits";
    beyond_indices(found) = "the conversion from Ito to Stratonovich cannot be written: its indices exceed 128 bits; add the correction -1/2 \
        Σ_k (X_k · ∇) X_k to the force by hand, and leave `calculus` out";
}
