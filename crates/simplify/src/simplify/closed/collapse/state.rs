//! State of a collapse.

use glam::Vec3;

use crate::mesh::pulse::Pulse;
use crate::mesh::thread_ranges::indices_where;
use crate::simplify::closed::faces_around::smallest_first;
use crate::simplify::closed::output::Output;
use crate::simplify::closed::prepare::area_weights::AreaWeights;
use crate::simplify::closed::prepare::surface::PreparedSurface;
use crate::simplify::limits::Limit;
use crate::simplify::options::Outcome;
use crate::spatial::curve_order;

use super::attribute_quadrics::AttributeQuadrics;
use super::cheapest_edge::CheapestEdge;
use super::compaction::Compaction;
use super::component_ceilings::Ceilings;
use super::constraints::Constraints;
use super::corner_table::{CornerTable, NONE, renumber_corner};
use super::end_ring::EndRing;
use super::failed_merges::FailedMerges;
use super::history::CollapseEvent;
use super::pair::{CollapseVertex, add_pull};
use super::poses::Poses;
use super::recording::Recording;

/// Value of `corner` in a removed vertex.
pub(super) const REMOVED: u32 = u32::MAX - 1;

const LEAST_REMOVED: usize = 8;
/// Estimated distance of the last merges, at unit size, above which a surface loses its shape.
const MOST_BEND: f64 = 0.01;
/// Least cosine between a face's normals before and after a merge.
// Nineteen meshes, ratios 0.01 to 0.05: at 0 and at 0.4 the largest distance is 2 to 3 % larger.
const LEAST_COSINE: f32 = 0.2;

/// State of a collapse on a closed complex.
///
/// A vertex has an index in `nodes`, which compaction changes, and a fixed number on the surface, its `id`.
#[derive(Clone)]
pub struct Collapse<'a> {
    pub(super) nodes: Vec<CollapseVertex>,
    pub(super) corners: CornerTable,
    /// Surface vertex into which each one was merged; itself if it remains.
    pub(super) merged: Vec<u32>,
    /// Number of nodes that are no ghost vertices; they come first.
    pub(super) n_inner: usize,
    pub n_vertices: usize,
    pub n_faces: usize,
    pub(super) pass: u32,
    pub(super) cheapest: Vec<CheapestEdge>,
    pub(super) n_link_tests: u32,
    pub(super) end_rings: [EndRing; 2],
    pub(super) ceilings: Ceilings,
    /// Failed merges of each surface vertex; empty without ceilings.
    pub(super) failed: Vec<FailedMerges>,
    pub(super) was_ceiling_met: bool,
    pub(super) was_turn_forbidden: bool,
    /// Least cosine between a face's normals before and after a merge.
    pub(super) least_cosine: f32,
    /// Vertices left by each pass that merged some, and its highest price, at unit size.
    pub(super) pass_prices: Vec<(usize, f32)>,
    pub(super) area_weights: AreaWeights,
    pub(super) attributes: AttributeQuadrics,
    pub(super) poses: Poses,
    pub(super) constraints: Option<Constraints>,
    /// Marks surface vertices whose prices depend on more than planes.
    pub(super) is_special: Vec<bool>,
    pub(super) copy: CopyState<'a>,
    pub history: Option<Vec<CollapseEvent>>,
    pub(super) recording: Option<Box<Recording>>,
    pub(super) pulse: Pulse<'a>,
}

#[derive(Clone, Default)]
pub(super) enum CopyState<'a> {
    #[default]
    Unwanted,
    Wanted,
    Kept(Box<Collapse<'a>>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CollapseEnd {
    Reached,
    Smallest,
    WouldTurn,
    LosesShape,
    Held,
    /// Too few free vertices to keep the shape; holds the numbers of held and of all vertices.
    TooFewFree(usize, usize),
}

impl CollapseEnd {
    pub fn outcome(self) -> Outcome {
        match self {
            Self::Reached => Outcome::Reached,
            Self::Smallest => Outcome::Stopped("every component is as small as its topology allows".into()),
            Self::Held => Outcome::Stopped("kept edges or locked vertices allow no further merge".into()),
            Self::TooFewFree(held, all) => Outcome::Stopped(format!(
                "{held} of {all} vertices are on kept or locked edges, and merging the others would damage the shape"
            )),
            Self::LosesShape => Outcome::Stopped(
                "further merges would change the shape of components too much or break another constraint".into(),
            ),
            Self::WouldTurn => Outcome::Stopped("every remaining merge would flip a face".into()),
        }
    }
}

pub fn merges_to(limit: Limit, n_vertices: usize, n_faces: usize) -> usize {
    // A merge removes one vertex and, except at a boundary, two faces.
    n_vertices.saturating_sub(limit.vertices).max(n_faces.saturating_sub(limit.faces).div_ceil(2))
}

/// Estimates the smallest size that keeps the shape by the prices of a collapse from `n_input` vertices; `None` if its result does.
///
/// A price is an area times a squared distance, and the area around a vertex its share of the whole.
pub fn size_with_shape(
    pass_prices: &[(usize, f32)],
    n_input: usize,
    [n_vertices, n_faces]: [usize; 2],
    area: f64,
) -> Option<(usize, usize)> {
    let keeps_shape = |&(n, price): &(usize, f32)| f64::from(price) * n as f64 <= MOST_BEND * MOST_BEND * area;
    let first = pass_prices.iter().position(|pass| !keeps_shape(pass))?;
    let vertices = if first > 0 { pass_prices[first - 1].0 } else { n_input };
    // A merge removes two faces, but for those at boundaries.
    Some((vertices, n_faces + 2 * (vertices - n_vertices)))
}

/// Builds the corner table of a closed surface; node `i` is vertex `order[i]`.
fn corners_in_order(surface: &PreparedSurface, order: &[u32]) -> CornerTable {
    // Surface vertices get their rank along the space-filling curve. Ghost vertices follow them and keep their numbers.
    let mut rank = vec![0; order.len()];
    (0u32..).zip(order).for_each(|(i, &v)| rank[v as usize] = i);
    let n_ghosts = surface.rings.n_ghosts();
    let ghost_faces = if n_ghosts > 0 { surface.rings.ghost_faces() } else { Vec::new() };
    let by_rank = |face: &[u32; 3]| face.map(|v| rank.get(v as usize).copied().unwrap_or(v));
    CornerTable::new(order.len() + n_ghosts, surface.faces.iter().chain(&ghost_faces).map(by_rank))
}

fn node_of(surface: &PreparedSurface, v: u32) -> CollapseVertex {
    let importance = surface.importance.get(v as usize).copied().unwrap_or(1.0);
    CollapseVertex::new(surface.positions[v as usize], add_pull(surface.quadrics[v as usize]), importance, v)
}

impl<'a> Collapse<'a> {
    pub fn new(pulse: Pulse<'a>, surface: &PreparedSurface) -> Self {
        let n_inner = surface.n_vertices();
        // Neighbours in space become neighbours in memory.
        let order = curve_order(n_inner, |v| surface.positions[v as usize].to_array(), || pulse.beat(0));
        let corners = corners_in_order(surface, &order);
        pulse.beat(0);
        let mut nodes: Vec<CollapseVertex> = pulse.counting_if(false).map(&order, |&v| node_of(surface, v));
        nodes.extend((0..surface.rings.n_ghosts()).map(|_| CollapseVertex::ghost()));
        // Any corner of a vertex serves as the start of walks around it.
        for c in corners.corners() {
            let node = &mut nodes[corners.vertex(c) as usize];
            (node.corner, node.degree) = (c, node.degree + 1);
        }
        pulse.beat(0);
        Self {
            nodes,
            corners,
            merged: (0..n_inner as u32).collect(),
            n_inner,
            n_vertices: n_inner,
            n_faces: surface.faces.len(),
            pass: 1,
            cheapest: Vec::new(),
            n_link_tests: 0,
            end_rings: Default::default(),
            ceilings: Ceilings::default(),
            failed: Vec::new(),
            was_ceiling_met: false,
            was_turn_forbidden: false,
            least_cosine: LEAST_COSINE,
            pass_prices: Vec::new(),
            area_weights: surface.area_weights,
            attributes: AttributeQuadrics::default(),
            poses: Poses::default(),
            constraints: None,
            is_special: Vec::new(),
            copy: CopyState::Unwanted,
            history: None,
            recording: None,
            pulse,
        }
    }

    pub fn with_ceilings(self, ceilings: Ceilings) -> Self {
        Self { failed: vec![FailedMerges::NONE; ceilings.left.len()], ceilings, ..self }
    }

    pub fn with_constraints(
        self,
        constraints: Option<Constraints>,
        attributes: AttributeQuadrics,
        poses: Poses,
        history: Option<Vec<CollapseEvent>>,
    ) -> Self {
        let mut collapse = Self { constraints, attributes, poses, history, ..self };
        // Vertices with special prices are marked once, so that pricing skips all lookups at the others.
        if collapse.constraints.is_some() || !collapse.attributes.is_empty() || !collapse.poses.is_empty() {
            let has_more = |v| !collapse.poses.is_empty() || collapse.attributes.has_quadric_at(v);
            let is_special = |v| has_more(v) || collapse.constraints.as_ref().is_some_and(|it| it.affects(v));
            collapse.is_special = (0..collapse.merged.len() as u32).map(is_special).collect();
        }
        if !collapse.poses.is_empty() {
            (0..collapse.n_inner as u32).for_each(|v| collapse.renew_poses(v));
        }
        collapse
    }

    /// Estimates the smallest size, in vertices and faces, at which the surface keeps its shape; `None` if it does now.
    pub fn size_with_shape(&self, area: f64) -> Option<(usize, usize)> {
        size_with_shape(&self.pass_prices, self.merged.len(), [self.n_vertices, self.n_faces], area)
    }

    pub fn free_memory(self) {
        // Freeing the memory of millions of vertices takes a while, so it is split into steps with beats between them.
        let Self { nodes, corners, pulse, .. } = self;
        pulse.beat(0);
        drop(nodes);
        pulse.beat(0);
        drop(corners);
        pulse.beat(0);
    }

    /// Returns the remaining mesh in the order of surface vertices; faces begin with their smallest vertices.
    pub fn output(&self) -> Output {
        let pulse = self.pulse.counting_if(false);
        // The output keeps the order of surface vertices, whatever order the collapse has in memory.
        let remaining = indices_where(pulse, &self.merged, |v, &merged| v == merged);
        let mut number = vec![NONE; self.merged.len()];
        (0u32..).zip(&remaining).for_each(|(i, &v)| number[v as usize] = i);
        let mut positions = vec![Vec3::ZERO; remaining.len()];
        for node in self.nodes[..self.n_inner].iter().filter(|node| node.corner != REMOVED) {
            positions[number[node.id as usize] as usize] = node.position;
        }
        pulse.beat(0);
        let by_number = |face: [u32; 3]| smallest_first(face.map(|v| number[self.nodes[v as usize].id as usize]));
        let faces: Vec<[u32; 3]> = self.own_faces().map(by_number).collect();
        pulse.beat(0);
        let vertex_of = pulse.map_numbers(self.merged.len(), |v| number[self.final_vertex(v as u32) as usize]);
        let pins = self.constraints.as_ref().map(|constraints| constraints.pins.select(&remaining));
        let has_free_curves = self.constraints.as_ref().is_some_and(Constraints::are_curves_soft);
        Output::new(pulse, positions, faces, pins.unwrap_or_default(), vertex_of).with_free_curves(has_free_curves)
    }

    pub fn n_surface_vertices(&self) -> usize {
        self.merged.len()
    }

    /// Counts the vertices and faces that each of `n` components has left, by the component of each surface vertex.
    pub fn count_by_component(&self, component_of_vertex: &[u32], n: usize) -> Vec<[usize; 2]> {
        let mut sizes = vec![[0; 2]; n];
        let vertices = (0u32..).zip(&self.merged).filter(|(v, merged)| v == *merged);
        vertices.for_each(|(v, _)| sizes[component_of_vertex[v as usize] as usize][0] += 1);
        for [v, _, _] in self.own_faces() {
            sizes[component_of_vertex[self.nodes[v as usize].id as usize] as usize][1] += 1;
        }
        sizes
    }

    /// Lists the faces that are no ghosts: these only closed the boundaries.
    fn own_faces(&self) -> impl Iterator<Item = [u32; 3]> {
        self.corners.faces().filter(|face| face.iter().all(|&v| !self.is_ghost(v)))
    }

    pub(super) fn final_vertex(&self, mut v: u32) -> u32 {
        while self.merged[v as usize] != v {
            v = self.merged[v as usize];
        }
        v
    }

    pub(super) fn compact(&mut self) {
        // Moving all rows pays only if enough vertices were removed.
        if (self.n_inner - self.n_vertices) * LEAST_REMOVED <= self.nodes.len() {
            return;
        }
        let vertices = Compaction::new(self.nodes.len(), |v| self.nodes[v].corner != REMOVED);
        // Faces move first, since vertices and cheapest edges refer to corners.
        let faces = self.corners.compact(vertices.numbers());
        let faces = faces.numbers();
        let with_corner = |node: CollapseVertex| match node.corner {
            NONE => node,
            corner => CollapseVertex { corner: renumber_corner(faces, corner), ..node },
        };
        vertices.compact_rows(&mut self.nodes, with_corner);
        self.recording.iter_mut().for_each(|recording| recording.compact(&vertices));
        self.nodes.truncate(vertices.len());
        vertices.compact_rows(&mut self.cheapest, |cheapest| cheapest.renumber(faces));
        self.cheapest.truncate(self.n_vertices);
        self.n_inner = self.n_vertices;
    }

    pub(super) fn remaining(&self) -> impl Iterator<Item = u32> {
        (0..self.n_inner as u32).filter(|&v| self.nodes[v as usize].corner != REMOVED)
    }

    pub(super) fn is_ghost(&self, v: u32) -> bool {
        v as usize >= self.n_inner
    }

    pub(super) fn has_reached(&self, limit: Limit) -> bool {
        self.n_vertices <= limit.vertices && self.n_faces <= limit.faces
    }

    pub fn pass_prices(&self) -> &[(usize, f32)] {
        &self.pass_prices
    }

    pub fn n_held(&self) -> usize {
        let Some(constraints) = &self.constraints else { return 0 };
        self.remaining().filter(|&v| constraints.is_held(self.nodes[v as usize].id)).count()
    }

    pub fn without_constraints(self) -> Self {
        Self { constraints: self.constraints.and_then(Constraints::without_curves), history: None, ..self }
    }

    pub fn without_progress(self) -> Self {
        Self { pulse: self.pulse.counting_if(false), ..self }
    }

    /// Returns the numbers of vertices and faces.
    pub fn size(&self) -> (usize, usize) {
        (self.n_vertices, self.n_faces)
    }

    pub fn merges_to(&self, limit: Limit) -> usize {
        let (n_vertices, n_faces) = self.size();
        let least = merges_to(limit, n_vertices, n_faces);
        // The degree of a ghost vertex is the length of its boundary.
        let n_boundary: usize = self.nodes[self.n_inner..].iter().map(|ghost| ghost.degree as usize).sum();
        if n_boundary == 0 || n_faces <= limit.faces {
            return least;
        }
        let share = (n_boundary as f64 / n_vertices.max(1) as f64).min(1.0);
        least.max(((n_faces - limit.faces) as f64 / (2.0 - share)) as usize)
    }
}
