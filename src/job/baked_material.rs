//! A baked material that replaces the original's materials.

use crate::io::Extra;
use crate::mesh::{Attributes, Looks};

use serde::Serialize;

/// A baked material and the attributes that use it.
pub struct BakedMaterial {
    /// Attributes of the corners.
    pub attributes: Attributes,
    /// Material by name.
    pub extra: Extra,
    /// Material for pictures.
    pub looks: Looks,
    /// Figures for the report.
    pub figures: BakeFigures,
    /// Failures, one line each.
    pub notes: Vec<String>,
}

/// Figures of a bake.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BakeFigures {
    /// Texels per side of each texture.
    pub size: usize,
    /// Number of charts.
    pub charts: usize,
    /// Share of the texels inside charts.
    pub covered: f64,
    /// Seconds of the bake; set by the caller.
    pub seconds: f64,
}
