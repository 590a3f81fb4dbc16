//! Transfer of values to the original's vertices by closest points.

use glam::DVec3;

use crate::along_surface::laplacian::Laplacian;
use neural_mesh::mesh::TriMesh;
use neural_mesh::parallel;
use neural_mesh::spatial::NearestOnTriangles;

pub struct ValueTransfer {
    // Indices into the simplified mesh's `Laplacian::vertices`, n x 3.
    corners: Vec<[u32; 3]>,
    weights: Vec<[f64; 3]>,
}

impl ValueTransfer {
    pub fn new(
        points: &[DVec3],
        simplified: &TriMesh,
        laplacian: &Laplacian,
        near: &NearestOnTriangles,
    ) -> Option<Self> {
        let mut place = vec![0; simplified.positions().len()];
        laplacian.vertices.iter().enumerate().for_each(|(at, &v)| place[v as usize] = at as u32);
        let hits = parallel::map(points.len(), 64, |i| near.nearest(points[i]));
        let of_face = |face: u32| simplified.faces()[face as usize].map(|v| place[v as usize]);
        let hits: Vec<_> = hits.into_iter().collect::<Option<_>>()?;
        let (corners, weights) = hits.into_iter().map(|hit| (of_face(hit.triangle), hit.weights)).unzip();
        Some(Self { corners, weights })
    }

    pub fn values(&self, on_simplified: &[f64]) -> Vec<f64> {
        let value = |(corners, weights): (&[u32; 3], &[f64; 3])| {
            let parts = (0..3).filter(|&k| weights[k] > 0.0);
            parts.map(|k| weights[k] * on_simplified[corners[k] as usize]).sum()
        };
        self.corners.iter().zip(&self.weights).map(value).collect()
    }
}
