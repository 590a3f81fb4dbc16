//! The quadric error of Garland and Heckbert (1997): weighted squared distance to a set of planes.

use glam::DVec3;

/// A quadratic form `x -> x'Ax + 2 b'x + c`, the weighted sum of squared distances to planes and points.
///
/// `a` holds the upper triangle of the symmetric 3 x 3 matrix as xx, xy, xz, yy, yz, zz.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quadric {
    /// Upper triangle of A: xx, xy, xz, yy, yz, zz.
    pub a: [f64; 6],
    /// The linear part b.
    pub b: DVec3,
    /// The constant part c.
    pub c: f64,
}
