//! Learned methods of others, one folder per method.

pub mod dse;
pub mod pointtrinet;
pub mod potamias;
mod weights;

use crate::baselines::check_has_faces;
use anyhow::Result;
use neural_mesh::autodiff::{Tensors, Value};
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::{TriMesh, compact};
use neural_mesh::spatial::farthest_points;
use neural_mesh::train::StepFunction;
use std::sync::Arc;

pub use weights::LearnedWeights;

// Tensors with small initial weights: probabilities start near one half, and displacements near zero.
const SMALL: [&str; 3] = ["classifier.decision_2.weights", "proposals.score_3.weights", "refinement.moved"];

/// A learned method of others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LearnedBaseline {
    /// Delaunay surface elements (Rakotosaona et al. 2021).
    Dse,
    /// Points drawn in a latent space (Potamias, Bouritsas and Zafeiriou 2022).
    Potamias,
    /// Triangles proposed in rounds (Sharp and Ovsjanikov 2020).
    PointTriNet,
}

impl LearnedBaseline {
    /// All learned methods.
    pub const ALL: [Self; 3] = [Self::Dse, Self::Potamias, Self::PointTriNet];

    /// Returns the name in tables and arguments, and of the training objective.
    pub fn name(self) -> &'static str {
        ["dse", "potamias", "pointtrinet"][self as usize]
    }

    /// Returns the method with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|baseline| baseline.name() == name)
    }

    /// Returns the shapes of the tensors; `width_share` is in (0, 1].
    pub fn shapes(self, width_share: f64) -> Tensors<[usize; 2]> {
        match self {
            Self::Dse => dse::shapes(width_share),
            Self::Potamias => potamias::shapes(width_share),
            Self::PointTriNet => pointtrinet::shapes(width_share),
        }
    }

    /// Returns random initial tensors.
    pub fn initial_tensors(self, width_share: f64, seed: u64) -> Tensors<Arc<Matrix>> {
        self.shapes(width_share).draw_scaled(seed, |name| if SMALL.contains(&name) { 0.1 } else { 1.0 })
    }

    /// Returns the training step of the method.
    pub fn step(self) -> &'static StepFunction<'static> {
        match self {
            Self::Dse => &dse::dse_step,
            Self::Potamias => &potamias::potamias_step,
            Self::PointTriNet => &pointtrinet::pointtrinet_step,
        }
    }
}

/// Simplifies a mesh to at most `n_vertices`; the seed chooses the first point.
///
/// # Errors
/// One line where the result has no face or is no mesh.
pub fn simplify_by_learned(weights: &LearnedWeights, mesh: &TriMesh, n_vertices: usize, seed: u64) -> Result<TriMesh> {
    let simplified = match weights.baseline() {
        LearnedBaseline::Dse => dse::simplify(mesh, n_vertices, seed, weights.tensors()),
        LearnedBaseline::Potamias => potamias::simplify(mesh, n_vertices, seed, weights.tensors()),
        LearnedBaseline::PointTriNet => pointtrinet::simplify(mesh, n_vertices, seed, weights.tensors()),
    }?;
    check_has_faces(simplified)
}

/// Returns a tensor of checked weights by name.
///
/// # Panics
/// If there is none of this name; [`LearnedWeights`] have all of their network.
fn tensor<'a>(tensors: &'a Tensors<Value>, name: &str) -> &'a Value {
    tensors.find_tensor(name).expect("the tensors of this network")
}

/// Returns weights and bias of a layer.
fn layer<'a>(tensors: &'a Tensors<Value>, name: &str) -> [&'a Value; 2] {
    [".weights", ".bias"].map(|of| tensor(tensors, &format!("{name}{of}")))
}

/// Returns the first `n` layers `name_0`, `name_1`, and so on.
fn layers<'a>(tensors: &'a Tensors<Value>, name: &str, n: usize) -> Vec<[&'a Value; 2]> {
    (0..n).map(|i| layer(tensors, &format!("{name}_{i}"))).collect()
}

fn scale_width(width: usize, share: f64) -> usize {
    ((width as f64 * share).round() as usize).max(1)
}

fn compact_with_first_point(mesh: &TriMesh, seed: u64) -> Result<(TriMesh, u32)> {
    let (mesh, _) = compact(mesh.positions(), mesh.faces().to_vec())?;
    let mesh = check_has_faces(mesh)?;
    let first = seed % mesh.positions().len() as u64;
    Ok((mesh, first as u32))
}

/// Draws `n` farthest vertices from `first` on, in ascending order.
fn farthest_vertices(mesh: &TriMesh, n: usize, first: u32) -> Vec<u32> {
    let mut samples = farthest_points(mesh.positions(), n, first);
    samples.sort_unstable();
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::run_on_threads;
    use neural_mesh::mesh::shapes;
    use neural_mesh::train::{Moments, Settings, StepResult, TrainingItem, adam_step};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;

    /// Makes tensors whose entries follow from their number, row, column and height.
    pub fn tensors_by_formula(
        shapes: &Tensors<[usize; 2]>,
        entry: impl Fn(f64, [f64; 2], f64) -> f64,
    ) -> Tensors<Arc<Matrix>> {
        let mut number = -1.0;
        shapes.map(|_, &[n_rows, n_cols]| {
            number += 1.0;
            let entry = |i: usize, j: usize| entry(number, [i as f64, j as f64], n_rows as f64) as f32;
            Arc::new(Matrix::from_fn(n_rows, n_cols, entry))
        })
    }

    pub fn with_names(shapes: &Tensors<[usize; 2]>, values: &[Value]) -> Tensors<Value> {
        shapes.iter().map(|(name, _)| name).zip(values).map(|(name, value)| (name, value.clone())).collect()
    }

    #[track_caller]
    pub fn assert_near<'a>(found: &[f32], expected: impl IntoIterator<Item = &'a f64>) {
        let expected: Vec<f64> = expected.into_iter().copied().collect();
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((f64::from(*found) - expected).abs() < 1e-4, "{found} {expected}");
        }
    }

    fn train_twelve_steps(baseline: LearnedBaseline, width_share: f64) -> Vec<StepResult> {
        let settings = Settings::from_toml(&format!("objective = \"{}\"", baseline.name())).unwrap();
        let item = TrainingItem { name: "sphere".into(), mesh: shapes::wavy_sphere(4, 5.0), ratio: 0.1 };
        let mut tensors = baseline.initial_tensors(width_share, 1);
        let mut moments = Moments::zero(&tensors.map(|_, matrix| matrix.shape()));
        let mut steps = Vec::new();
        for _ in 0..12 {
            let random = &mut Xoshiro256PlusPlus::seed_from_u64(0);
            let step = baseline.step()(&tensors, &item, &settings, random).unwrap();
            tensors = adam_step(&tensors, &step.gradients, &mut moments, &settings, 0.003);
            steps.push(step);
        }
        steps
    }

    #[test]
    fn steps_on_one_mesh_lower_the_losses() {
        let steps = train_twelve_steps(LearnedBaseline::Dse, 0.03);
        let terms: Vec<_> = steps.iter().map(|step| [step.terms[0].1, step.terms[1].1]).collect();
        assert!((0..2).all(|term| terms[11][term] < 0.8 * terms[0][term]), "{terms:?}");
        let steps = train_twelve_steps(LearnedBaseline::Potamias, 0.25);
        let totals: Vec<f64> = steps.iter().map(|step| step.total()).collect();
        assert!(totals[11] < 0.97 * totals[0], "{totals:?}");
    }

    #[test]
    fn meshes_too_small_for_a_step_are_errors() {
        let settings = Settings::from_toml("").unwrap();
        let cube = || shapes::cuboid([1.0; 3], 1);
        for (baseline, mesh, ratio, words) in [
            (LearnedBaseline::Dse, cube(), 0.5, "no more than 60"),
            (LearnedBaseline::Dse, shapes::many_boxes(40), 1.0, "no component"),
            (LearnedBaseline::Potamias, cube(), 0.5, "fewer than 16"),
            (LearnedBaseline::PointTriNet, TriMesh::default(), 0.5, "too little surface"),
        ] {
            let item = TrainingItem { name: "small".into(), mesh, ratio };
            let random = &mut Xoshiro256PlusPlus::seed_from_u64(0);
            let refused = baseline.step()(&baseline.initial_tensors(0.05, 1), &item, &settings, random).unwrap_err();
            assert!(refused.contains(words), "{refused}");
        }
    }

    #[test]
    fn the_same_bits_on_any_number_of_threads() {
        let sphere = shapes::wavy_sphere(2, 4.0);
        for weights in LearnedBaseline::ALL.map(LearnedWeights::load_shipped) {
            let on_threads = |n| run_on_threads(n, || simplify_by_learned(weights, &sphere, 64, 0).unwrap());
            assert_eq!(on_threads(1), on_threads(3), "{}", weights.baseline().name());
        }
    }
}
