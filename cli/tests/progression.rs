//! `neural-mesh progression`, and `simplify` from its files.

use std::path::Path;

use crate::common::{error_line, files, folder, json, read_welded, refuse, run, succeed, test_mesh_path};
use neural_mesh::io;
use neural_mesh::mesh::{shapes, topology};

fn make(folder: &Path, mesh: &str, more: &[&str]) {
    succeed(folder, &[&["progression", mesh, "-o", "a.nmp"], more].concat());
}

#[test]
fn any_size_comes_from_one_file() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    make(folder.path(), spot.to_str().unwrap(), &[]);
    let sizes = [("--faces", "1000"), ("--faces", "10%"), ("--vertices", "300"), ("--ratio", "0.05")];
    for ((option, size), n_faces) in sizes.into_iter().zip([1000, 584, 596, 288]) {
        for effort in ["fast", "standard"] {
            let arguments = ["simplify", "a.nmp", "-o", "b.ply", option, size, "--effort", effort, "--force"];
            succeed(folder.path(), &arguments);
            let mesh = read_welded(&folder.path().join("b.ply"));
            assert!(topology(&mesh).is_closed_manifold());
            assert_eq!(mesh.faces().len(), n_faces, "{option} {size}");
        }
    }
    succeed(folder.path(), &["simplify", "a.nmp", "-o", "c.obj", "--lods", "50%,10%", "--no-check"]);
    assert_eq!(io::read_path(&folder.path().join("c-lod1.obj"), None).unwrap().positions.len(), 293);
}

#[test]
fn distances_are_proved_on_request() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    make(folder.path(), spot.to_str().unwrap(), &["--prove"]);
    let within = ["simplify", "a.nmp", "-o", "b.ply", "--error", "2%", "--report", "b.json"];
    succeed(folder.path(), &within);
    let report = json(&folder.path().join("b.json"));
    let (proved, sampled) = (&report["certified"]["upper_percent"], &report["distance"]["max_percent"]);
    assert!(proved.as_f64().unwrap() <= 2.0 && sampled.as_f64() <= proved.as_f64(), "{report}");
    assert!(report["output"]["faces"].as_u64().unwrap() < 3000);
    make(folder.path(), spot.to_str().unwrap(), &["--force"]);
    let refused = error_line(&run(folder.path(), &["simplify", "a.nmp", "-o", "d.ply", "--error", "2%"]));
    assert!(refused.contains("no level has a proved distance"), "{refused}");
}

#[test]
fn materials_come_back_from_the_file_alone() {
    let folder = folder();
    let text = "mtllib a.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    std::fs::write(folder.path().join("a.obj"), text).unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
    make(folder.path(), "a.obj", &[]);
    ["a.obj", "a.mtl"].iter().for_each(|name| std::fs::remove_file(folder.path().join(name)).unwrap());
    succeed(folder.path(), &["simplify", "a.nmp", "-o", "b.obj", "--faces", "2"]);
    let written = std::fs::read_to_string(folder.path().join("b.obj")).unwrap();
    assert!(written.contains("usemtl red") && written.contains("mtllib a.mtl"), "{written}");
    assert_eq!(files(folder.path()), ["a.mtl", "a.nmp", "b.obj"]);
}

/// Writes a scene whose node moves its mesh, and returns its name.
fn write_scene(folder: &Path) -> &'static str {
    std::fs::write(folder.join("scene.glb"), crate::common::avatar::Avatar::new(8).glb()).unwrap();
    "scene.glb"
}

#[test]
fn a_scene_has_levels_in_every_format() {
    let folder = folder();
    make(folder.path(), write_scene(folder.path()), &[]);
    let simplify = |input: &str, output: &str| {
        let arguments = ["simplify", input, "-o", output, "--ratio", "40%", "--effort", "fast", "--no-check"];
        let run = run(folder.path(), &arguments);
        assert_eq!(run.code, Some(0), "{output}: {}", run.stderr);
        io::read_path(&folder.path().join(output), None).unwrap()
    };
    let scene = simplify("a.nmp", "level.glb");
    for ending in ["ply", "obj", "stl", "off"] {
        let level = simplify("a.nmp", &format!("level.{ending}"));
        // The level is that of the scene, with the nodes' transforms.
        let placed = io::read_path(&folder.path().join("level.glb"), None).unwrap();
        assert_eq!((level.faces.len(), level.faces.len() > 20), (placed.faces.len(), true), "{ending}");
        assert!((level.diagonal() / placed.diagonal() - 1.0).abs() < 1e-5, "{ending}");
        assert_eq!(scene.faces.len(), placed.faces.len());
    }
}

#[test]
fn levels_of_a_scene_are_one_file_in_a_glb() {
    let folder = folder();
    make(folder.path(), write_scene(folder.path()), &[]);
    let levels = ["--lods", "60%,30%", "--effort", "fast", "--no-check"];
    succeed(folder.path(), &[&["simplify", "a.nmp", "-o", "levels.glb"], &levels[..]].concat());
    succeed(folder.path(), &[&["simplify", "a.nmp", "a.nmp", "-o", "out", "--format", "glb"], &levels[..]].concat());
    assert_eq!(files(folder.path()), ["a.nmp", "levels.glb", "out", "scene.glb"]);
    assert_eq!(files(&folder.path().join("out")), ["a.glb", "manifest.csv"]);
    let written = std::fs::read(folder.path().join("levels.glb")).unwrap();
    assert!(String::from_utf8_lossy(&written).contains("MSFT_lod"));
}

#[test]
fn commands_that_read_meshes_refuse_a_progression_with_advice_that_works() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    make(folder.path(), spot.to_str().unwrap(), &[]);
    for words in ["compare a.nmp a.nmp", "clusters a.nmp -o a.nmc", "mesh-points a.nmp -o b.ply"] {
        let line = refuse(folder.path(), &words.split(' ').collect::<Vec<_>>(), 1);
        let advice = "neural-mesh simplify a.nmp -o MESH.ply --ratio 100%";
        assert_eq!(line, format!("neural-mesh: a.nmp: is a progression: write its mesh by `{advice}`"), "{words}");
        succeed(folder.path(), &[&advice.split(' ').skip(1).collect::<Vec<_>>()[..], &["--force"]].concat());
    }
    assert_eq!(io::read_path(&folder.path().join("MESH.ply"), None).unwrap().faces.len(), 5856);
}

#[test]
fn levels_below_the_floor_drop_components_and_repeat_nothing() {
    let folder = folder();
    // Spheres in a row, each of which has at least four vertices.
    let sphere = shapes::icosphere(2);
    let row = shapes::unite((0..6).map(|i| shapes::place(&sphere, |[x, y, z]| [x + 3.0 * i as f32, y, z])));
    let bytes = io::write(&row, &neural_mesh::mesh::Frame::default(), io::Format::Ply).unwrap();
    std::fs::write(folder.path().join("row.ply"), bytes).unwrap();
    make(folder.path(), "row.ply", &[]);
    for input in ["row.ply", "a.nmp"] {
        let sizes = ["--lods", "50%,16,8,3,2", "--lods-by", "vertices", "--no-check", "--force", "--report", "r.json"];
        let run = succeed(folder.path(), &[&["simplify", input, "-o", "b.ply"], &sizes[..]].concat());
        let said = String::from_utf8(run.stdout).unwrap();
        assert_eq!(said.matches("levels left out: 2: they repeat the one of 4 vertices, 4 faces").count(), 1, "{said}");
        let levels = json(&folder.path().join("r.json"))["levels"].as_array().unwrap().clone();
        let n_vertices: Vec<u64> = levels.iter().map(|level| level["vertices"].as_u64().unwrap()).collect();
        assert_eq!(n_vertices, [486, 16, 8, 4], "{input}");
        assert_eq!(levels.iter().filter(|level| level["outcome"] != "reached").count(), 1, "{input}");
    }
    assert_eq!(
        files(folder.path()),
        ["a.nmp", "b-lod0.ply", "b-lod1.ply", "b-lod2.ply", "b-lod3.ply", "r.json", "row.ply"]
    );
}

#[test]
fn a_page_is_written_beside_the_progression() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    let arguments = ["progression", spot.to_str().unwrap(), "-o", "spot.nmp", "--quiet", "--html"];
    let with_page = |page: &str| run(folder.path(), &[&arguments[..], &[page]].concat());
    for wrong in ["-", "./spot.nmp"] {
        let refused = with_page(wrong);
        assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    }
    let made = with_page("spot.html");
    assert_eq!((made.code, made.stdout.len()), (Some(0), 0), "{}", made.stderr);
    let page = std::fs::read_to_string(folder.path().join("spot.html")).unwrap();
    assert!(page.contains("<title>spot.ply - ") && page.contains("data-of=\"embedded\""));
    assert_eq!(files(folder.path()), ["spot.html", "spot.nmp"]);
}

#[test]
fn wrong_requests_end_in_one_line() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    let spot = spot.to_str().unwrap();
    make(folder.path(), spot, &[]);
    std::fs::write(folder.path().join("bad.nmp"), "NMESHPRG nothing").unwrap();
    for (arguments, code, why) in [
        (&["progression", spot, "-o", "b.ply"][..], 2, "end the name in .nmp"),
        (&["progression", "-", "-o", "b.nmp"], 2, "give the names of files"),
        (&["progression", spot, "-o", "a.nmp"], 1, "exists"),
        (&["simplify", "a.nmp", "-o", "b.ply", "--faces", "9", "--subset"], 2, "the options with which it was made"),
        (&["simplify", "a.nmp", "-o", "b.ply", "--size", "9kB"], 2, "levels by size or error"),
        (&["simplify", "bad.nmp", "-o", "b.ply", "--faces", "9"], 1, "not a progression"),
    ] {
        let refused = run(folder.path(), arguments);
        assert_eq!(refused.code, Some(code), "{}", refused.stderr);
        assert!(error_line(&refused).contains(why), "{}", refused.stderr);
    }
    assert_eq!(files(folder.path()), ["a.nmp", "bad.nmp"]);
}
