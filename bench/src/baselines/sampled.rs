//! Sampled vertices meshed by ball pivoting.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::ball_pivoting;
use anyhow::Result;
use neural_mesh::mesh::{TriMesh, compact, vertex_normals};
use neural_mesh::spatial::farthest_points;

pub(super) fn farthest_ball_pivoting(mesh: &TriMesh, n_vertices: usize, seed: u64) -> Result<TriMesh> {
    let (mesh, _) = compact(mesh.positions(), mesh.faces().to_vec())?;
    let first = uniform_points(mesh.positions().len(), 1, seed);
    let samples = first.first().map_or(Vec::new(), |&first| farthest_points(mesh.positions(), n_vertices, first));
    mesh_samples(&mesh, samples)
}

pub(super) fn uniform_ball_pivoting(mesh: &TriMesh, n_vertices: usize, seed: u64) -> Result<TriMesh> {
    let (mesh, _) = compact(mesh.positions(), mesh.faces().to_vec())?;
    mesh_samples(&mesh, uniform_points(mesh.positions().len(), n_vertices, seed))
}

fn uniform_points(n: usize, k: usize, seed: u64) -> Vec<u32> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    // Only the first k places of a shuffle (Fisher and Yates) are drawn.
    let mut points: Vec<u32> = (0..n as u32).collect();
    for i in 0..k.min(n) {
        // The upper half of the 128-bit product is a number below n - i, equal on every machine.
        let offset = (u128::from(rng.next_u64()) * (n - i) as u128) >> 64;
        points.swap(i, i + offset as usize);
    }
    points.truncate(k);
    points
}

fn mesh_samples(mesh: &TriMesh, mut samples: Vec<u32>) -> Result<TriMesh> {
    samples.sort_unstable();
    let [points, normals] = points_and_normals(mesh, &samples);
    Ok(compact(&points, ball_pivoting(&points, &normals))?.0)
}

/// Returns positions and normals of some vertices, n x 3 each.
pub(crate) fn points_and_normals(mesh: &TriMesh, samples: &[u32]) -> [Vec<[f32; 3]>; 2] {
    let normals = vertex_normals(mesh);
    [mesh.positions(), &normals].map(|rows| samples.iter().map(|&v| rows[v as usize]).collect())
}
