//! Documents: a mesh with the other content of its file, or a glTF scene united into one mesh.

mod far_parts;
mod flat_level;
mod godot;
mod images;
mod least;
mod mesh_levels;
mod named_groups;
mod placed_surface;
mod read;
mod write;

use crate::io::{self, Asset, Extra};
use crate::mesh::cleanup::{CleanCounts, Cleaned};
use crate::mesh::{Attributes, Channel, Frame, Looks, Role, TriMesh, UnitedMesh};
use crate::picture::image_size;
use crate::repair::RepairCounts;
use crate::simplify::{self, Input, Progression, importance_of_channel};

use super::report::Dropped;
use super::request::Job;
use super::textures::Textures;

pub use named_groups::list_names;
pub use placed_surface::PlacedSurface;

/// A mesh, or a scene whose meshes are united into one.
pub struct Document {
    /// Local origin of the coordinates, and whether the file stores doubles.
    pub frame: Frame,
    /// Changes made by cleaning.
    pub counts: CleanCounts,
    /// Content dropped or repaired while reading, one line each.
    pub notes: Vec<String>,
    /// Changes made by `--fill-holes` or `--printable`.
    pub repaired: Option<RepairCounts>,
    kind: Kind,
    /// Progression whose levels are the results.
    progression: Option<Progression>,
    // Attributes that the result keeps; `None` if it keeps all of the input's.
    wanted: Option<Attributes>,
    /// Importance of each vertex, in the order of the file.
    factors: Option<Vec<f32>>,
    textures: Option<Textures>,
}

/// Piece of the united mesh that a part of the asset is.
#[derive(Clone, Copy)]
struct PartPiece {
    number: usize,
    /// Point of the part's coordinates that is the origin of the piece's.
    origin: [f32; 3],
}

enum Kind {
    Mesh {
        cleaned: Box<Cleaned>,
        // Double-precision positions, n_raw x 3, if single precision would change them.
        exact: Option<Vec<[f64; 3]>>,
        extra: Extra,
    },
    Scene {
        asset: Box<Asset>,
        united: UnitedMesh,
        // Piece of the united mesh for each part of the asset; `None` for a part without faces.
        pieces: Vec<Option<PartPiece>>,
    },
}

impl Document {
    /// Returns the bounding box diagonal of the mesh, or of the scene with its nodes' transforms.
    pub fn diagonal(&self) -> f64 {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => cleaned.mesh.diagonal(),
            Kind::Scene { united, .. } => united.diagonal(),
        }
    }

    /// Returns whether the document is a glTF scene.
    pub fn is_scene(&self) -> bool {
        matches!(self.kind, Kind::Scene { .. })
    }

    /// Returns whether the document is a scene that uses the glTF extension `name`.
    pub fn has_extension(&self, name: &str) -> bool {
        matches!(&self.kind, Kind::Scene { asset, .. } if asset.has_extension(name))
    }

    /// Returns the mesh; for a scene, the united one.
    pub fn mesh(&self) -> &TriMesh {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => &cleaned.mesh,
            Kind::Scene { united, .. } => &united.mesh,
        }
    }

    /// Returns the attributes of the mesh.
    pub fn attributes(&self) -> &Attributes {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => &cleaned.attributes,
            Kind::Scene { united, .. } => &united.attributes,
        }
    }

    /// Lists names of materials, groups and objects, each with the index of a group of faces.
    pub fn group_names(&self) -> Vec<(String, u32)> {
        match &self.kind {
            Kind::Mesh { extra, .. } => {
                let names = |group: &io::Group| [&group.material, &group.name, &group.object].map(Option::clone);
                let named = extra.groups.iter().zip(0..).flat_map(|(group, i)| names(group).map(|name| (name, i)));
                named.filter_map(|(name, i)| Some((name?, i))).collect()
            }
            Kind::Scene { asset, united, pieces } => {
                let parts = asset.parts().iter().zip(pieces).filter_map(|(part, piece)| Some((part, (*piece)?)));
                let named =
                    parts.flat_map(|(part, piece)| part.materials.iter().zip(united.first_group(piece.number)..));
                named.map(|(name, group)| (name.clone(), group)).collect()
            }
        }
    }

    /// Lists the dropped components with the names of their mesh or object and material.
    pub fn dropped_components(&self, report: &simplify::Report) -> Vec<Dropped> {
        let name = |face: u32| {
            let group = self.attributes().group(face);
            match &self.kind {
                Kind::Mesh { extra, .. } => extra.groups.get(group as usize).map_or_else(String::new, |group| {
                    join_names(group.object.as_ref().or(group.name.as_ref()), group.material.as_ref())
                }),
                Kind::Scene { asset, united, pieces } => {
                    let piece = united.piece_of_group(group);
                    let part = pieces.iter().position(|of_part| of_part.is_some_and(|it| it.number == piece));
                    part.map_or_else(String::new, |part| {
                        let part = &asset.parts()[part];
                        join_names(Some(&part.name), part.materials.get((group - united.first_group(piece)) as usize))
                    })
                }
            }
        };
        let dropped = |component: &simplify::DroppedComponent| {
            let name = Some(name(component.face)).filter(|name| !name.is_empty());
            let name = name.unwrap_or_else(|| format!("the component of face {}", component.face));
            Dropped { name, faces: component.n_faces }
        };
        report.dropped.iter().map(dropped).collect()
    }

    /// Returns the material of each group of faces, and one line per problem.
    pub fn looks(&self, allow_outside: bool) -> (Looks, Vec<String>) {
        match &self.kind {
            Kind::Mesh { extra, .. } => io::read_looks(extra, allow_outside),
            Kind::Scene { asset, .. } => asset.scene_looks(),
        }
    }

    /// Converts texels to a share of the largest colour texture's side; without textures, of 1024 texels.
    pub fn share_of_texture(&self, texels: f64, job: &Job) -> f64 {
        let (looks, _) = self.looks(job.arguments.allow_outside);
        let textures = looks.of_groups.iter().filter_map(|look| look.texture.as_ref());
        let side = textures.filter_map(|texture| image_size(&texture.image)).flatten().max();
        (texels / side.map_or(1024.0, |side| side as f64)).min(1.0)
    }

    /// Returns the input for the simplifier.
    pub fn input(&self) -> Input<'_> {
        let mut input = Input::bare(self.mesh());
        input.attributes = self.wanted.as_ref().unwrap_or(self.attributes());
        input.scene = self.united_mesh();
        input
    }

    /// Returns the attributes of the result with the original's groups of faces.
    pub fn attributes_with_groups(&self) -> Attributes {
        let all = self.attributes();
        let wanted = self.wanted.as_ref().unwrap_or(all).clone();
        Attributes { groups: all.groups.clone(), ..wanted }
    }

    /// Sets the progression of the document's mesh; results are then its levels.
    pub fn with_progression(self, progression: Progression) -> Self {
        Self { progression: Some(progression), ..self }
    }

    /// Returns the progression whose levels are the results, if there is one.
    pub fn progression(&self) -> Option<&Progression> {
        self.progression.as_ref()
    }

    /// Returns the united mesh of a scene.
    pub fn united_mesh(&self) -> Option<&UnitedMesh> {
        match &self.kind {
            Kind::Mesh { .. } => None,
            Kind::Scene { united, .. } => Some(united),
        }
    }

    /// Sets the importance of each vertex, in the order of the file.
    pub fn with_importance(self, factors: Option<Vec<f32>>) -> Self {
        Self { factors, ..self }
    }

    /// Returns the importance set by the caller, n_vertices; the inner `None` means invalid numbers.
    pub fn importance(&self) -> Option<Option<Vec<f32>>> {
        let (factors, sources) = (self.factors.as_ref()?, self.file_vertices()?);
        let values: Option<Vec<f32>> = sources.iter().map(|&vertex| factors.get(vertex as usize).copied()).collect();
        Some(values.and_then(|values| {
            let channel = Channel { name: String::new(), role: Role::Other, width: 1, values };
            let attributes = Attributes { wedges: self.mesh().faces().to_vec(), ..Attributes::default() };
            importance_of_channel(self.mesh(), &attributes, &channel)
        }))
    }

    /// Returns the index in the file of each vertex; `None` for a scene.
    pub fn file_vertices(&self) -> Option<&[u32]> {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => Some(&cleaned.source),
            Kind::Scene { .. } => None,
        }
    }
}

/// Joins the names of an object and its material, such as `door (oak)`.
fn join_names(object: Option<&String>, material: Option<&String>) -> String {
    match (object, material) {
        (Some(object), Some(material)) => format!("{object} ({material})"),
        (object, material) => object.or(material).cloned().unwrap_or_default(),
    }
}
