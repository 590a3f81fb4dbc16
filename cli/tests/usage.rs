//! Wrong arguments are rejected before any file is opened.

use crate::common::*;

fn simplify_missing(arguments: &[&str]) -> Run {
    let folder = folder();
    let run = run(folder.path(), &[&["simplify", "missing.ply"], arguments].concat());
    assert_eq!(files(folder.path()), Vec::<String>::new());
    run
}

#[test]
fn sizes_that_are_none_are_usage_errors() {
    for ratio in ["0", "-0.1", "1.0001", "7", "nan", "inf", "-inf"] {
        let run = simplify_missing(&["-o", "a.ply", "--ratio", ratio]);
        assert_eq!(run.code, Some(2), "{ratio}");
        assert!(error_line(&run).contains("--ratio"), "{ratio}");
    }
    for option in ["--vertices", "--faces"] {
        assert_eq!(simplify_missing(&["-o", "a.ply", option, "0"]).code, Some(2));
        assert_eq!(simplify_missing(&["-o", "a.ply", option, "many"]).code, Some(2));
    }
    assert_eq!(simplify_missing(&["-o", "a.ply"]).code, Some(2));
    assert_eq!(simplify_missing(&["-o", "a.ply", "--ratio", "0.5", "--faces", "10"]).code, Some(2));
}

#[test]
fn scores_from_the_geometry_ask_no_network_and_say_why() {
    for (network, reason) in [(["--assembly", "paper"], "--assembly closed"), (["--weights", "w"], "--weights")] {
        let run =
            simplify_missing(&[&["-o", "a.ply", "--ratio", "0.5", "--scores", "geometry"][..], &network].concat());
        assert_eq!(run.code, Some(2));
        let line = error_line(&run);
        assert!(line.contains("--scores geometry") && line.contains(reason), "{line}");
    }
}

#[test]
fn the_mean_asks_no_network_and_the_paper_has_no_choice() {
    let optimize =
        |rest: &[&str]| simplify_missing(&[&["-o", "a.ply", "--ratio", "0.5", "--optimize"][..], rest].concat());
    for (rest, reason) in [(["mean", "--weights", "w"], "--weights"), (["max", "--assembly", "paper"], "leave one out")]
    {
        let run = optimize(&rest);
        assert_eq!(run.code, Some(2));
        let line = error_line(&run);
        assert!(line.contains("--optimize") && line.contains(reason), "{line}");
    }
    assert_eq!(optimize(&["all"]).code, Some(2));
}

#[test]
fn other_settings_are_checked_too() {
    for bad in [
        &["--threads", "0"][..],
        &["--threads", "100000"],
        &["--format", "doc"],
        &["--report", "a.ply"],
        &["--picture", "-"],
        &["--view", "front"],
        &["--picture", "a.png", "--view", "up"],
        &["--picture", "a.png", "--view", "30"],
        &["--map", "-"],
        &["--json", "--report", "a.json"],
        &["--scores", "none"],
        &["--seed", "-1"],
        &["--error", "0.5%"],
        &["--crease-angle", "200"],
        &["--map", "a.ply"],
        &["--importance", "x", "--assembly", "paper"],
        &["--close"],
        &["--nonsense"],
    ] {
        let run = simplify_missing(&[&["-o", "a.ply", "--ratio", "0.5"], bad].concat());
        assert_eq!(run.code, Some(2), "{bad:?}: {}", run.stderr);
    }
}

#[test]
fn the_output_format_has_to_be_known() {
    assert_eq!(simplify_missing(&["-o", "a.xyz", "--ratio", "0.5"]).code, Some(2));
    assert_eq!(simplify_missing(&["-o", "-", "--ratio", "0.5"]).code, Some(1));
    assert_eq!(simplify_missing(&["-o", "a.xyz", "--format", "obj", "--ratio", "0.5"]).code, Some(1));
}

#[test]
fn a_format_other_than_that_of_the_output_name_is_refused() {
    let folder = folder_with_octahedron();
    std::fs::write(folder.path().join("a.dat"), OCTAHEDRON).unwrap();
    let with_format = |input: &str, output: &str, format: &str| {
        run(folder.path(), &["simplify", input, "-o", output, "--ratio", "1", "--force", "--format", format])
    };
    let refused = with_format("a.obj", "b.obj", "stl");
    assert_eq!((refused.code, files(folder.path())), (Some(2), vec!["a.dat".to_string(), "a.obj".to_string()]));
    assert!(
        error_line(&refused).contains("b.obj: --format stl: the name ends in another format"),
        "{}",
        refused.stderr
    );
    // A variant of the format in the name, and the format of an input that shows none, are accepted.
    for (input, output, format) in
        [("a.obj", "b.stl", "stl-ascii"), ("a.dat", "b.ply", "obj"), ("a.obj", "b.ply", "obj")]
    {
        let accepted = with_format(input, output, format);
        assert_eq!(accepted.code, Some(0), "{}", accepted.stderr);
    }
    let cloud = run(folder.path(), &["mesh-points", "a.obj", "-o", "c.ply", "--format", "stl"]);
    assert_eq!(cloud.code, Some(2), "{}", cloud.stderr);
}

#[test]
fn sizes_of_other_kinds_are_checked_as_well() {
    for bad in [
        &["--error", "-1"][..],
        &["--error", "much"],
        &["--error", "nan%"],
        &["--size", "0"],
        &["--size", "2 elephants"],
        &["--lods", "0.1,0.5"],
        &["--lods", "0.5,0"],
        &["--lods", "0.5,0.2", "--assembly", "paper"],
    ] {
        let run = simplify_missing(&[&["-o", "a.ply"], bad].concat());
        assert_eq!(run.code, Some(2), "{bad:?}: {}", run.stderr);
    }
}

#[test]
fn help_fits_on_two_screens_and_help_all_shows_every_option() {
    let folder = folder();
    let help = |option| {
        let help = succeed(folder.path(), &["simplify", option]);
        String::from_utf8(help.stdout).unwrap()
    };
    let (short, all) = (help("--help"), help("--help-all"));
    assert!(short.lines().count() <= 100 && short.lines().all(|line| line.chars().count() <= 100), "{short}");
    for option in ["--ratio", "--faces", "--error", "--keep-features", "--textures", "--report", "--help-all"] {
        assert!(short.contains(option) && all.contains(option), "{option}");
    }
    for option in ["--crease-angle", "--assembly", "--no-check", "--map", "--hidden"] {
        assert!(!short.contains(option) && all.contains(option), "{option}");
    }
    let words = all.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("the small network that ships with the program"), "{words}");
    assert!(words.contains("a formula gives more where the surface bends"), "{words}");
    assert_eq!(run(folder.path(), &["--version"]).code, Some(0));
    assert_eq!(run(folder.path(), &[]).code, Some(2));
}
