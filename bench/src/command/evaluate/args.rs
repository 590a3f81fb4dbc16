//! The arguments of `evaluate` as typed.

use std::path::PathBuf;

use clap::Parser;

use neural_mesh_cli::shared::numbers::{n_threads, number, seed, share, whole};

const EVALUATE_NOTES: &str = "\
Methods: network, geometry, paper, paper-closed (ours: closed with the scores of the network, closed without a network, \
the paper's assembly, the same with its holes closed); qem, meshopt, meshopt-update, meshopt-sloppy, clustering, farthest-bpa, uniform-bpa; dse (Delaunay surface \
elements of learned maps), pointtrinet (farthest points, triangulated by networks), potamias (a point-cloud \
simplification that learns, and balls); tools; all.

In the command of a tool, {in} and {out} are PLY files ({in.obj}, {out.stl}, {in.off} and so on for other formats), \
{ratio}, {faces}, {vertices} the size. No shell runs it, but quotes work as in one. A line `seconds: 0.25` on its \
standard output is its time; without one, that of the whole process counts.

RUN is created and holds settings.json (what was asked), rows.csv and rows.json (a row for each mesh, ratio, method \
and seed), report.html (tables, plots, the worst cases in 3-D), tables.md, error-size.svg, time-size.svg, error-time.svg \
and worst (meshes of the worst cases). docs/evaluate.md explains them.

Each tool is tried once on a small mesh before anything is measured. Killed at any moment, it loses the current case; the \
same command with --resume continues, also with another command for a tool that had no result. A method that fails or \
takes too long is a row with its error. Exit codes: 0 done, 1 the input, a tool, the disk or standard output, 2 usage, \
130 interrupted.";

/// Measure methods at several sizes on a folder of meshes: tables, plots
#[derive(Debug, Parser)]
#[command(after_help = EVALUATE_NOTES, override_usage = "neural-mesh-bench evaluate --data DIR --out RUN [OPTIONS]
       neural-mesh-bench evaluate --report RUN [--relative-to METHOD]")]
pub struct EvaluateArgs {
    /// Folder of meshes: OBJ, PLY, STL, OFF, glTF, GLB, 3MF, FBX
    #[arg(long, value_name = "DIR", required_unless_present = "report")]
    pub data: Option<PathBuf>,
    /// Folder for the results
    #[arg(long, value_name = "RUN", required_unless_present = "report")]
    pub out: Option<PathBuf>,
    /// Methods, separated by commas
    #[arg(long, value_name = "A,B", value_delimiter = ',', default_value = "all")]
    pub methods: Vec<String>,
    /// A program as a method; can be given several times
    #[arg(long = "tool", value_name = "NAME='cmd {in} {out} {ratio}'")]
    pub tools: Vec<String>,
    /// Shares of the vertices to keep, such as 0.1 or 10%
    #[arg(
        long,
        value_name = "R,R",
        value_delimiter = ',',
        default_value = "0.05,0.1,0.2,0.5",
        value_parser = share,
        allow_hyphen_values = true
    )]
    pub ratios: Vec<f64>,
    /// Seeds of the sampling
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "0", value_parser = seed, allow_negative_numbers = true)]
    pub seeds: Vec<u64>,
    /// Timed runs of each method; the median counts
    #[arg(long, value_name = "N", default_value = "3", value_parser = whole::<usize>(1, u64::MAX), allow_negative_numbers = true)]
    pub repeat: usize,
    /// Seconds that a run may take
    #[arg(long, value_name = "SECONDS", default_value = "600", value_parser = number("seconds above 0", |x| x > 0.0 && x <= 1e9),
        allow_negative_numbers = true)]
    pub time_limit: f64,
    /// Only meshes whose file names begin with one of these
    #[arg(long, value_name = "PREFIX,PREFIX", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Weights for the method network [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Weights for the method paper [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub paper_weights: Option<PathBuf>,
    /// Weights for methods of others that learn; each file says for which [default: those that come with the program]
    #[arg(long, value_name = "FILE,FILE", value_delimiter = ',')]
    pub learned_weights: Vec<PathBuf>,
    /// Also measure the spectrum (the paper's LE), which takes longer than all the rest
    #[arg(long)]
    pub spectrum: bool,
    /// Draw the meshes from six sides and measure how alike the pictures are
    #[arg(long)]
    pub appearance: bool,
    /// Samples on each surface
    #[arg(long, value_name = "N", default_value = "50000", value_parser = whole::<usize>(1, u64::MAX), allow_negative_numbers = true)]
    pub samples: usize,
    /// Threads that a method may use [default: one per core]; times depend on it, figures do not
    #[arg(long, value_name = "N", value_parser = n_threads, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Continue with the rows in RUN
    #[arg(long)]
    pub resume: bool,
    /// Method that the others are divided by in the tables [default: qem, where it takes part]
    #[arg(long, value_name = "METHOD")]
    pub relative_to: Option<String>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Write page, tables and plots of an evaluation, finished or not, and do nothing else
    #[arg(long, value_name = "RUN", conflicts_with_all = ["data", "out", "methods", "tools", "ratios", "seeds", "resume"])]
    pub report: Option<PathBuf>,
}
