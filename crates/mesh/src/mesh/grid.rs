//! Rounds positions to a regular grid.

use rustc_hash::FxHashMap;

use super::has_area;

/// The points `origin + step * [i, j, k]` for whole numbers i, j, k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionGrid {
    /// Point 0, 0, 0.
    pub origin: [f64; 3],
    /// Distance between neighbouring points along an axis.
    pub step: f64,
}

impl PositionGrid {
    /// Builds a grid over points, whose longest side has `2^bits - 1` steps.
    ///
    /// `None` if the points have no extent or `f32` cannot hold the step.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::mesh::PositionGrid;
    /// let grid = PositionGrid::from_points([[1.0; 3], [2.0, 1.25, 1.0]].into_iter(), 8).unwrap();
    /// assert_eq!((grid.origin, grid.round([2.0, 1.25, 1.0])), ([1.0; 3], [255, 64, 0]));
    /// ```
    pub fn from_points(points: impl Iterator<Item = [f32; 3]>, bits: u32) -> Option<Self> {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for point in points {
            low = std::array::from_fn(|axis| low[axis].min(point[axis]));
            high = std::array::from_fn(|axis| high[axis].max(point[axis]));
        }
        let side = |axis: usize| f64::from(high[axis]) - f64::from(low[axis]);
        let longest = side(0).max(side(1)).max(side(2));
        let step = (longest / f64::from((1u32 << bits) - 1)) as f32;
        // The next larger number, so that the grid reaches the last point.
        let step = if f64::from(step) * f64::from((1u32 << bits) - 1) < longest { step.next_up() } else { step };
        let is_usable = step.is_normal() && low.iter().all(|x| x.is_finite());
        is_usable.then(|| Self { origin: low.map(in_few_digits), step: in_few_digits(step) })
    }

    /// Returns the indices of the nearest grid point.
    pub fn round(&self, point: [f64; 3]) -> [i64; 3] {
        // A cast from float to integer saturates.
        std::array::from_fn(|axis| ((point[axis] - self.origin[axis]) / self.step).round() as i64)
    }

    /// Returns the grid point with these indices.
    pub fn point(&self, numbers: [i64; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| self.origin[axis] + self.step * numbers[axis] as f64)
    }

    /// Returns the largest distance that rounding moves a point.
    pub fn rounding(&self) -> f64 {
        0.5 * 3f64.sqrt() * self.step
    }

    /// Returns whether rounding keeps vertices apart and every face's area above zero.
    pub fn preserves(&self, positions: &[[f32; 3]], faces: &[[u32; 3]]) -> bool {
        let numbers: Vec<[i64; 3]> = positions.iter().map(|p| self.round(p.map(f64::from))).collect();
        let mut first: FxHashMap<[i64; 3], [f32; 3]> = FxHashMap::default();
        let mut stays_apart = |v: u32| {
            let position = positions[v as usize];
            *first.entry(numbers[v as usize]).or_insert(position) == position
        };
        faces.as_flattened().iter().all(|&v| stays_apart(v))
            && faces.iter().all(|face| {
                has_area(face.map(|v| numbers[v as usize].map(|x| x as f64)))
                    || !has_area(face.map(|v| positions[v as usize].map(f64::from)))
            })
    }
}

/// Returns the longest side of the points' bounding box.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::longest_side;
/// assert_eq!(longest_side([[0.0, 1.0, 5.0], [2.0, -2.0, 5.0]].into_iter()), 3.0);
/// ```
pub fn longest_side(points: impl Iterator<Item = [f64; 3]>) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        low = std::array::from_fn(|axis| low[axis].min(p[axis]));
        high = std::array::from_fn(|axis| high[axis].max(p[axis]));
    }
    (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max)
}

/// Returns the double with the fewest digits that rounds to `x`.
fn in_few_digits(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_move_by_no_more_than_said() {
        let points: Vec<[f32; 3]> =
            (0..999).map(|i| [0.37, -1.7, 5e-3].map(|x| (f64::from(i) * x).sin() as f32 * 70.0 + 1e3)).collect();
        for bits in [8, 14, 16] {
            let grid = PositionGrid::from_points(points.iter().copied(), bits).unwrap();
            for point in &points {
                let (exact, numbers) = (point.map(f64::from), grid.round(point.map(f64::from)));
                assert!(numbers.iter().all(|n| (0..1 << bits).contains(n)), "{numbers:?}");
                let moved = glam::DVec3::from(grid.point(numbers)).distance(exact.into());
                assert!(moved <= grid.rounding() * (1.0 + 1e-9), "{moved}");
            }
        }
        assert_eq!(PositionGrid::from_points([[7.0; 3]].into_iter(), 14), None);
        assert_eq!(PositionGrid::from_points(std::iter::empty(), 14), None);
    }

    #[test]
    fn meshes_that_rounding_would_change_are_not_preserved() {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let grid = PositionGrid { origin: [0.0; 3], step: 0.1 };
        assert!(grid.preserves(&square, &[[0, 1, 2], [0, 2, 3]]));
        let near = [square[0], square[1], square[2], [0.04, 0.03, 0.0]];
        assert!(!grid.preserves(&near, &[[0, 1, 2], [0, 2, 3]]));
        let flat = [square[0], square[1], square[2], [0.5, 0.04, 0.0]];
        assert!(!grid.preserves(&flat, &[[0, 1, 2], [0, 1, 3]]));
        // Faces without area and equal positions do not count.
        assert!(grid.preserves(&[square[0], square[1], square[0]], &[[0, 1, 2]]));
    }
}
