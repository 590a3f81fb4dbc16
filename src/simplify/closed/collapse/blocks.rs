//! The first part of a large collapse, in blocks: runs of vertices along a space-filling curve, each a complex of its own
//! that stays within the cache, all of them side by side.
//!
//! A vertex with a neighbour in another block is frozen, so that no block changes what another one sees. Each round has one
//! price for all blocks, and none goes beyond the limit. What is left, a few percent of the merges and the edges between
//! blocks, is for the collapse of the whole. Blocks depend on the mesh alone: as many threads as there are find the same.

use rayon::prelude::*;

use crate::mesh::OneRings;
use crate::mesh::pulse::Pulse;
use crate::simplify::closed::cluster::placement::Placement;
use crate::simplify::limits::Limit;
use crate::spatial::curve_order;

use super::complex::{Collapse, NONE, ghosts, merges_to};
use super::links::Links;
use super::pair::Node;
use super::rounds::price_of_round;

/// Vertices of a block: a vertex takes about 150 bytes with its neighbours and prices, a block 5 MB.
const BLOCK: usize = 32_768;
/// Blocks from which on there is more within them than between them: with one there is nothing to do side by side.
const LEAST_BLOCKS: usize = 2;
/// Share of the merges that are left to the whole, which prices the edges between the blocks, too: the frozen vertices,
/// a few percent, have no other turn.
const LEFT: f64 = 0.02;

impl<'a> Collapse<'a> {
    /// As [`Collapse::new`], and on the way down to the limit as far as blocks go, if there are enough vertices for them.
    pub fn toward(
        pulse: Pulse<'a>,
        limit: Limit,
        last_stretch: f64,
        placed: &Placement,
        rings: &OneRings,
        ceilings: Vec<f32>,
    ) -> Self {
        if rings.n_vertices() >= LEAST_BLOCKS * BLOCK {
            return collapse_in_blocks(pulse, placed, rings, [limit.times(last_stretch), limit], &ceilings);
        }
        Self::new(pulse, placed, rings).below(ceilings)
    }
}

/// A complex over these positions, quadrics and rings, most of the way down to the last stretch and then to the limit.
fn collapse_in_blocks<'a>(
    pulse: Pulse<'a>,
    placed: &Placement,
    rings: &OneRings,
    [stretch, limit]: [Limit; 2],
    ceilings: &[f32],
) -> Collapse<'a> {
    let n_vertices = rings.n_vertices();
    let (ghosts, n_faces) = ghosts(rings);
    let order = curve_order(n_vertices, |v| placed.position(v).as_vec3().to_array(), || pulse.beat(0));
    let split = Split::new(pulse.counting_if(false), order, n_vertices.div_ceil(BLOCK));
    pulse.beat(0);
    let block = |i| split.block(i, placed, rings).below(split.of_block(i, ceilings));
    let mut blocks: Vec<Collapse> = (0..split.n_blocks()).into_par_iter().map(block).collect();
    blocks.par_iter_mut().for_each(Collapse::price);
    let n_free = blocks.iter().flat_map(|block| &block.frozen).filter(|frozen| !**frozen).count();
    let share = n_free as f64 / n_vertices as f64;
    let to_do = |limit| (share * merges_to(limit, n_vertices, n_faces) as f64) as usize;
    let done = descend(&mut blocks, to_do(stretch));
    blocks.par_iter_mut().for_each(|block| {
        block.begin_last_stretch();
        block.price();
    });
    descend(&mut blocks, to_do(limit).saturating_sub(done));
    split.joined(pulse, blocks, ghosts, n_faces)
}

/// Takes away about as many vertices as are `to_do`, never more, in rounds of all blocks together; returns how many.
fn descend(blocks: &mut [Collapse], to_do: usize) -> usize {
    let (mut left, mut most) = (to_do, 0.0);
    while left as f64 > LEFT * to_do as f64 {
        most = price_of_round(left, most, &*blocks);
        let counts: Vec<usize> = blocks.par_iter().map(|block| block.n_up_to(most)).collect();
        let n_all: usize = counts.iter().sum();
        let rounds = blocks.par_iter_mut().zip(counts).map(|(block, n)| {
            let n_vertices = block.n_vertices;
            let at_most = if n_all <= left { n } else { (n as u128 * left as u128 / n_all as u128) as usize };
            block.round(Limit::of_vertices(0), most, at_most);
            n_vertices - block.n_vertices
        });
        let merged = rounds.sum::<usize>();
        if merged == 0 {
            break;
        }
        left -= merged.min(left);
    }
    to_do - left
}

/// Vertices in blocks.
struct Split {
    /// The vertices, block after block.
    order: Vec<u32>,
    /// The place of each vertex in the order.
    rank: Vec<u32>,
    /// Where the blocks begin, and the number of vertices.
    starts: Vec<usize>,
}

impl Split {
    /// So many blocks of about equal size of vertices in this order.
    fn new(pulse: Pulse, order: Vec<u32>, n_blocks: usize) -> Self {
        let mut rank = vec![0; order.len()];
        for numbers in pulse.through(0..order.len()) {
            numbers.clone().zip(&order[numbers]).for_each(|(i, &v)| rank[v as usize] = i as u32);
        }
        let starts = (0..=n_blocks).map(|i| order.len() * i / n_blocks).collect();
        Self { order, rank, starts }
    }

    fn n_blocks(&self) -> usize {
        self.starts.len() - 1
    }

    /// The ceilings of a block's vertices; empty where there are none.
    fn of_block(&self, block: usize, ceilings: &[f32]) -> Vec<f32> {
        self.vertices(block).iter().filter_map(|&v| ceilings.get(v as usize).copied()).collect()
    }

    fn vertices(&self, block: usize) -> &[u32] {
        &self.order[self.starts[block]..self.starts[block + 1]]
    }

    /// The complex of a block. Neighbours elsewhere stand behind its own vertices, by their numbers in the mesh.
    fn block<'a>(&self, i: usize, placed: &'a Placement, rings: &OneRings) -> Collapse<'a> {
        placed.pulse().beat(0);
        let own = self.vertices(i);
        let n_inner = own.len();
        let mut frozen = vec![false; n_inner];
        let mut links = Links::with_capacity(n_inner);
        let mut nodes = Vec::with_capacity(n_inner);
        for (&v, frozen) in own.iter().zip(&mut frozen) {
            let neighbor = |&w: &u32| {
                let rank = self.rank.get(w as usize).map_or(usize::MAX, |&rank| rank as usize);
                let place = rank.wrapping_sub(self.starts[i]);
                let is_own = place < n_inner;
                *frozen |= !is_own;
                if is_own { place as u32 } else { n_inner as u32 + w }
            };
            let ring = links.push(rings.ring(v).iter().map(neighbor));
            nodes.push(Node::new(placed, v, ring));
        }
        let mut block = Collapse { frozen, ..Collapse::of(placed.pulse(), nodes, links, n_inner, 2 * n_inner) };
        block.hold_hubs();
        block
    }

    /// One complex again, of what lives in the blocks, with the ghost vertices and out of as many faces as it had before.
    fn joined<'a>(&self, pulse: Pulse<'a>, blocks: Vec<Collapse>, ghosts: Vec<Node>, n_faces: usize) -> Collapse<'a> {
        let mut n_before = 0;
        let numbered = blocks.into_iter().map(|block| {
            let first = n_before;
            n_before += block.n_vertices as u32;
            (first, block)
        });
        let numbered: Vec<(u32, Collapse)> = numbered.collect();
        let n_inner = n_before as usize;
        let numbers = |(first, block): &(u32, Collapse)| block.numbers(*first);
        let numbers: Vec<Vec<u32>> = numbered.par_iter().map(numbers).collect();
        let mut begun = vec![0; self.order.len()];
        for (block, numbers) in numbers.iter().enumerate() {
            pulse.beat(0);
            self.vertices(block).iter().zip(numbers).for_each(|(&v, &number)| begun[v as usize] = number);
        }

        let elsewhere = |w: u32| match (w as usize).checked_sub(begun.len()) {
            None => begun[w as usize],
            Some(ghost) => (n_inner + ghost) as u32,
        };
        let part = |((_, block), numbers): ((u32, Collapse), &Vec<u32>)| block.part(numbers, elsewhere);
        let parts: Vec<Part> = numbered.into_par_iter().zip(&numbers).map(part).collect();
        let n_merged = self.order.len() - n_inner;
        let mut whole = whole_of(pulse, parts, ghosts, n_inner, n_faces - 2 * n_merged);
        whole.hold_hubs();
        // The faces around these were not all of one block.
        whole.unpriced.clone().unwrap_or_default().into_iter().for_each(|v| whole.renew(v));
        Collapse { begun, ..whole }
    }
}

/// The complex of these parts and the ghost vertices, with so many vertices and faces.
fn whole_of(pulse: Pulse<'_>, parts: Vec<Part>, ghosts: Vec<Node>, n_inner: usize, n_faces: usize) -> Collapse<'_> {
    let (mut nodes_of, mut links_of, mut n_blocks) = (Vec::new(), Vec::new(), 0);
    let (mut least, mut unpriced, mut ceilings) = (Vec::with_capacity(n_inner), Vec::new(), Vec::new());
    for part in parts {
        nodes_of.push((n_blocks, part.nodes));
        n_blocks += part.links.n_blocks();
        links_of.push(part.links);
        least.extend(part.least);
        ceilings.extend(part.ceilings);
        unpriced.extend(part.unpriced);
    }
    let all_nodes = || {
        let mut nodes = Vec::with_capacity(n_inner + ghosts.len());
        for (n_before, part) in nodes_of {
            pulse.beat(0);
            nodes.extend(part.into_iter().map(|node| Node { ring: node.ring.after(n_before), ..node }));
        }
        nodes.extend(ghosts);
        nodes
    };
    let all_links = || {
        let mut links = Links::with_capacity(n_inner);
        for part in links_of {
            pulse.beat(0);
            links.append(part);
        }
        links
    };
    let (nodes, links) = rayon::join(all_nodes, all_links);
    Collapse {
        least,
        ceilings,
        unpriced: Some(unpriced),
        is_last_stretch: true,
        ..Collapse::of(pulse, nodes, links, n_inner, n_faces)
    }
}

/// What lives of a block, in the numbers of the whole.
struct Part {
    nodes: Vec<Node>,
    links: Links,
    least: Vec<f32>,
    ceilings: Vec<f32>,
    /// The vertices with neighbours that were frozen: their prices are not known.
    unpriced: Vec<u32>,
}

impl Collapse<'_> {
    /// What lives of this block; `numbers` are those of its vertices, `elsewhere` gives those of others.
    fn part(self, numbers: &[u32], elsewhere: impl Fn(u32) -> u32) -> Part {
        self.pulse.beat(0);
        let n_own = self.n_inner as u32;
        let number = |w: u32| w.checked_sub(n_own).map_or_else(|| numbers[w as usize], &elsewhere);
        let mut links = Links::with_capacity(self.n_vertices);
        let node = |v: u32| {
            let node = self.nodes[v as usize];
            let ring = links.push_renumbered(&self.links, node.ring, number);
            let partner = if node.partner == NONE { NONE } else { number(node.partner) };
            Node { ring, partner, ..node }
        };
        let nodes = self.living().map(node).collect();
        let is_known = |v: u32| !self.is_frozen(v) && !self.ring(v).any(|w| self.is_frozen(w));
        let unpriced = self.living().filter(|&v| !is_known(v)).map(|v| numbers[v as usize]).collect();
        let least = self.living().map(|v| self.least[v as usize]).collect();
        let ceilings = self.living().filter_map(|v| self.ceilings.get(v as usize).copied()).collect();
        Part { nodes, links, least, ceilings, unpriced }
    }

    /// The number of each vertex, merged ones that of what they became, when those that live are counted from `first`.
    fn numbers(&self, first: u32) -> Vec<u32> {
        self.pulse.beat(0);
        let mut numbers = vec![0; self.n_inner];
        self.living().zip(first..).for_each(|(v, number)| numbers[v as usize] = number);
        (0..self.n_inner as u32).for_each(|v| numbers[v as usize] = numbers[self.last(v) as usize]);
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes, topology};
    use crate::simplify::closed::cluster::assignment::Assignment;
    use crate::simplify::closed::cluster::placement::{Placement, Places};
    use crate::simplify::closed::collapse::{End, tests::error};
    use crate::simplify::closed::prepare::surface::Surface;

    /// The collapse of a mesh to its fifth in blocks and as a whole.
    fn in_blocks_and_whole(mesh: &TriMesh) -> [Collapse<'static>; 2] {
        let surface = Surface::new(mesh, Pulse::NONE);
        let n_vertices = surface.n_vertices();
        assert!(n_vertices >= LEAST_BLOCKS * BLOCK);
        let placed = Placement::new(&surface, Places::default(), &[]);
        let limit = Limit::of_vertices(n_vertices / 5);
        let mut whole = Collapse::new(Pulse::NONE, &placed, &surface.rings);
        let mut in_blocks = collapse_in_blocks(Pulse::NONE, &placed, &surface.rings, [limit.times(1.1), limit], &[]);
        let left = in_blocks.n_vertices - limit.vertices;
        assert!((0.002..0.2).contains(&(left as f64 / n_vertices as f64)), "{left}");
        assert_eq!([whole.run(limit, 1.1), in_blocks.run(limit, 1.1)], [End::Reached; 2]);
        [in_blocks, whole]
    }

    #[test]
    fn blocks_end_where_the_whole_does() {
        for mesh in [shapes::torus(380, 200, 1.0, 0.4), shapes::open_cylinder(300, 240), shapes::klein_bottle(360, 200)]
        {
            let [in_blocks, whole] = in_blocks_and_whole(&mesh);
            assert_eq!(in_blocks.n_vertices, whole.n_vertices);
            let surface = Surface::new(&mesh, Pulse::NONE);
            let errors = [&in_blocks, &whole].map(|collapse| error(&surface, collapse));
            assert!(errors[0] < 1.35 * errors[1] + 1e-12, "{errors:?}");
            let output = in_blocks.output(&Assignment::identity(mesh.positions().len()));
            let (faces, positions, vertex_of) = (output.faces().to_vec(), output.positions, output.vertex_of);
            assert_eq!((faces.len(), vertex_of.len()), (in_blocks.n_faces, mesh.positions().len()));
            let mut is_used = vec![false; positions.len()];
            vertex_of.iter().for_each(|&v| is_used[v as usize] = true);
            assert!(is_used.iter().all(|used| *used));
            let lighter = TriMesh::new(positions.iter().map(|p| p.to_array()).collect(), faces).unwrap();
            let (before, after) = (topology(&mesh), topology(&lighter));
            assert_eq!(after.non_manifold_edges + after.non_manifold_vertices + after.unreferenced_vertices, 0);
            assert_eq!((after.euler, after.components), (before.euler, before.components));
            assert_eq!((after.boundary_loops, after.orientable), (before.boundary_loops, before.orientable));
        }
    }

    #[test]
    fn blocks_are_near_what_they_stand_for() {
        let mesh = shapes::torus(380, 200, 1.0, 0.4);
        let surface = Surface::new(&mesh, Pulse::NONE);
        let [in_blocks, _] = in_blocks_and_whole(&mesh);
        let output = in_blocks.output(&Assignment::identity(surface.n_vertices()));
        let far = surface.positions.iter().zip(&output.vertex_of);
        let far = far.map(|(p, &v)| p.distance(output.positions[v as usize]));
        let farthest = far.fold(0.0, f32::max);
        assert!(farthest < 0.1, "{farthest}");
    }
}
