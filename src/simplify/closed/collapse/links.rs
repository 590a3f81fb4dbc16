//! The ordered neighbours of every vertex, as a collapse changes them: lists in one array, longer ones moved to its end.

/// Free places behind a list that begins.
const ROOM: usize = 2;

/// Where the neighbours of a vertex are listed.
#[derive(Clone, Copy, Default)]
pub(super) struct Span {
    first: u32,
    len: u32,
}

impl Span {
    /// Number of neighbours.
    pub fn len(self) -> usize {
        self.len as usize
    }

    /// That of an apex with so many neighbours, which are not listed.
    pub fn unlisted(len: u32) -> Self {
        Self { first: 0, len }
    }

    /// The same list after others with so many places.
    pub fn after(self, n_places: u32) -> Self {
        Self { first: self.first + n_places, ..self }
    }

    /// With a neighbour less.
    pub fn shorter(self) -> Self {
        Self { len: self.len.saturating_sub(1), ..self }
    }

    fn range(self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.len) as usize
    }
}

/// The lists; before each stands how many places it has.
pub(super) struct Links {
    places: Vec<u32>,
    joined: Vec<u32>,
}

impl Links {
    /// No lists yet, with room for so many neighbours of so many vertices.
    pub fn with_capacity(n_neighbors: usize, n_vertices: usize) -> Self {
        Self { places: Vec::with_capacity(n_neighbors + n_vertices * (1 + ROOM)), joined: Vec::new() }
    }

    /// Lists the neighbours of one more vertex.
    pub fn push(&mut self, ring: impl Iterator<Item = u32>) -> Span {
        let before = self.places.len();
        self.places.push(0);
        self.places.extend(ring);
        let len = (self.places.len() - before - 1) as u32;
        self.places.extend([0; ROOM]);
        self.places[before] = len + ROOM as u32;
        Span { first: before as u32 + 1, len }
    }

    /// Takes other lists over behind its own; returns after how many places they stand.
    pub fn append(&mut self, other: Self) -> u32 {
        let n_places = self.places.len() as u32;
        self.places.extend(other.places);
        n_places
    }

    /// The neighbours in order.
    pub fn of(&self, span: Span) -> &[u32] {
        &self.places[span.range()]
    }

    /// So many neighbours from the one numbered `first`; behind the last one, others.
    #[inline(always)]
    pub fn some_of<const N: usize>(&self, span: Span, first: usize) -> [u32; N] {
        let list = &self.of(span)[first..];
        match list.first_chunk() {
            Some(whole) => *whole,
            None => std::array::from_fn(|i| list.get(i).or(list.first()).copied().unwrap_or_default()),
        }
    }

    /// Writes one neighbour for another.
    pub fn replace(&mut self, span: Span, old: u32, new: u32) {
        if let Some(place) = self.places[span.range()].iter_mut().find(|w| **w == old) {
            *place = new;
        }
    }

    /// Takes a neighbour out.
    pub fn remove(&mut self, span: &mut Span, old: u32) {
        let list = &mut self.places[span.range()];
        if let Some(at) = list.iter().position(|&w| w == old) {
            list.copy_within(at + 1.., at);
        }
        *span = span.shorter();
    }

    /// The neighbours of `u` when `v` is merged into it: those of `v` take its place.
    pub fn join(&mut self, [u, v]: [u32; 2], [of_u, of_v]: [Span; 2]) -> Span {
        let mut joined = std::mem::take(&mut self.joined);
        joined.clear();
        extend_after(&mut joined, self.of(of_u), v);
        let (first, last) = (joined.first().copied(), joined.last().copied());
        let begin = joined.len();
        extend_after(&mut joined, self.of(of_v), u);
        // Around both ends the neighbours run the same way, unless the surface has one side only.
        if joined.get(begin).copied() != last {
            joined[begin..].reverse();
        }
        debug_assert_eq!([joined.get(begin).copied(), joined.last().copied()], [last, first]);
        joined.pop();
        joined.remove(begin);
        let span = self.write(&joined, [of_u, of_v]);
        self.joined = joined;
        span
    }

    /// Writes a list over one of two old ones, or behind all others where it is too long for them.
    fn write(&mut self, list: &[u32], old: [Span; 2]) -> Span {
        let len = list.len() as u32;
        let room = |span: &Span| self.places[span.first as usize - 1];
        if let Some(span) = old.into_iter().find(|span| room(span) >= len) {
            self.places[span.first as usize..][..list.len()].copy_from_slice(list);
            return Span { len, ..span };
        }
        let room = len + len / 2;
        self.places.push(room);
        let first = self.places.len() as u32;
        self.places.extend_from_slice(list);
        self.places.resize((first + room) as usize, 0);
        Span { first, len }
    }
}

/// Appends a cyclic list from behind `start` to before it.
fn extend_after(joined: &mut Vec<u32>, ring: &[u32], start: u32) {
    let at = ring.iter().position(|&w| w == start).unwrap_or(0);
    joined.extend_from_slice(&ring[at + 1..]);
    joined.extend_from_slice(&ring[..at]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::OneRings;

    fn links(rings: &OneRings) -> (Links, Vec<Span>) {
        let mut links = Links::with_capacity(rings.n_entries(), rings.n_vertices());
        let spans = (0..rings.n_vertices() as u32).map(|v| links.push(rings.ring(v).iter().copied())).collect();
        (links, spans)
    }

    #[test]
    fn the_neighbours_of_both_ends_become_one_ring() {
        // Vertices 0 and 1 of a closed fan: 2 and 5 are opposite to their edge.
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1], [1, 5, 6], [1, 6, 7], [1, 7, 2]];
        let rings = OneRings::new(8, &faces).unwrap();
        let (mut links, spans) = links(&rings);
        let ring = |v: usize| rings.ring(v as u32).to_vec();
        assert!((0..8).all(|v| links.of(spans[v]) == ring(v)));
        let joined = links.join([0, 1], [spans[0], spans[1]]);
        let list = links.of(joined);
        let start = list.iter().position(|&w| w == 2).unwrap();
        let cycle: Vec<u32> = (0..6).map(|i| list[(start + i) % 6]).collect();
        assert_eq!((list.len(), cycle), (6, vec![2, 3, 4, 5, 6, 7]));
    }

    #[test]
    fn long_lists_move_and_short_ones_stay() {
        let wheel = |n: u32| (0..n).map(move |i| [0, 1 + i, 1 + (i + 1) % n]);
        let faces: Vec<[u32; 3]> = wheel(5).collect();
        let rings = OneRings::new(6, &faces).unwrap();
        let (mut links, spans) = links(&rings);
        let n_places = links.places.len();
        let same = links.write(&[9; 6], [spans[0], spans[1]]);
        assert_eq!((same.first, links.of(same).len(), links.places.len()), (spans[0].first, 6, n_places));
        let moved = links.write(&[7; 20], [same, spans[1]]);
        assert_eq!((links.of(moved), links.of(same)), ([7; 20].as_slice(), [9; 6].as_slice()));
        links.replace(moved, 7, 8);
        assert_eq!(links.of(moved)[0], 8);
    }
}
