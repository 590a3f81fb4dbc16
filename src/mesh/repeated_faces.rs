//! Finds faces that have the same three vertices as an earlier face, in any order.

use super::first_equal::first_equal;

/// All bits of a vertex's mark: at least two faces at it set the same one.
const SUSPECT: u32 = u32::MAX;

/// The faces that repeat an earlier one, ascending; vertex indices are below `n_vertices`.
///
/// Each face sets one of 32 bits at its lowest vertex, chosen by the other two. Only faces at vertices where two set the same bit
/// can be equal, and only these are looked up: of usual meshes a tenth to three tenths.
pub(super) fn repeated_faces(faces: &[[u32; 3]], n_vertices: usize) -> Vec<u32> {
    let mut marks = vec![0u32; n_vertices];
    let mut any = false;
    for &face in faces {
        let [lowest, middle, highest] = sorted(face);
        let bit = 1 << (middle.wrapping_mul(0x9e37_79b9).wrapping_add(highest.wrapping_mul(0x85eb_ca6b)) >> 27);
        let mark = &mut marks[lowest as usize];
        let repeats = *mark & bit != 0;
        any |= repeats;
        *mark = if repeats { SUSPECT } else { *mark | bit };
    }
    if !any {
        return Vec::new();
    }
    let is_suspect = |&i: &u32| marks[lowest(faces[i as usize]) as usize] == SUSPECT;
    let suspects: Vec<u32> = (0..faces.len() as u32).filter(is_suspect).collect();
    let (first, _) = first_equal(suspects.len(), |i| sorted(faces[suspects[i] as usize]));
    suspects.iter().zip(0..).filter(|&(_, i)| first[i as usize] != i).map(|(&face, _)| face).collect()
}

/// Vertex indices ascending.
fn sorted([a, b, c]: [u32; 3]) -> [u32; 3] {
    let (low, high) = (a.min(b), a.max(b));
    [low.min(c), low.max(high.min(c)), high.max(c)]
}

fn lowest([a, b, c]: [u32; 3]) -> u32 {
    a.min(b).min(c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_a_search(
            faces in prop::collection::vec(prop::array::uniform3(0u32..6), 0..50),
            spread in prop::sample::select(vec![1u32, 1000]),
        ) {
            let faces: Vec<_> = faces.into_iter().map(|face| face.map(|vertex| vertex * spread)).collect();
            let same = |a: &[u32; 3], b: &[u32; 3]| sorted(*a) == sorted(*b);
            let repeats = |&i: &u32| faces[..i as usize].iter().any(|face| same(face, &faces[i as usize]));
            let expected: Vec<u32> = (0..faces.len() as u32).filter(repeats).collect();
            prop_assert_eq!(repeated_faces(&faces, 6 * spread as usize), expected);
        }
    }

    #[test]
    fn a_vertex_with_very_many_faces_is_no_trouble() {
        let fan: Vec<_> = (1..100_000).map(|i| [i, 0, i + 1]).chain([[8, 0, 7], [3, 4, 0]]).collect();
        assert_eq!(repeated_faces(&fan, 100_001), [99_999, 100_000]);
    }
}
