//! What a simplified mesh wears that was baked for it, in place of what it has of the original.

use crate::io::Extra;
use crate::mesh::{Attributes, Looks};

use serde::Serialize;

/// All that is written of a baked mesh beside its surface.
pub struct Dress {
    /// What its corners carry.
    pub attributes: Attributes,
    /// Its material, by name.
    pub extra: Extra,
    /// The same as pictures show it.
    pub looks: Looks,
    /// What was done.
    pub figures: Baked,
    /// What could not be baked, in one line each.
    pub notes: Vec<String>,
}

/// What was baked for a result.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Baked {
    /// Texels a side of each texture.
    pub size: usize,
    /// Pieces that the surface was cut into.
    pub charts: usize,
    /// Share of the texels that lie in a chart.
    pub covered: f64,
    /// From the simplified mesh to its textures, as bytes of PNG files; whoever has a clock fills it in.
    pub seconds: f64,
}
