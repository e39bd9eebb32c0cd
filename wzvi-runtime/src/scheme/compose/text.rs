//! The text of a composition: its coefficients, followed by the text of the composed scheme, assembled at
//! compile time.

use std::marker::PhantomData;

use super::{Composes, Partitioned};
use crate::scheme::elements::Elements;
use crate::scheme::system::Discretized;

/// The parts of a step of a composition, for users.
#[derive(Clone, Copy, Debug)]
pub enum Listing {
    /// Steps with these weights.
    Steps(&'static [f64]),
    /// The flows of two parts in turn.
    Turns {
        /// The names of the first and of the second part.
        parts: [&'static str; 2],
        /// In units of the step.
        coefficients: &'static [f64],
        /// A remark on how the parts are taken.
        note: &'static str,
    },
}

/// The names of the parts of a table.
pub(super) const DRIFT_KICK: [&str; 2] = ["drift of ", "kick of "];

/// The listing of a table with these names of its parts.
pub(super) const fn turns<W: Partitioned>([first, second]: [&'static str; 2], note: &'static str) -> Listing {
    let parts = if W::STARTS_WITH_DRIFT { [first, second] } else { [second, first] };
    Listing::Turns { parts, coefficients: W::SEQUENCE, note }
}

/// Largest number of coefficients that are listed.
const LISTED: usize = 100;

/// Largest length of a text in bytes.
const ROOM: usize = 1 << 16;

/// `EQUATIONS` of steps of `E` with the weights `W`, for the system `H`.
pub(super) struct EquationsText<H, E, W>(PhantomData<(H, E, W)>);

impl<H, E, W> EquationsText<H, E, W>
where
    H: Elements + Discretized<E>,
    W: Composes<E, H::Structure>,
{
    /// The order of the weights, or that of the composed steps where it is higher.
    const ORDER: u32 = if W::ORDER > H::PLAN.order { W::ORDER } else { H::PLAN.order };
    const TEXT: BoundedText<ROOM> = BoundedText::of(&W::LISTING, Self::ORDER, H::EQUATIONS);
    /// The text.
    pub(super) const ALL: &'static str = {
        let text: &'static BoundedText<ROOM> = &Self::TEXT;
        text.as_str()
    };
}

/// The beginning of lines in the texts of composed schemes: how closely a step keeps the energy, and its
/// modified energy.
const WITHIN: &str = "  H0 is a first integral: kept by the step nearly, within O(";
const MODIFIED: &str = "  modified energy, kept within ";
/// The most bytes by which the order of a composition is longer than that of a step.
const ORDER_ROOM: usize = 8;

/// Whether `text` is at this place.
const fn begins(bytes: &[u8], at: usize, text: &str) -> bool {
    let text = text.as_bytes();
    let mut i = 0;
    while i < text.len() && at + i < bytes.len() && bytes[at + i] == text[i] {
        i += 1;
    }
    i == text.len()
}

/// A text of at most `N` bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundedText<const N: usize> {
    bytes: [u8; N],
    length: usize,
}

impl<const N: usize> BoundedText<N> {
    /// Texts one after the other, without those for which there is no room.
    pub(crate) const fn joined(texts: &[&str]) -> Self {
        let mut all = Self { bytes: [0; N], length: 0 };
        let mut i = 0;
        while i < texts.len() {
            all.push(texts[i]);
            i += 1;
        }
        all
    }

    /// The text of a composition of this order of steps with the text `base`.
    const fn of(listing: &Listing, order: u32, base: &str) -> Self {
        let mut text = Self { bytes: [0; N], length: 0 };
        let (parts, coefficients) = match listing {
            Listing::Steps(weights) => {
                text.push("A step of size h is, one after the other, a step of size\n");
                (["", ""], *weights)
            }
            Listing::Turns { parts, coefficients, note } => {
                text.push("A step of size h is, one after the other");
                text.push(note);
                text.push(", a\n");
                (*parts, *coefficients)
            }
        };
        let mut i = 0;
        while i < coefficients.len() && i < LISTED {
            text.push("  ");
            text.push(parts[i % 2]);
            text.push_number(coefficients[i]);
            text.push(" h\n");
            i += 1;
        }
        if i < coefficients.len() {
            text.push("  ...\n");
        }
        text.push(match listing {
            Listing::Steps(_) => "of\n\n",
            Listing::Turns { .. } => "where the flows are those in\n\n",
        });
        // The composed scheme has its own constant, of any length.
        if text.length + base.len() + ORDER_ROOM <= N {
            text.push_of_order(base, order);
        } else {
            text.push("its own EQUATIONS\n");
        }
        text
    }

    /// Appends the text of the composed scheme, with the order of the composition in the fact on the energy,
    /// and without the modified energy of the composed step.
    const fn push_of_order(&mut self, base: &str, order: u32) {
        let bytes = base.as_bytes();
        let (mut at, mut is_of_modified) = (0, false);
        while at < bytes.len() {
            let mut end = at;
            while end < bytes.len() && bytes[end] != b'\n' {
                end += 1;
            }
            // The terms of the modified energy are indented by more.
            is_of_modified = begins(bytes, at, MODIFIED) || is_of_modified && begins(bytes, at, "    ");
            if !is_of_modified {
                let power = if begins(bytes, at, WITHIN) { at + WITHIN.len() } else { end };
                let mut i = at;
                while i < end && self.length < N {
                    self.bytes[self.length] = bytes[i];
                    self.length += 1;
                    i += 1;
                    if i == power && power < end {
                        self.push_order(order);
                        while i < end && bytes[i] != b')' {
                            i += 1;
                        }
                    }
                }
                self.push("\n");
            }
            at = end + 1;
        }
    }

    /// The order as a power of `h`: `h`, `h²`, `h^4`.
    const fn push_order(&mut self, order: u32) {
        match order {
            1 => self.push("h"),
            2 => self.push("h²"),
            _ => {
                self.push("h^");
                if order > 9 {
                    self.push_digit((order / 10 % 10) as u128);
                }
                self.push_digit((order % 10) as u128);
            }
        }
    }

    pub(crate) const fn as_str(&self) -> &str {
        match std::str::from_utf8(self.bytes.split_at(self.length).0) {
            Ok(text) => text,
            // Not reached: only whole texts are pushed.
            Err(_) => "",
        }
    }

    /// Appends `text`, or nothing if it does not fit.
    const fn push(&mut self, text: &str) {
        let bytes = text.as_bytes();
        if self.length + bytes.len() > N {
            return;
        }
        let mut i = 0;
        while i < bytes.len() {
            self.bytes[self.length] = bytes[i];
            self.length += 1;
            i += 1;
        }
    }

    const fn push_digit(&mut self, digit: u128) {
        if self.length < N {
            self.bytes[self.length] = b'0' + digit as u8;
            self.length += 1;
        }
    }

    /// Appends a number to 16 decimals: weights are of order 1.
    const fn push_number(&mut self, number: f64) {
        const UNIT: u128 = 10_u128.pow(16);
        let size = if number < 0.0 { -number } else { number };
        if size.is_nan() || size >= 1e15 {
            return self.push("(no number)");
        }
        if number < 0.0 {
            self.push("-");
        }
        let bits = size.to_bits();
        let (biased, fraction) = ((bits >> 52) as u32, (bits & ((1 << 52) - 1)) as u128);
        // `mantissa / 2^shift`, where `size < 2^50` makes `shift` positive.
        let (mantissa, shift) =
            if biased == 0 { (fraction, 1074) } else { (fraction + (1 << 52), 1075 - biased) };
        let scaled = if shift > 120 { 0 } else { (mantissa * UNIT + (1 << (shift - 1))) >> shift };
        let (mut whole, mut rest) = (scaled / UNIT, scaled % UNIT);
        let mut power = 1;
        while whole / power >= 10 {
            power *= 10;
        }
        while power > 0 {
            self.push_digit(whole / power);
            whole %= power;
            power /= 10;
        }
        if rest != 0 {
            self.push(".");
        }
        let mut unit = UNIT / 10;
        while rest != 0 {
            self.push_digit(rest / unit);
            rest %= unit;
            unit /= 10;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_that_were_written() {
        for number in
            [0.0, 1.0, 0.5, 1.3512071919596575, -1.7024143839193153, 12.25, -0.016404589403617633, 1e-300]
        {
            let mut text = BoundedText::<40> { bytes: [0; 40], length: 0 };
            text.push_number(number);
            let read: f64 = text.as_str().parse().unwrap_or(f64::NAN);
            // Half of the last decimal.
            assert!(
                (read - number).abs() <= 0.5e-16 + f64::EPSILON * number.abs(),
                "{number} {}",
                text.as_str()
            );
        }
        let mut text = BoundedText::<40> { bytes: [0; 40], length: 0 };
        text.push_number(-0.25);
        assert_eq!(text.as_str(), "-0.25");
    }

    #[test]
    fn a_text_without_room_refers_to_that_of_the_scheme() {
        let listing = Listing::Steps(&[1.0]);
        let long = "a long text\n".repeat(20);
        let whole = BoundedText::<400>::of(&listing, 2, &long);
        assert!(whole.as_str().ends_with(&long));
        let short = BoundedText::<200>::of(&listing, 2, &long);
        assert!(short.as_str().ends_with("  1 h\nof\n\nits own EQUATIONS\n"), "{}", short.as_str());
    }

    /// The energy of a composed step is kept to the order of the composition, not to that of its substeps.
    #[test]
    fn the_energy_is_kept_to_the_order_of_the_composition() {
        let base = "Verlet\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²) between the boundaries of its branches\n  \
                    modified energy, kept within O(h⁴): H0 + h² (...)\n    H_pp(H_q,H_q) = p²\n  first integral p\n";
        for (order, power) in [(4, "h^4"), (8, "h^8"), (10, "h^10")] {
            let text = BoundedText::<600>::of(&Listing::Steps(&[1.0]), order, base);
            let facts = format!(
                "Facts\n  H0 is a first integral: kept by the step nearly, within O({power}) between the boundaries of its branches\n  first integral p\n"
            );
            assert!(text.as_str().ends_with(&facts), "{}", text.as_str());
        }
    }
}
