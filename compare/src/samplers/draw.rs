//! The samplers by name.

use neural_mesh::mesh::TriMesh;
use neural_mesh::simplify::gumbel_top_k;

use super::elimination::eliminate;
use super::farthest::farthest_points;
use super::metric::{BEND, Cells, edge_lengths};

/// A way to draw vertices.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Sampler {
    Darts,
    Elimination { bent: bool },
    Farthest { bent: bool },
    GumbelEqual,
    GumbelArea { bent: bool },
}

impl Sampler {
    pub const ALL: [Self; 8] = [
        Self::Darts,
        Self::Elimination { bent: true },
        Self::Farthest { bent: true },
        Self::GumbelArea { bent: true },
        Self::Elimination { bent: false },
        Self::Farthest { bent: false },
        Self::GumbelArea { bent: false },
        Self::GumbelEqual,
    ];

    /// The name in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Darts => "darts",
            Self::Elimination { bent: true } => "elimination, bend",
            Self::Farthest { bent: true } => "farthest, bend",
            Self::GumbelArea { bent: true } => "Gumbel, bend",
            Self::Elimination { bent: false } => "elimination",
            Self::Farthest { bent: false } => "farthest",
            Self::GumbelArea { bent: false } => "Gumbel, area",
            Self::GumbelEqual => "Gumbel, equal",
        }
    }

    /// Whether another seed draws other vertices.
    pub fn is_random(self) -> bool {
        !matches!(self, Self::Elimination { .. })
    }

    /// Draws `n` vertices; none for darts, which the pass itself throws.
    pub fn draw(self, mesh: &TriMesh, n: usize, seed: u64) -> Option<Vec<u32>> {
        let equal = || vec![0.0; mesh.positions().len()];
        match self {
            Self::Darts => None,
            Self::Elimination { bent } => Some(eliminate(mesh.positions(), &Cells::new(mesh, bend(bent)), n)),
            Self::Farthest { bent } => {
                let first = gumbel_top_k(&equal(), 1, seed).first().copied()?;
                Some(farthest_points(&edge_lengths(mesh, bend(bent)), n, first))
            }
            Self::GumbelEqual => Some(gumbel_top_k(&equal(), n, seed)),
            Self::GumbelArea { bent } => {
                let areas = Cells::new(mesh, bend(bent)).areas;
                let scores: Vec<f32> = areas.iter().map(|area| area.max(f64::MIN_POSITIVE).ln() as f32).collect();
                Some(gumbel_top_k(&scores, n, seed))
            }
        }
    }
}

fn bend(bent: bool) -> f64 {
    if bent { BEND } else { 0.0 }
}
