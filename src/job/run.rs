//! Execution of a job: simplify, bake, pack, measure and report.

use crate::io::{Format, PackOptions, Packing};
use crate::mesh::Role;
use crate::search::simplify_to_size;
use crate::simplify::{Hidden, Input, Options, Purpose, Simplified, Size, simplify, simplify_levels_of_detail};

use super::advice::list_advice;
use super::bake;
use super::baked_material::BakedMaterial;
use super::document::Document;
use super::error::JobError;
use super::files::Meshes;
use super::importance::VertexValues;
use super::outcome::JobOutcome;
use super::progression::levels_for_goal;
use super::report::{
    Certified, DistanceFigures, JobReport, Level, MeshSize, OutputFigures, SAMPLES, Seconds, outcome_words,
    score_words, stop_reason,
};
use super::request::Job;
use super::resolve::{options_for, resolve_target};
use super::shares;
use super::simplified_results::SimplifiedResults;
use super::size::{Bound, Goal};
use super::watch::{JobStage, Watch};
use super::within::simplify_within;

/// Runs a job on the current thread pool; writes no files.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::io::Format;
/// use neural_mesh::job::{Document, Job, run};
/// use neural_mesh::simplify::{Options, Size};
///
/// let mut job = Job::new(Options::new(Size::Faces(2)), Format::Ply);
/// job.names.files = vec!["square.ply".into()];
/// let square = b"OFF\n5 4 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.5 0\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n";
/// let document = Document::from_bytes(square, None, &job)?;
/// let mut outcome = run(&document, &job, &mut |_| ControlFlow::Continue(()))?;
/// let files = outcome.write(&document, &job)?;
/// assert_eq!((outcome.report.output.size.faces, files.len()), (2, 1));
/// assert!(files[0].bytes.starts_with(b"ply"));
/// # Ok::<(), neural_mesh::job::JobError>(())
/// ```
///
/// # Errors
/// [`JobError`] if options contradict each other or do not suit the document, the mesh cannot be simplified, or the
/// listener ends the job.
pub fn run(document: &Document, job: &Job, watch: &mut dyn Watch) -> Result<JobOutcome, JobError> {
    job.check()?;
    check_bounds(document, job)?;
    watch.begin(JobStage::Simplify);
    let mut simplified = simplify_document(document, job, watch)?;
    let without_repeats = simplified.leave_out_repeats(&job.goal.texts());
    let SimplifiedResults { results, certified, note, pack, named } = simplified;
    let baked = bake_result(document, &results, job, watch)?;
    let (packing, unpacked) = pack_results(document, &results.iter().collect::<Vec<_>>(), pack, job)?;
    watch.begin(JobStage::Check);
    let mut levels: Vec<Level> = results.iter().map(|it| measure_result(document, it, packing.as_ref(), job)).collect();
    for (level, distance) in levels.iter_mut().zip(&certified) {
        level.certified = Some(Certified::new(distance, document.diagonal()));
    }
    levels.iter_mut().for_each(|level| level.set_view(|| document.diagonal(), job.field_of_view()));
    let of_baked = baked.as_ref().map_or(Vec::new(), |baked| baked.notes.clone());
    let mut notes = [document.notes.clone(), of_baked, unpacked].concat();
    let n_first_notes = notes.len();
    let unproved = results.first().and_then(|first| note_unproved(job, first));
    let others = [note.map(String::from), note_missing_poses(document, job), unproved, without_repeats];
    notes.extend(others.into_iter().flatten());
    let mut report = make_report(document, job, &results, levels)?;
    (report.notes, report.named, report.baked) = (notes, named, baked.as_ref().map(|baked| baked.figures));
    Ok(JobOutcome { results, report, baked, packing, n_first_notes })
}

/// Rejects distances in the unit of the mesh within which any shape of its size is, as they were meant in percent.
fn check_bounds(document: &Document, job: &Job) -> Result<(), JobError> {
    let option = if job.goal.n_levels().is_some() { "--lods" } else { "--error" };
    // No point of a mesh is farther than this from the middle of its bounding box.
    let most = 0.5 * document.diagonal();
    let too_far = job.goal.bounds().iter().find_map(|bound| match *bound {
        Bound::Absolute(distance) if distance > most && most > 0.0 => Some(distance),
        _ => None,
    });
    let Some(distance) = too_far else { return Ok(()) };
    let meant = if distance <= 100.0 { format!("; did you mean {distance}%?") } else { String::new() };
    let what = "is more than half of the diagonal of the mesh, so any shape is within it: give less";
    Err(JobError::Options(format!("{option} {distance}: {what} than {most:.3}, or percent{meant}")))
}

fn simplify_document(document: &Document, job: &Job, watch: &mut dyn Watch) -> Result<SimplifiedResults, JobError> {
    if let Some(progression) = document.progression() {
        return levels_for_goal(document, progression, job);
    }
    // Named shares are simplified first; the rest then gets the remaining size.
    let values = VertexValues::new(document, job)?;
    let options = options_for(document, job);
    // The check has refused shares with the paper's assembly.
    let Some(closed) = options.assembly.as_closed().filter(|_| !job.arguments.shares().is_empty()) else {
        let kept = document.faces_named("--keep", &job.arguments.keep)?;
        let mut input = values.input(document);
        input.kept = &kept;
        return simplify_to_goal(document, &input, &options, job, watch);
    };
    let (simplified_groups, named) = shares::simplify_named(document, &values, closed, job, watch)?;
    let mut simplified =
        simplify_to_goal(document, &simplified_groups.input(document.united_mesh()), &options, job, watch)?;
    shares::renumber(&mut simplified.results, &simplified_groups);
    Ok(SimplifiedResults { named, ..simplified })
}

fn simplify_to_goal(
    document: &Document,
    input: &Input,
    options: &Options,
    job: &Job,
    watch: &mut dyn Watch,
) -> Result<SimplifiedResults, JobError> {
    let single_result = |result| SimplifiedResults::new(vec![result], job);
    // The check has refused goals that need the closed assembly, except for a single level.
    match (&job.goal, options.assembly.as_closed()) {
        (goal, Some(closed)) if goal.is_by_error() => {
            simplify_within(goal.bounds(), (document, input), closed, job, watch)
        }
        (Goal::Levels(sizes), Some(closed)) if !sizes.is_empty() => {
            let sizes: Vec<Size> = sizes.iter().map(|size| resolve_target(*size, document, job)).collect();
            let forward_event = &mut |event| watch.event(event);
            let levels = simplify_levels_of_detail(input, closed, &sizes, forward_event)?;
            Ok(SimplifiedResults::new(levels, job))
        }
        (Goal::Bytes(n_bytes), _) => {
            document.check_bytes(*n_bytes, job, job.names.file(0))?;
            let bytes_of = |result: &Simplified| bytes_of(document, result, job);
            let forward_event = &mut |event| watch.event(event);
            simplify_to_size(input, &options.assembly, *n_bytes, &bytes_of, forward_event).map(single_result)
        }
        _ => Ok(single_result(simplify(input, options, &mut |event| watch.event(event))?)),
    }
}

fn bytes_of(document: &Document, result: &Simplified, job: &Job) -> Result<usize, JobError> {
    let (packing, _) = pack_results(document, &[result], job.arguments.packing(), job)?;
    let alone = Meshes { results: vec![result], packing: packing.as_ref(), ..Meshes::default() };
    let files = document.to_files(&alone, job, job.names.file(0));
    files.map(|files| files.n_bytes(job.format)).map_err(|error| JobError::Output(error.to_string()))
}

fn bake_result(
    document: &Document,
    results: &[Simplified],
    job: &Job,
    watch: &mut dyn Watch,
) -> Result<Option<BakedMaterial>, JobError> {
    let (Some(size), Some(result)) = (job.arguments.bake, results.first()) else { return Ok(None) };
    watch.begin(JobStage::Bake);
    let is_gltf = matches!(job.format, Format::Gltf | Format::Glb);
    let (looks, missing) = document.looks(job.arguments.allow_outside);
    let original = (document.mesh(), document.attributes(), &looks);
    let baked = bake::bake_material(size, is_gltf, original, &result.mesh).map_err(JobError::Document)?;
    Ok(Some(BakedMaterial { notes: [missing, baked.notes].concat(), ..baked }))
}

// The second result has one line per mesh whose positions stay unpacked.
fn pack_results(
    document: &Document,
    results: &[&Simplified],
    options: Option<PackOptions>,
    job: &Job,
) -> Result<(Option<Packing>, Vec<String>), JobError> {
    let Some(options) = options else { return Ok((None, Vec::new())) };
    let packing = document.packing(results, job, &options);
    let (packing, notes) = packing.map_err(|error| JobError::Document(error.to_string()))?;
    Ok((Some(packing), notes))
}

/// Measures size, distance and, if requested, topology of a result.
fn measure_result(document: &Document, result: &Simplified, packing: Option<&Packing>, job: &Job) -> Level {
    let distance = || document.distance(result, packing, SAMPLES).as_ref().map(DistanceFigures::new);
    let mut output = OutputFigures::new(MeshSize::measure(&result.mesh, job.shapes), &result.report);
    output.dropped = document.dropped_components(&result.report);
    Level::new(output, outcome_words(&result.report.outcome), (!job.arguments.no_check).then(distance).flatten())
}

fn note_missing_poses(document: &Document, job: &Job) -> Option<String> {
    let has_poses = document.attributes().channel(Role::MorphPosition).is_some();
    let what = "--for poses: the mesh has no skin or morph targets, so every region is assumed to bend alike";
    (job.closed_options().purpose == Purpose::Poses && !has_poses).then(|| what.into())
}

// The proof leaves out components dropped by `--prune` and `--hidden`.
fn note_unproved(job: &Job, result: &Simplified) -> Option<String> {
    let is_by_name = job.arguments.prune_below().is_some() || job.closed_options().hidden == Hidden::Drop;
    let is_proved = job.goal.is_by_error();
    let what =
        "the proved distance leaves out components dropped by --prune and --hidden; the sampled distance includes them";
    (is_proved && is_by_name && result.report.components_pruned > 0).then(|| what.into())
}

fn make_report(
    document: &Document,
    job: &Job,
    results: &[Simplified],
    levels: Vec<Level>,
) -> Result<JobReport, JobError> {
    let none = || JobError::Document("no result was made".into());
    let (first, result) = levels.first().cloned().zip(results.first()).ok_or_else(none)?;
    // Dropped components change the topology, so the report shows it.
    let with_shape = job.shapes || result.report.components_pruned > 0;
    let is_stopped = stop_reason(&first.outcome).is_some();
    let free = if is_stopped { list_advice(job, document, &first.output) } else { Vec::new() };
    Ok(JobReport {
        free,
        input: MeshSize::measure(document.mesh(), with_shape),
        output: first.output,
        target: job.goal.clone(),
        outcome: first.outcome,
        scores: score_words(result.report.scores),
        seed: job.arguments.seed,
        threads: rayon::current_num_threads(),
        seconds: Seconds::default(),
        cleaned: document.counts,
        repaired: document.repaired,
        baked: None,
        named: Vec::new(),
        distance: first.distance,
        certified: first.certified,
        levels: if job.goal.n_levels().is_some() { levels } else { Vec::new() },
        notes: Vec::new(),
    })
}
