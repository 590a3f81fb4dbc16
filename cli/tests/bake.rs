//! `--bake`: results look like the original.

use std::fmt::Write as _;
use std::path::Path;

use neural_mesh::appearance::VIEWS;
use neural_mesh::io::{self, Asset};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{Attributes, Looks, Role, TriMesh, shapes};
use neural_mesh::metrics::psnr;
use neural_mesh::picture::{DecodedMaterials, Image, ShadedMesh, decode_image, encode_png, encode_webp, view_shaded};
use serde_json::json;

use crate::common::{OCTAHEDRON, error_line, files, folder, folder_with_octahedron, json, refuse, run, succeed};

fn ball() -> String {
    let mesh = shapes::wavy_sphere(5, 12.0);
    let band = |x: f32| if (40.0 * x).sin() > 0.0 { 0.9 } else { 0.2 };
    let mut text = String::new();
    for [x, y, z] in mesh.positions() {
        writeln!(text, "v {x} {y} {z} {} {} {}", band(*x), band(*y), 0.5 + 0.4 * z).unwrap();
    }
    for [a, b, c] in mesh.faces() {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    text
}

fn sheet(folder: &Path) {
    let n = 60;
    let mut text = String::from("mtllib sheet.mtl\nusemtl cloth\n");
    for i in 0..(n + 1) * (n + 1) {
        let [x, y] = [i % (n + 1), i / (n + 1)].map(|x| f64::from(x) / f64::from(n));
        writeln!(text, "v {x} {y} {}\nvt {x} {y}", 0.03 * (20.0 * x).sin() * (17.0 * y).sin()).unwrap();
    }
    for i in 0..n * n {
        let [a, b] = [i % n + i / n * (n + 1) + 1, (i / n + 1) * (n + 1) + i % n + 1];
        writeln!(text, "f {a}/{a} {0}/{0} {1}/{1}\nf {a}/{a} {1}/{1} {b}/{b}", a + 1, b + 1).unwrap();
    }
    std::fs::write(folder.join("sheet.obj"), text).unwrap();
    std::fs::write(
        folder.join("sheet.mtl"),
        "newmtl cloth\nKd 1 1 1\nPr 0.6\nPm 0\nKe 1 1 1\nmap_Kd a.png\nmap_Ke b.png\nmap_Pr b.png\n",
    )
    .unwrap();
    let image = |colour: fn(usize, usize) -> [u8; 3]| {
        let pixel = |i: usize| {
            let [r, g, b] = colour(i % 64, i / 64);
            [r, g, b, 255]
        };
        encode_png(&Image { width: 64, height: 64, rgba: (0..64 * 64).flat_map(pixel).collect() })
    };
    let checks = |x: usize, y: usize| if (x / 8 + y / 8).is_multiple_of(2) { [220, 60, 30] } else { [30, 90, 200] };
    std::fs::write(folder.join("a.png"), image(checks)).unwrap();
    std::fs::write(folder.join("b.png"), image(|x, _| [4 * x as u8; 3])).unwrap();
}

struct TexturedMesh {
    mesh: TriMesh,
    attributes: Attributes,
    looks: Looks,
}

fn read_textured(path: &Path) -> TexturedMesh {
    let read = io::read_attributed_path(path, None).unwrap();
    let (looks, notes) = io::read_looks(&read.extra, false);
    assert_eq!(notes, Vec::<String>::new());
    let cleaned = clean(read.mesh, &CleanOptions::default()).unwrap();
    // Positions in the file: the middles of two meshes may differ.
    let place = |&p: &[f32; 3]| cleaned.frame.to_file(p).map(|x| x as f32);
    let positions = cleaned.mesh.positions().iter().map(place).collect();
    let mesh = TriMesh::new(positions, cleaned.mesh.faces().to_vec()).unwrap();
    TexturedMesh { mesh, attributes: cleaned.attributes, looks }
}

fn likeness(before: &TexturedMesh, after: &TexturedMesh) -> f64 {
    let coats = [before, after].map(|it| DecodedMaterials::new(&it.attributes, &it.looks).0.unwrap());
    let shaded = [(&before.mesh, &coats[0]), (&after.mesh, &coats[1])].map(|(mesh, materials)| {
        let mut shaded = ShadedMesh::bare(mesh);
        shaded.materials = Some(materials);
        shaded
    });
    let mut pixels = [Vec::new(), Vec::new()];
    for direction in VIEWS {
        let views = view_shaded(&shaded, direction, 256);
        pixels.iter_mut().zip(views).for_each(|(all, view)| all.extend(view.shaded.rgba));
    }
    psnr(&pixels[0], &pixels[1]).unwrap()
}

fn simplify(folder: &Path, input: &str, output: &str, more: &[&str]) -> String {
    let done = succeed(folder, &[&["simplify", input, "-o", output, "-f"], more].concat());
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn a_twentieth_of_the_faces_looks_like_the_original_in_every_format() {
    let folder = folder();
    let in_folder = |name: &str| folder.path().join(name);
    std::fs::write(in_folder("ball.obj"), ball()).unwrap();
    let original = read_textured(&in_folder("ball.obj"));
    let asked = ["--ratio", "0.05", "--bake", "512", "--report", "r.json"];
    simplify(folder.path(), "ball.obj", "plain.obj", &["--ratio", "0.05"]);
    let plain = likeness(&original, &read_textured(&in_folder("plain.obj")));
    for output in ["baked.glb", "baked.obj", "baked.gltf"] {
        let said = simplify(folder.path(), "ball.obj", output, &asked);
        let line = said.lines().find(|line| line.starts_with("baked     512 x 512 texels, ")).unwrap();
        assert!(line.contains(" charts, ") && line.ends_with(" % of them"), "{line}");
        let report = &json(&in_folder("r.json"))["baked"];
        assert_eq!(report["size"], 512);
        assert!(report["covered"].as_f64().unwrap() > 0.4 && report["charts"].as_u64().unwrap() > 1, "{report}");
        let baked = read_textured(&in_folder(output));
        assert!(baked.mesh.faces().len() < original.mesh.faces().len() / 18);
        let found = likeness(&original, &baked);
        assert!(found > plain + 3.0 && found > 24.0, "{output}: {found} dB, {plain} dB without");
        let look = &baked.looks.of_groups[0];
        for texture in [&look.texture, &look.finish.normal_texture] {
            let image = decode_image(&texture.as_ref().unwrap().image).unwrap();
            assert_eq!((image.width, image.height), (512, 512));
        }
        assert_eq!((&look.finish.roughness_texture, look.finish.roughness, look.finish.metal), (&None, 1.0, 0.0));
    }
    assert_eq!(
        files(folder.path()),
        [
            "baked.glb",
            "baked.gltf",
            "baked.mtl",
            "baked.obj",
            "baked_0.png",
            "baked_1.png",
            "ball.obj",
            "plain.obj",
            "r.json"
        ]
    );
    let library = std::fs::read_to_string(in_folder("baked.mtl")).unwrap();
    assert!(library.contains("\nmap_Kd baked_0.png\n") && library.contains("\nnorm baked_1.png\n"), "{library}");
}

#[test]
fn normals_tangents_and_coordinates_are_written_with_the_normal_map() {
    let folder = folder();
    std::fs::write(folder.path().join("ball.obj"), ball()).unwrap();
    simplify(folder.path(), "ball.obj", "a.glb", &["--faces", "1000", "--bake", "128"]);
    let asset = Asset::read_path(&folder.path().join("a.glb")).unwrap();
    let attributes = &asset.parts()[0].mesh.attributes;
    let mut roles: Vec<String> = attributes.channels.iter().map(|channel| format!("{:?}", channel.role)).collect();
    roles.sort();
    assert_eq!(roles, ["Normal", "Tangent", "Uv"]);
    for channel in &attributes.channels {
        let rows = channel.values.chunks_exact(channel.width);
        match channel.role {
            Role::Uv => assert!(channel.values.iter().all(|x| (0.0..=1.0).contains(x))),
            _ => rows.for_each(|row| {
                assert!((row[..3].iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-3, "{row:?}");
                assert!(row.get(3).is_none_or(|sign| sign.abs() == 1.0), "{row:?}");
            }),
        }
    }
}

#[test]
fn emission_roughness_and_metal_are_baked() {
    let folder = folder();
    sheet(folder.path());
    let original = read_textured(&folder.path().join("sheet.obj"));
    for output in ["baked.glb", "baked.obj"] {
        simplify(folder.path(), "sheet.obj", output, &["--ratio", "0.05", "--bake", "256"]);
        let baked = read_textured(&folder.path().join(output));
        assert!(likeness(&original, &baked) > 24.0, "{output}: {}", likeness(&original, &baked));
        let finish = &baked.looks.of_groups[0].finish;
        assert!(finish.emission_texture.is_some() && finish.emission == [1.0; 3], "{output}");
        assert_eq!(finish.metal_texture.is_some(), output == "baked.glb");
        let rough = decode_image(&finish.roughness_texture.as_ref().unwrap().image).unwrap();
        let greens = rough.rgba.as_chunks::<4>().0.iter().map(|pixel| pixel[1]);
        // Up to 0.6 of the texture's 252.
        assert!(greens.clone().max().unwrap().abs_diff(151) < 3 && greens.min().unwrap() < 5, "{output}");
    }
    let library = std::fs::read_to_string(folder.path().join("baked.mtl")).unwrap();
    assert!(library.contains("\nmap_Ke ") && library.contains("\nmap_Pr ") && !library.contains("map_Pm"), "{library}");
}

#[test]
fn the_bytes_are_the_same_on_any_number_of_threads() {
    let folder = folder();
    std::fs::write(folder.path().join("ball.obj"), ball()).unwrap();
    let written = |threads: &str| {
        let asked = ["--ratio", "0.03", "--bake", "200", "--threads", threads, "-q"];
        simplify(folder.path(), "ball.obj", "a.glb", &asked);
        std::fs::read(folder.path().join("a.glb")).unwrap()
    };
    let one = written("1");
    assert!(one == written("2") && one == written("3"));
}

fn scene(targets: bool) -> String {
    let numbers = |first: char| {
        let lines = OCTAHEDRON.lines().filter(move |line| line.starts_with(first));
        lines.flat_map(|line| line.split(' ').skip(1).map(|x| x.parse::<f32>().unwrap()))
    };
    let mut bytes: Vec<u8> = numbers('v').flat_map(f32::to_le_bytes).collect();
    bytes.extend(numbers('f').flat_map(|corner| (corner as u32 - 1).to_le_bytes()));
    use base64::prelude::*;
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bytes));
    let primitive = json!({"attributes": {"POSITION": 0}, "indices": 1});
    let with = |key: &str, value: serde_json::Value| {
        let mut primitive = primitive.clone();
        primitive[key] = value;
        json!({"primitives": [primitive]})
    };
    let bent = [with("targets", json!([{"POSITION": 0}]))];
    let plain = [with("material", 0.into()), with("material", 1.into())];
    json!({
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": bytes.len(), "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteLength": 72}, {"buffer": 0, "byteOffset": 72, "byteLength": 96}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 6, "min": [-1, -1, -1], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 24}
        ],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0}},
            {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 1, 1], "metallicFactor": 1}}
        ],
        "meshes": if targets { bent.to_vec() } else { plain.to_vec() },
        "nodes": [{"mesh": 0}, {"mesh": usize::from(!targets), "translation": [3, 0, 0]}],
        "scenes": [{"nodes": [0, 1]}], "scene": 0
    })
    .to_string()
}

#[test]
fn the_meshes_of_a_scene_become_one_with_the_looks_of_all() {
    let folder = folder();
    std::fs::write(folder.path().join("scene.gltf"), scene(false)).unwrap();
    simplify(folder.path(), "scene.gltf", "one.glb", &["--ratio", "1", "--bake", "64"]);
    let asset = Asset::read_path(&folder.path().join("one.glb")).unwrap();
    assert_eq!(asset.parts().len(), 1);
    let look = &asset.looks().0[0][0];
    let pixels = |texture: &Option<neural_mesh::mesh::BaseTexture>| {
        let image = decode_image(&texture.as_ref().unwrap().image).unwrap();
        image.rgba.as_chunks::<4>().0.iter().map(|&[r, g, b, _]| [r, g, b]).collect::<std::collections::HashSet<_>>()
    };
    assert_eq!(pixels(&look.texture), [[255, 0, 0], [0, 0, 255]].into());
    assert_eq!(pixels(&look.finish.metal_texture), [[255, 255, 0], [255, 255, 255]].into());
}

#[test]
fn unbakeable_requests_are_refused_in_one_line() {
    let folder = folder_with_octahedron();
    std::fs::write(folder.path().join("bent.gltf"), scene(true)).unwrap();
    let before = files(folder.path());
    for (input, output, size, code, words) in [
        ("a.obj", "b.glb", "0", 2, "--bake 0: give a whole number from 16 to 8192"),
        ("a.obj", "b.glb", "8193", 2, "--bake 8193: give a whole number from 16 to 8192"),
        ("gone.obj", "b.ply", "64", 2, "--bake 64: ply cannot store textures: write glb, gltf or obj"),
        ("gone.obj", "b.stl", "64", 2, "--bake 64: stl cannot store textures: write glb, gltf or obj"),
        ("bent.gltf", "b.glb", "64", 2, "--bake: a mesh with a skin or morph targets has more than one shape"),
    ] {
        let refused = run(folder.path(), &["simplify", input, "-o", output, "--ratio", "0.5", "--bake", size]);
        assert_eq!(refused.code, Some(code), "{}", refused.stderr);
        assert!(error_line(&refused).contains(words), "{}", refused.stderr);
    }
    for other in [&["--lods", "0.5,0.2"][..], &["--size", "2MB"], &["--ratio", "0.5", "--ignore", "uv"]] {
        let asked = [&["simplify", "a.obj", "-o", "b.glb", "--bake", "64"], other].concat();
        let refused = run(folder.path(), &asked);
        assert_eq!(refused.code, Some(2), "{other:?}");
        assert!(refused.stderr.contains("cannot be used with"), "{}", refused.stderr);
    }
    let parts: String =
        (0..300).map(|i| crate::common::sphere(1 + 14 * i, 3, [3.0 * i as f64, 0.0, 0.0], 1.0)).collect();
    std::fs::write(folder.path().join("parts.obj"), parts).unwrap();
    let asked = ["simplify", "parts.obj", "-o", "b.glb", "--ratio", "1", "--bake", "16", "-q"];
    let line = refuse(folder.path(), &asked, 1);
    assert!(line.contains("--bake 16: the charts do not fit on 16 x 16 texels"), "{line}");
    std::fs::remove_file(folder.path().join("parts.obj")).unwrap();
    assert_eq!(files(folder.path()), before);
}

#[test]
fn a_batch_bakes_each_mesh_and_says_which_format_holds_none() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("in")).unwrap();
    sheet(&folder.path().join("in"));
    std::fs::write(folder.path().join("in/ball.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
    let asked = ["simplify", "in", "-o", "out", "--ratio", "0.1", "--bake", "64"];
    assert_eq!(run(folder.path(), &asked).code, Some(1));
    let out = folder.path().join("out");
    let rows = std::fs::read_to_string(out.join("manifest.csv")).unwrap();
    assert!(rows.contains("--bake 64") && rows.contains("off cannot store textures"), "{rows}");
    assert!(read_textured(&out.join("sheet.obj")).looks.of_groups[0].texture.is_some());
    let bad = ["simplify", "in", "-o", "out2", "--ratio", "0.1", "--bake", "9"];
    assert_eq!(run(folder.path(), &bad).code, Some(2));
}

#[test]
fn a_webp_is_baked_and_what_cannot_be_decoded_is_refused() {
    let folder = folder();
    let square = "mtllib a.mtl\nusemtl cloth\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
        vt 0.5 0.5\nf 1/1 2/2 5/5\nf 2/2 3/3 5/5\nf 3/3 4/4 5/5\nf 4/4 1/1 5/5\n";
    std::fs::write(folder.path().join("a.obj"), square).unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl cloth\nKd 1 1 1\nmap_Kd a.webp\n").unwrap();
    let green = Image { width: 8, height: 8, rgba: [10, 200, 30, 255].repeat(64) };
    let webp = encode_webp(&green).unwrap();
    let ktx2 = [&b"\xabKTX 20\xbb\r\n\x1a\n"[..], &[0; 68]].concat();
    let unread =
        "is not a complete KTX2 of ETC1S, UASTC or RGBA8 within 67 million pixels: give it as PNG, JPEG or WebP";
    let words = ["simplify", "a.obj", "-o", "b.glb", "--ratio", "1", "--bake", "64", "--force"];
    for (image, why) in [
        (&ktx2[..], unread),
        (&webp[..webp.len() / 2], "is not a complete WebP: save it again"),
        (b"GIF89a", "is not PNG, JPEG or WebP: convert it to one of these"),
    ] {
        std::fs::write(folder.path().join("a.webp"), image).unwrap();
        let run = run(folder.path(), &words);
        assert_eq!(run.code, Some(1), "{}", run.stderr);
        let line = format!("neural-mesh: a.obj: --bake 64: an image of the material \"cloth\" {why}");
        assert_eq!(error_line(&run), line);
        assert!(!folder.path().join("b.glb").exists());
    }
    std::fs::write(folder.path().join("a.webp"), &webp).unwrap();
    succeed(folder.path(), &words);
    let (looks, _) = Asset::read_path(&folder.path().join("b.glb")).unwrap().looks();
    let look = &looks[0][0];
    let seen = look.texture.as_ref().map(|texture| decode_image(&texture.image).unwrap());
    let [r, g, _] = look.colour;
    assert!(seen.map_or(g > 3.0 * r, |image| image.rgba[1] > 150 && image.rgba[0] < 60), "{:?}", look.colour);
}

#[test]
fn a_ktx2_is_baked() {
    let folder = folder();
    let square = "mtllib a.mtl\nusemtl cloth\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
        vt 0.5 0.5\nf 1/1 2/2 5/5\nf 2/2 3/3 5/5\nf 3/3 4/4 5/5\nf 4/4 1/1 5/5\n";
    std::fs::write(folder.path().join("a.obj"), square).unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl cloth\nKd 1 1 1\nmap_Kd a.ktx2\n").unwrap();
    std::fs::write(folder.path().join("a.ktx2"), include_bytes!("../../tests/images/uastc_zstd.ktx2")).unwrap();
    let words = ["simplify", "a.obj", "-o", "b.glb", "--ratio", "1", "--bake", "64", "--force"];
    succeed(folder.path(), &words);
    let (looks, _) = Asset::read_path(&folder.path().join("b.glb")).unwrap().looks();
    let image = decode_image(&looks[0][0].texture.as_ref().unwrap().image).unwrap();
    // Red and green rise from zero to full, one along each side.
    for channel in [0, 1] {
        let values = image.rgba.iter().skip(channel).step_by(4);
        assert!(values.clone().min() < Some(&30) && values.max() > Some(&225), "{channel}");
    }
}
