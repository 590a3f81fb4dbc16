//! Loss terms of the face probabilities, Eqs. (7) to (10).

use super::Settings;
use super::sampled_mesh::{CandidateGraph, SampledMesh};
use crate::linalg::Csr;
use crate::loss::{self, FaceObjective, NamedTerm, face_geometry};
use crate::mesh::TriMesh;
use crate::mesh::surface_samples::surface_samples;
use crate::model::barycenters;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// Points drawn on the original surface per sample, to measure the coverage.
const POINTS_PER_SAMPLE: usize = 4;

pub(super) struct FaceContext<'a> {
    pub mesh: &'a TriMesh,
    pub drawn: &'a SampledMesh,
    pub candidates: &'a CandidateGraph,
}

pub(super) fn face_terms(
    faces: &FaceContext,
    probabilities: &[f32],
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Vec<NamedTerm> {
    let FaceContext { mesh, drawn, candidates } = faces;
    let triangles = &candidates.faces.triangles;
    let quotient_triangles = &drawn.quotient_triangles;
    let labels: Vec<bool> =
        triangles.iter().map(|triangle| quotient_triangles.binary_search(triangle).is_ok()).collect();
    let surface = surface_points(mesh, POINTS_PER_SAMPLE * drawn.points.len(), random.next_u64());
    let judged = loss::Candidates {
        points: &drawn.points,
        triangles,
        edges: &candidates.faces.entries,
        at_boundary: &boundary_entries(quotient_triangles, &candidates.extended),
        labels: &labels,
        original_barycenters: &drawn.frame.apply(&barycenters(mesh.positions(), mesh.faces())),
        surface: &drawn.frame.apply(&surface),
    };
    let objective = objective(settings);
    loss::face_terms(&judged, &face_geometry(&judged, &objective), &objective, probabilities)
}

pub(super) fn has_face_terms(settings: &Settings) -> bool {
    let FaceObjective { forward, reverse, coverage, closure, collision, crossing, overlap, agreement, .. } =
        objective(settings);
    [forward, reverse, coverage, closure, collision, crossing, overlap, agreement].iter().any(|&weight| weight != 0.0)
}

fn objective(settings: &Settings) -> FaceObjective {
    let (literal, trained) = if settings.literal { (1.0, 0.0) } else { (0.0, 1.0) };
    FaceObjective {
        forward: settings.lambda_forward,
        reverse: literal * settings.lambda_reverse,
        coverage: trained * settings.lambda_coverage,
        closure: settings.lambda_closure,
        collision: settings.lambda_collision,
        crossing: settings.lambda_crossings,
        overlap: settings.lambda_overlap,
        agreement: settings.lambda_agreement,
        by_count: settings.literal,
        ..FaceObjective::TRAINED
    }
}

fn surface_points(mesh: &TriMesh, n: usize, seed: u64) -> Vec<[f32; 3]> {
    surface_samples(mesh, n, seed).iter().map(|sample| sample.point(mesh).as_vec3().to_array()).collect()
}

/// Returns for each entry of G_ext whether exactly one quotient triangle has this edge.
fn boundary_entries(quotient_triangles: &[[u32; 3]], extended: &Csr) -> Vec<bool> {
    let mut counts = vec![0u32; extended.n_entries()];
    for &[i, j, k] in quotient_triangles {
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
    fn boundaries_are_edges_of_one_spanned_triangle() {
        let graph = Csr::from_edges(4, [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3], [0, 3]]);
        let found = boundary_entries(&[[0, 1, 2], [1, 2, 3]], &graph);
        let is_boundary = |i: usize, j: u32| found[graph.position(i, j).unwrap()];
        assert!(is_boundary(0, 1) && is_boundary(0, 2) && is_boundary(1, 3) && is_boundary(2, 3));
        assert!(!is_boundary(1, 2) && !is_boundary(0, 3));
    }
}
