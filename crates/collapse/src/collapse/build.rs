//! Rings from faces: count the faces of each vertex, write them one after the other, chain each vertex' faces.
//!
//! A vertex whose faces form no single chain is no disk; [`build_rings`] reports all of those, and `cut` gives each of
//! their chains a vertex of its own.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use crate::collapse::rings::{NONE, PADDING, Rings, Vertex, state};
use crate::collapse::team::{STRETCH, Team, split};

/// A face seen from one of its vertices: the vertices after and before that one.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Wedge {
    next: u32,
    previous: u32,
}

/// The faces of a vertex, in order.
#[derive(Clone, Copy, PartialEq, Debug)]
enum FanShape {
    Closed,
    Open,
    NoDisk,
}

/// Vertices above which a row of wedges is chained by a sorted list.
const LONG: usize = 48;

/// Rings, or the vertices that are no disk, in rising order, with the vertices given back.
pub(crate) enum Built {
    Rings(Rings),
    NoDisks(Vec<u32>, Vec<Vertex>),
}

/// Returns whether a face has three different vertices; others are left out.
pub(crate) fn is_face(face: &[u32; 3]) -> bool {
    face[0] != face[1] && face[1] != face[2] && face[2] != face[0]
}

/// Builds the rings of faces whose vertex `v` is number `ranks[v]` among `vertices`.
pub(crate) fn build_rings(vertices: Vec<Vertex>, faces: &[[u32; 3]], ranks: &[u32], team: Team) -> Built {
    let (mut wedges, ends) = gather_wedges(vertices.len(), faces, ranks, team);
    let row = |v: usize| if v == 0 { 0 } else { ends[v - 1] as usize }..ends[v] as usize;
    let pieces = pieces_of(vertices.len());
    let mut states = vec![0u8; vertices.len()];
    let mut lengths = vec![0usize; pieces.len()];
    let mut no_disks = vec![Vec::new(); pieces.len()];
    // Chain each row; a closed fan of n faces has n neighbours, an open one n + 1.
    let row_lengths = pieces.iter().map(|piece| row(piece.end - 1).end - row(piece.start).start);
    let work: Vec<_> = split(&mut wedges, row_lengths)
        .into_iter()
        .zip(states.chunks_mut(STRETCH))
        .zip(lengths.iter_mut().zip(&mut no_disks))
        .zip(&pieces)
        .collect();
    team.run(work, |(((wedges, states), (length, no_disks)), piece)| {
        let first = row(piece.start).start;
        for v in piece.clone() {
            let fan = &mut wedges[row(v).start - first..row(v).end - first];
            let state = &mut states[v - piece.start];
            *length += fan.len();
            match chain(fan) {
                _ if fan.is_empty() => *state = state::GONE,
                // Two faces back to back have no neighbourhood to merge in.
                FanShape::Closed if fan.len() < 3 => *state = state::LOCKED,
                FanShape::Closed => {}
                FanShape::Open => {
                    *state = state::BOUNDARY;
                    *length += 1;
                }
                FanShape::NoDisk => no_disks.push(v as u32),
            }
        }
    });
    let no_disks = no_disks.concat();
    if !no_disks.is_empty() {
        return Built::NoDisks(no_disks, vertices);
    }
    let wedges = wedges.as_slice();
    let mut rings = Rings { vertices, states, n_faces: wedges.len() / 3, ..Rings::default() };
    write_rings(&mut rings, &lengths, |v| &wedges[row(v)], team);
    Built::Rings(rings)
}

fn pieces_of(n_vertices: usize) -> Vec<Range<usize>> {
    (0..n_vertices).step_by(STRETCH).map(|first| first..(first + STRETCH).min(n_vertices)).collect()
}

// The wedges of all vertices, vertex by vertex, and where each vertex' wedges end.
fn gather_wedges(n_vertices: usize, faces: &[[u32; 3]], ranks: &[u32], team: Team) -> (Vec<Wedge>, Vec<u32>) {
    // With several threads wedges of a vertex come in any order; `chain` starts at the lowest in every case.
    let is_shared = team.n_threads > 1;
    let increment = |count: &AtomicU32| {
        if is_shared {
            return count.fetch_add(1, Relaxed);
        }
        let before = count.load(Relaxed);
        count.store(before + 1, Relaxed);
        before
    };
    let mut places: Vec<AtomicU32> = (0..=n_vertices).map(|_| AtomicU32::new(0)).collect();
    team.run(faces.chunks(STRETCH).collect(), |faces| {
        for face in faces.iter().filter(|face| is_face(face)) {
            for &v in face {
                increment(&places[ranks[v as usize] as usize + 1]);
            }
        }
    });
    let mut sum = 0;
    for place in &mut places {
        let place = place.get_mut();
        sum += *place;
        *place = sum;
    }
    let wedges: Vec<AtomicU64> = (0..sum).map(|_| AtomicU64::new(0)).collect();
    team.run(faces.chunks(STRETCH).collect(), |faces| {
        for face in faces.iter().filter(|face| is_face(face)) {
            let [a, b, c] = [ranks[face[0] as usize], ranks[face[1] as usize], ranks[face[2] as usize]];
            for (v, next, previous) in [(a, b, c), (b, c, a), (c, a, b)] {
                let wedge = u64::from(previous) << 32 | u64::from(next);
                wedges[increment(&places[v as usize]) as usize].store(wedge, Relaxed);
            }
        }
    });
    let unpack = |wedge: AtomicU64| {
        let wedge = wedge.into_inner();
        Wedge { next: wedge as u32, previous: (wedge >> 32) as u32 }
    };
    // Places are ends now.
    (wedges.into_iter().map(unpack).collect(), places.into_iter().map(AtomicU32::into_inner).collect())
}

// Puts the wedges of a vertex in cyclic order: a closed fan from its lowest neighbour on, an open one from its boundary.
#[inline(never)]
fn chain(wedges: &mut [Wedge]) -> FanShape {
    if wedges.len() > LONG {
        return chain_long(wedges);
    }
    let n = wedges.len();
    let (mut seen, mut lowest) = (0u64, 0);
    for i in 0..n {
        seen |= 1 << (wedges[i].next & 63);
        if wedges[i].next < wedges[lowest].next {
            lowest = i;
        }
    }
    // Two wedges with one first neighbour; 64 classes tell for most vertices that there are none.
    if seen.count_ones() as usize != n && (1..n).any(|i| wedges[..i].iter().any(|w| w.next == wedges[i].next)) {
        return FanShape::NoDisk;
    }
    if n > 0 {
        wedges.swap(0, lowest);
    }
    let mut done = 1;
    while done < n {
        let Some(found) = (done..n).find(|&i| wedges[i].next == wedges[done - 1].previous) else { break };
        wedges.swap(done, found);
        done += 1;
    }
    if n == 0 || done == n && wedges[n - 1].previous == wedges[0].next {
        return FanShape::Closed;
    }
    // The chain ended: the other wedges have to come before it.
    while done < n {
        let Some(found) = (done..n).find(|&i| wedges[i].previous == wedges[0].next) else { return FanShape::NoDisk };
        wedges.swap(done, found);
        wedges[..=done].rotate_right(1);
        done += 1;
    }
    let last = wedges[n - 1].previous;
    if wedges.iter().any(|w| w.next == last) { FanShape::NoDisk } else { FanShape::Open }
}

// `chain` for vertices of any degree: the successor of a wedge is found by bisection.
fn chain_long(wedges: &mut [Wedge]) -> FanShape {
    let mut by_next = wedges.to_vec();
    by_next.sort_unstable_by_key(|w| w.next);
    let mut ends: Vec<u32> = wedges.iter().map(|w| w.previous).collect();
    ends.sort_unstable();
    let has_twice = by_next.windows(2).any(|pair| pair[0].next == pair[1].next);
    if has_twice || ends.windows(2).any(|pair| pair[0] == pair[1]) {
        return FanShape::NoDisk;
    }
    let is_first = |w: &&Wedge| ends.binary_search(&w.next).is_err();
    let first = by_next.iter().find(is_first);
    let mut wedge = *first.unwrap_or(&by_next[0]);
    for done in 0..wedges.len() {
        wedges[done] = wedge;
        match by_next.binary_search_by_key(&wedge.previous, |w| w.next) {
            // A closed fan is back at its start only after all wedges.
            Ok(found) if done + 1 < wedges.len() && by_next[found] != wedges[0] => wedge = by_next[found],
            _ if done + 1 < wedges.len() => return FanShape::NoDisk,
            _ => {}
        }
    }
    if first.is_some() { FanShape::Open } else { FanShape::Closed }
}

// Writes the rings of chained fans; `lengths` are those of the pieces' rings together.
fn write_rings<'a>(rings: &mut Rings, lengths: &[usize], fan: impl Fn(usize) -> &'a [Wedge] + Sync, team: Team) {
    let n = rings.vertices.len();
    let length: usize = lengths.iter().sum();
    rings.neighbors = vec![0; length + PADDING];
    rings.starts = vec![length as u32; n + 1];
    rings.degrees = vec![0; n];
    rings.refused = vec![NONE; n];
    rings.errors = vec![0.0; n];
    let mut sum = 0;
    let firsts = lengths.iter().map(|length| {
        sum += length;
        sum - length
    });
    let states = &rings.states;
    let work: Vec<_> = split(&mut rings.neighbors, lengths.iter().copied())
        .into_iter()
        .zip(rings.starts[..n].chunks_mut(STRETCH).zip(rings.degrees.chunks_mut(STRETCH)))
        .zip(pieces_of(n).into_iter().zip(firsts))
        .collect();
    team.run(work, |((neighbors, (starts, degrees)), (piece, first))| {
        let mut k = 0;
        for v in piece.clone() {
            let wedges = fan(v);
            starts[v - piece.start] = (first + k) as u32;
            for wedge in wedges {
                neighbors[k] = wedge.next;
                k += 1;
            }
            if states[v] & state::BOUNDARY != 0 {
                neighbors[k] = wedges[wedges.len() - 1].previous;
                k += 1;
            }
            degrees[v - piece.start] = (first + k) as u32 - starts[v - piece.start];
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wedges_of(ring: &[u32], is_closed: bool) -> Vec<Wedge> {
        let n = if is_closed { ring.len() } else { ring.len() - 1 };
        (0..n).map(|i| Wedge { next: ring[i], previous: ring[(i + 1) % ring.len()] }).collect()
    }

    fn shuffle(wedges: &mut [Wedge]) {
        for i in 0..wedges.len() {
            wedges.swap(i, (i * 7 + 3) % wedges.len());
        }
    }

    #[test]
    fn short_and_long_fans_are_chained_alike() {
        for n in [3, 7, 40, 60, 1000] {
            let ring: Vec<u32> = (0..n).map(|i| (i * 37 + 11) % 1009).collect();
            for is_closed in [true, false] {
                let mut wedges = wedges_of(&ring, is_closed);
                shuffle(&mut wedges);
                let mut by_list = wedges.clone();
                let fan = if is_closed { FanShape::Closed } else { FanShape::Open };
                assert_eq!((chain(&mut wedges), chain_long(&mut by_list)), (fan, fan));
                assert_eq!(wedges, by_list);
                assert!(wedges.windows(2).all(|pair| pair[0].previous == pair[1].next));
            }
        }
    }

    #[test]
    fn two_fans_or_a_neighbour_met_twice_are_no_disk() {
        let two_open = [wedges_of(&[1, 2, 3], false), wedges_of(&[4, 5], false)].concat();
        let two_closed = [wedges_of(&[1, 2, 3], true), wedges_of(&[4, 5, 6], true)].concat();
        let three_at_an_edge =
            [wedges_of(&[1, 2], false), wedges_of(&[3, 2], false), wedges_of(&[2, 4], false)].concat();
        for wedges in [two_open, two_closed, three_at_an_edge] {
            assert_eq!(chain(&mut wedges.clone()), FanShape::NoDisk);
            assert_eq!(chain_long(&mut wedges.clone()), FanShape::NoDisk);
        }
    }

    #[test]
    fn a_tetrahedron_has_four_rings() {
        let vertices = (0..4).map(|i| Vertex::new([i as f32; 3], i)).collect();
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        let Built::Rings(rings) = build_rings(vertices, &faces, &[0, 1, 2, 3], Team::alone()) else { panic!() };
        rings.sanity_check();
        assert_eq!(rings.ring(0), [1, 2, 3]);
        assert_eq!(rings.n_faces, 4);
    }
}
