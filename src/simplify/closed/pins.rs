//! What may not move: vertices that are locked, all vertices where the result is a subset of the mesh's, and the vertices on
//! the plane of a half, which stay on it.
//!
//! Pins begin over the vertices of the surface and are carried over to those of the collapse and of the output.

use glam::DVec3;

use super::prepare::surface::Surface;
use super::request::{Half, Keep};

/// Which vertices may not move, over those of the surface, of a collapse or of an output.
#[derive(Clone, Debug, Default)]
pub struct Pins {
    /// Whether each vertex stays where it is; empty where all may go.
    locked: Vec<bool>,
    /// Whether edges between two such vertices stay edges.
    holds_edges: bool,
    /// Whether the vertices have to lie on vertices of the mesh.
    subset: bool,
    /// The vertex of the surface that each vertex lies on, while it lies on one; empty over the surface itself.
    origin: Vec<u32>,
    plane: Option<PlaneVertices>,
}

impl Pins {
    /// Takes what has to stay over to the vertices of the surface, where some are copies.
    pub fn on(surface: &Surface, keep: &Keep) -> Self {
        let is_locked = |v: u32| keep.locked[v as usize];
        let locked = if keep.locked.is_empty() { Vec::new() } else { surface.sources().map(is_locked).collect() };
        let plane = keep.half.map(|half| PlaneVertices::of(surface, &half));
        Self { locked, holds_edges: !keep.kept.is_empty(), subset: keep.subset, origin: Vec::new(), plane }
    }

    /// Those of a subset in which nothing is locked.
    #[cfg(test)]
    pub fn of_a_subset() -> Self {
        Self { subset: true, ..Self::default() }
    }

    /// Whether nothing is pinned.
    pub fn is_empty(&self) -> bool {
        self.locked.is_empty() && !self.subset && self.plane.is_none()
    }

    /// Whether anything is pinned beside the plane of a half.
    pub fn hold_more_than_plane(&self) -> bool {
        self.subset || self.plane.is_none() || self.locked.contains(&true)
    }

    /// For so many vertices of a collapse, which are those of the surface, each on itself.
    pub fn on_own_vertices(&self, n_vertices: usize) -> Self {
        let vertices = 0..n_vertices as u32;
        let locked = vertices.clone().map(|v| self.is_locked(v)).collect();
        Self { locked, origin: vertices.collect(), ..self.clone() }
    }

    /// The same with nothing locked.
    pub fn unlocked(self) -> Self {
        Self { locked: vec![false; self.locked.len()], ..self }
    }

    /// For some of the vertices, in this order.
    pub fn of_living(&self, living: &[u32]) -> Self {
        Self {
            locked: living.iter().map(|&v| self.is_locked(v)).collect(),
            holds_edges: self.holds_edges,
            subset: self.subset,
            origin: living.iter().map(|&v| self.origin[v as usize]).collect(),
            plane: self.plane.as_ref().map(|plane| plane.of_living(living)),
        }
    }

    /// The vertices that stay where they are.
    pub fn locked_vertices(&self) -> impl Iterator<Item = u32> {
        (0..self.locked.len() as u32).filter(|&v| self.locked[v as usize])
    }

    /// Whether a vertex stays where it is.
    pub fn is_locked(&self, v: u32) -> bool {
        self.locked.get(v as usize).is_some_and(|&locked| locked)
    }

    /// Whether the edge between two vertices stays one.
    pub fn hold_edge(&self, u: u32, v: u32) -> bool {
        self.holds_edges && self.is_locked(u) && self.is_locked(v)
    }

    /// Whether a vertex stays where it is, or on the plane.
    pub fn has(&self, v: u32) -> bool {
        self.is_locked(v) || self.is_on_cut(v)
    }

    /// Whether the vertices have to lie on vertices of the mesh.
    pub fn is_subset(&self) -> bool {
        self.subset
    }

    /// Whether the vertices may move apart where their positions coincide: of the halves of a mirrored mesh they do so together,
    /// and those of a subset stay.
    pub fn let_duplicates_move(&self) -> bool {
        !self.subset && self.plane.is_none()
    }

    /// The vertices on the plane, where this is one half of a mirrored mesh.
    pub fn plane(&self) -> Option<&PlaneVertices> {
        self.plane.as_ref()
    }

    /// Whether a vertex stays on the plane.
    pub fn is_on_cut(&self, v: u32) -> bool {
        self.plane.as_ref().is_some_and(|plane| plane.has(v))
    }

    /// Whether two vertices stay on the plane: their edge is one of the cut, and no other may join them.
    pub fn are_on_cut(&self, u: u32, v: u32) -> bool {
        self.is_on_cut(u) && self.is_on_cut(v)
    }

    /// The vertex of the surface that each vertex lies on, while it lies on one; empty where nothing is pinned.
    pub fn origins(&self) -> &[u32] {
        &self.origin
    }

    /// Gives the vertices of the surface that vertices lie on other numbers.
    pub fn renumber_origins(&mut self, number: impl Fn(u32) -> u32) {
        self.origin.iter_mut().for_each(|v| *v = number(*v));
    }

    /// Takes note that a vertex lies on this one of the surface now.
    pub fn set_origin(&mut self, v: u32, origin: u32) {
        self.origin[v as usize] = origin;
    }

    /// Takes note that `v` was merged into `u`, and whether `u` then went to where `v` was.
    pub fn merge(&mut self, u: u32, v: u32, goes_to_v: bool) {
        self.locked[u as usize] |= self.locked[v as usize];
        if goes_to_v {
            self.origin[u as usize] = self.origin[v as usize];
        }
        self.plane.iter_mut().for_each(|plane| plane.merge(u, v));
    }

    /// Whether each vertex stays on the plane, where this is one half of a mirrored mesh; else empty.
    pub fn into_plane_flags(self) -> Vec<bool> {
        self.plane.map(|plane| plane.is_on).unwrap_or_default()
    }
}

/// The vertices that stay on the plane of a half.
///
/// The half and its image make a manifold where no edge but those of the cut joins two vertices of the plane, and no face three:
/// it would coincide with its own image; and where each of them has an edge of the cut. The half begins so, and no merge and no
/// flip makes it otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlaneVertices {
    axis: usize,
    is_on: Vec<bool>,
    n_on: usize,
}

impl PlaneVertices {
    /// Takes the vertices over to those of the surface. Of one that was split those are on the plane that have an edge of the cut.
    pub fn of(surface: &Surface, half: &Half) -> Self {
        let flag = |v: u32| half.on_plane[surface.source(v) as usize];
        let meets_cut = |v: u32| match surface.rings.ring(v) {
            [first, .., last, _ghost] => flag(*first) || flag(*last),
            _ => false,
        };
        let is_on = |v: u32| flag(v) && surface.rings.ghost(v).is_some() && meets_cut(v);
        Self::new(half.axis, (0..surface.n_vertices() as u32).map(is_on).collect())
    }

    fn of_living(&self, living: &[u32]) -> Self {
        Self::new(self.axis, living.iter().map(|&v| self.has(v)).collect())
    }

    fn new(axis: usize, is_on: Vec<bool>) -> Self {
        let n_on = is_on.iter().filter(|&&on| on).count();
        Self { axis, is_on, n_on }
    }

    /// The axis across which the plane lies.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// Whether a vertex stays on the plane; no ghost vertex does.
    pub fn has(&self, v: u32) -> bool {
        self.is_on.get(v as usize).copied().unwrap_or(false)
    }

    /// Number of vertices on the plane.
    pub fn len(&self) -> usize {
        self.n_on
    }

    fn merge(&mut self, u: u32, v: u32) {
        let both = self.has(u) && self.has(v);
        self.n_on -= usize::from(both);
        self.is_on[u as usize] |= self.is_on[v as usize];
    }

    /// Whether a merge of `u` and `v` with these neighbours would join two vertices of the plane that are not neighbours yet.
    pub fn would_bridge(&self, [u, v]: [u32; 2], [of_u, of_v]: [&[u32]; 2]) -> bool {
        let new_neighbour = |w: &u32, p: u32, of_p: &[u32]| self.has(*w) && *w != p && !of_p.contains(w);
        match (self.has(u), self.has(v)) {
            (true, false) => of_v.iter().any(|w| new_neighbour(w, u, of_u)),
            (false, true) => of_u.iter().any(|w| new_neighbour(w, v, of_v)),
            _ => false,
        }
    }

    /// Whether a merge of `u` and `v` with these neighbours, in order around them, would leave a face with all corners on the plane.
    pub fn would_lay_flat(&self, [u, v]: [u32; 2], [of_u, of_v]: [&[u32]; 2]) -> bool {
        let (on_plane, ring) = match (self.has(u), self.has(v)) {
            (true, false) => (u, of_v),
            (false, true) => (v, of_u),
            _ => return false,
        };
        let lies_there = |&w: &u32| w != on_plane && self.has(w);
        ring.iter().zip(ring.iter().cycle().skip(1)).any(|(w, next)| lies_there(w) && lies_there(next))
    }

    /// Whether a merge of `u` and `v` with these neighbours would take the last edge of a cut between two boundaries: what it joins
    /// would touch its image in a vertex.
    pub fn would_end_cut(&self, [u, v]: [u32; 2], [of_u, of_v]: [&[u32]; 2]) -> bool {
        let goes_on = |ring: &[u32], other: u32| ring.iter().any(|&w| w != other && self.has(w));
        self.has(u) && self.has(v) && !goes_on(of_u, v) && !goes_on(of_v, u)
    }

    /// Where along the axis the merged vertex of `u` and `v` has to lie, seen from `u` when `v` lies at `other`; `None` where
    /// it may lie anywhere.
    pub fn height(&self, u: u32, v: u32, other: DVec3) -> Option<f64> {
        match (self.has(u), self.has(v)) {
            (false, false) => None,
            (true, _) => Some(0.0),
            (false, true) => Some(other[self.axis]),
        }
    }

    /// Lets the solutions of the systems of the vertices, an upper triangle and a right side each, stay on the plane.
    pub fn confine(&self, systems: &mut [[f32; 9]]) {
        for system in systems.iter_mut().zip(&self.is_on).filter_map(|(system, on)| on.then_some(system)) {
            let [xx, xy, xz, yy, yz, zz, ..] = *system;
            system[..6].copy_from_slice(&self.without_slant([xx, xy, xz, yy, yz, zz]));
            system[6 + self.axis] = 0.0;
        }
    }

    /// The sum of a quadric and its image, upper triangles.
    pub fn with_image(&self, quadric: [f32; 6]) -> [f32; 6] {
        self.without_slant(quadric.map(|x| 2.0 * x))
    }

    /// An upper triangle whose axis has nothing to do with the two others.
    fn without_slant(&self, mut a: [f32; 6]) -> [f32; 6] {
        let slanted = [[1, 2], [1, 4], [2, 4]][self.axis];
        slanted.into_iter().for_each(|entry| a[entry] = 0.0);
        a
    }
}
