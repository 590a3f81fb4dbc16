//! Saved collapse, which continues after components are dropped.

use crate::simplify::limits::Limit;
use crate::simplify::options::SimplifyError;
use crate::simplify::progress::Progress;

use super::collapse::Collapse;
use super::collapse_base::CollapseBase;
use super::dropping::DroppedFaces;
use super::original::Original;
use super::prepare::prepare_at_scale;
use super::prepare::surface::Normalisation;
use super::request::ClosedRequest;

pub struct SavedCollapse<'a> {
    collapse: Collapse<'a>,
    scale: Normalisation,
    corners: Vec<[u32; 3]>,
}

impl<'a> SavedCollapse<'a> {
    /// Removes components from a copied collapse; `None` if it is below the limit already.
    pub(super) fn from_copy(
        dropped: &DroppedFaces,
        base: &CollapseBase,
        copy: Collapse<'a>,
        limit: Limit,
    ) -> Option<Self> {
        let surface = &base.original.surface;
        let corners_of = |face: u32| {
            // Corners are identified by their mesh vertex, since the next surface numbers its vertices differently.
            let own = surface.faces[face as usize];
            base.original.mesh.faces()[face as usize].map(|corner| {
                let v = own.into_iter().find(|&v| surface.source(v) == corner).unwrap_or(own[0]);
                base.collapse_vertices.get(v as usize).copied().unwrap_or(v)
            })
        };
        let corners_of_faces = |is_gone: bool| {
            let faces = (0u32..).zip(&dropped.faces).filter(move |(_, is_dropped)| **is_dropped == is_gone);
            faces.map(|(face, _)| corners_of(face))
        };
        // The copy loses the components, and is of use only if merges remain.
        let collapse = copy.remove_components(corners_of_faces(true).flatten());
        let has_merges_left = collapse.merges_to(limit) > 0;
        has_merges_left.then(|| Self { collapse, scale: surface.scale, corners: corners_of_faces(false).collect() })
    }

    /// Attaches the collapse to the remaining mesh; `None` if its non-manifold vertices are split differently.
    pub(super) fn attach<'b>(
        self,
        request: &ClosedRequest<'b>,
        limit: Limit,
        progress: Progress<'b>,
    ) -> Result<Option<(CollapseBase<'b>, Collapse<'a>)>, SimplifyError> {
        progress.enter("surface", request.task.input.mesh.faces().len())?;
        let mut original = prepare_at_scale(self.scale, request, progress.pulse);
        // Only a new collapse reads the quadrics.
        original.surface.quadrics = Vec::new();
        let Some(collapse_vertices) = self.vertices(&original) else { return Ok(None) };
        progress.enter("collapse", self.collapse.merges_to(limit))?;
        Ok(Some((CollapseBase { original, collapse_vertices }, self.collapse)))
    }

    fn vertices(&self, Original { mesh, surface, .. }: &Original) -> Option<Vec<u32>> {
        const NONE: u32 = u32::MAX;
        let mut vertices = vec![NONE; surface.n_vertices()];
        // Each corner of the new surface finds its old vertex. A vertex with two old ones was split differently.
        for ((face, corners), saved_corners) in surface.faces.iter().zip(mesh.faces()).zip(&self.corners) {
            for &v in face {
                let at = corners.iter().position(|&corner| corner == surface.source(v))?;
                let before = std::mem::replace(&mut vertices[v as usize], saved_corners[at]);
                if before != NONE && before != saved_corners[at] {
                    return None;
                }
            }
        }
        Some(vertices)
    }
}
