//! `neural-mesh simplify`: read, simplify, measure, draw, write, say.

use std::path::{Path, PathBuf};

use neural_mesh::io::{Format, OutputFile};
use neural_mesh::job::{self, Document, Files, MapFile, Outcome, Part, REACHED, Report, Watch};
use neural_mesh::model::Weights;
use neural_mesh::simplify::Simplified;

use crate::document;
use crate::done::Done;
use crate::drawing::{drawn, pictured};
use crate::failure::{Failure, name};
use crate::files::{self, Pending};
use crate::interrupt;
use crate::names::is_stream;
use crate::out_of_core;
use crate::plan::Plan;
use crate::progress::Progress;
use crate::read::read_weights;
use crate::request::Request;
use crate::words::{self, Voice};

/// Does what is asked, on as many threads as asked.
pub fn run(request: Request) -> Result<(), Failure> {
    check_places(&request)?;
    interrupt::watch(Failure::Interrupted);
    in_pool(request.n_threads, || run_in_pool(request))
}

/// Refuses, before any work, places where no file of the request can be put.
pub fn check_places(request: &Request) -> Result<(), Failure> {
    let results = [&request.report, &request.picture, &request.map];
    let results = results.into_iter().flatten().filter(|path| !is_stream(path)).cloned();
    let paths: Vec<PathBuf> = request.outputs().into_iter().chain(results).collect();
    files::check_places(paths.iter().map(PathBuf::as_path), request.force)
}

/// Does something on so many threads, or on one per core.
pub fn in_pool(n_threads: Option<usize>, work: impl FnOnce() -> Result<(), Failure> + Send) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads.unwrap_or(0)).build();
    let pool = pool.map_err(|error| Failure::Failed(format!("threads cannot be started: {error}: ask for fewer")))?;
    pool.install(work)
}

fn run_in_pool(mut request: Request) -> Result<(), Failure> {
    let mut progress = Progress::new(request.quiet, Plan::of(&request, None));
    let weights = read_weights(request.weights.as_deref(), request.job.options.assembly)?;
    let done = match out_of_core::simplified(&request, weights.as_ref(), &mut progress)? {
        Some(done) => done,
        None => simplify_file(&mut request, weights.as_ref(), &mut progress)?,
    };
    drop(progress);
    let (report, cleaned) = done.put()?;
    say(&request, &report, &cleaned);
    met(&request, &report)
}

/// Whether what was written is as asked, as far as that matters for the exit code.
pub fn met(request: &Request, report: &Report) -> Result<(), Failure> {
    let mut outcomes = std::iter::once(&report.outcome).chain(report.levels.iter().map(|level| &level.outcome));
    match outcomes.find(|outcome| *outcome != REACHED) {
        Some(outcome) if request.strict => {
            let written = request.output.as_deref().map_or("standard output".into(), name);
            let is_written =
                if request.stays_in_memory { "the result" } else { &format!("{written}: is written, but") };
            Err(Failure::Unmet(format!("{is_written} {outcome}")))
        }
        _ => Ok(()),
    }
}

/// Reads the mesh, simplifies, writes beside the places of the results, measures, draws.
pub fn simplify_file(
    request: &mut Request,
    weights: Option<&Weights>,
    progress: &mut Progress,
) -> Result<Done, Failure> {
    progress.begin(Part::Read);
    let document = document::open(request)?;
    simplify_document(&document, request, weights, progress).map(|(done, _)| done)
}

/// As [`simplify_file`], for a document that is open; gives the results, too.
pub fn simplify_document(
    document: &Document,
    request: &Request,
    weights: Option<&Weights>,
    progress: &mut Progress,
) -> Result<(Done, Vec<Simplified>), Failure> {
    progress.follow(Plan::of(request, Some(document.mesh())));
    let failed = |error| request.failure(error);
    let mut outcome = job::run(document, &request.job, weights, progress).map_err(failed)?;
    progress.begin(Part::Write);
    let mut files = OnTheirWay::default();
    if !request.stays_in_memory {
        files = on_their_way(outcome.write(document, &request.job).map_err(failed)?, request, &mut outcome.report)?;
    }
    progress.begin(Part::Picture);
    let pictured = pictured(request, document, &mut outcome)?;
    files.pending.extend(drawn(request, pictured.as_ref(), &outcome.report)?);
    let Outcome { mut report, results, .. } = outcome;
    report.seconds = progress.seconds();
    report.baked.iter_mut().for_each(|baked| baked.seconds = report.seconds.bake.unwrap_or_default());
    let first = results.first().ok_or_else(|| Failure::of(&request.source.path, "no result was made"))?;
    files.pending.extend(mapped(request, document, first)?);
    let json = files::prepare_json(request.report.as_deref(), &report, request.force, &mut files.pending)?;
    let OnTheirWay { bytes, pending, beside } = files;
    let cleaned = document.counts.to_string();
    let done = Done { report, cleaned, bytes: bytes.or(json), pending, beside, force: request.force };
    Ok((done, results))
}

/// Results on their way.
#[derive(Default)]
struct OnTheirWay {
    bytes: Option<Vec<u8>>,
    pending: Vec<Pending>,
    beside: Option<(PathBuf, Vec<OutputFile>)>,
}

/// The meshes as bytes where standard output is their place, else as files on their way.
fn on_their_way(made: Vec<Files>, request: &Request, report: &mut Report) -> Result<OnTheirWay, Failure> {
    let mut done = OnTheirWay::default();
    let mut paths = request.outputs().into_iter();
    for files in made {
        let Some(path) = paths.next() else {
            let n = files.beside.len();
            let what = format!("{n} files beside the mesh are not written to standard output");
            report.notes.extend((n > 0).then_some(what));
            done.bytes = Some(files.bytes);
            continue;
        };
        done.pending.push(files::prepare(&path, &files.bytes, request.force)?);
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let (_, beside) = done.beside.get_or_insert((folder, Vec::new()));
        let fresh = files.beside.into_iter().filter(|file| beside.iter().all(|other| other.path != file.path));
        beside.extend(fresh.collect::<Vec<_>>());
    }
    Ok(done)
}

/// The map on its way to its file, where one is asked for.
fn mapped(request: &Request, document: &Document, result: &Simplified) -> Result<Option<Pending>, Failure> {
    let (Some(path), Some(map)) = (&request.map, &result.map) else { return Ok(None) };
    let file = MapFile::of(map, document.file_vertices());
    let json = serde_json::to_vec(&file).map_err(|error| Failure::of(path, error))?;
    files::prepare(path, &json, request.force).map(Some)
}

fn say(request: &Request, report: &Report, cleaned: &str) {
    let voice = match request.output {
        _ if request.quiet => Voice::Quiet,
        Some(_) if !request.reports_to_stdout() => Voice::Out,
        _ => Voice::Err,
    };
    words::notes(report, cleaned).iter().for_each(|line| voice.say(line));
    if request.explain {
        words::explained(report).iter().for_each(|line| voice.say(line));
    }
    match &report.levels[..] {
        [] => {
            voice.say(&words::size(&report.input, &report.output.size));
            bytes(request).iter().for_each(|bytes| voice.say(&words::bytes(*bytes)));
            words::written(&report.output).iter().for_each(|line| voice.say(line));
            report.certified.iter().for_each(|distance| voice.say(&words::certified(distance)));
            report.distance.iter().for_each(|distance| voice.say(&words::distance(distance)));
        }
        levels => levels.iter().enumerate().for_each(|(i, level)| voice.say(&words::level(i, &report.input, level))),
    }
    voice.say(&words::time(&report.seconds));
}

/// Bytes of the input and of the result, where each is one file.
fn bytes(request: &Request) -> Option<[u64; 2]> {
    let (input, result) = (&request.source.path, request.output.as_deref()?);
    if [Format::from_path(input), Some(request.job.format)].contains(&Some(Format::Gltf)) {
        return None;
    }
    let of = |path: &Path| std::fs::metadata(path).ok().filter(|found| found.is_file()).map(|found| found.len());
    Some([of(input)?, of(result)?])
}
