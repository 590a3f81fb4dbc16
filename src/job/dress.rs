//! A baked material that replaces the original's appearance.

use crate::io::Extra;
use crate::mesh::{Attributes, Looks};

use serde::Serialize;

/// Everything about a baked mesh except its surface.
pub struct Dress {
    /// Attributes of the corners.
    pub attributes: Attributes,
    /// Material by name.
    pub extra: Extra,
    /// Appearance for pictures.
    pub looks: Looks,
    /// Figures of the bake.
    pub figures: Baked,
    /// Remarks about failures, one line each.
    pub notes: Vec<String>,
}

/// The figures of a bake.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Baked {
    /// Texels per side of each texture.
    pub size: usize,
    /// Number of charts.
    pub charts: usize,
    /// Share of the texels inside charts.
    pub covered: f64,
    /// Seconds from simplified mesh to PNG bytes; filled in by the caller.
    pub seconds: f64,
}
