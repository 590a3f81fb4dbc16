//! Sampling of vertices from their scores that keeps samples apart, Sec. 3.1: the multinomial's density in blue noise.
//!
//! Independent draws clump and leave gaps, whatever their probabilities are. Here a vertex is drawn as in
//! [`gumbel_top_k`](super::gumbel_top_k), but only where no earlier sample lies within the radius at which its probability
//! says that the next one should be.

use super::sample_vertices::gumbel_keys;
use crate::linalg::Csr;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How often the unit of the radius is halved between its bounds.
const ROUNDS: usize = 14;
/// Scores farther than this from their mean count as if they were not: radii span a factor of `exp(2 * 3)`.
const MOST_SCORE: f64 = 6.0;

/// Draws k different vertices with a density proportional to `exp(score)` per vertex, none near another.
///
/// Vertices are visited in the order of their Gumbel keys. One is taken where no sample before it lies closer, along the
/// edges, than that sample's radius, `unit * sqrt(area / exp(score))` with the area about a vertex from its edges. The unit is
/// the largest found that leaves room for k.
///
/// # Shapes
/// - `points`: n x 3, `rings`: n x n, the edges
/// - `scores`: n
/// - returns min(k, n) vertices, ascending
///
/// # Panics
/// When the three differ in n.
///
/// ```
/// use neural_mesh::{linalg::Csr, simplify::scattered_samples};
/// let line: Vec<[f32; 3]> = (0..100).map(|i| [i as f32, 0.0, 0.0]).collect();
/// let edges = Csr::from_edges(100, (0..99).map(|i| [i, i + 1]));
/// let samples = scattered_samples(&line, &edges, &[0.0; 100], 20, 7);
/// assert!(samples.len() == 20 && samples.windows(2).all(|pair| pair[1] - pair[0] > 1));
/// ```
pub fn scattered_samples(points: &[[f32; 3]], rings: &Csr, scores: &[f32], k: usize, seed: u64) -> Vec<u32> {
    assert!(points.len() == rings.n_rows() && points.len() == scores.len(), "one row and one score per point");
    let mut keys = gumbel_keys(scores, seed);
    keys.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let order: Vec<u32> = keys.into_iter().map(|(_, vertex)| vertex).collect();
    if k >= order.len() {
        return (0..order.len() as u32).collect();
    }
    let field = Field { points, rings, radii: relative_radii(points, rings, scores) };
    let mut best = order.clone();
    let (mut low, mut high) = (0.0, 4.0 * (points.len() as f64 / k.max(1) as f64).sqrt());
    for _ in 0..ROUNDS {
        let unit = 0.5 * (low + high);
        let taken = field.taken(&order, unit);
        if taken.len() < k {
            high = unit;
        } else {
            low = unit;
            best = taken;
        }
    }
    best.truncate(k);
    best.sort_unstable();
    best
}

/// `sqrt(area / exp(score))`, the area that of a hexagon's share of the mean squared edge, the score about the mean.
fn relative_radii(points: &[[f32; 3]], rings: &Csr, scores: &[f32]) -> Vec<f64> {
    let mean = scores.iter().map(|&s| f64::from(s)).sum::<f64>() / scores.len().max(1) as f64;
    let radius = |(v, &score): (usize, &f32)| {
        let ring = rings.row(v);
        let squared: f64 = ring.iter().map(|&w| distance2(points[v], points[w as usize])).sum();
        let score = (f64::from(score) - mean).clamp(-MOST_SCORE, MOST_SCORE);
        (squared / ring.len().max(1) as f64 / score.exp()).sqrt()
    };
    scores.iter().enumerate().map(radius).collect()
}

fn distance2(p: [f32; 3], q: [f32; 3]) -> f64 {
    (0..3).map(|axis| f64::from(p[axis] - q[axis]).powi(2)).sum()
}

struct Field<'a> {
    points: &'a [[f32; 3]],
    rings: &'a Csr,
    radii: Vec<f64>,
}

impl Field<'_> {
    /// The vertices of `order` that no earlier one of them covers, at this unit of the radius.
    fn taken(&self, order: &[u32], unit: f64) -> Vec<u32> {
        let mut distance = vec![f64::INFINITY; order.len()];
        let mut taken = Vec::new();
        for &v in order {
            if distance[v as usize] == f64::INFINITY {
                taken.push(v);
                self.cover(&mut distance, v, unit * self.radii[v as usize]);
            }
        }
        taken
    }

    /// Marks what lies within `radius` of `from` along the edges and is not nearer to another sample.
    fn cover(&self, distance: &mut [f64], from: u32, radius: f64) {
        let mut front = BinaryHeap::from([Reverse((0u64, from))]);
        distance[from as usize] = 0.0;
        while let Some(Reverse((bits, v))) = front.pop() {
            let here = f64::from_bits(bits);
            if here > distance[v as usize] {
                continue;
            }
            for &w in self.rings.row(v as usize) {
                let there = here + distance2(self.points[v as usize], self.points[w as usize]).sqrt();
                if there <= radius && there < distance[w as usize] {
                    distance[w as usize] = there;
                    front.push(Reverse((there.to_bits(), w)));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::{edge_graph, gumbel_top_k};

    /// Mean squared distance from the vertices to the nearest sample.
    fn spread(points: &[[f32; 3]], samples: &[u32]) -> f64 {
        let nearest =
            |p: &[f32; 3]| samples.iter().map(|&s| distance2(*p, points[s as usize])).fold(f64::MAX, f64::min);
        points.iter().map(nearest).sum::<f64>() / points.len() as f64
    }

    #[test]
    fn samples_cover_better_than_independent_draws() {
        let mesh = shapes::icosphere(4);
        let (points, rings) = (mesh.positions(), edge_graph(&mesh));
        let scores = vec![0.0; points.len()];
        for k in [30, 200] {
            let scattered = scattered_samples(points, &rings, &scores, k, 1);
            assert_eq!(scattered.len(), k);
            assert!(spread(points, &scattered) < 0.7 * spread(points, &gumbel_top_k(&scores, k, 1)), "{k}");
        }
    }

    #[test]
    fn density_follows_the_scores() {
        let mesh = shapes::icosphere(4);
        let (points, rings) = (mesh.positions(), edge_graph(&mesh));
        let scores: Vec<f32> = points.iter().map(|p| if p[2] > 0.0 { 4.0f32.ln() } else { 0.0 }).collect();
        let samples = scattered_samples(points, &rings, &scores, 300, 3);
        let above = samples.iter().filter(|&&v| points[v as usize][2] > 0.0).count() as f64;
        assert!((above / (300.0 - above) / 4.0 - 1.0).abs() < 0.25, "{above}");
    }

    #[test]
    fn there_are_as_many_as_asked_for() {
        let mesh = shapes::icosphere(2);
        let (points, rings) = (mesh.positions(), edge_graph(&mesh));
        for k in [0, 1, 50, 161, 162, 1000] {
            let samples = scattered_samples(points, &rings, &vec![0.0; points.len()], k, 5);
            assert_eq!(samples.len(), k.min(points.len()));
            assert!(samples.is_sorted_by(|a, b| a < b));
        }
        assert_eq!(scattered_samples(&[[0.0; 3]; 9], &Csr::from_edges(9, []), &[0.0; 9], 4, 1).len(), 4);
    }
}
