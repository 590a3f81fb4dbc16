//! What constrains a collapse beside the topology: curves that stay, vertices that are pinned.
//!
//! A curve loses a vertex only to its neighbour along the curve. Endpoints and branch points are fixed; two adjacent branch
//! points may merge. A vertex of a curve never meets another one across the surface, and no face between two curves goes with its
//! last two edges: nothing that lies between curves is lost.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::geometry::Quadric;
use crate::simplify::closed::original::Original;
use crate::simplify::closed::pins::Pins;

use super::pair::{MergedVertex, Pair, Place};

/// The constraints of a collapse, over its vertices.
pub struct Constraints {
    /// For each vertex on a feature curve its neighbours along it.
    along: FxHashMap<u32, Vec<u32>>,
    /// For each of them the planes on the original's edges that became it.
    planes: FxHashMap<u32, Quadric>,
    /// What may not move.
    pub(super) pins: Pins,
}

impl Constraints {
    /// The constraints where `region` says which vertex each vertex of the surface became, and `origin` on which of them each
    /// vertex lies.
    pub fn new(original: &Original, region: &[u32], origin: Vec<u32>) -> Self {
        let mut along: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for [a, b] in original.features.edges_between(region) {
            along.entry(a).or_default().push(b);
            along.entry(b).or_default().push(a);
        }
        let mut planes: FxHashMap<u32, Quadric> = FxHashMap::default();
        for edge in &original.features.edges {
            for &v in edge {
                let quadric = planes.entry(region[v as usize]).or_default();
                *quadric += original.surface.plane_on_edge(*edge, v);
            }
        }
        Self { along, planes, pins: original.pins.of_regions(region, origin) }
    }

    /// Whether anything holds vertices beside the plane of a half.
    pub fn hold_more_than_plane(&self) -> bool {
        !self.along.is_empty() || self.pins.hold_more_than_plane()
    }

    /// The planes on the curves of two vertices about `origin`; nothing where no curve runs through them.
    pub fn planes_on_curves(&self, vertices: [u32; 2], origin: DVec3) -> Quadric {
        let planes = vertices.into_iter().filter_map(|v| self.planes.get(&v));
        planes.fold(Quadric::default(), |sum, planes| sum + planes.about(origin))
    }

    /// The merged vertex of `u` and `v`, seen from `u`; `None` where they stay two.
    pub fn placement(&self, u: u32, v: u32, pair: &Pair) -> Option<MergedVertex> {
        let [of_u, of_v] = [u, v].map(|w| self.of(w));
        if !of_u.is_empty() && !of_v.is_empty() && !of_u.contains(&v) {
            return None;
        }
        let stays = |w: u32, along: &[u32]| self.pins.is_locked(w) || !matches!(along.len(), 0 | 2);
        let height = self.pins.plane().and_then(|plane| plane.height(u, v, pair.other()));
        match (stays(u, of_u), stays(v, of_v)) {
            (true, true) if self.are_branch_points([u, v]) && of_u.contains(&v) => Some(best_end(pair)),
            (true, true) => None,
            (true, false) if height.is_some_and(|_| !self.pins.is_on_cut(u)) => None,
            (false, true) if height.is_some_and(|_| !self.pins.is_on_cut(v)) => None,
            (true, false) => Some(pair.at(Place::Kept)),
            (false, true) => Some(pair.at(Place::Gone)),
            (false, false) if self.pins.is_subset() => Some(best_end(pair)),
            (false, false) => match (height, self.pins.plane()) {
                (Some(height), Some(plane)) => Some(pair.placement_at(plane.axis(), height)),
                _ => Some(pair.placement()),
            },
        }
    }

    /// Whether curves branch at all of these, which nothing else pins.
    fn are_branch_points(&self, vertices: [u32; 2]) -> bool {
        vertices.into_iter().all(|v| self.of(v).len() > 2 && !self.pins.has(v))
    }

    /// Whether the curves outlive the faces at `opposite` that a merge of `u` and `v` takes away.
    pub fn outlive(&self, u: u32, v: u32, opposite: [u32; 2]) -> bool {
        let [of_u, of_v] = [u, v].map(|w| self.of(w));
        !opposite.iter().any(|w| of_u.contains(w) && of_v.contains(w))
    }

    /// Takes note that `v` was merged into `u`.
    pub fn merge(&mut self, u: u32, v: u32, place: Place) {
        self.pins.merge(u, v, place == Place::Gone);
        if let Some(planes) = self.planes.remove(&v) {
            *self.planes.entry(u).or_default() += planes;
        }
        let Some(of_v) = self.along.remove(&v) else { return };
        for w in of_v {
            if let Some(list) = self.along.get_mut(&w) {
                list.retain(|&x| x != v && x != u);
                if w != u {
                    list.push(u);
                }
            }
            let list = self.along.entry(u).or_default();
            if w != u && !list.contains(&w) {
                list.push(w);
            }
        }
    }

    fn of(&self, v: u32) -> &[u32] {
        self.along.get(&v).map_or(&[], Vec::as_slice)
    }
}

/// The cheaper one of the two ends, as a place for the merged vertex.
fn best_end(pair: &Pair) -> MergedVertex {
    let [kept, gone] = [Place::Kept, Place::Gone].map(|place| pair.at(place));
    if gone.price < kept.price { gone } else { kept }
}
