//! Value of an option: a flag, a number, a text.

use serde::Deserialize;

/// Value of an option, parsed like on the command line.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum OptionValue {
    /// `true` for an option without a value, `false` for an option not given.
    Flag(bool),
    /// Number: `0.1`, `5000`.
    Number(f64),
    /// Text: `"10%"`, `"2MB"`.
    Text(String),
}

impl OptionValue {
    /// Returns the value as text; `None` for a flag.
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Flag(_) => None,
            Self::Number(number) => Some(number.to_string()),
            Self::Text(text) => Some(text.clone()),
        }
    }

    /// Returns whether the option is given.
    pub fn is_given(&self) -> bool {
        *self != Self::Flag(false)
    }
}

impl From<f64> for OptionValue {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<&str> for OptionValue {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}
