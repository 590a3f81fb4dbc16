//! Algebra of 3 x 3 matrices with derivatives.

use std::ops::{Add, AddAssign};

use glam::{DMat3, DVec3};

/// Quadratic form `x'Ax - 2 b'x`, smallest where `A x = b`; or a gradient with respect to A and b.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct QuadraticForm {
    pub a: DMat3,
    pub b: DVec3,
}

impl QuadraticForm {
    pub const ZERO: Self = Self { a: DMat3::ZERO, b: DVec3::ZERO };
}

impl Add for QuadraticForm {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b }
    }
}

impl AddAssign for QuadraticForm {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

pub(super) fn outer(x: DVec3, y: DVec3) -> DMat3 {
    DMat3::from_cols(x * y.x, x * y.y, x * y.z)
}

pub(super) fn trace(a: &DMat3) -> f64 {
    a.x_axis.x + a.y_axis.y + a.z_axis.z
}

pub(super) fn stiffen(a: &DMat3, weight: f64) -> DMat3 {
    *a + DMat3::IDENTITY * (weight * trace(a))
}

/// Solves `a x = b` for a positive definite `a`; else returns zero.
pub(super) fn solve(a: &DMat3, b: DVec3) -> DVec3 {
    // `L D L'`, since cofactors would lose the tiny eigenvalues of nearly flat regions.
    let d0 = a.x_axis.x;
    let (l10, l20) = (a.x_axis.y / d0, a.x_axis.z / d0);
    let d1 = a.y_axis.y - l10 * a.x_axis.y;
    let l21 = (a.y_axis.z - l20 * a.x_axis.y) / d1;
    let d2 = a.z_axis.z - l20 * a.x_axis.z - l21 * l21 * d1;
    let y1 = b.y - l10 * b.x;
    let z = (b.z - l20 * b.x - l21 * y1) / d2;
    let y = y1 / d1 - l21 * z;
    let x = b.x / d0 - l10 * y - l20 * z;
    let is_definite = d0 > 0.0 && d1 > 0.0 && d2 > 0.0;
    let solution = DVec3::new(x, y, z);
    if is_definite && solution.is_finite() { solution } else { DVec3::ZERO }
}

/// Converts a gradient by `x = solve(a, b)` to the gradient by `a` and `b`.
pub(super) fn solve_backward(a: &DMat3, x: DVec3, gradient: DVec3) -> QuadraticForm {
    let to_b = solve(a, gradient);
    QuadraticForm { a: (outer(to_b, x) + outer(x, to_b)) * -0.5, b: to_b }
}

pub(super) fn stiffen_backward(gradient: &DMat3, weight: f64) -> DMat3 {
    // The map is linear and symmetric, so it is its own adjoint.
    stiffen(gradient, weight)
}

/// Converts a gradient by the area normal `(b - a) x (c - a)` to gradients by the corners.
pub(super) fn area_normal_backward([a, b, c]: [DVec3; 3], gradient: DVec3) -> [DVec3; 3] {
    let to_b = (c - a).cross(gradient);
    let to_c = gradient.cross(b - a);
    [-to_b - to_c, to_b, to_c]
}

/// Converts a gradient by `v / |v|` to the gradient by `v`; zero at zero.
pub(super) fn unit_backward(v: DVec3, gradient: DVec3) -> DVec3 {
    let length = v.length();
    if length > 0.0 {
        let unit = v / length;
        (gradient - unit * unit.dot(gradient)) / length
    } else {
        DVec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::triangle::area_normal_f64;

    const A: DVec3 = DVec3::new(0.3, -1.0, 0.5);
    const B: DVec3 = DVec3::new(1.2, 0.4, -0.7);
    const C: DVec3 = DVec3::new(-0.2, 0.9, 1.1);
    const G: DVec3 = DVec3::new(0.7, -0.3, 0.2);

    fn assert_slope(x: DVec3, gradient: DVec3, loss: impl Fn(DVec3) -> f64) {
        let numeric = DVec3::from_array([0, 1, 2].map(|axis| {
            let step = DVec3::AXES[axis] * 1e-6;
            (loss(x + step) - loss(x - step)) / 2e-6
        }));
        assert!(numeric.distance(gradient) < 1e-8 * (1.0 + gradient.length()), "{numeric} {gradient}");
    }

    #[test]
    fn systems_are_solved_and_what_is_singular_gives_zero() {
        let a = outer(A, A) + outer(B, B) + outer(C, C);
        assert!((a * solve(&a, G)).distance(G) < 1e-12);
        let nearly_flat = stiffen(&outer(A, A), 1e-6);
        assert!((nearly_flat * solve(&nearly_flat, G)).distance(G) < 1e-9);
        assert_eq!(solve(&outer(A, A), G), DVec3::ZERO);
        assert_eq!(solve(&DMat3::ZERO, G), DVec3::ZERO);
    }

    #[test]
    fn derivatives_are_slopes() {
        assert_slope(B, area_normal_backward([A, B, C], G)[1], |b| area_normal_f64([A, b, C]).dot(G));
        assert_slope(C, area_normal_backward([A, B, C], G)[2], |c| area_normal_f64([A, B, c]).dot(G));
        assert_slope(A, area_normal_backward([A, B, C], G)[0], |a| area_normal_f64([a, B, C]).dot(G));
        assert_slope(A, unit_backward(A, G), |a| a.normalize().dot(G));
        let system = |v: DVec3| outer(v, v) + outer(B, B) + outer(C, C);
        let solved = |v: DVec3| solve(&system(v), B + v);
        let to = solve_backward(&system(A), solved(A), G);
        assert_slope(A, to.a * A * 2.0 + to.b, |a| solved(a).dot(G));
    }
}
