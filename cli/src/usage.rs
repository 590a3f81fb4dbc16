//! Messages for wrong arguments.

use std::error::Error;
use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use neural_mesh::io::Format;

use crate::failure::Failure;

/// Options that give `simplify` a size.
const TARGETS: [&str; 6] = ["--ratio", "--faces", "--vertices", "--error", "--size", "--lods"];

/// Returns a one-line error for mistakes whose remedy is known; `None` leaves the message to the parser.
///
/// `words` are the arguments after the program's name.
pub fn explain_error(error: &clap::Error, words: &[String]) -> Option<Failure> {
    rejected_value(error).or_else(|| missing_command(error, words)).or_else(|| missing_output(error, words))
}

/// Returns an error such as `--ratio 50: give a share ...` for a rejected value.
fn rejected_value(error: &clap::Error) -> Option<Failure> {
    let why = error.source().filter(|_| error.kind() == ErrorKind::ValueValidation)?;
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.as_str(),
        _ => "",
    };
    // The parser clap names the option with its value, as in `--fill-holes[=<EDGES>]`; only the name is kept.
    let option = context(ContextKind::InvalidArg).split([' ', '=', '[', '<']).next().unwrap_or_default();
    Some(Failure::Usage(format!("{option} {}: {why}", context(ContextKind::InvalidValue))))
}

/// Explains a mesh in the place of the command.
fn missing_command(error: &clap::Error, words: &[String]) -> Option<Failure> {
    let first = words.first().filter(|_| error.kind() == ErrorKind::InvalidSubcommand)?;
    is_mesh_name(first).then(|| {
        let command = complete_command(&[&["simplify".into()], words].concat());
        Failure::Usage(format!("{first}: is a mesh and no command: run {command}"))
    })
}

/// Explains a result without `-o`, and a missing size.
fn missing_output(error: &clap::Error, words: &[String]) -> Option<Failure> {
    let is_simplify = words.first().is_some_and(|word| word == "simplify");
    if error.kind() != ErrorKind::MissingRequiredArgument
        || !is_simplify
        || !words.iter().any(|word| is_mesh_name(word))
    {
        return None;
    }
    let has_output = words.iter().any(|word| is_output_option(word));
    let has_target = words.iter().any(|word| is_target_option(word));
    let what = match (has_output, has_target) {
        (false, true) => "give the result after -o",
        (false, false) => "give the result after -o, and a size",
        (true, false) => "give a size: --ratio, --faces, --vertices, --error, --size or --lods",
        (true, true) => return None,
    };
    Some(Failure::Usage(format!("simplify: {what}: {}", complete_command(words))))
}

/// Completes a command line to one that works: a second mesh becomes the result, and a size is added.
fn complete_command(words: &[String]) -> String {
    let mut words: Vec<String> = words.to_vec();
    if !words.iter().any(|word| is_output_option(word)) {
        let mut meshes = (0..words.len()).filter(|&at| is_mesh_name(&words[at]) && !is_value(&words, at));
        let (first, last) = (meshes.next(), meshes.next_back());
        match (first, last.filter(|&at| !Path::new(&words[at]).exists())) {
            (_, Some(last)) => words.insert(last, "-o".into()),
            (Some(first), None) => {
                words.splice(first + 1..first + 1, ["-o".into(), output_name(&words[first])]);
            }
            _ => {}
        }
    }
    if !words.iter().any(|word| is_target_option(word)) {
        words.extend(["--ratio".into(), "10%".into()]);
    }
    let quoted = words.iter().map(|word| if word.contains(' ') { format!("'{word}'") } else { word.clone() });
    format!("`neural-mesh {}`", quoted.collect::<Vec<_>>().join(" "))
}

/// Returns a free name for the result of a mesh, in its format if that is written.
fn output_name(input: &str) -> String {
    let stem = Path::new(input).with_extension("");
    let ending = Path::new(input).extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let ending = if ["obj", "ply", "stl", "off", "gltf", "glb", "vrm"].contains(&&*ending) { &ending } else { "glb" };
    format!("{}-light.{ending}", stem.display())
}

fn is_output_option(word: &str) -> bool {
    word.starts_with("-o") || word == "--output" || word.starts_with("--output=")
}

fn is_target_option(word: &str) -> bool {
    TARGETS.contains(&word.split('=').next().unwrap_or_default())
}

/// Returns whether a word is the value of the option before it, such as the file of `--report`.
fn is_value(words: &[String], at: usize) -> bool {
    at.checked_sub(1).is_some_and(|before| words[before].starts_with("--") && !words[before].contains('='))
}

fn is_mesh_name(word: &str) -> bool {
    !word.starts_with('-') && Format::from_path(Path::new(word)).is_some()
}
