//! Each `Optimize` is best by its own measure, and each `Effort` is closer than the previous one.

use std::path::Path;

use crate::common::{assert_closed_manifold, assert_same_topology, simplify_valid};
use neural_mesh::appearance::{USUAL_HEIGHT, appearance};
use neural_mesh::io::read_path;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{TriMesh, shapes, topology};
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::simplify::{ClosedOptions, Effort, Optimize, Options, ScoreSource, Simplified, Size};
use neural_mesh::spatial::FaceTree;

const NAMES: [&str; 2] = ["nefertiti.ply", "spot.ply"];

fn mesh(name: &str) -> TriMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes").join(name);
    clean(read_path(&path, None).unwrap(), &CleanOptions::default()).unwrap().mesh
}

fn simplify_to_ratio(mesh: &TriMesh, ratio: f64, optimize: Optimize, effort: Effort) -> Simplified {
    let options = ClosedOptions { optimize, effort, ..ClosedOptions::default() };
    simplify_valid(mesh, &Options::with_closed(Size::Ratio(ratio), options))
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

// Counts vertices that stand out from the original more than those around them.
fn count_spikes(original: &FaceTree, result: &TriMesh, least: f64) -> usize {
    let distance = |p: &[f32; 3]| original.nearest(p.map(f64::from).into()).unwrap().1.sqrt();
    let distances: Vec<f64> = result.positions().iter().map(distance).collect();
    let mut around = vec![(0.0, 0); distances.len()];
    for &[a, b, c] in result.faces() {
        for [v, w] in [[a, b], [b, c], [c, a]] {
            let (sum, n) = &mut around[v as usize];
            (*sum, *n) = (*sum + distances[w as usize], *n + 1);
        }
    }
    let is_spike = |(d, (sum, n)): &(&f64, &(f64, i32))| **d > least.max(5.5 * sum / f64::from(*n));
    distances.iter().zip(&around).filter(is_spike).count()
}

fn largest_component(mesh: &TriMesh) -> TriMesh {
    let options = ClosedOptions { prune_below: f64::MAX, ..ClosedOptions::default() };
    let whole = Options::with_closed(Size::Ratio(1.0), options);
    simplify_valid(mesh, &whole).mesh
}

#[test]
fn no_vertex_stands_out_as_a_spike() {
    let (mut n_shortened, mut n_left) = (0, 0);
    // Near another component, a vertex can be closer to it than to its own surface.
    for mesh in ["nefertiti.ply", "suzanne.ply"].map(|name| largest_component(&mesh(name))) {
        let original = FaceTree::new(mesh.positions(), mesh.faces());
        // Unit size is a diagonal of 0.7 to 1.4.
        let least = 3e-3 * 2_f64.sqrt() * mesh.diagonal();
        let efforts = [Effort::Fast, Effort::Standard];
        let goals = [Optimize::Balanced, Optimize::Mean, Optimize::Max, Optimize::Normals, Optimize::Looks];
        for (effort, optimize) in efforts.into_iter().flat_map(|effort| goals.map(|goal| (effort, goal))) {
            for ratio in [0.02, 0.1, 0.2] {
                let result = simplify_to_ratio(&mesh, ratio, optimize, effort);
                n_shortened += result.report.shortened_spikes;
                n_left += count_spikes(&original, &result.mesh, least);
            }
        }
    }
    assert!(n_shortened > 30 && n_left == 0, "{n_shortened} {n_left}");
}

#[test]
fn looks_are_best_where_much_is_hidden() {
    // A nut in its shell: the nut has as many vertices, but nobody sees it.
    let (shell, nut) = (shapes::wavy_sphere(5, 12.0), shapes::wavy_sphere(5, 12.0));
    let both = shapes::unite([&shell, &shapes::place(&nut, |p| p.map(|x| 0.8 * x))]);
    for ratio in [0.03, 0.1] {
        let flip = |optimize| {
            let result = simplify_to_ratio(&both, ratio, optimize, Effort::Standard).mesh;
            assert_closed_manifold(&result);
            appearance(&both, &result, USUAL_HEIGHT).unwrap().flip
        };
        let [balanced, looks] = [Optimize::Balanced, Optimize::Looks].map(flip);
        assert!(looks < 0.9 * balanced, "{ratio}: {looks} {balanced}");
    }
}

#[test]
fn an_eye_stays_in_its_socket_for_its_looks() {
    // A head with a hole over an eye: without the eye, the inside of the head would show.
    let (head, eye) = (shapes::icosphere(5), shapes::icosphere(2));
    let is_open = |face: &[u32; 3]| face.iter().all(|&v| head.positions()[v as usize][2] > 0.99);
    let open = head.faces().iter().copied().filter(|face| !is_open(face)).collect();
    let open = TriMesh::new(head.positions().to_vec(), open).unwrap();
    let both = shapes::unite([open, shapes::place(&eye, |[x, y, z]| [0.15 * x, 0.15 * y, 0.15 * z + 0.84])]);
    let n_components =
        |optimize| topology(&simplify_to_ratio(&both, 0.005, optimize, Effort::Standard).mesh).components;
    assert_eq!([Optimize::Balanced, Optimize::Looks].map(n_components), [1, 2]);
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
