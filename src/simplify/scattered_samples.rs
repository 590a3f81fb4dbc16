//! Vertex sampling by scores that spreads the samples, Sec. 3.1: the multinomial's density with blue noise.
//!
//! The first vertex is drawn as in [`gumbel_top_k`](super::gumbel_top_k). Each further one is the farthest from all
//! before it, in a metric that makes the wanted density uniform (farthest point sampling, Eldar et al. 1997).

use super::sample_vertices::gumbel_keys;
use crate::linalg::Csr;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;

/// Largest difference of a score from the mean; the density stays within 400 times the mean.
const MOST_SCORE: f64 = 6.0;

/// Draws k different vertices with a density proportional to `exp(score)` per vertex, spread as far apart as possible.
///
/// Distances run along the edges. An edge of length l counts `l sqrt(exp(score) / area)`, the mean of both ends; the
/// area at a vertex is estimated from its edges. Unreached vertices are farthest, so every component gets a sample if k
/// suffices. Ties follow the Gumbel keys.
///
/// # Shapes
/// - `points`: n x 3, `rings`: n x n, the edges
/// - `scores`: n
/// - returns min(k, n) vertices, ascending
///
/// # Panics
/// If the three differ in n.
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
    let mut field = SampleField::new(points, rings, &metric_stretch(points, rings, scores));
    let mut samples = Vec::with_capacity(k.min(points.len()));
    let Some((&(_, first), others)) = keys.split_first().filter(|_| k > 0) else { return samples };
    samples.push(first);
    field.add_sample(first);
    // Unreached vertices are all infinitely far and sorted by their keys.
    let rank = |(at, &(_, vertex)): (usize, &(f64, u32))| (field.bits(vertex), Reverse(at as u32), vertex);
    let mut waiting: BinaryHeap<(u64, Reverse<u32>, u32)> = others.iter().enumerate().map(rank).collect();
    while samples.len() < k {
        let Some(mut farthest) = waiting.peek_mut() else { break };
        // A queued distance may be out of date: distances only fall, so the top is refreshed until it holds.
        let bits = field.bits(farthest.2);
        if bits < farthest.0 {
            farthest.0 = bits;
        } else {
            let (_, _, vertex) = PeekMut::pop(farthest);
            samples.push(vertex);
            field.add_sample(vertex);
        }
    }
    samples.sort_unstable();
    samples
}

/// Computes `sqrt(exp(score) / area)` with the mean squared edge as area; 0 without area.
fn metric_stretch(points: &[[f32; 3]], rings: &Csr, scores: &[f32]) -> Vec<f64> {
    let mean = scores.iter().map(|&s| f64::from(s)).sum::<f64>() / scores.len().max(1) as f64;
    let stretch = |(v, &score): (usize, &f32)| {
        let ring = rings.row(v);
        let squared: f64 = ring.iter().map(|&w| distance2(points[v], points[w as usize])).sum();
        let score = (f64::from(score) - mean).clamp(-MOST_SCORE, MOST_SCORE);
        if squared > 0.0 { (score.exp() * ring.len() as f64 / squared).sqrt() } else { 0.0 }
    };
    scores.iter().enumerate().map(stretch).collect()
}

fn distance2(p: [f32; 3], q: [f32; 3]) -> f64 {
    (0..3).map(|axis| f64::from(p[axis] - q[axis]).powi(2)).sum()
}

struct SampleField<'a> {
    rings: &'a Csr,
    lengths: Vec<f64>,
    distance: Vec<f64>,
    /// Queue of Dijkstra's algorithm; kept for its memory.
    front: BinaryHeap<Reverse<(u64, u32)>>,
}

impl<'a> SampleField<'a> {
    /// Computes edge lengths; `stretch` is the metric over Euclidean length at each vertex.
    fn new(points: &[[f32; 3]], rings: &'a Csr, stretch: &[f64]) -> Self {
        let length = |v: usize, w: usize| 0.5 * (stretch[v] + stretch[w]) * distance2(points[v], points[w]).sqrt();
        let of_vertex = |v: usize| rings.row(v).iter().map(move |&w| length(v, w as usize));
        let lengths = (0..points.len()).into_par_iter().flat_map_iter(of_vertex).collect();
        Self { rings, lengths, distance: vec![f64::INFINITY; points.len()], front: BinaryHeap::new() }
    }

    fn bits(&self, vertex: u32) -> u64 {
        self.distance[vertex as usize].to_bits()
    }

    fn add_sample(&mut self, sample: u32) {
        let Self { rings, lengths, distance, front } = self;
        distance[sample as usize] = 0.0;
        front.push(Reverse((0, sample)));
        while let Some(Reverse((bits, v))) = front.pop() {
            let (v, here) = (v as usize, f64::from_bits(bits));
            // An outdated entry: the vertex was reached on a shorter way.
            if here > distance[v] {
                continue;
            }
            for (&w, length) in rings.row(v).iter().zip(&lengths[rings.range(v)]) {
                let there = here + length;
                if there < distance[w as usize] {
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
