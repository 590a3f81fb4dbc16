//! What a simplified mesh wears that was baked for it, in place of what it has of the original.

use neural_mesh::io::Extra;
use neural_mesh::mesh::{Attributes, Looks};

use crate::report::Baked;

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
