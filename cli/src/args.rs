//! The arguments of commands as typed; `request` makes of them what is done.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Parser, ValueEnum};
use neural_mesh::job::{Count, RatioOf, count, ratio_of, share};

use crate::numbers::{GIB, MOST_SAMPLES, n_threads, number, seed, texels, view, whole};

const SIMPLIFY_NOTES: &str = "\
Reads and writes OBJ, PLY, STL, OFF, glTF, GLB, VRM and 3MF, each also compressed (.gz); reads FBX. 3MF, FBX, geometry compressed by Draco and textures in KTX2 need the features 3mf, fbx, draco and ktx2. Vertices at equal positions are one vertex; \
sizes count the vertices that a face uses. Texture coordinates, normals, colours, materials and other attributes are \
carried over: seams stay seams. A glTF written as glTF keeps its scene; its meshes share the size asked for.

Scores decide where vertices go: more where the surface bends, by a formula. --scores network asks a small network that \
ships with the program, --weights FILE yours; with --scores geometry every vertex counts by its area. The report says which \
(\"scores\": \"bending\").

Batches: meshes are simplified in parallel, each into a file of its name below OUT, with a row in OUT/manifest.csv. A mesh \
that fails is a row too; the others continue, and the exit code is 1. OUT takes one batch at a time. Folders are searched with all folders below. \
--format writes all results in one format.

Exit codes: 0 done, 1 the input, the disk or standard output, 2 usage, 3 written, but not as asked, 130 interrupted. If a \
constraint stops the simplification before the size asked for, the mesh is written, a line and the report say what stopped \
it (\"outcome\": \"stopped: ...\"), and the exit code is 0, or 3 with --strict. The bound of --error or --size is held or the exit \
code is 3.";

/// Arguments of `simplify`.
#[derive(Debug, Parser)]
#[command(after_help = SIMPLIFY_NOTES, group = ArgGroup::new("target").required(true).multiple(true).args(["ratio", "vertices", "faces", "error", "size", "lods"]))]
pub struct SimplifyArgs {
    /// The mesh to simplify; - for standard input. A folder, a pattern like 'scans/*.ply' or several meshes: a batch
    #[arg(value_name = "IN", required_unless_present = "list")]
    pub inputs: Vec<PathBuf>,
    /// The mesh to write, or a folder to write it into under the name of IN; - for standard output (messages then go to standard
    /// error), in the format of IN. Of a link, what it leads to is replaced. For a batch, the folder
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// File that names the meshes of a batch, one per line; - for standard input
    #[arg(long, value_name = "FILE", conflicts_with = "inputs")]
    pub list: Option<PathBuf>,
    /// Continue a batch: meshes that are done are skipped
    #[arg(long)]
    pub resume: bool,
    /// Memory that may be used, by all meshes of a batch together [default: what is free; a batch plans with half of it]. A single PLY
    /// (binary), STL or OBJ that takes more is simplified in pieces, its shape alone
    #[arg(long, value_name = "GIB", value_parser = number(GIB, |gib| gib > 0.0), allow_negative_numbers = true)]
    pub memory: Option<f64>,
    /// Share of the vertices to keep: 0.1 or 10%. NAME=R is the share of what has this name, as with --keep; as often as wanted, beside a
    /// size of the whole, which the rest makes up for as far as it can. Without one the rest stays
    #[arg(long, value_name = "[NAME=]R", value_parser = ratio_of, allow_hyphen_values = true)]
    pub ratio: Vec<RatioOf>,
    /// Number of vertices: 5000, 10k, 1.5M, or 10% of the input's
    #[arg(long, value_name = "N", value_parser = count, allow_hyphen_values = true, conflicts_with_all = ["faces", "error", "size", "lods"])]
    pub vertices: Option<Count>,
    /// Number of faces: 5000, 10k, 1.5M, or 10% of the input's
    #[arg(long, value_name = "N", value_parser = count, allow_hyphen_values = true, conflicts_with_all = ["error", "size", "lods"])]
    pub faces: Option<Count>,
    /// Largest distance from the original, proved in both directions: finds the smallest mesh within it. In the unit of
    /// the mesh, or with % in percent of its diagonal
    #[arg(long, value_name = "E", allow_hyphen_values = true, conflicts_with_all = ["size", "lods"])]
    pub error: Option<String>,
    /// Bytes of the mesh file, also as 500kB or 2MB: finds the largest mesh that fits
    #[arg(long, value_name = "BYTES", conflicts_with = "lods")]
    pub size: Option<String>,
    /// Levels of detail: falling shares of the vertices, such as 50%,25%,10% or 0.5,0.25,0.1; written as OUT with {level} as 0, 1 and so on, or with -lod0, -lod1
    /// in the name, of a glTF scene as one file (MSFT_lod)
    #[arg(long, value_name = "R,R", value_delimiter = ',', allow_hyphen_values = true)]
    pub lods: Vec<String>,
    /// What --lods are: vertices or faces, each in shares or in numbers such as 20k,5k,1k, or largest distances that are proved, as of
    /// --error, such as 0.1%,0.5%,2% [default: shares of the vertices]
    #[arg(long, value_enum, value_name = "WHAT", requires = "lods")]
    pub lods_by: Option<LodsByArg>,
    /// Exit with 3 where the size asked for was not reached
    #[arg(long)]
    pub strict: bool,
    /// Keep the vertices and edges of the boundary bit for bit, so that tiles fit together
    #[arg(long, alias = "lock-borders")]
    pub lock_boundaries: bool,
    /// Do not move vertices: those of the result are vertices of the input
    #[arg(long)]
    pub subset: bool,
    /// Close the holes that the network leaves (--assembly paper)
    #[arg(long)]
    pub close: bool,
    /// Keep edges where faces meet at more than 30 degrees
    #[arg(long)]
    pub keep_features: bool,
    /// Keep edges where faces meet at more than DEGREES
    #[arg(long, value_name = "DEGREES", value_parser = number("degrees from 0 to 180", |x| (0.0..=180.0).contains(&x)),
        allow_negative_numbers = true, conflicts_with = "keep_features")]
    pub crease_angle: Option<f64>,
    /// How far a seam of the texture may leave its place at a low price, in texels of the largest texture of colours (without one,
    /// of 1024 a side); 0 holds seams like creases [default: a 64th of the side]
    #[arg(long, value_name = "TEXELS", value_parser = number("texels, 0 or more", |x| x >= 0.0), allow_negative_numbers = true)]
    pub seam_error: Option<f64>,
    /// What the result does not need, so that it holds nothing back: uv, normals, colors, materials
    #[arg(long, value_enum, value_name = "WHAT", value_delimiter = ',')]
    pub ignore: Vec<IgnoreArg>,
    /// Make the result its own mirror image, exactly; the mesh must be one. About x, y or z (through 0 or the middle), or a
    /// plane like x=0.5 [default: the plane that fits best]
    #[arg(long, value_name = "PLANE", num_args = 0..=1, require_equals = true)]
    pub symmetric: Option<Option<String>>,
    /// Bring what has this name back as it is, vertices, faces and all that they carry; as often as wanted. A node (with all below it),
    /// mesh or material of a glTF, an object, group or material of another mesh
    #[arg(long, value_name = "NAME", conflicts_with_all = ["printable", "fill_holes", "weld", "bake"])]
    pub keep: Vec<String>,
    /// Attribute of one number, such as a property of a PLY, that says how much each vertex counts: twice the number, twice
    /// as much. Or NAME=FACTOR: faces of this node, mesh, material, group or object count FACTOR times as much
    #[arg(long, value_name = "NAME")]
    pub importance: Option<String>,
    /// Write as JSON which vertex went where, and where each corner came from
    #[arg(long, value_name = "FILE.json")]
    pub map: Option<PathBuf>,
    /// Say what holds the result: kept edges, locked vertices, components
    #[arg(long)]
    pub explain: bool,
    /// Also read files that the mesh names (materials, textures) outside its folder
    #[arg(long)]
    pub allow_outside: bool,
    /// How sampled vertices become a surface
    #[arg(long, value_enum, default_value = "closed")]
    pub assembly: AssemblyArg,
    /// Where the scores come from, which decide where vertices go [default: bending, with --weights network]
    #[arg(long, value_enum)]
    pub scores: Option<ScoresArg>,
    /// The figure in which the result is to be near
    #[arg(long, value_enum, default_value = "balanced")]
    pub optimize: OptimizeArg,
    /// How long it may take
    #[arg(long, value_enum, default_value = "standard")]
    pub effort: EffortArg,
    /// Weights of a trained network (safetensors) [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Seed of the sampling of `--assembly paper`; the same seed gives the same mesh
    #[arg(long, value_name = "N", default_value = "0", value_parser = seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// Threads to use [default: one per core]; the result is the same with any number
    #[arg(long, value_name = "N", value_parser = n_threads, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Keep all components, also those that cost more vertices than they show
    #[arg(long)]
    pub keep_components: bool,
    /// Drop components whose bounding box has a smaller diagonal than SIZE, in the unit of the mesh, or with % in percent of its
    /// diagonal; without SIZE, with --error, than the bound. The bound is then that of what stays
    #[arg(long, value_name = "SIZE", num_args = 0..=1, require_equals = true)]
    pub prune: Option<Option<String>>,
    /// What becomes of what no ray from outside reaches, as inner shells
    #[arg(long, value_enum, default_value = "keep")]
    pub hidden: HiddenArg,
    /// What the result is for
    #[arg(long = "for", value_enum, value_name = "WHAT", default_value = "shape")]
    pub purpose: PurposeArg,
    /// Close holes whose boundary has at most EDGES edges [default: all] before anything is simplified
    #[arg(long, value_name = "EDGES", value_parser = whole::<usize>(0, u64::MAX), num_args = 0..=1, require_equals = true, conflicts_with = "symmetric")]
    pub fill_holes: Option<Option<usize>>,
    /// Make a solid of it before it is simplified: holes closed, faces wound outward, fins, walls and shells within removed, and
    /// pieces smaller than SIZE, in the unit of the mesh, or with % in percent of its diagonal [default: 1%]
    #[arg(long, value_name = "SIZE", num_args = 0..=1, require_equals = true, conflicts_with_all = ["fill_holes", "symmetric", "no_weld"])]
    pub printable: Option<Option<String>>,
    /// Simplify the shape alone, unwrap the result and bake what the original looks like into textures of SIZE x SIZE texels, with
    /// a normal map of its surface; writes glb, gltf or obj
    #[arg(long, value_name = "SIZE", value_parser = texels, allow_negative_numbers = true,
        conflicts_with_all = ["size", "lods", "ignore"])]
    pub bake: Option<usize>,
    /// Write a glTF as engines load it, as gltfpack does: in small numbers (KHR_mesh_quantization) and compressed
    /// (EXT_meshopt_compression); with =quantize in small numbers alone
    #[arg(long, value_enum, value_name = "HOW", num_args = 0..=1, require_equals = true, default_missing_value = "meshopt",
        conflicts_with_all = ["symmetric", "lock_boundaries", "subset"])]
    pub compress: Option<CompressArg>,
    /// Make textures smaller that are longer than SIZE texels a side; the others keep every byte
    #[arg(long, value_name = "SIZE", value_parser = texels, allow_negative_numbers = true, conflicts_with = "bake")]
    pub textures: Option<usize>,
    /// Keep vertices at equal positions apart
    #[arg(long)]
    pub no_weld: bool,
    /// Merge vertices nearer than DISTANCE before all else; in the unit of the mesh, or with % in percent of its diagonal
    #[arg(long, value_name = "DISTANCE", allow_hyphen_values = true, conflicts_with = "no_weld")]
    pub weld: Option<String>,
    /// Do not measure the distance from the original
    #[arg(long)]
    pub no_check: bool,
    /// Format to write if the name of OUT does not say (- takes that of IN), else the one to read:
    /// obj, ply, ply-ascii, stl, stl-ascii, off, gltf, glb
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Write a report as JSON; - for standard output (messages then go to standard error); of many meshes into a folder
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// The same as --report -
    #[arg(long, conflicts_with = "report")]
    pub json: bool,
    /// Draw the mesh before and after, side by side, with a ring where the result is farthest off; of many meshes into a folder
    #[arg(long, value_name = "FILE.png")]
    pub picture: Option<PathBuf>,
    /// Where the picture is taken from: front, back, left, right, top, bottom, or degrees around and above, like 30,20
    /// [default: where much is seen]
    #[arg(long, value_name = "VIEW", value_parser = view, allow_hyphen_values = true, requires = "picture")]
    pub view: Option<[f32; 2]>,
    /// Draw edges over textures and colours, too
    #[arg(long, requires = "picture")]
    pub wires: bool,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Replace existing files
    #[arg(short, long)]
    pub force: bool,
}

/// What a mesh carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum IgnoreArg {
    /// Texture coordinates, and the tangents that follow them
    Uv,
    /// Normals: they are drawn as the faces say
    Normals,
    /// Colours of vertices
    #[value(alias = "colours")]
    Colors,
    /// Materials and groups of faces
    Materials,
}

/// How small a glTF is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CompressArg {
    /// In small numbers, compressed
    Meshopt,
    /// In small numbers
    Quantize,
}

/// What levels of detail are told by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LodsByArg {
    /// Vertices
    Vertices,
    /// Faces
    Faces,
    /// Largest distances from the original
    Error,
}

/// How sampled vertices become a surface.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum AssemblyArg {
    /// Closed where the input is closed
    Closed,
    /// As in the paper: the network's most probable faces; leaves holes
    Paper,
}

/// Where the scores come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ScoresArg {
    /// From a formula: more vertices where the surface bends
    Bending,
    /// From a trained network
    Network,
    /// From nowhere: every vertex counts by its area
    Geometry,
}

/// The figure in which a result is to be near.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum OptimizeArg {
    /// Good in all of them
    Balanced,
    /// The mean distance; no network, takes longer
    Mean,
    /// The largest distance; takes longer, the mean is farther
    Max,
    /// The normals, and so the shading; the mean is farther
    Normals,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EffortArg {
    /// The collapse alone
    Fast,
    /// What pays
    Standard,
    /// All that brings the result nearer
    Best,
}

/// What a result is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PurposeArg {
    /// The shape as it stands
    Shape,
    /// Poses as well, those of its morph targets and its skin, without them any
    Poses,
    /// The spectrum of its Laplacian: vibrations, distances along the surface, matching; faces of like areas
    Spectrum,
}

/// What becomes of what no ray from outside reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HiddenArg {
    /// It counts like the rest
    Keep,
    /// It counts a thousandth, and keeps a tenth of its vertices
    Cheap,
    /// Components hidden as a whole are dropped; the bound of --error is then that of what stays
    Drop,
}

const MESH_POINTS_NOTES: &str = "\
Reads the vertices of OBJ, PLY, STL, OFF and GLB, faces or not, and text with x y z on each line; writes OBJ, PLY, STL and \
OFF. Points keep their positions; points at equal positions are merged. The result may have holes: the program says \
so, and --report writes it down. Exit codes: 0 done, 1 the input, the disk or standard output, 2 usage, 130 interrupted.";

/// Arguments of `mesh-points`.
#[derive(Debug, Parser)]
#[command(after_help = MESH_POINTS_NOTES, group = ArgGroup::new("size").args(["ratio", "vertices"]))]
pub struct MeshPointsArgs {
    /// The cloud; - for standard input
    #[arg(value_name = "CLOUD")]
    pub input: PathBuf,
    /// The mesh to write; - for standard output (messages then go to standard error)
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Share of the points that become vertices: 0.1 or 10% [default: all]
    #[arg(long, value_name = "R", value_parser = share, allow_hyphen_values = true)]
    pub ratio: Option<f64>,
    /// Number of points that become vertices: 5000, 10k, 1.5M, or 10% of them [default: all]
    #[arg(long, value_name = "N", value_parser = count, allow_hyphen_values = true)]
    pub vertices: Option<Count>,
    /// Weights of a trained network (safetensors) [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Seed of the sampling of `--assembly paper`; the same seed gives the same mesh
    #[arg(long, value_name = "N", default_value = "0", value_parser = seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// Threads to use [default: one per core]; the result is the same with any number
    #[arg(long, value_name = "N", value_parser = n_threads, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Format to write if the name of OUT does not say: obj, ply, ply-ascii, stl, stl-ascii, off
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
A file that cannot be read is a line on standard error; the others are described all the same, and the exit code is 1. Exit \
codes: 0 done, 1 a file, the disk or standard output, 2 usage.";

/// Arguments of `info`.
#[derive(Debug, Parser)]
#[command(after_help = INFO_NOTES)]
pub struct InfoArgs {
    /// The meshes to look at; - for standard input
    #[arg(value_name = "IN", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Format of standard input, or of files whose names do not say
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Keep vertices at equal positions apart
    #[arg(long)]
    pub no_weld: bool,
    /// Answer in JSON, a line for each mesh
    #[arg(long)]
    pub json: bool,
    /// Memory that may be used [default: what is free]. A PLY (binary), STL or OBJ that takes more is looked at in pieces
    #[arg(long, value_name = "GIB", value_parser = number(GIB, |gib| gib > 0.0), allow_negative_numbers = true, conflicts_with = "no_weld")]
    pub memory: Option<f64>,
}

const LIMITS_NOTES: &str = "\
The mesh is simplified as `simplify` does it, level by level, with the options given here, and written nowhere. The line `so` says why it \
gets no smaller, the lines `free` which options would let it. Exit codes: 0 done, 1 the input, the disk or standard output, 2 usage, \
130 interrupted.";

/// Arguments of `limits`.
#[derive(Debug, Parser)]
#[command(after_help = LIMITS_NOTES)]
pub struct LimitsArgs {
    /// The mesh or scene to look at; - for standard input
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// Keep the vertices and edges of the boundary
    #[arg(long)]
    pub lock_boundaries: bool,
    /// Keep edges where faces meet at more than 30 degrees
    #[arg(long)]
    pub keep_features: bool,
    /// Keep all components
    #[arg(long)]
    pub keep_components: bool,
    /// What has this name comes back as it is, as with `simplify`; as often as wanted
    #[arg(long, value_name = "NAME")]
    pub keep: Vec<String>,
    /// What the result does not need, so that it holds nothing back: uv, normals, colors, materials
    #[arg(long, value_enum, value_name = "WHAT", value_delimiter = ',')]
    pub ignore: Vec<IgnoreArg>,
    /// Keep vertices at equal positions apart
    #[arg(long)]
    pub no_weld: bool,
    /// Format of the result, which says what it has to hold: the input's where it is not given
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,
    /// Threads to use [default: one per core]; the answer is the same with any number
    #[arg(long, value_name = "N", value_parser = n_threads, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Answer in JSON
    #[arg(long)]
    pub json: bool,
    /// Print errors only, and the answer
    #[arg(short, long)]
    pub quiet: bool,
}

const COMPARE_NOTES: &str = "\
Reads OBJ, PLY, STL, OFF, glTF, GLB, 3MF and FBX. The page of --html is one file that needs no network: the meshes side by side in \
3-D under one camera, with the distance from the other surface painted on and the figures beside. The JSON and the page \
explain the figures. Of several results, one that cannot be read is a line on standard error, and the others are compared all \
the same. Exit codes: 0 done, 1 the input, the disk or standard output, 2 usage, 130 interrupted.";

/// Arguments of `compare`.
#[derive(Debug, Parser)]
#[command(after_help = COMPARE_NOTES)]
pub struct CompareArgs {
    /// The mesh that the others were made from; - for standard input
    #[arg(value_name = "ORIGINAL")]
    pub original: PathBuf,
    /// Meshes to compare with it, in the order of the columns
    #[arg(value_name = "SIMPLIFIED", required = true)]
    pub simplified: Vec<PathBuf>,
    /// Write a page that shows the meshes in any browser
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
    /// Write all figures with their names and units; - for standard output (the table then goes to standard error)
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,
    /// Samples on each surface, for distances and normals
    #[arg(long, value_name = "N", default_value = "50000", value_parser = whole::<usize>(1, MOST_SAMPLES), allow_negative_numbers = true)]
    pub samples: usize,
    /// Seed of the samples; the same seed gives the same figures
    #[arg(long, value_name = "N", default_value = "0", value_parser = seed, allow_negative_numbers = true)]
    pub seed: u64,
    /// Show all figures, not the ten that are asked for most
    #[arg(long)]
    pub all: bool,
    /// Draw the meshes from six sides and measure how alike the pictures are
    #[arg(long)]
    pub appearance: bool,
    /// Threads to use [default: one per core]; the figures are the same with any number
    #[arg(long, value_name = "N", value_parser = n_threads, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Keep vertices at equal positions apart
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
    /// All files that are read, the original first.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&self.original).chain(&self.simplified).map(PathBuf::as_path)
    }
}
