//! Triangles with side lengths only, glued along their sides.

// The half-edge `3 * face + side` starts at the corner `side` of its face.
#[derive(Clone, Debug, Default)]
pub struct GluedTriangles {
    pub start: Vec<u32>,
    pub twin: Vec<u32>,
    pub length: Vec<f64>,
}

impl GluedTriangles {
    pub fn ends(&self, half_edge: usize) -> [u32; 2] {
        [self.start[half_edge], self.start[next(half_edge)]]
    }

    pub fn sides(&self, half_edge: usize) -> [f64; 3] {
        let second = next(half_edge);
        [half_edge, second, next(second)].map(|side| self.length[side])
    }

    pub fn mean_length(&self) -> f64 {
        self.length.iter().sum::<f64>() / self.length.len().max(1) as f64
    }

    /// Lengthens all sides equally until every triangle inequality holds with a margin of `share` of the mean length
    /// (Sharp and Crane 2020, Sec. 4.5).
    pub fn mollify(&mut self, share: f64) {
        let least = share * self.mean_length();
        let missing = |half_edge: usize| {
            let [a, b, c] = self.sides(half_edge);
            least - (b + c - a)
        };
        let longer = (0..self.length.len()).map(missing).fold(0.0, f64::max);
        self.length.iter_mut().for_each(|length| *length += longer);
    }
}

pub fn next(half_edge: usize) -> usize {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::geometry::side_lengths::area;

    #[test]
    fn mollified_sides_make_triangles() {
        let length = vec![1.0, 1.0, 2.0, 0.0, 3.0, 3.0];
        let mut glued = GluedTriangles { start: vec![0, 1, 2, 0, 1, 3], twin: vec![], length };
        glued.mollify(1e-3);
        for face in 0..2 {
            assert!(area(glued.sides(3 * face)) > 0.0);
        }
        assert!((glued.length[0] - 1.0 - 1e-3 * 10.0 / 6.0).abs() < 1e-12);
    }
}
