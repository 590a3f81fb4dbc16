//! Settings of processors, as `.meta` files have them.

use neural_mesh::simplify::ClosedOptions;
use serde::{Deserialize, Serialize};

/// Settings of a simplification; a `.meta` file names those that differ from the default.
///
/// The default leaves meshes as they are, so that a default processor changes nothing unasked.
///
/// ```
/// use neural_mesh_bevy::{SimplifySettings, SizeSetting};
/// let settings: SimplifySettings = ron::from_str("(size: Ratio(0.25), options: (effort: best, subset: true))")?;
/// assert_eq!((settings.size, settings.options.subset), (SizeSetting::Ratio(0.25), true));
/// # Ok::<(), ron::error::SpannedError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SimplifySettings {
    /// Size of the result.
    pub size: SizeSetting,
    /// Options of the simplifier; its choices are written small, as `effort: fast`.
    pub options: ClosedOptions,
}

/// Size of a processed mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum SizeSetting {
    /// Share of the positions, above 0 and at most 1.
    Ratio(f64),
    /// Number of positions.
    Vertices(usize),
    /// Number of triangles.
    Faces(usize),
    /// Largest distance to the original, in the unit of the mesh.
    Error(f64),
}

impl Default for SizeSetting {
    fn default() -> Self {
        Self::Ratio(1.0)
    }
}
