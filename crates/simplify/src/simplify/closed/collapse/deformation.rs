//! Deformation of the surface by a merge.

use glam::Vec3;

use crate::geometry::triangle::nearest_point;

use super::end_ring::EndRing;
use super::state::Collapse;

/// Share of the allowed deformation below which distances are not measured exactly.
const NEGLIGIBLE: f32 = 0.02;

impl Collapse<'_> {
    /// Returns the deformation still allowed after both ends moved to `x`; negative if exceeded.
    #[inline(always)]
    pub(super) fn ceiling_after(&self, ends: [u32; 2], end_rings: &[EndRing; 2], x: Vec3) -> f32 {
        if !self.has_ceilings() {
            return f32::INFINITY;
        }
        // The stricter end decides; infinite ceilings skip the measurement.
        let ceiling = self.ids(ends).into_iter().map(|v| self.ceilings.left[v as usize]).fold(f32::INFINITY, f32::min);
        if ceiling == f32::INFINITY { ceiling } else { ceiling - self.distance_of_merge(ends, end_rings, x, ceiling) }
    }

    /// Measures the largest distance between the faces before and after a merge; stops once it exceeds `most`.
    #[inline(never)]
    fn distance_of_merge(&self, ends: [u32; 2], end_rings: &[EndRing; 2], x: Vec3, most: f32) -> f32 {
        let place = |w: u32| (!self.is_ghost(w)).then(|| self.nodes[w as usize].position);
        let [u, v] = ends.map(|w| self.nodes[w as usize].position);
        // `before` holds the faces that stay and the two that vanish, `after` those that stay.
        let (mut before, mut after) = (Vec::with_capacity(16), Vec::with_capacity(16));
        for (here, star) in [u, v].into_iter().zip(end_rings) {
            for pair in star.ring[1..].windows(2) {
                if let (Some(q), Some(r)) = (place(pair[0]), place(pair[1])) {
                    before.push([here, q, r]);
                    after.push([x, q, r]);
                }
            }
        }
        let ring = &end_rings[0].ring;
        let opposite = [ring[1], ring[ring.len() - 1]];
        before.extend(opposite.into_iter().filter_map(|w| Some([u, v, place(w)?])));
        // The search starts at a distance that is negligible for the ceiling: smaller ones need not be exact.
        let mut farthest = Farthest { distance2: (NEGLIGIBLE * most).powi(2), most2: most * most };
        self.measure_along_curves(&mut farthest, ends, end_rings, x);
        // The removed vertices themselves are usually farthest.
        farthest.measure(&after, [u, v].into_iter());
        // Corners may stay near while a face between them vanishes or an opening is covered.
        let middle = |[p, q, r]: [Vec3; 3]| (p + q + r) / 3.0;
        farthest.measure(&after, before.iter().map(|&face| middle(face)));
        farthest.measure(&before, after.iter().map(|&face| middle(face)));
        // The way back: midpoints of the new edges against the old faces.
        let rings = end_rings.iter().flat_map(|star| &star.ring[1..]);
        farthest.measure(&before, rings.filter_map(|&w| Some(0.5 * (x + place(w)?))));
        farthest.distance2.sqrt()
    }

    fn measure_along_curves(&self, farthest: &mut Farthest, ends: [u32; 2], end_rings: &[EndRing; 2], x: Vec3) {
        // Curves separate regions that a viewer distinguishes, such as panes or tiles.
        let Some(constraints) = &self.constraints else { return };
        let (mut before, mut after) = (Vec::new(), Vec::new());
        for (end, star) in ends.into_iter().zip(end_rings) {
            let here = self.nodes[end as usize].position;
            let along = constraints.held_neighbours(self.nodes[end as usize].id);
            for &w in star.ring.iter().filter(|&&w| !self.is_ghost(w) && along.contains(&self.nodes[w as usize].id)) {
                let there = self.nodes[w as usize].position;
                before.push([here, there, there]);
                if !ends.contains(&w) {
                    after.push([x, there, there]);
                }
            }
        }
        if !after.is_empty() {
            let middle = |[p, q, _]: [Vec3; 3]| 0.5 * (p + q);
            farthest.measure(&after, before.iter().flat_map(|&curve| [curve[0], middle(curve)]));
            farthest.measure(&before, after.iter().map(|&curve| middle(curve)));
        }
    }
}

struct Farthest {
    distance2: f32,
    most2: f32,
}

impl Farthest {
    /// Raises the largest distance by those of more points to their nearest triangles; triangle `i` is tried first for
    /// point `i`.
    fn measure(&mut self, triangles: &[[Vec3; 3]], points: impl Iterator<Item = Vec3>) {
        for (i, point) in points.enumerate() {
            // Beyond the bound the merge is forbidden anyway.
            if self.distance2 > self.most2 {
                return;
            }
            // Starting at the probable triangle lets the bound cut most searches short.
            let (before, from) = triangles.split_at(i.min(triangles.len()));
            let mut nearest2 = f32::INFINITY;
            for &corners in from.iter().chain(before) {
                nearest2 = nearest2.min(nearest_point(point, corners).distance_squared(point));
                if nearest2 <= self.distance2 {
                    break;
                }
            }
            self.distance2 = self.distance2.max(nearest2);
        }
    }
}
