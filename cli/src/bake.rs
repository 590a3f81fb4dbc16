//! `--bake`: what the original looks like as textures of the result.

use std::time::Instant;

use neural_mesh::bake::{BakeError, BakeOptions, Original, SIZES, bake};
use neural_mesh::io::{Extra, Group};
use neural_mesh::mesh::{Attributes, Looks, TriMesh};

use crate::dress::{Baked, Dress};
use crate::failure::Failure;

/// What the material is called.
const MATERIAL: &str = "baked";

/// Refuses sizes of which there are no textures.
pub fn check(size: usize) -> Result<(), Failure> {
    if SIZES.contains(&size) { Ok(()) } else { Err(Failure::Usage(format!("--bake: {}", BakeError::BadSize(size)))) }
}

/// What a simplified mesh wears of its original: textures of `size` x `size` texels, as glTF has them or as a library of an OBJ.
pub fn dress(
    size: usize,
    is_gltf: bool,
    (mesh, attributes, looks): (&TriMesh, &Attributes, &Looks),
    simplified: &TriMesh,
) -> Result<Dress, String> {
    let began = Instant::now();
    let original = Original { mesh, attributes, looks };
    let options = BakeOptions { size, separate_maps: !is_gltf, with_tangents: is_gltf };
    let baked = bake(&original, simplified, &options).map_err(|error| format!("--bake {size}: {error}"))?;
    let group = Group { material: Some(MATERIAL.into()), ..Group::default() };
    let seconds = began.elapsed().as_secs_f64();
    Ok(Dress {
        attributes: baked.attributes,
        looks: Looks { of_groups: vec![baked.look.clone()], v_is_up: true, linear_colours: false },
        extra: Extra { groups: vec![group], looks: vec![(MATERIAL.into(), baked.look)], ..Extra::default() },
        figures: Baked { size, charts: baked.n_charts, covered: baked.covered, seconds },
        notes: baked.notes,
    })
}

#[cfg(test)]
mod tests {
    use super::SIZES;
    use crate::numbers::TEXELS;

    #[test]
    fn what_is_typed_is_what_is_baked() {
        assert_eq!((*SIZES.start() as u64, *SIZES.end() as u64), TEXELS);
    }
}
