//! The mesh after a pass: survivors get new numbers, and each ring is written from the old ones.

use std::ops::Range;

use crate::collapse::lanes::{EightIndices, EightLanes, Kernel, dispatch};
use crate::collapse::rings::{NONE, PADDING, Rings, Vertex, state};
use crate::collapse::team::{STRETCH, Team, split};

/// How many vertices and neighbours a piece keeps, and how many come before it.
#[derive(Clone, Copy, Default)]
struct Kept {
    vertices: usize,
    neighbors: usize,
    first_vertex: usize,
    first_neighbor: usize,
}

/// Returns the mesh after the merges of a pass, and each vertex' number in it; merged vertices have their survivor's.
///
/// `best` holds the other end of each merge. `room` gives its arrays to the new mesh.
pub(crate) fn rebuild(rings: &Rings, best: &[u64], room: Rings, n_faces: usize, team: Team) -> (Rings, Vec<u32>) {
    let n = rings.vertices.len();
    let mut numbers = vec![0u32; n];
    let mut kept = number_survivors(rings, &mut numbers, team);
    let (mut n_vertices, mut n_neighbors) = (0, 0);
    for kept in &mut kept {
        kept.first_vertex = n_vertices;
        kept.first_neighbor = n_neighbors;
        n_vertices += kept.vertices;
        n_neighbors += kept.neighbors;
    }
    team.run(numbers.chunks_mut(STRETCH).zip(&kept).collect(), |(numbers, kept)| {
        numbers.iter_mut().for_each(|number| *number += kept.first_vertex as u32);
    });
    number_merged(rings, &mut numbers);
    let mut new = make_room(room, n_vertices, n_neighbors);
    new.n_faces = n_faces;
    write_pieces(rings, best, &numbers, &kept, &mut new, team);
    (new, numbers)
}

// Numbers within each piece.
fn number_survivors(rings: &Rings, numbers: &mut [u32], team: Team) -> Vec<Kept> {
    let mut kept = vec![Kept::default(); numbers.len().div_ceil(STRETCH)];
    team.run(numbers.chunks_mut(STRETCH).zip(&mut kept).enumerate().collect(), |(i, (numbers, kept))| {
        let range = i * STRETCH..i * STRETCH + numbers.len();
        for ((number, state), degree) in numbers.iter_mut().zip(&rings.states[range.clone()]).zip(&rings.degrees[range])
        {
            let lives = usize::from(state & state::GONE == 0);
            *number = kept.vertices as u32;
            kept.vertices += lives;
            kept.neighbors += *degree as usize * lives;
        }
    });
    kept
}

// A merged vertex has the number of its survivor, which may be anywhere.
fn number_merged(rings: &Rings, numbers: &mut [u32]) {
    for (v, state) in rings.states.iter().enumerate() {
        if state & state::GONE != 0 {
            numbers[v] = numbers[rings.vertices[v].survivor as usize];
        }
    }
}

fn make_room(mut room: Rings, n_vertices: usize, n_neighbors: usize) -> Rings {
    // What is written below needs no clearing, but safe code has no memory without values.
    room.vertices.resize(n_vertices, Vertex::default());
    room.starts.resize(n_vertices + 1, 0);
    room.starts[n_vertices] = n_neighbors as u32;
    room.degrees.resize(n_vertices, 0);
    room.states.resize(n_vertices, 0);
    room.refused.resize(n_vertices, NONE);
    room.errors.resize(n_vertices, 0.0);
    room.neighbors.resize(n_neighbors + PADDING, 0);
    // Padding may be old entries of a longer array; it is loaded, but never followed out of range.
    room.neighbors[n_neighbors..].fill(0);
    room
}

/// The part of the new mesh that one piece of the old one becomes.
struct NewPiece<'a> {
    vertices: &'a mut [Vertex],
    starts: &'a mut [u32],
    degrees: &'a mut [u32],
    states: &'a mut [u8],
    refused: &'a mut [u32],
    errors: &'a mut [f32],
    neighbors: &'a mut [u32],
}

fn write_pieces(rings: &Rings, best: &[u64], numbers: &[u32], kept: &[Kept], new: &mut Rings, team: Team) {
    let lengths = || kept.iter().map(|kept| kept.vertices);
    let mut vertices = split(&mut new.vertices, lengths()).into_iter();
    let mut starts = split(&mut new.starts, lengths()).into_iter();
    let mut degrees = split(&mut new.degrees, lengths()).into_iter();
    let mut states = split(&mut new.states, lengths()).into_iter();
    let mut refused = split(&mut new.refused, lengths()).into_iter();
    let mut errors = split(&mut new.errors, lengths()).into_iter();
    let neighbors = split(&mut new.neighbors, kept.iter().map(|kept| kept.neighbors));
    let pieces = neighbors.into_iter().zip(kept).enumerate().map(|(i, (neighbors, kept))| {
        let piece = NewPiece {
            vertices: vertices.next().unwrap_or_default(),
            starts: starts.next().unwrap_or_default(),
            degrees: degrees.next().unwrap_or_default(),
            states: states.next().unwrap_or_default(),
            refused: refused.next().unwrap_or_default(),
            errors: errors.next().unwrap_or_default(),
            neighbors,
        };
        (i * STRETCH..((i + 1) * STRETCH).min(rings.vertices.len()), piece, kept)
    });
    team.run(pieces.collect(), |(range, mut piece, kept)| {
        write_vertices(rings, numbers, range.clone(), &mut piece, kept);
        dispatch(WriteRings { rings, best, numbers, range, out: piece.neighbors });
    });
}

fn write_vertices(rings: &Rings, numbers: &[u32], range: Range<usize>, piece: &mut NewPiece, kept: &Kept) {
    let mut start = kept.first_neighbor as u32;
    let mut new = 0;
    for v in range {
        let (state, degree) = (rings.states[v], rings.degrees[v]);
        if state & state::GONE != 0 {
            continue;
        }
        piece.vertices[new] = Vertex::new(rings.vertices[v].position, (kept.first_vertex + new) as u32);
        piece.starts[new] = start;
        start += degree;
        piece.degrees[new] = degree;
        piece.errors[new] = rings.errors[v];
        piece.refused[new] = NONE;
        let mut new_state = state & !state::MERGED;
        if state & state::REFUSED != 0 {
            // A changed ring is worth another try.
            if state & state::MERGED != 0 || degree as usize != rings.range(v).len() {
                new_state &= !(state::REFUSED | state::RESTS);
            } else {
                piece.refused[new] = numbers[rings.refused[v] as usize];
            }
        }
        piece.states[new] = new_state;
        new += 1;
    }
}

/// Writes the rings of the survivors of a range, in new numbers.
struct WriteRings<'a> {
    rings: &'a Rings,
    best: &'a [u64],
    numbers: &'a [u32],
    range: Range<usize>,
    out: &'a mut [u32],
}

impl Kernel for WriteRings<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: EightLanes>(self) {
        let WriteRings { rings, best, numbers, range, out } = self;
        let mut start = 0;
        for v in range {
            let state = rings.states[v];
            if state & state::GONE != 0 {
                continue;
            }
            let (old, length) = (rings.range(v), rings.degrees[v] as usize);
            let is_short = state & state::MERGED == 0 && old.len() <= 8;
            if let (true, Some(room)) = (is_short, out[start..].first_chunk_mut::<9>()) {
                let raw: &EightIndices = rings.neighbors[old.start..].first_chunk().expect("rings are padded");
                let new = L::load_numbers(numbers, &L::keep_first(raw, old.len(), v as u32));
                write_short(room, &new, old.len() == length);
            } else {
                let mate = if state & state::MERGED != 0 { best[v] as u32 } else { NONE };
                write_any(rings, numbers, v, mate, &mut out[start..start + length]);
            }
            start += length;
        }
    }
}

// A ring of at most eight; neighbours merged with each other are in a row, and come once. What is written behind the
// ring is overwritten by the next.
#[inline(always)]
fn write_short(room: &mut [u32; 9], new: &EightIndices, is_whole: bool) {
    if is_whole {
        room[..8].copy_from_slice(new);
        return;
    }
    room[0] = new[0];
    let mut n = 0;
    for l in 1..8 {
        n += usize::from(new[l] != new[l - 1]);
        room[n] = new[l];
    }
}

// Any ring; in place of the `mate`, which was merged into v, come the mate's other neighbours.
#[inline(always)]
fn write_any(rings: &Rings, numbers: &[u32], v: usize, mate: u32, out: &mut [u32]) {
    let (mut n, mut last) = (0, NONE);
    for &w in rings.ring(v) {
        if w != mate {
            write_once(out, &mut n, &mut last, numbers[w as usize]);
            continue;
        }
        let others = rings.ring(mate as usize);
        let at_v = others.iter().position(|&x| x as usize == v).unwrap_or(0);
        for &w in others[at_v + 1..].iter().chain(&others[..at_v]) {
            write_once(out, &mut n, &mut last, numbers[w as usize]);
        }
    }
}

// The first of a closed ring may come again at its end, where there is no room left.
#[inline(always)]
fn write_once(out: &mut [u32], n: &mut usize, last: &mut u32, number: u32) {
    if let Some(place) = out.get_mut(*n) {
        *place = number;
    }
    *n += usize::from(number != *last);
    *last = number;
}
