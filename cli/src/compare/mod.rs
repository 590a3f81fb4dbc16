//! `neural-mesh compare`: measures simplified meshes against their original.

mod comparison;
mod cover_data;
pub mod images;
mod json;
mod mesh_cover;
mod meshes;
mod page;
mod table;

use neural_mesh::io::{FilesRead, ReadMesh};
use neural_mesh::job::{JobStage, Watch};

use crate::args::CompareArgs;
use crate::failure::Failure;
use crate::files::{self, OutputPaths, PendingFile};
use crate::interrupt;
use crate::messages::{MessageStream, print_error};
use crate::names::{check_stdin, is_stream};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::simplify::in_pool;
use comparison::{Comparison, measure_results};
use meshes::{ComparedMeshes, read_all};

/// Comparison returned to another program.
pub struct ComparisonOutput {
    /// JSON of `--json`.
    pub figures: String,
    /// Page of `--html`, if requested.
    pub page: Option<String>,
}

const READ_AND_PAGE_COSTS: [f64; 2] = [0.05, 0.15];

fn plan(args: &CompareArgs) -> Plan {
    let drawing = if args.html.is_some() { READ_AND_PAGE_COSTS[1] } else { 0.0 };
    Plan::new(&[(JobStage::Read, READ_AND_PAGE_COSTS[0]), (JobStage::Check, 1.0), (JobStage::Picture, drawing)])
}

pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    check_args(args)?;
    let read = list_inputs(args);
    files::check_output_paths(
        &OutputPaths::new([], [&args.json, &args.html].into_iter().flatten()),
        &read,
        args.force,
    )?;
    interrupt::handle_signals(Failure::Interrupted);
    in_pool(args.threads, || run_in_pool(args, &read))
}

pub fn list_inputs(args: &CompareArgs) -> FilesRead {
    files::list_files_read(None, args.inputs())
}

fn run_in_pool(args: &CompareArgs, read: &FilesRead) -> Result<(), Failure> {
    let mut progress = Progress::new(args.quiet, plan(args));
    progress.begin(JobStage::Read);
    let ComparedMeshes { original, simplified, unread } = read_all(args, Vec::new(), read)?;
    let left_out = if unread.is_empty() { Ok(()) } else { Err(Failure::Reported) };
    progress.suspend(|| unread.iter().for_each(print_error));
    if simplified.is_empty() {
        return left_out;
    }
    let comparison = measure_results(args, original, simplified, &mut progress);
    progress.begin(JobStage::Picture);
    let PreparedOutputs { pending, json, notes } = prepare_outputs(args, &comparison)?;
    drop(progress);
    // Messages must not mix with JSON on standard output.
    let voice = match json {
        _ if args.quiet => MessageStream::Quiet,
        Some(_) => MessageStream::Err,
        None => MessageStream::Out,
    };
    files::check_pending(&pending, read)?;
    json.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
    files::place_files(pending, read)?;
    table::format_table(&comparison, args.all).iter().for_each(|line| voice.print_line(line));
    notes.iter().for_each(|note| voice.print_line(&format!("note      {note}")));
    left_out
}

pub fn compare_in_memory(
    args: &CompareArgs,
    given: Vec<Option<ReadMesh>>,
    read: &FilesRead,
) -> Result<ComparisonOutput, Failure> {
    let ComparedMeshes { original, simplified, unread } = read_all(args, given, read)?;
    if let Some(failure) = unread.into_iter().next() {
        return Err(failure);
    }
    let comparison = measure_results(args, original, simplified, &mut Progress::silent());
    let figures = json::to_json(&comparison).to_string();
    Ok(ComparisonOutput { figures, page: args.html.is_some().then(|| page::create_page(&comparison).html) })
}

struct PreparedOutputs {
    pending: Vec<PendingFile>,
    json: Option<Vec<u8>>,
    notes: Vec<String>,
}

fn prepare_outputs(args: &CompareArgs, comparison: &Comparison) -> Result<PreparedOutputs, Failure> {
    let (mut pending, mut notes) = (Vec::new(), Vec::new());
    let json = files::prepare_json(args.json.as_deref(), &json::to_json(comparison), args.force, &mut pending)?;
    if let Some(path) = &args.html {
        let page = page::create_page(comparison);
        pending.push(files::prepare_file(path, page.html.as_bytes(), args.force)?);
        notes = page.notes;
    }
    Ok(PreparedOutputs { pending, json, notes })
}

pub fn check_args(args: &CompareArgs) -> Result<(), Failure> {
    check_stdin(args.inputs())?;
    if args.html.as_deref().is_some_and(is_stream) {
        return Err(Failure::Usage("--html needs the name of a file".into()));
    }
    Ok(())
}
