//! Small random meshes and requests: results are valid, of the target size or with a reason, and reproducible.

#![no_main]

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::mesh::{RawMesh, Topology, TriMesh, shapes, topology};
use neural_mesh::simplify::{ClosedOptions, Options, Outcome, Simplified, SimplifyError, Size, simplify};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let [shape, size, flags, edits @ ..] = bytes else { return };
    let (positions, faces) = start(*shape);
    let mut raw = RawMesh::new(positions, faces);
    raw.double = flags & 16 != 0;
    edits.chunks_exact(4).for_each(|edit| apply([edit[0], edit[1], edit[2], edit[3]], &mut raw));
    let mut cleaning = CleanOptions::default();
    cleaning.weld = flags & 1 == 0;
    let Ok(cleaned) = clean(raw, &cleaning) else { return };
    let target = match flags >> 1 & 3 {
        0 => Size::Ratio(f64::from(*size) / 255.0),
        1 => Size::Vertices(*size as usize),
        2 => Size::FaceRatio(f64::from(*size) / 255.0),
        _ => Size::Faces(*size as usize),
    };
    let (prune, frame) = (flags & 8 != 0, cleaned.frame);
    let options = Options::with_closed(target, ClosedOptions { prune, frame, ..ClosedOptions::default() });
    let run = || simplify(&cleaned.mesh, &options, &mut |_| ControlFlow::Continue(()));
    let result = run();
    assert_eq!(result, run());
    match result {
        Ok(result) => check(&cleaned, &options, &result),
        Err(SimplifyError::BadTarget(_)) => assert_eq!(*size, 0),
        Err(SimplifyError::Overflow) => assert!(reach(&cleaned.mesh) > 1e37),
        Err(error) => panic!("{error}"),
    }
});

fn reach(mesh: &TriMesh) -> f32 {
    mesh.positions().iter().flatten().fold(0.0, |most, x| most.max(x.abs()))
}

fn start(shape: u8) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mesh = match shape % 12 {
        0 => return ((0..16u32).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect(), Vec::new()),
        1 => shapes::tetrahedron(),
        2 => shapes::cuboid([1.0, 2.0, 3.0], 3),
        3 => shapes::icosphere(2),
        4 => shapes::torus(12, 8, 2.0, 0.7),
        5 => shapes::grid(8, 6),
        6 => shapes::open_cylinder(12, 4),
        7 => shapes::moebius_strip(16, 3),
        8 => shapes::chain_of_tori(2),
        9 => shapes::touching_spheres(1),
        10 => shapes::thin_sheet(5, 1e-3),
        _ => shapes::klein_bottle(12, 8),
    };
    let (positions, faces) = mesh.into_parts();
    (positions.into_iter().map(|p| p.map(f64::from)).collect(), faces)
}

// Applies one change: moves a vertex, shrinks or snaps all, or adds, removes, flips or splits a face.
fn apply([kind, a, b, c]: [u8; 4], RawMesh { positions, faces, .. }: &mut RawMesh) {
    let n = positions.len();
    let (vertex, face, axis) = (a as usize % n, a as usize % faces.len().max(1), b as usize % 3);
    match kind % 12 {
        0 => faces.push([a, b, c].map(|v| v as u32 % n as u32)),
        1 if !faces.is_empty() => drop(faces.swap_remove(face)),
        2 if !faces.is_empty() => faces[face].reverse(),
        3 => positions[vertex] = positions[b as usize % n],
        4 => positions[vertex][axis] = f64::from(c as i8) / 16.0,
        5 => positions[vertex][axis] *= 10f64.powi(c as i32 % 64 - 32),
        6 => positions[vertex][axis] += f64::from(c as i8) * 1e-6,
        7 => positions.iter_mut().for_each(|p| p[axis] *= 10f64.powi(c as i32 % 16 - 12)),
        8 => positions.iter_mut().for_each(|p| p[axis] = (p[axis] * f64::from(c)).round() / f64::from(c.max(1))),
        _ if !faces.is_empty() => split(positions, faces, face, [b, c].map(|x| f64::from(x) / 255.0)),
        _ => {}
    }
}

// Splits a face in three at a point on its median.
fn split(positions: &mut Vec<[f64; 3]>, faces: &mut Vec<[u32; 3]>, face: usize, [s, t]: [f64; 2]) {
    let corners = faces[face];
    let [p, q, r] = corners.map(|v| positions[v as usize]);
    positions.push(std::array::from_fn(|k| (1.0 - s) * p[k] + s * ((1.0 - t) * q[k] + t * r[k])));
    let middle = positions.len() as u32 - 1;
    faces.swap_remove(face);
    faces.extend((0..3).map(|i| [corners[i], corners[(i + 1) % 3], middle]));
}

fn check(Cleaned { mesh, frame, .. }: &Cleaned, options: &Options, result: &Simplified) {
    let (before, after) = (topology(mesh), topology(&result.mesh));
    let story = format!("{before:?} {after:?} {options:?} {:?}", result.report);
    let places: BTreeSet<_> = result.mesh.positions().iter().map(|&p| frame.to_file(p).map(key)).collect();
    assert_eq!(places.len(), after.vertices, "positions shared, {story}");
    assert_eq!(after.unreferenced_vertices, 0, "vertices unused, {story}");
    assert!(after.faces > 0, "nothing left, {story}");
    assert_eq!(after.non_manifold_edges + after.non_manifold_vertices, 0, "not a manifold, {story}");
    // Sheets that met in an edge may be joined to a one-sided surface.
    if after.orientable {
        assert_eq!(after.inconsistent_edges, 0, "wound differently, {story}");
    }
    if before.non_manifold_edges == 0 {
        check_topology(&before, &after, result.report.components_pruned, &story);
    }
    check_size(&before, &after, options, result, &story);
}

// Returns a key that equal numbers share.
fn key(x: f64) -> u64 {
    (x + 0.0).to_bits()
}

fn check_topology(before: &Topology, after: &Topology, n_pruned: usize, story: &str) {
    let figures = |t: &Topology| (t.orientable, t.closed, t.components, t.genus, t.boundary_loops);
    if n_pruned == 0 {
        assert_eq!(figures(before), figures(after), "another surface, {story}");
        let euler = |t: &Topology| t.edges as i64 - t.faces as i64 - t.vertices as i64;
        let is_manifold = before.non_manifold_vertices == 0;
        assert!(!is_manifold || euler(before) == euler(after), "another surface, {story}");
    } else {
        let separate = before.non_manifold_vertices == 0;
        assert!(!separate || after.components + n_pruned == before.components, "pieces lost, {story}");
        assert!(after.components < before.components, "{story}");
        assert!(!before.closed || after.closed, "opened, {story}");
        assert!(after.boundary_loops <= before.boundary_loops, "{story}");
    }
}

// Checks that the size is the target's, unless components were pruned or the input was already smaller.
fn check_size(before: &Topology, after: &Topology, options: &Options, result: &Simplified, story: &str) {
    let is_of_faces = options.target.is_of_faces();
    let (was, is) = if is_of_faces { (before.faces, after.faces) } else { (before.vertices, after.vertices) };
    let asked = options.target.count(was);
    if result.report.outcome == Outcome::Reached {
        let split = if was <= asked { result.report.split_vertices } else { 0 };
        assert!(is <= asked + split, "too large, {story}");
        assert!(is + 1 >= asked.min(was) || result.report.components_pruned > 0, "too small, {story}");
    } else {
        assert!(is > asked, "stopped below the target, {story}");
    }
}
