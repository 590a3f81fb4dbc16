//! Sizes: shares, numbers, distances, bytes; goals of one or several.

use std::fmt;

use serde::ser::{Serialize, Serializer};
use serde_json::json;

use crate::simplify::{Size, percent};

/// Goal of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Goal {
    /// One result of this size.
    One(Size),
    /// Levels of detail: sizes of vertices or faces, each no larger than the one before.
    Levels(Vec<Size>),
    /// The smallest result within this distance from the original.
    Error(Bound),
    /// Levels of detail: the smallest results within these rising distances.
    ErrorLevels(Vec<Bound>),
    /// The largest result whose file has at most this many bytes.
    Bytes(usize),
}

impl Goal {
    /// Returns the sizes, one for each result; empty for distances and bytes.
    pub fn sizes(&self) -> &[Size] {
        match self {
            Self::One(size) => std::slice::from_ref(size),
            Self::Levels(sizes) => sizes,
            Self::Error(_) | Self::ErrorLevels(_) | Self::Bytes(_) => &[],
        }
    }

    /// Returns the distances that results keep; empty for goals of other kinds.
    pub fn bounds(&self) -> &[Bound] {
        match self {
            Self::Error(bound) => std::slice::from_ref(bound),
            Self::ErrorLevels(bounds) => bounds,
            Self::One(_) | Self::Levels(_) | Self::Bytes(_) => &[],
        }
    }

    /// Returns sizes or distances as they are typed.
    pub fn texts(&self) -> Vec<String> {
        self.sizes().iter().map(Size::to_string).chain(self.bounds().iter().map(Bound::to_string)).collect()
    }

    /// Returns whether the goal is an upper bound of distance or bytes.
    pub fn is_bound(&self) -> bool {
        self.is_by_error() || self.n_bytes().is_some()
    }

    /// Returns whether results keep distances.
    pub fn is_by_error(&self) -> bool {
        matches!(self, Self::Error(_) | Self::ErrorLevels(_))
    }

    /// Returns the largest size of the file in bytes, if that is the goal.
    pub fn n_bytes(&self) -> Option<usize> {
        if let Self::Bytes(n_bytes) = *self { Some(n_bytes) } else { None }
    }

    /// Returns the number of levels of detail, if there are any.
    pub fn n_levels(&self) -> Option<usize> {
        match self {
            Self::Levels(sizes) => Some(sizes.len()),
            Self::ErrorLevels(bounds) => Some(bounds.len()),
            Self::One(_) | Self::Error(_) | Self::Bytes(_) => None,
        }
    }
}

/// One key and its value: `{"ratio": 0.1}`, `{"lods_faces": ["5000", "10%"]}`.
impl Serialize for Goal {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let shares: Vec<Option<f64>> =
            self.sizes().iter().map(|size| size.share().filter(|_| !size.is_of_faces())).collect();
        let (key, value) = match self {
            Self::One(Size::Ratio(share)) => ("ratio", json!(share)),
            Self::One(Size::Vertices(n)) => ("vertices", json!(n)),
            Self::One(Size::FaceRatio(share)) => ("faces_percent", json!(percent(*share))),
            Self::One(Size::Faces(n)) => ("faces", json!(n)),
            Self::Error(Bound::Absolute(distance)) => ("error", json!(distance)),
            Self::Error(Bound::Percent(percent)) => ("error_percent", json!(percent)),
            Self::Bytes(n_bytes) => ("bytes", json!(n_bytes)),
            Self::Levels(_) if shares.iter().all(Option::is_some) => ("lods", json!(shares)),
            Self::Levels(sizes) if sizes[0].is_of_faces() => ("lods_faces", json!(self.texts())),
            Self::Levels(_) => ("lods_vertices", json!(self.texts())),
            Self::ErrorLevels(_) => ("lods_error", json!(self.texts())),
        };
        to.collect_map([(key, value)])
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
    fn a_goal_is_one_key_and_its_value() {
        let words = |goal: Goal| serde_json::to_string(&goal).unwrap();
        for (goal, json) in [
            (Goal::One(Size::Ratio(0.1)), r#"{"ratio":0.1}"#),
            (Goal::One(Size::Vertices(12)), r#"{"vertices":12}"#),
            (Goal::One(Size::Faces(20)), r#"{"faces":20}"#),
            (Goal::One(Size::FaceRatio(0.07)), r#"{"faces_percent":7.0}"#),
            (Goal::Error(Bound::Absolute(0.5)), r#"{"error":0.5}"#),
            (Goal::Error(Bound::Percent(0.5)), r#"{"error_percent":0.5}"#),
            (Goal::Bytes(2000), r#"{"bytes":2000}"#),
            (Goal::Levels(vec![Size::Ratio(0.5), Size::Ratio(0.1)]), r#"{"lods":[0.5,0.1]}"#),
            (Goal::Levels(vec![Size::Vertices(9), Size::Ratio(0.1)]), r#"{"lods_vertices":["9","10%"]}"#),
            (Goal::Levels(vec![Size::FaceRatio(0.5), Size::Faces(7)]), r#"{"lods_faces":["50%","7"]}"#),
            (Goal::ErrorLevels(vec![Bound::Percent(0.5)]), r#"{"lods_error":["0.5%"]}"#),
        ] {
            assert_eq!(words(goal), json);
        }
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
