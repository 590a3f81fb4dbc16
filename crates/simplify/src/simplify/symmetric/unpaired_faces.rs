//! Faces without a mirror image.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::mesh::{TriMesh, join_positions};
use crate::spatial::FaceTree;

use super::image_plane::ImagePlane;

/// Counts faces or boundary edges without an image; `vertices` holds the image of each vertex.
pub(super) fn count_unpaired(mesh: &TriMesh, plane: &ImagePlane, vertices: &[u32], tolerance: f64) -> usize {
    let places = WeldedFaces::new(mesh, vertices);
    let images = ImagePoints { positions: mesh.positions(), plane, tolerance };
    match images.count_off(mesh.faces(), &places.unpaired_faces()) {
        // Boundaries are checked only if all faces have images.
        0 => images.count_off(&places.boundary_triangles(), &places.unpaired_boundary()),
        n_alone => n_alone,
    }
}

struct WeldedFaces {
    faces: Vec<[u32; 3]>,
    images: Vec<[u32; 3]>,
    boundary: Vec<[u32; 2]>,
}

impl WeldedFaces {
    fn new(mesh: &TriMesh, vertices: &[u32]) -> Self {
        let (places, _) = join_positions(mesh.positions());
        let faces: Vec<[u32; 3]> = mesh.faces().iter().map(|face| face.map(|v| places[v as usize])).collect();
        let image = |v: u32| places[vertices[v as usize] as usize];
        let images = mesh.faces().iter().map(|face| face.map(image)).collect();
        let boundary = boundary_edges(&faces);
        Self { faces, images, boundary }
    }

    /// Finds the faces whose image is neither a face nor covered by several faces together.
    fn unpaired_faces(&self) -> Vec<u32> {
        // The two sides may cut a quad or polygon differently, so faces may match only together.
        let known: FxHashSet<[u32; 3]> = self.faces.iter().copied().map(ascending).collect();
        let is_other = |f: &u32| !known.contains(&ascending(self.images[*f as usize]));
        let mut others: Vec<u32> = (0..self.faces.len() as u32).filter(is_other).collect();
        // If unmatched faces and their images cover one region, each edge around it occurs once among each.
        let mut odd = FxHashSet::default();
        for &f in &others {
            for edge in edges_of(self.faces[f as usize]).into_iter().chain(edges_of(self.images[f as usize])) {
                if !odd.remove(&edge) {
                    odd.insert(edge);
                }
            }
        }
        // An image whose edges all exist crosses no diagonal, so a face is missing there.
        let is_edge: FxHashSet<[u32; 2]> = match others[..] {
            [] => FxHashSet::default(),
            _ => self.faces.iter().flat_map(|&face| edges_of(face)).collect(),
        };
        let is_alone = |image: [[u32; 2]; 3]| {
            image.iter().any(|edge| odd.contains(edge)) || image.iter().all(|edge| is_edge.contains(edge))
        };
        others.retain(|&f| is_alone(edges_of(self.images[f as usize])));
        others
    }

    fn boundary_triangles(&self) -> Vec<[u32; 3]> {
        self.boundary.iter().map(|&[a, b]| [a, b, b]).collect()
    }

    fn unpaired_boundary(&self) -> Vec<u32> {
        if self.boundary.is_empty() {
            return Vec::new();
        }
        let known: FxHashSet<[u32; 2]> = self.boundary.iter().copied().collect();
        let mut image = FxHashMap::default();
        for (face, images) in self.faces.iter().zip(&self.images) {
            image.extend(face.iter().copied().zip(images.iter().copied()));
        }
        let is_unlike = |&(_, [a, b]): &(u32, &[u32; 2])| !known.contains(&edge(image[a], image[b]));
        (0..).zip(&self.boundary).filter(is_unlike).map(|(number, _)| number).collect()
    }
}

struct ImagePoints<'a> {
    positions: &'a [[f32; 3]],
    plane: &'a ImagePlane,
    tolerance: f64,
}

impl ImagePoints<'_> {
    fn count_off(&self, triangles: &[[u32; 3]], some: &[u32]) -> usize {
        if some.is_empty() {
            return 0;
        }
        let tree = FaceTree::new(self.positions, triangles);
        let is_off = |number: &&u32| {
            // One point per triangle suffices, since unmatched faces together cover what their images cover.
            let triangle = triangles[**number as usize];
            let corners = triangle.map(|v| DVec3::from(self.plane.image(self.positions[v as usize]).map(f64::from)));
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            tree.nearest(middle).is_none_or(|(_, distance2)| distance2 > self.tolerance * self.tolerance)
        };
        some.iter().filter(is_off).count()
    }
}

fn boundary_edges(faces: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut n_faces: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    faces.iter().flat_map(|&face| edges_of(face)).for_each(|edge| *n_faces.entry(edge).or_default() += 1);
    faces.iter().flat_map(|&face| edges_of(face)).filter(|edge| n_faces[edge] == 1).collect()
}

fn edges_of([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [edge(a, b), edge(b, c), edge(c, a)]
}

fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

pub(super) fn ascending(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}
