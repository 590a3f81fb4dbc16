//! `neural-mesh clusters`: writes a hierarchy of clusters, and a page that draws its cuts.

mod page;

use std::borrow::Cow;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Parser, ValueEnum};
use neural_mesh::clusters::{ClusterError, ClusterOptions, Clusters, build_clusters};
use neural_mesh::io;
use neural_mesh::job::{Document, Job, JobStage, Watch};
use neural_mesh::simplify::{ClosedOptions, SimplifyError};
use serde::Serialize;

use crate::args::{ClustersArgs, SimplifyArgs};
use crate::failure::{Failure, display_path};
use crate::files;
use crate::interrupt;
use crate::messages::{MessageStream, group_digits};
use crate::names::{check_stdout, is_stream};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::read::parse_source;
use crate::request::{Request, resolve_request};
use crate::simplify::in_pool;

const COSTS: [(JobStage, f64); 3] = [(JobStage::Read, 0.05), (JobStage::Simplify, 0.9), (JobStage::Write, 0.05)];
const MESHLET_MESH: &str = "meshlet_mesh";

/// Report, with fields in the order of the JSON.
#[derive(Debug, Serialize)]
struct ClustersReport {
    faces: usize,
    clusters: usize,
    groups: usize,
    levels: u32,
    roots: usize,
    root_faces: u32,
    /// Mean faces per cluster over the most.
    fill: f64,
    /// Proved distance of the coarsest level, in the unit of the mesh.
    root_error: f32,
    /// Bytes of the file.
    bytes: usize,
    threads: usize,
    seconds: f64,
}

pub fn run(args: &ClustersArgs) -> Result<(), Failure> {
    if args.html.as_deref().is_some_and(is_stream) {
        return Err(Failure::Usage("--html needs the name of a file".into()));
    }
    let outputs = [Some(&args.output), args.report.as_ref(), args.html.as_ref()].into_iter().flatten();
    files::check_output_paths(outputs.map(PathBuf::as_path).filter(|path| !is_stream(path)), args.force)?;
    check_stdout(is_stream(&args.output), args.report.as_deref().is_some_and(is_stream))?;
    interrupt::handle_signals(Failure::Interrupted);
    in_pool(args.threads, || run_in_pool(args))
}

fn run_in_pool(args: &ClustersArgs) -> Result<(), Failure> {
    let began = Instant::now();
    let request = create_request(args)?;
    let mut progress = Progress::new(args.quiet, Plan::new(&COSTS));
    progress.begin(JobStage::Read);
    let read = parse_source(&request.source, io::read_attributed, io::read_attributed_path)?;
    let document = Document::from_mesh(read, &request.job).map_err(|error| request.failure(error))?;
    progress.begin(JobStage::Simplify);
    let clusters = build(args, &request.job, &document, &mut progress)?;
    progress.begin(JobStage::Write);
    let bytes = encode(&args.output, &clusters)?;
    let mut pending = Vec::new();
    if !is_stream(&args.output) {
        pending.push(files::prepare_file(&args.output, &bytes, args.force)?);
    }
    if let Some(path) = &args.html {
        // The page reads the same bytes, unless the file is Bevy's.
        let file = if is_for_bevy(&args.output) { Cow::Owned(clusters.to_bytes()) } else { Cow::Borrowed(&bytes[..]) };
        let page = page::create_page(&input_name(&args.input), &file);
        pending.push(files::prepare_file(path, page.as_bytes(), args.force)?);
    }
    let report = create_report(args, &clusters, (document.mesh().faces().len(), bytes.len()), began);
    let json = files::prepare_json(args.report.as_deref(), &report, args.force, &mut pending)?;
    drop(progress);
    let for_stdout = is_stream(&args.output).then_some(bytes).or(json);
    for_stdout.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
    files::place_files(pending)?;
    print_report(args, &report);
    Ok(())
}

fn create_request(args: &ClustersArgs) -> Result<Request, Failure> {
    // A GLB holds all attributes, so that none is left out.
    let mut words: Vec<OsString> =
        ["simplify", "-o", "-", "--ratio", "50%", "--format", "glb"].map(OsString::from).into();
    let ignored = args.ignore.iter().filter_map(|what| Some(what.to_possible_value()?.get_name().to_string()));
    words.extend(ignored.map(|what| format!("--ignore={what}").into()));
    let effort = args.effort.to_possible_value();
    words.extend(effort.map(|effort| format!("--effort={}", effort.get_name()).into()));
    words.extend(["--".into(), args.input.clone().into_os_string()]);
    // The arguments are given to the parser of `simplify`, so that its checks and defaults apply.
    let parsed = SimplifyArgs::try_parse_from(words).map_err(|error| Failure::Usage(error.to_string()))?;
    resolve_request(parsed)
}

fn build(args: &ClustersArgs, job: &Job, document: &Document, progress: &mut Progress) -> Result<Clusters, Failure> {
    let &ClustersArgs { max_faces, max_vertices, clusters_per_group, .. } = args;
    let simplify = ClosedOptions { frame: document.frame, ..job.closed_options() };
    let options = ClusterOptions { max_faces, max_vertices, clusters_per_group, simplify };
    let made = build_clusters(&document.input(&[], &[]), &options, &mut |event| progress.event(event));
    made.map_err(|error| match error {
        ClusterError::Simplify(SimplifyError::Interrupted) => Failure::Interrupted,
        ClusterError::BadSize { .. } => Failure::Usage(error.to_string()),
        error => Failure::in_file(&args.input, error),
    })
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

fn create_report(
    args: &ClustersArgs,
    clusters: &Clusters,
    (faces, bytes): (usize, usize),
    began: Instant,
) -> ClustersReport {
    let roots = clusters.roots();
    let root_faces = roots.iter().map(|&root| clusters.clusters[root as usize].n_faces).sum();
    let n_clusters = clusters.clusters.len();
    ClustersReport {
        faces,
        clusters: n_clusters,
        groups: clusters.groups.len(),
        levels: 1 + clusters.clusters.iter().map(|cluster| cluster.level).max().unwrap_or(0),
        roots: roots.len(),
        root_faces,
        fill: clusters.faces.len() as f64 / (n_clusters * args.max_faces) as f64,
        root_error: clusters.groups.iter().map(|group| group.error).fold(0.0, f32::max),
        bytes,
        threads: rayon::current_num_threads(),
        seconds: began.elapsed().as_secs_f64(),
    }
}

fn print_report(args: &ClustersArgs, report: &ClustersReport) {
    // Messages must not mix with a file or a report on standard output.
    let is_streamed = is_stream(&args.output) || args.report.as_deref().is_some_and(is_stream);
    let voice = match (args.quiet, is_streamed) {
        (true, _) => MessageStream::Quiet,
        (false, false) => MessageStream::Out,
        (false, true) => MessageStream::Err,
    };
    let [faces, clusters, groups] = [report.faces, report.clusters, report.groups].map(group_digits);
    let ClustersReport { levels, roots, root_faces, root_error, .. } = report;
    voice.print_line(&format!("size      {faces} faces -> {clusters} clusters in {groups} groups, {levels} levels"));
    voice.print_line(&format!(
        "coarsest  {roots} cluster of {root_faces} faces, within {root_error:.4} of the original (proved)"
    ));
    voice.print_line(&format!("file      {:.3} MB", report.bytes as f64 / 1e6));
    voice.print_line(&format!("time      {:.3} s", report.seconds));
}
