//! Constraints of a collapse other than topology: held curves, seams, which only raise prices, and pins.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::geometry::Quadric;
use crate::simplify::closed::original::Original;
use crate::simplify::closed::pins::Pins;

use super::pair::{MergedVertex, Pair, Placement};

/// Factor on the price of moving a seam within its slack.
// Five textured models: at 0.03 the mean distance is 8 % smaller and rendered pictures lose 0.3 dB, at 0.3 it is 12 %
// larger.
const SEAM_PRICE: f64 = 0.1;

#[derive(Clone)]
pub struct Constraints {
    curves: FxHashMap<u32, Curve>,
    pub(super) pins: Pins,
    /// True if curves no longer forbid merges, and only their planes add to prices.
    are_curves_soft: bool,
}

#[derive(Clone, Default)]
struct Curve {
    neighbours: Vec<u32>,
    planes: Quadric,
    slack: f64,
    is_held: bool,
}

impl Constraints {
    pub fn new(original: &Original) -> Self {
        let mut curves: FxHashMap<u32, Curve> = FxHashMap::default();
        let mut curve = |v: u32, change: &dyn Fn(&mut Curve)| change(curves.entry(v).or_default());
        // Every curve vertex knows its neighbours along curves; branch points have more than two.
        for &[a, b] in &original.features.edges {
            curve(a, &|curve| curve.neighbours.push(b));
            curve(b, &|curve| curve.neighbours.push(a));
        }
        for (&edge, &slack) in original.features.edges.iter().zip(&original.features.slack) {
            for v in edge {
                // Each edge adds its plane to both ends, and its squared slack with the same weight.
                let planes = original.surface.plane_on_edge(edge, v);
                let weight = planes.trace();
                curve(v, &|curve| {
                    curve.planes += planes;
                    curve.slack += weight * f64::from(slack * slack);
                    curve.is_held |= slack == 0.0;
                });
            }
        }
        // Planes let the end of a curve slide along the curve, so the end is also pulled to its position.
        for v in original.features.curve_ends() {
            let place = original.surface.positions[v as usize].as_dvec3();
            curve(v, &|curve| {
                curve.planes = curve.planes.with_point(place, curve.planes.trace());
                curve.slack *= 2.0;
            });
        }
        let pins = original.pins.with_surface_origins(original.surface.n_vertices());
        Self { curves, pins, are_curves_soft: false }
    }

    pub(super) fn affects(&self, v: u32) -> bool {
        self.pins.is_subset() || self.pins.is_locked(v) || self.curves.contains_key(&v)
    }

    pub fn is_binding(&self) -> bool {
        self.pins.is_binding() || !self.are_curves_soft && self.curves.values().any(|curve| curve.is_held)
    }

    pub fn without_curves(self) -> Option<Self> {
        let pins = self.pins.without_locks();
        pins.is_subset().then(|| Self { curves: FxHashMap::default(), pins, are_curves_soft: false })
    }

    /// Lets merges leave held curves at the price of their planes; returns false if none forbids a merge.
    pub fn soften_curves(&mut self) -> bool {
        let has_held = self.curves.values().any(|curve| curve.is_held);
        has_held && !std::mem::replace(&mut self.are_curves_soft, true)
    }

    pub fn are_curves_soft(&self) -> bool {
        self.are_curves_soft
    }

    pub fn is_held(&self, v: u32) -> bool {
        self.pins.is_locked(v) || self.curves.get(&v).is_some_and(|curve| curve.is_held)
    }

    pub fn held_neighbours(&self, v: u32) -> &[u32] {
        curve_neighbours(self.curves.get(&v).filter(|curve| curve.is_held && !self.are_curves_soft))
    }

    pub fn planes_on_held_curves(&self, vertices: [u32; 2], origin: DVec3) -> Quadric {
        let curves = self.curves_at(vertices);
        if are_held(curves) { planes(curves, origin) } else { Quadric::default() }
    }

    /// Places the merged vertex relative to the first end, which is at `origin`; `None` if the merge is forbidden.
    pub fn placement(&self, vertices: [u32; 2], origin: DVec3, pair: &Pair) -> Option<MergedVertex> {
        // Curves with slack never forbid a merge: they only raise its price.
        let curves = self.curves_at(vertices);
        if are_held(curves) && !self.are_curves_soft {
            return self.held_placement(vertices, curves, pair);
        }
        let merged = self.place_merged(vertices.map(|v| self.pins.is_locked(v)), pair)?;
        Some(MergedVertex { price: merged.price + price_of_curves(curves, origin, merged.offset), ..merged })
    }

    fn held_placement(&self, [u, v]: [u32; 2], curves: [Option<&Curve>; 2], pair: &Pair) -> Option<MergedVertex> {
        let [of_u, of_v] = curves.map(curve_neighbours);
        // Two curve vertices merge only if they are neighbours along a curve.
        if !of_u.is_empty() && !of_v.is_empty() && !of_u.contains(&v) {
            return None;
        }
        // Endpoints and branch points have one or more than two neighbours along curves: they stay in place.
        let stays = |w: u32, along: &[u32]| self.pins.is_locked(w) || !matches!(along.len(), 0 | 2);
        let stay = [stays(u, of_u), stays(v, of_v)];
        // Adjacent branch points may merge, or junctions of short curves would block the collapse.
        if stay == [true; 2] && self.are_branch_points([u, v]) && of_u.contains(&v) {
            return Some(best_end(pair));
        }
        self.place_merged(stay, pair)
    }

    fn place_merged(&self, stay: [bool; 2], pair: &Pair) -> Option<MergedVertex> {
        match stay {
            [true, true] => None,
            [true, false] => Some(pair.place_at(Placement::KeptEnd)),
            [false, true] => Some(pair.place_at(Placement::RemovedEnd)),
            [false, false] if self.pins.is_subset() => Some(best_end(pair)),
            [false, false] => Some(pair.placement()),
        }
    }

    fn are_branch_points(&self, vertices: [u32; 2]) -> bool {
        vertices.into_iter().all(|v| curve_neighbours(self.curves.get(&v)).len() > 2 && !self.pins.is_locked(v))
    }

    /// Returns whether held curves survive a merge that removes the faces with corners `opposite`.
    pub fn survives_merge(&self, u: u32, v: u32, opposite: [u32; 2]) -> bool {
        if self.are_curves_soft {
            return true;
        }
        let curves = self.curves_at([u, v]);
        let [of_u, of_v] = curves.map(curve_neighbours);
        // A face with its other two edges on held curves would take both curves with it.
        let is_lost =
            |w: &u32| of_u.contains(w) && of_v.contains(w) && (are_held(curves) || are_held(self.curves_at([*w; 2])));
        !opposite.iter().any(is_lost)
    }

    pub fn merge(&mut self, u: u32, v: u32, place: Placement) {
        self.pins.merge(u, v, place == Placement::RemovedEnd);
        // The neighbours of `v` along curves become those of `u`.
        let Some(of_v) = self.curves.remove(&v) else { return };
        for &w in &of_v.neighbours {
            if let Some(curve) = self.curves.get_mut(&w) {
                curve.neighbours.retain(|&x| x != v && x != u);
                if w != u {
                    curve.neighbours.push(u);
                }
            }
        }
        let curve = self.curves.entry(u).or_default();
        curve.planes += of_v.planes;
        curve.slack += of_v.slack;
        curve.is_held |= of_v.is_held;
        for w in of_v.neighbours {
            if w != u && !curve.neighbours.contains(&w) {
                curve.neighbours.push(w);
            }
        }
    }

    fn curves_at(&self, vertices: [u32; 2]) -> [Option<&Curve>; 2] {
        vertices.map(|v| self.curves.get(&v))
    }
}

fn curve_neighbours(curve: Option<&Curve>) -> &[u32] {
    curve.map_or(&[], |curve| &curve.neighbours)
}

fn are_held(curves: [Option<&Curve>; 2]) -> bool {
    curves.into_iter().flatten().any(|curve| curve.is_held)
}

fn planes(curves: [Option<&Curve>; 2], origin: DVec3) -> Quadric {
    curves.into_iter().flatten().fold(Quadric::default(), |sum, curve| sum + curve.planes.with_origin(origin))
}

/// Returns the price of moving a vertex off its seams, from `origin` by `offset`.
fn price_of_curves(curves: [Option<&Curve>; 2], origin: DVec3, offset: DVec3) -> f64 {
    // Curves without slack are held, and their planes are part of the pair's quadric.
    let slack: f64 = curves.into_iter().flatten().map(|curve| curve.slack).sum();
    if slack == 0.0 {
        return 0.0;
    }
    // Within the slack a tenth of the squared distance counts, beyond it all: a convex function.
    let squares = planes(curves, origin).value(offset);
    SEAM_PRICE * squares + (1.0 - SEAM_PRICE) * (squares - slack).max(0.0)
}

fn best_end(pair: &Pair) -> MergedVertex {
    let [kept, removed] = [Placement::KeptEnd, Placement::RemovedEnd].map(|place| pair.place_at(place));
    if removed.price < kept.price { removed } else { kept }
}
