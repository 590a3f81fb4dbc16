//! Interpretation of file names.

use std::path::{Path, PathBuf};

use neural_mesh::io::{Format, can_read, is_gltf_path, write_obstacle};

use crate::failure::Failure;

/// Lists the formats that this build reads, such as `give OBJ, PLY or STL`.
pub fn list_readable_formats() -> String {
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
    format!("give {}", join_alternatives(read))
}

fn join_alternatives(names: impl Iterator<Item = String>) -> String {
    let names: Vec<String> = names.collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// Typed input, output and format of one mesh.
#[derive(Clone, Copy)]
pub struct MeshPaths<'a> {
    pub input: &'a Path,
    /// File, `-` for standard output, or a folder where the file is named like the input.
    pub output: &'a Path,
    /// Format of the output if its name has no known ending, else of the input.
    pub format: Option<&'a str>,
}

#[derive(Debug, PartialEq)]
pub struct Destination {
    pub path: PathBuf,
    pub format: Format,
    /// True if the format is that of the input, which is known only after reading.
    pub takes_input_format: bool,
}

pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

pub const LEVEL_PLACEHOLDER: &str = "{level}";

pub fn has_level_placeholder(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().contains(LEVEL_PLACEHOLDER))
}

/// Adds the placeholder after a mark such as `-lod` if it is missing: `spot.obj.gz` becomes `spot-lod{level}.obj.gz`.
pub fn with_level_placeholder(path: &Path, mark: &str) -> PathBuf {
    if has_level_placeholder(path) {
        return path.into();
    }
    let mut name = Format::without_gz(path).file_stem().unwrap_or_default().to_os_string();
    let ending = path.file_name().unwrap_or_default().as_encoded_bytes().get(name.len()..).unwrap_or_default();
    name.push(format!("{mark}{LEVEL_PLACEHOLDER}{}", String::from_utf8_lossy(ending)));
    path.with_file_name(name)
}

/// Returns the name without ending and placeholder, or `None` if nothing remains.
pub fn stem_without_level(path: &Path) -> Option<String> {
    let stem = Format::without_gz(path).file_stem()?.to_string_lossy().replace(LEVEL_PLACEHOLDER, "");
    let name = stem.trim_matches(['-', '_', '.', ' ']);
    (!name.is_empty()).then(|| name.into())
}

pub fn level_paths(path: &Path, n_levels: usize) -> Vec<PathBuf> {
    let has_levels = n_levels > 0 && has_level_placeholder(path);
    if has_levels { (0..n_levels).filter_map(|level| level_path(path, level)).collect() } else { vec![path.into()] }
}

/// Returns the path of one level, or `None` without a name.
pub fn level_path(path: &Path, level: usize) -> Option<PathBuf> {
    let name = path.file_name()?.to_string_lossy();
    Some(path.with_file_name(name.replace(LEVEL_PLACEHOLDER, &level.to_string())))
}

pub fn check_stdin<'a>(inputs: impl Iterator<Item = &'a Path>) -> Result<(), Failure> {
    if inputs.filter(|path| is_stream(path)).count() > 1 {
        return Err(Failure::Usage("only one mesh can come from standard input: give files for the others".into()));
    }
    Ok(())
}

pub fn check_stdout(takes_mesh: bool, takes_report: bool) -> Result<(), Failure> {
    if takes_mesh && takes_report {
        let what = "standard output takes the mesh or the report: give one of them a file name";
        return Err(Failure::Usage(what.into()));
    }
    Ok(())
}

pub fn parse_format(name: &str) -> Result<Format, Failure> {
    let unknown = || format!("--format {name}: unknown format: choose from {}", Format::NAMES.join(", "));
    Format::from_name(name).ok_or_else(|| Failure::Usage(unknown()))
}

pub fn format_from_path(path: &Path) -> Option<Format> {
    if is_stream(path) { None } else { Format::from_path(path) }
}

/// Resolves the output of one mesh; standard output gets the input's format by default.
pub fn resolve_destination(paths: &MeshPaths) -> Result<Destination, Failure> {
    let given = paths.format.map(parse_format).transpose()?;
    let MeshPaths { input, output, .. } = *paths;
    // The format of a stream is known only after it is read.
    if is_stream(output) && given.is_none() {
        let (format, takes_input_format) = (single_file_format(guess_format(input)), guess_format(input).is_none());
        return Ok(Destination { path: output.to_path_buf(), format, takes_input_format });
    }
    let path = if output.is_dir() { path_in_folder(output, input, given)? } else { output.to_path_buf() };
    // Next to an output name with a known ending, `--format` may describe an input without one.
    let describes_input = |given: Format| {
        format_from_path(&path).is_some_and(|named| binary_variant(named) != binary_variant(given))
            && format_from_path(input).is_none_or(|named| binary_variant(named) == binary_variant(given))
    };
    let format = output_format(&path, given.filter(|given| !describes_input(*given)))?;
    Ok(Destination { format, path, takes_input_format: false })
}

/// Returns the format that the file's name shows, or GLB if the content is a glTF.
pub fn guess_format(path: &Path) -> Option<Format> {
    format_from_path(path).or_else(|| (!is_stream(path) && is_gltf_path(path)).then_some(Format::Glb))
}

fn path_in_folder(folder: &Path, input: &Path, given: Option<Format>) -> Result<PathBuf, Failure> {
    match input.file_name() {
        Some(name) if !is_stream(input) => {
            Ok(folder
                .join(with_ending(name.as_ref(), given.or(guess_format(input)).map_or(Format::Ply, result_format))))
        }
        _ => {
            let what = "is a folder, and standard input has no name: give the name of a file";
            Err(Failure::Usage(format!("{}: {what}", folder.display())))
        }
    }
}

/// Replaces the ending by that of a format, dropping `.gz`; a VRM keeps its ending.
pub fn with_ending(name: &Path, format: Format) -> PathBuf {
    let name = Format::without_gz(name);
    if format == Format::Glb && is_vrm(&name) { name.into_owned() } else { name.with_extension(file_ending(format)) }
}

pub fn is_vrm(path: &Path) -> bool {
    Format::without_gz(path).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("vrm"))
}

pub fn file_ending(format: Format) -> &'static str {
    binary_variant(format).name()
}

/// Returns whether a name is that of a progression.
pub fn is_progression_name(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("nmp"))
}

/// Rejects a progression as the input of a command that reads meshes.
pub fn refuse_progression(path: &Path) -> Result<(), Failure> {
    if !is_progression_name(path) {
        return Ok(());
    }
    let how = format!("neural-mesh simplify {} -o MESH.ply --ratio 100%", path.display());
    Err(Failure::in_file(path, format!("is a progression: write its mesh by `{how}`")))
}

/// Returns the input's format if it fits into one file, else a similar one, else PLY.
pub fn single_file_format(read: Option<Format>) -> Format {
    match read {
        Some(Format::Gltf) => Format::Glb,
        read => read.map_or(Format::Ply, result_format),
    }
}

pub fn result_format(read: Format) -> Format {
    if read == Format::Fbx { Format::Glb } else { read }
}

/// Chooses the output format by the name, else by `--format`, and rejects contradictions.
pub fn output_format(output: &Path, given: Option<Format>) -> Result<Format, Failure> {
    let format = format_from_path(output).or(given).ok_or_else(|| unknown_format(output))?;
    // `--format ply-ascii -o x.ply` means the text variant of the format in the name.
    match given {
        Some(given) if binary_variant(given) != binary_variant(format) => Err(format_conflict(output, given)),
        given => check_writable(given.unwrap_or(format)),
    }
}

fn format_conflict(output: &Path, given: Format) -> Failure {
    let what = format!(
        "--format {0}: the name ends in another format: leave --format out, or end the name in .{1}",
        given.name(),
        file_ending(given)
    );
    Failure::Usage(format!("{}: {what}", output.display()))
}

pub fn check_writable(format: Format) -> Result<Format, Failure> {
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
            let endings = join_alternatives(endings.map(|name| format!(".{name}")));
            let how = format!("end the name in {endings}, or give --format, one of");
            format!("{}: the format is not known: {how} {names}", output.display())
        }
    })
}

fn binary_variant(format: Format) -> Format {
    match format {
        Format::PlyAscii => Format::Ply,
        Format::StlAscii => Format::Stl,
        other => other,
    }
}
