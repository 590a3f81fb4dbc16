//! `neural-mesh-bench evaluate`: rows, failures, resumed runs and output files.

use std::path::Path;

use crate::common::{self, *};
use neural_mesh::io::{Format, write};
use neural_mesh::mesh::{Frame, TriMesh, shapes};
use serde_json::Value;

fn data_folder(meshes: &[(&str, TriMesh)]) -> tempfile::TempDir {
    let folder = folder();
    std::fs::create_dir(folder.path().join("data")).unwrap();
    for (name, mesh) in meshes {
        let bytes = write(mesh, &Frame::default(), Format::Ply).unwrap();
        std::fs::write(folder.path().join("data").join(name), bytes).unwrap();
    }
    folder
}

fn ball() -> (&'static str, TriMesh) {
    ("ball.ply", shapes::icosphere(3))
}

fn evaluation<'a>(run: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let quick = ["evaluate", "--data", "data", "--out", run, "--repeat", "1", "--samples", "1000", "--threads", "1"];
    [&quick, more].concat()
}

fn rows(folder: &Path, run: &str) -> Vec<Value> {
    json(&folder.join(run).join("rows.json")).as_array().unwrap().clone()
}

fn rows_without_times(folder: &Path, run: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join(run).join("rows.csv")).unwrap();
    let rows = text.lines().map(|line| line.split(',').map(String::from).collect::<Vec<_>>());
    let mut rows: Vec<Vec<String>> = rows.collect();
    assert_eq!(rows[0][11], "seconds");
    rows.iter_mut().for_each(|row| drop(row.remove(11)));
    rows
}

#[test]
fn every_case_has_its_row_with_sensible_figures() {
    let folder = data_folder(&[("wave.ply", shapes::wavy_sphere(4, 0.5)), ball()]);
    std::fs::write(folder.path().join("data/bad.ply"), "ply\nno mesh\n").unwrap();
    let more = ["--methods", "closed,qem,clustering,paper", "--ratios", "0.1,0.3"];
    let done = run(folder.path(), &evaluation("run", &more));
    assert_eq!((done.code, done.stderr.as_str()), (Some(0), ""));
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(said.contains("failed    bad.ply") && said.contains("tables.md"), "{said}");
    let rows = rows(folder.path(), "run");
    assert_eq!(rows.len(), 3 * 2 * 4);
    let find = |mesh: &str, ratio: f64, method: &str| {
        let is_it = |row: &&Value| row["mesh"] == mesh && row["ratio"] == ratio && row["method"] == method;
        rows.iter().find(is_it).unwrap()
    };
    for ratio in [0.1, 0.3] {
        let [ours, qem, clustering] = ["closed", "qem", "clustering"].map(|method| find("wave.ply", ratio, method));
        let number = |row: &Value, name: &str| row[name].as_f64().unwrap();
        assert!(number(qem, "distance_mean") < number(clustering, "distance_mean"));
        assert!(number(ours, "seconds") > 0.0 && number(ours, "distance_mean") > 0.0);
        assert_eq!(qem["faces_asked"], ours["faces_out"]);
        assert!(qem["faces_out"].as_u64() <= ours["faces_out"].as_u64());
        assert_eq!(ours["vertices_in"], 2562);
        assert_eq!(ours["vertices_out"], (2562.0 * ratio) as u64);
        assert!(ours["version"].is_string() && ours["cpu"].is_string() && ours["cores"].as_u64() > Some(0));
        assert!(find("bad.ply", ratio, "qem")["error"].as_str().unwrap().starts_with("the input mesh: "));
    }
    let tables = std::fs::read_to_string(folder.path().join("run/tables.md")).unwrap();
    for words in
        ["| closed | 2 of 2 |", "| qem | 2 of 2 |", "| clustering |", "| paper |", "Relative to qem", "bad.ply"]
    {
        assert!(tables.contains(words), "{words}: {tables}");
    }
}

#[test]
fn a_method_that_crashes_is_a_row_with_its_error() {
    let folder = data_folder(&[ball()]);
    let tools = [
        "--tool",
        "crashes=sh -c 'test {ratio} = 0.5 && exec cp $0 $1; echo alas >&2; kill -SEGV $$' {in} {out}",
        "--tool",
        "leaves=sh -c 'test {ratio} = 0.4 || cp $0 $1' {in} {out}",
        "--tool",
        "copies=cp {in.obj} {out.obj}",
    ];
    let more = [&["--methods", "qem", "--ratios", "0.4"], &tools[..]].concat();
    let done = run(folder.path(), &evaluation("run", &more));
    assert_eq!(done.code, Some(0), "{}", done.stderr);
    let rows = rows(folder.path(), "run");
    let error = |method: &str| {
        let row = rows.iter().find(|row| row["method"] == method).unwrap();
        row["error"].as_str().unwrap().to_string()
    };
    assert!(error("crashes").contains("crashed") && error("crashes").contains("alas"), "{}", error("crashes"));
    assert_eq!((error("leaves").as_str(), error("copies").as_str()), ("left no result", ""));
    let copy = rows.iter().find(|row| row["method"] == "copies").unwrap();
    assert_eq!((&copy["vertices_out"], &copy["timed"]), (&copy["vertices_in"], &"process".into()));
}

#[test]
fn a_method_that_takes_too_long_is_stopped() {
    let folder = data_folder(&[ball()]);
    let began = std::time::Instant::now();
    let stopped = |run: &str, limit: &str, methods: &[&str]| {
        let more = [&["--ratios", "0.4", "--time-limit", limit], methods].concat();
        assert_eq!(common::run(folder.path(), &evaluation(run, &more)).code, Some(0));
        let rows = rows(folder.path(), run);
        let error = |row: &Value| row["error"].as_str().unwrap().to_string();
        assert!(rows.iter().all(|row| error(row).contains(&format!("time limit of {limit} s"))), "{rows:?}");
        rows.len()
    };
    let hangs = "hangs=sh -c 'test {ratio} = 0.4 && sleep 600; cp $0 $1' {in} {out}";
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
    let whole = run(folder.path(), &evaluation("whole", &more));
    assert_eq!(whole.code, Some(0), "{}", whole.stderr);
    let log = folder.path().join("log");
    // Each evaluation with work to do first tries the tool at 0.5.
    let n_runs = || std::fs::read_to_string(&log).unwrap().lines().filter(|ratio| *ratio != "0.5").count();
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
    let finished = run(folder.path(), &resuming);
    assert_eq!(finished.code, Some(0), "{}", finished.stderr);
    assert_eq!(rows_without_times(folder.path(), "killed"), rows_without_times(folder.path(), "whole"));
    let worst = |run: &str| {
        let kept = folder.path().join(run).join("worst");
        files(&kept).into_iter().map(|name| (std::fs::read(kept.join(&name)).unwrap(), name)).collect::<Vec<_>>()
    };
    assert!(worst("killed") == worst("whole") && worst("whole").len() > 9, "{:?}", worst("killed").len());
    assert!((12..=12 + n_killed).contains(&n_runs()), "{} runs", n_runs());
    let seen = || [&log, &table].map(|path| std::fs::read(path).unwrap());
    let before = seen();
    assert_eq!(run(folder.path(), &resuming).code, Some(0));
    assert_eq!(seen(), before);
}

#[test]
fn a_tool_ends_when_the_evaluation_is_killed() {
    let folder = data_folder(&[ball()]);
    let tool = "stays=sh -c 'test {ratio} = 0.5 && exec cp $0 $1; sleep 6000 & echo $$ $! > ids; wait' {in} {out}";
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
    let tool = "spoils=sh -c 'echo $OMP_NUM_THREADS >> threads; cp $0 $1; echo rubbish > $0' {in} {out}";
    let more = ["--methods", "spoils,qem", "--ratios", "0.2,0.5", "--tool", tool];
    let done = run(folder.path(), &evaluation("run", &more));
    assert_eq!(done.code, Some(0), "{}", done.stderr);
    let rows = rows(folder.path(), "run");
    assert!(rows.len() == 4 && rows.iter().all(|row| row["error"] == ""), "{rows:?}");
    assert_eq!(std::fs::read_to_string(folder.path().join("threads")).unwrap(), "1\n".repeat(3));
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
    let expected = [
        "error-size.svg",
        "error-time.svg",
        "report.html",
        "rows.csv",
        "rows.json",
        "settings.json",
        "tables.md",
        "time-size.svg",
        "worst",
    ];
    assert_eq!(files(&folder.path().join("run")), expected);
    let help = String::from_utf8(run(folder.path(), &["evaluate", "--help"]).stdout).unwrap();
    assert!(expected.iter().all(|name| help.contains(name)), "{help}");
    let tables = std::fs::read_to_string(folder.path().join("run/tables.md")).unwrap();
    expected.iter().filter(|name| !["rows.csv", "settings.json", "worst"].contains(name)).for_each(|name| {
        std::fs::remove_file(folder.path().join("run").join(name)).unwrap();
    });
    let report = run(folder.path(), &["evaluate", "--report", "run", "--relative-to", "qem", "-q"]);
    assert_eq!((report.code, report.stdout, report.stderr.as_str()), (Some(0), vec![], ""));
    assert_eq!(std::fs::read_to_string(folder.path().join("run/tables.md")).unwrap(), tables);
    assert_eq!(files(&folder.path().join("run")), expected);
}

#[test]
fn a_wrong_tool_is_said_before_anything_runs() {
    let folder = data_folder(&[ball()]);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let good = "log=sh -c 'echo run >> log; cp $0 $1' {in} {out}";
    let cases = [
        ("wrong=no-such-program {in} {out}", "no-such-program cannot be started"),
        ("wrong=sh -c 'echo first; echo alas; exit 3' {in} {out}", "ended with exit code 3: first alas"),
        ("wrong=sh -c 'echo aside; echo alas >&2' {in} {out}", "left no result: alas"),
        ("wrong=sh -c 'echo no mesh > $1' {in} {out}", "the result: "),
    ];
    for (tool, words) in cases {
        for run_folder in ["new", "empty"] {
            let more = ["--methods", "qem", "--ratios", "0.5", "--tool", good, "--tool", tool];
            let refusal = run(folder.path(), &evaluation(run_folder, &more));
            let line = error_line(&refusal);
            assert_eq!(refusal.code, Some(1), "{line}");
            assert!(
                line.contains("tool wrong: ") && line.contains(words) && line.ends_with("correct its command"),
                "{line}"
            );
        }
        assert!(!folder.path().join("new").exists() && files(&folder.path().join("empty")).is_empty());
    }
    // Only the other tool was tried.
    assert_eq!(n_lines(&folder.path().join("log")), 2 * cases.len());
}

#[test]
fn a_corrected_tool_is_measured_again_and_nothing_else() {
    let folder = data_folder(&[ball(), ("box.ply", shapes::cuboid([1.0, 2.0, 3.0], 6))]);
    std::fs::write(folder.path().join("data/bad.ply"), "ply\nno mesh\n").unwrap();
    let tools = |command: &str| {
        let other = "other=sh -c 'echo run >> log; cp $0 $1' {in} {out}".to_string();
        [other, format!("mine={command}")].map(|tool| ["--tool".to_string(), tool]).concat()
    };
    let evaluated = |command: &str, more: &[&str]| {
        let tools = tools(command);
        let tools = tools.iter().map(String::as_str);
        let more: Vec<&str> =
            ["--methods", "qem", "--ratios", "0.4"].into_iter().chain(tools).chain(more.iter().copied()).collect();
        run(folder.path(), &evaluation("run", &more))
    };
    let fails = "sh -c 'test {ratio} = 0.5 && exec cp $0 $1; exit 4' {in} {out}";
    assert_eq!(evaluated(fails, &[]).code, Some(0));
    let [before, log] = ["run/rows.csv", "log"].map(|name| std::fs::read_to_string(folder.path().join(name)).unwrap());
    assert_eq!(before.matches("exit code 4").count(), 2);
    // A wrong command leaves everything unchanged.
    assert_eq!(evaluated("sh -c 'exit 5' {in} {out}", &["--resume"]).code, Some(1));
    assert_eq!(std::fs::read_to_string(folder.path().join("run/rows.csv")).unwrap(), before);
    let done = evaluated("cp {in} {out}", &["--resume"]);
    assert_eq!(done.code, Some(0), "{}", done.stderr);
    let after = std::fs::read_to_string(folder.path().join("run/rows.csv")).unwrap();
    let stays = |line: &&str| !line.contains("exit code 4");
    let kept: Vec<&str> = before.lines().filter(stays).collect();
    assert_eq!(after.lines().take(kept.len()).collect::<Vec<_>>(), kept);
    let rows = rows(folder.path(), "run");
    let mine: Vec<&Value> = rows.iter().filter(|row| row["method"] == "mine").collect();
    assert_eq!((rows.len(), mine.iter().filter(|row| row["error"] == "").count(), mine.len()), (9, 2, 3));
    assert_eq!(std::fs::read_to_string(folder.path().join("log")).unwrap(), log, "the other tool had nothing to do");
    // Now the tool has results of its command.
    let refused = evaluated(fails, &["--resume"]);
    let line = error_line(&refused);
    assert!(
        refused.code == Some(1)
            && line.contains("the tool mine already has results of another command, `cp {in} {out}`"),
        "{line}"
    );
    assert_eq!(evaluated("cp {in} {out}", &["--resume"]).code, Some(0));
}

#[test]
fn refusals_say_what_to_do() {
    let folder = data_folder(&[ball()]);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let quick = |more: &[&'static str]| evaluation("run", &[&["--methods", "qem", "--ratios", "0.5"], more].concat());
    assert_eq!(run(folder.path(), &quick(&[])).code, Some(0));
    let refused = |code: i32, arguments: &[&str], words: &str| {
        let refusal = run(folder.path(), arguments);
        assert_eq!(refusal.code, Some(code), "{}", refusal.stderr);
        let line = error_line(&refusal);
        assert!(line.contains(words), "{line}");
    };
    refused(1, &quick(&[]), "--resume");
    refused(1, &quick(&["--resume", "--seeds", "1"]), "`seeds`");
    refused(1, &quick(&["--resume", "--time-limit", "5"]), "`time-limit`");
    refused(2, &evaluation("new", &["--methods", "qem,magic"]), "meshopt-sloppy");
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
        ("--seeds", "-1", "a whole number of at least 0"),
        ("--repeat", "0", "at least 1"),
        ("--time-limit", "-1", "seconds above 0"),
        ("--samples", "0", "at least 1"),
        ("--threads", "0", "from 1 to 1024"),
    ] {
        let refused = run(folder.path(), &["evaluate", "--data", "missing", "--out", "run", option, value]);
        let line = error_line(&refused);
        assert!(refused.code == Some(2) && line.contains(option) && line.contains(words), "{line}");
    }
}
