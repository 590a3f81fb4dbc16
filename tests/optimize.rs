//! Each `Optimize` is best by its own measure, and each `Effort` is closer than the previous one.

use std::ops::ControlFlow;
use std::path::Path;

use crate::common::{assert_closed_manifold, assert_same_topology};
use neural_mesh::io::read_path;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::simplify::{ClosedOptions, Effort, Optimize, Options, ScoreSource, Simplified, Target, simplify};

const NAMES: [&str; 2] = ["nefertiti.ply", "spot.ply"];

fn mesh(name: &str) -> TriMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes").join(name);
    clean(read_path(&path, None).unwrap(), &CleanOptions::default()).unwrap().mesh
}

fn simplify_to_ratio(mesh: &TriMesh, ratio: f64, optimize: Optimize, effort: Effort) -> Simplified {
    let options = ClosedOptions { optimize, effort, ..ClosedOptions::default() };
    simplify(mesh, None, &Options::with_closed(Target::Ratio(ratio), options), &mut |_| ControlFlow::Continue(()))
        .unwrap()
}

// Returns the logarithms of mean distance, largest distance and normal error, summed over meshes and ratios.
fn figures(optimize: Optimize, effort: Effort) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for name in NAMES {
        let mesh = mesh(name);
        let original = Surface::new(&mesh, 20_000, 1);
        for ratio in [0.05, 0.1, 0.2, 0.5] {
            let result = simplify_to_ratio(&mesh, ratio, optimize, effort).mesh;
            assert_closed_manifold(&result);
            assert_same_topology(&mesh, &result);
            let both = surface_distance(&original, &Surface::new(&result, 20_000, 2)).unwrap().both;
            let figures = [both.mean, both.max, both.normal_error];
            sums.iter_mut().zip(figures).for_each(|(sum, figure)| *sum += figure.ln());
        }
    }
    sums
}

#[test]
fn each_is_best_by_its_own_figure() {
    let [balanced, mean, max, normals] =
        [Optimize::Balanced, Optimize::Mean, Optimize::Max, Optimize::Normals].map(|of| figures(of, Effort::Standard));
    assert!(mean[0] < balanced[0] && mean[0] < max[0] && mean[0] < normals[0], "{mean:?} {balanced:?}");
    assert!(max[1] < balanced[1] && max[1] < mean[1], "{max:?} {balanced:?} {mean:?}");
    assert!(normals[2] < balanced[2] && normals[2] < mean[2], "{normals:?} {balanced:?} {mean:?}");
}

#[test]
fn the_more_effort_the_nearer() {
    for optimize in [Optimize::Balanced, Optimize::Mean, Optimize::Max] {
        let [fast, standard, best] =
            [Effort::Fast, Effort::Standard, Effort::Best].map(|effort| figures(optimize, effort)[0]);
        assert!(fast > standard && standard > best, "{optimize:?}: {fast} {standard} {best}");
    }
}

#[test]
fn the_mean_asks_for_no_scores_and_says_so() {
    let mesh = mesh(NAMES[0]);
    assert_eq!(simplify_to_ratio(&mesh, 0.1, Optimize::Mean, Effort::Standard).report.scores, ScoreSource::Geometry);
    assert_eq!(simplify_to_ratio(&mesh, 0.1, Optimize::Max, Effort::Standard).report.scores, ScoreSource::Bending);
}
