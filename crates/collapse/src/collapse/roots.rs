//! Disjoint sets by parents: the root of a set is its own parent.

/// Returns the root of the set of `v`, and halves the way there.
pub(crate) fn find_root(parents: &mut [u32], mut v: u32) -> u32 {
    while parents[v as usize] != v {
        let above = parents[parents[v as usize] as usize];
        parents[v as usize] = above;
        v = above;
    }
    v
}
