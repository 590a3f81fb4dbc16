//! A collapse that goes on without the components that were dropped: nothing up to it is done again for the others.

use crate::mesh::TriMesh;
use crate::simplify::limits::Limit;
use crate::simplify::options::SimplifyError;
use crate::simplify::progress::Progress;

use super::Clustered;
use super::cluster::assignment::Assignment;
use super::collapse::Collapse;
use super::dropping::Dropped;
use super::original::Original;
use super::prepare::prepare_at_scale;
use super::prepare::surface::Normalisation;
use super::request::Request;

/// A collapse of all components from which the dropped ones were removed.
pub struct Begun<'a> {
    collapse: Collapse<'a>,
    /// The normalisation of the surface of all components.
    scale: Normalisation,
    /// The regions of the corners of each face that stays, as the mesh has them.
    regions: Vec<[u32; 3]>,
    oversample: f64,
    n_regions: usize,
    n_refined: usize,
}

impl<'a> Begun<'a> {
    /// Takes the copy of a collapse on from where more is left than this limit asks for; `None` where less is.
    pub(super) fn without(dropped: &Dropped, clustered: &Clustered, copy: Collapse<'a>, limit: Limit) -> Option<Self> {
        let Clustered { original, assignment, oversample, n_refined, .. } = clustered;
        let surface = &original.surface;
        let regions_of = |face: u32| {
            let own = surface.faces[face as usize];
            original.mesh.faces()[face as usize].map(|corner| {
                let v = own.into_iter().find(|&v| surface.source(v) == corner).unwrap_or(own[0]);
                assignment.region[v as usize]
            })
        };
        let of_state = |goes: bool| {
            let faces = (0u32..).zip(&dropped.faces).filter(move |(_, is_dropped)| **is_dropped == goes);
            faces.map(|(face, _)| regions_of(face))
        };
        let collapse = copy.without(of_state(true).flatten());
        (collapse.merges_to(limit) > 0).then(|| Self {
            collapse,
            scale: surface.scale,
            regions: of_state(false).collect(),
            oversample: *oversample,
            n_regions: assignment.n_regions,
            n_refined: *n_refined,
        })
    }

    /// Lays the collapse over the mesh without the dropped components; `None` where its sheets part otherwise than they did beside these.
    ///
    /// # Errors
    /// [`SimplifyError::Interrupted`] where the listener says so.
    pub(super) fn over<'b>(
        self,
        mesh: &'b TriMesh,
        request: &Request,
        limit: Limit,
        progress: Progress<'b>,
    ) -> Result<Option<(Clustered<'b>, Collapse<'a>)>, SimplifyError> {
        progress.enter("surface", mesh.faces().len())?;
        let mut original = prepare_at_scale(mesh, self.scale, &request.keep, progress.pulse);
        // Nothing that follows asks for these.
        original.surface.quadrics = Vec::new();
        let Some(region) = self.region(&original) else { return Ok(None) };
        progress.enter("collapse", self.collapse.merges_to(limit))?;
        let assignment = Assignment { region, n_regions: self.n_regions, samples: Vec::new() };
        let Self { collapse, oversample, n_refined, .. } = self;
        Ok(Some((Clustered { original, assignment, oversample, n_refined, cases: None }, collapse)))
    }

    /// The region of each vertex of the surface; `None` where one would have two.
    fn region(&self, Original { mesh, surface, .. }: &Original) -> Option<Vec<u32>> {
        const NONE: u32 = u32::MAX;
        let mut region = vec![NONE; surface.n_vertices()];
        for ((face, corners), regions) in surface.faces.iter().zip(mesh.faces()).zip(&self.regions) {
            for &v in face {
                let at = corners.iter().position(|&corner| corner == surface.source(v))?;
                let before = std::mem::replace(&mut region[v as usize], regions[at]);
                if before != NONE && before != regions[at] {
                    return None;
                }
            }
        }
        Some(region)
    }
}
