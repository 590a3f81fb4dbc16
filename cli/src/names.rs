//! What names of files say: standard streams, formats, folders to write into.

use std::path::{Path, PathBuf};

use neural_mesh::io::{Format, can_read, is_gltf_path, write_obstacle};

use crate::failure::Failure;

/// What this build reads, as a remedy: `give OBJ, PLY, STL, OFF, glTF, GLB, VRM, 3MF or FBX`.
pub fn readable() -> String {
    let named = [
        ("OBJ", Format::Obj),
        ("PLY", Format::Ply),
        ("STL", Format::Stl),
        ("OFF", Format::Off),
        ("glTF", Format::Gltf),
        ("GLB", Format::Glb),
        ("VRM", Format::Glb),
        ("3MF", Format::ThreeMf),
        ("FBX", Format::Fbx),
    ];
    let read = named.into_iter().filter(|(_, format)| can_read(*format)).map(|(name, _)| name.to_string());
    format!("give {}", alternatives(read))
}

/// `a, b or c`.
fn alternatives(names: impl Iterator<Item = String>) -> String {
    let names: Vec<String> = names.collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// Where a mesh comes from and where it goes.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    /// A path, or `-` for a standard stream.
    pub input: &'a Path,
    /// The same; or a folder, in which the result has the name of the input.
    pub output: &'a Path,
    /// A format: the output's where its name does not say, else the input's.
    pub format: Option<&'a str>,
}

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

/// What stands in the name of a file for the number of a level of detail.
pub const LEVEL: &str = "{level}";

/// Whether the name of a file has a place for the level.
pub fn names_level(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().contains(LEVEL))
}

/// The same name with a place for the level: `spot.obj.gz` becomes `spot-lod{level}.obj.gz`.
pub fn with_level(path: &Path) -> PathBuf {
    if names_level(path) {
        return path.into();
    }
    let mut name = Format::without_gz(path).file_stem().unwrap_or_default().to_os_string();
    let ending = path.file_name().unwrap_or_default().as_encoded_bytes().get(name.len()..).unwrap_or_default();
    name.push(format!("-lod{LEVEL}{}", String::from_utf8_lossy(ending)));
    path.with_file_name(name)
}

/// The name without its ending and without the place for the level: what levels share is called after it. None where nothing is left.
pub fn without_level(path: &Path) -> Option<String> {
    let stem = Format::without_gz(path).file_stem()?.to_string_lossy().replace(LEVEL, "");
    let name = stem.trim_matches(['-', '_', '.', ' ']);
    (!name.is_empty()).then(|| name.into())
}

/// The files of so many levels; one where there are none, or the name has no place for the level.
pub fn level_paths(path: &Path, n_levels: usize) -> Vec<PathBuf> {
    let has_levels = n_levels > 0 && names_level(path);
    let Some(name) = path.file_name().filter(|_| has_levels) else { return vec![path.into()] };
    let name = name.to_string_lossy();
    (0..n_levels).map(|level| path.with_file_name(name.replace(LEVEL, &level.to_string()))).collect()
}

/// Refuses more than one mesh from standard input.
pub fn check_stdin<'a>(inputs: impl Iterator<Item = &'a Path>) -> Result<(), Failure> {
    if inputs.filter(|path| is_stream(path)).count() > 1 {
        return Err(Failure::Usage("only one mesh can come from standard input: give files for the others".into()));
    }
    Ok(())
}

/// Refuses a mesh and a report that both go to standard output.
pub fn check_stdout(takes_mesh: bool, takes_report: bool) -> Result<(), Failure> {
    if takes_mesh && takes_report {
        let what = "standard output takes the mesh or the report: give one of them a file name";
        return Err(Failure::Usage(what.into()));
    }
    Ok(())
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
pub fn destination(place: &Place) -> Result<Destination, Failure> {
    let given = place.format.map(format_of).transpose()?;
    let Place { input, output, .. } = *place;
    if is_stream(output) && given.is_none() {
        let (format, follows_input) = (alone(shown(input)), shown(input).is_none());
        return Ok(Destination { path: output.to_path_buf(), format, follows_input });
    }
    let path = if output.is_dir() { in_folder(output, input, given)? } else { output.to_path_buf() };
    Ok(Destination { format: output_format(&path, given)?, path, follows_input: false })
}

/// The format of a mesh, as far as its name says it, or its bytes that it is a glTF.
pub fn shown(path: &Path) -> Option<Format> {
    named(path).or_else(|| (!is_stream(path) && is_gltf_path(path)).then_some(Format::Glb))
}

/// A path in the folder with the name of the input.
fn in_folder(folder: &Path, input: &Path, given: Option<Format>) -> Result<PathBuf, Failure> {
    match input.file_name() {
        Some(name) if !is_stream(input) => {
            Ok(folder.join(with_ending(name.as_ref(), given.or(shown(input)).map_or(Format::Ply, as_result))))
        }
        _ => {
            let what = "is a folder, and standard input has no name: give the name of a file";
            Err(Failure::Usage(format!("{}: {what}", folder.display())))
        }
    }
}

/// A name with the ending of a format; results in folders are not compressed. A VRM, which is a GLB, keeps its own.
pub fn with_ending(name: &Path, format: Format) -> PathBuf {
    let name = Format::without_gz(name);
    if format == Format::Glb && is_vrm(&name) { name.into_owned() } else { name.with_extension(ending(format)) }
}

/// Whether a name ends as that of a VRM.
pub fn is_vrm(path: &Path) -> bool {
    Format::without_gz(path).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("vrm"))
}

/// What names of files in a format end in.
pub fn ending(format: Format) -> &'static str {
    family(format).name()
}

/// The format that standard output takes of what was read: one that needs no file beside it; PLY where it is not known.
pub fn alone(read: Option<Format>) -> Format {
    match read {
        Some(Format::Gltf) => Format::Glb,
        read => read.map_or(Format::Ply, as_result),
    }
}

/// The format of a result where none is asked for: that of its mesh, or GLB where that is read and not written.
pub fn as_result(read: Format) -> Format {
    if read == Format::Fbx { Format::Glb } else { read }
}

/// The format to write: what the name says, else what `--format` says; the two may not disagree where only one is meant.
pub fn output_format(output: &Path, given: Option<Format>) -> Result<Format, Failure> {
    let format = named(output).or(given).ok_or_else(|| unknown_format(output))?;
    // `--format ply-ascii -o x.ply` asks for the text variant of what the name says.
    writable(given.filter(|given| family(*given) == family(format)).unwrap_or(format))
}

/// A format, if this build writes it.
pub fn writable(format: Format) -> Result<Format, Failure> {
    write_obstacle(format).map_or(Ok(format), |what| Err(Failure::Usage(format!("{}: {what}", format.name()))))
}

fn unknown_format(output: &Path) -> Failure {
    let is_written = |name: &&str| Format::from_name(name).is_some_and(|format| write_obstacle(format).is_none());
    let names = Format::NAMES.into_iter().filter(is_written).collect::<Vec<_>>().join(", ");
    let ends_as_folder = output.as_os_str().as_encoded_bytes().last().is_some_and(|&last| last == b'/');
    Failure::Usage(match output {
        _ if is_stream(output) => format!("standard output: the format is not known: give --format, one of {names}"),
        _ if ends_as_folder => format!("{}: there is no such folder: create it first", output.display()),
        _ => {
            let endings = Format::NAMES.into_iter().filter(is_written).filter(|name| !name.contains('-'));
            let endings = alternatives(endings.map(|name| format!(".{name}")));
            let how = format!("end the name in {endings}, or give --format, one of");
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
