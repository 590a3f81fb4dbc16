//! Transformer of mesh assets.

use bevy_asset::transformer::{AssetTransformer, TransformedAsset};
use bevy_mesh::Mesh;
use bevy_reflect::TypePath;

use super::settings::SimplifySettings;
use crate::{MeshError, SimplifiedMesh, simplify_mesh, simplify_mesh_to_error};

/// Transformer that simplifies meshes between a loader and a saver of meshes.
///
/// Bevy has no file format for a single [`Mesh`]; use it as
/// `LoadTransformAndSave<YourMeshLoader, MeshSimplifier, YourMeshSaver>`. For glTF files there is `GltfSimplifier`.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct MeshSimplifier;

impl AssetTransformer for MeshSimplifier {
    type AssetInput = Mesh;
    type AssetOutput = Mesh;
    type Settings = SimplifySettings;
    type Error = MeshError;

    async fn transform<'a>(
        &'a self,
        mut asset: TransformedAsset<Mesh>,
        settings: &'a SimplifySettings,
    ) -> Result<TransformedAsset<Mesh>, MeshError> {
        let simplified = simplify_by_settings(&asset, settings)?;
        *asset = simplified.mesh;
        Ok(asset)
    }
}

fn simplify_by_settings(mesh: &Mesh, settings: &SimplifySettings) -> Result<SimplifiedMesh, MeshError> {
    let options = &settings.options;
    match settings.error {
        Some(error) => simplify_mesh_to_error(mesh, error, options),
        None => simplify_mesh(mesh, settings.size, options),
    }
}
