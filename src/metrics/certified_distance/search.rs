//! Branch and bound: parts of faces wait by how far they may be, and the farthest are cut.

use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::bounds::Bounds;
use super::other::Other;
use super::piece::{Corner, across_the_middle, farthest, halves, middle};

/// Parts that are cut side by side. More would be cut that a larger lower bound makes needless.
const AT_ONCE: usize = 256;
/// Every so many cuts of a part one is across its middle, so that it shrinks whatever the planes are.
const HALVED: u32 = 5;
/// Points that are looked up for one cut, about.
const SEARCHES: u64 = 10;
/// A part of a face that waits to be cut.
pub(super) struct Waiting {
    pub upper: f64,
    pub part: Part,
    /// How often the face was cut to get it.
    pub n_cuts: u32,
}

/// A face as it is, or the corners of a part of it.
pub(super) enum Part {
    Face(u32),
    Piece(Vec<Corner>),
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.upper.total_cmp(&other.upper)
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}

/// What one cut finds.
#[derive(Default)]
struct Found {
    lower: f64,
    /// Of the parts that the bounds allow.
    upper: f64,
    waiting: Vec<Waiting>,
}

/// Tightens the bounds by cutting what waits, the largest upper bounds first.
pub(super) fn tighten(
    mut waiting: BinaryHeap<Waiting>,
    corners_of: &(dyn Fn(u32) -> [Corner; 3] + Sync),
    other: &Other,
    bounds: &mut Bounds,
) {
    while let Some(first) = waiting.peek() {
        if bounds.allow(first.upper) || other.is_exhausted() || bounds.is_beyond() {
            bounds.upper = bounds.upper.max(first.upper);
            return;
        }
        let next: Vec<Waiting> = (0..other.at_once(AT_ONCE, SEARCHES)).map_while(|_| waiting.pop()).collect();
        let found: Vec<Found> = next.into_par_iter().map(|next| other.cut(next, corners_of, bounds)).collect();
        for found in found {
            bounds.raise_to(found.lower);
            bounds.upper = bounds.upper.max(found.upper);
            waiting.extend(found.waiting);
        }
    }
}

impl Other<'_> {
    /// Cuts a part, unless the face nearest to its middle is near enough to all of it.
    fn cut(&self, waiting: Waiting, corners_of: &(dyn Fn(u32) -> [Corner; 3] + Sync), bounds: &Bounds) -> Found {
        let corners = match waiting.part {
            Part::Face(face) => corners_of(face).to_vec(),
            Part::Piece(corners) => corners,
        };
        let middle = self.corner(middle(&corners), Some(corners[0].face));
        let mut found = Found { lower: middle.distance, ..Found::default() };
        let upper = self.farthest_from(&corners, middle.face).min(waiting.upper);
        if bounds.allow(upper) {
            found.upper = upper;
            return found;
        }
        let n_cuts = waiting.n_cuts + 1;
        for corners in self.parts(corners, middle.face, n_cuts.is_multiple_of(HALVED), bounds) {
            // A distance that is not exact is no larger than the lower bound.
            found.lower = found.lower.max(farthest(&corners));
            let upper = self.upper(&corners, |upper| bounds.allow(upper)).min(waiting.upper);
            if bounds.allow(upper) {
                found.upper = found.upper.max(upper);
            } else {
                found.waiting.push(Waiting { upper, part: Part::Piece(corners), n_cuts });
            }
        }
        found
    }

    /// The part that lies over `face` and those beyond its sides; where no side passes through, what is on either side of the
    /// plane halfway to another face, or of the middle.
    fn parts(&self, corners: Vec<Corner>, face: u32, is_to_halve: bool, bounds: &Bounds) -> Vec<Vec<Corner>> {
        let mut parts = Vec::new();
        let mut within = corners;
        if !is_to_halve {
            let corner_at = |p| self.corner_by(face, p, bounds.lower);
            for wall in self.walls(face) {
                if let Some([inside, outside]) = halves(&within, &wall, corner_at) {
                    parts.push(outside);
                    within = inside;
                }
            }
        }
        if parts.is_empty() {
            let bisector = || self.bisector(&within, face).filter(|_| !is_to_halve);
            let halves = |plane| halves(&within, &plane, |p| self.corner(p, Some(face)));
            let across = || halves(across_the_middle(&within));
            return match bisector().and_then(halves).or_else(across) {
                Some(parts) => parts.into(),
                None => vec![within],
            };
        }
        parts.push(within);
        parts
    }
}
