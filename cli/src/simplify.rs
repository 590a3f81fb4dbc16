//! `neural-mesh simplify`: read, simplify, measure, draw, write, say.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use neural_mesh::io::{self, Format, ReadError};
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::mesh::{RawMesh, TriMesh};
use neural_mesh::metrics::quick_distance;
use neural_mesh::model::Weights;
use neural_mesh::picture::{PictureOptions, encode_png, render};
use neural_mesh::simplify::{Options, Simplified, SimplifyError, simplify};

use crate::failure::{Failure, name};
use crate::files::{self, Pending};
use crate::interrupt;
use crate::progress::Progress;
use crate::report::{self, Distance, Output, Report, Seconds, Size};
use crate::request::{Request, Source, is_stream};
use crate::words::{self, Voice};

/// Samples on each surface for the distance: enough for its mean within a hundredth.
const SAMPLES: usize = 10_000;

/// Does what is asked, on as many threads as asked.
pub fn run(request: Request) -> Result<(), Failure> {
    let results = [&request.output, &request.report, &request.picture];
    results.into_iter().flatten().try_for_each(|path| files::check_place(path, request.force))?;
    interrupt::watch(Failure::Interrupted);
    in_pool(request.n_threads, || run_in_pool(&request))
}

/// Does something on so many threads, or on one per core.
pub fn in_pool(n_threads: Option<usize>, work: impl FnOnce() -> Result<(), Failure> + Send) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads.unwrap_or(0)).build();
    let pool = pool.map_err(|error| Failure::Failed(format!("threads cannot be started: {error}: ask for fewer")))?;
    pool.install(work)
}

fn run_in_pool(request: &Request) -> Result<(), Failure> {
    let mut progress = Progress::new(request.quiet);
    let weights = request.weights.as_deref().map(read_weights).transpose()?;
    let Done { report, cleaned, bytes, pending } = simplify_file(request, weights.as_ref(), &mut progress)?;
    drop(progress);
    bytes.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
    files::place(pending)?;
    say(request, &report, &cleaned);
    Ok(())
}

/// A run that is done but for the last step: nothing stands in its place yet.
pub struct Done {
    /// What was done.
    pub report: Report,
    /// What was cleaned, in words.
    pub cleaned: String,
    /// The mesh for standard output, where that is its place.
    pub bytes: Option<Vec<u8>>,
    /// The files.
    pub pending: Vec<Pending>,
}

/// Reads the mesh, simplifies, writes beside the places of the results, measures, draws.
pub fn simplify_file(request: &Request, weights: Option<&Weights>, progress: &mut Progress) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    progress.show("read", 0.0);
    let raw = timed(&mut seconds.read, || read(&request.source))?;
    let lighter = timed(&mut seconds.simplify, || lighter(raw, request, weights, progress))?;
    seconds.stages = report::stages(progress.take_stages());
    progress.show("write", 0.0);
    let (bytes, pending) = timed(&mut seconds.write, || written(&lighter, request))?;
    progress.show("check", 0.0);
    let Lighter { cleaned, result, .. } = lighter;
    let (input, output, distance) = timed(&mut seconds.check, || measured(&cleaned.mesh, &result, request));
    let report = told(request, &cleaned, &result, Figures { input, output, distance, seconds });
    progress.show("picture", 0.0);
    let drawn = drawn(request, [&cleaned.mesh, &result.mesh], &report)?;
    let pending = [pending, drawn, reported(request, &report)?].into_iter().flatten().collect();
    Ok(Done { report, cleaned: cleaned.counts.to_string(), bytes, pending })
}

/// Does something and adds the seconds it took.
fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let began = Instant::now();
    let result = work();
    *seconds += began.elapsed().as_secs_f64();
    result
}

/// Reads the weights of a network.
pub fn read_weights(path: &Path) -> Result<Weights, Failure> {
    Weights::from_bytes(&files::read(path)?).map_err(|error| Failure::of(path, error))
}

/// Reads and parses a mesh.
pub fn read(source: &Source) -> Result<RawMesh, Failure> {
    let parse: Box<dyn Fn(Option<Format>) -> Result<RawMesh, ReadError>> = if is_stream(&source.path) {
        let bytes = files::read(&source.path)?;
        Box::new(move |format| io::read(&bytes, format))
    } else {
        Box::new(|format| io::read_path(&source.path, format))
    };
    let mesh = match (parse(source.format), source.last_resort) {
        (Err(ReadError { format: None, .. }), Some(format)) => parse(Some(format)),
        (mesh, _) => mesh,
    };
    mesh.map_err(|error| Failure::of(&source.path, error))
}

/// Welds and cleans a mesh as read.
pub fn cleaned(raw: RawMesh, source: &Source) -> Result<Cleaned, Failure> {
    clean(raw, &CleanOptions { weld: source.weld }).map_err(|error| Failure::of(&source.path, error))
}

/// A mesh before and after.
struct Lighter {
    cleaned: Cleaned,
    result: Simplified,
    /// Positions of the result as the input has them in double precision, where no vertex has moved.
    exact: Option<Vec<[f64; 3]>>,
}

fn lighter(
    raw: RawMesh,
    request: &Request,
    weights: Option<&Weights>,
    progress: &mut Progress,
) -> Result<Lighter, Failure> {
    // Of doubles the mesh holds what single precision does; vertices that stay in place get the rest back.
    let exact = raw.double.then(|| raw.positions.clone());
    let cleaned = cleaned(raw, &request.source)?;
    let options = Options { frame: cleaned.frame, ..request.options.clone() };
    let mut tell = |event| {
        progress.event(event);
        ControlFlow::Continue(())
    };
    let result = simplify(&cleaned.mesh, weights, &options, &mut tell);
    let result = result.map_err(|error| refused(&error, &request.source.path))?;
    let exact = exact.and_then(|positions| in_place(&positions, &cleaned, &result));
    Ok(Lighter { cleaned, result, exact })
}

/// The input's own positions of the result's vertices, where each is one of the input's.
fn in_place(positions: &[[f64; 3]], cleaned: &Cleaned, result: &Simplified) -> Option<Vec<[f64; 3]>> {
    let position = |&vertex: &u32| positions.get(*cleaned.source.get(vertex as usize)? as usize).copied();
    result.source_vertices.as_ref()?.iter().map(position).collect()
}

/// The library's refusal as the program's.
fn refused(error: &SimplifyError, input: &Path) -> Failure {
    match error {
        SimplifyError::Interrupted => Failure::Interrupted,
        SimplifyError::BadTarget(_) | SimplifyError::BadOversample(_) => Failure::Usage(error.to_string()),
        _ => Failure::of(input, error),
    }
}

/// The mesh as bytes where standard output is its place, else as a file on its way.
fn written(lighter: &Lighter, request: &Request) -> Result<(Option<Vec<u8>>, Option<Pending>), Failure> {
    let (mesh, format) = (&lighter.result.mesh, request.output_format);
    let bytes = match &lighter.exact {
        Some(positions) => io::write_exact(mesh, positions.clone(), format),
        None => io::write(mesh, &lighter.cleaned.frame, format),
    };
    let shown = request.output.clone().unwrap_or_else(|| PathBuf::from("standard output"));
    let bytes = bytes.map_err(|error| Failure::of(&shown, error))?;
    match &request.output {
        Some(path) => Ok((None, Some(files::prepare(path, &bytes, request.force)?))),
        None => Ok((Some(bytes), None)),
    }
}

/// Sizes of both meshes, and how far they are apart; what they are as surfaces where someone is told.
fn measured(original: &TriMesh, result: &Simplified, request: &Request) -> (Size, Output, Option<Distance>) {
    let distance = || quick_distance(original, &result.mesh, SAMPLES, 0).map(|found| Distance::of(&found, SAMPLES));
    let distance = request.check.then(distance).flatten();
    let with_shape = request.report.is_some();
    let input = Size::of(original, with_shape || result.report.components_pruned > 0);
    (input, Output::of(Size::of(&result.mesh, with_shape), &result.report), distance)
}

/// What was measured of a run.
struct Figures {
    input: Size,
    output: Output,
    distance: Option<Distance>,
    seconds: Seconds,
}

fn told(request: &Request, cleaned: &Cleaned, result: &Simplified, figures: Figures) -> Report {
    Report {
        input: figures.input,
        output: figures.output,
        target: request.options.target.into(),
        outcome: report::outcome(&result.report.outcome),
        scores: report::scores(result.report.scores),
        oversample: result.report.oversample,
        seed: request.options.seed,
        threads: rayon::current_num_threads(),
        seconds: figures.seconds,
        cleaned: (&cleaned.counts).into(),
        distance: figures.distance,
    }
}

/// The picture on its way to its file, where one is asked for.
fn drawn(request: &Request, meshes: [&TriMesh; 2], report: &Report) -> Result<Option<Pending>, Failure> {
    let Some(path) = &request.picture else { return Ok(None) };
    let captions = vec![
        format!("{}\n{}", words::shortened(&name(&request.source.path)), words::counts(&report.input)),
        format!("simplified\n{}", words::counts(&report.output.size)),
    ];
    let image = render(&meshes, &PictureOptions { captions, ..Default::default() });
    files::prepare(path, &encode_png(&image), request.force).map(Some)
}

/// The report on its way to its file, where one is asked for.
fn reported(request: &Request, report: &Report) -> Result<Option<Pending>, Failure> {
    let Some(path) = &request.report else { return Ok(None) };
    let mut json = serde_json::to_vec_pretty(report).map_err(|error| Failure::of(path, error))?;
    json.push(b'\n');
    files::prepare(path, &json, request.force).map(Some)
}

fn say(request: &Request, report: &Report, cleaned: &str) {
    let voice = match (request.quiet, &request.output) {
        (true, _) => Voice::Quiet,
        (false, Some(_)) => Voice::Out,
        (false, None) => Voice::Err,
    };
    words::notes(report, cleaned).iter().for_each(|line| voice.say(line));
    voice.say(&words::size(&report.input, &report.output.size));
    report.distance.iter().for_each(|distance| voice.say(&words::distance(distance)));
    voice.say(&words::time(&report.seconds));
}
