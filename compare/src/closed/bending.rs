//! An importance made by a formula, from how much the surface bends: what learned scores have to beat.

use glam::DVec3;
use neural_mesh::linalg::Csr;
use neural_mesh::mesh::TriMesh;
use neural_mesh::simplify::{edge_graph, vertex_areas, vertex_normals};

/// Bending beyond this many times the mean, either way, counts as if it were not.
const MOST: f64 = 10.0;

/// The square root of the bending about each vertex over its mean by area: the largest turn of the normal per length along
/// the edges of a vertex, averaged once over it and its neighbours. All ones where nothing bends.
pub fn bending_importance(mesh: &TriMesh) -> Vec<f32> {
    let (rings, areas) = (edge_graph(mesh), vertex_areas(mesh));
    let raw = largest_turns(mesh, &rings);
    let average = |of: &[usize]| -> Option<f64> {
        let area: f64 = of.iter().map(|&w| areas[w]).sum();
        (area > 0.0).then(|| of.iter().map(|&w| areas[w] * raw[w]).sum::<f64>() / area)
    };
    let around = |v: usize| -> Vec<usize> { [v].into_iter().chain(neighbors(&rings, v)).collect() };
    let smooth: Vec<f64> = (0..raw.len()).map(|v| average(&around(v)).unwrap_or(raw[v])).collect();
    let total: f64 = areas.iter().sum();
    let mean = smooth.iter().zip(&areas).map(|(bending, area)| bending * area).sum::<f64>() / total;
    if !(mean > 0.0 && mean.is_finite()) {
        return vec![1.0; raw.len()];
    }
    smooth.iter().map(|bending| (bending / mean).clamp(1.0 / MOST, MOST).sqrt() as f32).collect()
}

/// The largest turn of the normal per length along the edges of each vertex.
fn largest_turns(mesh: &TriMesh, rings: &Csr) -> Vec<f64> {
    let double = |rows: &[[f32; 3]]| -> Vec<DVec3> { rows.iter().map(|p| DVec3::from(p.map(f64::from))).collect() };
    let (points, normals) = (double(mesh.positions()), double(&vertex_normals(mesh)));
    let turn = |v: usize, w: usize| {
        let length = points[v].distance(points[w]);
        if length > 0.0 { normals[v].distance(normals[w]) / length } else { 0.0 }
    };
    (0..points.len()).map(|v| neighbors(rings, v).map(|w| turn(v, w)).fold(0.0, f64::max)).collect()
}

fn neighbors(rings: &Csr, v: usize) -> impl Iterator<Item = usize> {
    rings.row(v).iter().map(|&w| w as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn edges_count_more_than_planes() {
        let mesh = shapes::cuboid([1.0; 3], 8);
        let importance = bending_importance(&mesh);
        let at = |wanted: [f32; 3]| mesh.positions().iter().position(|&p| p == wanted).unwrap();
        assert!((importance[at([0.5, 0.5, 0.0])] - 0.1f32.sqrt()).abs() < 1e-6);
        assert!(importance[at([0.0; 3])] > 1.2);
        assert!(bending_importance(&shapes::grid(5, 5)).iter().all(|&x| x == 1.0));
    }
}
