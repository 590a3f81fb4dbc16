//! Settings of processors, as `.meta` files have them.

use neural_mesh::simplify::{ClosedOptions, Effort, Optimize, Purpose};
use serde::{Deserialize, Serialize};

/// Settings of a simplification; a `.meta` file names those that differ from the default.
///
/// The default leaves meshes as they are, so that a default processor changes nothing unasked.
///
/// ```
/// use neural_mesh_bevy::{SimplifySettings, SizeSetting};
/// let settings: SimplifySettings = ron::from_str("(size: Ratio(0.25), subset: true)")?;
/// assert_eq!((settings.size, settings.subset), (SizeSetting::Ratio(0.25), true));
/// # Ok::<(), ron::error::SpannedError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SimplifySettings {
    /// Size of the result.
    pub size: SizeSetting,
    /// Trade-off between time and accuracy.
    pub effort: EffortSetting,
    /// Error measure to optimise.
    pub optimize: OptimizeSetting,
    /// True if small components may be dropped where their vertices are better spent elsewhere.
    pub prune: bool,
    /// True if boundaries stay bit for bit.
    pub lock_boundaries: bool,
    /// True if vertices stay at positions of the original.
    pub subset: bool,
    /// True if the mesh will bend, by a skin or morph targets.
    pub bends: bool,
    /// Least angle between face normals, in degrees, of edges that are kept as creases.
    pub crease_angle: Option<f32>,
}

impl Default for SimplifySettings {
    fn default() -> Self {
        Self {
            size: SizeSetting::default(),
            effort: EffortSetting::default(),
            optimize: OptimizeSetting::default(),
            prune: true,
            lock_boundaries: false,
            subset: false,
            bends: false,
            crease_angle: None,
        }
    }
}

impl SimplifySettings {
    /// Returns the options of the simplifier.
    ///
    /// ```
    /// use neural_mesh_bevy::{ClosedOptions, SimplifySettings};
    /// assert_eq!(SimplifySettings::default().to_options(), ClosedOptions::default());
    /// ```
    pub fn to_options(&self) -> ClosedOptions {
        ClosedOptions {
            effort: self.effort.into(),
            optimize: self.optimize.into(),
            prune: self.prune,
            lock_boundaries: self.lock_boundaries,
            subset: self.subset,
            purpose: if self.bends { Purpose::Poses } else { Purpose::Shape },
            crease_angle: self.crease_angle,
            ..ClosedOptions::default()
        }
    }
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

/// Trade-off between time and accuracy, as [`Effort`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum EffortSetting {
    /// Collapse without flips and fit.
    Fast,
    /// Default trade-off.
    #[default]
    Standard,
    /// More sample points, and more steps of the fit.
    Best,
}

impl From<EffortSetting> for Effort {
    fn from(effort: EffortSetting) -> Self {
        match effort {
            EffortSetting::Fast => Self::Fast,
            EffortSetting::Standard => Self::Standard,
            EffortSetting::Best => Self::Best,
        }
    }
}

/// Error measure to optimise, as [`Optimize`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum OptimizeSetting {
    /// All measures.
    #[default]
    Balanced,
    /// Mean distance; takes longer.
    Mean,
    /// Largest distance.
    Max,
    /// Normals, and so shading.
    Normals,
    /// Appearance: surfaces count by how much of them is visible.
    Looks,
}

impl From<OptimizeSetting> for Optimize {
    fn from(optimize: OptimizeSetting) -> Self {
        match optimize {
            OptimizeSetting::Balanced => Self::Balanced,
            OptimizeSetting::Mean => Self::Mean,
            OptimizeSetting::Max => Self::Max,
            OptimizeSetting::Normals => Self::Normals,
            OptimizeSetting::Looks => Self::Looks,
        }
    }
}
