//! Original and results as numbers for a page.

use neural_mesh::mesh::{TriMesh, irregular_edges};
use neural_mesh::metrics::{ColourScale, PaintedMesh, colour_scale};
use neural_mesh::spatial::NearestOnTriangles;

use super::packed::Packed;
use super::surface_data::SurfaceData;

/// Distances from sample points of an original to a result, and the reverse.
pub struct Distances {
    of_result: Vec<f32>,
    of_original: Vec<f32>,
}

impl Distances {
    /// Measures the distances; each mesh comes with its search structure.
    pub fn new(original: (&TriMesh, &NearestOnTriangles), result: (&TriMesh, &NearestOnTriangles)) -> Self {
        Self {
            of_result: PaintedMesh::new(result.0).distances_to(original.1),
            of_original: PaintedMesh::new(original.0).distances_to(result.1),
        }
    }

    /// Packs the distances as shares of the distance `max`.
    pub fn pack(&self, original: &SurfaceData, result: &SurfaceData, max: f32) -> String {
        let mut values = Packed::default();
        result.pack_values(&mut values, &self.of_result, max);
        original.pack_values(&mut values, &self.of_original, max);
        values.text()
    }
}

/// Returns one colour scale for the distances of all results of an original, each with equal weight.
pub fn common_colour_scale<'a>(
    original: &TriMesh,
    pairs: impl IntoIterator<Item = (&'a TriMesh, &'a Distances)>,
) -> ColourScale {
    let shares_of_original = PaintedMesh::new(original).shares();
    let mut weighed = Vec::new();
    for (result, pair) in pairs {
        weighed.extend(pair.of_result.iter().copied().zip(PaintedMesh::new(result).shares()));
        weighed.extend(pair.of_original.iter().copied().zip(shares_of_original.iter().copied()));
    }
    colour_scale(weighed)
}

/// Packs a mesh, with its open, non-manifold and turned edges, which the page colours.
pub fn pack_surface(mesh: &TriMesh) -> SurfaceData {
    SurfaceData::new(mesh, &irregular_edges(mesh), PaintedMesh::new(mesh).steps)
}
