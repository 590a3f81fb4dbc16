//! Finds faces that have the same three vertices as an earlier face, in any order.

use super::first_equal::first_equal;

/// Comparisons per face after which lists give way to a hash table: long lists mean vertices with very many faces.
const COMPARISONS_PER_FACE: usize = 8;

/// The faces that repeat an earlier one, ascending; vertex indices are below `n_vertices`.
pub(super) fn repeated_faces(faces: &[[u32; 3]], n_vertices: usize) -> Vec<u32> {
    by_lists(faces, n_vertices).unwrap_or_else(|| by_hash(faces))
}

/// By lists of the faces whose lowest vertex is the same: near in memory where faces are near on the surface.
/// `None` where the lists get long.
fn by_lists(faces: &[[u32; 3]], n_vertices: usize) -> Option<Vec<u32>> {
    const END: u32 = u32::MAX;
    let mut head = vec![END; n_vertices];
    let mut next = Vec::with_capacity(faces.len());
    let mut repeated = Vec::new();
    let mut comparisons_left = COMPARISONS_PER_FACE * faces.len();
    for (i, &face) in faces.iter().enumerate() {
        let key = sorted(face);
        let first = &mut head[key[0] as usize];
        let mut other = *first;
        while other != END && sorted(faces[other as usize]) != key {
            comparisons_left = comparisons_left.checked_sub(1)?;
            other = next[other as usize];
        }
        next.push(*first);
        if other == END {
            *first = i as u32;
        } else {
            repeated.push(i as u32);
        }
    }
    Some(repeated)
}

/// By one hash table over all faces.
fn by_hash(faces: &[[u32; 3]]) -> Vec<u32> {
    let (first, _) = first_equal(faces.len(), |face| sorted(faces[face]));
    (0..faces.len() as u32).filter(|&face| first[face as usize] != face).collect()
}

/// Vertex indices ascending.
fn sorted([a, b, c]: [u32; 3]) -> [u32; 3] {
    let (low, high) = (a.min(b), a.max(b));
    [low.min(c), low.max(high.min(c)), high.max(c)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn lists_and_hash_agree_with_a_search(faces in prop::collection::vec(prop::array::uniform3(0u32..6), 0..50)) {
            let same = |a: &[u32; 3], b: &[u32; 3]| sorted(*a) == sorted(*b);
            let repeats = |&i: &u32| faces[..i as usize].iter().any(|face| same(face, &faces[i as usize]));
            let expected: Vec<u32> = (0..faces.len() as u32).filter(repeats).collect();
            prop_assert_eq!(&by_hash(&faces), &expected);
            prop_assert_eq!(by_lists(&faces, 6).unwrap_or(expected.clone()), expected);
        }
    }

    #[test]
    fn a_vertex_with_very_many_faces_costs_no_more() {
        let fan: Vec<_> = (1..100_000).map(|i| [i, 0, i + 1]).chain([[8, 0, 7], [3, 4, 0]]).collect();
        assert_eq!(by_lists(&fan, 100_001), None);
        assert_eq!(repeated_faces(&fan, 100_001), [99_999, 100_000]);
    }
}
