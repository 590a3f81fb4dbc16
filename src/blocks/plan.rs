//! Assignment of positions to blocks: boxes split along their longest side.

use rustc_hash::FxHashMap;

/// Cells along each side of the cube around the mesh.
const SIDE: u16 = 512;

type CubeCell = [u16; 3];

/// Number of positions in each cell of a cubic grid.
#[derive(Clone, Debug)]
pub struct Census {
    grid: CubeGrid,
    counts: FxHashMap<CubeCell, u64>,
}

#[derive(Clone, Debug)]
pub struct BlockPlan {
    grid: CubeGrid,
    splits: Vec<Split>,
    n_blocks: usize,
}

#[derive(Clone, Copy, Debug)]
struct CubeGrid {
    low: [f32; 3],
    // Cells per unit length.
    scale: f64,
}

// Cells before `at` along `axis` take the first branch, others the second.
#[derive(Clone, Copy, Debug)]
struct Split {
    axis: usize,
    at: u16,
    branches: [Branch; 2],
}

#[derive(Clone, Copy, Debug)]
enum Branch {
    Split(usize),
    Block(usize),
}

impl CubeGrid {
    fn cell(&self, position: [f32; 3]) -> CubeCell {
        [0, 1, 2].map(|axis| {
            let along = (f64::from(position[axis]) - f64::from(self.low[axis])) * self.scale;
            (along as u16).min(SIDE - 1)
        })
    }
}

impl Census {
    pub fn new(low: [f32; 3], high: [f32; 3]) -> Self {
        let longest = (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis])).fold(0.0, f64::max);
        let scale = if longest > 0.0 { f64::from(SIDE - 1) / longest } else { 0.0 };
        Self { grid: CubeGrid { low, scale }, counts: FxHashMap::default() }
    }

    pub fn count(&mut self, position: [f32; 3]) {
        *self.counts.entry(self.grid.cell(position)).or_default() += 1;
    }

    /// Plans `n_blocks` blocks of about equally many positions, fewer if there are too few cells.
    pub fn plan(self, n_blocks: usize) -> BlockPlan {
        let mut cells: Vec<(CubeCell, u64)> = self.counts.into_iter().collect();
        cells.sort_unstable();
        let mut plan = BlockPlan { grid: self.grid, splits: Vec::new(), n_blocks: 0 };
        plan.split(&mut cells, n_blocks.max(1));
        plan
    }
}

impl BlockPlan {
    pub fn n_blocks(&self) -> usize {
        self.n_blocks
    }

    pub fn block_at(&self, position: [f32; 3]) -> usize {
        let cell = self.grid.cell(position);
        let mut branch = if self.splits.is_empty() { Branch::Block(0) } else { Branch::Split(0) };
        loop {
            match branch {
                Branch::Block(block) => return block,
                Branch::Split(number) => {
                    let Split { axis, at, branches } = self.splits[number];
                    branch = branches[usize::from(cell[axis] >= at)];
                }
            }
        }
    }

    fn split(&mut self, cells: &mut [(CubeCell, u64)], n_blocks: usize) -> Branch {
        let Some((axis, at)) = (n_blocks > 1).then(|| find_split(cells, n_blocks)).flatten() else {
            self.n_blocks += 1;
            return Branch::Block(self.n_blocks - 1);
        };
        let number = self.splits.len();
        self.splits.push(Split { axis, at, branches: [Branch::Block(0); 2] });
        let n_before = cells.partition_point(|(cell, _)| cell[axis] < at);
        let (before, after) = cells.split_at_mut(n_before);
        let branches = [(before, n_blocks / 2), (after, n_blocks - n_blocks / 2)];
        self.splits[number].branches = branches.map(|(cells, n)| self.split(cells, n));
        Branch::Split(number)
    }
}

/// Sorts cells along the longest side of their box; returns that axis and the end of the first half.
fn find_split(cells: &mut [(CubeCell, u64)], n_blocks: usize) -> Option<(usize, u16)> {
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
        mesh.positions().iter().for_each(|&p| sizes[plan.block_at(p)] += 1);
        let even = mesh.positions().len() / 7;
        assert!(sizes.iter().all(|&n| n > even / 2 && n < 2 * even), "{sizes:?}");
        for far in [[f32::MAX; 3], [f32::MIN; 3], [f32::NAN; 3]] {
            assert!(plan.block_at(far) < 7);
        }
    }

    #[test]
    fn one_place_is_one_block() {
        let mut census = Census::new([2.0; 3], [2.0; 3]);
        (0..100).for_each(|_| census.count([2.0; 3]));
        assert_eq!(census.plan(5).n_blocks(), 1);
    }
}
