//! `neural-mesh compare`: table, JSON, page, rejected arguments.

use std::fs;
use std::path::Path;

use crate::common::*;

fn folder_of_octahedra() -> tempfile::TempDir {
    let folder = folder();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("a.obj", OCTAHEDRON);
    write("open.obj", OCTAHEDRON.strip_suffix("f 1 4 6\n").unwrap());
    write("large.obj", &OCTAHEDRON.replace(" 1 0", " 2 0").replace(" -1 0", " -2 0"));
    folder
}

fn words(run: &Run) -> String {
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    String::from_utf8(run.stdout.clone()).unwrap()
}

fn compare(folder: &Path, arguments: &[&str]) -> Run {
    run(folder, &[&["compare"], arguments, &["--samples", "500"]].concat())
}

#[test]
fn a_table_has_a_row_per_figure_and_a_column_per_result() {
    let folder = folder_of_octahedra();
    let table = words(&compare(folder.path(), &["a.obj", "a.obj", "open.obj"]));
    let row = |name: &str| {
        let line = table.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}: {table}"));
        line.split_whitespace().map(String::from).collect::<Vec<_>>()
    };
    assert!(table.starts_with("original  a.obj: 6 vertices, 8 faces"), "{table}");
    assert_eq!(row("faces "), ["faces", "faces", "8", "7"]);
    assert_eq!(row("boundary edges"), ["boundary", "edges", "edges", "0", "3"]);
    assert!(row("distance mean").starts_with(&["distance".into(), "mean".into(), "%".into()]));
    assert_eq!(files(folder.path()), ["a.obj", "large.obj", "open.obj"]);
}

#[test]
fn eleven_figures_are_shown_and_the_others_where_they_are_asked_for() {
    let folder = folder_of_octahedra();
    let n_rows = |more: &[&str]| {
        let table = words(&compare(folder.path(), &[&["a.obj", "large.obj"], more].concat()));
        let rows: Vec<String> =
            table.lines().skip_while(|line| !line.starts_with("figure")).skip(1).map(String::from).collect();
        assert!(rows.iter().all(|row| !row.ends_with(" -")), "{table}");
        rows.len()
    };
    assert_eq!(n_rows(&[]), 11);
    assert!(n_rows(&["--all"]) > 20);
}

#[test]
fn the_json_holds_every_figure_with_its_unit_for_every_result() {
    let folder = folder_of_octahedra();
    let run = compare(folder.path(), &["a.obj", "a.obj", "open.obj", "--json", "a.json", "--quiet"]);
    assert_eq!(words(&run), "");
    let json = json(&folder.path().join("a.json"));
    let figures = json["figures"].as_array().unwrap();
    let results = json["results"].as_array().unwrap();
    assert!(figures.len() > 10 && results.len() == 2);
    for figure in figures {
        assert!(figure["unit"].is_string() && figure["about"].as_str().unwrap().len() > 5, "{figure}");
        for result in results {
            assert!(result["values"].get(figure["name"].as_str().unwrap()).is_some(), "{figure}");
        }
    }
    assert_eq!(results[1]["name"], "open.obj");
    assert_eq!(results[1]["values"]["boundary_edges"], 3.0);
    assert_eq!(json["settings"]["samples"], 500);
}

#[test]
fn a_result_that_cannot_be_read_is_left_out() {
    let folder = folder_of_octahedra();
    fs::write(folder.path().join("bad.ply"), "ply").unwrap();
    let run = compare(folder.path(), &["a.obj", "bad.ply", "open.obj", "missing.ply", "--json", "a.json"]);
    assert_eq!((run.code, run.stderr.lines().count()), (Some(1), 2), "{}", run.stderr);
    assert!(run.stderr.contains("neural-mesh: bad.ply: ") && run.stderr.contains("neural-mesh: missing.ply: "));
    assert!(String::from_utf8(run.stdout).unwrap().contains("open.obj"));
    let results = json(&folder.path().join("a.json"))["results"].clone();
    assert_eq!((results.as_array().unwrap().len(), &results[0]["name"]), (1, &"open.obj".into()));
    for meshes in [["a.obj", "bad.ply"], ["bad.ply", "a.obj"]] {
        let run = compare(folder.path(), &meshes);
        assert_eq!((run.code, run.stdout.len()), (Some(1), 0));
        assert!(error_line(&run).contains("bad.ply"), "{}", run.stderr);
    }
}

#[test]
fn the_figures_are_the_same_on_any_number_of_threads() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    let spot = spot.to_str().unwrap();
    let suzanne = test_mesh_path("suzanne.ply");
    let both = [spot, suzanne.to_str().unwrap()];
    for threads in ["1", "3"] {
        let (json, html) = (format!("{threads}.json"), format!("{threads}.html"));
        let arguments = [&both[..], &["--threads", threads, "--json", &json, "--html", &html]].concat();
        words(&compare(folder.path(), &arguments));
    }
    for ending in ["json", "html"] {
        let [one, three] = ["1", "3"].map(|n| fs::read(folder.path().join(format!("{n}.{ending}"))).unwrap());
        assert!(one == three, "{ending}");
    }
}

#[test]
fn meshes_far_from_the_origin_are_compared_where_they_are() {
    let folder = folder();
    let moved = |by: f64| format!("v {} 0 0\nv {} 0 0\nv {by} 1 0\nf 1 2 3\n", by, by + 1.0);
    fs::write(folder.path().join("a.obj"), moved(5_000_000.125)).unwrap();
    fs::write(folder.path().join("b.obj"), moved(5_000_000.375)).unwrap();
    words(&compare(folder.path(), &["a.obj", "b.obj", "--json", "a.json"]));
    let values = json(&folder.path().join("a.json"))["results"][0]["values"].clone();
    // A quarter of the side 1 of a triangle with diagonal sqrt(2).
    let largest = values["distance_max"].as_f64().unwrap();
    assert!(largest > 12.0 && largest < 17.7, "{largest}");
}

#[test]
fn the_page_holds_all_meshes_and_names() {
    let folder = folder_of_octahedra();
    fs::copy(folder.path().join("open.obj"), folder.path().join("<b>&.obj")).unwrap();
    words(&compare(folder.path(), &["a.obj", "<b>&.obj", "large.obj", "--html", "a.html"]));
    let page = fs::read_to_string(folder.path().join("a.html")).unwrap();
    assert_eq!(page.matches(" id=\"comparison\">").count(), 1);
    for name in ["surface-0", "surface-1", "distances-1", "surface-2", "distances-2"] {
        assert_eq!(page.matches(&format!(" data-of=\"{name}\">")).count(), 1, "{name}");
    }
    assert!(page.contains("\\u003cb>&.obj") && !page.contains("<b>&"));
    assert!(page.contains("<title>a.obj"));
}

#[test]
fn malformed_arguments_are_usage_errors() {
    let folder = folder_of_octahedra();
    for bad in [
        &["a.obj"][..],
        &["-", "-"],
        &["a.obj", "missing.obj", "--samples", "0"],
        &["a.obj", "missing.obj", "--threads", "0"],
        &["a.obj", "missing.obj", "--html", "-"],
        &["a.obj", "missing.obj", "--html", "x", "--json", "x"],
        &["a.obj", "missing.obj", "--nonsense"],
    ] {
        let run = run(folder.path(), &[&["compare"], bad].concat());
        assert_eq!(run.code, Some(2), "{bad:?}: {}", run.stderr);
    }
}

#[test]
fn bad_input_and_taken_places_leave_nothing() {
    let folder = folder_of_octahedra();
    fs::write(folder.path().join("bad.obj"), "v 0 0 0\n").unwrap();
    fs::write(folder.path().join("taken.html"), "mine").unwrap();
    let before = files(folder.path());
    for bad in [
        &["missing.obj", "a.obj", "--html", "a.html"][..],
        &["a.obj", "bad.obj", "--html", "a.html", "--json", "a.json"],
        &["a.obj", "a.obj", "--html", "taken.html", "--json", "a.json"],
        &["a.obj", "a.obj", "--html", "none/a.html"],
    ] {
        let run = compare(folder.path(), bad);
        assert_eq!(run.code, Some(1), "{bad:?}");
        error_line(&run);
        assert_eq!(files(folder.path()), before, "{bad:?}");
    }
    words(&compare(folder.path(), &["a.obj", "a.obj", "--html", "taken.html", "--force"]));
    assert_ne!(fs::read(folder.path().join("taken.html")).unwrap(), b"mine");
}

#[test]
fn one_mesh_may_come_from_standard_input() {
    let folder = folder_of_octahedra();
    let run = run_with_input(folder.path(), &["compare", "a.obj", "-"], OCTAHEDRON.as_bytes());
    assert!(words(&run).contains("standard input"));
}
