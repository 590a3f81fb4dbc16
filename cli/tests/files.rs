//! Effects on the disk: complete files or none.

use std::fs;

use crate::common::*;

#[test]
fn existing_files_are_refused_without_force() {
    let input = test_mesh_path("spot.ply");
    let all = [
        "simplify",
        input.to_str().unwrap(),
        "--ratio",
        "0.2",
        "-o",
        "a.ply",
        "--report",
        "a.json",
        "--picture",
        "a.png",
    ];
    for taken in ["a.ply", "a.json", "a.png"] {
        let folder = folder();
        fs::write(folder.path().join(taken), "mine").unwrap();
        let line = refuse(folder.path(), &all, 1);
        assert!(line.contains("--force"), "{line}");
        assert_eq!(files(folder.path()), [taken]);
        assert_eq!(fs::read(folder.path().join(taken)).unwrap(), b"mine");
        assert_eq!(run(folder.path(), &[&all[..], &["--force"]].concat()).code, Some(0));
        assert_eq!(files(folder.path()), ["a.json", "a.ply", "a.png"]);
        assert_ne!(fs::read(folder.path().join(taken)).unwrap(), b"mine");
    }
}

#[test]
fn a_mesh_may_replace_its_own_input() {
    let folder = folder_with_octahedron();
    succeed(folder.path(), &["simplify", "a.obj", "-o", "a.obj", "--ratio", "0.9", "--force"]);
    assert_eq!(info(folder.path(), "a.obj")["vertices"], 5);
}

#[test]
fn nothing_appears_when_the_input_is_bad() {
    for bad in ["", "v 0 0 0\n", "hello", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "solid x\nfacet"] {
        let folder = folder();
        let arguments = ["simplify", "-", "-o", "a.ply", "--ratio", "0.5", "--report", "a.json", "--picture", "a.png"];
        let run = run_with_input(folder.path(), &arguments, bad.as_bytes());
        assert_eq!(run.code, Some(1), "{bad:?}");
        error_line(&run);
        assert_eq!(files(folder.path()), Vec::<String>::new(), "{bad:?}");
    }
}

#[test]
fn places_where_nothing_can_be_written_are_refused_first() {
    let folder = folder();
    fs::create_dir_all(folder.path().join("b.ply/missing.ply")).unwrap();
    for output in ["none/a.ply", "b.ply"] {
        let line = refuse(folder.path(), &["simplify", "missing.ply", "-o", output, "--ratio", "0.5", "--force"], 1);
        assert!(line.contains(output), "{line}");
    }
    assert_eq!(files(folder.path()), ["b.ply"]);
}

// A folder in which no file can be created, even by root.
#[cfg(target_os = "linux")]
#[test]
fn a_place_that_takes_no_file_is_refused_before_the_work() {
    let folder = folder();
    for option in ["-o", "--report", "--picture"] {
        let mut words = vec!["simplify", "missing.ply", "--ratio", "0.5"];
        words.extend([option, "/proc/self/a.ply"]);
        if option != "-o" {
            words.extend(["-o", "b.ply"]);
        }
        let run = run(folder.path(), &words);
        let line = error_line(&run);
        assert!(
            run.code == Some(1) && line.contains("/proc/self/a.ply") && line.contains("cannot create a file"),
            "{line}"
        );
    }
    assert!(files(folder.path()).is_empty());
}

#[test]
fn a_folder_takes_the_mesh_under_its_name() {
    let folder = folder();
    let in_folder = |name: &str| folder.path().join(name);
    fs::write(in_folder("a.obj"), OCTAHEDRON).unwrap();
    fs::create_dir(in_folder("out")).unwrap();
    let into = |output: &str, more: &[&str]| {
        run(folder.path(), &[&["simplify", "a.obj", "-o", output, "--ratio", "1"], more].concat())
    };
    let first = into("out", &["--report", "r.json"]);
    assert_eq!(first.code, Some(0), "{}", first.stderr);
    let refused = into("out/", &[]);
    assert!(
        refused.code == Some(1) && error_line(&refused).contains("out/a.obj: exists already"),
        "{}",
        refused.stderr
    );
    assert_eq!(into("out", &["--force"]).code, Some(0));
    assert_eq!(into("out", &["--format", "stl-ascii"]).code, Some(0));
    assert_eq!(into("out", &["--lods", "1,0.9"][..]).code, Some(2));
    succeed(folder.path(), &["simplify", "a.obj", "-o", "out", "--lods", "1,0.8"]);
    assert_eq!(files(&in_folder("out")), ["a-lod0.obj", "a-lod1.obj", "a.obj", "a.stl"]);
    // Not a batch: no manifest, but a report.
    assert_eq!(files(folder.path()), ["a.obj", "out", "r.json"]);
}

#[test]
fn a_folder_is_no_way_to_lose_the_input() {
    let folder = folder_with_octahedron();
    let line = refuse(folder.path(), &["simplify", "a.obj", "-o", ".", "--ratio", "1"], 1);
    assert!(line.contains("a.obj: exists already"), "{line}");
    assert_eq!(fs::read_to_string(folder.path().join("a.obj")).unwrap(), OCTAHEDRON);
    let nameless = run_with_input(folder.path(), &["simplify", "-", "-o", ".", "--ratio", "1"], OCTAHEDRON.as_bytes());
    assert!(nameless.code == Some(2) && error_line(&nameless).contains("has no name"), "{}", nameless.stderr);
    assert_eq!(files(folder.path()), ["a.obj"]);
}

#[test]
fn a_missing_input_is_named() {
    let folder = folder();
    let missing = run(folder.path(), &["simplify", "missing.ply", "-o", "a.ply", "--ratio", "0.5"]);
    assert_eq!(missing.code, Some(1));
    assert!(error_line(&missing).contains("missing.ply"));
    assert_eq!(run(folder.path(), &["info", "missing.ply"]).code, Some(1));
}

#[cfg(unix)]
#[test]
fn written_files_have_the_permissions_of_new_files() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    run_with_input(folder.path(), &["simplify", "-", "-o", "a.obj", "--ratio", "1"], OCTAHEDRON.as_bytes());
    fs::write(folder.path().join("plain"), "").unwrap();
    let [mode, plain] =
        ["a.obj", "plain"].map(|name| fs::metadata(folder.path().join(name)).unwrap().permissions().mode());
    assert_eq!(mode, plain);
}

#[cfg(unix)]
#[test]
fn a_link_stays_and_the_file_behind_it_changes() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    let in_folder = |name: &str| folder.path().join(name);
    fs::create_dir(in_folder("there")).unwrap();
    fs::write(in_folder("there/real.obj"), "old").unwrap();
    symlink("there/real.obj", in_folder("link.obj")).unwrap();
    symlink("link.obj", in_folder("twice.obj")).unwrap();
    symlink("there/new.obj", in_folder("ahead.obj")).unwrap();
    symlink("nowhere/new.obj", in_folder("nowhere.obj")).unwrap();
    symlink("around.obj", in_folder("around.obj")).unwrap();
    let write = |name: &str, force: &[&str]| {
        let arguments = [&["simplify", "-", "-o", name, "--ratio", "1"], force].concat();
        run_with_input(folder.path(), &arguments, OCTAHEDRON.as_bytes())
    };
    for (link, real) in
        [("link.obj", "there/real.obj"), ("twice.obj", "there/real.obj"), ("ahead.obj", "there/new.obj")]
    {
        assert_eq!(write(link, &[]).code, Some(1));
        let before = fs::read(in_folder(real)).ok();
        let run = write(link, &["--force"]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert!(fs::symlink_metadata(in_folder(link)).unwrap().is_symlink());
        assert_eq!(info(folder.path(), real)["faces"], 8, "{before:?}");
        fs::write(in_folder(real), "old").unwrap();
    }
    for link in ["nowhere.obj", "around.obj"] {
        let run = write(link, &["--force"]);
        assert_eq!(run.code, Some(1));
        assert!(error_line(&run).contains(link));
    }
    assert_eq!(files(&in_folder("there")), ["new.obj", "real.obj"]);
}

#[track_caller]
fn check_shared_file_is_refused(folder: &std::path::Path, arguments: &[&str]) {
    let before = files(folder);
    let line = refuse(folder, arguments, 2);
    assert!(line.contains("give each result its own file"), "{line}");
    assert_eq!(files(folder), before);
}

#[test]
fn results_that_would_be_one_file_are_refused_first() {
    let folder = folder();
    fs::create_dir(folder.path().join("b")).unwrap();
    fs::write(folder.path().join("in.obj"), OCTAHEDRON).unwrap();
    let simplify = |more: &[&str]| {
        check_shared_file_is_refused(folder.path(), &[&["simplify", "in.obj", "--ratio", "1"], more].concat())
    };
    let here = folder.path().join("a.ply");
    for other in ["a.ply", "./a.ply", "b/../a.ply", here.to_str().unwrap()] {
        for option in ["--report", "--picture", "--map"] {
            simplify(&["-o", "a.ply", option, other]);
            simplify(&["-o", "a.ply", option, other, "--force"]);
        }
    }
    simplify(&["-o", "c.ply", "--report", "a", "--picture", "./a"]);
    let lods = ["simplify", "in.obj", "--lods", "1,0.9", "-o", "a.ply", "--report", "a-lod1.ply"];
    check_shared_file_is_refused(folder.path(), &lods);
    check_shared_file_is_refused(folder.path(), &["mesh-points", "in.obj", "-o", "a.ply", "--report", "b/../a.ply"]);
    check_shared_file_is_refused(folder.path(), &["compare", "in.obj", "in.obj", "--json", "a", "--html", "./a"]);
}

#[cfg(unix)]
#[test]
fn results_that_would_be_one_file_through_links_are_refused_first() {
    let folder = folder();
    let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, folder.path().join(name)).unwrap();
    fs::create_dir(folder.path().join("b")).unwrap();
    fs::write(folder.path().join("in.obj"), OCTAHEDRON).unwrap();
    fs::write(folder.path().join("b/a.ply"), "old").unwrap();
    link("b", "c");
    link("b/a.ply", "d.json");
    link("b/new.ply", "e.json");
    for (output, report) in [("b/f.ply", "c/f.ply"), ("b/a.ply", "d.json"), ("c/new.ply", "e.json")] {
        let arguments = ["simplify", "in.obj", "--ratio", "1", "-o", output, "--report", report, "--force"];
        check_shared_file_is_refused(folder.path(), &arguments);
    }
    assert_eq!(fs::read(folder.path().join("b/a.ply")).unwrap(), b"old");
}

#[test]
fn companion_files_of_a_mesh_are_never_replaced_by_other_results() {
    let folder = folder();
    let in_folder = |name: &str| folder.path().join(name);
    fs::create_dir_all(in_folder("out/maps")).unwrap();
    fs::create_dir(in_folder("maps")).unwrap();
    fs::write(in_folder("in.mtl"), "newmtl m\nmap_Kd maps/t.png\n").unwrap();
    fs::write(in_folder("maps/t.png"), "texture").unwrap();
    fs::write(in_folder("in.obj"), format!("mtllib in.mtl\nusemtl m\n{OCTAHEDRON}")).unwrap();
    let simplify = |more: &[&str]| run(folder.path(), &[&["simplify", "in.obj", "--ratio", "1"], more].concat());
    for (option, place) in
        [("--report", "out/in.mtl"), ("--picture", "out/maps/t.png"), ("--map", "out/maps/../in.mtl")]
    {
        let refused = simplify(&["-o", "out/a.obj", option, place, "--force"]);
        assert_eq!(refused.code, Some(1), "{option}");
        assert!(error_line(&refused).contains("choose another name"), "{}", refused.stderr);
        assert_eq!((files(&in_folder("out")), files(&in_folder("out/maps"))), (vec!["maps".into()], Vec::new()));
    }
    assert_eq!(simplify(&["-o", "out/in.mtl", "--format", "obj", "--force"]).code, Some(1));
    assert_eq!(files(&in_folder("out")), ["maps"]);
    assert_eq!(simplify(&["-o", "out/a.obj", "--report", "out/maps/r.json"]).code, Some(0));
    assert_eq!(files(&in_folder("out")), ["a.obj", "in.mtl", "maps"]);
}

#[test]
fn the_buffer_of_a_scene_is_never_replaced_by_another_result() {
    use base64::prelude::*;
    let folder = folder();
    let in_folder = |name: &str| folder.path().join(name);
    run_with_input(folder.path(), &["simplify", "-", "-o", "a.gltf", "--ratio", "1"], OCTAHEDRON.as_bytes());
    let mut scene = json(&in_folder("a.gltf"));
    let buffer = scene["buffers"][0]["uri"].as_str().unwrap().split(',').next_back().unwrap().to_string();
    fs::write(in_folder("a.bin"), BASE64_STANDARD.decode(buffer).unwrap()).unwrap();
    scene["buffers"][0]["uri"] = "a.bin".into();
    fs::write(in_folder("a.gltf"), scene.to_string()).unwrap();
    let arguments = ["simplify", "a.gltf", "--ratio", "1", "-o", "b.gltf", "--report"];
    let refused = run(folder.path(), &[&arguments[..], &["b.bin", "--force"]].concat());
    assert_eq!(refused.code, Some(1), "{}", refused.stderr);
    assert_eq!(files(folder.path()), ["a.bin", "a.gltf"]);
    assert_eq!(run(folder.path(), &[&arguments[..], &["b.json"]].concat()).code, Some(0));
    assert_eq!(files(folder.path()), ["a.bin", "a.gltf", "b.bin", "b.gltf", "b.json"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing_behind() {
    let folder = folder();
    let input = test_mesh_path("spot.ply");
    // The mesh exceeds the buffer of a pipe that is never read, so the run waits with its other results prepared.
    let arguments = [
        "simplify",
        input.to_str().unwrap(),
        "-o",
        "-",
        "--format",
        "ply",
        "--ratio",
        "1",
        "--report",
        "a.json",
        "--picture",
        "a.png",
    ];
    let mut child = program(folder.path(), &arguments).spawn().unwrap();
    let unread = child.stdout.take();
    let run = interrupt_once(child, || files(folder.path()).len() >= 2);
    drop(unread);
    assert_eq!(run.code, Some(130), "{}", run.stderr);
    assert_eq!(files(folder.path()), Vec::<String>::new());
}

#[test]
fn an_unread_mesh_is_a_failure_without_files() {
    let folder = folder();
    let input = test_mesh_path("spot.ply");
    let arguments =
        ["simplify", input.to_str().unwrap(), "-o", "-", "--format", "ply", "--ratio", "1", "--report", "a.json"];
    let mut child = program(folder.path(), &arguments).spawn().unwrap();
    drop(child.stdout.take());
    let run = finish(child);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert_eq!(files(folder.path()), Vec::<String>::new());
}
