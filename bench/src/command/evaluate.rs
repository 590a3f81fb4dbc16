//! `neural-mesh-bench evaluate`: arguments, measurement and report.

use std::path::{Path, PathBuf};

use clap::Parser;
use neural_mesh_cli::shared::{Failure, MessageStream, display_path, stopping};

use crate::evaluate::{EvaluateOptions, REPORT, evaluate, write_report};

const EVALUATE_NOTES: &str = "\
Methods of neural-mesh: closed (the default), network (with the scores of the network), geometry (without scores), mean, max, normals, \
looks (--optimize), fast, best, best-mean (--effort), paper (the paper's assembly), paper-closed (with its holes closed), paper-placed (and its vertices placed), paper-quotient (all triangles between three regions, unclassified). Other methods: qem, \
meshopt, meshopt-update, farthest-bpa, uniform-bpa, dse (Delaunay surface elements of learned maps), \
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
    data: Option<PathBuf>,
    /// Folder for the results
    #[arg(long, value_name = "RUN", required_unless_present = "report")]
    out: Option<PathBuf>,
    #[command(flatten)]
    options: EvaluateOptions,
    /// Reference method of the quotients in the tables [default: qem, where it takes part]
    #[arg(long, value_name = "METHOD")]
    relative_to: Option<String>,
    /// Print errors only
    #[arg(short, long)]
    quiet: bool,
    /// Write the report of an evaluation, finished or not, and do nothing else
    #[arg(long, value_name = "RUN", conflicts_with_all = ["data", "out", "methods", "tools", "ratios", "seeds", "resume"])]
    report: Option<PathBuf>,
}

pub fn run(args: &EvaluateArgs) -> Result<(), Failure> {
    match (&args.report, &args.data, &args.out) {
        (Some(folder), _, _) => publish(folder, args),
        (None, Some(data), Some(out)) => measure(args, data, out),
        _ => Err(Failure::Usage("--data and --out are needed: give a folder of meshes and one for the rows".into())),
    }
}

fn measure(args: &EvaluateArgs, data: &Path, out: &Path) -> Result<(), Failure> {
    let methods = args.options.settings.resolve_methods()?;
    if let Some(other) = args.relative_to.as_ref().filter(|other| !methods.iter().any(|m| m.name() == other.as_str())) {
        return Err(Failure::Usage(format!("--relative-to {other}: is not among the methods: add it to --methods")));
    }
    stopping::handle_stop_signals();
    let is_finished = evaluate(data, out, &args.options, &|line| message_stream(args).print_line(line))?;
    publish(out, args)?;
    if is_finished {
        return Ok(());
    }
    let what = format!("interrupted: the rows so far are kept in {}: continue with --resume", display_path(out));
    Err(Failure::Stopped(what))
}

fn message_stream(args: &EvaluateArgs) -> MessageStream {
    if args.quiet { MessageStream::Quiet } else { MessageStream::Out }
}

fn publish(folder: &Path, args: &EvaluateArgs) -> Result<(), Failure> {
    write_report(folder, args.relative_to.as_deref())?;
    message_stream(args).print_line(&format!("wrote     {}", display_path(&folder.join(REPORT))));
    Ok(())
}
