//! Report of a hierarchy.

use std::time::Instant;

use neural_mesh::clusters::ClusterFigures;
use serde::Serialize;

use crate::args::ClustersArgs;
use crate::files::PendingFile;
use crate::messages::{MessageStream, group_digits};
use crate::names::is_stream;

/// Hierarchy in temporary files, or for standard output.
pub struct WrittenClusters {
    pub figures: ClusterFigures,
    /// Faces of the input.
    pub n_faces: usize,
    pub n_bytes: usize,
    /// Changes to textures of the page, one line each.
    pub notes: Vec<String>,
    pub pending: Vec<PendingFile>,
    pub for_stdout: Option<Vec<u8>>,
}

/// Report, with fields in the order of the JSON.
#[derive(Debug, Serialize)]
pub struct ClustersReport {
    faces: usize,
    clusters: usize,
    groups: usize,
    levels: u32,
    roots: usize,
    root_faces: usize,
    /// Mean faces per cluster over the most.
    fill: f64,
    /// Proved distance of the coarsest level, in the unit of the mesh.
    root_error: f32,
    /// Bytes of the file.
    bytes: usize,
    threads: usize,
    seconds: f64,
}

pub fn create_report(args: &ClustersArgs, written: &WrittenClusters, began: Instant) -> ClustersReport {
    let ClusterFigures { n_clusters, n_groups, n_levels, n_roots, n_root_faces, n_faces, root_error, .. } =
        written.figures;
    ClustersReport {
        faces: written.n_faces,
        clusters: n_clusters,
        groups: n_groups,
        levels: n_levels,
        roots: n_roots,
        root_faces: n_root_faces,
        fill: n_faces as f64 / (n_clusters * args.max_faces) as f64,
        root_error,
        bytes: written.n_bytes,
        threads: rayon::current_num_threads(),
        seconds: began.elapsed().as_secs_f64(),
    }
}

pub fn print_report(args: &ClustersArgs, report: &ClustersReport, notes: &[String]) {
    // Messages must not mix with a file or a report on standard output.
    let is_streamed = is_stream(&args.output) || args.report.as_deref().is_some_and(is_stream);
    let voice = match (args.quiet, is_streamed) {
        (true, _) => MessageStream::Quiet,
        (false, false) => MessageStream::Out,
        (false, true) => MessageStream::Err,
    };
    notes.iter().for_each(|note| voice.print_line(&format!("note      {note}")));
    let [faces, clusters, groups] = [report.faces, report.clusters, report.groups].map(group_digits);
    let ClustersReport { levels, roots, root_faces, root_error, .. } = report;
    voice.print_line(&format!("size      {faces} faces -> {clusters} clusters in {groups} groups, {levels} levels"));
    voice.print_line(&format!(
        "coarsest  {roots} cluster of {root_faces} faces, within {root_error:.4} of the original (proved)"
    ));
    voice.print_line(&format!("file      {:.3} MB", report.bytes as f64 / 1e6));
    voice.print_line(&format!("time      {:.3} s", report.seconds));
}
