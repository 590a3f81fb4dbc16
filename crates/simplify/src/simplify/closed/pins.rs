//! Pinned vertices: locked ones, and those of a subset.

use super::prepare::surface::PreparedSurface;
use super::request::{ClosedRequest, Task};

#[derive(Clone, Debug, Default)]
pub struct Pins {
    locked: Vec<bool>,
    locks_edges: bool,
    subset: bool,
    /// Surface vertex from which each vertex originates; empty for the surface's own vertices.
    origin: Vec<u32>,
}

impl Pins {
    pub fn new(surface: &PreparedSurface, request: &ClosedRequest) -> Self {
        let Task { input, options, .. } = request.task;
        let is_locked = |v: u32| request.locked[v as usize];
        let locked = if request.locked.is_empty() { Vec::new() } else { surface.sources().map(is_locked).collect() };
        Self { locked, locks_edges: !input.kept.is_empty(), subset: options.subset, origin: Vec::new() }
    }

    #[cfg(test)]
    pub fn new_subset() -> Self {
        Self { subset: true, ..Self::default() }
    }

    pub fn is_empty(&self) -> bool {
        self.locked.is_empty() && !self.subset
    }

    pub fn is_binding(&self) -> bool {
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

    pub fn is_subset(&self) -> bool {
        self.subset
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
    }
}
