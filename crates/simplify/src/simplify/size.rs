//! The size that is asked for.

use std::fmt;

/// Size of the result.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
pub enum Size {
    /// Share of the vertices that remain, the paper's N_s / N_org; above 0, at most 1.
    Ratio(f64),
    /// Number of vertices.
    Vertices(usize),
    /// Share of the faces that remain; above 0, at most 1.
    FaceRatio(f64),
    /// Number of faces.
    Faces(usize),
}

impl Size {
    /// Returns the share of the vertices or faces, if it is one.
    pub fn share(self) -> Option<f64> {
        if let Self::Ratio(share) | Self::FaceRatio(share) = self { Some(share) } else { None }
    }

    /// Returns whether the size is of faces; others are of vertices.
    pub fn is_of_faces(self) -> bool {
        matches!(self, Self::FaceRatio(_) | Self::Faces(_))
    }

    /// Returns the number for a mesh with `n` vertices or faces, of which the size is; at least 1 for shares.
    pub fn count(self, n: usize) -> usize {
        match self {
            Self::Ratio(share) | Self::FaceRatio(share) => count_of_share(n, share),
            Self::Vertices(number) | Self::Faces(number) => number,
        }
    }

    /// Returns the size as a number for a mesh of this size.
    pub fn to_number(self, n_vertices: usize, n_faces: usize) -> Self {
        if self.is_of_faces() { Self::Faces(self.count(n_faces)) } else { Self::Vertices(self.count(n_vertices)) }
    }

    /// Returns the share of the vertices or faces that remains of a mesh of this size.
    ///
    /// ```
    /// # use neural_mesh_simplify as neural_mesh;
    /// use neural_mesh::simplify::Size;
    /// assert_eq!([Size::Ratio(0.3), Size::Vertices(6), Size::Faces(5)].map(|it| it.share_of(12, 20)), [0.3, 0.5, 0.25]);
    /// ```
    pub fn share_of(self, n_vertices: usize, n_faces: usize) -> f64 {
        let divide = |n: usize, n_all: usize| n as f64 / n_all.max(1) as f64;
        match self {
            Self::Ratio(share) | Self::FaceRatio(share) => share,
            Self::Vertices(n) => divide(n, n_vertices),
            Self::Faces(n) => divide(n, n_faces),
        }
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ratio(share) | Self::FaceRatio(share) => write!(f, "{}%", percent(*share)),
            Self::Vertices(number) | Self::Faces(number) => write!(f, "{number}"),
        }
    }
}

/// Converts a share to percent, rounded to 12 decimals.
pub fn percent(share: f64) -> f64 {
    (share * 1e14).round() / 1e12
}

/// Returns a share of `n` as a number, rounded down so that no result is larger than its share; at least 1.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// assert_eq!([0.29, 0.999, 1e-9].map(|share| neural_mesh::simplify::count_of_share(100, share)), [29, 99, 1]);
/// ```
pub fn count_of_share(n: usize, share: f64) -> usize {
    // The factor is needed since 29 % of 100 is 28.999999999999996 in doubles.
    ((n as f64 * share * (1.0 + 1e-12)) as usize).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_many_is_the_number_that_people_mean() {
        let counts = [Size::Ratio(0.29).count(100), Size::FaceRatio(0.001).count(3), Size::Vertices(7).count(3)];
        assert_eq!(counts, [29, 1, 7]);
        assert_eq!([Size::Ratio(0.07).to_string(), Size::Faces(5).to_string()], ["7%", "5"]);
    }

    #[test]
    fn shares_of_faces_and_vertices_are_numbers_once_the_mesh_is_known() {
        assert_eq!(Size::FaceRatio(0.25).to_number(500, 1000), Size::Faces(250));
        assert_eq!(Size::Ratio(0.25).to_number(500, 1000), Size::Vertices(125));
        assert_eq!(
            [Size::Vertices(12), Size::Faces(9)].map(|it| it.to_number(500, 1000)),
            [Size::Vertices(12), Size::Faces(9)]
        );
    }
}
