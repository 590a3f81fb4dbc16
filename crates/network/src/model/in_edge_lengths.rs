//! The network's unit of length: the mean edge length of its graph.
//!
//! The paper's unit is the diagonal of the bounding box.

use crate::linalg::Csr;
use glam::DVec3;

/// A translation followed by a scaling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeFrame {
    /// The point moved to the origin.
    pub centre: [f64; 3],
    /// Factor by which lengths are multiplied, above 0.
    pub scale: f64,
}

impl EdgeFrame {
    /// Returns the frame with the mean of `points` at the origin and mean edge length 1.
    ///
    /// The scale is 1 if all edges have length 0.
    ///
    /// # Shapes
    /// - `graph`: n x n, symmetric; loops are ignored
    pub fn new<P: Copy + Into<[f32; 3]>>(points: &[P], graph: &Csr) -> Self {
        assert_eq!(points.len(), graph.n_rows(), "one row per point");
        let point = |v: usize| DVec3::from(points[v].into().map(f64::from));
        let (mut sum, mut lengths, mut n_edges) = (DVec3::ZERO, 0.0, 0);
        for i in 0..points.len() {
            let p = point(i);
            sum += p;
            // Rows ascend. Each edge is visited once, at its smaller end.
            for &j in graph.row(i).iter().rev().take_while(|&&j| j as usize > i) {
                lengths += p.distance(point(j as usize));
                n_edges += 1;
            }
        }
        let centre = (sum / points.len().max(1) as f64).to_array();
        Self { centre, scale: if lengths > 0.0 { f64::from(n_edges) / lengths } else { 1.0 } }
    }

    /// Transforms points into this frame.
    pub fn apply<P: Copy + Into<[f32; 3]>>(&self, points: &[P]) -> Vec<[f32; 3]> {
        let centre = DVec3::from(self.centre);
        let moved = |&p: &P| ((DVec3::from(p.into().map(f64::from)) - centre) * self.scale).as_vec3().to_array();
        points.iter().map(moved).collect()
    }
}

/// Moves the mean of points to the origin and scales the edges of `graph` to mean length 1.
///
/// # Shapes
/// - `graph`: n x n, symmetric
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::{linalg::Csr, model::in_edge_lengths};
/// let path = Csr::from_edges(3, [[0, 1], [1, 2]]);
/// let points = in_edge_lengths(&[[10.0, 0.0, 0.0], [13.0, 4.0, 0.0], [16.0, 8.0, 0.0]], &path);
/// assert_eq!(points, [[-0.6, -0.8, 0.0], [0.0; 3], [0.6, 0.8, 0.0]]);
/// ```
pub fn in_edge_lengths<P: Copy + Into<[f32; 3]>>(points: &[P], graph: &Csr) -> Vec<[f32; 3]> {
    EdgeFrame::new(points, graph).apply(points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::random;

    #[test]
    fn a_finer_unit_changes_nothing() {
        let points: Vec<[f32; 3]> = random(20, 3, 1).data().as_chunks().0.to_vec();
        let graph = Csr::from_edges(20, (0..20).flat_map(|i| [[i, (i + 1) % 20], [i, (i + 7) % 20]]));
        let large: Vec<[f32; 3]> = points.iter().map(|p| p.map(|x| 64.0 * x)).collect();
        assert_eq!(in_edge_lengths(&points, &graph), in_edge_lengths(&large, &graph));
        assert_eq!(in_edge_lengths(&points, &graph), in_edge_lengths(&points, &graph.with_loops()));
    }

    #[test]
    fn without_lengths_the_scale_stays() {
        assert_eq!(in_edge_lengths(&[[7.0; 3]; 3], &Csr::from_edges(3, [[0, 1]])), [[0.0; 3]; 3]);
        assert_eq!(
            in_edge_lengths(&[[0.0; 3], [2.0, 0.0, 0.0]], &Csr::from_edges(2, [])),
            [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
        );
    }
}
