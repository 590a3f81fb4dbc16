//! `--bake`: textures that store the look of the original.

use crate::bake::{BakeError, BakeOptions, BakeSource, SIZES, bake};
use crate::io::{Extra, Group};
use crate::mesh::{Attributes, Looks, TriMesh};

use super::baked_material::{BakeFigures, BakedMaterial};
use super::error::JobError;

const MATERIAL: &str = "baked";

pub fn check_size(size: usize) -> Result<(), JobError> {
    if SIZES.contains(&size) { Ok(()) } else { Err(JobError::Options(format!("--bake: {}", BakeError::BadSize(size)))) }
}

/// Bakes textures of `size` x `size` texels.
pub fn bake_material(
    size: usize,
    is_gltf: bool,
    (mesh, attributes, looks): (&TriMesh, &Attributes, &Looks),
    simplified: &TriMesh,
) -> Result<BakedMaterial, String> {
    let original = BakeSource::new(mesh, attributes, looks);
    let mut options = BakeOptions::new(size);
    (options.separate_maps, options.with_tangents) = (!is_gltf, is_gltf);
    let baked = bake(&original, simplified, &options).map_err(|error| format!("--bake {size}: {error}"))?;
    let mut group = Group::default();
    group.material = Some(MATERIAL.into());
    let mut looks = Looks::new(vec![baked.look.clone()]);
    looks.v_is_up = true;
    let mut extra = Extra::default();
    (extra.groups, extra.looks) = (vec![group], vec![(MATERIAL.into(), baked.look)]);
    Ok(BakedMaterial {
        attributes: baked.attributes,
        looks,
        extra,
        figures: BakeFigures { size, charts: baked.n_charts, covered: baked.covered, seconds: 0.0 },
        notes: baked.notes,
    })
}
