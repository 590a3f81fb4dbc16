//! `neural-mesh limits`: reports how small a mesh gets, and what limits it.

use std::collections::HashSet;

use neural_mesh::appearance::{USUAL_HEIGHT, appearance};
use neural_mesh::job::{
    Arguments, Document, Dropped, Goal, JobReport, JobStage, Level, MeshSize, Shape, Size, Watch, list_advice, percent,
    stop_reason,
};
use neural_mesh::picture::{CornerNormals, ShadedMesh};
use neural_mesh::simplify::{DroppedComponent, Simplified};
use serde::Serialize;

use crate::args::LimitsArgs;
use crate::document;
use crate::escapes::escape_controls_in_json;
use crate::failure::{Failure, display_path};
use crate::interrupt;
use crate::messages::{MessageStream, group_digits, limit_lines, list_names};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::request::Request;
use crate::simplify::{in_pool, simplify_document};

const TRIED_SHARES: [f64; 6] = [0.5, 0.25, 0.1, 0.05, 0.02, 0.01];
/// Vertices of the smallest possible surface.
const MIN_VERTICES: usize = 3;

#[derive(Debug, Serialize)]
struct SizeLimits {
    file: String,
    vertices: usize,
    faces: usize,
    components: usize,
    boundary_edges: usize,
    levels: Vec<SizeRow>,
    smallest: SizeRow,
    outcome: String,
    #[serde(rename = "held")]
    limits: LimitCounts,
    /// Options that would allow a smaller mesh, one line each.
    free: Vec<String>,
}

#[derive(Debug, Serialize)]
struct SizeRow {
    /// Requested share of the vertices in percent; the actual one for the smallest mesh.
    percent: f64,
    vertices: usize,
    faces: usize,
    components: usize,
    /// Mean distance to the original, in percent of the diagonal.
    mean_percent: Option<f64>,
    max_percent: Option<f64>,
    /// FLIP error of shaded pictures, 0 for equal ones, at most 1.
    flip: Option<f64>,
    /// Components that the previous, larger level still had.
    dropped: Vec<Dropped>,
}

#[derive(Debug, Serialize)]
struct LimitCounts {
    kept_edges: usize,
    locked_vertices: usize,
    components_at_minimum: usize,
    split_vertices: usize,
}

pub fn run(args: &LimitsArgs) -> Result<(), Failure> {
    interrupt::handle_signals(Failure::Interrupted);
    in_pool(args.threads, || describe(args))
}

fn describe(args: &LimitsArgs) -> Result<(), Failure> {
    let mut request = create_request(args)?;
    let mut progress = Progress::new(args.quiet, Plan::estimate(&request, None));
    progress.begin(JobStage::Read);
    let document = document::open(&mut request)?;
    let sizes = level_sizes(document.mesh().positions().len());
    request.job.goal = Goal::Levels(sizes.clone());
    let (run, results) = simplify_document(&document, &request, &mut progress)?;
    drop(progress);
    let limits = SizeLimits::new(&document, &request, &run.report, &results, &sizes)?;
    if args.json {
        let json = serde_json::to_string(&limits).map_err(|error| Failure::in_file(&request.source.path, error))?;
        MessageStream::Out.print_line(&escape_controls_in_json(&json));
    } else {
        limits.to_lines(&run.report).iter().for_each(|line| MessageStream::Out.print_line(line));
    }
    Ok(())
}

fn create_request(args: &LimitsArgs) -> Result<Request, Failure> {
    let arguments = Arguments {
        lods: vec!["50%".into()],
        no_weld: args.no_weld,
        lock_boundaries: args.lock_boundaries,
        keep_features: args.keep_features,
        keep_components: args.keep_components,
        ignore: args.ignore.clone(),
        keep: args.keep.clone(),
        ..Arguments::default()
    };
    let mut request = Request::without_output(&args.input, args.format.as_deref(), &arguments)?;
    // The mesh is not written.
    (request.job.shapes, request.stays_in_memory) = (true, true);
    Ok(request)
}

/// Returns the sizes to try: several ratios, and the smallest surface.
fn level_sizes(n_vertices: usize) -> Vec<Size> {
    let is_more = |share: &f64| (share * n_vertices as f64) as usize > MIN_VERTICES;
    let shares = TRIED_SHARES.into_iter().filter(is_more).map(Size::Ratio);
    shares.chain([Size::Vertices(MIN_VERTICES)]).collect()
}

impl SizeLimits {
    fn new(
        document: &Document,
        request: &Request,
        report: &JobReport,
        results: &[Simplified],
        sizes: &[Size],
    ) -> Result<Self, Failure> {
        // A component counts for the first level that dropped it.
        let mut dropped_faces = HashSet::new();
        let mut rows: Vec<SizeRow> = Vec::new();
        for ((level, result), size) in report.levels.iter().zip(results).zip(sizes) {
            let is_new: Vec<bool> =
                result.report.dropped.iter().map(|&DroppedComponent { face, .. }| dropped_faces.insert(face)).collect();
            let flip = picture_error(document, result);
            rows.push(SizeRow { flip, ..SizeRow::new(level, *size, report.input.vertices, &is_new) });
        }
        let no_result = || Failure::in_file(&request.source.path, "no result was made");
        let (last, smallest) = report.levels.last().zip(rows.pop()).ok_or_else(no_result)?;
        let n_reached = report.levels.iter().take_while(|level| stop_reason(&level.outcome).is_none()).count();
        let output = &last.output;
        // Components dropped at levels that were not reached count for the smallest mesh.
        let (levels, beyond) = split_rows(rows, n_reached);
        let dropped = beyond.into_iter().flat_map(|row| row.dropped).chain(smallest.dropped).collect();
        Ok(Self {
            file: display_path(&request.source.path),
            vertices: report.input.vertices,
            faces: report.input.faces,
            components: shape_count(&report.input, |shape| shape.components),
            boundary_edges: shape_count(&report.input, |shape| shape.boundary_edges),
            levels,
            smallest: SizeRow { dropped, ..smallest },
            outcome: last.outcome.clone(),
            limits: LimitCounts {
                kept_edges: output.kept_edges,
                locked_vertices: output.locked_vertices,
                components_at_minimum: output.components_at_minimum,
                split_vertices: output.split_vertices,
            },
            free: list_advice(&request.job, document, output),
        })
    }

    fn to_lines(&self, report: &JobReport) -> Vec<String> {
        let [vertices, faces, components] = [self.vertices, self.faces, self.components].map(group_digits);
        let boundary = match self.boundary_edges {
            0 => "closed".into(),
            n => format!("{} boundary edges", group_digits(n)),
        };
        let mut lines = vec![
            format!("{}: {vertices} vertices, {faces} faces, components: {components}, {boundary}", self.file),
            format!(
                "{:<10}{:>12}{:>12}{:>12}{:>12}{:>12}{:>9}",
                "size", "vertices", "faces", "components", "mean", "max", "picture"
            ),
        ];
        lines.extend(self.levels.iter().map(|row| row.line(&format!("{} %", row.percent))));
        lines.push(self.smallest.line("smallest"));
        let named = self.levels.iter().map(|row| (format!("at {} %", row.percent), row));
        for (size, row) in named.chain([("smallest".into(), &self.smallest)]).filter(|(_, row)| !row.dropped.is_empty())
        {
            lines.push(format!("dropped   {size}: {}", list_names(&row.dropped, usize::MAX)));
        }
        lines.extend(report.levels.last().into_iter().flat_map(|last| limit_lines(&last.output)));
        lines.extend(stop_reason(&self.outcome).map(|why| format!("limit     nothing smaller keeps this: {why}")));
        lines.extend(self.free.iter().map(|how| format!("try       {how}")));
        lines
    }
}

fn split_rows(mut rows: Vec<SizeRow>, n: usize) -> (Vec<SizeRow>, Vec<SizeRow>) {
    let beyond = rows.split_off(n.min(rows.len()));
    (rows, beyond)
}

impl SizeRow {
    fn new(level: &Level, size: Size, n_vertices: usize, is_new: &[bool]) -> Self {
        let MeshSize { vertices, faces, .. } = level.output.size;
        let share = size.share().unwrap_or(vertices as f64 / n_vertices.max(1) as f64);
        let dropped = level.output.dropped.iter().zip(is_new).filter(|(_, is_new)| **is_new);
        Self {
            percent: percent(share),
            vertices,
            faces,
            components: shape_count(&level.output.size, |shape| shape.components),
            mean_percent: level.distance.map(|distance| distance.mean_percent),
            max_percent: level.distance.map(|distance| distance.max_percent),
            flip: None,
            dropped: dropped.map(|(component, _)| component.clone()).collect(),
        }
    }

    fn line(&self, size: &str) -> String {
        let [vertices, faces, components] = [self.vertices, self.faces, self.components].map(group_digits);
        let format_distance = |percent: Option<f64>| percent.map_or("-".into(), |percent| format!("{percent:.3} %"));
        let [mean, max] = [self.mean_percent, self.max_percent].map(format_distance);
        let picture = self.flip.map_or("-".into(), |flip| format!("{flip:.3}"));
        format!("{size:<10}{vertices:>12}{faces:>12}{components:>12}{mean:>12}{max:>12}{picture:>9}")
    }
}

/// Compares shaded pictures of original and result, without textures; `None` without faces.
fn picture_error(document: &Document, result: &Simplified) -> Option<f64> {
    let surfaces = document.place_surfaces(result).ok()?;
    let normals = surfaces.each_ref().map(|surface| CornerNormals::new(&surface.attributes));
    let [before, after] =
        [0, 1].map(|i| ShadedMesh { normals: normals[i].as_ref(), ..ShadedMesh::bare(&surfaces[i].mesh) });
    appearance(before, after, USUAL_HEIGHT).map(|appearance| appearance.flip)
}

fn shape_count(size: &MeshSize, figure: impl Fn(&Shape) -> usize) -> usize {
    size.shape.as_ref().map_or(0, figure)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_fall_down_to_the_smallest_surface() {
        assert_eq!(level_sizes(100_000).len(), 7);
        assert_eq!(
            level_sizes(100),
            [Size::Ratio(0.5), Size::Ratio(0.25), Size::Ratio(0.1), Size::Ratio(0.05), Size::Vertices(3)]
        );
        assert_eq!(level_sizes(4), [Size::Vertices(3)]);
    }
}
