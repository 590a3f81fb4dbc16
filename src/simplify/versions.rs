//! Versions of what the assemblies make: figures that were measured with another version are of other results.

/// Version of the closed assembly: another number where the same input, options and seed give other bits.
///
/// ```
/// assert!(neural_mesh::simplify::CLOSED_VERSION >= 1);
/// ```
pub const CLOSED_VERSION: u32 = 1;

/// Version of the paper's assembly, likewise.
///
/// ```
/// assert!(neural_mesh::simplify::PAPER_VERSION >= 1);
/// ```
pub const PAPER_VERSION: u32 = 1;
