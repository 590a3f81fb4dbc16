//! Kept faces and locked vertices come back bit for bit.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use neural_mesh::mesh::{Attributes, Channel, Role, TriMesh, shapes, topology, with_flat_normals};
use neural_mesh::simplify::{
    ClosedOptions, Hidden, Input, Options, Outcome, Simplified, SimplifyError, Size, simplify,
    simplify_levels_of_detail,
};

use crate::common::{assert_closed_manifold, with_changes};

fn go_on() -> impl FnMut(neural_mesh::simplify::Event) -> ControlFlow<()> {
    |_| ControlFlow::Continue(())
}

fn input<'a>(mesh: &'a TriMesh, attributes: &'a Attributes, kept: &'a [bool]) -> Input<'a> {
    with_changes(Input::bare(mesh), |input| (input.attributes, input.kept) = (attributes, kept))
}

type Corner = (Vec<u32>, Vec<(String, Vec<u32>)>);

// Returns faces as three corners, the least corner first, in order.
fn faces(mesh: &TriMesh, attributes: &Attributes, is_one: impl Fn(usize) -> bool) -> Vec<[Corner; 3]> {
    let bits = |values: &[f32]| values.iter().map(|x| x.to_bits()).collect::<Vec<u32>>();
    let corner = |f: usize, c: usize| {
        let carried = attributes
            .channels
            .iter()
            .map(|channel| (channel.name.clone(), bits(channel.value(attributes.wedges[f][c]))));
        let mut carried: Vec<_> = carried.collect();
        carried.sort();
        (bits(&mesh.positions()[mesh.faces()[f][c] as usize]), carried)
    };
    let mut faces: Vec<[Corner; 3]> = (0..mesh.faces().len())
        .filter(|&f| is_one(f))
        .map(|f| {
            let mut face = [0, 1, 2].map(|c| corner(f, c));
            let first = (0..3).min_by_key(|&c| face[c].0.clone()).unwrap();
            face.rotate_left(first);
            face
        })
        .collect();
    faces.sort();
    faces
}

#[track_caller]
fn assert_kept(before: &Input, result: &Simplified) {
    let kept = faces(before.mesh, before.attributes, |f| before.kept[f]);
    let all = faces(&result.mesh, &result.attributes, |_| true);
    assert!(!kept.is_empty());
    let missing = kept.iter().filter(|face| all.binary_search(face).is_err()).count();
    assert_eq!(missing, 0, "of {} kept faces", kept.len());
}

// Builds a bumpy sphere with texture coordinates; the faces above a height are kept.
fn sphere_with_kept_cap(height: f32) -> (TriMesh, Attributes, Vec<bool>) {
    let mesh = shapes::wavy_sphere(5, 6.0);
    let z = |face: &[u32; 3]| face.iter().map(|&v| mesh.positions()[v as usize][2]).sum::<f32>() / 3.0;
    let kept: Vec<bool> = mesh.faces().iter().map(|face| z(face) > height).collect();
    let values = mesh.positions().iter().flat_map(|p| [0.5 + 0.3 * p[0], 0.5 + 0.3 * p[1] * p[2]]).collect();
    let channels = vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }];
    let attributes = Attributes { wedges: mesh.faces().to_vec(), channels, groups: Vec::new() };
    (mesh, attributes, kept)
}

#[test]
fn kept_faces_come_back_bit_for_bit_and_the_rest_makes_up_the_size() {
    let (mesh, attributes, kept) = sphere_with_kept_cap(0.8);
    let bare = Attributes::default();
    let flat = with_flat_normals(&mesh, &attributes, "normal");
    for carried in [&bare, &attributes, &flat] {
        let before = input(&mesh, carried, &kept);
        for ratio in [0.5, 0.3] {
            let result = simplify(before, &Options::new(Size::Ratio(ratio)), &mut go_on()).unwrap();
            assert_eq!(result.report.outcome, Outcome::Reached);
            assert_eq!(result.mesh.positions().len(), (mesh.positions().len() as f64 * ratio) as usize);
            assert_closed_manifold(&result.mesh);
            assert_kept(&before, &result);
        }
    }
}

#[test]
fn kept_faces_are_reported_as_the_limit() {
    let (mesh, attributes, kept) = sphere_with_kept_cap(0.0);
    let before = input(&mesh, &attributes, &kept);
    let result = simplify(before, &Options::new(Size::Ratio(0.02)), &mut go_on()).unwrap();
    assert!(matches!(result.report.outcome, Outcome::Stopped(_)), "{:?}", result.report);
    let corners: BTreeSet<u32> =
        mesh.faces().iter().zip(&kept).filter(|(_, kept)| **kept).flat_map(|(face, _)| *face).collect();
    assert_eq!(result.report.locked_vertices, corners.len());
    assert_closed_manifold(&result.mesh);
    assert_kept(&before, &result);
}

#[test]
fn all_levels_keep_what_is_kept() {
    let (mesh, attributes, kept) = sphere_with_kept_cap(0.9);
    let before = input(&mesh, &attributes, &kept);
    let targets = [Size::Ratio(0.5), Size::Ratio(0.3), Size::Ratio(0.2)];
    let levels = simplify_levels_of_detail(before, &ClosedOptions::default(), &targets, &mut go_on()).unwrap();
    assert_eq!(levels.len(), 3);
    levels.iter().for_each(|level| assert_kept(&before, level));
}

// Builds a large sphere with small ones inside, of which the last two are kept.
fn nested_spheres() -> (TriMesh, Vec<bool>) {
    let [large, small] = [shapes::icosphere(4), shapes::icosphere(1)];
    let n_kept = 2 * small.faces().len();
    let inner = |i: i32| shapes::place(&small, |[x, y, z]| [0.01 * x + 0.1 * i as f32, 0.01 * y, 0.01 * z]);
    let mesh = shapes::unite([large].into_iter().chain((0..6).map(inner)));
    let n_faces = mesh.faces().len();
    (mesh, (0..n_faces).map(|f| f + n_kept >= n_faces).collect())
}

#[test]
fn kept_components_are_dropped_for_nothing() {
    let (mesh, kept) = nested_spheres();
    let attributes = Attributes::default();
    let before = input(&mesh, &attributes, &kept);
    let plain = ClosedOptions::default();
    let pruned = ClosedOptions { prune_below: 0.1, ..plain.clone() };
    let hidden = ClosedOptions { hidden: Hidden::Drop, ..plain.clone() };
    let [plain, pruned, hidden] =
        [plain, pruned, hidden].map(|options| Options::with_closed(Size::Vertices(150), options));
    for (options, n_components) in [(&plain, None), (&pruned, Some(3)), (&hidden, Some(3))] {
        let result = simplify(before, options, &mut go_on()).unwrap();
        assert_kept(&before, &result);
        let found = topology(&result.mesh).components;
        assert!(n_components.is_none_or(|n| n == found), "{found}");
    }
    let unkept = simplify(&mesh, &pruned, &mut go_on()).unwrap();
    assert_eq!(topology(&unkept.mesh).components, 1);
}

#[test]
fn a_torn_surface_keeps_its_faces() {
    let sheets = shapes::tetrahedra_sharing_edge();
    let kept = vec![true; sheets.faces().len()];
    let attributes = Attributes::default();
    let before = input(&sheets, &attributes, &kept);
    let result = simplify(before, &Options::new(Size::Vertices(4)), &mut go_on()).unwrap();
    assert_kept(&before, &result);
}

#[test]
fn flags_that_do_not_fit_are_refused() {
    let mesh = shapes::icosphere(2);
    let attributes = Attributes::default();
    let short = vec![true; 3];
    let options = Options::new(Size::Ratio(0.5));
    let refused = simplify(input(&mesh, &attributes, &short), &options, &mut go_on());
    assert_eq!(refused.unwrap_err(), SimplifyError::BadInput);
}

#[test]
fn locked_vertices_keep_every_bit_with_and_without_vertices_that_no_face_uses() {
    let sphere = shapes::wavy_sphere(4, 5.0);
    let (mut positions, faces) = sphere.into_parts();
    positions.insert(0, [7.0; 3]);
    let mesh = TriMesh::new(positions, faces.into_iter().map(|face| face.map(|v| v + 1)).collect()).unwrap();
    let locked: Vec<bool> = (0..mesh.positions().len()).map(|v| v % 20 == 5).collect();
    let input = with_changes(Input::bare(&mesh), |input| input.locked = &locked);
    let result = simplify(input, &Options::new(Size::Faces(800)), &mut go_on()).unwrap();
    assert_eq!((result.mesh.faces().len(), result.report.locked_vertices), (800, 128));
    assert_closed_manifold(&result.mesh);
    let bits = |p: &[f32; 3]| p.map(f32::to_bits);
    let left: BTreeSet<[u32; 3]> = result.mesh.positions().iter().map(bits).collect();
    let held = mesh.positions().iter().zip(&locked).filter(|(_, locked)| **locked);
    assert!(held.map(|(p, _)| bits(p)).all(|p| left.contains(&p)));
    let short = with_changes(Input::bare(&mesh), |input| input.locked = &locked[1..]);
    let refused = simplify(short, &Options::new(Size::Faces(800)), &mut go_on()).unwrap_err();
    assert_eq!(refused, SimplifyError::BadInput);
}

#[test]
fn components_with_locked_vertices_are_dropped_for_nothing() {
    let (mesh, kept) = nested_spheres();
    let mut locked = vec![false; mesh.positions().len()];
    mesh.faces().iter().zip(&kept).filter(|(_, kept)| **kept).for_each(|(face, _)| locked[face[0] as usize] = true);
    let input = with_changes(Input::bare(&mesh), |input| input.locked = &locked);
    for options in [
        Options::with_closed(Size::Vertices(60), ClosedOptions { prune_below: 10.0, ..ClosedOptions::default() }),
        Options::with_closed(Size::Vertices(60), ClosedOptions { hidden: Hidden::Drop, ..ClosedOptions::default() }),
    ] {
        let result = simplify(input, &options, &mut go_on()).unwrap();
        let left: BTreeSet<[u32; 3]> = result.mesh.positions().iter().map(|p| p.map(f32::to_bits)).collect();
        let held = mesh.positions().iter().zip(&locked).filter(|(_, locked)| **locked);
        assert!(held.map(|(p, _)| p.map(f32::to_bits)).all(|p| left.contains(&p)));
    }
}
