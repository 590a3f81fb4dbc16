//! Arguments of `evaluate`.

use std::path::PathBuf;

use clap::Parser;

use crate::evaluate::Settings;

const EVALUATE_NOTES: &str = "\
Methods of neural-mesh: closed (the default), network (with the scores of the network), geometry (without scores), mean, max, normals \
(--optimize), fast, best, best-mean (--effort), paper (the paper's assembly), paper-closed (with its holes closed), paper-placed (and its vertices placed), paper-quotient (all triangles between three regions, unclassified). Other methods: qem, \
collapse, collapse-fitted (the collapse of plain meshes, without and with two fit steps), meshopt, meshopt-update, farthest-bpa, uniform-bpa, dse (Delaunay surface elements of learned maps), \
pointtrinet (farthest points, triangulated by networks), potamias (learned point-cloud simplification and ball pivoting). Tools have \
their own names; all stands for every method.

In the command of a tool, {in} and {out} are PLY files ({in.obj}, {out.stl}, {in.off} and so on for other formats); \
{ratio}, {faces} and {vertices} are the target size. Quotes work as in a shell, but no shell runs it. A line `seconds: 0.25` \
on its standard output is taken as its time; otherwise the whole process is timed.

RUN is created. It holds settings.json, rows.csv (a row for each mesh, ratio, method and seed) and report.md (tables). \
docs/evaluate.md explains them.

If evaluate is killed, only the current case is lost, and the same command with --resume continues. A method that fails or takes too long becomes a row with its error. \
Exit codes: 0 done, 1 the input, a tool, the disk or standard output failed, 2 wrong usage, 130 interrupted.";

/// Measure methods at several sizes on a folder of meshes
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
    #[command(flatten)]
    pub settings: Settings,
    /// Weights for the method network [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Weights for the method paper [default: those that come with the program]
    #[arg(long, value_name = "FILE")]
    pub paper_weights: Option<PathBuf>,
    /// Weights for learned methods of others, each file marked with its method [default: those that come with the
    /// program]
    #[arg(long, value_name = "FILE,FILE", value_delimiter = ',')]
    pub learned_weights: Vec<PathBuf>,
    /// Continue with the rows in RUN
    #[arg(long)]
    pub resume: bool,
    /// Reference method of the quotients in the tables [default: qem, where it takes part]
    #[arg(long, value_name = "METHOD")]
    pub relative_to: Option<String>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Write the report of an evaluation, finished or not, and do nothing else
    #[arg(long, value_name = "RUN", conflicts_with_all = ["data", "out", "methods", "tools", "ratios", "seeds", "resume"])]
    pub report: Option<PathBuf>,
}
