//! The value of an option as a face has it: a flag, a number, a text.

use serde::Deserialize;

/// A value of an option; numbers and texts mean what they mean on the command line.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Given without a value, or not given.
    Flag(bool),
    /// A number: `0.1`, `5000`.
    Number(f64),
    /// A text: `"10%"`, `"2MB"`.
    Text(String),
}

impl Value {
    /// As it is typed; `None` for a flag.
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Flag(_) => None,
            Self::Number(number) => Some(number.to_string()),
            Self::Text(text) => Some(text.clone()),
        }
    }

    /// Whether the option is given.
    pub fn is_given(&self) -> bool {
        *self != Self::Flag(false)
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}
