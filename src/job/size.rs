//! What a result has to meet: sizes, distances, bytes, levels of detail.

use std::fmt;

use crate::simplify::Target;

/// What a result has to meet.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// The target of the options.
    Target,
    /// A share of the faces.
    ShareOfFaces(f64),
    /// A largest distance from the original.
    Error(Bound),
    /// A number of bytes.
    Size(usize),
    /// Levels of detail, each no larger than the one before.
    Levels(Vec<LevelSize>),
    /// Levels of detail by largest distances from the original, which rise.
    ErrorLevels(Vec<Bound>),
}

impl Goal {
    /// Whether it bounds the result, as a number of vertices or faces does not.
    pub fn is_bound(&self) -> bool {
        matches!(self, Self::Error(_) | Self::Size(_) | Self::ErrorLevels(_))
    }

    /// How many levels of detail there are to be, where there are.
    pub fn n_levels(&self) -> Option<usize> {
        match self {
            Self::Levels(sizes) => Some(sizes.len()),
            Self::ErrorLevels(bounds) => Some(bounds.len()),
            _ => None,
        }
    }
}

/// How many vertices or faces stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Count {
    /// So many.
    Number(usize),
    /// So many of those there are, above 0 and at most 1.
    Share(f64),
}

impl Count {
    /// The number where there are `n`; at least 1.
    pub fn of(self, n: usize) -> usize {
        match self {
            Self::Number(number) => number,
            // 29 % of 100 are 29, and 28.999999999999996 in doubles.
            Self::Share(share) => ((n as f64 * share * (1.0 + 1e-12)) as usize).max(1),
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

/// A share in percent, without the noise of doubles.
pub fn percent(share: f64) -> f64 {
    (share * 1e14).round() / 1e12
}

/// The size of a level of detail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelSize {
    /// A number of vertices, or a share of them.
    Vertices(Count),
    /// A number of faces, or a share of them.
    Faces(Count),
}

impl LevelSize {
    /// Returns the target for a mesh of so many faces.
    pub fn target(self, n_faces: usize) -> Target {
        match self {
            Self::Vertices(Count::Share(ratio)) => Target::Ratio(ratio),
            Self::Vertices(Count::Number(n)) => Target::Vertices(n),
            Self::Faces(count) => Target::Faces(count.of(n_faces)),
        }
    }

    /// The number or the share, whatever it is of.
    pub fn count(self) -> Count {
        match self {
            Self::Vertices(count) | Self::Faces(count) => count,
        }
    }
}

/// A distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// In the unit of the mesh.
    Absolute(f64),
    /// In percent of the diagonal of the mesh's bounding box.
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
    /// In the unit of a mesh with this diagonal.
    pub fn over(self, diagonal: f64) -> f64 {
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
        assert_eq!([Count::Share(0.29).of(100), Count::Share(0.001).of(3), Count::Number(7).of(3)], [29, 1, 7]);
        assert_eq!([Count::Share(0.07).to_string(), Count::Number(5).to_string()], ["7%", "5"]);
    }

    #[test]
    fn a_distance_in_percent_is_one_of_the_diagonal() {
        assert_eq!([Bound::Percent(5.0).over(4.0), Bound::Absolute(5.0).over(4.0)], [0.2, 5.0]);
    }
}
