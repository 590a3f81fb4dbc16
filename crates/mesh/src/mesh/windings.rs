//! Connected faces and their relative winding.

use super::union_find::UnionFind;

/// Disjoint sets of faces in both windings: face `f` is `2 f`, reversed `2 f + 1`.
pub(super) struct Windings(UnionFind);

impl Windings {
    pub(super) fn new(n_faces: usize) -> Self {
        Self(UnionFind::new(2 * n_faces))
    }

    /// Joins two faces with equal or opposite winding; returns false if that makes the surface one-sided.
    pub(super) fn join(&mut self, [f, g]: [u32; 2], against: bool) -> bool {
        let g_beside_f = 2 * g + u32::from(against);
        if self.0.find(2 * f) == self.0.find(g_beside_f ^ 1) {
            return false;
        }
        self.0.union(2 * f, g_beside_f);
        self.0.union(2 * f + 1, g_beside_f ^ 1);
        true
    }

    /// Returns the first face connected to `f`, and whether `f` is wound opposite to it.
    pub(super) fn first(&mut self, f: u32) -> (u32, bool) {
        let [as_is, turned] = [2 * f, 2 * f + 1].map(|side| self.0.find(side));
        (as_is.min(turned) / 2, turned < as_is)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_joined_to_a_surface_with_one_side() {
        let mut sides = Windings::new(5);
        assert!(sides.join([0, 1], false) && sides.join([1, 2], true) && sides.join([3, 4], true));
        assert!(!sides.join([0, 2], false) && sides.join([0, 2], true));
        assert_eq!([0, 1, 2, 3, 4].map(|f| sides.first(f)), [(0, false), (0, false), (0, true), (3, false), (3, true)]);
        assert!(sides.join([4, 2], false) && sides.join([0, 3], false) && !sides.join([0, 3], true));
    }
}
