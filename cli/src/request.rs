//! Turns typed arguments into checked requests before any file is opened.

use std::path::{Path, PathBuf};

use neural_mesh::io::{FilesRead, Format};
use neural_mesh::job::{Arguments, Engine, Goal, Job, JobError, LodsBy, Names};

use crate::args::SimplifyArgs;
use crate::content::Content;
use crate::failure::Failure;
use crate::files;
use crate::memory;
use crate::names::{
    Destination, LEVEL_PLACEHOLDER, MeshPaths, check_stdout, format_from_path, has_level_placeholder, is_stream,
    level_path, level_paths, list_readable_formats, parse_format, resolve_destination, stem_without_level,
    with_level_placeholder,
};

#[derive(Debug)]
pub struct Request {
    pub source: Source,
    /// Options of the job; the output format may be set after reading.
    pub job: Job,
    /// Output file; `None` for standard output.
    pub output: Option<PathBuf>,
    /// True if the output format is that of the input, which is known only after reading.
    pub takes_input_format: bool,
    /// True if the mesh is returned to another program and not written.
    pub stays_in_memory: bool,
    /// Memory bound in bytes, if the caller set one.
    pub memory: Option<u64>,
    pub map: Option<PathBuf>,
    pub explain: bool,
    pub weights: Option<PathBuf>,
    pub n_threads: Option<usize>,
    pub report: Option<PathBuf>,
    pub picture: Option<PathBuf>,
    /// View of the picture in degrees around and above; `None` chooses one.
    pub view: Option<[f32; 2]>,
    pub wires: bool,
    pub quiet: bool,
    pub force: bool,
    pub strict: bool,
    /// Files that the run reads, if the arguments name them.
    pub read: FilesRead,
}

/// Advice for an input of unknown format, where OUT has a known ending and where not.
const ADVICE_FOR_NAMED_OUTPUT: &str = "--format NAME sets the format of IN, as the name of OUT has a known ending";
const ADVICE_FOR_UNNAMED_OUTPUT: &str =
    "--format NAME sets the format of the result, and that of IN if nothing else shows it";

/// Name of a file that levels share, if the given name is only the placeholder.
const SHARED_NAME: &str = "levels";

impl Request {
    pub fn reports_to_stdout(&self) -> bool {
        self.report.as_deref().is_some_and(is_stream)
    }

    pub fn failure(&self, error: JobError) -> Failure {
        match error {
            JobError::Interrupted => Failure::Interrupted,
            JobError::Options(_) | JobError::Feature { .. } => to_usage_failure(&error),
            JobError::Output(text) => {
                Failure::in_file(self.output.as_deref().unwrap_or(Path::new("standard output")), text)
            }
            other => Failure::in_file(&self.source.path, other),
        }
    }

    pub fn name_files(&mut self) {
        let name = |path: &PathBuf| path.file_name().unwrap_or("mesh".as_ref()).to_string_lossy().into_owned();
        let folder = self.output.as_ref().map(|path| path.parent().unwrap_or(Path::new("")).to_path_buf());
        let files = self.outputs().iter().map(name).collect();
        self.job.names = Names { files, shared: self.shared_name(), folder, ..self.job.names.clone() };
    }

    /// Returns the output files, one per level; levels of a scene share a file without the placeholder.
    pub fn outputs(&self) -> Vec<PathBuf> {
        let Some(path) = self.path_of_levels() else { return Vec::new() };
        let n_levels = self.job.goal.n_levels();
        n_levels.map_or_else(|| vec![path.clone()], |n_levels| level_paths(&path, n_levels))
    }

    /// Returns the output file, with the placeholder if each level has its own.
    fn path_of_levels(&self) -> Option<PathBuf> {
        let path = self.output.as_ref()?;
        // Only levels need the content of the file.
        let has_levels = self.job.goal.n_levels().is_some();
        let is_split = has_levels && self.job.has_file_per_level(self.source.is_scene(self.job.format));
        Some(if is_split { with_level_placeholder(path, mark_levels(self.job.arguments.engine)) } else { path.clone() })
    }

    /// Lists files of further levels than the run writes, as a run with more levels leaves them.
    pub fn older_levels(&self, n_levels: usize) -> Vec<PathBuf> {
        let path =
            self.path_of_levels().filter(|path| self.job.goal.n_levels().is_some() && has_level_placeholder(path));
        let further = path.into_iter().flat_map(|path| (n_levels..).filter_map(move |level| level_path(&path, level)));
        further.take_while(|path| path.symlink_metadata().is_ok()).collect()
    }

    fn shared_name(&self) -> Option<String> {
        let (path, _) = (self.output.as_deref()?, self.job.goal.n_levels()?);
        Some(stem_without_level(path).unwrap_or_else(|| SHARED_NAME.into()))
    }
}

#[derive(Debug)]
pub struct Source {
    pub path: PathBuf,
    /// Format from the arguments, if the input's name has no known ending.
    pub format: Option<Format>,
    /// Format to try if neither the input's name nor its content shows one.
    pub last_resort: Option<Format>,
    pub weld: bool,
    /// True if a glTF scene is joined into one mesh, whatever the output format.
    pub joins_scene: bool,
    pub remedy: String,
    pub content: Content,
}

impl Source {
    pub fn new(path: PathBuf, given: Option<Format>, weld: bool) -> Self {
        let format = given.filter(|_| format_from_path(&path).is_none());
        let content = Content::default();
        Self { path, format, last_resort: None, weld, joins_scene: false, remedy: list_readable_formats(), content }
    }

    /// Returns whether the source is a glTF scene that stays a scene in the output format.
    pub fn is_scene(&self, output: Format) -> bool {
        matches!(output, Format::Gltf | Format::Glb) && self.is_gltf()
    }

    /// Returns whether the source is a glTF that is not joined into one mesh.
    pub fn is_gltf(&self) -> bool {
        let may_be = self.format.is_none_or(|format| matches!(format, Format::Gltf | Format::Glb));
        may_be && !self.joins_scene && self.content.is_gltf(&self.path)
    }

    /// Creates a source read as `given` only if neither name nor content show the format.
    fn by_content(path: PathBuf, given: Option<Format>, weld: bool) -> Self {
        Self { last_resort: given, ..Self::new(path, None, weld) }
    }

    pub fn with_remedy(self, remedy: &str) -> Self {
        Self { remedy: format!("{}; {remedy}", list_readable_formats()), ..self }
    }

    pub fn with_joined_scene(self, joins_scene: bool) -> Self {
        Self { joins_scene, ..self }
    }
}

impl Request {
    pub fn new(paths: &MeshPaths, arguments: &Arguments) -> Result<Self, Failure> {
        let Destination { path: output, format, takes_input_format } = resolve_destination(paths)?;
        let mut job = create_job(arguments, (!takes_input_format).then_some(format))?;
        job.format = format;
        let mut request = Self {
            source: input_source(paths, !arguments.no_weld)?.with_joined_scene(arguments.joins_scenes()),
            strict: job.goal.is_bound(),
            job,
            memory: None,
            map: None,
            explain: false,
            output: (!is_stream(&output)).then_some(output),
            takes_input_format,
            stays_in_memory: false,
            weights: arguments.weights.clone(),
            n_threads: None,
            report: None,
            picture: None,
            view: None,
            wires: false,
            quiet: true,
            force: false,
            read: files::list_files_read(Some(paths.input), None),
        };
        request.name_files();
        check_level_placeholder(&request)?;
        Ok(request)
    }
}

impl Request {
    /// Returns a request whose result is not written to a file; `format` is that of the result.
    pub fn without_output(input: &Path, format: Option<&str>, arguments: &Arguments) -> Result<Self, Failure> {
        let request = Self::new(&MeshPaths { input, output: Path::new("-"), format }, arguments)?;
        Ok(Self { quiet: false, ..request })
    }
}

pub fn resolve_request(mut args: SimplifyArgs) -> Result<Request, Failure> {
    args.options.map = args.map.is_some();
    check_single_mesh(&args)?;
    let input = args.inputs.first().map_or(Path::new(""), PathBuf::as_path);
    let paths = MeshPaths { input, output: &args.output, format: args.options.format.as_deref() };
    let base = Request::new(&paths, &args.options)?;
    let mut request = Request {
        strict: args.strict || base.strict,
        memory: args.memory.map(memory::gib_to_bytes),
        map: args.map,
        explain: args.explain,
        n_threads: args.threads,
        report: args.report.or_else(|| args.json.then(|| "-".into())),
        picture: args.picture,
        view: args.view,
        wires: args.wires,
        quiet: args.quiet,
        force: args.force,
        ..base
    };
    request.weights.iter().for_each(|path| request.read.add(path));
    request.job.shapes = request.report.is_some();
    check_streams(&request)?;
    Ok(request)
}

/// Returns the mark before a level's number in names of files; engines know levels by `_LOD`.
pub fn mark_levels(engine: Option<Engine>) -> &'static str {
    if engine.is_some() { "_LOD" } else { "-lod" }
}

/// Converts an error of options.
fn to_usage_failure(error: &JobError) -> Failure {
    match error {
        JobError::Feature { option, feature } => {
            Failure::LacksFeature { option: (*option).into(), feature: (*feature).into() }
        }
        _ => Failure::Usage(error.to_string()),
    }
}

/// Creates the job; `None` means that the output format is not known yet.
pub fn create_job(arguments: &Arguments, format: Option<Format>) -> Result<Job, Failure> {
    let to_failure = |error: JobError| to_usage_failure(&error);
    let job = arguments.job_as(format.unwrap_or(Format::Glb)).map_err(to_failure)?;
    format.map_or(Ok(()), |_| job.check_format()).map_err(to_failure)?;
    Ok(job)
}

/// Returns the input source; `--format` is its format only if the name of OUT has a known ending.
fn input_source(paths: &MeshPaths, weld: bool) -> Result<Source, Failure> {
    let format = paths.format.map(parse_format).transpose()?;
    let path = paths.input.to_path_buf();
    Ok(match format_from_path(paths.output).filter(|_| !paths.output.is_dir()) {
        Some(_) => Source::new(path, format, weld).with_remedy(ADVICE_FOR_NAMED_OUTPUT),
        None => Source::by_content(path, format, weld).with_remedy(ADVICE_FOR_UNNAMED_OUTPUT),
    })
}

fn check_single_mesh(args: &SimplifyArgs) -> Result<(), Failure> {
    if args.resume {
        return Err(Failure::Usage("--resume is for batches: give a folder, a pattern or --list".into()));
    }
    memory::limit_memory(args.memory);
    Ok(())
}

/// Returns whether a missed target changes the exit code: always for bounds, else with `--strict`.
pub fn is_strict(args: &SimplifyArgs) -> bool {
    let Arguments { error, size, lods_by, .. } = &args.options;
    args.strict || error.is_some() || size.is_some() || *lods_by == Some(LodsBy::Error)
}

fn check_level_placeholder(request: &Request) -> Result<(), Failure> {
    match (&request.output, &request.job.goal) {
        (_, Goal::Levels(_) | Goal::ErrorLevels(_)) | (None, _) => Ok(()),
        (Some(path), _) if !has_level_placeholder(path) => Ok(()),
        (Some(path), _) => {
            let what = format!("{}: {LEVEL_PLACEHOLDER} is for levels of detail: add --lods", path.display());
            Err(Failure::Usage(what))
        }
    }
}

fn check_streams(request: &Request) -> Result<(), Failure> {
    if [&request.picture, &request.map].into_iter().flatten().any(|path| is_stream(path)) {
        return Err(Failure::Usage("--picture and --map need the name of a file".into()));
    }
    check_stdout(request.output.is_none(), request.reports_to_stdout())
}
