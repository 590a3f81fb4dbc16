//! Figures of simplified meshes over their original.

use neural_mesh::appearance::{self, USUAL_HEIGHT, appearance};
use neural_mesh::job::{JobStage, Watch};
use neural_mesh::metrics::{CompareOptions, Figure, ReferenceMesh, compare};

use super::meshes::NamedMesh;
use crate::args::CompareArgs;
use crate::progress::Progress;

pub struct Comparison {
    pub original: NamedMesh,
    pub results: Vec<MeasuredResult>,
    pub options: CompareOptions,
}

pub struct MeasuredResult {
    pub mesh: NamedMesh,
    pub figures: Vec<Figure>,
}

pub fn measure_results(
    args: &CompareArgs,
    original: NamedMesh,
    simplified: Vec<NamedMesh>,
    progress: &mut Progress,
) -> Comparison {
    progress.begin(JobStage::Check);
    let mut options = CompareOptions::default();
    (options.samples, options.seed) = (args.samples, args.seed);
    let prepared = ReferenceMesh::new(&original.mesh, &options);
    let n_results = simplified.len() as f64;
    let measure = |(number, mesh): (usize, NamedMesh)| {
        progress.show_step_done(JobStage::Check, (number as f64 + 0.5) / (n_results + 0.5));
        let mut figures = compare(&prepared, &mesh.mesh);
        let similarity = appearance(original.to_shaded(), mesh.to_shaded(), USUAL_HEIGHT);
        // What a viewer sees comes after the distances.
        let at = figures.iter().position(|figure| figure.name == "distance_max").map_or(0, |at| at + 1);
        figures.splice(at..at, appearance::figures(similarity.as_ref()));
        MeasuredResult { figures, mesh }
    };
    let results = simplified.into_iter().enumerate().map(measure).collect();
    Comparison { original, results, options }
}
