//! Components of faces.

use glam::DVec3;

use crate::mesh::pulse::Pulse;
use crate::mesh::union_find::join_faces;

use super::faces::RepairFaces;

pub(super) fn components(faces: &RepairFaces) -> (Vec<u32>, usize) {
    components_over_edges(faces, |_| true)
}

pub(super) fn components_over_edges(faces: &RepairFaces, is_wanted: impl Fn(usize) -> bool) -> (Vec<u32>, usize) {
    join_faces(faces.positions.len(), &faces.corners, is_wanted).number_sets(Pulse::NONE)
}

/// Drops components with a bounding-box diagonal below `least`, never the largest by area; returns the number dropped.
pub(super) fn drop_small(faces: &mut RepairFaces, least: f64) -> usize {
    let (component, n) = components(faces);
    let mut areas = vec![0.0; n];
    let mut boxes = vec![(DVec3::INFINITY, DVec3::NEG_INFINITY); n];
    for (face, &component) in faces.numbers().zip(&component) {
        areas[component as usize] += faces.area(face);
        let (low, high) = &mut boxes[component as usize];
        for point in faces.points(face) {
            (*low, *high) = (low.min(point), high.max(point));
        }
    }
    // One component always stays: the largest by area, the first of equals.
    let largest = (0..n).max_by(|&a, &b| areas[a].total_cmp(&areas[b]).then(b.cmp(&a)));
    let is_kept =
        |component: usize| Some(component) == largest || (boxes[component].1 - boxes[component].0).length() >= least;
    let n_kept = (0..n).filter(|&component| is_kept(component)).count();
    if n_kept < n {
        faces.retain(|face| is_kept(component[face as usize] as usize));
    }
    n - n_kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, shapes, topology};

    #[test]
    fn components_are_those_that_topology_counts() {
        for mesh in [shapes::many_boxes(20), shapes::tetrahedra_sharing_edge(), shapes::touching_spheres(1)] {
            let faces = RepairFaces::new(&mesh, &Attributes::default());
            assert_eq!(components(&faces).1, topology(&mesh).components);
        }
    }

    #[test]
    fn small_components_go_and_the_largest_stays() {
        let mesh = shapes::many_boxes(20);
        let mut faces = RepairFaces::new(&mesh, &Attributes::default());
        assert_eq!(drop_small(&mut faces, 0.0), 0);
        assert_eq!((drop_small(&mut faces, f64::INFINITY), components(&faces).1), (19, 1));
    }
}
