//! A collapse as it was on its way, to go on from without components that are not worth their vertices.

use crate::simplify::limits::Limit;

use super::complex::{Collapse, OwnCopy};
use super::links::Span;

/// Vertices over those asked for with which a copy is kept: of the rest enough are left where up to three quarters of them go.
const KEPT_AT: f64 = 4.0;

impl<'a> Collapse<'a> {
    /// Returns the collapse, set to keep a copy of itself before it reaches the next limit.
    pub fn keeping_a_copy(self) -> Self {
        Self { copy: OwnCopy::Wanted, ..self }
    }

    /// Keeps the copy if it is wanted and the limit is near.
    pub(super) fn keep_copy(&mut self, limit: Limit) {
        if matches!(self.copy, OwnCopy::Wanted) && self.reached(limit.times(KEPT_AT)) {
            self.copy = OwnCopy::Unwanted;
            self.copy = OwnCopy::Kept(Box::new(self.clone()));
        }
    }

    /// Takes the copy out, if one was kept.
    pub fn take_copy(&mut self) -> Option<Self> {
        match std::mem::take(&mut self.copy) {
            OwnCopy::Kept(copy) => Some(*copy),
            OwnCopy::Unwanted | OwnCopy::Wanted => None,
        }
    }

    /// Removes the components that the vertices of these regions make up, all vertices of each.
    pub fn without(mut self, regions: impl Iterator<Item = u32>) -> Self {
        let mut is_gone = vec![false; self.n_inner];
        for region in regions {
            let v = self.begun.get(region as usize).copied().unwrap_or(region);
            is_gone[self.last(v) as usize] = true;
        }
        let (gone, left): (Vec<u32>, Vec<u32>) = self.living().partition(|&v| is_gone[v as usize]);
        let own: Vec<u32> = (0..self.n_inner as u32).collect();
        self.n_faces -= self.faces_from(&gone, &own).len();
        self.n_vertices -= gone.len();
        for &v in &gone {
            let ghosts: Vec<u32> = self.ring(v).filter(|&w| self.is_ghost(w)).collect();
            ghosts.into_iter().for_each(|ghost| self.nodes[ghost as usize].ring = Span::unlisted(0));
            // Nobody asks any more what it became.
            self.merged[v as usize] = left.first().copied().unwrap_or(v);
            (self.least[v as usize], self.nodes[v as usize].ring) = (f32::INFINITY, Span::default());
        }
        self.paid.clear();
        self
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::pulse::Pulse;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::cluster::assignment::Assignment;
    use crate::simplify::closed::cluster::placement::{Placement, Places};
    use crate::simplify::closed::collapse::{Collapse, End};
    use crate::simplify::closed::prepare::surface::Surface;
    use crate::simplify::limits::Limit;

    const LAST_STRETCH: f64 = 1.1;

    fn collapse<'a>(surface: &Surface<'a>) -> Collapse<'a> {
        Collapse::new(Pulse::NONE, &Placement::new(surface, Places::default(), &[]), &surface.rings)
    }

    /// A sphere, and an open cylinder with fewer vertices beside it.
    fn beside() -> (TriMesh, usize) {
        let (sphere, cylinder) = (shapes::wavy_sphere(4, 5.0), shapes::open_cylinder(30, 12));
        let n = sphere.positions().len() as u32;
        let far = cylinder.positions().iter().map(|p| [p[0] + 5.0, p[1], p[2]]);
        let positions = sphere.positions().iter().copied().chain(far).collect();
        let faces = cylinder.faces().iter().map(|face| face.map(|v| v + n));
        (TriMesh::new(positions, sphere.faces().iter().copied().chain(faces).collect()).unwrap(), n as usize)
    }

    #[test]
    fn a_copy_goes_on_without_a_component_to_the_size_asked_for() {
        let (mesh, n) = beside();
        let surface = Surface::new(&mesh, Pulse::NONE);
        let mut whole = collapse(&surface).keeping_a_copy();
        let limit = Limit::of_vertices(300);
        assert_eq!(whole.run(limit, LAST_STRETCH), End::Reached);
        let copy = whole.take_copy().unwrap();
        assert!(whole.take_copy().is_none() && copy.size().0 > 600);
        let mut rest = copy.without(n as u32..mesh.positions().len() as u32);
        assert_eq!(rest.merges_to(limit), rest.size().0 - 300);
        assert_eq!(rest.run(limit, LAST_STRETCH), End::Reached);
        let output = rest.output(&Assignment::identity(mesh.positions().len()));
        assert_eq!((output.positions.len(), output.faces().len()), (300, 596));
        assert!(output.positions.iter().all(|p| surface.scale.restore(p.as_dvec3())[0] < 2.0));
        let stands_for = |v: usize| surface.positions[v].distance(output.positions[output.vertex_of[v] as usize]);
        assert!((0..n).all(|v| stands_for(v) < 0.2));
    }

    #[test]
    fn without_the_sphere_the_cylinder_keeps_its_boundaries() {
        let (mesh, n) = beside();
        let surface = Surface::new(&mesh, Pulse::NONE);
        let mut rest = collapse(&surface).without(0..n as u32);
        assert_eq!(rest.size(), (mesh.positions().len() - n, mesh.faces().len() - 5120));
        assert_eq!(rest.run(Limit::of_vertices(100), LAST_STRETCH), End::Reached);
        assert_eq!(rest.output(&Assignment::identity(mesh.positions().len())).faces().len(), rest.size().1);
    }
}
