//! Connected components: dropping and counting them.

use crate::mesh::TriMesh;
use crate::mesh::pulse::Pulse;
use crate::mesh::union_find::{join_faces, join_vertices};

use super::hidden::hidden_components;
use super::input::Input;
use super::options::{ClosedOptions, Hidden, SimplifyError};
use super::sub_mesh::SubMesh;

const TETRAHEDRON: usize = 4;

/// Counts the components of a manifold, and those that no collapse can shrink.
pub(super) fn count_components(pulse: Pulse, mesh: &TriMesh) -> (usize, usize) {
    // A manifold's components share no vertex, so vertices may be joined.
    let faces = pulse.chunks(mesh.faces()).flatten().copied();
    let (component, n) = join_vertices(mesh.positions().len(), faces).number_sets(pulse);
    let mut n_faces = vec![0; n];
    mesh.faces().iter().for_each(|face| n_faces[component[face[0] as usize] as usize] += 1);
    n_faces.retain(|&n| n > 0);
    (n_faces.len(), n_faces.iter().filter(|&&n| n == 1 || n == TETRAHEDRON).count())
}

fn number_components(pulse: Pulse, mesh: &TriMesh) -> (Vec<u32>, usize) {
    pulse.beat(0);
    join_faces(mesh.positions().len(), mesh.faces(), |_| true).number_sets(pulse)
}

/// Drops components smaller than `prune_below`, and hidden ones with `Hidden::Drop`.
#[doc(hidden)]
pub fn prune<'a>(pulse: Pulse, input: &Input<'a>, options: &ClosedOptions) -> Result<SubMesh<'a>, SimplifyError> {
    let (mesh, least, drops_hidden) = (input.mesh, options.prune_below, options.hidden == Hidden::Drop);
    if !(least > 0.0 || drops_hidden) {
        return Ok(SubMesh::whole(input));
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
    let largest = shown.max_by(|&x, &y| areas[x].total_cmp(&areas[y]).then(x.cmp(&y)));
    let diagonals = diagonals(&view.mesh, &seen, n);
    let is_dropped = |c| hidden[c] || Some(c) != largest && !kept[c] && diagonals[c] < least;
    let dropped: Vec<bool> = (0..n).map(|c| largest.is_some() && is_dropped(c)).collect();
    let [n_dropped, n_hidden] = [&dropped, &hidden].map(|flags| flags.iter().filter(|&&flag| flag).count());
    SubMesh::without_components(input, [n_dropped, n_hidden], |face| dropped[component[face] as usize])
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
        let mesh = shapes::unite(places.map(|(r, x)| shapes::place(&sphere, |p| [r * p[0] + x, r * p[1], r * p[2]])));
        let options = ClosedOptions { hidden: Hidden::Drop, ..dropping_below(0.0) };
        assert_eq!(prune(Pulse::NONE, &Input::bare(&sphere), &options).unwrap().origin.n_dropped, 0);
        let left = prune(Pulse::NONE, &Input::bare(&mesh), &options).unwrap();
        assert_eq!((left.origin.n_dropped, left.origin.n_hidden), (2, 2));
        let faces = left.origin.faces.unwrap();
        assert_eq!((faces.len(), faces.last()), (2 * sphere.faces().len(), Some(&(mesh.faces().len() as u32 - 1))));
        let both = prune(Pulse::NONE, &Input::bare(&mesh), &ClosedOptions { prune_below: 4.0, ..options }).unwrap();
        assert_eq!((both.origin.n_dropped, both.origin.n_hidden), (3, 2));
    }

    #[test]
    fn components_below_a_size_are_dropped() {
        // Cubes of sides 1, 2 and 3.
        let cubes = shapes::unite([1.0, 2.0, 3.0].map(|side| shapes::cuboid([side; 3], 1)));
        assert_eq!(count_components(Pulse::NONE, &cubes), (3, 0));
        let input = Input::bare(&cubes);
        let below = |side: f64| prune(Pulse::NONE, &input, &dropping_below(side * 3f64.sqrt())).unwrap();
        assert_eq!([0.99, 0.0, f64::NAN, 2.01].map(|side| below(side).origin.n_dropped), [0, 0, 0, 2]);
        let two = below(1.01);
        assert_eq!((two.origin.n_dropped, two.origin.vertices.unwrap()[0], two.origin.faces.unwrap()[0]), (1, 8, 12));
        let last = below(100.0);
        assert_eq!((last.origin.n_dropped, last.input().mesh.faces().len()), (2, 12));
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
        assert_eq!(
            (one.origin.n_dropped, one.origin.faces, one.origin.vertices),
            (1, Some(vec![0, 1, 2, 3]), Some(vec![0, 1, 2, 3]))
        );
    }

    #[test]
    fn a_tetrahedron_is_as_small_as_it_gets() {
        assert_eq!(count_components(Pulse::NONE, &shapes::tetrahedron()), (1, 1));
    }
}
