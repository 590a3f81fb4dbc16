//! The triangles that make the surface: those on which most patches agree, as far as they fit together.

use super::lie_over_each_other;
use glam::Vec3;
use neural_mesh::spatial::nearest_neighbours;
use rustc_hash::FxHashMap;

/// Triangles at so many of the points nearest to a corner are looked at, as in the paper's program.
const NEAR: usize = 5;
/// Triangles closer than this share of the mean distance of a point to its nearest lie over each other; as there.
const CLOSE: f64 = 0.3;

/// Triangles that were taken.
struct Taken<'a> {
    points: &'a [[f32; 3]],
    /// The nearest points of each, n x k.
    near: Vec<u32>,
    within: f64,
    faces: Vec<[u32; 3]>,
    /// Places in `faces` by point.
    at: Vec<Vec<u32>>,
    /// Triangles on each edge.
    edges: FxHashMap<[u32; 2], u8>,
}

/// Chooses triangles: those with most votes first, of those the ones whose longest edge is shortest, each where all its
/// edges have at most one triangle and it lies over none that was taken.
///
/// What comes out has edges of one or two triangles. A vertex may still have two fans, as in the paper's program.
///
/// # Shapes
/// - `points`: n x 3; `voted`: triangles with different corners below n, each once, with 1 to 3 votes
///
/// ```
/// use neural_mesh_bench::learned_baselines::dse::selected;
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let voted = [([0, 1, 2], 2), ([0, 1, 3], 1), ([0, 2, 3], 3)];
/// assert_eq!(selected(&points, &voted), [[0, 2, 3], [0, 1, 2]]);
/// ```
pub fn selected(points: &[[f32; 3]], voted: &[([u32; 3], u8)]) -> Vec<[u32; 3]> {
    let mut queue: Vec<(u8, f32, [u32; 3])> =
        voted.iter().map(|&(corners, votes)| (votes, longest_edge(points, corners), corners)).collect();
    queue.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut taken = Taken::new(points);
    for (_, _, corners) in queue {
        if taken.fits(corners) {
            taken.take(corners);
        }
    }
    taken.faces
}

fn longest_edge(points: &[[f32; 3]], [a, b, c]: [u32; 3]) -> f32 {
    let at = |v: u32| Vec3::from(points[v as usize]);
    [[a, b], [b, c], [c, a]].map(|[p, q]| at(p).distance_squared(at(q))).into_iter().fold(0.0, f32::max)
}

fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)])
}

impl<'a> Taken<'a> {
    fn new(points: &'a [[f32; 3]]) -> Self {
        let near = nearest_neighbours(points, NEAR);
        let k = near.len() / points.len().max(1);
        let distance =
            |(v, row): (usize, &[u32])| f64::from(Vec3::from(points[v]).distance(points[row[0] as usize].into()));
        let sum: f64 = near.chunks_exact(k.max(1)).enumerate().map(distance).sum();
        let within = CLOSE * sum / points.len().max(1) as f64;
        Self {
            points,
            near,
            within,
            faces: Vec::new(),
            at: vec![Vec::new(); points.len()],
            edges: FxHashMap::default(),
        }
    }

    fn fits(&self, corners: [u32; 3]) -> bool {
        if edges(corners).iter().any(|edge| self.edges.get(edge).is_some_and(|&n| n >= 2)) {
            return false;
        }
        let k = self.near.len() / self.points.len();
        let around = |v: u32| std::iter::once(v).chain(self.near[v as usize * k..][..k].iter().copied());
        let mut others: Vec<u32> = corners.into_iter().flat_map(around).collect();
        others.sort_unstable();
        others.dedup();
        let mut faces: Vec<u32> = others.iter().flat_map(|&v| self.at[v as usize].iter().copied()).collect();
        faces.sort_unstable();
        faces.dedup();
        !faces.iter().any(|&face| lie_over_each_other(self.points, [corners, self.faces[face as usize]], self.within))
    }

    fn take(&mut self, corners: [u32; 3]) {
        let face = self.faces.len() as u32;
        corners.iter().for_each(|&v| self.at[v as usize].push(face));
        edges(corners).into_iter().for_each(|edge| *self.edges.entry(edge).or_default() += 1);
        self.faces.push(corners);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn votes_go_before_length_and_no_edge_has_three() {
        let points: Vec<[f32; 3]> =
            vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-1.0, 1.5, 0.5], [-1.0, -2.0, 0.5]];
        let voted = [([0, 1, 2], 1), ([0, 1, 3], 1), ([0, 1, 4], 2)];
        assert_eq!(selected(&points, &voted), [[0, 1, 4], [0, 1, 2]]);
    }

    #[test]
    fn nothing_of_nothing() {
        assert!(selected(&[], &[]).is_empty());
    }
}
