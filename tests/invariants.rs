//! Invariants of results, over shapes and random closed meshes of very uneven sampling.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use glam::{Quat, Vec3};

use crate::common::{assert_closed_manifold, assert_same_topology, simplify_valid, uneven_closed_mesh};
use neural_mesh::io::{self, Format};
use neural_mesh::linalg::test_values::run_on_threads;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{Frame, TriMesh, shapes, topology};
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::simplify::{ClosedOptions, Options, Outcome, Simplified, SimplifyError, Size, simplify};
use proptest::prelude::*;

fn simplify_to(mesh: &TriMesh, target: Size) -> Simplified {
    simplify_valid(mesh, &Options::new(target))
}

// Returns the mesh after an STL round trip, welded by position.
fn through_stl(mesh: &TriMesh) -> TriMesh {
    let bytes = io::write(mesh, &Frame::default(), Format::Stl).unwrap();
    clean(io::read(&bytes, None).unwrap(), &CleanOptions::default()).unwrap().mesh
}

#[test]
fn corners_and_creases_of_large_parts_stay() {
    // The box has more vertices than one collapse takes from a scan.
    let size = [3.0, 2.0, 1.0];
    let mesh = shapes::cuboid(size, 60);
    assert!(mesh.positions().len() > 20_000);
    let lighter = simplify_to(&mesh, Size::Ratio(0.01));
    let bounds: [f32; 3] = size.map(|x| x as f32);
    for corner in 0..8 {
        let place: [f32; 3] = std::array::from_fn(|k| if corner >> k & 1 == 1 { bounds[k] } else { 0.0 });
        let distance = |p: &[f32; 3]| (0..3).map(|k| (p[k] - place[k]).abs()).fold(0.0, f32::max);
        let nearest = lighter.mesh.positions().iter().map(distance).fold(f32::INFINITY, f32::min);
        assert!(nearest < 1e-4, "{place:?} {nearest}");
    }
    // Distance to a crease is measured inside and outside; the sides of the box bound it.
    for p in lighter.mesh.positions() {
        let inside = (0..3).map(|k| p[k].min(bounds[k] - p[k])).fold(f32::INFINITY, f32::min);
        assert!(inside.abs() < 1e-4, "{p:?}");
    }
}

// Builds a prism or a double pyramid over a regular polygon, with one more point per edge at each subdivision.
fn polyhedron(is_prism: bool, n: u32, height: f32, n_subdivisions: u32) -> TriMesh {
    let corner = |i: u32, z: f32| {
        let angle = std::f32::consts::TAU * i as f32 / n as f32;
        [angle.cos(), angle.sin(), z]
    };
    let sides = (0..n).map(|i| (i, (i + 1) % n));
    let (positions, faces): (Vec<[f32; 3]>, Vec<[u32; 3]>) = if is_prism {
        let walls = sides.flat_map(|(i, j)| [[i, j, n + j], [i, n + j, n + i]]);
        let ends = (1..n - 1).flat_map(|i| [[0, i + 1, i], [n, n + i, n + i + 1]]);
        let corners = [0.0, height].into_iter().flat_map(|z| (0..n).map(move |i| corner(i, z)));
        (corners.collect(), walls.chain(ends).collect())
    } else {
        let corners = (0..n).map(|i| corner(i, 0.0)).chain([[0.0, 0.0, height], [0.0, 0.0, -height]]);
        (corners.collect(), sides.flat_map(|(i, j)| [[i, j, n], [j, i, n + 1]]).collect())
    };
    (0..n_subdivisions).fold(TriMesh::new(positions, faces).unwrap(), |mesh, _| subdivide(&mesh))
}

fn subdivide(mesh: &TriMesh) -> TriMesh {
    let mut positions = mesh.positions().to_vec();
    let mut middles = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let [p, q] = [a, b].map(|v| mesh.positions()[v as usize]);
            positions.push([0, 1, 2].map(|k| 0.5 * (p[k] + q[k])));
            positions.len() as u32 - 1
        })
    };
    let mut faces = Vec::new();
    for &[a, b, c] in mesh.faces() {
        let [x, y, z] = [middle(a, b), middle(b, c), middle(c, a)];
        faces.extend([[a, x, z], [x, b, y], [z, y, c], [x, y, z]]);
    }
    TriMesh::new(positions, faces).unwrap()
}

// Expects a closed mesh of the target size that survives welding, with all components but those reported as dropped.
fn check(original: &TriMesh, ratio: f64) {
    let target = Size::Ratio(ratio);
    let result = check_with(original, ratio, &Options::new(target));
    let components = topology(original).components - result.report.components_pruned;
    assert_eq!(topology(&result.mesh).components, components);
    let whole = ClosedOptions { prune: false, ..ClosedOptions::default() };
    let result = check_with(original, ratio, &Options::with_closed(target, whole));
    assert_same_topology(original, &result.mesh);
}

fn check_with(original: &TriMesh, ratio: f64, options: &Options) -> Simplified {
    let n_vertices = original.positions().len();
    let result = simplify_valid(original, options);
    assert_closed_manifold(&result.mesh);
    let welded = through_stl(&result.mesh);
    assert_closed_manifold(&welded);
    assert_eq!(welded.positions().len(), result.mesh.positions().len());
    let asked = (n_vertices as f64 * ratio) as usize;
    match result.report.outcome {
        Outcome::Reached => assert!((asked.saturating_sub(1)..=asked).contains(&result.mesh.positions().len())),
        Outcome::Stopped(_) => assert!(result.mesh.positions().len() > asked),
    }
    result
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn polyhedra_come_back_exactly(
        is_prism: bool,
        n in 3..9u32,
        height in 0.2..3.0f32,
        n_subdivisions in 1..5u32,
        turn in prop::array::uniform3(-3.0..3.0f32),
    ) {
        let [coarse, fine] = [0, n_subdivisions].map(|times| polyhedron(is_prism, n, height, times));
        let rotation = Quat::from_scaled_axis(turn.into());
        let turned = fine.positions().iter().map(|&p| (rotation * Vec3::from(p)).to_array()).collect();
        let fine = TriMesh::new(turned, fine.faces().to_vec()).unwrap();
        let result = simplify_to(&fine, Size::Vertices(coarse.positions().len()));
        prop_assert_eq!(result.mesh.positions().len(), coarse.positions().len());
        assert_closed_manifold(&result.mesh);
        let [found, expected] = [&result.mesh, &fine].map(|mesh| Surface::new(mesh, 2000, 0));
        let distance = surface_distance(&found, &expected).unwrap().both.max;
        prop_assert!(distance < 1e-4 * fine.diagonal(), "{}", distance / fine.diagonal());
    }

    #[test]
    fn closed_stays_closed(mesh in uneven_closed_mesh(), ratio in 0.02..1.0f64) {
        check(&mesh, ratio);
    }
}

#[test]
fn closed_shapes_stay_closed() {
    let shapes = [
        shapes::icosphere(4),
        shapes::torus(60, 24, 1.0, 0.25),
        shapes::cuboid([4.0, 0.05, 3.0], 20),
        shapes::bolt(48),
        shapes::wavy_sphere(4, 20.0),
        shapes::many_boxes(4),
    ];
    for shape in &shapes {
        for ratio in [0.01, 0.1, 0.5, 0.9] {
            check(shape, ratio);
        }
    }
}

#[test]
fn threads_and_repetition_change_no_bit() {
    // The second mesh is large enough for parallel runs and blocks.
    for (mesh, ratio) in [(shapes::wavy_sphere(5, 20.0), 0.1), (shapes::torus(600, 300, 1.0, 0.4), 0.15)] {
        let with = |n| run_on_threads(n, || simplify_to(&mesh, Size::Ratio(ratio)));
        let first = with(1);
        for n_threads in [1, 2, 8] {
            assert_eq!(with(n_threads), first);
        }
    }
}

#[test]
fn what_is_collapsed_in_blocks_is_closed_and_of_the_size_asked_for() {
    let mesh = shapes::torus(600, 300, 1.0, 0.4);
    for ratio in [0.02, 0.15, 0.5, 0.9] {
        let lighter = simplify_to(&mesh, Size::Ratio(ratio));
        assert_eq!(lighter.mesh.positions().len(), (ratio * mesh.positions().len() as f64) as usize);
        assert_closed_manifold(&lighter.mesh);
        assert_same_topology(&mesh, &lighter.mesh);
    }
}

#[test]
fn progress_moves_forward_and_can_stop_the_run() {
    let mesh = shapes::icosphere(4);
    let mut stages: Vec<&str> = Vec::new();
    let options = Options::new(Size::Ratio(0.1));
    let done = simplify(&mesh, &options, &mut |event| {
        assert!((0.0..=1.0).contains(&event.done));
        if stages.last() != Some(&event.stage) {
            stages.push(event.stage);
        }
        ControlFlow::Continue(())
    });
    assert!(done.is_ok() && stages.len() > 3, "{stages:?}");
    for stop_after in 0..stages.len() {
        let mut heard = 0;
        let stopped = simplify(&mesh, &options, &mut |_| {
            heard += 1;
            if heard > stop_after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(stopped, Err(SimplifyError::Interrupted), "{stop_after}");
    }
}
