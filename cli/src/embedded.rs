//! The program's requests for another face in the same process: meshes in memory beside files, results as they are. Nothing is said,
//! no signal is watched for, and threads are those of the pool that the caller is in.
//!
//! A request is the words of the command line, so that options mean the same and are refused alike.

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Parser;
use clap::error::ErrorKind;
use neural_mesh::io::ReadMesh;
use neural_mesh::job::{Document, Goal, Part, Watch};
use neural_mesh::mesh::RawMesh;
use neural_mesh::simplify::{Listener, Record, Simplified, simplify_recorded};

use crate::args::{CompareArgs, SimplifyArgs};
use crate::files;
use crate::level_files::outputs;
use crate::progress::Progress;
use crate::read::{self, read_weights};
use crate::request::{Request, resolve};
use crate::simplify::{check_places, met, simplify_document};
use crate::{batch, compare, document, mesh_points, usage};

pub use crate::compare::Compared;
pub use crate::failure::Failure;
pub use crate::mesh_points::PointsMeshed;

/// A mesh to simplify that is in memory, and how much its vertices count: a number of at least 0 for each, or nothing.
pub type Given = (ReadMesh, Option<Vec<f32>>);

/// What came of a request.
pub struct Outcome {
    /// The result, or one for each level of detail.
    pub results: Vec<Kept>,
    /// What `--report` writes.
    pub report: String,
    /// What was cleaned, in words.
    pub cleaned: String,
    /// The vertex as given that each cleaned vertex is, by which the map counts; nothing for a scene.
    pub file_vertices: Option<Vec<u32>>,
    /// Names of materials, groups and objects, and the groups of faces that have them.
    pub group_names: Vec<(String, u32)>,
    /// Files that were written.
    pub paths: Vec<PathBuf>,
    /// Why the result is not as asked, where that matters.
    pub unmet: Option<String>,
}

/// A result in memory.
pub struct Kept {
    /// The mesh, in single precision; of a scene all of its meshes in one, side by side.
    pub simplified: Simplified,
    /// Where its vertices lie, n x 3, where the input is in double precision.
    pub exact: Option<Vec<[f64; 3]>>,
}

/// Simplifies what is given, or the file that the words name, as `neural-mesh simplify` does; with `-o -` nothing is written.
/// `is_wanted` is asked once more before files are put in their places.
///
/// # Errors
/// [`Failure`], as the program's; [`Failure::Interrupted`] where the listener or `is_wanted` ends it.
pub fn simplify(
    words: &[String],
    given: Option<Given>,
    listener: Box<Listener<'static>>,
    is_wanted: &dyn Fn() -> ControlFlow<()>,
) -> Result<Outcome, Failure> {
    let mut request = request(words, given.is_some())?;
    let weights = read_weights(request.weights.as_deref(), request.job.options.assembly)?;
    let mut progress = Progress::heard_by(listener);
    progress.begin(Part::Read);
    let document = match given {
        Some((mesh, factors)) => {
            Document::from_mesh(mesh, &request.job).map_err(|error| Failure::of_job(error, &request))?.weighed(factors)
        }
        None => document::open(&mut request)?,
    };
    let (done, results) = simplify_document(&document, &request, weights.as_ref(), &mut progress)?;
    if is_wanted().is_break() {
        return Err(Failure::Interrupted);
    }
    let (report, cleaned) = done.put()?;
    let kept = |simplified: Simplified| {
        let exact = document.exact_positions(&simplified, &request.job);
        Kept { simplified, exact }
    };
    Ok(Outcome {
        results: results.into_iter().map(kept).collect(),
        report: serde_json::to_string(&report).map_err(|error| Failure::of(&request.source.path, error))?,
        cleaned,
        file_vertices: document.file_vertices().map(<[u32]>::to_vec),
        group_names: document.group_names(),
        paths: outputs(&request),
        unmet: met(&request, &report).err().map(|failure| failure.to_string()),
    })
}

/// A result as a function of the vertices given.
pub struct Recorded {
    /// The function, in local coordinates of the cleaned vertices.
    pub record: Record,
    /// Where the local origin lies.
    pub origin: [f64; 3],
    /// The vertex given that each cleaned vertex is.
    pub sources: Vec<u32>,
    /// The faces of the result.
    pub faces: Vec<[u32; 3]>,
}

/// Simplifies a mesh and records how the result depends on its vertices; the words are those of a size and of the options that a
/// record knows.
///
/// # Errors
/// As [`simplify`].
pub fn record(words: &[String], raw: RawMesh, mut listener: Box<Listener<'static>>) -> Result<Recorded, Failure> {
    let request = request(words, true)?;
    let job = &request.job;
    let is_plain = matches!(job.goal, Goal::Target | Goal::ShareOfFaces(_))
        && job.repair.is_none()
        && job.importance.is_none()
        && job.keep.is_empty()
        && job.shares.is_empty();
    if !is_plain || job.options.symmetric.is_some() || job.prune_below.is_some() {
        return Err(Failure::Usage("a record needs --ratio, --vertices or --faces, and a mesh as it is".into()));
    }
    let weights = read_weights(request.weights.as_deref(), job.options.assembly)?;
    let cleaned = read::cleaned(raw, &request.source)?;
    let target = request.job.target(cleaned.mesh.faces().len());
    let mut options = request.job.options;
    (options.target, options.frame) = (target, cleaned.frame);
    let (simplified, record) = simplify_recorded(&cleaned.mesh, weights.as_ref(), &options, &mut *listener)?;
    let (_, faces) = simplified.mesh.into_parts();
    Ok(Recorded { record, origin: cleaned.frame.origin, sources: cleaned.source, faces })
}

/// The words as a request for one mesh.
fn request(words: &[String], is_given: bool) -> Result<Request, Failure> {
    let args: SimplifyArgs = parsed(words)?;
    if !is_given && batch::is_meant(&args) {
        return Err(Failure::Usage("a folder, a pattern or several meshes: give one mesh at a time".into()));
    }
    if is_given && args.output.is_dir() {
        let what = "is a folder, and the mesh has no name: give the name of a file";
        return Err(Failure::Usage(format!("{}: {what}", args.output.display())));
    }
    let mut request = resolve(args)?;
    if request.reports_to_stdout() {
        return Err(Failure::Usage("--report -: standard output is not written to: give the name of a file".into()));
    }
    request.stays_in_memory = request.output.is_none();
    // A mesh in memory has no file that could be a scene.
    request.source.as_one |= is_given;
    // It comes with the result.
    request.map = None;
    check_places(&request)?;
    Ok(request)
}

/// Compares what is given, and the files that the words name where nothing is, as `neural-mesh compare` does; the page is
/// made where the words have `--html`, and written there if `writes`.
///
/// # Errors
/// As [`simplify`].
pub fn compare(
    words: &[String],
    given: Vec<Option<ReadMesh>>,
    writes: bool,
    is_wanted: &dyn Fn() -> ControlFlow<()>,
) -> Result<Compared, Failure> {
    let args: CompareArgs = parsed(words)?;
    compare::check(&args)?;
    let place = args.html.as_deref().filter(|_| writes);
    files::check_places(place, args.force)?;
    let compared = compare::embedded(&args, given)?;
    if is_wanted().is_break() {
        return Err(Failure::Interrupted);
    }
    if let (Some(path), Some(page)) = (place, &compared.page) {
        files::place(vec![files::prepare(path, page.as_bytes(), args.force)?])?;
    }
    Ok(compared)
}

/// Meshes the cloud that is given, or the file that the words name, as `neural-mesh mesh-points` does; with `-o -` nothing is
/// written.
///
/// # Errors
/// As [`simplify`].
pub fn mesh_points(
    words: &[String],
    given: Option<RawMesh>,
    listener: Box<Listener<'static>>,
    is_wanted: &dyn Fn() -> ControlFlow<()>,
) -> Result<PointsMeshed, Failure> {
    let mut meshed = mesh_points::embedded(parsed(words)?, given, Progress::heard_by(listener))?;
    if is_wanted().is_break() {
        return Err(Failure::Interrupted);
    }
    files::place(std::mem::take(&mut meshed.pending))?;
    Ok(meshed)
}

/// The arguments of a command from its words, without its name.
fn parsed<A: Parser>(words: &[String]) -> Result<A, Failure> {
    let words = std::iter::once("neural-mesh").chain(words.iter().map(String::as_str));
    A::try_parse_from(words).map_err(|error| match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => Failure::Usage("no option of that name".into()),
        _ => usage::refused_value(&error).unwrap_or_else(|| Failure::Usage(first_paragraph(&error.to_string()))),
    })
}

/// What a usage error says before it shows the usage, in one line.
fn first_paragraph(error: &str) -> String {
    let lines = error.lines().take_while(|line| !line.trim().is_empty()).map(str::trim);
    lines.collect::<Vec<_>>().join(" ").trim_start_matches("error: ").to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(String::from).collect()
    }

    fn given(double: bool) -> Option<Given> {
        let (positions, faces) = shapes::wavy_sphere(4, 5.0).into_parts();
        let positions =
            positions.into_iter().map(|p| p.map(|x| f64::from(x) + 0.1 * f64::from(u8::from(double)))).collect();
        let mut read = ReadMesh::default();
        read.mesh = RawMesh::new(positions, faces);
        read.mesh.double = double;
        Some((read, None))
    }

    fn run(text: &str, given: Option<Given>) -> Result<Outcome, Failure> {
        simplify(&words(text), given, Box::new(|_| ControlFlow::Continue(())), &|| ControlFlow::Continue(()))
    }

    #[test]
    fn a_mesh_in_memory_stays_there() {
        let outcome = run("mesh -o - --format ply --faces 500 --no-check", given(false)).unwrap();
        assert_eq!((outcome.results[0].simplified.mesh.faces().len(), outcome.paths.len()), (500, 0));
        assert!(outcome.results[0].exact.is_none() && outcome.unmet.is_none());
        assert!(outcome.report.contains("\"outcome\":\"reached\""));
    }

    #[test]
    fn vertices_that_stay_keep_their_doubles() {
        let before = given(true).unwrap().0.mesh.positions;
        let outcome = run("mesh -o - --format ply --ratio 0.2 --subset", given(true)).unwrap();
        let after = outcome.results[0].exact.as_ref().unwrap();
        assert!(after.iter().all(|position| before.contains(position)));
    }

    #[test]
    fn what_counts_more_gets_more_vertices() {
        let (mesh, _) = given(false).unwrap();
        let factors = mesh.mesh.positions.iter().map(|p| if p[0] > 0.0 { 50.0 } else { 0.0 }).collect();
        let outcome = run("mesh -o - --format ply --ratio 0.1", Some((mesh.clone(), Some(factors)))).unwrap();
        let positions = outcome.results[0].simplified.mesh.positions();
        assert!(positions.iter().filter(|p| p[0] > 0.0).count() > positions.len() * 3 / 4);
        let none = vec![0.0; mesh.mesh.positions.len()];
        let failure = run("mesh -o - --format ply --ratio 0.1", Some((mesh, Some(none)))).err().unwrap();
        assert_eq!(failure.to_string(), "importance: needs numbers of at least 0, not all of them 0");
    }

    #[test]
    fn a_record_gives_its_result_again() {
        let raw = given(true).unwrap().0.mesh;
        let positions = raw.positions.clone();
        let recorded =
            record(&words("mesh -o - --format ply --faces 400"), raw.clone(), Box::new(|_| ControlFlow::Continue(())))
                .unwrap();
        let outcome = run("mesh -o - --format ply --faces 400", given(true)).unwrap();
        let local = |&v: &u32| std::array::from_fn(|k| positions[v as usize][k] - recorded.origin[k]);
        let again = recorded.record.positions_in_doubles(&recorded.sources.iter().map(local).collect::<Vec<_>>());
        let result = outcome.results[0].exact.as_ref().unwrap();
        assert_eq!(recorded.faces, outcome.results[0].simplified.mesh.faces());
        let moved = |(p, q): (&[f64; 3], &[f64; 3])| {
            (0..3).map(|k| (p[k] + recorded.origin[k] - q[k]).abs()).fold(0.0, f64::max)
        };
        assert!(again.iter().zip(result).map(moved).fold(0.0, f64::max) < 1e-6);
        let refused = record(&words("mesh -o - --format ply --error 1%"), raw, Box::new(|_| ControlFlow::Continue(())));
        assert!(refused.is_err());
    }

    #[test]
    fn refusals_are_one_line() {
        let failures =
            ["mesh -o - --format ply", "mesh -o - --format ply --ratio 2", "mesh -o - --format ply --rato 1"]
                .map(|text| run(text, given(false)).err().unwrap().to_string());
        assert!(failures.iter().all(|text| !text.contains('\n') && text.len() < 200), "{failures:?}");
        assert!(failures[1].starts_with("--ratio 2: give a share above 0"));
    }

    #[test]
    fn what_is_not_wanted_any_more_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.ply");
        let words = words(&format!("mesh -o {} --ratio 0.2", path.display()));
        let go_on = || Box::new(|_| ControlFlow::Continue(()));
        let stopped = simplify(&words, given(false), go_on(), &|| ControlFlow::Break(()));
        assert!(matches!(stopped, Err(Failure::Interrupted)) && !path.exists());
        let written = simplify(&words, given(false), go_on(), &|| ControlFlow::Continue(())).unwrap();
        assert!(path.exists() && written.paths == [path]);
    }
}
