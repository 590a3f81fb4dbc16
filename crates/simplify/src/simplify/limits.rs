//! Sizes resolved to numbers of vertices and faces.

use crate::mesh::TriMesh;

use super::options::SimplifyError;
use super::size::Size;

#[derive(Clone, Copy)]
pub(super) struct Limit {
    pub vertices: usize,
    pub faces: usize,
    /// Price above which no merge is made, at unit size.
    pub price: f32,
}

impl Limit {
    pub const NONE: Self = Self::from_vertices(u32::MAX as usize);

    pub const fn from_vertices(vertices: usize) -> Self {
        Self { vertices, faces: usize::MAX, price: f32::INFINITY }
    }

    pub fn size(self) -> usize {
        self.vertices.min(self.faces / 2 + 2)
    }

    pub fn scale(self, factor: f64) -> Self {
        let times = |n: usize| (n as f64 * factor) as usize;
        Self { vertices: times(self.vertices), faces: times(self.faces), ..self }
    }

    /// Returns whether a rest of a whole has fewer vertices or faces than the limit allows, and the whole has not.
    pub fn needs_more_than(self, rest: [usize; 2], whole: [usize; 2]) -> bool {
        let is_short = |limit: usize, i: usize| limit <= whole[i] && rest[i] < limit;
        is_short(self.vertices, 0) || is_short(self.faces, 1)
    }

    /// Returns the share of a mesh's vertices or faces, whichever is less, in 0..=1.
    pub fn share_of(self, mesh: &TriMesh) -> f64 {
        let share = |limit: usize, n: usize| (limit as f64 / n.max(1) as f64).min(1.0);
        share(self.vertices, mesh.positions().len()).min(share(self.faces, mesh.faces().len()))
    }

    pub fn is_met_by(self, mesh: &TriMesh) -> bool {
        self.vertices >= mesh.positions().len() && self.faces >= mesh.faces().len()
    }
}

pub(super) fn resolve_limit(mesh: &TriMesh, size: Size) -> Result<Limit, SimplifyError> {
    resolve_limit_of([mesh.positions().len(), mesh.faces().len()], size)
}

/// Resolves a size for a mesh with these numbers of vertices and faces.
pub(super) fn resolve_limit_of([n_vertices, n_faces]: [usize; 2], size: Size) -> Result<Limit, SimplifyError> {
    if size.share().is_some_and(|share| !(share > 0.0 && share <= 1.0)) {
        return Err(SimplifyError::BadTarget(size));
    }
    match size.to_number(n_vertices, n_faces) {
        Size::Vertices(vertices) if vertices > 0 => Ok(Limit::from_vertices(vertices)),
        Size::Faces(faces) if faces > 0 => Ok(Limit { faces, ..Limit::from_vertices(usize::MAX) }),
        _ => Err(SimplifyError::BadTarget(size)),
    }
}

pub(super) fn resolve_levels(mesh: &TriMesh, sizes: &[Size]) -> Result<Vec<Limit>, SimplifyError> {
    let mut limits: Vec<Limit> = Vec::with_capacity(sizes.len());
    for &size in sizes {
        let limit = resolve_limit(mesh, size)?;
        if limits.last().is_some_and(|last| limit.size() > last.size()) {
            return Err(SimplifyError::BadTarget(size));
        }
        limits.push(limit);
    }
    Ok(limits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_in_percent_are_the_numbers_that_people_mean() {
        for percent in 1..=100usize {
            let share = percent as f64 / 100.0;
            for n in 1..=1000 {
                let limit = resolve_limit_of([n, 0], Size::Ratio(share)).unwrap();
                assert_eq!(limit.vertices, (n * percent / 100).max(1), "{percent} % of {n}");
                let limit = resolve_limit_of([0, n], Size::FaceRatio(share)).unwrap();
                assert_eq!(limit.faces, (n * percent / 100).max(1), "{percent} % of {n}");
            }
        }
    }
}
