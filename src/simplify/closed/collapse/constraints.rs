//! What constrains a collapse beside the topology: curves that stay, vertices that are pinned.
//!
//! A curve that is held loses a vertex only to its neighbour along the curve. Endpoints and branch points are fixed; two adjacent
//! branch points may merge. A vertex of a curve never meets another one across the surface, and no face between two curves goes with
//! its last two edges: nothing that lies between curves is lost.
//!
//! Curves with slack, seams of textures, only have a price: the squared distances from where they ran, which cost little within the
//! slack. Branch points move, curves meet across the surface, and what lies between them may go.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::geometry::Quadric;
use crate::simplify::closed::original::Original;
use crate::simplify::closed::pins::Pins;

use super::pair::{MergedVertex, Pair, Place};

/// What it costs that a curve leaves its place within its slack, over what a held one costs. Five textured models in 6 to 803
/// charts, four ratios: at 0.03 the mean distance is 8 % nearer and pictures 0.3 dB less alike, at 0.3 it is 12 % farther and they are
/// as alike; where the first two texels cost nothing, seams wander over planes.
const SEAM_PRICE: f64 = 0.1;

/// The constraints of a collapse, over its vertices.
#[derive(Clone)]
pub struct Constraints {
    /// What runs through each vertex on a feature curve.
    curves: FxHashMap<u32, Curve>,
    /// What may not move.
    pub(super) pins: Pins,
}

/// A vertex of a curve.
#[derive(Clone, Default)]
struct Curve {
    /// Its neighbours along curves.
    along: Vec<u32>,
    /// The planes on the original's edges that became it.
    planes: Quadric,
    /// The squared slack of these edges, as the planes are weighed.
    slack: f64,
    /// Whether one of the curves is held.
    is_held: bool,
}

impl Constraints {
    /// The constraints over the vertices of a surface.
    pub fn new(original: &Original) -> Self {
        let mut curves: FxHashMap<u32, Curve> = FxHashMap::default();
        let mut curve = |v: u32, change: &dyn Fn(&mut Curve)| change(curves.entry(v).or_default());
        for &[a, b] in &original.features.edges {
            curve(a, &|curve| curve.along.push(b));
            curve(b, &|curve| curve.along.push(a));
        }
        for (&edge, &slack) in original.features.edges.iter().zip(&original.features.slack) {
            for v in edge {
                let planes = original.surface.plane_on_edge(edge, v);
                let weight = planes.trace();
                curve(v, &|curve| {
                    curve.planes += planes;
                    curve.slack += weight * f64::from(slack * slack);
                    curve.is_held |= slack == 0.0;
                });
            }
        }
        // An end has a place along its curve, too.
        for v in original.features.ends() {
            let place = original.surface.positions[v as usize].as_dvec3();
            curve(v, &|curve| {
                curve.planes = curve.planes.pulled_to(place, curve.planes.trace());
                curve.slack *= 2.0;
            });
        }
        Self { curves, pins: original.pins.on_own_vertices(original.surface.n_vertices()) }
    }

    /// Whether a vertex is on a curve, or pinned.
    pub(super) fn touch(&self, v: u32) -> bool {
        self.pins.is_subset() || self.pins.has(v) || self.curves.contains_key(&v)
    }

    /// Whether anything holds vertices beside the plane of a half.
    pub fn hold_more_than_plane(&self) -> bool {
        !self.curves.is_empty() || self.pins.hold_more_than_plane()
    }

    /// The same without curves, and nothing locked; `None` where that constrains nothing.
    pub fn bare(self) -> Option<Self> {
        let pins = self.pins.unlocked();
        (pins.is_subset() || pins.plane().is_some()).then(|| Self { curves: FxHashMap::default(), pins })
    }

    /// Whether a held curve runs through a vertex, or it may not move.
    pub fn is_held(&self, v: u32) -> bool {
        self.pins.is_locked(v) || self.curves.get(&v).is_some_and(|curve| curve.is_held)
    }

    /// The neighbours of a vertex along curves, where one of these is held.
    pub fn along_held(&self, v: u32) -> &[u32] {
        along(self.curves.get(&v).filter(|curve| curve.is_held))
    }

    /// The planes on the curves of two vertices about `origin`; nothing where no held curve runs through them.
    pub fn planes_on_held_curves(&self, vertices: [u32; 2], origin: DVec3) -> Quadric {
        let curves = self.curves_at(vertices);
        if are_held(curves) { planes(curves, origin) } else { Quadric::default() }
    }

    /// The merged vertex of `u`, at `origin`, and `v`, seen from `u`; `None` where they stay two.
    pub fn placement(&self, vertices: [u32; 2], origin: DVec3, pair: &Pair) -> Option<MergedVertex> {
        let curves = self.curves_at(vertices);
        if are_held(curves) {
            return self.held_placement(vertices, curves, pair);
        }
        let merged = self.placed(vertices, vertices.map(|v| self.pins.is_locked(v)), pair)?;
        Some(MergedVertex { price: merged.price + price_of_curves(curves, origin, merged.offset), ..merged })
    }

    /// The same where a held curve runs through one of the two.
    fn held_placement(&self, [u, v]: [u32; 2], curves: [Option<&Curve>; 2], pair: &Pair) -> Option<MergedVertex> {
        let [of_u, of_v] = curves.map(along);
        if !of_u.is_empty() && !of_v.is_empty() && !of_u.contains(&v) {
            return None;
        }
        let stays = |w: u32, along: &[u32]| self.pins.is_locked(w) || !matches!(along.len(), 0 | 2);
        let stay = [stays(u, of_u), stays(v, of_v)];
        if stay == [true; 2] && self.are_branch_points([u, v]) && of_u.contains(&v) {
            return Some(best_end(pair));
        }
        self.placed([u, v], stay, pair)
    }

    /// The merged vertex where some of the two stay.
    fn placed(&self, [u, v]: [u32; 2], stay: [bool; 2], pair: &Pair) -> Option<MergedVertex> {
        let height = self.pins.plane().and_then(|plane| plane.height(u, v, pair.other()));
        match stay {
            [true, true] => None,
            [true, false] if height.is_some_and(|_| !self.pins.is_on_cut(u)) => None,
            [false, true] if height.is_some_and(|_| !self.pins.is_on_cut(v)) => None,
            [true, false] => Some(pair.at(Place::Kept)),
            [false, true] => Some(pair.at(Place::Gone)),
            [false, false] if self.pins.is_subset() => Some(best_end(pair)),
            [false, false] => match (height, self.pins.plane()) {
                (Some(height), Some(plane)) => Some(pair.placement_at(plane.axis(), height)),
                _ => Some(pair.placement()),
            },
        }
    }

    /// Whether curves branch at all of these, which nothing else pins.
    fn are_branch_points(&self, vertices: [u32; 2]) -> bool {
        vertices.into_iter().all(|v| along(self.curves.get(&v)).len() > 2 && !self.pins.has(v))
    }

    /// Whether held curves outlive the faces at `opposite` that a merge of `u` and `v` takes away.
    pub fn outlive(&self, u: u32, v: u32, opposite: [u32; 2]) -> bool {
        let curves = self.curves_at([u, v]);
        let [of_u, of_v] = curves.map(along);
        let is_lost =
            |w: &u32| of_u.contains(w) && of_v.contains(w) && (are_held(curves) || are_held(self.curves_at([*w; 2])));
        !opposite.iter().any(is_lost)
    }

    /// Takes note that `v` was merged into `u`.
    pub fn merge(&mut self, u: u32, v: u32, place: Place) {
        self.pins.merge(u, v, place == Place::Gone);
        let Some(of_v) = self.curves.remove(&v) else { return };
        for &w in &of_v.along {
            if let Some(curve) = self.curves.get_mut(&w) {
                curve.along.retain(|&x| x != v && x != u);
                if w != u {
                    curve.along.push(u);
                }
            }
        }
        let curve = self.curves.entry(u).or_default();
        curve.planes += of_v.planes;
        curve.slack += of_v.slack;
        curve.is_held |= of_v.is_held;
        for w in of_v.along {
            if w != u && !curve.along.contains(&w) {
                curve.along.push(w);
            }
        }
    }

    fn curves_at(&self, vertices: [u32; 2]) -> [Option<&Curve>; 2] {
        vertices.map(|v| self.curves.get(&v))
    }
}

/// The neighbours of a vertex along curves.
fn along(curve: Option<&Curve>) -> &[u32] {
    curve.map_or(&[], |curve| &curve.along)
}

/// Whether a held curve runs through one of two vertices.
fn are_held(curves: [Option<&Curve>; 2]) -> bool {
    curves.into_iter().flatten().any(|curve| curve.is_held)
}

/// The planes on the curves of two vertices about `origin`.
fn planes(curves: [Option<&Curve>; 2], origin: DVec3) -> Quadric {
    curves.into_iter().flatten().fold(Quadric::default(), |sum, curve| sum + curve.planes.about(origin))
}

/// What curves cost that leave their places when a merge puts two of their vertices at `offset` from `origin`.
fn price_of_curves(curves: [Option<&Curve>; 2], origin: DVec3, offset: DVec3) -> f64 {
    let slack: f64 = curves.into_iter().flatten().map(|curve| curve.slack).sum();
    if slack == 0.0 {
        return 0.0;
    }
    let squares = planes(curves, origin).value(offset);
    SEAM_PRICE * squares + (1.0 - SEAM_PRICE) * (squares - slack).max(0.0)
}

/// The cheaper one of the two ends, as a place for the merged vertex.
fn best_end(pair: &Pair) -> MergedVertex {
    let [kept, gone] = [Place::Kept, Place::Gone].map(|place| pair.at(place));
    if gone.price < kept.price { gone } else { kept }
}
