//! Triangles with side lengths only, glued along their sides.

/// Triangles glued along their sides; half-edge `3 * face + side` runs from one corner to the next.
#[derive(Clone, Debug, Default)]
pub struct GluedTriangles {
    /// Start vertex of each half-edge, 3 n_faces.
    pub start: Vec<u32>,
    /// Opposite half-edge of the neighbour, 3 n_faces.
    pub twin: Vec<u32>,
    /// Length of each half-edge, 3 n_faces.
    pub length: Vec<f64>,
}

impl GluedTriangles {
    /// Returns the start and end of a half-edge.
    pub fn ends(&self, half_edge: usize) -> [u32; 2] {
        [self.start[half_edge], self.start[next(half_edge)]]
    }

    /// Returns the lengths of a half-edge and of the next two around its face.
    pub fn sides(&self, half_edge: usize) -> [f64; 3] {
        let second = next(half_edge);
        [half_edge, second, next(second)].map(|side| self.length[side])
    }

    /// Returns the mean side length; 0 without faces.
    pub fn mean_length(&self) -> f64 {
        self.length.iter().sum::<f64>() / self.length.len().max(1) as f64
    }

    /// Lengthens all sides until every triangle inequality holds by `share` of the mean length (Sharp and Crane 2020,
    /// Sec. 4.5).
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

/// Returns the next half-edge around the face.
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
