//! Half-edges, the sides of faces.
//!
//! The index of a half-edge is that of the corner where it starts: `3 * face + corner`.

use crate::linalg::Rows;

#[derive(Clone, Copy, Default)]
#[doc(hidden)]
pub struct HalfEdge {
    /// Larger vertex of the edge.
    pub end: u32,
    pub half_edge: u32,
}

impl HalfEdge {
    #[doc(hidden)]
    pub fn face(self) -> u32 {
        self.half_edge / 3
    }

    /// Returns whether the half-edge starts at the smaller vertex.
    #[doc(hidden)]
    pub fn runs_up(self, faces: &[[u32; 3]]) -> bool {
        start(faces, self.half_edge) != self.end
    }
}

#[doc(hidden)]
pub const NO_TWIN: u32 = u32::MAX;

#[doc(hidden)]
pub fn start(faces: &[[u32; 3]], half_edge: u32) -> u32 {
    faces.as_flattened()[half_edge as usize]
}

/// Returns the next half-edge of the face.
#[doc(hidden)]
pub fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

/// Calls `visit` with the ends of every edge, the smaller first, and its half-edges, ascending.
#[doc(hidden)]
pub fn for_each_edge(n_vertices: usize, faces: &[[u32; 3]], mut visit: impl FnMut([u32; 2], &[HalfEdge])) {
    let side = |half_edge, a: u32, b: u32| (a.min(b), HalfEdge { end: a.max(b), half_edge });
    let sides = |(f, &[a, b, c]): (u32, &[u32; 3])| [side(3 * f, a, b), side(3 * f + 1, b, c), side(3 * f + 2, c, a)];
    let mut at_low_ends = Rows::new(n_vertices, (0..).zip(faces).flat_map(sides));
    for vertex in 0..n_vertices {
        let half_edges = at_low_ends.row_mut(vertex);
        half_edges.sort_by_key(|h| h.end);
        half_edges.chunk_by(|x, y| x.end == y.end).for_each(|edge| visit([vertex as u32, edge[0].end], edge));
    }
}

/// Returns the twin of each half-edge; [`NO_TWIN`] unless the edge has two half-edges.
#[doc(hidden)]
pub fn twins(n_vertices: usize, faces: &[[u32; 3]]) -> Vec<u32> {
    let mut twins = vec![NO_TWIN; 3 * faces.len()];
    for_each_edge(n_vertices, faces, |_, edge| {
        if let &[g, h] = edge {
            twins[g.half_edge as usize] = h.half_edge;
            twins[h.half_edge as usize] = g.half_edge;
        }
    });
    twins
}

/// Winds the faces connected to `seeds` over edges with two faces; returns them, nearest first.
///
/// `is_against` gets true for faces wound against the seeds, and holds false for these.
#[doc(hidden)]
pub fn spread_winding(seeds: Vec<u32>, faces: &[[u32; 3]], twins: &[u32], is_against: &mut [Option<bool>]) -> Vec<u32> {
    let mut component = seeds;
    let mut n_done = 0;
    while let Some(&f) = component.get(n_done) {
        n_done += 1;
        for half_edge in 3 * f..3 * f + 3 {
            let twin = twins[half_edge as usize];
            if twin != NO_TWIN && is_against[twin as usize / 3].is_none() {
                let is_opposed = start(faces, half_edge) == start(faces, twin);
                is_against[twin as usize / 3] = is_against[f as usize].map(|of_face| of_face != is_opposed);
                component.push(twin / 3);
            }
        }
    }
    component
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};
    use std::collections::BTreeMap;

    fn soups() -> impl Iterator<Item = (u32, Vec<[u32; 3]>)> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        (0..60).map(move |round| {
            let n = 4 + round % 9;
            let faces = (0..2 * round).map(|_| [0; 3].map(|_| rng.next_u32() % n));
            (n, faces.filter(|&[a, b, c]| a != b && b != c && c != a).collect())
        })
    }

    fn naive(faces: &[[u32; 3]]) -> BTreeMap<[u32; 2], Vec<u32>> {
        let mut edges: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for half_edge in 0..3 * faces.len() as u32 {
            let [a, b] = [half_edge, next(half_edge)].map(|corner| start(faces, corner));
            edges.entry([a.min(b), a.max(b)]).or_default().push(half_edge);
        }
        edges
    }

    #[test]
    fn edges_agree_with_a_map_on_random_soups() {
        for (n, faces) in soups() {
            let mut found = Vec::new();
            for_each_edge(n as usize, &faces, |ends, edge| {
                assert!(edge.iter().all(|h| h.end == ends[1]));
                let is_up = |h: &HalfEdge| start(&faces, h.half_edge) == ends[0];
                assert!(edge.iter().all(|h| h.runs_up(&faces) == is_up(h)));
                found.push((ends, edge.iter().map(|h| h.half_edge).collect::<Vec<_>>()));
            });
            assert_eq!(found, naive(&faces).into_iter().collect::<Vec<_>>());
        }
    }

    #[test]
    fn twins_are_the_two_half_edges_of_an_edge() {
        for (n, faces) in soups() {
            let mut expected = vec![NO_TWIN; 3 * faces.len()];
            for edge in naive(&faces).into_values() {
                if let [g, h] = edge[..] {
                    (expected[g as usize], expected[h as usize]) = (h, g);
                }
            }
            assert_eq!(twins(n as usize, &faces), expected);
        }
    }

    #[test]
    fn without_faces_there_are_no_edges() {
        for_each_edge(3, &[], |_, _| unreachable!("no face has an edge"));
        assert!(twins(0, &[]).is_empty());
    }
}
