//! Where what has to stay takes the vertices that the surface needs: the collapse ends before it ruins the rest.
//!
//! What is held does not go, so all merges are the others'. Where that takes the surface more than about three times as far from the original
//! as with nothing held, the collapse is made anew, down to about the smallest size at which it does not.

use glam::Vec3;

use crate::geometry::triangle::area_normal;
use crate::simplify::limits::Limit;

use super::collapse::{Collapse, End};
use super::original::Original;
use super::output::Output;

/// Held vertices of all, one of so many, from which on the surface is looked at. Distance falls with the number of vertices: where
/// half are left to the surface, it is about twice as far as with all.
const MANY: usize = 2;
/// How many times as far as with nothing held the surface may be before it is refined, which brings it nearer than the other one:
/// charts of thirty faces over a sphere come to 2.7 to 3.8 times in the end where they are 3.9 times before, patches over a bumpy one to 2.6
/// to 3.0.
const MOST: f64 = 4.2;
/// A mean distance that ruins no surface of unit size.
const NEAR: f64 = 1e-4;
/// From each size that is tried to the next, of the vertices that are not held.
const STEP: f64 = 1.25;
/// Points of the original that tell how far a surface is, about.
const POINTS: usize = 4096;

/// How a collapse began in which so much is held that it may have to be made anew.
pub struct Beginning<'a>(Collapse<'a>);

impl<'a> Beginning<'a> {
    /// `None` where too little is held to ruin the surface at any of these sizes.
    pub fn of(collapse: &Collapse<'a>, limits: &[Limit]) -> Option<Self> {
        let least = limits.iter().map(|limit| limit.size()).min()?;
        (MANY * collapse.n_held() >= least).then(|| Self(collapse.clone().uncounted()))
    }

    /// Where a collapse that came to a limit has ruined the surface: one that ends before, and how. `distance` says how far from the
    /// original a collapse is.
    pub fn anew(
        &self,
        ended: &Collapse,
        limit: Limit,
        distance: impl Fn(&Collapse) -> f64,
    ) -> Option<(Collapse<'a>, End)> {
        if MANY * ended.n_held() < ended.size().0 {
            return None;
        }
        let mut bare = self.0.clone().bare();
        bare.run(limit);
        let most = (MOST * distance(&bare)).max(NEAR);
        if distance(ended) <= most {
            return None;
        }
        let last = self.last(ended.size().0, |collapse| distance(collapse) <= most);
        let mut collapse = self.0.clone();
        collapse.run(last);
        let end = End::WouldRuin(collapse.n_held(), collapse.size().0);
        Some((collapse, end))
    }

    /// The last of ever smaller sizes above `least` at which all is well.
    fn last(&self, least: usize, is_well: impl Fn(&Collapse) -> bool) -> Limit {
        let mut collapse = self.0.clone();
        let mut last = collapse.size().0;
        loop {
            let n_held = collapse.n_held().min(last);
            let next = n_held + ((last - n_held) as f64 / STEP) as usize;
            collapse.run(Limit::of_vertices(next));
            let (size, _) = collapse.size();
            if size <= least || size >= last || !is_well(&collapse) {
                return Limit::of_vertices(last);
            }
            last = size;
        }
    }
}

/// The mean distance of the original from an output, on the surface of unit size, by some points.
pub fn distance(original: &Original, output: &Output) -> f64 {
    let tree = output.tree();
    let surface = &original.surface;
    let (mut sum, mut areas) = (0.0, 0.0);
    for face in surface.faces.iter().step_by(surface.faces.len().div_ceil(POINTS).max(1)) {
        let corners = face.map(|v| surface.positions[v as usize]);
        let area = f64::from(area_normal(corners).length());
        let centre = corners.iter().sum::<Vec3>() / 3.0;
        sum += area * tree.nearest(centre.as_dvec3()).map_or(0.0, |hit| hit.distance2.sqrt());
        areas += area;
    }
    if areas > 0.0 { sum / areas } else { 0.0 }
}
