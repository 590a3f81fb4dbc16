//! Hierarchies of meshes larger than `--memory`, without attributes.

use neural_mesh::clusters::cluster_pieces;
use neural_mesh::io::Pieces;
use neural_mesh::job::{JobStage, Watch};

use crate::args::ClustersArgs;
use crate::failure::Failure;
use crate::files;
use crate::names::is_stream;
use crate::out_of_core::{PROBLEM, REMEDY, check_content, show_step, working_space};
use crate::progress::Progress;
use crate::request::Request;

use super::report::WrittenClusters;
use super::request::{cluster_options, to_failure};

/// Builds the hierarchy of a file in pieces, with at most `n_bytes` of memory, and writes it to a temporary file.
pub fn write_in_blocks(
    args: &ClustersArgs,
    request: &Request,
    (pieces, n_bytes): (&Pieces, u64),
    progress: &mut Progress,
) -> Result<WrittenClusters, Failure> {
    check_output(args)?;
    check_content(request, pieces)?;
    let options = cluster_options(args, request.job.closed_options());
    let room = working_space(Some(&args.output), n_bytes);
    progress.begin(JobStage::Simplify);
    let stored = cluster_pieces(pieces, &options, &room, &mut show_step(progress, JobStage::Simplify));
    let mut stored = stored.map_err(|error| to_failure(args, error))?;
    progress.begin(JobStage::Write);
    let (file, n_bytes) = files::prepare_file_by(&args.output, args.force, |file| stored.write(file))?;
    let (figures, n_faces) = (stored.figures, stored.n_faces);
    Ok(WrittenClusters { figures, n_faces, n_bytes, notes: Vec::new(), pending: vec![file], for_stdout: None })
}

/// Rejects outputs that need the whole hierarchy in memory.
fn check_output(args: &ClustersArgs) -> Result<(), Failure> {
    let ending = args.output.extension();
    let problem = if args.html.is_some() {
        "--html does not work in blocks: leave it out"
    } else if is_stream(&args.output) || ending.is_none_or(|ending| !ending.eq_ignore_ascii_case("nmc")) {
        "in blocks only files named .nmc are written: choose such a name"
    } else {
        return Ok(());
    };
    Err(Failure::in_file(&args.input, format!("{PROBLEM}, and {problem}, or {REMEDY}")))
}
