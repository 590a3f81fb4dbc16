//! `neural-mesh mesh-points`: read a cloud, mesh it, write, say what surface came of it.

use std::path::PathBuf;
use std::time::Instant;

use neural_mesh::io::{self, Format};
use neural_mesh::job::{Part, Watch};
use neural_mesh::mesh::{PointCloud, RawMesh, TriMesh, point_cloud, topology};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{Assembly, MeshedPoints, SimplifyError, mesh_points};
use serde::Serialize;

use crate::args::MeshPointsArgs;
use crate::failure::Failure;
use crate::files::{self, Pending};
use crate::interrupt;
use crate::names::{check_stdout, format_of, is_stream, output_format};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::read::read_weights;
use crate::simplify::in_pool;
use crate::words::{Voice, grouped};

/// Costs: reading is little beside the network.
const COSTS: [(Part, f64); 3] = [(Part::Read, 0.03), (Part::Simplify, 0.95), (Part::Write, 0.02)];

/// One run, complete and consistent.
struct Request {
    args: MeshPointsArgs,
    format: Format,
}

/// All that is reported of a run, in the order of the JSON.
#[derive(Debug, Serialize)]
struct Report {
    /// Different finite points of the cloud.
    points: usize,
    /// Points at the position of an earlier one, left out.
    repeated_points: usize,
    /// Points with a coordinate that is infinite or not a number, left out.
    non_finite_points: usize,
    vertices: usize,
    faces: usize,
    /// Points that were to be vertices and ended on no face.
    unused_points: usize,
    closed: bool,
    /// Loops of edges with one face.
    holes: usize,
    boundary_edges: usize,
    non_manifold_edges: usize,
    non_manifold_vertices: usize,
    /// Edges whose two faces do not agree on a side, because the surface has only one.
    inconsistent_edges: usize,
    components: usize,
    seed: u64,
    threads: usize,
    seconds: f64,
}

/// Checks the arguments, then does what they ask, on as many threads as asked.
pub fn run(args: MeshPointsArgs) -> Result<(), Failure> {
    let request = resolve(args)?;
    let results = [Some(&request.args.output), request.args.report.as_ref()].into_iter().flatten();
    let files_to_be = results.map(PathBuf::as_path).filter(|path| !is_stream(path));
    files::check_places(files_to_be, request.args.force)?;
    interrupt::watch(Failure::Interrupted);
    in_pool(request.args.threads, || run_in_pool(&request))
}

fn resolve(args: MeshPointsArgs) -> Result<Request, Failure> {
    let given = args.format.as_deref().map(format_of).transpose()?;
    let format = output_format(&args.output, given)?;
    check_stdout(is_stream(&args.output), reports_to_stdout(&args))?;
    Ok(Request { args, format })
}

fn reports_to_stdout(args: &MeshPointsArgs) -> bool {
    args.report.as_deref().is_some_and(is_stream)
}

fn run_in_pool(request: &Request) -> Result<(), Failure> {
    let Request { args, .. } = request;
    let began = Instant::now();
    let mut progress = Progress::new(args.quiet, Plan::new(&COSTS));
    progress.begin(Part::Read);
    let raw = io::read_points(&files::read(&args.input)?).map_err(|error| Failure::of(&args.input, error))?;
    let meshed = Meshed::of(raw, args, &mut progress)?;
    progress.begin(Part::Write);
    let (bytes, mut pending) = written(request, &meshed)?;
    let report = told(args, &meshed, began.elapsed().as_secs_f64());
    let json = files::prepare_json(args.report.as_deref(), &report, args.force, &mut pending)?;
    drop(progress);
    let for_stdout = is_stream(&args.output).then_some(bytes).or(json);
    for_stdout.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
    files::place(pending)?;
    say(args, &report);
    Ok(())
}

/// Meshes a cloud in memory, as `embedded` says.
pub fn embedded(args: MeshPointsArgs, raw: Option<RawMesh>, mut progress: Progress) -> Result<PointsMeshed, Failure> {
    let request = resolve(args)?;
    let began = Instant::now();
    let read =
        || io::read_points(&files::read(&request.args.input)?).map_err(|error| Failure::of(&request.args.input, error));
    let meshed = Meshed::of(raw.map_or_else(read, Ok)?, &request.args, &mut progress)?;
    let report = told(&request.args, &meshed, began.elapsed().as_secs_f64());
    let mut pending = Vec::new();
    files::prepare_json(request.args.report.as_deref(), &report, request.args.force, &mut pending)?;
    if !is_stream(&request.args.output) {
        pending.extend(written(&request, &meshed)?.1);
    }
    let report = serde_json::to_string(&report).map_err(|error| Failure::of(&request.args.input, error))?;
    let exact = meshed.exact_positions();
    let Meshed { cloud, result, .. } = meshed;
    let of_file = |&point: &u32| cloud.source.get(point as usize).copied().unwrap_or(point);
    let sources = result.source_points.iter().map(of_file).collect();
    Ok(PointsMeshed { mesh: result.mesh, exact, sources, report, pending })
}

/// A meshed cloud as another face has it.
pub struct PointsMeshed {
    /// The mesh, in local coordinates.
    pub mesh: TriMesh,
    /// Where its vertices lie, n x 3, where the cloud is in double precision.
    pub exact: Option<Vec<[f64; 3]>>,
    /// The point, as given, that each vertex is, n.
    pub sources: Vec<u32>,
    /// What `--report` writes.
    pub report: String,
    /// Files on their way.
    pub pending: Vec<Pending>,
}

/// A cloud and the mesh over it.
struct Meshed {
    cloud: PointCloud,
    /// Points as read, where these are doubles: vertices stay in place, and get back what single precision does not hold.
    exact: Option<Vec<[f64; 3]>>,
    result: MeshedPoints,
}

impl Meshed {
    fn of(raw: RawMesh, args: &MeshPointsArgs, progress: &mut Progress) -> Result<Self, Failure> {
        let given = read_weights(args.weights.as_deref(), Assembly::Paper)?;
        let weights = given.as_ref().unwrap_or_else(|| Weights::shipped_paper_open());
        let exact = raw.double.then(|| raw.positions.clone());
        let cloud = point_cloud(raw).map_err(|error| Failure::of(&args.input, error))?;
        let result = meshed(args, &cloud, weights, progress)?;
        Ok(Self { cloud, exact, result })
    }

    /// The vertices as their points were read, where these are doubles.
    fn exact_positions(&self) -> Option<Vec<[f64; 3]>> {
        let exact = self.exact.as_deref()?;
        let as_read = |at: &u32| exact.get(*self.cloud.source.get(*at as usize)? as usize).copied();
        self.result.source_points.iter().map(as_read).collect()
    }
}

fn meshed(
    args: &MeshPointsArgs,
    cloud: &PointCloud,
    weights: &Weights,
    progress: &mut Progress,
) -> Result<MeshedPoints, Failure> {
    let n_points = cloud.points.len();
    let of_ratio = args.ratio.map(|ratio| (n_points as f64 * ratio) as usize);
    let n_vertices = args.vertices.map(|count| count.of(n_points)).or(of_ratio).unwrap_or(n_points);
    let result = mesh_points(&cloud.points, n_vertices, weights, args.seed, &mut |event| progress.event(event));
    result.map_err(|error| match error {
        SimplifyError::Interrupted => Failure::Interrupted,
        error => Failure::of(&args.input, error),
    })
}

/// The mesh as bytes, and as a file on its way unless standard output is its place.
fn written(request: &Request, meshed: &Meshed) -> Result<(Vec<u8>, Vec<Pending>), Failure> {
    let Request { args, format, .. } = request;
    let Meshed { cloud, result, .. } = meshed;
    let bytes = match meshed.exact_positions() {
        Some(positions) => io::write_exact(&result.mesh, positions, *format),
        None => io::write(&result.mesh, &cloud.frame, *format),
    };
    let bytes = bytes.map_err(|error| Failure::of(&args.output, error))?;
    let is_file = !is_stream(&args.output);
    let pending = is_file.then(|| files::prepare(&args.output, &bytes, args.force)).transpose()?;
    Ok((bytes, pending.into_iter().collect()))
}

fn told(args: &MeshPointsArgs, Meshed { cloud, result, .. }: &Meshed, seconds: f64) -> Report {
    let found = topology(&result.mesh);
    Report {
        points: cloud.points.len(),
        repeated_points: cloud.repeated,
        non_finite_points: cloud.non_finite,
        vertices: found.vertices,
        faces: found.faces,
        unused_points: result.unused_points,
        closed: found.closed,
        holes: found.boundary_loops,
        boundary_edges: found.boundary_edges,
        non_manifold_edges: found.non_manifold_edges,
        non_manifold_vertices: found.non_manifold_vertices,
        inconsistent_edges: found.inconsistent_edges,
        components: found.components,
        seed: args.seed,
        threads: rayon::current_num_threads(),
        seconds,
    }
}

fn say(args: &MeshPointsArgs, report: &Report) {
    let voice = match (args.quiet, is_stream(&args.output) || reports_to_stdout(args)) {
        (true, _) => Voice::Quiet,
        (false, false) => Voice::Out,
        (false, true) => Voice::Err,
    };
    let [points, vertices, faces] = [report.points, report.vertices, report.faces].map(grouped);
    if report.repeated_points + report.non_finite_points > 0 {
        let [repeated, non_finite] = [report.repeated_points, report.non_finite_points].map(grouped);
        voice.say(&format!("left out  {repeated} repeated points, {non_finite} non-finite points"));
    }
    if report.unused_points > 0 {
        voice.say(&format!("unused    {} points are not used by any face", grouped(report.unused_points)));
    }
    voice.say(&format!("size      {points} points -> {vertices} vertices, {faces} faces"));
    voice.say(&surface(report));
    voice.say(&format!("time      {:.3} s", report.seconds));
}

/// `surface   3 holes (12 boundary edges), 0 non-manifold edges, 2 components`
fn surface(report: &Report) -> String {
    let [holes, boundary, edges, components] =
        [report.holes, report.boundary_edges, report.non_manifold_edges, report.components].map(grouped);
    let holes = if report.closed { "closed".into() } else { format!("{holes} holes ({boundary} boundary edges)") };
    format!("surface   {holes}, {edges} non-manifold edges, {components} components")
}
