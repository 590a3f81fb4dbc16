//! Precision of numbers in the written file.

use crate::common::*;

fn positions(obj: &str) -> Vec<[f64; 3]> {
    let row = |line: &str| line.split(' ').skip(1).map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
    obj.lines().filter(|line| line.starts_with("v ")).map(|line| row(line).try_into().unwrap()).collect()
}

#[test]
fn an_stl_that_single_precision_cannot_hold_is_refused_with_what_can() {
    for offset in [3e6, 1e8] {
        let (folder, mesh) = (folder(), sphere(1, 12, [offset; 3], 1.0));
        for format in ["a.stl", "b.stl.gz"] {
            let run =
                run_with_input(folder.path(), &["simplify", "-", "-o", format, "--ratio", "0.5"], mesh.as_bytes());
            let line = error_line(&run);
            assert!(run.code == Some(1) && line.contains("write ply, obj or glb"), "{offset}: {line}");
            assert_eq!(files(folder.path()), Vec::<String>::new());
        }
        for format in ["a.ply", "b.obj", "c.off", "d.glb"] {
            let run =
                run_with_input(folder.path(), &["simplify", "-", "-o", format, "--ratio", "0.5"], mesh.as_bytes());
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            let info = info(folder.path(), format);
            assert_eq!((&info["closed"], &info["vertices"]), (&true.into(), &133.into()), "{offset}: {format}");
        }
    }
}

#[test]
fn an_stl_of_doubles_is_what_the_report_says() {
    let (folder, mesh) = (folder(), sphere(1, 12, [3e6; 3], 30.0));
    let arguments = ["simplify", "-", "-o", "a.stl", "--ratio", "0.5", "--report", "r.json"];
    let run = run_with_input(folder.path(), &arguments, mesh.as_bytes());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let (report, info) = (json(&folder.path().join("r.json")), info(folder.path(), "a.stl"));
    for figure in ["vertices", "faces", "closed", "components", "euler"] {
        assert_eq!(report["output"][figure], info[figure], "{figure}");
    }
    assert!(report["notes"].to_string().contains("vertices are rounded by up to"), "{}", report["notes"]);
}

#[test]
fn a_distance_counts_what_an_stl_rounds() {
    let (folder, mesh) = (folder(), sphere(1, 12, [3e6; 3], 30.0));
    let arguments = ["simplify", "-", "-o", "a.stl", "--error", "0.05"];
    let run = run_with_input(folder.path(), &arguments, mesh.as_bytes());
    assert!(run.code == Some(1) && error_line(&run).contains("rounds vertices by up to"), "{}", run.stderr);
    let arguments = ["simplify", "-", "-o", "a.stl", "--error", "3", "--report", "r.json"];
    let run = run_with_input(folder.path(), &arguments, mesh.as_bytes());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let upper = json(&folder.path().join("r.json"))["certified"]["upper"].as_f64().unwrap();
    assert!(upper > 0.2 && upper <= 3.0, "{upper}");
}

// Short decimals may be single precision, but a reader in double precision sees different numbers.
#[test]
fn locked_vertices_keep_every_bit_of_decimals() {
    let mut mesh = String::new();
    for (x, y) in (0..9).flat_map(|x| (0..9).map(move |y| (x, y))) {
        mesh += &format!("v {:?} {:?} {:?}\n", f64::from(x) / 10.0, f64::from(y) / 10.0, f64::from(x * y % 5) / 100.0);
    }
    for (x, y) in (0..8).flat_map(|x| (0..8).map(move |y| (x, y))) {
        let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| (x + i) * 9 + y + j + 1);
        mesh += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    let (folder, input) = (folder(), positions(&mesh));
    let run_as = |arguments: &[&str]| {
        let all = [&["simplify", "-", "--force", "--ratio", "0.6"], arguments].concat();
        let run = run_with_input(folder.path(), &all, mesh.as_bytes());
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    };
    // Each format, read again in double precision.
    for file in ["a.obj", "a.ply", "a.off"] {
        run_as(&["-o", file, "--lock-boundaries"]);
        succeed(folder.path(), &["simplify", file, "-o", "again.obj", "--ratio", "1", "--force"]);
        let found = positions(&std::fs::read_to_string(folder.path().join("again.obj")).unwrap());
        let boundary = input.iter().filter(|p| p[..2].iter().any(|x| *x == 0.0 || *x == 0.8));
        boundary.for_each(|p| assert!(found.contains(p), "{file}: {p:?}"));
    }
    run_as(&["-o", "b.obj", "--subset", "--lock-boundaries"]);
    let found = positions(&std::fs::read_to_string(folder.path().join("b.obj")).unwrap());
    assert!(found.iter().all(|p| input.contains(p)), "{found:?}");
}

// The coordinate -222256064 was once written as -222256060: equal in single precision, different in double.
#[test]
fn text_is_the_number_that_it_stands_for() {
    let mesh = "v 5264.966796875 -222256064.0 21.4942569732666\nv 5264.966796875 -222256064.0 21.9942569732666\n\
                v 5264.466796875 -222256064.0 21.4942569732666\nf 3 2 1\n";
    for file in ["a.obj", "a.off"] {
        let folder = folder();
        let run = run_with_input(folder.path(), &["simplify", "-", "-o", file, "--size", "9999"], mesh.as_bytes());
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let text = std::fs::read_to_string(folder.path().join(file)).unwrap();
        assert!(text.contains("5264.466796875 -222256064 21.494257\n"), "{text}");
    }
}

#[test]
fn components_that_single_precision_loses_are_refused() {
    let n = sphere(1, 12, [0.0; 3], 1.0).matches("v ").count();
    for (centre, is_held) in [([50.0, 0.0, 0.0], true), ([1e9, 0.0, 0.0], false)] {
        let mesh = sphere(1, 12, [0.0; 3], 1.0) + &sphere(n + 1, 12, centre, 1.0);
        let folder = folder();
        let run = run_with_input(folder.path(), &["simplify", "-", "-o", "a.ply", "--ratio", "0.5"], mesh.as_bytes());
        if is_held {
            assert_eq!((run.code, &info(folder.path(), "a.ply")["components"]), (Some(0), &2.into()));
            continue;
        }
        let line = error_line(&run);
        assert!(run.code == Some(1) && line.contains("as separate files"), "{line}");
        assert_eq!(files(folder.path()), Vec::<String>::new());
    }
}
