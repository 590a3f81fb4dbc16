//! Textures of one material from texels.

use std::sync::Arc;

use super::BakeOptions;
use super::texel::{Texel, to_byte};
use crate::mesh::{BaseTexture, Finish, Look, Looks, Wrap, linear_light, srgb};
use crate::parallel;
use crate::picture::{Image, encode_png_opaque};

const STRAIGHT: [u8; 3] = [128, 128, 255];
/// Texels that a thread takes at least.
const BLOCK: usize = 1 << 14;

/// Makes the material from size x size texels; uniform values become the original's exact factors instead of textures.
pub(super) fn look(texels: &[Texel], looks: &Looks, options: &BakeOptions) -> Look {
    let map = |of: fn(&Texel) -> [u8; 3]| texture(texels, options.size, of);
    let colour = common_value(texels, |texel| texel.colour);
    let is_straight = common_value(texels, |texel| texel.normal) == Some(STRAIGHT);
    // The two slowest encodings run in parallel.
    let (texture, normal_texture) = parallel::join(
        || colour.is_none().then(|| map(|texel| texel.colour)),
        || (!is_straight).then(|| map(|texel| texel.normal)),
    );
    let emission = common_value(texels, |texel| texel.emission);
    let finish = Finish {
        emission: linear_factor(emission, common_factor(looks, |look| look.finish.emission)),
        emission_texture: emission.is_none().then(|| map(|texel| texel.emission)),
        normal_texture,
        ..roughness_and_metal(texels, looks, options)
    };
    Look {
        colour: linear_factor(colour, common_factor(looks, |look| look.colour)),
        texture,
        uses_corner_colours: false,
        finish,
    }
}

fn roughness_and_metal(texels: &[Texel], looks: &Looks, options: &BakeOptions) -> Finish {
    let map = |of: fn(&Texel) -> [u8; 3]| Some(texture(texels, options.size, of));
    let roughness = common_value(texels, |texel| texel.roughness);
    let metal = common_value(texels, |texel| texel.metal);
    let (roughness_texture, metal_texture) = match (roughness, metal) {
        (Some(_), Some(_)) => (None, None),
        // glTF reads roughness from green and metal from blue of one image.
        _ if !options.separate_maps => {
            let both = map(|texel| [255, texel.roughness, texel.metal]);
            (both.clone(), both)
        }
        _ => (
            roughness.map_or_else(|| map(|texel| [texel.roughness; 3]), |_| None),
            metal.map_or_else(|| map(|texel| [texel.metal; 3]), |_| None),
        ),
    };
    let factor = |bytes: Option<u8>, exact: Option<f32>, texture: &Option<BaseTexture>| match bytes {
        Some(bytes) if texture.is_none() => {
            exact.filter(|&exact| to_byte(exact) == bytes).unwrap_or(f32::from(bytes) / 255.0)
        }
        _ => 1.0,
    };
    Finish {
        roughness: factor(roughness, common_factor(looks, |look| look.finish.roughness), &roughness_texture),
        metal: factor(metal, common_factor(looks, |look| look.finish.metal), &metal_texture),
        roughness_texture,
        metal_texture,
        ..Finish::default()
    }
}

fn common_value<T: PartialEq + Sync + Send + Copy>(texels: &[Texel], of: fn(&Texel) -> T) -> Option<T> {
    let first = of(texels.first()?);
    (!parallel::any(texels.len(), BLOCK, |i| of(&texels[i]) != first)).then_some(first)
}

fn common_factor<T: PartialEq>(looks: &Looks, of: fn(&Look) -> T) -> Option<T> {
    let Some(first) = looks.of_groups.first() else { return Some(of(&Look::default())) };
    looks.of_groups.iter().all(|look| of(look) == of(first)).then(|| of(first))
}

/// Returns a colour in linear light: white if a texture has it, else `exact` if that rounds to `bytes`, else that of
/// `bytes`.
fn linear_factor(bytes: Option<[u8; 3]>, exact: Option<[f32; 3]>) -> [f32; 3] {
    let Some(bytes) = bytes else { return [1.0; 3] };
    let exact = exact.filter(|exact| exact.map(|x| to_byte(srgb(x.clamp(0.0, 1.0)))) == bytes);
    exact.unwrap_or(bytes.map(|byte| linear_light(f32::from(byte) / 255.0)))
}

fn texture(texels: &[Texel], size: usize, of: fn(&Texel) -> [u8; 3]) -> BaseTexture {
    let mut rgba = vec![[0; 4]; texels.len()];
    parallel::fill(&mut rgba, BLOCK, |i| {
        let [r, g, b] = of(&texels[i]);
        [r, g, b, 255]
    });
    let image = Image { width: size, height: size, rgba: rgba.into_flattened() };
    let image: Arc<[u8]> = encode_png_opaque(&image).into();
    BaseTexture { image, channel: String::new(), wrap: [Wrap::Repeat; 2] }
}
