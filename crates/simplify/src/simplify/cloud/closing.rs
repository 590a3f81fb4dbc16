//! Closing of the holes between chosen faces.

use super::manifold_faces::{ManifoldFaces, edges_of};
use super::pinches::AtPinch;
use super::planes::point;
use crate::mesh::{Attributes, TriMesh};
use crate::repair::fill_some_holes;
use glam::DVec3;

/// Twice the area of the largest hole that is closed, over its circumference, in mean edges: a disk of three edges'
/// radius.
const LARGEST_HOLE: f64 = 3.0;

/// Longest edge of a face that is added, in mean edges.
// On three validation meshes, 5 leaves 0.68 to 1.15 % of the edges open, 8 0.28 to 0.84 %; without a bound, the largest
// distance quotient rises from 1.25 to 1.53.
const LONGEST_EDGE: f64 = 8.0;

/// Most rounds of filling holes and removing faces.
const ROUNDS: usize = 8;

/// Fills small holes; removes faces at vertices that several holes touch, and fills the holes that result.
///
/// The points of `chosen` are in units of edges. Large holes stay, since a surface may have a boundary.
pub fn close_surface(points: &[[f32; 3]], chosen: &mut ManifoldFaces) {
    for round in 1..=ROUNDS {
        let n_filled = fill_small_holes(points, chosen);
        // Where the largest fan at a vertex was in the way twice, the vertex goes.
        let kept = if round % 3 == 0 { AtPinch::Nothing } else { AtPinch::LargestFan };
        let n_removed = if round < ROUNDS { chosen.remove_pinches(kept) } else { 0 };
        if n_filled + n_removed == 0 {
            break;
        }
    }
}

fn fill_small_holes(points: &[[f32; 3]], chosen: &mut ManifoldFaces) -> usize {
    let faces = chosen.list_wound_faces();
    let n_before = faces.len();
    let Ok(open) = TriMesh::new(points.to_vec(), faces) else { return 0 };
    let filled = fill_some_holes(&open, Attributes::NONE, usize::MAX, |rim| is_small(points, rim));
    let new = filled.mesh.faces()[n_before..].iter().map(|face| face.map(|v| filled.sources[v as usize]));
    new.filter(|&face| is_short(points, face) && chosen.add(face)).count()
}

fn is_short(points: &[[f32; 3]], face: [u32; 3]) -> bool {
    edges_of(face)
        .iter()
        .all(|edge| edge.map(|v| point(points, v)).windows(2).all(|p| p[0].distance(p[1]) < LONGEST_EDGE))
}

fn is_small(points: &[[f32; 3]], rim: &[u32]) -> bool {
    let edges = || rim.iter().zip(rim.iter().cycle().skip(1)).map(|(&a, &b)| [a, b].map(|v| point(points, v)));
    let twice_area: DVec3 = edges().map(|[a, b]| a.cross(b)).sum();
    let circumference: f64 = edges().map(|[a, b]| a.distance(b)).sum();
    twice_area.length() < LARGEST_HOLE * circumference
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, topology};
    use crate::model::in_edge_lengths;
    use crate::simplify::edge_graph;

    fn close(mesh: &TriMesh, is_kept: impl Fn(usize) -> bool) -> TriMesh {
        let points = in_edge_lengths(mesh.positions(), &edge_graph(mesh));
        let mut chosen = ManifoldFaces::new(&points);
        let kept = mesh.faces().iter().enumerate().filter(|(at, _)| is_kept(*at));
        kept.for_each(|(_, &face)| assert!(chosen.add(face)));
        close_surface(&points, &mut chosen);
        TriMesh::new(points.clone(), chosen.list_wound_faces()).unwrap()
    }

    #[test]
    fn a_surface_full_of_holes_is_closed() {
        for every in [5, 17] {
            for shape in [shapes::torus(24, 12, 2.0, 1.0), shapes::icosphere(3)] {
                let figures = topology(&close(&shape, |at| at % every != 0));
                assert!(figures.is_closed_manifold(), "{every}: {figures:?}");
            }
        }
    }

    #[test]
    fn a_large_boundary_stays() {
        let figures = topology(&close(&shapes::open_cylinder(40, 12), |at| at % 11 != 5));
        assert_eq!((figures.boundary_loops, figures.non_manifold_edges), (2, 0));
        // A disk of ten edges has a radius of 1.6 edges.
        assert!(topology(&close(&shapes::open_cylinder(10, 12), |_| true)).is_closed_manifold());
    }
}
