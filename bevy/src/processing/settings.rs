//! Settings of processors, as `.meta` files have them.

use neural_mesh::simplify::{ClosedOptions, Size};
use serde::{Deserialize, Serialize};

/// Settings of a simplification; a `.meta` file names those that differ from the default.
///
/// The default leaves meshes as they are, so that a default processor changes nothing unasked.
///
/// ```
/// use neural_mesh_bevy::{SimplifySettings, Size};
/// let settings: SimplifySettings = ron::from_str("(size: Ratio(0.25), options: (effort: best, subset: true))")?;
/// assert_eq!((settings.size, settings.options.subset), (Size::Ratio(0.25), true));
/// # Ok::<(), ron::error::SpannedError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SimplifySettings {
    /// Size of the result; without effect if there is an error.
    pub size: Size,
    /// Largest distance to the original, in the unit of the mesh, in place of a size.
    pub error: Option<f64>,
    /// Options of the simplifier; its choices are written small, as `effort: fast`.
    pub options: ClosedOptions,
}

impl Default for SimplifySettings {
    fn default() -> Self {
        Self { size: Size::Ratio(1.0), error: None, options: ClosedOptions::default() }
    }
}
