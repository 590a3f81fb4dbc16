//! What the probabilities of the faces are judged by, Eqs. (7) to (10), in the printed forms or those that train.

use super::Settings;
use super::paper_step::{Candidates, Drawn, Sum};
use crate::linalg::Csr;
use crate::loss::{
    OverlapSettings, closure, collisions, conflicts_by_count, conflicts_by_pair, coverage, edge_crossings,
    forward_distance, forward_distances, near_triangles, overlaps, quotient_agreement, reverse_distance,
    reverse_distances,
};
use crate::mesh::TriMesh;
use crate::mesh::surface_samples::surface_samples;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// Points of the original surface per sample at which the coverage is measured.
const POINTS_PER_SAMPLE: usize = 4;
/// Candidates looked at from each of them.
const NEAR: usize = 24;
/// What a point that nothing covers costs at least: a squared length, in edges between samples.
const UNCOVERED: f64 = 1.0;
/// Points on every triangle, and triangles near each, for Eq. (8): the paper's numbers in training.
const REVERSE: (usize, usize) = (10, 20);
/// How far out of the plane two edges or triangles may pass and still be in conflict, in their own sizes.
const FLATNESS: f64 = 0.1;
/// Points on each triangle with which overlaps are found.
const OVERLAP_POINTS: usize = 10;

/// What the terms look at.
pub(super) struct Faces<'a> {
    /// The original.
    pub mesh: &'a TriMesh,
    /// The samples.
    pub drawn: &'a Drawn,
    /// The faces that have probabilities.
    pub candidates: &'a Candidates,
}

/// The terms of the probabilities, and the gradient of their sum to them.
pub(super) fn face_terms(
    faces: &Faces,
    p: &[f32],
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> (Vec<(&'static str, f64)>, Vec<f32>) {
    let Faces { mesh, drawn, candidates } = faces;
    let (points, triangles) = (&drawn.points, &candidates.faces.triangles);
    let neighbours = &candidates.neighbours;
    let seed = random.next_u64();
    let mut sum = Sum::new(p.len());
    sum.add("forward", settings.lambda_forward, || {
        forward_distance(&forward_distances(points, triangles, &drawn.frame.apply(&barycenters(mesh))), p)
    });
    match settings.literal {
        true => sum.add("reverse", settings.lambda_reverse, || {
            let original = drawn.frame.apply(mesh.positions());
            reverse_distance(&reverse_distances(points, triangles, &original, REVERSE.0, REVERSE.1), p)
        }),
        false => sum.add("coverage", settings.lambda_coverage, || {
            let surface = surface_points(mesh, POINTS_PER_SAMPLE * points.len(), seed);
            coverage(&near_triangles(points, triangles, &drawn.frame.apply(&surface), NEAR), UNCOVERED, p)
        }),
    }
    let conflicts = if settings.literal { conflicts_by_count } else { conflicts_by_pair };
    sum.add("collision", settings.lambda_collision, || conflicts(&collisions(points, triangles, neighbours), p));
    sum.add("crossings", settings.lambda_crossings, || {
        conflicts(&edge_crossings(points, triangles, neighbours, FLATNESS), p)
    });
    sum.add("overlap", settings.lambda_overlap, || {
        let how = OverlapSettings { per_triangle: OVERLAP_POINTS, flatness: FLATNESS };
        conflicts(&overlaps(points, triangles, neighbours, how), p)
    });
    sum.add("closure", settings.lambda_closure, || {
        closure(&candidates.faces.entries, &at_border(&drawn.quotient.triangles, &candidates.extended), p)
    });
    sum.add("agreement", settings.lambda_agreement, || {
        let spanned = triangles.iter().map(|triangle| drawn.quotient.triangles.binary_search(triangle).is_ok());
        quotient_agreement(&spanned.collect::<Vec<_>>(), 1.0, p)
    });
    (sum.terms, sum.gradient)
}

/// The barycenter of each face of the original, n_faces x 3.
fn barycenters(mesh: &TriMesh) -> Vec<[f32; 3]> {
    let mean = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| mesh.positions()[v as usize]);
        [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0)
    };
    mesh.faces().iter().map(mean).collect()
}

fn surface_points(mesh: &TriMesh, n: usize, seed: u64) -> Vec<[f32; 3]> {
    surface_samples(mesh, n, seed).iter().map(|sample| sample.point(mesh).as_vec3().to_array()).collect()
}

/// For each entry of G_ext whether one face is right there: where the mesh spans one triangle between the regions.
fn at_border(spanned: &[[u32; 3]], extended: &Csr) -> Vec<bool> {
    let mut counts = vec![0u32; extended.n_entries()];
    for &[i, j, k] in spanned {
        for (from, to) in [(i, j), (i, k), (j, k)] {
            if let Some(at) = extended.position(from as usize, to) {
                counts[at] += 1;
            }
        }
    }
    counts.into_iter().map(|count| count == 1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_are_edges_of_one_spanned_triangle() {
        let graph = Csr::from_edges(4, [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3], [0, 3]]);
        let found = at_border(&[[0, 1, 2], [1, 2, 3]], &graph);
        let is_border = |i: usize, j: u32| found[graph.position(i, j).unwrap()];
        assert!(is_border(0, 1) && is_border(0, 2) && is_border(1, 3) && is_border(2, 3));
        assert!(!is_border(1, 2) && !is_border(0, 3));
    }
}
