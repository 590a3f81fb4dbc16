//! Units of length by their 3MF names.

const UNITS: [(f64, &str); 6] =
    [(1e-6, "micron"), (0.001, "millimeter"), (0.01, "centimeter"), (0.0254, "inch"), (0.3048, "foot"), (1.0, "meter")];

#[cfg(feature = "3mf")]
pub(super) fn is_known(unit: &str) -> bool {
    UNITS.iter().any(|(_, name)| *name == unit)
}

#[cfg(feature = "fbx")]
pub(super) fn from_meters(meters: f64) -> Option<String> {
    UNITS.iter().find(|(unit, _)| (meters / unit - 1.0).abs() < 1e-6).map(|(_, name)| name.to_string())
}
