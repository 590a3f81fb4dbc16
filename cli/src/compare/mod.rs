//! `neural-mesh compare`: reads an original and simplified meshes, judges each, and says it as table, JSON and page.

mod json;
mod marked;
mod meshes;
mod packed;
mod page;
mod painted;
mod surface_data;
mod table;

use std::path::Path;

use neural_mesh::metrics::{Figure, Judging, Original, compare};

use crate::args::CompareArgs;
use crate::failure::Failure;
use crate::files::{self, Pending};
use crate::interrupt;
use crate::progress::Progress;
use crate::request::{check_threads, is_stream};
use crate::simplify::in_pool;
use crate::words::Voice;
use meshes::{Named, read_all};

/// More samples than any comparison needs, fewer than fill the memory.
const MOST_SAMPLES: usize = 10_000_000;

/// An original, what was made of it, and how each result was judged.
struct Comparison {
    original: Named,
    results: Vec<Judged>,
    judging: Judging,
}

/// A simplified mesh with its figures.
struct Judged {
    mesh: Named,
    figures: Vec<Figure>,
}

/// Compares, on as many threads as asked.
pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    check(args)?;
    results(args).try_for_each(|path| files::check_place(path, args.force))?;
    interrupt::watch(Failure::Interrupted);
    in_pool(args.threads, || run_in_pool(args))
}

fn run_in_pool(args: &CompareArgs) -> Result<(), Failure> {
    let progress = Progress::new(args.quiet);
    progress.show("read", 0.0);
    let (original, simplified) = read_all(args)?;
    progress.show("check", 0.0);
    let comparison = judged(original, simplified, judging(args));
    progress.show("picture", 0.0);
    let pending = written(args, &comparison)?;
    drop(progress);
    files::place(pending)?;
    let voice = if args.quiet { Voice::Quiet } else { Voice::Out };
    table::lines(&comparison).iter().for_each(|line| voice.say(line));
    Ok(())
}

fn judging(args: &CompareArgs) -> Judging {
    let all = Judging { samples: args.samples, seed: args.seed, ..Judging::default() };
    if args.quick { Judging { eigenpairs: 0, geodesics: false, ..all } } else { all }
}

fn judged(original: Named, simplified: Vec<Named>, judging: Judging) -> Comparison {
    let prepared = Original::new(&original.mesh, &judging);
    let judge = |mesh: Named| Judged { figures: compare(&prepared, &mesh.mesh), mesh };
    let results = simplified.into_iter().map(judge).collect();
    Comparison { original, results, judging }
}

/// What goes to files, on its way there.
fn written(args: &CompareArgs, comparison: &Comparison) -> Result<Vec<Pending>, Failure> {
    let mut pending = Vec::new();
    if let Some(path) = &args.json {
        pending.push(files::prepare(path, &json::bytes(comparison), args.force)?);
    }
    if let Some(path) = &args.html {
        pending.push(files::prepare(path, page::html(comparison).as_bytes(), args.force)?);
    }
    Ok(pending)
}

/// Files that are written.
fn results(args: &CompareArgs) -> impl Iterator<Item = &Path> {
    [&args.json, &args.html].into_iter().flatten().map(|path| path.as_path())
}

/// What is wrong with the arguments is found before any file is opened.
fn check(args: &CompareArgs) -> Result<(), Failure> {
    check_threads(args.threads)?;
    if !(1..=MOST_SAMPLES).contains(&args.samples) {
        let asked = args.samples;
        return Err(Failure::Usage(format!("--samples {asked}: give a number from 1 to {MOST_SAMPLES}")));
    }
    if args.inputs().filter(|path| is_stream(path)).count() > 1 {
        return Err(Failure::Usage("standard input holds one mesh: name the others by their files".into()));
    }
    if results(args).any(is_stream) {
        return Err(Failure::Usage("only the table goes to standard output: give JSON and page a file name".into()));
    }
    if args.json.is_some() && args.json == args.html {
        return Err(Failure::Usage("JSON and page have the same name: give each a file of its own".into()));
    }
    Ok(())
}
