//! The ordered neighbours of every vertex, as a collapse changes them, and what it costs to merge with each: lists in blocks
//! of eight, so that most of what is asked of them takes one pass over eight numbers.

/// Neighbours in a block: the prices fill one register of 256 bits, prices and neighbours one cache line.
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

    /// That of a vertex with so many neighbours, which are not listed.
    pub fn unlisted(len: u32) -> Self {
        Self { block: NONE, len }
    }

    /// Whether the neighbours are not listed.
    #[inline(always)]
    pub fn is_unlisted(self) -> bool {
        self.block == NONE
    }

    /// The same list after others of so many blocks.
    pub fn after(self, n_blocks: u32) -> Self {
        if self.is_unlisted() { self } else { Self { block: self.block + n_blocks, ..self } }
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
}

/// Eight neighbours and what it costs to merge with each: infinite while that is not known and where they have to stay two. One
/// cache line.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Block {
    neighbors: [u32; WIDTH],
    prices: [f32; WIDTH],
}

impl Block {
    const EMPTY: Self = Self { neighbors: [NONE; WIDTH], prices: [f32::INFINITY; WIDTH] };
}

/// The lists. Behind the last neighbour of one stands no vertex, at an infinite price.
#[derive(Clone, Default)]
pub(super) struct Links {
    blocks: Vec<Block>,
    joined: Vec<u32>,
}

impl Links {
    /// No lists yet, with room for those of so many vertices.
    pub fn with_capacity(n_vertices: usize) -> Self {
        Self { blocks: Vec::with_capacity(n_vertices + n_vertices / WIDTH), joined: Vec::new() }
    }

    /// Lists the neighbours of one more vertex.
    pub fn push(&mut self, ring: impl ExactSizeIterator<Item = u32>) -> Span {
        let span = self.more(ring.len());
        let places = self.blocks[span.blocks()].iter_mut().flat_map(|block| &mut block.neighbors);
        places.zip(ring).for_each(|(place, w)| *place = w);
        span
    }

    /// Takes a list over from others, with other numbers for the neighbours and the prices that it has there.
    pub fn push_renumbered(&mut self, others: &Self, list: Span, number: impl Fn(u32) -> u32) -> Span {
        if list.is_unlisted() {
            return list;
        }
        let span = self.more(list.len());
        for (block, old) in self.blocks[span.blocks()].iter_mut().zip(&others.blocks[list.blocks()]) {
            let neighbors = old.neighbors.map(|w| if w == NONE { NONE } else { number(w) });
            *block = Block { neighbors, prices: old.prices };
        }
        span
    }

    fn more(&mut self, len: usize) -> Span {
        let span = Span { block: self.blocks.len() as u32, len: len as u32 };
        self.blocks.resize(span.blocks().end, Block::EMPTY);
        span
    }

    /// Number of blocks.
    pub fn n_blocks(&self) -> u32 {
        self.blocks.len() as u32
    }

    /// Takes other lists over behind its own.
    pub fn append(&mut self, other: Self) {
        self.blocks.extend(other.blocks);
    }

    /// The neighbours in order.
    #[inline(always)]
    pub fn of(&self, span: Span) -> impl ExactSizeIterator<Item = u32> + Clone {
        (0..span.len()).map(move |i| self.at(span, i))
    }

    /// The neighbours in order from behind the one in place `i` around to before it.
    #[inline(always)]
    pub fn beyond(&self, span: Span, i: usize) -> impl Iterator<Item = u32> {
        (i + 1..span.len()).chain(0..i).map(move |i| self.at(span, i))
    }

    /// The neighbour in place `i`.
    #[inline(always)]
    pub fn at(&self, span: Span, i: usize) -> u32 {
        self.blocks[span.blocks().start + i / WIDTH].neighbors[i % WIDTH]
    }

    /// Eight neighbours of a list.
    #[inline(always)]
    pub fn block(&self, block: usize) -> &[u32; WIDTH] {
        &self.blocks[block].neighbors
    }

    /// What it costs to merge with these eight.
    #[inline(always)]
    pub fn prices(&self, block: usize) -> &[f32; WIDTH] {
        &self.blocks[block].prices
    }

    /// The same, to be written.
    #[inline(always)]
    pub fn prices_mut(&mut self, block: usize) -> &mut [f32; WIDTH] {
        &mut self.blocks[block].prices
    }

    /// The neighbour that it costs least to merge with, and what that costs.
    #[inline(always)]
    pub fn cheapest(&self, span: Span) -> (f32, u32) {
        let mut least = (f32::INFINITY, NONE);
        for Block { neighbors, prices } in &self.blocks[span.blocks()] {
            for i in 0..WIDTH {
                least = if prices[i] < least.0 { (prices[i], neighbors[i]) } else { least };
            }
        }
        least
    }

    /// Where a neighbour stands in its list.
    #[inline(always)]
    pub fn position(&self, span: Span, neighbor: u32) -> Option<usize> {
        self.blocks[span.blocks()].iter().enumerate().find_map(|(i, block)| {
            let places = places_of(&block.neighbors, neighbor);
            (places != 0).then_some(i * WIDTH + places.trailing_zeros() as usize)
        })
    }

    /// How many vertices both lists hold.
    #[inline(always)]
    pub fn n_shared(&self, of_u: Span, of_v: Span) -> usize {
        let mut n_shared = 0;
        for one in &self.blocks[of_u.blocks()] {
            for other in &self.blocks[of_v.blocks()] {
                for w in other.neighbors {
                    n_shared += usize::from((places_of(&one.neighbors, w) != 0) & (w != NONE));
                }
            }
        }
        n_shared
    }

    /// Writes what it costs to merge with this neighbour.
    #[inline(always)]
    pub fn set_price(&mut self, span: Span, neighbor: u32, price: f32) {
        if let Some(at) = self.position(span, neighbor) {
            self.blocks[span.blocks().start + at / WIDTH].prices[at % WIDTH] = price;
        }
    }

    /// Writes one neighbour for another.
    #[inline(always)]
    pub fn replace(&mut self, span: Span, old: u32, new: u32) {
        for block in &mut self.blocks[span.blocks()] {
            block.neighbors.iter_mut().for_each(|w| *w = if *w == old { new } else { *w });
        }
    }

    /// Takes a neighbour out.
    #[inline(always)]
    pub fn remove(&mut self, span: &mut Span, old: u32) {
        let Some(at) = self.position(*span, old) else { return };
        let blocks = &mut self.blocks[span.blocks()];
        let (mut i, mut at) = (at / WIDTH, at % WIDTH);
        loop {
            let next = blocks.get(i + 1).map_or((NONE, f32::INFINITY), |next| (next.neighbors[0], next.prices[0]));
            let Some(Block { neighbors, prices }) = blocks.get_mut(i) else { break };
            neighbors.copy_within(at + 1.., at);
            prices.copy_within(at + 1.., at);
            (neighbors[WIDTH - 1], prices[WIDTH - 1]) = next;
            (i, at) = (i + 1, 0);
        }
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
        let at = self.position(span, start).unwrap_or(0);
        joined.extend(self.beyond(span, at));
    }

    /// Writes a list over one of two old ones, or behind all others where it is too long for them.
    #[inline(always)]
    fn write(&mut self, list: &[u32], old: [Span; 2]) -> Span {
        let n_blocks = list.len().div_ceil(WIDTH);
        let span = match old.into_iter().find(|span| span.blocks().len() >= n_blocks) {
            Some(span) => Span { len: list.len() as u32, ..span },
            None => self.more(list.len()),
        };
        for (block, part) in self.blocks[span.blocks()].iter_mut().zip(list.chunks(WIDTH)) {
            *block = Block::EMPTY;
            for (place, &w) in block.neighbors.iter_mut().zip(part) {
                *place = w;
            }
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
        assert!((0..8).all(|v| links.of(spans[v]).eq(ring(v))));
        assert_eq!(links.n_shared(spans[0], spans[1]), 2);
        let joined = links.join([0, 1], [spans[0], spans[1]]);
        let list: Vec<u32> = links.of(joined).collect();
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
        let n_blocks = links.blocks.len();
        let same = links.write(&[9; 8], [spans[0], spans[1]]);
        assert_eq!((same.block, same.len(), links.blocks.len()), (spans[0].block, 8, n_blocks));
        let moved = links.write(&[7; 20], [same, spans[1]]);
        assert!(links.of(moved).eq([7; 20]) && links.of(same).eq([9; 8]));
        assert_eq!(links.blocks.len(), n_blocks + 3);
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
        assert_eq!((span.len(), links.position(span, 20)), (10, Some(9)));
        assert_eq!((links.cheapest(span), links.position(span, 15)), ((0.5, 99), None));
        assert_eq!(
            links.prices(span.blocks().start + 1)[1..],
            [4.5, f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY]
        );
    }
}
