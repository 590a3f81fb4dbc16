//! Mesh files through the public readers and writers: every format restores the written mesh.

use crate::common::with_changes;
use neural_mesh::io::{self, Format};
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::mesh::{Frame, RawMesh, TriMesh};
use proptest::prelude::*;

const WRITTEN: [Format; 6] = [Format::Obj, Format::Ply, Format::PlyAscii, Format::Stl, Format::StlAscii, Format::Off];

fn corners(mesh: &TriMesh) -> Vec<[[f32; 3]; 3]> {
    mesh.faces().iter().map(|face| face.map(|vertex| mesh.positions()[vertex as usize])).collect()
}

fn read_back(bytes: &[u8], format: Option<Format>) -> Cleaned {
    clean(io::read(bytes, format).unwrap(), &CleanOptions::default()).unwrap()
}

fn any_finite() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits).prop_filter("not finite", |x| x.is_finite())
}

fn any_mesh(coordinates: impl Strategy<Value = f32>) -> impl Strategy<Value = Cleaned> {
    let positions = prop::collection::vec(prop::array::uniform3(coordinates.prop_map(f64::from)), 3..20);
    let faces = prop::collection::vec(prop::array::uniform3(0u32..20), 1..30);
    (positions, faces).prop_map(|(positions, mut faces)| {
        faces.push([0, 1, 2]);
        clean(RawMesh::new(positions, faces), &options_without_welding()).unwrap()
    })
}

fn options_without_welding() -> CleanOptions {
    with_changes(CleanOptions::default(), |options| options.weld = false)
}

proptest! {
    #[test]
    fn every_format_gives_single_precision_back_exactly(cleaned in any_mesh(any_finite())) {
        for format in WRITTEN {
            let bytes = io::write(&cleaned.mesh, &cleaned.frame, format).unwrap();
            for hint in [None, Some(format)] {
                let back = io::read(&bytes, hint).unwrap();
                prop_assert!(!back.double, "{:?}", format);
                let back = clean(back, &options_without_welding()).unwrap();
                prop_assert_eq!(corners(&back.mesh), corners(&cleaned.mesh), "{:?}", format);
            }
        }
    }

    #[test]
    fn every_format_but_stl_gives_far_coordinates_back_exactly(
        mut cleaned in any_mesh(-1e6f32..1e6),
        origin in prop::array::uniform3(prop::sample::select(vec![0.0, 5e6, -4_096.0, 1e9])),
    ) {
        cleaned.frame = Frame { origin, double: true };
        let expected: Vec<_> = cleaned.mesh.positions().iter().map(|&local| cleaned.frame.to_file(local)).collect();
        for format in [Format::Obj, Format::Ply, Format::PlyAscii, Format::Off] {
            let bytes = io::write(&cleaned.mesh, &cleaned.frame, format).unwrap();
            let back = io::read(&bytes, None).unwrap();
            for (found, expected) in back.positions.iter().zip(&expected) {
                for axis in 0..3 {
                    // Without an offset, text holds the shortest digits of the single-precision value.
                    let same = found[axis] == expected[axis]
                        || origin[axis] == 0.0 && found[axis] as f32 == expected[axis] as f32;
                    prop_assert!(same, "{:?} {:?} {:?}", format, found, expected);
                }
            }
        }
    }

    #[test]
    fn ply_of_any_layout(
        cleaned in any_mesh(any_finite()),
        encoding in prop::sample::select(vec!["ascii", "binary_little_endian", "binary_big_endian"]),
        order in Just(vec!["x", "y", "z", "nx", "tags"]).prop_shuffle(),
        wide in any::<bool>(),
        length in prop::sample::select(vec!["uchar", "int", "ushort"]),
        faces_first in any::<bool>(),
    ) {
        let bytes = ply(&cleaned.mesh, encoding, &order, wide, length, faces_first);
        let raw = io::read(&bytes, None).unwrap();
        prop_assert_eq!(raw.double, wide);
        let raw = with_changes(raw, |raw| raw.double = false);
        prop_assert_eq!(corners(&clean(raw, &options_without_welding()).unwrap().mesh), corners(&cleaned.mesh));
    }

    #[test]
    fn any_bytes_give_a_mesh_or_one_line(bytes in prop::collection::vec(any::<u8>(), 0..200), start in 0usize..7) {
        let starts: [&[u8]; 7] = [
            b"", b"v 1 2 3\nf ", b"OFF 1 1 ", b"solid\nfacet vertex ", b"glTF\x02\0\0\0", b"{\"nodes\":",
            b"ply\nformat binary_big_endian 1.0\nelement vertex 9\nproperty list char double x\nend_header\n",
        ];
        let bytes = [starts[start], &bytes].concat();
        for format in [None, Some(Format::Obj), Some(Format::Ply), Some(Format::Stl), Some(Format::Off), Some(Format::Gltf)] {
            if let Err(error) = io::read(&bytes, format) {
                prop_assert!(!error.to_string().contains(['\n', '\r']), "{}", error);
            }
        }
    }
}

// Builds a PLY with vertex properties in this `order`, lists on vertices, and a value after each face.
fn ply(mesh: &TriMesh, encoding: &str, order: &[&str], wide: bool, length: &str, faces_first: bool) -> Vec<u8> {
    let put = |out: &mut Vec<u8>, kind: &str, value: f64| {
        let bytes = match kind {
            _ if encoding == "ascii" => return out.extend(format!("{value} ").bytes()),
            "double" => value.to_le_bytes().to_vec(),
            "float" => (value as f32).to_le_bytes().to_vec(),
            "int" => (value as i32).to_le_bytes().to_vec(),
            "ushort" => (value as u16).to_le_bytes().to_vec(),
            _ => vec![value as u8],
        };
        let big = encoding == "binary_big_endian";
        out.extend(if big { bytes.into_iter().rev().collect() } else { bytes });
    };
    let scalar = if wide { "double" } else { "float" };
    let mut heads = [format!("element vertex {}\n", mesh.positions().len()), String::new()];
    for name in order {
        let kind = if *name == "tags" { format!("list {length} double") } else { scalar.into() };
        heads[0] += &format!("property {kind} {name}\n");
    }
    heads[1] =
        format!("element face {}\nproperty list {length} int vertex_index\nproperty uchar flag\n", mesh.faces().len());
    let mut bodies = [Vec::new(), Vec::new()];
    for (i, position) in mesh.positions().iter().enumerate() {
        for name in order {
            match ["x", "y", "z"].iter().position(|axis| axis == name) {
                Some(axis) => put(&mut bodies[0], scalar, f64::from(position[axis])),
                None if *name == "nx" => put(&mut bodies[0], scalar, 1.0),
                None => {
                    put(&mut bodies[0], length, (i % 3) as f64);
                    (0..i % 3).for_each(|_| put(&mut bodies[0], "double", 0.5));
                }
            }
        }
    }
    for face in mesh.faces() {
        put(&mut bodies[1], length, 3.0);
        face.iter().for_each(|&vertex| put(&mut bodies[1], "int", f64::from(vertex)));
        put(&mut bodies[1], "uchar", 7.0);
    }
    if faces_first {
        heads.reverse();
        bodies.reverse();
    }
    [format!("ply\nformat {encoding} 1.0\n{}end_header\n", heads.concat()).into_bytes(), bodies.concat()].concat()
}

#[test]
fn surveyed_coordinates_keep_their_millimetres() {
    let side = 60;
    let point =
        |i: u32| [5_123_456.789 + f64::from(i % side) * 0.137, 481_234.567 + f64::from(i / side) * 0.211, 312.001];
    let positions: Vec<_> = (0..side * side).map(point).collect();
    let faces = (0..side * (side - 1) - 1).map(|i| [i, i + 1, i + side]).collect();
    let text: String =
        positions.iter().map(|[x, y, z]| format!("v {x:.3} {y:.3} {z:.3}\n")).collect::<String>() + "f 1 2 3\n";
    assert!(io::read(text.as_bytes(), None).unwrap().double);
    let raw = with_changes(RawMesh::new(positions.clone(), faces), |raw| raw.double = true);
    let Cleaned { mesh, frame, source, .. } = clean(raw, &CleanOptions::default()).unwrap();
    for format in [Format::Obj, Format::Ply, Format::PlyAscii, Format::Off] {
        let back = io::read(&io::write(&mesh, &frame, format).unwrap(), None).unwrap();
        assert!(back.double, "{format:?}");
        for (found, &source) in back.positions.iter().zip(&source) {
            let exact = positions[source as usize];
            assert!((0..3).all(|axis| (found[axis] - exact[axis]).abs() < 1e-5), "{found:?} {exact:?}");
        }
    }
}

#[test]
fn every_triangle_of_a_stl_soup_finds_its_neighbours() {
    let positions = vec![[0.1, 0.2, 0.3], [1.0, 0.0, 1e-20], [0.0, 1.0 / 3.0, 0.0], [0.0, -7e-3, 1.0]];
    let mesh = TriMesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
    let back = read_back(&io::write(&mesh, &Frame::default(), Format::Stl).unwrap(), None);
    assert_eq!((back.mesh.positions().len(), back.counts.welded_vertices), (4, 8));
}

#[test]
fn the_same_tetrahedron_in_every_format() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes/tiny");
    let read = |name: &str| clean(io::read_path(&folder.join(name), None).unwrap(), &CleanOptions::default()).unwrap();
    let expected = corners(&read("tetrahedron.ply").mesh);
    assert_eq!(expected.len(), 4);
    for name in
        ["tetrahedron.obj", "tetrahedron_ascii.ply", "tetrahedron.stl", "tetrahedron_ascii.stl", "tetrahedron.off"]
    {
        assert_eq!(corners(&read(name).mesh), expected, "{name}");
    }
    for name in ["tetrahedron.gltf", "tetrahedron_apart.gltf", "tetrahedron.glb"] {
        assert_eq!(corners(&read(name).mesh), expected, "{name}");
    }
    let far = read("tetrahedron_far.ply");
    assert_eq!(far.frame.to_file(far.mesh.positions()[1]), [5_000_001.0, -4_194_304.0, 1_024.0]);
}
