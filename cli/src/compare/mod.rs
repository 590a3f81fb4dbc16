//! `neural-mesh compare`: measures simplified meshes against their original.

mod cover_data;
mod images;
mod json;
mod mesh_cover;
mod meshes;
mod page;
mod table;

use std::path::Path;

use neural_mesh::appearance::{self, USUAL_HEIGHT, appearance};
use neural_mesh::io::ReadMesh;
use neural_mesh::job::{JobStage, Watch};
use neural_mesh::metrics::{CompareOptions, Figure, ReferenceMesh, compare};

use crate::args::CompareArgs;
use crate::failure::Failure;
use crate::files::{self, Pending};
use crate::interrupt;
use crate::names::{check_stdin, is_stream};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::simplify::in_pool;
use crate::words::{Voice, complain};
use meshes::{Meshes, Named, read_all};

struct Comparison {
    original: Named,
    results: Vec<MeasuredResult>,
    judging: CompareOptions,
}

/// Comparison for another program.
pub struct Compared {
    /// JSON of `--json`.
    pub figures: String,
    /// Page of `--html`, if requested.
    pub page: Option<String>,
}

struct MeasuredResult {
    mesh: Named,
    figures: Vec<Figure>,
}

const COSTS: [f64; 2] = [0.05, 0.15];

fn plan(args: &CompareArgs) -> Plan {
    let drawing = if args.html.is_some() { COSTS[1] } else { 0.0 };
    Plan::new(&[(JobStage::Read, COSTS[0]), (JobStage::Check, 1.0), (JobStage::Picture, drawing)])
}

pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    check(args)?;
    files::check_places(results(args), args.force)?;
    interrupt::watch(Failure::Interrupted);
    in_pool(args.threads, || run_in_pool(args))
}

fn run_in_pool(args: &CompareArgs) -> Result<(), Failure> {
    let mut progress = Progress::new(args.quiet, plan(args));
    progress.begin(JobStage::Read);
    let Meshes { original, simplified, unread } = read_all(args, Vec::new())?;
    let left_out = if unread.is_empty() { Ok(()) } else { Err(Failure::Reported) };
    progress.suspend(|| unread.iter().for_each(complain));
    if simplified.is_empty() {
        return left_out;
    }
    let comparison = measure_results(args, original, simplified, &mut progress);
    progress.begin(JobStage::Picture);
    let PreparedOutputs { pending, json, notes } = prepare_outputs(args, &comparison)?;
    drop(progress);
    // Messages must not mix with JSON on standard output.
    let voice = match json {
        _ if args.quiet => Voice::Quiet,
        Some(_) => Voice::Err,
        None => Voice::Out,
    };
    json.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
    files::place(pending)?;
    table::lines(&comparison, args.all).iter().for_each(|line| voice.say(line));
    notes.iter().for_each(|note| voice.say(&format!("note      {note}")));
    left_out
}

pub fn compare_in_memory(args: &CompareArgs, given: Vec<Option<ReadMesh>>) -> Result<Compared, Failure> {
    let Meshes { original, simplified, unread } = read_all(args, given)?;
    if let Some(failure) = unread.into_iter().next() {
        return Err(failure);
    }
    let comparison = measure_results(args, original, simplified, &mut Progress::silent());
    let figures = json::value(&comparison).to_string();
    Ok(Compared { figures, page: args.html.is_some().then(|| page::page(&comparison).html) })
}

fn measure_results(args: &CompareArgs, original: Named, simplified: Vec<Named>, progress: &mut Progress) -> Comparison {
    progress.begin(JobStage::Check);
    let mut judging = CompareOptions::default();
    (judging.samples, judging.seed) = (args.samples, args.seed);
    let prepared = ReferenceMesh::new(&original.mesh, &judging);
    let n_results = simplified.len() as f64;
    let judge = |(number, mesh): (usize, Named)| {
        progress.move_on(JobStage::Check, (number as f64 + 0.5) / (n_results + 0.5));
        let mut figures = compare(&prepared, &mesh.mesh);
        let looks = args.appearance.then(|| appearance(original.to_shaded(), mesh.to_shaded(), USUAL_HEIGHT)).flatten();
        figures.extend(appearance::figures(looks.as_ref()));
        MeasuredResult { figures, mesh }
    };
    let results = simplified.into_iter().enumerate().map(judge).collect();
    Comparison { original, results, judging }
}

struct PreparedOutputs {
    pending: Vec<Pending>,
    json: Option<Vec<u8>>,
    notes: Vec<String>,
}

fn prepare_outputs(args: &CompareArgs, comparison: &Comparison) -> Result<PreparedOutputs, Failure> {
    let (mut pending, mut notes) = (Vec::new(), Vec::new());
    let json = files::prepare_json(args.json.as_deref(), &json::value(comparison), args.force, &mut pending)?;
    if let Some(path) = &args.html {
        let page = page::page(comparison);
        pending.push(files::prepare(path, page.html.as_bytes(), args.force)?);
        notes = page.notes;
    }
    Ok(PreparedOutputs { pending, json, notes })
}

fn results(args: &CompareArgs) -> impl Iterator<Item = &Path> {
    [&args.json, &args.html].into_iter().flatten().map(|path| path.as_path()).filter(|path| !is_stream(path))
}

pub fn check(args: &CompareArgs) -> Result<(), Failure> {
    check_stdin(args.inputs())?;
    if args.html.as_deref().is_some_and(is_stream) {
        return Err(Failure::Usage("--html needs the name of a file".into()));
    }
    Ok(())
}
