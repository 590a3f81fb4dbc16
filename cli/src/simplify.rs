//! `neural-mesh simplify`: reads, simplifies, measures, draws, writes and reports.

use std::path::{Path, PathBuf};

use neural_mesh::io::{Format, OutputFile};
use neural_mesh::job::{self, Document, Files, JobOutcome, JobReport, JobStage, MapFile, REACHED, Watch};
use neural_mesh::simplify::Simplified;

use crate::document;
use crate::drawing::{draw_picture, picture_encoder, prepare_picture};
use crate::failure::{Failure, display_path};
use crate::files::{self, OutputPaths, PendingFile};
use crate::finished_run::FinishedRun;
use crate::interrupt;
use crate::messages::{self, MessageStream};
use crate::out_of_core;
use crate::plan::Plan;
use crate::progress::Progress;
use crate::read::read_weights;
use crate::request::Request;

pub fn run(request: Request) -> Result<(), Failure> {
    check_outputs(&request, request.force)?;
    interrupt::handle_signals(Failure::Interrupted);
    in_pool(request.n_threads, || run_in_pool(request))
}

/// Checks the files that a request writes; `force` allows existing ones.
pub fn check_outputs(request: &Request, force: bool) -> Result<(), Failure> {
    let others = [&request.report, &request.picture, &request.map];
    let paths = OutputPaths::new(&request.outputs(), others.into_iter().flatten());
    files::check_output_paths(&paths, &request.read, force)?;
    request.picture.iter().try_for_each(|path| picture_encoder(path).map(drop))
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
    request.job.weights = read_weights(request.weights.as_deref(), &request.job.options.assembly)?;
    // A mesh that needs more memory than allowed is simplified in blocks, without attributes.
    let run = match out_of_core::simplify_in_blocks(&request, &mut progress)? {
        Some(run) => run,
        None => simplify_file(&mut request, &mut progress)?,
    };
    drop(progress);
    // The result may replace the mesh.
    let n_bytes_read = size_of(&request.source.path);
    let (report, cleaned) = run.place_results()?;
    print_result(&request, &report, &cleaned, n_bytes_read);
    check_target(&request, &report)
}

/// Returns [`Failure::Unmet`] if the request is strict and the result misses the target or costs components their shape.
pub fn check_target(request: &Request, report: &JobReport) -> Result<(), Failure> {
    let mut outcomes = std::iter::once(&report.outcome).chain(report.levels.iter().map(|level| &level.outcome));
    let missed = outcomes.find(|outcome| *outcome != REACHED);
    let missed = missed.map(|outcome| format!("the target is not reached: simplification {outcome}"));
    let mut costs = std::iter::once(&report.output).chain(report.levels.iter().map(|level| &level.output));
    // Who bounds a distance or a file has said what the result may cost.
    let mut cost = || costs.find_map(|output| messages::describe_cost(report, output));
    let cost = if request.job.goal.is_bound() { None } else { cost() };
    match missed.or_else(|| Some(format!("the size has its price: {}", cost?))) {
        Some(what) if request.strict => {
            let name = request.output.as_deref().map_or("standard output".into(), display_path);
            let is_written = if request.stays_in_memory { "" } else { &format!("{name}: the result is written, but ") };
            Err(Failure::Unmet(format!("{is_written}{what}")))
        }
        _ => Ok(()),
    }
}

pub fn simplify_file(request: &mut Request, progress: &mut Progress) -> Result<FinishedRun, Failure> {
    progress.begin(JobStage::Read);
    let document = document::open(request)?;
    simplify_document(&document, request, progress).map(|(run, _)| run)
}

/// Simplifies an open document and prepares all files.
pub fn simplify_document(
    document: &Document,
    request: &Request,
    progress: &mut Progress,
) -> Result<(FinishedRun, Vec<Simplified>), Failure> {
    check_levels(document, request)?;
    progress.set_plan(Plan::estimate(request, Some(document.mesh())));
    let to_failure = |error| request.failure(error);
    let mut outcome = job::run(document, &request.job, progress).map_err(to_failure)?;
    // Files are only prepared here and moved into place together at the end, so that an error leaves none behind.
    progress.begin(JobStage::Write);
    let mut files = PreparedFiles::default();
    if !request.stays_in_memory {
        files =
            prepare_meshes(outcome.write(document, &request.job).map_err(to_failure)?, request, &mut outcome.report)?;
    }
    if request.picture.is_some() {
        progress.begin(JobStage::Picture);
    }
    let pictured = prepare_picture(request, document, &mut outcome)?;
    files.pending.extend(draw_picture(request, pictured.as_ref(), &outcome.report)?);
    let JobOutcome { mut report, results, .. } = outcome;
    report.notes.extend(note_older_levels(&request.older_levels(results.len())));
    // The report comes last, since it has the seconds of all steps.
    report.seconds = progress.seconds();
    report.baked.iter_mut().for_each(|baked| baked.seconds = report.seconds.bake.unwrap_or_default());
    let first = results.first().ok_or_else(|| Failure::in_file(&request.source.path, "no result was made"))?;
    files.pending.extend(prepare_map(request, document, first)?);
    let json = files::prepare_json(request.report.as_deref(), &report, request.force, &mut files.pending)?;
    let PreparedFiles { bytes, pending, extra_files } = files;
    let cleaned = document.counts.to_string();
    // Companion files of the mesh are known only now.
    let read = request.read.join(&document.files_read());
    let bytes = bytes.or(json);
    let run = FinishedRun { report, cleaned, bytes, pending, extra_files, force: request.force, read };
    Ok((run, results))
}

/// Rejects several files for standard output.
fn check_levels(document: &Document, request: &Request) -> Result<(), Failure> {
    let is_stream = request.output.is_none() && !request.stays_in_memory;
    let n_levels = request.job.goal.n_levels().unwrap_or(1);
    if is_stream && n_levels > 1 && request.job.has_file_per_level(document.is_scene()) {
        let what = "standard output takes one file, and each of these levels is one: give -o the name of a file";
        return Err(Failure::Usage(what.into()));
    }
    Ok(())
}

#[derive(Default)]
struct PreparedFiles {
    bytes: Option<Vec<u8>>,
    pending: Vec<PendingFile>,
    extra_files: Option<(PathBuf, Vec<OutputFile>)>,
}

fn prepare_meshes(written: Vec<Files>, request: &Request, report: &mut JobReport) -> Result<PreparedFiles, Failure> {
    let mut prepared = PreparedFiles::default();
    let mut paths = request.outputs().into_iter();
    for files in written {
        // Standard output takes one mesh and no further files.
        let Some(path) = paths.next() else {
            let n = files.companion_files.len();
            let what = format!("{n} material or texture files are left out: standard output takes only the mesh");
            report.notes.extend((n > 0).then_some(what));
            prepared.bytes = Some(files.bytes);
            continue;
        };
        prepared.pending.push(files::prepare_file(&path, &files.bytes, request.force)?);
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let (_, extra_files) = prepared.extra_files.get_or_insert((folder, Vec::new()));
        // Levels of detail share textures; each texture is written once.
        let new_files =
            files.companion_files.into_iter().filter(|file| extra_files.iter().all(|other| other.path != file.path));
        extra_files.extend(new_files.collect::<Vec<_>>());
    }
    Ok(prepared)
}

/// Names files of further levels, which stay: they may be of an earlier run, or the user's.
fn note_older_levels(older: &[PathBuf]) -> Option<String> {
    let names: Vec<String> = older.iter().map(|path| display_path(path)).collect();
    (!names.is_empty()).then(|| format!("not of these levels, and left as they are: {}", names.join(", ")))
}

fn prepare_map(request: &Request, document: &Document, result: &Simplified) -> Result<Option<PendingFile>, Failure> {
    let (Some(path), Some(map)) = (&request.map, &result.map) else { return Ok(None) };
    let file = MapFile::new(map, document.file_vertices());
    let json = serde_json::to_vec(&file).map_err(|error| Failure::in_file(path, error))?;
    files::prepare_file(path, &json, request.force).map(Some)
}

fn print_result(request: &Request, report: &JobReport, cleaned: &str, n_bytes_read: Option<u64>) {
    // Messages must not mix with a mesh or a report on standard output.
    let voice = match request.output {
        _ if request.quiet => MessageStream::Quiet,
        Some(_) if !request.reports_to_stdout() => MessageStream::Out,
        _ => MessageStream::Err,
    };
    messages::note_lines(report, cleaned).iter().for_each(|line| voice.print_line(line));
    if request.explain {
        messages::explain_lines(report).iter().for_each(|line| voice.print_line(line));
    }
    match &report.levels[..] {
        [] => {
            voice.print_line(&messages::size_line(&report.input, &report.output.size));
            file_sizes(request, n_bytes_read).iter().for_each(|bytes| voice.print_line(&messages::file_line(*bytes)));
            messages::written_line(&report.output).iter().for_each(|line| voice.print_line(line));
            report.certified.iter().for_each(|distance| voice.print_line(&messages::certified_line(distance)));
            report.distance.iter().for_each(|distance| voice.print_line(&messages::distance_line(distance)));
        }
        levels => levels
            .iter()
            .enumerate()
            .for_each(|(i, level)| voice.print_line(&messages::level_line(i, &report.input, level))),
    }
    voice.print_line(&messages::time_line(&report.seconds));
}

/// Returns the file sizes of input and result, if each is one file.
fn file_sizes(request: &Request, n_bytes_read: Option<u64>) -> Option<[u64; 2]> {
    let (input, result) = (&request.source.path, request.output.as_deref()?);
    // A .gltf has most of its data in other files, so its size would mislead.
    if [Format::from_path(input), Some(request.job.format)].contains(&Some(Format::Gltf)) {
        return None;
    }
    Some([n_bytes_read?, size_of(result)?])
}

fn size_of(path: &Path) -> Option<u64> {
    std::fs::metadata(path).ok().filter(|found| found.is_file()).map(|found| found.len())
}
