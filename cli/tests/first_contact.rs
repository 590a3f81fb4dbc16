//! Messages for the mistakes of a first contact: the next step is in the line.

use std::fs;
use std::path::Path;

use crate::common::*;

#[track_caller]
fn refused_line(folder: &Path, words: &str) -> String {
    refuse(folder, &words.split(' ').collect::<Vec<_>>(), 2)
}

/// Runs the command between backquotes at the end of a line.
fn run_advice(folder: &Path, line: &str) -> Run {
    let command = line.rsplit('`').nth(1).unwrap();
    let words: Vec<&str> = command.split(' ').collect();
    assert_eq!(words[0], "neural-mesh", "{line}");
    run(folder, &words[1..])
}

#[test]
fn a_distance_that_was_meant_in_percent_is_asked_back() {
    let folder = folder_with_octahedron();
    let line = refused_line(folder.path(), "simplify a.obj -o b.obj --error 5");
    assert!(line.contains("--error 5: is more than half of the diagonal"), "{line}");
    assert!(line.ends_with("did you mean 5%?"), "{line}");
    let levels = refused_line(folder.path(), "simplify a.obj -o b.obj --lods 0.1,5 --lods-by error");
    assert!(levels.contains("--lods 5: is more than half"), "{levels}");
    assert!(!refused_line(folder.path(), "simplify a.obj -o b.obj --error 500").contains("did you mean"));
    assert_eq!(files(folder.path()), ["a.obj"]);
    for error in ["5%", "0.5", "60%"] {
        let run = run(folder.path(), &["simplify", "a.obj", "-o", "b.obj", "--force", "--error", error]);
        assert_eq!(run.code, Some(0), "{error}: {}", run.stderr);
    }
}

#[test]
fn advice_for_a_missing_command_output_or_size_is_a_command_that_works() {
    for words in [
        "a.obj",
        "a.obj --ratio 50%",
        "a.obj -o b.obj --ratio 50%",
        "a.obj b.obj",
        "simplify a.obj b.obj",
        "simplify a.obj b.obj --ratio 50%",
        "simplify a.obj",
        "simplify a.obj --faces 6",
        "simplify a.obj -o b.obj",
        "simplify --ratio=50% a.obj b.obj",
    ] {
        let folder = folder_with_octahedron();
        let line = refused_line(folder.path(), words);
        assert_eq!(files(folder.path()), ["a.obj"]);
        let advised = run_advice(folder.path(), &line);
        assert_eq!(advised.code, Some(0), "{words}: {line}: {}", advised.stderr);
        assert_eq!(files(folder.path()).len(), 2, "{line}");
    }
}

#[test]
fn a_mesh_without_the_output_option_hints_at_it() {
    let folder = folder();
    let line = refused_line(folder.path(), "simplify in.ply out.ply --ratio 10%");
    assert!(line.contains("give the result after -o: `neural-mesh simplify in.ply -o out.ply --ratio 10%`"), "{line}");
    let command = refused_line(folder.path(), "in.ply");
    assert!(command.contains("run `neural-mesh simplify in.ply -o in-light.ply --ratio 10%`"), "{command}");
}

#[test]
fn levels_that_cannot_be_proved_are_said() {
    let folder = folder();
    // Fewer vertices than the smallest level for which distances are proved.
    fs::write(folder.path().join("a.obj"), OCTAHEDRON).unwrap();
    let made = succeed(folder.path(), &["progression", "a.obj", "-o", "a.nmp", "--prove"]);
    let said = String::from_utf8(made.stdout).unwrap();
    assert!(said.contains("no distance could be proved"), "{said}");
    let line = refuse(folder.path(), &["simplify", "a.nmp", "-o", "b.obj", "--error", "1%"], 1);
    assert!(line.contains("make it again with --prove or, if that proved none, give a size"), "{line}");
}

#[test]
fn long_names_out_of_files_are_cut() {
    let folder = folder();
    let name = "x".repeat(5000);
    let text = format!("mtllib {name}.mtl\nusemtl {name}\n{OCTAHEDRON}");
    fs::write(folder.path().join("a.obj"), text).unwrap();
    for words in [
        "simplify a.obj -o b.obj --ratio 90%",
        "simplify a.obj -o b.stl --ratio 90%",
        "simplify a.obj -o c.obj --ratio 90% --keep wheel",
        "info a.obj",
    ] {
        let run = run(folder.path(), &words.split(' ').collect::<Vec<_>>());
        let said = String::from_utf8(run.stdout).unwrap() + &run.stderr;
        assert!(!said.contains(&"x".repeat(81)) && said.lines().all(|line| line.len() < 400), "{words}: {said}");
    }
}

#[test]
fn info_knows_progressions_and_hierarchies() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    let spot = spot.to_str().unwrap();
    for words in [["progression", spot, "-o", "a.nmp", "--quiet"], ["clusters", spot, "-o", "a.nmc", "--quiet"]] {
        assert_eq!(run(folder.path(), &words).code, Some(0));
    }
    let said = |name: &str| String::from_utf8(run(folder.path(), &["info", name]).stdout).unwrap();
    assert!(
        said("a.nmp").starts_with("a.nmp: progression of spot.ply: levels of any size up to 2"),
        "{}",
        said("a.nmp")
    );
    assert!(said("a.nmc").starts_with("a.nmc: hierarchy of "), "{}", said("a.nmc"));
    let n_faces = info(folder.path(), spot)["faces"].clone();
    assert_eq!([&info(folder.path(), "a.nmp")["faces"], &info(folder.path(), "a.nmc")["faces"]], [&n_faces, &n_faces]);
    fs::write(folder.path().join("b.nmp"), "words").unwrap();
    let line = refuse(folder.path(), &["info", "b.nmp"], 1);
    assert!(line.contains("not a progression"), "{line}");
}
