//! The language rules that a search can check: names, length of first sentences, phrases.

use std::collections::BTreeMap;

use crate::layers::{Source, all_code, library, sources, start_of_tests};

mod lists;
use lists::{NO_CLOSURE_NAMES, PHRASES, SAME_NAMES};

// Limit of words in the first sentence of a doc comment.
const MOST_WORDS: usize = 25;
// Folders where "part" means a component of a mesh.
const MESH_FOLDERS: [&str; 6] = [
    "crates/mesh/src/geometry/",
    "crates/mesh/src/mesh/",
    "crates/mesh/src/spatial/",
    "crates/measure/",
    "crates/repair/",
    "crates/simplify/",
];

// Comments and definitions of a formatted file, each with its line.
#[derive(Default)]
struct Described {
    comments: Vec<(usize, String)>,
    // Doc comments outside tests.
    docs: Vec<(usize, Vec<String>)>,
    types: Vec<(usize, String)>,
}

fn read(source: &Source) -> Described {
    let tests_at = source.text[..start_of_tests(&source.text)].lines().count();
    let (mut read, mut is_in_docs) = (Described::default(), false);
    for (line, text) in (1..).zip(source.text.lines()) {
        let trimmed = text.trim();
        let is_docs = trimmed.starts_with("///") || trimmed.starts_with("//!");
        if trimmed.starts_with("//") {
            let words = trimmed.trim_start_matches(['/', '!']).trim().to_string();
            read.comments.push((line, words.clone()));
            match read.docs.last_mut().filter(|_| is_in_docs && is_docs) {
                Some((_, docs)) => docs.push(words),
                None if is_docs && line <= tests_at => read.docs.push((line, vec![words])),
                None => {}
            }
        }
        read.types.extend(type_name(text).map(|name| (line, name)));
        is_in_docs = is_docs && line <= tests_at;
    }
    read
}

// Returns the name of the type that a line defines.
fn type_name(line: &str) -> Option<String> {
    let mut words = line.trim().split(' ').skip_while(|word| word.starts_with("pub") || *word == "unsafe");
    let keyword = words.next()?;
    let is_alias = keyword == "type" && !line.starts_with(' ');
    let letters = words.next().filter(|_| is_alias || ["struct", "enum", "trait", "union"].contains(&keyword))?.chars();
    Some(letters.take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect())
}

// Returns the first sentence of docs, with code in backticks as one word.
fn first_sentence(docs: &[String]) -> String {
    let is_prose =
        |line: &&String| !line.is_empty() && !line.starts_with(['-', '*', '|', '#', '>']) && !line.starts_with("```");
    let lines: Vec<&str> =
        docs.iter().skip_while(|line| !is_prose(line)).take_while(is_prose).map(String::as_str).collect();
    let mut text = blank_code(&lines.join(" "));
    for word in ["e.g.", "i.e.", "Eq.", "Eqs.", "Sec.", "Fig.", "cf.", "al.", "vs."] {
        text = text.replace(word, word.trim_end_matches('.'));
    }
    let ends = text.match_indices(['.', '!', '?']).map(|(at, _)| at + 1);
    let end = ends.into_iter().find(|&end| text[end..].trim_start_matches([')', '"']).starts_with(' '));
    text[..end.unwrap_or(text.len())].to_string()
}

fn blank_code(text: &str) -> String {
    text.split('`').enumerate().map(|(i, piece)| if i % 2 == 0 { piece } else { "Code" }).collect()
}

fn is_in(list: &str, word: &str) -> bool {
    list.split(' ').any(|known| known == word)
}

// Returns whether lower-case text has a phrase that is not inside a longer word.
fn holds(text: &str, phrase: &str) -> bool {
    let is_letter = |letter: Option<char>| letter.is_some_and(char::is_alphanumeric);
    let is_whole =
        |(at, _)| !is_letter(text[..at].chars().next_back()) && !is_letter(text[at + phrase.len()..].chars().next());
    text.match_indices(phrase).any(is_whole)
}

// Path, line, and replacement.
type Finding = (String, usize, String);

fn find_in_files(find: impl Fn(&Source) -> Vec<(usize, String)>) -> Vec<Finding> {
    let found = all_code().into_iter().map(|source| (find(&source), source.path));
    found.flat_map(|(lines, path)| lines.into_iter().map(move |(line, text)| (path.clone(), line, text))).collect()
}

fn assert_no_findings(findings: Vec<Finding>) {
    let lines: Vec<String> = findings.iter().map(|(path, line, text)| format!("{path}:{line}: {text}")).collect();
    assert!(lines.is_empty(), "{} findings:\n{}", lines.len(), lines.join("\n"));
}

fn find_equal_types() -> Vec<Finding> {
    let mut found = Vec::new();
    let packages = ["bevy/src", "cli/src", "bench/src", "c/src", "web/src", "python/src"].map(sources);
    for files in std::iter::once(library()).chain(packages) {
        let mut places: BTreeMap<String, Vec<(String, usize)>> = BTreeMap::new();
        // Stubs of features have the names of the types that they replace.
        let is_stub = |source: &Source| source.path.rsplit('/').next().is_some_and(|name| name.starts_with("no_"));
        for source in files.into_iter().filter(|source| !is_stub(source)) {
            for (line, name) in read(&source).types {
                places.entry(name).or_default().push((source.path.clone(), line));
            }
        }
        places.retain(|name, places| places.len() > 1 && SAME_NAMES.iter().all(|(known, _)| known != name));
        for (name, places) in places {
            let all: Vec<String> = places.iter().map(|(path, line)| format!("{path}:{line}")).collect();
            let text = format!("type {name} is defined at {}: say in each name what it is", all.join(", "));
            found.extend(places.into_iter().map(|(path, line)| (path, line, text.clone())));
        }
    }
    found
}

// Lists closures with a name that says nothing of what they do.
fn find_bare_closures() -> Vec<Finding> {
    find_in_files(|source| {
        let is_bench = source.path.starts_with("bench/");
        let lines = source.text.lines().enumerate().filter(|_| !is_bench);
        let names = lines.filter_map(|(at, line)| Some((at + 1, closure_name(line)?)));
        let bare = names.filter(|(_, name)| is_in(NO_CLOSURE_NAMES, name));
        bare.map(|(line, name)| (line, format!("closure {name}: write what it does, or what it returns"))).collect()
    })
}

// Returns the name of a closure that a line binds.
fn closure_name(line: &str) -> Option<&str> {
    let (name, value) = line.trim_start_matches([' ', '/']).strip_prefix("let ")?.split_once(" = ")?;
    let is_closure = value.trim_start_matches("move ").starts_with('|');
    is_closure.then(|| name.trim_start_matches("mut ").split(':').next().unwrap())
}

fn find_long_sentences() -> Vec<Finding> {
    find_in_files(|source| {
        let n_words = |docs: &[String]| first_sentence(docs).split_whitespace().count();
        let long = read(source).docs.into_iter().filter(|(_, docs)| n_words(docs) > MOST_WORDS);
        let text = format!("the first sentence is too long: write at most {MOST_WORDS} words");
        long.map(|(line, _)| (line, text.clone())).collect()
    })
}

fn find_old_phrases() -> Vec<Finding> {
    find_in_files(|source| {
        let mut found = Vec::new();
        let is_of_meshes = MESH_FOLDERS.iter().any(|folder| source.path.starts_with(folder));
        for (line, text) in read(source).comments {
            let prose = blank_code(&text).to_lowercase();
            let phrases = PHRASES.iter().filter(|(phrase, _)| holds(&prose, phrase));
            found.extend(phrases.map(|(phrase, instead)| (line, format!("\"{phrase}\": write {instead}"))));
            let says_part = ["part", "parts"].iter().any(|part| {
                let rest = prose.replace(&format!("{part} of"), "").replace(&format!("{part} in"), "");
                holds(&rest, part) && !prose.ends_with(part)
            });
            if is_of_meshes && says_part {
                found.push((line, "\"part\": write component (\"part of\" is fine)".into()));
            }
        }
        found
    })
}

#[test]
fn type_names_are_unique_in_a_crate() {
    assert_no_findings(find_equal_types());
}

#[test]
fn closures_are_more_than_prepositions() {
    assert_no_findings(find_bare_closures());
}

#[test]
fn docs_begin_with_a_short_sentence() {
    assert_no_findings(find_long_sentences());
}

#[test]
fn comments_use_plain_phrases() {
    assert_no_findings(find_old_phrases());
}

#[test]
fn at_most_five_type_names_occur_twice() {
    assert!(SAME_NAMES.len() <= 5 && SAME_NAMES.iter().all(|(_, reason)| !reason.is_empty()));
}

#[test]
fn the_rules_tell_good_from_bad() {
    let lines = ["    let mut at = |k: usize| k;", "let of: F = move |x| x", "let at = 3;", "// let by = || 1;"];
    assert_eq!(lines.map(closure_name), [Some("at"), Some("of"), None, Some("by")]);
    assert_eq!(type_name("    pub(super) struct Area<T> {").as_deref(), Some("Area"));
    assert_eq!(type_name("    type Item = u32;"), None);
    let docs = ["Adds `a. b` (e.g. one). Then".to_string(), "more.".into()];
    assert_eq!(first_sentence(&docs), "Adds Code (eg one).".replace("eg", "e.g"));
    assert!(holds("what is told here", "told") && !holds("untold", "told"));
}
