//! Step of measured objectives, which learns the best vertex importance for the closed assembly.
//!
//! Simultaneous perturbation (Spall 1992) estimates the gradient by the scores. Each cell of the surface moves its
//! scores up or down at random; results of these and of the opposite moves are measured. Each cell is credited with the
//! difference inside it.

use super::random::{random_below, uniform};
use super::scored_mesh::score_mesh;
use super::{ErrorShares, JudgedErrors, Objective, Settings, StepResult, TrainingItem};
use crate::linalg::Csr;
use crate::mesh::TriMesh;
use crate::model::Weights;
use crate::parallel;
use crate::simplify::{WeightedResult, edge_graph, importance_of_scores, simplify_with_importance, vertex_areas};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use std::collections::VecDeque;

/// Fewest output vertices with which a step is useful.
const MIN_OUTPUT_VERTICES: usize = 50;
/// Prior value of an output vertex: minus the derivative of an error's logarithm to the logarithm of the vertex count.
// Errors are assumed inversely proportional to the number of vertices.
const PRIOR_WORTH: f64 = 1.0;
/// Weight of [`PRIOR_WORTH`]: that of a measurement which moves this share of the output vertices between cells.
const PRIOR_WEIGHT: f64 = 0.2;

/// Computes the objective's terms and their estimated gradient.
///
/// # Errors
/// The reason why this mesh is unsuitable.
pub fn measured_step(
    objective: &dyn Objective,
    weights: &Weights,
    item: &TrainingItem,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<StepResult, String> {
    let mesh = &item.mesh;
    let n_output = (mesh.positions().len() as f64 * item.ratio) as usize;
    if n_output < MIN_OUTPUT_VERTICES {
        return Err(format!("would keep fewer than {MIN_OUTPUT_VERTICES} vertices at the ratio of this step"));
    }
    let scored = score_mesh(weights, mesh);
    let scores = scored.scores.matrix().data();
    let Estimate { terms, gradient, .. } =
        run_probes(objective, mesh, &scored.rings, scores, n_output, settings, random)?;
    Ok(StepResult { terms, gradients: scored.backward(gradient.into_iter().map(|g| g as f32).collect()) })
}

/// Estimated value and gradient of an objective for the closed assembly.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// Minimised terms by name, averaged over the probes (pairs of perturbed results).
    pub terms: Vec<(&'static str, f64)>,
    /// Gradient of the terms' sum by the scores, n_vertices.
    pub gradient: Vec<f64>,
    /// Variance of the gradient over the probes, n_vertices; 0 with a single probe.
    pub variance: Vec<f64>,
}

/// Estimates how an objective of results with `n_output` vertices changes with the vertex scores.
///
/// Scores are logarithms of importance. The settings `probes`, `probe_cell` and `probe_step` control the estimate.
///
/// # Errors
/// The reason why a result cannot be made or judged.
///
/// ```
/// use neural_mesh::{mesh::shapes, train::{Settings, ShapeObjective, estimate_gradient}};
/// let (mesh, settings) = (shapes::wavy_sphere(4, 4.0), Settings::from_toml("probes = 2").unwrap());
/// let scores = vec![0.0; mesh.positions().len()];
/// let estimate = estimate_gradient(&ShapeObjective, &mesh, &scores, 100, &settings, 1).unwrap();
/// assert!(estimate.gradient.iter().any(|&g| g != 0.0) && estimate.variance.iter().all(|&x| x >= 0.0));
/// ```
pub fn estimate_gradient(
    objective: &dyn Objective,
    mesh: &TriMesh,
    scores: &[f32],
    n_output: usize,
    settings: &Settings,
    seed: u64,
) -> Result<Estimate, String> {
    if scores.len() != mesh.positions().len() || !scores.iter().all(|score| score.is_finite()) {
        return Err(format!("give a finite score for each of {} vertices", mesh.positions().len()));
    }
    let random = &mut Xoshiro256PlusPlus::seed_from_u64(seed);
    run_probes(objective, mesh, &edge_graph(mesh), scores, n_output, settings, random)
}

fn run_probes(
    objective: &dyn Objective,
    mesh: &TriMesh,
    rings: &Csr,
    scores: &[f32],
    n_output: usize,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<Estimate, String> {
    let areas = vertex_areas(mesh);
    let importance = importance_of_scores(scores, &areas);
    let prober = Prober { objective, mesh, rings, areas: &areas, importance: &importance, n_output, settings };
    let probes = (0..settings.probes).map(|_| branch_generator(random));
    let found = parallel::each(probes, |mut random| prober.probe(&mut random));
    let found: Vec<ProbeResult> = found.into_iter().collect::<Result<_, _>>()?;
    Ok(average_probes(&found, mesh.positions().len()))
}

fn branch_generator(random: &mut Xoshiro256PlusPlus) -> Xoshiro256PlusPlus {
    let own = random.clone();
    random.jump();
    own
}

fn average_probes(found: &[ProbeResult], n: usize) -> Estimate {
    let share = 1.0 / found.len().max(1) as f64;
    let mut gradient = vec![0.0f64; n];
    found.iter().for_each(|f| gradient.iter_mut().zip(&f.gradient).for_each(|(sum, g)| *sum += share * g));
    let mut variance = vec![0.0f64; n];
    let of_mean = share / found.len().saturating_sub(1).max(1) as f64;
    for f in found {
        let differences = f.gradient.iter().zip(&gradient).map(|(g, mean)| (g - mean).powi(2));
        variance.iter_mut().zip(differences).for_each(|(sum, square)| *sum += of_mean * square);
    }
    let names = found.first().into_iter().flat_map(|f| &f.terms).map(|(name, _)| *name).enumerate();
    let terms = names.map(|(k, name)| (name, share * found.iter().map(|f| f.terms[k].1).sum::<f64>())).collect();
    Estimate { terms, gradient, variance }
}

struct Prober<'a> {
    objective: &'a dyn Objective,
    mesh: &'a TriMesh,
    rings: &'a Csr,
    areas: &'a [f64],
    /// Importance from the unperturbed scores, n_vertices.
    importance: &'a [f32],
    n_output: usize,
    settings: &'a Settings,
}

struct ProbeResult {
    terms: Vec<(&'static str, f64)>,
    gradient: Vec<f64>,
}

impl Prober<'_> {
    fn probe(&self, random: &mut Xoshiro256PlusPlus) -> Result<ProbeResult, String> {
        let n_cells = (self.n_output / self.settings.probe_cell.max(1)).max(4);
        let cells = cells(self.rings, n_cells, random);
        let signs: Vec<f32> = (0..n_cells).map(|_| if uniform(random) < 0.5 { -1.0 } else { 1.0 }).collect();
        let step = self.settings.probe_step as f32;
        let moved = |by: f32| -> Vec<f32> { cells.iter().map(|&cell| by * signs[cell as usize]).collect() };
        let (up, down) = (self.simplify_moved(&moved(step))?, self.simplify_moved(&moved(-step))?);
        let JudgedErrors { terms, error_shares } = self.objective.judge(self.mesh, [&up, &down])?;
        let mut counts = vec![0.0f64; n_cells];
        let [of_up, of_down] = [self.output_shares(&up), self.output_shares(&down)];
        let n_output = of_up.iter().sum::<f64>().max(1.0);
        for (&cell, (up, down)) in cells.iter().zip(of_up.iter().zip(&of_down)) {
            counts[cell as usize] += (up - down) / n_output;
        }
        let (changes, worth) = self.cell_changes(&error_shares, &cells, &counts, &signs, terms.len());
        let slopes: Vec<f64> = (0..n_cells)
            .map(|c| f64::from(signs[c]) * (changes[c] + worth * counts[c]) / (2.0 * f64::from(step)))
            .collect();
        Ok(ProbeResult { terms, gradient: share_by_area(&slopes, &cells, self.areas) })
    }

    /// Returns the change of the summed terms in each cell, and the value of an output vertex.
    fn cell_changes(
        &self,
        error_shares: &ErrorShares,
        cells: &[u32],
        counts: &[f64],
        signs: &[f32],
        n_terms: usize,
    ) -> (Vec<f64>, f64) {
        let mut changes = vec![0.0f64; signs.len()];
        let cell_of = |v: u32| cells[v as usize] as usize;
        match error_shares {
            ErrorShares::Faces(shares) => {
                self.mesh.faces().iter().zip(shares).for_each(|(face, share)| changes[cell_of(face[0])] += share);
            }
            ErrorShares::Vertices(shares) => {
                cells.iter().zip(shares).for_each(|(&cell, share)| changes[cell as usize] += share)
            }
            // A single error has no location, so only the prior gives the value of an output vertex.
            ErrorShares::Everywhere(all) => return (vec![*all; signs.len()], PRIOR_WORTH * n_terms as f64),
        }
        let worth = vertex_worth(&changes, counts, signs, n_terms);
        (changes, worth)
    }

    fn simplify_moved(&self, moves: &[f32]) -> Result<WeightedResult, String> {
        let importance: Vec<f32> = self.importance.iter().zip(moves).map(|(factor, by)| factor * by.exp()).collect();
        simplify_with_importance(self.mesh, self.n_output, &importance).map_err(|error| error.to_string())
    }

    fn output_shares(&self, result: &WeightedResult) -> Vec<f64> {
        share_by_area(&vec![1.0; result.mesh.positions().len()], &result.vertex_of, self.areas)
    }
}

/// Divides each group's value among its members by area.
fn share_by_area(values: &[f64], groups: &[u32], areas: &[f64]) -> Vec<f64> {
    let mut totals = vec![0.0f64; values.len()];
    groups.iter().zip(areas).for_each(|(&group, area)| totals[group as usize] += area);
    let share = |(&group, area): (&u32, &f64)| match totals[group as usize] {
        total if total > 0.0 => values[group as usize] * area / total,
        _ => 0.0,
    };
    groups.iter().zip(areas).map(share).collect()
}

/// Returns the value of an output vertex, which a cell pays for each vertex gained.
///
/// The number of output vertices is fixed, so raising all cells together must change nothing.
fn vertex_worth(changes: &[f64], counts: &[f64], signs: &[f32], n_terms: usize) -> f64 {
    let usual = PRIOR_WORTH * n_terms as f64;
    let along = |values: &[f64]| values.iter().zip(signs).map(|(x, &sign)| x * f64::from(sign)).sum::<f64>();
    ((usual * PRIOR_WEIGHT - along(changes)) / (PRIOR_WEIGHT + along(counts).max(0.0))).clamp(0.0, 3.0 * usual)
}

/// Divides the vertices into `n_cells` cells that grow over the edges from random vertices.
fn cells(rings: &Csr, n_cells: usize, random: &mut Xoshiro256PlusPlus) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let mut cells = vec![NONE; rings.n_rows()];
    let mut pending = VecDeque::new();
    for cell in 0..n_cells as u32 {
        let start = random_below(random, rings.n_rows());
        if cells[start] == NONE {
            cells[start] = cell;
            pending.push_back(start);
        }
    }
    while let Some(v) = pending.pop_front() {
        for &w in rings.row(v) {
            if cells[w as usize] == NONE {
                cells[w as usize] = cells[v];
                pending.push_back(w as usize);
            }
        }
    }
    cells.into_iter().map(|cell| if cell == NONE { 0 } else { cell }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::train::ShapeObjective;

    #[test]
    fn cells_are_pieces_of_the_surface() {
        let rings = edge_graph(&shapes::icosphere(3));
        let cells = cells(&rings, 20, &mut Xoshiro256PlusPlus::seed_from_u64(1));
        let neighbours_alike = |v: usize| rings.row(v).iter().any(|&w| cells[w as usize] == cells[v]);
        assert!((0..rings.n_rows()).all(neighbours_alike));
        assert!((10..=20).contains(&cells.iter().collect::<std::collections::HashSet<_>>().len()));
    }

    #[test]
    fn means_and_their_variance_have_their_golden_values() {
        let found = [1.0, 3.0, 8.0].map(|g| ProbeResult { terms: vec![("a", g)], gradient: vec![g, 1.0] });
        let Estimate { terms, gradient, variance } = average_probes(&found, 2);
        assert!((terms[0].1 - 4.0).abs() < 1e-12 && (gradient[0] - 4.0).abs() < 1e-12);
        // Variance of the mean: squares 9, 1, 16 over 3 x 2.
        assert!((variance[0] - 26.0 / 6.0).abs() < 1e-12 && variance[1] < 1e-24, "{variance:?}");
    }

    #[test]
    fn a_vertex_is_worth_what_all_cells_together_gain() {
        let (signs, counts) = ([1.0, -1.0, 1.0], [2.0, -1.0, 3.0]);
        let changes = counts.map(|count| -4.0 * count);
        assert!(
            (vertex_worth(&changes, &counts, &signs, 3) - (3.0 * PRIOR_WEIGHT + 24.0) / (PRIOR_WEIGHT + 6.0)).abs()
                < 1e-12
        );
        assert!((vertex_worth(&[0.0; 3], &[0.0; 3], &signs, 3) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_gradient_asks_for_more_where_errors_are() {
        // A sphere with one rough cap: with uniform scores the errors are largest on the cap.
        let sphere = shapes::icosphere(5);
        let rough = |p: &[f32; 3]| {
            let wave = if p[2] > 0.6 { 1.0 + 0.02 * (25.0 * p[0]).sin() * (25.0 * p[1]).sin() } else { 1.0 };
            p.map(|x| x * wave)
        };
        let mesh = TriMesh::new(sphere.positions().iter().map(rough).collect(), sphere.faces().to_vec()).unwrap();
        let settings = Settings::from_toml("objective = \"shape\"").unwrap();
        let areas = vertex_areas(&mesh);
        // Scores that are low on the cap, the opposite of good ones.
        let scores: Vec<f32> = mesh.positions().iter().map(|p| if p[2] > 0.6 { -3.0 } else { 0.0 }).collect();
        let rings = edge_graph(&mesh);
        let importance = importance_of_scores(&scores, &areas);
        let prober = Prober {
            objective: &ShapeObjective,
            mesh: &mesh,
            rings: &rings,
            areas: &areas,
            importance: &importance,
            n_output: 600,
            settings: &settings,
        };
        let mut cap = 0.0;
        for seed in 0..4 {
            let found = prober.probe(&mut Xoshiro256PlusPlus::seed_from_u64(seed)).unwrap();
            cap +=
                mesh.positions().iter().zip(&found.gradient).filter(|(p, _)| p[2] > 0.6).map(|(_, g)| g).sum::<f64>();
        }
        assert!(cap < -0.05, "{cap}");
    }
}
