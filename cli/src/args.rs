//! Command-line arguments as typed; `request` turns them into checked options.

use std::path::{Path, PathBuf};

use clap::{ArgAction, ArgGroup, Parser};
use neural_mesh::clusters::LARGEST_CLUSTER;
use neural_mesh::job::{Arguments, Ignored, Size, seed, share, vertices, whole_number_parser};
use neural_mesh::simplify::{Effort, Optimize, ScoreSource};

use crate::numbers::{MAX_SAMPLES, parse_gib, parse_thread_count, parse_view};

// The help lists what this build has.
const FBX_NOTE: &str = if cfg!(feature = "fbx") { "; FBX is read only" } else { "" };

fn short_notes() -> String {
    format!(
        "Formats: OBJ, PLY, STL, OFF, glTF, GLB, VRM, 3MF, each also as .gz{FBX_NOTE}. Texture coordinates, normals, colours and \
        materials are carried over. --help-all explains all options and the exit codes."
    )
}

fn simplify_notes() -> String {
    format!(
        "Formats: reads and writes OBJ, PLY, STL, OFF, glTF, GLB, VRM and 3MF, each also compressed (.gz){FBX_NOTE}. \
        Reads glTF whose geometry or textures are compressed (Draco, meshopt, KTX2). {SIMPLIFY_NOTES}"
    )
}

const SIMPLIFY_NOTES: &str = "\
Texture coordinates, normals, colours, materials and other attributes are carried over. A glTF written as glTF keeps its scene, and \
its meshes share the target size.

Sizes: vertices at equal positions count as one vertex, and vertices without a face do not count.

Scores say which regions get more vertices. By default a formula gives more where the surface bends. --scores network uses the \
small network that ships with the program, --weights FILE your own. With --scores geometry all regions are treated by area alone. \
The report names the source (\"scores\": \"bending\").

Batches: meshes are simplified in parallel. Each result gets the name of its mesh inside OUT, and a row in OUT/manifest.csv. A mesh \
that fails gets a row with the reason, the others continue, and the exit code is 1. Folders are searched with all their subfolders. \
--format writes all results in one format. Only one batch may write into OUT at a time.

Exit codes: 0 success, 1 problem with the input, the disk or standard output, 2 wrong usage, 3 the result was written but misses the \
target, 130 interrupted. If a constraint stops the simplification early, the mesh is written, and the report gives the reason \
(\"outcome\": \"stopped: ...\"). The exit code is then 0, or 3 with --strict. A missed bound of --error or --size always gives 3.";

/// Headings of the program's own options in the help, after those of [`Arguments`].
const REPORTS_HEADING: &str = "Reports and pictures";
const RUNNING_HEADING: &str = "Batches, threads and memory";

/// Arguments of `simplify`: `--help` shows those that most people need, `--help-all` all of them.
#[derive(Debug, Parser)]
#[command(after_help = short_notes(), after_long_help = simplify_notes(), disable_help_flag = true,
    override_usage = "neural-mesh simplify IN... -o OUT TARGET [OPTIONS]

TARGET is one of --ratio, --faces, --vertices, --error, --size and --lods.",
    group = ArgGroup::new("target").required(true).multiple(true).args(["ratio", "vertices", "faces", "error", "size", "lods"]))]
pub struct SimplifyArgs {
    /// Mesh to simplify; - for standard input. Several meshes, a folder or a pattern like 'scans/*.ply' make a batch
    #[arg(value_name = "IN", required_unless_present = "list")]
    pub inputs: Vec<PathBuf>,
    /// File or folder for the result; - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    #[command(flatten)]
    pub options: Arguments,
    /// Replace existing files
    #[arg(short, long)]
    pub force: bool,
    /// Exit with code 3 if the target was not reached, as --error and --size always do
    #[arg(long, hide_short_help = true)]
    pub strict: bool,
    // The helps come after `--for`.
    /// Print help for the most used options
    #[arg(short, long, action = ArgAction::HelpShort, display_order = 91)]
    help: Option<bool>,
    /// Print help for all options
    #[arg(long, action = ArgAction::HelpLong, display_order = 92)]
    help_all: Option<bool>,

    /// Write a report as JSON; - for standard output. In a batch, a folder
    #[arg(long, value_name = "FILE.json", help_heading = REPORTS_HEADING)]
    pub report: Option<PathBuf>,
    /// Print the report as JSON to standard output
    #[arg(long, conflicts_with = "report", help_heading = REPORTS_HEADING)]
    pub json: bool,
    /// Draw original and result side by side into a PNG, JPEG or WebP, back sides in red, and mark where the distance is
    /// largest
    #[arg(long, value_name = "FILE.png", help_heading = REPORTS_HEADING)]
    pub picture: Option<PathBuf>,
    /// View of the picture: front, back, left, right, top, bottom, or degrees around and above, like 30,20 [default: a
    /// view that shows much]
    #[arg(long, value_name = "VIEW", value_parser = parse_view, allow_hyphen_values = true, requires = "picture", help_heading = REPORTS_HEADING,
        hide_short_help = true)]
    pub view: Option<[f32; 2]>,
    /// In the picture, draw edges over textures and colours
    #[arg(long, requires = "picture", help_heading = REPORTS_HEADING, hide_short_help = true)]
    pub wires: bool,
    /// Print what limits the result: kept edges, locked vertices, components
    #[arg(long, help_heading = REPORTS_HEADING)]
    pub explain: bool,
    /// Write a JSON file that maps input vertices to output vertices, and output corners to input faces
    #[arg(long, value_name = "FILE.json", help_heading = REPORTS_HEADING, hide_short_help = true)]
    pub map: Option<PathBuf>,
    /// Print errors only
    #[arg(short, long, help_heading = REPORTS_HEADING)]
    pub quiet: bool,

    /// Continue a batch: skip meshes that are done
    #[arg(long, help_heading = RUNNING_HEADING)]
    pub resume: bool,
    /// File with the meshes of a batch, one per line; - for standard input
    #[arg(long, value_name = "FILE", conflicts_with = "inputs", help_heading = RUNNING_HEADING, hide_short_help = true)]
    pub list: Option<PathBuf>,
    /// Threads to use [default: one per core]; does not change the result
    #[arg(long, value_name = "N", value_parser = parse_thread_count, allow_negative_numbers = true, help_heading = RUNNING_HEADING)]
    pub threads: Option<usize>,
    /// Memory to use, in GiB [default: what is free]; larger PLY, STL and OBJ are simplified in blocks
    #[arg(long, value_name = "GIB", value_parser = parse_gib, allow_negative_numbers = true, help_heading = RUNNING_HEADING,
        long_help = "Memory to use, in GiB, for all meshes of a batch together [default: what is free; half of it for a batch]. A single \
        binary PLY, STL or OBJ that needs more is simplified in blocks, without its attributes")]
    pub memory: Option<f64>,
}

const MESH_POINTS_NOTES: &str = "\
Reads the vertices of OBJ, PLY, STL, OFF and GLB, with or without faces, and text with x y z on each line. Writes what simplify \
writes. Points keep their positions; points at equal positions are merged. The result may have holes, which the program and \
--report count. Exit codes: 0 success, 1 problem with the input, the disk or standard output, 2 wrong usage, 130 interrupted.";

/// Arguments of `mesh-points`.
#[derive(Debug, Parser)]
#[command(after_help = MESH_POINTS_NOTES, group = ArgGroup::new("size").args(["ratio", "vertices"]))]
pub struct MeshPointsArgs {
    /// Point cloud; - for standard input
    #[arg(value_name = "CLOUD")]
    pub input: PathBuf,
    /// File for the mesh; - for standard output (messages then go to standard error)
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Share of the points that become vertices: 0.1 or 10% [default: all]
    #[arg(long, value_name = "R", value_parser = share, allow_hyphen_values = true)]
    pub ratio: Option<f64>,
    /// Number of points that become vertices: 5000, 10k, 1.5M or 10% [default: all]
    #[arg(long, value_name = "N", value_parser = vertices, allow_hyphen_values = true)]
    pub vertices: Option<Size>,
    /// Keep vertices at their points [default: noise is smoothed, and fewer vertices than points are placed]
    #[arg(long)]
    pub keep_points: bool,
    /// Weights of a trained network (safetensors) [default: those of the program]
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Seed of the sampling; equal seeds give equal meshes
    #[arg(long, value_name = "N", default_value = "0", value_parser = seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// Threads to use [default: one per core]; does not change the result
    #[arg(long, value_name = "N", value_parser = parse_thread_count, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Format of the result where the name of OUT has no known ending: obj, ply, ply-ascii, stl, stl-ascii, off, gltf, glb
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Write a report as JSON; - for standard output (messages then go to standard error)
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Replace existing files
    #[arg(short, long)]
    pub force: bool,
}

const INFO_NOTES: &str = "\
A file that cannot be read gets a line on standard error; the others are still described, and the exit code is 1. Exit \
codes: 0 success, 1 problem with a file, the disk or standard output, 2 wrong usage.";

/// Arguments of `info`.
#[derive(Debug, Parser)]
#[command(after_help = INFO_NOTES)]
pub struct InfoArgs {
    /// Meshes to describe; - for standard input
    #[arg(value_name = "IN", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Format of standard input, or of files without a known ending
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Do not merge vertices at equal positions
    #[arg(long)]
    pub no_weld: bool,
    /// Print JSON, one line for each mesh
    #[arg(long)]
    pub json: bool,
    /// Memory to use, in GiB [default: what is free]; larger PLY (binary), STL and OBJ are read in blocks
    #[arg(long, value_name = "GIB", value_parser = parse_gib, allow_negative_numbers = true, conflicts_with = "no_weld")]
    pub memory: Option<f64>,
}

/// Arguments of `clusters`.
#[derive(Debug, Parser)]
pub struct ClustersArgs {
    /// Mesh or scene; - for standard input. A scene becomes one mesh
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// File for the hierarchy: .nmc, or .meshlet_mesh for Bevy; - for standard output (messages then go to standard error)
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Most faces of a cluster, 4 to 256
    #[arg(long, value_name = "N", default_value = "128", value_parser = whole_number_parser::<usize>(4, LARGEST_CLUSTER as u64))]
    pub max_faces: usize,
    /// Most vertices of a cluster, 4 to 256
    #[arg(long, value_name = "N", default_value = "256", value_parser = whole_number_parser::<usize>(4, LARGEST_CLUSTER as u64))]
    pub max_vertices: usize,
    /// About how many clusters are simplified together, at least 2
    #[arg(long, value_name = "N", default_value = "16", value_parser = whole_number_parser::<usize>(2, u64::MAX))]
    pub clusters_per_group: usize,
    /// Time to spend: more time, smaller distance to the original
    #[arg(long, value_enum, default_value_t)]
    pub effort: Effort,
    /// Discard attributes (uv, normals, colors, materials)
    #[arg(long, value_enum, value_name = "WHAT", value_delimiter = ',')]
    pub ignore: Vec<Ignored>,
    /// Threads to use [default: one per core]; does not change the result
    #[arg(long, value_name = "N", value_parser = parse_thread_count, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Memory to use, in GiB [default: what is free]; larger PLY (binary), STL and OBJ are read in blocks
    #[arg(long, value_name = "GIB", value_parser = parse_gib, allow_negative_numbers = true)]
    pub memory: Option<f64>,
    /// Write a page that draws the hierarchy, with all that it needs inside
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
    /// Write a report as JSON; - for standard output (messages then go to standard error)
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Replace existing files
    #[arg(short, long)]
    pub force: bool,
}

const PROGRESSION_NOTES: &str = "\
Reads what simplify reads; OUT ends in .nmp. `neural-mesh simplify OUT -o LIGHT --ratio R` then makes any size of the mesh without \
another collapse, as does --faces, --vertices, --lods and, after --prove, --error. The file holds the input, so it may be moved. \
Exit codes: 0 success, 1 problem with the input or the disk, 2 wrong usage, 130 interrupted.";

/// Arguments of `progression`.
#[derive(Debug, Parser)]
#[command(after_help = PROGRESSION_NOTES)]
pub struct ProgressionArgs {
    /// Mesh or scene
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// File for the progression, in .nmp
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Prove the distances of levels at halving sizes, so that simplify takes --error; takes longer
    #[arg(long)]
    pub prove: bool,
    /// Write a page with a slider through the levels, with all that it needs inside
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
    /// Measure to favour
    #[arg(long, value_enum, default_value_t, hide_possible_values = true)]
    pub optimize: Optimize,
    /// Time that each level may take: fast, standard or best
    #[arg(long, value_enum, default_value_t, hide_possible_values = true)]
    pub effort: Effort,
    /// Source of the scores, which say where vertices are needed [default: bending]
    #[arg(long, value_enum, hide_possible_values = true)]
    pub scores: Option<ScoreSource>,
    /// Keep the boundary exactly
    #[arg(long)]
    pub lock_boundaries: bool,
    /// Do not move vertices
    #[arg(long)]
    pub subset: bool,
    /// Keep edges where the surface bends by more than 30 degrees
    #[arg(long)]
    pub keep_features: bool,
    /// Keep all components
    #[arg(long)]
    pub keep_components: bool,
    /// Keep a node, mesh, object, group or material unchanged; may be repeated
    #[arg(long, value_name = "NAME")]
    pub keep: Vec<String>,
    /// Do not merge vertices at equal positions
    #[arg(long)]
    pub no_weld: bool,
    /// Threads to use [default: one per core]; does not change the result
    #[arg(long, value_name = "N", value_parser = parse_thread_count, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Replace an existing file
    #[arg(short, long)]
    pub force: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
}

const LIMITS_NOTES: &str = "\
Simplifies the mesh level by level, with the options given here, and writes no mesh. `picture` is the FLIP error of \
shaded pictures, 0 for equal ones. The lines `limit` say what holds the smallest size; the lines `try` name options that \
would help. Exit codes: 0 success, \
1 problem with the input, the disk or standard output, 2 wrong usage, 130 interrupted.";

/// Arguments of `limits`.
#[derive(Debug, Parser)]
#[command(after_help = LIMITS_NOTES)]
pub struct LimitsArgs {
    /// Mesh or scene to examine; - for standard input
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Keep the boundary exactly
    #[arg(long)]
    pub lock_boundaries: bool,
    /// Keep edges where the surface bends by more than 30 degrees
    #[arg(long)]
    pub keep_features: bool,
    /// Keep all components
    #[arg(long)]
    pub keep_components: bool,
    /// Keep a node, mesh, object, group or material unchanged; may be repeated
    #[arg(long, value_name = "NAME")]
    pub keep: Vec<String>,
    /// Discard attributes (uv, normals, colors, materials), so that their seams and borders do not limit the result
    #[arg(long, value_enum, value_name = "WHAT", value_delimiter = ',')]
    pub ignore: Vec<Ignored>,
    /// Do not merge vertices at equal positions
    #[arg(long)]
    pub no_weld: bool,
    /// Format of the planned result, which decides the attributes to keep [default: format of the input]
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Threads to use [default: one per core]; does not change the result
    #[arg(long, value_name = "N", value_parser = parse_thread_count, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Print errors and the result only
    #[arg(short, long)]
    pub quiet: bool,
}

const COMPARE_NOTES: &str = "\
Reads the formats of simplify. --html writes one file that needs no network: the meshes in 3-D under \
a wipe or side by side, their distances as colours, a map of what the eye notices, and all measures. The JSON and the page explain the measures. A result that cannot be \
read gets a line on standard error, and the others are still compared. Exit codes: 0 success, 1 problem with the input, the disk or \
standard output, 2 wrong usage, 130 interrupted.";

/// Arguments of `compare`.
#[derive(Debug, Parser)]
#[command(after_help = COMPARE_NOTES)]
pub struct CompareArgs {
    /// Original mesh; - for standard input
    #[arg(value_name = "ORIGINAL")]
    pub original: PathBuf,
    /// Meshes to compare with the original, one column each
    #[arg(value_name = "SIMPLIFIED", required = true)]
    pub simplified: Vec<PathBuf>,
    /// Write a page that shows the meshes in any browser
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
    /// Write all measures with their names and units; - for standard output (the table then goes to standard error)
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,
    /// Samples on each surface, for distances and normals
    #[arg(long, value_name = "N", default_value = "50000", value_parser = whole_number_parser::<usize>(1, MAX_SAMPLES), allow_negative_numbers = true)]
    pub samples: usize,
    /// Seed of the samples; equal seeds give equal results
    #[arg(long, value_name = "N", default_value = "0", value_parser = seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// Show all measures instead of the eleven most used
    #[arg(long)]
    pub all: bool,
    /// Threads to use [default: one per core]; does not change the result
    #[arg(long, value_name = "N", value_parser = parse_thread_count, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Do not merge vertices at equal positions
    #[arg(long)]
    pub no_weld: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Replace existing files
    #[arg(short, long)]
    pub force: bool,
}

impl CompareArgs {
    /// Returns all files to read, the original first.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&self.original).chain(&self.simplified).map(PathBuf::as_path)
    }
}
