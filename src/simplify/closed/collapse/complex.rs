//! A closed complex being collapsed: its vertices, their neighbours, and what is left of them.

use glam::Vec3;
use rayon::prelude::*;

use crate::mesh::OneRings;
use crate::mesh::pulse::{PARALLEL, Pulse};
use crate::mesh::shares::indices_where;
use crate::simplify::closed::cluster::assignment::Assignment;
use crate::simplify::closed::cluster::placement::Placement;
use crate::simplify::closed::output::Output;
use crate::simplify::limits::Limit;
use crate::simplify::options::Outcome;

use super::attribute_quadrics::AttributeQuadrics;
use super::constraints::Constraints;
use super::history::Event;
use super::links::{Links, Span};
use super::pair::Node;
use super::poses::Poses;

/// No vertex.
pub(super) const NONE: u32 = u32::MAX;

/// A closed complex being collapsed.
#[derive(Clone)]
pub struct Collapse<'a> {
    /// Vertices, the ghost vertices of the boundaries last.
    pub(super) nodes: Vec<Node>,
    /// Where the vertices are: what the nodes say, once more and closer together.
    pub(super) positions: Vec<Vec3>,
    /// The neighbours of the vertices; those of the ghost vertices and of hubs are not kept.
    pub(super) links: Links,
    /// The vertex each vertex was merged into, itself while it lives.
    pub(super) merged: Vec<u32>,
    pub(super) n_inner: usize,
    pub(super) n_vertices: usize,
    pub(super) n_faces: usize,
    /// The price at which each vertex is to be merged with its partner; infinite for those that may not go.
    pub(super) least: Vec<f32>,
    /// The vertices whose prices are not known; `None` where no price is.
    pub(super) unpriced: Option<Vec<u32>>,
    /// The vertices whose turn it is in a round.
    pub(super) turn: Vec<u32>,
    /// Whether each vertex belongs to no edge that may go; empty where all may.
    pub(super) frozen: Vec<bool>,
    /// How far merges may still leave each vertex from the surface after them, n_inner; empty where that is no matter.
    pub(super) ceilings: Vec<f32>,
    /// Whether a ceiling kept an edge that could go.
    pub(super) ceiling_met: bool,
    /// For each vertex at the start the one it was when these vertices were numbered; empty where they are the same.
    pub(super) begun: Vec<u32>,
    pub(super) turn_forbidden: bool,
    /// How many vertices each round left that merged some, and up to which price.
    pub(super) paid: Vec<(usize, f32)>,
    /// Whether every price is kept that of the present surface.
    pub(super) is_last_stretch: bool,
    /// What merges cost the colours and normals at the corners, if there are any.
    pub(super) attributes: AttributeQuadrics,
    /// What merges cost other poses, if there are any.
    pub(super) poses: Poses,
    /// What constrains it beside the topology.
    pub(super) constraints: Option<Constraints>,
    /// The copy of itself from an earlier round, if one is wanted.
    pub(super) copy: OwnCopy<'a>,
    /// What happened, in order, where that is to be remembered.
    pub history: Option<Vec<Event>>,
    /// Who listens: the items done are merges.
    pub(super) pulse: Pulse<'a>,
}

/// The copy that a collapse makes of itself in an early round.
#[derive(Clone, Default)]
pub(super) enum OwnCopy<'a> {
    /// It does not.
    #[default]
    Unwanted,
    /// It will.
    Wanted,
    /// It did.
    Kept(Box<Collapse<'a>>),
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At the limit.
    Reached,
    /// Every edge that is left holds the topology: components are at their smallest.
    Smallest,
    /// The same in one half of a mirrored mesh.
    SmallestMirrored,
    /// The edges that could go would turn a face over.
    WouldTurn,
    /// The edges that could go would take the shape of their component.
    LosesShape,
    /// What has to stay leaves no edge that could go.
    Held,
    /// Before what has to stay would take the vertices that the surface needs: so many of so many vertices.
    WouldRuin(usize, usize),
}

impl End {
    /// What the caller is told.
    pub fn outcome(self) -> Outcome {
        match self {
            Self::Reached => Outcome::Reached,
            Self::Smallest => Outcome::Stopped("every component is as small as its topology allows".into()),
            Self::SmallestMirrored => {
                Outcome::Stopped("every component is as small as its topology and the mirror plane allow".into())
            }
            Self::Held => Outcome::Stopped("kept edges or locked vertices allow no further merge".into()),
            Self::WouldRuin(held, all) => Outcome::Stopped(format!(
                "{held} of {all} vertices are on edges that are held or locked, and with fewer the rest would be ruined"
            )),
            Self::LosesShape => Outcome::Stopped("with fewer vertices components would lose their shape".into()),
            Self::WouldTurn => Outcome::Stopped("every remaining merge would turn a face over".into()),
        }
    }
}

/// The merges without which so many vertices and faces do not come to the limit: each takes away two faces at most.
pub fn merges_to(limit: Limit, n_vertices: usize, n_faces: usize) -> usize {
    n_vertices.saturating_sub(limit.vertices).max(n_faces.saturating_sub(limit.faces).div_ceil(2))
}

/// The ghost vertices, each with as many neighbours as there are vertices on its boundary, and the faces of a surface with these
/// rings, those at ghost vertices left out.
pub(super) fn ghosts(rings: &OneRings) -> (Vec<Node>, usize) {
    let n_inner = rings.n_vertices();
    let mut n_neighbors = vec![0; rings.n_ghosts()];
    if rings.n_ghosts() > 0 {
        let at_ghosts = (0..n_inner as u32).filter_map(|v| rings.ghost(v));
        at_ghosts.for_each(|ghost| n_neighbors[ghost as usize - n_inner] += 1);
    }
    let at_ghosts: usize = n_neighbors.iter().map(|n| *n as usize).sum();
    let ghosts = n_neighbors.into_iter().map(|len| Node { ring: Span::unlisted(len), ..Node::default() });
    (ghosts.collect(), (rings.n_entries() - 2 * at_ghosts) / 3)
}

impl<'a> Collapse<'a> {
    /// Starts from the placed vertices and the rings of the faces over them.
    pub fn new(pulse: Pulse<'a>, placed: &Placement, rings: &OneRings) -> Self {
        let n_inner = rings.n_vertices();
        let mut links = Links::with_capacity(n_inner);
        let mut node = |v: usize| Node::new(placed, v as u32, links.push(rings.ring(v as u32).iter().copied()));
        let (ghosts, n_faces) = ghosts(rings);
        let mut nodes: Vec<Node> = Vec::with_capacity(n_inner + ghosts.len());
        for vertices in pulse.counting_if(false).through(0..n_inner) {
            nodes.extend(vertices.map(&mut node));
        }
        nodes.extend(ghosts);
        Self::of(pulse, nodes, links, n_inner, n_faces)
    }

    /// The same, where merges together may not leave a vertex farther from the surface than its ceiling, n_inner; any may where they are empty.
    pub fn below(self, ceilings: Vec<f32>) -> Self {
        Self { ceilings, ..self }
    }

    /// The same under constraints, with a price on colours, normals and other poses, and with a history if there is one to be written.
    pub fn under(
        self,
        constraints: Option<Constraints>,
        attributes: AttributeQuadrics,
        poses: Poses,
        history: Option<Vec<Event>>,
    ) -> Self {
        let mut under = Self { constraints, attributes, poses, history, ..self };
        if !under.poses.is_empty() {
            (0..under.n_inner as u32).for_each(|v| under.renew_poses(v));
        }
        under
    }

    /// Starts from nodes, the ghost vertices last, and their neighbours; so many vertices and faces.
    pub(super) fn of(pulse: Pulse<'a>, nodes: Vec<Node>, links: Links, n_inner: usize, n_faces: usize) -> Self {
        let mut positions = Vec::with_capacity(n_inner);
        for nodes in pulse.counting_if(false).over(&nodes[..n_inner]) {
            positions.extend(nodes.iter().map(|node| node.position));
        }
        Self {
            positions,
            merged: (0..n_inner as u32).collect(),
            nodes,
            links,
            n_inner,
            n_vertices: n_inner,
            n_faces,
            least: vec![f32::INFINITY; n_inner],
            unpriced: None,
            turn: Vec::new(),
            frozen: Vec::new(),
            ceilings: Vec::new(),
            ceiling_met: false,
            begun: Vec::new(),
            turn_forbidden: false,
            paid: Vec::new(),
            is_last_stretch: false,
            attributes: AttributeQuadrics::default(),
            poses: Poses::default(),
            constraints: None,
            copy: OwnCopy::Unwanted,
            history: None,
            pulse,
        }
    }

    /// Gives the memory back, in parts: that of millions of vertices takes a while.
    pub fn end(self) {
        let Self { nodes, links, pulse, .. } = self;
        pulse.beat(0);
        drop(nodes);
        pulse.beat(0);
        drop(links);
        pulse.beat(0);
    }

    /// What is left, renumbered; each face begins with its first vertex. `assignment` says which vertex each of the surface's was
    /// at the start.
    pub fn output(&self, assignment: &Assignment) -> Output {
        let pulse = self.pulse.counting_if(false);
        let living = indices_where(pulse, &self.merged, |v, &merged| v == merged);
        let mut number = vec![NONE; self.n_inner];
        (0u32..).zip(&living).for_each(|(i, &v)| number[v as usize] = i);
        let place = |&v: &u32| self.positions[v as usize];
        let positions: Vec<Vec3> = pulse.map(&living, place);
        let faces: Vec<Vec<[u32; 3]>> =
            living.par_chunks(PARALLEL).map(|chunk| self.faces_from(chunk, &number)).collect();
        let faces = faces.concat();
        let of_regions = self.vertex_of_regions(&number);
        let vertex_of = pulse.map(&assignment.region, |&region| of_regions[region as usize]);
        let pins = self.constraints.as_ref().map(|constraints| constraints.pins.of_living(&living));
        Output::new(pulse, positions, faces, pins.unwrap_or_default(), vertex_of)
    }

    /// For each vertex at the start the number of the one that stands for it now.
    fn vertex_of_regions(&self, number: &[u32]) -> Vec<u32> {
        let last = |v: u32| number[self.last(v) as usize];
        match self.begun.as_slice() {
            [] => self.pulse.counting_if(false).map_numbers(self.n_inner, |v| last(v as u32)),
            begun => self.pulse.counting_if(false).map(begun, |&v| last(v)),
        }
    }

    /// The faces whose first vertices these are, those at ghost vertices left out, by the numbers of their vertices.
    pub(super) fn faces_from(&self, vertices: &[u32], number: &[u32]) -> Vec<[u32; 3]> {
        self.pulse.beat(0);
        let mut faces = Vec::with_capacity(2 * vertices.len());
        for &v in vertices {
            let span = self.nodes[v as usize].ring;
            if span.is_unlisted() {
                continue;
            }
            // Faces at a vertex without a list are found at their others.
            let is_behind = |w: u32| v < w || self.is_frozen(w);
            let mut last = span.len().checked_sub(1).map_or(NONE, |last| self.links.at(span, last));
            for w in self.links.of(span) {
                if is_behind(last) && is_behind(w) && !self.is_ghost(last.max(w)) {
                    faces.push([v, last, w].map(|v| number[v as usize]));
                }
                last = w;
            }
        }
        faces
    }

    /// The vertex that stands for `v` now.
    pub(super) fn last(&self, mut v: u32) -> u32 {
        while self.merged[v as usize] != v {
            v = self.merged[v as usize];
        }
        v
    }

    pub(super) fn living(&self) -> impl Iterator<Item = u32> {
        (0..self.n_inner as u32).filter(|&v| self.merged[v as usize] == v)
    }

    pub(super) fn ring(&self, v: u32) -> impl ExactSizeIterator<Item = u32> + Clone {
        self.links.of(self.nodes[v as usize].ring)
    }

    pub(super) fn is_ghost(&self, v: u32) -> bool {
        v as usize >= self.n_inner
    }

    pub(super) fn is_frozen(&self, v: u32) -> bool {
        self.frozen.get(v as usize).is_some_and(|frozen| *frozen)
    }

    pub(super) fn reached(&self, limit: Limit) -> bool {
        let (n_vertices, n_faces) = self.size();
        n_vertices <= limit.vertices && n_faces <= limit.faces
    }

    /// How many vertices rounds of merges left, falling, and up to which price each went: squared distances times area, on the surface
    /// of unit size.
    pub fn paid(&self) -> &[(usize, f32)] {
        &self.paid
    }

    /// Whether merges may not leave vertices far from the surface: what is held ruins nothing then.
    pub fn has_ceilings(&self) -> bool {
        !self.ceilings.is_empty()
    }

    /// How many vertices are on held curves or locked; where this is one half of a mirrored mesh, at most so many of the whole.
    pub fn n_held(&self) -> usize {
        let Some(constraints) = &self.constraints else { return 0 };
        let n = self.living().filter(|&v| constraints.is_held(v)).count();
        if self.plane().is_some() { 2 * n } else { n }
    }

    /// The same complex with nothing held but by the plane of a half.
    pub fn bare(self) -> Self {
        Self { constraints: self.constraints.and_then(Constraints::bare), history: None, ..self }
    }

    /// The same complex, whose merges do not count as done.
    pub fn uncounted(self) -> Self {
        Self { pulse: self.pulse.counting_if(false), ..self }
    }

    /// Vertices and faces; where this is one half of a mirrored mesh, those of the whole.
    pub fn size(&self) -> (usize, usize) {
        match self.plane() {
            None => (self.n_vertices, self.n_faces),
            Some(plane) => (2 * self.n_vertices - plane.len(), 2 * self.n_faces),
        }
    }
}
