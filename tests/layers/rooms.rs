//! Upper bounds on the lines of Rust in each room of the repository.

use std::collections::BTreeMap;

use super::{Source, root, sources, start_of_tests};

const BOUNDS: &str = "tests/lines.csv";
/// Environment variable; `write` replaces the bounds by the present lines.
const WRITE_VARIABLE: &str = "NEURAL_MESH_LINES";

#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
struct Lines {
    code: usize,
    comments: usize,
    tests: usize,
}

// Counts the lines of a file that are not blank: all of a folder of tests are tests.
fn count(source: &Source) -> Lines {
    let is_tests = source.path.split('/').any(|folder| ["tests", "examples"].contains(&folder));
    let end = if is_tests { 0 } else { start_of_tests(&source.text) };
    let filled = |text: &str| text.lines().filter(|line| !line.trim().is_empty()).count();
    let (own, tests) = source.text.split_at(end);
    let comments = own.lines().filter(|line| line.trim_start().starts_with("//")).count();
    Lines { code: filled(own) - comments, comments, tests: filled(tests) }
}

// A module of the library, a crate beside it, or a package.
fn room(path: &str) -> String {
    let folders: Vec<&str> = path.split('/').collect();
    let n = match folders[0] {
        "crates" => 2,
        "src" if folders.len() > 2 => 2,
        _ => 1,
    };
    folders[..n].join("/").trim_end_matches(".rs").into()
}

fn present_lines() -> BTreeMap<String, Lines> {
    let packages =
        ["bench", "bevy", "c", "cli", "crates", "examples", "fuzz", "python", "src", "tests", "web", "xatlas"];
    let mut rooms = BTreeMap::<String, Lines>::new();
    for source in packages.into_iter().flat_map(sources) {
        let of_others = ["target/", "node_modules/", "vendor/"].iter().any(|folder| source.path.contains(folder));
        if of_others {
            continue;
        }
        let Lines { code, comments, tests } = count(&source);
        let lines = rooms.entry(room(&source.path)).or_default();
        lines.code += code;
        lines.comments += comments;
        lines.tests += tests;
    }
    rooms
}

fn write(rooms: &BTreeMap<String, Lines>) -> String {
    let row = |(room, lines): (&String, &Lines)| format!("{room},{},{},{}\n", lines.code, lines.comments, lines.tests);
    "room,code,comments,tests\n".to_string() + &rooms.iter().map(row).collect::<String>()
}

fn read(text: &str) -> BTreeMap<String, Lines> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let [code, comments, tests] = [1, 2, 3].map(|column: usize| cells[column].parse().unwrap());
        (cells[0].to_string(), Lines { code, comments, tests })
    };
    text.lines().skip(1).map(row).collect()
}

// Lists what is above its bound. A room without bounds is too large with any line.
fn excesses(present: &BTreeMap<String, Lines>, bounds: &BTreeMap<String, Lines>) -> Vec<String> {
    let mut above = Vec::new();
    for (room, lines) in present {
        let bound = bounds.get(room).copied().unwrap_or_default();
        let kinds = [
            ("code", lines.code, bound.code),
            ("comments", lines.comments, bound.comments),
            ("tests", lines.tests, bound.tests),
        ];
        let larger = kinds.into_iter().filter(|(_, present, bound)| present > bound);
        above
            .extend(larger.map(|(kind, present, bound)| format!("{room}: {present} lines of {kind}, at most {bound}")));
    }
    above
}

#[test]
fn no_room_has_more_lines_than_its_bounds() {
    let present = present_lines();
    let path = root().join(BOUNDS);
    if std::env::var(WRITE_VARIABLE).is_ok_and(|word| word == "write") {
        std::fs::write(&path, write(&present)).unwrap();
    }
    let above = excesses(&present, &read(&std::fs::read_to_string(&path).unwrap()));
    assert!(
        above.is_empty(),
        "{above:#?}\nmake them fewer, or write the bounds with {WRITE_VARIABLE}=write and say why in the commit"
    );
}

#[test]
fn a_line_more_is_an_excess() {
    let rooms = |code| BTreeMap::from([("crates/mesh".to_string(), Lines { code, comments: 2, tests: 3 })]);
    assert_eq!(read(&write(&rooms(5))), rooms(5));
    assert!(excesses(&rooms(5), &rooms(5)).is_empty());
    assert_eq!(excesses(&rooms(6), &rooms(5)), ["crates/mesh: 6 lines of code, at most 5"]);
    assert_eq!(excesses(&rooms(6), &BTreeMap::new()).len(), 3);
}
