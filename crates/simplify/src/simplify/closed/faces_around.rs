//! Faces around each vertex and across each edge.

use rustc_hash::FxHashMap;

use crate::linalg::Rows;
use crate::mesh::pulse::Pulse;
use crate::mesh::thread_ranges::corner_rows;

/// Valence above which a vertex's edges are in a hash map.
// In a fan every edge of the hub is looked up, which would be quadratic in a list.
const MOST_SEARCHED: usize = 64;

pub fn smallest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        first if first == a => [a, b, c],
        first if first == b => [b, c, a],
        _ => [c, a, b],
    }
}

/// Faces around each vertex: rows in one array, and a map of changed rows.
pub struct FacesAround {
    rows: Rows<FaceCorner>,
    changed: FxHashMap<u32, Vec<FaceCorner>>,
    hub_edges: FxHashMap<[u32; 2], u32>,
}

/// Face at a vertex, and the vertex that follows in it.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct FaceCorner {
    pub face: u32,
    pub next: u32,
}

impl FacesAround {
    pub fn new(pulse: Pulse, n_vertices: usize, faces: &[[u32; 3]]) -> Self {
        let rows = corner_rows(pulse, n_vertices, faces, |face, [_, next, _]| FaceCorner { face, next });
        // A long row would be scanned for each of its edges; few vertices need the hash map.
        let mut around = Self { rows, changed: FxHashMap::default(), hub_edges: FxHashMap::default() };
        let Self { rows, hub_edges, .. } = &mut around;
        for v in (0..n_vertices as u32).filter(|&v| rows.row(v as usize).len() > MOST_SEARCHED) {
            for &FaceCorner { face, next } in rows.row(v as usize) {
                hub_edges.entry([v, next]).or_insert(face);
            }
        }
        around
    }

    fn is_hub(&self, vertex: u32) -> bool {
        self.rows.row(vertex as usize).len() > MOST_SEARCHED
    }

    #[inline]
    pub fn corners(&self, vertex: u32) -> &[FaceCorner] {
        if !self.changed.is_empty()
            && let Some(row) = self.changed.get(&vertex)
        {
            return row;
        }
        self.rows.row(vertex as usize)
    }

    pub fn faces(&self, vertex: u32) -> impl Iterator<Item = u32> {
        self.corners(vertex).iter().map(|corner| corner.face)
    }

    pub fn faces_of_all(&self, vertices: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let mut faces: Vec<u32> = vertices.into_iter().flat_map(|v| self.faces(v)).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    /// Finds the face with the directed edge from `u` to `v`.
    #[inline]
    pub fn face_along(&self, u: u32, v: u32) -> Option<u32> {
        let row = self.corners(u);
        if row.len() > MOST_SEARCHED && self.is_hub(u) {
            return self.hub_edges.get(&[u, v]).copied();
        }
        find_next(row, v)
    }

    pub fn has_edge(&self, u: u32, v: u32) -> bool {
        self.face_along(u, v).or_else(|| self.face_along(v, u)).is_some()
    }

    pub fn replace_face(&mut self, f: u32, before: [u32; 3], now: [u32; 3]) {
        let [a, b, c] = before;
        for (v, next) in [(a, b), (b, c), (c, a)] {
            // Rows are replaced as a whole: flips are few, and untouched rows stay in one array.
            let row: Vec<FaceCorner> = self.corners(v).iter().copied().filter(|corner| corner.face != f).collect();
            if self.is_hub(v) {
                match find_next(&row, next) {
                    Some(other) => self.hub_edges.insert([v, next], other),
                    None => self.hub_edges.remove(&[v, next]),
                };
            }
            self.changed.insert(v, row);
        }
        let [a, b, c] = now;
        for (v, next) in [(a, b), (b, c), (c, a)] {
            let row = [self.corners(v), &[FaceCorner { face: f, next }]].concat();
            if self.is_hub(v) {
                self.hub_edges.entry([v, next]).or_insert(f);
            }
            self.changed.insert(v, row);
        }
    }
}

#[inline]
fn find_next(row: &[FaceCorner], next: u32) -> Option<u32> {
    row.iter().find(|corner| corner.next == next).map(|corner| corner.face)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flipped_edge_is_found_as_in_a_new_table() {
        let mut faces = vec![[0, 1, 2], [1, 0, 3], [2, 1, 4]];
        let mut around = FacesAround::new(Pulse::NONE, 5, &faces);
        assert_eq!((around.face_along(1, 0), around.has_edge(2, 3)), (Some(1), false));
        for (f, now) in [(0u32, [2, 3, 1]), (1, [3, 2, 0])] {
            around.replace_face(f, std::mem::replace(&mut faces[f as usize], now), now);
        }
        let anew = FacesAround::new(Pulse::NONE, 5, &faces);
        for v in 0..5 {
            let sorted = |around: &FacesAround| {
                let mut row: Vec<(u32, u32)> = around.corners(v).iter().map(|c| (c.face, c.next)).collect();
                row.sort_unstable();
                row
            };
            assert_eq!(sorted(&around), sorted(&anew), "{v}");
        }
    }

    #[test]
    fn edges_of_a_hub_are_those_of_its_row() {
        let n = 3 * MOST_SEARCHED as u32;
        let mut faces: Vec<[u32; 3]> = (1..n).map(|v| [0, v, v + 1]).collect();
        faces.extend([[0, 7, 9], [0, 7, 11]]);
        let mut around = FacesAround::new(Pulse::NONE, n as usize + 1, &faces);
        assert!(around.is_hub(0) && !around.is_hub(1));
        for f in [6usize, 6, 20, 40, n as usize] {
            let [a, b, c] = faces[f];
            let now = [a, c, (b + 50) % n + 1];
            around.replace_face(f as u32, std::mem::replace(&mut faces[f], now), now);
            for v in 0..=n {
                assert_eq!(around.face_along(0, v), find_next(around.corners(0), v), "{f} {v}");
            }
        }
    }
}
