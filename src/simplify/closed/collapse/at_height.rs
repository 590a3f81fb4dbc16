//! Placement of merged vertices on the mirror plane.

use glam::{DMat2, DVec2, DVec3};

use super::pair::{MergedVertex, Pair, Placement};

/// Least determinant over the squared trace; a smaller one is rounding of single precision.
// 1e-10 and 1e-6 change no mirrored result.
const LEAST_DETERMINANT: f64 = 1e-8;

impl Pair {
    pub fn placement_at(&self, axis: usize, height: f64) -> MergedVertex {
        match self.minimum_at(axis, height).filter(|(x, _)| self.is_within_reach(*x)) {
            Some((offset, price)) => MergedVertex { place: Placement::Minimum, offset, price },
            None => self.best_at(axis, height),
        }
    }

    fn minimum_at(&self, axis: usize, height: f64) -> Option<(DVec3, f64)> {
        let [xx, xy, xz, yy, yz, zz] = self.sum.a;
        let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        // With one coordinate fixed, a 2 x 2 system remains.
        let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        let a = DMat2::from_cols_array_2d(&[[rows[i][i], rows[i][j]], [rows[i][j], rows[j][j]]]);
        let scale = rows[i][i] + rows[j][j];
        if a.determinant() <= LEAST_DETERMINANT * scale * scale {
            return None;
        }
        let slope = DVec2::new(rows[i][axis], rows[j][axis]) * height;
        let place = a.inverse() * (DVec2::new(self.sum.b[i], self.sum.b[j]) - slope);
        let mut x = DVec3::ZERO;
        (x[axis], x[i], x[j]) = (height, place.x, place.y);
        Some((x, self.sum.value(x)))
    }

    fn best_at(&self, axis: usize, height: f64) -> MergedVertex {
        let places = [Placement::KeptEnd, Placement::RemovedEnd, Placement::Middle].map(|place| self.place_at(place));
        let fit = places.into_iter().filter(|merged| merged.offset[axis] == height);
        fit.min_by(|x, y| x.price.total_cmp(&y.price)).unwrap_or(places[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Quadric;

    #[test]
    fn the_minimum_at_a_height_is_the_lowest_value_there() {
        let planes = [([1.0, 0.2, 0.3], 1.0), ([0.1, 1.0, -0.4], 2.0), ([0.3, -0.2, 1.0], 0.5)];
        let of =
            |(n, w): ([f64; 3], f64)| Quadric::from_plane(DVec3::from(n).normalize(), DVec3::new(0.2, 0.1, 0.3), w);
        let sum = planes.into_iter().map(of).fold(Quadric::default(), |x, y| x + y);
        let pair = Pair::from_sum(sum, DVec3::new(0.0, 1.0, 0.0));
        let MergedVertex { place, offset: x, price } = pair.placement_at(0, 0.0);
        assert_eq!((place, x.x), (Placement::Minimum, 0.0));
        for step in [[0.0, 1e-3, 0.0], [0.0, -1e-3, 0.0], [0.0, 0.0, 1e-3], [0.0, 0.0, -1e-3]] {
            assert!(sum.value(x + DVec3::from(step)) > price);
        }
    }

    #[test]
    fn without_a_minimum_an_end_on_the_plane_is_chosen() {
        let pair = Pair::from_sum(Quadric::default(), DVec3::new(0.5, 1.0, 0.0));
        assert_eq!(pair.placement_at(0, 0.0).place, Placement::KeptEnd);
        assert_eq!(pair.placement_at(0, 0.5).place, Placement::RemovedEnd);
    }
}
