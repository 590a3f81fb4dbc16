//! What a comparison measures, and from how many samples.

/// Eigenpairs of the Laplacian that the paper compares, at most.
const EIGENPAIRS: usize = 200;

/// What is measured, and from how many samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Judging {
    /// Samples on each surface; the paper's 50 thousand by default.
    pub samples: usize,
    /// Decides where the samples lie; those of the simplified mesh are drawn with the next one.
    pub seed: u64,
    /// Eigenpairs of the Laplacian, at most; 0 leaves out LE and biharmonic distances, which cost more than all other
    /// figures. [`Original::eigenpairs`](super::Original::eigenpairs) says how many are compared.
    pub eigenpairs: usize,
    /// Whether distances along the surface are measured.
    pub geodesics: bool,
    /// Vertex of the original from which distances along the surface are measured; by default, or where no face uses it,
    /// the one farthest from the middle of the bounding box.
    pub source: Option<u32>,
}

impl Default for Judging {
    fn default() -> Self {
        Self { samples: 50_000, seed: 0, eigenpairs: EIGENPAIRS, geodesics: true, source: None }
    }
}
