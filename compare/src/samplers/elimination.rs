//! Weighted sample elimination (Yuksel 2015): blue noise by taking the most crowded points away, one by one.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use super::metric::Cells;

/// Exponent of the weights, limit on the smallest distances: the paper's alpha, beta and gamma.
const ALPHA: f64 = 8.0;
const BETA: f64 = 0.65;
const GAMMA: f64 = 1.5;

/// Keeps `n_kept` of the points of a surface with these cells, in order of their indices.
///
/// To draw more where the density is higher, distances between two points are scaled by the root of the larger of their
/// densities.
pub fn eliminate(points: &[[f32; 3]], cells: &Cells, n_kept: usize) -> Vec<u32> {
    let n_kept = n_kept.min(points.len());
    let area: f64 = cells.areas.iter().sum();
    let most = (area / (2.0 * 3f64.sqrt() * n_kept.max(1) as f64)).sqrt();
    let least = most * (1.0 - (n_kept as f64 / points.len() as f64).powf(GAMMA)) * BETA;
    let neighbours = Neighbours::new(points, &cells.density, 2.0 * most);
    let weight = |distance: f64| (1.0 - distance.clamp(2.0 * least, 2.0 * most) / (2.0 * most)).powf(ALPHA);
    let mut crowding = vec![0.0; points.len()];
    (0..points.len())
        .for_each(|i| neighbours.of(i, &mut |j, distance| crowding[i] += if i == j { 0.0 } else { weight(distance) }));
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
        neighbours.of(i, &mut |j, distance| {
            if kept[j] {
                crowding[j] -= weight(distance);
                heap.push(Crowded(crowding[j], j));
            }
        });
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

/// Points sorted by the boxes of a grid.
struct Neighbours<'a> {
    points: &'a [[f32; 3]],
    /// How much longer than plain distances are at each point, n_points.
    scale: Vec<f64>,
    reach: f64,
    width: f64,
    boxes: HashMap<[i64; 3], Vec<u32>>,
}

impl<'a> Neighbours<'a> {
    fn new(points: &'a [[f32; 3]], density: &[f64], reach: f64) -> Self {
        let scale: Vec<f64> = density.iter().map(|density| density.sqrt()).collect();
        let width = reach * points.len() as f64 / scale.iter().sum::<f64>();
        let mut boxes: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for (i, &p) in points.iter().enumerate() {
            boxes.entry(cell(p, width)).or_default().push(i as u32);
        }
        Self { points, scale, reach, width, boxes }
    }

    /// Visits the points nearer than the reach with their distances, the point itself among them.
    fn of(&self, i: usize, visit: &mut dyn FnMut(usize, f64)) {
        let around = cell(self.points[i], self.width);
        let n = (self.reach / self.scale[i] / self.width).ceil() as i64;
        for [x, y, z] in (-n..=n).flat_map(|x| (-n..=n).flat_map(move |y| (-n..=n).map(move |z| [x, y, z]))) {
            let in_box = self.boxes.get(&[around[0] + x, around[1] + y, around[2] + z]);
            for j in in_box.into_iter().flatten().map(|&j| j as usize) {
                let distance = self.scale[i].max(self.scale[j]) * distance(self.points[i], self.points[j]);
                if distance < self.reach {
                    visit(j, distance);
                }
            }
        }
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
        let kept = eliminate(points, &Cells::new(&sphere, 0.0), 500);
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
        let plain = |n| Cells { areas: vec![1.0; n], density: vec![1.0; n] };
        assert_eq!(eliminate(&[[0.0; 3], [1.0; 3]], &plain(2), 5), [0, 1]);
        assert!(eliminate(&[], &plain(0), 5).is_empty());
    }

    #[test]
    fn where_the_density_is_four_times_as_high_stand_about_four_times_as_many() {
        let side = |x: i32| if x < 100 { 1.0 } else { 4.0 };
        let plate: Vec<[f32; 3]> = (0..200).flat_map(|x| (0..100).map(move |y| [x as f32, y as f32, 0.0])).collect();
        let density: Vec<f64> = plate.iter().map(|p| side(p[0] as i32)).collect();
        let kept = eliminate(&plate, &Cells { areas: density.clone(), density }, 1000);
        let dense = kept.iter().filter(|&&i| plate[i as usize][0] >= 100.0).count();
        assert!((740..860).contains(&dense), "{dense}");
    }
}
