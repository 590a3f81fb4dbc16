//! Advice in messages is accepted and helps.

use std::fs;
use std::path::Path;

use crate::common::avatar::Avatar;
use crate::common::*;

fn list_advice(run: &Run) -> Vec<String> {
    let words = String::from_utf8(run.stdout.clone()).unwrap();
    words.lines().filter_map(|line| line.strip_prefix("try       ")).map(String::from).collect()
}

fn advised_value(line: &str, option: &str) -> String {
    let (_, rest) = line.split_once(option).unwrap_or_else(|| panic!("{line}"));
    rest.trim_start().split([' ', ',', ';']).next().unwrap().to_string()
}

fn advised_attributes(line: &str) -> String {
    line.split_once("--ignore ").unwrap().1.split(' ').next().unwrap().trim_end_matches(',').to_string()
}

fn vertices(folder: &Path, words: &[&str]) -> (Run, u64) {
    let all = [
        &["simplify"],
        words,
        &["--vertices", "60", "--seam-error", "0", "--hold-shape", "--force", "--report", "r.json"],
    ]
    .concat();
    let run = run(folder, &all);
    assert_eq!(run.code, Some(0), "{words:?}: {}", run.stderr);
    (run, json(&folder.join("r.json"))["output"]["vertices"].as_u64().unwrap())
}

#[test]
fn advised_options_are_accepted_and_allow_smaller_results() {
    let folder = folder();
    fs::write(folder.path().join("a.obj"), charts(12, &["red", "blue"])).unwrap();
    vertices(folder.path(), &["a.obj", "-o", "a.glb", "--ignore", "colors"]);
    run(folder.path(), &["simplify", "a.obj", "-o", "a.glb", "--ratio", "1", "--force"]);
    for (input, output) in [("a.obj", "b.obj"), ("a.obj", "b.ply"), ("a.glb", "b.glb"), ("a.glb", "b.obj")] {
        let (limited, n_limited) = vertices(folder.path(), &[input, "-o", output]);
        let lines = list_advice(&limited);
        assert!(n_limited > 100 && !lines.is_empty(), "{input} {output}: {n_limited} {lines:?}");
        let (_, n_freed) = vertices(folder.path(), &[input, "-o", output, "--ignore", &advised_attributes(&lines[0])]);
        let is_scene = output == "b.glb";
        assert_eq!(lines.len(), if is_scene { 3 } else { 2 }, "{lines:?}");
        assert_eq!(lines.last().map(String::as_str), Some("without --hold-shape shapes give way to the size"));
        // The primitives of a scene stay separate, and the next line says what to do about it.
        assert!(is_scene || n_freed <= 60, "{input} {output}: {n_freed} {lines:?}");
        assert!(!is_scene || !lines[0].contains("materials") && lines[1].contains("--ignore materials"), "{lines:?}");
    }
    let (_, n_freed) = vertices(folder.path(), &["a.glb", "-o", "c.obj", "--ignore", "uv,materials"]);
    assert!(n_freed <= 60, "{n_freed}");
}

#[test]
fn ignored_attributes_stay_in_the_advice() {
    let folder = folder();
    fs::write(folder.path().join("a.obj"), charts(12, &["red", "blue"])).unwrap();
    let (limited, _) = vertices(folder.path(), &["a.obj", "-o", "b.obj", "--ignore", "materials"]);
    assert_eq!(advised_attributes(&list_advice(&limited)[0]), "materials,uv");
}

#[test]
fn a_size_that_images_exceed_is_refused_before_anything_is_written() {
    let folder = folder();
    fs::write(folder.path().join("a.glb"), Avatar::new(256).glb()).unwrap();
    let words = ["simplify", "a.glb", "-o", "b.glb", "--size", "100kB"];
    let refused = run(folder.path(), &words);
    assert_eq!((refused.code, files(folder.path())), (Some(1), vec!["a.glb".to_string()]), "{}", refused.stderr);
    let line = error_line(&refused);
    assert!(line.contains("--size 100000: images alone take "), "{line}");
    let side = advised_value(&line, "--textures ");
    let smaller = run(folder.path(), &[&words[..], &["--textures", &side]].concat());
    assert_eq!(smaller.code, Some(0), "{side}: {}", smaller.stderr);
    let n_bytes = fs::metadata(folder.path().join("b.glb")).unwrap().len();
    assert!((50_000..=100_000).contains(&n_bytes), "{side}: {n_bytes}");
    let hopeless = run(folder.path(), &["simplify", "a.glb", "-o", "c.glb", "--size", "900"]);
    assert!(hopeless.code == Some(1) && error_line(&hopeless).ends_with(": allow more bytes"), "{}", hopeless.stderr);
}

#[test]
fn the_size_of_a_gltf_counts_its_buffer_file() {
    let folder = folder();
    fs::write(folder.path().join("a.obj"), sphere(1, 30, [0.0; 3], 1.0)).unwrap();
    succeed(folder.path(), &["simplify", "a.obj", "-o", "a.glb", "--ratio", "1"]);
    for input in ["a.obj", "a.glb"] {
        succeed(folder.path(), &["simplify", input, "-o", "b.gltf", "--size", "20kB", "--force"]);
        let bytes = |name: &str| fs::metadata(folder.path().join(name)).map_or(0, |found| found.len());
        let n_bytes = bytes("b.gltf") + bytes("b.bin");
        assert!((15_000..=20_000).contains(&n_bytes), "{input}: {n_bytes}");
        let _ = fs::remove_file(folder.path().join("b.bin"));
    }
}

#[test]
fn a_name_without_an_ending_gets_the_formats_that_this_build_writes() {
    let folder = folder_with_octahedron();
    let line = refuse(folder.path(), &["simplify", "a.obj", "-o", "b", "--ratio", "1"], 2);
    for format in line.rsplit("one of ").next().unwrap().split(", ") {
        let run = run(folder.path(), &["simplify", "a.obj", "-o", "b", "--ratio", "1", "--format", format, "--force"]);
        assert_eq!(run.code, Some(0), "{format}: {}", run.stderr);
    }
}

type Words<'a> = &'a [&'a str];

#[test]
fn refusals_say_what_is_accepted() {
    let folder = folder();
    fs::write(folder.path().join("a.glb"), Avatar::new(8).glb()).unwrap();
    fs::write(folder.path().join("a.obj"), OCTAHEDRON).unwrap();
    // A rejected command, the end of its message, and the commands that follow the advice.
    let cases: [(Words, &str, &[Words]); 9] = [
        (
            &["a.glb", "-o", "b.glb", "--ignore", "uv,materials"],
            "leave materials out, or write obj or ply",
            &[
                &["a.glb", "-o", "b.glb", "--ignore", "uv"],
                &["a.glb", "-o", "b.obj", "--ignore", "uv,materials"],
                &["a.glb", "-o", "b.ply", "--ignore", "uv,materials"],
            ],
        ),
        (
            &["a.glb", "-o", "b.glb", "--printable"],
            "write stl, ply or obj",
            &[
                &["a.glb", "-o", "b.stl", "--printable"],
                &["a.glb", "-o", "b.ply", "--printable"],
                &["a.glb", "-o", "b.obj", "--printable"],
            ],
        ),
        (&["a.glb", "-o", "b.glb", "--bake", "64"], "", &[&["a.glb", "-o", "b.glb"]]),
        (
            &["a.obj", "-o", "b.stl", "--textures", "64"],
            "write glb, gltf, obj or ply",
            &[
                &["a.obj", "-o", "b.glb", "--textures", "64"],
                &["a.obj", "-o", "b.gltf", "--textures", "64"],
                &["a.obj", "-o", "c.obj", "--textures", "64"],
                &["a.obj", "-o", "b.ply", "--textures", "64"],
            ],
        ),
        (
            &["a.obj", "-o", "b.ply", "--compress=quantize"],
            "write glb or gltf",
            &[&["a.obj", "-o", "b.glb", "--compress=quantize"], &["a.obj", "-o", "b.gltf", "--compress=quantize"]],
        ),
        (
            &["a.obj", "-o", "b.ply", "--close"],
            "leave it out, the closed assembly makes no holes (--fill-holes closes those of the input)",
            &[&["a.obj", "-o", "b.ply"]],
        ),
        (&["a.obj", "-o", "b.fbx"], "choose glb, which stores the same content", &[&["a.obj", "-o", "b.glb"]]),
        (&["a.obj", "-o", "a.obj"], "replace it with --force", &[&["a.obj", "-o", "a.obj", "--force"]]),
        (&["a.obj", "-o", "b.vrm"], "end the name in .glb", &[&["a.obj", "-o", "b.glb"]]),
    ];
    for (refused, advice, accepted) in cases {
        let is_about_files = refused[0] == refused[2];
        let refused = [refused, if is_about_files { &[] } else { &["--force"] }].concat();
        let run = |words: &[&str]| run(folder.path(), &[&["simplify", "--ratio", "1"], words].concat());
        let line = error_line(&run(&refused));
        assert!(line.ends_with(advice), "{line}");
        for accepted in accepted {
            let accepted = [*accepted, if is_about_files { &[] } else { &["--force"] }].concat();
            let run = run(&accepted);
            assert_eq!(run.code, Some(0), "{accepted:?}: {}", run.stderr);
        }
    }
}
