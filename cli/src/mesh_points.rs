//! `neural-mesh mesh-points`: meshes a point cloud.

use std::time::Instant;

use neural_mesh::io::{self, FilesRead, Format};
use neural_mesh::job::{JobStage, Watch};
use neural_mesh::mesh::{PointCloud, RawMesh, TriMesh, point_cloud, topology};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{
    Assembly, MeshedPoints, PaperOptions, PointsOptions, SimplifyError, count_of_share, mesh_points,
};
use serde::Serialize;

use crate::args::MeshPointsArgs;
use crate::failure::Failure;
use crate::files::{self, OutputPaths, PendingFile};
use crate::interrupt;
use crate::messages::{MessageStream, group_digits};
use crate::names::{check_stdout, is_stream, output_format, parse_format, refuse_progression};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::read::read_weights;
use crate::simplify::in_pool;

const COSTS: [(JobStage, f64); 3] = [(JobStage::Read, 0.03), (JobStage::Simplify, 0.95), (JobStage::Write, 0.02)];

struct MeshPointsRequest {
    args: MeshPointsArgs,
    format: Format,
    read: FilesRead,
}

/// Report, with fields in the order of the JSON.
#[derive(Debug, Serialize)]
struct Report {
    points: usize,
    /// Points dropped because an earlier one has their position.
    repeated_points: usize,
    non_finite_points: usize,
    vertices: usize,
    faces: usize,
    /// Points chosen as vertices that got no face.
    unused_points: usize,
    /// Neighbours over which noise was smoothed, 0 if it was not.
    smoothed_over: usize,
    closed: bool,
    holes: usize,
    boundary_edges: usize,
    non_manifold_edges: usize,
    non_manifold_vertices: usize,
    /// Edges whose two faces are oriented differently, as on a one-sided surface.
    inconsistent_edges: usize,
    components: usize,
    seed: u64,
    threads: usize,
    seconds: f64,
}

pub fn run(args: MeshPointsArgs) -> Result<(), Failure> {
    let request = resolve_request(args)?;
    check_outputs(&request)?;
    interrupt::handle_signals(Failure::Interrupted);
    in_pool(request.args.threads, || run_in_pool(&request))
}

fn check_outputs(MeshPointsRequest { args, read, .. }: &MeshPointsRequest) -> Result<(), Failure> {
    files::check_output_paths(&OutputPaths::new([&args.output], &args.report), read, args.force)
}

fn resolve_request(args: MeshPointsArgs) -> Result<MeshPointsRequest, Failure> {
    refuse_progression(&args.input)?;
    let given = args.format.as_deref().map(parse_format).transpose()?;
    let format = output_format(&args.output, given)?;
    check_stdout(is_stream(&args.output), reports_to_stdout(&args))?;
    let read = files::list_files_read(Some(&args.input), args.weights.as_deref());
    Ok(MeshPointsRequest { args, format, read })
}

fn reports_to_stdout(args: &MeshPointsArgs) -> bool {
    args.report.as_deref().is_some_and(is_stream)
}

fn run_in_pool(request: &MeshPointsRequest) -> Result<(), Failure> {
    let MeshPointsRequest { args, .. } = request;
    let began = Instant::now();
    let mut progress = Progress::new(args.quiet, Plan::new(&COSTS));
    progress.begin(JobStage::Read);
    let raw = io::read_points(&files::read(&args.input)?).map_err(|error| Failure::in_file(&args.input, error))?;
    let meshed = MeshedCloud::new(raw, args, &mut progress)?;
    progress.begin(JobStage::Write);
    let (bytes, mut pending) = prepare_output(request, &meshed)?;
    let report = create_report(args, &meshed, began.elapsed().as_secs_f64());
    let json = files::prepare_json(args.report.as_deref(), &report, args.force, &mut pending)?;
    drop(progress);
    let for_stdout = is_stream(&args.output).then_some(bytes).or(json);
    for_stdout.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
    files::place_files(pending, &request.read)?;
    print_report(args, &report);
    Ok(())
}

pub fn mesh_in_memory(
    args: MeshPointsArgs,
    raw: Option<RawMesh>,
    mut progress: Progress,
) -> Result<MeshPointsOutput, Failure> {
    let request = resolve_request(args)?;
    check_outputs(&request)?;
    let began = Instant::now();
    let read = || {
        io::read_points(&files::read(&request.args.input)?)
            .map_err(|error| Failure::in_file(&request.args.input, error))
    };
    let meshed = MeshedCloud::new(raw.map_or_else(read, Ok)?, &request.args, &mut progress)?;
    let report = create_report(&request.args, &meshed, began.elapsed().as_secs_f64());
    let mut pending = Vec::new();
    files::prepare_json(request.args.report.as_deref(), &report, request.args.force, &mut pending)?;
    if !is_stream(&request.args.output) {
        pending.extend(prepare_output(&request, &meshed)?.1);
    }
    let report = serde_json::to_string(&report).map_err(|error| Failure::in_file(&request.args.input, error))?;
    let exact = meshed.exact_positions();
    let MeshedCloud { cloud, result, .. } = meshed;
    let to_input_point = |&point: &u32| cloud.source.get(point as usize).copied().unwrap_or(point);
    let sources = result.source_points.iter().map(to_input_point).collect();
    Ok(MeshPointsOutput { mesh: result.mesh, exact, sources, report, pending, read: request.read })
}

/// Mesh of a point cloud, returned to another program.
pub struct MeshPointsOutput {
    /// Mesh in local coordinates.
    pub mesh: TriMesh,
    /// Vertex positions, n x 3, if the cloud has double precision.
    pub exact: Option<Vec<[f64; 3]>>,
    /// Input point of each vertex, n.
    pub sources: Vec<u32>,
    /// Report, as `--report` writes it.
    pub report: String,
    /// Written files that must be moved into place.
    pub pending: Vec<PendingFile>,
    /// Files that were read.
    pub read: FilesRead,
}

struct MeshedCloud {
    cloud: PointCloud,
    /// Points in double precision.
    exact: Option<Vec<[f64; 3]>>,
    result: MeshedPoints,
}

impl MeshedCloud {
    fn new(raw: RawMesh, args: &MeshPointsArgs, progress: &mut Progress) -> Result<Self, Failure> {
        let given = read_weights(args.weights.as_deref(), &Assembly::Paper(PaperOptions::default()))?;
        let weights = given.as_deref().unwrap_or_else(|| Weights::shipped_paper_open());
        let exact = raw.double.then(|| raw.positions.clone());
        let cloud = point_cloud(raw).map_err(|error| Failure::in_file(&args.input, error))?;
        let result = mesh_cloud(args, &cloud, weights, progress)?;
        Ok(Self { cloud, exact, result })
    }

    fn exact_positions(&self) -> Option<Vec<[f64; 3]>> {
        let exact = self.exact.as_deref()?;
        if self.result.has_moved {
            return Some(self.result.mesh.positions().iter().map(|&p| self.cloud.frame.to_file(p)).collect());
        }
        let as_read = |at: &u32| exact.get(*self.cloud.source.get(*at as usize)? as usize).copied();
        self.result.source_points.iter().map(as_read).collect()
    }
}

fn mesh_cloud(
    args: &MeshPointsArgs,
    cloud: &PointCloud,
    weights: &Weights,
    progress: &mut Progress,
) -> Result<MeshedPoints, Failure> {
    let n_points = cloud.points.len();
    let n_of_ratio = args.ratio.map(|ratio| count_of_share(n_points, ratio));
    let n_vertices = args.vertices.map(|size| size.count(n_points)).or(n_of_ratio).unwrap_or(n_points);
    let normals = cloud.normals.as_deref();
    let options = PointsOptions { n_vertices, keep_points: args.keep_points, normals, seed: args.seed };
    let result = mesh_points(&cloud.points, &options, weights, &mut |event| progress.event(event));
    result.map_err(|error| match error {
        SimplifyError::Interrupted => Failure::Interrupted,
        error => Failure::in_file(&args.input, error),
    })
}

fn prepare_output(request: &MeshPointsRequest, meshed: &MeshedCloud) -> Result<(Vec<u8>, Vec<PendingFile>), Failure> {
    let MeshPointsRequest { args, format, .. } = request;
    let MeshedCloud { cloud, result, .. } = meshed;
    let bytes = match meshed.exact_positions() {
        Some(positions) => io::write_exact(&result.mesh, positions, *format),
        None => io::write(&result.mesh, &cloud.frame, *format),
    };
    let bytes = bytes.map_err(|error| Failure::in_file(&args.output, error))?;
    let is_file = !is_stream(&args.output);
    let pending = is_file.then(|| files::prepare_file(&args.output, &bytes, args.force)).transpose()?;
    Ok((bytes, pending.into_iter().collect()))
}

fn create_report(args: &MeshPointsArgs, MeshedCloud { cloud, result, .. }: &MeshedCloud, seconds: f64) -> Report {
    let topology = topology(&result.mesh);
    Report {
        points: cloud.points.len(),
        repeated_points: cloud.repeated,
        non_finite_points: cloud.non_finite,
        vertices: topology.vertices,
        faces: topology.faces,
        unused_points: result.unused_points,
        smoothed_over: result.smoothed_over.unwrap_or(0),
        closed: topology.closed,
        holes: topology.boundary_loops,
        boundary_edges: topology.boundary_edges,
        non_manifold_edges: topology.non_manifold_edges,
        non_manifold_vertices: topology.non_manifold_vertices,
        inconsistent_edges: topology.inconsistent_edges,
        components: topology.components,
        seed: args.seed,
        threads: rayon::current_num_threads(),
        seconds,
    }
}

fn print_report(args: &MeshPointsArgs, report: &Report) {
    // Messages must not mix with a mesh or a report on standard output.
    let voice = match (args.quiet, is_stream(&args.output) || reports_to_stdout(args)) {
        (true, _) => MessageStream::Quiet,
        (false, false) => MessageStream::Out,
        (false, true) => MessageStream::Err,
    };
    let [points, vertices, faces] = [report.points, report.vertices, report.faces].map(group_digits);
    if report.repeated_points + report.non_finite_points > 0 {
        let [repeated, non_finite] = [report.repeated_points, report.non_finite_points].map(group_digits);
        voice.print_line(&format!("left out  {repeated} repeated points, {non_finite} non-finite points"));
    }
    if report.smoothed_over > 0 {
        voice.print_line(&format!("smoothed  noise over {} neighbours", report.smoothed_over));
    }
    if report.unused_points > 0 {
        voice.print_line(&format!("unused    {} points are not used by any face", group_digits(report.unused_points)));
    }
    voice.print_line(&format!("size      {points} points -> {vertices} vertices, {faces} faces"));
    voice.print_line(&surface_line(report));
    voice.print_line(&format!("time      {:.3} s", report.seconds));
}

fn surface_line(report: &Report) -> String {
    let [holes, boundary, edges, components] =
        [report.holes, report.boundary_edges, report.non_manifold_edges, report.components].map(group_digits);
    let holes = if report.closed { "closed".into() } else { format!("{holes} holes ({boundary} boundary edges)") };
    format!("surface   {holes}, {edges} non-manifold edges, {components} components")
}
