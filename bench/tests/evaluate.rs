//! `neural-mesh-bench evaluate`: rows, failures, resumed runs and the report.

use std::collections::BTreeMap;
use std::path::Path;

use crate::common::{self, *};
use crate::data_folder;
use neural_mesh::io::{Format, write};
use neural_mesh::mesh::{Frame, TriMesh, shapes};

fn ball() -> (&'static str, TriMesh) {
    ("ball.ply", shapes::icosphere(3))
}

fn evaluation<'a>(run: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let quick = ["evaluate", "--data", "data", "--out", run, "--repeat", "1", "--samples", "1000", "--threads", "1"];
    [&quick, more].concat()
}

/// A row by the names of its columns.
type Row = BTreeMap<String, String>;

fn rows(folder: &Path, run: &str) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(folder.join(run).join("rows.csv")).unwrap();
    let names = reader.headers().unwrap().clone();
    let row = |record: csv::StringRecord| names.iter().map(String::from).zip(record.iter().map(String::from)).collect();
    reader.records().map(|record| row(record.unwrap())).collect()
}

fn rows_without_times(folder: &Path, run: &str) -> Vec<Row> {
    let mut rows = rows(folder, run);
    assert!(rows.iter_mut().all(|row| row.remove("seconds").is_some()));
    rows
}

#[test]
fn every_case_has_its_row_with_sensible_figures() {
    let folder = data_folder(&[("wave.ply", shapes::wavy_sphere(4, 0.5)), ball()]);
    std::fs::write(folder.path().join("data/bad.ply"), "ply\nno mesh\n").unwrap();
    let more = ["--methods", "closed,qem,uniform-bpa,paper", "--ratios", "0.1,0.3"];
    let done = run(folder.path(), &evaluation("run", &more));
    assert_eq!((done.code, done.stderr.as_str()), (Some(0), ""));
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(said.contains("failed    bad.ply") && said.contains("report.md"), "{said}");
    let rows = rows(folder.path(), "run");
    assert_eq!(rows.len(), 3 * 2 * 4);
    let find = |mesh: &str, ratio: f64, method: &str| {
        let is_it = |row: &&Row| row["mesh"] == mesh && row["ratio"] == ratio.to_string() && row["method"] == method;
        rows.iter().find(is_it).unwrap()
    };
    for ratio in [0.1, 0.3] {
        let [ours, qem, drawn] = ["closed", "qem", "uniform-bpa"].map(|method| find("wave.ply", ratio, method));
        let number = |row: &Row, name: &str| row[name].parse::<f64>().unwrap();
        assert!(number(qem, "distance_mean") < number(drawn, "distance_mean"));
        assert!(number(ours, "seconds") > 0.0 && number(ours, "distance_mean") > 0.0);
        assert_eq!(qem["faces_asked"], ours["faces_out"]);
        assert!(number(qem, "faces_out") <= number(ours, "faces_out"));
        assert_eq!(number(ours, "vertices_in"), 2562.0);
        assert_eq!(number(ours, "vertices_out"), (2562.0 * ratio).floor());
        assert!(ours["machine"].ends_with(" cores"));
        assert!(find("bad.ply", ratio, "qem")["error"].starts_with("the input mesh: "));
    }
    let report = std::fs::read_to_string(folder.path().join("run/report.md")).unwrap();
    for words in
        ["| closed | 2 of 2 |", "| qem | 2 of 2 |", "| uniform-bpa |", "| paper |", "Relative to qem", "bad.ply"]
    {
        assert!(report.contains(words), "{words}: {report}");
    }
}

#[test]
fn a_method_that_crashes_is_a_row_with_its_error() {
    let folder = data_folder(&[ball()]);
    let tools = [
        "--tool",
        "crashes=sh -c 'echo alas >&2; kill -SEGV $$' {in} {out}",
        "--tool",
        "exits=sh -c 'echo first; echo alas; exit 3' {in} {out}",
        "--tool",
        "leaves=sh -c 'echo aside; echo gone >&2' {in} {out}",
        "--tool",
        "spoils=sh -c 'echo no mesh > $1' {in} {out}",
        "--tool",
        "lacks=no-such-program {in} {out}",
        "--tool",
        "copies=cp {in.obj} {out.obj}",
    ];
    let more = [&["--methods", "qem", "--ratios", "0.4"], &tools[..]].concat();
    succeed(folder.path(), &evaluation("run", &more));
    let rows = rows(folder.path(), "run");
    let error = |method: &str| {
        let row = rows.iter().find(|row| row["method"] == method).unwrap();
        row["error"].clone()
    };
    assert!(error("crashes").contains("crashed") && error("crashes").contains("alas"), "{}", error("crashes"));
    let cases = [
        ("exits", "ended with exit code 3: first alas"),
        ("leaves", "left no result: gone"),
        ("spoils", "the result: "),
        ("lacks", "no-such-program cannot be started"),
    ];
    for (method, words) in cases {
        assert!(error(method).contains(words), "{}", error(method));
    }
    let copy = rows.iter().find(|row| row["method"] == "copies").unwrap();
    assert_eq!((error("copies").as_str(), &copy["vertices_out"]), ("", &copy["vertices_in"]));
    assert_eq!(copy["whole_process"], "1");
}

#[test]
fn a_method_that_takes_too_long_is_stopped() {
    let folder = data_folder(&[ball()]);
    let began = std::time::Instant::now();
    let stopped = |run: &str, limit: &str, methods: &[&str]| {
        let more = [&["--ratios", "0.4", "--time-limit", limit], methods].concat();
        assert_eq!(common::run(folder.path(), &evaluation(run, &more)).code, Some(0));
        let rows = rows(folder.path(), run);
        assert!(rows.iter().all(|row| row["error"].contains(&format!("time limit of {limit} s"))), "{rows:?}");
        rows.len()
    };
    let hangs = "hangs=sh -c 'sleep 600; cp $0 $1' {in} {out}";
    assert_eq!(stopped("tool", "5", &["--methods", "hangs", "--tool", hangs]), 1);
    assert_eq!(stopped("ours", "0.000001", &["--methods", "closed,qem"]), 2);
    assert!(began.elapsed().as_secs() < 600);
}

#[test]
fn killed_and_resumed_it_has_the_same_rows_and_redoes_nothing() {
    let folder = data_folder(&[
        ball(),
        ("box.ply", shapes::cuboid([1.0, 2.0, 3.0], 6)),
        ("ring.ply", shapes::torus(24, 12, 2.0, 0.5)),
    ]);
    let tool = "counts=sh -c 'echo {ratio} >> log; cp $0 $1' {in} {out}";
    let more = ["--methods", "geometry,qem,counts", "--ratios", "0.2,0.4", "--seeds", "0,1", "--tool", tool];
    succeed(folder.path(), &evaluation("whole", &more));
    let log = folder.path().join("log");
    let n_runs = || n_lines(&log);
    assert_eq!(n_runs(), 12);
    std::fs::remove_file(&log).unwrap();
    let resuming = evaluation("killed", &[&more[..], &["--resume"]].concat());
    let mut n_killed = 0;
    // Each pair is a number of rows in the table, of 37, and milliseconds before the kill.
    let table = folder.path().join("killed/rows.csv");
    for (n_rows, milliseconds) in [(0, 20), (2, 0), (11, 9), (20, 3)] {
        let child = program(folder.path(), &resuming).spawn().unwrap();
        n_killed += usize::from(kill_after(child, milliseconds, || n_lines(&table) >= n_rows));
    }
    assert!(n_killed >= 2, "killed only {n_killed} times");
    succeed(folder.path(), &resuming);
    assert_eq!(rows_without_times(folder.path(), "killed"), rows_without_times(folder.path(), "whole"));
    assert!((12..=12 + n_killed).contains(&n_runs()), "{} runs", n_runs());
    let seen = || [&log, &table].map(|path| std::fs::read(path).unwrap());
    let before = seen();
    succeed(folder.path(), &resuming);
    assert_eq!(seen(), before);
}

#[test]
fn a_tool_ends_when_the_evaluation_is_killed() {
    let folder = data_folder(&[ball()]);
    let tool = "stays=sh -c 'sleep 6000 & echo $$ $! > ids; wait' {in} {out}";
    let more = ["--methods", "stays", "--ratios", "0.4", "--tool", tool];
    let mut child = program(folder.path(), &evaluation("run", &more)).spawn().unwrap();
    let ids = || std::fs::read_to_string(folder.path().join("ids")).unwrap_or_default();
    wait_until(|| ids().ends_with('\n') || child.try_wait().unwrap().is_some());
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(ids().split_whitespace().count(), 2);
    wait_until(|| !ids().split_whitespace().any(runs));
}

fn runs(id: &str) -> bool {
    let is_known = std::process::Command::new("kill").args(["-0", id]).output().unwrap().status.success();
    let status = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    // An ended process may be listed until its parent collects it.
    is_known && !status.contains(") Z")
}

#[test]
fn changes_of_a_tool_to_its_files_do_not_affect_others() {
    let folder = data_folder(&[ball()]);
    let tool =
        "spoils=sh -c 'echo $OMP_NUM_THREADS $RAYON_NUM_THREADS >> threads; cp $0 $1; echo rubbish > $0' {in} {out}";
    let more = ["--methods", "spoils,qem", "--ratios", "0.2,0.5", "--tool", tool];
    succeed(folder.path(), &evaluation("run", &more));
    let rows = rows(folder.path(), "run");
    assert!(rows.len() == 4 && rows.iter().all(|row| row["error"].is_empty()), "{rows:?}");
    assert_eq!(std::fs::read_to_string(folder.path().join("threads")).unwrap(), "1 1\n".repeat(2));
}

#[test]
fn ctrl_c_keeps_what_is_done() {
    let folder = data_folder(&[ball()]);
    let tool = "stays=sh -c 'test {ratio} != 0.4 || sleep 6000; cp $0 $1' {in} {out}";
    let more = ["--methods", "qem", "--ratios", "0.2,0.4", "--tool", tool];
    let child = program(folder.path(), &evaluation("run", &more)).spawn().unwrap();
    let table = folder.path().join("run/rows.csv");
    let stopped = interrupt_once(child, || n_lines(&table) >= 3);
    assert_eq!(stopped.code, Some(130), "{}", stopped.stderr);
    assert!(error_line(&stopped).contains("--resume"));
    assert_eq!(rows(folder.path(), "run").len(), 2);
}

#[test]
fn an_evaluation_writes_the_files_that_the_help_lists() {
    let folder = data_folder(&[ball()]);
    assert_eq!(run(folder.path(), &evaluation("run", &["--methods", "qem,meshopt", "--ratios", "0.5"])).code, Some(0));
    let expected = ["report.md", "rows.csv", "settings.json"];
    assert_eq!(files(&folder.path().join("run")), expected);
    let help = String::from_utf8(run(folder.path(), &["evaluate", "--help"]).stdout).unwrap();
    assert!(expected.iter().all(|name| help.contains(name)), "{help}");
    let path = folder.path().join("run/report.md");
    let report = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let again = run(folder.path(), &["evaluate", "--report", "run", "--relative-to", "qem", "-q"]);
    assert_eq!((again.code, again.stdout, again.stderr.as_str()), (Some(0), vec![], ""));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), report);
}

#[test]
fn refusals_say_what_to_do() {
    let folder = data_folder(&[ball()]);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let quick = |more: &[&'static str]| evaluation("run", &[&["--methods", "qem", "--ratios", "0.5"], more].concat());
    succeed(folder.path(), &quick(&[]));
    let refused = |code: i32, arguments: &[&str], words: &str| {
        let line = refuse(folder.path(), arguments, code);
        assert!(line.contains(words), "{line}");
    };
    refused(1, &quick(&[]), "--resume");
    refused(1, &quick(&["--resume", "--seeds", "1"]), "`seeds`");
    refused(1, &quick(&["--resume", "--time-limit", "5"]), "`time-limit`");
    refused(2, &evaluation("new", &["--methods", "qem,magic"]), "meshopt-update");
    refused(2, &evaluation("new", &["--ratios", "0.5,1.5"]), "1.5");
    refused(2, &evaluation("new", &["--tool", "mine=cp {in}"]), "{out}");
    refused(2, &evaluation("new", &["--methods", "qem", "--relative-to", "paper"]), "--methods");
    refused(1, &evaluation("new", &["--only", "cat"]), "cat");
    refused(1, &evaluation("new", &["--weights", "none.safetensors"]), "none.safetensors");
    refused(1, &evaluation("data", &[]), "ball.ply");
    refused(1, &["evaluate", "--data", "empty", "--out", "new"], "no mesh");
    refused(1, &["evaluate", "--data", "none", "--out", "new"], "none");
    refused(1, &["evaluate", "--report", "data"], "rows.csv");
    refused(2, &["evaluate", "--report", "run", "--relative-to", "paper"], "qem");
    assert!(!folder.path().join("new").exists());
    assert_eq!(run(folder.path(), &["evaluate", "--data", "data"]).code, Some(2));
    let other = write(&shapes::icosphere(2), &Frame::default(), Format::Ply).unwrap();
    std::fs::write(folder.path().join("data/ball.ply"), other).unwrap();
    refused(1, &quick(&["--resume"]), "ball.ply has changed");
}

#[test]
fn numbers_are_told_what_is_taken() {
    let folder = folder();
    for (option, value, words) in [
        ("--ratios", "0.5,2", "like 10%"),
        ("--ratios", "nan", "like 10%"),
        ("--seeds", "-1", "a whole number of at least 0"),
        ("--repeat", "0", "at least 1"),
        ("--time-limit", "-1", "seconds above 0"),
        ("--time-limit", "inf", "seconds above 0"),
        ("--samples", "0", "at least 1"),
        ("--threads", "0", "from 1 to 1024"),
    ] {
        let line = refuse(folder.path(), &["evaluate", "--data", "missing", "--out", "run", option, value], 2);
        assert!(line.contains(option) && line.contains(words), "{line}");
    }
}
