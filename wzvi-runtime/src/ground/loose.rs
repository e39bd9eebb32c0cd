//! Numbers in the formats of `serde`. Formats for people, such as JSON, have no NaN and no infinity: there
//! these are texts, `"NaN"`, `"inf"` and `"-inf"`, and `null` reads as NaN.
//!
//! Tested by `tests/paths/checkpoint/serial.rs`.

use std::fmt;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A number that may be NaN or infinite.
#[derive(Clone, Copy)]
struct ExtendedNumber(f64);

impl Serialize for ExtendedNumber {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            value if value.is_finite() || !serializer.is_human_readable() => serializer.serialize_f64(value),
            value => serializer.collect_str(&value),
        }
    }
}

impl<'de> Deserialize<'de> for ExtendedNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match deserializer.is_human_readable() {
            true => deserializer.deserialize_any(NumberOrText),
            false => f64::deserialize(deserializer).map(Self),
        }
    }
}

struct NumberOrText;

impl Visitor<'_> for NumberOrText {
    type Value = ExtendedNumber;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, \"NaN\", \"inf\" or \"-inf\"")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<ExtendedNumber, E> {
        Ok(ExtendedNumber(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<ExtendedNumber, E> {
        Ok(ExtendedNumber(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<ExtendedNumber, E> {
        Ok(ExtendedNumber(value as f64))
    }

    fn visit_unit<E: Error>(self) -> Result<ExtendedNumber, E> {
        Ok(ExtendedNumber(f64::NAN))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<ExtendedNumber, E> {
        match text {
            "NaN" => Ok(ExtendedNumber(f64::NAN)),
            "inf" => Ok(ExtendedNumber(f64::INFINITY)),
            "-inf" => Ok(ExtendedNumber(f64::NEG_INFINITY)),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(text), &self)),
        }
    }
}

/// One number: `#[serde(with = "loose::number")]`.
pub(crate) mod number {
    use super::{Deserialize, Deserializer, ExtendedNumber, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        ExtendedNumber(*value).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        ExtendedNumber::deserialize(deserializer).map(|ExtendedNumber(value)| value)
    }
}

/// A number that may be absent: `#[serde(with = "loose::option")]`. In a format for people `null` is an
/// absent one.
pub(crate) mod option {
    use super::{Deserialize, Deserializer, ExtendedNumber, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
        value.map(ExtendedNumber).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
        Option::<ExtendedNumber>::deserialize(deserializer)
            .map(|value| value.map(|ExtendedNumber(value)| value))
    }
}

/// Lists by name: `#[serde(with = "loose::lists")]`.
pub(crate) mod lists {
    use super::{Deserialize, Deserializer, ExtendedNumber, Serializer};

    type Lists = Vec<(String, Vec<f64>)>;

    pub(crate) fn serialize<S: Serializer>(lists: &Lists, serializer: S) -> Result<S::Ok, S::Error> {
        let loose = |list: &[f64]| list.iter().copied().map(ExtendedNumber).collect::<Vec<_>>();
        serializer.collect_seq(lists.iter().map(|(name, list)| (name, loose(list))))
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Lists, D::Error> {
        let lists = Vec::<(String, Vec<ExtendedNumber>)>::deserialize(deserializer)?;
        let plain = |list: Vec<ExtendedNumber>| list.into_iter().map(|ExtendedNumber(value)| value).collect();
        Ok(lists.into_iter().map(|(name, list)| (name, plain(list))).collect())
    }
}
