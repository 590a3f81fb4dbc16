//! Faces with the same three vertices.

use glam::Vec3;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::geometry::triangle::area_normal_f64;

use super::first_equal::first_equal;
use super::pulse::Pulse;
use super::union_find::UnionFind;
use super::winding::wind;

/// Largest area of connected pairs of coincident faces, relative to the mesh, at which both faces are dropped.
const SMALL: f64 = 1e-4;
/// Mark of a vertex at which two faces set one bit.
const SUSPECT: u32 = u32::MAX;

/// Returns the faces that repeat an earlier one, ascending.
///
/// Each face sets one of 32 bits at its lowest vertex; faces are compared only where a bit was set twice.
pub(super) fn repeated_faces(faces: &[[u32; 3]], n_vertices: usize) -> Vec<u32> {
    let mut marks = vec![0u32; n_vertices];
    let mut any = false;
    for &face in faces {
        let [lowest, middle, highest] = sort_corners(face);
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
    let (first, _) = first_equal(suspects.len(), |i| sort_corners(faces[suspects[i] as usize]));
    suspects.iter().zip(0..).filter(|&(_, i)| first[i as usize] != i).map(|(&face, _)| face).collect()
}

/// Returns the faces to drop, ascending: superfluous ones of `repeated`, and pairs in small patches on a body.
///
/// A patch of connected repeated faces stays if, at an edge with an even number of faces, dropping it would leave an
/// odd number above one, some of them without a copy: closed bodies touch along the patch.
pub(super) fn superfluous_faces(positions: &[[f32; 3]], faces: &[[u32; 3]], repeated: Vec<u32>) -> Vec<u32> {
    if repeated.is_empty() {
        return repeated;
    }
    let mut edges: FxHashMap<[u32; 2], RepeatedEdge> = FxHashMap::default();
    let mut patches = UnionFind::new(repeated.len());
    let mut with_copies = FxHashSet::default();
    for (place, &face) in (0..).zip(&repeated) {
        let is_first_copy = with_copies.insert(sort_corners(faces[face as usize]));
        for side in sides(faces[face as usize]) {
            let edge = edges.entry(side).or_insert(RepeatedEdge { n_faces: 0, n_repeated: 0, n_with_copies: 0, place });
            edge.n_repeated += 1;
            edge.n_with_copies += u32::from(is_first_copy);
            patches.union(place, edge.place);
        }
    }
    for side in faces.iter().flat_map(|&face| sides(face)) {
        edges.entry(side).and_modify(|edge| edge.n_faces += 1);
    }
    let mut is_blocked = vec![false; repeated.len()];
    let would_open = |edge: &&RepeatedEdge| {
        let n_left = edge.n_faces - edge.n_repeated;
        // Where each face has a copy, the whole surface is there twice, once for each side.
        edge.n_faces.is_multiple_of(2) && n_left % 2 == 1 && n_left > edge.n_with_copies.max(1)
    };
    for edge in edges.values().filter(would_open) {
        is_blocked[patches.find(edge.place) as usize] = true;
    }
    let blocked = (0..).zip(&repeated).filter(|&(place, _)| is_blocked[patches.find(place) as usize]);
    let kept = pick_odd_copies(faces, blocked.map(|(_, &face)| face));
    let mut superfluous: Vec<u32> = repeated.into_iter().filter(|face| !kept.contains(face)).collect();
    for side in superfluous.iter().flat_map(|&face| sides(faces[face as usize])) {
        edges.entry(side).and_modify(|edge| edge.n_faces -= 1);
    }
    superfluous.extend(superfluous_in_pairs(positions, faces, find_face_pairs(faces, &kept, &mut edges), &edges));
    superfluous.sort_unstable();
    superfluous
}

/// Exchanges superfluous faces and their kept backs, so that kept faces are wound as their neighbours, or outward.
pub(super) fn prefer_wound_sides(positions: &[[f32; 3]], faces: &[[u32; 3]], superfluous: &mut [u32]) {
    let mut dropped = superfluous.iter().copied().peekable();
    let kept: Vec<u32> = (0..faces.len() as u32).filter(|face| dropped.next_if_eq(face).is_none()).collect();
    let mut wound: Vec<[u32; 3]> = kept.iter().map(|&face| faces[face as usize]).collect();
    let backs = find_backs(faces, &wound, superfluous);
    if backs.is_empty() {
        return;
    }
    let may_turn: Vec<bool> = (0..kept.len()).map(|i| backs.contains_key(&i)).collect();
    wind(positions, &mut wound, &may_turn);
    for (i, place) in backs {
        if is_even(wound[i]) != is_even(faces[kept[i] as usize]) {
            superfluous[place] = kept[i];
        }
    }
    superfluous.sort_unstable();
}

/// Returns the place in `superfluous` of the back of each kept face, except where several coincident faces are kept.
fn find_backs(faces: &[[u32; 3]], kept: &[[u32; 3]], superfluous: &[u32]) -> FxHashMap<usize, usize> {
    let mut same: FxHashMap<[u32; 3], (Vec<usize>, Vec<usize>)> = FxHashMap::default();
    for (place, &face) in superfluous.iter().enumerate() {
        same.entry(sort_corners(faces[face as usize])).or_default().1.push(place);
    }
    for (i, &face) in kept.iter().enumerate() {
        same.entry(sort_corners(face)).and_modify(|same| same.0.push(i));
    }
    let back = |(kept_faces, places): (Vec<usize>, Vec<usize>)| {
        let &[i] = kept_faces.as_slice() else { return None };
        let is_back = |&place: &usize| is_even(faces[superfluous[place] as usize]) != is_even(kept[i]);
        places.into_iter().find(is_back).map(|place| (i, place))
    };
    same.into_values().filter_map(back).collect()
}

/// Returns the pairs of coincident faces that bound no body, from the rim inward; subtracts them from `edges`.
fn find_face_pairs(faces: &[[u32; 3]], kept: &[u32], edges: &mut FxHashMap<[u32; 2], RepeatedEdge>) -> Vec<[u32; 2]> {
    let mut same: FxHashMap<[u32; 3], Vec<u32>> =
        kept.iter().map(|&face| (sort_corners(faces[face as usize]), Vec::new())).collect();
    for (face, &corners) in (0..).zip(faces) {
        same.entry(sort_corners(corners)).and_modify(|same| same.push(face));
    }
    let mut at_sides: FxHashMap<[u32; 2], Vec<[u32; 3]>> = FxHashMap::default();
    same.keys().for_each(|&face| sides(face).into_iter().for_each(|side| at_sides.entry(side).or_default().push(face)));
    let mut pairs = Vec::new();
    let mut open: Vec<[u32; 3]> = same.keys().copied().collect();
    while let Some(face) = open.pop() {
        let n_own = sides(face).iter().filter(|side| edges.get(*side).is_some_and(|edge| edge.n_faces == 2)).count();
        let pair = same.get(&face).and_then(|same| <[u32; 2]>::try_from(same.as_slice()).ok());
        let Some(pair) = pair.filter(|_| n_own >= 2) else { continue };
        pairs.push(pair);
        same.remove(&face);
        for side in sides(face) {
            edges.entry(side).and_modify(|edge| edge.n_faces -= 2);
            open.extend(at_sides.get(&side).into_iter().flatten());
        }
    }
    pairs
}

/// Returns the faces to drop: both of pairs in small attached patches, and the second of other pairs.
fn superfluous_in_pairs(
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    pairs: Vec<[u32; 2]>,
    edges: &FxHashMap<[u32; 2], RepeatedEdge>,
) -> Vec<u32> {
    let area = |face: [u32; 3]| area_normal_f64(face.map(|v| Vec3::from(positions[v as usize]).as_dvec3())).length();
    let mut joined = UnionFind::new(pairs.len());
    let mut first_at: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for (number, pair) in (0..).zip(&pairs) {
        for side in sides(faces[pair[0] as usize]) {
            joined.union(number, *first_at.entry(side).or_insert(number));
        }
    }
    let (patch, n) = joined.number_sets(Pulse::NONE);
    let mut sums = vec![(0.0, false); n];
    for (pair, &patch) in pairs.iter().zip(&patch) {
        let face = faces[pair[0] as usize];
        let (sum, is_attached) = &mut sums[patch as usize];
        *sum += area(face);
        *is_attached |= sides(face).iter().any(|side| edges.get(side).is_some_and(|edge| edge.n_faces > 0));
    }
    let all: f64 = if pairs.is_empty() { 0.0 } else { faces.iter().map(|&face| area(face)).sum() };
    let is_removed = |patch: u32| sums[patch as usize].1 && sums[patch as usize].0 <= SMALL * all;
    pairs
        .iter()
        .zip(patch)
        .flat_map(|(pair, patch)| if is_removed(patch) { &pair[..] } else { &pair[1..] })
        .copied()
        .collect()
}

struct RepeatedEdge {
    n_faces: u32,
    n_repeated: u32,
    /// Faces, counted once each, that are repeated.
    n_with_copies: u32,
    place: u32,
}

fn pick_odd_copies(faces: &[[u32; 3]], some: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut same: FxHashMap<[u32; 3], Vec<u32>> = FxHashMap::default();
    some.for_each(|face| same.entry(sort_corners(faces[face as usize])).or_default().push(face));
    same.retain(|_, same| same.len() % 2 == 1);
    let mut kept = Vec::new();
    for &face in faces {
        // The first face over these vertices.
        let Some(same) = same.remove(&sort_corners(face)) else { continue };
        let against = same.iter().find(|&&other| is_even(faces[other as usize]) != is_even(face));
        kept.extend(against.or(same.first()));
    }
    kept
}

fn is_even([a, b, c]: [u32; 3]) -> bool {
    [a < b, b < c, c < a].iter().filter(|ascends| **ascends).count() == 2
}

/// Returns the edges of a face, the smaller vertex first.
#[doc(hidden)]
pub fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)])
}

fn sort_corners([a, b, c]: [u32; 3]) -> [u32; 3] {
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
            let same = |a: &[u32; 3], b: &[u32; 3]| sort_corners(*a) == sort_corners(*b);
            let repeats = |&i: &u32| faces[..i as usize].iter().any(|face| same(face, &faces[i as usize]));
            let expected: Vec<u32> = (0..faces.len() as u32).filter(repeats).collect();
            prop_assert_eq!(repeated_faces(&faces, 6 * spread as usize), expected);
        }
    }

    fn curve(n: usize) -> Vec<[f32; 3]> {
        (0..n).map(|i| [i as f32, (i * i) as f32, (i * i * i) as f32]).collect()
    }

    fn superfluous(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<u32> {
        superfluous_faces(positions, faces, repeated_faces(faces, positions.len()))
    }

    #[test]
    fn a_wall_between_closed_bodies_keeps_both_its_sides() {
        let bodies = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 2, 0], [1, 0, 4], [2, 1, 4], [0, 2, 4]];
        assert_eq!(repeated_faces(&bodies, 5), [4]);
        assert!(superfluous(&curve(5), &bodies).is_empty());
        // Two of four coincident faces stay.
        let more = [&bodies[..], &[[0, 2, 1], [1, 2, 0]]].concat();
        assert_eq!(superfluous(&curve(5), &more).len(), 2);
    }

    #[test]
    fn a_surface_for_each_side_is_one_surface_where_sheets_meet_too() {
        let sheets = [[0, 1, 2], [0, 1, 3], [1, 0, 4]];
        let backs = sheets.map(|[a, b, c]| [a, c, b]);
        let faces = [sheets, backs].concat();
        assert_eq!(superfluous(&curve(5), &faces), [3, 4, 5]);
    }

    #[test]
    fn small_attached_face_pairs_are_dropped() {
        let body = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let patch = [[0, 1, 4], [1, 0, 4], [1, 5, 4], [5, 1, 4]];
        let faces = [&body[..], &patch[..]].concat();
        let mut positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        positions.extend([[0.5, -1e-4, 0.0], [1.0, -1e-4, 0.0]]);
        assert_eq!(superfluous(&positions, &faces), [4, 5, 6, 7]);
        positions[4..].copy_from_slice(&[[0.5, -0.1, 0.0], [1.0, -0.1, 0.0]]);
        assert_eq!(superfluous(&positions, &faces), [5, 7]);
    }

    #[test]
    fn leaves_with_two_sides_keep_one() {
        let leaves: Vec<[u32; 3]> = [2, 3, 4].into_iter().flat_map(|tip| [[0, 1, tip], [1, 0, tip]]).collect();
        assert_eq!(superfluous(&curve(5), &leaves), [1, 3, 5]);
    }

    #[test]
    fn copies_whose_removal_opens_no_edge_are_superfluous() {
        let body = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let one_more = [&body[..], &[[0, 1, 2]]].concat();
        assert_eq!(superfluous(&curve(4), &one_more), [4]);
        let twice = [body, body].concat();
        assert_eq!(superfluous(&curve(4), &twice), [4, 5, 6, 7]);
        assert_eq!(superfluous(&curve(3), &[[0, 1, 2], [1, 2, 0]]), [1]);
    }

    #[test]
    fn of_a_face_and_its_back_the_one_wound_as_its_neighbours_stays() {
        // Faces 1 and 3 of a tetrahedron come inside out first; face 2 has no back.
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [1, 0, 3], [1, 2, 3], [0, 2, 3], [0, 1, 2], [0, 1, 3], [2, 0, 3]];
        let mut dropped = superfluous(&positions, &faces);
        assert_eq!(dropped, [4, 5, 6]);
        prefer_wound_sides(&positions, &faces, &mut dropped);
        assert_eq!(dropped, [1, 3, 4]);
        // Without it, the tetrahedron is turned outward; all faces were inside out.
        let faces = [[0, 1, 2], [1, 0, 3], [2, 1, 3], [0, 2, 3], [0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mut dropped = superfluous(&positions, &faces);
        prefer_wound_sides(&positions, &faces, &mut dropped);
        assert_eq!(dropped, [0, 1, 2, 3]);
        // A flat sheet has no outside: its first side stays.
        let sheet = [[0.1, 0.2, 0.3], [0.7, 0.2, 0.1], [0.3, 0.9, 0.5]];
        for faces in [[[0, 1, 2], [0, 2, 1]], [[0, 2, 1], [0, 1, 2]]] {
            let mut dropped = superfluous(&sheet, &faces);
            prefer_wound_sides(&sheet, &faces, &mut dropped);
            assert_eq!(dropped, [1]);
        }
    }

    #[test]
    fn a_vertex_with_very_many_faces_is_no_trouble() {
        let fan: Vec<_> = (1..100_000).map(|i| [i, 0, i + 1]).chain([[8, 0, 7], [3, 4, 0]]).collect();
        assert_eq!(repeated_faces(&fan, 100_001), [99_999, 100_000]);
    }
}
