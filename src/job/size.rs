//! Sizes: shares, numbers, distances, bytes; goals of one or several.

use std::fmt;

use crate::simplify::{Target, count_of_share};

/// Requested size of a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// Share of the vertices, above 0 and at most 1.
    Ratio(f64),
    /// Number of vertices.
    Vertices(usize),
    /// Share of the faces, above 0 and at most 1.
    FaceRatio(f64),
    /// Number of faces.
    Faces(usize),
    /// Largest distance from the original.
    Error(Bound),
    /// Largest size of the file in bytes.
    Bytes(usize),
}

impl Size {
    /// Returns the target for a mesh with `n_faces` faces; all vertices if only a search finds it.
    pub fn target(self, n_faces: usize) -> Target {
        match self {
            Self::Ratio(ratio) => Target::Ratio(ratio),
            Self::Vertices(n) => Target::Vertices(n),
            Self::FaceRatio(ratio) => Target::Faces(count_of_share(n_faces, ratio)),
            Self::Faces(n) => Target::Faces(n),
            Self::Error(_) | Self::Bytes(_) => Target::Ratio(1.0),
        }
    }

    /// Returns the share of the vertices or faces, if it is one.
    pub fn share(self) -> Option<f64> {
        if let Self::Ratio(share) | Self::FaceRatio(share) = self { Some(share) } else { None }
    }

    /// Returns the number of vertices or faces for a mesh with `n` of them, at least 1; all for other sizes.
    pub fn count(self, n: usize) -> usize {
        match self {
            Self::Ratio(share) | Self::FaceRatio(share) => count_of_share(n, share),
            Self::Vertices(number) | Self::Faces(number) => number,
            Self::Error(_) | Self::Bytes(_) => n,
        }
    }

    /// Returns the distance, if it is one.
    pub fn bound(self) -> Option<Bound> {
        if let Self::Error(bound) = self { Some(bound) } else { None }
    }

    /// Returns whether the size is of vertices.
    pub fn is_of_vertices(self) -> bool {
        matches!(self, Self::Ratio(_) | Self::Vertices(_))
    }

    /// Returns whether the size is of faces.
    pub fn is_of_faces(self) -> bool {
        matches!(self, Self::FaceRatio(_) | Self::Faces(_))
    }
}

impl From<Target> for Size {
    fn from(target: Target) -> Self {
        match target {
            Target::Ratio(ratio) => Self::Ratio(ratio),
            Target::Vertices(n) => Self::Vertices(n),
            Target::Faces(n) => Self::Faces(n),
        }
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ratio(share) | Self::FaceRatio(share) => write!(f, "{}%", percent(*share)),
            Self::Vertices(number) | Self::Faces(number) | Self::Bytes(number) => write!(f, "{number}"),
            Self::Error(bound) => write!(f, "{bound}"),
        }
    }
}

/// Goal of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// One result.
    One(Size),
    /// Levels of detail: sizes of vertices or faces, each no larger than the one before, or rising distances.
    Levels(Vec<Size>),
}

impl Goal {
    /// Returns the sizes, one for each result.
    pub fn sizes(&self) -> &[Size] {
        match self {
            Self::One(size) => std::slice::from_ref(size),
            Self::Levels(sizes) => sizes,
        }
    }

    /// Returns the distances that results keep; empty for goals of other kinds.
    pub fn bounds(&self) -> Vec<Bound> {
        self.sizes().iter().filter_map(|size| size.bound()).collect()
    }

    /// Returns whether the goal is an upper bound of distance or bytes.
    pub fn is_bound(&self) -> bool {
        self.sizes().iter().any(|size| matches!(size, Size::Error(_) | Size::Bytes(_)))
    }

    /// Returns whether results keep distances.
    pub fn is_by_error(&self) -> bool {
        self.sizes().iter().any(|size| size.bound().is_some())
    }

    /// Returns the largest size of the file in bytes, if that is the goal.
    pub fn n_bytes(&self) -> Option<usize> {
        if let Self::One(Size::Bytes(n_bytes)) = *self { Some(n_bytes) } else { None }
    }

    /// Returns the number of levels of detail, if there are any.
    pub fn n_levels(&self) -> Option<usize> {
        if let Self::Levels(sizes) = self { Some(sizes.len()) } else { None }
    }
}

/// Converts a share to percent, rounded to 12 decimals.
pub fn percent(share: f64) -> f64 {
    (share * 1e14).round() / 1e12
}

/// Distance, absolute or relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// In the unit of the mesh.
    Absolute(f64),
    /// In percent of the bounding box diagonal.
    Percent(f64),
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absolute(distance) => write!(f, "{distance}"),
            Self::Percent(percent) => write!(f, "{percent}%"),
        }
    }
}

impl Bound {
    /// Returns whether the distance is at most another of the same kind.
    pub(super) fn is_at_most(self, other: Self) -> bool {
        match (self, other) {
            (Self::Percent(one), Self::Percent(other)) | (Self::Absolute(one), Self::Absolute(other)) => one <= other,
            _ => false,
        }
    }

    /// Converts to the unit of a mesh with this diagonal.
    pub fn to_absolute(self, diagonal: f64) -> f64 {
        match self {
            Self::Absolute(distance) => distance,
            Self::Percent(percent) => 0.01 * percent * diagonal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::share;

    #[test]
    fn shares_of_faces_are_numbers_once_the_mesh_is_known() {
        assert_eq!(Size::FaceRatio(0.25).target(1000), Target::Faces(250));
        assert_eq!(Size::Ratio(0.25).target(1000), Target::Ratio(0.25));
        assert_eq!(Size::Vertices(12).target(1000), Target::Vertices(12));
    }

    #[test]
    fn a_share_of_many_is_the_number_that_people_mean() {
        let counts = [Size::Ratio(0.29).count(100), Size::FaceRatio(0.001).count(3), Size::Vertices(7).count(3)];
        assert_eq!(counts, [29, 1, 7]);
        assert_eq!([Size::Ratio(0.07).to_string(), Size::Faces(5).to_string()], ["7%", "5"]);
    }

    #[test]
    fn whole_and_tenth_percents_of_every_count_are_rounded_down_and_never_below_one() {
        for n in 1..=1000 {
            for tenths in 1..=1000 {
                let Ok(share) = share(&format!("{}%", f64::from(tenths) / 10.0)) else { panic!("{tenths}") };
                let exact = (n * tenths as usize / 1000).max(1);
                assert_eq!(Size::Ratio(share).count(n), exact, "{tenths} tenths of a percent of {n}");
            }
        }
    }

    #[test]
    fn a_distance_in_percent_is_one_of_the_diagonal() {
        assert_eq!([Bound::Percent(5.0).to_absolute(4.0), Bound::Absolute(5.0).to_absolute(4.0)], [0.2, 5.0]);
    }
}
