//! Wedges, and attributes with their prices: arrays that follow the passes.

use crate::collapse::attributes::WedgeAttributes;
use crate::collapse::rings::Rings;
use crate::collapse::wedges::Wedges;

/// Wedges of the input's faces, and the attributes of the wedges.
pub(crate) struct SideArrays {
    pub wedges: Wedges,
    pub attributes: Option<WedgeAttributes>,
}

impl SideArrays {
    /// Marks the lines of a pass, and writes what attributes lose into `losses`, one number per entry of the rings; leaves it empty without attributes.
    pub(crate) fn prepare_pass(&mut self, rings: &mut Rings, losses: &mut Vec<f32>) {
        self.wedges.mark_lines(rings);
        if let Some(attributes) = &mut self.attributes {
            attributes.write_losses(rings, &self.wedges.faces, losses);
        }
    }

    /// Follows the merges of a pass, from `rings` to `next`.
    pub(crate) fn follow(&mut self, rings: &Rings, next: &Rings, numbers: &[u32]) {
        let pairs = self.wedges.find_pairs(rings, numbers);
        if let Some(attributes) = &mut self.attributes {
            attributes.follow(&pairs, next, numbers);
        }
        self.wedges.follow(&pairs, numbers);
    }
}
