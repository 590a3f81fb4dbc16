//! A grid of points.

use rustc_hash::FxHashMap;

/// Points sorted into cubic cells.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::PointGrid;
/// let grid = PointGrid::new(&[[0.0; 3], [1.0, 0.0, 0.0], [9.0, 0.0, 0.0]], 2.0);
/// assert_eq!(grid.find_within([0.5, 0.0, 0.0], 2.0), [0, 1]);
/// ```
pub struct PointGrid {
    side: f64,
    points: Vec<[f64; 3]>,
    cells: FxHashMap<[i64; 3], Vec<u32>>,
}

impl PointGrid {
    /// Sorts points (n x 3, finite) into cells; `side` is best about the search distance.
    pub fn new(points: &[[f64; 3]], side: f64) -> Self {
        let side = if side > 0.0 && side.is_finite() { side } else { 1.0 };
        let mut cells: FxHashMap<[i64; 3], Vec<u32>> = FxHashMap::default();
        for (at, p) in (0..).zip(points) {
            cells.entry(cell(*p, side)).or_default().push(at);
        }
        Self { side, points: points.to_vec(), cells }
    }

    /// Returns the points at most `reach` from `p`, ascending.
    pub fn find_within(&self, p: [f64; 3], reach: f64) -> Vec<u32> {
        let low = cell(p.map(|x| x - reach), self.side);
        let high = cell(p.map(|x| x + reach), self.side);
        let mut found = Vec::new();
        for (x, y) in (low[0]..=high[0]).flat_map(|x| (low[1]..=high[1]).map(move |y| (x, y))) {
            let column = (low[2]..=high[2]).filter_map(|z| self.cells.get(&[x, y, z]));
            found.extend(column.flatten().filter(|&&at| self.distance2(at, p) <= reach * reach));
        }
        found.sort_unstable();
        found
    }

    fn distance2(&self, at: u32, p: [f64; 3]) -> f64 {
        let q = self.points[at as usize];
        (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum()
    }
}

fn cell(p: [f64; 3], side: f64) -> [i64; 3] {
    p.map(|x| (x / side).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn agrees_with_a_search(
            points in prop::collection::vec(prop::array::uniform3(-3.0f64..3.0), 0..100),
            p in prop::array::uniform3(-3.0f64..3.0),
            (side, reach) in (0.1f64..2.0, 0.0f64..3.0),
        ) {
            let grid = PointGrid::new(&points, side);
            let near = |at: &u32| grid.distance2(*at, p) <= reach * reach;
            let expected: Vec<u32> = (0..points.len() as u32).filter(near).collect();
            prop_assert_eq!(grid.find_within(p, reach), expected);
        }
    }
}
