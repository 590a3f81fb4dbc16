//! Whole meshes before and after.

use super::measure::{count_boundary_edges, count_turned, distance, is_manifold, volume};
use super::meshes::{TestMesh, box_of_squares, bumpy_torus, cone, double_cone, sheet, terrain};
use std::ops::ControlFlow;
use std::sync::Mutex;

use crate::collapse::CollapseSize::{self, Faces, Vertices};
use crate::collapse::{
    CollapseError, CollapseOptions, CollapseOutcome, CollapseResult, CollapseTurn, collapse, collapse_in_turn,
};

fn run(mesh: &TestMesh, size: CollapseSize, options: &CollapseOptions) -> (TestMesh, CollapseResult) {
    let result = collapse(&mesh.positions, &mesh.faces, size, options).expect("the mesh is valid");
    (TestMesh { positions: result.positions.clone(), faces: result.faces.clone() }, result)
}

fn with_fit(n_fit_steps: usize) -> CollapseOptions<'static> {
    CollapseOptions { n_fit_steps, ..CollapseOptions::default() }
}

#[test]
fn closed_meshes_stay_closed_manifold_near_and_reach_the_size() {
    for (mesh, most) in [(bumpy_torus(60, 30), 0.02), (box_of_squares(12), 1e-4), (double_cone(200), 0.01)] {
        let mean_area = mesh.faces.len();
        for n in [mean_area / 2, mean_area / 5, mean_area / 10] {
            for n_fit_steps in [0, 2] {
                let (small, result) = run(&mesh, Faces(n), &with_fit(n_fit_steps));
                assert_eq!(result.outcome, CollapseOutcome::Reached);
                assert!(small.faces.len() == n || small.faces.len() == n - n % 2, "{} {n}", small.faces.len());
                assert!(is_manifold(&small));
                assert_eq!(count_boundary_edges(&small), 0);
                assert_eq!(count_boundary_edges(&small.weld()), 0);
                assert_eq!(count_turned(&small, &mesh), 0, "{most} {n} {n_fit_steps}");
                let (mean, largest) = distance(&small, &mesh);
                assert!(mean < most && largest < 8.0 * most, "{n}: {mean} {largest}");
                assert!((volume(&small) / volume(&mesh) - 1.0).abs() < 0.02);
            }
        }
    }
}

#[test]
fn boundaries_stay_boundaries_and_keep_their_course() {
    let mesh = terrain(40);
    for n in [1600, 640, 200] {
        let (small, result) = run(&mesh, Faces(n), &with_fit(2));
        assert!(small.faces.len() == n || small.faces.len() == n - 1);
        assert_eq!(result.outcome, CollapseOutcome::Reached);
        assert!(is_manifold(&small) && count_boundary_edges(&small) > 3);
        assert_eq!(count_turned(&small, &mesh), 0);
        let (mean, largest) = distance(&small, &mesh);
        assert!(mean < 0.004 && largest < 0.04, "{n}: {mean} {largest}");
        // Corners of the square are still there.
        let reach = |k: usize, is_high: bool| {
            let bound = if is_high { f32::max } else { f32::min };
            small.positions.iter().map(|p| p[k]).fold(small.positions[0][k], bound)
        };
        for k in 0..2 {
            assert!(reach(k, false).abs() < 0.02 && (reach(k, true) - 1.0).abs() < 0.02);
        }
    }
}

#[test]
fn vertices_can_be_asked_for_exactly() {
    for mesh in [bumpy_torus(40, 20), terrain(20)] {
        for n in [mesh.positions.len() / 3, mesh.positions.len() / 7] {
            let (small, _) = run(&mesh, Vertices(n), &CollapseOptions::default());
            assert_eq!(small.positions.len(), n);
            assert!(is_manifold(&small));
        }
    }
}

#[test]
fn the_rim_of_a_sheet_without_thickness_keeps_its_course() {
    let mesh = sheet(24);
    for n in [mesh.faces.len() / 5, 100, 40] {
        let (small, result) = run(&mesh, Faces(n), &CollapseOptions::default());
        assert_eq!(result.outcome, CollapseOutcome::Reached);
        assert!(is_manifold(&small) && count_boundary_edges(&small) == 0);
        let (mean, largest) = distance(&small, &mesh);
        assert!(mean < 1e-3 && largest < 0.02, "{n}: {mean} {largest}");
    }
}

#[test]
fn components_without_a_merge_do_not_keep_others_from_merging() {
    // Tetrahedra are the cheapest of all, and as small as a closed surface can be.
    let mut mesh = bumpy_torus(60, 30);
    for i in 0..300u32 {
        let at = [i as f32 * 0.01, 0.005, 0.02];
        let first = mesh.positions.len() as u32;
        for corner in [[0.0f32; 3], [1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]] {
            mesh.positions.push([0, 1, 2].map(|k| at[k] + corner[k]));
        }
        mesh.faces.extend([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|face| face.map(|v| v + first)));
    }
    for n_of_torus in [1000, 200] {
        let n = n_of_torus + 4 * 300;
        let (small, result) = run(&mesh, Faces(n), &CollapseOptions::default());
        assert_eq!((small.faces.len(), result.outcome), (n, CollapseOutcome::Reached));
        assert!(is_manifold(&small) && count_boundary_edges(&small) == 0);
        // Components are dropped by these prices.
        assert!(result.pass_prices.iter().all(|(_, price)| price.is_finite()));
    }
}

#[test]
fn any_degree_collapses() {
    for mesh in [double_cone(3000), cone(3000)] {
        let n = mesh.faces.len() / 10;
        let (small, result) = run(&mesh, Faces(n), &with_fit(1));
        assert_eq!((small.faces.len(), result.outcome), (n, CollapseOutcome::Reached));
        assert!(is_manifold(&small));
        let (mean, largest) = distance(&small, &mesh);
        assert!(largest < 0.01, "{mean} {largest}");
    }
}

#[test]
fn threads_do_not_change_the_bits() {
    // Several stretches.
    let mesh = bumpy_torus(600, 200);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads can be started");
    for n in [120_000, 20_001] {
        let options = with_fit(1);
        let (one, result) = run(&mesh, Faces(n), &options);
        assert_eq!(one.faces.len(), n - n % 2);
        assert!(is_manifold(&one) && count_boundary_edges(&one) == 0);
        let (three, other) = pool.install(|| run(&mesh, Faces(n), &CollapseOptions { n_threads: 0, ..options }));
        assert_eq!(one.faces, three.faces);
        let bits = |mesh: &TestMesh| mesh.positions.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&one), bits(&three));
        assert_eq!(result.record.vertices_after(9), other.record.vertices_after(9));
    }
}

#[test]
fn locked_vertices_keep_their_bits() {
    let mesh = bumpy_torus(40, 20);
    let locked: Vec<bool> = (0..mesh.positions.len()).map(|v| v % 9 == 0).collect();
    let (small, result) = run(&mesh, Faces(400), &CollapseOptions { locked: &locked, ..with_fit(2) });
    assert!(is_manifold(&small));
    let numbers = result.record.vertices_after(result.record.n_passes());
    for (v, p) in mesh.positions.iter().enumerate().filter(|(v, _)| locked[*v]) {
        assert_eq!(&small.positions[numbers[v] as usize], p);
    }
}

#[test]
fn the_record_leads_from_each_vertex_to_one_near_it() {
    let mesh = bumpy_torus(60, 30);
    let (small, result) = run(&mesh, Faces(720), &with_fit(0));
    let numbers = result.record.vertices_after(result.record.n_passes());
    assert_eq!(numbers.len(), mesh.positions.len());
    let mut is_met = vec![false; small.positions.len()];
    for (v, &number) in numbers.iter().enumerate() {
        is_met[number as usize] = true;
        let (p, q) = (mesh.positions[v], small.positions[number as usize]);
        let squared: f32 = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum();
        assert!(squared.sqrt() < 0.8, "{p:?} {q:?}");
    }
    assert!(is_met.into_iter().all(|x| x));
    // A prefix leads to a larger mesh whose faces, mapped, are the input's.
    let half = result.record.vertices_after(2);
    assert_eq!(half.iter().max().map_or(0, |last| last + 1), result.record.n_vertices(2) as u32);
}

#[test]
fn components_that_touch_stay_closed_and_apart() {
    // Two boxes with one edge at the same place, and two with one corner.
    let edge = box_of_squares(6).join(box_of_squares(6).move_by([1.0, 1.0, 0.0])).weld();
    let corner = box_of_squares(6).join(box_of_squares(6).move_by([1.0, 1.0, 1.0])).weld();
    for mesh in [edge, corner] {
        assert!(!is_manifold(&mesh));
        assert_eq!(count_boundary_edges(&mesh), 0);
        let (small, _) = run(&mesh, Faces(mesh.faces.len() / 4), &with_fit(2));
        assert!(is_manifold(&small));
        assert_eq!(count_boundary_edges(&small), 0);
        assert_eq!(count_boundary_edges(&small.weld()), 0);
        assert!(small.faces.len() <= mesh.faces.len() / 4);
        assert!(distance(&small, &mesh).1 < 1e-4);
    }
}

#[test]
fn what_cannot_be_a_disk_stays_as_closed_as_it_was() {
    // A fin on a box: an edge of three faces.
    let mut mesh = box_of_squares(6);
    let face = mesh.faces[0];
    mesh.positions.push([0.5, 0.5, 3.0]);
    let tip = mesh.positions.len() as u32 - 1;
    mesh.faces.push([face[0], face[1], tip]);
    let before = count_boundary_edges(&mesh);
    let (small, _) = run(&mesh, Faces(100), &with_fit(1));
    assert_eq!(count_boundary_edges(&small.weld()), before);
    // Faces that are there twice, and one without area.
    let mut mesh = bumpy_torus(20, 10);
    mesh.faces.extend([mesh.faces[3], mesh.faces[7], [4, 4, 9]]);
    let (small, _) = run(&mesh, Faces(150), &with_fit(0));
    assert!(small.faces.iter().flatten().all(|&v| (v as usize) < small.positions.len()));
}

#[test]
fn what_cannot_get_smaller_stops_short() {
    let (small, result) = run(&bumpy_torus(12, 8), Faces(2), &with_fit(0));
    assert_eq!(result.outcome, CollapseOutcome::Stopped);
    // A torus needs 14 faces.
    assert!(small.faces.len() >= 14 && is_manifold(&small) && count_boundary_edges(&small) == 0);
    let (same, result) = run(&box_of_squares(2), Faces(1000), &with_fit(2));
    assert_eq!((same.faces.len(), result.outcome, result.error), (48, CollapseOutcome::Reached, 0.0));
    let (none, _) = run(&TestMesh::default(), Faces(10), &with_fit(2));
    assert!(none.faces.is_empty());
}

#[test]
fn the_error_is_about_the_distance() {
    let mesh = bumpy_torus(60, 30);
    for n in [1800, 600, 300] {
        let (small, result) = run(&mesh, Faces(n), &with_fit(0));
        let (mean, largest) = distance(&small, &mesh);
        assert!(
            f64::from(result.error) > mean && f64::from(result.error) < 6.0 * largest,
            "{} {largest}",
            result.error
        );
    }
}

#[test]
fn huge_and_tiny_units_give_the_same_faces() {
    let mesh = bumpy_torus(30, 15);
    let (small, _) = run(&mesh, Faces(300), &with_fit(1));
    for scale in [2f32.powi(-110), 2f32.powi(120)] {
        let mut scaled = mesh.clone();
        scaled.positions.iter_mut().flatten().for_each(|x| *x *= scale);
        assert_eq!(run(&scaled, Faces(300), &with_fit(1)).0.faces, small.faces);
    }
}

#[test]
fn a_listener_hears_rising_shares_and_ends_the_collapse() {
    let mesh = bumpy_torus(60, 30);
    let (heard, last) = (Mutex::new(Vec::new()), 0.5);
    let listener = |share: f32| {
        heard.lock().map(|mut heard| heard.push(share)).expect("no other thread fails");
        if share < last { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let (_, result) = run(&mesh, Faces(100), &CollapseOptions { listener: Some(&listener), ..with_fit(1) });
    let heard = heard.into_inner().expect("no other thread fails");
    assert!(heard[0] == 0.0 && heard.is_sorted() && result.faces.len() > 100);
    // The fit is left out, too.
    assert_eq!((result.outcome, result.record.n_passes()), (CollapseOutcome::Stopped, heard.len() - 2));
    assert!(heard[heard.len() - 2] >= last && heard[heard.len() - 1] == 1.0);
}

#[test]
fn bad_input_is_refused_with_its_place() {
    let mesh = box_of_squares(2);
    let refuse = |mesh: &TestMesh, options: &CollapseOptions| {
        collapse(&mesh.positions, &mesh.faces, Faces(10), options).expect_err("the mesh is not valid")
    };
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut broken = mesh.clone();
        broken.positions[5][1] = bad;
        assert_eq!(refuse(&broken, &with_fit(0)), CollapseError::NotFinite { vertex: 5 });
    }
    let mut broken = mesh.clone();
    broken.faces[7][2] = 99;
    assert_eq!(refuse(&broken, &with_fit(0)), CollapseError::IndexOutOfRange { face: 7 });
    // A face twice.
    let mut broken = mesh.clone();
    broken.faces.push(broken.faces[0]);
    assert_eq!(refuse(&broken, &CollapseOptions { cuts: false, ..with_fit(0) }), CollapseError::NotManifold);
    let options = CollapseOptions { locked: &[true], ..with_fit(0) };
    assert_eq!(refuse(&mesh, &options), CollapseError::WrongLength { what: "locks" });
}

#[test]
fn sizes_in_turn_begin_with_the_one_alone_and_all_are_manifold() {
    let mesh = bumpy_torus(48, 32);
    let options = with_fit(2);
    let (alone, _) = run(&mesh, Faces(1000), &options);
    let collect = |sizes: &[CollapseSize], keeps_way: bool| {
        let mut results = Vec::new();
        let turn = |i: usize| CollapseTurn { size: sizes[i], is_last: i + 1 == sizes.len(), keeps_way };
        let receive = |result| {
            results.push(result);
            (results.len() < sizes.len()).then(|| turn(results.len()))
        };
        collapse_in_turn(&mesh.positions, &mesh.faces, turn(0), &options, receive).expect("the mesh is valid");
        results
    };
    let results = collect(&[Faces(1000), Vertices(300), Faces(200), Vertices(500)], false);
    assert_eq!((&results[0].positions, &results[0].faces), (&alone.positions, &alone.faces));
    assert_eq!([results[1].positions.len(), results[2].faces.len(), results[3].faces.len()], [300, 200, 200]);
    let there_and_back = collect(&[Vertices(20), Vertices(300), Vertices(1000), Vertices(100)], true);
    assert_eq!([0, 1, 2, 3].map(|i| there_and_back[i].positions.len()), [20, 300, 1000, 100]);
    let errors = &there_and_back[0].pass_errors;
    assert!(
        errors.is_sorted_by(|a, b| a.0 > b.0 && a.1 <= b.1)
            && errors.last() == Some(&(20, f64::from(there_and_back[0].error)))
    );
    for result in results.iter().chain(&there_and_back) {
        assert!(is_manifold(&TestMesh { positions: result.positions.clone(), faces: result.faces.clone() }));
        let became = result.record.vertices_after(result.record.n_passes());
        assert!(became.iter().all(|&v| (v as usize) < result.positions.len()));
    }
}
