//! The quadric error of Garland and Heckbert (1997).

use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

use glam::{DVec3, Vec3};

/// A quadratic form `x -> x'Ax - 2 b'x + c` that sums weighted squared distances to planes and points.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::geometry::Quadric;
/// let ground = Quadric::with_minimum([0.0, 0.0, 0.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0].into());
/// assert_eq!(ground.value([5.0, 5.0, 4.0].into()), 2.0 * 3.0 * 3.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quadric {
    /// Upper triangle of A: xx, xy, xz, yy, yz, zz.
    pub a: [f64; 6],
    /// The vector b.
    pub b: DVec3,
    /// The constant c.
    pub c: f64,
}

impl Quadric {
    /// Ratio of determinant to cubed trace below which A is singular.
    pub const SINGULAR: f64 = 1e-11;

    /// Makes the form `(x - p)' A (x - p)` with A's upper triangle `a`.
    pub fn with_minimum(a: [f32; 6], p: Vec3) -> Self {
        let a = a.map(f64::from);
        let p = p.as_dvec3();
        let b = times(&a, p);
        Self { a, b, c: b.dot(p) }
    }

    /// Makes the squared distance to a plane through `p`, times `weight`.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::geometry::Quadric;
    /// let ground = Quadric::from_plane([0.0, 0.0, 1.0].into(), [7.0, 0.0, 1.0].into(), 2.0);
    /// assert_eq!(ground.value([5.0, 5.0, 4.0].into()), 2.0 * 3.0 * 3.0);
    /// ```
    pub fn from_plane(normal: DVec3, p: DVec3, weight: f64) -> Self {
        let DVec3 { x, y, z } = normal;
        let a = [x * x, x * y, x * z, y * y, y * z, z * z].map(|entry| weight * entry);
        let height = normal.dot(p);
        Self { a, b: normal * (weight * height), c: weight * height * height }
    }

    /// Returns the value at `x`, at least 0.
    pub fn value(&self, x: DVec3) -> f64 {
        (times(&self.a, x).dot(x) - 2.0 * self.b.dot(x) + self.c).max(0.0)
    }

    /// Returns the form in coordinates whose origin is `origin`.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::geometry::Quadric;
    /// let ground = Quadric::with_minimum([0.0, 0.0, 0.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0].into());
    /// assert_eq!(ground.with_origin([7.0, 0.0, 3.0].into()).value([5.0, 5.0, 1.0].into()), 2.0 * 3.0 * 3.0);
    /// ```
    #[inline]
    pub fn with_origin(&self, origin: DVec3) -> Self {
        let there = times(&self.a, origin);
        Self { a: self.a, b: self.b - there, c: self.c + (there - self.b * 2.0).dot(origin) }
    }

    /// Returns A's trace: the total weight of the planes.
    #[inline]
    pub fn trace(&self) -> f64 {
        self.a[0] + self.a[3] + self.a[5]
    }

    /// Adds the squared distance to `p`, times `weight`.
    pub fn with_point(mut self, p: DVec3, weight: f64) -> Self {
        [0, 3, 5].into_iter().for_each(|diagonal| self.a[diagonal] += weight);
        self.b += p * weight;
        self.c += p.length_squared() * weight;
        self
    }

    /// Returns the minimiser and its value; `None` if A is singular.
    #[inline]
    pub fn minimum(&self) -> Option<(DVec3, f64)> {
        let (adjugate, determinant) = self.adjugate()?;
        let x = times(&adjugate, self.b) / determinant;
        Some((x, (self.c - self.b.dot(x)).max(0.0)))
    }

    /// Returns `d'Ad`, half the second derivative along `d`.
    #[inline]
    pub fn curvature(&self, d: DVec3) -> f64 {
        times(&self.a, d).dot(d)
    }

    /// Returns the upper triangle of A's inverse; `None` if A is singular.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::geometry::Quadric;
    /// let corner = Quadric::with_minimum([2.0, 0.0, 0.0, 4.0, 0.0, 8.0], [0.0, 0.0, 1.0].into());
    /// assert_eq!(corner.inverse(), Some([0.5, 0.0, 0.0, 0.25, 0.0, 0.125]));
    /// ```
    pub fn inverse(&self) -> Option<[f64; 6]> {
        self.adjugate().map(|(adjugate, determinant)| adjugate.map(|x| x / determinant))
    }

    #[inline]
    fn adjugate(&self) -> Option<([f64; 6], f64)> {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        let (c0, c1, c2) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
        let determinant = xx * c0 + xy * c1 + xz * c2;
        let scale = self.trace();
        if determinant <= Self::SINGULAR * scale * scale * scale {
            return None;
        }
        Some(([c0, c1, c2, xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy], determinant))
    }
}

#[inline]
fn times(a: &[f64; 6], x: DVec3) -> DVec3 {
    DVec3::new(
        a[0] * x.x + a[1] * x.y + a[2] * x.z,
        a[1] * x.x + a[3] * x.y + a[4] * x.z,
        a[2] * x.x + a[4] * x.y + a[5] * x.z,
    )
}

impl Add for Quadric {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { a: std::array::from_fn(|i| self.a[i] + other.a[i]), b: self.b + other.b, c: self.c + other.c }
    }
}

impl Sub for Quadric {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { a: std::array::from_fn(|i| self.a[i] - other.a[i]), b: self.b - other.b, c: self.c - other.c }
    }
}

impl Mul<f64> for Quadric {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self { a: self.a.map(|entry| entry * factor), b: self.b * factor, c: self.c * factor }
    }
}

impl AddAssign for Quadric {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Quadric {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_planes_meet_at_the_minimum() {
        let corner = Vec3::new(0.3, -0.2, 0.7);
        let planes = [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.5]];
        let on_plane = [Vec3::Y, Vec3::Z, Vec3::X].map(|along| corner + 3.0 * along);
        let sum =
            planes.into_iter().zip(on_plane).fold(Quadric::default(), |q, (a, p)| q + Quadric::with_minimum(a, p));
        let (x, value) = sum.minimum().unwrap();
        assert!(x.distance(corner.as_dvec3()) < 1e-6, "{x}");
        assert!(value < 1e-12);
        assert!((sum.value(x + DVec3::Y) - 2.0).abs() < 1e-6);
    }

    #[test]
    fn a_single_plane_has_no_single_minimum() {
        assert!(Quadric::with_minimum([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], Vec3::ONE).minimum().is_none());
    }
}
