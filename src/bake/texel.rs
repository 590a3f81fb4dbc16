//! What is known of a texel.

use rayon::prelude::*;

/// Where a texel lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Place {
    /// In no chart, and not beside one.
    #[default]
    Outside,
    /// Its middle lies in a chart.
    Inside,
    /// Its middle lies beside a chart.
    Border,
    /// It has been given what the nearest one has.
    Dilated,
}

/// What the original looks like at a texel, as bytes of textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Texel {
    /// Base colour, sRGB.
    pub colour: [u8; 3],
    /// Light of its own, sRGB.
    pub emission: [u8; 3],
    /// 0 to 255 for 0 to 1.
    pub roughness: u8,
    /// 0 to 255 for 0 to 1.
    pub metal: u8,
    /// The direction in tangent space, 0 to 255 for -1 to 1.
    pub normal: [u8; 3],
    /// Where it lies.
    pub place: Place,
}

/// The share of texels whose middle lies in a chart.
pub(super) fn share_inside(texels: &[Texel]) -> f64 {
    let n_inside = texels.par_iter().filter(|texel| texel.place == Place::Inside).count();
    n_inside as f64 / texels.len().max(1) as f64
}

/// A number from 0 to 1 as a byte.
pub(super) fn byte(x: f32) -> u8 {
    (255.0 * x.clamp(0.0, 1.0)).round() as u8
}
