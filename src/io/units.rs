//! What lengths mean: in metres, and the words of 3MF, which [`Extra::unit`](super::Extra::unit) takes.

const UNITS: [(f64, &str); 6] =
    [(1e-6, "micron"), (0.001, "millimeter"), (0.01, "centimeter"), (0.0254, "inch"), (0.3048, "foot"), (1.0, "meter")];

/// Whether it is a word for a unit.
#[cfg(feature = "3mf")]
pub(super) fn is_known(unit: &str) -> bool {
    UNITS.iter().any(|(_, name)| *name == unit)
}

/// The word for a length of so many metres, where there is one.
#[cfg(feature = "fbx")]
pub(super) fn of_meters(meters: f64) -> Option<String> {
    UNITS.iter().find(|(unit, _)| (meters / unit - 1.0).abs() < 1e-6).map(|(_, name)| name.to_string())
}
