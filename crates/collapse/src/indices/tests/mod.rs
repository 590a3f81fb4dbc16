//! Whole buffers before and after.

use super::*;
use crate::collapse::tests::measure::{count_boundary_edges, count_turned, distance, is_manifold};
use crate::collapse::tests::meshes::{TestMesh, bumpy_torus, terrain};

fn buffers(mesh: &TestMesh) -> IndexBuffers<'_> {
    IndexBuffers { indices: &mesh.faces, positions: &mesh.positions, ..IndexBuffers::default() }
}

fn run(buffers: &IndexBuffers, options: &IndexOptions) -> (TestMesh, IndexResult) {
    let result = simplify_indices(buffers, options).expect("the buffers are valid");
    let mut positions = buffers.positions.to_vec();
    result.write_moved(&mut positions, &mut buffers.attributes.to_vec());
    (TestMesh { positions, faces: result.indices.clone() }, result)
}

/// A mesh whose faces on one side of a cut have vertices of their own, and the side of each vertex.
///
/// `side` tells the side of a face by its mean position.
fn cut_apart(mesh: &TestMesh, side: impl Fn([f32; 3]) -> bool) -> (TestMesh, Vec<bool>) {
    let n = mesh.positions.len() as u32;
    let mut cut = TestMesh { positions: [&mesh.positions[..], &mesh.positions].concat(), faces: Vec::new() };
    for face in &mesh.faces {
        let mean = [0, 1, 2].map(|k| face.iter().map(|&v| mesh.positions[v as usize][k]).sum::<f32>() / 3.0);
        cut.faces.push(if side(mean) { face.map(|v| v + n) } else { *face });
    }
    (cut, (0..2 * n).map(|v| v >= n).collect())
}

#[test]
fn vertices_stay_where_they_were_unless_they_may_move() {
    let mesh = bumpy_torus(60, 30);
    for n in [1800, 720, 360] {
        let (subset, result) = run(&buffers(&mesh), &IndexOptions::new(n, 1.0));
        assert_eq!((subset.faces.len(), result.moved.len()), (n, 0));
        let options = IndexOptions { moves: true, ..IndexOptions::new(n, 1.0) };
        let (moved, _) = run(&buffers(&mesh), &options);
        assert_eq!(moved.faces.len(), n);
        for small in [&subset, &moved] {
            assert!(is_manifold(small) && count_boundary_edges(small) == 0 && count_turned(small, &mesh) == 0);
        }
        let (of_subset, of_moved) = (distance(&subset, &mesh), distance(&moved, &mesh));
        assert!(of_moved.0 < 0.8 * of_subset.0, "{of_moved:?} {of_subset:?}");
        // The estimate tells the largest distance within a factor of four.
        let estimate = result.error * measure_extent(&mesh.positions);
        let largest = of_subset.1 as f32;
        assert!(estimate > 0.25 * largest && estimate < 4.0 * largest, "{estimate} {largest}");
    }
}

#[test]
fn sides_of_a_seam_stay_apart_and_the_surface_closed() {
    let mesh = bumpy_torus(60, 30);
    // Two straight cuts, and one with ends and forks.
    let straight = |p: [f32; 3]| p[0] > 0.0;
    let ragged = |p: [f32; 3]| (p[0] * 9.0).sin() + (p[1] * 7.0).sin() > 0.8;
    let sides: [&dyn Fn([f32; 3]) -> bool; 2] = [&straight, &ragged];
    for side in sides {
        let (cut, side_of) = cut_apart(&mesh, side);
        for (n, moves) in [(1800, false), (720, false), (720, true), (360, true)] {
            let (small, result) = run(&buffers(&cut), &IndexOptions { moves, ..IndexOptions::new(n, 1.0) });
            assert_eq!(small.faces.len(), n);
            let welded = small.weld();
            assert_eq!((welded.faces.len(), count_boundary_edges(&welded)), (n, 0));
            assert!(is_manifold(&welded) && count_turned(&small, &cut) == 0);
            for (face, &source) in small.faces.iter().zip(&result.sources) {
                let of_source = side_of[cut.faces[source as usize][0] as usize];
                assert!(face.iter().all(|&v| side_of[v as usize] == of_source), "a face has corners of both sides");
            }
            assert!(distance(&small, &cut).0 < 0.02);
        }
    }
}

#[test]
fn faces_by_the_record_are_those_followed_from_pass_to_pass() {
    // Two tori that meet in a vertex, which is cut.
    let one = bumpy_torus(30, 15);
    let shift = [0, 1, 2].map(|k| one.positions[0][k] - one.positions[200][k]);
    let both = one.clone().join(one.move_by(shift)).weld();
    let mut with_copy = both.clone();
    with_copy.positions.push(both.positions[0]);
    for moves in [false, true] {
        let options = IndexOptions { moves, ..IndexOptions::new(300, 1.0) };
        let (small, result) = run(&buffers(&both), &options);
        let (followed, twin) = run(&buffers(&with_copy), &options);
        assert_eq!((small.faces.len(), &small.faces, result.sources), (300, &followed.faces, twin.sources));
        assert_eq!(small.positions, followed.positions[..small.positions.len()]);
        let (mean, largest) = distance(&small, &both);
        assert!(mean < 0.03 && largest < 0.3, "{mean} {largest}");
    }
}

#[test]
fn the_course_between_groups_is_kept() {
    let mesh = bumpy_torus(60, 30);
    let group = |face: &[u32; 3]| u32::from(face.iter().map(|&v| mesh.positions[v as usize][0]).sum::<f32>() > 0.0);
    let groups: Vec<u32> = mesh.faces.iter().map(group).collect();
    let find_shared = |faces: &[[u32; 3]], groups: &[u32]| {
        let mut used = vec![[false; 2]; mesh.positions.len()];
        for (face, &group) in faces.iter().zip(groups) {
            face.iter().for_each(|&v| used[v as usize][group as usize] = true);
        }
        used.into_iter().map(|used| used == [true; 2]).collect::<Vec<bool>>()
    };
    let grouped = IndexBuffers { groups: &groups, ..buffers(&mesh) };
    let (small, result) = run(&grouped, &IndexOptions::new(720, 1.0));
    assert_eq!((small.faces.len(), count_boundary_edges(&small)), (720, 0));
    let groups_left: Vec<u32> = result.sources.iter().map(|&face| groups[face as usize]).collect();
    let (before, after) = (find_shared(&mesh.faces, &groups), find_shared(&small.faces, &groups_left));
    assert!(after.contains(&true) && after.iter().zip(before).all(|(after, before)| before || !after));
}

#[test]
fn the_ends_of_a_cut_inside_the_surface_go_along_it() {
    // One edge apart in two: both ends have one wedge, the middle two.
    let mesh = terrain(20);
    let middle = mesh.positions.iter().position(|p| (p[0] - 0.5).abs() < 0.03 && (p[1] - 0.5).abs() < 0.03);
    let middle = middle.expect("the terrain has a middle") as u32;
    let mut cut = mesh.clone();
    cut.positions.push(mesh.positions[middle as usize]);
    let copy = cut.positions.len() as u32 - 1;
    for face in cut.faces.iter_mut().filter(|face| face.contains(&middle)).take(3) {
        *face = face.map(|v| if v == middle { copy } else { v });
    }
    let (small, _) = run(&buffers(&cut), &IndexOptions::new(40, 1.0));
    assert!(small.faces.len() <= 40 && is_manifold(&small.weld()));
    assert_eq!(count_boundary_edges(&small), count_boundary_edges(&small.weld()), "the cut is gone");
}

#[test]
fn linear_attributes_are_carried_exactly_and_steps_are_kept() {
    let mut mesh = terrain(30);
    mesh.positions.iter_mut().for_each(|p| p[2] = 0.0);
    let linear: Vec<f32> = mesh.positions.iter().flat_map(|p| [2.0 * p[0] - p[1] + 0.3, 7.0]).collect();
    let weighted = IndexBuffers { attributes: &linear, weights: &[0.5, 0.0], ..buffers(&mesh) };
    let options = IndexOptions { moves: true, ..IndexOptions::new(60, 1.0) };
    let (small, result) = run(&weighted, &options);
    assert!(small.faces.len() <= 60);
    for ((_, p), row) in result.moved.iter().zip(result.attributes.chunks(2)) {
        assert!((row[0] - (2.0 * p[0] - p[1] + 0.3)).abs() < 1e-4 && row[1] == 7.0, "{row:?}");
    }
    // A round spot of another colour: with weights its outline is kept.
    let spot: Vec<f32> =
        mesh.positions.iter().map(|p| if (p[0] - 0.5).hypot(p[1] - 0.5) < 0.3 { 1.0 } else { 0.0 }).collect();
    let error = |weight: f32| {
        let weights = [weight];
        let colored = IndexBuffers { attributes: &spot, weights: &weights, ..buffers(&mesh) };
        let (small, _) = run(&colored, &IndexOptions::new(200, 1.0));
        let lost = mesh.positions.iter().zip(&spot).map(|(p, color)| (color - interpolate(&small, &spot, *p)).abs());
        lost.sum::<f32>() / spot.len() as f32
    };
    let (with, without) = (error(1.0), error(0.0));
    assert!(with < 0.5 * without, "{with} {without}");
}

// The colour of a flat mesh at a point.
fn interpolate(mesh: &TestMesh, colors: &[f32], p: [f32; 3]) -> f32 {
    let area = |a: [f32; 3], b: [f32; 3], c: [f32; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let weigh = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| mesh.positions[v as usize]);
        let whole = area(a, b, c);
        [area(p, b, c) / whole, area(a, p, c) / whole, area(a, b, p) / whole]
    };
    let least = |weights: [f32; 3]| weights.into_iter().fold(f32::INFINITY, f32::min);
    let best = mesh.faces.iter().max_by(|x, y| least(weigh(x)).total_cmp(&least(weigh(y))));
    best.map_or(f32::NAN, |face| weigh(face).iter().zip(face).map(|(w, &v)| w * colors[v as usize]).sum())
}

#[test]
fn errors_bound_the_result_and_grow_with_it() {
    let mesh = bumpy_torus(60, 30);
    let mut n_before = mesh.faces.len() + 1;
    for max_error in [1e-4, 1e-3, 1e-2] {
        let (small, result) = run(&buffers(&mesh), &IndexOptions::new(0, max_error));
        assert!(result.error <= max_error && small.faces.len() < n_before);
        n_before = small.faces.len();
        let absolute = max_error * measure_extent(&mesh.positions);
        let options = IndexOptions { is_absolute: true, ..IndexOptions::new(0, absolute) };
        let (same, result) = run(&buffers(&mesh), &options);
        assert_eq!(same.faces, small.faces);
        assert!(result.error <= absolute);
    }
    // A size that is reached before the error is not passed.
    assert_eq!(run(&buffers(&mesh), &IndexOptions::new(2000, 0.1)).0.faces.len(), 2000);
}

#[test]
fn locked_vertices_and_boundaries_stay() {
    let mesh = terrain(30);
    let locks: Vec<bool> = (0..mesh.positions.len()).map(|v| v % 17 == 0).collect();
    for moves in [false, true] {
        let locked = IndexBuffers { locks: &locks, ..buffers(&mesh) };
        let (small, _) = run(&locked, &IndexOptions { moves, ..IndexOptions::new(400, 1.0) });
        for v in (0..mesh.positions.len()).filter(|v| locks[*v]) {
            assert_eq!(small.positions[v], mesh.positions[v]);
            assert!(small.faces.as_flattened().contains(&(v as u32)));
        }
        let options = IndexOptions { moves, locks_boundaries: true, ..IndexOptions::new(400, 1.0) };
        let (small, _) = run(&buffers(&mesh), &options);
        assert_eq!(count_boundary_edges(&small), count_boundary_edges(&mesh));
    }
}

#[test]
fn few_triangles_of_many_vertices_are_as_if_alone() {
    let (one, two) = (bumpy_torus(20, 10), bumpy_torus(30, 10).move_by([40.0, 0.0, 0.0]));
    let both = one.clone().join(two);
    let some = &both.faces[..one.faces.len()];
    let sparse = IndexOptions { is_sparse: true, ..IndexOptions::new(100, 0.5) };
    let result = simplify_indices(&IndexBuffers { indices: some, ..buffers(&both) }, &sparse).expect("it is valid");
    let alone = simplify_indices(&buffers(&one), &IndexOptions::new(100, 0.5)).expect("it is valid");
    assert_eq!((result.indices, result.error), (alone.indices, alone.error));
}

#[test]
fn small_components_go_where_they_may() {
    let small = TestMesh {
        positions: bumpy_torus(12, 6).positions.iter().map(|p| p.map(|x| 0.05 * x)).collect(),
        ..bumpy_torus(12, 6)
    };
    let mesh = bumpy_torus(30, 15).join(small.clone()).join(small.move_by([3.0, 0.0, 0.0]));
    let options = IndexOptions { prunes: true, ..IndexOptions::new(34, 1.0) };
    let (pruned, result) = run(&buffers(&mesh), &options);
    assert_eq!(pruned.faces.len(), 34);
    assert!(result.error > 0.0);
    let (kept, _) = run(&buffers(&mesh), &IndexOptions::new(34, 1.0));
    let count = |mesh: &TestMesh| mesh.faces.iter().filter(|face| face[0] as usize >= 30 * 15).count();
    assert_eq!(count(&pruned), 0);
    assert!(count(&kept) > 0);
    let left = prune_components(&buffers(&mesh), 0.1).expect("it is valid");
    assert_eq!(left.len(), 2 * 30 * 15);
}

#[test]
fn any_size_is_reached_by_cells() {
    let mesh = bumpy_torus(30, 15).join(bumpy_torus(30, 15).move_by([0.5, 0.2, 3.0]));
    for n in [500, 50, 7, 0] {
        let (faces, error) = simplify_sloppily(&buffers(&mesh), n, f32::INFINITY).expect("it is valid");
        assert!(faces.len() <= n && faces.len() >= n / 2, "{n}: {}", faces.len());
        assert!(error < 1.8, "{error}");
    }
    // What is locked stays, also where that is more than asked for.
    let locks: Vec<bool> = (0..mesh.positions.len()).map(|v| v % 3 != 0).collect();
    let (faces, _) = simplify_sloppily(&IndexBuffers { locks: &locks, ..buffers(&mesh) }, 1, 2.0).expect("it is valid");
    assert!(faces.len() > 1);
}

#[test]
fn selected_points_are_spread() {
    let mesh = bumpy_torus(60, 30);
    let chosen = select_points(&mesh.positions, &[], 0.0, 200).expect("it is valid");
    assert_eq!(chosen.len(), 200);
    assert!(chosen.windows(2).all(|pair| pair[0] < pair[1]));
    let nearest = |p: [f32; 3]| {
        let squared = |v: &u32| (0..3).map(|k| (mesh.positions[*v as usize][k] - p[k]).powi(2)).sum::<f32>();
        chosen.iter().map(squared).fold(f32::INFINITY, f32::min).sqrt()
    };
    let farthest = mesh.positions.iter().map(|p| nearest(*p)).fold(0.0, f32::max);
    assert!(farthest < 0.2 * measure_extent(&mesh.positions), "{farthest}");
}

#[test]
fn wrong_buffers_are_named() {
    let mesh = bumpy_torus(8, 4);
    let refuse =
        |buffers: &IndexBuffers| simplify_indices(buffers, &IndexOptions::new(10, 1.0)).expect_err("it is wrong");
    let wrong = [[0, 1, 900]];
    assert_eq!(refuse(&IndexBuffers { indices: &wrong, ..buffers(&mesh) }), CollapseError::IndexOutOfRange { face: 0 });
    let short = IndexBuffers { attributes: &[1.0], weights: &[1.0], ..buffers(&mesh) };
    assert_eq!(refuse(&short), CollapseError::WrongLength { what: "attributes" });
    assert_eq!(
        refuse(&IndexBuffers { locks: &[true], ..buffers(&mesh) }),
        CollapseError::WrongLength { what: "locks" }
    );
}
