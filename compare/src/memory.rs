//! Peak memory of the program on one mesh with its defaults, measured by the kernel for a child process.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Result, ensure};
use nix::sys::resource::{UsageWho, getrusage};
use serde::{Deserialize, Serialize};

use crate::load::{load, name};
use crate::table;

#[derive(clap::Args)]
pub struct Args {
    /// The program.
    #[arg(long)]
    program: PathBuf,
    /// Mesh file.
    #[arg(long)]
    mesh: PathBuf,
    /// Share of the vertices that stay.
    #[arg(long)]
    ratio: f64,
    /// Faces that the mesh must have more than to be run.
    #[arg(long, default_value_t = 0)]
    above: usize,
    /// Table to add a row to; a row of the same mesh and ratio is kept, and nothing is run.
    #[arg(long)]
    out: PathBuf,
}

/// Peak memory of one run, files and the distance check included.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct MemoryRow {
    pub mesh: String,
    pub ratio: f64,
    /// Faces of the input.
    pub faces: usize,
    pub peak_bytes: u64,
}

/// Runs the program once; this process must have had no other child.
pub fn memory(args: &Args) -> Result<()> {
    let mut rows: Vec<MemoryRow> = table::read(&args.out)?;
    let mesh = name(&args.mesh);
    if rows.iter().any(|row| row.mesh == mesh && row.ratio == args.ratio) {
        return Ok(());
    }
    let faces = load(&args.mesh)?.faces().len();
    if faces <= args.above {
        return Ok(());
    }
    let folder = args.out.with_extension("scratch");
    std::fs::create_dir_all(&folder)?;
    let peak_bytes = peak_of_run(args, &folder.join("out.ply"))?;
    std::fs::remove_dir_all(&folder)?;
    rows.push(MemoryRow { mesh, ratio: args.ratio, faces, peak_bytes });
    table::write(&args.out, &rows)
}

fn peak_of_run(args: &Args, out: &Path) -> Result<u64> {
    let mut command = Command::new(&args.program);
    command.arg("simplify").arg(&args.mesh).arg("-o").arg(out);
    command.args(["--ratio", &args.ratio.to_string(), "--threads", "1", "--quiet", "--force"]);
    let status = command.stdout(Stdio::null()).status()?;
    ensure!(status.success(), "{} on {}: {status}", args.program.display(), args.mesh.display());
    Ok(getrusage(UsageWho::RUSAGE_CHILDREN)?.max_rss() as u64 * 1024)
}
