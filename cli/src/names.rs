//! What names of files say: standard streams, formats, folders to write into.

use std::path::{Path, PathBuf};

use neural_mesh::io::Format;

use crate::args::SimplifyArgs;
use crate::failure::Failure;

/// What can be read, as a remedy.
pub const READABLE: &str = "give OBJ, PLY, STL, OFF, glTF or GLB";

/// Where a result goes and as what.
#[derive(Debug, PartialEq)]
pub struct Destination {
    /// A path, or `-` for standard output.
    pub path: PathBuf,
    /// The format it is written in.
    pub format: Format,
    /// Whether that is the format of the input, which shows when it is read.
    pub follows_input: bool,
}

/// Whether a path stands for standard input or output.
pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The format with that name.
pub fn format_of(name: &str) -> Result<Format, Failure> {
    let unknown = || format!("--format {name}: unknown format: choose from {}", Format::NAMES.join(", "));
    Format::from_name(name).ok_or_else(|| Failure::Usage(unknown()))
}

/// The format that a name says.
pub fn named(path: &Path) -> Option<Format> {
    if is_stream(path) { None } else { Format::from_path(path) }
}

/// Where the result of one mesh goes: to the name that is given, or into the folder under the name of the mesh; standard output
/// takes the format of the mesh where no other is given.
pub fn destination(args: &SimplifyArgs) -> Result<Destination, Failure> {
    let given = args.format.as_deref().map(format_of).transpose()?;
    let input = args.inputs.first().map_or(Path::new(""), PathBuf::as_path);
    if is_stream(&args.output) && given.is_none() {
        let (format, follows_input) = (alone(named(input)), named(input).is_none());
        return Ok(Destination { path: args.output.clone(), format, follows_input });
    }
    let path = if args.output.is_dir() { in_folder(&args.output, input, given)? } else { args.output.clone() };
    Ok(Destination { format: output_format(&path, given)?, path, follows_input: false })
}

/// A path in the folder with the name of the input.
fn in_folder(folder: &Path, input: &Path, given: Option<Format>) -> Result<PathBuf, Failure> {
    match input.file_name() {
        Some(name) if !is_stream(input) => {
            Ok(folder.join(with_ending(name.as_ref(), given.or(named(input)).unwrap_or(Format::Ply))))
        }
        _ => {
            let what = "is a folder, and standard input has no name: give the name of a file";
            Err(Failure::Usage(format!("{}: {what}", folder.display())))
        }
    }
}

/// A name with the ending of a format; results in folders are not compressed.
pub fn with_ending(name: &Path, format: Format) -> PathBuf {
    Format::without_gz(name).with_extension(ending(format))
}

/// What names of files in a format end in.
pub fn ending(format: Format) -> &'static str {
    family(format).name()
}

/// The format that standard output takes of what was read: one that needs no file beside it; PLY where it is not known.
pub fn alone(read: Option<Format>) -> Format {
    match read {
        Some(Format::Gltf) => Format::Glb,
        read => read.unwrap_or(Format::Ply),
    }
}

/// The format to write: what the name says, else what `--format` says; the two may not disagree where only one is meant.
pub fn output_format(output: &Path, given: Option<Format>) -> Result<Format, Failure> {
    let format = named(output).or(given).ok_or_else(|| unknown_format(output))?;
    // `--format ply-ascii -o x.ply` asks for the text variant of what the name says.
    Ok(given.filter(|given| family(*given) == family(format)).unwrap_or(format))
}

fn unknown_format(output: &Path) -> Failure {
    let names = Format::NAMES.join(", ");
    let ends_as_folder = output.as_os_str().as_encoded_bytes().last().is_some_and(|&last| last == b'/');
    Failure::Usage(match output {
        _ if is_stream(output) => format!("standard output: the format is not known: give --format, one of {names}"),
        _ if ends_as_folder => format!("{}: there is no such folder: create it first", output.display()),
        _ => {
            let how = "end the name in .obj, .ply, .stl, .off, .gltf or .glb, or give --format, one of";
            format!("{}: the format is not known: {how} {names}", output.display())
        }
    })
}

/// The variants of a format are one family.
fn family(format: Format) -> Format {
    match format {
        Format::PlyAscii => Format::Ply,
        Format::StlAscii => Format::Stl,
        other => other,
    }
}
