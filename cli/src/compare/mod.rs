//! `neural-mesh compare`: reads an original and simplified meshes, judges each, and says it as table, JSON and page.

mod cover_data;
mod images;
mod json;
mod meshes;
mod page;
mod table;
mod worn;

use std::path::Path;

use neural_mesh::appearance::{self, USUAL_HEIGHT, appearance};
use neural_mesh::io::ReadMesh;
use neural_mesh::job::{Part, Watch};
use neural_mesh::metrics::{CompareOptions, Figure, ReferenceMesh, compare};

use crate::args::CompareArgs;
use crate::failure::Failure;
use crate::files::{self, Pending};
use crate::interrupt;
use crate::names::{check_stdin, is_stream};
use crate::plan::Plan;
use crate::progress::Progress;
use crate::simplify::in_pool;
use crate::words::{Voice, complain};
use meshes::{Meshes, Named, read_all};

/// An original, what was made of it, and how each result was judged.
struct Comparison {
    original: Named,
    results: Vec<Judged>,
    judging: CompareOptions,
}

/// A comparison as another face has it.
pub struct Compared {
    /// What `--json` writes.
    pub figures: String,
    /// What `--html` writes, where the arguments name a page.
    pub page: Option<String>,
}

/// A simplified mesh with its figures.
struct Judged {
    mesh: Named,
    figures: Vec<Figure>,
}

/// Costs of reading and drawing over that of measuring.
const COSTS: [f64; 2] = [0.05, 0.15];

/// What a comparison goes through.
fn plan(args: &CompareArgs) -> Plan {
    let drawing = if args.html.is_some() { COSTS[1] } else { 0.0 };
    Plan::new(&[(Part::Read, COSTS[0]), (Part::Check, 1.0), (Part::Picture, drawing)])
}

/// Compares, on as many threads as asked.
pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    check(args)?;
    files::check_places(results(args), args.force)?;
    interrupt::watch(Failure::Interrupted);
    in_pool(args.threads, || run_in_pool(args))
}

fn run_in_pool(args: &CompareArgs) -> Result<(), Failure> {
    let mut progress = Progress::new(args.quiet, plan(args));
    progress.begin(Part::Read);
    let Meshes { original, simplified, unread } = read_all(args, Vec::new())?;
    let left_out = if unread.is_empty() { Ok(()) } else { Err(Failure::Told) };
    progress.aside(|| unread.iter().for_each(complain));
    if simplified.is_empty() {
        return left_out;
    }
    let comparison = judged(args, original, simplified, &mut progress);
    progress.begin(Part::Picture);
    let Written { pending, json, notes } = written(args, &comparison)?;
    drop(progress);
    let voice = match json {
        _ if args.quiet => Voice::Quiet,
        Some(_) => Voice::Err,
        None => Voice::Out,
    };
    json.iter().try_for_each(|bytes| files::write_to_stdout(bytes))?;
    files::place(pending)?;
    table::lines(&comparison, args.all).iter().for_each(|line| voice.say(line));
    notes.iter().for_each(|note| voice.say(&format!("note      {note}")));
    left_out
}

/// Compares in memory, as `embedded` says.
pub fn embedded(args: &CompareArgs, given: Vec<Option<ReadMesh>>) -> Result<Compared, Failure> {
    let Meshes { original, simplified, unread } = read_all(args, given)?;
    if let Some(failure) = unread.into_iter().next() {
        return Err(failure);
    }
    let comparison = judged(args, original, simplified, &mut Progress::silent());
    let figures = json::value(&comparison).to_string();
    Ok(Compared { figures, page: args.html.is_some().then(|| page::page(&comparison).html) })
}

fn judged(args: &CompareArgs, original: Named, simplified: Vec<Named>, progress: &mut Progress) -> Comparison {
    progress.begin(Part::Check);
    let mut judging = CompareOptions::default();
    (judging.samples, judging.seed) = (args.samples, args.seed);
    let prepared = ReferenceMesh::new(&original.mesh, &judging);
    let n_results = simplified.len() as f64;
    let judge = |(number, mesh): (usize, Named)| {
        progress.move_on(Part::Check, (number as f64 + 0.5) / (n_results + 0.5));
        let mut figures = compare(&prepared, &mesh.mesh);
        let looks = args.appearance.then(|| appearance(original.shaded(), mesh.shaded(), USUAL_HEIGHT)).flatten();
        figures.extend(appearance::figures(looks.as_ref()));
        Judged { figures, mesh }
    };
    let results = simplified.into_iter().enumerate().map(judge).collect();
    Comparison { original, results, judging }
}

/// A comparison on its way to its places.
struct Written {
    pending: Vec<Pending>,
    /// The JSON, where standard output is its place.
    json: Option<Vec<u8>>,
    /// What the page cannot show, in one line each.
    notes: Vec<String>,
}

fn written(args: &CompareArgs, comparison: &Comparison) -> Result<Written, Failure> {
    let (mut pending, mut notes) = (Vec::new(), Vec::new());
    let json = files::prepare_json(args.json.as_deref(), &json::value(comparison), args.force, &mut pending)?;
    if let Some(path) = &args.html {
        let page = page::page(comparison);
        pending.push(files::prepare(path, page.html.as_bytes(), args.force)?);
        notes = page.notes;
    }
    Ok(Written { pending, json, notes })
}

/// Files that are written.
fn results(args: &CompareArgs) -> impl Iterator<Item = &Path> {
    [&args.json, &args.html].into_iter().flatten().map(|path| path.as_path()).filter(|path| !is_stream(path))
}

/// What is wrong with the arguments is found before any file is opened.
pub fn check(args: &CompareArgs) -> Result<(), Failure> {
    check_stdin(args.inputs())?;
    if args.html.as_deref().is_some_and(is_stream) {
        return Err(Failure::Usage("--html needs the name of a file".into()));
    }
    Ok(())
}
