//! Output cannot control the terminal, and failed writes are errors.

use std::fs;
use std::io::Write;
use std::process::Stdio;

use crate::common::*;

const EVIL: &str = "e\u{1b}[2J\u{1b}]0;pwn\u{7}\u{9b}6n\u{202e}";
const LINES: &str = "\u{85}\u{2028}\u{2029}";

#[track_caller]
fn check_no_controls(run: &Run) -> String {
    let said = format!("{}{}", String::from_utf8(run.stdout.clone()).unwrap(), run.stderr);
    let is_control =
        |letter: char| letter != '\n' && (letter.is_control() || LINES.contains(letter) || letter == '\u{202e}');
    assert!(!said.contains(is_control), "{said:?}");
    said
}

#[track_caller]
fn check_escaped(run: &Run) -> String {
    let said = check_no_controls(run);
    assert!(said.contains("e\\u{1b}[2J\\u{1b}]0;pwn\\u{7}\\u{9b}6n\\u{202e}"), "{said}");
    said
}

fn tetrahedron(header: &str, faces: [&str; 4], more: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n{header}end_header\n\
         0 0 0\n1 0 0\n0 1 0\n0 0 1\n{}\n{more}",
        faces.join("\n")
    )
}

const FACES: [&str; 4] = ["3 0 2 1", "3 0 1 3", "3 1 2 3", "3 2 0 3"];

// Long work without a terminal prints a line now and then.
#[test]
fn long_work_prints_its_progress() {
    let folder = folder();
    let waiting = |more: &[&str]| {
        let words = [&["simplify", "-", "-o", "a.obj", "--ratio", "1", "--force"], more].concat();
        let mut child = program(folder.path(), &words).stdin(Stdio::piped()).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        std::thread::sleep(std::time::Duration::from_secs(8));
        stdin
            .write_all(tetrahedron("element face 4\nproperty list uchar int vertex_indices\n", FACES, "").as_bytes())
            .unwrap();
        drop(stdin);
        finish(child)
    };
    let (told, quiet) = std::thread::scope(|scope| {
        let quiet = scope.spawn(|| waiting(&["--quiet"]));
        (waiting(&[]), quiet.join().unwrap())
    });
    assert_eq!((told.code, quiet.code), (Some(0), Some(0)), "{}{}", told.stderr, quiet.stderr);
    assert!(told.stderr.starts_with("progress  0 % reading, "), "{}", told.stderr);
    assert_eq!(quiet.stderr, "");
}

#[test]
fn names_in_a_ply_are_spelled_out() {
    let list = "element face 4\nproperty list uchar int vertex_indices\n";
    let of_faces = ["3 0 2 1 0.5", "3 0 1 3 1", "3 1 2 3 2", "3 2 0 3 3"];
    for file in [
        tetrahedron(&format!("{list}element {EVIL} 1\nproperty int a\n"), FACES, "7\n"),
        tetrahedron(&format!("{list}property float {EVIL}\n"), of_faces, ""),
    ] {
        let folder = folder();
        fs::write(folder.path().join("a.ply"), file).unwrap();
        let made = succeed(folder.path(), &["simplify", "a.ply", "-o", "b.ply", "--ratio", "1"]);
        assert!(check_escaped(&made).contains("note      "));
    }
    let folder = folder();
    let cut = tetrahedron(&format!("{list}element {EVIL} 9\nproperty int a\n"), FACES, "7\n");
    fs::write(folder.path().join("a.ply"), cut).unwrap();
    let refused = run(folder.path(), &["simplify", "a.ply", "-o", "b.ply", "--ratio", "1"]);
    assert_eq!(refused.code, Some(1));
    check_escaped(&refused);
    error_line(&refused);
}

#[test]
fn names_in_an_obj_are_spelled_out() {
    let folder = folder();
    let named = format!("mtllib {EVIL}.mtl\no {EVIL}\ng {EVIL}\nusemtl {EVIL}\n{OCTAHEDRON}");
    fs::write(folder.path().join("a.obj"), named).unwrap();
    let arguments = ["simplify", "a.obj", "-o", "b.obj", "--ratio", "1"];
    let made = succeed(folder.path(), &[&arguments[..], &["--picture", "b.png"]].concat());
    check_escaped(&made);
    for importance in ["none=2", "none"] {
        let refused = run(folder.path(), &[&arguments[..], &["--importance", importance, "--force"]].concat());
        assert_eq!(refused.code, Some(2), "{}", refused.stderr);
        check_no_controls(&refused);
    }
}

#[test]
fn names_in_a_gltf_are_spelled_out() {
    let folder = folder();
    let here = format!("data:application/octet-stream;base64,{}", "A".repeat(48));
    for uri in [EVIL, &here] {
        let asset = serde_json::json!({
            "asset": { "version": "2.0" },
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "name": EVIL, "primitives": [{ "attributes": { "POSITION": 0 } }] }],
            "accessors": [{ "name": EVIL, "componentType": 5126, "count": 3, "type": EVIL, "bufferView": 0 }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "buffers": [{ "uri": uri, "byteLength": 36 }],
        });
        fs::write(folder.path().join("a.gltf"), asset.to_string()).unwrap();
        for command in [&["info", "a.gltf"][..], &["simplify", "a.gltf", "-o", "b.glb", "--ratio", "1"]] {
            let refused = run(folder.path(), command);
            assert_eq!(refused.code, Some(1));
            check_escaped(&refused);
            error_line(&refused);
        }
    }
}

#[test]
fn names_of_files_are_spelled_out() {
    let folder = folder();
    let [good, bad] = ["obj", "ply"].map(|ending| format!("{EVIL}{LINES}\n.{ending}"));
    fs::write(folder.path().join(&good), OCTAHEDRON).unwrap();
    fs::write(folder.path().join(&bad), "ply").unwrap();
    for (command, code) in [
        (&["info", &good][..], 0),
        (&["info", &bad], 1),
        (&["compare", &good, &good], 0),
        (&["simplify", &bad, "-o", "b.ply", "--ratio", "0.5"], 1),
        (&["simplify", ".", "-o", "out", "--ratio", "1"], 1),
        (&["simplify", &good, "-o", &bad, "--ratio", "1", "--format", EVIL], 2),
    ] {
        let said = run(folder.path(), command);
        assert_eq!(said.code, Some(code), "{command:?}: {}", said.stderr);
        check_escaped(&said);
    }
    // Names as a shell pattern gives them.
    let refused = run(folder.path(), &["info", &good, &bad]);
    assert_eq!(refused.code, Some(1));
    check_escaped(&refused);
    // JSON uses its own reversible escapes.
    let told = run(folder.path(), &["info", &good, "--json"]);
    check_no_controls(&told);
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&told.stdout).unwrap()["file"], good);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_a_failure() {
    let folder = folder_with_octahedron();
    let cloud = test_mesh_path("suzanne.ply");
    for arguments in [
        &["info", "a.obj"][..],
        &["info", "a.obj", "--json"],
        &["simplify", "a.obj", "-o", "-", "--format", "obj", "--ratio", "1"],
        &["simplify", "a.obj", "-o", "b.obj", "--ratio", "1"],
        &["simplify", ".", "-o", "out", "--ratio", "1"],
        &["compare", "a.obj", "a.obj"],
        &["mesh-points", cloud.to_str().unwrap(), "-o", "c.obj"],
        &["--help"],
        &["--version"],
    ] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let run = finish(program(folder.path(), arguments).stdout(full).spawn().unwrap());
        assert_eq!(run.code, Some(1), "{arguments:?} {}", run.stderr);
        assert!(run.stderr.contains("standard output: "), "{arguments:?} {}", run.stderr);
    }
    // The mesh is in place before messages fail.
    assert_eq!(info(folder.path(), "b.obj")["vertices"], 6);
    assert_eq!(run(folder.path(), &["info", "a.obj"]).code, Some(0));
}

#[cfg(target_os = "linux")]
#[test]
fn a_closed_standard_output_is_a_failure() {
    let folder = folder_with_octahedron();
    let program = env!("CARGO_BIN_EXE_neural-mesh");
    let by_shell = |arguments: &str| {
        let mut shell = std::process::Command::new("sh");
        shell.current_dir(folder.path()).args(["-c", &format!("exec '{program}' {arguments}")]);
        let output = shell.output().unwrap();
        Run { code: output.status.code(), stdout: output.stdout, stderr: String::from_utf8(output.stderr).unwrap() }
    };
    for arguments in ["info a.obj", "info a.obj --json", "simplify a.obj -o - --format obj --ratio 1", "--version"] {
        let closed = by_shell(&format!("{arguments} >&-"));
        assert_eq!(closed.code, Some(1), "{arguments} {}", closed.stderr);
        assert!(error_line(&closed).contains("standard output: is closed: "), "{}", closed.stderr);
        for elsewhere in [">/dev/null", "<&- >/dev/null", "1<>/dev/null", ""] {
            assert_eq!(by_shell(&format!("{arguments} {elsewhere}")).code, Some(0), "{arguments} {elsewhere}");
        }
    }
    // Without messages, nothing can fail.
    assert_eq!(by_shell("simplify a.obj -o b.obj --ratio 1 --quiet >&-").code, Some(0));
}

#[test]
fn an_unread_standard_output_is_a_failure() {
    let folder = folder_with_octahedron();
    for arguments in [&["info", "a.obj"][..], &["info", "a.obj", "--json"], &["compare", "a.obj", "a.obj"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let run = finish(program(folder.path(), arguments).stdout(writer).spawn().unwrap());
        assert_eq!(run.code, Some(1), "{arguments:?}");
        assert!(error_line(&run).contains("standard output: "), "{}", run.stderr);
    }
}
