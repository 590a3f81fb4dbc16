//! From typed arguments to what will be done, before any file is opened: whatever is wrong here is a usage error.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use neural_mesh::io::Format;
use neural_mesh::job::{Arguments, Count, Goal, Job, JobError, Names, Value};

use crate::args::{LodsByArg, SimplifyArgs};
use crate::content::Content;
use crate::failure::Failure;
use crate::memory;
use crate::names::{
    Destination, LEVEL, Place, check_stdout, destination, format_of, is_stream, level_paths, named, names_level,
    readable, with_level, without_level,
};

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
const NAMED_OUTPUT: &str = "--format sets the format of IN where the name of OUT has a known ending";
const UNNAMED_OUTPUT: &str = "--format is for the output";

/// What levels share whose files say nothing but their level.
const SHARED: &str = "levels";

impl Request {
    /// Whether standard output takes the report.
    pub fn reports_to_stdout(&self) -> bool {
        self.report.as_deref().is_some_and(is_stream)
    }

    /// The end of its job as the program's.
    pub fn failure(&self, error: JobError) -> Failure {
        match error {
            JobError::Interrupted => Failure::Interrupted,
            JobError::Options(text) => Failure::Usage(text),
            JobError::Output(text) => Failure::of(self.output.as_deref().unwrap_or(Path::new("standard output")), text),
            other => Failure::of(&self.source.path, other),
        }
    }

    /// Names the files of the results, now that their format is known.
    pub fn name_files(&mut self) {
        let name = |path: &PathBuf| path.file_name().unwrap_or("mesh".as_ref()).to_string_lossy().into_owned();
        self.job.names = Names { files: self.outputs().iter().map(name).collect(), shared: self.shared_name() };
    }

    /// Where the mesh goes, or each level of detail; those of a scene are one file where the name has no place for the level.
    pub fn outputs(&self) -> Vec<PathBuf> {
        let Some(path) = &self.output else { return Vec::new() };
        let Some(n_levels) = self.job.goal.n_levels() else { return vec![path.clone()] };
        let is_scene = self.source.is_scene(self.job.format);
        level_paths(&if is_scene { path.clone() } else { with_level(path) }, n_levels)
    }

    /// The name after which files are called that levels share, where there are such levels.
    fn shared_name(&self) -> Option<String> {
        let (path, _) = (self.output.as_deref()?, self.job.goal.n_levels()?);
        Some(without_level(path).unwrap_or_else(|| SHARED.into()))
    }
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

impl Request {
    /// From one place to the other, with nothing said or drawn beside.
    pub fn new(place: &Place, arguments: &Arguments) -> Result<Self, Failure> {
        let Destination { path: output, format, follows_input } = destination(place)?;
        let mut job = job(arguments, (!follows_input).then_some(format))?;
        job.format = format;
        let mut request = Self {
            source: source(place, !arguments.no_weld)?.united(arguments.bake.is_some()),
            strict: job.goal.is_bound(),
            job,
            memory: None,
            map: None,
            explain: false,
            output: (!is_stream(&output)).then_some(output),
            follows_input,
            stays_in_memory: false,
            weights: None,
            n_threads: None,
            report: None,
            picture: None,
            view: None,
            wires: false,
            quiet: true,
            force: false,
        };
        request.name_files();
        check_level(&request)?;
        Ok(request)
    }
}

/// Checks the arguments of `simplify` and fills in what they leave open.
pub fn resolve(args: SimplifyArgs) -> Result<Request, Failure> {
    check_single(&args)?;
    let input = args.inputs.first().map_or(Path::new(""), PathBuf::as_path);
    let place = Place { input, output: &args.output, format: args.format.as_deref() };
    let bare = Request::new(&place, &arguments(&args)?)?;
    let mut request = Request {
        strict: args.strict || bare.strict,
        memory: args.memory.map(memory::bytes_of),
        map: args.map,
        explain: args.explain,
        weights: args.weights,
        n_threads: args.threads,
        report: args.report.or_else(|| args.json.then(|| "-".into())),
        picture: args.picture,
        view: args.view,
        wires: args.wires,
        quiet: args.quiet,
        force: args.force,
        ..bare
    };
    request.job.shapes = request.report.is_some();
    check_streams(&request)?;
    Ok(request)
}

/// What is asked of a mesh that is written in a format; `None` where that is not known yet.
pub fn job(arguments: &Arguments, format: Option<Format>) -> Result<Job, Failure> {
    let failed = |error: JobError| Failure::Usage(error.to_string());
    let job = arguments.job_as(format.unwrap_or(Format::Glb)).map_err(failed)?;
    format.map_or(Ok(()), |_| job.check_format()).map_err(failed)?;
    Ok(job)
}

/// The options of the command line as those of a job.
pub fn arguments(args: &SimplifyArgs) -> Result<Arguments, Failure> {
    let number = |count: Count| Value::Text(count.to_string());
    let text = |text: &String| Value::Text(text.clone());
    let optional =
        |value: &Option<Option<String>>| value.as_ref().map(|it| it.as_ref().map_or(Value::Flag(true), text));
    let whole: Vec<f64> = args.ratio.iter().filter(|of| of.name.is_none()).map(|of| of.share).collect();
    if whole.len() > 1 {
        let what = "--ratio cannot be used with a second one: give one size of the whole, and others as NAME=R";
        return Err(Failure::Usage(what.into()));
    }
    Ok(Arguments {
        ratio: whole.first().copied().map(Value::Number),
        ratio_of: args.ratio.iter().filter_map(|of| Some((of.name.clone()?, of.share.into()))).collect(),
        vertices: args.vertices.map(number),
        faces: args.faces.map(number),
        error: args.error.as_ref().map(text),
        size: args.size.as_ref().map(text),
        lods: args.lods.iter().map(text).collect(),
        lods_by: args.lods_by.as_ref().map(name_of),
        symmetric: optional(&args.symmetric),
        prune: optional(&args.prune),
        fill_holes: args.fill_holes.map(|most| most.map_or(Value::Flag(true), |most| Value::Text(most.to_string()))),
        printable: optional(&args.printable),
        compress: args.compress.as_ref().map(|how| Value::Text(name_of(how))),
        weld: args.weld.as_ref().map(text),
        ..plain_arguments(args)
    })
}

/// Those among them that have a value of their own kind.
fn plain_arguments(args: &SimplifyArgs) -> Arguments {
    Arguments {
        assembly: Some(name_of(&args.assembly)),
        scores: args.scores.as_ref().map(name_of),
        optimize: Some(name_of(&args.optimize)),
        effort: Some(name_of(&args.effort)),
        hidden: Some(name_of(&args.hidden)),
        purpose: Some(name_of(&args.purpose)),
        seed: args.seed,
        lock_boundaries: args.lock_boundaries,
        subset: args.subset,
        close: args.close,
        place: args.place,
        keep_components: args.keep_components,
        keep_features: args.keep_features,
        crease_angle: args.crease_angle,
        seam_error: args.seam_error,
        ignore: args.ignore.iter().map(name_of).collect(),
        keep: args.keep.clone(),
        importance: args.importance.clone(),
        map: args.map.is_some(),
        bake: args.bake,
        textures: args.textures,
        no_weld: args.no_weld,
        no_check: args.no_check,
        allow_outside: args.allow_outside,
        has_weights: args.weights.is_some(),
        ..Arguments::default()
    }
}

/// What a value of an option is called.
fn name_of(value: &impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().into())
}

/// Where the mesh comes from. `--format` is the output's where its name does not say, else the input's.
fn source(place: &Place, weld: bool) -> Result<Source, Failure> {
    let format = place.format.map(format_of).transpose()?;
    let path = place.input.to_path_buf();
    Ok(match named(place.output).filter(|_| !place.output.is_dir()) {
        Some(_) => Source::new(path, format, weld).unknown(NAMED_OUTPUT),
        None => Source::by_content(path, format, weld).unknown(UNNAMED_OUTPUT),
    })
}

/// What only a batch has a use for.
fn check_single(args: &SimplifyArgs) -> Result<(), Failure> {
    if args.resume {
        return Err(Failure::Usage("--resume is for batches: give a folder, a pattern or --list".into()));
    }
    memory::bound(args.memory);
    Ok(())
}

/// Whether a result that is short of what was asked is told by the exit code: a bound always, a size on request.
pub fn strict(args: &SimplifyArgs) -> bool {
    args.strict || args.error.is_some() || args.size.is_some() || args.lods_by == Some(LodsByArg::Error)
}

/// The level has a place in the name of what has levels.
fn check_level(request: &Request) -> Result<(), Failure> {
    match (&request.output, &request.job.goal) {
        (_, Goal::Levels(_) | Goal::ErrorLevels(_)) | (None, _) => Ok(()),
        (Some(path), _) if !names_level(path) => Ok(()),
        (Some(path), _) => {
            let what = format!("{}: {LEVEL} is for levels of detail: add --lods", path.display());
            Err(Failure::Usage(what))
        }
    }
}

/// Standard output takes the mesh or the report.
fn check_streams(request: &Request) -> Result<(), Failure> {
    if [&request.picture, &request.map].into_iter().flatten().any(|path| is_stream(path)) {
        return Err(Failure::Usage("--picture and --map need the name of a file".into()));
    }
    check_stdout(request.output.is_none(), request.reports_to_stdout())
}
