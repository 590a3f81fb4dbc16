//! Disjoint sets over indices.

use super::half_edges::for_each_edge;
use super::pulse::Pulse;

#[doc(hidden)]
pub struct UnionFind {
    parent: Vec<u32>,
    sets: usize,
}

impl UnionFind {
    #[doc(hidden)]
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect(), sets: n }
    }

    /// Returns the smallest member of the set of `x`.
    #[doc(hidden)]
    pub fn find(&mut self, mut x: u32) -> u32 {
        loop {
            let parent = self.parent[x as usize];
            if parent == x {
                return x;
            }
            let above = self.parent[parent as usize];
            self.parent[x as usize] = above;
            x = above;
        }
    }

    /// Merges two sets; returns whether they were different.
    #[doc(hidden)]
    pub fn union(&mut self, x: u32, y: u32) -> bool {
        if self.parent[x as usize] == self.parent[y as usize] {
            return false;
        }
        let (x, y) = (self.find(x), self.find(y));
        self.parent[x.max(y) as usize] = x.min(y);
        self.sets -= usize::from(x != y);
        x != y
    }

    /// Returns each member's set number, counted in the order of first members, and the number of sets.
    #[doc(hidden)]
    pub fn number_sets(&mut self, pulse: Pulse) -> (Vec<u32>, usize) {
        let n = self.parent.len();
        let mut set_of: Vec<u32> = Vec::with_capacity(n);
        let mut n_sets = 0;
        for members in pulse.counting_if(false).ranges(0..n) {
            for x in members.start as u32..members.end as u32 {
                let first = self.find(x);
                let is_first = first == x;
                set_of.push(if is_first { n_sets } else { set_of[first as usize] });
                n_sets += u32::from(is_first);
            }
        }
        (set_of, n_sets as usize)
    }

    #[doc(hidden)]
    pub fn n_sets(&self) -> usize {
        self.sets
    }
}

/// Joins the vertices of each face.
#[doc(hidden)]
pub fn join_vertices(n_vertices: usize, faces: impl Iterator<Item = [u32; 3]>) -> UnionFind {
    let mut sets = UnionFind::new(n_vertices);
    faces.for_each(|[a, b, c]| {
        sets.union(a, b);
        sets.union(b, c);
    });
    sets
}

/// Joins faces over the edges whose number of faces `is_wanted` accepts.
#[doc(hidden)]
pub fn join_faces(n_vertices: usize, faces: &[[u32; 3]], is_wanted: impl Fn(usize) -> bool) -> UnionFind {
    let mut sets = UnionFind::new(faces.len());
    for_each_edge(n_vertices, faces, |_, around| {
        if is_wanted(around.len()) {
            around.windows(2).for_each(|pair| _ = sets.union(pair[0].face(), pair[1].face()));
        }
    });
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_numbered_by_their_first_members() {
        let mut sets = UnionFind::new(6);
        sets.union(5, 1);
        sets.union(4, 2);
        sets.union(2, 5);
        assert_eq!(sets.number_sets(Pulse::NONE), (vec![0, 1, 1, 2, 1, 1], 3));
        assert_eq!(UnionFind::new(0).number_sets(Pulse::NONE), (vec![], 0));
    }

    #[test]
    fn faces_are_joined_over_the_edges_that_are_wanted() {
        // Three faces at one edge, and one that touches the first at a vertex.
        let faces = [[0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 5, 6]];
        let sets = |is_wanted: fn(usize) -> bool| join_faces(7, &faces, is_wanted).number_sets(Pulse::NONE).0;
        assert_eq!(sets(|_| true), [0, 0, 0, 1]);
        assert_eq!(sets(|n| n == 2), [0, 1, 2, 3]);
    }
}
