//! A point with its geodesic neighbours and their logarithmic map.

/// A point of a cloud, some points around it, and where the logarithmic map at the point puts them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// Indices of points; the first is the patch's own.
    pub points: Vec<u32>,
    /// Where each lies in the plane: its distance along the surface from the origin, in the direction in which it is left.
    /// The own point lies at the origin, or near it where a network says so.
    pub map: Vec<[f64; 2]>,
}

impl Patch {
    /// How far the farthest point of the map lies from the origin.
    pub fn radius(&self) -> f64 {
        self.map.iter().map(|at| at[0].hypot(at[1])).fold(0.0, f64::max)
    }
}
