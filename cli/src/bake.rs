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
    let original = Original::new(mesh, attributes, looks);
    let mut options = BakeOptions::new(size);
    (options.separate_maps, options.with_tangents) = (!is_gltf, is_gltf);
    let baked = bake(&original, simplified, &options).map_err(|error| format!("--bake {size}: {error}"))?;
    let mut group = Group::default();
    group.material = Some(MATERIAL.into());
    let mut looks = Looks::new(vec![baked.look.clone()]);
    looks.v_is_up = true;
    let mut extra = Extra::default();
    (extra.groups, extra.looks) = (vec![group], vec![(MATERIAL.into(), baked.look)]);
    let seconds = began.elapsed().as_secs_f64();
    Ok(Dress {
        attributes: baked.attributes,
        looks,
        extra,
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
