//! Disjoint sets over indices, merged toward the smaller root.

/// Disjoint sets of `0..n`.
pub(crate) struct UnionFind {
    parent: Vec<u32>,
    sets: usize,
}

impl UnionFind {
    pub(crate) fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect(), sets: n }
    }

    /// The smallest member of the set of `x`.
    pub(crate) fn find(&mut self, mut x: u32) -> u32 {
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

    /// Merges two sets; returns whether they were different ones.
    pub(crate) fn union(&mut self, x: u32, y: u32) -> bool {
        if self.parent[x as usize] == self.parent[y as usize] {
            return false;
        }
        let (x, y) = (self.find(x), self.find(y));
        self.parent[x.max(y) as usize] = x.min(y);
        self.sets -= usize::from(x != y);
        x != y
    }

    /// How many sets there are.
    pub(crate) fn sets(&self) -> usize {
        self.sets
    }
}
