//! Every file of a folder of broken ones through the program: one line and exit 1, or a mesh that is there.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use crate::table;

#[derive(clap::Args)]
pub struct Args {
    /// The program.
    #[arg(long)]
    program: PathBuf,
    /// Folder with the files.
    #[arg(long)]
    folder: PathBuf,
    /// Table of meshes with the columns `set`, `file` and `notes`; rows of the set `bad` are run.
    #[arg(long)]
    manifest: PathBuf,
    /// Table to write.
    #[arg(long)]
    out: PathBuf,
}

/// The columns of the manifest that count here.
#[derive(Deserialize)]
struct Listed {
    set: String,
    file: String,
    notes: String,
}

/// What the program made of one file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BrokenRow {
    pub file: String,
    /// Whether the notes call it valid, so that it has to be read.
    pub valid: bool,
    /// `read`, `refused`, or what is wrong: `panic`, `late`, `silent`, `empty`, `left a file`, `exit N`.
    pub verdict: String,
    pub seconds: f64,
    /// What the program said last on stderr.
    pub message: String,
}

/// Runs the program on every file; the wording of the notes decides whether a file has to be read.
pub fn broken_files(args: &Args) -> Result<()> {
    let listed: Vec<Listed> = table::read(&args.manifest)?;
    let scratch = args.out.with_extension("scratch");
    std::fs::create_dir_all(&scratch)?;
    let mut rows = Vec::new();
    for listed in listed.iter().filter(|listed| listed.set == "bad") {
        let valid = listed.notes.split(|c: char| !c.is_alphanumeric()).any(|word| word == "valid");
        let out = scratch.join("out.ply");
        let run = run_on(&args.program, &args.folder.join(&listed.file), &out)?;
        let verdict = judge(&run, &out);
        let _ = std::fs::remove_file(&out);
        let message = run.stderr.lines().last().unwrap_or_default().to_owned();
        rows.push(BrokenRow { file: listed.file.clone(), valid, verdict, seconds: run.seconds, message });
    }
    std::fs::remove_dir_all(&scratch)?;
    table::write(&args.out, &rows)
}

struct Run {
    /// None where it had to be stopped, or was by a signal.
    code: Option<i32>,
    late: bool,
    seconds: f64,
    stderr: String,
}

fn run_on(program: &Path, file: &Path, out: &Path) -> Result<Run> {
    let errors = out.with_extension("stderr");
    let start = Instant::now();
    let mut child = Command::new(program)
        .arg("simplify")
        .arg(file)
        .arg("-o")
        .arg(out)
        .args(["--ratio", "0.5", "--quiet", "--force"])
        .stdout(Stdio::null())
        .stderr(std::fs::File::create(&errors)?)
        .spawn()
        .with_context(|| format!("starting {}", program.display()))?;
    let status = loop {
        match child.try_wait()? {
            Some(status) => break Some(status),
            None if start.elapsed() > Duration::from_secs(10) => break None,
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    };
    if status.is_none() {
        child.kill()?;
        child.wait()?;
    }
    let seconds = start.elapsed().as_secs_f64();
    let stderr = String::from_utf8_lossy(&std::fs::read(&errors)?).into_owned();
    Ok(Run { code: status.and_then(|status| status.code()), late: status.is_none(), seconds, stderr })
}

fn judge(run: &Run, out: &Path) -> String {
    let verdict = match run.code {
        _ if run.late => "late",
        _ if run.stderr.contains("panicked at") => "panic",
        None => "panic",
        Some(0) if !out.exists() => "silent",
        Some(0) if crate::load::load(out).map_or(true, |mesh| mesh.faces().is_empty()) => "empty",
        Some(0) => "read",
        Some(1) if out.exists() => "left a file",
        Some(1) if run.stderr.trim().lines().count() != 1 => "not one line",
        Some(1) => "refused",
        Some(code) => return format!("exit {code}"),
    };
    verdict.to_owned()
}
