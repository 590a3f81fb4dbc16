//! The arguments as typed; `request` makes of them what is done.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Parser, Subcommand, ValueEnum};

use crate::evaluate::EvaluateArgs;
use crate::train::TrainArgs;

/// Simplifies triangle meshes: closed stays closed, and the result lies close to the original.
#[derive(Debug, Parser)]
#[command(name = "neural-mesh", version, arg_required_else_help = true)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a lighter mesh
    Simplify(SimplifyArgs),
    /// Make a mesh of a cloud of points, with a trained network
    MeshPoints(MeshPointsArgs),
    /// Say what a mesh is: counts, bounds, closed, manifold, components, genus, what was cleaned
    Info(InfoArgs),
    /// Say and show how simplified meshes differ from their original
    Compare(CompareArgs),
    // What these two are for stands with their arguments, which a build without them does not have.
    Train(TrainArgs),
    Evaluate(EvaluateArgs),
    /// Do one job for an evaluation
    #[command(hide = true)]
    EvaluateOne,
}

const SIMPLIFY_NOTES: &str = "\
Reads and writes OBJ, PLY, STL, OFF, glTF and GLB, each also compressed (.gz). Vertices at equal positions are one vertex; \
sizes count the vertices that a face uses. Texture coordinates, normals, colours, materials and other attributes are \
carried over: seams stay seams. A glTF written as glTF keeps its scene; its meshes share the size asked for.

Scores: the density of the vertices follows scores, those of a small network that comes with the program, or of yours with \
--weights FILE. With --scores geometry no network is asked and every vertex counts by its area. The report says which \
(\"scores\": \"network\").

Batches: meshes are simplified side by side, each into a file of its own name below OUT and a row of OUT/manifest.csv. One \
that fails is a row too, and the others go on; the exit code is then 1. Folders are searched with those within. With \
--format all results are of one format.

Exit codes: 0 done, 1 the input or the disk, 2 usage, 130 interrupted. Where a constraint stops the simplification \
before the size asked for, the mesh is written, the exit code is 0, and a line and the report say what stopped it.";

/// Arguments of `simplify`.
#[derive(Debug, Parser)]
#[command(after_help = SIMPLIFY_NOTES, group = ArgGroup::new("target").required(true).args(["ratio", "vertices", "faces", "error", "size", "lods"]))]
pub struct SimplifyArgs {
    /// The mesh to simplify; - for standard input. A folder, a pattern like 'scans/*.ply' or several meshes: a batch
    #[arg(value_name = "IN", required_unless_present = "list")]
    pub inputs: Vec<PathBuf>,
    /// The mesh to write; - for standard output (then all words go to standard error). For a batch the folder
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// File that names the meshes of a batch, one on each line; - for standard input
    #[arg(long, value_name = "FILE", conflicts_with = "inputs")]
    pub list: Option<PathBuf>,
    /// Go on with a batch: meshes that are done are not done again
    #[arg(long)]
    pub resume: bool,
    /// Memory that the meshes of a batch may take together [default: half of what is free]
    #[arg(long, value_name = "GIB")]
    pub memory: Option<f64>,
    /// Share of the vertices that stay, above 0 and at most 1
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub ratio: Option<f64>,
    /// Number of vertices
    #[arg(long, value_name = "N")]
    pub vertices: Option<usize>,
    /// Number of faces
    #[arg(long, value_name = "N")]
    pub faces: Option<usize>,
    /// Largest distance from the original, proved in both directions: the smallest mesh found that holds it. In the unit
    /// of the mesh, or with % in percent of its diagonal
    #[arg(long, value_name = "E", allow_hyphen_values = true)]
    pub error: Option<String>,
    /// Bytes of the mesh file, also as 500kB or 2MB: the largest mesh found that fits
    #[arg(long, value_name = "BYTES")]
    pub size: Option<String>,
    /// Levels of detail: shares of the vertices, falling, as 0.5,0.25,0.1; written as OUT with -lod0, -lod1 and so on in
    /// the name, those of a glTF scene into one file (MSFT_lod)
    #[arg(long, value_name = "R,R", value_delimiter = ',', allow_hyphen_values = true)]
    pub lods: Vec<f64>,
    /// Keep the borders, vertices and edges, bit for bit, so that tiles fit together
    #[arg(long)]
    pub lock_borders: bool,
    /// Leave vertices where they are: those of the result are vertices of the input
    #[arg(long)]
    pub subset: bool,
    /// Keep edges where faces meet at more than 30 degrees
    #[arg(long)]
    pub keep_features: bool,
    /// Keep edges where faces meet at more than so many degrees
    #[arg(long, value_name = "DEGREES", conflicts_with = "keep_features")]
    pub crease_angle: Option<f32>,
    /// Make the result its own mirror image, as the mesh has to be: positions and faces, exactly. About the plane that fits
    /// best, or about x, y, z (through 0 or the middle), or one like x=0.5
    #[arg(long, value_name = "PLANE", num_args = 0..=1, require_equals = true)]
    pub symmetric: Option<Option<String>>,
    /// Attribute of one number, such as a property of a PLY, that says how much each vertex counts: twice the number, twice
    /// as much. Or NAME=FACTOR: the faces of this material, group or object count so many times as much as others
    #[arg(long, value_name = "NAME")]
    pub importance: Option<String>,
    /// Write which vertex went where, and where each corner came from, as JSON
    #[arg(long, value_name = "FILE.json")]
    pub map: Option<PathBuf>,
    /// Say what holds the result: kept edges, locked vertices, components, and how many vertices they take
    #[arg(long)]
    pub explain: bool,
    /// Read files that the mesh names (materials, textures) from outside its folder too
    #[arg(long)]
    pub allow_outside: bool,
    /// How sampled vertices become a surface
    #[arg(long, value_enum, default_value = "closed")]
    pub assembly: AssemblyArg,
    /// Where the scores come from that say where more vertices stay
    #[arg(long, value_enum, default_value = "network")]
    pub scores: ScoresArg,
    /// Weights of a trained network (safetensors) [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Samples drawn per vertex asked for, 1 to 4 [default: the method's choice]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub oversample: Option<f64>,
    /// Seed of the sampling; the same seed gives the same mesh
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Threads to use [default: one per core]; the result is the same with any number
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Drop components too small for the size asked for, instead of keeping their smallest closed form. With a size: drop
    /// those whose bounding box has a smaller diagonal, in the unit of the mesh, or with % in percent of its diagonal
    #[arg(long, value_name = "SIZE", num_args = 0..=1, require_equals = true)]
    pub prune: Option<Option<String>>,
    /// Leave vertices at equal positions apart
    #[arg(long)]
    pub no_weld: bool,
    /// Make one of vertices nearer than that, before all else; in the unit of the mesh, or with % in percent of its diagonal
    #[arg(long, value_name = "DISTANCE", allow_hyphen_values = true, conflicts_with = "no_weld")]
    pub weld: Option<String>,
    /// Do not measure the distance from the original
    #[arg(long)]
    pub no_check: bool,
    /// Format to write where the name of OUT does not say, else the one to read:
    /// obj, ply, ply-ascii, stl, stl-ascii, off, gltf, glb
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Write what was done as JSON
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Draw the mesh before and after, side by side
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Replace files that exist
    #[arg(short, long)]
    pub force: bool,
}

/// How sampled vertices become a surface.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum AssemblyArg {
    /// Closed where the input is closed
    Closed,
    /// As the paper prints it: the network's most probable faces; leaves holes
    Paper,
}

/// Where the scores come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ScoresArg {
    /// From a trained network
    Network,
    /// From the areas of the faces alone; no network is asked
    Geometry,
}

const MESH_POINTS_NOTES: &str = "\
Reads the vertices of OBJ, PLY, STL, OFF and GLB, faces or not, and text with x y z on each line; writes OBJ, PLY, STL and \
OFF. Points keep their positions; points at equal positions are one. The result may have holes: what came of it is said \
and, with --report, written down. Exit codes: 0 done, 1 the input or the disk, 2 usage, 130 interrupted.";

/// Arguments of `mesh-points`.
#[derive(Debug, Parser)]
#[command(after_help = MESH_POINTS_NOTES, group = ArgGroup::new("size").args(["ratio", "vertices"]))]
pub struct MeshPointsArgs {
    /// The cloud; - for standard input
    #[arg(value_name = "CLOUD")]
    pub input: PathBuf,
    /// The mesh to write; - for standard output (then all words go to standard error)
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Share of the points that become vertices, above 0 and at most 1 [default: all]
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub ratio: Option<f64>,
    /// Number of points that become vertices [default: all]
    #[arg(long, value_name = "N")]
    pub vertices: Option<usize>,
    /// Weights of a trained network (safetensors) [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Seed of the sampling; the same seed gives the same mesh
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Threads to use [default: one per core]; the result is the same with any number
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Format to write where the name of OUT does not say: obj, ply, ply-ascii, stl, stl-ascii, off
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Write what was done as JSON
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Replace files that exist
    #[arg(short, long)]
    pub force: bool,
}

/// Arguments of `info`.
#[derive(Debug, Parser)]
pub struct InfoArgs {
    /// The mesh to look at; - for standard input
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Format of standard input, or of a file whose name does not say
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Leave vertices at equal positions apart
    #[arg(long)]
    pub no_weld: bool,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
}

const COMPARE_NOTES: &str = "\
Reads OBJ, PLY, STL, OFF, glTF and GLB. The page of --html is one file that needs no network: the meshes side by side in \
3-D under one camera, with the distance from the other surface painted on and the numbers beside. What the figures mean is \
in the JSON and on the page. Exit codes: 0 done, 1 the input or the disk, 2 usage, 130 interrupted.";

/// Arguments of `compare`.
#[derive(Debug, Parser)]
#[command(after_help = COMPARE_NOTES)]
pub struct CompareArgs {
    /// The mesh that others were made of; - for standard input
    #[arg(value_name = "ORIGINAL")]
    pub original: PathBuf,
    /// Meshes to compare with it, in the order of the columns
    #[arg(value_name = "SIMPLIFIED", required = true)]
    pub simplified: Vec<PathBuf>,
    /// Write a page to look at the meshes, for any browser
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
    /// Write all figures with their names and units
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,
    /// Samples on each surface, from which distances and normals are measured
    #[arg(long, value_name = "N", default_value_t = 50_000)]
    pub samples: usize,
    /// Seed of the samples; the same seed gives the same figures
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Leave out what takes longest: the spectrum, and distances along the surface
    #[arg(long)]
    pub quick: bool,
    /// Draw the meshes from six sides and measure how alike the pictures are
    #[arg(long)]
    pub appearance: bool,
    /// Threads to use [default: one per core]; the figures are the same with any number
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Leave vertices at equal positions apart
    #[arg(long)]
    pub no_weld: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Replace files that exist
    #[arg(short, long)]
    pub force: bool,
}

impl CompareArgs {
    /// All files that are read, the original first.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&self.original).chain(&self.simplified).map(PathBuf::as_path)
    }
}
