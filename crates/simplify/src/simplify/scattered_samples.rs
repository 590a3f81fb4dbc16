//! Sampling of vertices by scores that keeps samples apart (Sec. 3.1).

use super::sample_vertices::gumbel_keys;
use crate::linalg::Csr;
use crate::parallel;
use std::collections::VecDeque;

/// Largest distance of a score from the mean of all scores.
// This keeps the density below 400 times the mean for networks in training; scores of the shipped weights stay within 3
// on twelve training meshes.
const MOST_SCORE: f64 = 6.0;

/// First reach, the least distance of samples, over that in the densest arrangement of k samples.
// Above 1, so that the first round leaves some of the samples to the next.
const FIRST_REACH: f64 = 1.2;

/// Ratio of the reaches of successive rounds.
const SHRINKING: f64 = 0.92;

/// Rounds after which the remaining samples are taken whatever their distance.
// Only vertices at one position are that near.
const MOST_ROUNDS: usize = 128;

/// Vertices whose edges a thread measures at once.
const BLOCK: usize = 1024;

/// Draws k different vertices with a density proportional to `exp(score)`, kept apart from each other.
///
/// Dart throwing (Cook 1986; McCool and Fiume 1992): vertices come in the order of
/// [`gumbel_top_k`](super::gumbel_top_k)'s draws. One becomes a sample if no sample is within a reach, which shrinks
/// from round to round. Distances run along the edges, stretched by `sqrt(exp(score) / area)`. Every component gets a
/// sample if k suffices.
///
/// # Shapes
/// - `points`: n x 3, `rings`: n x n, the edges
/// - `scores`: n
/// - returns min(k, n) vertices, ascending
///
/// # Panics
/// If `points`, `rings` and `scores` differ in n.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{linalg::Csr, simplify::scattered_samples};
/// let line: Vec<[f32; 3]> = (0..100).map(|i| [i as f32, 0.0, 0.0]).collect();
/// let edges = Csr::from_edges(100, (0..99).map(|i| [i, i + 1]));
/// let samples = scattered_samples(&line, &edges, &[0.0; 100], 20, 7);
/// assert!(samples.len() == 20 && samples.windows(2).all(|pair| pair[1] - pair[0] > 1));
/// ```
pub fn scattered_samples(points: &[[f32; 3]], rings: &Csr, scores: &[f32], k: usize, seed: u64) -> Vec<u32> {
    assert!(points.len() == rings.n_rows() && points.len() == scores.len(), "one row and one score per point");
    let k = k.min(points.len());
    let mut keys = gumbel_keys(scores, seed);
    keys.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let scores = centre_scores(scores);
    let waiting: Vec<u32> = keys.into_iter().map(|(_, vertex)| vertex).collect();
    let mut field = DistanceField::new(points, rings, &stretches(points, rings, &scores));
    let mut reach = first_reach(&scores, k);
    let (mut samples, mut waiting) = split_first_of_components(rings, waiting, k);
    samples.iter().for_each(|&sample| field.add_sample(sample, reach));
    for _ in 0..MOST_ROUNDS {
        // Vertices that are left out now may be far enough for the shorter reach of the next round.
        waiting.retain(|&vertex| {
            let is_sample = samples.len() < k && field.distance[vertex as usize] >= reach;
            if is_sample {
                samples.push(vertex);
                field.add_sample(vertex, reach);
            }
            !is_sample
        });
        if samples.len() == k {
            break;
        }
        reach *= SHRINKING;
    }
    samples.extend(waiting.into_iter().take(k - samples.len()));
    samples.sort_unstable();
    samples
}

fn split_first_of_components(rings: &Csr, waiting: Vec<u32>, k: usize) -> (Vec<u32>, Vec<u32>) {
    let (mut is_reached, mut front) = (vec![false; rings.n_rows()], Vec::new());
    let mut begins_component = |vertex: u32| {
        if is_reached[vertex as usize] {
            return false;
        }
        front.push(vertex);
        while let Some(v) = front.pop() {
            if !std::mem::replace(&mut is_reached[v as usize], true) {
                front.extend(rings.row(v as usize).iter().filter(|&&w| !is_reached[w as usize]));
            }
        }
        true
    };
    let (mut first, mut others) = (Vec::new(), Vec::with_capacity(waiting.len()));
    for vertex in waiting {
        let list = if first.len() < k && begins_component(vertex) { &mut first } else { &mut others };
        list.push(vertex);
    }
    (first, others)
}

fn first_reach(scores: &[f64], k: usize) -> f64 {
    let area: f64 = scores.iter().map(|score| score.exp()).sum();
    // In the densest arrangement, of triangles, each sample has an area of sqrt(3) / 2 of its squared distance.
    FIRST_REACH * (2.0 / 3f64.sqrt() * area / k.max(1) as f64).sqrt()
}

fn centre_scores(scores: &[f32]) -> Vec<f64> {
    let mean = scores.iter().map(|&s| f64::from(s)).sum::<f64>() / scores.len().max(1) as f64;
    scores.iter().map(|&score| (f64::from(score) - mean).clamp(-MOST_SCORE, MOST_SCORE)).collect()
}

/// Returns `sqrt(exp(score) / area)` of each vertex, with the mean squared edge as area.
fn stretches(points: &[[f32; 3]], rings: &Csr, scores: &[f64]) -> Vec<f64> {
    let stretch = |v: usize| {
        let ring = rings.row(v);
        let squared: f64 = ring.iter().map(|&w| distance2(points[v], points[w as usize])).sum();
        if squared > 0.0 { (scores[v].exp() * ring.len() as f64 / squared).sqrt() } else { 0.0 }
    };
    parallel::map(scores.len(), BLOCK, stretch)
}

fn distance2(p: [f32; 3], q: [f32; 3]) -> f64 {
    (0..3).map(|axis| f64::from(p[axis] - q[axis]).powi(2)).sum()
}

struct DistanceField<'a> {
    rings: &'a Csr,
    lengths: Vec<f64>,
    distance: Vec<f64>,
    front: VecDeque<u32>,
}

impl<'a> DistanceField<'a> {
    /// Builds the field without samples; `stretch` is the factor on lengths at each vertex.
    fn new(points: &[[f32; 3]], rings: &'a Csr, stretch: &[f64]) -> Self {
        let length = |v: usize, w: usize| 0.5 * (stretch[v] + stretch[w]) * distance2(points[v], points[w]).sqrt();
        let of_block = |begin: usize| {
            let rows = begin..(begin + BLOCK).min(points.len());
            let mut lengths = Vec::with_capacity(rings.rows_range(rows.clone()).len());
            rows.for_each(|v| lengths.extend(rings.row(v).iter().map(|&w| length(v, w as usize))));
            lengths
        };
        let lengths = parallel::each((0..points.len()).step_by(BLOCK), of_block).concat();
        Self { rings, lengths, distance: vec![f64::INFINITY; points.len()], front: VecDeque::new() }
    }

    /// Lowers the distances around a sample, up to `reach`.
    // A queue in place of a heap: within a reach are a few vertices, of which hardly one is visited twice, and the least sum along
    // a path does not depend on the order of visits.
    fn add_sample(&mut self, sample: u32, reach: f64) {
        let Self { rings, lengths, distance, front } = self;
        distance[sample as usize] = 0.0;
        front.push_back(sample);
        while let Some(v) = front.pop_front() {
            let here = distance[v as usize];
            for (&w, length) in rings.row(v as usize).iter().zip(&lengths[rings.range(v as usize)]) {
                let there = here + length;
                if there < reach && there < distance[w as usize] {
                    distance[w as usize] = there;
                    front.push_back(w);
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
    fn the_requested_number_of_samples_is_drawn() {
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
