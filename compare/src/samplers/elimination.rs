//! Weighted sample elimination (Yuksel 2015): blue noise by taking the most crowded points away, one by one.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

/// Exponent of the weights, limit on the smallest distances: the paper's alpha, beta and gamma.
const ALPHA: f64 = 8.0;
const BETA: f64 = 0.65;
const GAMMA: f64 = 1.5;

/// Keeps `n_kept` of the points of a surface of the given area, in order of their indices.
pub fn eliminate(points: &[[f32; 3]], n_kept: usize, area: f64) -> Vec<u32> {
    let n_kept = n_kept.min(points.len());
    let most = (area / (2.0 * 3f64.sqrt() * n_kept.max(1) as f64)).sqrt();
    let least = most * (1.0 - (n_kept as f64 / points.len() as f64).powf(GAMMA)) * BETA;
    let neighbours = Neighbours::new(points, 2.0 * most);
    let weight = |a: usize, b: usize| {
        let distance = distance(points[a], points[b]).clamp(2.0 * least, 2.0 * most);
        (1.0 - distance / (2.0 * most)).powf(ALPHA)
    };
    let sum = |i: usize| neighbours.of(points, i).map(|j| weight(i, j)).sum::<f64>();
    let mut crowding: Vec<f64> = (0..points.len()).map(sum).collect();
    let mut heap: BinaryHeap<Crowded> = crowding.iter().enumerate().map(|(i, &c)| Crowded(c, i)).collect();
    let mut kept = vec![true; points.len()];
    let mut left = points.len();
    while left > n_kept {
        let Some(Crowded(c, i)) = heap.pop() else { break };
        if !kept[i] || c != crowding[i] {
            continue;
        }
        kept[i] = false;
        left -= 1;
        for j in neighbours.of(points, i).filter(|&j| kept[j]) {
            crowding[j] -= weight(i, j);
            heap.push(Crowded(crowding[j], j));
        }
    }
    (0..points.len() as u32).filter(|&i| kept[i as usize]).collect()
}

/// A point and the sum of its weights at some time; the heap gives the most crowded first, of equal ones the first.
#[derive(PartialEq)]
struct Crowded(f64, usize);

impl Eq for Crowded {}

impl PartialOrd for Crowded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Crowded {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(other.1.cmp(&self.1))
    }
}

/// Points by cells as wide as the reach.
struct Neighbours {
    reach: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl Neighbours {
    fn new(points: &[[f32; 3]], reach: f64) -> Self {
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for (i, &p) in points.iter().enumerate() {
            cells.entry(cell(p, reach)).or_default().push(i as u32);
        }
        Self { reach, cells }
    }

    /// Points nearer than the reach, without the point itself.
    fn of(&self, points: &[[f32; 3]], i: usize) -> impl Iterator<Item = usize> {
        let [x, y, z] = cell(points[i], self.reach);
        let around = (0..27).map(move |k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]);
        let near = around.filter_map(|cell| self.cells.get(&cell)).flatten().map(|&j| j as usize);
        near.filter(move |&j| j != i && distance(points[i], points[j]) < self.reach)
    }
}

fn cell(p: [f32; 3], width: f64) -> [i64; 3] {
    p.map(|x| (f64::from(x) / width).floor() as i64)
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    (0..3).map(|k| (f64::from(a[k]) - f64::from(b[k])).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn what_is_kept_stands_apart() {
        let sphere = shapes::icosphere(5);
        let points = sphere.positions();
        let kept = eliminate(points, 500, 4.0 * std::f64::consts::PI);
        assert_eq!(kept.len(), 500);
        let at = |i: u32| points[i as usize];
        let nearest =
            |&i: &u32| kept.iter().filter(|&&j| j != i).map(|&j| distance(at(i), at(j))).fold(f64::INFINITY, f64::min);
        let least = kept.iter().map(nearest).fold(f64::INFINITY, f64::min);
        let most = (4.0 * std::f64::consts::PI / (2.0 * 3f64.sqrt() * 500.0)).sqrt();
        assert!(least > 1.2 * most, "{} of the largest possible spacing", least / (2.0 * most));
    }

    #[test]
    fn nothing_more_can_be_kept_than_there_is() {
        assert_eq!(eliminate(&[[0.0; 3], [1.0; 3]], 5, 1.0), [0, 1]);
        assert!(eliminate(&[], 5, 1.0).is_empty());
    }
}
