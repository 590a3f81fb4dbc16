//! Features of a triangle's nearest points and triangles.

use super::network::{POINT_NUMBERS, TRIANGLE_NUMBERS};
use super::{Candidates, LocalFrame};
use neural_mesh::linalg::Matrix;
use neural_mesh::parallel;
use neural_mesh::spatial::{nearest_neighbours, nearest_to};

/// Nearest points and nearest triangles per triangle.
pub const NEIGHBOURS: usize = 64;

/// Nearest points and triangles of all candidates.
#[derive(Clone, Debug, PartialEq)]
pub struct CandidateNeighbourhoods<'a> {
    /// Vertices, n_vertices x 3.
    pub vertices: &'a [[f32; 3]],
    /// Candidates, n.
    pub candidates: &'a Candidates,
    /// Nearest points, n x `n_points`.
    pub points: Vec<u32>,
    /// Points per candidate: 64, or all.
    pub n_points: usize,
    /// Nearest other triangles, n x `n_triangles`.
    pub triangles: Vec<u32>,
    /// Triangles per candidate: 64, or all others.
    pub n_triangles: usize,
}

impl<'a> CandidateNeighbourhoods<'a> {
    /// Finds the neighbourhoods of all candidates.
    pub fn new(vertices: &'a [[f32; 3]], candidates: &'a Candidates) -> Self {
        let triangles = &candidates.triangles;
        let barycenter = |&triangle: &[u32; 3]| {
            let corners = corners(vertices, triangle);
            std::array::from_fn(|axis| corners.iter().map(|corner| corner[axis]).sum::<f32>() / 3.0)
        };
        let barycenters: Vec<[f32; 3]> = triangles.iter().map(barycenter).collect();
        Self {
            vertices,
            candidates,
            points: nearest_to(vertices, &barycenters, NEIGHBOURS),
            n_points: NEIGHBOURS.min(vertices.len()),
            triangles: nearest_neighbours(&barycenters, NEIGHBOURS),
            n_triangles: NEIGHBOURS.min(triangles.len().saturating_sub(1)),
        }
    }

    /// Returns the nearest points of a candidate.
    pub fn nearest_points(&self, candidate: usize) -> &[u32] {
        &self.points[candidate * self.n_points..][..self.n_points]
    }

    /// Returns the nearest triangles of a candidate.
    pub fn nearest_triangles(&self, candidate: usize) -> &[u32] {
        &self.triangles[candidate * self.n_triangles..][..self.n_triangles]
    }
}

/// Computes the features of points in the frames of their triangles.
///
/// # Shapes
/// - `queries`: n triangles with k points each; the corner order decides the frame
/// - returns (n * k) x 6, see [`LocalFrame::coordinates`]
pub fn point_features(vertices: &[[f32; 3]], queries: &[([u32; 3], &[u32])]) -> Matrix {
    let k = queries.first().map_or(0, |(_, points)| points.len());
    let mut features = vec![0.0; queries.len() * k * POINT_NUMBERS];
    parallel::rows_mut(&mut features, k * POINT_NUMBERS, 64, |query, rows| {
        let (triangle, points) = &queries[query];
        let frame = LocalFrame::new(corners(vertices, *triangle));
        for (row, &point) in rows.as_chunks_mut().0.iter_mut().zip(*points) {
            *row = frame.coordinates(vertices[point as usize]);
        }
    });
    Matrix::new(queries.len() * k, POINT_NUMBERS, features)
}

/// Computes the features of triangles near each query.
///
/// # Shapes
/// - `queries`: n candidates
/// - returns (n * n_triangles) x 13: least and largest coordinates of the corners, probability
pub fn triangle_features(neighbourhoods: &CandidateNeighbourhoods, queries: &[u32]) -> Matrix {
    let (vertices, candidates, k) = (neighbourhoods.vertices, neighbourhoods.candidates, neighbourhoods.n_triangles);
    let mut features = vec![0.0; queries.len() * k * TRIANGLE_NUMBERS];
    parallel::rows_mut(&mut features, k * TRIANGLE_NUMBERS, 64, |at, rows| {
        let query = queries[at] as usize;
        let frame = LocalFrame::new(corners(vertices, candidates.triangles[query]));
        let near = neighbourhoods.nearest_triangles(query);
        for (row, &other) in rows.chunks_exact_mut(TRIANGLE_NUMBERS).zip(near) {
            let seen = corners(vertices, candidates.triangles[other as usize]).map(|p| frame.coordinates(p));
            for c in 0..POINT_NUMBERS {
                row[c] = seen[0][c].min(seen[1][c]).min(seen[2][c]);
                row[POINT_NUMBERS + c] = seen[0][c].max(seen[1][c]).max(seen[2][c]);
            }
            row[2 * POINT_NUMBERS] = candidates.probabilities[other as usize];
        }
    });
    Matrix::new(queries.len() * k, TRIANGLE_NUMBERS, features)
}

pub(super) fn corners(vertices: &[[f32; 3]], triangle: [u32; 3]) -> [[f32; 3]; 3] {
    triangle.map(|v| vertices[v as usize])
}
