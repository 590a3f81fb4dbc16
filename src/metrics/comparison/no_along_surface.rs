//! What stands for figures along the surface in a build without the feature `spectrum`: none.

use super::figure::Figure;
use super::judging::Judging;
use crate::mesh::TriMesh;
use crate::metrics::Surface;

/// Whether this build measures the spectrum and distances along the surface: whether the feature `spectrum` is on.
pub const MEASURES_ALONG_SURFACE: bool = false;

/// Nothing.
pub struct AlongSurface;

impl AlongSurface {
    /// Solves for nothing.
    pub fn new(_: &TriMesh, _: &Judging, _: usize) -> Self {
        Self
    }

    /// No eigenpairs.
    pub fn eigenpairs(&self, _: usize) -> usize {
        0
    }

    /// No figures.
    pub fn figures(&self, _: &TriMesh, _: &Surface, _: usize) -> [Figure; 0] {
        []
    }
}
