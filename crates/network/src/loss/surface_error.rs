//! Training loss of the closed assembly: logarithms of mean distance, normal error and largest distance.

use crate::geometry::triangle::area_normal;
use crate::parallel;
use crate::spatial::NearestOnTriangles;
use glam::{DVec3, Vec3};

/// Exponent of the norm that approximates the largest distance.
const PEAK: i32 = 8;

/// Distances and normal errors of a result at points of the original surface.
#[derive(Clone, Debug, PartialEq)]
pub struct PointErrors {
    /// Area represented by each point, n_points.
    pub areas: Vec<f32>,
    /// Distance to the result, n_points.
    pub distances: Vec<f32>,
    /// `1 - n.n'` of the unit normals of the original and of the closest face, n_points; 0 to 2.
    pub turns: Vec<f32>,
}

/// Measures the errors at the barycenters of the original's triangles.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::point_errors;
/// let triangle_at_height = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
/// let errors = point_errors(&[triangle_at_height(0.0)], &[triangle_at_height(0.25)]);
/// assert_eq!((errors.areas, errors.distances, errors.turns), (vec![0.5], vec![0.25], vec![0.0]));
/// ```
pub fn point_errors(original: &[[[f32; 3]; 3]], result: &[[[f32; 3]; 3]]) -> PointErrors {
    let normal = |corners: &[[f32; 3]; 3]| area_normal(corners.map(Vec3::from));
    let normals: Vec<Vec3> = result.iter().map(|corners| normal(corners).normalize_or_zero()).collect();
    let nearest = NearestOnTriangles::new(result);
    let measure_triangle = |t: usize| {
        let corners = &original[t];
        let own = normal(corners);
        let place: DVec3 = corners.iter().map(|p| Vec3::from(*p).as_dvec3() / 3.0).sum();
        let (distance, turn) = nearest.nearest(place).map_or((0.0, 0.0), |hit| {
            let cosine = own.normalize_or_zero().dot(normals[hit.triangle as usize]);
            (hit.distance2.sqrt() as f32, 1.0 - cosine)
        });
        (0.5 * own.length(), distance, turn)
    };
    let all = parallel::map(original.len(), 64, measure_triangle);
    PointErrors {
        areas: all.iter().map(|x| x.0).collect(),
        distances: all.iter().map(|x| x.1).collect(),
        turns: all.iter().map(|x| x.2).collect(),
    }
}

/// Sums over the points: area, area-weighted distance and normal error, and powers of the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorSums {
    area: f64,
    distance: f64,
    turn: f64,
    peak: f64,
    /// Largest distance, by which distances are divided before the power is taken.
    unit: f64,
}

/// Averages the sums of two results; tiny errors replace zeros, so that logarithms exist.
pub fn error_sums(errors: [&PointErrors; 2]) -> ErrorSums {
    let unit = errors.iter().flat_map(|e| &e.distances).fold(f32::MIN_POSITIVE, |a, &b| a.max(b));
    let mut sums = ErrorSums { area: 0.0, distance: 0.0, turn: 0.0, peak: 0.0, unit: f64::from(unit) };
    for errors in errors {
        for ((&area, &distance), &turn) in errors.areas.iter().zip(&errors.distances).zip(&errors.turns) {
            let (area, distance, turn) = (f64::from(area), f64::from(distance), f64::from(turn));
            sums.area += 0.5 * area;
            sums.distance += 0.5 * area * distance;
            sums.turn += 0.5 * area * turn;
            sums.peak += 0.5 * (distance / sums.unit).powi(PEAK);
        }
    }
    sums.area = sums.area.max(f64::MIN_POSITIVE);
    sums.distance = sums.distance.max(1e-12 * sums.area * sums.unit);
    sums.turn = sums.turn.max(1e-12 * sums.area);
    sums.peak = sums.peak.max(1e-12);
    sums
}

/// Returns the logarithms of the mean distance, the mean normal error and the 8-norm of the distances.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::{PointErrors, error_sums, log_errors};
/// let one = PointErrors { areas: vec![2.0], distances: vec![0.5], turns: vec![1.0] };
/// let [distance, turn, peak] = log_errors(&error_sums([&one, &one]));
/// assert!((distance - 0.5_f64.ln()).abs() < 1e-12 && turn == 0.0 && (peak - 0.5_f64.ln()).abs() < 1e-12);
/// ```
pub fn log_errors(sums: &ErrorSums) -> [f64; 3] {
    let peak = sums.unit.ln() + sums.peak.ln() / f64::from(PEAK);
    [(sums.distance / sums.area).ln(), (sums.turn / sums.area).ln(), peak]
}

/// Computes each point's share in the sum of the three logarithms, linearised at `sums`.
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::{PointErrors, error_sums, log_errors, error_shares};
/// let errors = |d: f32| PointErrors { areas: vec![1.0, 1.0], distances: vec![0.5, d], turns: vec![0.1, d] };
/// let [a, b] = [errors(0.4), errors(0.41)];
/// let sums = error_sums([&a, &b]);
/// let loss = |e: &PointErrors| log_errors(&error_sums([e, e])).iter().sum::<f64>();
/// let difference = error_shares(&b, &sums)[1] - error_shares(&a, &sums)[1];
/// assert!((difference - (loss(&b) - loss(&a))).abs() < 1e-3 * difference);
/// ```
pub fn error_shares(errors: &PointErrors, sums: &ErrorSums) -> Vec<f64> {
    let part = |((&area, &distance), &turn): ((&f32, &f32), &f32)| {
        let (area, distance, turn) = (f64::from(area), f64::from(distance), f64::from(turn));
        let peak = (distance / sums.unit).powi(PEAK) / (f64::from(PEAK) * sums.peak);
        area * distance / sums.distance + area * turn / sums.turn + peak
    };
    errors.areas.iter().zip(&errors.distances).zip(&errors.turns).map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_perfect_result_has_finite_logarithms() {
        let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let errors = point_errors(&[triangle], &[triangle]);
        let sums = error_sums([&errors, &errors]);
        assert!(log_errors(&sums).iter().all(|x| x.is_finite()));
        assert!(error_shares(&errors, &sums).iter().all(|x| x.is_finite()));
        let none = point_errors(&[triangle], &[]);
        assert!(log_errors(&error_sums([&none, &none])).iter().all(|x| x.is_finite()));
    }

    #[test]
    fn shares_are_the_slopes_of_the_logarithms() {
        let change_errors = |k: usize, d: f32, turn: f32| {
            let mut errors =
                PointErrors { areas: vec![0.5, 1.0, 2.0], distances: vec![0.3, 0.5, 0.4], turns: vec![0.2, 0.1, 0.4] };
            errors.distances[k] += d;
            errors.turns[k] += turn;
            errors
        };
        let loss = |errors: &PointErrors| log_errors(&error_sums([errors, errors])).iter().sum::<f64>();
        for k in 0..3 {
            for (d, turn) in [(1e-3, 0.0), (0.0, 1e-3)] {
                let [up, down] = [change_errors(k, d, turn), change_errors(k, -d, -turn)];
                let sums = error_sums([&up, &down]);
                let found = error_shares(&up, &sums)[k] - error_shares(&down, &sums)[k];
                let difference = loss(&up) - loss(&down);
                assert!((found - difference).abs() < 1e-3 * difference, "{k}: {found} {difference}");
            }
        }
    }

    #[test]
    fn the_peak_follows_the_largest_distance() {
        let errors = |d: f32| PointErrors {
            areas: vec![1.0; 100],
            distances: [vec![0.1; 99], vec![d]].concat(),
            turns: vec![0.1; 100],
        };
        let peak = |d: f32| log_errors(&error_sums([&errors(d), &errors(d)]))[2];
        assert!((peak(1.0) - peak(0.5) - 2.0f64.ln()).abs() < 0.01);
    }
}
