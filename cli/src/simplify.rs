//! `neural-mesh simplify`: reads, simplifies, measures, draws, writes and reports.

use std::path::{Path, PathBuf};

use neural_mesh::io::{Format, OutputFile};
use neural_mesh::job::{self, Document, Files, JobOutcome, JobReport, JobStage, MapFile, REACHED, Watch};
use neural_mesh::model::Weights;
use neural_mesh::simplify::Simplified;

use crate::document;
use crate::done::Done;
use crate::drawing::{draw_picture, prepare_picture};
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

pub fn run(request: Request) -> Result<(), Failure> {
    check_places(&request)?;
    interrupt::watch(Failure::Interrupted);
    in_pool(request.n_threads, || run_in_pool(request))
}

pub fn check_places(request: &Request) -> Result<(), Failure> {
    let results = [&request.report, &request.picture, &request.map];
    let results = results.into_iter().flatten().filter(|path| !is_stream(path)).cloned();
    let paths: Vec<PathBuf> = request.outputs().into_iter().chain(results).collect();
    files::check_places(paths.iter().map(PathBuf::as_path), request.force)
}

/// Runs `work` on `n_threads` threads, or on one per core.
pub fn in_pool(n_threads: Option<usize>, work: impl FnOnce() -> Result<(), Failure> + Send) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads.unwrap_or(0)).build();
    let pool =
        pool.map_err(|error| Failure::Failed(format!("threads cannot be started: {error}: use fewer threads")))?;
    pool.install(work)
}

fn run_in_pool(mut request: Request) -> Result<(), Failure> {
    let mut progress = Progress::new(request.quiet, Plan::estimate(&request, None));
    let weights = read_weights(request.weights.as_deref(), request.job.options.assembly)?;
    // A mesh that needs more memory than allowed is simplified in blocks, without attributes.
    let done = match out_of_core::simplify_in_blocks(&request, weights.as_ref(), &mut progress)? {
        Some(done) => done,
        None => simplify_file(&mut request, weights.as_ref(), &mut progress)?,
    };
    drop(progress);
    let (report, cleaned) = done.put()?;
    say(&request, &report, &cleaned);
    check_target(&request, &report)
}

/// Returns an error if the result misses the target and the request is strict.
pub fn check_target(request: &Request, report: &JobReport) -> Result<(), Failure> {
    let mut outcomes = std::iter::once(&report.outcome).chain(report.levels.iter().map(|level| &level.outcome));
    match outcomes.find(|outcome| *outcome != REACHED) {
        Some(outcome) if request.strict => {
            let written = request.output.as_deref().map_or("standard output".into(), name);
            let is_written =
                if request.stays_in_memory { "the result" } else { &format!("{written}: the result is written, but") };
            Err(Failure::Unmet(format!("{is_written} {outcome}")))
        }
        _ => Ok(()),
    }
}

pub fn simplify_file(
    request: &mut Request,
    weights: Option<&Weights>,
    progress: &mut Progress,
) -> Result<Done, Failure> {
    progress.begin(JobStage::Read);
    let document = document::open(request)?;
    simplify_document(&document, request, weights, progress).map(|(done, _)| done)
}

/// Simplifies an open document and prepares all files.
pub fn simplify_document(
    document: &Document,
    request: &Request,
    weights: Option<&Weights>,
    progress: &mut Progress,
) -> Result<(Done, Vec<Simplified>), Failure> {
    progress.follow(Plan::estimate(request, Some(document.mesh())));
    let failed = |error| request.failure(error);
    let mut outcome = job::run(document, &request.job, weights, progress).map_err(failed)?;
    // Files are only prepared here and moved into place together at the end, so that an error leaves none behind.
    progress.begin(JobStage::Write);
    let mut files = PreparedFiles::default();
    if !request.stays_in_memory {
        files = prepare_meshes(outcome.write(document, &request.job).map_err(failed)?, request, &mut outcome.report)?;
    }
    progress.begin(JobStage::Picture);
    let pictured = prepare_picture(request, document, &mut outcome)?;
    files.pending.extend(draw_picture(request, pictured.as_ref(), &outcome.report)?);
    let JobOutcome { mut report, results, .. } = outcome;
    // The report comes last, since it has the seconds of all steps.
    report.seconds = progress.seconds();
    report.baked.iter_mut().for_each(|baked| baked.seconds = report.seconds.bake.unwrap_or_default());
    let first = results.first().ok_or_else(|| Failure::in_file(&request.source.path, "no result was made"))?;
    files.pending.extend(prepare_map(request, document, first)?);
    let json = files::prepare_json(request.report.as_deref(), &report, request.force, &mut files.pending)?;
    let PreparedFiles { bytes, pending, beside } = files;
    let cleaned = document.counts.to_string();
    let done = Done { report, cleaned, bytes: bytes.or(json), pending, beside, force: request.force };
    Ok((done, results))
}

#[derive(Default)]
struct PreparedFiles {
    bytes: Option<Vec<u8>>,
    pending: Vec<Pending>,
    beside: Option<(PathBuf, Vec<OutputFile>)>,
}

fn prepare_meshes(made: Vec<Files>, request: &Request, report: &mut JobReport) -> Result<PreparedFiles, Failure> {
    let mut done = PreparedFiles::default();
    let mut paths = request.outputs().into_iter();
    for files in made {
        // Standard output takes one mesh and no further files.
        let Some(path) = paths.next() else {
            let n = files.beside.len();
            let what = format!("{n} material or texture files are left out: standard output takes only the mesh");
            report.notes.extend((n > 0).then_some(what));
            done.bytes = Some(files.bytes);
            continue;
        };
        done.pending.push(files::prepare(&path, &files.bytes, request.force)?);
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let (_, beside) = done.beside.get_or_insert((folder, Vec::new()));
        // Levels share textures, and each is written once.
        let fresh = files.beside.into_iter().filter(|file| beside.iter().all(|other| other.path != file.path));
        beside.extend(fresh.collect::<Vec<_>>());
    }
    Ok(done)
}

fn prepare_map(request: &Request, document: &Document, result: &Simplified) -> Result<Option<Pending>, Failure> {
    let (Some(path), Some(map)) = (&request.map, &result.map) else { return Ok(None) };
    let file = MapFile::new(map, document.file_vertices());
    let json = serde_json::to_vec(&file).map_err(|error| Failure::in_file(path, error))?;
    files::prepare(path, &json, request.force).map(Some)
}

fn say(request: &Request, report: &JobReport, cleaned: &str) {
    // Messages must not mix with a mesh or a report on standard output.
    let voice = match request.output {
        _ if request.quiet => Voice::Quiet,
        Some(_) if !request.reports_to_stdout() => Voice::Out,
        _ => Voice::Err,
    };
    words::notes(report, cleaned).iter().for_each(|line| voice.say(line));
    if request.explain {
        words::explain_lines(report).iter().for_each(|line| voice.say(line));
    }
    match &report.levels[..] {
        [] => {
            voice.say(&words::size(&report.input, &report.output.size));
            bytes(request).iter().for_each(|bytes| voice.say(&words::bytes(*bytes)));
            words::written_line(&report.output).iter().for_each(|line| voice.say(line));
            report.certified.iter().for_each(|distance| voice.say(&words::certified_line(distance)));
            report.distance.iter().for_each(|distance| voice.say(&words::distance(distance)));
        }
        levels => levels.iter().enumerate().for_each(|(i, level)| voice.say(&words::level(i, &report.input, level))),
    }
    voice.say(&words::time(&report.seconds));
}

/// Returns the file sizes of input and result, if each is one file.
fn bytes(request: &Request) -> Option<[u64; 2]> {
    let (input, result) = (&request.source.path, request.output.as_deref()?);
    // A .gltf has most of its data in other files, so its size would mislead.
    if [Format::from_path(input), Some(request.job.format)].contains(&Some(Format::Gltf)) {
        return None;
    }
    let of = |path: &Path| std::fs::metadata(path).ok().filter(|found| found.is_file()).map(|found| found.len());
    Some([of(input)?, of(result)?])
}
