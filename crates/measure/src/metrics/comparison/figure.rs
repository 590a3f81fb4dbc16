//! A named figure of a comparison.

/// A value with its name and unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Name in snake case.
    pub name: &'static str,
    /// Unit such as "% of diagonal"; empty for plain numbers.
    pub unit: &'static str,
    /// Meaning in a few words.
    pub about: &'static str,
    /// Value; `None` if unknown.
    pub value: Option<f64>,
}

impl Figure {
    /// Creates a figure; a value that is not finite becomes `None`.
    pub fn new(name: &'static str, unit: &'static str, about: &'static str, value: Option<f64>) -> Self {
        Self { name, unit, about, value: value.filter(|value| value.is_finite()) }
    }
}
