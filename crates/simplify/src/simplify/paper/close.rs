//! Closing of the holes that the network left.

use super::NO_SAMPLE;
use crate::mesh::half_edges::for_each_edge;
use crate::mesh::{Attributes, TriMesh};
use crate::repair::fill_some_holes;

/// Most rounds: where loops touch, one round may leave holes for the next.
const ROUNDS: usize = 4;

/// Fills the holes that the network left; corners of new faces are samples.
///
/// A loop stays open if at least half of its edges join samples whose regions the boundary of the mesh crosses. Faces
/// that share no edge with another are dropped.
///
/// # Shapes
/// - `samples`: n_samples vertices of the mesh; `assignment`: n_vertices indices into them, or [`NO_SAMPLE`]
/// - `faces`: n_faces x 3 vertices of the mesh that are samples; returns faces of the same form
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::shapes, simplify::paper::close_holes};
/// let sphere = shapes::icosphere(2);
/// let all: Vec<u32> = (0..162).collect();
/// assert_eq!(close_holes(&sphere, &all, &all, sphere.faces()[3..].to_vec()).len(), 320);
/// ```
pub fn close_holes(mesh: &TriMesh, samples: &[u32], assignment: &[u32], faces: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    let ends = mark_boundary_regions(mesh, samples, assignment);
    let is_hole = |of: &[u32]| {
        let next = of.iter().cycle().skip(1);
        let n_ends = of.iter().zip(next).filter(|(a, b)| ends[**a as usize] && ends[**b as usize]).count();
        2 * n_ends < of.len()
    };
    let mut faces = drop_lone_faces(mesh.positions().len(), faces);
    for _ in 0..ROUNDS {
        let Ok(open) = TriMesh::new(mesh.positions().to_vec(), faces.clone()) else { break };
        let filled = fill_some_holes(&open, Attributes::NONE, usize::MAX, is_hole);
        if filled.counts.holes_filled == 0 {
            break;
        }
        let n_before = faces.len();
        faces = filled.mesh.faces().iter().map(|face| face.map(|v| filled.sources[v as usize])).collect();
        faces = drop_third_faces(mesh.positions().len(), faces, n_before);
    }
    faces
}

fn drop_third_faces(n_vertices: usize, faces: Vec<[u32; 3]>, n_before: usize) -> Vec<[u32; 3]> {
    let mut is_dropped = vec![false; faces.len()];
    for_each_edge(n_vertices, &faces, |_, half_edges| {
        let later = half_edges.iter().skip(2).map(|side| side.half_edge as usize / 3);
        later.filter(|&face| face >= n_before).for_each(|face| is_dropped[face] = true);
    });
    let mut is_dropped = is_dropped.into_iter();
    faces.into_iter().filter(|_| is_dropped.next() == Some(false)).collect()
}

fn mark_boundary_regions(mesh: &TriMesh, samples: &[u32], assignment: &[u32]) -> Vec<bool> {
    let n = mesh.positions().len();
    let mut ends = vec![false; n];
    for_each_edge(n, mesh.faces(), |edge, half_edges| {
        let regions = edge.map(|v| assignment[v as usize]).into_iter().filter(|&region| region != NO_SAMPLE);
        if half_edges.len() == 1 {
            regions.for_each(|region| ends[samples[region as usize] as usize] = true);
        }
    });
    ends
}

fn drop_lone_faces(n_vertices: usize, faces: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    let mut is_joined = vec![false; faces.len()];
    for_each_edge(n_vertices, &faces, |_, half_edges| {
        if half_edges.len() > 1 {
            half_edges.iter().for_each(|side| is_joined[side.half_edge as usize / 3] = true);
        }
    });
    let mut joined = is_joined.into_iter();
    faces.into_iter().filter(|_| joined.next() == Some(true)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, topology};

    fn all(mesh: &TriMesh) -> Vec<u32> {
        (0..mesh.positions().len() as u32).collect()
    }

    fn punched_torus(mesh: &TriMesh, every: usize) -> Vec<[u32; 3]> {
        let numbered = mesh.faces().iter().enumerate();
        numbered.filter(|(at, _)| at % every != 0).map(|(_, face)| *face).collect()
    }

    #[test]
    fn a_torus_full_of_holes_is_closed_again_over_the_same_vertices() {
        let torus = shapes::torus(24, 12, 2.0, 1.0);
        for every in [3, 5, 17] {
            let faces = close_holes(&torus, &all(&torus), &all(&torus), punched_torus(&torus, every));
            let mesh = TriMesh::new(torus.positions().to_vec(), faces).unwrap();
            // Where holes touch everywhere, a few edges may stay open, since no round finds a face for them.
            let open = topology(&mesh).boundary_edges;
            assert!(open <= 4, "{every}: {open}");
        }
    }

    #[test]
    fn results_end_at_the_boundary_of_the_mesh() {
        let tube = shapes::open_cylinder(24, 10);
        let faces = close_holes(&tube, &all(&tube), &all(&tube), punched_torus(&tube, 11));
        let mesh = TriMesh::new(tube.positions().to_vec(), faces).unwrap();
        // A face that is missing at an end of the tube leaves a notch there.
        let open = topology(&mesh).boundary_edges;
        assert!((48..72).contains(&open), "{open}");
    }

    #[test]
    fn the_newest_of_three_faces_at_an_edge_is_dropped() {
        let fan = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        assert_eq!(drop_third_faces(5, fan.clone(), 2), fan[..2]);
        assert_eq!(drop_third_faces(5, fan.clone(), 3), fan);
    }

    #[test]
    fn a_lone_face_is_dropped() {
        let (strip, lone) = (vec![[0, 1, 2], [1, 3, 2]], [4, 5, 6]);
        assert_eq!(drop_lone_faces(7, [strip.clone(), vec![lone]].concat()), strip);
    }
}
