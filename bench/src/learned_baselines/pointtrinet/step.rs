//! The step of the objective "pointtrinet": a patch of a surface triangulated by the networks of
//! this module, judged by their losses.
//!
//! As in the paper, gradients flow through the last round alone; the candidates come from the rounds before it. No known
//! triangulation teaches it.

use super::{
    Candidates, Draw, Neighbourhoods, PointTriNet, Proposal, SurfacePoint, classifier, last_candidates, overlap_kernel,
    point_probabilities, proposal_match, proposals, surface_to_triangles, triangle_samples, triangles_to_surface,
    watertightness,
};
use glam::{DVec3, Vec3};
use neural_mesh::autodiff::{Tape, Tensors, Value, WeightsError};
use neural_mesh::linalg::Matrix;
use neural_mesh::loss::Term;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::surface_samples::{SurfaceSample, surface_samples};
use neural_mesh::spatial::{farthest_points, nearest_to};
use neural_mesh::train::random::{below, uniform};
use neural_mesh::train::{Item, Settings, Step};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;
use std::sync::Arc;

/// Vertices of a patch.
const PATCH_VERTICES: usize = 256;
/// Points of the surface beside it.
const PATCH_SURFACE: usize = 1024;
/// The share of a mesh that a patch covers.
const PATCH_SHARE: f64 = 0.25;
/// One in so many surface points looks for the nearest triangle.
const SURFACE_STRIDE: usize = 10;
/// Points drawn on the candidates, for the distance to the surface and for overlaps.
const SAMPLES: usize = 1000;
/// Weight of the overlaps; the other terms have 1.
const OVERLAP: f64 = 0.01;
/// Share of the proposals that takes any point.
const RANDOM_SHARE: f32 = 0.25;
/// One in so many candidates proposes in the round that learns, which says as much about the proposals at a quarter of
/// the time.
const PROPOSING_STRIDE: usize = 4;

/// One step on one patch.
pub fn pointtrinet_step(
    tensors: &Tensors<Arc<Matrix>>,
    item: &Item,
    _: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<Step, String> {
    let patch = Patch::of(&item.mesh, random).ok_or("has too little surface for a patch")?;
    let missing = |error: WeightsError| error.to_string();
    let net = PointTriNet::of(&tensors.constants()).map_err(missing)?;
    let draw = Draw { seed: random.next_u64(), random_share: RANDOM_SHARE };
    let candidates = last_candidates(&net, &patch.vertices, draw);
    let mut tape = Tape::default();
    let parameters = tensors.parameters(&mut tape);
    let net = PointTriNet::of(&parameters).map_err(missing)?;
    let last = LastRound::of(&mut tape, &net, &patch, candidates, Draw { seed: random.next_u64(), ..draw });
    let terms = last.terms(&patch, random);
    let [to_queries, to_points] = last.gradients(&terms);
    let gradients = tape.backward(&[(&last.probabilities, to_queries), (&last.of_points, to_points)]);
    Ok(Step {
        terms: terms.iter().map(|(name, term)| (*name, term.value)).collect(),
        gradients: parameters.gradients(&gradients),
    })
}

/// A piece of a surface: vertices to triangulate, and the surface itself.
struct Patch {
    vertices: Vec<[f32; 3]>,
    surface: Vec<SurfacePoint>,
    /// Mean distance of the surface's points to their mean.
    length: f64,
}

impl Patch {
    /// The points nearest to a place on the surface. Half of the patches have vertices at random, as in the paper; the others
    /// have them spread as farthest points spread them, which is how meshes are sampled for simplification.
    fn of(mesh: &TriMesh, random: &mut Xoshiro256PlusPlus) -> Option<Self> {
        let [n_vertices, n_surface] = [PATCH_VERTICES, PATCH_SURFACE].map(|n| (n as f64 / PATCH_SHARE) as usize);
        let surface = surface_points(mesh, n_surface, random.next_u64());
        let positions: Vec<[f32; 3]> = surface.iter().map(|at| at.point).collect();
        let dense = |n: usize, seed: u64| -> Vec<[f32; 3]> {
            surface_samples(mesh, n, seed).iter().map(|sample| sample.point(mesh).as_vec3().to_array()).collect()
        };
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
        let center = positions[below(random, positions.len())];
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

/// The round that learns.
struct LastRound {
    /// With the probabilities of this round.
    candidates: Candidates,
    probabilities: Value,
    of_points: Value,
    /// The candidates that propose.
    queries: Vec<u32>,
    proposals: Vec<Proposal>,
}

impl LastRound {
    fn of(tape: &mut Tape, net: &PointTriNet<Value>, patch: &Patch, before: Candidates, draw: Draw) -> Self {
        let neighbourhoods = Neighbourhoods::new(&patch.vertices, &before);
        let all: Vec<u32> = (0..before.triangles.len() as u32).collect();
        let probabilities = classifier(tape, &net.classifier, &neighbourhoods, &all);
        let first = (draw.seed % PROPOSING_STRIDE as u64) as usize;
        let queries: Vec<u32> = all.into_iter().skip(first).step_by(PROPOSING_STRIDE).collect();
        let of_points = point_probabilities(tape, &net.proposals, &neighbourhoods, &queries);
        let p = probabilities.matrix().data();
        let of_queries: Vec<f32> = queries.iter().map(|&query| p[query as usize]).collect();
        let proposals = proposals(&neighbourhoods, &queries, &of_queries, of_points.matrix().data(), draw);
        let candidates = Candidates { probabilities: p.to_vec(), ..before };
        Self { candidates, probabilities, of_points, queries, proposals }
    }

    /// The losses by name, with their weights; the last one's gradient is to the proposals, that of the others to the
    /// candidates.
    fn terms(&self, patch: &Patch, random: &mut Xoshiro256PlusPlus) -> [(&'static str, Term); 5] {
        let Candidates { triangles, probabilities: p } = &self.candidates;
        let (vertices, length) = (&patch.vertices, patch.length);
        let points: Vec<[f32; 3]> = patch.surface.iter().step_by(SURFACE_STRIDE).map(|at| at.point).collect();
        let everywhere = triangle_samples(vertices, triangles, &vec![1.0; p.len()], SAMPLES, random.next_u64());
        let where_likely = triangle_samples(vertices, triangles, p, SAMPLES, random.next_u64());
        [
            ("surface_to_triangles", surface_to_triangles(&points, vertices, triangles, p, length)),
            ("triangles_to_surface", triangles_to_surface(&patch.surface, &everywhere, p, length)),
            ("overlap_kernel", times(overlap_kernel(&where_likely, vertices, triangles, p), OVERLAP)),
            ("watertightness", watertightness(triangles, p)),
            ("proposal_match", proposal_match(&self.candidates, &self.proposals)),
        ]
    }

    /// The gradients to the probabilities of the candidates and of the points. A proposal is the product of one of each.
    fn gradients(&self, terms: &[(&'static str, Term); 5]) -> [Matrix; 2] {
        let [.., (_, matched)] = terms;
        let mut to_candidates = vec![0.0; self.candidates.probabilities.len()];
        for (_, term) in &terms[..terms.len() - 1] {
            to_candidates.iter_mut().zip(&term.gradient).for_each(|(sum, g)| *sum += g);
        }
        let mut to_points = vec![0.0; self.of_points.matrix().n_rows()];
        for (proposal, gradient) in self.proposals.iter().zip(&matched.gradient) {
            let (row, query) = (proposal.row as usize, self.queries[proposal.query as usize] as usize);
            to_points[row] += gradient * self.candidates.probabilities[query];
            to_candidates[query] += gradient * self.of_points.matrix().data()[row];
        }
        [to_candidates, to_points].map(|gradient| Matrix::new(gradient.len(), 1, gradient))
    }
}

fn times(term: Term, factor: f64) -> Term {
    let gradient = term.gradient.iter().map(|&g| (f64::from(g) * factor) as f32).collect();
    Term { value: factor * term.value, gradient }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learned_baselines::pointtrinet::drawn;
    use neural_mesh::mesh::shapes;
    use neural_mesh::train::{Moments, adam_step};
    use rand_xoshiro::rand_core::SeedableRng;

    fn item() -> Item {
        Item { name: "sphere".into(), mesh: shapes::wavy_sphere(3, 5.0), ratio: 0.1 }
    }

    fn seeded() -> Xoshiro256PlusPlus {
        Xoshiro256PlusPlus::seed_from_u64(0)
    }

    /// Whole steps change the candidates, too, so that their losses need not fall one by one.
    #[test]
    fn steps_on_held_candidates_lower_the_loss() {
        let settings = Settings::from_toml("").unwrap();
        let patch = Patch::of(&item().mesh, &mut seeded()).unwrap();
        let draw = Draw { seed: 1, random_share: RANDOM_SHARE };
        let mut tensors = drawn(1.0 / 16.0, 1);
        let mut moments = Moments::zero(&tensors.map(|_, matrix| matrix.shape()));
        let candidates = last_candidates(&PointTriNet::of(&tensors.constants()).unwrap(), &patch.vertices, draw);
        let mut totals = Vec::new();
        for _ in 0..6 {
            let mut tape = Tape::default();
            let parameters = tensors.parameters(&mut tape);
            let net = PointTriNet::of(&parameters).unwrap();
            let last = LastRound::of(&mut tape, &net, &patch, candidates.clone(), draw);
            let terms = last.terms(&patch, &mut seeded());
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
        let (settings, tensors) = (Settings::from_toml("").unwrap(), drawn(1.0 / 16.0, 1));
        let on_threads = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| pointtrinet_step(&tensors, &item(), &settings, &mut seeded()).unwrap())
        };
        let one = on_threads(1);
        assert_eq!(one, on_threads(2));
        assert!(one.gradients.iter().all(|(_, gradient)| gradient.data().iter().any(|&g| g != 0.0)));
    }

    #[test]
    fn what_has_no_surface_is_said() {
        let settings = Settings::from_toml("").unwrap();
        let item = Item { name: "nothing".into(), mesh: TriMesh::default(), ratio: 0.5 };
        let random = &mut Xoshiro256PlusPlus::seed_from_u64(0);
        assert!(pointtrinet_step(&drawn(0.1, 1), &item, &settings, random).unwrap_err().contains("too little surface"));
    }
}
