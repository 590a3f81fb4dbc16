//! Training step of the objective "pointtrinet".

use super::{
    CandidateNeighbourhoods, Candidates, Draw, Proposal, SurfacePoint, classifier, last_candidates, overlap_kernel,
    point_probabilities, proposal_match, proposals, surface_to_triangles, triangle_samples, triangles_to_surface,
    watertightness,
};
use glam::{DVec3, Vec3};
use neural_mesh::autodiff::{Tape, Tensors, Value};
use neural_mesh::linalg::Matrix;
use neural_mesh::loss::Term;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::surface_samples::{SurfaceSample, surface_samples};
use neural_mesh::spatial::{farthest_points, nearest_to};
use neural_mesh::train::random::{random_below, uniform};
use neural_mesh::train::{Settings, StepResult, TrainingItem};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;
use std::sync::Arc;

const PATCH_VERTICES: usize = 256;
const PATCH_SURFACE: usize = 1024;
const PATCH_SHARE: f64 = 0.25;
// Stride: one surface point in ten is compared with the triangles.
const SURFACE_STRIDE: usize = 10;
const SAMPLES: usize = 1000;
// Weight of the overlap loss; the other losses have weight 1.
const OVERLAP: f64 = 0.01;
const RANDOM_SHARE: f32 = 0.25;
// Stride: one candidate in four proposes triangles in the round that learns.
const PROPOSING_STRIDE: usize = 4;

/// Takes one training step on one patch.
pub fn pointtrinet_step(
    tensors: &Tensors<Arc<Matrix>>,
    item: &TrainingItem,
    _: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<StepResult, String> {
    let patch = SurfacePatch::draw(&item.mesh, random).ok_or("has too little surface for a patch")?;
    let draw = Draw { seed: random.next_u64(), random_share: RANDOM_SHARE };
    let candidates = last_candidates(&tensors.constants(), &patch.vertices, draw);
    let mut tape = Tape::default();
    let parameters = tensors.parameters(&mut tape);
    // As in the paper, gradients pass through the last round only.
    let last = LastRound::run(&mut tape, &parameters, &patch, candidates, Draw { seed: random.next_u64(), ..draw });
    let terms = last.terms(&patch, random);
    let [to_queries, to_points] = last.gradients(&terms);
    let gradients = tape.backward(&[(&last.probabilities, to_queries), (&last.of_points, to_points)]);
    Ok(StepResult {
        terms: terms.iter().map(|(name, term)| (*name, term.value)).collect(),
        gradients: parameters.gradients(&gradients),
    })
}

struct SurfacePatch {
    vertices: Vec<[f32; 3]>,
    surface: Vec<SurfacePoint>,
    // Mean distance of the surface points from their mean.
    length: f64,
}

impl SurfacePatch {
    fn draw(mesh: &TriMesh, random: &mut Xoshiro256PlusPlus) -> Option<Self> {
        let [n_vertices, n_surface] = [PATCH_VERTICES, PATCH_SURFACE].map(|n| (n as f64 / PATCH_SHARE) as usize);
        let surface = surface_points(mesh, n_surface, random.next_u64());
        let positions: Vec<[f32; 3]> = surface.iter().map(|at| at.point).collect();
        let dense = |n: usize, seed: u64| -> Vec<[f32; 3]> {
            surface_samples(mesh, n, seed).iter().map(|sample| sample.point(mesh).as_vec3().to_array()).collect()
        };
        // Half of the patches have random vertices, as in the paper, the others farthest points.
        let all = match uniform(random) < 0.5 {
            true => dense(n_vertices, random.next_u64()),
            false => {
                let many = dense(4 * n_vertices, random.next_u64());
                farthest_points(&many, n_vertices, 0).iter().map(|&at| many[at as usize]).collect()
            }
        };
        if all.len() < PATCH_VERTICES || positions.is_empty() {
            return None;
        }
        let center = positions[random_below(random, positions.len())];
        let near = |points: &[[f32; 3]], n: usize| nearest_to(points, &[center], n);
        let vertices = near(&all, PATCH_VERTICES).iter().map(|&at| all[at as usize]).collect();
        let surface: Vec<SurfacePoint> =
            near(&positions, PATCH_SURFACE).iter().map(|&at| surface[at as usize]).collect();
        let length = mean_distance(&surface);
        (length > 0.0).then_some(Self { vertices, surface, length })
    }
}

fn surface_points(mesh: &TriMesh, n: usize, seed: u64) -> Vec<SurfacePoint> {
    let of = |sample: &SurfaceSample| {
        let [a, b, c] = mesh.faces()[sample.face as usize].map(|v| Vec3::from_array(mesh.positions()[v as usize]));
        let normal = (b - a).cross(c - a).normalize_or_zero();
        SurfacePoint { point: sample.point(mesh).as_vec3().to_array(), normal: normal.to_array() }
    };
    surface_samples(mesh, n, seed).iter().map(of).collect()
}

fn mean_distance(surface: &[SurfacePoint]) -> f64 {
    let n = surface.len() as f64;
    let points = || surface.iter().map(|at| DVec3::from_array(at.point.map(f64::from)));
    let mean = points().sum::<DVec3>() / n;
    points().map(|point| point.distance(mean)).sum::<f64>() / n
}

struct LastRound {
    candidates: Candidates,
    probabilities: Value,
    of_points: Value,
    queries: Vec<u32>,
    proposals: Vec<Proposal>,
}

impl LastRound {
    fn run(tape: &mut Tape, tensors: &Tensors<Value>, patch: &SurfacePatch, before: Candidates, draw: Draw) -> Self {
        let neighbourhoods = CandidateNeighbourhoods::new(&patch.vertices, &before);
        let all: Vec<u32> = (0..before.triangles.len() as u32).collect();
        let probabilities = classifier(tape, tensors, &neighbourhoods, &all);
        let first = (draw.seed % PROPOSING_STRIDE as u64) as usize;
        let queries: Vec<u32> = all.into_iter().skip(first).step_by(PROPOSING_STRIDE).collect();
        let of_points = point_probabilities(tape, tensors, &neighbourhoods, &queries);
        let p = probabilities.matrix().data();
        let of_queries: Vec<f32> = queries.iter().map(|&query| p[query as usize]).collect();
        let proposals = proposals(&neighbourhoods, &queries, &of_queries, of_points.matrix().data(), draw);
        let candidates = Candidates { probabilities: p.to_vec(), ..before };
        Self { candidates, probabilities, of_points, queries, proposals }
    }

    fn terms(&self, patch: &SurfacePatch, random: &mut Xoshiro256PlusPlus) -> [(&'static str, Term); 5] {
        let Candidates { triangles, probabilities: p } = &self.candidates;
        let (vertices, length) = (&patch.vertices, patch.length);
        let points: Vec<[f32; 3]> = patch.surface.iter().step_by(SURFACE_STRIDE).map(|at| at.point).collect();
        let everywhere = triangle_samples(vertices, triangles, &vec![1.0; p.len()], SAMPLES, random.next_u64());
        // The last loss has a gradient by the proposals, the others by the candidates.
        let where_likely = triangle_samples(vertices, triangles, p, SAMPLES, random.next_u64());
        [
            ("surface_to_triangles", surface_to_triangles(&points, vertices, triangles, p, length)),
            ("triangles_to_surface", triangles_to_surface(&patch.surface, &everywhere, p, length)),
            ("overlap_kernel", scale_loss(overlap_kernel(&where_likely, vertices, triangles, p), OVERLAP)),
            ("watertightness", watertightness(triangles, p)),
            ("proposal_match", proposal_match(&self.candidates, &self.proposals)),
        ]
    }

    fn gradients(&self, terms: &[(&'static str, Term); 5]) -> [Matrix; 2] {
        let [.., (_, matched)] = terms;
        let mut to_candidates = vec![0.0; self.candidates.probabilities.len()];
        for (_, term) in &terms[..terms.len() - 1] {
            to_candidates.iter_mut().zip(&term.gradient).for_each(|(sum, g)| *sum += g);
        }
        let mut to_points = vec![0.0; self.of_points.matrix().n_rows()];
        // The probability of a proposal is the product of a candidate's and a point's.
        for (proposal, gradient) in self.proposals.iter().zip(&matched.gradient) {
            let (row, query) = (proposal.row as usize, self.queries[proposal.query as usize] as usize);
            to_points[row] += gradient * self.candidates.probabilities[query];
            to_candidates[query] += gradient * self.of_points.matrix().data()[row];
        }
        [to_candidates, to_points].map(|gradient| Matrix::new(gradient.len(), 1, gradient))
    }
}

fn scale_loss(term: Term, factor: f64) -> Term {
    let gradient = term.gradient.iter().map(|&g| (f64::from(g) * factor) as f32).collect();
    Term { value: factor * term.value, gradient }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learned_baselines::LearnedBaseline;
    use crate::linalg::test_values::run_on_threads;
    use neural_mesh::mesh::shapes;
    use neural_mesh::train::{Moments, adam_step};
    use rand_xoshiro::rand_core::SeedableRng;

    fn item() -> TrainingItem {
        TrainingItem { name: "sphere".into(), mesh: shapes::wavy_sphere(3, 5.0), ratio: 0.1 }
    }

    fn seeded_rng() -> Xoshiro256PlusPlus {
        Xoshiro256PlusPlus::seed_from_u64(0)
    }

    // Candidates are constant, because whole steps change them and their losses may rise.
    #[test]
    fn steps_on_held_candidates_lower_the_loss() {
        let settings = Settings::from_toml("").unwrap();
        let patch = SurfacePatch::draw(&item().mesh, &mut seeded_rng()).unwrap();
        let draw = Draw { seed: 1, random_share: RANDOM_SHARE };
        let mut tensors = LearnedBaseline::PointTriNet.initial_tensors(1.0 / 16.0, 1);
        let mut moments = Moments::zero(&tensors.map(|_, matrix| matrix.shape()));
        let candidates = last_candidates(&tensors.constants(), &patch.vertices, draw);
        let mut totals = Vec::new();
        for _ in 0..6 {
            let mut tape = Tape::default();
            let parameters = tensors.parameters(&mut tape);
            let last = LastRound::run(&mut tape, &parameters, &patch, candidates.clone(), draw);
            let terms = last.terms(&patch, &mut seeded_rng());
            totals.push(terms.iter().map(|(_, term)| term.value).sum::<f64>());
            let [to_queries, to_points] = last.gradients(&terms);
            let results = [(&last.probabilities, to_queries), (&last.of_points, to_points)];
            let gradients = parameters.gradients(&tape.backward(&results));
            tensors = adam_step(&tensors, &gradients, &mut moments, &settings, 0.003);
        }
        assert!(totals[5] < 0.98 * totals[0], "{totals:?}");
    }

    #[test]
    fn a_step_repeats_its_bits_on_any_number_of_threads() {
        let (settings, tensors) =
            (Settings::from_toml("").unwrap(), LearnedBaseline::PointTriNet.initial_tensors(1.0 / 16.0, 1));
        let step = || pointtrinet_step(&tensors, &item(), &settings, &mut seeded_rng()).unwrap();
        let on_threads = |n| run_on_threads(n, step);
        let one = on_threads(1);
        assert_eq!(one, on_threads(2));
        assert!(one.gradients.iter().all(|(_, gradient)| gradient.data().iter().any(|&g| g != 0.0)));
    }
}
