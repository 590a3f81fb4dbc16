//! Stored normals in pictures.

use glam::{Vec2, Vec3};

use super::camera::Camera;
use super::raster::weights_at;
use super::scaled_mesh::ScaledMesh;
use crate::mesh::Attributes;

// A shorter blend of unit normals has no direction.
const LEAST_LENGTH: f32 = 1e-6;

/// Unit normals at the corners of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct CornerNormals {
    // n_faces x 3; zeros on faces where a corner has none.
    normals: Vec<[Vec3; 3]>,
}

impl CornerNormals {
    /// Takes the stored normals from a mesh's attributes; `None` without any.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// use neural_mesh::mesh::{Attributes, Channel, Role};
    /// use neural_mesh::picture::CornerNormals;
    /// let normals = Channel { name: "NORMAL".into(), role: Role::Normal, width: 3, values: vec![0.0, 0.0, 2.0] };
    /// let attributes = Attributes { wedges: vec![[0; 3]], channels: vec![normals], groups: Vec::new() };
    /// assert!(CornerNormals::new(&attributes).is_some());
    /// assert!(CornerNormals::new(Attributes::NONE).is_none());
    /// ```
    pub fn new(attributes: &Attributes) -> Option<Self> {
        let channel = attributes.normals()?;
        let unit = |wedge: u32| Vec3::from_slice(channel.value(wedge)).normalize_or_zero();
        let corners = |wedges: &[u32; 3]| {
            let normals = wedges.map(unit);
            // A single missing normal would tilt the whole face.
            if normals.contains(&Vec3::ZERO) { [Vec3::ZERO; 3] } else { normals }
        };
        Some(Self { normals: attributes.wedges.iter().map(corners).collect() })
    }

    /// Returns the unit normals of a face's corners; zeros if the face has none.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// use neural_mesh::mesh::{Attributes, Channel, Role};
    /// use neural_mesh::picture::CornerNormals;
    /// let normals = Channel { name: "NORMAL".into(), role: Role::Normal, width: 3, values: vec![0.0, 0.0, 2.0] };
    /// let attributes = Attributes { wedges: vec![[0; 3]], channels: vec![normals], groups: Vec::new() };
    /// let normals = CornerNormals::new(&attributes).unwrap();
    /// assert_eq!((normals.corners(0)[1], normals.corners(1)[1]), ([0.0, 0.0, 1.0], [0.0; 3]));
    /// ```
    pub fn corners(&self, face: u32) -> [[f32; 3]; 3] {
        self.normals.get(face as usize).map_or([[0.0; 3]; 3], |corners| corners.map(|normal| normal.to_array()))
    }

    pub(super) fn place_on<'a>(
        &'a self,
        shape: &'a ScaledMesh,
        points: &'a [Vec3],
        camera: &'a Camera,
    ) -> Option<BlendedNormals<'a>> {
        let fits = self.normals.len() == shape.faces.len();
        fits.then_some(BlendedNormals { corners: self, points, faces: shape.faces, camera })
    }
}

pub(super) struct BlendedNormals<'a> {
    corners: &'a CornerNormals,
    // Projected vertices in samples, with the inverse depth as z, n_vertices.
    points: &'a [Vec3],
    faces: &'a [[u32; 3]],
    camera: &'a Camera,
}

impl BlendedNormals<'_> {
    /// Returns the unit normal of a face at a point in sample coordinates, in the view's frame; zero if it has none.
    pub fn normal(&self, face: u32, at: Vec2) -> Vec3 {
        let weights = weights_at(self.points, self.faces[face as usize], at);
        let [a, b, c] = self.corners.normals[face as usize];
        let blend = a * weights.x + b * weights.y + c * weights.z;
        if blend.length() > LEAST_LENGTH && blend.is_finite() {
            self.camera.view(blend.normalize())
        } else {
            Vec3::ZERO
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ShadedMesh, view, view_shaded};
    use super::*;
    use crate::mesh::{Channel, Role, TriMesh, shapes, vertex_normals, with_flat_normals};

    fn smooth(mesh: &TriMesh) -> Attributes {
        let values = vertex_normals(mesh).into_iter().flatten().collect();
        let channel = Channel { name: "NORMAL".into(), role: Role::Normal, width: 3, values };
        Attributes { wedges: mesh.faces().to_vec(), channels: vec![channel], groups: Vec::new() }
    }

    #[test]
    fn normals_of_faces_shade_as_faces_do() {
        let mesh = shapes::icosphere(2);
        let normals = CornerNormals::new(&with_flat_normals(&mesh, Attributes::NONE, "NORMAL"));
        let shaded = ShadedMesh { normals: normals.as_ref(), ..ShadedMesh::bare(&mesh) };
        let [bare, shaded] = [view(&[&mesh], [30.0, 15.0], 96), view_shaded(&[shaded], [30.0, 15.0], 96)];
        let bytes = bare[0].shaded.rgba.iter().zip(&shaded[0].shaded.rgba);
        assert!(
            bytes.chain(bare[0].normals.rgba.iter().zip(&shaded[0].normals.rgba)).all(|(x, y)| x.abs_diff(*y) <= 1)
        );
    }

    #[test]
    fn smooth_normals_hide_facets() {
        let sphere = shapes::icosphere(2);
        let normals = CornerNormals::new(&smooth(&sphere));
        let shaded = ShadedMesh { normals: normals.as_ref(), ..ShadedMesh::bare(&sphere) };
        // Neighbouring pixels differ by far less than between facets.
        let largest_step = |view: &super::super::MeshView| {
            let pairs = (1..view.covered.len())
                .filter(|&i| i % view.normals.width > 0 && view.covered[i] == 9 && view.covered[i - 1] == 9);
            let step = |i: usize| {
                (0..3).map(|k| view.normals.rgba[4 * i + k].abs_diff(view.normals.rgba[4 * i - 4 + k])).max()
            };
            let inner = pairs.filter(|i| view.normals.rgba[4 * i + 2] > 220);
            inner.filter_map(step).max().unwrap()
        };
        let flat = largest_step(&view(&[&sphere], [30.0, 15.0], 96)[0]);
        let smooth = largest_step(&view_shaded(&[shaded], [30.0, 15.0], 96)[0]);
        assert!(3 * smooth < flat, "{smooth} {flat}");
    }

    #[test]
    fn faces_without_normals_and_other_meshes_are_shaded_by_faces() {
        let (mesh, other) = (shapes::icosphere(2), shapes::icosphere(1));
        let zeros = Channel { name: "NORMAL".into(), role: Role::Normal, width: 3, values: vec![0.0; 3] };
        let none = Attributes { wedges: vec![[0; 3]; mesh.faces().len()], channels: vec![zeros], groups: Vec::new() };
        for attributes in [none, smooth(&other)] {
            let normals = CornerNormals::new(&attributes);
            let shaded = ShadedMesh { normals: normals.as_ref(), ..ShadedMesh::bare(&mesh) };
            assert_eq!(view_shaded(&[shaded], [30.0, 15.0], 64), view(&[&mesh], [30.0, 15.0], 64));
        }
    }
}
