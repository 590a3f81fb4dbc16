//! Goals: sizes, distances, bytes, levels of detail.

use std::fmt;

use crate::simplify::{Target, count_of_share};

/// Goal of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// Target of the simplifier's options.
    Target,
    /// Share of the faces, above 0 and at most 1.
    ShareOfFaces(f64),
    /// Largest distance from the original.
    Error(Bound),
    /// Largest size of the file in bytes.
    Size(usize),
    /// Levels of detail, each no larger than the one before.
    Levels(Vec<LevelSize>),
    /// Levels of detail by rising distances from the original.
    ErrorLevels(Vec<Bound>),
}

impl Goal {
    /// Returns whether the goal is an upper bound of distance or bytes.
    pub fn is_bound(&self) -> bool {
        matches!(self, Self::Error(_) | Self::Size(_) | Self::ErrorLevels(_))
    }

    /// Returns the number of levels of detail, if there are any.
    pub fn n_levels(&self) -> Option<usize> {
        match self {
            Self::Levels(sizes) => Some(sizes.len()),
            Self::ErrorLevels(bounds) => Some(bounds.len()),
            _ => None,
        }
    }
}

/// Number of vertices or faces, absolute or relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Count {
    /// Absolute number.
    Number(usize),
    /// Share, above 0 and at most 1.
    Share(f64),
}

impl Count {
    /// Returns the number for a total of `n`, at least 1.
    pub fn resolve(self, n: usize) -> usize {
        match self {
            Self::Number(number) => number,
            Self::Share(share) => count_of_share(n, share),
        }
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Share(share) => write!(f, "{}%", percent(*share)),
        }
    }
}

/// Converts a share to percent, rounded to 12 decimals.
pub fn percent(share: f64) -> f64 {
    (share * 1e14).round() / 1e12
}

/// Size of a level of detail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelSize {
    /// Number or share of the vertices.
    Vertices(Count),
    /// Number or share of the faces.
    Faces(Count),
}

impl LevelSize {
    /// Returns the target for a mesh with `n_faces` faces.
    pub fn target(self, n_faces: usize) -> Target {
        match self {
            Self::Vertices(Count::Share(ratio)) => Target::Ratio(ratio),
            Self::Vertices(Count::Number(n)) => Target::Vertices(n),
            Self::Faces(count) => Target::Faces(count.resolve(n_faces)),
        }
    }

    /// Returns the number or share.
    pub fn count(self) -> Count {
        match self {
            Self::Vertices(count) | Self::Faces(count) => count,
        }
    }
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

    #[test]
    fn shares_of_faces_are_numbers_once_the_mesh_is_known() {
        assert_eq!(LevelSize::Faces(Count::Share(0.25)).target(1000), Target::Faces(250));
        assert_eq!(LevelSize::Vertices(Count::Share(0.25)).target(1000), Target::Ratio(0.25));
        assert_eq!(LevelSize::Vertices(Count::Number(12)).target(1000), Target::Vertices(12));
    }

    #[test]
    fn a_share_of_many_is_the_number_that_people_mean() {
        assert_eq!(
            [Count::Share(0.29).resolve(100), Count::Share(0.001).resolve(3), Count::Number(7).resolve(3)],
            [29, 1, 7]
        );
        assert_eq!([Count::Share(0.07).to_string(), Count::Number(5).to_string()], ["7%", "5"]);
    }

    #[test]
    fn a_distance_in_percent_is_one_of_the_diagonal() {
        assert_eq!([Bound::Percent(5.0).to_absolute(4.0), Bound::Absolute(5.0).to_absolute(4.0)], [0.2, 5.0]);
    }
}
