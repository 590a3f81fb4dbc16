//! Noise on the vertices of a step, whose samples are measured by the mesh without it.

use super::random::{normal_pair, uniform};
use crate::mesh::{InvalidMesh, TriMesh};
use glam::Vec3;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Moves all vertices by normal noise in half of all cases; its deviation is drawn between 0 and `most` mean edge lengths.
pub(super) fn roughen(mesh: &TriMesh, most: f64, random: &mut Xoshiro256PlusPlus) -> Result<TriMesh, InvalidMesh> {
    let mut positions = mesh.positions().to_vec();
    let share = (2.0 * uniform(random) - 1.0).max(0.0);
    let deviation = most * share * mean_edge_length(&positions, mesh.faces());
    for pair in positions.as_flattened_mut().chunks_mut(2) {
        let normals = normal_pair(random);
        pair.iter_mut().zip(normals).for_each(|(x, normal)| *x += (deviation * normal) as f32);
    }
    TriMesh::new(positions, mesh.faces().to_vec())
}

pub(super) fn mean_edge_length(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> f64 {
    let point = |v: u32| Vec3::from(positions[v as usize]).as_dvec3();
    let edges = faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.map(|[a, b]| point(a).distance(point(b))).sum::<f64>() / (3 * faces.len()).max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use rand_xoshiro::rand_core::SeedableRng;

    #[test]
    fn vertices_move_by_at_most_the_deviation_on_average() {
        let mesh = shapes::icosphere(4);
        let length = mean_edge_length(mesh.positions(), mesh.faces());
        let deviations = (0..40).map(|seed| {
            let noisy = roughen(&mesh, 0.5, &mut Xoshiro256PlusPlus::seed_from_u64(seed)).unwrap();
            let pairs = noisy.positions().as_flattened().iter().zip(mesh.positions().as_flattened());
            let squares: Vec<f64> = pairs.map(|(a, b)| f64::from(a - b).powi(2)).collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() / length
        });
        let deviations: Vec<f64> = deviations.collect();
        assert!(deviations.iter().all(|&deviation| deviation < 0.52));
        assert!((deviations.iter().sum::<f64>() / 40.0 - 0.125).abs() < 0.05, "{deviations:?}");
        assert!((10..30).contains(&deviations.iter().filter(|&&deviation| deviation == 0.0).count()));
        let clean = roughen(&mesh, 0.0, &mut Xoshiro256PlusPlus::seed_from_u64(1)).unwrap();
        assert_eq!(clean.positions(), mesh.positions());
    }
}
