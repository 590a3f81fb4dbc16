//! Upper bound on the length of functions.

use super::{Source, all_code};

// Lines of the longest function, from `fn` to its closing brace, without comments: that of a driver that reads as a table of
// contents, or of one algorithm with a comment before each block.
const MOST_LINES: usize = 60;
// Lines that nearly all functions have at most; one in `ONE_LONG_OF` may have more.
const USUAL_LINES: usize = 40;
const ONE_LONG_OF: usize = 100;

// Returns the functions of formatted code without comments: first line, name, number of lines that are not empty.
fn lengths(code: &str) -> Vec<(usize, String, usize)> {
    let lines: Vec<&str> = code.lines().collect();
    let begins = lines.iter().enumerate().filter_map(|(at, line)| Some((at, function_name(line)?)));
    let length = |at: usize| {
        let indent = lines[at].len() - lines[at].trim_start().len();
        let closes =
            |line: &&str| line.len() > indent && line[..indent].trim().is_empty() && line[indent..].starts_with('}');
        let is_whole = |line: &str| line.trim_end().ends_with(['}', ';']);
        let last = if is_whole(lines[at]) { 0 } else { lines[at..].iter().position(closes)? };
        Some(lines[at..=at + last].iter().filter(|line| !line.trim().is_empty()).count())
    };
    begins.filter_map(|(at, name)| Some((at + 1, name, length(at)?))).collect()
}

fn function_name(line: &str) -> Option<String> {
    let (before, after) = line.split_once("fn ")?;
    let is_qualifier =
        |word: &str| ["const", "async", "unsafe"].contains(&word) || word.starts_with("pub") || word.ends_with(')');
    if !before.split_whitespace().all(is_qualifier) {
        return None;
    }
    let name: String = after.chars().take_while(|letter| letter.is_alphanumeric() || *letter == '_').collect();
    (!name.is_empty()).then_some(name)
}

fn too_long(source: &Source) -> Vec<String> {
    let long = lengths(&source.code).into_iter().filter(|(_, _, n_lines)| *n_lines > MOST_LINES);
    long.map(|(line, name, n_lines)| format!("{}:{line}: {name} has {n_lines} lines", source.path)).collect()
}

#[test]
fn no_function_is_longer_than_sixty_lines_and_few_than_forty() {
    let all = all_code();
    let all_lengths = || all.iter().flat_map(|source| lengths(&source.code));
    let n_functions = all_lengths().count();
    assert!(n_functions > 1000, "only {n_functions} functions were found: the code is read wrong");
    assert_eq!(all.iter().flat_map(too_long).collect::<Vec<_>>(), Vec::<String>::new());
    let n_long = all_lengths().filter(|(_, _, n_lines)| *n_lines > USUAL_LINES).count();
    assert!(
        n_long * ONE_LONG_OF <= n_functions,
        "{n_long} of {n_functions} functions have more than {USUAL_LINES} lines"
    );
}

#[test]
fn lines_are_counted_from_the_name_to_the_brace() {
    let code = "pub(in crate::io) fn a(\n    x: u32,\n) -> u32 {\n    x\n}\nimpl B {\n    fn c() {}\n    const fn d() {\n        if x {\n        }\n    }\n}\n";
    let found: Vec<(String, usize)> = lengths(code).into_iter().map(|(_, name, n_lines)| (name, n_lines)).collect();
    assert_eq!(found, [("a".into(), 5), ("c".into(), 1), ("d".into(), 4)]);
    assert!(lengths("let call: fn (u32) = f;\n// the fn here\n").is_empty());
}
