//! Commands for another program in the same process, with meshes in memory or in files.
//!
//! Nothing is printed, no signal is handled, and threads come from the caller's pool.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use neural_mesh::io::{Folder, Format, ReadMesh};
use neural_mesh::job::{Arguments, Document, Job, JobStage, Watch, make_progression};
use neural_mesh::mesh::RawMesh;
use neural_mesh::simplify::{
    Assembly, Input, Listener, Options, Progression, Record, Simplified, Size, asked_scores, simplify_recorded,
};
use serde::Deserialize;

use crate::failure::display_path;
use crate::files::{self, OutputPaths};
use crate::names::MeshPaths;
use crate::progress::Progress;
use crate::read::{self, read_weights};
use crate::request::Request;
use crate::simplify::{check_outputs, check_target, simplify_document};
use crate::{batch, compare, document, mesh_points, progression};

pub use crate::args::{CompareArgs, MeshPointsArgs};
pub use crate::compare::ComparisonOutput;
pub use crate::failure::Failure;
pub use crate::mesh_points::MeshPointsOutput;
pub use crate::numbers::MAX_SAMPLES;

/// Files of a request.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Files {
    /// Input file, if no mesh is given.
    pub input: Option<PathBuf>,
    /// Output file; `None` keeps the result in memory.
    pub out: Option<PathBuf>,
    /// Format of the output if the output's name has no known ending, else of the input.
    pub format: Option<String>,
    /// Weights of a network.
    pub weights: Option<PathBuf>,
    /// File for the picture.
    pub picture: Option<PathBuf>,
    /// File for the report.
    pub report: Option<PathBuf>,
    /// True if a missed target is an error.
    pub strict: bool,
    /// True if existing files are replaced.
    pub force: bool,
    /// True to return the bytes of a file in `format` instead of writing the file.
    pub bytes: bool,
}

/// Mesh in memory to simplify.
pub enum InputMesh {
    /// Mesh, and optionally a weight of at least 0 per vertex.
    Mesh(Box<ReadMesh>, Option<Vec<f32>>),
    /// Bytes of a file, and the file's name, whose ending gives the format if the bytes do not.
    File(Vec<u8>, String),
}

/// Result of a request.
pub struct Outcome {
    /// Results, one per level of detail.
    pub results: Vec<MemoryResult>,
    /// Report, as `--report` writes it.
    pub report: serde_json::Value,
    /// Summary of the cleaning.
    pub cleaned: String,
    /// Input vertex of each cleaned vertex; `None` for a scene.
    pub file_vertices: Option<Vec<u32>>,
    /// Names of materials, groups and objects, each with its group's number.
    pub group_names: Vec<(String, u32)>,
    /// Written files.
    pub paths: Vec<PathBuf>,
    /// Bytes of the result's file, if requested.
    pub bytes: Option<Vec<u8>>,
    /// Description of a missed target, if that is an error.
    pub unmet: Option<String>,
}

/// Result in memory.
pub struct MemoryResult {
    /// Mesh in single precision; the meshes of a scene are joined.
    pub simplified: Simplified,
    /// Vertex positions, n x 3, if the input has double precision.
    pub exact: Option<Vec<[f64; 3]>>,
}

/// Simplifies the given mesh, or the input file, as `neural-mesh simplify` does.
///
/// `check_cancelled` is called once, before files are moved into place.
///
/// # Errors
/// [`Failure`], as in the program; [`Failure::Interrupted`] if the listener or `check_cancelled` stops the run.
pub fn simplify(
    arguments: Arguments,
    files: &Files,
    given: Option<InputMesh>,
    listener: Box<Listener<'static>>,
    check_cancelled: &dyn Fn() -> ControlFlow<()>,
) -> Result<Outcome, Failure> {
    let mut request = request(arguments, files, given.is_some())?;
    // A mesh in memory has no file, so no glTF scene to keep.
    request.source.joins_scene |= matches!(given, Some(InputMesh::Mesh(..)));
    request.job.weights = read_weights(request.weights.as_deref(), &request.job.options.assembly)?;
    let mut progress = Progress::with_listener(listener);
    progress.begin(JobStage::Read);
    let document = open_document(given, &mut request)?;
    complete(&document, &request, &mut progress, check_cancelled)
}

fn complete(
    document: &Document,
    request: &Request,
    progress: &mut Progress,
    check_cancelled: &dyn Fn() -> ControlFlow<()>,
) -> Result<Outcome, Failure> {
    let (mut run, results) = simplify_document(document, request, progress)?;
    if check_cancelled().is_break() {
        return Err(Failure::Interrupted);
    }
    // From here on, files are written.

    let bytes = run.bytes.take();
    let (report, cleaned) = run.place_results()?;
    let to_memory_result = |simplified: Simplified| {
        let exact = document.exact_positions(&simplified, &request.job);
        MemoryResult { simplified, exact }
    };
    Ok(Outcome {
        results: results.into_iter().map(to_memory_result).collect(),
        report: serde_json::to_value(&report).map_err(|error| Failure::in_file(&request.source.path, error))?,
        cleaned,
        file_vertices: document.file_vertices().map(<[u32]>::to_vec),
        group_names: document.group_names(),
        paths: request.outputs(),
        bytes,
        unmet: check_target(request, &report).err().map(|failure| failure.to_string()),
    })
}

/// A progression and the document of which it has all levels.
pub struct OpenProgression(Document);

impl OpenProgression {
    /// Makes the progression of the given mesh, or of the input file; proves distances of levels if `proves`.
    ///
    /// # Errors
    /// As [`simplify`].
    pub fn new(
        arguments: Arguments,
        files: &Files,
        given: Option<InputMesh>,
        proves: bool,
        listener: Box<Listener<'static>>,
    ) -> Result<Self, Failure> {
        let mut request = request(arguments, files, given.is_some())?;
        request.source.joins_scene |= matches!(given, Some(InputMesh::Mesh(..)));
        request.job.weights = read_weights(request.weights.as_deref(), &request.job.options.assembly)?;
        let mut progress = Progress::with_listener(listener);
        progress.begin(JobStage::Read);
        let input = match &given {
            Some(InputMesh::Mesh(..)) => Vec::new(),
            Some(InputMesh::File(bytes, name)) => vec![(name.clone(), bytes.clone())],
            None => progression::read_files(&request.source.path, &request.read)?,
        };
        let document = open_document(given, &mut request)?;
        let made = make_progression(&document, &request.job, proves, &mut progress);
        let mut progression = made.map_err(|error| request.failure(error))?;
        progression.files = input;
        let document = document.with_progression(progression);
        document.files_read().join(&request.read);
        Ok(Self(document))
    }

    /// Opens the bytes of a progression.
    ///
    /// # Errors
    /// [`Failure`] if the bytes are no progression.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Failure> {
        let failed = |error: &dyn std::fmt::Display| Failure::Failed(error.to_string());
        let progression = Progression::from_bytes(bytes).map_err(|error| failed(&error))?;
        let job = Job::new(Options::new(Size::Ratio(1.0)), Format::Ply);
        Document::from_progression(progression, &job).map(Self).map_err(|error| failed(&error))
    }

    /// Writes the progression to a file; `force` replaces one there that it was not made from.
    ///
    /// # Errors
    /// [`Failure`] if the file cannot be written.
    pub fn save(&self, path: &Path, force: bool) -> Result<(), Failure> {
        let outputs = OutputPaths::new([], [&path.to_path_buf()]);
        files::check_output_paths(&outputs, &self.0.files_read(), force)?;
        let bytes = self.progression().map(Progression::to_bytes).unwrap_or_default();
        files::place_files(vec![files::prepare_file(path, &bytes, force)?], &self.0.files_read())
    }

    /// Returns the progression.
    pub fn progression(&self) -> Option<&Progression> {
        self.0.progression()
    }

    /// Makes the level that the arguments request, as [`simplify`] does.
    ///
    /// # Errors
    /// As [`simplify`].
    pub fn level(
        &self,
        arguments: Arguments,
        files: &Files,
        listener: Box<Listener<'static>>,
        check_cancelled: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Outcome, Failure> {
        let request = request(arguments, files, true)?;
        complete(&self.0, &request, &mut Progress::with_listener(listener), check_cancelled)
    }
}

fn open_document(given: Option<InputMesh>, request: &mut Request) -> Result<Document, Failure> {
    match given {
        Some(InputMesh::Mesh(mesh, factors)) => {
            let document = Document::from_mesh(*mesh, &request.job).map_err(|error| request.failure(error))?;
            Ok(document.with_importance(factors))
        }
        Some(InputMesh::File(bytes, name)) => {
            if request.takes_input_format {
                document::set_input_format(request, Format::from_content(&bytes).or_else(|| Format::from_name(&name)))?;
            }
            let folder = Folder::in_memory(std::iter::empty::<(String, Vec<u8>)>());
            let document = Document::from_bytes_in(&bytes, &name, &folder, &request.job);
            document.map_err(|error| request.failure(error))
        }
        None => document::open(request),
    }
}

/// Result's vertices as a differentiable function of the input's.
pub struct RecordedResult {
    /// Function from cleaned to resulting vertices, both relative to `origin`.
    pub record: Record,
    /// Origin of the local coordinates.
    pub origin: [f64; 3],
    /// Input vertex of each cleaned vertex.
    pub sources: Vec<u32>,
    /// Faces of the result.
    pub faces: Vec<[u32; 3]>,
}

/// Simplifies a mesh and records the result as a function of its vertices.
///
/// # Errors
/// As [`simplify`]; also for options that a record does not support.
pub fn record(
    arguments: Arguments,
    files: &Files,
    raw: RawMesh,
    mut listener: Box<Listener<'static>>,
) -> Result<RecordedResult, Failure> {
    let mut request = request(arguments, files, true)?;
    let job = &request.job;
    let is_plain = job.goal.n_levels().is_none()
        && !job.goal.is_bound()
        && job.arguments.repair().is_none()
        && job.arguments.importance.is_none()
        && job.arguments.keep.is_empty()
        && job.arguments.shares().is_empty();
    if !is_plain || job.arguments.prune_below().is_some() {
        return Err(Failure::Usage(
            "a record needs --ratio, --vertices or --faces, and excludes --ratio NAME=R, --keep, --importance, --prune, --fill-holes and --printable: leave these out".into(),
        ));
    }
    request.job.weights = read_weights(request.weights.as_deref(), &request.job.options.assembly)?;
    let cleaned = read::clean_mesh(raw, &request.source)?;
    let mut options = request.job.simplifier_options();
    if let Assembly::Closed(closed) = &mut options.assembly {
        closed.frame = cleaned.frame;
    }
    let mut input = Input::bare(&cleaned.mesh);
    let scores = asked_scores(request.job.closed_options().scores, &cleaned.mesh, request.job.weights.as_deref());
    input.scores = &scores;
    let (simplified, record) = simplify_recorded(input, &options, &mut *listener)?;
    let (_, faces) = simplified.mesh.into_parts();
    Ok(RecordedResult { record, origin: cleaned.frame.origin, sources: cleaned.source, faces })
}

fn request(mut arguments: Arguments, files: &Files, is_given: bool) -> Result<Request, Failure> {
    let input = files.input.as_deref().filter(|_| !is_given).unwrap_or(Path::new("mesh"));
    let output = files.out.as_deref().unwrap_or(Path::new("-"));
    if !is_given && batch::names_several_meshes(input) {
        return Err(Failure::Usage("a folder, a pattern or several meshes: give one mesh at a time".into()));
    }
    if is_given && output.is_dir() {
        let what = "is a folder, and the mesh has no name: give the name of a file";
        return Err(Failure::Usage(format!("{}: {what}", output.display())));
    }
    arguments.weights.clone_from(&files.weights);
    // PLY holds all attributes of a result that stays in memory.
    let format = files.format.as_deref().or((files.out.is_none() && !files.bytes).then_some("ply"));
    let mut request = Request::new(&MeshPaths { input, output, format }, &arguments)?;
    request.strict |= files.strict;
    request.stays_in_memory = files.out.is_none() && !files.bytes;
    request.force = files.force;
    request.weights.iter().for_each(|path| request.read.add(path));
    (request.picture, request.report) = (files.picture.clone(), files.report.clone());
    request.job.shapes = request.report.is_some();
    if let Some(path) = [&request.report, &request.picture]
        .into_iter()
        .flatten()
        .find(|path| display_path(path) == display_path(Path::new("-")))
    {
        return Err(Failure::Usage(format!(
            "{}: standard output is not available here: give the name of a file",
            path.display()
        )));
    }
    check_outputs(&request, request.force)?;
    Ok(request)
}

/// Compares meshes as `neural-mesh compare` does; `None` in `given` means the file of that name.
///
/// The page is built if `html` is set, and written there if `writes`.
///
/// # Errors
/// As [`simplify`].
pub fn compare(
    args: &CompareArgs,
    given: Vec<Option<ReadMesh>>,
    writes: bool,
    check_cancelled: &dyn Fn() -> ControlFlow<()>,
) -> Result<ComparisonOutput, Failure> {
    compare::check_args(args)?;
    let page_path = args.html.as_deref().filter(|_| writes);
    let read = compare::list_inputs(args);
    files::check_output_paths(&OutputPaths::new([], args.html.iter().filter(|_| writes)), &read, args.force)?;
    let compared = compare::compare_in_memory(args, given, &read)?;
    if check_cancelled().is_break() {
        return Err(Failure::Interrupted);
    }
    if let (Some(path), Some(page)) = (page_path, &compared.page) {
        files::place_files(vec![files::prepare_file(path, page.as_bytes(), args.force)?], &read)?;
    }
    Ok(compared)
}

/// Meshes the given cloud, or the input file, as `neural-mesh mesh-points` does. The output `-` writes nothing.
///
/// # Errors
/// As [`simplify`].
pub fn mesh_points(
    args: MeshPointsArgs,
    given: Option<RawMesh>,
    listener: Box<Listener<'static>>,
    check_cancelled: &dyn Fn() -> ControlFlow<()>,
) -> Result<MeshPointsOutput, Failure> {
    let mut meshed = mesh_points::mesh_in_memory(args, given, Progress::with_listener(listener))?;
    if check_cancelled().is_break() {
        return Err(Failure::Interrupted);
    }
    files::place_files(std::mem::take(&mut meshed.pending), &meshed.read)?;
    Ok(meshed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    fn parse_arguments(json: &str) -> Arguments {
        serde_json::from_str(json).unwrap()
    }

    fn input(double: bool) -> Option<InputMesh> {
        let (positions, faces) = shapes::wavy_sphere(4, 5.0).into_parts();
        let positions =
            positions.into_iter().map(|p| p.map(|x| f64::from(x) + 0.1 * f64::from(u8::from(double)))).collect();
        let mut read = ReadMesh::default();
        read.mesh = RawMesh::new(positions, faces);
        read.mesh.double = double;
        Some(InputMesh::Mesh(Box::new(read), None))
    }

    fn mesh(double: bool) -> ReadMesh {
        let Some(InputMesh::Mesh(mesh, _)) = input(double) else { unreachable!("it is a mesh") };
        *mesh
    }

    fn run(json: &str, given: Option<InputMesh>) -> Result<Outcome, Failure> {
        simplify(parse_arguments(json), &Files::default(), given, Box::new(|_| ControlFlow::Continue(())), &|| {
            ControlFlow::Continue(())
        })
    }

    #[test]
    fn a_mesh_in_memory_writes_no_file() {
        let outcome = run(r#"{"faces": 500, "no_check": true}"#, input(false)).unwrap();
        assert_eq!((outcome.results[0].simplified.mesh.faces().len(), outcome.paths.len()), (500, 0));
        assert!(outcome.results[0].exact.is_none() && outcome.unmet.is_none());
        assert_eq!(outcome.report["outcome"], "reached");
    }

    #[test]
    fn kept_vertices_keep_their_double_precision() {
        let before = mesh(true).mesh.positions;
        let outcome = run(r#"{"ratio": 0.2, "subset": true}"#, input(true)).unwrap();
        let after = outcome.results[0].exact.as_ref().unwrap();
        assert!(after.iter().all(|position| before.contains(position)));
    }

    #[test]
    fn important_regions_get_more_vertices() {
        let mesh = mesh(false);
        let factors = mesh.mesh.positions.iter().map(|p| if p[0] > 0.0 { 50.0 } else { 0.0 }).collect();
        let outcome = run(r#"{"ratio": 0.1}"#, Some(InputMesh::Mesh(Box::new(mesh.clone()), Some(factors)))).unwrap();
        let positions = outcome.results[0].simplified.mesh.positions();
        assert!(positions.iter().filter(|p| p[0] > 0.0).count() > positions.len() * 3 / 4);
        let none = vec![0.0; mesh.mesh.positions.len()];
        let failure = run(r#"{"ratio": 0.1}"#, Some(InputMesh::Mesh(Box::new(mesh), Some(none)))).err().unwrap();
        assert_eq!(failure.to_string(), "importance: give numbers of at least 0, with one above 0");
    }

    #[test]
    fn a_record_reproduces_its_result() {
        let raw = mesh(true).mesh;
        let positions = raw.positions.clone();
        let recorded = record(
            parse_arguments(r#"{"faces": 400}"#),
            &Files::default(),
            raw.clone(),
            Box::new(|_| ControlFlow::Continue(())),
        )
        .unwrap();
        let outcome = run(r#"{"faces": 400}"#, input(true)).unwrap();
        let local = |&v: &u32| std::array::from_fn(|k| positions[v as usize][k] - recorded.origin[k]);
        let again = recorded.record.positions_in_doubles(&recorded.sources.iter().map(local).collect::<Vec<_>>());
        let result = outcome.results[0].exact.as_ref().unwrap();
        assert_eq!(recorded.faces, outcome.results[0].simplified.mesh.faces());
        let moved = |(p, q): (&[f64; 3], &[f64; 3])| {
            (0..3).map(|k| (p[k] + recorded.origin[k] - q[k]).abs()).fold(0.0, f64::max)
        };
        assert!(again.iter().zip(result).map(moved).fold(0.0, f64::max) < 1e-6);
        let refused = record(
            parse_arguments(r#"{"error": "1%"}"#),
            &Files::default(),
            raw,
            Box::new(|_| ControlFlow::Continue(())),
        );
        assert!(refused.is_err());
    }

    #[test]
    fn a_file_in_memory_becomes_a_file_in_memory() {
        let silent = || Box::new(|_| ControlFlow::Continue(()));
        let go_on = || ControlFlow::Continue(());
        let run =
            |json: &str, files: Files, given| simplify(parse_arguments(json), &files, given, silent(), &go_on).unwrap();
        let as_bytes = |format: &str| Files { bytes: true, format: Some(format.into()), ..Files::default() };
        let scene = run(r#"{"ratio": 1}"#, as_bytes("glb"), input(false)).bytes.unwrap();
        let simplified = run(r#"{"faces": 500}"#, as_bytes("glb"), Some(InputMesh::File(scene.clone(), String::new())));
        assert!(simplified.bytes.unwrap().starts_with(b"glTF") && simplified.paths.is_empty());
        let arrays = run(r#"{"faces": 500}"#, Files::default(), Some(InputMesh::File(scene, String::new())));
        assert_eq!((arrays.results[0].simplified.mesh.faces().len(), arrays.bytes), (500, None));
    }

    #[test]
    fn refusals_are_one_line() {
        let failures =
            ["{}", r#"{"ratio": 0.2, "faces": 9}"#].map(|json| run(json, input(false)).err().unwrap().to_string());
        assert!(failures.iter().all(|text| !text.contains('\n') && text.len() < 200), "{failures:?}");
        assert!(failures[1].starts_with("--ratio cannot be used with --faces"));
    }

    #[test]
    fn a_cancelled_run_writes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.ply");
        let (arguments, files) =
            (parse_arguments(r#"{"ratio": 0.2}"#), Files { out: Some(path.clone()), ..Files::default() });
        let go_on = || Box::new(|_| ControlFlow::Continue(()));
        let stopped = simplify(arguments.clone(), &files, input(false), go_on(), &|| ControlFlow::Break(()));
        assert!(matches!(stopped, Err(Failure::Interrupted)) && !path.exists());
        let written = simplify(arguments, &files, input(false), go_on(), &|| ControlFlow::Continue(())).unwrap();
        assert!(path.exists() && written.paths == [path]);
    }
}
