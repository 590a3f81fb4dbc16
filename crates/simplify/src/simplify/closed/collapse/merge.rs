//! Merges of two vertices: tests, and the update of the mesh.

use glam::{DVec3, Vec3};

use crate::geometry::triangle::{area_normal, has_area};

use super::end_ring::EndRing;
use super::history::{CollapseEvent, Merge};
use super::pair::{CollapseVertex, LastChange, MergedVertex, Pair};
use super::state::{Collapse, REMOVED};

// Largest number of neighbours of both ends together, around which each test walks. Benchmark meshes stay below a
// hundredth of this.
const MOST_NEIGHBORS: u32 = 4096;

#[inline(always)]
fn mean_importance([u, v]: [&CollapseVertex; 2]) -> f32 {
    // Weighting by area keeps the total weight of both regions.
    let areas = [u.area(), v.area()];
    let mean = (u.importance * areas[0] + v.importance * areas[1]) / (areas[0] + areas[1]);
    if mean > 0.0 { mean } else { u.importance }
}

impl Collapse<'_> {
    #[inline(always)]
    pub(super) fn ids(&self, ends: [u32; 2]) -> [u32; 2] {
        ends.map(|v| self.nodes[v as usize].id)
    }

    pub(super) fn pair(&self, u: u32, v: u32) -> Pair {
        let mut pair = Pair::new(&self.nodes[u as usize], &self.nodes[v as usize]);
        // Each contribution is a quadric of the merged position, so one minimum serves all.
        let ids = self.ids([u, v]);
        if !self.poses.is_empty() {
            pair.sum = self.poses.mean_price(ids, pair.other(), pair.sum);
        }
        if !self.attributes.is_empty() {
            pair.sum += self.attributes.price(ids, pair.other());
        }
        if let Some(constraints) = &self.constraints {
            pair.sum += constraints.planes_on_held_curves(ids, self.nodes[u as usize].position.as_dvec3());
        }
        pair
    }

    pub(super) fn constrained_price(&self, u: u32, v: u32) -> f32 {
        let merged = self.placement(u, v, &self.pair(u, v));
        merged.map_or(f32::INFINITY, |merged| merged.price as f32)
    }

    #[inline(always)]
    fn placement(&self, u: u32, v: u32, pair: &Pair) -> Option<MergedVertex> {
        match &self.constraints {
            None => Some(pair.placement()),
            Some(constraints) => {
                constraints.placement(self.ids([u, v]), self.nodes[u as usize].position.as_dvec3(), pair)
            }
        }
    }

    /// Merges the other end of the edge opposite `corner` into `u`; returns false if a test forbids it.
    #[inline(always)]
    pub(super) fn try_merge(&mut self, u: u32, corner: u32) -> bool {
        // The buffers are taken out so that the methods may borrow the collapse.
        let mut end_rings = std::mem::take(&mut self.end_rings);
        let done = self.try_merge_with(u, corner, &mut end_rings);
        self.end_rings = end_rings;
        done
    }

    #[inline(always)]
    fn try_merge_with(&mut self, u: u32, corner: u32, end_rings: &mut [EndRing; 2]) -> bool {
        let ends = self.corners.edge(corner);
        let v = if ends[0] == u { ends[1] } else { ends[0] };
        // From cheap to expensive: link condition, placement, constraints, turned faces, shape of the component.
        let Some(opposite) = self.check_link([u, v], corner, end_rings) else { return false };
        let pair = self.pair(u, v);
        let Some(merged) = self.placement(u, v, &pair) else { return false };
        if self.breaks_constraints([u, v], opposite) {
            return false;
        }
        // The position is rounded before the tests, so that they judge what is stored.
        let x = (self.nodes[u as usize].position.as_dvec3() + merged.offset).as_vec3();
        if self.would_turn_face([u, v], end_rings, x)
            || self.would_turn_face_in_poses([u, v], end_rings, &pair, merged.offset)
        {
            self.note_failure(u, None);
            return false;
        }
        let ceiling = self.ceiling_after([u, v], end_rings, x);
        if ceiling < 0.0 {
            self.note_failure(u, Some(-ceiling));
            return false;
        }
        if self.recording.is_some() {
            self.record_merge([u, v], &merged, x, end_rings);
        }
        self.merge_vertex_data([u, v], &pair, &merged, x, ceiling);
        self.merge_topology([u, v], corner, end_rings);
        true
    }

    #[inline(always)]
    fn breaks_constraints(&self, ends: [u32; 2], opposite: [u32; 2]) -> bool {
        let Some(constraints) = &self.constraints else { return false };
        let [u, v] = self.ids(ends);
        !constraints.survives_merge(u, v, self.ids(opposite))
    }

    #[inline(always)]
    fn merge_vertex_data(&mut self, [u, v]: [u32; 2], pair: &Pair, merged: &MergedVertex, x: Vec3, ceiling: f32) {
        // Data of the surface vertices are merged here, the topology in `merge_topology`.
        let [kept, removed] = [u, v].map(|w| self.nodes[w as usize]);
        let (ids, place) = ([kept.id, removed.id], merged.place);
        let event = CollapseEvent::Merge(Merge { kept: kept.id, removed: removed.id, place });
        self.history.iter_mut().for_each(|history| history.push(event.clone()));
        self.constraints.iter_mut().for_each(|constraints| constraints.merge(kept.id, removed.id, place));
        let step = (x - kept.position).as_dvec3();
        self.attributes.merge(ids, pair.other(), step);
        if !self.poses.is_empty() {
            self.poses.merge(ids, pair.other(), step);
        }
        if !self.is_special.is_empty() {
            self.is_special[kept.id as usize] |= self.is_special[removed.id as usize];
        }
        let node = &mut self.nodes[u as usize];
        (node.position, node.importance) = (x, mean_importance([&kept, &removed]));
        self.ceilings.left.get_mut(kept.id as usize).into_iter().for_each(|of_u| *of_u = ceiling);
    }

    #[inline(always)]
    fn check_link(&mut self, [u, v]: [u32; 2], corner: u32, end_rings: &mut [EndRing; 2]) -> Option<[u32; 2]> {
        // An opposite vertex loses a face and must keep three.
        let opposite = [corner, self.corners.corner_across(corner)].map(|c| self.corners.vertex(c));
        let degrees = [u, v].map(|w| self.nodes[w as usize].degree);
        let is_larger = |w: &u32| self.nodes[*w as usize].degree > 3;
        if degrees == [3, 3] || degrees[0] + degrees[1] > MOST_NEIGHBORS || !opposite.iter().all(is_larger) {
            return None;
        }
        // The neighbours of the first end are stamped; stamped neighbours of the second end are shared.
        self.n_link_tests += 1;
        for (end, star) in end_rings.iter_mut().enumerate() {
            star.gather(&self.corners, [u, v][end], corner);
        }
        for &w in &end_rings[0].ring {
            self.nodes[w as usize].seen = self.n_link_tests;
        }
        let n_shared = end_rings[1].ring.iter().filter(|&&w| self.nodes[w as usize].seen == self.n_link_tests).count();
        let has_ghost = |ring: &[u32]| ring.iter().any(|&w| self.is_ghost(w));
        // An inner edge between two boundary vertices would pinch the surface.
        let bridges = || end_rings.iter().all(|star| has_ghost(&star.ring)) && !has_ghost(&opposite);
        (n_shared == 2 && !bridges()).then_some(opposite)
    }

    #[inline(always)]
    fn would_turn_face(&self, ends: [u32; 2], end_rings: &[EndRing; 2], x: Vec3) -> bool {
        let place = |w: u32| (!self.is_ghost(w)).then(|| self.nodes[w as usize].position);
        let least = self.least_cosine;
        would_turn_face_at(ends[0], &end_rings[0].ring[1..], x, least, place)
            || would_turn_face_at(ends[1], &end_rings[1].ring[1..], x, least, place)
    }

    /// Returns whether a face would turn in another pose if both ends merged at `offset` in the present one.
    #[inline(never)]
    fn would_turn_face_in_poses(&self, ends: [u32; 2], end_rings: &[EndRing; 2], pair: &Pair, offset: DVec3) -> bool {
        (0..self.poses.n_poses()).any(|k| {
            let x = self.poses.merge_in_pose(k, self.ids(ends), pair.other(), offset).position;
            let place =
                |w: u32| (!self.is_ghost(w)).then(|| self.poses.vertex_poses(self.nodes[w as usize].id)[k].position);
            ends.into_iter()
                .zip(end_rings)
                .any(|(v, star)| would_turn_face_at(v, &star.ring[1..], x, self.least_cosine, place))
        })
    }

    #[inline(always)]
    fn merge_topology(&mut self, [u, v]: [u32; 2], corner: u32, end_rings: &[EndRing; 2]) {
        // All corners of `v` move to `u`, then the two faces at the edge are removed.
        end_rings[1].corners.iter().for_each(|&c| self.corners.set_vertex(c, u));
        for corner in [corner, self.corners.corner_across(corner)] {
            let w = self.corners.vertex(corner);
            self.n_faces -= usize::from(!self.is_ghost(w));
            let [at_w, at_u] = self.corners.remove_face(corner);
            let opposite = &mut self.nodes[w as usize];
            (opposite.corner, opposite.degree) = (at_w, opposite.degree - 1);
            self.nodes[u as usize].corner = at_u;
        }
        let [kept, removed] = self.ids([u, v]);
        self.merged[removed as usize] = kept;
        self.n_vertices -= 1;
        // Neither end counts the other any more, and the two opposite vertices were counted twice.
        self.nodes[u as usize].degree = self.nodes[u as usize].degree + self.nodes[v as usize].degree - 4;
        self.nodes[v as usize].corner = REMOVED;
        // Faces of the neighbours changed: their quadrics are stale, and edges that failed may work now.
        for &w in end_rings.iter().flat_map(|star| &star.ring) {
            let node = &mut self.nodes[w as usize];
            (node.changed, node.wait) = (node.changed.with_neighbour_change(self.pass), 0.0);
        }
        self.nodes[u as usize].changed = LastChange::from_merge(self.pass);
        self.nodes[v as usize].changed = LastChange::from_merge(self.pass);
    }
}

/// Returns whether a face at `v` would turn or lose its area if `v` moved to `x`; `place` returns positions.
#[inline(always)]
fn would_turn_face_at(
    v: u32,
    neighbors: &[u32],
    x: Vec3,
    least_cosine: f32,
    place: impl Fn(u32) -> Option<Vec3>,
) -> bool {
    let Some(p) = place(v) else { return false };
    let mut before: Option<Vec3> = None;
    for &w in neighbors {
        let here = place(w);
        if let (Some(q), Some(r)) = (before, here) {
            // A degenerate face may turn freely; others keep their direction and an area.
            let (old, new) = (area_normal([p, q, r]), area_normal([x, q, r]));
            let along = old.dot(new);
            // Squares carry the signs of both cosines, which saves the root of the lengths.
            let least = least_cosine * least_cosine.abs() * old.length_squared() * new.length_squared();
            let stays = along * along.abs() > least && has_area(new, [x, q, r]);
            if !stays && has_area(old, [p, q, r]) {
                return true;
            }
        }
        before = here;
    }
    false
}
