//! Chamfer distance: the paper's CD (Sec. 4.1).

use glam::DVec3;

use crate::parallel;
use crate::spatial::nearest_to;

const CHUNK: usize = 512;

/// Mean squared distances between two point sets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Chamfer {
    /// Mean squared distance from the first set to the second.
    pub forward: f64,
    /// Mean squared distance from the second set to the first.
    pub backward: f64,
}

impl Chamfer {
    /// Returns `CD = forward + backward`.
    pub fn sum(&self) -> f64 {
        self.forward + self.backward
    }
}

/// Measures `CD = mean_a min_b |a - b|^2 + mean_b min_a |a - b|^2`; `None` if a set is empty.
///
/// Nearest points are found in single precision.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::metrics::chamfer;
/// let a = [[0.0; 3], [2.0, 0.0, 0.0]].map(glam::DVec3::from);
/// let b = [[0.0, 1.0, 0.0]].map(glam::DVec3::from);
/// let distance = chamfer(&a, &b).unwrap();
/// assert_eq!((distance.forward, distance.backward, distance.sum()), (3.0, 1.0, 4.0));
/// ```
pub fn chamfer(a: &[DVec3], b: &[DVec3]) -> Option<Chamfer> {
    if a.is_empty() || b.is_empty() {
        return None;
    }
    let [a_single, b_single] =
        [a, b].map(|points| points.iter().map(|p| p.as_vec3().to_array()).collect::<Vec<[f32; 3]>>());
    let forward = mean_squared_distance(a, b, &nearest_to(&b_single, &a_single, 1));
    let backward = mean_squared_distance(b, a, &nearest_to(&a_single, &b_single, 1));
    Some(Chamfer { forward, backward })
}

fn mean_squared_distance(from: &[DVec3], to: &[DVec3], nearest: &[u32]) -> f64 {
    let sums = parallel::chunks(from, CHUNK, |chunk, points| {
        let pairs = points.iter().zip(&nearest[chunk * CHUNK..]);
        pairs.map(|(p, &at)| p.distance_squared(to[at as usize])).sum::<f64>()
    });
    sums.iter().sum::<f64>() / from.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn naive(a: &[DVec3], b: &[DVec3]) -> f64 {
        let nearest = |p: &DVec3| b.iter().map(|q| p.distance_squared(*q)).fold(f64::INFINITY, f64::min);
        a.iter().map(nearest).sum::<f64>() / a.len() as f64
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn agrees_with_all_pairs(
            a in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 1..200),
            b in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 1..200),
        ) {
            let [a, b] = [a, b].map(|points| points.iter().map(|p| DVec3::from(p.map(f64::from))).collect::<Vec<_>>());
            let distance = chamfer(&a, &b).unwrap();
            prop_assert!((distance.forward - naive(&a, &b)).abs() < 1e-6);
            prop_assert!((distance.backward - naive(&b, &a)).abs() < 1e-6);
            prop_assert_eq!(chamfer(&b, &a).unwrap().forward, distance.backward);
            prop_assert_eq!(chamfer(&a, &a).unwrap().sum(), 0.0);
        }
    }

    #[test]
    fn a_missing_half_counts_from_the_side_that_has_it() {
        let line: Vec<DVec3> = (0..101).map(|i| DVec3::new(f64::from(i) / 100.0, 0.0, 0.0)).collect();
        let distance = chamfer(&line, &line[..51]).unwrap();
        // Fifty points at 0.01, 0.02, ... 0.5 from the end: the sum of their squares is 4.2925.
        assert!((distance.forward - 4.2925 / 101.0).abs() < 1e-9);
        assert_eq!(distance.backward, 0.0);
    }
}
