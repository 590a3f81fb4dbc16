//! Mirror images of vertices and corners.

use rustc_hash::FxHashMap;

use crate::mesh::{Frame, TriMesh};
use crate::simplify::SimplifyError;
use crate::spatial::nearest_to;

use super::image_plane::{ImagePlane, is_within, tolerance};
use super::unpaired_faces::{ascending, count_unpaired};

pub(super) struct MirrorPairs {
    pub vertices: Vec<u32>,
    /// Corner (`3 * face + corner`) at the image of each corner.
    pub corners: Vec<u32>,
}

impl MirrorPairs {
    /// Finds the images of all vertices and corners; faces need not match one by one.
    ///
    /// # Errors
    /// [`SimplifyError::NotSymmetric`] with the number of vertices or faces without an image.
    pub fn new(mesh: &TriMesh, plane: &ImagePlane, frame: &Frame) -> Result<Self, SimplifyError> {
        let images: Vec<[f32; 3]> = mesh.positions().iter().map(|&p| plane.image(p)).collect();
        let vertices = nearest_to(mesh.positions(), &images, 1);
        let tolerance = tolerance(mesh);
        let is_alone = |(image, v): &(&[f32; 3], &u32)| !is_within(**image, mesh.positions()[**v as usize], tolerance);
        let n_alone = images.iter().zip(&vertices).filter(is_alone).count();
        let refused = |vertices, faces| SimplifyError::NotSymmetric { plane: plane.in_file(frame), vertices, faces };
        if n_alone > 0 {
            return Err(refused(n_alone, 0));
        }
        // Vertices are checked first: without their images, faces have none.
        let n_alone = count_unpaired(mesh, plane, &vertices, tolerance);
        if n_alone > 0 {
            return Err(refused(0, n_alone));
        }
        let images = Images::new(mesh, &vertices);
        let corners = (0..mesh.faces().len() as u32).flat_map(|f| images.corners(f)).collect();
        Ok(Self { corners, vertices })
    }
}

struct Images<'a> {
    mesh: &'a TriMesh,
    vertices: &'a [u32],
    faces: FxHashMap<[u32; 3], u32>,
    half_edges: FxHashMap<[u32; 2], u32>,
    corner_at: Vec<u32>,
}

impl<'a> Images<'a> {
    fn new(mesh: &'a TriMesh, vertices: &'a [u32]) -> Self {
        let (mut faces, mut half_edges) = (FxHashMap::default(), FxHashMap::default());
        let mut corner_at = vec![0; mesh.positions().len()];
        // In reverse order, so that the first of several faces stays.
        for (f, face) in (0..mesh.faces().len() as u32).zip(mesh.faces()).rev() {
            faces.insert(ascending(*face), f);
            for k in 0..3 {
                half_edges.insert([face[k], face[(k + 1) % 3]], 3 * f + k as u32);
                corner_at[face[k] as usize] = 3 * f + k as u32;
            }
        }
        Self { mesh, vertices, faces, half_edges, corner_at }
    }

    fn image_of_face(&self, f: u32) -> [u32; 3] {
        self.mesh.faces()[f as usize].map(|v| self.vertices[v as usize])
    }

    /// Finds corners at the images of a face's corners, on its image face if that exists.
    fn corners(&self, f: u32) -> [u32; 3] {
        let image = self.image_of_face(f);
        let whole = self.faces.get(&ascending(image)).copied();
        std::array::from_fn(|k| {
            // The image is wound the other way, so its edges run backwards.
            let beside = [[image[(k + 1) % 3], image[k]], [image[k], image[(k + 2) % 3]]];
            let over_edge = || beside.iter().find_map(|edge| self.half_edges.get(edge)).map(|&half_edge| half_edge / 3);
            let face = whole.or_else(over_edge);
            let corner = face.and_then(|face| self.corner_of(face, image[k]));
            corner.unwrap_or(self.corner_at[image[k] as usize])
        })
    }

    fn corner_of(&self, face: u32, v: u32) -> Option<u32> {
        self.mesh.faces()[face as usize].iter().position(|&w| w == v).map(|k| 3 * face + k as u32)
    }
}
