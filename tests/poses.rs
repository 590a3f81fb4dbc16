//! Results for other poses, where morph targets move the mesh.

use crate::common::with_changes;
use std::ops::ControlFlow;

use neural_mesh::mesh::{Attributes, Channel, Role, TriMesh, shapes, topology};
use neural_mesh::metrics::quick_distance;
use neural_mesh::simplify::{ClosedOptions, Input, Options, Purpose, Simplified, SimplifyError, Size, simplify};

// Bends a point of a slab into three quarters of a ring.
fn bend_point([x, y, z]: [f32; 3]) -> [f32; 3] {
    let (radius, angle) = (2.0 - z, 0.55 * x);
    [radius * angle.sin(), y, 2.0 - radius * angle.cos()]
}

// Builds a slab 8 long, and a morph target that bends it.
fn slab() -> (TriMesh, Attributes) {
    let mesh = shapes::cuboid([8.0, 1.0, 0.5], 24);
    let step = |&p: &[f32; 3]| std::array::from_fn::<f32, 3, _>(|i| bend_point(p)[i] - p[i]);
    let values = mesh.positions().iter().flat_map(step).collect();
    let bend = Channel { name: "TARGET_0/POSITION".into(), role: Role::MorphPosition, width: 3, values };
    let attributes = Attributes { wedges: mesh.faces().to_vec(), channels: vec![bend], groups: Vec::new() };
    (mesh, attributes)
}

fn for_purpose(target: Size, purpose: Purpose) -> Options {
    Options::with_closed(target, ClosedOptions { purpose, ..ClosedOptions::default() })
}

fn simplify_with_attributes(
    mesh: &TriMesh,
    attributes: &Attributes,
    options: &Options,
) -> Result<Simplified, SimplifyError> {
    let input = with_changes(Input::bare(mesh), |input| input.attributes = attributes);
    simplify(input, options, &mut |_| ControlFlow::Continue(()))
}

fn apply_pose(mesh: &TriMesh, attributes: &Attributes) -> TriMesh {
    let mut positions = mesh.positions().to_vec();
    for (face, wedges) in mesh.faces().iter().zip(&attributes.wedges) {
        for (&v, &wedge) in face.iter().zip(wedges) {
            let step = attributes.channels[0].value(wedge);
            positions[v as usize] = std::array::from_fn(|i| mesh.positions()[v as usize][i] + step[i]);
        }
    }
    TriMesh::new(positions, mesh.faces().to_vec()).unwrap()
}

#[test]
fn flat_regions_keep_vertices_that_bend_in_other_poses() {
    let (mesh, attributes) = slab();
    let distances = [Purpose::Shape, Purpose::Poses].map(|purpose| {
        let options = for_purpose(Size::Vertices(60), purpose);
        let result = simplify_with_attributes(&mesh, &attributes, &options).unwrap();
        assert_eq!(result.mesh.positions().len(), 60);
        assert!(topology(&result.mesh).is_closed_manifold());
        let far = |original: &TriMesh, found: &TriMesh| quick_distance(original, found, 20_000, 0).unwrap().mean;
        let pose = apply_pose(&result.mesh, &result.attributes);
        [far(&mesh, &result.mesh), far(&apply_pose(&mesh, &attributes), &pose)]
    });
    let [[_, in_pose], [here, in_pose_for_poses]] = distances;
    assert!(in_pose_for_poses < 0.7 * in_pose && here < 0.001, "{distances:?}");
}

#[test]
fn unknown_poses_are_nearer_with_the_pull_for_poses() {
    let moved = |mesh: &TriMesh, place: fn([f32; 3]) -> [f32; 3]| {
        TriMesh::new(mesh.positions().iter().copied().map(place).collect(), mesh.faces().to_vec()).unwrap()
    };
    let limb = moved(&shapes::open_cylinder(24, 96), |[x, y, z]| [4.0 * z, 0.3 * y, 0.3 * x]);
    let ring = |mesh: &TriMesh| moved(mesh, bend_point);
    let [in_pose, in_pose_bending] = [Purpose::Shape, Purpose::Poses].map(|purpose| {
        let options = for_purpose(Size::Vertices(150), purpose);
        let result = simplify_with_attributes(&limb, &Attributes::default(), &options).unwrap();
        assert_eq!(result.mesh.positions().len(), 150);
        assert!(quick_distance(&limb, &result.mesh, 20_000, 0).unwrap().mean < 0.02);
        quick_distance(&ring(&limb), &ring(&result.mesh), 20_000, 0).unwrap().mean
    });
    assert!(in_pose_bending < 0.7 * in_pose, "{in_pose_bending} {in_pose}");
}

#[test]
fn a_mesh_without_area_bends_nowhere() {
    let line =
        TriMesh::new((0..9).map(|i| [i as f32, 0.0, 0.0]).collect(), vec![[0, 3, 8], [1, 4, 7], [2, 5, 6]]).unwrap();
    let options = for_purpose(Size::Ratio(0.5), Purpose::Poses);
    let result = simplify_with_attributes(&line, &Attributes::default(), &options).unwrap();
    assert!(result.mesh.positions().iter().flatten().all(|x| x.is_finite()));
}
