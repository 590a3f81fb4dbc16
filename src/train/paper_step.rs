//! Step of the objective "paper": the network of Secs. 3.1 to 3.3 with the losses of Sec. 3.4.
//!
//! Samples and candidates are constants for the gradient. With `end_to_end`, the surface distances reach the Point Sampler
//! through the inclusion probabilities of the samples; otherwise it learns from its own terms only.

use super::face_terms::{FaceContext, face_terms, has_face_terms};
use super::patch::cut_patch;
use super::random::uniform;
use super::roughen::roughen;
use super::sampled_mesh::{classify_faces, connect_samples};
use super::sampler_terms::{SamplerInput, sampler_terms};
use super::scored_mesh::{ScoredMesh, score_mesh, score_points};
use super::{Settings, StepResult, TrainingItem, network_gradients};
use crate::autodiff::Value;
use crate::linalg::Matrix;
use crate::loss::{DrawnFaces, NamedTerm, gradient_through_draw, inclusion, total};
use crate::mesh::TriMesh;
use crate::model::{EdgeFrame, Weights};
use crate::simplify::{cloud_graph, scattered_samples};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;

/// Terms over faces that teach the Point Sampler end to end. The others are least where samples crowd together, in faces
/// that are easy to join.
const DISTANCES: [&str; 3] = ["forward", "reverse", "coverage"];

/// Fewest samples of a useful step.
const LEAST_SAMPLES: usize = 16;

pub(super) fn paper_step(
    weights: &Weights,
    item: &TrainingItem,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<StepResult, String> {
    let original = cut_patch(item, settings, random)?;
    let mesh = match settings.noise > 0.0 {
        true => roughen(&original, settings.noise, random).map_err(|error| error.to_string())?,
        false => original.clone(),
    };
    let n_samples = (mesh.positions().len() as f64 * item.ratio) as usize;
    if n_samples < LEAST_SAMPLES {
        return Err(format!("would keep fewer than {LEAST_SAMPLES} samples at the ratio of this step"));
    }
    let as_cloud = settings.clouds > 0.0 && uniform(random) < settings.clouds;
    let ScoredMesh { mut tape, net, rings, points, scores, .. } = match as_cloud {
        false => score_mesh(weights, &mesh),
        true => score_points(weights, mesh.positions(), unknown_normals(&mesh), cloud_graph(mesh.positions())),
    };
    let originals = EdgeFrame::new(mesh.positions(), &rings).apply(original.positions());
    let surface = SamplerInput { points: &points, originals: &originals, rings: &rings };
    let of_scores = sampler_terms(&surface, scores.matrix().data(), n_samples, settings, random);
    let mut results = vec![(scores.clone(), of_scores)];
    let mut through_draw = None;
    if has_face_terms(settings) {
        let samples = scattered_samples(&points, &rings, scores.matrix().data(), n_samples, random.next_u64());
        let drawn = connect_samples(&mesh, &points, &rings, &samples, as_cloud);
        let (probabilities, candidates) = classify_faces(&mut tape, &net, &drawn, weights);
        let faces = FaceContext { mesh: &original, drawn: &drawn, candidates: &candidates };
        let of_faces = face_terms(&faces, probabilities.matrix().data(), settings, random);
        if settings.end_to_end {
            let chances = inclusion(scores.matrix().data(), n_samples);
            let (triangles, p) = (&candidates.faces.triangles, probabilities.matrix().data());
            let judged = DrawnFaces { samples: &samples, faces: triangles, probabilities: p };
            let distances: Vec<NamedTerm> =
                of_faces.iter().filter(|term| DISTANCES.contains(&term.name)).cloned().collect();
            let to_scores = gradient_through_draw(&judged, &total(&distances, p.len()).gradient, &chances);
            through_draw = Some(Matrix::new(to_scores.len(), 1, to_scores));
        }
        results.push((probabilities, of_faces));
    }
    let terms = results.iter().flat_map(|(_, terms)| terms);
    let terms = terms.map(|term| (term.name, term.weight * term.term.value)).collect();
    let mut gradients: Vec<_> = results.iter().map(|(values, terms)| (values, gradient(values, terms))).collect();
    gradients.extend(through_draw.map(|gradient| (&scores, gradient)));
    Ok(StepResult { terms, gradients: network_gradients(&net, &tape.backward(&gradients)) })
}

fn unknown_normals(mesh: &TriMesh) -> Vec<[f32; 3]> {
    vec![[0.0; 3]; mesh.positions().len()]
}

fn gradient(values: &Value, terms: &[NamedTerm]) -> Matrix {
    let n = values.matrix().n_rows();
    Matrix::new(n, 1, total(terms, n).gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use rand_xoshiro::rand_core::SeedableRng;

    fn terms(toml: &str) -> Vec<(&'static str, f64)> {
        step(toml).terms
    }

    fn step(toml: &str) -> StepResult {
        step_of_seed(toml, 0)
    }

    fn step_of_seed(toml: &str, seed: u64) -> StepResult {
        let settings = Settings::from_toml(toml).unwrap();
        let item = TrainingItem { name: "sphere".into(), mesh: shapes::wavy_sphere(3, 5.0), ratio: 0.1 };
        let weights = Weights::random(1);
        paper_step(&weights, &item, &settings, &mut Xoshiro256PlusPlus::seed_from_u64(seed)).unwrap()
    }

    #[test]
    fn collisions_crossings_and_overlaps_are_found() {
        for toml in ["", "literal = true"] {
            let found = terms(toml);
            for name in ["collision", "crossing", "overlap"] {
                assert!(found.iter().any(|term| term.0 == name && term.1 > 0.0), "{toml} {name}: {found:?}");
            }
        }
    }

    #[test]
    fn the_terms_over_faces_reach_the_point_sampler_end_to_end_alone() {
        let squares = |toml: &str, stage: &str| -> f64 {
            let named = step(&format!("lambda_sampler = 0.0\nlambda_smoothness = 0.0\n{toml}")).gradients;
            let of_stage = named.iter().filter(|(name, _)| name.starts_with(stage));
            of_stage.flat_map(|(_, matrix)| matrix.data()).map(|&g| f64::from(g).powi(2)).sum()
        };
        assert_eq!(squares("", "point_sampler"), 0.0);
        assert!(squares("end_to_end = true", "point_sampler") > 0.0);
        let others = ["", "end_to_end = true"].map(|toml| squares(toml, "face_classifier"));
        assert!(others[0] > 0.0 && others[0] == others[1]);
    }

    #[test]
    fn a_cloud_is_judged_by_the_mesh_it_came_from() {
        let (mesh, cloud) = (terms("clouds = 0.0"), terms("clouds = 1.0"));
        let names = |terms: &[(&'static str, f64)]| terms.iter().map(|term| term.0).collect::<Vec<_>>();
        assert_eq!(names(&mesh), names(&cloud));
        assert_ne!(mesh, cloud);
        assert!(cloud.iter().all(|term| term.1.is_finite()) && cloud.iter().any(|term| term.0 == "agreement"));
    }

    #[test]
    fn samples_of_a_noisy_mesh_are_measured_by_the_mesh_without_noise() {
        let value = |toml: &str, seed| {
            let found = step_of_seed(toml, seed).terms;
            found.iter().find(|term| term.0 == "deviation").map(|term| term.1)
        };
        assert_eq!(value("noise = 0", 0), None);
        // Half of the steps have no noise.
        let largest = |noise: f64| {
            let of_seed = |seed| value(&format!("noise = {noise}"), seed).unwrap();
            (0..8).map(of_seed).fold(0.0, f64::max)
        };
        let [little, much] = [0.01, 1.0].map(largest);
        assert!(little > 0.0 && little < 1e-3 && much > 1e-2, "{little} {much}");
    }

    #[test]
    fn the_printed_losses_have_nothing_of_ours_among_them() {
        let printed = ["chamfer", "forward", "reverse", "collision", "crossing", "overlap"];
        let toml = "literal = true\nlambda_closure = 0.0\nlambda_agreement = 0.0";
        assert_eq!(terms(toml).iter().map(|term| term.0).collect::<Vec<_>>(), printed);
    }
}
