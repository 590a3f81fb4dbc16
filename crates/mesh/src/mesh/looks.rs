//! Appearance of materials.

use std::sync::Arc;

/// The behaviour of a texture outside 0..1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The texture repeats.
    #[default]
    Repeat,
    /// The border colours continue.
    Clamp,
    /// The texture repeats, every other time mirrored.
    Mirror,
}

impl Wrap {
    /// Returns the name in pages.
    #[doc(hidden)]
    pub fn name(self) -> &'static str {
        match self {
            Self::Repeat => "repeat",
            Self::Clamp => "clamp",
            Self::Mirror => "mirror",
        }
    }
}

/// A texture with its coordinates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BaseTexture {
    /// Bytes of a PNG, JPEG, WebP or KTX2 file.
    pub image: Arc<[u8]>,
    /// Name of the channel of coordinates; empty means the first.
    pub channel: String,
    /// Behaviour along u and v.
    pub wrap: [Wrap; 2],
}

impl BaseTexture {
    /// Makes a repeating texture on the first texture coordinates.
    pub fn new(image: Arc<[u8]>) -> Self {
        Self { image, channel: String::new(), wrap: [Wrap::Repeat; 2] }
    }
}

/// The appearance of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Base colour in linear RGB, 0..=1; multiplies the texture.
    pub colour: [f32; 3],
    /// Base colour texture.
    pub texture: Option<BaseTexture>,
    /// True if vertex colours multiply the base colour.
    pub uses_corner_colours: bool,
    /// Other surface properties.
    pub finish: Finish,
}

/// Surface properties of a material other than its base colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Finish {
    /// Emitted light in linear RGB, 0..=1; multiplies the texture.
    pub emission: [f32; 3],
    /// Texture of the emitted light, sRGB.
    pub emission_texture: Option<BaseTexture>,
    /// Roughness in 0..=1; multiplies the texture's green channel.
    pub roughness: f32,
    /// Texture of the roughness.
    pub roughness_texture: Option<BaseTexture>,
    /// Metalness in 0..=1; multiplies the texture's blue channel.
    pub metal: f32,
    /// Texture of the metalness.
    pub metal_texture: Option<BaseTexture>,
    /// Tangent-space normal map (MikkTSpace, green upwards).
    pub normal_texture: Option<BaseTexture>,
    /// Factor of the normal map's first two components.
    pub normal_scale: f32,
    /// Texture of the occlusion of ambient light, in its red channel.
    pub occlusion_texture: Option<BaseTexture>,
    /// Strength of the occlusion in 0..=1.
    pub occlusion: f32,
    /// True if the material is opaque.
    pub is_opaque: bool,
}

impl Look {
    /// Returns the texture whose coordinates and wrap modes a viewer uses: that of the colour, else the first map.
    pub fn main_texture(&self) -> Option<&BaseTexture> {
        self.texture.as_ref().or_else(|| self.finish.maps().into_iter().find_map(|(_, map)| map))
    }

    /// Lists the maps on the main texture's coordinates, each with its name.
    pub fn drawn_maps(&self) -> impl Iterator<Item = (&'static str, &BaseTexture)> {
        let channel = self.main_texture().map(|texture| &texture.channel);
        let maps = self.finish.maps().into_iter().filter_map(|(name, map)| Some((name, map?)));
        maps.filter(move |(_, map)| Some(&map.channel) == channel)
    }
}

impl Finish {
    /// Returns whether a surface is rough and not metal, emits no light and has no map: only a colour.
    pub fn is_matte(&self) -> bool {
        self.maps().iter().all(|(_, map)| map.is_none())
            && self.emission == [0.0; 3]
            && (self.roughness, self.metal) == (1.0, 0.0)
    }

    fn maps(&self) -> [(&'static str, Option<&BaseTexture>); 5] {
        [
            ("normal", self.normal_texture.as_ref()),
            ("emission", self.emission_texture.as_ref()),
            ("roughness", self.roughness_texture.as_ref()),
            ("metal", self.metal_texture.as_ref()),
            ("occlusion", self.occlusion_texture.as_ref()),
        ]
    }
}

impl Default for Look {
    fn default() -> Self {
        Self { colour: [1.0; 3], texture: None, uses_corner_colours: true, finish: Finish::default() }
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
            occlusion_texture: None,
            occlusion: 1.0,
            is_opaque: true,
        }
    }
}

/// The appearance of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Looks {
    /// Appearance by group index; white beyond the last.
    pub of_groups: Vec<Look>,
    /// True if v points up, as in OBJ, not down, as in glTF.
    pub v_is_up: bool,
    /// True if vertex colours are linear, as in glTF, not sRGB, as in PLY and OBJ.
    pub linear_colours: bool,
}

impl Looks {
    /// Makes looks from one entry per group.
    pub fn new(of_groups: Vec<Look>) -> Self {
        Self { of_groups, ..Self::default() }
    }

    /// Returns whether every group is white and without a texture of its colour.
    pub fn is_plain(&self) -> bool {
        self.of_groups.iter().all(|look| look.texture.is_none() && look.colour == [1.0; 3])
    }
}

/// Converts a linear colour component to sRGB, both in 0..=1.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{linear_light, srgb};
/// assert!((srgb(linear_light(0.3)) - 0.3).abs() < 1e-6);
/// ```
pub fn srgb(light: f32) -> f32 {
    if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

/// Converts an sRGB colour component to linear light, both in 0..=1.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::linear_light;
/// assert_eq!((linear_light(0.0), linear_light(1.0)), (0.0, 1.0));
/// assert!((linear_light(0.5) - 0.214).abs() < 1e-3);
/// ```
pub fn linear_light(srgb: f32) -> f32 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}
