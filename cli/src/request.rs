//! From typed arguments to what will be done, before any file is opened: whatever is wrong here is a usage error.

use std::path::PathBuf;

use neural_mesh::io::{Format, PackOptions};
use neural_mesh::job::{Bound, Count, Goal, Ignored, Job, Names, Repair};
use neural_mesh::simplify::{
    Axis, Effort, Hidden, MirrorPlane, Optimize, Options, Purpose, ScoreSource, Symmetry, Target,
};

use crate::args::{
    AssemblyArg, CompressArg, EffortArg, HiddenArg, IgnoreArg, OptimizeArg, PurposeArg, ScoresArg, SimplifyArgs,
};
use crate::bound::bound;
use crate::compress;
use crate::content::Content;
use crate::failure::Failure;
use crate::level_files::{outputs, shared_name};
use crate::levels::Levels;
use crate::memory;
use crate::names::{Destination, LEVEL, check_stdout, destination, format_of, is_stream, named, names_level, readable};

/// One run of `simplify`, complete and consistent.
#[derive(Debug)]
pub struct Request {
    /// Where the mesh comes from.
    pub source: Source,
    /// What is asked of it, whatever its file; its format is known once the input is read where it follows that.
    pub job: Job,
    /// Where it goes; `None` for standard output.
    pub output: Option<PathBuf>,
    /// Whether the format is that of the input, which shows when it is read.
    pub follows_input: bool,
    /// Whether the mesh is written nowhere: another face takes it as it is.
    pub stays_in_memory: bool,
    /// Bytes of memory that may be taken, where that is bounded by the caller.
    pub memory: Option<u64>,
    /// Where the map goes.
    pub map: Option<PathBuf>,
    /// Whether it is said what holds the result.
    pub explain: bool,
    /// File of the weights; `None` for those that ship.
    pub weights: Option<PathBuf>,
    /// Threads; `None` for one per core.
    pub n_threads: Option<usize>,
    /// Where the report goes.
    pub report: Option<PathBuf>,
    /// Where the picture goes.
    pub picture: Option<PathBuf>,
    /// Where its eye is, as degrees around and above; a view is chosen where it is not said.
    pub view: Option<[f32; 2]>,
    /// Whether it has edges over textures and colours, too.
    pub wires: bool,
    /// Whether anything is said.
    pub quiet: bool,
    /// Whether existing files are replaced.
    pub force: bool,
    /// Whether what was asked for and is not reached is told by the exit code.
    pub strict: bool,
}

/// What to do about an input of unknown format where `--format` may say it, and where that says the format of the output.
const NAMED_OUTPUT: &str = "as the name of OUT says its format, --format may say that of IN";
const UNNAMED_OUTPUT: &str = "--format is for the output";

impl Request {
    /// Whether standard output takes the report.
    pub fn reports_to_stdout(&self) -> bool {
        self.report.as_deref().is_some_and(is_stream)
    }

    /// Names the files of the results, now that their format is known.
    pub fn name_files(&mut self) {
        let name = |path: &PathBuf| path.file_name().unwrap_or("mesh".as_ref()).to_string_lossy().into_owned();
        self.job.names = Names { files: outputs(self).iter().map(name).collect(), shared: shared_name(self) };
    }
}

/// Pieces smaller than that are no part of a print, in percent of the diagonal: 1 mm of 10 cm.
const PIECE_PERCENT: f64 = 1.0;

/// Bits of a coordinate in a glTF of small numbers: what gltfpack takes.
const POSITION_BITS: u32 = 14;

/// Degrees between faces at what `--keep-features` keeps.
const FEATURE_ANGLE: f32 = 30.0;

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
    /// Whether a scene becomes one mesh in any format.
    pub as_one: bool,
    /// What to do where the format is not known.
    pub remedy: String,
    /// What its bytes say.
    pub content: Content,
}

impl Source {
    /// A mesh that is read as `given`, where that is said and its name says nothing.
    pub fn new(path: PathBuf, given: Option<Format>, weld: bool) -> Self {
        let format = given.filter(|_| named(&path).is_none());
        let content = Content::default();
        Self { path, format, last_resort: None, weld, as_one: false, remedy: readable(), content }
    }

    /// Whether it is a glTF scene that stays one: its bytes say so, not its name.
    pub fn is_scene(&self, output: Format) -> bool {
        matches!(output, Format::Gltf | Format::Glb) && self.is_gltf()
    }

    /// Whether it is a glTF that is not asked for as one mesh.
    pub fn is_gltf(&self) -> bool {
        let may_be = self.format.is_none_or(|format| matches!(format, Format::Gltf | Format::Glb));
        may_be && !self.as_one && self.content.is_gltf(&self.path)
    }

    /// A mesh that is read as `given` only where neither its name nor its content says anything.
    fn by_content(path: PathBuf, given: Option<Format>, weld: bool) -> Self {
        Self { last_resort: given, ..Self::new(path, None, weld) }
    }

    /// The same, with what is to be done where the format is not known.
    pub fn unknown(self, remedy: &str) -> Self {
        Self { remedy: format!("{}; {remedy}", readable()), ..self }
    }

    /// The same, as one mesh where that is asked for.
    pub fn united(self, as_one: bool) -> Self {
        Self { as_one, ..self }
    }
}

/// Checks the arguments of `simplify` and fills in what they leave open.
pub fn resolve(args: SimplifyArgs) -> Result<Request, Failure> {
    check_single(&args)?;
    let Destination { path: output, format, follows_input } = destination(&args)?;
    let source = source(&args)?;
    let mut request = Request {
        job: job(&args, (!follows_input).then_some(format))?,
        strict: strict(&args)?,
        memory: args.memory.map(memory::bytes_of),
        map: args.map,
        explain: args.explain,
        output: (!is_stream(&output)).then_some(output),
        source,
        follows_input,
        stays_in_memory: false,
        weights: args.weights,
        n_threads: args.threads,
        report: args.report.or_else(|| args.json.then(|| "-".into())),
        picture: args.picture,
        view: args.view,
        wires: args.wires,
        quiet: args.quiet,
        force: args.force,
    };
    (request.job.format, request.job.shapes) = (format, request.report.is_some());
    request.name_files();
    check_streams(&request).and_then(|()| check_level(&request))?;
    Ok(request)
}

/// What is asked of a mesh that is written in a format; `None` where that is not known yet.
pub fn job(args: &SimplifyArgs, format: Option<Format>) -> Result<Job, Failure> {
    let mut job = Job::new(options(args)?, format.unwrap_or(Format::Glb));
    (job.goal, job.shares) = (goal(args)?, shares(args));
    (job.weld, job.weld_near) = (!args.no_weld, weld_near(args)?);
    (job.seam_texels, job.prune_below) = (args.seam_error, prune_below(args)?);
    (job.repair, job.compress) = (repair(args)?, compress(args)?);
    (job.bake, job.textures) = (args.bake, args.textures);
    job.ignore = args.ignore.iter().copied().map(Ignored::from).collect();
    (job.importance, job.keep) = (args.importance.clone(), args.keep.clone());
    (job.allow_outside, job.check) = (args.allow_outside, !args.no_check);
    let checked = if format.is_some() { job.check() } else { job.check_options() };
    checked.map_err(|error| Failure::Usage(error.to_string()))?;
    Ok(job)
}

impl From<IgnoreArg> for Ignored {
    fn from(arg: IgnoreArg) -> Self {
        match arg {
            IgnoreArg::Uv => Self::Uv,
            IgnoreArg::Normals => Self::Normals,
            IgnoreArg::Colors => Self::Colors,
            IgnoreArg::Materials => Self::Materials,
        }
    }
}

/// Where the mesh comes from. `--format` is the output's where its name does not say, else the input's.
fn source(args: &SimplifyArgs) -> Result<Source, Failure> {
    let format = args.format.as_deref().map(format_of).transpose()?;
    let path = args.inputs.first().cloned().unwrap_or_default();
    let source = match named(&args.output).filter(|_| !args.output.is_dir()) {
        Some(_) => Source::new(path, format, !args.no_weld).unknown(NAMED_OUTPUT),
        None => Source::by_content(path, format, !args.no_weld).unknown(UNNAMED_OUTPUT),
    };
    Ok(source.united(args.bake.is_some()))
}

/// What only a batch has a use for.
fn check_single(args: &SimplifyArgs) -> Result<(), Failure> {
    if args.resume {
        return Err(Failure::Usage("--resume is for batches: give a folder, a pattern or --list".into()));
    }
    memory::bound(args.memory);
    Ok(())
}

/// What is asked of the simplifier.
fn options(args: &SimplifyArgs) -> Result<Options, Failure> {
    let mut options = Options::new(target(args)?);
    options.assembly = args.assembly.into();
    options.scores = match args.scores {
        None if args.weights.is_some() => ScoreSource::Network,
        None | Some(ScoresArg::Bending) => ScoreSource::Bending,
        Some(ScoresArg::Network) => ScoreSource::Network,
        Some(ScoresArg::Geometry) => ScoreSource::Geometry,
    };
    options.optimize = optimize(args.optimize);
    options.effort = effort(args.effort);
    if args.scores == Some(ScoresArg::Geometry) {
        check_no_network("--scores geometry", args)?;
    } else if args.scores == Some(ScoresArg::Bending) {
        check_no_network("--scores bending", args)?;
    } else if options.optimize == Optimize::Mean {
        check_no_network("--optimize mean", args)?;
    }
    options.seed = args.seed;
    options.prune = !args.keep_components;
    options.hidden = hidden(args.hidden);
    options.purpose = purpose(args.purpose);
    options.lock_boundaries = args.lock_boundaries;
    options.subset = args.subset;
    options.close = args.close;
    options.map = args.map.is_some();
    options.crease_angle = args.keep_features.then_some(FEATURE_ANGLE).or(args.crease_angle.map(|x| x as f32));
    options.symmetric = args.symmetric.as_ref().map(|plane| symmetry(plane.as_deref())).transpose()?;
    Ok(options)
}

fn optimize(figure: OptimizeArg) -> Optimize {
    match figure {
        OptimizeArg::Balanced => Optimize::Balanced,
        OptimizeArg::Mean => Optimize::Mean,
        OptimizeArg::Max => Optimize::Max,
        OptimizeArg::Normals => Optimize::Normals,
    }
}

fn effort(effort: EffortArg) -> Effort {
    match effort {
        EffortArg::Fast => Effort::Fast,
        EffortArg::Standard => Effort::Standard,
        EffortArg::Best => Effort::Best,
    }
}

fn hidden(what: HiddenArg) -> Hidden {
    match what {
        HiddenArg::Keep => Hidden::Keep,
        HiddenArg::Cheap => Hidden::Cheap,
        HiddenArg::Drop => Hidden::Drop,
    }
}

fn purpose(of: PurposeArg) -> Purpose {
    match of {
        PurposeArg::Shape => Purpose::Shape,
        PurposeArg::Poses => Purpose::Poses,
        PurposeArg::Spectrum => Purpose::Spectrum,
    }
}

/// The plane of a symmetry as typed: nothing, `x`, `x=0.5`.
fn symmetry(text: Option<&str>) -> Result<Symmetry, Failure> {
    let Some(text) = text else { return Ok(Symmetry::Found) };
    let (name, at) = text.split_once('=').map_or((text, None), |(name, at)| (name, Some(at)));
    let axis = Axis::ALL.into_iter().find(|axis| name.trim().eq_ignore_ascii_case(&axis.to_string()));
    let at = at.map(|at| at.trim().parse().ok().filter(|at: &f64| at.is_finite()));
    match (axis, at) {
        (Some(axis), None) => Ok(Symmetry::Across(axis)),
        (Some(axis), Some(Some(at))) => Ok(Symmetry::Plane(MirrorPlane { axis, at })),
        _ => Err(Failure::Usage(format!("--symmetric={text}: give x, y or z, or a plane like x=0.5"))),
    }
}

/// What is asked for beside a number of vertices or faces.
fn goal(args: &SimplifyArgs) -> Result<Goal, Failure> {
    if let Some(Count::Share(share)) = args.faces {
        return Ok(Goal::ShareOfFaces(share));
    }
    match (&args.error, &args.size) {
        (Some(text), _) => bound("--error", text).map(Goal::Error),
        (_, Some(text)) => n_bytes(text).map(Goal::Size),
        _ if !args.lods.is_empty() => Ok(match Levels::of(&args.lods, args.lods_by)? {
            Levels::Sizes(sizes) => Goal::Levels(sizes),
            Levels::Errors(bounds) => Goal::ErrorLevels(bounds),
        }),
        _ => Ok(Goal::Target),
    }
}

/// Whether a result that is short of what was asked is told by the exit code: a bound always, a size on request.
pub fn strict(args: &SimplifyArgs) -> Result<bool, Failure> {
    Ok(args.strict || goal(args)?.is_bound())
}

/// The size below which components are dropped: as given, or the distance asked for.
fn prune_below(args: &SimplifyArgs) -> Result<Option<Bound>, Failure> {
    match (&args.prune, &args.error) {
        (Some(Some(text)), _) => bound("--prune", text).map(Some),
        (Some(None), Some(error)) => bound("--error", error).map(Some),
        _ => Ok(None),
    }
}

/// What is done to the mesh before it is simplified.
fn repair(args: &SimplifyArgs) -> Result<Option<Repair>, Failure> {
    match (&args.printable, args.fill_holes) {
        (Some(size), _) => {
            let size = size.as_ref().map_or(Ok(Bound::Percent(PIECE_PERCENT)), |text| bound("--printable", text))?;
            Ok(Some(Repair::Printable(size)))
        }
        (_, Some(most_edges)) => Ok(Some(Repair::FillHoles(most_edges.unwrap_or(usize::MAX)))),
        _ => Ok(None),
    }
}

/// How the numbers of a result are packed, where that is asked for.
fn compress(args: &SimplifyArgs) -> Result<Option<PackOptions>, Failure> {
    let Some(how) = args.compress else { return Ok(None) };
    let compress = how == CompressArg::Meshopt;
    if compress {
        compress::check()?;
    }
    Ok(Some(PackOptions { bits: POSITION_BITS, compress }))
}

/// The distance below which vertices become one.
fn weld_near(args: &SimplifyArgs) -> Result<Option<Bound>, Failure> {
    args.weld.as_ref().map(|text| bound("--weld", text)).transpose()
}

/// A size as typed: `200000`, `500kB`, `2MB`.
fn n_bytes(text: &str) -> Result<usize, Failure> {
    let binary = [("kib", 1024.0), ("mib", 1048576.0), ("gib", 1073741824.0)];
    let decimal = [("kb", 1e3), ("mb", 1e6), ("gb", 1e9), ("k", 1e3), ("m", 1e6), ("g", 1e9), ("b", 1.0)];
    let lower = text.to_ascii_lowercase();
    let found = binary.iter().chain(&decimal).find_map(|(unit, factor)| Some((lower.strip_suffix(unit)?, *factor)));
    let (number, factor) = found.unwrap_or((&lower, 1.0));
    let value = number.trim().parse().ok().map(|x: f64| x * factor).filter(|x| *x >= 1.0 && *x < 1e15);
    value.map(|x| x as usize).ok_or_else(|| Failure::Usage(format!("--size {text}: give bytes, like 500kB or 2MB")))
}

/// Where every vertex counts by its area, a network has nothing to do.
fn check_no_network(option: &str, args: &SimplifyArgs) -> Result<(), Failure> {
    let why = match (args.assembly, &args.weights) {
        (AssemblyArg::Paper, _) => "the paper's assembly needs a network: use --assembly closed",
        (_, Some(_)) => "it uses no network: leave --weights out",
        _ => return Ok(()),
    };
    Err(Failure::Usage(format!("{option}: {why}")))
}

/// Returns the names with shares of their own.
fn shares(args: &SimplifyArgs) -> Vec<(String, f64)> {
    args.ratio.iter().filter_map(|of| Some((of.name.clone()?, of.share))).collect()
}

/// Returns the share of the whole, where that is its size.
///
/// # Errors
/// [`Failure::Usage`] where the whole has several sizes.
fn whole_ratio(args: &SimplifyArgs) -> Result<Option<f64>, Failure> {
    let whole: Vec<f64> = args.ratio.iter().filter(|of| of.name.is_none()).map(|of| of.share).collect();
    let sizes = [
        ("--vertices", args.vertices.is_some()),
        ("--faces", args.faces.is_some()),
        ("--error", args.error.is_some()),
        ("--size", args.size.is_some()),
        ("--lods", !args.lods.is_empty()),
        ("a second one", whole.len() > 1),
    ];
    if let Some((other, _)) = sizes.into_iter().find(|(_, is_given)| *is_given && !whole.is_empty()) {
        let what = format!("--ratio cannot be used with {other}: give one size of the whole, and others as NAME=R");
        return Err(Failure::Usage(what));
    }
    Ok(whole.first().copied())
}

/// The size, as far as it is known before the mesh is.
fn target(args: &SimplifyArgs) -> Result<Target, Failure> {
    let ratio = whole_ratio(args)?;
    // Shares of the faces are numbers when the mesh is known.
    if let (Goal::Levels(sizes), false) = (goal(args)?, args.lods.is_empty()) {
        return Ok(sizes.first().map_or(Target::Ratio(1.0), |size| size.target(usize::MAX)));
    }
    Ok(match (ratio, args.vertices, args.faces) {
        (Some(ratio), _, _) | (_, Some(Count::Share(ratio)), _) => Target::Ratio(ratio),
        (_, Some(Count::Number(n)), _) => Target::Vertices(n),
        (_, _, Some(Count::Number(n))) => Target::Faces(n),
        _ => Target::Ratio(1.0),
    })
}

/// The level has a place in the name of what has levels.
fn check_level(request: &Request) -> Result<(), Failure> {
    match (&request.output, &request.job.goal) {
        (_, Goal::Levels(_) | Goal::ErrorLevels(_)) | (None, _) => Ok(()),
        (Some(path), _) if !names_level(path) => Ok(()),
        (Some(path), _) => {
            let what = format!("{}: {LEVEL} is for levels of detail: ask for them with --lods", path.display());
            Err(Failure::Usage(what))
        }
    }
}

/// Standard output takes the mesh or the report.
fn check_streams(request: &Request) -> Result<(), Failure> {
    if [&request.picture, &request.map].into_iter().flatten().any(|path| is_stream(path)) {
        return Err(Failure::Usage("picture and map are files: give each a name".into()));
    }
    check_stdout(request.output.is_none(), request.reports_to_stdout())
}
