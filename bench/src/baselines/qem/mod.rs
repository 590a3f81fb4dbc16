//! Edge collapse by quadric error with optimal placement (Garland and Heckbert 1997).
//!
//! As the paper has it and as Open3D runs it: planes of faces weighed by area; planes through open edges at right
//! angles to their face, with the same weight; the vertex of a collapsed edge at the minimum of both quadrics, or else
//! at the best of its ends and its middle; no collapse that turns a face over. No test of the topology: pinches may
//! appear. Unlike in Open3D, what counts as singular does not depend on the unit.
//!
//! Ours, since no crate has it: `baby_shark` puts vertices in the middle of edges; `alum` has optimal placement, but
//! for manifolds alone, with no way out where the quadric is singular and no planes for open edges; `meshopt` has a
//! metric and rules of its own.

mod quadrics;
mod surface;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::BaselineError;
use neural_mesh::mesh::{TriMesh, edges};
use surface::{Candidate, Surface};

/// Collapses the cheapest edges until at most `n_faces` are left.
pub(super) fn qem(mesh: &TriMesh, n_faces: usize) -> Result<TriMesh, BaselineError> {
    let mut surface = Surface::new(mesh);
    let mut queue: BinaryHeap<Reverse<Candidate>> =
        edges(mesh).into_iter().map(|edge| Reverse(surface.candidate(edge.ends))).collect();
    while surface.n_faces > n_faces {
        let Some(Reverse(candidate)) = queue.pop() else { break };
        if surface.is_current(&candidate) && !surface.turns_a_face(&candidate) {
            surface.collapse(&candidate);
            let kept = candidate.edge[0];
            queue.extend(surface.neighbours(kept).into_iter().map(|v| Reverse(surface.candidate([kept, v]))));
        }
    }
    surface.into_mesh()
}
