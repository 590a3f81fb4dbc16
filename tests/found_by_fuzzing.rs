//! Defects found by fuzzing, as named tests.

use crate::common::{assert_closed_manifold, assert_manifold, assert_same_topology, simplify_valid};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{RawMesh, TriMesh, shapes, topology};
use neural_mesh::simplify::{Options, Outcome, Size};

fn weld_positions(mesh: TriMesh) -> TriMesh {
    let (positions, faces) = mesh.into_parts();
    let positions = positions.into_iter().map(|p| p.map(f64::from)).collect();
    clean(RawMesh::new(positions, faces), &CleanOptions::default()).unwrap().mesh
}

#[test]
fn a_number_of_faces_is_reached_from_above_where_boundaries_cost_faces() {
    let tube = shapes::open_cylinder(12, 4);
    let result = simplify_valid(&tube, &Options::new(Size::Faces(64)));
    assert_eq!((result.report.outcome, result.mesh.faces().len()), (Outcome::Reached, 64));
    assert_manifold(&result.mesh);
}

#[test]
fn a_mesh_that_is_small_enough_still_comes_out_as_a_manifold() {
    let touching = shapes::touching_spheres(1);
    for mesh in [touching.clone(), weld_positions(touching)] {
        let n_vertices = mesh.positions().len();
        let result = simplify_valid(&mesh, &Options::new(Size::Vertices(n_vertices)));
        assert_closed_manifold(&result.mesh);
        assert_same_topology(&mesh, &result.mesh);
        // A vertex between sheets is split, and nothing else is removed for it.
        assert_eq!(result.mesh.positions().len(), n_vertices + result.report.split_vertices);
    }
}

#[test]
fn surfaces_with_one_side_stay_manifolds() {
    for mesh in [shapes::moebius_strip(16, 3), shapes::klein_bottle(12, 8)] {
        let before = topology(&mesh);
        for target in [4, 12, 30] {
            let after = topology(&simplify_valid(&mesh, &Options::new(Size::Vertices(target))).mesh);
            assert_eq!(after.non_manifold_edges + after.non_manifold_vertices, 0, "{after:?}");
            assert!(!after.orientable, "{after:?}");
            assert_eq!((after.euler, after.boundary_loops), (before.euler, before.boundary_loops));
        }
    }
}

#[test]
fn narrow_rings_keep_both_boundaries() {
    let (mut positions, faces) = shapes::open_cylinder(24, 3).into_parts();
    positions.iter_mut().for_each(|p| p[2] *= 0.01);
    let ring = TriMesh::new(positions, faces).unwrap();
    for vertices in [6, 8, 12, 20] {
        let result = simplify_valid(&ring, &Options::new(Size::Vertices(vertices)));
        assert_manifold(&result.mesh);
        assert_same_topology(&ring, &result.mesh);
    }
}

#[test]
fn a_surface_pressed_flat_leaves_no_vertex_without_faces() {
    let (mut positions, faces) = shapes::chain_of_tori(2).into_parts();
    positions.iter_mut().for_each(|p| p[0] = 0.0);
    let flat = weld_positions(TriMesh::new(positions, faces).unwrap());
    assert_manifold(&simplify_valid(&flat, &Options::new(Size::Ratio(0.02))).mesh);
}
