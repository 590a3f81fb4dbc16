//! Merges with all that their places depend on, for derivatives.

use crate::collapse::quadric::visit_folds;
use crate::collapse::rings::{RingsView, Vertex, state};
use crate::collapse::stretch::VertexStretch;
use crate::collapse::vector::{Point, scale};

/// A merge of a pass; each vertex is named by the input vertex that is its origin.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PassMerge {
    /// The vertex that stays.
    pub kept: u32,
    /// The vertex that goes.
    pub removed: u32,
    /// The rings of both at the beginning of the pass, whose quadrics place the merged vertex.
    pub rings: [StartRing; 2],
    /// Place of the merged vertex.
    pub place: MergePlace,
}

/// The neighbours of a vertex in cyclic order, on a boundary from one boundary edge to the other.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StartRing {
    /// The neighbours.
    pub neighbors: Vec<u32>,
    /// Neighbours along folds, the rims of thin sheets; the quadric has their lines, too.
    pub folds: Vec<u32>,
    /// True on a boundary.
    pub is_open: bool,
}

/// Place of a merged vertex.
#[derive(Clone, Debug, PartialEq)]
pub enum MergePlace {
    /// At the vertex that stays.
    Kept,
    /// At the vertex that goes.
    Removed,
    /// Halfway between them.
    Middle,
    /// At the least error of the two quadrics.
    Least,
    /// From there [`VOLUME_SHARE`](crate::VOLUME_SHARE) of the way to the plane that keeps the volume of a star.
    TowardVolume {
        /// The border of the star when the merge took place, in cyclic order: the neighbours of the kept vertex, then the rest.
        border: Vec<u32>,
        /// Number of these next to the kept vertex.
        n_of_kept: usize,
    },
}

impl PassMerge {
    /// Records the merge of `edge`, by the numbers of the pass.
    ///
    /// `x` is the place and `d` the removed end, both seen from the kept one. `border` is that of a star inside the surface.
    #[cold]
    pub(crate) fn new(
        rings: RingsView,
        stretch: &VertexStretch,
        edge: [u32; 2],
        [x, d]: [Point; 2],
        border: Option<(&[u32], usize)>,
    ) -> Self {
        let is_open = |v: u32| stretch.states[(v - stretch.first) as usize] & state::BOUNDARY != 0;
        let ring = |v: u32| StartRing { neighbors: rings.ring(v).to_vec(), folds: Vec::new(), is_open: is_open(v) };
        let place = match border {
            _ if x == [0.0; 3] => MergePlace::Kept,
            _ if x == d => MergePlace::Removed,
            _ if x == scale(d, 0.5) => MergePlace::Middle,
            None => MergePlace::Least,
            Some((border, n_of_kept)) => {
                MergePlace::TowardVolume { border: border.iter().map(|v| v + stretch.first).collect(), n_of_kept }
            }
        };
        let [kept, removed] = edge;
        Self { kept, removed, rings: edge.map(ring), place }
    }

    /// Finds the folds at both ends by the vertices before the pass.
    pub(crate) fn find_folds(&mut self, before: &[Vertex]) {
        for (ring, end) in self.rings.iter_mut().zip([self.kept, self.removed]) {
            let folds = &mut ring.folds;
            visit_folds(before, end, &ring.neighbors, ring.is_open, |v| folds.push(v));
        }
    }

    /// Gives all vertices other names.
    pub(crate) fn rename(&mut self, name: &[u32]) {
        let ends = [&mut self.kept, &mut self.removed];
        let neighbors = self.rings.iter_mut().flat_map(|ring| ring.neighbors.iter_mut().chain(&mut ring.folds));
        let border = match &mut self.place {
            MergePlace::TowardVolume { border, .. } => &mut border[..],
            _ => &mut [],
        };
        ends.into_iter().chain(neighbors).chain(border).for_each(|v| *v = name[*v as usize]);
    }
}
