//! What the program does to the disk: whole files or none, nothing replaced unasked, nothing left behind.

use std::fs;

use crate::common::*;

#[test]
fn existing_files_are_refused_without_force() {
    let input = shipped("spot.ply");
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
        let refused = run(folder.path(), &all);
        assert_eq!(refused.code, Some(1));
        assert!(the_line(&refused).contains("--force"));
        assert_eq!(files(folder.path()), [taken]);
        assert_eq!(fs::read(folder.path().join(taken)).unwrap(), b"mine");
        assert_eq!(run(folder.path(), &[&all[..], &["--force"]].concat()).code, Some(0));
        assert_eq!(files(folder.path()), ["a.json", "a.ply", "a.png"]);
        assert_ne!(fs::read(folder.path().join(taken)).unwrap(), b"mine");
    }
}

#[test]
fn a_mesh_may_replace_its_own_input() {
    let folder = folder();
    fs::write(folder.path().join("a.obj"), OCTAHEDRON).unwrap();
    let run = run(folder.path(), &["simplify", "a.obj", "-o", "a.obj", "--ratio", "0.9", "--force"]);
    assert_eq!(run.code, Some(0), "{}", run.words);
    assert_eq!(info(folder.path(), "a.obj")["vertices"], 5);
}

#[test]
fn nothing_appears_when_the_input_is_bad() {
    for bad in ["", "v 0 0 0\n", "hello", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "solid x\nfacet"] {
        let folder = folder();
        let arguments = ["simplify", "-", "-o", "a.ply", "--ratio", "0.5", "--report", "a.json", "--picture", "a.png"];
        let run = run_with_input(folder.path(), &arguments, bad.as_bytes());
        assert_eq!(run.code, Some(1), "{bad:?}");
        the_line(&run);
        assert_eq!(files(folder.path()), Vec::<String>::new(), "{bad:?}");
    }
}

#[test]
fn places_where_nothing_can_be_written_are_refused_first() {
    let folder = folder();
    fs::create_dir(folder.path().join("b.ply")).unwrap();
    for output in ["none/a.ply", "b.ply"] {
        let run = run(folder.path(), &["simplify", "missing.ply", "-o", output, "--ratio", "0.5", "--force"]);
        assert_eq!(run.code, Some(1));
        assert!(the_line(&run).contains(output));
    }
    assert_eq!(files(folder.path()), ["b.ply"]);
}

#[test]
fn a_missing_input_is_named() {
    let folder = folder();
    let missing = run(folder.path(), &["simplify", "missing.ply", "-o", "a.ply", "--ratio", "0.5"]);
    assert_eq!(missing.code, Some(1));
    assert!(the_line(&missing).contains("missing.ply"));
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
    let folder = folder();
    fs::write(folder.path().join("real.obj"), "old").unwrap();
    std::os::unix::fs::symlink("real.obj", folder.path().join("link.obj")).unwrap();
    let run = run_with_input(
        folder.path(),
        &["simplify", "-", "-o", "link.obj", "--ratio", "1", "-f"],
        OCTAHEDRON.as_bytes(),
    );
    assert_eq!(run.code, Some(0), "{}", run.words);
    assert!(fs::symlink_metadata(folder.path().join("link.obj")).unwrap().is_symlink());
    assert_eq!(info(folder.path(), "real.obj")["faces"], 8);
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing_behind() {
    let folder = folder();
    let input = shipped("spot.ply");
    // The mesh is larger than a pipe holds and nobody reads it, so the run waits with its other results prepared.
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
    assert_eq!(run.code, Some(130), "{}", run.words);
    assert_eq!(files(folder.path()), Vec::<String>::new());
}

#[test]
fn nobody_reading_the_mesh_is_a_failure_without_files() {
    let folder = folder();
    let input = shipped("spot.ply");
    let arguments =
        ["simplify", input.to_str().unwrap(), "-o", "-", "--format", "ply", "--ratio", "1", "--report", "a.json"];
    let mut child = program(folder.path(), &arguments).spawn().unwrap();
    drop(child.stdout.take());
    let run = finish(child);
    assert_eq!(run.code, Some(1), "{}", run.words);
    assert_eq!(files(folder.path()), Vec::<String>::new());
}
