//! Attributes of whole meshes: seams stay seams, values stay in place.

use crate::common::{simplify_valid, with_changes};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

use glam::Vec3;
use neural_mesh::mesh::{
    Attributes, Channel, FeatureEdge, Role, TriMesh, edges, seams, shapes, topology, vertex_normals, with_flat_normals,
};
use neural_mesh::metrics::quick_distance;
use neural_mesh::simplify::{ClosedOptions, Input, Options, Outcome, SEAM_ERROR, Simplified, Size, simplify};

fn simplify_with_attributes(mesh: &TriMesh, attributes: &Attributes, options: &Options) -> Simplified {
    let input = with_changes(Input::bare(mesh), |input| input.attributes = attributes);
    simplify_valid(input, options)
}

fn octant(p: Vec3) -> u32 {
    u32::from(p.x > 0.0) + 2 * u32::from(p.y > 0.0) + 4 * u32::from(p.z > 0.0)
}

// Returns the texture coordinates of a point in an octant's chart.
fn uv(p: Vec3, octant: u32) -> [f32; 2] {
    [10.0 * octant as f32 + p.x + 0.5 * p.z, p.y - 0.5 * p.z]
}

// Builds a bumpy sphere in eight charts, with a wedge for each corner.
fn charted_sphere() -> (TriMesh, Attributes) {
    let mesh = shapes::wavy_sphere(5, 6.0);
    let position = |v: u32| Vec3::from(mesh.positions()[v as usize]);
    let groups: Vec<u32> =
        mesh.faces().iter().map(|face| octant(face.iter().map(|&v| position(v)).sum::<Vec3>())).collect();
    let corners = mesh.faces().iter().zip(&groups).flat_map(|(face, &group)| face.map(|v| uv(position(v), group)));
    let values = corners.flatten().collect();
    let wedges = (0..mesh.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let channels = vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }];
    (mesh, Attributes { wedges, channels, groups })
}

#[test]
fn no_face_mixes_charts_and_values_stay_where_they_were() {
    let (mesh, mut attributes) = charted_sphere();
    let off_plane = |v: &u32| Vec3::from(mesh.positions()[*v as usize]).abs().min_element();
    let vertices = |mesh: &TriMesh, of: &Attributes| -> Vec<u32> {
        seams(mesh, of, 0.0).iter().flat_map(|seam| seam.ends).collect()
    };
    let widest = vertices(&mesh, &attributes).iter().map(off_plane).fold(0.0, f32::max);
    let groups = std::mem::take(&mut attributes.groups);
    let held = 0.0;
    for (with_groups, n, seam_error) in [
        (false, 2000, held),
        (true, 800, SEAM_ERROR),
        (false, 150, held),
        (true, 150, held),
        (false, 2000, SEAM_ERROR),
        (false, 150, SEAM_ERROR),
    ] {
        attributes.groups = if with_groups { groups.clone() } else { Vec::new() };
        let options = Options::with_closed(Size::Vertices(n), ClosedOptions { seam_error, ..ClosedOptions::default() });
        let result = simplify_with_attributes(&mesh, &attributes, &options);
        assert_eq!((&result.report.outcome, result.mesh.positions().len()), (&Outcome::Reached, n));
        assert!(topology(&result.mesh).is_closed_manifold());
        let carried = &result.attributes;
        let mut worst = 0.0f32;
        for (face, wedges) in result.mesh.faces().iter().zip(&carried.wedges) {
            let charts = wedges.map(|wedge| (carried.channels[0].value(wedge)[0] / 10.0).round() as u32);
            assert!(charts == [charts[0]; 3], "{charts:?}");
            for (&v, &wedge) in face.iter().zip(wedges) {
                let (meant, found) =
                    (uv(result.mesh.positions()[v as usize].into(), charts[0]), carried.channels[0].value(wedge));
                worst = worst.max((0..2).map(|i| (meant[i] - found[i]).abs()).fold(0.0, f32::max));
            }
        }
        // Group borders are exact; a curve with slack may deviate by as much as the target allows.
        let slack = if with_groups || seam_error == held { 0.0 } else { 1.0 / (n as f32).sqrt() };
        assert!(worst < 0.08 + slack, "{n} {worst}");
        let n_charts: BTreeSet<u32> =
            (0..carried.n_wedges() as u32).map(|w| (carried.channels[0].value(w)[0] / 10.0).round() as u32).collect();
        assert_eq!(n_charts.len(), 8);
        assert_eq!(carried.groups.len(), if with_groups { result.mesh.faces().len() } else { 0 });
        for v in vertices(&result.mesh, carried) {
            let p = Vec3::from(result.mesh.positions()[v as usize]);
            let most = widest + slack + if n < 500 { 0.06 } else { 0.02 };
            assert!(p.abs().min_element() < most, "a seam left its curve: {p}");
        }
    }
}

#[test]
fn stripes_from_a_palette_keep_their_areas() {
    // Each face shows one point of the texture, the colour of its stripe.
    let (mesh, mut attributes) = charted_sphere();
    attributes.groups = Vec::new();
    let centre = |mesh: &TriMesh, f: usize| {
        mesh.faces()[f].map(|v| Vec3::from(mesh.positions()[v as usize])).iter().sum::<Vec3>() / 3.0
    };
    let colour = |f: usize| if (5.0 * centre(&mesh, f).z).rem_euclid(2.0) < 1.0 { 0.25 } else { 0.75 };
    attributes.channels[0].values = (0..mesh.faces().len()).flat_map(|f| [colour(f), 0.5].repeat(3)).collect();
    let dark_share = |mesh: &TriMesh, attributes: &Attributes| {
        let (mut dark, mut all) = (0.0, 0.0);
        for (face, wedges) in mesh.faces().iter().zip(&attributes.wedges) {
            let [a, b, c] = face.map(|v| Vec3::from(mesh.positions()[v as usize]));
            let area = (b - a).cross(c - a).length();
            let colours = wedges.map(|wedge| attributes.channels[0].value(wedge)[0]);
            let are_all = |colour: f32| colours.iter().all(|x| (x - colour).abs() < 1e-5);
            assert!(are_all(0.25) || are_all(0.75), "{colours:?}");
            all += area;
            dark += if are_all(0.25) { area } else { 0.0 };
        }
        dark / all
    };
    let before = dark_share(&mesh, &attributes);
    let result = simplify_with_attributes(&mesh, &attributes, &Options::new(Size::Ratio(0.05)));
    assert_eq!(result.report.outcome, Outcome::Reached);
    let after = dark_share(&result.mesh, &result.attributes);
    assert!((after - before).abs() < 0.02, "{before} {after}");
    // The stripes stay in place, not only in area.
    let is_off = |f: &usize| {
        let wedge = result.attributes.wedges[*f][0];
        let near = (0..mesh.faces().len()).min_by(|&x, &y| {
            let distance = |g: usize| centre(&mesh, g).distance(centre(&result.mesh, *f));
            distance(x).total_cmp(&distance(y))
        });
        near.is_some_and(|near| (colour(near) - result.attributes.channels[0].value(wedge)[0]).abs() > 0.1)
    };
    let n_off = (0..result.mesh.faces().len()).filter(is_off).count();
    assert!(50 * n_off < result.mesh.faces().len(), "{n_off} of {}", result.mesh.faces().len());
}

#[test]
fn a_seam_within_one_chart_stays_a_seam() {
    // The seam goes around a torus: u jumps from 1 to 0 there.
    let mesh = shapes::torus(96, 32, 1.0, 0.4);
    let turn = |v: u32, face: &[u32; 3]| {
        let angle = |v: u32| {
            let p = mesh.positions()[v as usize];
            (p[1].atan2(p[0]) / std::f32::consts::TAU).rem_euclid(1.0)
        };
        let others = face.iter().map(|&w| angle(w)).fold(0.0, f32::max);
        if angle(v) < 0.25 && others > 0.75 { angle(v) + 1.0 } else { angle(v) }
    };
    let values = mesh.faces().iter().flat_map(|face| face.map(|v| [turn(v, face), 0.0])).flatten().collect();
    let wedges = (0..mesh.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let channels = vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }];
    let attributes = Attributes { wedges, channels, groups: Vec::new() };
    let result = simplify_with_attributes(&mesh, &attributes, &Options::new(Size::Vertices(300)));
    for wedges in &result.attributes.wedges {
        let u = wedges.map(|wedge| result.attributes.channels[0].value(wedge)[0]);
        let width = u.iter().copied().fold(f32::MIN, f32::max) - u.iter().copied().fold(f32::MAX, f32::min);
        assert!(width < 0.3, "{u:?}");
    }
    assert!(seams(&result.mesh, &result.attributes, 0.0).len() > 4);
}

// Builds patches of materials over a bumpy sphere, `n` along each side of a cube around it.
fn build_patches(n: f32) -> (TriMesh, Attributes) {
    let mesh = shapes::wavy_sphere(5, 6.0);
    let patch = |face: &[u32; 3]| {
        let centre = face.iter().map(|&v| Vec3::from(mesh.positions()[v as usize])).sum::<Vec3>() / 3.0;
        let [x, y, z] = (0.5 * n * (centre + Vec3::ONE)).to_array().map(|x| x.floor().max(0.0) as u32);
        x + 32 * (y + 32 * z)
    };
    let groups = mesh.faces().iter().map(patch).collect();
    (mesh, Attributes { groups, ..Attributes::default() })
}

#[test]
fn held_vertices_never_spoil_the_rest() {
    let (mesh, attributes) = build_patches(12.0);
    let far = |found: &TriMesh| quick_distance(&mesh, found, 8000, 0).unwrap().mean;
    for n in [4000, 700, 500] {
        let options = Options::new(Size::Vertices(n));
        let [held, bare] =
            [&attributes, &Attributes::default()].map(|it| simplify_with_attributes(&mesh, it, &options));
        let (held_far, bare_far) = (far(&held.mesh), far(&bare.mesh));
        // A result this close is not distorted.
        assert!(held_far < (3.3 * bare_far).max(2e-4), "{n}: {held_far} {bare_far}");
        assert!(topology(&held.mesh).is_closed_manifold());
        assert_eq!((&held.report.outcome, held.mesh.positions().len()), (&Outcome::Reached, n));
    }
    // With held shapes the size gives way instead.
    let holding = ClosedOptions { hold_shape: Some(0.01), ..ClosedOptions::default() };
    let held = simplify_with_attributes(&mesh, &attributes, &Options::with_closed(Size::Vertices(500), holding));
    assert!(matches!(&held.report.outcome, Outcome::Stopped(why) if why.contains("would damage the shape")));
    assert!((501..4000).contains(&held.mesh.positions().len()));
}

#[test]
fn free_curves_keep_materials_and_charts_apart() {
    let (mesh, patches) = build_patches(8.0);
    // Each patch has its place on the texture; values are positions.
    let number: BTreeMap<u32, u32> =
        patches.groups.iter().copied().collect::<BTreeSet<u32>>().into_iter().zip(0..).collect();
    let groups: Vec<u32> = patches.groups.iter().map(|group| number[group]).collect();
    let corners = mesh.faces().iter().zip(&groups);
    let uv =
        |v: u32, group: u32| [mesh.positions()[v as usize][0] + 10.0 * group as f32, mesh.positions()[v as usize][1]];
    let values = corners.flat_map(|(face, &group)| face.map(|v| uv(v, group))).flatten().collect();
    let wedges = (0..mesh.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let channels = vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }];
    let attributes = Attributes { groups, wedges, channels };
    for n in [400, 60, 12] {
        let result = simplify_with_attributes(&mesh, &attributes, &Options::new(Size::Vertices(n)));
        assert_eq!((&result.report.outcome, result.mesh.positions().len()), (&Outcome::Reached, n));
        for (face, (wedges, group)) in
            result.mesh.faces().iter().zip(result.attributes.wedges.iter().zip(&result.attributes.groups))
        {
            for (&v, &wedge) in face.iter().zip(wedges) {
                let value = result.attributes.channels[0].value(wedge);
                let off = value[0] - 10.0 * *group as f32 - result.mesh.positions()[v as usize][0];
                assert!(off.abs() < 2.5, "{n}: {value:?} of group {group}");
            }
        }
    }
}

#[test]
fn flat_shading_holds_nothing_and_stays_flat() {
    let mesh = shapes::wavy_sphere(5, 6.0);
    let flat = with_flat_normals(&mesh, &Attributes::default(), "NORMAL");
    let options = Options::new(Size::Vertices(150));
    let [result, bare] = [&flat, &Attributes::default()].map(|it| simplify_with_attributes(&mesh, it, &options));
    assert_eq!((&result.report.outcome, &result.mesh), (&Outcome::Reached, &bare.mesh));
    assert_eq!(result.attributes, with_flat_normals(&bare.mesh, &Attributes::default(), "NORMAL"));
}

#[test]
fn hard_edges_make_way_and_stay_where_they_are() {
    // Each octant of a sphere is shaded as if it were tilted.
    let mesh = shapes::wavy_sphere(5, 6.0);
    let tilt = |octant: u32| [0, 1, 2].map(|axis| if octant >> axis & 1 == 1 { 0.4 } else { -0.4 });
    let centre = |face: &[u32; 3]| face.iter().map(|&v| Vec3::from(mesh.positions()[v as usize])).sum::<Vec3>();
    let shaded = |p: Vec3, octant: u32| (p.normalize() + Vec3::from(tilt(octant))).normalize().to_array();
    let corners = mesh.faces().iter().map(|face| (face, octant(centre(face))));
    let values = corners.flat_map(|(face, octant)| {
        face.map(|v| shaded(Vec3::from(mesh.positions()[v as usize]), octant)).into_iter().flatten()
    });
    let channels = vec![Channel { name: "n".into(), role: Role::Normal, width: 3, values: values.collect() }];
    let wedges = (0..mesh.faces().len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let attributes = Attributes { wedges, channels, groups: Vec::new() };
    for n in [400, 40] {
        let result = simplify_with_attributes(&mesh, &attributes, &Options::new(Size::Vertices(n)));
        assert_eq!((&result.report.outcome, result.mesh.positions().len()), (&Outcome::Reached, n));
        assert!(topology(&result.mesh).is_closed_manifold());
        let off = |seam: &FeatureEdge| {
            let far = |&v: &u32| Vec3::from(result.mesh.positions()[v as usize]).abs().min_element();
            seam.ends.iter().map(far).fold(0.0, f32::max)
        };
        let seams = seams(&result.mesh, &result.attributes, 0.0);
        let worst = seams.iter().map(off).fold(0.0, f32::max);
        assert!(!seams.is_empty() && worst < 2.0 / (n as f32).sqrt(), "{n}: {worst}");
    }
}

#[test]
fn small_charts_yield_to_the_requested_size() {
    let mesh = shapes::torus(96, 48, 1.0, 0.4);
    let n_faces = mesh.faces().len() as u32;
    // Faces come in pairs, in the order of the grid; charts are four squares wide and high.
    let chart = |face: u32| (face / 2 / 48 / 4) * 12 + face / 2 % 48 / 4;
    let uv = |face: u32, v: u32| {
        let [x, y, z] = mesh.positions()[v as usize];
        [0.08 * (x + z) + (chart(face) % 16) as f32, 0.08 * (y - z) + (chart(face) / 16) as f32]
    };
    let corners = (0..n_faces).flat_map(|f| mesh.faces()[f as usize].map(|v| uv(f, v)));
    let values: Vec<f32> = corners.flatten().collect();
    let wedges = (0..n_faces).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let channels = vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }];
    let attributes = Attributes { wedges, channels, groups: Vec::new() };
    let size = Size::Vertices(230);
    let held = simplify_with_attributes(
        &mesh,
        &attributes,
        &Options::with_closed(size, ClosedOptions { seam_error: 0.0, ..ClosedOptions::default() }),
    );
    let result = simplify_with_attributes(&mesh, &attributes, &Options::new(size));
    let bare = simplify_with_attributes(&mesh, &Attributes::default(), &Options::new(size));
    assert_eq!((&result.report.outcome, result.mesh.positions().len()), (&Outcome::Reached, 230));
    assert!(topology(&result.mesh).is_closed_manifold());
    let far = |found: &TriMesh| quick_distance(&mesh, found, 8000, 0).unwrap().mean;
    let [charted, bare] = [&result, &bare].map(|result| far(&result.mesh));
    assert!(charted < 1.5 * bare, "{charted} {bare}");
    assert!(matches!(held.report.outcome, Outcome::Stopped(_)) || far(&held.mesh) > charted);
    for wedges in &result.attributes.wedges {
        let charts =
            wedges.map(|wedge| result.attributes.channels[0].value(wedge)).map(|uv| [uv[0].round(), uv[1].round()]);
        assert_eq!(charts, [charts[0]; 3]);
    }
}

#[test]
fn locked_boundaries_keep_every_bit() {
    let mesh = shapes::open_cylinder(60, 40);
    let boundary = |mesh: &TriMesh| -> BTreeSet<[[u32; 3]; 2]> {
        let bits = |v: u32| mesh.positions()[v as usize].map(f32::to_bits);
        let mut ends: Vec<_> = edges(mesh).into_iter().filter(|e| e.n_faces() == 1).map(|e| e.ends.map(bits)).collect();
        ends.iter_mut().for_each(|ends| ends.sort_unstable());
        ends.into_iter().collect()
    };
    for n in [1500, 250, 150] {
        let options = Options::with_closed(
            Size::Vertices(n),
            ClosedOptions { lock_boundaries: true, ..ClosedOptions::default() },
        );
        let result = simplify_with_attributes(&mesh, &Attributes::default(), &options);
        assert_eq!(result.mesh.positions().len(), n);
        assert_eq!(boundary(&result.mesh), boundary(&mesh));
        assert_eq!(result.report.locked_vertices, 120);
    }
    let options =
        Options::with_closed(Size::Vertices(50), ClosedOptions { lock_boundaries: true, ..ClosedOptions::default() });
    let result = simplify_with_attributes(&mesh, &Attributes::default(), &options);
    assert!(result.mesh.positions().len() >= 120 && result.report.outcome != Outcome::Reached);
    assert_eq!(boundary(&result.mesh), boundary(&mesh));
}

#[test]
fn a_subset_moves_no_vertex() {
    let mesh = shapes::wavy_sphere(5, 7.0);
    for n in [2000, 300] {
        let options =
            Options::with_closed(Size::Vertices(n), ClosedOptions { subset: true, ..ClosedOptions::default() });
        let result = simplify_with_attributes(&mesh, &Attributes::default(), &options);
        let sources = result.source_vertices.unwrap();
        assert_eq!(result.mesh.positions().len(), n);
        assert!(topology(&result.mesh).is_closed_manifold());
        let distinct: BTreeSet<u32> = sources.iter().copied().collect();
        assert_eq!(distinct.len(), n);
        assert!(result.mesh.positions().iter().zip(&sources).all(|(p, &v)| *p == mesh.positions()[v as usize]));
    }
}

#[test]
fn the_map_leads_from_every_corner_to_a_point_near_it() {
    let (mesh, attributes) = charted_sphere();
    let options = Options::with_closed(Size::Vertices(700), ClosedOptions { map: true, ..ClosedOptions::default() });
    for attributes in [&attributes, &Attributes::default()] {
        let result = simplify_with_attributes(&mesh, attributes, &options);
        let map = result.map.unwrap();
        let point = |v: u32| Vec3::from(mesh.positions()[v as usize]);
        for (f, corners) in result.mesh.faces().iter().enumerate() {
            for (k, &x) in corners.iter().enumerate() {
                let face = mesh.faces()[map.corner_faces[f][k] as usize];
                let weights = map.corner_weights[f][k];
                let there: Vec3 = face.iter().zip(weights).map(|(&v, w)| point(v) * w).sum();
                assert!(there.distance(result.mesh.positions()[x as usize].into()) < 0.05);
            }
        }
        assert_eq!((map.output_vertices.len(), map.input_vertices.len()), (mesh.positions().len(), 700));
        for (x, &v) in (0u32..).zip(&map.input_vertices) {
            assert_eq!(map.output_vertices[v as usize], x);
        }
    }
    let whole = simplify_with_attributes(
        &mesh,
        &attributes,
        &Options::with_closed(Size::Ratio(1.0), ClosedOptions { map: true, ..ClosedOptions::default() }),
    );
    assert_eq!(whole.map.unwrap().output_vertices, (0..mesh.positions().len() as u32).collect::<Vec<_>>());
}

#[test]
fn creases_stay_edges() {
    let mesh = shapes::cuboid([1.0, 0.6, 0.3], 24);
    let options = Options::with_closed(
        Size::Vertices(60),
        ClosedOptions { crease_angle: Some(40.0), ..ClosedOptions::default() },
    );
    let result = simplify_with_attributes(&mesh, &Attributes::default(), &options);
    let near = |x: f32, side: f32| x.abs().min((x - side).abs()) < 1e-4;
    let corner = |p: &[f32; 3]| p.iter().zip([1.0, 0.6, 0.3]).all(|(x, side)| near(*x, side));
    assert_eq!(result.mesh.positions().iter().filter(|p| corner(p)).count(), 8);
    let sharp = neural_mesh::mesh::creases(&result.mesh, 40.0);
    let length = |[a, b]: [u32; 2]| {
        let [a, b] = [a, b].map(|v| Vec3::from(result.mesh.positions()[v as usize]));
        a.distance(b)
    };
    let whole: f32 = sharp.into_iter().map(length).sum();
    assert!((whole - 4.0 * 1.9).abs() < 0.01, "{whole}");
}

#[test]
fn attributes_of_another_mesh_are_refused() {
    let mesh = shapes::icosphere(1);
    let attributes = Attributes { groups: vec![1], ..Attributes::default() };
    let input = with_changes(Input::bare(&mesh), |input| input.attributes = &attributes);
    let result = simplify(input, &Options::new(Size::Vertices(9)), &mut |_| ControlFlow::Continue(()));
    assert!(result.is_err_and(|error| error.to_string().contains("attributes")));
}

// Builds a square of n x n quads with these heights.
fn terrain(n: u32, height: impl Fn(f32, f32) -> f32) -> TriMesh {
    let flat = shapes::grid(n, n);
    let positions = flat.positions().iter().map(|&[x, y, _]| [x, y, height(x, y)]).collect();
    TriMesh::new(positions, flat.faces().to_vec()).unwrap()
}

fn at_vertices(mesh: &TriMesh, role: Role, width: usize, value: impl Fn(Vec3) -> Vec<f32>) -> Attributes {
    let values = mesh.positions().iter().flat_map(|&p| value(p.into())).collect();
    let channels = vec![Channel { name: "values".into(), role, width, values }];
    Attributes { wedges: mesh.faces().to_vec(), channels, groups: Vec::new() }
}

// Returns the root mean square error of the first number, interpolated over the faces of a result.
fn error(result: &TriMesh, numbers: impl Fn(usize) -> [f32; 3], meant: impl Fn(Vec3) -> f32) -> f32 {
    let (mut sum, mut n) = (0.0, 0.0);
    for (f, face) in result.faces().iter().enumerate() {
        let [a, b, c] = face.map(|v| Vec3::from(result.positions()[v as usize]));
        let area = (b - a).cross(c - a).length();
        for i in 0..6 {
            for j in 0..6 - i {
                let weights = [i, j, 5 - i - j].map(|x| (x as f32 + 1.0 / 3.0) / 6.0);
                let place = a * weights[0] + b * weights[1] + c * weights[2];
                let blended: f32 = numbers(f).iter().zip(weights).map(|(x, w)| x * w).sum();
                sum += area * (blended - meant(place)).powi(2);
                n += area;
            }
        }
    }
    (sum / n).sqrt()
}

fn at_corners(attributes: &Attributes, f: usize) -> [f32; 3] {
    attributes.wedges[f].map(|wedge| attributes.channels[0].value(wedge)[0])
}

fn rough(x: f32, y: f32) -> f32 {
    (1..8)
        .map(|k| (k as f32 * (9.0 * x + 5.0 * y)).sin() * (k as f32 * (4.0 * y - 7.0 * x) + 2.0).cos() / k as f32)
        .sum::<f32>()
        * 0.04
}

#[test]
fn the_boundary_of_a_rough_terrain_stays_straight() {
    let mesh = terrain(80, rough);
    for ratio in [0.3, 0.1] {
        let result = simplify_with_attributes(&mesh, &Attributes::default(), &Options::new(Size::Ratio(ratio)));
        let boundary = edges(&result.mesh).into_iter().filter(|edge| edge.n_faces() == 1).flat_map(|edge| edge.ends);
        let off = |v: u32| {
            let [x, y, _] = result.mesh.positions()[v as usize];
            [x, 1.0 - x, y, 1.0 - y].into_iter().map(f32::abs).fold(f32::INFINITY, f32::min)
        };
        let worst = boundary.map(off).fold(0.0, f32::max);
        assert!(worst < 2e-3, "{ratio} {worst}");
    }
}

#[test]
fn values_are_fitted_over_the_faces() {
    let mesh = terrain(60, |x, y| 0.3 * (5.0 * x).sin() * (4.0 * y).cos());
    let meant = |p: Vec3| 0.5 + 0.4 * (11.0 * p.x + 3.0 * p.y).sin();
    for (role, width) in [(Role::Colour, 3), (Role::Uv, 2)] {
        let attributes = at_vertices(&mesh, role, width, |p| vec![meant(p); width]);
        let options =
            Options::with_closed(Size::Vertices(150), ClosedOptions { map: true, ..ClosedOptions::default() });
        let result = simplify_with_attributes(&mesh, &attributes, &options);
        let map = result.map.unwrap();
        let nearest = |f: usize| {
            let blend_corner = |k: usize| {
                let values = at_corners(&attributes, map.corner_faces[f][k] as usize);
                values.iter().zip(map.corner_weights[f][k]).map(|(x, w)| x * w).sum()
            };
            [blend_corner(0), blend_corner(1), blend_corner(2)]
        };
        let fitted = error(&result.mesh, |f| at_corners(&result.attributes, f), meant);
        let nearest = error(&result.mesh, nearest, meant);
        assert!(fitted < 0.85 * nearest, "{role:?} {fitted} {nearest}");
    }
}

#[test]
fn values_of_vertices_that_stay_are_those_of_the_input() {
    let mesh = terrain(40, rough);
    let meant = |p: Vec3| 0.5 + 0.4 * (11.0 * p.x + 3.0 * p.y).sin();
    let attributes = at_vertices(&mesh, Role::Colour, 3, |p| vec![meant(p); 3]);
    let subset = ClosedOptions { subset: true, ..ClosedOptions::default() };
    let locked = ClosedOptions { lock_boundaries: true, ..ClosedOptions::default() };
    for (options, is_locked) in [(subset, false), (locked, true)] {
        let result = simplify_with_attributes(&mesh, &attributes, &Options::with_closed(Size::Ratio(0.2), options));
        let is_inner = |p: Vec3| is_locked && [p.x, p.y].iter().all(|x| (0.001..0.999).contains(x));
        for (face, wedges) in result.mesh.faces().iter().zip(&result.attributes.wedges) {
            for (&v, &wedge) in face.iter().zip(wedges) {
                let p = Vec3::from(result.mesh.positions()[v as usize]);
                assert!(is_inner(p) || result.attributes.channels[0].value(wedge)[0] == meant(p));
            }
        }
    }
}

#[test]
fn vertices_stay_where_colours_change() {
    let mesh = shapes::grid(60, 60);
    let meant = |p: Vec3| (4.0 * ((p.x - 0.5).powi(2) + (p.y - 0.5).powi(2)).sqrt() - 0.6).clamp(0.0, 1.0);
    let attributes = at_vertices(&mesh, Role::Colour, 3, |p| vec![meant(p); 3]);
    let result = simplify_with_attributes(&mesh, &attributes, &Options::new(Size::Vertices(80)));
    let error = error(&result.mesh, |f| at_corners(&result.attributes, f), meant);
    assert!(error < 0.03, "{error}");
}

#[test]
fn small_charts_do_not_hold_what_is_around_them() {
    // 674 charts of 30 faces each meet by threes at twice as many corners, more than the target's vertices.
    let mesh = shapes::icosphere(5);
    let cell = |p: Vec3| p.to_array().map(|x| (x * 6.0).round() as i32);
    let centre = |face: &[u32; 3]| face.iter().map(|&v| Vec3::from(mesh.positions()[v as usize])).sum::<Vec3>() / 3.0;
    let mut cells: Vec<[i32; 3]> = mesh.faces().iter().map(|face| cell(centre(face))).collect();
    let groups = cells.clone();
    cells.sort_unstable();
    cells.dedup();
    let groups = groups.iter().map(|cell| cells.binary_search(cell).unwrap() as u32).collect();
    let attributes = Attributes { groups, ..Attributes::default() };
    let result = simplify_with_attributes(&mesh, &attributes, &Options::new(Size::Vertices(1200)));
    assert!(topology(&result.mesh).is_closed_manifold());
    let left: BTreeSet<u32> = result.attributes.groups.iter().copied().collect();
    assert_eq!((result.report.outcome, left.len()), (Outcome::Reached, cells.len()));
}

// Returns the root mean square of the sines between interpolated and expected normals.
fn normal_error(result: &TriMesh, normals: impl Fn(usize) -> [Vec3; 3], meant: impl Fn(Vec3) -> Vec3) -> f32 {
    let (mut sum, mut n) = (0.0, 0.0);
    for (f, face) in result.faces().iter().enumerate() {
        let corners = face.map(|v| Vec3::from(result.positions()[v as usize]));
        let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
        for weights in [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8], [0.34, 0.33, 0.33]] {
            let blend = |of: [Vec3; 3]| of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2];
            sum += area * blend(normals(f)).normalize().cross(meant(blend(corners))).length_squared();
            n += area;
        }
    }
    (sum / n).sqrt()
}

fn normals_at_corners(attributes: &Attributes, f: usize) -> [Vec3; 3] {
    attributes.wedges[f].map(|wedge| Vec3::from_slice(attributes.channels[0].value(wedge)))
}

#[test]
fn normals_are_fitted_over_the_faces() {
    let mesh = terrain(60, |x, y| 0.1 * (9.0 * x).sin() * (8.0 * y).cos());
    let meant = |p: Vec3| {
        let slope = [0.9 * (9.0 * p.x).cos() * (8.0 * p.y).cos(), -0.8 * (9.0 * p.x).sin() * (8.0 * p.y).sin()];
        Vec3::new(-slope[0], -slope[1], 1.0).normalize()
    };
    let attributes = at_vertices(&mesh, Role::Normal, 3, |p| meant(p).to_array().to_vec());
    let options = Options::with_closed(Size::Vertices(150), ClosedOptions { map: true, ..ClosedOptions::default() });
    let result = simplify_with_attributes(&mesh, &attributes, &options);
    let map = result.map.unwrap();
    let nearest = |f: usize| {
        [0, 1, 2].map(|k| {
            let values = normals_at_corners(&attributes, map.corner_faces[f][k] as usize);
            let weights = map.corner_weights[f][k];
            (values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]).normalize()
        })
    };
    let fitted = normal_error(&result.mesh, |f| normals_at_corners(&result.attributes, f), meant);
    let nearest = normal_error(&result.mesh, nearest, meant);
    assert!(fitted < 0.95 * nearest, "{fitted} {nearest}");
}

#[test]
fn shading_does_not_jump_where_only_texture_or_material_does() {
    let (mesh, mut attributes) = charted_sphere();
    let normals = vertex_normals(&mesh);
    let values = mesh.faces().iter().flatten().flat_map(|&v| normals[v as usize]).collect();
    attributes.channels.insert(0, Channel { name: "normal".into(), role: Role::Normal, width: 3, values });
    let groups = std::mem::take(&mut attributes.groups);
    for (with_groups, n) in [(false, 150), (true, 800), (false, 2000)] {
        attributes.groups = if with_groups { groups.clone() } else { Vec::new() };
        let result = simplify_with_attributes(&mesh, &attributes, &Options::new(Size::Vertices(n)));
        assert!(topology(&result.mesh).is_closed_manifold());
        let mut of_vertices = vec![None; result.mesh.positions().len()];
        for (f, face) in result.mesh.faces().iter().enumerate() {
            for (&v, normal) in face.iter().zip(normals_at_corners(&result.attributes, f)) {
                assert!((normal.length() - 1.0).abs() < 1e-5);
                assert_eq!(*of_vertices[v as usize].get_or_insert(normal), normal);
            }
        }
    }
}

// Winds a cap of the mesh inward; its normals follow, or still point outward.
fn with_inward_cap(mesh: &TriMesh, follow: bool) -> (TriMesh, Attributes) {
    let normals = vertex_normals(mesh);
    let is_inward = |face: &[u32; 3]| face.iter().all(|&v| mesh.positions()[v as usize][2] > 0.5);
    assert!(mesh.faces().iter().any(is_inward));
    let wind = |face: &[u32; 3]| if is_inward(face) { [face[0], face[2], face[1]] } else { *face };
    let faces: Vec<[u32; 3]> = mesh.faces().iter().map(wind).collect();
    let sign = |face: &[u32; 3]| if follow && is_inward(face) { -1.0 } else { 1.0 };
    let values = faces.iter().flat_map(|face| face.map(|v| normals[v as usize].map(|x| sign(face) * x)));
    let values = values.flatten().collect();
    let wedges = (0..faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let channels = vec![Channel { name: "normal".into(), role: Role::Normal, width: 3, values }];
    let mesh = TriMesh::new(mesh.positions().to_vec(), faces).unwrap();
    (mesh, Attributes { wedges, channels, groups: Vec::new() })
}

#[test]
fn normals_follow_faces_that_were_wound_the_other_way() {
    let (alone, strip) = (shapes::wavy_sphere(4, 5.0), shapes::moebius_strip(40, 4));
    // A one-sided component far away, whose faces cannot all be wound alike, changes nothing.
    let both = shapes::unite([&alone, &shapes::place(&strip, |[x, y, z]| [x + 9.0, y, z])]);
    for (mesh, follow) in [(&alone, true), (&alone, false), (&both, true)] {
        let (mesh, attributes) = with_inward_cap(mesh, follow);
        let result = simplify_with_attributes(&mesh, &attributes, &Options::new(Size::Vertices(300)));
        let triangle = |face: &[u32; 3]| face.map(|v| Vec3::from(result.mesh.positions()[v as usize]));
        let of_sphere = result.mesh.faces().iter().map(triangle).enumerate().filter(|(_, corners)| corners[0].x < 5.0);
        for (f, [a, b, c]) in of_sphere {
            let normal: Vec3 = normals_at_corners(&result.attributes, f).into_iter().sum();
            assert!(normal.dot((b - a).cross(c - a)) > 0.0 && normal.dot(a) > 0.0, "{follow} {f}");
        }
    }
}

#[test]
fn vertices_stay_where_normals_change() {
    let mesh = shapes::grid(60, 60);
    // A flat sheet is shaded as if it bent in the middle.
    let meant = |p: Vec3| Vec3::new(0.8 * (1.0 - 4.0 * (p - 0.5).truncate().length()).max(0.0), 0.0, 1.0).normalize();
    let attributes = at_vertices(&mesh, Role::Normal, 3, |p| meant(p).to_array().to_vec());
    let result = simplify_with_attributes(&mesh, &attributes, &Options::new(Size::Vertices(80)));
    let error = normal_error(&result.mesh, |f| normals_at_corners(&result.attributes, f), meant);
    assert!(error < 0.03, "{error}");
}
