//! Circles of files: each uses an item that the next one defines.
//!
//! A file uses the file that defines the item, whichever modules pass its name on; parents and children count like others.
//! A module that is only a name on the way to an item does not count, nor does a name that is only passed on.

use std::collections::{BTreeMap, BTreeSet};

use super::{Source, library_folders, sources};

// Limit of followed re-exports for one name.
const DEEPEST: usize = 8;

// Folders whose `mod.rs` and children still use each other.
const OPEN_KNOTS: [&str; 5] = [
    "bench/src/learned_baselines/",
    "src/clusters/container/",
    "crates/io/src/io/obj/",
    "crates/io/src/io/pieces/",
    "crates/io/src/io/ply/",
];

type Path = Vec<String>;

struct Tree<'a> {
    files: BTreeMap<Path, &'a Source>,
    // Names that each module introduces, with their paths.
    uses: BTreeMap<Path, Vec<Use>>,
}

#[derive(Clone, Debug, PartialEq)]
struct Use {
    path: Path,
    name: String,
    is_public: bool,
}

impl<'a> Tree<'a> {
    fn new(sources: &'a [Source], folder: &str) -> Self {
        let files: BTreeMap<Path, &Source> =
            sources.iter().map(|source| (module_of(&source.path, folder), source)).collect();
        let uses = files.iter().map(|(module, source)| (module.clone(), uses(&source.code))).collect();
        Self { files, uses }
    }

    // Returns the modules whose files define what a module uses.
    fn imports(&self, module: &Path) -> BTreeSet<Path> {
        let code = without_uses(&self.files[module].code);
        let lines = code.lines().filter(|line| !line.contains("mod ") || !line.ends_with(';'));
        let words: BTreeSet<&str> = lines.flat_map(words).collect();
        let is_used = |import: &&Use| !import.is_public || words.contains(import.name.as_str());
        let stated = self.uses[module].iter().filter(is_used).map(|import| import.path.clone());
        let found = stated.chain(inline_paths(&code)).filter_map(|path| self.find_definition(module, &path, 0));
        found.filter(|(other, is_item)| *is_item && other != module).map(|(other, _)| other).collect()
    }

    // Returns the module whose file defines what `path` means in `module`, and whether that is an item and no module.
    fn find_definition(&self, module: &Path, path: &[String], depth: usize) -> Option<(Path, bool)> {
        let (mut at, rest) = self.start(module, path, depth)?;
        for (i, name) in rest.iter().enumerate() {
            let passed_on = self.uses.get(&at).and_then(|uses| uses.iter().find(|import| import.name == *name));
            let child = self.child(&at, name);
            match (passed_on, child) {
                // An item may have the name of its module.
                (Some(import), child) if depth < DEEPEST && (child.is_none() || i + 1 == rest.len()) => {
                    return self.find_definition(&at, &[&import.path, &rest[i + 1..]].concat(), depth + 1);
                }
                (_, Some(child)) => at = child,
                _ => return Some((at, true)),
            }
        }
        Some((at, false))
    }

    // Returns the module where a path starts, and the names after it.
    fn start<'p>(&self, module: &Path, path: &'p [String], depth: usize) -> Option<(Path, &'p [String])> {
        let n_up = path.iter().take_while(|name| *name == "super").count();
        let imported = |first: &String| {
            let import = self.uses[module].iter().find(|import| import.name == *first && depth < DEEPEST)?;
            let (found, is_item) = self.find_definition(module, &import.path, depth + 1)?;
            (!is_item).then_some(found)
        };
        match path.first()?.as_str() {
            "crate" => Some((Path::new(), &path[1..])),
            "self" => Some((module.clone(), &path[1..])),
            "super" => Some((module[..module.len().checked_sub(n_up)?].to_vec(), &path[n_up..])),
            first => Some((self.child(module, first).or_else(|| imported(&path[0]))?, &path[1..])),
        }
    }

    fn child(&self, module: &Path, name: &str) -> Option<Path> {
        let child = [&module[..], &[name.to_string()]].concat();
        self.files.contains_key(&child).then_some(child)
    }

    fn circles(&self) -> Vec<String> {
        let imports: BTreeMap<&Path, BTreeSet<Path>> =
            self.files.keys().map(|module| (module, self.imports(module))).collect();
        let file = |module: &Path| self.files[module].path.as_str();
        let mut found = Vec::new();
        for (module, others) in &imports {
            let back = others.iter().filter(|other| reachable_modules(&imports, other).contains(*module));
            found.extend(back.map(|other| format!("{} imports {}", file(module), file(other))));
        }
        found
    }
}

fn reachable_modules(imports: &BTreeMap<&Path, BTreeSet<Path>>, from: &Path) -> BTreeSet<Path> {
    let mut reached = BTreeSet::new();
    let mut pending = vec![from.clone()];
    while let Some(module) = pending.pop() {
        let others = imports.get(&module).into_iter().flatten();
        pending.extend(others.filter(|other| reached.insert((*other).clone())).cloned().collect::<Vec<_>>());
    }
    reached
}

// Returns the module of a file: `src/io/gltf/schema.rs` is `io::gltf::schema`; the root file has no name.
fn module_of(file: &str, folder: &str) -> Path {
    let names = file.trim_start_matches(folder).trim_start_matches('/').trim_end_matches(".rs");
    let names = names.split('/').filter(|name| !["mod", "lib", "main"].contains(name));
    names.map(String::from).collect()
}

// Returns begin and end of the `use` items of code.
fn use_items(code: &str) -> Vec<(usize, usize)> {
    let is_start = |at: usize| code[..at].chars().next_back().is_none_or(|before| before.is_whitespace());
    let begins = code.match_indices("use ").map(|(at, _)| at).filter(|&at| is_start(at));
    begins.filter_map(|at| Some((at, at + code[at..].find(';')?))).collect()
}

fn uses(code: &str) -> Vec<Use> {
    let mut found = Vec::new();
    for (begin, end) in use_items(code) {
        let line = code[..begin].rfind('\n').map_or(0, |at| at + 1);
        let is_public = code[line..begin].contains("pub");
        let tree: String = code[begin + 4..end].split_whitespace().collect::<Vec<_>>().join(" ");
        let mut paths = Vec::new();
        flatten(&tree, &[], &mut paths);
        found.extend(paths.into_iter().map(|(path, name)| Use { path, name, is_public }));
    }
    found
}

// Expands a tree such as `a::{b, c::d as e}` into paths with their names.
fn flatten(tree: &str, before: &[String], found: &mut Vec<(Path, String)>) {
    let tree = tree.trim();
    if let Some(list) = tree.strip_prefix('{') {
        split_list(list.trim_end().trim_end_matches('}')).iter().for_each(|tree| flatten(tree, before, found));
        return;
    }
    if let Some((first, rest)) = tree.split_once("::") {
        let before = [before, &[first.trim().to_string()]].concat();
        return flatten(rest, &before, found);
    }
    let (last, name) = tree.split_once(" as ").unwrap_or((tree, tree));
    let path = match last {
        "" => return,
        "self" => before.to_vec(),
        _ => [before, &[last.to_string()]].concat(),
    };
    let name = if name == "self" { path.last().cloned().unwrap_or_default() } else { name.to_string() };
    found.push((path, name));
}

// Splits a list at its commas, outside of braces.
fn split_list(list: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut depth = 0;
    for letter in list.chars() {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        match letter {
            ',' if depth == 0 => parts.push(String::new()),
            _ => parts[..].last_mut().unwrap().push(letter),
        }
    }
    parts
}

fn without_uses(code: &str) -> String {
    let mut left = code.to_string();
    for (begin, end) in use_items(code).into_iter().rev() {
        left.replace_range(begin..=end, "");
    }
    left
}

fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split(|letter: char| !letter.is_alphanumeric() && letter != '_')
}

// Lists the paths of two or more names in code.
fn inline_paths(code: &str) -> Vec<Path> {
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
    let words = code.split(|letter: char| !is_part(letter));
    let paths = words.filter(|word| word.contains("::") && !word.starts_with(':'));
    paths.map(|path| path.split("::").filter(|name| !name.is_empty()).map(String::from).collect()).collect()
}

fn circles_below(folder: &str) -> Vec<String> {
    let found = Tree::new(&sources(folder), folder).circles();
    found.into_iter().filter(|line| OPEN_KNOTS.iter().all(|knot| !line.starts_with(knot))).collect()
}

#[test]
fn no_files_use_each_other_in_a_circle() {
    let programs = ["bench/src", "bevy/src", "c/src", "cli/src", "python/src", "web/src"].map(String::from);
    for folder in library_folders().into_iter().chain(programs) {
        assert_eq!(circles_below(&folder), Vec::<String>::new());
    }
}

fn source(path: &str, code: &str) -> Source {
    Source { path: path.into(), text: code.into(), code: code.into() }
}

#[test]
fn circles_are_found_through_names_passed_on() {
    let circle = [
        source("src/lib.rs", "pub mod a;"),
        source("src/a/mod.rs", "mod b;\nmod c;\nmod d;\npub use b::{Thing, other as more};\npub use c::f;"),
        source("src/a/b.rs", "pub struct Thing;\nfn g() { super::c::f() }"),
        source("src/a/c.rs", "use super::{\n    Thing as T,\n};\npub fn f() {}"),
        source("src/a/d.rs", "use crate::a::f;"),
    ];
    let found = Tree::new(&circle, "src").circles();
    assert_eq!(found, ["src/a/b.rs imports src/a/c.rs", "src/a/c.rs imports src/a/b.rs"]);
}

#[test]
fn parents_and_children_are_in_circles_only_by_items() {
    let knot = [
        source("src/a/mod.rs", "mod b;\npub use b::f;\npub const N: u32 = 1;\nfn g() { f() }"),
        source("src/a/b.rs", "use super::N;\npub fn f() {}"),
    ];
    let found = Tree::new(&knot, "src").circles();
    assert_eq!(found, ["src/a/mod.rs imports src/a/b.rs", "src/a/b.rs imports src/a/mod.rs"]);
    let tree = [
        source("src/a/mod.rs", "mod b;\nmod d;\npub use b::f;\npub use d::N;\nuse std::fmt;"),
        source("src/a/b.rs", "use super::{N, d};\npub fn f() { d::h() }"),
        source("src/a/d.rs", "pub fn h() {}\npub const N: u32 = 1;"),
        source("src/c.rs", "use crate::a::N;"),
    ];
    assert_eq!(Tree::new(&tree, "src").circles(), Vec::<String>::new());
}

#[test]
fn uses_are_read_in_every_form() {
    let code = "pub(crate) use a::{self, b::{c, d as e}};\nlet because = 1;\nuse super::super::x;";
    let found = uses(code);
    let names: Vec<&str> = found.iter().map(|import| import.name.as_str()).collect();
    assert_eq!(names, ["a", "c", "e", "x"]);
    assert_eq!(found[2], Use { path: ["a", "b", "d"].map(String::from).to_vec(), name: "e".into(), is_public: true });
    assert_eq!(found[3].path, ["super", "super", "x"].map(String::from));
}
