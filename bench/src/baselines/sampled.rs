//! Vertices drawn from the mesh, and a surface made of them by ball pivoting: what remains without connectivity.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::BaselineError;
use super::ball_pivoting;
use neural_mesh::mesh::{TriMesh, compact, vertex_normals};
use neural_mesh::spatial::farthest_points;

/// Farthest points, the first at random, and balls over them.
pub(super) fn farthest_ball_pivoting(mesh: &TriMesh, n_vertices: usize, seed: u64) -> Result<TriMesh, BaselineError> {
    let (mesh, _) = compact(mesh.positions(), mesh.faces().to_vec())?;
    let first = uniform_points(mesh.positions().len(), 1, seed);
    let samples = first.first().map_or(Vec::new(), |&first| farthest_points(mesh.positions(), n_vertices, first));
    meshed(&mesh, samples)
}

/// Vertices drawn with equal probability, and balls over them.
pub(super) fn uniform_ball_pivoting(mesh: &TriMesh, n_vertices: usize, seed: u64) -> Result<TriMesh, BaselineError> {
    let (mesh, _) = compact(mesh.positions(), mesh.faces().to_vec())?;
    meshed(&mesh, uniform_points(mesh.positions().len(), n_vertices, seed))
}

/// Draws min(k, n) different numbers below n: the first k of a shuffle (Fisher and Yates).
fn uniform_points(n: usize, k: usize, seed: u64) -> Vec<u32> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut points: Vec<u32> = (0..n as u32).collect();
    for i in 0..k.min(n) {
        // The top half of a product of 64 bits: below n - i, the same on every machine.
        let offset = (u128::from(rng.next_u64()) * (n - i) as u128) >> 64;
        points.swap(i, i + offset as usize);
    }
    points.truncate(k);
    points
}

/// The samples in the mesh's order with its normals, meshed.
fn meshed(mesh: &TriMesh, mut samples: Vec<u32>) -> Result<TriMesh, BaselineError> {
    samples.sort_unstable();
    let normals = vertex_normals(mesh);
    let pick = |rows: &[[f32; 3]]| -> Vec<[f32; 3]> { samples.iter().map(|&v| rows[v as usize]).collect() };
    let points = pick(mesh.positions());
    let faces = ball_pivoting(&points, &pick(&normals));
    Ok(compact(&points, faces)?.0)
}
