//! Texels: their content and place.

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum TexelPlace {
    // Neither in a chart nor next to one.
    #[default]
    Outside,
    // Centre in a chart.
    Inside,
    // Centre next to a chart.
    Border,
    // Filled from the nearest texel.
    Dilated,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Texel {
    // Base colour, sRGB.
    pub colour: [u8; 3],
    // Emission, sRGB.
    pub emission: [u8; 3],
    // Roughness, 0 to 255 for 0 to 1.
    pub roughness: u8,
    // Metalness, 0 to 255 for 0 to 1.
    pub metal: u8,
    // Direction in tangent space, 0 to 255 for -1 to 1.
    pub normal: [u8; 3],
    pub place: TexelPlace,
}

pub(super) fn to_byte(x: f32) -> u8 {
    (255.0 * x.clamp(0.0, 1.0)).round() as u8
}
