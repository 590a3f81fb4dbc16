//! Edge collapse by quadrics (Garland and Heckbert 1997), as in Open3D; the topology is not checked.

mod quadrics;
mod surface;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use anyhow::Result;
use neural_mesh::mesh::{TriMesh, edges};
use surface::{CollapseCandidate, CollapsingMesh};

pub(super) fn qem(mesh: &TriMesh, n_faces: usize) -> Result<TriMesh> {
    let mut surface = CollapsingMesh::new(mesh);
    let mut queue: BinaryHeap<Reverse<CollapseCandidate>> =
        edges(mesh).into_iter().map(|edge| Reverse(surface.price_collapse(edge.ends))).collect();
    while surface.n_faces > n_faces {
        let Some(Reverse(candidate)) = queue.pop() else { break };
        if surface.try_collapse(&candidate) {
            let kept = candidate.edge[0];
            queue.extend(surface.neighbours(kept).into_iter().map(|v| Reverse(surface.price_collapse([kept, v]))));
        }
    }
    surface.into_mesh()
}
