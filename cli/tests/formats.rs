//! Conversions keep what `docs/formats.md` says.

use std::path::Path;

use neural_mesh::io::{ReadMesh, read_attributed_path, read_looks};
use neural_mesh::mesh::Role;
use neural_mesh::picture::{Image, encode_png};

use crate::common::*;

fn everything(folder: &Path) {
    let picture = Image { width: 2, height: 2, rgba: [[250, 120, 10, 255]; 4].concat() };
    std::fs::write(folder.join("wood.png"), encode_png(&picture)).unwrap();
    std::fs::write(folder.join("a.mtl"), "newmtl wood\nKd 1 1 1\nmap_Kd wood.png\n").unwrap();
    const N: usize = 12;
    let mut text = String::from("mtllib a.mtl\nvn 0 0 1\n");
    let grid_point = |i: usize| [i % (N + 1), i / (N + 1)].map(|x| x as f64 / N as f64);
    for [x, y] in (0..(N + 1) * (N + 1)).map(grid_point) {
        text += &format!("v {x} {y} {} {x} {y} 0.5\nvt {x} {y}\n", 0.2 * (4.0 * x).sin() * y);
    }
    for (object, rows) in [("seat", 0..N / 2), ("back", N / 2..N)] {
        text += &format!("o {object}\nusemtl wood\n");
        for (row, column) in rows.flat_map(|row| (0..N).map(move |column| (row, column))) {
            let low = row * (N + 1) + column + 1;
            let corners = [low, low + 1, low + N + 2, low + N + 1].map(|v| format!("{v}/{v}/1"));
            text += &format!("f {}\n", corners.join(" "));
        }
    }
    std::fs::write(folder.join("a.obj"), text).unwrap();
}

fn has(what: &str, read: &ReadMesh) -> bool {
    let carries = |role| read.mesh.attributes.channel(role).is_some();
    let groups = &read.extra.groups;
    match what {
        "texture coordinates" => carries(Role::Uv),
        "normals" => carries(Role::Normal),
        "colours" => carries(Role::Colour),
        "textures" => read_looks(&read.extra, false).0.of_groups.iter().any(|look| look.texture.is_some()),
        "names of materials" => groups.iter().any(|group| group.material.as_deref() == Some("wood")),
        "names of objects" => {
            ["seat", "back"].iter().all(|name| groups.iter().any(|group| group.object.as_deref() == Some(*name)))
        }
        _ => panic!("{what}: a row that nothing is known of"),
    }
}

/// Source format, target format, and whether the attribute is kept.
type Pair = (&'static str, String, bool);

fn table() -> Vec<(String, Vec<Pair>)> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/formats.md")).unwrap();
    let cells = |line: &str| -> Vec<String> {
        line.trim().trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect()
    };
    let from = text.lines().position(|line| line.starts_with("| carried to")).expect("the table of carried attributes");
    let heads = cells(text.lines().nth(from).unwrap());
    let rows = text.lines().skip(from + 2).take_while(|line| line.starts_with('|'));
    let row = |line: &str| {
        let row = cells(line);
        let pair = |(to, cell): (&String, &String)| -> Vec<Pair> {
            let from = ["obj", "ply", "glb", "gltf"];
            let targets = to.to_lowercase().split(", ").map(String::from).collect::<Vec<_>>();
            let goes = |source: &str| match cell.as_str() {
                "yes" => true,
                "-" => false,
                only => only.strip_prefix("from ").unwrap().to_lowercase().split(", ").any(|name| name == source),
            };
            targets.into_iter().flat_map(|target| from.map(|source| (source, target.clone(), goes(source)))).collect()
        };
        (row[0].clone(), heads[1..].iter().zip(&row[1..]).flat_map(pair).collect())
    };
    rows.map(row).collect()
}

#[test]
fn each_pair_of_formats_carries_what_its_table_says() {
    let folder = folder();
    everything(folder.path());
    // Files of each format with everything it can hold.
    let convert = |from: &str, to: &str| {
        let place = to.rsplit_once('/').unwrap().0;
        std::fs::create_dir_all(folder.path().join(place)).unwrap();
        let done = run(folder.path(), &["simplify", from, "-o", to, "--ratio", "0.6"]);
        assert_eq!(done.code, Some(0), "{from} {to}: {}", done.stderr);
    };
    for source in ["obj", "ply", "glb", "gltf"] {
        convert("a.obj", &format!("from_{source}/b.{source}"));
    }
    let table = table();
    assert_eq!(table.len(), 6);
    for source in ["obj", "ply", "glb", "gltf"] {
        for target in ["obj", "ply", "glb", "gltf", "stl", "off", "3mf"] {
            let to = format!("{source}_{target}/c.{target}");
            convert(&format!("from_{source}/b.{source}"), &to);
            let read = read_attributed_path(&folder.path().join(&to), None).unwrap();
            for (what, pairs) in &table {
                let (_, _, goes) = pairs.iter().find(|(from, to, _)| *from == source && to == target).unwrap();
                assert_eq!(has(what, &read), *goes, "{what}, {source} to {target}");
            }
        }
    }
}

#[test]
fn a_3mf_keeps_its_unit_and_its_objects_and_stays_closed() {
    use neural_mesh::io::{Extra, Format, Group, Model, WriteOptions, write_attributed};
    use neural_mesh::mesh::cleanup::{CleanOptions, clean};
    use neural_mesh::mesh::{Attributes, Frame, shapes};
    let folder = folder();
    let (one, other) = (shapes::torus(48, 24, 1.0, 0.3), shapes::icosphere(3));
    let mesh = shapes::unite([&one, &shapes::place(&other, |[x, y, z]| [x + 5.0, y, z])]);
    let groups = (0..mesh.faces().len()).map(|face| u32::from(face >= one.faces().len())).collect();
    let object = |name: &str| {
        let mut group = Group::default();
        group.object = Some(name.into());
        group
    };
    let mut extra = Extra::default();
    (extra.unit, extra.groups) = (Some("inch".into()), vec![object("ring"), object("ball")]);
    let attributes = &Attributes { groups, ..Attributes::default() };
    let model = Model::new(&mesh, Frame::default(), attributes, &extra);
    let options = WriteOptions::new(Format::ThreeMf, "a");
    std::fs::write(folder.path().join("a.3mf"), write_attributed(&model, &options).unwrap().bytes).unwrap();
    succeed(folder.path(), &["simplify", "a.3mf", "-o", "b.3mf", "--faces", "600"]);
    let read = read_attributed_path(&folder.path().join("b.3mf"), None).unwrap();
    let names: Vec<_> = read.extra.groups.iter().filter_map(|group| group.object.as_deref()).collect();
    assert_eq!((names.as_slice(), read.extra.unit.as_deref()), (&["ring", "ball"][..], Some("inch")));
    // Without welding, each edge must still have two faces.
    let mut as_it_is = CleanOptions::default();
    as_it_is.weld = false;
    let mesh = clean(read.mesh, &as_it_is).unwrap().mesh;
    let edges = |face: &[u32; 3]| [[face[0], face[1]], [face[1], face[2]], [face[2], face[0]]];
    let sides: std::collections::HashSet<[u32; 2]> = mesh.faces().iter().flat_map(edges).collect();
    assert!(mesh.faces().len() <= 600 && sides.len() == 3 * mesh.faces().len());
    assert!(sides.iter().all(|&[a, b]| sides.contains(&[b, a])));
}
