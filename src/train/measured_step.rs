//! The step of objectives that are measured: which importance of the vertices makes the closed assembly's result best.
//!
//! Assembly and errors are what they are in use; nothing is relaxed. The loss is the measured one, and its gradient to
//! the scores is estimated: the surface is divided into cells, each cell's scores are moved up or down at random, and
//! the result is measured on both sides (simultaneous perturbation, Spall 1992). Where errors have places, every cell is
//! credited with the change within itself: one pair of runs says something about hundreds of cells.

use super::random::{below, uniform};
use super::scored::scored;
use super::{Blame, Item, Objective, Settings, Step, Verdict};
use crate::linalg::Csr;
use crate::mesh::TriMesh;
use crate::model::Weights;
use crate::simplify::{
    Importance, Refinements, WeightedResult, edge_graph, importance_of_scores, simplify_with_importance, vertex_areas,
};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use rayon::prelude::*;
use std::collections::VecDeque;

/// Fewer output vertices than this say little.
const LEAST_VERTICES: usize = 50;
/// What an output vertex is worth in the logarithm of an error times the number of vertices, where the cells of a step do not say:
/// errors fall in proportion to the vertices.
const WORTH: f64 = 1.0;
/// Weight of that guess against what the cells say, in shares of all output vertices.
const BELIEF: f64 = 0.2;

/// One step: the objective's terms, and the gradient that the probes estimate.
///
/// # Errors
/// In a few words why the step cannot be made with this mesh.
pub fn measured_step(
    objective: &dyn Objective,
    weights: &Weights,
    item: &Item,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<Step, String> {
    let mesh = &item.mesh;
    let n_output = (mesh.positions().len() as f64 * item.ratio) as usize;
    if n_output < LEAST_VERTICES {
        return Err(format!("has fewer than {LEAST_VERTICES} vertices left at this ratio"));
    }
    let scored = scored(weights, mesh);
    let scores = scored.scores.matrix().data();
    let Estimate { terms, gradient, .. } = probed(objective, mesh, &scored.rings, scores, n_output, settings, random)?;
    Ok(Step { terms, gradients: scored.backward(gradient.into_iter().map(|g| g as f32).collect()) })
}

/// What probes say about an objective of the closed assembly's results, and how it depends on the scores of the vertices.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// What is minimised, by name, over all probes.
    pub terms: Vec<(&'static str, f64)>,
    /// Of the sum of the terms to the scores, n_vertices: the mean over the probes.
    pub gradient: Vec<f64>,
    /// Of that mean, n_vertices: how much it would vary with other probes; 0 where there is one alone.
    pub variance: Vec<f64>,
}

/// Estimates how an objective of results with `n_output` vertices depends on the scores of the vertices, logarithms of their
/// importance, by simultaneous perturbation (Spall 1992). `probes`, `probe_cell` and `probe_step` of the settings count.
///
/// # Shapes
/// - `scores`: n_vertices
///
/// # Errors
/// In a few words, where a result cannot be made or judged.
///
/// ```
/// use neural_mesh::{mesh::shapes, train::{Settings, Shape, estimated}};
/// let (mesh, settings) = (shapes::wavy_sphere(4, 4.0), Settings::from_toml("probes = 2").unwrap());
/// let scores = vec![0.0; mesh.positions().len()];
/// let estimate = estimated(&Shape, &mesh, &scores, 100, &settings, 1).unwrap();
/// assert!(estimate.gradient.iter().any(|&g| g != 0.0) && estimate.variance.iter().all(|&x| x >= 0.0));
/// ```
pub fn estimated(
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
    probed(objective, mesh, &edge_graph(mesh), scores, n_output, settings, random)
}

fn probed(
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
    let probing = Probing { objective, mesh, rings, areas: &areas, importance: &importance, n_output, settings };
    let probes: Vec<Xoshiro256PlusPlus> = (0..settings.probes).map(|_| branched(random)).collect();
    let found: Vec<Found> =
        probes.into_par_iter().map(|mut random| probing.probe(&mut random)).collect::<Result<_, _>>()?;
    Ok(mean(&found, mesh.positions().len()))
}

/// A generator of its own for each probe.
fn branched(random: &mut Xoshiro256PlusPlus) -> Xoshiro256PlusPlus {
    let own = random.clone();
    random.jump();
    own
}

/// The terms and the gradients of all probes, averaged.
fn mean(found: &[Found], n: usize) -> Estimate {
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

struct Probing<'a> {
    objective: &'a dyn Objective,
    mesh: &'a TriMesh,
    rings: &'a Csr,
    areas: &'a [f64],
    /// By the scores as they are, n_vertices.
    importance: &'a [f32],
    n_output: usize,
    settings: &'a Settings,
}

/// What one pair of runs says.
struct Found {
    /// Of both runs together.
    terms: Vec<(&'static str, f64)>,
    /// To the scores, n_vertices.
    gradient: Vec<f64>,
}

impl Probing<'_> {
    fn probe(&self, random: &mut Xoshiro256PlusPlus) -> Result<Found, String> {
        let n_cells = (self.n_output / self.settings.probe_cell.max(1)).max(4);
        let cells = cells(self.rings, n_cells, random);
        let signs: Vec<f32> = (0..n_cells).map(|_| if uniform(random) < 0.5 { -1.0 } else { 1.0 }).collect();
        let step = self.settings.probe_step as f32;
        let moved = |by: f32| -> Vec<f32> { cells.iter().map(|&cell| by * signs[cell as usize]).collect() };
        let (up, down) = (self.side(&moved(step))?, self.side(&moved(-step))?);
        let Verdict { terms, blame } = self.objective.judge(self.mesh, [&up, &down])?;
        let mut counts = vec![0.0f64; n_cells];
        let [of_up, of_down] = [self.counts(&up), self.counts(&down)];
        let n_output = of_up.iter().sum::<f64>().max(1.0);
        for (&cell, (up, down)) in cells.iter().zip(of_up.iter().zip(&of_down)) {
            counts[cell as usize] += (up - down) / n_output;
        }
        let (changes, worth) = self.changes(&blame, &cells, &counts, &signs, terms.len());
        let slopes: Vec<f64> = (0..n_cells)
            .map(|c| f64::from(signs[c]) * (changes[c] + worth * counts[c]) / (2.0 * f64::from(step)))
            .collect();
        Ok(Found { terms, gradient: shared_out(&slopes, &cells, self.areas) })
    }

    /// What each cell did to the terms, and what a vertex is worth.
    fn changes(&self, blame: &Blame, cells: &[u32], counts: &[f64], signs: &[f32], n_terms: usize) -> (Vec<f64>, f64) {
        let mut changes = vec![0.0f64; signs.len()];
        let cell_of = |v: u32| cells[v as usize] as usize;
        match blame {
            Blame::Faces(shares) => {
                self.mesh.faces().iter().zip(shares).for_each(|(face, share)| changes[cell_of(face[0])] += share);
            }
            Blame::Vertices(shares) => {
                cells.iter().zip(shares).for_each(|(&cell, share)| changes[cell as usize] += share)
            }
            // All cells together say nothing about one vertex more.
            Blame::Everywhere(all) => return (vec![*all; signs.len()], WORTH * n_terms as f64),
        }
        let worth = worth(&changes, counts, signs, n_terms);
        (changes, worth)
    }

    /// Simplifies with the scores moved.
    fn side(&self, moves: &[f32]) -> Result<WeightedResult, String> {
        let importance: Vec<f32> = self.importance.iter().zip(moves).map(|(factor, by)| factor * by.exp()).collect();
        let (importance, parts) = (Importance::Given(&importance), Refinements::default());
        simplify_with_importance(self.mesh, self.n_output, importance, &parts).map_err(|error| error.to_string())
    }

    /// The share of an output vertex in each input vertex, n_vertices.
    fn counts(&self, result: &WeightedResult) -> Vec<f64> {
        shared_out(&vec![1.0; result.mesh.positions().len()], &result.vertex_of, self.areas)
    }
}

/// What each group has, divided among its members by their areas; nothing where a group has no area.
fn shared_out(values: &[f64], groups: &[u32], areas: &[f64]) -> Vec<f64> {
    let mut totals = vec![0.0f64; values.len()];
    groups.iter().zip(areas).for_each(|(&group, area)| totals[group as usize] += area);
    let share = |(&group, area): (&u32, &f64)| match totals[group as usize] {
        total if total > 0.0 => values[group as usize] * area / total,
        _ => 0.0,
    };
    groups.iter().zip(areas).map(share).collect()
}

/// What a vertex more is worth: the number of output vertices is fixed, so a cell pays for those that it draws to
/// itself. Raising all cells together changes nothing, which says how much.
fn worth(changes: &[f64], counts: &[f64], signs: &[f32], n_terms: usize) -> f64 {
    let usual = WORTH * n_terms as f64;
    let along = |values: &[f64]| values.iter().zip(signs).map(|(x, &sign)| x * f64::from(sign)).sum::<f64>();
    ((usual * BELIEF - along(changes)) / (BELIEF + along(counts).max(0.0))).clamp(0.0, 3.0 * usual)
}

/// Divides the vertices into cells that grow over the edges from random places; what none reaches is in cell 0.
fn cells(rings: &Csr, n_cells: usize, random: &mut Xoshiro256PlusPlus) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let mut cells = vec![NONE; rings.n_rows()];
    let mut pending = VecDeque::new();
    for cell in 0..n_cells as u32 {
        let start = below(random, rings.n_rows());
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
    use crate::train::Shape;

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
        let found = [1.0, 3.0, 8.0].map(|g| Found { terms: vec![("a", g)], gradient: vec![g, 1.0] });
        let Estimate { terms, gradient, variance } = mean(&found, 2);
        assert!((terms[0].1 - 4.0).abs() < 1e-12 && (gradient[0] - 4.0).abs() < 1e-12);
        // Squares 9, 1, 16 over 3 x 2.
        assert!((variance[0] - 26.0 / 6.0).abs() < 1e-12 && variance[1] < 1e-24, "{variance:?}");
    }

    #[test]
    fn a_vertex_is_worth_what_all_cells_together_gain() {
        let (signs, counts) = ([1.0, -1.0, 1.0], [2.0, -1.0, 3.0]);
        let changes = counts.map(|count| -4.0 * count);
        assert!((worth(&changes, &counts, &signs, 3) - (3.0 * BELIEF + 24.0) / (BELIEF + 6.0)).abs() < 1e-12);
        assert!((worth(&[0.0; 3], &[0.0; 3], &signs, 3) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_gradient_asks_for_more_where_errors_are() {
        // A sphere with one rough cap: with even scores its errors are there.
        let sphere = shapes::icosphere(5);
        let rough = |p: &[f32; 3]| {
            let wave = if p[2] > 0.6 { 1.0 + 0.02 * (25.0 * p[0]).sin() * (25.0 * p[1]).sin() } else { 1.0 };
            p.map(|x| x * wave)
        };
        let mesh = TriMesh::new(sphere.positions().iter().map(rough).collect(), sphere.faces().to_vec()).unwrap();
        let settings = Settings::from_toml("objective = \"shape\"").unwrap();
        let areas = vertex_areas(&mesh);
        // Scores that say the opposite of what is good.
        let scores: Vec<f32> = mesh.positions().iter().map(|p| if p[2] > 0.6 { -3.0 } else { 0.0 }).collect();
        let rings = edge_graph(&mesh);
        let importance = importance_of_scores(&scores, &areas);
        let probing = Probing {
            objective: &Shape,
            mesh: &mesh,
            rings: &rings,
            areas: &areas,
            importance: &importance,
            n_output: 600,
            settings: &settings,
        };
        let mut cap = 0.0;
        for seed in 0..4 {
            let found = probing.probe(&mut Xoshiro256PlusPlus::seed_from_u64(seed)).unwrap();
            cap +=
                mesh.positions().iter().zip(&found.gradient).filter(|(p, _)| p[2] > 0.6).map(|(_, g)| g).sum::<f64>();
        }
        assert!(cap < -0.05, "{cap}");
    }
}
