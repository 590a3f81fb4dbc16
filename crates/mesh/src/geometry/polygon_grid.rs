//! A grid over the corners of a polygon.

use glam::DVec2;

const MOST: usize = 1024;
/// Margin around a cell, relative to its size.
const MARGIN: f64 = 1e-6;

pub(super) struct CornerGrid {
    low: DVec2,
    side: DVec2,
    n_side: usize,
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl CornerGrid {
    pub fn new(points: &[DVec2], corners: &[u32]) -> Self {
        let places = || corners.iter().map(|&corner| points[corner as usize]);
        let low = places().fold(DVec2::INFINITY, DVec2::min);
        let high = places().fold(DVec2::NEG_INFINITY, DVec2::max);
        let n_side = (corners.len() as f64).sqrt().ceil().clamp(1.0, MOST as f64) as usize;
        let side = ((high - low) / n_side as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        let mut grid =
            Self { low, side, n_side, starts: vec![0; n_side * n_side + 1], corners: vec![0; corners.len()] };
        let cells: Vec<usize> = places().map(|p| grid.cell(p)).collect();
        cells.iter().for_each(|&cell| grid.starts[cell + 1] += 1);
        (0..n_side * n_side).for_each(|cell| grid.starts[cell + 1] += grid.starts[cell]);
        let mut next = grid.starts.clone();
        for (&corner, &cell) in corners.iter().zip(&cells) {
            grid.corners[next[cell] as usize] = corner;
            next[cell] += 1;
        }
        grid
    }

    fn cell_coordinates(&self, p: DVec2) -> [usize; 2] {
        let place = (p - self.low) / self.side;
        [place.x, place.y].map(|x| (x as usize).min(self.n_side - 1))
    }

    fn cell(&self, p: DVec2) -> usize {
        let [column, row] = self.cell_coordinates(p);
        row * self.n_side + column
    }

    /// Returns whether `wanted` accepts any corner near a counter-clockwise triangle, and the number of tests.
    pub fn any_near(&self, [a, b, c]: [DVec2; 3], mut wanted: impl FnMut(u32) -> bool) -> (bool, usize) {
        let margin = self.side * MARGIN;
        let ([first_column, first_row], [last_column, last_row]) =
            (self.cell_coordinates(a.min(b).min(c) - margin), self.cell_coordinates(a.max(b).max(c) + margin));
        let mut n_visits = 0;
        for row in first_row..=last_row {
            for column in first_column..=last_column {
                n_visits += 1;
                let low = self.low + self.side * DVec2::new(column as f64, row as f64);
                if [(a, b), (b, c), (c, a)].into_iter().any(|edge| self.is_beyond(edge, low)) {
                    continue;
                }
                let cell = row * self.n_side + column;
                for &corner in &self.corners[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
                    n_visits += 1;
                    if wanted(corner) {
                        return (true, n_visits);
                    }
                }
            }
        }
        (false, n_visits)
    }

    fn is_beyond(&self, (p, q): (DVec2, DVec2), low: DVec2) -> bool {
        let (along, margin) = (q - p, self.side * MARGIN);
        let (low, high) = (low - margin, low + self.side + margin);
        // The corner of the cell that is farthest to the left.
        let corner = DVec2::new(if along.y < 0.0 { high.x } else { low.x }, if along.x > 0.0 { high.y } else { low.y });
        along.perp_dot(corner - p) < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_what_lies_in_a_triangle(
            points in prop::collection::vec(prop::array::uniform2(-9i8..9), 3..80),
            triangle in prop::array::uniform3(prop::array::uniform2(-12i8..12)),
        ) {
            let point = |p: [i8; 2]| DVec2::new(f64::from(p[0]) / 7.0, f64::from(p[1]) / 3.0);
            let points: Vec<DVec2> = points.into_iter().map(point).collect();
            let [a, b, c] = triangle.map(point);
            prop_assume!((b - a).perp_dot(c - a) > 0.0);
            let is_inside = |i: u32| {
                let p = points[i as usize];
                [(a, b), (b, c), (c, a)].into_iter().all(|(q, r)| (r - q).perp_dot(p - q) >= 0.0)
            };
            let corners: Vec<u32> = (0..points.len() as u32).collect();
            let found = CornerGrid::new(&points, &corners).any_near([a, b, c], is_inside);
            prop_assert_eq!(found.0, corners.into_iter().any(is_inside));
        }
    }

    #[test]
    fn looks_at_little_for_a_small_triangle() {
        let points: Vec<DVec2> = (0..10_000).map(|i| DVec2::new((i % 100) as f64, (i / 100) as f64)).collect();
        let grid = CornerGrid::new(&points, &(0..10_000).collect::<Vec<u32>>());
        let small = [DVec2::new(50.2, 50.2), DVec2::new(50.8, 50.2), DVec2::new(50.2, 50.8)];
        let diagonal = [DVec2::new(0.2, 0.1), DVec2::new(99.2, 99.1), DVec2::new(50.2, 50.3)];
        assert!(grid.any_near(small, |_| false).1 < 20);
        // All cells are visited, but few corners.
        assert!(grid.any_near(diagonal, |_| false).1 < 10_800);
    }
}
