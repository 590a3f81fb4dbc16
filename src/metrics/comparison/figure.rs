//! One figure of a comparison.

/// A value with its name and unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Figure {
    /// Name in snake case; never changes.
    pub name: &'static str,
    /// What the value counts in, such as "% of diagonal" or "degrees"; empty for plain numbers.
    pub unit: &'static str,
    /// What it is, in a few words.
    pub about: &'static str,
    /// The value; `None` where it cannot be measured or was not asked for.
    pub value: Option<f64>,
}

impl Figure {
    /// A figure; what is not finite is no value.
    pub fn new(name: &'static str, unit: &'static str, about: &'static str, value: Option<f64>) -> Self {
        Self { name, unit, about, value: value.filter(|value| value.is_finite()) }
    }
}

/// A figure; what is not finite is no value.
pub(super) fn figure(name: &'static str, unit: &'static str, about: &'static str, value: Option<f64>) -> Figure {
    Figure::new(name, unit, about, value)
}
