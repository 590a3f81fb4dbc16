//! The unit frame: the mesh is moved and scaled so that its bounding box is around the origin and one unit wide.

use crate::collapse::options::CollapseError;
use crate::collapse::vector::Point;

/// The center of the bounding box and its longest side, in the input's units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UnitFrame {
    center: [f64; 3],
    size: f64,
    scale: f64,
}

/// Returns the lowest and highest coordinates of points; zeros for none.
pub(crate) fn bounding_box(positions: &[Point]) -> [Point; 2] {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in positions {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    if positions.is_empty() { [[0.0; 3]; 2] } else { [low, high] }
}

impl UnitFrame {
    /// Measures the bounding box; refuses coordinates that are not finite.
    pub(crate) fn new(positions: &[Point]) -> Result<UnitFrame, CollapseError> {
        // A sum of zeros, else NaN.
        if let Some(vertex) = positions.iter().position(|p| (p[0] * 0.0 + p[1] * 0.0) + p[2] * 0.0 != 0.0) {
            return Err(CollapseError::NotFinite { vertex });
        }
        let [low, high] = bounding_box(positions).map(|corner| corner.map(f64::from));
        let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let scale = if size > 0.0 { 1.0 / size } else { 1.0 };
        Ok(UnitFrame { center: [0, 1, 2].map(|k| 0.5 * (low[k] + high[k])), size: 1.0 / scale, scale })
    }

    #[inline(always)]
    pub(crate) fn to_unit(self, p: Point) -> Point {
        [
            ((f64::from(p[0]) - self.center[0]) * self.scale) as f32,
            ((f64::from(p[1]) - self.center[1]) * self.scale) as f32,
            ((f64::from(p[2]) - self.center[2]) * self.scale) as f32,
        ]
    }

    pub(crate) fn to_input(self, p: Point) -> Point {
        [0, 1, 2].map(|k| (f64::from(p[k]) * self.size + self.center[k]) as f32)
    }

    /// Returns a length of the input in the unit frame.
    pub(crate) fn to_unit_length(self, length: f32) -> f32 {
        (f64::from(length) * self.scale) as f32
    }

    /// Returns the factor from prices, areas times squared distances, to the input's units.
    pub(crate) fn unit_of_prices(self) -> f64 {
        self.size.powi(4)
    }

    /// Returns a length of the unit frame in the input's units.
    pub(crate) fn to_input_length(self, length: f32) -> f32 {
        (f64::from(length) * self.size) as f32
    }
}
