//! Copy of a collapse, to continue without components that are dropped later.

use crate::simplify::limits::Limit;

use super::corner_table::NONE;
use super::state::{Collapse, CopyState, REMOVED};

/// Size at which the copy is made, over the target.
// So the copy is still large enough if components with three quarters of its vertices are dropped.
const COPY_RATIO: f64 = 4.0;

impl<'a> Collapse<'a> {
    pub fn with_copy(self) -> Self {
        Self { copy: CopyState::Wanted, ..self }
    }

    /// Makes the copy at the present size, if one is wanted and not there yet.
    pub fn with_copy_if_wanted(mut self) -> Self {
        if matches!(self.copy, CopyState::Wanted) {
            self.make_copy();
        }
        self
    }

    fn make_copy(&mut self) {
        self.copy = CopyState::Unwanted;
        self.copy = CopyState::Kept(Box::new(self.clone()));
    }

    pub(super) fn make_copy_if_due(&mut self, limit: Limit) {
        // A single component is never dropped, so it needs no copy.
        if matches!(self.copy, CopyState::Wanted) && self.has_reached(limit.scale(COPY_RATIO)) {
            self.copy = CopyState::Unwanted;
            if !self.is_one_component() {
                self.make_copy();
            }
        }
    }

    fn is_one_component(&self) -> bool {
        // Counts the vertices that are connected with the first one.
        let mut pending: Vec<u32> = self.remaining().take(1).collect();
        let mut is_met = vec![false; self.nodes.len()];
        pending.iter().for_each(|&v| is_met[v as usize] = true);
        let mut n_met = 0;
        while let Some(v) = pending.pop() {
            n_met += 1;
            for w in self.neighbors(v).filter(|&w| !self.is_ghost(w)) {
                if !std::mem::replace(&mut is_met[w as usize], true) {
                    pending.push(w);
                }
            }
        }
        n_met == self.n_vertices
    }

    pub fn take_copy(&mut self) -> Option<Self> {
        match std::mem::take(&mut self.copy) {
            CopyState::Kept(copy) => Some(*copy),
            CopyState::Unwanted | CopyState::Wanted => None,
        }
    }

    pub fn remove_components(mut self, vertices: impl Iterator<Item = u32>) -> Self {
        let mut removed_ids = vec![false; self.merged.len()];
        vertices.for_each(|v| removed_ids[self.final_vertex(v) as usize] = true);
        let (nodes, n_inner) = (&mut self.nodes, self.n_inner);
        let mut n_faces = 0;
        self.corners.retain(|face| {
            // Faces at ghost vertices go with their component but are not counted.
            let ghost = face.into_iter().find(|&v| v as usize >= n_inner);
            let stays = face
                .into_iter()
                .all(|v| !removed_ids.get(nodes[v as usize].id as usize).is_some_and(|removed| *removed));
            n_faces += usize::from(stays && ghost.is_none());
            if let (false, Some(ghost)) = (stays, ghost) {
                nodes[ghost as usize].degree -= 1;
            }
            stays
        });
        // A walk must not start at a ghost vertex without faces.
        let ghosts = self.nodes[n_inner..].iter_mut();
        ghosts.filter(|ghost| ghost.degree == 0).for_each(|ghost| ghost.corner = NONE);
        let remaining: Vec<u32> = self.remaining().collect();
        let is_removed = |&v: &u32| removed_ids[self.nodes[v as usize].id as usize];
        let (removed, left): (Vec<u32>, Vec<u32>) = remaining.into_iter().partition(is_removed);
        // Removed vertices are never looked up again, so any remaining one serves as their target.
        let left = left.first().map(|&v| self.nodes[v as usize].id);
        for &v in &removed {
            let id = self.nodes[v as usize].id;
            self.merged[id as usize] = left.unwrap_or(id);
            self.nodes[v as usize].corner = REMOVED;
        }
        (self.n_vertices, self.n_faces) = (self.n_vertices - removed.len(), n_faces);
        // Prices paid by the larger mesh do not apply to the rest.
        self.pass_prices.clear();
        self
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::pulse::Pulse;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::collapse::{Collapse, CollapseEnd};
    use crate::simplify::closed::prepare::surface::PreparedSurface;
    use crate::simplify::limits::Limit;

    fn collapse<'a>(surface: &PreparedSurface<'a>) -> Collapse<'a> {
        Collapse::new(Pulse::NONE, surface)
    }

    fn sphere_and_cylinder() -> (TriMesh, usize) {
        let (sphere, cylinder) = (shapes::wavy_sphere(4, 5.0), shapes::open_cylinder(30, 12));
        let far = shapes::place(&cylinder, |[x, y, z]| [x + 5.0, y, z]);
        (shapes::unite([&sphere, &far]), sphere.positions().len())
    }

    #[test]
    fn a_copy_continues_without_a_component_to_the_requested_size() {
        let (mesh, n) = sphere_and_cylinder();
        let surface = PreparedSurface::new(&mesh, Pulse::NONE);
        let mut whole = collapse(&surface).with_copy();
        let limit = Limit::from_vertices(300);
        assert_eq!(whole.run(limit), CollapseEnd::Reached);
        let copy = whole.take_copy().unwrap();
        assert!(whole.take_copy().is_none() && copy.size().0 > 600);
        let mut rest = copy.remove_components(n as u32..mesh.positions().len() as u32);
        assert_eq!(rest.merges_to(limit), rest.size().0 - 300);
        assert_eq!(rest.run(limit), CollapseEnd::Reached);
        let output = rest.output();
        assert_eq!((output.positions.len(), output.faces().len()), (300, 596));
        assert!(output.positions.iter().all(|p| surface.scale.restore(p.as_dvec3())[0] < 2.0));
        let stands_for = |v: usize| surface.positions[v].distance(output.positions[output.vertex_of[v] as usize]);
        assert!((0..n).all(|v| stands_for(v) < 0.2));
    }

    #[test]
    fn without_the_sphere_the_cylinder_keeps_its_boundaries() {
        let (mesh, n) = sphere_and_cylinder();
        let surface = PreparedSurface::new(&mesh, Pulse::NONE);
        let mut rest = collapse(&surface).remove_components(0..n as u32);
        assert_eq!(rest.size(), (mesh.positions().len() - n, mesh.faces().len() - 5120));
        assert_eq!(rest.run(Limit::from_vertices(100)), CollapseEnd::Reached);
        assert_eq!(rest.output().faces().len(), rest.size().1);
    }
}
