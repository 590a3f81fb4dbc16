//! Connected components: dropping and counting them.

use crate::mesh::pulse::Pulse;
use crate::mesh::union_find::{UnionFind, join_faces};
use crate::mesh::{TriMesh, compact};

use super::hidden::hidden_components;
use super::input::Input;
use super::options::{ClosedOptions, DroppedComponent, Hidden, Report};

const TETRAHEDRON: usize = 4;

/// Counts the components of a manifold, and those that no collapse can shrink.
pub(super) fn count_components(pulse: Pulse, mesh: &TriMesh) -> (usize, usize) {
    let mut sets = UnionFind::new(mesh.positions().len());
    // A manifold's components share no vertex, so vertices may be joined.
    for faces in pulse.chunks(mesh.faces()) {
        for &[a, b, c] in faces {
            sets.union(a, b);
            sets.union(b, c);
        }
    }
    let (component, n) = sets.number_sets(pulse);
    let mut n_faces = vec![0; n];
    mesh.faces().iter().for_each(|face| n_faces[component[face[0] as usize] as usize] += 1);
    n_faces.retain(|&n| n > 0);
    (n_faces.len(), n_faces.iter().filter(|&&n| n == 1 || n == TETRAHEDRON).count())
}

fn number_components(pulse: Pulse, mesh: &TriMesh) -> (Vec<u32>, usize) {
    pulse.beat(0);
    join_faces(mesh.positions().len(), mesh.faces(), |_| true).number_sets(pulse)
}

pub(crate) struct PrunedMesh {
    pub mesh: TriMesh,
    pub sources: Vec<u32>,
    pub faces: Vec<u32>,
    pub n_dropped: usize,
    pub n_hidden: usize,
    pub dropped: Vec<DroppedComponent>,
}

impl PrunedMesh {
    /// Adds the dropped components to a report; face indices become those of the original.
    pub fn add_to_report(&self, report: &mut Report) {
        report.components_pruned += self.n_dropped;
        report.components_hidden += self.n_hidden;
        report.dropped.iter_mut().for_each(|component| component.face = self.faces[component.face as usize]);
        report.dropped.extend(&self.dropped);
        report.dropped.sort_unstable_by_key(|component| component.face);
    }
}

/// Drops components smaller than `prune_below`, and hidden ones with `Hidden::Drop`; `None` if all stay.
pub(crate) fn prune(pulse: Pulse, input: &Input, options: &ClosedOptions) -> Option<PrunedMesh> {
    let (mesh, least, drops_hidden) = (input.mesh, options.prune_below, options.hidden == Hidden::Drop);
    if !(least > 0.0 || drops_hidden) {
        return None;
    }
    let (component, n) = number_components(pulse, mesh);
    // Sizes and visibility are those in the scene, where a mesh may be scaled or repeated.
    let view = input.view();
    let seen: Vec<u32> = view.faces.iter().map(|&face| component[face as usize]).collect();
    let mut hidden = if drops_hidden && n > 1 { hidden_components(&view.mesh, &seen, n) } else { vec![false; n] };
    // Components with kept or locked faces stay, hidden or not.
    let mut kept = vec![false; n];
    component.iter().zip(input.kept).for_each(|(&c, is_kept)| kept[c as usize] |= is_kept);
    let is_locked = |face: &[u32; 3]| face.iter().any(|&v| input.locked.get(v as usize) == Some(&true));
    component.iter().zip(mesh.faces()).for_each(|(&c, face)| kept[c as usize] |= is_locked(face));
    hidden.iter_mut().zip(&kept).for_each(|(hidden, kept)| *hidden &= !kept);
    let areas = areas(&view.mesh, &seen, n);
    let shown = (0..n).filter(|&c| !hidden[c]);
    // The visible component with the largest area stays; of equal ones the last.
    let largest = shown.max_by(|&x, &y| areas[x].total_cmp(&areas[y]).then(x.cmp(&y)))?;
    let diagonals = diagonals(&view.mesh, &seen, n);
    let dropped: Vec<bool> = (0..n).map(|c| hidden[c] || c != largest && !kept[c] && diagonals[c] < least).collect();
    let [n_dropped, n_hidden] = [&dropped, &hidden].map(|flags| flags.iter().filter(|&&flag| flag).count());
    remove_faces(mesh, n_dropped, |face| dropped[component[face] as usize])
        .map(|pruned| PrunedMesh { n_hidden, ..pruned })
}

fn areas(mesh: &TriMesh, component: &[u32], n: usize) -> Vec<f64> {
    let mut areas = vec![0.0f64; n];
    for (face, &c) in mesh.faces().iter().zip(component) {
        let corners = face.map(|v| glam::Vec3::from(mesh.positions()[v as usize]).as_dvec3());
        areas[c as usize] += crate::geometry::triangle::area_normal_f64(corners).length();
    }
    areas
}

fn diagonals(mesh: &TriMesh, component: &[u32], n: usize) -> Vec<f64> {
    let mut bounds = vec![(glam::DVec3::INFINITY, glam::DVec3::NEG_INFINITY); n];
    for (face, &c) in mesh.faces().iter().zip(component) {
        let (low, high) = &mut bounds[c as usize];
        for &vertex in face {
            let position = glam::Vec3::from(mesh.positions()[vertex as usize]).as_dvec3();
            (*low, *high) = (low.min(position), high.max(position));
        }
    }
    bounds.iter().map(|(low, high)| (*high - *low).length()).collect()
}

/// Removes faces that make up `n_dropped` components; `None` if `n_dropped` is 0.
pub(super) fn remove_faces(mesh: &TriMesh, n_dropped: usize, is_dropped: impl Fn(usize) -> bool) -> Option<PrunedMesh> {
    if n_dropped == 0 {
        return None;
    }
    let faces: Vec<u32> = (0u32..).take(mesh.faces().len()).filter(|&f| !is_dropped(f as usize)).collect();
    let kept = faces.iter().map(|&f| mesh.faces()[f as usize]).collect();
    let dropped = dropped_components(mesh, is_dropped);
    let pruned = |(mesh, sources)| PrunedMesh { mesh, sources, faces, n_dropped, n_hidden: 0, dropped };
    compact(mesh.positions(), kept).ok().map(pruned)
}

fn dropped_components(mesh: &TriMesh, is_dropped: impl Fn(usize) -> bool) -> Vec<DroppedComponent> {
    let faces: Vec<u32> = (0u32..).take(mesh.faces().len()).filter(|&f| is_dropped(f as usize)).collect();
    let corners: Vec<[u32; 3]> = faces.iter().map(|&f| mesh.faces()[f as usize]).collect();
    let (component, n) = join_faces(mesh.positions().len(), &corners, |_| true).number_sets(Pulse::NONE);
    // Faces come in order, so the first face found is the first of its component.
    let mut dropped: Vec<Option<DroppedComponent>> = vec![None; n];
    for (&face, component) in faces.iter().zip(component) {
        dropped[component as usize].get_or_insert(DroppedComponent { face, n_faces: 0 }).n_faces += 1;
    }
    dropped.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn dropping_below(prune_below: f64) -> ClosedOptions {
        ClosedOptions { prune_below, ..ClosedOptions::default() }
    }

    #[test]
    fn hidden_components_are_dropped() {
        // Spheres of radius 3, 2 and 1 about one point, and a small one next to them.
        let sphere = shapes::icosphere(2);
        let places = [(3.0, 0.0), (2.0, 0.0), (1.0, 0.0), (0.5, 9.0)];
        let n = sphere.positions().len() as u32;
        let at = |(r, x): (f32, f32)| sphere.positions().iter().map(move |p| [r * p[0] + x, r * p[1], r * p[2]]);
        let faces = (0..4).flat_map(|i| sphere.faces().iter().map(move |face| face.map(|v| v + i * n)));
        let mesh = TriMesh::new(places.into_iter().flat_map(at).collect(), faces.collect()).unwrap();
        let options = ClosedOptions { hidden: Hidden::Drop, ..dropping_below(0.0) };
        let left = prune(Pulse::NONE, &Input::bare(&mesh), &options).unwrap();
        assert_eq!((left.n_dropped, left.n_hidden, left.faces.len()), (2, 2, 2 * sphere.faces().len()));
        assert_eq!(left.faces.last(), Some(&(mesh.faces().len() as u32 - 1)));
        let both = prune(Pulse::NONE, &Input::bare(&mesh), &ClosedOptions { prune_below: 4.0, ..options }).unwrap();
        assert_eq!((both.n_dropped, both.n_hidden), (3, 2));
        assert!(
            prune(Pulse::NONE, &Input::bare(&sphere), &ClosedOptions { hidden: Hidden::Drop, ..dropping_below(0.0) })
                .is_none()
        );
    }

    #[test]
    fn components_below_a_size_are_dropped() {
        // Cubes of sides 1, 2 and 3.
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        for side in [1.0f32, 2.0, 3.0] {
            let cube = shapes::cuboid([f64::from(side); 3], 1);
            faces.extend(cube.faces().iter().map(|face| face.map(|v| v + positions.len() as u32)));
            positions.extend_from_slice(cube.positions());
        }
        let cubes = TriMesh::new(positions, faces).unwrap();
        assert_eq!(count_components(Pulse::NONE, &cubes), (3, 0));
        let below = |side: f64| prune(Pulse::NONE, &Input::bare(&cubes), &dropping_below(side * 3f64.sqrt()));
        assert!(below(0.99).is_none() && below(0.0).is_none() && below(f64::NAN).is_none());
        let two = below(1.01).unwrap();
        assert_eq!((two.n_dropped, two.sources.first(), two.faces.first()), (1, Some(&8), Some(&12)));
        assert_eq!(below(2.01).unwrap().n_dropped, 2);
        let last = below(100.0).unwrap();
        assert_eq!((last.n_dropped, last.mesh.faces().len()), (2, 12));
    }

    #[test]
    fn parts_that_touch_at_a_vertex_are_two() {
        // A large tetrahedron and a small one at its corner.
        let large = shapes::tetrahedron();
        let small = |p: &[f32; 3]| p.map(|x| -0.01 * x);
        let positions = large.positions().iter().copied().chain(large.positions()[1..].iter().map(small));
        let faces = large.faces().iter().copied();
        let faces = faces.chain(large.faces().iter().map(|face| face.map(|v| if v == 0 { 0 } else { v + 3 })));
        assert_eq!(large.positions()[0], [0.0; 3]);
        let touching = TriMesh::new(positions.collect(), faces.collect()).unwrap();
        let one = prune(Pulse::NONE, &Input::bare(&touching), &dropping_below(0.5)).unwrap();
        assert_eq!((one.n_dropped, one.faces, one.sources), (1, vec![0, 1, 2, 3], vec![0, 1, 2, 3]));
    }

    #[test]
    fn a_tetrahedron_is_as_small_as_it_gets() {
        assert_eq!(count_components(Pulse::NONE, &shapes::tetrahedron()), (1, 1));
    }
}
