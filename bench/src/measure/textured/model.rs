//! A textured model from a file.

use std::path::Path;

use anyhow::{Context, Result};
use neural_mesh::io::{Asset, Format, read_attributed_path, read_looks};
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::mesh::{Attributes, Look, Looks, ScenePiece, TriMesh, UnitedMesh};

pub struct AttributedMesh {
    pub mesh: TriMesh,
    pub attributes: Attributes,
}

pub struct Model {
    pub attributed: AttributedMesh,
    pub looks: Looks,
    pub notes: Vec<String>,
}

impl Model {
    pub fn read(path: &Path) -> Result<Self> {
        match Format::from_path(path) {
            Some(Format::Gltf | Format::Glb) => Self::from_asset(&Asset::read_path(path)?),
            _ => Self::from_mesh_file(path),
        }
    }

    fn from_mesh_file(path: &Path) -> Result<Self> {
        let read = read_attributed_path(path, None)?;
        let (looks, notes) = read_looks(&read.extra, false);
        let cleaned = clean(read.mesh, &CleanOptions::default())?;
        Ok(Self { attributed: AttributedMesh { mesh: cleaned.mesh, attributes: cleaned.attributes }, looks, notes })
    }

    fn from_asset(asset: &Asset) -> Result<Self> {
        let cleaned = |part: &neural_mesh::io::AssetPart| clean(part.mesh.clone(), &CleanOptions::default());
        let parts: Vec<Cleaned> = asset.parts().iter().map(cleaned).collect::<Result<_, _>>()?;
        let piece = |(part, of): (_, &neural_mesh::io::AssetPart)| {
            let Cleaned { mesh, attributes, .. }: &Cleaned = part;
            ScenePiece { mesh, attributes, scale: of.scale, places: &[] }
        };
        let pieces: Vec<ScenePiece> = parts.iter().zip(asset.parts()).map(piece).collect();
        let united = UnitedMesh::new(&pieces).context("its meshes are too far apart in size")?;
        let (of_parts, notes) = asset.looks();
        let mut looks = Looks { linear_colours: true, ..Looks::default() };
        for (piece, of_part) in of_parts.into_iter().enumerate() {
            looks.of_groups.resize(united.first_group(piece) as usize, Look::default());
            looks.of_groups.extend(of_part);
        }
        Ok(Self { attributed: AttributedMesh { mesh: united.mesh, attributes: united.attributes }, looks, notes })
    }
}
