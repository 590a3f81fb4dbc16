//! Shapes and indices of results.

use bevy_asset::RenderAssetUsages;
use bevy_mesh::{Indices, Mesh, PrimitiveTopology};
use neural_mesh::mesh::shapes;
use neural_mesh_bevy::{ClosedOptions, Outcome, Size, simplify_indices, simplify_mesh, simplify_mesh_to_error};

use crate::helpers::{corners, is_closed, long, n_points, none, positions, short, torus};

#[test]
fn closed_stays_closed_with_indices_of_the_same_size() {
    for (indices, is_short) in [(short as fn(_) -> _, true), (long, false), (none, true)] {
        let mesh = torus(indices);
        let light = simplify_mesh(&mesh, Size::Ratio(0.1), &ClosedOptions::default()).unwrap();
        assert_eq!(light.report.outcome, Outcome::Reached);
        let light = light.mesh;
        assert!(is_closed(&light));
        assert_eq!(n_points(&light), 204);
        assert_eq!(matches!(light.indices(), Some(Indices::U16(_))), is_short);
        // One vertex per position and wedge: nothing is repeated, nothing unused.
        let mut used = corners(&light);
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), light.count_vertices());
        assert!(light.count_vertices() < 204 + 60, "{} vertices", light.count_vertices());
    }
}

#[test]
fn fewer_triangles_over_the_same_vertices_stay_closed_with_all_attributes() {
    for (indices, is_short) in [(short as fn(_) -> _, true), (long, false)] {
        let mesh = torus(indices);
        let (indices, error) = simplify_indices(&mesh, 800, 1.0).unwrap();
        assert!(
            indices.len() <= 2400 && indices.len() > 2300 && error > 0.0 && error < 0.02,
            "{} {error}",
            indices.len()
        );
        assert_eq!(matches!(indices, Indices::U16(_)), is_short);
        let mut light = mesh.clone();
        light.insert_indices(indices);
        assert!(is_closed(&light) && light.count_vertices() == mesh.count_vertices());
        assert!(light.attribute(Mesh::ATTRIBUTE_UV_0) == mesh.attribute(Mesh::ATTRIBUTE_UV_0));
        assert!(simplify_indices(&mesh, 0, 0.5 * error).unwrap().0.len() > 2400);
    }
    assert_eq!(simplify_indices(&torus(none), 800, 1.0).unwrap().0.len(), 3 * 4096);
}

#[test]
fn a_mesh_without_indices_gives_the_result_of_one_with_indices() {
    let simplify = |mesh: &Mesh| simplify_mesh(mesh, Size::Faces(300), &ClosedOptions::default()).unwrap().mesh;
    let (indexed, loose) = (simplify(&torus(long)), simplify(&torus(none)));
    let triangles = |mesh: &Mesh| -> Vec<[f32; 3]> {
        corners(mesh).iter().map(|&corner| positions(mesh)[corner as usize]).collect()
    };
    assert_eq!(n_points(&indexed), n_points(&loose));
    assert_eq!(triangles(&indexed).len(), triangles(&loose).len());
}

#[test]
fn long_indices_are_used_where_short_ones_do_not_suffice() {
    let (positions, faces) = shapes::torus(400, 200, 1.0, 0.4).into_parts();
    let loose: Vec<[f32; 3]> = faces.as_flattened().iter().map(|&v| positions[v as usize]).collect();
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, loose);
    let whole = simplify_mesh(&mesh, Size::Ratio(1.0), &ClosedOptions::default()).unwrap().mesh;
    assert_eq!(whole.count_vertices(), 80_000);
    assert!(matches!(whole.indices(), Some(Indices::U32(_))) && is_closed(&whole));
}

#[test]
fn a_box_keeps_its_edges_and_normals() {
    let sides = shapes::cuboid([1.0, 2.0, 3.0], 8);
    let mut flat = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default()).with_inserted_attribute(
        Mesh::ATTRIBUTE_POSITION,
        sides.faces().as_flattened().iter().map(|&v| sides.positions()[v as usize]).collect::<Vec<_>>(),
    );
    flat.compute_flat_normals();
    let light = simplify_mesh(&flat, Size::Faces(12), &ClosedOptions::default()).unwrap().mesh;
    assert!(is_closed(&light));
    assert_eq!((n_points(&light), corners(&light).len()), (8, 36));
    assert!((24..=36).contains(&light.count_vertices()));
    for normal in crate::helpers::floats(&light, Mesh::ATTRIBUTE_NORMAL) {
        assert!((normal.iter().map(|x| x.abs()).fold(0.0, f32::max) - 1.0).abs() < 1e-5, "{normal:?}");
    }
}

#[test]
fn the_error_of_a_result_is_kept() {
    let mesh = torus(long);
    let light = simplify_mesh_to_error(&mesh, 0.02, &ClosedOptions::default()).unwrap();
    assert_eq!(light.report.outcome, Outcome::Reached);
    assert!(light.mesh.count_vertices() < mesh.count_vertices() / 2 && is_closed(&light.mesh));
    // Vertices of the result are near the torus itself.
    for &[x, y, z] in positions(&light.mesh) {
        let distance = (x.hypot(y) - 1.0).hypot(z) - 0.4;
        assert!(distance.abs() < 0.02 + 0.005, "{distance}");
    }
}

#[test]
fn results_repeat_bit_for_bit() {
    let mesh = torus(short);
    let simplify = || simplify_mesh(&mesh, Size::Ratio(0.15), &ClosedOptions::default()).unwrap().mesh;
    assert_eq!(simplify(), simplify());
}
