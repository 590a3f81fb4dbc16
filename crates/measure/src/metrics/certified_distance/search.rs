//! Branch and bound over polygons, the largest upper bounds first.

use std::collections::BinaryHeap;

use super::distance_bounds::DistanceBounds;
use super::polygon::{PolygonCorner, bisecting_plane, largest_corner_distance, middle, radius_from, split_polygon};
use super::target_surface::TargetSurface;
use crate::parallel;

const MAX_BATCH: usize = 256;
/// Interval, in cuts of a polygon, at which one cut bisects it.
const BISECT_EVERY: u32 = 5;
const SEARCHES_PER_CUT: u64 = 10;
pub(super) struct SearchItem {
    pub upper: f64,
    pub part: FacePart,
    pub n_cuts: u32,
}

pub(super) enum FacePart {
    Face(u32),
    Piece(Vec<PolygonCorner>),
}

impl Ord for SearchItem {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.upper.total_cmp(&other.upper)
    }
}

impl PartialOrd for SearchItem {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for SearchItem {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for SearchItem {}

#[derive(Default)]
struct CutResult {
    lower: f64,
    upper: f64,
    waiting: Vec<SearchItem>,
}

pub(super) fn tighten_bounds(
    mut waiting: BinaryHeap<SearchItem>,
    corners_of: &(dyn Fn(u32) -> [PolygonCorner; 3] + Sync),
    target: &TargetSurface,
    bounds: &mut DistanceBounds,
) {
    while let Some(first) = waiting.peek() {
        if bounds.is_tight_enough(first.upper) || target.is_exhausted() || bounds.is_too_far() {
            bounds.upper = bounds.upper.max(first.upper);
            return;
        }
        let next = (0..target.batch_size(MAX_BATCH, SEARCHES_PER_CUT)).map_while(|_| waiting.pop());
        for found in parallel::each(next, |next| target.cut(next, corners_of, bounds)) {
            bounds.raise_lower(found.lower);
            bounds.upper = bounds.upper.max(found.upper);
            waiting.extend(found.waiting);
        }
    }
}

impl TargetSurface<'_> {
    fn cut(
        &self,
        waiting: SearchItem,
        corners_of: &(dyn Fn(u32) -> [PolygonCorner; 3] + Sync),
        bounds: &DistanceBounds,
    ) -> CutResult {
        let corners = match waiting.part {
            FacePart::Face(face) => corners_of(face).to_vec(),
            FacePart::Piece(corners) => corners,
        };
        let middle = self.corner_enough(middle(&corners), corners[0].face, bounds);
        let mut found = CutResult { lower: middle.distance, ..CutResult::default() };
        let radius = radius_from(&corners, &middle);
        // Faces much smaller than the polygon are far from most of it, and their sides would cut slivers off.
        let is_large = radius > self.longest_side(middle.face);
        let near = if is_large { f64::INFINITY } else { self.distance_from_face(&corners, middle.face) };
        let upper = near.min(middle.distance + radius).min(waiting.upper);
        if bounds.is_tight_enough(upper) {
            found.upper = upper;
            return found;
        }
        let n_cuts = waiting.n_cuts + 1;
        let is_to_halve = is_large || n_cuts.is_multiple_of(BISECT_EVERY);
        for corners in self.parts(corners, middle.face, is_to_halve, bounds) {
            // A corner's distance is exact, or at most the lower bound.
            found.lower = found.lower.max(largest_corner_distance(&corners));
            let upper = self.upper_bound(&corners, |upper| bounds.is_tight_enough(upper)).min(upper);
            if bounds.is_tight_enough(upper) {
                found.upper = found.upper.max(upper);
            } else {
                found.waiting.push(SearchItem { upper, part: FacePart::Piece(corners), n_cuts });
            }
        }
        found
    }

    /// Splits a polygon along the sides of `face`, else at the bisector to another face, else in the middle.
    fn parts(
        &self,
        corners: Vec<PolygonCorner>,
        face: u32,
        is_to_halve: bool,
        bounds: &DistanceBounds,
    ) -> Vec<Vec<PolygonCorner>> {
        let mut parts = Vec::new();
        let mut within = corners;
        if !is_to_halve {
            let corner_at = |p| self.corner_from_face(face, p, bounds);
            for wall in self.side_planes(face) {
                if let Some([inside, outside]) = split_polygon(&within, &wall, corner_at) {
                    parts.push(outside);
                    within = inside;
                }
            }
        }
        if parts.is_empty() {
            let bisector = || self.bisector(&within, face).filter(|_| !is_to_halve);
            let split_polygon = |plane| split_polygon(&within, &plane, |p| self.corner_enough(p, face, bounds));
            let across = || split_polygon(bisecting_plane(&within));
            return match bisector().and_then(split_polygon).or_else(across) {
                Some(parts) => parts.into(),
                None => vec![within],
            };
        }
        parts.push(within);
        parts
    }
}
