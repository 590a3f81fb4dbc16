//! Files that a run has read: none is replaced, but the mesh itself by its result with `--force`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use crate::common::*;
use neural_mesh::picture::{Image, encode_png, image_size};
use serde_json::{Value, json};

const N: usize = 7;

fn write_texture(path: &Path) {
    let rgba = (0..64 * 64).flat_map(|at| [(at % 64 * 4) as u8, (at / 64 * 4) as u8, 90, 255]).collect();
    fs::write(path, encode_png(&Image { width: 64, height: 64, rgba })).unwrap();
}

fn grid() -> (Vec<[f32; 3]>, Vec<[u16; 3]>) {
    let point = |at: usize| [(at % N) as f32, (at / N) as f32, (at % 3 * (at / N % 4)) as f32 * 0.2];
    let cell = |at: usize| {
        let at = (at / (N - 1) * N + at % (N - 1)) as u16;
        [[at, at + 1, at + N as u16], [at + 1, at + 1 + N as u16, at + N as u16]]
    };
    ((0..N * N).map(point).collect(), (0..(N - 1) * (N - 1)).flat_map(cell).collect())
}

fn write_obj(folder: &Path) {
    let (points, faces) = grid();
    let mut text = String::from("mtllib hi.mtl\nusemtl skin\n");
    for [x, y, z] in points {
        text += &format!("v {x} {y} {z}\nvt {} {}\n", x / N as f32, y / N as f32);
    }
    faces.iter().map(|face| face.map(|v| v + 1)).for_each(|[a, b, c]| text += &format!("f {a}/{a} {b}/{b} {c}/{c}\n"));
    fs::write(folder.join("hi.obj"), text).unwrap();
    fs::write(folder.join("hi.mtl"), "newmtl skin\nKd 1 1 1\nmap_Kd t.png\n").unwrap();
}

fn write_gltf(folder: &Path) {
    let (points, faces) = grid();
    let uvs: Vec<[f32; 2]> = points.iter().map(|p| [p[0] / N as f32, p[1] / N as f32]).collect();
    let parts: [Vec<u8>; 3] = [
        points.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect(),
        uvs.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect(),
        faces.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect(),
    ];
    let [a, b, c] = [0, 1, 2].map(|at: usize| parts[at].len());
    let bound = |axis: usize, pick: fn(f32, f32) -> f32| points.iter().map(|p| p[axis]).reduce(pick).unwrap();
    let [low, high] = [f32::min as fn(f32, f32) -> f32, f32::max].map(|pick| [0, 1, 2].map(|axis| bound(axis, pick)));
    let document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "buffers": [{"byteLength": a + b + c, "uri": "x.bin"}],
        "bufferViews": [{"buffer": 0, "byteLength": a}, {"buffer": 0, "byteOffset": a, "byteLength": b},
            {"buffer": 0, "byteOffset": a + b, "byteLength": c}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": N * N, "type": "VEC3",
                "min": low, "max": high},
            {"bufferView": 1, "componentType": 5126, "count": N * N, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 3 * faces.len(), "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"uri": "t.png"}],
    });
    fs::write(folder.join("hi.gltf"), document.to_string()).unwrap();
    fs::write(folder.join("x.bin"), parts.concat()).unwrap();
}

/// Writes a mesh with a buffer, a library and a texture, in four formats, with links to all files.
fn write_inputs(folder: &Path) {
    write_texture(&folder.join("t.png"));
    write_obj(folder);
    write_gltf(folder);
    succeed_in_words(folder, "simplify hi.obj -o hi.ply --ratio 1 --no-check");
    succeed_in_words(folder, "simplify hi.obj -o hi.stl --ratio 1 --no-check");
    succeed_in_words(folder, "progression hi.ply -o hi.nmp --quiet");
    for name in files(folder) {
        fs::hard_link(folder.join(&name), folder.join(format!("hard-{name}"))).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(format!("./hard-{name}"), folder.join(format!("soft-{name}"))).unwrap();
    }
    #[cfg(unix)]
    std::os::unix::fs::symlink(".", folder.join("here")).unwrap();
}

#[track_caller]
fn succeed_in_words(folder: &Path, words: &str) {
    succeed(folder, &words.split(' ').collect::<Vec<_>>());
}

/// Returns what is behind each name in the folder.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let behind = |name: String| Some((fs::read(folder.join(&name)).ok()?, name));
    files(folder).into_iter().filter_map(behind).map(|(bytes, name)| (name, bytes)).collect()
}

struct Draws(u64);

impl Draws {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }

    fn pick<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

const READ: [&str; 7] = ["hi.gltf", "x.bin", "t.png", "hi.obj", "hi.mtl", "hi.ply", "hi.nmp"];
const INPUTS: [&str; 5] = ["hi.gltf", "hi.obj", "hi.ply", "hi.stl", "hi.nmp"];

/// Draws a name: of a file that may be read, a link to one, or a new one.
fn draw_name(draws: &mut Draws) -> String {
    let name = draws.pick(&READ);
    match draws.below(6) {
        0 => format!("hard-{name}"),
        1 if cfg!(unix) => format!("soft-{name}"),
        2 if cfg!(unix) => format!("here/{name}"),
        3 => draws.pick(&["new.gltf", "x.gltf", "new.obj", "new.ply", "t.gltf"]).into(),
        _ => name.into(),
    }
}

struct Draw {
    words: Vec<String>,
    input: &'static str,
    result: Option<String>,
    reads_companions: bool,
}

fn draw_run(draws: &mut Draws) -> Draw {
    let input = draws.pick(&INPUTS);
    let [first, second, third] = [(); 3].map(|()| draw_name(draws));
    let format = draws.pick(&["gltf", "obj", "ply", "glb"]);
    let (text, reads_companions) = match draws.below(10) {
        0 => (format!("clusters {input} -o {first} --report {second} --html {third}"), false),
        // The texture of a PLY stays out of a progression.
        1 => (format!("progression {input} -o {} --html {second}", first.replace(".ply", ".nmp")), input != "hi.ply"),
        2 => (format!("compare {input} hi.ply --json {first} --html {second}"), true),
        3 => (format!("mesh-points {input} -o {first} --format ply --report {second}"), false),
        4 => (format!("simplify {input} -o {first} --format {format} --ratio .3 --report {second}"), true),
        5 => {
            (format!("simplify {input} -o {first} --format {format} --ratio .3 --map {second} --report {third}"), true)
        }
        6 => (format!("simplify {input} -o {first} --format {format} --lods .5,.2 --textures 16"), true),
        7 => (format!("simplify {input} -o new.{format} --ratio .3 --textures 16 --picture {first}"), true),
        8 => (format!("simplify {input} -o hi.{format} --ratio .3"), true),
        _ => (format!("simplify {input} -o x.{format} --ratio .3 --textures 16"), true),
    };
    let mut words: Vec<String> = text.split(' ').map(String::from).collect();
    words.extend((words[0] == "simplify").then(|| "--no-check".into()));
    words.extend((draws.below(4) > 0).then(|| "--force".into()));
    let is_result = matches!(words[0].as_str(), "simplify" | "mesh-points") && words.contains(&"--force".into());
    Draw { result: is_result.then(|| words[3].clone()), words, input, reads_companions }
}

#[test]
fn no_run_replaces_a_file_that_it_has_read() {
    let origin = folder();
    write_inputs(origin.path());
    let before = contents(origin.path());
    let (mut draws, mut n_done) = (Draws(7), 0);
    for _ in 0..300 {
        let draw = draw_run(&mut draws);
        let folder = folder();
        copy_with_links(origin.path(), folder.path());
        let words: Vec<&str> = draw.words.iter().map(String::as_str).collect();
        let run = run(folder.path(), &words);
        n_done += usize::from(run.code == Some(0));
        let after = contents(folder.path());
        if run.code != Some(0) {
            assert_eq!(after, before, "{words:?} {}", run.stderr);
            continue;
        }
        let companions: &[&str] = match draw.input {
            "hi.gltf" => &["x.bin", "t.png"],
            "hi.obj" => &["hi.mtl", "t.png"],
            "hi.ply" => &["t.png"],
            _ => &[],
        };
        let mut kept: Vec<&str> = if draw.reads_companions { companions.to_vec() } else { Vec::new() };
        // The result may take the place of its own mesh, by any of its names.
        let own = draw.result.is_some_and(|name| name.trim_start_matches("here/").ends_with(draw.input));
        kept.extend((!own).then_some(draw.input));
        for name in kept {
            assert_eq!(after[name], before[name], "{words:?} changed {name}");
            assert_eq!(after[&format!("hard-{name}")], before[name], "{words:?} changed hard-{name}");
        }
    }
    // Neither all nor none is refused, so both kinds are looked at.
    assert!((30..270).contains(&n_done), "{n_done}");
}

/// Copies files, hard links as such.
fn copy_with_links(from: &Path, to: &Path) {
    for name in files(from) {
        let (path, at) = (from.join(&name), to.join(&name));
        match fs::read_link(&path) {
            #[cfg(unix)]
            Ok(link) => std::os::unix::fs::symlink(link, at).unwrap(),
            _ if name.starts_with("hard-") => {}
            _ => drop(fs::copy(path, at).unwrap()),
        }
    }
    let hard = |name: &String| name.strip_prefix("hard-").map(String::from);
    files(from)
        .iter()
        .filter_map(hard)
        .for_each(|name| fs::hard_link(to.join(&name), to.join(format!("hard-{name}"))).unwrap());
}

#[test]
fn companion_files_get_new_names_where_the_original_ones_are() {
    for (input, output, texture, named_in) in [
        ("hi.gltf", "y.gltf", "t-16.png", "y.gltf"),
        ("hi.obj", "y.obj", "t-16.png", "hi-1.mtl"),
        ("hi.ply", "y.ply", "t-16.png", "y.ply"),
        ("hi.obj", "y.ply", "t-16.png", "y.ply"),
    ] {
        for force in [&["--force"][..], &[]] {
            let folder = folder();
            write_inputs(folder.path());
            let before = contents(folder.path());
            let words =
                [&["simplify", input, "-o", output, "--ratio", ".3", "--textures", "16", "--no-check"], force].concat();
            let run = run(folder.path(), &words);
            assert_eq!(run.code, Some(0), "{words:?} {}", run.stderr);
            let after = contents(folder.path());
            assert!(before.iter().all(|(name, bytes)| after[name] == *bytes), "{words:?}");
            assert_eq!(image_size(&after[texture]), Some([16, 16]));
            let text = String::from_utf8_lossy(&after[named_in]);
            assert!(text.contains(texture) && !text.contains("t.png"), "{words:?} {text}");
            // A second run finds its own files and needs no further names.
            let more: &[&str] = if force.is_empty() { &["--force"] } else { &[] };
            let again = crate::common::run(folder.path(), &[&words[..], more].concat());
            assert_eq!(again.code, Some(0), "{words:?} {}", again.stderr);
            assert_eq!(contents(folder.path()).keys().collect::<Vec<_>>(), after.keys().collect::<Vec<_>>());
        }
    }
}

#[test]
fn a_buffer_that_would_replace_the_original_one_gets_a_new_name() {
    let folder = folder();
    write_gltf(folder.path());
    write_texture(&folder.path().join("t.png"));
    let before = contents(folder.path());
    succeed_in_words(folder.path(), "simplify hi.gltf -o x.gltf --ratio .3 --force");
    assert_eq!(files(folder.path()), ["hi.gltf", "t.png", "x-1.bin", "x.bin", "x.gltf"]);
    assert_eq!(json(&folder.path().join("x.gltf"))["buffers"][0]["uri"], "x-1.bin");
    assert!(before.iter().all(|(name, bytes)| fs::read(folder.path().join(name)).unwrap() == *bytes));
    assert!(info(folder.path(), "x.gltf")["faces"].as_u64() < info(folder.path(), "hi.gltf")["faces"].as_u64());
}

#[test]
fn a_mesh_in_place_leaves_its_companion_files_as_they_were() {
    let folder = folder();
    write_obj(folder.path());
    write_texture(&folder.path().join("t.png"));
    let before = contents(folder.path());
    succeed_in_words(folder.path(), "simplify hi.obj -o hi.obj --ratio .3 --textures 16 --force");
    let after = contents(folder.path());
    assert_eq!(files(folder.path()), ["hi-1.mtl", "hi.mtl", "hi.obj", "t-16.png", "t.png"]);
    assert!(after["hi.obj"].starts_with(b"mtllib hi-1.mtl\n") && after["hi.obj"].len() < before["hi.obj"].len());
    assert_eq!([&after["hi.mtl"], &after["t.png"]], [&before["hi.mtl"], &before["t.png"]]);
}

#[test]
fn standard_input_is_a_file_that_is_read() {
    let folder = folder();
    let in_folder = |name: &str| folder.path().join(name);
    fs::write(in_folder("a.obj"), OCTAHEDRON).unwrap();
    let simplify = |words: &str| {
        let mut command = program(folder.path(), &words.split(' ').collect::<Vec<_>>());
        command.stdin(Stdio::from(fs::File::open(in_folder("a.obj")).unwrap()));
        finish(command.spawn().unwrap())
    };
    if cfg!(unix) {
        let refused = simplify("simplify - -o b.obj --ratio 1 --report a.obj --force");
        assert!(refused.code == Some(1) && error_line(&refused).contains("a.obj: is read in this run"));
        assert_eq!(files(folder.path()), ["a.obj"]);
    }
    assert_eq!(simplify("simplify - -o a.obj --ratio .9 --force").code, Some(0));
    assert_eq!(info(folder.path(), "a.obj")["vertices"], 5);
}

#[test]
fn reports_and_pages_on_a_mesh_are_refused_in_one_line() {
    let folder = folder();
    write_inputs(folder.path());
    let before = contents(folder.path());
    for words in [
        "simplify hi.gltf -o new.gltf --ratio .3 --report hi.gltf",
        "simplify hi.gltf -o new.gltf --ratio .3 --map x.bin",
        "simplify hi.obj -o new.obj --ratio .3 --picture t.png",
        "simplify hi.obj -o hi.mtl --format obj --ratio .3",
        "simplify hi.ply -o new.ply --ratio .3 --weights hi.obj --report hi.obj",
        "clusters hi.ply -o hi.ply",
        "clusters hi.ply -o new.nmc --html hi.ply",
        "clusters hi.gltf -o x.bin",
        "progression hi.obj -o new.nmp --html t.png",
        "compare hi.ply hi.obj --json hi.obj",
        "compare hi.ply hi.obj --html hi.mtl",
        "mesh-points hi.ply -o new.ply --report hi.ply",
    ] {
        for force in [&[][..], &["--force"]] {
            let words = [&words.split(' ').collect::<Vec<_>>()[..], &["--quiet"], force].concat();
            let line = refuse(folder.path(), &words, 1);
            assert!(line.contains("choose another name"), "{line}");
            assert_eq!(contents(folder.path()), before, "{words:?}");
        }
    }
}

#[test]
fn a_batch_replaces_no_mesh_but_by_its_own_result() {
    let folder = folder();
    let in_folder = |name: &str| folder.path().join(name);
    fs::create_dir_all(in_folder("in")).unwrap();
    for (place, scale) in [("b.obj", 2), ("in/b.obj", 1), ("in/c.obj", 1)] {
        fs::write(in_folder(place), OCTAHEDRON.replace(" 1", &format!(" {scale}"))).unwrap();
    }
    let before = fs::read(in_folder("in/b.obj")).unwrap();
    // The result of the first mesh would be at the place of the second.
    let nested = run(folder.path(), &["simplify", "b.obj", "in/b.obj", "-o", "in", "--ratio", ".9", "--force"]);
    assert_eq!(nested.code, Some(1), "{}", nested.stderr);
    assert!(nested.stderr.contains("b.obj: is read in this run"), "{}", nested.stderr);
    assert_eq!(fs::read(in_folder("in/b.obj")).unwrap(), before);
    // In place, each is replaced by its own, and a list is not replaced by the manifest.
    succeed(&in_folder("in"), &["simplify", "b.obj", "c.obj", "-o", ".", "--ratio", ".9", "--force"]);
    assert_eq!(["b.obj", "c.obj"].map(|name| info(&in_folder("in"), name)["vertices"].clone()), [5, 5]);
    fs::write(in_folder("manifest.csv"), "b.obj\n").unwrap();
    for list in [&["--list", "manifest.csv"][..], &["b.obj", "in/c.obj"]] {
        let refused = run(folder.path(), &[&["simplify", "-o", ".", "--ratio", ".9", "--force"], list].concat());
        assert_eq!(refused.code, Some(1), "{}", refused.stderr);
        assert_eq!(fs::read(in_folder("manifest.csv")).unwrap(), b"b.obj\n");
    }
}

#[test]
fn a_batch_in_place_leaves_textures_and_buffers_as_they_were() {
    let folder = folder();
    let in_folder = |name: &str| folder.path().join(name);
    write_inputs(folder.path());
    for name in ["hi.ply", "hi.stl", "hi.nmp"] {
        fs::remove_file(in_folder(name)).unwrap();
    }
    // The buffer of the one has the name that the new buffer of the other would get.
    let other = fs::read_to_string(in_folder("hi.gltf")).unwrap().replace("x.bin", "hi.bin");
    fs::write(in_folder("z.gltf"), other).unwrap();
    fs::copy(in_folder("x.bin"), in_folder("hi.bin")).unwrap();
    let links: Vec<PathBuf> = files(folder.path())
        .iter()
        .filter(|name| name.contains("hard-") || name.contains("soft-") || *name == "here")
        .map(|name| in_folder(name))
        .collect();
    links.iter().for_each(|link| fs::remove_file(link).unwrap());
    let before = contents(folder.path());
    for threads in ["1", "4"] {
        let words = [
            "simplify",
            ".",
            "-o",
            ".",
            "--ratio",
            ".5",
            "--textures",
            "16",
            "--no-check",
            "--force",
            "--threads",
            threads,
        ];
        succeed(folder.path(), &words);
        let after = contents(folder.path());
        for name in ["t.png", "x.bin", "hi.bin", "hi.mtl"] {
            assert_eq!(after[name], before[name], "{name}");
        }
        let buffer = json(&in_folder("hi.gltf"))["buffers"][0]["uri"].clone();
        assert!(matches!(buffer, Value::String(name) if name.starts_with("hi-")));
    }
}
