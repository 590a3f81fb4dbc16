//! The cells of space that each component of a scene is in, on grids of several sizes.
//!
//! A cell that loses its last component leaves a gap, as in a lattice mast without its bars. Few pixels show such a gap.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::linalg::Rows;

use super::dropping::PlacedComponents;

/// Side of the finest cells, over the scene's diagonal; each coarser grid doubles it.
const FINEST: f64 = 1.0 / 32.0;
const N_GRIDS: u32 = 3;
/// Largest number of parts of a face's side between points in the finest cells.
const MOST_PARTS: f64 = 64.0;

/// The numbered cells of all grids that components are in.
pub struct OccupiedCells {
    of_component: Rows<u32>,
    /// Number of components in each cell.
    pub counts: Vec<u32>,
    /// Squared side of each cell, over that of the scene's diagonal.
    squares: Vec<f64>,
}

impl OccupiedCells {
    /// Finds the cells of `n` components, at all of their placements in a scene of this diagonal.
    pub fn new(placed: &PlacedComponents, n: usize, diagonal: f64) -> Self {
        let side = FINEST * diagonal;
        let mut finest: Vec<(u32, [i32; 3])> = Vec::new();
        placed.visit_faces(|component, _, corners| {
            visit_points(corners, 0.5 * side, |point| {
                let found = (component, point.to_array().map(|x| (x / side).floor() as i32));
                finest.extend((finest.last() != Some(&found)).then_some(found));
            });
        });
        finest.sort_unstable();
        finest.dedup();
        let (mut numbers, mut squares) = (FxHashMap::default(), Vec::new());
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for grid in 0..N_GRIDS {
            for &(component, at) in &finest {
                let cell = *numbers.entry((grid, at.map(|x| x >> grid))).or_insert_with(|| {
                    squares.push((FINEST * f64::from(1 << grid)).powi(2));
                    squares.len() as u32 - 1
                });
                pairs.push((component, cell));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut counts = vec![0; squares.len()];
        pairs.iter().for_each(|&(_, cell)| counts[cell as usize] += 1);
        Self { of_component: Rows::new(n, pairs.into_iter()), counts, squares }
    }

    pub fn of_component(&self, component: usize) -> &[u32] {
        self.of_component.row(component)
    }

    /// Sums the squared sides of the cells that are empty without the component, over the scene's squared diagonal.
    pub fn emptied_without(&self, component: usize, counts: &[u32]) -> f64 {
        let own = self.of_component(component).iter();
        own.filter(|&&cell| counts[cell as usize] == 1).map(|&cell| self.squares[cell as usize]).sum()
    }
}

/// Calls `visit` with points of a triangle at most `spacing` apart.
fn visit_points([a, b, c]: [DVec3; 3], spacing: f64, mut visit: impl FnMut(DVec3)) {
    let longest = (b - a).length().max((c - a).length()).max((c - b).length());
    let n = (longest / spacing).ceil().clamp(1.0, MOST_PARTS) as u32;
    let part = |i: u32| f64::from(i) / f64::from(n);
    for i in 0..=n {
        (0..=n - i).for_each(|j| visit(a + part(i) * (b - a) + part(j) * (c - a)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::closed::original::Original;

    #[test]
    fn cells_that_a_component_shares_are_not_emptied() {
        let ball = |x: f32| shapes::place(&shapes::icosphere(0), |p| p.map(|y| 1e-3 * y + 0.01 + x));
        let mesh = shapes::unite([ball(0.0), ball(0.0), ball(0.5)]);
        let original = Original::bare(&mesh);
        let component_of_face: Vec<u32> = (0..60).map(|face| face / 20).collect();
        let placed = PlacedComponents::new(&original, None, None, &component_of_face, 3);
        let cells = OccupiedCells::new(&placed, 3, 1.0);
        let emptied = |component: usize| cells.emptied_without(component, &cells.counts);
        // One cell of each grid.
        assert_eq!([emptied(0), emptied(1), emptied(2)], [0.0, 0.0, (1.0 + 4.0 + 16.0) / 1024.0]);
    }

    #[test]
    fn long_faces_have_points_in_all_cells() {
        let mut cells = Vec::new();
        let corners = [[0.0; 3], [10.0, 0.0, 0.0], [10.0, 0.1, 0.0]].map(DVec3::from);
        visit_points(corners, 0.25, |point| cells.push((2.0 * point.x).floor() as i32));
        assert!((0..20).all(|cell| cells.contains(&cell)), "{cells:?}");
    }
}
