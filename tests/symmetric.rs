//! Mirror-symmetric meshes give mirror-symmetric results, bit for bit.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

use glam::Vec3;
use neural_mesh::linalg::test_values::run_on_threads;
use neural_mesh::mesh::{Attributes, Channel, Frame, Role, TriMesh, seams, shapes, topology};
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::search::simplify_to_error;
use neural_mesh::simplify::{
    Axis, ClosedOptions, Input, MirrorPlane, Options, Outcome, SimplifyError, Symmetry, Target, simplify,
    simplify_levels_of_detail,
};

use crate::common::{assert_closed_manifold, assert_manifold, assert_same_topology, simplify_valid, with_changes};

fn go_on(_: neural_mesh::simplify::Event) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn options(target: Target, symmetry: Symmetry) -> Options {
    Options::with_closed(target, mirrored(symmetry))
}

fn mirrored(symmetry: Symmetry) -> ClosedOptions {
    ClosedOptions { symmetric: Some(symmetry), ..ClosedOptions::default() }
}

fn move_vertices(mesh: &TriMesh, to: impl Fn(Vec3) -> Vec3) -> TriMesh {
    let positions = mesh.positions().iter().map(|&p| to(p.into()).to_array()).collect();
    TriMesh::new(positions, mesh.faces().to_vec()).unwrap()
}

fn bumpy(level: u32) -> TriMesh {
    move_vertices(&shapes::icosphere(level), |p| {
        let x = p.x.abs();
        p * (1.0 + 0.15 * (6.0 * x).sin() * (4.0 * p.y + 1.0).cos() + 0.1 * (5.0 * p.z + 3.0 * x).sin())
    })
}

// Expects that every vertex and face has an exact mirror image.
#[track_caller]
fn assert_mirrored(mesh: &TriMesh, plane: &MirrorPlane) {
    let (axis, at) = (plane.axis.index(), plane.at);
    let bits = |p: [f32; 3]| p.map(|x| (x + 0.0).to_bits());
    let number: BTreeMap<[u32; 3], u32> = (0..).zip(mesh.positions()).map(|(v, &p)| (bits(p), v)).collect();
    let image = |p: [f32; 3]| {
        let mut q = p;
        let x = 2.0 * at - f64::from(p[axis]);
        q[axis] = x as f32;
        assert_eq!(f64::from(q[axis]), x, "an image that is no single number");
        q
    };
    let images: Vec<u32> = mesh.positions().iter().map(|&p| *number.get(&bits(image(p))).expect("an image")).collect();
    let rotated = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap();
    let faces: BTreeSet<[u32; 3]> = mesh.faces().iter().map(|&face| rotated(face)).collect();
    for &face in mesh.faces() {
        let [a, b, c] = face.map(|v| images[v as usize]);
        assert!(faces.contains(&rotated([a, c, b])), "a face without its image");
    }
}

fn distance(original: &TriMesh, result: &TriMesh) -> f64 {
    let [x, y] = [original, result].map(|mesh| Surface::new(mesh, 20_000, 0));
    surface_distance(&x, &y).unwrap().both.mean
}

#[test]
fn closed_stays_closed_and_mirrored_at_the_requested_size() {
    let tori = shapes::torus(64, 32, 1.0, 0.4);
    let meshes = [
        bumpy(4),
        move_vertices(&shapes::icosphere(4), |p| p + Vec3::new(0.7, 3.0, -2.0)),
        tori,
        shapes::plate(6, 0.02),
    ];
    for mesh in &meshes {
        for target in
            [Target::Ratio(0.5), Target::Vertices(301), Target::Vertices(300), Target::Faces(200), Target::Vertices(61)]
        {
            for symmetry in [Symmetry::Best, Symmetry::Across(Axis::X)] {
                let result = simplify_valid(mesh, &options(target, symmetry));
                assert_closed_manifold(&result.mesh);
                assert_same_topology(mesh, &result.mesh);
                assert_mirrored(&result.mesh, &result.report.mirror.unwrap());
                let (n_vertices, n_faces) = (result.mesh.positions().len(), result.mesh.faces().len());
                match target {
                    Target::Vertices(n) => assert_eq!(n_vertices, n),
                    Target::Faces(n) => assert_eq!(n_faces, n),
                    Target::Ratio(ratio) => assert_eq!(n_vertices, (ratio * mesh.positions().len() as f64) as usize),
                }
                assert_eq!(result.report.outcome, Outcome::Reached);
            }
        }
    }
}

#[test]
fn a_mirrored_result_lies_as_close_as_any() {
    for mesh in [bumpy(5), shapes::torus(96, 48, 1.0, 0.4)] {
        let n = mesh.positions().len() / 10;
        let plain = simplify_valid(&mesh, &Options::new(Target::Vertices(n)));
        let mirrored = simplify_valid(&mesh, &options(Target::Vertices(n), Symmetry::Across(Axis::X)));
        let quotient = distance(&mesh, &mirrored.mesh) / distance(&mesh, &plain.mesh);
        assert!(quotient < 1.1, "{quotient}");
    }
}

#[test]
fn planes_where_no_edge_runs_and_where_no_zero_is() {
    let cube = shapes::cuboid([1.0, 1.0, 1.0], 9);
    for (symmetry, plane) in [
        (Symmetry::Across(Axis::Y), MirrorPlane { axis: Axis::Y, at: 0.5 }),
        (Symmetry::Plane(MirrorPlane { axis: Axis::Z, at: 0.5 }), MirrorPlane { axis: Axis::Z, at: 0.5 }),
    ] {
        let result = simplify_valid(&cube, &options(Target::Vertices(101), symmetry));
        assert_eq!((result.report.mirror, result.mesh.positions().len()), (Some(plane), 101));
        assert_closed_manifold(&result.mesh);
        assert_mirrored(&result.mesh, &plane);
        assert!(distance(&cube, &result.mesh) < 2e-3);
    }
    // Coordinates have many digits or are far from the origin, which the frame then stores.
    let odd = move_vertices(&bumpy(4), |p| p * 0.37 + Vec3::new(12.345, 0.1, -7.0));
    let result = simplify_valid(&odd, &options(Target::Ratio(0.1), Symmetry::Best));
    assert_mirrored(&result.mesh, &result.report.mirror.unwrap());
    let frame = Frame { origin: [5e6, 0.0, 0.0], double: true };
    let far = ClosedOptions { frame, ..mirrored(Symmetry::Plane(MirrorPlane { axis: Axis::X, at: 5e6 })) };
    let result = simplify_valid(&bumpy(4), &Options::with_closed(Target::Ratio(0.1), far));
    assert_eq!(result.report.mirror.unwrap().at, 5e6);
    assert_mirrored(&result.mesh, &MirrorPlane { axis: Axis::X, at: 0.0 });
}

#[test]
fn down_to_the_smallest_it_stays_a_closed_mirrored_surface() {
    for mesh in [bumpy(3), shapes::torus(24, 12, 1.0, 0.4), shapes::cuboid([1.0; 3], 5), shapes::many_boxes(3)] {
        for n in [40, 20, 12, 9, 5, 4, 1] {
            let found = simplify(
                Input::bare(&mesh),
                None,
                &options(Target::Vertices(n), Symmetry::Across(Axis::Y)),
                &mut go_on,
            );
            let Ok(result) = found else {
                assert!(matches!(found, Err(SimplifyError::NotSymmetric { .. })));
                continue;
            };
            assert_closed_manifold(&result.mesh);
            assert_same_topology(&mesh, &result.mesh);
            assert_mirrored(&result.mesh, &result.report.mirror.unwrap());
        }
    }
}

// Builds the faces of the chosen octants over vertices (1, 0, 0), (-1, 0, 0), (0, 1, 0) and so on.
fn octahedron(has: impl Fn([bool; 3]) -> bool) -> TriMesh {
    let corner = |i: usize| std::array::from_fn(|k| if k == i / 2 { 1.0 - 2.0 * (i % 2) as f32 } else { 0.0 });
    let face = |signs: [bool; 3]| {
        let [x, y, z] = [0, 1, 2].map(|k| 2 * k as u32 + u32::from(signs[k]));
        if signs.iter().filter(|&&negative| negative).count() % 2 == 0 { [x, y, z] } else { [x, z, y] }
    };
    let octants = (0..8).map(|i| [i & 1, i & 2, i & 4].map(|bit| bit > 0)).filter(|&signs| has(signs));
    TriMesh::new((0..6).map(corner).collect(), octants.map(face).collect()).unwrap()
}

#[test]
fn the_smallest_has_no_face_twice_and_what_is_not_reached_is_said() {
    let octahedron = octahedron(|_| true);
    let tetrahedron = {
        let positions = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        TriMesh::new(positions, vec![[0, 1, 3], [3, 2, 0], [3, 1, 2], [2, 1, 0]]).unwrap()
    };
    let others =
        [shapes::icosphere(0), shapes::icosphere(2), shapes::cuboid([1.0; 3], 2), shapes::torus(8, 4, 1.0, 0.4)];
    for mesh in others.iter().chain([&octahedron, &tetrahedron]) {
        let targets = (1..24).map(Target::Vertices).chain((1..40).map(Target::Faces));
        for target in targets {
            let result = simplify_valid(mesh, &options(target, Symmetry::Across(Axis::Y)));
            assert_closed_manifold(&result.mesh);
            let triples: BTreeSet<BTreeSet<u32>> = result.mesh.faces().iter().map(|&face| face.into()).collect();
            assert_eq!(triples.len(), result.mesh.faces().len(), "{target:?}: a face twice");
            let (size, asked, step) = match target {
                // Without a possible merge within the plane, each merge removes four faces.
                Target::Faces(n) => (result.mesh.faces().len(), n, 3),
                Target::Vertices(n) => (result.mesh.positions().len(), n, 1),
                Target::Ratio(_) => unreachable!(),
            };
            let is_reached = result.report.outcome == Outcome::Reached;
            assert_eq!(is_reached, size <= asked, "{target:?}: {size}, {:?}", result.report.outcome);
            assert!(!is_reached || size + step >= asked || mesh.positions().len() < asked, "{target:?}: {size}");
        }
        let Outcome::Stopped(why) =
            simplify_valid(mesh, &options(Target::Vertices(1), Symmetry::Across(Axis::Y))).report.outcome
        else {
            panic!("one vertex")
        };
        assert!(why.contains("mirror plane") || why.contains("flip a face"), "{why}");
    }
    let least = simplify_valid(&octahedron, &options(Target::Ratio(0.5), Symmetry::Best));
    assert_eq!((least.mesh.positions().len(), least.mesh.faces().len()), (5, 6));
}

#[test]
fn open_surfaces_stay_in_one_piece_down_to_the_smallest() {
    let tube = shapes::open_cylinder(12, 1);
    let sector = |face: &[u32; 3]| {
        let middle = face.iter().map(|&v| Vec3::from(tube.positions()[v as usize])).sum::<Vec3>();
        (middle.y.atan2(middle.x) / std::f32::consts::TAU * 12.0).floor() as i32
    };
    let strips = tube.faces().iter().copied().filter(|face| sector(face).rem_euclid(4) > 0).collect();
    let strips = neural_mesh::mesh::compact(tube.positions(), strips).unwrap().0;
    assert_eq!(topology(&strips).components, 3);
    for (mesh, axes) in [(&tube, &Axis::ALL[..]), (&strips, &[Axis::Z]), (&shapes::grid(6, 5), &[Axis::X, Axis::Y])] {
        for (&axis, n) in axes.iter().flat_map(|axis| (1..30).map(move |n| (axis, n))) {
            let result = simplify_valid(mesh, &options(Target::Vertices(n), Symmetry::Across(axis)));
            assert_manifold(&result.mesh);
            assert_same_topology(mesh, &result.mesh);
            assert_mirrored(&result.mesh, &result.report.mirror.unwrap());
        }
    }
}

// Returns the number of faces without mirror image, from the error.
#[track_caller]
fn n_alone(mesh: &TriMesh, symmetry: Symmetry) -> usize {
    let asked = options(Target::Ratio(0.9), symmetry);
    match simplify(mesh, None, &asked, &mut go_on) {
        Err(SimplifyError::NotSymmetric { vertices: 0, faces, .. }) => faces,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_face_whose_image_is_missing_is_refused_though_all_vertices_have_theirs() {
    let without_one = octahedron(|signs| signs != [true, false, true]);
    for symmetry in Axis::ALL.map(Symmetry::Across).into_iter().chain([Symmetry::Best]) {
        assert_eq!(n_alone(&without_one, symmetry), 1);
    }
    // The boundary has a mirror image, edge by edge, but no face has.
    let kept = [[false, true, false], [false, true, true], [true, false, true], [true, true, false]];
    assert_eq!(n_alone(&octahedron(|signs| kept.contains(&signs)), Symmetry::Across(Axis::Y)), 1);
    // The sheet is so thin that its other side is where the mirrored face should be.
    let sheet = move_vertices(&shapes::icosphere(2), |p| Vec3::new(p.x, p.y, 1e-7 * p.z));
    let keeps = |lost: &dyn Fn(Vec3) -> bool| {
        let middle =
            |face: &[u32; 3]| face.iter().map(|&v| Vec3::from(sheet.positions()[v as usize])).sum::<Vec3>() / 3.0;
        let (lost, kept): (Vec<[u32; 3]>, _) = sheet.faces().iter().copied().partition(|face| lost(middle(face)));
        assert!(!lost.is_empty());
        TriMesh::new(sheet.positions().to_vec(), kept).unwrap()
    };
    let is_near = |p: Vec3| p.z > 0.0 && (p - Vec3::new(p.x.signum() * 0.5, 0.4, p.z)).length() < 0.1;
    assert!(n_alone(&keeps(&|p| is_near(p) && p.x > 0.0), Symmetry::Across(Axis::X)) > 0);
    // Missing on both sides, the face leaves two holes that are mirror images and stay.
    let holes = keeps(&is_near);
    let result = simplify_valid(&holes, &options(Target::Ratio(0.5), Symmetry::Across(Axis::X)));
    assert_eq!(topology(&result.mesh).boundary_loops, topology(&holes).boundary_loops);
    assert!(topology(&holes).boundary_loops == 2);
}

#[test]
fn a_gap_beside_the_plane_is_refused() {
    let tube = move_vertices(&shapes::open_cylinder(16, 1), |p| p);
    let is_kept = |face: &[u32; 3]| {
        let middle = face.iter().map(|&v| Vec3::from(tube.positions()[v as usize])).sum::<Vec3>() / 3.0;
        middle.x < 0.0 || !(0.0..0.3).contains(&middle.y)
    };
    let kept = tube.faces().iter().copied().filter(is_kept).collect();
    let gap = neural_mesh::mesh::compact(tube.positions(), kept).unwrap().0;
    assert_eq!(topology(&gap).boundary_loops, 1);
    let asked = options(Target::Ratio(0.5), Symmetry::Across(Axis::Y));
    let found = simplify(&gap, None, &asked, &mut go_on);
    assert!(matches!(found, Err(SimplifyError::NotSymmetric { .. })), "{found:?}");
}

#[test]
fn of_planes_with_all_vertices_that_is_taken_in_which_faces_have_images() {
    // The two missing faces are mirror images in z = 0 only.
    let two_missing = octahedron(|[x, y, _]| !(x && y));
    let result = simplify_valid(&two_missing, &options(Target::Vertices(6), Symmetry::Best));
    assert_eq!(result.report.mirror.unwrap().axis, Axis::Z);
    assert_same_topology(&two_missing, &result.mesh);
}

#[test]
fn quads_cut_along_other_diagonals_are_mirrored() {
    // The quads are steep; those with x > 0 are split along the other diagonal.
    let grid = shapes::grid(8, 8);
    let steep = |p: Vec3| Vec3::new(p.x, p.y, 0.3 * ((7.0 * (p.x - 0.5).abs()).sin() * (9.0 * p.y).cos()));
    let quads = grid.faces().chunks(2).flat_map(|quad| {
        let shared: Vec<u32> = quad[0].iter().copied().filter(|v| quad[1].contains(v)).collect();
        let alone = |f: usize| quad[f].iter().copied().find(|v| !shared.contains(v)).unwrap();
        let is_right = grid.positions()[shared[0] as usize][0] > 0.5 || grid.positions()[shared[1] as usize][0] > 0.5;
        let k = quad[0].iter().position(|v| *v == alone(0)).unwrap();
        let [a, b, c, d] = [alone(0), quad[0][(k + 1) % 3], alone(1), quad[0][(k + 2) % 3]];
        if is_right { [[a, b, c], [a, c, d]] } else { [quad[0], quad[1]] }
    });
    let mesh = move_vertices(&TriMesh::new(grid.positions().to_vec(), quads.collect()).unwrap(), steep);
    let result = simplify_valid(&mesh, &options(Target::Ratio(0.8), Symmetry::Across(Axis::X)));
    assert_same_topology(&mesh, &result.mesh);
    assert_mirrored(&result.mesh, &result.report.mirror.unwrap());
}

#[test]
fn a_fan_that_touches_a_sheet_on_the_plane_comes_apart_from_its_image() {
    // A fan and its image touch the middle of a sheet that crosses the plane x = 0.
    let sheet = move_vertices(&shapes::grid(4, 4), |p| Vec3::new(p.x - 0.5, p.y - 0.5, 0.0));
    let middle = sheet.positions().iter().position(|p| *p == [0.0; 3]).unwrap() as u32;
    let (mut positions, mut faces) = (sheet.positions().to_vec(), sheet.faces().to_vec());
    for side in [1.0, -1.0] {
        let first = positions.len() as u32;
        positions.extend((0..4).map(|i| [0.3 * side, 0.1 * (i as f32 - 1.5), 0.5]));
        let fan = (0..3).map(|i| [middle, first + i, first + i + 1]);
        faces.extend(fan.map(|[a, b, c]| if side > 0.0 { [a, b, c] } else { [a, c, b] }));
    }
    let touching = TriMesh::new(positions, faces).unwrap();
    for n in [33, 25, 15] {
        let result = simplify_valid(&touching, &options(Target::Vertices(n), Symmetry::Across(Axis::X)));
        assert_manifold(&result.mesh);
        assert_mirrored(&result.mesh, &result.report.mirror.unwrap());
        assert_eq!(topology(&result.mesh).components, 3);
    }
}

#[test]
fn solids_that_touch_the_plane_with_an_edge_come_apart() {
    // A box has an edge in the plane x = 0; its image shares the vertices of that edge.
    let solid = move_vertices(&shapes::cuboid([1.0; 3], 6), |p| Vec3::new(p.x + p.y, p.y - p.x, p.z));
    let mut positions = solid.positions().to_vec();
    let image = |v: u32, positions: &mut Vec<[f32; 3]>| match solid.positions()[v as usize] {
        [0.0, ..] => v,
        [x, y, z] => {
            positions.push([-x, y, z]);
            positions.len() as u32 - 1
        }
    };
    let images: Vec<u32> = (0..solid.positions().len() as u32).map(|v| image(v, &mut positions)).collect();
    let turned = solid.faces().iter().map(|&[a, b, c]| [a, c, b].map(|v| images[v as usize]));
    let both = TriMesh::new(positions, solid.faces().iter().copied().chain(turned).collect()).unwrap();
    assert!(topology(&both).non_manifold_edges > 0);
    for n in [200, 60, 16] {
        let result = simplify_valid(&both, &options(Target::Vertices(n), Symmetry::Best));
        assert_closed_manifold(&result.mesh);
        assert_mirrored(&result.mesh, &MirrorPlane { axis: Axis::X, at: 0.0 });
        assert_eq!((topology(&result.mesh).components, result.mesh.positions().len()), (2, n));
    }
}

#[test]
fn open_surfaces_keep_their_boundaries() {
    let tube = move_vertices(&shapes::open_cylinder(48, 24), |p| p);
    for axis in [Axis::X, Axis::Z] {
        let result = simplify_valid(&tube, &options(Target::Vertices(150), Symmetry::Across(axis)));
        assert_manifold(&result.mesh);
        assert_same_topology(&tube, &result.mesh);
        assert_mirrored(&result.mesh, &result.report.mirror.unwrap());
        assert!(distance(&tube, &result.mesh) < 0.01);
    }
}

#[test]
fn each_side_keeps_its_own_texture_and_groups() {
    // A ring of vertices is on the plane.
    let mesh = shapes::torus(64, 32, 1.0, 0.4);
    let outward = |p: Vec3| (p - Vec3::new(p.x, p.y, 0.0).normalize()).normalize();
    // The right half is in the chart about u = 0, the left half about u = 10, or one chart covers both.
    for (apart, normals) in [(10.0, false), (0.0, true)] {
        let side = |face: &[u32; 3]| {
            let sum: f32 = face.iter().map(|&v| mesh.positions()[v as usize][0]).sum();
            if sum > 0.0 { 0.0 } else { apart }
        };
        let value = |v: u32, face: &[u32; 3]| {
            let p = Vec3::from(mesh.positions()[v as usize]);
            [p.z + side(face) + 0.3 * p.x, p.y]
        };
        let values = mesh.faces().iter().flat_map(|face| face.map(|v| value(v, face))).flatten().collect();
        let wedges = (0..mesh.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let mut channels = vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }];
        if normals {
            let normal = |&v: &u32| outward(mesh.positions()[v as usize].into()).to_array();
            let values = mesh.faces().as_flattened().iter().flat_map(normal).collect();
            channels.push(Channel { name: "normal".into(), role: Role::Normal, width: 3, values });
        }
        let groups = mesh.faces().iter().map(|face| u32::from(side(face) > 0.0)).collect();
        let attributes = Attributes { wedges, channels, groups };
        let input = with_changes(Input::bare(&mesh), |input| input.attributes = &attributes);
        let asked = options(Target::Vertices(250), Symmetry::Across(Axis::X));
        let result = simplify_valid(input, &asked);
        assert_closed_manifold(&result.mesh);
        assert_mirrored(&result.mesh, &MirrorPlane { axis: Axis::X, at: 0.0 });
        let carried = &result.attributes;
        assert!(carried.is_valid_for(result.mesh.faces().len()) && carried.channels.len() == 1 + usize::from(normals));
        let mut worst = 0.0f32;
        for (f, face) in result.mesh.faces().iter().enumerate() {
            let middle: Vec3 =
                face.iter().map(|&v| Vec3::from(result.mesh.positions()[v as usize])).sum::<Vec3>() / 3.0;
            let meant = if middle.x > 0.0 { 0.0 } else { apart };
            assert_eq!(carried.group(f as u32), u32::from(meant > 0.0));
            for (&v, &wedge) in face.iter().zip(&carried.wedges[f]) {
                let p = Vec3::from(result.mesh.positions()[v as usize]);
                let uv = carried.channels[0].value(wedge);
                worst = worst.max((uv[0] - (p.z + meant + 0.3 * p.x)).abs()).max((uv[1] - p.y).abs());
                if normals {
                    assert!(Vec3::from_slice(carried.channels[1].value(wedge)).dot(outward(p)) > 0.95);
                }
            }
        }
        assert!(worst < 0.1, "{worst}");
        // With separate charts the plane is a seam; with one chart there is no seam.
        let n_seams = seams(&result.mesh, carried, 0.0).len();
        assert_eq!(n_seams > 0, apart > 0.0, "{n_seams}");
    }
}

#[test]
fn a_mesh_that_is_none_is_refused_with_the_number_of_vertices() {
    let lopsided = move_vertices(&bumpy(3), |p| if p.x > 0.5 { p + Vec3::new(0.1, 0.0, 0.0) } else { p });
    let asked = options(Target::Ratio(0.5), Symmetry::Across(Axis::X));
    let error = simplify(&lopsided, None, &asked, &mut go_on).unwrap_err();
    assert!(matches!(error, SimplifyError::NotSymmetric { vertices: 1.., .. }), "{error:?}");
    assert!(error.to_string().contains("not symmetric about x = 0"), "{error}");
    let both = ClosedOptions { map: true, ..mirrored(Symmetry::Across(Axis::X)) };
    let both = Options::with_closed(Target::Ratio(0.5), both);
    let error = simplify(&bumpy(3), None, &both, &mut go_on).unwrap_err();
    assert_eq!(error, SimplifyError::NotWithSymmetry("a map"));
    let flat = shapes::grid(4, 4);
    let asked = options(Target::Ratio(0.5), Symmetry::Plane(MirrorPlane { axis: Axis::Z, at: 0.0 }));
    let error = simplify(&flat, None, &asked, &mut go_on).unwrap_err();
    assert_eq!(error, SimplifyError::InMirrorPlane(32));
}

#[test]
fn levels_and_proved_distances_are_mirrored_too() {
    let mesh = bumpy(4);
    let asked = mirrored(Symmetry::Best);
    let targets = [Target::Ratio(0.5), Target::Vertices(500), Target::Vertices(99)];
    let levels = simplify_levels_of_detail(&mesh, None, &asked, &targets, &mut go_on).unwrap();
    for (level, n) in levels.iter().zip([1281, 500, 99]) {
        assert_eq!(level.mesh.positions().len(), n);
        assert_mirrored(&level.mesh, &level.report.mirror.unwrap());
        assert!(topology(&level.mesh).is_closed_manifold());
    }
    let found = simplify_to_error(&Input::bare(&mesh), None, &asked, 0.05, &mut go_on).unwrap();
    assert!(found.distance.upper <= 0.05 && found.simplified.mesh.positions().len() < 800);
    assert_mirrored(&found.simplified.mesh, &found.simplified.report.mirror.unwrap());
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let mesh = bumpy(4);
    let result = |n| run_on_threads(n, || simplify_valid(&mesh, &options(Target::Ratio(0.1), Symmetry::Best)));
    assert_eq!(result(1), result(3));
}
