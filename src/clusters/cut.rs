//! Cuts: the clusters that are drawn together.

use crate::mesh::{Attributes, TriMesh, compact, join_positions};

use super::{ClusterGroup, Clusters};

/// A camera, for the size of errors on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewPoint {
    /// Position, in the mesh's coordinates.
    pub eye: [f32; 3],
    /// Pixels of one unit at the distance 1: half the height of the image over the tangent of half the angle of view.
    pub pixels: f64,
    /// Distance of the near plane, in the mesh's unit.
    pub near: f64,
}

impl ViewPoint {
    /// Returns a bound of a group's error on the screen, in pixels.
    ///
    /// It never falls from a group to one that simplifies its result, since errors grow and spheres are nested.
    pub fn error_in_pixels(&self, group: &ClusterGroup) -> f64 {
        let distance = group.sphere.distance(self.eye).max(self.near).max(f64::MIN_POSITIVE);
        f64::from(group.error) * self.pixels / distance
    }
}

impl Clusters {
    /// Returns the clusters to draw if `is_fine` accepts the results of groups that are near enough to the input.
    ///
    /// The cut covers the surface once and has no cracks if `is_fine` accepts all groups that led to an accepted one, as
    /// bounds of errors do.
    pub fn cut(&self, is_fine: impl Fn(&ClusterGroup) -> bool) -> Vec<u32> {
        let fine: Vec<bool> = self.groups.iter().map(is_fine).collect();
        let is_fine = |group: Option<u32>| group.map(|group| fine[group as usize]);
        // Results of fine groups are drawn in place of what they simplify.
        let is_drawn = |cluster: u32| {
            let cluster = &self.clusters[cluster as usize];
            is_fine(cluster.source) != Some(false) && is_fine(cluster.group) != Some(true)
        };
        (0..self.clusters.len() as u32).filter(|&cluster| is_drawn(cluster)).collect()
    }

    /// Returns the coarsest cut whose distance from the input is proved to be at most `error`, in the mesh's unit.
    pub fn cut_at_error(&self, error: f64) -> Vec<u32> {
        self.cut(|group| f64::from(group.error) <= error)
    }

    /// Returns the coarsest cut with errors of at most `pixels` on the screen.
    pub fn cut_for_view(&self, view: &ViewPoint, pixels: f64) -> Vec<u32> {
        self.cut(|group| view.error_in_pixels(group) <= pixels)
    }

    /// Joins clusters in one mesh with their attributes; vertices at one position are one vertex.
    pub fn mesh_of(&self, clusters: &[u32]) -> (TriMesh, Attributes) {
        let corners: Vec<[u32; 3]> = clusters.iter().flat_map(|&cluster| self.faces_of(cluster)).collect();
        let (first, _) = join_positions(&self.positions);
        let faces = corners.iter().map(|face| face.map(|v| first[v as usize])).collect();
        let group = |&cluster: &u32| {
            let cluster = &self.clusters[cluster as usize];
            (cluster.first_face..cluster.first_face + cluster.n_faces).map(|face| self.face_groups[face as usize])
        };
        let attributes = Attributes {
            wedges: if self.channels.is_empty() { Vec::new() } else { corners },
            channels: self.channels.clone(),
            groups: if self.face_groups.is_empty() { Vec::new() } else { clusters.iter().flat_map(group).collect() },
        };
        // No cluster has a face with two corners at one position.
        let mesh = compact(&self.positions, faces).map(|(mesh, _)| mesh).unwrap_or_default();
        (mesh, attributes)
    }
}
