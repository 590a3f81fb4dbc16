//! `neural-mesh clusters`: writes a hierarchy of clusters, and a page that draws its cuts.

mod in_blocks;
mod paints;
mod report;
mod request;

use std::borrow::Cow;
use std::path::Path;
use std::time::Instant;

use neural_mesh::clusters::{Clusters, build_clusters};
use neural_mesh::io::{self, FilesRead};
use neural_mesh::job::{Document, Job, JobStage, Watch};
use neural_mesh::simplify::ClosedOptions;

use crate::args::ClustersArgs;
use crate::failure::{Failure, display_path};
use crate::files::{self, OutputPaths};
use crate::interrupt;
use crate::names::{check_stdout, is_stream};
use crate::page::embed_file_with;
use crate::page::empty_pages::empty_page;
use crate::plan::Plan;
use crate::progress::Progress;
use crate::read::{open_in_pieces, parse_source};
use crate::request::Request;
use crate::simplify::in_pool;
use in_blocks::write_in_blocks;
use report::{WrittenClusters, create_report, print_report};
use request::{cluster_options, create_request, to_failure};

const COSTS: [(JobStage, f64); 3] = [(JobStage::Read, 0.05), (JobStage::Simplify, 0.9), (JobStage::Write, 0.05)];
const MESHLET_MESH: &str = "meshlet_mesh";

pub fn run(args: &ClustersArgs) -> Result<(), Failure> {
    if args.html.as_deref().is_some_and(is_stream) {
        return Err(Failure::Usage("--html needs the name of a file".into()));
    }
    // A hierarchy is no mesh, so it never replaces its input.
    let outputs = [Some(&args.output), args.report.as_ref(), args.html.as_ref()].into_iter().flatten();
    let read = files::list_files_read(None, [args.input.as_path()]);
    files::check_output_paths(&OutputPaths::new([], outputs), &read, args.force)?;
    check_stdout(is_stream(&args.output), args.report.as_deref().is_some_and(is_stream))?;
    interrupt::handle_signals(Failure::Interrupted);
    in_pool(args.threads, || run_in_pool(args, &read))
}

fn run_in_pool(args: &ClustersArgs, read: &FilesRead) -> Result<(), Failure> {
    let began = Instant::now();
    let request = create_request(args)?;
    let mut progress = Progress::new(args.quiet, Plan::new(&COSTS));
    progress.begin(JobStage::Read);
    let mut written = match open_in_pieces(&args.input, request.memory, None) {
        Some((pieces, n_bytes)) => write_in_blocks(args, &request, (&pieces, n_bytes), &mut progress)?,
        None => write_from_memory(args, &request, read, &mut progress)?,
    };
    let report = create_report(args, &written, began);
    let json = files::prepare_json(args.report.as_deref(), &report, args.force, &mut written.pending)?;
    drop(progress);
    files::check_pending(&written.pending, read)?;
    written.for_stdout.or(json).iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
    files::place_files(written.pending, read)?;
    print_report(args, &report, &written.notes);
    Ok(())
}

fn write_from_memory(
    args: &ClustersArgs,
    request: &Request,
    files_read: &FilesRead,
    progress: &mut Progress,
) -> Result<WrittenClusters, Failure> {
    let read = parse_source(&request.source, io::read_attributed, io::read_attributed_path)?;
    let document = Document::from_mesh(read, &request.job).map_err(|error| request.failure(error))?;
    files_read.join(&document.files_read());
    progress.begin(JobStage::Simplify);
    let clusters = build(args, &request.job, &document, progress)?;
    progress.begin(JobStage::Write);
    let bytes = encode(&args.output, &clusters)?;
    let (mut pending, mut notes) = (Vec::new(), Vec::new());
    if !is_stream(&args.output) {
        pending.push(files::prepare_file(&args.output, &bytes, args.force)?);
    }
    if let Some(path) = &args.html {
        // The page reads the same bytes, unless the file is Bevy's.
        let file = if is_for_bevy(&args.output) { Cow::Owned(clusters.to_bytes()) } else { Cow::Borrowed(&bytes[..]) };
        let paints = paints::pack_paints(&document, request.job.arguments.allow_outside);
        let data = (&paints.facts, paints.scripts.as_str());
        let page = embed_file_with(empty_page("clusters.html"), &input_name(&args.input), &file, data);
        notes = paints.notes;
        pending.push(files::prepare_file(path, page.as_bytes(), args.force)?);
    }
    let (figures, n_faces, n_bytes) = (clusters.figures(), document.mesh().faces().len(), bytes.len());
    let for_stdout = is_stream(&args.output).then_some(bytes);
    Ok(WrittenClusters { figures, n_faces, n_bytes, notes, pending, for_stdout })
}

fn build(args: &ClustersArgs, job: &Job, document: &Document, progress: &mut Progress) -> Result<Clusters, Failure> {
    let simplify = ClosedOptions { frame: document.frame, ..job.closed_options() };
    let options = cluster_options(args, simplify);
    let made = build_clusters(&document.input(), &options, &mut |event| progress.event(event));
    made.map_err(|error| to_failure(args, error))
}

fn is_for_bevy(output: &Path) -> bool {
    output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(MESHLET_MESH))
}

fn encode(output: &Path, clusters: &Clusters) -> Result<Vec<u8>, Failure> {
    match is_for_bevy(output) {
        true => clusters.to_meshlet_mesh().map_err(|error| Failure::in_file(output, error)),
        false => Ok(clusters.to_bytes()),
    }
}

/// Returns the name of the mesh for readers of the page.
fn input_name(input: &Path) -> String {
    match input.file_name() {
        Some(name) if !is_stream(input) => name.to_string_lossy().into_owned(),
        _ => display_path(input),
    }
}
