//! Checks of `ARCHITECTURE.md` against the code.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use neural_mesh::mesh::TriMesh;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

mod circles;
mod lengths;
mod rooms;

pub struct Source {
    // Path from the root of the repository, with `/` as separator.
    pub path: String,
    pub text: String,
    // Code without comments and tests.
    pub code: String,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn sources(folder: &str) -> Vec<Source> {
    let mut files = Vec::new();
    collect(&root().join(folder), &mut files);
    files.sort();
    files.iter().map(|path| source(path)).collect()
}

/// Lists the folders of the library: its own `src`, and that of each crate it consists of.
pub fn library_folders() -> Vec<String> {
    let crates = std::fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().file_name());
    let mut folders: Vec<String> = crates.map(|name| format!("crates/{}/src", name.to_str().unwrap())).collect();
    folders.sort();
    folders.insert(0, "src".into());
    folders
}

/// Returns the code of the library.
pub fn library() -> Vec<Source> {
    library_folders().iter().flat_map(|folder| sources(folder)).collect()
}

/// Returns the code of the library and of all that stands on it.
pub fn all_code() -> Vec<Source> {
    let packages = ["bevy/src", "c/src", "cli/src", "bench/src", "python/src", "web/src"];
    library().into_iter().chain(packages.into_iter().flat_map(sources)).collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            files.push(path);
        }
    }
}

fn source(path: &Path) -> Source {
    let text = std::fs::read_to_string(path).unwrap();
    let code = text[..start_of_tests(&text)]
        .lines()
        .map(|line| line.split("//").next().unwrap())
        .collect::<Vec<_>>()
        .join("\n");
    let path = path.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/");
    Source { path, text, code }
}

// Returns the position of a file's test module.
pub fn start_of_tests(text: &str) -> usize {
    let opens_module =
        |rest: &str| rest.lines().nth(1).is_some_and(|line| line.contains("mod ") && line.ends_with('{'));
    // Helpers that tests of several crates share are tests, too.
    let marks = ["#[cfg(test)]", "#[cfg(any(test, feature = \"test-support\"))]"];
    let starts = marks.iter().flat_map(|mark| text.match_indices(mark)).map(|(at, _)| at);
    starts.filter(|&at| opens_module(&text[at..])).min().unwrap_or(text.len())
}

// Returns the library module of a file; `None` for a `lib.rs` and other packages.
fn module(source: &Source) -> Option<&str> {
    let inside = match source.path.strip_prefix("crates/") {
        Some(in_crate) => in_crate.split_once("/src/")?.1,
        None => source.path.strip_prefix("src/")?,
    };
    let name = inside.split('/').next()?.trim_end_matches(".rs");
    (name != "lib").then_some(name)
}

// Reads the allowed imports of each module from the table in `ARCHITECTURE.md`.
fn table() -> BTreeMap<String, Vec<String>> {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let rows = text.lines().map(|line| line.split('|').map(str::trim).collect::<Vec<_>>());
    let layers = rows.filter(|cells| cells.len() == 7 && cells[1].parse::<u32>().is_ok());
    layers
        .map(|cells| {
            let allowed = cells[4].split(", ").filter(|name| *name != "-").map(String::from).collect();
            (cells[2].trim_matches('`').to_string(), allowed)
        })
        .collect()
}

// Lists the modules of the crate that code names after `crate::`, alone or in braces.
fn imports(code: &str) -> Vec<String> {
    code.match_indices("crate::").flat_map(|(at, prefix)| first_names(&code[at + prefix.len()..])).collect()
}

// Returns the first names of a path or a braced list: `{a::{b, c}, d}` gives a and d.
fn first_names(path: &str) -> Vec<String> {
    let Some(list) = path.strip_prefix('{') else { return vec![name(path)] };
    let mut depth = 0;
    let mut names = vec![name(list)];
    for (at, letter) in list.char_indices() {
        match letter {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(name(&list[at + 1..])),
            _ => {}
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

fn name(path: &str) -> String {
    path.trim_start().chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect()
}

// Lists `path: word` for each forbidden word in the code of a file.
fn find_words(files: &[Source], words: &[&str]) -> Vec<String> {
    let hits = |source: &Source| {
        let held = words.iter().filter(|word| source.code.contains(**word));
        held.map(|word| format!("{}: {word}", source.path)).collect::<Vec<_>>()
    };
    files.iter().flat_map(hits).collect()
}

#[test]
fn imports_are_found_in_every_form() {
    assert_eq!(imports("use crate::mesh::TriMesh; crate::io::read()"), ["mesh", "io"]);
    assert_eq!(imports("use crate::{linalg::{Matrix, Csr}, mesh};"), ["linalg", "mesh"]);
}

#[test]
fn modules_import_only_what_the_table_allows() {
    let table = table();
    assert!(table.len() >= 10, "the layer table of ARCHITECTURE.md could not be read: {table:?}");
    for source in library() {
        let Some(module) = module(&source) else { continue };
        let allowed = table.get(module).unwrap_or_else(|| panic!("{module} is not in the layer table"));
        for import in imports(&source.code) {
            let fine = import == module || allowed.contains(&import);
            assert!(fine, "{}: {module} may not import {import}", source.path);
        }
        let (_, inside) = source.path.split_once("src/").unwrap();
        let depth = inside.matches('/').count() + 1 - usize::from(inside.ends_with("/mod.rs"));
        assert!(
            !source.code.contains(&"super::".repeat(depth)) || depth == 0,
            "{}: write crate:: for what lies outside",
            source.path
        );
    }
}

#[test]
fn the_table_names_only_modules_that_exist() {
    for module in table().into_keys() {
        let is_there = |folder: &String| root().join(folder).join(&module).join("mod.rs").exists();
        assert!(library_folders().iter().any(is_there), "{module} has no mod.rs");
    }
}

#[test]
fn the_library_touches_nothing_outside_itself() {
    let library = library();
    let speech = ["println!", "print!(", "eprint!(", "dbg!("];
    assert_eq!(find_words(&library, &speech), Vec::<String>::new());
    let world = ["std::env", "std::process", "Instant", "SystemTime"];
    assert_eq!(find_words(&library, &world), Vec::<String>::new());
    let may_touch = |source: &Source| matches!(module(source), Some("io" | "train"));
    let no_files: Vec<Source> = library.into_iter().filter(|source| !may_touch(source)).collect();
    assert_eq!(find_words(&no_files, &["std::fs", "fs::", "File::"]), Vec::<String>::new());
}

#[test]
fn no_code_panics_on_purpose() {
    let all = all_code();
    assert_eq!(find_words(&all, &[".unwrap()", "todo!(", "unimplemented!(", "allow(dead_code"]), Vec::<String>::new());
    // Readers get arbitrary data and must not panic; elsewhere an `expect` may state an invariant.
    let boundary = |source: &Source| {
        ["bevy/", "c/", "cli/", "python/", "web/", "crates/io/"].iter().any(|place| source.path.starts_with(place))
    };
    let boundary: Vec<Source> = all.into_iter().filter(boundary).collect();
    assert_eq!(find_words(&boundary, &[".expect(", "panic!(", "unreachable!("]), Vec::<String>::new());
}

#[test]
fn unsafe_code_for_c_stands_in_one_file_and_says_why_it_is_sound() {
    let all: Vec<Source> = sources("c/src").into_iter().chain(sources("c/core/src")).collect();
    let (allocator, all): (Vec<Source>, Vec<Source>) =
        all.into_iter().partition(|source| source.path == "c/core/src/allocator.rs");
    let (pointers, others): (Vec<Source>, Vec<Source>) =
        all.into_iter().partition(|source| source.path == "c/core/src/pointers.rs");
    // Other files only declare names and functions with pointers; an allocator is unsafe as a whole.
    let [Source { code, text, .. }] = &allocator[..] else { panic!("c/core/src/allocator.rs is missing") };
    assert_eq!(code.matches("unsafe impl GlobalAlloc for").count(), 1);
    assert!(text.contains("// SAFETY: ") && text.lines().count() <= 140);
    assert_eq!(find_words(&others, &["unsafe {", "unsafe impl"]), Vec::<String>::new());
    for Source { path, code, text } in &others {
        let [names, functions] = ["#[unsafe(no_mangle)]", "unsafe extern"].map(|word| code.matches(word).count());
        let reasons = ["// SAFETY: ", "/// # Safety"].map(|word| text.matches(word).count());
        assert_eq!(reasons, [names, functions], "{path}");
    }
    let [Source { code, text, .. }] = &pointers[..] else { panic!("c/core/src/pointers.rs is missing") };
    let n_of = |text: &str, word: &str| text.matches(word).count();
    assert_eq!(n_of(text, "// SAFETY: "), n_of(code, "unsafe {") + n_of(code, "unsafe impl"));
    assert!(text.lines().count() <= 160);
}

#[test]
fn unsafe_code_stands_in_kernels_the_allocator_and_names_for_javascript_alone() {
    let (door, all): (Vec<Source>, Vec<Source>) =
        all_code().into_iter().filter(|source| !source.path.starts_with("c/")).partition(|source| {
            ["web/src/caller.rs", "web/src/documents/clock.rs", "web/src/exports.rs"].contains(&source.path.as_str())
        });
    let (allocator, others): (Vec<Source>, Vec<Source>) =
        all.into_iter().partition(|source| source.path == "cli/src/allocator.rs");
    // Only declarations are allowed there.
    let n_of = |word: &str| door.iter().map(|source| source.code.matches(word).count()).sum::<usize>();
    let declared = ["#[unsafe(no_mangle)]", "unsafe extern \"C\" {", "allow(unsafe_code"].map(n_of);
    assert_eq!((declared, n_of("unsafe ")), ([4, 2, 3], 5));
    let is_kernel =
        |source: &Source| module(source) == Some("linalg") || source.path.ends_with("collapse/lanes/avx2.rs");
    let elsewhere: Vec<Source> = others.into_iter().filter(|source| !is_kernel(source)).collect();
    assert_eq!(find_words(&elsewhere, &["unsafe ", "allow(unsafe_code)"]), Vec::<String>::new());
    // The allocator file must justify its use of `unsafe` and stay small.
    let [Source { code, text, .. }] = &allocator[..] else { panic!("cli/src/allocator.rs is missing") };
    assert_eq!((code.matches("unsafe impl").count(), code.matches("unsafe impl GlobalAlloc for").count()), (1, 1));
    assert!(text.contains("// SAFETY: ") && text.lines().count() <= 120);
}

#[test]
fn files_say_what_they_are() {
    let tests = ["bevy/tests", "cli/tests", "bench/tests", "tests", "web/tests"].into_iter().flat_map(sources);
    for source in all_code().into_iter().chain(tests) {
        assert!(source.text.starts_with("//! "), "{} does not open with //!", source.path);
        for word in [concat!("TO", "DO"), concat!("FIX", "ME")] {
            assert!(!source.text.contains(word), "{}: {word}", source.path);
        }
    }
}

#[test]
fn every_file_of_tests_is_compiled() {
    for folder in ["tests", "bevy/tests", "cli/tests", "bench/tests"] {
        let main = std::fs::read_to_string(root().join(folder).join("main.rs")).unwrap();
        let manifest = std::fs::read_to_string(root().join(folder).join("../Cargo.toml")).unwrap();
        for source in sources(folder) {
            let inside = source.path[folder.len() + 1..].trim_end_matches(".rs");
            let name = inside.split('/').next().unwrap();
            let is_program = name == "main" || manifest.contains(&format!("[[test]]\nname = \"{name}\"\n"));
            assert!(is_program || main.contains(&format!("mod {name};\n")), "{folder}/main.rs lacks {name}");
        }
    }
}

#[test]
fn property_tests_draw_the_same_cases_every_time() {
    let settings = std::fs::read_to_string(root().join(".cargo/config.toml")).unwrap();
    assert!(settings.contains("\n[env]\n") && settings.contains("\nPROPTEST_RNG_SEED = \""), "{settings}");
    let mut runners = [(); 2].map(|()| TestRunner::default());
    let drawn = runners.each_mut().map(|runner| any::<[u64; 4]>().new_tree(runner).unwrap().current());
    assert_eq!(drawn[0], drawn[1], "cargo sets the seed: run the tests by it");
}

#[test]
fn a_mesh_that_is_not_valid_cannot_be_built() {
    let corners = || vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert!(TriMesh::new(corners(), vec![[0, 1, 2]]).is_ok());
    assert!(TriMesh::new(corners(), vec![[0, 1, 3]]).is_err());
    assert!(TriMesh::new(corners(), vec![[0, 1, 1]]).is_err());
    assert!(TriMesh::new(vec![[0.0, f32::NAN, 0.0]], vec![]).is_err());
}

#[test]
fn every_invariant_names_a_test_that_exists() {
    let mut text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    // The published crate has no docs.
    text += &std::fs::read_to_string(root().join("docs/closed.md")).unwrap_or_default();
    let named: Vec<(&str, &str)> = text.split('`').filter_map(|span| span.split_once(".rs::")).collect();
    assert!(!named.is_empty());
    for (file, test) in named {
        let code = std::fs::read_to_string(root().join(format!("{file}.rs"))).unwrap_or_default();
        let function = test.rsplit("::").next().unwrap();
        assert!(code.contains(&format!("fn {function}(")), "{file}.rs has no test {test}");
    }
}
