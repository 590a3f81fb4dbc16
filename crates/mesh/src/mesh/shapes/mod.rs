//! Small named test meshes.
//!
//! Faces of closed shapes face outward. A size that is not finite gives the empty mesh.

mod assemble;
mod cad;
mod open;
mod singular;
mod solid;
mod united;

pub use assemble::{place, unite};
pub use cad::{bolt, plate, thin_sheet};
pub use open::{grid, open_cylinder};
pub use singular::{klein_bottle, moebius_strip, tetrahedra_sharing_edge, tetrahedra_sharing_vertex};
pub use solid::{cuboid, icosphere, tetrahedron, torus, wavy_sphere};
pub use united::{chain_of_tori, many_boxes, touching_spheres};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle::area_normal_f64;
    use crate::mesh::{TriMesh, join_positions, topology};
    use glam::DVec3;

    fn volume(mesh: &TriMesh) -> f64 {
        let point = |v: u32| DVec3::from_array(mesh.positions()[v as usize].map(f64::from));
        let signed = |face: &[u32; 3]| point(face[0]).dot(area_normal_f64(face.map(point)));
        // The corner's height times the doubled area is six times the volume under the face.
        mesh.faces().iter().map(signed).sum::<f64>() / 6.0
    }

    fn assert_closed(mesh: &TriMesh, components: usize, genus: usize, volume_range: std::ops::Range<f64>) {
        let topology = topology(mesh);
        assert!(topology.is_closed_manifold(), "{topology:?}");
        assert_eq!((topology.components, topology.genus), (components, Some(genus)));
        assert_eq!(topology.unreferenced_vertices, 0);
        assert!(volume_range.contains(&volume(mesh)), "volume {}", volume(mesh));
    }

    #[test]
    fn solids_are_closed_and_look_outward() {
        assert_closed(&tetrahedron(), 1, 0, 0.16..0.17);
        assert_closed(&cuboid([1.0, 2.0, 3.0], 3), 1, 0, 5.999..6.001);
        assert_closed(&icosphere(0), 1, 0, 2.5..2.6);
        assert_closed(&icosphere(4), 1, 0, 4.15..4.19);
        assert_closed(&torus(64, 32, 1.0, 0.25), 1, 1, 1.2..1.24);
        assert_closed(&wavy_sphere(4, 30.0), 1, 0, 3.5..5.0);
    }

    #[test]
    fn parts_of_machines_are_closed_and_look_outward() {
        assert_closed(&plate(8, 0.01), 1, 0, 0.1..0.2);
        assert_closed(&bolt(32), 1, 0, 3.0..12.0);
        assert_closed(&thin_sheet(20, 1e-3), 1, 0, 0.9e-3..1.3e-3);
    }

    #[test]
    fn united_shapes_count_their_parts() {
        assert_closed(&touching_spheres(3), 2, 0, 8.0..8.4);
        assert_closed(&chain_of_tori(5), 5, 5, 5.5..6.5);
        assert_closed(&many_boxes(94), 94, 0, 0.1..94.0);
    }

    #[test]
    fn touching_spheres_have_one_position_twice() {
        let mesh = touching_spheres(2);
        let (first, _) = join_positions(mesh.positions());
        assert_eq!((0..).zip(first).filter(|(vertex, first)| vertex != first).count(), 1);
    }

    #[test]
    fn a_plate_is_flat_faces_and_a_fine_rim() {
        let mesh = plate(8, 0.01);
        let point = |v: u32| DVec3::from_array(mesh.positions()[v as usize].map(f64::from));
        let areas = mesh.faces().iter().map(|face| area_normal_f64(face.map(point)).length());
        let (small, large) = areas.fold((f64::MAX, 0.0), |(low, high), a| (a.min(low), a.max(high)));
        assert!(small > 0.0 && large / small > 1e5, "{small} {large}");
    }

    #[test]
    fn open_shapes_have_their_boundaries() {
        let grid = topology(&grid(4, 3));
        assert_eq!((grid.boundary_edges, grid.boundary_loops, grid.genus), (14, 1, Some(0)));
        let cylinder = topology(&open_cylinder(12, 3));
        assert_eq!((cylinder.boundary_edges, cylinder.boundary_loops, cylinder.genus), (24, 2, Some(0)));
        assert_eq!(cylinder.euler, 0);
    }

    #[test]
    fn one_sided_surfaces_are_not_orientable() {
        let strip = topology(&moebius_strip(20, 3));
        assert!(!strip.orientable && strip.inconsistent_edges == 3 && strip.boundary_loops == 1);
        assert_eq!((strip.genus, strip.euler), (None, 0));
        let bottle = topology(&klein_bottle(20, 8));
        assert!(bottle.closed && !bottle.orientable && !bottle.is_closed_manifold());
        assert_eq!((bottle.genus, bottle.euler, bottle.non_manifold_edges), (None, 0, 0));
    }

    #[test]
    fn tetrahedra_that_share_are_singular_there_only() {
        let edge = topology(&tetrahedra_sharing_edge());
        assert_eq!((edge.non_manifold_edges, edge.components, edge.closed), (1, 1, true));
        let vertex = topology(&tetrahedra_sharing_vertex());
        assert_eq!((vertex.non_manifold_vertices, vertex.non_manifold_edges), (1, 0));
        assert_eq!((vertex.components, vertex.genus, vertex.euler), (2, Some(0), 3));
    }
}
