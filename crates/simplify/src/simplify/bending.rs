//! Vertex scores by a formula: larger where the surface bends more.

use crate::linalg::{Csr, rounded};
use glam::Vec3;

const EXPONENT: f32 = 0.5;
/// Largest ratio between a vertex's bending and the mean, either way.
// The exponential of a score is then between 1 / 5.5 and 5.5.
const MOST_RATIO: f32 = 30.0;

/// Computes each vertex's score `ln(b / mean b) / 2` from its bending `b`; `None` if the whole surface is flat.
///
/// `b` is the largest change of the unit normal per length over a vertex's edges, averaged by area over its one-ring.
///
/// # Shapes
/// - `points`: n x 3, from [`in_edge_lengths`](crate::model::in_edge_lengths); `normals`: n x 3, unit vectors
/// - `areas`: n, `rings`: n x n, the edges
/// - returns n scores
///
/// # Panics
/// If the arguments differ in n.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::shapes, model::in_edge_lengths};
/// use neural_mesh::simplify::{bending_scores, edge_graph, vertex_areas, vertex_normals};
/// let flat = shapes::grid(4, 4);
/// let rings = edge_graph(&flat);
/// let points = in_edge_lengths(flat.positions(), &rings);
/// assert_eq!(bending_scores(&points, &vertex_normals(&flat), &vertex_areas(&flat), &rings), None);
/// ```
pub fn bending_scores(points: &[[f32; 3]], normals: &[[f32; 3]], areas: &[f64], rings: &Csr) -> Option<Vec<f32>> {
    let distance = |rows: &[[f32; 3]], v: usize, w: u32| Vec3::from(rows[v]).distance(rows[w as usize].into());
    let largest_bend = |v: usize| {
        let along = |&w: &u32| distance(normals, v, w) / distance(points, v, w).max(1e-6);
        rings.row(v).iter().map(along).fold(0.0, f32::max)
    };
    // One round of averaging damps the noise of single edges.
    let raw: Vec<f64> = (0..points.len()).map(|v| f64::from(largest_bend(v))).collect();
    let average = |v: usize| {
        let around = std::iter::once(v).chain(rings.row(v).iter().map(|&w| w as usize));
        let (sum, area) = around.fold((0.0, 0.0), |(sum, area), w| (sum + areas[w] * raw[w], area + areas[w]));
        if area > 0.0 { sum / area } else { raw[v] }
    };
    let smooth: Vec<f64> = (0..points.len()).map(average).collect();
    let mean = smooth.iter().zip(areas).map(|(b, area)| b * area).sum::<f64>() / areas.iter().sum::<f64>();
    let log = |b: &f64| EXPONENT * rounded::ln(((b / mean) as f32).clamp(1.0 / MOST_RATIO, MOST_RATIO));
    (mean > 0.0 && mean.is_finite()).then(|| smooth.iter().map(log).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::{edge_graph, vertex_areas, vertex_normals};

    #[test]
    fn the_formula_asks_for_edges_and_is_silent_on_planes() {
        let mesh = shapes::cuboid([1.0; 3], 8);
        let (normals, areas, rings) = (vertex_normals(&mesh), vertex_areas(&mesh), edge_graph(&mesh));
        let wanted = bending_scores(mesh.positions(), &normals, &areas, &rings).unwrap();
        let middle = mesh.positions().iter().position(|p| p[0] == 0.5 && p[1] == 0.5).unwrap();
        let corner = mesh.positions().iter().position(|p| *p == [0.0; 3]).unwrap();
        assert_eq!(wanted[middle], EXPONENT * (1.0 / MOST_RATIO).ln());
        assert!(wanted[corner] > 0.2);
        let flat = shapes::grid(5, 5);
        let (normals, areas, rings) = (vertex_normals(&flat), vertex_areas(&flat), edge_graph(&flat));
        assert_eq!(bending_scores(flat.positions(), &normals, &areas, &rings), None);
    }
}
