//! A point's neighbours and their logarithmic map.

/// A point of a cloud, its geodesic neighbours and their logarithmic map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// Indices of points, the patch's own first.
    pub points: Vec<u32>,
    /// Positions in the plane: geodesic distance and initial direction.
    pub map: Vec<[f64; 2]>,
}

impl Patch {
    /// Returns the largest distance from the origin.
    pub fn radius(&self) -> f64 {
        self.map.iter().map(|at| at[0].hypot(at[1])).fold(0.0, f64::max)
    }
}
