//! Whether components keep their shape: how far a merge leaves the surface around it from what it was before.

use glam::Vec3;

use crate::geometry::triangle::nearest_point;

use super::complex::Collapse;

/// Share of a ceiling below which a distance is not measured on.
const NEGLIGIBLE: f32 = 0.02;

impl Collapse<'_> {
    /// Returns how far later merges may still take a vertex from the surface after the ends of an edge have gone to `x`, in the unit of
    /// the positions; below 0 where this merge takes the surface too far.
    #[inline(always)]
    pub(super) fn ceiling_after(&self, ends: [u32; 2], opposite: [u32; 2], x: Vec3) -> f32 {
        let Some(&of_u) = self.ceilings.get(ends[0] as usize) else { return f32::INFINITY };
        let ceiling = of_u.min(self.ceilings[ends[1] as usize]);
        if ceiling == f32::INFINITY { ceiling } else { ceiling - self.distance_of_merge(ends, opposite, x, ceiling) }
    }

    /// The distance between the faces around an edge before and after its ends have gone to `x`, or one above `most`.
    #[inline(never)]
    fn distance_of_merge(&self, ends: [u32; 2], opposite: [u32; 2], x: Vec3, most: f32) -> f32 {
        let [u, v] = ends.map(|w| self.positions[w as usize]);
        let (mut before, mut after) = (Vec::with_capacity(16), Vec::with_capacity(16));
        for (own, other, here) in [(ends[0], ends[1], u), (ends[1], ends[0], v)] {
            let ring = self.nodes[own as usize].ring;
            let at = self.links.position(ring, other).unwrap_or(0);
            let mut last: Option<Vec3> = None;
            for w in self.links.beyond(ring, at) {
                let next = self.positions.get(w as usize).copied();
                if let (Some(q), Some(r)) = (last, next) {
                    before.push([here, q, r]);
                    after.push([x, q, r]);
                }
                last = next;
            }
        }
        before.extend(opposite.iter().filter_map(|&w| Some([u, v, *self.positions.get(w as usize)?])));
        let mut farthest = Farthest { distance2: (NEGLIGIBLE * most).powi(2), most2: most * most };
        farthest.look(&after, [u, v].into_iter());
        // What lies between corners that stay near may be gone, and what was open may be covered.
        let middle = |[p, q, r]: [Vec3; 3]| (p + q + r) / 3.0;
        farthest.look(&after, before.iter().map(|&face| middle(face)));
        farthest.look(&before, after.iter().map(|&face| middle(face)));
        farthest.look(&before, after.iter().map(|&[x, q, _]| 0.5 * (x + q)));
        farthest.distance2.sqrt()
    }
}

/// The largest squared distance of points from triangles, as far as it matters.
struct Farthest {
    distance2: f32,
    /// What lies beyond is not looked for.
    most2: f32,
}

impl Farthest {
    /// Looks at more points; triangle `i` is likely to be nearest to point `i`.
    fn look(&mut self, triangles: &[[Vec3; 3]], points: impl Iterator<Item = Vec3>) {
        for (i, point) in points.enumerate() {
            if self.distance2 > self.most2 {
                return;
            }
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
