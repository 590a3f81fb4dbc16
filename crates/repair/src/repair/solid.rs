//! Printable meshes.

use rustc_hash::FxHashSet;

use crate::mesh::half_edges::for_each_edge;
use crate::mesh::{Attributes, TriMesh};

use super::bodies::bodies;
use super::cells::find_leaks;
use super::components::{components, drop_small};
use super::faces::{FaceOrigin, RepairFaces};
use super::fill::fill;
use super::fins::drop_fins;
use super::nesting::nest;
use super::one_sided::cut_one_sided;
use super::repeated::{drop_opposite, drop_repeated};
use super::touching::separate_touching;
use super::{NothingSolid, RepairCounts, Repaired};

/// Largest number of rounds to close holes; filling may make a surface one-sided again.
const MOST_ROUNDS: usize = 4;

/// Least share of the input's area that must remain.
const LEAST_LEFT: f64 = 0.01;

/// Makes a mesh the surface of a solid, with two faces at every edge, all wound outward.
///
/// Drops components whose bounding box has a diagonal below `least_size`, fins, sheets, inner walls, and hidden shells
/// (see `nesting`). Fills all holes. Intersecting surfaces stay as they are.
///
/// # Errors
/// [`NothingSolid`] if less than a hundredth of the area is left.
///
/// ```
/// # use neural_mesh_repair as neural_mesh;
/// use neural_mesh::mesh::{Attributes, TriMesh, shapes, topology};
/// use neural_mesh::repair::printable;
/// let sphere = shapes::icosphere(2);
/// // Half of the faces turned, ten gone.
/// let faces = sphere.faces().iter().enumerate().skip(10);
/// let faces = faces.map(|(i, &[a, b, c])| if i % 2 == 0 { [a, c, b] } else { [a, b, c] }).collect();
/// let messy = TriMesh::new(sphere.positions().to_vec(), faces).unwrap();
/// let solid = printable(&messy, Attributes::NONE, 0.0).unwrap();
/// assert!(topology(&solid.mesh).is_closed_manifold());
/// ```
pub fn printable(mesh: &TriMesh, attributes: &Attributes, least_size: f64) -> Result<Repaired, NothingSolid> {
    let mut faces = RepairFaces::new(mesh, attributes);
    drop_small(&mut faces, least_size);
    // Holes first: cells mean little where surfaces are open.
    let mut n_filled = close_holes(&mut faces);
    let parted = mark_sheet_components(&mut faces, &mut n_filled);
    let mut bodies = bodies(&faces, &parted);
    // Bodies know their faces; nesting decides which of them are solid.
    nest(&faces, &mut bodies);
    let mut is_hull = vec![false; faces.len()];
    for &(face, turn) in bodies.iter().flat_map(|body| &body.hull) {
        is_hull[face as usize] = true;
        if turn {
            faces.turn(face);
        }
    }
    faces.retain(|face| is_hull[face as usize]);
    // Walls shared by two bodies cancel out, which joins the bodies.
    drop_opposite(&mut faces);
    drop_small(&mut faces, least_size);
    // Input of sheets alone leaves slivers, which are no solid.
    let [left, all] = [area(&faces), area(&RepairFaces::new(mesh, Attributes::NONE))];
    if faces.len() == 0 || left < LEAST_LEFT * all {
        return Err(NothingSolid);
    }
    let counts = counts(mesh, &faces, n_filled);
    Ok(separate_touching(faces.into_repaired(attributes, counts)))
}

fn area(faces: &RepairFaces) -> f64 {
    faces.numbers().map(|face| faces.area(face)).sum()
}

/// Fills all holes after dropping faces that prevent it; returns the number filled.
fn close_holes(faces: &mut RepairFaces) -> usize {
    let mut n_filled = 0;
    for _ in 0..MOST_ROUNDS {
        let n_changed = drop_repeated(faces) + cut_one_sided(faces) + drop_fins(faces);
        let open = open_edges(faces);
        if open.is_empty() && n_changed == 0 {
            break;
        }
        // Only loops at truly open edges: the cut also separates closed surfaces.
        let filled = fill(faces, usize::MAX, |rims| {
            let ends = rims.iter().zip(rims.iter().cycle().skip(1)).map(|(a, b)| [a.vertex, b.vertex]);
            ends.into_iter().any(|[a, b]| open.contains(&[a.min(b), a.max(b)]))
        });
        n_filled += filled.n_filled;
    }
    n_filled
}

fn mark_sheet_components(faces: &mut RepairFaces, n_filled: &mut usize) -> Vec<bool> {
    // Angles fail where surfaces intersect away from edges.
    let leaks = find_leaks(faces);
    if leaks.contains(&true) {
        let filled = fill(faces, usize::MAX, |rims| rims.iter().any(|rim| leaks[rim.face() as usize]));
        *n_filled += filled.n_filled;
    }
    let (component, n) = components(faces);
    let mut is_parted = vec![false; n];
    leaks.iter().zip(&component).filter(|(leaks, _)| **leaks).for_each(|(_, &at)| is_parted[at as usize] = true);
    component.iter().map(|&component| is_parted[component as usize]).collect()
}

fn open_edges(faces: &RepairFaces) -> FxHashSet<[u32; 2]> {
    let mut open = FxHashSet::default();
    for_each_edge(faces.positions.len(), &faces.corners, |ends, around| {
        if around.len() == 1 {
            open.insert(ends);
        }
    });
    open
}

fn counts(mesh: &TriMesh, faces: &RepairFaces, n_filled: usize) -> RepairCounts {
    let before = RepairFaces::new(mesh, Attributes::NONE);
    let (component, n_before) = components(&before);
    // Remaining faces of each component, as read and reversed.
    let mut left = vec![[0usize; 2]; n_before];
    for (&source, made) in faces.sources.iter().zip(&faces.origins) {
        if let Some(&component) = component.get(source as usize) {
            left[component as usize][usize::from(*made == FaceOrigin::Turned)] += 1;
        }
    }
    let n_dropped = left.iter().filter(|left| **left == [0; 2]).count();
    let n_kept: usize = left.as_flattened().iter().sum();
    RepairCounts {
        holes_filled: n_filled,
        faces_removed: mesh.faces().len() - n_kept,
        components_dropped: n_dropped,
        components_added: (components(faces).1 + n_dropped).saturating_sub(n_before),
        components_flipped: left.iter().filter(|[as_read, turned]| turned > as_read).count(),
        ..RepairCounts::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Channel, Role, edges, manifold, shapes, topology};
    use proptest::prelude::*;

    fn is_solid(mesh: &TriMesh) -> bool {
        let cut = manifold(mesh.positions(), mesh.faces());
        edges(mesh).iter().all(|edge| edge.up == edge.down) && cut.rings.n_ghosts() == 0 && cut.rings.is_oriented()
    }

    fn solid(mesh: &TriMesh) -> Repaired {
        printable(mesh, Attributes::NONE, 0.0).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn soups_become_solid_or_nothing(faces in prop::collection::vec(prop::array::uniform3(0u32..14), 1..60)) {
            let mut seen = FxHashSet::default();
            let sorted = |mut face: [u32; 3]| { face.sort_unstable(); face };
            let faces: Vec<_> = faces.into_iter().filter(|&[a, b, c]| a != b && b != c && c != a && seen.insert(sorted([a, b, c]))).collect();
            let positions = shapes::wavy_sphere(1, 3.0).positions()[..14].to_vec();
            let mesh = TriMesh::new(positions, faces).unwrap();
            if let Ok(repaired) = printable(&mesh, Attributes::NONE, 0.0) {
                prop_assert!(is_solid(&repaired.mesh));
                prop_assert!(crate::metrics::volume(&repaired.mesh).unwrap() > 0.0);
            }
        }

        #[test]
        fn what_was_torn_and_turned_is_whole_again(
            gone in prop::collection::vec(any::<usize>(), 0..40),
            turned in prop::collection::vec(any::<bool>(), 1..200),
        ) {
            let mesh = shapes::torus(20, 10, 2.0, 0.7);
            let n = mesh.faces().len();
            let gone: FxHashSet<usize> = gone.into_iter().map(|g| g % n).collect();
            let left = mesh.faces().iter().enumerate().filter(|(f, _)| !gone.contains(f));
            let left = left.zip(turned.iter().cycle()).map(|((_, &[a, b, c]), &turn)| if turn { [a, c, b] } else { [a, b, c] });
            let repaired = solid(&TriMesh::new(mesh.positions().to_vec(), left.collect()).unwrap());
            prop_assert!(topology(&repaired.mesh).is_closed_manifold());
            let (volume, whole) = (crate::metrics::volume(&repaired.mesh).unwrap(), crate::metrics::volume(&mesh).unwrap());
            prop_assert!((volume / whole - 1.0).abs() < 0.1, "{volume} {whole}");
        }
    }

    #[test]
    fn solid_meshes_stay_unchanged() {
        for mesh in [shapes::icosphere(3), shapes::chain_of_tori(3), shapes::many_boxes(9)] {
            let repaired = solid(&mesh);
            assert_eq!(repaired.mesh, mesh);
            assert_eq!(repaired.counts, RepairCounts::default());
        }
    }

    #[test]
    fn sheets_are_nothing() {
        for mesh in [shapes::grid(9, 9), shapes::moebius_strip(40, 4)] {
            assert_eq!(printable(&mesh, Attributes::NONE, 0.0), Err(NothingSolid));
        }
    }

    #[test]
    fn a_surface_with_one_side_is_cut_open_and_closed() {
        assert!(is_solid(&solid(&shapes::klein_bottle(40, 20)).mesh));
        // A Klein bottle: a torus, cut and joined again mirrored.
        let (around, tube) = (40u32, 20u32);
        let torus = shapes::torus(around, tube, 2.0, 0.7);
        let mirrored = |v: u32| v / tube * tube + (tube - v % tube) % tube;
        let is_last = |v: u32| v / tube == around - 1;
        let joined = |face: &[u32; 3]| {
            let at_cut = face.iter().any(|&v| is_last(v)) && face.iter().any(|&v| v < tube);
            face.map(|v| if at_cut && v < tube { mirrored(v) } else { v })
        };
        let bottle = TriMesh::new(torus.positions().to_vec(), torus.faces().iter().map(joined).collect()).unwrap();
        assert!(!topology(&bottle).orientable);
        let repaired = solid(&bottle);
        assert!(is_solid(&repaired.mesh) && repaired.counts.holes_filled > 0);
        assert!(crate::metrics::volume(&repaired.mesh).unwrap() > 0.0);
    }

    #[test]
    fn a_crumb_next_to_a_two_sided_sheet_is_not_solid() {
        let n = 6u32;
        let vertex = |i: u32, j: u32| i * (n + 1) + j;
        let quads = (0..n).flat_map(|i| {
            (0..n).map(move |j| [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)])
        });
        let plate = quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d], [b, a, d], [b, d, c]]);
        let places = (0..(n + 1) * (n + 1)).map(|v| [(v / (n + 1)) as f32, (v % (n + 1)) as f32, 0.0]);
        let crumb = shapes::tetrahedron();
        let crumbs = crumb.faces().iter().map(|face| face.map(|v| v + (n + 1) * (n + 1)));
        let positions = places.chain(crumb.positions().iter().map(|p| [0.1 * p[0], 0.1 * p[1], 3.0 + 0.1 * p[2]]));
        let mesh = TriMesh::new(positions.collect(), plate.chain(crumbs).collect()).unwrap();
        assert_eq!(printable(&mesh, Attributes::NONE, 0.0).map(|it| it.counts), Err(NothingSolid));
    }

    #[test]
    fn small_components_go() {
        let boxes = shapes::many_boxes(20);
        let repaired = printable(&boxes, Attributes::NONE, boxes.diagonal()).unwrap();
        assert_eq!((repaired.counts.components_dropped, topology(&repaired.mesh).components), (19, 1));
        assert_eq!(repaired.counts.faces_removed, boxes.faces().len() - repaired.mesh.faces().len());
    }

    #[test]
    fn normals_of_what_is_turned_are_turned() {
        let sphere = shapes::icosphere(2);
        let values = sphere.positions().iter().flatten().map(|x| -x).collect();
        let normals = Channel { name: "n".into(), role: Role::Normal, width: 3, values };
        let inside_out = sphere.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
        let mesh = TriMesh::new(sphere.positions().to_vec(), inside_out).unwrap();
        let attributes = Attributes { wedges: mesh.faces().to_vec(), channels: vec![normals], groups: Vec::new() };
        let repaired = printable(&mesh, &attributes, 0.0).unwrap();
        assert_eq!((repaired.counts.components_flipped, repaired.counts.faces_turned), (1, mesh.faces().len()));
        assert!(repaired.attributes.is_valid_for(mesh.faces().len()));
        for (face, wedges) in repaired.mesh.faces().iter().zip(&repaired.attributes.wedges) {
            for (v, wedge) in face.iter().zip(wedges) {
                assert_eq!(repaired.attributes.channels[0].value(*wedge), repaired.mesh.positions()[*v as usize]);
            }
        }
    }
}
