//! What is simplified and written again: a mesh with all that its file says, or the meshes of a glTF scene, as one.

mod images;
mod least;
mod named;
mod read;
mod seen;
mod write;

use crate::io::{self, Asset, Extra};
use crate::mesh::cleanup::{CleanCounts, Cleaned};
use crate::mesh::{Attributes, Channel, Frame, Looks, Role, TriMesh, UnitedMesh};
use crate::picture::image_size;
use crate::repair::RepairCounts;
use crate::simplify::{self, Input, MirrorPlane, Symmetry, importance_of_channel};

use super::error::JobError;
use super::report::Dropped;
use super::request::Job;
use super::textures::Textures;

pub use named::listed;
pub use seen::Seen;

/// A mesh, or the meshes of a scene side by side in one.
pub struct Document {
    /// How coordinates lie in the file.
    pub frame: Frame,
    /// What was cleaned.
    pub counts: CleanCounts,
    /// What could not be kept, in one line each.
    pub notes: Vec<String>,
    /// What a repair did, where one was asked for.
    pub repaired: Option<RepairCounts>,
    kind: Kind,
    /// What of the attributes the result is to have, where that is not all.
    wanted: Option<Attributes>,
    /// How much each vertex counts as it was read, where the caller says so.
    factors: Option<Vec<f32>>,
    /// Who makes its textures smaller, where that is asked for.
    textures: Option<Textures>,
}

enum Kind {
    Mesh {
        cleaned: Box<Cleaned>,
        /// Positions in double precision, n_raw x 3, where the file has such, or decimals that are to stay.
        exact: Option<Vec<[f64; 3]>>,
        extra: Extra,
    },
    Scene {
        asset: Box<Asset>,
        united: UnitedMesh,
        /// For each part of the asset its piece of the united mesh; none where the part has no face that can be drawn.
        pieces: Vec<Option<usize>>,
    },
}

impl Document {
    /// The diagonal of the box of the mesh, of a scene where a viewer sees it.
    pub fn diagonal(&self) -> f64 {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => cleaned.mesh.diagonal(),
            Kind::Scene { united, .. } => united.diagonal(),
        }
    }

    /// Whether it is a glTF scene that stays one.
    pub fn is_scene(&self) -> bool {
        matches!(self.kind, Kind::Scene { .. })
    }

    /// Whether it is a scene that uses a glTF extension.
    pub fn has_extension(&self, name: &str) -> bool {
        matches!(&self.kind, Kind::Scene { asset, .. } if asset.has_extension(name))
    }

    /// The mesh, or all of them.
    pub fn mesh(&self) -> &TriMesh {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => &cleaned.mesh,
            Kind::Scene { united, .. } => &united.mesh,
        }
    }

    /// What its corners and faces carry.
    pub fn attributes(&self) -> &Attributes {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => &cleaned.attributes,
            Kind::Scene { united, .. } => &united.attributes,
        }
    }

    /// The names of materials, groups and objects that the file has for groups of faces, and which groups these are.
    pub fn group_names(&self) -> Vec<(String, u32)> {
        match &self.kind {
            Kind::Mesh { extra, .. } => {
                let names = |group: &io::Group| [&group.material, &group.name, &group.object].map(Option::clone);
                let named = extra.groups.iter().zip(0..).flat_map(|(group, i)| names(group).map(|name| (name, i)));
                named.filter_map(|(name, i)| Some((name?, i))).collect()
            }
            Kind::Scene { asset, united, pieces } => {
                let parts = asset.parts().iter().zip(pieces).filter_map(|(part, piece)| Some((part, (*piece)?)));
                let named = parts.flat_map(|(part, piece)| part.materials.iter().zip(united.first_group(piece)..));
                named.map(|(name, group)| (name.clone(), group)).collect()
            }
        }
    }

    /// Names the components that a result lacks: by the mesh of a scene, or the object, and the material.
    pub fn dropped(&self, report: &simplify::Report) -> Vec<Dropped> {
        let name = |face: u32| {
            let group = self.attributes().group(face);
            match &self.kind {
                Kind::Mesh { extra, .. } => extra.groups.get(group as usize).map_or_else(String::new, |group| {
                    named(group.object.as_ref().or(group.name.as_ref()), group.material.as_ref())
                }),
                Kind::Scene { asset, united, pieces } => {
                    let piece = united.piece_of_group(group);
                    let part = pieces.iter().position(|of_part| *of_part == Some(piece));
                    part.map_or_else(String::new, |part| {
                        let part = &asset.parts()[part];
                        named(Some(&part.name), part.materials.get((group - united.first_group(piece)) as usize))
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

    /// What the groups of its faces look like; beside it what could not be had of that, in one line each.
    pub fn looks(&self, allow_outside: bool) -> (Looks, Vec<String>) {
        match &self.kind {
            Kind::Mesh { extra, .. } => io::read_looks(extra, allow_outside),
            Kind::Scene { asset, .. } => asset.scene_looks(),
        }
    }

    /// So many texels as a share of the side of its largest texture of colours, or of 1024 texels where it has none.
    pub fn share_of_texture(&self, texels: f64, job: &Job) -> f64 {
        let (looks, _) = self.looks(job.allow_outside);
        let textures = looks.of_groups.iter().filter_map(|look| look.texture.as_ref());
        let side = textures.filter_map(|texture| image_size(&texture.image)).flatten().max();
        (texels / side.map_or(1024.0, |side| side as f64)).min(1.0)
    }

    /// What the simplifier is given.
    pub fn input<'a>(&'a self, importance: &'a [f32], kept: &'a [bool]) -> Input<'a> {
        let mut input = Input::bare(self.mesh());
        input.attributes = self.wanted.as_ref().unwrap_or(self.attributes());
        (input.importance, input.kept) = (importance, kept);
        input.scene = self.united();
        input
    }

    /// Returns what the simplifier is given of what corners and faces carry, with the groups of the faces.
    pub fn attributes_with_groups(&self) -> Attributes {
        let all = self.attributes();
        let wanted = self.wanted.as_ref().unwrap_or(all).clone();
        Attributes { groups: all.groups.clone(), ..wanted }
    }

    /// The meshes of the scene, where it is one.
    pub fn united(&self) -> Option<&UnitedMesh> {
        match &self.kind {
            Kind::Mesh { .. } => None,
            Kind::Scene { united, .. } => Some(united),
        }
    }

    /// The plane of a symmetry, as it lies in the mesh: that of a scene's only mesh is in the coordinates of that mesh.
    pub fn symmetry(&self, symmetry: Symmetry) -> Result<Symmetry, JobError> {
        let Kind::Scene { united, pieces, .. } = &self.kind else { return Ok(symmetry) };
        if pieces.iter().flatten().count() > 1 {
            let what = "--symmetric: a scene of several meshes has no single plane: give a file for each";
            return Err(JobError::Options(what.into()));
        }
        Ok(match symmetry {
            Symmetry::Plane(MirrorPlane { axis, at }) => {
                Symmetry::Plane(MirrorPlane { axis, at: at * united.scale(0) })
            }
            other => other,
        })
    }

    /// The plane of a result, as it lies in the file.
    pub fn plane_of_file(&self, plane: MirrorPlane) -> MirrorPlane {
        match &self.kind {
            Kind::Mesh { .. } => plane,
            Kind::Scene { united, .. } => MirrorPlane { at: plane.at / united.scale(0), ..plane },
        }
    }

    /// The same, with how much each vertex counts as it was read.
    pub fn weighed(self, factors: Option<Vec<f32>>) -> Self {
        Self { factors, ..self }
    }

    /// How much the vertices count, n_vertices, where the caller says so; nothing within where that is no importance.
    pub fn importance(&self) -> Option<Option<Vec<f32>>> {
        let (factors, sources) = (self.factors.as_ref()?, self.file_vertices()?);
        let values: Option<Vec<f32>> = sources.iter().map(|&vertex| factors.get(vertex as usize).copied()).collect();
        Some(values.and_then(|values| {
            let channel = Channel { name: String::new(), role: Role::Other, width: 1, values };
            let attributes = Attributes { wedges: self.mesh().faces().to_vec(), ..Attributes::default() };
            importance_of_channel(self.mesh(), &attributes, &channel)
        }))
    }

    /// The vertex of the file that each vertex was read from; for a scene, whose vertices are those of its primitives, none.
    pub fn file_vertices(&self) -> Option<&[u32]> {
        match &self.kind {
            Kind::Mesh { cleaned, .. } => Some(&cleaned.source),
            Kind::Scene { .. } => None,
        }
    }
}

/// `door (oak)`, as far as there are names.
fn named(object: Option<&String>, material: Option<&String>) -> String {
    match (object, material) {
        (Some(object), Some(material)) => format!("{object} ({material})"),
        (object, material) => object.or(material).cloned().unwrap_or_default(),
    }
}
