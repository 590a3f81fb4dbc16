//! Bounding boxes.

/// An axis-parallel box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Low corner.
    pub low: [f32; 3],
    /// High corner.
    pub high: [f32; 3],
}

impl Bounds {
    /// The empty box.
    pub const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// Returns the bounding box of points.
    #[inline(always)]
    pub fn from_points(points: &[[f32; 3]]) -> Self {
        let of_point = |&p: &[f32; 3]| Self { low: p, high: p };
        points.iter().map(of_point).reduce(|all, point| all.union(&point)).unwrap_or(Self::EMPTY)
    }

    /// Returns the smallest box around two boxes.
    #[inline(always)]
    pub fn union(&self, other: &Self) -> Self {
        // One instruction each; `f32::min` also handles NaN.
        let smaller = |x: f32, y: f32| if y < x { y } else { x };
        let larger = |x: f32, y: f32| if y > x { y } else { x };
        Self {
            low: std::array::from_fn(|k| smaller(self.low[k], other.low[k])),
            high: std::array::from_fn(|k| larger(self.high[k], other.high[k])),
        }
    }

    /// Returns whether two boxes share a point.
    pub fn overlaps(&self, other: &Self) -> bool {
        // Compares all axes: no branch to predict.
        (0..3).fold(true, |all, k| all & (self.low[k] <= other.high[k]) & (other.low[k] <= self.high[k]))
    }

    /// Returns the diagonal, 0 for the empty box.
    pub fn diagonal(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|k| (f64::from(self.high[k]) - f64::from(self.low[k])).max(0.0));
        x.hypot(y).hypot(z)
    }

    pub(super) fn half_area(&self) -> f32 {
        let [x, y, z]: [f32; 3] = std::array::from_fn(|k| (self.high[k] - self.low[k]).max(0.0));
        x * y + y * z + z * x
    }
}
