//! Simplification of meshes larger than `--memory` in blocks, without attributes.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use neural_mesh::blocks::{OutOfCoreError, OutOfCoreResult, WorkingSpace, simplify_pieces};
use neural_mesh::io::{self, Extra, Model, Pieces, WriteOptions};
use neural_mesh::job::{
    DistanceFigures, JobReport, JobStage, MeshSize, OutputFigures, SAMPLES, Seconds, outcome_words, score_words,
};
use neural_mesh::mesh::Attributes;
use neural_mesh::metrics::QuickDistance;
use neural_mesh::simplify::{Assembly, Hidden, Purpose, SimplifyError};

use crate::failure::Failure;
use crate::files;
use crate::finished_run::FinishedRun;
use crate::plan::Plan;
use crate::progress::Progress;
use crate::read::open_in_pieces;
use crate::request::Request;

pub const PROBLEM: &str = "the mesh needs more memory than allowed";
pub const REMEDY: &str = "allow more with --memory";
/// Memory reserved in addition to that of the blocks, in bytes.
const OVERHEAD_BYTES: u64 = 16 << 20;
/// Costs in ns per face of simplifying in blocks and of measuring distances, for 100 million faces.
const SIMPLIFY_COST: f64 = 740.0;
const CHECK_COST: f64 = 460.0;

/// Simplifies a mesh that needs more memory than allowed; `None` if it fits.
pub fn simplify_in_blocks(request: &Request, progress: &mut Progress) -> Result<Option<FinishedRun>, Failure> {
    let path = &request.source.path;
    let began = Instant::now();
    let Some((pieces, n_bytes)) = open_in_pieces(path, request.memory, request.job.arguments.bake) else {
        return Ok(None);
    };
    check_options(request, &pieces)?;
    let room = working_space(request.output.as_deref(), n_bytes);
    let options = request.job.simplifier_options();
    let weights = request.job.weights.as_deref();
    let check_cost = if request.job.arguments.no_check { 0.0 } else { CHECK_COST };
    progress.set_plan(Plan::new(&[(JobStage::Simplify, SIMPLIFY_COST), (JobStage::Check, check_cost)]));
    let to_failure = |error| match error {
        OutOfCoreError::Simplify(SimplifyError::Interrupted) => Failure::Interrupted,
        error => Failure::in_file(path, error),
    };
    let result = simplify_pieces(&pieces, weights, &options, &room, &mut show_step(progress, JobStage::Simplify));
    let result = result.map_err(to_failure)?;
    let mut seconds = Seconds { simplify: began.elapsed().as_secs_f64(), ..Seconds::default() };
    let began = Instant::now();
    let n_samples = if request.job.arguments.no_check { 0 } else { SAMPLES };
    let distance = result.distance(n_samples, 0, &mut show_step(progress, JobStage::Check)).map_err(to_failure)?;
    seconds.check = began.elapsed().as_secs_f64();
    prepare_output(request, result, distance, seconds).map(Some)
}

/// Returns the memory for blocks of `n_bytes`, and the folder of the output: its disk must have room anyway.
pub fn working_space(output: Option<&Path>, n_bytes: u64) -> WorkingSpace<'_> {
    let folder = output.and_then(Path::parent).unwrap_or(Path::new(""));
    WorkingSpace { n_bytes: n_bytes.saturating_sub(OVERHEAD_BYTES), folder }
}

pub fn show_step(progress: &mut Progress, step: JobStage) -> impl FnMut(f64) -> ControlFlow<()> + Send {
    move |done| {
        progress.show_step_done(step, done);
        ControlFlow::Continue(())
    }
}

/// Rejects options that need attributes or the whole mesh at once.
fn check_options(request: &Request, pieces: &Pieces) -> Result<(), Failure> {
    let options = request.job.closed_options();
    let named = [
        ("--lods", request.job.goal.n_levels().is_some()),
        ("--error", request.job.goal.is_by_error()),
        ("--size", request.job.goal.n_bytes().is_some()),
        ("--assembly paper", matches!(request.job.options.assembly, Assembly::Paper(_))),
        ("--importance", request.job.arguments.importance.is_some()),
        ("--keep", !request.job.arguments.keep.is_empty()),
        ("--ratio NAME=R", !request.job.arguments.shares().is_empty()),
        ("--map", request.map.is_some()),
        ("--picture", request.picture.is_some()),
        ("--lock-boundaries", options.lock_boundaries),
        ("--subset", options.subset),
        ("--fill-holes or --printable", request.job.arguments.repair().is_some()),
        ("--bake", request.job.arguments.bake.is_some()),
        ("--compress", request.job.arguments.compress.is_some()),
        ("--prune", request.job.arguments.prune_below().is_some()),
        ("--hidden", options.hidden != Hidden::Keep),
        ("--for", options.purpose != Purpose::Shape),
        ("--no-weld or --weld", request.job.arguments.no_weld || request.job.arguments.weld.is_some()),
    ];
    if let Some((name, _)) = named.into_iter().find(|(_, is_requested)| *is_requested) {
        return Err(Failure::in_file(
            &request.source.path,
            format!("{PROBLEM}, and {name} does not work in blocks: {REMEDY}, or leave the option out"),
        ));
    }
    check_content(request, pieces)
}

/// Rejects a file whose attributes would be lost in blocks, unless they are to be ignored.
pub fn check_content(request: &Request, pieces: &Pieces) -> Result<(), Failure> {
    let content =
        pieces.other_content().filter(|_| request.job.arguments.ignore.is_empty() && !request.job.format.is_bare());
    let loses_content = |content| {
        let what = format!(
            "{PROBLEM}, and simplification in blocks would drop its {content}: {REMEDY}, or accept that with --ignore uv,normals,colors,materials"
        );
        Failure::in_file(&request.source.path, what)
    };
    content.map_or(Ok(()), |content| Err(loses_content(content)))
}

fn prepare_output(
    request: &Request,
    result: OutOfCoreResult,
    distance: Option<QuickDistance>,
    mut seconds: Seconds,
) -> Result<FinishedRun, Failure> {
    let began = Instant::now();
    let extra = Extra::default();
    let model = Model::new(&result.simplified.mesh, result.frame, Attributes::NONE, &extra);
    let path = request.output.as_deref();
    let shown_path = path.unwrap_or(Path::new("standard output"));
    let written = io::write_attributed(&model, &WriteOptions::new(request.job.format, "mesh"));
    let written = written.map_err(|error| Failure::in_file(shown_path, error))?;
    let mut pending: Vec<_> =
        path.map(|path| files::prepare_file(path, &written.bytes, request.force)).transpose()?.into_iter().collect();
    let bytes = path.is_none().then_some(written.bytes);
    seconds.write = began.elapsed().as_secs_f64();
    let in_blocks = format!("simplified in {} blocks to save memory", result.n_blocks);
    let notes = written.notes.into_iter().chain([in_blocks]).collect();
    let mut report = JobReport { notes, seconds, ..create_report(request, &result) };
    report.output.vertices_written = written.n_vertices;
    report.distance = distance.as_ref().map(DistanceFigures::new);
    let json = files::prepare_json(request.report.as_deref(), &report, request.force, &mut pending)?;
    let cleaned = result.counts.to_string();
    let (bytes, read) = (bytes.or(json), request.read.clone());
    Ok(FinishedRun { report, cleaned, bytes, pending, extra_files: None, force: request.force, read })
}

fn create_report(request: &Request, result: &OutOfCoreResult) -> JobReport {
    let simplified = &result.simplified;
    JobReport {
        input: MeshSize { vertices: result.n_vertices, faces: result.n_faces, shape: None },
        output: OutputFigures::new(MeshSize::measure(&simplified.mesh, request.report.is_some()), &simplified.report),
        target: request.job.goal.clone(),
        outcome: outcome_words(&simplified.report.outcome),
        scores: score_words(simplified.report.scores),
        seed: request.job.arguments.seed,
        threads: rayon::current_num_threads(),
        seconds: Seconds::default(),
        cleaned: result.counts,
        repaired: None,
        baked: None,
        named: Vec::new(),
        distance: None,
        certified: None,
        levels: Vec::new(),
        notes: Vec::new(),
        free: Vec::new(),
    }
}
