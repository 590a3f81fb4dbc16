//! A distance as people type it: `0.01` in the unit of the mesh, `0.5%` of its diagonal.

use neural_mesh::job::Bound;

use crate::failure::Failure;

/// A distance as typed behind an option: `0.01`, `0.5%`.
pub fn bound(option: &str, text: &str) -> Result<Bound, Failure> {
    let (number, make): (&str, fn(f64) -> Bound) = match text.strip_suffix('%') {
        Some(number) => (number, Bound::Percent),
        None => (text, Bound::Absolute),
    };
    let value = number.trim().parse().ok().filter(|x: &f64| *x >= 0.0 && x.is_finite());
    value.map(make).ok_or_else(|| Failure::Usage(format!("{option} {text}: give a distance, like 0.01, or like 0.5%")))
}
