//! The distances that the page paints: from every vertex of a mesh to the surface of another.

use neural_mesh::geometry::triangle::area_normal_f64;
use neural_mesh::mesh::TriMesh;
use neural_mesh::spatial::NearestOnTriangles;
use rayon::prelude::*;
use serde::Serialize;

/// Distances between an original and a result, in the mesh's unit.
pub struct Distances {
    /// From the result's vertices to the original.
    pub of_result: Vec<f32>,
    /// From the original's vertices to the result.
    pub of_original: Vec<f32>,
}

/// Where the colours may end, in the mesh's unit: over the surfaces of all pairs, each of the same weight, a vertex
/// standing for its share of the area.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Scale {
    /// Exceeded on a twentieth of the surface.
    pub p95: f32,
    /// Exceeded on a hundredth of the surface.
    pub p99: f32,
    /// The largest distance.
    pub max: f32,
}

/// A mesh made ready for nearest points.
pub fn surface(mesh: &TriMesh) -> NearestOnTriangles {
    let corners: Vec<_> = mesh.faces().iter().map(|face| face.map(|v| mesh.positions()[v as usize])).collect();
    NearestOnTriangles::new(&corners)
}

/// Distance of every vertex of a mesh from a surface, n_vertices.
pub fn distances(mesh: &TriMesh, surface: &NearestOnTriangles) -> Vec<f32> {
    let distance = |p: &[f32; 3]| {
        let nearest = surface.nearest(p.map(f64::from).into());
        nearest.map_or(0.0, |hit| hit.distance2.sqrt() as f32)
    };
    mesh.positions().par_iter().map(distance).collect()
}

/// Share of the mesh's area that each vertex stands for, a third of each face around it, n_vertices; all alike where
/// there is no area.
pub fn area_shares(mesh: &TriMesh) -> Vec<f64> {
    let mut shares = vec![0.0; mesh.positions().len()];
    for face in mesh.faces() {
        let area = area_normal_f64(face.map(|v| mesh.positions()[v as usize].map(f64::from).into())).length();
        face.iter().for_each(|&v| shares[v as usize] += area);
    }
    let total: f64 = shares.iter().sum();
    let even = 1.0 / shares.len().max(1) as f64;
    shares.iter().map(|area| if total > 0.0 { area / total } else { even }).collect()
}

/// The scale of distances, each with the share that it stands for.
pub fn scale(mut weighed: Vec<(f32, f64)>) -> Scale {
    weighed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let total: f64 = weighed.iter().map(|(_, share)| share).sum();
    let below = |part: f64| {
        let mut sum = 0.0;
        let reached = weighed.iter().find(|(_, share)| {
            sum += share;
            sum >= part * total
        });
        reached.map_or(0.0, |&(distance, _)| distance)
    };
    let max = weighed.last().map_or(0.0, |&(distance, _)| distance);
    Scale { p95: below(0.95), p99: below(0.99), max }
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn vertices_of_a_sphere_are_off_another_by_the_difference_of_radii() {
        let sphere = shapes::icosphere(3);
        let double = sphere.positions().iter().map(|p| p.map(|x| 2.0 * x)).collect();
        let double = TriMesh::new(double, sphere.faces().to_vec()).unwrap();
        let found = distances(&double, &surface(&sphere));
        assert_eq!(found.len(), double.positions().len());
        assert!(found.iter().all(|d| (d - 1.0).abs() < 0.01), "{found:?}");
    }

    #[test]
    fn the_scale_counts_area_not_vertices() {
        let even = |i: u32| (i as f32, 1.0);
        assert_eq!(scale((1..=1000).map(even).collect()), Scale { p95: 950.0, p99: 990.0, max: 1000.0 });
        let heavy = vec![(3.0, 1.0), (1.0, 96.0), (2.0, 3.0)];
        assert_eq!(scale(heavy), Scale { p95: 1.0, p99: 2.0, max: 3.0 });
        assert_eq!(scale(Vec::new()), Scale::default());
    }

    #[test]
    fn vertices_share_the_area_of_their_faces() {
        let corners = vec![[0.0; 3], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [3.0, 3.0, 0.0]];
        let mesh = TriMesh::new(corners, vec![[0, 1, 2], [1, 3, 2]]).unwrap();
        let shares = area_shares(&mesh);
        let wanted = [3.0, 12.0, 12.0, 9.0].map(|doubled| doubled / 36.0);
        assert!(shares.iter().zip(wanted).all(|(share, wanted)| (share - wanted).abs() < 1e-12), "{shares:?}");
        let point = TriMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        assert_eq!(area_shares(&point), [1.0 / 3.0; 3]);
    }
}
