//! Merges of two vertices within a stretch: tests, and the update of the mesh.

use glam::{DVec3, Vec3};

use crate::geometry::triangle::{area_normal, has_area};

use super::corner_table::{CornerStep, NONE, next};
use super::end_ring::EndRing;
use super::history::Merge;
use super::pair::{CollapseVertex, LastChange, MergedVertex, Pair};
use super::rules::Rules;
use super::state::REMOVED;
use super::stretch::{Beyond, Stretch, Within};

/// Least cosine between a face's normals before and after a merge.
// Nineteen meshes, ratios 0.01 to 0.05: at 0 and at 0.4 the largest distance is 2 to 3 % larger.
const LEAST_COSINE: f32 = 0.2;
// Largest number of neighbours of both ends together, around which each test walks. Benchmark meshes stay below a
// hundredth of this.
const MOST_NEIGHBORS: u32 = 4096;

/// Share of a vertex's `wait` below which its edges have failed already.
const WAIT_SLACK: f32 = 0.999;

/// Vertex with its cheapest edge.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    pub price: f32,
    pub vertex: u32,
    pub edge: u32,
}

/// Outcome of the visits of a pass in one stretch.
#[derive(Default)]
pub(super) struct Merges {
    /// Merges, with the deformation still allowed after each.
    pub merges: Vec<(Merge, f32)>,
    pub n_faces_removed: usize,
    pub n_link_tests: u32,
    pub was_turn_forbidden: bool,
    pub was_ceiling_met: bool,
    /// Candidates that need other stretches.
    pub deferred: Vec<Candidate>,
}

/// Merges the vertices of a stretch.
pub(super) struct Merger<'m> {
    pub stretch: Stretch<'m>,
    pub rules: &'m mut Rules,
    /// Marks surface vertices that only a merger with all rules may merge; empty for none.
    pub is_special: &'m [bool],
    /// Deformation still allowed at each surface vertex; empty for no limit.
    pub ceilings: &'m [f32],
    pub pass: u32,
    pub end_rings: [EndRing; 2],
    pub done: Merges,
}

#[inline(always)]
fn mean_importance([u, v]: [&CollapseVertex; 2]) -> f32 {
    // Weighting by area keeps the total weight of both regions.
    let areas = [u.area(), v.area()];
    let mean = (u.importance * areas[0] + v.importance * areas[1]) / (areas[0] + areas[1]);
    if mean > 0.0 { mean } else { u.importance }
}

impl Merger<'_> {
    /// Merges a vertex along its cheapest edge, or else along the next that costs at most `most_price`.
    #[inline(always)]
    pub fn visit(&mut self, candidate: &Candidate, most_price: f32) {
        if self.visit_within(candidate, most_price).is_err() {
            self.done.deferred.push(*candidate);
        }
    }

    #[inline(always)]
    fn visit_within(&mut self, &Candidate { vertex, edge, .. }: &Candidate, most_price: f32) -> Within<()> {
        if self.was_merged(vertex) {
            return Ok(());
        }
        let is_first = self.stretch.node(vertex).wait == 0.0;
        // If an end was merged in this pass, the price is stale: the vertex waits for the next pass.
        if is_first && (self.is_merged_edge(edge)? || self.try_merge(vertex, edge)?) {
            return Ok(());
        }
        self.try_others(vertex, is_first.then_some(edge), most_price)
    }

    #[inline(always)]
    fn was_merged(&self, v: u32) -> bool {
        v == NONE || self.stretch.node(v).changed == LastChange::from_merge(self.pass)
    }

    #[inline(always)]
    fn is_merged_edge(&self, edge: u32) -> Within<bool> {
        Ok(self.stretch.edge(edge)?.into_iter().any(|v| self.was_merged(v)))
    }

    #[inline(never)]
    fn try_others(&mut self, v: u32, tried: Option<u32>, most_price: f32) -> Within<()> {
        // Cheaper edges already failed, and nothing changed around them since.
        let least = WAIT_SLACK * self.stretch.node(v).wait;
        let edges = self.edges_at(v)?;
        let others = edges.into_iter().filter(|&(price, edge)| price >= least && Some(edge) != tried);
        let mut next = f32::INFINITY;
        for (price, edge) in others {
            if price > most_price {
                next = price;
                break;
            }
            if !self.is_merged_edge(edge)? && self.try_merge(v, edge)? {
                return Ok(());
            }
        }
        // A change nearby may have made the failed edges possible.
        let pass = self.pass;
        let node = self.stretch.node_mut(v);
        node.wait = if node.changed.is_in(pass) { 0.0 } else { next };
        Ok(())
    }

    /// Returns the prices and numbers of the edges at a vertex, the cheapest first.
    pub fn edges_at(&self, v: u32) -> Within<Vec<(f32, u32)>> {
        let CollapseVertex { corner, degree, .. } = *self.stretch.node(v);
        let mut edges = Vec::with_capacity(degree as usize);
        let mut is_within = self.stretch.corners.holds(corner);
        if !is_within {
            return Err(Beyond);
        }
        self.stretch.walk(v, CornerStep { at: corner, from: next(corner) }, |step| {
            let w = self.stretch.corners.vertex(step.from);
            is_within &= self.stretch.holds(w) && !self.is_special([v, w]);
            if is_within && !self.stretch.is_ghost(w) {
                let price = self.rules.price([v.min(w), v.max(w)].map(|end| self.stretch.node(end))).max(0.0);
                edges.push((price, self.stretch.corners.number_of_edge(step.opposite())));
            }
        })?;
        if !is_within {
            return Err(Beyond);
        }
        edges.retain(|(price, _)| *price < f32::INFINITY);
        edges.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        Ok(edges)
    }

    #[inline(always)]
    fn is_special(&self, ends: [u32; 2]) -> bool {
        !self.is_special.is_empty() && self.stretch.ids(ends).into_iter().any(|id| self.is_special[id as usize])
    }

    /// Merges the other end of the edge opposite `corner` into `u`; returns false if a test forbids it.
    #[inline(always)]
    pub fn try_merge(&mut self, u: u32, corner: u32) -> Within<bool> {
        // The buffers are taken out so that the methods may borrow the merger.
        let mut end_rings = std::mem::take(&mut self.end_rings);
        let done = self.try_merge_with(u, corner, &mut end_rings);
        self.end_rings = end_rings;
        done
    }

    #[inline(always)]
    fn try_merge_with(&mut self, u: u32, corner: u32, end_rings: &mut [EndRing; 2]) -> Within<bool> {
        let ends = self.stretch.edge(corner)?;
        let v = if ends[0] == u { ends[1] } else { ends[0] };
        if self.is_special([u, v]) {
            return Err(Beyond);
        }
        // From cheap to expensive: link condition, placement, constraints, turned faces, shape of the component.
        let Some(opposite) = self.check_link([u, v], corner, end_rings)? else { return Ok(false) };
        let nodes = [self.stretch.node(u), self.stretch.node(v)];
        let pair = self.rules.pair(nodes);
        let Some(merged) = self.rules.placement(nodes, &pair) else { return Ok(false) };
        if self.breaks_constraints([u, v], opposite, end_rings) {
            return Ok(false);
        }
        // The position is rounded before the tests, so that they judge what is stored.
        let x = (nodes[0].position.as_dvec3() + merged.offset).as_vec3();
        if self.would_turn_face([u, v], end_rings, x)
            || self.would_turn_face_in_poses([u, v], end_rings, &pair, merged.offset)
        {
            self.done.was_turn_forbidden = true;
            return Ok(false);
        }
        let ceiling = self.ceiling_after([u, v], end_rings, x);
        if ceiling < 0.0 {
            self.done.was_ceiling_met = true;
            return Ok(false);
        }
        self.merge_vertex_data([u, v], &pair, &merged, x, ceiling);
        self.merge_topology([u, v], corner, end_rings);
        Ok(true)
    }

    #[inline(always)]
    fn breaks_constraints(&self, ends: [u32; 2], opposite: [u32; 2], end_rings: &[EndRing; 2]) -> bool {
        let Some(constraints) = &self.rules.constraints else { return false };
        let [u, v] = self.stretch.ids(ends);
        !constraints.survives_merge(u, v, self.stretch.ids(opposite))
            || constraints.pins.plane().is_some_and(|plane| self.would_break_whole(plane, [u, v], end_rings))
    }

    #[inline(always)]
    fn merge_vertex_data(&mut self, [u, v]: [u32; 2], pair: &Pair, merged: &MergedVertex, x: Vec3, ceiling: f32) {
        // Data of the vertices are merged here, the topology in `merge_topology`.
        let (kept, removed) = (*self.stretch.node(u), *self.stretch.node(v));
        let (ids, place) = ([kept.id, removed.id], merged.place);
        self.done.merges.push((Merge { kept: kept.id, removed: removed.id, place }, ceiling));
        let Rules { constraints, attributes, poses } = &mut *self.rules;
        constraints.iter_mut().for_each(|constraints| constraints.merge(kept.id, removed.id, place));
        let step = (x - kept.position).as_dvec3();
        attributes.merge(ids, pair.other(), step);
        if !poses.is_empty() {
            poses.merge(ids, pair.other(), step);
        }
        let node = self.stretch.node_mut(u);
        (node.position, node.importance) = (x, mean_importance([&kept, &removed]));
    }

    #[inline(always)]
    fn check_link(&mut self, [u, v]: [u32; 2], corner: u32, end_rings: &mut [EndRing; 2]) -> Within<Option<[u32; 2]>> {
        let stretch = &mut self.stretch;
        let across = stretch.corners.corner_across(corner);
        if !stretch.corners.holds(across) {
            return Err(Beyond);
        }
        // An opposite vertex loses a face and must keep three.
        let opposite = [stretch.corners.vertex(corner), stretch.corners.vertex(across)];
        if !opposite.iter().all(|&w| stretch.holds(w)) {
            return Err(Beyond);
        }
        let degrees = [stretch.node(u).degree, stretch.node(v).degree];
        let is_larger = |w: &u32| stretch.node(*w).degree > 3;
        if degrees == [3, 3] || degrees[0] + degrees[1] > MOST_NEIGHBORS || !opposite.iter().all(is_larger) {
            return Ok(None);
        }
        // The neighbours of the first end are stamped; stamped neighbours of the second end are shared.
        self.done.n_link_tests += 1;
        let test = self.done.n_link_tests;
        let [of_u, of_v] = end_rings;
        of_u.gather(stretch, u, corner)?;
        of_v.gather(stretch, v, corner)?;
        for &w in &of_u.ring {
            stretch.get_node_mut(w)?.seen = test;
        }
        let mut n_shared = 0;
        for &w in &of_v.ring {
            n_shared += usize::from(stretch.get_node_mut(w)?.seen == test);
        }
        let has_ghost = |ring: &[u32]| ring.iter().any(|&w| stretch.is_ghost(w));
        // An inner edge between two boundary vertices would pinch the surface.
        let bridges = || end_rings.iter().all(|star| has_ghost(&star.ring)) && !has_ghost(&opposite);
        Ok((n_shared == 2 && !bridges()).then_some(opposite))
    }

    #[inline(always)]
    fn would_turn_face(&self, ends: [u32; 2], end_rings: &[EndRing; 2], x: Vec3) -> bool {
        let place = |w: u32| (!self.stretch.is_ghost(w)).then(|| self.stretch.node(w).position);
        would_turn_face_at(ends[0], &end_rings[0].ring[1..], x, place)
            || would_turn_face_at(ends[1], &end_rings[1].ring[1..], x, place)
    }

    /// Returns whether a face would turn in another pose if both ends merged at `offset` in the present one.
    #[inline(never)]
    fn would_turn_face_in_poses(&self, ends: [u32; 2], end_rings: &[EndRing; 2], pair: &Pair, offset: DVec3) -> bool {
        let poses = &self.rules.poses;
        (0..poses.n_poses()).any(|k| {
            let x = poses.merge_in_pose(k, self.stretch.ids(ends), pair.other(), offset).position;
            let in_pose = |w: u32| poses.vertex_poses(self.stretch.node(w).id)[k].position;
            let place = |w: u32| (!self.stretch.is_ghost(w)).then(|| in_pose(w));
            ends.into_iter().zip(end_rings).any(|(v, star)| would_turn_face_at(v, &star.ring[1..], x, place))
        })
    }

    #[inline(always)]
    fn merge_topology(&mut self, [u, v]: [u32; 2], corner: u32, end_rings: &[EndRing; 2]) {
        let Self { stretch, done, pass, .. } = self;
        // All corners of `v` move to `u`, then the two faces at the edge are removed.
        end_rings[1].corners.iter().for_each(|&c| stretch.corners.set_vertex(c, u));
        for corner in [corner, stretch.corners.corner_across(corner)] {
            let w = stretch.corners.vertex(corner);
            done.n_faces_removed += usize::from(!stretch.is_ghost(w));
            let [at_w, at_u] = stretch.corners.remove_face(corner);
            let opposite = stretch.node_mut(w);
            (opposite.corner, opposite.degree) = (at_w, opposite.degree - 1);
            stretch.node_mut(u).corner = at_u;
        }
        // Neither end counts the other any more, and the two opposite vertices were counted twice.
        stretch.node_mut(u).degree += stretch.node(v).degree - 4;
        stretch.node_mut(v).corner = REMOVED;
        // Faces of the neighbours changed: their quadrics are stale, and edges that failed may work now.
        for &w in end_rings.iter().flat_map(|star| &star.ring) {
            let node = stretch.node_mut(w);
            (node.changed, node.wait) = (node.changed.with_neighbour_change(*pass), 0.0);
        }
        [u, v].into_iter().for_each(|w| stretch.node_mut(w).changed = LastChange::from_merge(*pass));
    }
}

/// Returns whether a face at `v` would turn or lose its area if `v` moved to `x`; `place` returns positions.
#[inline(always)]
fn would_turn_face_at(v: u32, neighbors: &[u32], x: Vec3, place: impl Fn(u32) -> Option<Vec3>) -> bool {
    let Some(p) = place(v) else { return false };
    let mut before: Option<Vec3> = None;
    for &w in neighbors {
        let here = place(w);
        if let (Some(q), Some(r)) = (before, here) {
            // A degenerate face may turn freely; others keep their direction and an area.
            let (old, new) = (area_normal([p, q, r]), area_normal([x, q, r]));
            let along = old.dot(new);
            let least = LEAST_COSINE * LEAST_COSINE * old.length_squared() * new.length_squared();
            let stays = along > 0.0 && along * along > least && has_area(new, [x, q, r]);
            if !stays && has_area(old, [p, q, r]) {
                return true;
            }
        }
        before = here;
    }
    false
}
