//! Memoryless quadrics (Lindstrom and Turk 1999, "Evaluation of memoryless simplification"): sums over the present
//! faces.

use glam::Vec3;

use crate::linalg::{Isa, Work};
use crate::mesh::pulse::PARALLEL;
use crate::mesh::thread_ranges::indices_where;
use crate::parallel;
use crate::simplify::closed::prepare::area_weights::AreaWeights;
use crate::simplify::closed::prepare::surface::{add, line_along, plane_of, planes_around};

use super::corner_table::{CornerStep, next};
use super::history::{CollapseEvent, GHOST, Renewal};
use super::pair::{CollapseVertex, add_growing_pull, add_pull};
use super::state::{Collapse, REMOVED};

const CHUNK: usize = 1024;

struct PlaneSumTask<'a, 'b> {
    collapse: &'a Collapse<'b>,
    planes: &'a mut [[f32; 6]],
    vertices: &'a [u32],
}

impl Work for PlaneSumTask<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (planes, &v) in self.planes.iter_mut().zip(self.vertices) {
            *planes = self.collapse.sum_planes(v);
        }
    }
}

impl Collapse<'_> {
    /// Recomputes the quadrics of the vertices that changed in the last pass; returns these vertices.
    pub(super) fn renew_quadrics(&mut self) -> Vec<u32> {
        let pass = self.pass;
        // A vertex is stale if it or a neighbour was merged in the last pass.
        let is_stale = |_: u32, node: &CollapseVertex| node.corner != REMOVED && node.changed.is_in(pass);
        let stale = indices_where(self.pulse.counting_if(false), &self.nodes[..self.n_inner], is_stale);
        let mut planes = vec![[0.0; 6]; stale.len()];
        parallel::each(planes.chunks_mut(CHUNK).zip(stale.chunks(CHUNK)), |(planes, stale)| {
            self.pulse.beat(0);
            Isa::best().run(PlaneSumTask { collapse: self, planes, vertices: stale });
        });
        let growing_pull = self.poses.growing_pull();
        // `stale` ascends, so each chunk of nodes has a range of it.
        let first = |chunk: usize| stale.partition_point(|&v| (v as usize) < chunk * PARALLEL);
        parallel::chunks_mut(&mut self.nodes, PARALLEL, |chunk, nodes| {
            let range = first(chunk)..first(chunk + 1);
            for (&v, planes) in stale[range.clone()].iter().zip(&planes[range]) {
                let node = &mut nodes[v as usize - chunk * PARALLEL];
                // Importance multiplies the planes; the pull is added afterwards.
                node.planes = add_growing_pull(planes.map(|entry| entry * node.importance), growing_pull);
            }
        });
        if !self.poses.is_empty() {
            stale.iter().for_each(|&v| self.renew_poses(v));
        }
        if self.history.is_some() {
            stale.iter().for_each(|&v| self.record_renewal(v));
        }
        stale
    }

    pub(super) fn ring(&self, v: u32) -> Vec<u32> {
        self.neighbors(v).collect()
    }

    #[inline(always)]
    pub(super) fn neighbors(&self, v: u32) -> impl Iterator<Item = u32> {
        self.faces_around(v).map(|step| self.corners.vertex(step.from))
    }

    #[inline(always)]
    pub(super) fn faces_around(&self, v: u32) -> impl Iterator<Item = CornerStep> {
        let CollapseVertex { corner, degree, .. } = self.nodes[v as usize];
        let first = (degree > 0).then(|| CornerStep { at: corner, from: next(corner) });
        first.into_iter().flat_map(|first| self.corners.walk_around(first))
    }

    #[inline(never)]
    pub(super) fn renew_poses(&mut self, v: u32) {
        let ring = self.ring(v);
        let CollapseVertex { id, importance, .. } = self.nodes[v as usize];
        for k in 0..self.poses.n_poses() {
            // Connectivity is shared by all poses, positions are not.
            let neighbour =
                |&w: &u32| (!self.is_ghost(w)).then(|| self.poses.vertex_poses(self.nodes[w as usize].id)[k].position);
            let planes =
                planes_around(self.poses.vertex_poses(id)[k].position, ring.iter().map(neighbour), self.area_weights);
            self.poses.vertex_poses_mut(id)[k].planes = add_pull(planes.map(|entry| entry * importance));
        }
    }

    fn record_renewal(&mut self, v: u32) {
        let CollapseVertex { id, importance, position, .. } = self.nodes[v as usize];
        let ring = self.ring(v);
        let place = |i: usize| (!self.is_ghost(ring[i])).then(|| self.nodes[ring[i] as usize].position);
        let ids = ring.iter().map(|&w| if self.is_ghost(w) { GHOST } else { self.nodes[w as usize].id });
        let renewal = Renewal::new(id, ids.collect(), position, place, [importance, self.poses.growing_pull()]);
        self.history.get_or_insert_default().push(CollapseEvent::Renewal(renewal));
    }

    #[inline(always)]
    fn sum_planes(&self, v: u32) -> [f32; 6] {
        let CollapseVertex { position, corner, degree, .. } = self.nodes[v as usize];
        // The common case is one walk without allocations. Folds and constraints take the general sum.
        if self.constraints.is_none() && degree > 0 {
            let place = |corner: u32| {
                let w = self.corners.vertex(corner);
                (!self.is_ghost(w)).then(|| self.nodes[w as usize].position - position)
            };
            let (mut fan, mut before) =
                (Fan { area_weights: self.area_weights, ..Fan::default() }, place(next(corner)));
            for step in self.corners.walk_around(CornerStep { at: corner, from: next(corner) }) {
                let here = place(step.opposite());
                fan.add([before, here]);
                before = here;
            }
            // Without opposing faces there is no fold.
            if !fan.may_fold() {
                return fan.planes;
            }
        }
        self.sum_planes_with_folds(v)
    }

    #[inline(never)]
    fn sum_planes_with_folds(&self, v: u32) -> [f32; 6] {
        let node = &self.nodes[v as usize];
        let mut ring = Vec::with_capacity(node.degree as usize);
        let place = |w: u32| (!self.is_ghost(w)).then(|| self.nodes[w as usize].position);
        ring.extend(self.neighbors(v).map(place));
        planes_around(node.position, ring.iter().copied(), self.area_weights)
    }
}

#[derive(Default)]
struct Fan {
    planes: [f32; 6],
    area_weights: AreaWeights,
    first: Option<Vec3>,
    last: Vec3,
    has_opposed_faces: bool,
}

impl Fan {
    /// Adds a face by its other two corners, relative to the vertex; `None` is a ghost vertex.
    #[inline(always)]
    fn add(&mut self, corners: [Option<Vec3>; 2]) {
        // A ghost vertex is the outside: an edge next to it is a boundary edge.
        let mut normal = Vec3::ZERO;
        match corners {
            [Some(p), Some(q)] => {
                if let Some((of_face, plane)) = plane_of([Vec3::ZERO, p, q], self.area_weights) {
                    add(&mut self.planes, &plane);
                    normal = of_face;
                }
            }
            [Some(end), None] | [None, Some(end)] => add(&mut self.planes, &line_along(end)),
            [None, None] => {}
        }
        self.has_opposed_faces |= self.last.dot(normal) < 0.0;
        self.first = self.first.or(Some(normal));
        self.last = normal;
    }

    #[inline(always)]
    fn may_fold(&self) -> bool {
        self.has_opposed_faces || self.first.is_some_and(|first| self.last.dot(first) < 0.0)
    }
}
