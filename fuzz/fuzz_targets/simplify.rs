//! Any small mesh and any request: a valid mesh of the asked size or a stated reason, closed where the input was.

#![no_main]

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{RawMesh, TriMesh, shapes, topology};
use neural_mesh::simplify::{Options, Outcome, Simplified, Target, simplify};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let [shape, size, oversample, flags, edits @ ..] = bytes else { return };
    let (positions, faces) = start(*shape);
    let mut raw = RawMesh { positions, faces, ..RawMesh::default() };
    edits.chunks_exact(4).for_each(|edit| apply([edit[0], edit[1], edit[2], edit[3]], &mut raw));
    let Ok(cleaned) = clean(raw, &CleanOptions { weld: flags & 1 == 0 }) else { return };
    let mesh = cleaned.mesh;
    let target = match flags >> 1 & 3 {
        0 => Target::Ratio(f64::from(*size) / 255.0),
        1 => Target::Vertices(*size as usize),
        _ => Target::Faces(*size as usize),
    };
    let oversample = (*oversample > 0).then(|| 1.0 + f64::from(*oversample) / 85.0);
    let options = Options { oversample, seed: u64::from(*flags), prune: flags & 8 != 0, ..Options::new(target) };
    if let Ok(result) = simplify(&mesh, &options, &mut |_| ControlFlow::Continue(())) {
        check(&mesh, &options, &result);
    }
});

/// A mesh to start from, as positions and faces.
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

/// One change: a vertex moves, by little or by far or onto another, or a face comes, goes or turns.
fn apply([kind, a, b, c]: [u8; 4], RawMesh { positions, faces, .. }: &mut RawMesh) {
    let n = positions.len();
    let (vertex, face) = (a as usize % n, a as usize % faces.len().max(1));
    match kind % 8 {
        0 | 1 => faces.push([a, b, c].map(|v| v as u32 % n as u32)),
        2 if !faces.is_empty() => drop(faces.swap_remove(face)),
        3 if !faces.is_empty() => faces[face].reverse(),
        4 => positions[vertex] = positions[b as usize % n],
        5 => positions[vertex][b as usize % 3] = f64::from(c as i8) / 16.0,
        6 => positions[vertex][b as usize % 3] *= 10f64.powi(c as i32 % 64 - 32),
        _ => positions[vertex][b as usize % 3] += f64::from(c as i8) * 1e-6,
    }
}

/// What the simplifier promises.
fn check(mesh: &TriMesh, options: &Options, result: &Simplified) {
    let (before, after) = (topology(mesh), topology(&result.mesh));
    let Simplified { mesh: lighter, report, .. } = result;
    assert!(!lighter.faces().is_empty());
    let places: BTreeSet<_> = lighter.positions().iter().map(|p| p.map(|x| (x + 0.0).to_bits())).collect();
    assert_eq!(places.len(), lighter.positions().len(), "positions shared {before:?} {after:?} {report:?}");
    if before.closed && before.non_manifold_edges == 0 && before.orientable {
        assert!(after.is_closed_manifold(), "{before:?} {after:?} {report:?}");
    }
    if report.outcome == Outcome::Reached {
        let (n_vertices, n_faces) = (lighter.positions().len(), lighter.faces().len());
        match options.target {
            Target::Ratio(ratio) => {
                assert!(n_vertices as f64 <= (ratio * mesh.positions().len() as f64).round().max(1.0))
            }
            Target::Vertices(target) => assert!(n_vertices <= target),
            Target::Faces(target) => assert!(n_faces <= target),
        }
    }
}
