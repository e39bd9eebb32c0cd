//! The text of a composition: its coefficients, followed by the text of the composed scheme, assembled at compile time.

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
pub(super) struct Equations<H, E, W>(PhantomData<(H, E, W)>);

impl<H, E, W> Equations<H, E, W>
where
    H: Elements + Discretized<E>,
    W: Composes<E, H::Structure>,
{
    const TEXT: Text<ROOM> = Text::of(&W::LISTING, H::EQUATIONS);
    /// The text.
    pub(super) const ALL: &'static str = {
        let text: &'static Text<ROOM> = &Self::TEXT;
        text.as_str()
    };
}

/// A text of at most `N` bytes.
#[derive(Clone, Copy, Debug)]
struct Text<const N: usize> {
    bytes: [u8; N],
    length: usize,
}

impl<const N: usize> Text<N> {
    const fn of(listing: &Listing, base: &str) -> Self {
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
        text.push(if text.length + base.len() <= N { base } else { "its own EQUATIONS\n" });
        text
    }

    const fn as_str(&self) -> &str {
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
            let mut text = Text::<40> { bytes: [0; 40], length: 0 };
            text.push_number(number);
            let read: f64 = text.as_str().parse().unwrap_or(f64::NAN);
            // Half of the last decimal.
            assert!(
                (read - number).abs() <= 0.5e-16 + f64::EPSILON * number.abs(),
                "{number} {}",
                text.as_str()
            );
        }
        let mut text = Text::<40> { bytes: [0; 40], length: 0 };
        text.push_number(-0.25);
        assert_eq!(text.as_str(), "-0.25");
    }

    #[test]
    fn a_text_without_room_refers_to_that_of_the_scheme() {
        let listing = Listing::Steps(&[1.0]);
        let long = "a long text\n".repeat(20);
        let whole = Text::<400>::of(&listing, &long);
        assert!(whole.as_str().ends_with(&long));
        let short = Text::<200>::of(&listing, &long);
        assert!(short.as_str().ends_with("  1 h\nof\n\nits own EQUATIONS\n"), "{}", short.as_str());
    }
}
