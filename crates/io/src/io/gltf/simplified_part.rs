//! Simplified part of an asset.

use super::asset_part::AssetPart;
use super::semantics::{SKIN, TARGET};
use crate::io::WriteError;
use crate::mesh::{Attributes, Channel, RawMesh};

/// Part of an asset after simplification.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SimplifiedPart {
    /// Positions in coordinates of the part, n_vertices x 3.
    pub positions: Vec<[f32; 3]>,
    /// Vertex indices, n_faces x 3.
    pub faces: Vec<[u32; 3]>,
    /// Attributes in the channels of the part; groups are primitives.
    pub attributes: Attributes,
}

impl SimplifiedPart {
    /// Makes a part from positions, n_vertices x 3, faces, n_faces x 3, and attributes.
    pub fn new(positions: Vec<[f32; 3]>, faces: Vec<[u32; 3]>, attributes: Attributes) -> Self {
        Self { positions, faces, attributes }
    }

    /// Copies a part, without faces that have non-finite corners.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Asset, SimplifiedPart};
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// assert_eq!(SimplifiedPart::from_part(&asset.parts()[0]).faces.len(), 4);
    /// ```
    pub fn from_part(part: &AssetPart) -> Self {
        let RawMesh { positions, faces, attributes, .. } = &part.mesh;
        let is_finite = |v: &u32| positions.get(*v as usize).is_some_and(|p| p.iter().all(|x| (*x as f32).is_finite()));
        let kept: Vec<u32> =
            (0..faces.len() as u32).filter(|&face| faces[face as usize].iter().all(is_finite)).collect();
        // No face uses a position beyond single precision, so it is replaced.
        let finite = |x: f64| if (x as f32).is_finite() { x as f32 } else { 0.0 };
        Self {
            positions: positions.iter().map(|position| position.map(finite)).collect(),
            faces: kept.iter().map(|&face| faces[face as usize]).collect(),
            attributes: attributes.clone().select_faces(&kept).unwrap_or_default(),
        }
    }

    pub(super) fn wedges(&self, face: usize) -> [u32; 3] {
        self.attributes.wedges.get(face).copied().unwrap_or_default()
    }

    pub(super) fn channel(&self, name: &str) -> Option<&Channel> {
        self.attributes.find_channel(name, 0).map(|at| &self.attributes.channels[at])
    }

    pub(super) fn check(&self, part: &AssetPart) -> Result<(), WriteError> {
        let problem = |what: &str| Err(WriteError::new(format!("{}: {what}", part.name)));
        if !self.is_mesh() {
            return problem("faces, positions and attributes do not fit each other: give a valid mesh");
        }
        for (near, held) in part.mesh.attributes.channels.iter().enumerate() {
            // Skins and morph targets are required by nodes and animations; other channels may be dropped.
            let needed = held.name == SKIN || held.name.starts_with(TARGET);
            match self.attributes.find_channel(&held.name, near).map(|at| &self.attributes.channels[at]) {
                None if needed => {
                    return problem(&format!("the channel {} is missing: keep it in the result", held.name));
                }
                Some(channel) if channel.width != held.width => {
                    return problem(&format!("the channel {} has another width: keep its width", held.name));
                }
                _ => {}
            }
        }
        Ok(())
    }

    pub(super) fn is_mesh(&self) -> bool {
        let Attributes { wedges, channels, groups } = &self.attributes;
        let (n_vertices, n_faces) = (self.positions.len(), self.faces.len());
        self.faces.iter().flatten().all(|&vertex| (vertex as usize) < n_vertices)
            && self.positions.iter().flatten().all(|x| x.is_finite())
            && (channels.is_empty() || wedges.len() == n_faces && self.attributes.has_values_for(wedges))
            && (groups.is_empty() || groups.len() == n_faces)
    }
}
