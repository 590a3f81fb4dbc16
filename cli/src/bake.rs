//! `--bake`: what the original looks like as textures of the result.

use std::time::Instant;

use neural_mesh::bake::{BakeError, BakeOptions, Original, SIZES, bake};
use neural_mesh::io::{Extra, Format, Group};
use neural_mesh::mesh::Looks;
use neural_mesh::simplify::Simplified;

use crate::dress::Dress;
use crate::failure::Failure;
use crate::report::Baked;
use crate::request::Request;
use crate::subject::Subject;

/// What the material is called.
const MATERIAL: &str = "baked";

/// Refuses sizes of which there are no textures.
pub fn check(size: usize) -> Result<(), Failure> {
    if SIZES.contains(&size) { Ok(()) } else { Err(Failure::Usage(format!("--bake: {}", BakeError::BadSize(size)))) }
}

/// What a result wears, where that is asked for.
pub fn dress(request: &Request, subject: &Subject, result: &Simplified) -> Result<Option<Dress>, Failure> {
    let Some(size) = request.bake else { return Ok(None) };
    let began = Instant::now();
    let is_gltf = matches!(request.output_format, Format::Gltf | Format::Glb);
    let (looks, mut notes) = subject.looks(request.allow_outside);
    let original = Original { mesh: subject.mesh(), attributes: subject.attributes(), looks: &looks };
    let options = BakeOptions { size, separate_maps: !is_gltf, with_tangents: is_gltf };
    let baked = bake(&original, &result.mesh, &options)
        .map_err(|error| Failure::of(&request.source.path, format!("--bake {size}: {error}")))?;
    notes.extend(baked.notes);
    let group = Group { material: Some(MATERIAL.into()), ..Group::default() };
    let figures =
        Baked { size, charts: baked.n_charts, covered: baked.covered, seconds: began.elapsed().as_secs_f64() };
    Ok(Some(Dress {
        attributes: baked.attributes,
        looks: Looks { of_groups: vec![baked.look.clone()], v_is_up: true, linear_colours: false },
        extra: Extra { groups: vec![group], looks: vec![(MATERIAL.into(), baked.look)], ..Extra::default() },
        figures,
        notes,
    }))
}
