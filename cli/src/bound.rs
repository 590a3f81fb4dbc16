//! A distance as people type it: `0.01` in the unit of the mesh, `0.5%` of its diagonal.

use std::fmt;

use crate::failure::Failure;

/// A distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// In the unit of the mesh.
    Absolute(f64),
    /// In percent of the diagonal of the mesh's bounding box.
    Percent(f64),
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absolute(distance) => write!(f, "{distance}"),
            Self::Percent(percent) => write!(f, "{percent}%"),
        }
    }
}

impl Bound {
    /// In the unit of a mesh with this diagonal.
    pub fn over(self, diagonal: f64) -> f64 {
        match self {
            Self::Absolute(distance) => distance,
            Self::Percent(percent) => 0.01 * percent * diagonal,
        }
    }
}

/// A distance as typed behind an option: `0.01`, `0.5%`.
pub fn bound(option: &str, text: &str) -> Result<Bound, Failure> {
    let (number, make): (&str, fn(f64) -> Bound) = match text.strip_suffix('%') {
        Some(number) => (number, Bound::Percent),
        None => (text, Bound::Absolute),
    };
    let value = number.trim().parse().ok().filter(|x: &f64| *x >= 0.0 && x.is_finite());
    value.map(make).ok_or_else(|| Failure::Usage(format!("{option} {text}: give a distance, like 0.01, or like 0.5%")))
}
