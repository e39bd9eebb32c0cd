//! The description of a system for programs in other languages, and the systems that these make from named
//! numbers. The key `export` of `#[hamiltonian]` implements [`Exported`]; nothing here is `unsafe`, and
//! nothing here knows C.
//!
//! Tested by `tests/paths/export.rs`.

use crate::error::ConfigError;
use crate::scheme::system::Hamiltonian;

/// A system that programs in other languages can make and run.
pub trait Exported: Hamiltonian + Sized {
    /// The name of the type.
    const NAME: &'static str;
    /// Its documentation, line by line.
    const DOC: &'static str;
    /// Its fields, in the order of the struct.
    const FIELDS: &'static [FieldDescription];
    /// The closures of the attribute, each with its key, as they were written.
    const CLOSURES: &'static [(&'static str, &'static str)];
    /// The names of its schemes, as they were written, in the order of [`Exported::Schemes`].
    const SCHEMES: &'static [&'static str];
    /// Its schemes as a list: `(Midpoint, (Verlet, ()))`.
    type Schemes;

    /// The system with these fields.
    ///
    /// # Errors
    /// [`ConfigError::Setting`] with the name of a field that is missing or does not fit.
    fn from_fields(fields: &dyn GivenFields) -> Result<Self, ConfigError>;
}

/// A field of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldDescription {
    /// Its name, a number in a tuple struct.
    pub name: &'static str,
    /// Its type, as it was written.
    pub ty: &'static str,
    /// Its documentation.
    pub doc: &'static str,
}

/// Numbers in the shape of an array, the last index fastest. A single number has no axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Given<'g> {
    /// The numbers, as many as the product of the lengths.
    pub values: GivenNumbers<'g>,
    /// The length of each axis.
    pub shape: &'g [usize],
}

/// Real numbers or integers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GivenNumbers<'g> {
    /// Real numbers.
    Reals(&'g [f64]),
    /// Integers.
    Integers(&'g [i64]),
}

/// Values for the fields of a system, by name.
pub trait GivenFields {
    /// The value with this name.
    fn given(&self, name: &str) -> Option<Given<'_>>;
}

/// A type that a field of an exported system may have: real numbers, integers, truth values, and arrays and
/// lists of these.
#[diagnostic::on_unimplemented(
    message = "a field of an exported system cannot be a `{Self}`",
    note = "programs in other languages give numbers, arrays of numbers `[T; N]` and lists `Vec<T>`: give the field one of these types, or leave `export` out"
)]
pub trait FromGiven: Sized {
    /// The value with these numbers.
    ///
    /// # Errors
    /// A text that says what was expected.
    fn from_given(given: &Given<'_>) -> Result<Self, String>;
}

/// The value of a field.
///
/// # Errors
/// [`ConfigError::Setting`] with its name, if it is missing or does not fit.
pub fn field<T: FromGiven>(fields: &dyn GivenFields, name: &str) -> Result<T, ConfigError> {
    let Some(given) = fields.given(name) else {
        return Err(ConfigError::Setting(format!("the parameter `{name}` is missing")));
    };
    T::from_given(&given)
        .map_err(|expected| ConfigError::Setting(format!("the parameter `{name}` has to be {expected}")))
}

impl<'g> Given<'g> {
    /// A single number, if it has no axes.
    fn single(&self) -> Option<SingleNumber> {
        match (self.values, self.shape) {
            (GivenNumbers::Reals(&[value]), []) => Some(SingleNumber::Real(value)),
            (GivenNumbers::Integers(&[value]), []) => Some(SingleNumber::Integer(value)),
            _ => None,
        }
    }

    /// The part with this index along the first axis; `None` beyond the end, and for a single number.
    pub fn part(&self, index: usize) -> Option<Given<'g>> {
        let (&length, shape) = self.shape.split_first()?;
        let size = shape.iter().try_fold(1_usize, |size, &length| size.checked_mul(length))?;
        let start = index.checked_mul(size)?;
        let range = start..start.checked_add(size)?;
        let values = match self.values {
            GivenNumbers::Reals(values) => GivenNumbers::Reals(values.get(range)?),
            GivenNumbers::Integers(values) => GivenNumbers::Integers(values.get(range)?),
        };
        (index < length).then_some(Given { values, shape })
    }

    /// The value in the words of a message.
    fn described(&self) -> String {
        match self.single() {
            Some(SingleNumber::Real(value)) => format!("{value:?}"),
            Some(SingleNumber::Integer(value)) => value.to_string(),
            None => format!("an array of shape {:?}", self.shape),
        }
    }
}

/// A number by itself.
enum SingleNumber {
    Real(f64),
    Integer(i64),
}

/// Every integer up to here is a real number without rounding.
const LARGEST_EXACT: u64 = 1 << f64::MANTISSA_DIGITS;

impl FromGiven for f64 {
    fn from_given(given: &Given<'_>) -> Result<Self, String> {
        match given.single() {
            Some(SingleNumber::Real(value)) => Ok(value),
            #[allow(clippy::cast_precision_loss, reason = "exact up to this bound")]
            Some(SingleNumber::Integer(value)) if value.unsigned_abs() <= LARGEST_EXACT => Ok(value as f64),
            _ => Err(format!("a real number, not {}", given.described())),
        }
    }
}

impl FromGiven for bool {
    fn from_given(given: &Given<'_>) -> Result<Self, String> {
        match given.single() {
            Some(SingleNumber::Integer(0)) => Ok(false),
            Some(SingleNumber::Integer(1)) => Ok(true),
            _ => Err(format!("true or false, 1 or 0, not {}", given.described())),
        }
    }
}

macro_rules! integers {
    ($($integer:ty),*) => {
        $(
            impl FromGiven for $integer {
                fn from_given(given: &Given<'_>) -> Result<Self, String> {
                    let value = match given.single() {
                        Some(SingleNumber::Integer(value)) => Self::try_from(value).ok(),
                        _ => None,
                    };
                    value.ok_or_else(|| {
                        let found = given.described();
                        format!("an integer from {} to {}, not {found}", Self::MIN, Self::MAX)
                    })
                }
            }
        )*
    };
}
integers!(i8, i16, i32, i64, i128, isize, u8, u16, u32, u64, u128, usize);

impl<T: FromGiven> FromGiven for Vec<T> {
    fn from_given(given: &Given<'_>) -> Result<Self, String> {
        let Some(&length) = given.shape.first() else {
            return Err(format!("an array, not {}", given.described()));
        };
        let mut list = Self::new();
        list.try_reserve_exact(length)
            .map_err(|_| format!("an array that memory has room for, not {length} rows"))?;
        for index in 0..length {
            let part = given.part(index).ok_or("an array with as many numbers as its shape says")?;
            let element = T::from_given(&part);
            list.push(element.map_err(|expected| format!("an array with {expected} at index {index}"))?);
        }
        Ok(list)
    }
}

impl<T: FromGiven> FromGiven for Box<[T]> {
    fn from_given(given: &Given<'_>) -> Result<Self, String> {
        Vec::from_given(given).map(Vec::into_boxed_slice)
    }
}

impl<T: FromGiven, const N: usize> FromGiven for [T; N] {
    fn from_given(given: &Given<'_>) -> Result<Self, String> {
        let list = Vec::from_given(given)?;
        let found = list.len();
        list.try_into().map_err(|_| format!("an array of length {N}, not {found}"))
    }
}
