//! Settings of a task, by name. GivenFields of the system have the names `parameter.<field>`.

use std::collections::BTreeMap;

use wzvi::exported::{FieldDescription, Given, GivenFields, GivenNumbers};

use crate::error::TaskError;

/// The prefix of the fields of a system among settings.
pub const PARAMETER: &str = "parameter.";

/// Settings of all kinds of tasks.
pub const COMMON: &[&str] = &[
    "scheme",
    "q",
    "p",
    "t",
    "h",
    "eps",
    "until",
    "steps",
    "whole_steps",
    "project_start",
    "threads",
    "unwatched",
    "noise",
    "seed",
    "width",
    "truncation",
    "increments",
];

/// The value of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Real numbers and the lengths of their axes; none for a single number.
    Reals(Vec<f64>, Vec<usize>),
    /// Integers and the lengths of their axes.
    Integers(Vec<i64>, Vec<usize>),
    /// A text.
    Text(String),
}

impl Value {
    fn given(&self) -> Option<Given<'_>> {
        match self {
            Self::Reals(values, shape) => Some(Given { values: GivenNumbers::Reals(values), shape }),
            Self::Integers(values, shape) => Some(Given { values: GivenNumbers::Integers(values), shape }),
            Self::Text(_) => None,
        }
    }
}

/// The settings of a task. A later value replaces an earlier one.
#[derive(Clone, Debug, Default)]
pub struct Settings(BTreeMap<String, Value>);

/// Real numbers and the lengths of their axes.
#[derive(Clone, Debug, PartialEq)]
pub struct RealArray {
    /// The numbers, the last index fastest.
    pub values: Vec<f64>,
    /// The length of each axis.
    pub shape: Vec<usize>,
}

impl RealArray {
    /// The rows along the first axis; a single row without axes or with one.
    pub fn rows(&self) -> Vec<Vec<f64>> {
        match self.shape[..] {
            [] | [_] => vec![self.values.clone()],
            _ if self.values.is_empty() => Vec::new(),
            [rows, ..] => {
                let length = self.values.len() / rows;
                (0..rows).map(|row| self.values[row * length..(row + 1) * length].to_vec()).collect()
            }
        }
    }
}

impl Settings {
    /// Sets a value.
    pub fn set(&mut self, name: &str, value: Value) {
        self.0.insert(name.to_owned(), value);
    }

    /// Whether a setting was made.
    pub fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// A number.
    ///
    /// # Errors
    /// If it is another kind of value.
    pub fn real(&self, name: &str) -> Result<Option<f64>, TaskError> {
        match self.0.get(name) {
            None => Ok(None),
            Some(Value::Reals(values, _)) if values.len() == 1 => Ok(Some(values[0])),
            #[allow(clippy::cast_precision_loss, reason = "an integer in the place of a real number")]
            Some(Value::Integers(values, _)) if values.len() == 1 => Ok(Some(values[0] as f64)),
            Some(_) => Err(wrong(name, "a number")),
        }
    }

    /// An integer of 0 or more.
    ///
    /// # Errors
    /// If it is another kind of value.
    pub fn natural(&self, name: &str) -> Result<Option<u64>, TaskError> {
        match self.0.get(name) {
            None => Ok(None),
            Some(Value::Integers(values, _)) if values.len() == 1 => match u64::try_from(values[0]) {
                Ok(value) => Ok(Some(value)),
                Err(_) => {
                    Err(TaskError::setting(format!("`{name}` is {}: it has to be 0 or more", values[0])))
                }
            },
            Some(_) => Err(wrong(name, "an integer of 0 or more")),
        }
    }

    /// An integer of 0 or more that counts things in memory.
    ///
    /// # Errors
    /// If it is another kind of value.
    pub fn count(&self, name: &str) -> Result<Option<usize>, TaskError> {
        let Some(value) = self.natural(name)? else { return Ok(None) };
        usize::try_from(value).map(Some).map_err(|_| wrong(name, "an integer that this machine can count to"))
    }

    /// 1 or 0; 0 if the setting was not made.
    ///
    /// # Errors
    /// If it is another value.
    pub fn flag(&self, name: &str) -> Result<bool, TaskError> {
        match self.natural(name)? {
            None | Some(0) => Ok(false),
            Some(1) => Ok(true),
            Some(_) => Err(wrong(name, "1 or 0")),
        }
    }

    /// Real numbers with their shape. Integers count as real numbers.
    ///
    /// # Errors
    /// If it is a text.
    pub fn reals(&self, name: &str) -> Result<Option<RealArray>, TaskError> {
        match self.0.get(name) {
            None => Ok(None),
            Some(Value::Reals(values, shape)) => {
                Ok(Some(RealArray { values: values.clone(), shape: shape.clone() }))
            }
            #[allow(clippy::cast_precision_loss, reason = "integers in the place of real numbers")]
            Some(Value::Integers(values, shape)) => {
                let values = values.iter().map(|&value| value as f64).collect();
                Ok(Some(RealArray { values, shape: shape.clone() }))
            }
            Some(Value::Text(_)) => Err(wrong(name, "an array of real numbers")),
        }
    }

    /// A text.
    ///
    /// # Errors
    /// If it is another kind of value.
    pub fn text(&self, name: &str) -> Result<Option<&str>, TaskError> {
        match self.0.get(name) {
            None => Ok(None),
            Some(Value::Text(text)) => Ok(Some(text)),
            Some(_) => Err(wrong(name, "a text")),
        }
    }

    /// The lines of a text; none if the setting was not made.
    ///
    /// # Errors
    /// If it is another kind of value.
    pub fn lines(&self, name: &str) -> Result<Vec<&str>, TaskError> {
        Ok(self
            .text(name)?
            .map_or_else(Vec::new, |text| text.lines().filter(|line| !line.is_empty()).collect()))
    }

    /// Refuses settings that a kind of task does not have.
    ///
    /// # Errors
    /// The first one, with the names of those that there are.
    pub fn check(&self, kind: &str, own: &[&str], fields: &[FieldDescription]) -> Result<(), TaskError> {
        for name in self.0.keys() {
            let is_known = match name.strip_prefix(PARAMETER) {
                Some(field) => fields.iter().any(|known| known.name == field),
                None => COMMON.contains(&name.as_str()) || own.contains(&name.as_str()),
            };
            if !is_known {
                let settings: Vec<_> = own.iter().chain(COMMON).copied().collect();
                let parameters = match fields {
                    [] => "no parameters".to_owned(),
                    fields => {
                        let names: Vec<_> = fields.iter().map(|field| field.name).collect();
                        format!("the parameters `{}`", names.join("`, `"))
                    }
                };
                return Err(TaskError::setting(format!(
                    "there is no setting `{name}` of `{kind}`: there are `{}`, and {parameters}",
                    settings.join("`, `")
                )));
            }
        }
        Ok(())
    }
}

impl GivenFields for Settings {
    fn given(&self, name: &str) -> Option<Given<'_>> {
        self.0.get(&format!("{PARAMETER}{name}"))?.given()
    }
}

/// The fields of one system of a sweep: one of each parameter's elements along its first axis.
#[derive(Clone, Copy, Debug)]
pub struct Row<'s> {
    /// Settings in which each parameter has one axis more, in front.
    pub settings: &'s Settings,
    /// The index along this axis.
    pub index: usize,
}

impl GivenFields for Row<'_> {
    fn given(&self, name: &str) -> Option<Given<'_>> {
        self.settings.given(name)?.part(self.index)
    }
}

fn wrong(name: &str, expected: &str) -> TaskError {
    TaskError::setting(format!("`{name}` has to be {expected}"))
}
