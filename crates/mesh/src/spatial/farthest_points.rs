//! Farthest point sampling (Gonzalez 1985; Eldar et al. 1997), with a tree over the points.

use super::{Bounds, coherent_order};

const LEAF: usize = 32;

/// Picks `k` points, starting with `first`, each the farthest from those before it.
///
/// Ends early when every point is at the position of a sample.
///
/// # Shapes
/// - `points`: n x 3, finite; `first` below n
/// - returns at most min(k, n) indices, in the order of the picks
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::farthest_points;
/// let line: Vec<[f32; 3]> = (0..9).map(|i| [i as f32, 0.0, 0.0]).collect();
/// assert_eq!(farthest_points(&line, 3, 0), [0, 8, 4]);
/// assert_eq!(farthest_points(&[[1.0; 3]; 5], 3, 2), [2]);
/// ```
pub fn farthest_points(points: &[[f32; 3]], k: usize, first: u32) -> Vec<u32> {
    farthest_latent_points(points, &[], k, first)
}

/// Picks points as [`farthest_points`], by the distance between rows of a position and its latent numbers.
///
/// # Shapes
/// - `points`: n x 3, `latent`: n x width, row-major, both finite
///
/// # Panics
/// If `latent` does not have one row per point.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::farthest_latent_points;
/// let line: Vec<[f32; 3]> = (0..4).map(|i| [i as f32, 0.0, 0.0]).collect();
/// // The second point is not far away, but unlike the others.
/// assert_eq!(farthest_latent_points(&line, &[0.0, 9.0, 0.0, 0.0], 2, 0), [0, 1]);
/// ```
pub fn farthest_latent_points(points: &[[f32; 3]], latent: &[f32], k: usize, first: u32) -> Vec<u32> {
    let width = latent.len() / points.len().max(1);
    assert_eq!(latent.len(), width * points.len(), "a row of the latent space for each point");
    let mut samples = Vec::with_capacity(k.min(points.len()));
    if k == 0 || first as usize >= points.len() {
        return samples;
    }
    let mut field = Field::new(points, latent, width);
    samples.push(first);
    let mut own = latent[first as usize * width..][..width].to_vec();
    field.sample(points[first as usize], &own, 0);
    while samples.len() < k && field.nodes[0].far2 > 0.0 {
        let place = field.nodes[0].farthest;
        samples.push(field.order[place]);
        own.copy_from_slice(&field.latent[place * width..][..width]);
        field.sample(field.points[place], &own, 0);
    }
    samples
}

struct PointRange {
    bounds: Bounds,
    begin: usize,
    end: usize,
    children: Option<usize>,
    /// Largest squared distance from a point of the range to its nearest sample.
    far2: f64,
    /// Index of that point in the field's order.
    farthest: usize,
}

struct Field {
    order: Vec<u32>,
    points: Vec<[f32; 3]>,
    latent: Vec<f32>,
    width: usize,
    distance2: Vec<f64>,
    nodes: Vec<PointRange>,
}

impl Field {
    fn new(points: &[[f32; 3]], latent: &[f32], width: usize) -> Self {
        let order = coherent_order(points);
        let latent = order.iter().flat_map(|&at| &latent[at as usize * width..][..width]).copied().collect();
        let points: Vec<[f32; 3]> = order.iter().map(|&at| points[at as usize]).collect();
        let mut nodes = vec![node(&points, 0, points.len())];
        let mut at = 0;
        while at < nodes.len() {
            let (begin, end) = (nodes[at].begin, nodes[at].end);
            if end - begin > LEAF {
                let middle = begin.midpoint(end);
                nodes[at].children = Some(nodes.len());
                nodes.extend([node(&points, begin, middle), node(&points, middle, end)]);
            }
            at += 1;
        }
        Self { order, distance2: vec![f64::INFINITY; points.len()], points, latent, width, nodes }
    }

    /// Updates the distances in a node for a new sample, unless its box is too far away.
    fn sample(&mut self, p: [f32; 3], beside: &[f32], at: usize) {
        if gap2(&self.nodes[at].bounds, p) >= self.nodes[at].far2 {
            return;
        }
        let Some(child) = self.nodes[at].children else { return self.sample_leaf(p, beside, at) };
        self.sample(p, beside, child);
        self.sample(p, beside, child + 1);
        let farther = if self.nodes[child + 1].far2 > self.nodes[child].far2 { child + 1 } else { child };
        (self.nodes[at].far2, self.nodes[at].farthest) = (self.nodes[farther].far2, self.nodes[farther].farthest);
    }

    fn sample_leaf(&mut self, p: [f32; 3], beside: &[f32], at: usize) {
        let node = &mut self.nodes[at];
        node.far2 = 0.0;
        for place in node.begin..node.end {
            let latent = &self.latent[place * self.width..][..self.width];
            let distance2 = &mut self.distance2[place];
            *distance2 = distance2.min(squared_distance(self.points[place], p) + squared_difference(latent, beside));
            if *distance2 > node.far2 {
                (node.far2, node.farthest) = (*distance2, place);
            }
        }
    }
}

fn node(points: &[[f32; 3]], begin: usize, end: usize) -> PointRange {
    let bounds = Bounds::from_points(&points[begin..end]);
    PointRange { bounds, begin, end, children: None, far2: f64::INFINITY, farthest: begin }
}

fn gap2(bounds: &Bounds, p: [f32; 3]) -> f64 {
    squared_distance(p, std::array::from_fn(|axis| p[axis].clamp(bounds.low[axis], bounds.high[axis])))
}

fn squared_distance(p: [f32; 3], q: [f32; 3]) -> f64 {
    (0..3).map(|axis| (f64::from(p[axis]) - f64::from(q[axis])).powi(2)).sum()
}

fn squared_difference(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn reaches(points: &[[f32; 3]], samples: &[u32]) -> Vec<f64> {
        let distance2 = |a: u32, b: u32| squared_distance(points[a as usize], points[b as usize]);
        let reach = |i: usize| (0..i).map(|j| distance2(samples[i], samples[j])).fold(f64::INFINITY, f64::min);
        (0..samples.len()).map(reach).collect()
    }

    fn naive_reaches(points: &[[f32; 3]], k: usize, first: usize) -> Vec<f64> {
        let mut distance2 = vec![f64::INFINITY; points.len()];
        let mut next = first;
        let mut reaches = Vec::new();
        while reaches.len() < k && distance2[next] > 0.0 {
            reaches.push(distance2[next]);
            for (d, p) in distance2.iter_mut().zip(points) {
                *d = d.min(squared_distance(*p, points[next]));
            }
            next = (0..points.len()).fold(0, |best, i| if distance2[i] > distance2[best] { i } else { best });
        }
        reaches
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        #[test]
        fn every_sample_is_the_farthest(points in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 1..400)) {
            let samples = farthest_points(&points, 60, 0);
            prop_assert_eq!(reaches(&points, &samples), naive_reaches(&points, 60, 0));
        }

        #[test]
        fn every_sample_is_the_farthest_in_latent_space_too(
            rows in prop::collection::vec(prop::array::uniform5(-1.0f32..1.0), 1..300),
        ) {
            let points: Vec<[f32; 3]> = rows.iter().map(|row| [row[0], row[1], row[2]]).collect();
            let latent: Vec<f32> = rows.iter().flat_map(|row| [row[3], row[4]]).collect();
            let distance2 = |a: usize, b: usize| {
                squared_distance(points[a], points[b]) + squared_difference(&latent[2 * a..][..2], &latent[2 * b..][..2])
            };
            let samples = farthest_latent_points(&points, &latent, 40, 0);
            prop_assert_eq!(samples.len(), rows.len().min(40));
            for (n, &sample) in samples.iter().enumerate().skip(1) {
                let reach = |at: usize| samples[..n].iter().map(|&s| distance2(at, s as usize)).fold(f64::INFINITY, f64::min);
                prop_assert_eq!(reach(sample as usize), (0..rows.len()).map(reach).fold(0.0, f64::max));
            }
        }

        #[test]
        fn equal_points_are_sampled_once(points in prop::collection::vec(prop::array::uniform3(-1i8..2), 1..200)) {
            let points: Vec<[f32; 3]> = points.iter().map(|p| p.map(f32::from)).collect();
            let samples = farthest_points(&points, 1000, 0);
            let mut different: Vec<[u32; 3]> = points.iter().map(|p| p.map(|x| (x + 0.0).to_bits())).collect();
            different.sort_unstable();
            different.dedup();
            prop_assert_eq!(samples.len(), different.len());
        }
    }
}
