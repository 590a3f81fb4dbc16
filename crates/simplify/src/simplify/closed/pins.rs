//! Pinned vertices: locked ones, those of a subset, and those on the mirror plane.

use glam::DVec3;

use super::prepare::surface::PreparedSurface;
use super::request::{ClosedRequest, Task};
use crate::simplify::input::Half;

#[derive(Clone, Debug, Default)]
pub struct Pins {
    locked: Vec<bool>,
    locks_edges: bool,
    subset: bool,
    /// Surface vertex from which each vertex originates; empty for the surface's own vertices.
    origin: Vec<u32>,
    plane: Option<PlaneVertices>,
}

impl Pins {
    pub fn new(surface: &PreparedSurface, request: &ClosedRequest) -> Self {
        let Task { input, options, .. } = request.task;
        let is_locked = |v: u32| request.locked[v as usize];
        let locked = if request.locked.is_empty() { Vec::new() } else { surface.sources().map(is_locked).collect() };
        let plane = input.half.map(|half| PlaneVertices::from_half(surface, &half));
        Self { locked, locks_edges: !input.kept.is_empty(), subset: options.subset, origin: Vec::new(), plane }
    }

    #[cfg(test)]
    pub fn new_subset() -> Self {
        Self { subset: true, ..Self::default() }
    }

    pub fn is_empty(&self) -> bool {
        self.locked.is_empty() && !self.subset && self.plane.is_none()
    }

    pub fn has_more_than_plane(&self) -> bool {
        self.subset || self.locked.contains(&true)
    }

    pub fn with_surface_origins(&self, n_vertices: usize) -> Self {
        let vertices = 0..n_vertices as u32;
        let locked = vertices.clone().map(|v| self.is_locked(v)).collect();
        Self { locked, origin: vertices.collect(), ..self.clone() }
    }

    pub fn without_locks(self) -> Self {
        Self { locked: vec![false; self.locked.len()], ..self }
    }

    pub fn select(&self, remaining: &[u32]) -> Self {
        Self {
            locked: remaining.iter().map(|&v| self.is_locked(v)).collect(),
            locks_edges: self.locks_edges,
            subset: self.subset,
            origin: remaining.iter().map(|&v| self.origin[v as usize]).collect(),
            plane: self.plane.as_ref().map(|plane| plane.select(remaining)),
        }
    }

    pub fn locked_vertices(&self) -> impl Iterator<Item = u32> {
        (0..self.locked.len() as u32).filter(|&v| self.locked[v as usize])
    }

    pub fn is_locked(&self, v: u32) -> bool {
        self.locked.get(v as usize).is_some_and(|&locked| locked)
    }

    pub fn locks_edge(&self, u: u32, v: u32) -> bool {
        self.locks_edges && self.is_locked(u) && self.is_locked(v)
    }

    pub fn is_pinned(&self, v: u32) -> bool {
        self.is_locked(v) || self.is_on_cut(v)
    }

    pub fn is_subset(&self) -> bool {
        self.subset
    }

    pub fn may_separate(&self) -> bool {
        // A subset has fixed positions, and mirrored halves are separated together with their images.
        !self.subset && self.plane.is_none()
    }

    pub fn plane(&self) -> Option<&PlaneVertices> {
        self.plane.as_ref()
    }

    pub fn is_on_cut(&self, v: u32) -> bool {
        self.plane.as_ref().is_some_and(|plane| plane.contains(v))
    }

    pub fn are_on_cut(&self, u: u32, v: u32) -> bool {
        self.is_on_cut(u) && self.is_on_cut(v)
    }

    pub fn origins(&self) -> &[u32] {
        &self.origin
    }

    pub fn renumber_origins(&mut self, number: impl Fn(u32) -> u32) {
        self.origin.iter_mut().for_each(|v| *v = number(*v));
    }

    pub fn set_origin(&mut self, v: u32, origin: u32) {
        self.origin[v as usize] = origin;
    }

    /// Merges the pins of `v` into those of `u`; `is_moved_to_v` is true if `u` moved to `v`.
    pub fn merge(&mut self, u: u32, v: u32, is_moved_to_v: bool) {
        self.locked[u as usize] |= self.locked[v as usize];
        if is_moved_to_v {
            self.origin[u as usize] = self.origin[v as usize];
        }
        self.plane.iter_mut().for_each(|plane| plane.merge(u, v));
    }

    pub fn into_plane_flags(self) -> Vec<bool> {
        self.plane.map(|plane| plane.is_on).unwrap_or_default()
    }
}

/// Vertices that must stay on the mirror plane.
///
/// A half and its image form a manifold if only cut edges join two of these vertices, no face joins three, and each is
/// on a cut edge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlaneVertices {
    axis: usize,
    is_on: Vec<bool>,
    n_on: usize,
}

impl PlaneVertices {
    pub fn from_half(surface: &PreparedSurface, half: &Half) -> Self {
        let flag = |v: u32| half.on_plane[surface.source(v) as usize];
        // The first and the last neighbour of a boundary vertex are along the boundary.
        let meets_cut = |v: u32| match surface.rings.ring(v) {
            [first, .., last, _ghost] => flag(*first) || flag(*last),
            _ => false,
        };
        let is_on = |v: u32| flag(v) && surface.rings.ghost(v).is_some() && meets_cut(v);
        Self::new(half.axis, (0..surface.n_vertices() as u32).map(is_on).collect())
    }

    fn select(&self, remaining: &[u32]) -> Self {
        Self::new(self.axis, remaining.iter().map(|&v| self.contains(v)).collect())
    }

    fn new(axis: usize, is_on: Vec<bool>) -> Self {
        let n_on = is_on.iter().filter(|&&on| on).count();
        Self { axis, is_on, n_on }
    }

    pub fn axis(&self) -> usize {
        self.axis
    }

    pub fn contains(&self, v: u32) -> bool {
        self.is_on.get(v as usize).copied().unwrap_or(false)
    }

    pub fn len(&self) -> usize {
        self.n_on
    }

    fn merge(&mut self, u: u32, v: u32) {
        // Two plane vertices become one, otherwise the number stays.
        let both = self.contains(u) && self.contains(v);
        self.n_on -= usize::from(both);
        self.is_on[u as usize] |= self.is_on[v as usize];
    }

    /// Returns axis and height, relative to `u`, at which the merged vertex must be; `None` if neither end is on the
    /// plane.
    pub fn fixed_coordinate(&self, u: u32, v: u32, other: DVec3) -> Option<(usize, f64)> {
        match (self.contains(u), self.contains(v)) {
            (false, false) => None,
            (true, _) => Some((self.axis, 0.0)),
            (false, true) => Some((self.axis, other[self.axis])),
        }
    }

    /// Confines the solutions of plane vertices' systems (upper triangle, then right side) to the plane.
    pub fn confine_to_plane(&self, systems: &mut [[f32; 9]]) {
        for system in systems.iter_mut().zip(&self.is_on).filter_map(|(system, on)| on.then_some(system)) {
            // Without coupling to the axis and with a zero right side, the solution has no component along it.
            let [xx, xy, xz, yy, yz, zz, ..] = *system;
            system[..6].copy_from_slice(&self.without_axis_coupling([xx, xy, xz, yy, yz, zz]));
            system[6 + self.axis] = 0.0;
        }
    }

    /// Returns the sum of a plane vertex's quadric and its mirror image.
    pub fn with_image(&self, quadric: [f32; 6]) -> [f32; 6] {
        self.without_axis_coupling(quadric.map(|x| 2.0 * x))
    }

    fn without_axis_coupling(&self, mut a: [f32; 6]) -> [f32; 6] {
        let slanted = [[1, 2], [1, 4], [2, 4]][self.axis];
        slanted.into_iter().for_each(|entry| a[entry] = 0.0);
        a
    }
}
