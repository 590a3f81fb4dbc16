//! One half of a mesh that is its own mirror image: what keeps the vertices of the cut on the plane, so that the half and
//! its image make one surface.
//!
//! The two make a manifold where no edge but those of the cut joins two vertices of the plane: every other such edge would
//! coincide with its own image. The half begins so, and no merge and no flip makes such an edge.

use glam::DVec3;

use super::prepare::surface::{Surface, add, plane_of};

/// Which vertices of a mesh lie on the plane across an axis along which the mesh is one half.
#[derive(Clone, Copy, Debug)]
pub(in crate::simplify) struct Half<'a> {
    /// The axis: 0, 1 or 2.
    pub axis: usize,
    /// Whether each vertex lies on the cut, n_vertices; such a vertex has an edge of the cut.
    pub on_plane: &'a [bool],
}

/// The vertices that stay on the plane, over those of the surface, of a collapse or of a result.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct OnPlane {
    axis: usize,
    is_on: Vec<bool>,
    n_on: usize,
}

impl OnPlane {
    /// Takes the vertices over to those of the surface, where some are copies.
    pub fn of(surface: &Surface, half: &Half) -> Self {
        let is_on = |(v, source): (u32, u32)| half.on_plane[source as usize] && surface.rings.apex(v).is_some();
        Self::new(half.axis, (0..).zip(surface.sources()).map(is_on).collect())
    }

    /// For the vertices that `region` says the surface's became.
    pub fn of_regions(&self, region: &[u32], n_regions: usize) -> Self {
        let mut is_on = vec![false; n_regions];
        region.iter().zip(&self.is_on).for_each(|(&r, on)| is_on[r as usize] |= on);
        Self::new(self.axis, is_on)
    }

    /// For some of the vertices.
    pub fn of_living(&self, living: impl Iterator<Item = u32>) -> Self {
        Self::new(self.axis, living.map(|v| self.has(v)).collect())
    }

    fn new(axis: usize, is_on: Vec<bool>) -> Self {
        let n_on = is_on.iter().filter(|&&on| on).count();
        Self { axis, is_on, n_on }
    }

    /// The axis across which the plane lies.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// Whether a vertex stays on the plane; no apex of a border does.
    pub fn has(&self, v: u32) -> bool {
        self.is_on.get(v as usize).copied().unwrap_or(false)
    }

    /// Number of vertices on the plane.
    pub fn len(&self) -> usize {
        self.n_on
    }

    /// Whether each vertex stays on the plane.
    pub fn into_flags(self) -> Vec<bool> {
        self.is_on
    }

    /// Takes note that `v` was merged into `u`.
    pub fn merge(&mut self, u: u32, v: u32) {
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

    /// Where along the axis the merged vertex of `u` and `v` has to lie, seen from `u` when `v` lies at `other`; `None` where
    /// it may lie anywhere.
    pub fn height(&self, u: u32, v: u32, other: DVec3) -> Option<f64> {
        match (self.has(u), self.has(v)) {
            (false, false) => None,
            (true, _) => Some(0.0),
            (false, true) => Some(other[self.axis]),
        }
    }

    /// Lets the vertices of the plane count as they do in the whole mesh: the planes of their faces and borders and the images of
    /// these, and none that stand on the cut; and their normals lie in the plane.
    pub fn complete(&self, surface: &mut Surface) {
        let mut sums = vec![[0.0f32; 6]; if self.n_on > 0 { surface.n_vertices() } else { 0 }];
        for face in surface.faces.iter().filter(|face| face.iter().any(|&v| self.has(v))) {
            if let Some((_, plane)) = plane_of(face.map(|v| surface.positions[v as usize])) {
                let plane = self.with_image(plane);
                let corners = face.iter().filter(|&&v| self.has(v));
                corners.for_each(|&v| add(&mut sums[v as usize], &plane));
            }
        }
        for v in (0..sums.len()).filter(|&v| self.is_on[v]) {
            surface.normals[v][self.axis] = 0.0;
            surface.normals[v] = surface.normals[v].normalize_or_zero();
        }
        self.add_borders(surface, &mut sums);
        for v in (0..sums.len()).filter(|&v| self.is_on[v]) {
            let weight = sums[v][0] + sums[v][3] + sums[v][5];
            if weight > 0.0 {
                surface.quadrics[v] = sums[v];
            }
        }
    }

    /// Adds the lines along borders of the whole mesh, where these meet the plane, and their images.
    fn add_borders(&self, surface: &Surface, sums: &mut [[f32; 6]]) {
        let borders = if sums.is_empty() { Vec::new() } else { surface.rings.apex_faces() };
        for [a, b, _] in borders.into_iter().filter(|&[a, b, _]| self.has(a) != self.has(b)) {
            let v = if self.has(a) { a } else { b };
            let line = self.with_image(surface.line_along_border([a, b]));
            add(&mut sums[v as usize], &line);
        }
    }

    /// The sum of a quadric and its image, upper triangles.
    fn with_image(&self, quadric: [f32; 6]) -> [f32; 6] {
        self.without_slant(quadric.map(|x| 2.0 * x))
    }

    /// Lets the solutions of the systems of the vertices, an upper triangle and a right side each, stay on the plane.
    pub fn confine(&self, systems: &mut [[f32; 9]]) {
        for system in systems.iter_mut().zip(&self.is_on).filter_map(|(system, on)| on.then_some(system)) {
            let [xx, xy, xz, yy, yz, zz, ..] = *system;
            system[..6].copy_from_slice(&self.without_slant([xx, xy, xz, yy, yz, zz]));
            system[6 + self.axis] = 0.0;
        }
    }

    /// An upper triangle whose axis has nothing to do with the two others.
    fn without_slant(&self, mut a: [f32; 6]) -> [f32; 6] {
        let slanted = [[1, 2], [1, 4], [2, 4]][self.axis];
        slanted.into_iter().for_each(|entry| a[entry] = 0.0);
        a
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_vertex_of_the_cut_counts_as_in_the_whole() {
        let whole = shapes::torus(24, 12, 1.0, 0.4);
        let x = |v: u32| whole.positions()[v as usize][0];
        let faces: Vec<[u32; 3]> =
            whole.faces().iter().copied().filter(|face| face.iter().all(|&v| x(v) > -1e-6)).collect();
        let (half, sources) = crate::mesh::compact(whole.positions(), faces).unwrap();
        let on_plane: Vec<bool> = half.positions().iter().map(|p| p[0].abs() < 1e-6).collect();
        assert_eq!(on_plane.iter().filter(|&&on| on).count(), 24);
        let (mut surface, of_whole) = (Surface::new(&half), Surface::new(&whole));
        let plane = OnPlane::of(&surface, &Half { axis: 0, on_plane: &on_plane });
        plane.complete(&mut surface);
        // The halves are normalised by other powers of two.
        let ratio = (surface.scale.to_unit([1.0, 0.0, 0.0]) - surface.scale.to_unit([0.0; 3])).x
            / (of_whole.scale.to_unit([1.0, 0.0, 0.0]) - of_whole.scale.to_unit([0.0; 3])).x;
        for v in (0..on_plane.len()).filter(|&v| on_plane[v]) {
            let meant = of_whole.quadrics[sources[v] as usize].map(|x| x * (ratio * ratio) as f32);
            for (here, there) in surface.quadrics[v].iter().zip(meant) {
                assert!((here - there).abs() < 1e-5, "{:?} {meant:?}", surface.quadrics[v]);
            }
        }
    }
}
