//! The samplers of the paper's table, and the noise.

use glam::{DVec3, Vec3};
use neural_mesh::mesh::TriMesh;
use neural_mesh::model::Weights;
use neural_mesh::simplify::{gumbel_top_k, network_scores};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::paper::{even, farthest, scattered};

/// A way to draw vertices.
#[derive(Clone, Copy)]
pub enum Sampler<'a> {
    /// Any vertices, perhaps one twice: the plain multinomial.
    WithReplacement,
    /// Any vertices, each once.
    WithoutReplacement,
    /// Any vertices, apart from each other along the edges, as the network's are.
    Scattered,
    /// Farthest points along the edges.
    Farthest,
    /// By the network's scores, apart from each other.
    Network(&'a Weights),
}

impl<'a> Sampler<'a> {
    pub fn all(weights: Option<&'a Weights>) -> impl Iterator<Item = Self> {
        let plain = [Self::WithReplacement, Self::WithoutReplacement, Self::Scattered, Self::Farthest];
        plain.into_iter().chain(weights.map(Self::Network))
    }

    /// The name in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::WithReplacement => "uniform, with replacement",
            Self::WithoutReplacement => "uniform, without replacement",
            Self::Scattered => "scattered evenly",
            Self::Farthest => "farthest points",
            Self::Network(_) => "network",
        }
    }

    /// Draws `n` vertices; those drawn twice are there once.
    pub fn draw(self, mesh: &TriMesh, n: usize, seed: u64) -> Vec<u32> {
        let n_vertices = mesh.positions().len();
        match self {
            Self::WithReplacement => with_replacement(n_vertices, n, seed),
            Self::WithoutReplacement => gumbel_top_k(&even(mesh), n, seed),
            Self::Scattered => scattered(mesh, &even(mesh), n, seed),
            Self::Farthest => farthest(mesh, n, seed),
            Self::Network(weights) => scattered(mesh, &network_scores(mesh, weights), n, seed),
        }
    }
}

fn with_replacement(n_vertices: usize, n: usize, seed: u64) -> Vec<u32> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut drawn: Vec<u32> = (0..n).map(|_| (unit(&mut rng) * n_vertices as f64) as u32).collect();
    drawn.sort_unstable();
    drawn.dedup();
    drawn
}

/// The mesh with normal noise on every coordinate, `sigma` in diagonals of the bounding box.
pub fn with_noise(mesh: &TriMesh, sigma: f64, seed: u64) -> TriMesh {
    if sigma == 0.0 {
        return mesh.clone();
    }
    let scale = sigma * diagonal(mesh.positions());
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x6e6f_6973_6521);
    let moved = mesh.positions().iter().map(|p| p.map(|x| (f64::from(x) + scale * normal(&mut rng)) as f32));
    TriMesh::new(moved.collect(), mesh.faces().to_vec()).unwrap_or_else(|_| mesh.clone())
}

/// Length of the diagonal of the box around the points.
pub fn diagonal(points: &[[f32; 3]]) -> f64 {
    let points = || points.iter().map(|&p| Vec3::from(p));
    let [low, high] = [points().reduce(Vec3::min), points().reduce(Vec3::max)].map(Option::unwrap_or_default);
    DVec3::from(low).distance(DVec3::from(high))
}

/// A standard normal number (Box and Muller 1958).
fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let radius = (-2.0 * (1.0 - unit(rng)).ln()).sqrt();
    radius * (std::f64::consts::TAU * unit(rng)).cos()
}

/// A number in 0..1.
fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn with_replacement_a_share_is_drawn_twice() {
        let drawn = with_replacement(10_000, 10_000, 3).len() as f64 / 10_000.0;
        assert!((drawn - (1.0 - (-1f64).exp())).abs() < 0.01, "{drawn}");
    }

    #[test]
    fn noise_has_the_deviation_asked_for() {
        let mesh = shapes::icosphere(4);
        let noisy = with_noise(&mesh, 0.01, 1);
        let pairs = mesh.positions().as_flattened().iter().zip(noisy.positions().as_flattened());
        let squares: f64 = pairs.map(|(a, b)| f64::from(b - a).powi(2)).sum();
        let sigma = (squares / (3 * mesh.positions().len()) as f64).sqrt() / diagonal(mesh.positions());
        assert!((sigma - 0.01).abs() < 3e-4, "{sigma}");
    }
}
