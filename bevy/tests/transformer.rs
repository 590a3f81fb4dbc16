//! The transformer of meshes with settings as in a `.meta` file.

use bevy_asset::transformer::{AssetTransformer, TransformedAsset};
use bevy_asset::{ErasedLoadedAsset, LoadedAsset};
use bevy_mesh::Mesh;
use bevy_tasks::block_on;
use neural_mesh_bevy::{MeshError, MeshSimplifier, SimplifySettings};

use crate::helpers::{corners, is_closed, long, n_points, positions, torus};

fn transform(mesh: Mesh, settings: &str) -> Result<Mesh, MeshError> {
    let settings: SimplifySettings = ron::from_str(settings).unwrap();
    let loaded: ErasedLoadedAsset = LoadedAsset::from(mesh).into();
    let asset = TransformedAsset::<Mesh>::from_loaded(loaded).unwrap();
    Ok(block_on(MeshSimplifier.transform(asset, &settings))?.get().clone())
}

#[test]
fn every_kind_of_size_is_understood() {
    let transform = |settings| transform(torus(long), settings).unwrap();
    assert_eq!(n_points(&transform("(size: Ratio(0.25))")), 512);
    assert_eq!(n_points(&transform("(size: Vertices(300), options: (effort: best, optimize: looks))")), 300);
    assert_eq!(corners(&transform("(size: Faces(400), options: (effort: fast, purpose: poses))")).len(), 1200);
    let within = transform("(error: Some(0.02), options: (subset: true))");
    assert!(n_points(&within) < 1500 && is_closed(&within));
    let given: Vec<[f32; 3]> = positions(&torus(long)).to_vec();
    assert!(positions(&within).iter().all(|position| given.contains(position)));
    assert_eq!(n_points(&transform("()")), 2048);
}

#[test]
fn settings_that_do_not_exist_and_sizes_that_are_none_are_refused() {
    assert!(ron::from_str::<SimplifySettings>("(sise: Ratio(0.25))").is_err());
    assert!(matches!(transform(torus(long), "(size: Ratio(2.0))"), Err(MeshError::Simplify(_))));
}
