//! A baked material that replaces the original's materials.

use crate::io::Extra;
use crate::mesh::{Attributes, Looks};

use serde::Serialize;

/// A baked material and the attributes that use it.
pub struct BakedMaterial {
    /// Attributes of the result, with texture coordinates.
    pub attributes: Attributes,
    /// Material for the writers.
    pub extra: Extra,
    /// Material for the renderer.
    pub looks: Looks,
    /// Figures for the report.
    pub figures: BakeFigures,
    /// Problems of the bake, one line each.
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
