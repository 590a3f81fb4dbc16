//! How a surface looks beside its shape: base colours, what it does with light, and the textures that give them, as files
//! state them.

use std::sync::Arc;

/// What a texture does beyond its edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// It begins again.
    #[default]
    Repeat,
    /// The colours of its edge go on.
    Clamp,
    /// It begins again, every other time mirrored.
    Mirror,
}

/// A picture on a surface, which gives a base colour or another property.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct BaseTexture {
    /// The bytes of a PNG, JPEG, WebP or KTX2 file; materials that share it share them.
    pub image: Arc<[u8]>,
    /// Name of the channel with its coordinates; where it is empty, the first of texture coordinates.
    pub channel: String,
    /// What it does beyond its edges, along u and along v.
    pub wrap: [Wrap; 2],
}

impl BaseTexture {
    /// The bytes of a PNG, JPEG, WebP or KTX2 file, repeated; its coordinates are the first of texture coordinates.
    pub fn new(image: Arc<[u8]>) -> Self {
        Self { image, channel: String::new(), wrap: [Wrap::Repeat; 2] }
    }
}

/// What a material looks like where light is even.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Look {
    /// Base colour in linear light, red, green, blue, each 0 to 1; a texture is multiplied by it.
    pub colour: [f32; 3],
    /// The texture, where there is one.
    pub texture: Option<BaseTexture>,
    /// Whether colours at the corners, where the mesh has them, are multiplied with it too.
    pub with_corners: bool,
    /// What it does with light beside.
    pub finish: Finish,
}

/// What a material does with light, beside its base colour.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Finish {
    /// Light of its own, linear, red, green, blue, each 0 to 1; the texture is multiplied by it.
    pub emission: [f32; 3],
    /// The texture of that light, sRGB.
    pub emission_texture: Option<BaseTexture>,
    /// 0 to 1; the green of the texture is multiplied by it.
    pub roughness: f32,
    /// The texture of the roughness.
    pub roughness_texture: Option<BaseTexture>,
    /// 0 for what is no metal, 1 for metal; the blue of the texture is multiplied by it.
    pub metal: f32,
    /// The texture that tells metal; of glTF the one of the roughness.
    pub metal_texture: Option<BaseTexture>,
    /// Directions in tangent space, MikkTSpace, green upwards.
    pub normal_texture: Option<BaseTexture>,
    /// What the first two numbers of these are multiplied by.
    pub normal_scale: f32,
    /// Whether nothing of it is seen through.
    pub is_opaque: bool,
}

impl Default for Look {
    fn default() -> Self {
        Self { colour: [1.0; 3], texture: None, with_corners: true, finish: Finish::default() }
    }
}

impl Default for Finish {
    fn default() -> Self {
        Self {
            emission: [0.0; 3],
            emission_texture: None,
            roughness: 1.0,
            roughness_texture: None,
            metal: 0.0,
            metal_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            is_opaque: true,
        }
    }
}

/// What the groups of a mesh look like.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Looks {
    /// The look of each group, by its number ([`Attributes::group`](super::Attributes::group)); white beyond.
    pub of_groups: Vec<Look>,
    /// Whether v runs upwards from the lower edge of a texture, as in OBJ; downwards from the upper one, as in glTF.
    pub v_is_up: bool,
    /// Whether colours at the corners are in linear light, as in glTF; sRGB as in PLY and OBJ.
    pub linear_colours: bool,
}

impl Looks {
    /// The look of each group, by its number.
    pub fn new(of_groups: Vec<Look>) -> Self {
        Self { of_groups, ..Self::default() }
    }

    /// Whether every group is white, without a texture.
    pub fn is_plain(&self) -> bool {
        self.of_groups.iter().all(|look| look.texture.is_none() && look.colour == [1.0; 3])
    }
}

/// A channel of a colour in linear light as sRGB, both 0 to 1; the inverse of [`linear_light`].
///
/// ```
/// use neural_mesh::mesh::{linear_light, srgb};
/// assert!((srgb(linear_light(0.3)) - 0.3).abs() < 1e-6);
/// ```
pub fn srgb(light: f32) -> f32 {
    if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

/// A channel of a colour in sRGB as linear light, both 0 to 1.
///
/// ```
/// use neural_mesh::mesh::linear_light;
/// assert_eq!((linear_light(0.0), linear_light(1.0)), (0.0, 1.0));
/// assert!((linear_light(0.5) - 0.214).abs() < 1e-3);
/// ```
pub fn linear_light(srgb: f32) -> f32 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}
