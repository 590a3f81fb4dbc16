//! Groups of triangles: a vertex that several use has a wedge for each.

use std::collections::HashMap;

use crate::collapse::WedgeFace;

use super::buffers::IndexBuffers;

/// Wedges of the corners where groups share vertices.
pub(super) struct GroupWedges {
    /// A wedge per corner, n_faces x 3, if they are not the caller's vertices.
    pub wedges: Option<Vec<[u32; 3]>>,
    /// The caller's vertices of the wedges behind the caller's own.
    pub others: Vec<u32>,
    n_vertices: usize,
}

impl GroupWedges {
    pub(super) fn new(buffers: &IndexBuffers) -> GroupWedges {
        let n_vertices = buffers.positions.len();
        let mut by_group = GroupWedges { wedges: None, others: Vec::new(), n_vertices };
        if buffers.groups.is_empty() {
            return by_group;
        }
        let mut first_group = vec![None; n_vertices];
        let mut further = HashMap::new();
        let mut wedge = |v: u32, group: u32| {
            if *first_group[v as usize].get_or_insert(group) == group {
                return v;
            }
            *further.entry((v, group)).or_insert_with(|| {
                by_group.others.push(v);
                (n_vertices + by_group.others.len() - 1) as u32
            })
        };
        let wedges = buffers.indices.iter().zip(buffers.groups).map(|(f, &group)| f.map(|v| wedge(v, group))).collect();
        by_group.wedges = Some(wedges);
        by_group
    }

    /// Returns the caller's vertex of a wedge.
    pub(super) fn caller(&self, wedge: u32) -> u32 {
        self.others.get((wedge as usize).wrapping_sub(self.n_vertices)).copied().unwrap_or(wedge)
    }

    pub(super) fn name_caller(&self, faces: &mut [WedgeFace]) {
        if self.wedges.is_some() {
            faces.iter_mut().for_each(|face| face.wedges = face.wedges.map(|wedge| self.caller(wedge)));
        }
    }
}
