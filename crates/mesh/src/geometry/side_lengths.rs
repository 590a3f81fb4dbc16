//! Measures of triangles given by side lengths.

/// Returns the area (Kahan's form of Heron's formula), or 0 if there is no such triangle.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::geometry::side_lengths::area([3.0, 4.0, 5.0]), 6.0);
/// ```
pub fn area([a, b, c]: [f64; 3]) -> f64 {
    let (low, high) = (a.min(b), a.max(b));
    let [x, y, z] = [high.max(c), low.max(high.min(c)), low.min(c)];
    let product = (x + (y + z)) * (z - (x - y)) * (z + (x - y)) * (x + (y - z));
    0.25 * product.max(0.0).sqrt()
}

/// Returns the cotangent of the angle opposite to side `a`.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// assert_eq!(neural_mesh::geometry::side_lengths::opposite_cotangent([5.0, 3.0, 4.0]), 0.0);
/// ```
pub fn opposite_cotangent([a, b, c]: [f64; 3]) -> f64 {
    (b * b + c * c - a * a) / (4.0 * area([a, b, c]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_of_known_triangles() {
        assert!((area([3.0, 4.0, 5.0]) - 6.0).abs() < 1e-15 && (area([5.0, 3.0, 4.0]) - 6.0).abs() < 1e-15);
        assert_eq!(area([1.0, 2.0, 4.0]), 0.0);
        assert!(opposite_cotangent([5.0, 3.0, 4.0]).abs() < 1e-15);
        assert!((opposite_cotangent([3.0, 4.0, 5.0]) - 4.0 / 3.0).abs() < 1e-15);
        assert!((opposite_cotangent([1.0; 3]) - 1.0 / 3f64.sqrt()).abs() < 1e-15);
    }
}
