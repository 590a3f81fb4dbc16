//! Eigenvalues of symmetric 3 x 3 matrices.

/// Returns the ascending eigenvalues of the symmetric matrix with upper triangle xx, xy, xz, yy, yz, zz.
///
/// Uses the cosine form of the cubic's roots (Smith 1961).
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::geometry::eigenvalues;
/// assert_eq!(eigenvalues([3.0, 0.0, 0.0, -1.0, 0.0, 2.0]), [-1.0, 2.0, 3.0]);
/// let found = eigenvalues([2.0, 1.0, 0.0, 2.0, 0.0, 5.0]);
/// assert!(found.iter().zip([1.0, 3.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-12));
/// ```
pub fn eigenvalues([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> [f64; 3] {
    let beside = xy * xy + xz * xz + yz * yz;
    if beside == 0.0 {
        return sort_ascending([xx, yy, zz]);
    }
    let mean = (xx + yy + zz) / 3.0;
    let (x, y, z) = (xx - mean, yy - mean, zz - mean);
    let spread = ((x * x + y * y + z * z + 2.0 * beside) / 6.0).sqrt();
    let determinant = x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz);
    let cosine = (determinant / (2.0 * spread * spread * spread)).clamp(-1.0, 1.0);
    let angle = cosine.acos() / 3.0;
    let largest = mean + 2.0 * spread * angle.cos();
    let smallest = mean + 2.0 * spread * (angle + std::f64::consts::TAU / 3.0).cos();
    sort_ascending([smallest, 3.0 * mean - largest - smallest, largest])
}

fn sort_ascending(mut values: [f64; 3]) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DQuat, DVec3};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_turned_diagonal_keeps_its_eigenvalues(
            diagonal in prop::array::uniform3(prop_oneof![-2.0f64..2.0, Just(1.0), Just(0.0), Just(1e-9)]),
            turn in prop::array::uniform4(0.1f64..1.0),
            scale in prop_oneof![Just(1e-12f64), Just(1.0), Just(1e12)],
        ) {
            let turn = DMat3::from_quat(DQuat::from_array(turn).normalize());
            let m = turn * DMat3::from_diagonal(DVec3::from_array(diagonal) * scale) * turn.transpose();
            let found = eigenvalues([m.x_axis.x, m.y_axis.x, m.z_axis.x, m.y_axis.y, m.z_axis.y, m.z_axis.z]);
            for (a, b) in found.iter().zip(sort_ascending(diagonal)) {
                prop_assert!((a - b * scale).abs() <= 1e-7 * scale, "{found:?} {diagonal:?}");
            }
        }
    }

    #[test]
    fn zero_and_equal_values_are_fine() {
        assert_eq!(eigenvalues([0.0; 6]), [0.0; 3]);
        assert_eq!(eigenvalues([2.0, 0.0, 0.0, 2.0, 0.0, 2.0]), [2.0; 3]);
    }
}
