//! Attributes, groups and materials survive reading and writing, where the format has them.

use crate::common::with_changes;
use std::path::Path;

use neural_mesh::io::{
    self, Column, ColumnLayout, Extra, Format, Group, Model, ReadMesh, Scalar, WriteOptions, WrittenModel,
    read_attributed, read_attributed_path, write_attributed,
};
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::mesh::{Attributes, Channel, RawMesh, Role};
use proptest::prelude::*;

#[derive(Debug)]
struct Opened {
    cleaned: Cleaned,
    extra: Extra,
    notes: Vec<String>,
}

fn clean_read(read: ReadMesh, weld: bool) -> Opened {
    let cleaned = clean(read.mesh, &with_changes(CleanOptions::default(), |options| options.weld = weld)).unwrap();
    Opened { cleaned, extra: read.extra, notes: read.notes }
}

fn from_text(text: &str) -> Opened {
    clean_read(read_attributed(text.as_bytes(), None).unwrap(), true)
}

fn write_model(opened: &Opened, format: Format) -> WrittenModel {
    write_with_access(opened, format, false)
}

fn write_with_access(opened: &Opened, format: Format, allow_outside: bool) -> WrittenModel {
    let Opened { cleaned, extra, .. } = opened;
    let model = Model::new(&cleaned.mesh, cleaned.frame, &cleaned.attributes, extra);
    let options = with_changes(WriteOptions::new(format, "out"), |options| options.allow_outside = allow_outside);
    write_attributed(&model, &options).unwrap()
}

fn text(written: &WrittenModel) -> String {
    String::from_utf8(written.bytes.clone()).unwrap()
}

fn corners(cleaned: &Cleaned, roles: &[Role]) -> Vec<String> {
    let Cleaned { mesh, attributes, .. } = cleaned;
    let corner = |face: usize, corner: usize| {
        let position = mesh.positions()[mesh.faces()[face][corner] as usize];
        let channels = attributes.channels.iter().filter(|channel| roles.contains(&channel.role));
        let values: Vec<_> = channels.map(|channel| channel.value(attributes.wedges[face][corner])).collect();
        format!("{position:?} {values:?} {}", attributes.group(face as u32))
    };
    (0..mesh.faces().len()).map(|face| [0, 1, 2].map(|i| corner(face, i)).join(" | ")).collect()
}

fn any_finite() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits).prop_filter("not finite", |x| x.is_finite())
}

type Columns = (Role, &'static [(&'static str, Scalar)]);

// Generates meshes whose corners carry these channels, with groups numbered in the order of faces.
fn any_model(channels: &'static [Columns]) -> impl Strategy<Value = Opened> {
    let positions = prop::collection::vec(prop::array::uniform3(any_finite().prop_map(f64::from)), 4..12);
    let faces =
        prop::collection::vec((prop::array::uniform3(0u32..12), prop::array::uniform3(0u32..20), 0u32..3), 1..25);
    let values = prop::collection::vec((any_finite(), 0u8..=255), 20 * 12);
    (positions, faces, values).prop_map(move |(positions, mut faces, values)| {
        faces.push(([0, 1, 2], [0, 1, 2], 0));
        faces.sort_by_key(|face| face.2);
        let mut next = values.iter().copied();
        let channel = |(i, &(role, columns)): (usize, &Columns)| {
            let mut value = |scalar: Scalar| {
                let (any, byte) = next.next().unwrap();
                match (role, scalar) {
                    (Role::Colour, Scalar::U8) => (f64::from(byte) / 255.0) as f32,
                    (_, Scalar::U8) => f32::from(byte),
                    _ => any,
                }
            };
            let values = (0..20).flat_map(|_| columns.iter().map(|c| value(c.1)).collect::<Vec<_>>()).collect();
            Channel { name: format!("channel {i}"), role, width: columns.len(), values }
        };
        let found: Vec<Channel> = channels.iter().enumerate().map(channel).collect();
        let layout = |(channel, columns): (&Channel, &Columns)| ColumnLayout {
            channel: channel.name.clone(),
            columns: columns.1.iter().map(|&(name, scalar)| Column { name: name.into(), scalar }).collect(),
            per_corner: columns.1[0].0 == "texcoord",
        };
        let layouts = found.iter().zip(channels).map(layout).collect();
        let attributes = Attributes {
            wedges: faces.iter().map(|face| face.1).collect(),
            channels: found,
            groups: faces.iter().map(|face| face.2).collect(),
        };
        let faces = faces.iter().map(|face| face.0).collect();
        let raw = with_changes(RawMesh::new(positions, faces), |raw| raw.attributes = attributes);
        let mut cleaned = clean(raw, &CleanOptions::default()).unwrap();
        // Groups are numbered in order of first use, as a reader does.
        let mut used = cleaned.attributes.groups.clone();
        used.dedup();
        let number = |group: &u32| used.iter().position(|other| other == group).unwrap() as u32;
        cleaned.attributes.groups = cleaned.attributes.groups.iter().map(number).collect();
        let group = |i: u32| {
            with_changes(Group::default(), |group| {
                group.name = Some(format!("group {i}"));
                group.material = Some(format!("paint{}", i / 2));
                group.values = vec![f64::from(i) - 1.0];
            })
        };
        let groups = (0..used.len() as u32).map(group).collect();
        let extra = with_changes(Extra::default(), |extra| {
            extra.groups = groups;
            extra.layouts = layouts;
        });
        Opened { cleaned, extra, notes: Vec::new() }
    })
}

const FOR_OBJ: &[Columns] = &[
    (Role::Uv, &[("s", Scalar::F32), ("t", Scalar::F32)]),
    (Role::Normal, &[("nx", Scalar::F32), ("ny", Scalar::F32), ("nz", Scalar::F32)]),
];

const FOR_PLY: &[Columns] = &[
    (Role::Colour, &[("red", Scalar::U8), ("green", Scalar::U8), ("blue", Scalar::U8), ("alpha", Scalar::U8)]),
    (Role::Normal, &[("nx", Scalar::F32), ("ny", Scalar::F32), ("nz", Scalar::F32)]),
    (Role::Uv, &[("u", Scalar::F32), ("v", Scalar::F32)]),
    (Role::Other, &[("quality", Scalar::F64)]),
    (Role::Label, &[("label", Scalar::U8)]),
];

const WITH_CORNERS: &[Columns] =
    &[(Role::Label, &[("label", Scalar::U8)]), (Role::Uv, &[("texcoord", Scalar::F32), ("texcoord", Scalar::F32)])];

proptest! {
    #[test]
    fn obj_gives_corners_and_groups_back(model in any_model(FOR_OBJ)) {
        let written = write_model(&model, Format::Obj);
        prop_assert!(written.notes.is_empty(), "{:?}", written.notes);
        let back = clean_read(read_attributed(&written.bytes, None).unwrap(), true);
        let roles = [Role::Uv, Role::Normal];
        prop_assert_eq!(corners(&back.cleaned, &roles), corners(&model.cleaned, &roles));
        for (found, group) in back.extra.groups.iter().zip(&model.extra.groups) {
            prop_assert_eq!((&found.name, &found.material), (&group.name, &group.material));
        }
    }

    #[test]
    fn ply_gives_corners_back(model in any_model(FOR_PLY), format in prop::sample::select(vec![Format::Ply, Format::PlyAscii])) {
        let mut model = model;
        model.cleaned.attributes.groups.clear();
        model.extra.groups.clear();
        let back = clean_read(read_attributed(&write_model(&model, format).bytes, None).unwrap(), true);
        let roles = [Role::Colour, Role::Normal, Role::Uv, Role::Other, Role::Label];
        prop_assert_eq!(corners(&back.cleaned, &roles), corners(&model.cleaned, &roles));
        prop_assert_eq!(&back.cleaned.mesh, &model.cleaned.mesh);
        for (found, layout) in back.extra.layouts.iter().zip(&model.extra.layouts) {
            prop_assert_eq!(&found.columns, &layout.columns);
        }
    }

    #[test]
    fn ply_gives_lists_of_corners_and_numbers_of_faces_back(
        model in any_model(WITH_CORNERS),
        format in prop::sample::select(vec![Format::Ply, Format::PlyAscii]),
    ) {
        let mut model = model;
        model.extra.face_columns = vec![Column { name: "region".into(), scalar: Scalar::I8 }];
        model.extra.groups.iter_mut().for_each(|group| *group = with_changes(Group::default(), |bare| bare.values = group.values.clone()));
        let back = clean_read(read_attributed(&write_model(&model, format).bytes, None).unwrap(), true);
        let roles = [Role::Label, Role::Uv];
        prop_assert_eq!(corners(&back.cleaned, &roles), corners(&model.cleaned, &roles));
        prop_assert_eq!(&back.extra.groups, &model.extra.groups);
        prop_assert_eq!(&back.extra.face_columns, &model.extra.face_columns);
    }

    #[test]
    fn ply_of_any_layout_and_encoding(
        encoding in prop::sample::select(vec!["ascii", "binary_little_endian", "binary_big_endian"]),
        order in Just(vec!["x", "y", "z", "red", "green", "blue", "heat", "tags"]).prop_shuffle(),
        label in prop::sample::select(vec!["char", "uchar", "short", "ushort", "int", "uint"]),
        with_uvs in any::<bool>(),
    ) {
        let bytes = odd_ply(encoding, &order, label, with_uvs);
        let read = read_attributed(&bytes, None).unwrap();
        prop_assert!(read.notes.contains(&"the list tags of the vertices is dropped".to_string()));
        prop_assert_eq!(&read.mesh.faces, &[[0, 1, 2], [0, 2, 3], [3, 2, 1]]);
        prop_assert_eq!(&read.mesh.attributes.groups, &[0, 0, 1]);
        prop_assert_eq!(&read.extra.groups[1].values, &[4.0]);
        let channel = |name: &str| read.mesh.attributes.channels.iter().find(|c| c.name == name).unwrap();
        let corner = read.mesh.attributes.wedges[2][0];
        prop_assert_eq!(channel("colour").value(corner), [1.0, 0.2, 0.0]);
        prop_assert_eq!(channel("heat").value(corner), [3.5]);
        if with_uvs {
            prop_assert_eq!(channel("uv").value(read.mesh.attributes.wedges[1][2]), [3.0, 0.5]);
            prop_assert_eq!(channel("uv").value(corner), [10.0, 0.5]);
        }
        prop_assert!(read.mesh.attributes.is_valid_for(3));
    }

    #[test]
    fn any_bytes_give_attributes_that_fit_or_one_line(bytes in prop::collection::vec(any::<u8>(), 0..200), start in 0usize..5) {
        let starts: [&[u8]; 5] = [
            b"", b"v 1 2 3 1 1 1\nvt 1 2\nvn 1\nv 1 2 3\nf 1/1 2/-1 -1//1\nusemtl ", b"v 0 0 0\nf 1 1 1\ng a\nf 1/1 2 ",
            b"ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty char x\nproperty char y\nproperty char z\nproperty char q\n\
            element face 9\nproperty list uchar uchar vertex_index\nproperty list uchar uchar texcoord\nproperty char n\nend_header\n",
            b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 ",
        ];
        let bytes = [starts[start], &bytes].concat();
        match read_attributed(&bytes, None) {
            Ok(read) => {
                prop_assert!(read.notes.iter().all(|note| !note.contains(['\n', '\r'])), "{:?}", read.notes);
                prop_assert_eq!(read.mesh.attributes.wedges.is_empty(), read.mesh.attributes.channels.is_empty() || read.mesh.faces.is_empty());
                let bare = io::read(&bytes, None).unwrap();
                prop_assert_eq!(&bare.faces, &read.mesh.faces);
                // NaN differs from itself, so positions are compared as text.
                prop_assert_eq!(format!("{:?}", bare.positions), format!("{:?}", read.mesh.positions));
                if let Ok(cleaned) = clean(read.mesh, &CleanOptions::default()) {
                    let model = Opened { cleaned, extra: read.extra, notes: Vec::new() };
                    for format in [Format::Obj, Format::Ply, Format::PlyAscii] {
                        let written = write_model(&model, format);
                        let back = clean_read(read_attributed(&written.bytes, None).unwrap(), true);
                        prop_assert_eq!(back.cleaned.mesh.faces().len(), model.cleaned.mesh.faces().len());
                    }
                }
            }
            Err(error) => prop_assert!(!error.to_string().contains(['\n', '\r']), "{}", error),
        }
    }
}

// Builds a PLY of a quad and a triangle, with vertex columns in this order.
fn odd_ply(encoding: &str, order: &[&str], label: &str, with_uvs: bool) -> Vec<u8> {
    let mut out = format!("ply\nformat {encoding} 1.0\ncomment made by hand\nelement vertex 4\n").into_bytes();
    let kind = |name: &str| match name {
        "x" | "y" | "z" | "heat" => "float",
        _ => "uchar",
    };
    for name in order {
        let list = if *name == "tags" { "list uchar " } else { "" };
        out.extend(format!("property {list}{} {name}\n", kind(name)).bytes());
    }
    out.extend(b"element face 2\nproperty list uchar int vertex_indices\n");
    out.extend(format!("property {label} part\n").bytes());
    if with_uvs {
        out.extend(b"property list uchar double texcoord\n");
    }
    out.extend(b"end_header\n");
    let mut put = |kind: &str, value: f64| {
        let bytes = match kind {
            _ if encoding == "ascii" => return out.extend(format!("{value}\n").bytes()),
            "double" => value.to_le_bytes().to_vec(),
            "float" => (value as f32).to_le_bytes().to_vec(),
            "int" | "uint" => (value as i32).to_le_bytes().to_vec(),
            "short" | "ushort" => (value as i16).to_le_bytes().to_vec(),
            _ => vec![value as u8],
        };
        out.extend(if encoding == "binary_big_endian" { bytes.into_iter().rev().collect() } else { bytes });
    };
    for (i, position) in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].iter().enumerate() {
        for name in order {
            match *name {
                "x" => put("float", position[0]),
                "y" => put("float", position[1]),
                "z" => put("float", position[2]),
                "red" => put("uchar", 255.0),
                "green" => put("uchar", 51.0),
                "blue" => put("uchar", 0.0),
                "heat" => put("float", 0.5 + i as f64),
                _ => {
                    put("uchar", i as f64);
                    (0..i).for_each(|_| put("uchar", 9.0));
                }
            }
        }
    }
    for (corners, part) in [(&[0, 1, 2, 3][..], 3.0), (&[3, 2, 1], 4.0)] {
        put("uchar", corners.len() as f64);
        corners.iter().for_each(|&vertex| put("int", f64::from(vertex)));
        put(label, part);
        if with_uvs {
            put("uchar", 2.0 * corners.len() as f64);
            for i in 0..corners.len() {
                put("double", i as f64 + if part > 3.0 { 10.0 } else { 0.0 });
                put("double", 0.5);
            }
        }
    }
    out
}

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n";

#[test]
fn a_seam_makes_no_vertices() {
    let model = from_text(&format!("{QUAD}f 1/1 2/2 3/3 4/4\nf 2/5 5/1 3/3\n"));
    assert_eq!((model.cleaned.mesh.positions().len(), model.cleaned.attributes.n_wedges()), (5, 6));
    let ply = write_model(&model, Format::PlyAscii);
    assert_eq!(ply.notes, ["ply stores one set of values per vertex: 1 vertices are duplicated at seams"]);
    let back = clean_read(read_attributed(&ply.bytes, None).unwrap(), true);
    assert_eq!(back.cleaned.counts.welded_vertices, 1);
    assert_eq!(corners(&back.cleaned, &[Role::Uv]), corners(&model.cleaned, &[Role::Uv]));
}

#[test]
fn colours_come_back_in_the_kind_that_they_were() {
    let head = "ply\nformat ascii 1.0\nobj_info scanned\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let rest = "property float quality\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    for (kind, colour) in [("uchar", "255 7 0"), ("ushort", "65535 7 0"), ("float", "0.25 1 0.001")] {
        let columns: String = ["red", "green", "blue"].map(|name| format!("property {kind} {name}\n")).concat();
        let text = format!("{head}{columns}{rest}0 0 0 {colour} 0.5\n1 0 0 {colour} 2\n0 1 0 {colour} -3\n3 0 1 2\n");
        let model = from_text(&text);
        assert_eq!(self::text(&write_model(&model, Format::PlyAscii)), text);
        let obj = write_model(&model, Format::Obj);
        assert_eq!(obj.notes, ["obj cannot store quality: dropped"]);
        let back = from_text(&self::text(&obj));
        assert_eq!(corners(&back.cleaned, &[Role::Colour]), corners(&model.cleaned, &[Role::Colour]));
        let stl = write_model(&model, Format::Stl);
        assert_eq!(stl.notes, ["stl stores only geometry: colour, quality dropped"]);
    }
}

#[test]
fn groups_come_back_in_their_order() {
    let text = format!(
        "mtllib a.mtl\n{QUAD}f 1 2 3\no chair\ng back top\nusemtl wood\ns 1\nf 1/1 3/3 4/4\nusemtl cloth\ns off\nf 2/2 5/1 3/3\n"
    );
    let model = from_text(&text);
    let names: Vec<_> = model.extra.groups.iter().map(|group| group.material.as_deref()).collect();
    assert_eq!(names, [None, Some("wood"), Some("cloth")]);
    let out = self::text(&write_model(&model, Format::Obj));
    let words: Vec<&str> = out.lines().filter(|line| !line.starts_with(['v', 'f'])).collect();
    assert_eq!(words, ["mtllib a.mtl", "o chair", "g back top", "usemtl wood", "s 1", "usemtl cloth", "s off"]);
    assert_eq!(from_text(&out).extra.groups, model.extra.groups);
}

#[test]
fn odd_texts() {
    // Relative numbers, continued and CRLF lines, corners without values, a quad with such corners, a material without a
    // library.
    let cases = [
        format!("{QUAD}usemtl x\nf -5/-5 -4/-4 -3/-3 -2/-2\n"),
        format!("{QUAD}usemtl x\nf 1/1 2/2 \\\n 3/3 4/4\n"),
        format!("{QUAD}usemtl x\nf 1/1/9 2/2/ 3/3/-7 4/4//\n"),
        format!("{QUAD}usemtl x\nf 1/1 2/2 3/3 4/4\n").replace('\n', "\r\n"),
    ];
    let expected = from_text(&cases[0]);
    assert_eq!(expected.cleaned.attributes.channels.len(), 1);
    for case in &cases {
        let found = from_text(case);
        assert_eq!(corners(&found.cleaned, &[Role::Uv]), corners(&expected.cleaned, &[Role::Uv]), "{case}");
        assert_eq!(found.extra.groups, [with_changes(Group::default(), |group| group.material = Some("x".into()))]);
    }
    let lacking = from_text(&format!("{QUAD}f 1 2/99 3/-99 4/2\nvt 7 7\n"));
    let uv = &lacking.cleaned.attributes.channels[0];
    assert_eq!(uv.value(lacking.cleaned.attributes.wedges[0][1]), [0.0, 0.0]);
    let nan = from_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt nan 1 0.5\nl 1 2\np 1\nf 1/1 2/1 3/1\n");
    assert_eq!(nan.cleaned.attributes.channels[0].value(0), [0.0, 1.0]);
    assert_eq!(nan.notes.len(), 4, "{:?}", nan.notes);
}

#[test]
fn bare_files_carry_nothing() {
    for text in ["v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1 2 3\n", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"]
    {
        let read = read_attributed(text.as_bytes(), None).unwrap();
        assert_eq!((&read.mesh.attributes, &read.extra), (&Attributes::default(), &Extra::default()));
        assert_eq!(read.mesh, io::read(text.as_bytes(), None).unwrap());
    }
}

fn asset(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

fn open_path(path: &Path) -> Opened {
    clean_read(read_attributed_path(path, None).unwrap(), true)
}

fn places(written: &WrittenModel) -> Vec<&str> {
    written.companion_files.iter().filter_map(|file| file.path.to_str()).collect()
}

#[test]
fn libraries_and_textures_lie_beside_the_output_as_they_lay_beside_the_input() {
    let mtl = "# by hand\r\nnewmtl x\r\nKd 1 1 1\r\nmap_Kd -s 1 1 1 ../textures/my skin.png\r\nbump ..\\textures\\bump.png\r\nmap_Ks none.png\r\n";
    let mesh = format!("mtllib sub/a b.mtl\n{QUAD}usemtl x\nf 1/1 2/2 3/3\n");
    let folder = asset(&[
        ("in/mesh.obj", &mesh),
        ("in/sub/a b.mtl", mtl),
        ("in/textures/my skin.png", "skin"),
        ("in/textures/bump.png", "bump"),
    ]);
    let model = open_path(&folder.path().join("in/mesh.obj"));
    let written = write_model(&model, Format::Obj);
    assert_eq!(places(&written), ["textures/my skin.png", "textures/bump.png", "sub/a b.mtl"]);
    assert_eq!(written.notes, ["\"none.png\" is missing: it is not copied, but the OBJ refers to it"]);
    assert_eq!(written.companion_files[2].bytes, mtl.as_bytes());
    assert!(text(&written).starts_with("mtllib sub/a b.mtl\n"));
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    for force in [false, false, true] {
        io::write_files(&out, &written.companion_files, force).unwrap();
    }
    assert_eq!(std::fs::read(out.join("textures/my skin.png")).unwrap(), b"skin");
}

#[test]
fn what_lies_outside_is_read_only_where_that_is_allowed() {
    let folder = asset(&[("secret.png", "secret"), ("out.mtl", "newmtl y\nmap_Kd secret.png\n"), ("in/mesh.obj", "")]);
    let absolute = folder.path().join("secret.png");
    let mtl = format!("newmtl x\nmap_Kd ../secret.png\nmap_Ks {}\n", absolute.display());
    std::fs::write(folder.path().join("in/a.mtl"), &mtl).unwrap();
    let mesh = format!("mtllib a.mtl\nmtllib ../out.mtl\n{QUAD}usemtl x\nf 1/1 2/2 3/3\n");
    std::fs::write(folder.path().join("in/mesh.obj"), mesh).unwrap();
    let model = open_path(&folder.path().join("in/mesh.obj"));

    let closed = write_model(&model, Format::Obj);
    assert_eq!((places(&closed), &closed.companion_files[0].bytes[..]), (vec!["a.mtl"], mtl.as_bytes()));
    assert_eq!(closed.notes.iter().filter(|note| note.contains("is outside the folder")).count(), 3);
    assert!(text(&closed).starts_with("mtllib a.mtl\nmtllib ../out.mtl\n"));

    let open = write_with_access(&model, Format::Obj, true);
    assert_eq!(places(&open), ["secret.png", "a.mtl", "out.mtl"]);
    assert_eq!(open.companion_files[1].bytes, b"newmtl x\nmap_Kd secret.png\nmap_Ks secret.png\n");
    assert!(open.notes.is_empty(), "{:?}", open.notes);
    assert!(text(&open).starts_with("mtllib a.mtl\nmtllib out.mtl\n"));
}

#[cfg(unix)]
#[test]
fn links_lead_nowhere_else() {
    let folder = asset(&[("secret.png", "secret"), ("in/a.mtl", "newmtl x\nmap_Kd link.png\n")]);
    std::os::unix::fs::symlink(folder.path().join("secret.png"), folder.path().join("in/link.png")).unwrap();
    std::fs::write(folder.path().join("in/mesh.obj"), format!("mtllib a.mtl\n{QUAD}f 1 2 3\n")).unwrap();
    let model = open_path(&folder.path().join("in/mesh.obj"));
    assert_eq!(places(&write_model(&model, Format::Obj)), ["a.mtl"]);
    assert_eq!(places(&write_with_access(&model, Format::Obj, true)), ["link.png", "a.mtl"]);
}

#[test]
fn a_mesh_without_its_folder_says_what_is_not_copied() {
    let model = from_text(&format!("mtllib a.mtl\n{QUAD}usemtl x\nf 1/1 2/2 3/3\n"));
    let written = write_model(&model, Format::Obj);
    assert!(written.companion_files.is_empty() && written.notes[0].contains("as the mesh was read without its folder"));
    assert!(text(&written).starts_with("mtllib a.mtl\n"));
}

#[test]
fn textures_go_from_obj_to_ply_and_back() {
    let mesh = format!("mtllib a.mtl\n{QUAD}usemtl x\nf 1/1 2/2 3/3\nusemtl y\nf 1/1 3/3 4/4\n");
    let folder = asset(&[
        ("mesh.obj", &mesh),
        ("a.mtl", "newmtl y\nmap_Kd y.png\nnewmtl x\nmap_Kd x.png\n"),
        ("x.png", "x"),
        ("y.png", "y"),
    ]);
    let model = open_path(&folder.path().join("mesh.obj"));
    let ply = write_model(&model, Format::PlyAscii);
    assert_eq!(places(&ply), ["y.png", "x.png"]);
    let header = text(&ply);
    assert!(header.contains("comment TextureFile x.png\ncomment TextureFile y.png\n"), "{header}");
    assert!(header.contains("property list uchar float texcoord\nproperty int texnumber\n"));
    assert!(header.contains("element vertex 4\n"), "a vertex was repeated: {header}");

    std::fs::write(folder.path().join("mesh.ply"), &ply.bytes).unwrap();
    let obj = write_model(&open_path(&folder.path().join("mesh.ply")), Format::Obj);
    assert_eq!(places(&obj), ["x.png", "y.png", "out.mtl"]);
    let library = String::from_utf8(obj.companion_files[2].bytes.clone()).unwrap();
    assert_eq!(library, "newmtl texture_0\nKd 1 1 1\nmap_Kd x.png\nnewmtl texture_1\nKd 1 1 1\nmap_Kd y.png\n");
    let back = from_text(&text(&obj));
    assert_eq!(back.extra.materials(), ["texture_0", "texture_1"]);
    assert_eq!(corners(&back.cleaned, &[Role::Uv]), corners(&model.cleaned, &[Role::Uv]));
}

#[test]
fn attributes_of_another_mesh_are_refused() {
    let mut model = from_text(&format!("{QUAD}f 1/1 2/2 3/3\n"));
    model.cleaned.attributes.wedges[0][1] = 9;
    let Opened { cleaned, extra, .. } = &model;
    let model = Model::new(&cleaned.mesh, cleaned.frame, &cleaned.attributes, extra);
    let options = WriteOptions::new(Format::Ply, "out");
    assert!(write_attributed(&model, &options).unwrap_err().to_string().contains("do not match the faces"));
}

#[test]
fn compressed_files_are_read_and_written_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let model = from_text(&format!("{QUAD}f 1/1 2/2 3/3\n"));
    for (name, format) in [("mesh.obj.gz", Format::Obj), ("mesh.PLY.GZ", Format::Ply), ("mesh.stl.gz", Format::Stl)] {
        let path = folder.path().join(name);
        io::write_path(&path, &write_model(&model, format).bytes, false).unwrap();
        assert!(std::fs::read(&path).unwrap().starts_with(b"\x1f\x8b"));
        assert_eq!(io::read_path(&path, None).unwrap().faces, [[0, 1, 2]], "{name}");
        let plain = folder.path().join(Format::without_gz(name.as_ref()));
        std::fs::copy(&path, &plain).unwrap();
        assert_eq!(open_path(&plain).cleaned.mesh, open_path(&path).cleaned.mesh, "{name}");
        assert_eq!(io::read_points(&std::fs::read(&path).unwrap()).unwrap().positions.len() % 3, 0);
    }
}

#[test]
fn what_is_not_read_of_a_file_is_said() {
    let notes = |bytes: &[u8]| read_attributed(bytes, None).unwrap().notes;
    let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2";
    assert!(notes(off.as_bytes()).is_empty());
    assert_eq!(notes(format!("{off} 255 0 0\n").as_bytes()), ["colours of off faces are dropped"]);
    let coloured = off.replace("1 0 0\n", "1 0 0 0.5 0.5 0.5 1\n").replacen("OFF", "COFF", 1);
    assert_eq!(notes(coloured.as_bytes()), ["colours, normals or texture coordinates of off vertices are dropped"]);
    let mut stl = write_model(&from_text(&format!("{QUAD}f 1 2 3\n")), Format::Stl).bytes;
    assert!(notes(&stl).is_empty());
    *stl.last_mut().unwrap() = 0x80;
    assert_eq!(notes(&stl), ["colours or other marks of 1 stl facets are dropped"]);
    let solid = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
    assert_eq!(notes(solid.repeat(2).as_bytes()), ["2 stl solids become one mesh, their names are dropped"]);
}

#[test]
fn faces_of_different_numbers_are_groups_and_too_many_are_none() {
    let n = 2000;
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
        element face {n}\nproperty list uchar int vertex_indices\nproperty int id\nproperty float area\nend_header\n",
        n + 2
    );
    (0..n + 2).for_each(|i| text += &format!("{i} {} 0\n", i % 2));
    let with_ids = |id: &dyn Fn(usize) -> usize| {
        let faces: String = (0..n).map(|i| format!("3 {i} {} {} {} 0.5\n", i + 1, i + 2, id(i))).collect();
        from_text(&format!("{text}{faces}"))
    };
    let few = with_ids(&|i| i % 7);
    assert_eq!((few.extra.groups.len(), few.cleaned.attributes.group(8)), (7, 1));
    assert_eq!(few.notes, ["the property area of the faces is dropped"]);
    let many = with_ids(&|i| i);
    assert!(many.extra.groups.is_empty() && many.cleaned.attributes.groups.is_empty());
    assert!(many.notes[1].contains("too many different values"), "{:?}", many.notes);
}

#[test]
fn groups_of_every_face_are_said_and_dropped_and_many_groups_are_kept() {
    // Strips of 8 faces, each a group with a material; or each face a group.
    let strips = |faces_a_group: usize, n_faces: usize| {
        let mut text = String::from("mtllib a.mtl\n");
        for f in 0..n_faces {
            text += &format!("v {f} 0 0\nv {f} 1 0\nv {f} 0 1\n");
            if f % faces_a_group == 0 {
                text += &format!("g g{f}\nusemtl m{f}\n");
            }
            text += "f -3 -2 -1\n";
        }
        from_text(&text)
    };
    let began = std::time::Instant::now();
    let each = strips(1, 100_000);
    assert_eq!(
        (each.extra.groups.len(), each.cleaned.attributes.groups.len(), each.notes.len()),
        (0, 0, 2),
        "{:?}",
        each.notes
    );
    let many = strips(8, 800_000);
    assert_eq!((many.extra.groups.len(), many.extra.materials().len(), many.notes.len()), (100_000, 100_000, 0));
    let obj = write_model(&many, Format::Obj);
    assert_eq!(text(&obj).matches("usemtl").count(), 100_000);
    let ply = write_model(&many, Format::Ply);
    assert!(String::from_utf8_lossy(&ply.bytes[..600]).contains("property int material_index"));
    assert_eq!(io::read_looks(&many.extra, false).0.of_groups.len(), 100_000);
    // The time is seconds if it grows linearly with the groups, minutes if quadratically.
    assert!(began.elapsed().as_secs() < 60, "{:?}", began.elapsed());
}
