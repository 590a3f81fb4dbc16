//! The ordered neighbours of every vertex, as a collapse changes them, and what it costs to merge with each: lists in blocks
//! of eight, so that most of what is asked of them takes one pass over eight numbers.

/// Neighbours in a block.
pub(super) const WIDTH: usize = 8;
/// No vertex: what fills a block up.
const NONE: u32 = u32::MAX;

/// Where the neighbours of a vertex are listed.
#[derive(Clone, Copy, Default)]
pub(super) struct Span {
    block: u32,
    len: u32,
}

impl Span {
    /// Number of neighbours.
    #[inline(always)]
    pub fn len(self) -> usize {
        self.len as usize
    }

    /// That of an apex with so many neighbours, which are not listed.
    pub fn unlisted(len: u32) -> Self {
        Self { block: 0, len }
    }

    /// The same list after others of so many blocks.
    pub fn after(self, n_blocks: u32) -> Self {
        Self { block: self.block + n_blocks, ..self }
    }

    /// With a neighbour less.
    pub fn shorter(self) -> Self {
        Self { len: self.len.saturating_sub(1), ..self }
    }

    /// The blocks of the list; none for a list of none.
    #[inline(always)]
    pub fn blocks(self) -> std::ops::Range<usize> {
        self.block as usize..self.block as usize + self.len().div_ceil(WIDTH)
    }

    #[inline(always)]
    fn range(self) -> std::ops::Range<usize> {
        self.block as usize * WIDTH..self.block as usize * WIDTH + self.len()
    }
}

/// The lists. Behind the last neighbour of one stands no vertex, at an infinite price.
#[derive(Default)]
pub(super) struct Links {
    neighbors: Vec<[u32; WIDTH]>,
    /// What it costs to merge with each neighbour; infinite while that is not known and where they have to stay two.
    prices: Vec<[f32; WIDTH]>,
    joined: Vec<u32>,
}

impl Links {
    /// No lists yet, with room for those of so many vertices.
    pub fn with_capacity(n_vertices: usize) -> Self {
        let n_blocks = n_vertices + n_vertices / WIDTH;
        let (neighbors, prices) = (Vec::with_capacity(n_blocks), Vec::with_capacity(n_blocks));
        Self { neighbors, prices, joined: Vec::new() }
    }

    /// Lists the neighbours of one more vertex.
    pub fn push(&mut self, ring: impl ExactSizeIterator<Item = u32>) -> Span {
        let span = self.more(ring.len());
        self.neighbors.as_flattened_mut()[span.range()].iter_mut().zip(ring).for_each(|(place, w)| *place = w);
        span
    }

    fn more(&mut self, len: usize) -> Span {
        let span = Span { block: self.neighbors.len() as u32, len: len as u32 };
        self.neighbors.resize(span.blocks().end, [NONE; WIDTH]);
        self.prices.resize(span.blocks().end, [f32::INFINITY; WIDTH]);
        span
    }

    /// Takes other lists over behind its own; returns after how many blocks they stand.
    pub fn append(&mut self, other: Self) -> u32 {
        let n_blocks = self.neighbors.len() as u32;
        self.neighbors.extend(other.neighbors);
        self.prices.extend(other.prices);
        n_blocks
    }

    /// The neighbours in order.
    #[inline(always)]
    pub fn of(&self, span: Span) -> &[u32] {
        &self.neighbors.as_flattened()[span.range()]
    }

    /// Eight neighbours of a list.
    #[inline(always)]
    pub fn block(&self, block: usize) -> &[u32; WIDTH] {
        &self.neighbors[block]
    }

    /// What it costs to merge with these eight.
    #[inline(always)]
    pub fn prices(&self, block: usize) -> &[f32; WIDTH] {
        &self.prices[block]
    }

    /// The same, to be written.
    #[inline(always)]
    pub fn prices_mut(&mut self, block: usize) -> &mut [f32; WIDTH] {
        &mut self.prices[block]
    }

    /// The neighbour that it costs least to merge with, and what that costs.
    #[inline(always)]
    pub fn cheapest(&self, span: Span) -> (f32, u32) {
        let mut least = (f32::INFINITY, NONE);
        for block in span.blocks() {
            let (prices, neighbors) = (&self.prices[block], &self.neighbors[block]);
            for i in 0..WIDTH {
                least = if prices[i] < least.0 { (prices[i], neighbors[i]) } else { least };
            }
        }
        least
    }

    /// Where a neighbour stands in its list.
    #[inline(always)]
    pub fn position(&self, span: Span, neighbor: u32) -> Option<usize> {
        span.blocks().enumerate().find_map(|(i, block)| {
            let places = places_of(&self.neighbors[block], neighbor);
            (places != 0).then_some(i * WIDTH + places.trailing_zeros() as usize)
        })
    }

    /// How many vertices both lists hold.
    #[inline(always)]
    pub fn n_shared(&self, of_u: Span, of_v: Span) -> usize {
        let mut n_shared = 0;
        for one in self.neighbors[of_u.blocks()].iter() {
            for other in self.neighbors[of_v.blocks()].iter() {
                for &w in other {
                    n_shared += usize::from((places_of(one, w) != 0) & (w != NONE));
                }
            }
        }
        n_shared
    }

    /// Writes what it costs to merge with this neighbour.
    #[inline(always)]
    pub fn set_price(&mut self, span: Span, neighbor: u32, price: f32) {
        if let Some(at) = self.position(span, neighbor) {
            self.prices[span.blocks().start + at / WIDTH][at % WIDTH] = price;
        }
    }

    /// Writes one neighbour for another.
    #[inline(always)]
    pub fn replace(&mut self, span: Span, old: u32, new: u32) {
        for block in span.blocks() {
            self.neighbors[block].iter_mut().for_each(|w| *w = if *w == old { new } else { *w });
        }
    }

    /// Takes a neighbour out.
    #[inline(always)]
    pub fn remove(&mut self, span: &mut Span, old: u32) {
        let Some(at) = self.position(*span, old) else { return };
        let range = span.range();
        let neighbors = &mut self.neighbors.as_flattened_mut()[range.clone()];
        let prices = &mut self.prices.as_flattened_mut()[range];
        let last = neighbors.len() - 1;
        for i in at..last {
            (neighbors[i], prices[i]) = (neighbors[i + 1], prices[i + 1]);
        }
        (neighbors[last], prices[last]) = (NONE, f32::INFINITY);
        *span = span.shorter();
    }

    /// The neighbours of `u` when `v` is merged into it: those of `v` take its place. Their prices are not known.
    #[inline(always)]
    pub fn join(&mut self, [u, v]: [u32; 2], [of_u, of_v]: [Span; 2]) -> Span {
        let mut joined = std::mem::take(&mut self.joined);
        joined.clear();
        self.extend_after(&mut joined, of_u, v);
        let (first, last) = (joined.first().copied(), joined.last().copied());
        let begin = joined.len();
        self.extend_after(&mut joined, of_v, u);
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

    /// Appends a cyclic list from behind `start` to before it.
    #[inline(always)]
    fn extend_after(&self, joined: &mut Vec<u32>, span: Span, start: u32) {
        let ring = self.of(span);
        let at = self.position(span, start).unwrap_or(0);
        joined.extend(&ring[at + 1..]);
        joined.extend(&ring[..at]);
    }

    /// Writes a list over one of two old ones, or behind all others where it is too long for them.
    #[inline(always)]
    fn write(&mut self, list: &[u32], old: [Span; 2]) -> Span {
        let n_blocks = list.len().div_ceil(WIDTH);
        let span = match old.into_iter().find(|span| span.blocks().len() >= n_blocks) {
            Some(span) => Span { len: list.len() as u32, ..span },
            None => self.more(list.len()),
        };
        for (block, part) in span.blocks().zip(list.chunks(WIDTH)) {
            let mut whole = [NONE; WIDTH];
            for (place, &w) in whole.iter_mut().zip(part) {
                *place = w;
            }
            self.neighbors[block] = whole;
            self.prices[block] = [f32::INFINITY; WIDTH];
        }
        span
    }
}

/// Where a number stands among eight, a bit for each place.
#[inline(always)]
fn places_of(block: &[u32; WIDTH], number: u32) -> u8 {
    block.iter().enumerate().fold(0, |places, (i, &w)| places | u8::from(w == number) << i)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::OneRings;

    fn links(rings: &OneRings) -> (Links, Vec<Span>) {
        let mut links = Links::with_capacity(rings.n_vertices());
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
        assert_eq!(links.n_shared(spans[0], spans[1]), 2);
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
        let n_blocks = links.neighbors.len();
        let same = links.write(&[9; 8], [spans[0], spans[1]]);
        assert_eq!((same.block, links.of(same).len(), links.neighbors.len()), (spans[0].block, 8, n_blocks));
        let moved = links.write(&[7; 20], [same, spans[1]]);
        assert_eq!((links.of(moved), links.of(same)), ([7; 20].as_slice(), [9; 8].as_slice()));
        assert_eq!(links.neighbors.len(), n_blocks + 3);
    }

    #[test]
    fn prices_stay_with_their_neighbours() {
        let mut links = Links::default();
        let mut span = links.push(10..21);
        for w in 10..21 {
            links.set_price(span, w, (w as f32 - 15.5).abs());
        }
        assert_eq!(links.cheapest(span), (0.5, 15));
        links.remove(&mut span, 15);
        links.replace(span, 16, 99);
        assert_eq!((links.of(span).len(), links.position(span, 20)), (10, Some(9)));
        assert_eq!((links.cheapest(span), links.position(span, 15)), ((0.5, 99), None));
        assert_eq!(
            links.prices(span.blocks().start + 1)[1..],
            [4.5, f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY]
        );
    }
}
