//! Selection of compatible triangles by votes.

use super::are_overlapping;
use glam::Vec3;
use neural_mesh::spatial::nearest_neighbours;
use rustc_hash::FxHashMap;

// Number of points near each corner whose triangles are checked for overlap; from the paper's program.
const NEAR: usize = 5;
// Overlap distance as a fraction of the mean nearest-point distance; from the paper's program.
const CLOSE: f64 = 0.3;

struct SelectedTriangles<'a> {
    points: &'a [[f32; 3]],
    near: Vec<u32>,
    within: f64,
    faces: Vec<[u32; 3]>,
    at: Vec<Vec<u32>>,
    edges: FxHashMap<[u32; 2], u8>,
}

/// Selects triangles by votes, then by shortest longest edge, without overlaps or edges of three faces.
///
/// # Shapes
/// - `points`: n x 3; `voted`: distinct triangles with 1 to 3 votes
pub fn select_triangles(points: &[[f32; 3]], voted: &[([u32; 3], u8)]) -> Vec<[u32; 3]> {
    let mut queue: Vec<(u8, f32, [u32; 3])> =
        voted.iter().map(|&(corners, votes)| (votes, longest_edge(points, corners), corners)).collect();
    queue.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut selected = SelectedTriangles::new(points);
    for (_, _, corners) in queue {
        if selected.fits(corners) {
            selected.add(corners);
        }
    }
    selected.faces
}

fn longest_edge(points: &[[f32; 3]], [a, b, c]: [u32; 3]) -> f32 {
    let at = |v: u32| Vec3::from(points[v as usize]);
    [[a, b], [b, c], [c, a]].map(|[p, q]| at(p).distance_squared(at(q))).into_iter().fold(0.0, f32::max)
}

fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)])
}

impl<'a> SelectedTriangles<'a> {
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
        !faces.iter().any(|&face| are_overlapping(self.points, [corners, self.faces[face as usize]], self.within))
    }

    fn add(&mut self, corners: [u32; 3]) {
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
        assert_eq!(select_triangles(&points, &voted), [[0, 1, 4], [0, 1, 2]]);
        let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let voted = [([0, 1, 2], 2), ([0, 1, 3], 1), ([0, 2, 3], 3)];
        assert_eq!(select_triangles(&square, &voted), [[0, 2, 3], [0, 1, 2]]);
    }

    #[test]
    fn nothing_of_nothing() {
        assert!(select_triangles(&[], &[]).is_empty());
    }
}
