//! From typed arguments to what will be done, before any file is opened: whatever is wrong here is a usage error.

use std::path::{Path, PathBuf};

use neural_mesh::io::Format;
use neural_mesh::simplify::{Assembly, Options, ScoreSource, Target};

use crate::args::{AssemblyArg, ScoresArg, SimplifyArgs};
use crate::failure::Failure;

/// More threads than any machine has, fewer than a system refuses to start.
const MOST_THREADS: usize = 1024;

/// One run of `simplify`, complete and consistent.
#[derive(Debug)]
pub struct Request {
    /// Where the mesh comes from.
    pub source: Source,
    /// Where it goes; `None` for standard output.
    pub output: Option<PathBuf>,
    /// The format it is written in.
    pub output_format: Format,
    /// What is asked of the simplifier.
    pub options: Options,
    /// File of the weights; `None` for those that ship.
    pub weights: Option<PathBuf>,
    /// Threads; `None` for one per core.
    pub n_threads: Option<usize>,
    /// Whether the distance is measured.
    pub check: bool,
    /// Where the report goes.
    pub report: Option<PathBuf>,
    /// Where the picture goes.
    pub picture: Option<PathBuf>,
    /// Whether anything is said.
    pub quiet: bool,
    /// Whether existing files are replaced.
    pub force: bool,
}

/// Where a mesh comes from and how it is read.
#[derive(Debug)]
pub struct Source {
    /// A path, or `-` for standard input.
    pub path: PathBuf,
    /// The format, where the arguments say it and the name does not.
    pub format: Option<Format>,
    /// The format to try if neither name nor content say it.
    pub last_resort: Option<Format>,
    /// Whether vertices at equal positions become one.
    pub weld: bool,
}

impl Source {
    /// A mesh that is read as `given`, where that is said and its name says nothing.
    pub fn new(path: PathBuf, given: Option<Format>, weld: bool) -> Self {
        let format = given.filter(|_| named(&path).is_none());
        Self { path, format, last_resort: None, weld }
    }

    /// A mesh that is read as `given` only where neither its name nor its content says anything.
    fn by_content(path: PathBuf, given: Option<Format>, weld: bool) -> Self {
        Self { path, format: None, last_resort: given, weld }
    }
}

/// Checks the arguments of `simplify` and fills in what they leave open.
pub fn resolve(args: SimplifyArgs) -> Result<Request, Failure> {
    check_single(&args)?;
    let format = args.format.as_deref().map(format_of).transpose()?;
    let output_format = output_format(&args.output, format)?;
    // `--format` is the output's where its name does not say, else the input's.
    let source = if named(&args.output).is_some() { Source::new } else { Source::by_content };
    let request = Request {
        options: options(&args)?,
        output: (!is_stream(&args.output)).then_some(args.output),
        source: source(args.inputs.into_iter().next().unwrap_or_default(), format, !args.no_weld),
        output_format,
        weights: args.weights,
        n_threads: args.threads,
        check: !args.no_check,
        report: args.report,
        picture: args.picture,
        quiet: args.quiet,
        force: args.force,
    };
    check_threads(request.n_threads)?;
    check_paths(&request)?;
    Ok(request)
}

/// The format with that name.
pub fn format_of(name: &str) -> Result<Format, Failure> {
    let unknown = || format!("--format {name}: no such format: give one of {}", Format::NAMES.join(", "));
    Format::from_name(name).ok_or_else(|| Failure::Usage(unknown()))
}

/// Whether a path stands for standard input or output.
pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// What only a batch has a use for.
fn check_single(args: &SimplifyArgs) -> Result<(), Failure> {
    match args.resume || args.memory.is_some() {
        true => Err(Failure::Usage("--resume and --memory are for batches: give a folder, a pattern or --list".into())),
        false => Ok(()),
    }
}

/// What is asked of the simplifier.
pub fn options(args: &SimplifyArgs) -> Result<Options, Failure> {
    let mut options = Options::new(target(args)?);
    options.assembly = match args.assembly {
        AssemblyArg::Closed => Assembly::Closed,
        AssemblyArg::Paper => Assembly::Paper,
    };
    options.scores = match args.scores {
        ScoresArg::Network => ScoreSource::Network,
        ScoresArg::Geometry => ScoreSource::Geometry,
    };
    if options.scores == ScoreSource::Geometry {
        check_no_network(args)?;
    }
    if let Some(x) = args.oversample.filter(|x| !(1.0..=4.0).contains(x)) {
        return Err(Failure::Usage(format!("--oversample {x}: give a number from 1 to 4")));
    }
    options.oversample = args.oversample;
    options.seed = args.seed;
    options.prune = args.prune;
    Ok(options)
}

/// Scores from the geometry leave a network nothing to do.
fn check_no_network(args: &SimplifyArgs) -> Result<(), Failure> {
    let why = match (args.assembly, &args.weights) {
        (AssemblyArg::Paper, _) => "its faces are a network's choice: use --assembly closed",
        (_, Some(_)) => "it asks no network: leave --weights out",
        _ => return Ok(()),
    };
    Err(Failure::Usage(format!("--scores geometry: {why}")))
}

fn target(args: &SimplifyArgs) -> Result<Target, Failure> {
    match (args.ratio, args.vertices, args.faces) {
        (Some(ratio), _, _) if ratio > 0.0 && ratio <= 1.0 => Ok(Target::Ratio(ratio)),
        (Some(ratio), _, _) => Err(Failure::Usage(format!("--ratio {ratio}: give a number above 0 and at most 1"))),
        (_, Some(n), _) if n > 0 => Ok(Target::Vertices(n)),
        (_, _, Some(n)) if n > 0 => Ok(Target::Faces(n)),
        _ => Err(Failure::Usage("a mesh of size 0 is none: give --ratio R, --vertices N or --faces N above 0".into())),
    }
}

/// The format to write: what the name says, else what `--format` says; the two may not disagree where only one is meant.
pub fn output_format(output: &Path, given: Option<Format>) -> Result<Format, Failure> {
    let format = named(output).or(given).ok_or_else(|| {
        let where_to = if is_stream(output) { "standard output".into() } else { output.display().to_string() };
        Failure::Usage(format!("{where_to}: the format is not known: give --format obj, ply, stl or off"))
    })?;
    if matches!(format, Format::Gltf | Format::Glb) {
        return Err(Failure::Usage("glTF is read but not written: choose obj, ply, stl or off for OUT".into()));
    }
    // `--format ply-ascii -o x.ply` asks for the text variant of what the name says.
    Ok(given.filter(|given| family(*given) == family(format)).unwrap_or(format))
}

/// The format that a name says.
fn named(path: &Path) -> Option<Format> {
    if is_stream(path) { None } else { Format::from_path(path) }
}

/// The variants of a format are one family.
fn family(format: Format) -> Format {
    match format {
        Format::PlyAscii => Format::Ply,
        Format::StlAscii => Format::Stl,
        other => other,
    }
}

/// Refuses numbers of threads that no system starts.
pub fn check_threads(n_threads: Option<usize>) -> Result<(), Failure> {
    match n_threads {
        Some(n) if !(1..=MOST_THREADS).contains(&n) => {
            Err(Failure::Usage(format!("--threads {n}: give a number from 1 to {MOST_THREADS}")))
        }
        _ => Ok(()),
    }
}

/// Two results cannot go to one file, and only the mesh can go to standard output.
fn check_paths(request: &Request) -> Result<(), Failure> {
    let paths: Vec<&PathBuf> = [&request.output, &request.report, &request.picture].into_iter().flatten().collect();
    for (index, path) in paths.iter().enumerate() {
        if is_stream(path) {
            return Err(Failure::Usage(
                "only the mesh goes to standard output: give report and picture a file name".into(),
            ));
        }
        if paths[..index].contains(path) {
            return Err(Failure::Usage(format!("{}: named twice: give each result a file of its own", path.display())));
        }
    }
    Ok(())
}
