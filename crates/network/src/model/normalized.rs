//! Normalised frame of training data.

/// Moves the mean of points to the origin and scales their bounding box to diagonal 1.
///
/// Coincident points become the origin.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::model::normalize_points;
/// let points = normalize_points(&[[10.0, 0.0, 0.0], [13.0, 4.0, 0.0]]);
/// assert_eq!(points, [[-0.3, -0.4, 0.0], [0.3, 0.4, 0.0]]);
/// ```
pub fn normalize_points(points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut sum = [0.0f64; 3];
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for (axis, &x) in point.iter().enumerate() {
            sum[axis] += f64::from(x);
            low[axis] = low[axis].min(f64::from(x));
            high[axis] = high[axis].max(f64::from(x));
        }
    }
    let diagonal = (0..3).map(|axis| (high[axis] - low[axis]).powi(2)).sum::<f64>().sqrt();
    let scale = if diagonal > 0.0 { 1.0 / diagonal } else { 0.0 };
    let mean = sum.map(|sum| sum / points.len() as f64);
    points.iter().map(|p| [0, 1, 2].map(|axis| ((f64::from(p[axis]) - mean[axis]) * scale) as f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_without_extent_become_the_origin() {
        assert_eq!(normalize_points(&[[7.0, 8.0, 9.0]; 3]), [[0.0; 3]; 3]);
        assert!(normalize_points(&[]).is_empty());
    }
}
