//! Which block a place is of: boxes, halved along their longest side until each holds about as many positions.
//!
//! Runs of cells along Morton's curve had borders twice as long, and vertices on borders stay until blocks are joined.

use rustc_hash::FxHashMap;

/// Cells along each side of the cube around the mesh.
const SIDE: u16 = 512;

/// A cell of the cube.
type Cell = [u16; 3];

/// How many positions are in each cell.
#[derive(Clone, Debug)]
pub struct Census {
    grid: Grid,
    counts: FxHashMap<Cell, u64>,
}

/// The boxes of the blocks.
#[derive(Clone, Debug)]
pub struct Plan {
    grid: Grid,
    halvings: Vec<Halving>,
    n_blocks: usize,
}

/// Where cells lie.
#[derive(Clone, Copy, Debug)]
struct Grid {
    low: [f32; 3],
    /// Cells per length.
    scale: f64,
}

/// Cells before `at` along an axis go one way, the others the other way.
#[derive(Clone, Copy, Debug)]
struct Halving {
    axis: usize,
    at: u16,
    ways: [Way; 2],
}

#[derive(Clone, Copy, Debug)]
enum Way {
    Halved(usize),
    Block(usize),
}

impl Grid {
    fn cell(&self, position: [f32; 3]) -> Cell {
        [0, 1, 2].map(|axis| {
            let along = (f64::from(position[axis]) - f64::from(self.low[axis])) * self.scale;
            (along as u16).min(SIDE - 1)
        })
    }
}

impl Census {
    /// Nothing yet within a box.
    pub fn new(low: [f32; 3], high: [f32; 3]) -> Self {
        let longest = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis])).fold(0.0, f64::max);
        let scale = if longest > 0.0 { f64::from(SIDE - 1) / longest } else { 0.0 };
        Self { grid: Grid { low, scale }, counts: FxHashMap::default() }
    }

    /// Counts a position.
    pub fn count(&mut self, position: [f32; 3]) {
        *self.counts.entry(self.grid.cell(position)).or_default() += 1;
    }

    /// So many blocks, or fewer where cells are too few, with about as many positions in each.
    pub fn plan(self, n_blocks: usize) -> Plan {
        let mut cells: Vec<(Cell, u64)> = self.counts.into_iter().collect();
        cells.sort_unstable();
        let mut plan = Plan { grid: self.grid, halvings: Vec::new(), n_blocks: 0 };
        plan.halve(&mut cells, n_blocks.max(1));
        plan
    }
}

impl Plan {
    /// Number of blocks.
    pub fn n_blocks(&self) -> usize {
        self.n_blocks
    }

    /// The block that a place is of.
    pub fn home(&self, position: [f32; 3]) -> usize {
        let cell = self.grid.cell(position);
        let mut way = if self.halvings.is_empty() { Way::Block(0) } else { Way::Halved(0) };
        loop {
            match way {
                Way::Block(block) => return block,
                Way::Halved(number) => {
                    let Halving { axis, at, ways } = self.halvings[number];
                    way = ways[usize::from(cell[axis] >= at)];
                }
            }
        }
    }

    /// Parts cells into so many blocks.
    fn halve(&mut self, cells: &mut [(Cell, u64)], n_blocks: usize) -> Way {
        let Some((axis, at)) = (n_blocks > 1).then(|| middle(cells, n_blocks)).flatten() else {
            self.n_blocks += 1;
            return Way::Block(self.n_blocks - 1);
        };
        let number = self.halvings.len();
        self.halvings.push(Halving { axis, at, ways: [Way::Block(0); 2] });
        let n_before = cells.partition_point(|(cell, _)| cell[axis] < at);
        let (before, after) = cells.split_at_mut(n_before);
        let ways = [(before, n_blocks / 2), (after, n_blocks - n_blocks / 2)];
        self.halvings[number].ways = ways.map(|(cells, n)| self.halve(cells, n));
        Way::Halved(number)
    }
}

/// Sorts cells along the longest side of their box and gives it, and where the first half of the blocks ends; `None` of one cell.
fn middle(cells: &mut [(Cell, u64)], n_blocks: usize) -> Option<(usize, u16)> {
    let extent = |axis: usize| {
        let along = || cells.iter().map(|(cell, _)| cell[axis]);
        along().max().unwrap_or(0) - along().min().unwrap_or(0)
    };
    let axis = (0..3).max_by_key(|&axis| (extent(axis), std::cmp::Reverse(axis))).filter(|&axis| extent(axis) > 0)?;
    cells.sort_unstable_by_key(|(cell, _)| (cell[axis], *cell));
    let n_all: u64 = cells.iter().map(|(_, n)| n).sum();
    let wanted = n_all * (n_blocks / 2) as u64 / n_blocks as u64;
    let (mut n_before, first) = (0, cells[0].0[axis]);
    for (cell, n) in cells.iter() {
        if n_before >= wanted && cell[axis] > first {
            return Some((axis, cell[axis]));
        }
        n_before += n;
    }
    cells.last().map(|(cell, _)| (axis, cell[axis]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn blocks_are_of_about_one_size_and_hold_every_place() {
        let mesh = shapes::icosphere(5);
        let mut census = Census::new([-1.0; 3], [1.0; 3]);
        mesh.positions().iter().for_each(|&p| census.count(p));
        let plan = census.plan(7);
        assert_eq!(plan.n_blocks(), 7);
        let mut sizes = [0usize; 7];
        mesh.positions().iter().for_each(|&p| sizes[plan.home(p)] += 1);
        let even = mesh.positions().len() / 7;
        assert!(sizes.iter().all(|&n| n > even / 2 && n < 2 * even), "{sizes:?}");
        for far in [[f32::MAX; 3], [f32::MIN; 3], [f32::NAN; 3]] {
            assert!(plan.home(far) < 7);
        }
    }

    #[test]
    fn one_place_is_one_block() {
        let mut census = Census::new([2.0; 3], [2.0; 3]);
        (0..100).for_each(|_| census.count([2.0; 3]));
        assert_eq!(census.plan(5).n_blocks(), 1);
    }
}
