//! Ordered neighbours of every vertex of a manifold.
//!
//! Every boundary loop gets a ghost vertex, joined to all its vertices, so that each ring is a cycle.

use std::ops::Range;

use rustc_hash::FxHashMap;

use super::pulse::Pulse;
use super::thread_ranges::{corner_rows, split_rows, thread_ranges};
use crate::linalg::Rows;
use crate::parallel;

/// Largest length of a ring that is ordered without a hash map.
const LONG_RING: usize = 64;

/// The neighbours of every vertex in cyclic order.
///
/// Index `n_vertices + loop` is the ghost vertex of a boundary loop, last in a ring.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OneRings {
    offsets: Vec<u32>,
    neighbors: Vec<u32>,
    n_ghosts: usize,
    oriented: bool,
}

/// The error of vertices whose faces form more than one fan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotManifold {
    /// Vertex indices, ascending.
    pub vertices: Vec<u32>,
}

#[derive(Debug)]
pub(super) struct MeetingSheets {
    pub vertices: Vec<u32>,
    /// Vertices around which windings disagree, ascending.
    pub opposed: Vec<u32>,
}

impl std::fmt::Display for NotManifold {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the faces of {} vertices form more than one fan: split these vertices first", self.vertices.len())
    }
}

impl std::error::Error for NotManifold {}

impl OneRings {
    /// Orders the neighbours of all vertices of `faces` (n_faces x 3).
    ///
    /// # Errors
    /// [`NotManifold`] lists every vertex whose faces do not form a single fan.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::mesh::OneRings;
    /// let rings = OneRings::new(4, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    /// assert_eq!(rings.ring(0), [1, 2, 3, 4]); // open: the last is the ghost vertex of the only boundary loop
    /// assert_eq!(rings.n_ghosts(), 1);
    /// ```
    pub fn new(n_vertices: usize, faces: &[[u32; 3]]) -> Result<Self, NotManifold> {
        Self::new_with_pulse(Pulse::NONE, n_vertices, faces)
            .map_err(|meeting| NotManifold { vertices: meeting.vertices })
    }

    pub(super) fn new_with_pulse(pulse: Pulse, n_vertices: usize, faces: &[[u32; 3]]) -> Result<Self, MeetingSheets> {
        let Rows { starts, items: mut opposite_edges } = corner_rows(pulse, n_vertices, faces, |_, [_, b, c]| [b, c]);
        let shares = thread_ranges(n_vertices);
        let fans = split_rows(&shares, &mut opposite_edges, |v| starts[v + 1] as usize);
        let rows = |(share, fans)| RingRows::new(pulse, share, &starts, fans);
        let shares = parallel::each(shares.into_iter().zip(fans), rows);
        let and = |rows: RingRows, after| {
            pulse.beat(0);
            rows.append(after)
        };
        let rows = shares.into_iter().reduce(and).unwrap_or_default();
        if !rows.bad.is_empty() {
            return Err(MeetingSheets { vertices: rows.bad, opposed: rows.opposed });
        }
        let oriented = rows.opposed.is_empty();
        let mut rings = Self { offsets: rows.offsets, neighbors: rows.neighbors, n_ghosts: 0, oriented };
        rings.offsets.push(rings.neighbors.len() as u32);
        rings.number_boundary_loops(&rows.open);
        Ok(rings)
    }

    /// Returns the neighbours of a vertex in cyclic order.
    pub fn ring(&self, vertex: u32) -> &[u32] {
        &self.neighbors[self.offsets[vertex as usize] as usize..self.offsets[vertex as usize + 1] as usize]
    }

    /// Returns the number of vertices, without ghost vertices.
    pub fn n_vertices(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Returns the number of ghost vertices.
    pub fn n_ghosts(&self) -> usize {
        self.n_ghosts
    }

    /// Returns whether the winding is consistent.
    pub fn is_oriented(&self) -> bool {
        self.oriented
    }

    /// Returns the ghost vertex of a boundary vertex.
    pub fn ghost(&self, vertex: u32) -> Option<u32> {
        self.ring(vertex).last().copied().filter(|&last| last as usize >= self.n_vertices())
    }

    /// Returns a triangle per boundary edge: its two ends and the ghost vertex of its loop.
    pub fn ghost_faces(&self) -> Vec<[u32; 3]> {
        let boundary = (0..self.n_vertices() as u32).filter_map(|v| self.ghost(v).map(|ghost| (v, ghost)));
        if self.oriented {
            return boundary.map(|(v, ghost)| [self.ring(v)[0], v, ghost]).collect();
        }
        // Without consistent winding, every edge is found twice and kept once.
        let both = boundary.flat_map(|(v, ghost)| {
            let ring = self.ring(v);
            [ring[0], ring[ring.len() - 2]].map(|w| [w, v, ghost])
        });
        both.filter(|[w, v, _]| w > v).collect()
    }

    fn number_boundary_loops(&mut self, open: &[u32]) {
        let n_vertices = self.n_vertices();
        for &start in open {
            if self.neighbors[self.offsets[start as usize + 1] as usize - 1] != u32::MAX {
                continue;
            }
            let ghost = (n_vertices + self.n_ghosts) as u32;
            self.n_ghosts += 1;
            let mut pending = vec![start];
            while let Some(v) = pending.pop() {
                let end = self.offsets[v as usize + 1] as usize;
                if self.neighbors[end - 1] == u32::MAX {
                    self.neighbors[end - 1] = ghost;
                    pending.extend([self.ring(v)[0], self.neighbors[end - 2]]);
                }
            }
        }
    }
}

#[derive(Default)]
struct RingRows {
    offsets: Vec<u32>,
    neighbors: Vec<u32>,
    open: Vec<u32>,
    bad: Vec<u32>,
    opposed: Vec<u32>,
}

impl RingRows {
    fn new(pulse: Pulse, share: Range<usize>, starts: &[u32], mut fans: &mut [[u32; 2]]) -> Self {
        let mut rows = Self { offsets: Vec::with_capacity(share.len() + 1), ..Self::default() };
        rows.neighbors.reserve(fans.len());
        for vertices in pulse.ranges(share) {
            for v in vertices {
                let (fan, rest) = std::mem::take(&mut fans).split_at_mut((starts[v + 1] - starts[v]) as usize);
                rows.push(v as u32, fan);
                fans = rest;
            }
        }
        rows
    }

    fn append(mut self, after: Self) -> Self {
        let n_before = self.neighbors.len() as u32;
        self.offsets.extend(after.offsets.iter().map(|begin| n_before + begin));
        self.neighbors.extend(after.neighbors);
        self.open.extend(after.open);
        self.bad.extend(after.bad);
        self.opposed.extend(after.opposed);
        self
    }

    fn push(&mut self, v: u32, fan: &mut [[u32; 2]]) {
        self.offsets.push(self.neighbors.len() as u32);
        if self.extend_closed(fan) {
            return;
        }
        let mut oriented = true;
        let closed = order_fan(fan, &mut oriented);
        if !oriented {
            self.opposed.push(v);
        }
        match closed {
            Some(true) => self.neighbors.extend(fan.iter().map(|edge| edge[0])),
            Some(false) => {
                self.open.push(v);
                self.neighbors.extend(fan.iter().map(|edge| edge[0]));
                self.neighbors.extend([fan[fan.len() - 1][1], u32::MAX]);
            }
            None => self.bad.push(v),
        }
    }

    fn extend_closed(&mut self, fan: &[[u32; 2]]) -> bool {
        match fan.len() {
            3 => self.extend_cycle::<3>(fan),
            4 => self.extend_cycle::<4>(fan),
            5 => self.extend_cycle::<5>(fan),
            6 => self.extend_cycle::<6>(fan),
            7 => self.extend_cycle::<7>(fan),
            8 => self.extend_cycle::<8>(fan),
            _ => false,
        }
    }

    fn extend_cycle<const N: usize>(&mut self, fan: &[[u32; 2]]) -> bool {
        let Some(ring) = fan.first_chunk::<N>().and_then(cycle) else { return false };
        self.neighbors.extend(ring);
        true
    }
}

#[inline(always)]
fn cycle<const N: usize>(edges: &[[u32; 2]; N]) -> Option<[u32; N]> {
    let [first, mut tail] = edges[0];
    let mut ring = [first; N];
    let mut is_cycle = true;
    for here in &mut ring[1..] {
        *here = tail;
        is_cycle &= tail != first;
        // If no edge continues, `next` stays u32::MAX, which is no vertex.
        tail = edges[1..].iter().fold(u32::MAX, |next, &[a, b]| if a == *here { b } else { next });
    }
    is_cycle &= tail == first;
    is_cycle.then_some(ring)
}

/// Orders the opposite edges of one vertex head to tail; returns whether the fan is closed, `None` for several fans.
///
/// Clears `oriented` if an edge was reversed.
fn order_fan(fan: &mut [[u32; 2]], oriented: &mut bool) -> Option<bool> {
    if fan.is_empty() {
        return Some(true);
    }
    let n_ordered = grow_fan(fan, 1, oriented)?;
    if n_ordered == fan.len() {
        let closed = fan[0][0] == fan[n_ordered - 1][1];
        return if closed && fan.len() < 3 { None } else { Some(closed) };
    }
    reverse_fan(&mut fan[..n_ordered]);
    fan[n_ordered..].iter_mut().for_each(|pair| pair.reverse());
    let complete = grow_fan(fan, n_ordered, oriented)? == fan.len();
    reverse_fan(fan);
    complete.then_some(false)
}

/// Returns whether faces form one fan around a vertex.
pub(super) fn is_one_fan(fan: &mut [[u32; 2]]) -> bool {
    order_fan(fan, &mut true).is_some()
}

fn reverse_fan(fan: &mut [[u32; 2]]) {
    fan.reverse();
    fan.iter_mut().for_each(|pair| pair.reverse());
}

/// Extends the ordered first `n_ordered` edges of `fan`; returns their number, `None` if it branches.
fn grow_fan(fan: &mut [[u32; 2]], n_ordered: usize, oriented: &mut bool) -> Option<usize> {
    if fan.len() > LONG_RING {
        return grow_long_fan(fan, n_ordered, oriented);
    }
    for end in n_ordered..fan.len() {
        let tail = fan[end - 1][1];
        if tail == fan[0][0] {
            return None;
        }
        let mut next = None;
        for (i, pair) in fan.iter().enumerate().skip(end) {
            if pair[0] == tail || pair[1] == tail {
                if next.is_some() {
                    return None;
                }
                next = Some(i);
            }
        }
        let Some(next) = next else { return Some(end) };
        fan.swap(end, next);
        if fan[end][0] != tail {
            fan[end].reverse();
            *oriented = false;
        }
    }
    Some(fan.len())
}

fn grow_long_fan(fan: &mut [[u32; 2]], n_ordered: usize, oriented: &mut bool) -> Option<usize> {
    let mut places: FxHashMap<u32, [usize; 2]> = FxHashMap::default();
    for (i, pair) in fan.iter().enumerate().skip(n_ordered) {
        for v in pair {
            let slots = places.entry(*v).or_insert([usize::MAX; 2]);
            let free = slots.iter().position(|&slot| slot == usize::MAX)?;
            slots[free] = i;
        }
    }
    let rest = fan.to_vec();
    let mut used = vec![false; fan.len()];
    for end in n_ordered..fan.len() {
        let tail = fan[end - 1][1];
        if tail == fan[0][0] {
            return None;
        }
        let mut open = places.get(&tail).into_iter().flatten().filter(|&&i| i != usize::MAX && !used[i]);
        let next = open.next().copied();
        if open.next().is_some() {
            return None;
        }
        let Some(next) = next else {
            let unused = (n_ordered..rest.len()).filter(|&i| !used[i]);
            let left: Vec<_> = unused.map(|i| rest[i]).collect();
            fan[end..].copy_from_slice(&left);
            return Some(end);
        };
        used[next] = true;
        fan[end] = rest[next];
        if fan[end][0] != tail {
            fan[end].reverse();
            *oriented = false;
        }
    }
    Some(fan.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn closed_rings_are_cycles_of_faces() {
        let rings = OneRings::new(4, &TETRAHEDRON).unwrap();
        assert!(rings.is_oriented());
        assert_eq!(rings.n_ghosts(), 0);
        for v in 0..4 {
            let ring = rings.ring(v);
            assert_eq!(ring.len(), 3);
            for i in 0..3 {
                let (a, b) = (ring[i], ring[(i + 1) % 3]);
                assert!(
                    TETRAHEDRON.iter().any(|f| (0..3).any(|k| [f[k], f[(k + 1) % 3], f[(k + 2) % 3]] == [v, a, b]))
                );
            }
        }
    }

    #[test]
    fn every_boundary_loop_has_its_ghost() {
        // An annulus of 4 + 4 vertices.
        let faces: Vec<[u32; 3]> =
            (0..4).flat_map(|i| [[i, (i + 1) % 4, 4 + i], [(i + 1) % 4, 4 + (i + 1) % 4, 4 + i]]).collect();
        let rings = OneRings::new(8, &faces).unwrap();
        assert_eq!(rings.n_ghosts(), 2);
        assert_ne!(rings.ghost(0), rings.ghost(4));
        let mut closed = faces;
        closed.extend(rings.ghost_faces());
        let closed = OneRings::new(10, &closed).unwrap();
        assert!(closed.is_oriented());
        assert_eq!(closed.n_ghosts(), 0);
    }

    #[test]
    fn the_boundary_of_a_surface_with_one_side_gets_each_ghost_face_once() {
        let strip = crate::mesh::shapes::moebius_strip(16, 3);
        let n_vertices = strip.positions().len();
        let rings = OneRings::new(n_vertices, strip.faces()).unwrap();
        assert!(!rings.is_oriented());
        let closed = [strip.faces(), &rings.ghost_faces()].concat();
        assert_eq!(OneRings::new(n_vertices + 1, &closed).map(|closed| closed.n_ghosts()), Ok(0));
    }

    #[test]
    fn two_sheets_at_a_vertex_are_not_a_manifold() {
        let error = OneRings::new(5, &[[0, 1, 2], [0, 3, 4]]).unwrap_err();
        assert_eq!(error.vertices, [0]);
        let three_faces_on_an_edge = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
        assert_eq!(OneRings::new(5, &three_faces_on_an_edge).unwrap_err().vertices, [0, 1]);
    }

    #[test]
    fn a_face_and_its_opposite_are_no_surface() {
        assert!(OneRings::new(3, &[[0, 1, 2], [0, 2, 1]]).is_err());
    }

    #[test]
    fn inconsistent_winding_is_noticed_and_ordered_all_the_same() {
        let mut faces = TETRAHEDRON;
        faces[2].reverse();
        let rings = OneRings::new(4, &faces).unwrap();
        assert!(!rings.is_oriented());
        assert_eq!(rings.ring(0).len(), 3);
    }

    #[test]
    fn long_fans_are_ordered_like_short_ones() {
        for open in [false, true] {
            let n = 4 * LONG_RING as u32;
            let mut faces: Vec<[u32; 3]> = (0..n - u32::from(open)).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
            faces.swap(3, 100);
            faces[7].reverse();
            let rings = OneRings::new(n as usize + 1, &faces).unwrap();
            let ring = rings.ring(0);
            assert_eq!(ring.len(), n as usize + usize::from(open));
            assert!(!rings.is_oriented());
            let steps =
                ring[..n as usize].windows(2).filter(|w| w[0].abs_diff(w[1]) == 1 || w[0].abs_diff(w[1]) == n - 1);
            assert_eq!(steps.count(), n as usize - 1);
        }
    }

    #[test]
    fn the_hash_map_orders_any_fan_as_scanning_does() {
        // All choices of 4 edges between 5 vertices, shuffled.
        let edges: Vec<[u32; 2]> = (0..5).flat_map(|a| (a + 1..5).map(move |b| [a, b])).collect();
        for choice in 0..10_000usize {
            let picks = [choice % 10, choice / 10 % 10, choice / 100 % 10, choice / 1000];
            let fan = picks.map(|i| if (choice + i) % 3 == 0 { [edges[i][1], edges[i][0]] } else { edges[i] });
            let (mut scanned, mut hashed) = (fan, fan);
            let (mut oriented, mut oriented_hashed) = (true, true);
            let n = grow_fan(&mut scanned, 1, &mut oriented);
            let n_hashed = grow_long_fan(&mut hashed, 1, &mut oriented_hashed);
            // The scan may not see that a vertex has more than two edges.
            if let (Some(n), Some(n_hashed)) = (n, n_hashed) {
                assert_eq!((n, oriented, &scanned[..n]), (n_hashed, oriented_hashed, &hashed[..n]), "{fan:?}");
            }
            assert!(n.is_some() || n_hashed.is_none() || n_hashed.is_some_and(|n| n < 4), "{fan:?}");
        }
    }

    #[test]
    fn short_cycles_are_those_that_scanning_finds() {
        // All choices of 4 directed edges between 4 vertices.
        let edges: Vec<[u32; 2]> = (0..4).flat_map(|a| (0..4).map(move |b| [a, b])).filter(|[a, b]| a != b).collect();
        let mut n_cycles = 0;
        for choice in 0..12_usize.pow(4) {
            let fan = [1, 12, 144, 1728].map(|unit| edges[choice / unit % 12]);
            let (mut scanned, mut oriented) = (fan, true);
            let closed = order_fan(&mut scanned, &mut oriented) == Some(true) && oriented;
            assert_eq!(cycle(&fan), closed.then(|| scanned.map(|pair| pair[0])), "{fan:?}");
            n_cycles += usize::from(closed);
        }
        assert!(n_cycles > 100);
    }
}
