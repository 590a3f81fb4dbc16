//! What holds a collapse back beside the topology: curves that stay, vertices that stay where they are.
//!
//! A curve loses a vertex only to its neighbour along the curve; its ends stay in place, and branchings too, but that two of
//! them become one where nothing is left of the curve between. A vertex of a curve
//! never meets another one across the surface, and no face between two curves goes with its last two edges: nothing that
//! lies between curves is lost.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::pair::{Pair, Place};
use crate::simplify::closed::pins::OnPlane;
use crate::simplify::closed::prepare::features::Features;

/// The constraints of a collapse, over its vertices.
pub(in crate::simplify::closed) struct Holds {
    /// For each vertex on a kept curve its neighbours along it.
    along: FxHashMap<u32, Vec<u32>>,
    /// Whether each vertex stays where it is.
    fixed: Vec<bool>,
    /// Whether merged vertices go to one of the two.
    ends_only: bool,
    /// The vertex of the surface that each vertex lies on, while it lies on one.
    origin: Vec<u32>,
    /// What stays on the plane of a half.
    on_plane: Option<OnPlane>,
}

impl Holds {
    /// The constraints where `region` says which vertex each vertex of the surface became, and `origin` on which each
    /// vertex lies.
    pub fn new(features: &Features, region: &[u32], origin: Vec<u32>) -> Self {
        let mut fixed = vec![false; origin.len()];
        let locked = (0..features.locked.len()).filter(|&v| features.locked[v]);
        locked.for_each(|v| fixed[region[v] as usize] = true);
        let mut along: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for [a, b] in features.edges_between(region) {
            along.entry(a).or_default().push(b);
            along.entry(b).or_default().push(a);
        }
        let on_plane = features.on_plane.as_ref().map(|on_plane| on_plane.of_regions(region, origin.len()));
        Self { along, fixed, ends_only: features.subset, origin, on_plane }
    }

    /// Where the merged vertex of `u` and `v` goes, seen from `u`, and what that costs; `None` where they stay two.
    pub fn placement(&self, u: u32, v: u32, pair: &Pair) -> Option<(Place, DVec3, f64)> {
        let [of_u, of_v] = [u, v].map(|w| self.of(w));
        if !of_u.is_empty() && !of_v.is_empty() && !of_u.contains(&v) {
            return None;
        }
        let pinned = |w: u32, along: &[u32]| self.fixed[w as usize] || !matches!(along.len(), 0 | 2);
        let height = self.on_plane.as_ref().and_then(|on_plane| on_plane.height(u, v, pair.other()));
        match (pinned(u, of_u), pinned(v, of_v)) {
            (true, true) if self.are_branchings([u, v]) && of_u.contains(&v) => Some(best_end(pair)),
            (true, true) => None,
            (true, false) if height.is_some_and(|_| !self.is_on_plane(u)) => None,
            (false, true) if height.is_some_and(|_| !self.is_on_plane(v)) => None,
            (true, false) => Some(pair.at(Place::Kept)),
            (false, true) => Some(pair.at(Place::Gone)),
            (false, false) if self.ends_only => Some(best_end(pair)),
            (false, false) => match (height, &self.on_plane) {
                (Some(height), Some(on_plane)) => Some(pair.placement_at(on_plane.axis(), height)),
                _ => Some(pair.placement()),
            },
        }
    }

    /// Whether curves branch at all of these, which nothing else holds in place.
    fn are_branchings(&self, vertices: [u32; 2]) -> bool {
        let branches = |v: u32| self.of(v).len() > 2 && !self.is_fixed(v) && !self.is_on_plane(v);
        vertices.into_iter().all(branches)
    }

    /// What stays on the plane of a half.
    pub fn on_plane(&self) -> Option<&OnPlane> {
        self.on_plane.as_ref()
    }

    fn is_on_plane(&self, v: u32) -> bool {
        self.on_plane.as_ref().is_some_and(|on_plane| on_plane.has(v))
    }

    /// Whether the curves outlive the faces at `opposite` that a merge of `u` and `v` takes away.
    pub fn outlive(&self, u: u32, v: u32, opposite: [u32; 2]) -> bool {
        let [of_u, of_v] = [u, v].map(|w| self.of(w));
        !opposite.iter().any(|w| of_u.contains(w) && of_v.contains(w))
    }

    /// Takes note that `v` was merged into `u`.
    pub fn merge(&mut self, u: u32, v: u32, place: Place) {
        self.fixed[u as usize] |= self.fixed[v as usize];
        self.on_plane.iter_mut().for_each(|on_plane| on_plane.merge(u, v));
        if place == Place::Gone {
            self.origin[u as usize] = self.origin[v as usize];
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

    /// Whether a vertex stays where it is.
    pub fn is_fixed(&self, v: u32) -> bool {
        self.fixed[v as usize]
    }

    /// The vertex of the surface that `v` lies on.
    pub fn origin(&self, v: u32) -> u32 {
        self.origin[v as usize]
    }

    fn of(&self, v: u32) -> &[u32] {
        self.along.get(&v).map_or(&[], Vec::as_slice)
    }
}

/// The cheaper one of the two ends, as a place for the merged vertex.
fn best_end(pair: &Pair) -> (Place, DVec3, f64) {
    let [kept, gone] = [Place::Kept, Place::Gone].map(|place| pair.at(place));
    if gone.2 < kept.2 { gone } else { kept }
}
