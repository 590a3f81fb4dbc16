//! The loop over meshes, ratios and seeds that fills the main table.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::ValueEnum;

use crate::load::{load_raw, name};
use crate::measure::{Original, measure, topology_row};
use crate::methods::{self, Done, Method};
use crate::row::Row;
use crate::table;

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files.
    #[arg(long, num_args = 1.., required = true)]
    mesh: Vec<PathBuf>,
    /// Shares of the vertices that stay.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2,0.5")]
    ratios: Vec<f64>,
    /// Seeds of our sampling.
    #[arg(long, value_delimiter = ',', default_value = "0,1,2")]
    seeds: Vec<u64>,
    /// Table to write.
    #[arg(long)]
    out: PathBuf,
    /// Samples drawn per vertex asked for; without it, the method's own choice.
    #[arg(long)]
    oversample: Option<f64>,
    /// Times each simplification is run; the median time counts.
    #[arg(long, default_value_t = 3)]
    repeat: usize,
    /// Threads of the timed part.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Surface samples per side.
    #[arg(long, default_value_t = 100_000)]
    samples: usize,
    /// Methods to run; all of them without it.
    #[arg(long, value_enum, value_delimiter = ',')]
    method: Vec<Method>,
    /// Keep the rows that the table already has.
    #[arg(long)]
    resume: bool,
}

impl Args {
    /// The methods to run, ours first: the other one gets its number of faces.
    fn methods(&self) -> Vec<Method> {
        let wanted = |method: &Method| self.method.is_empty() || self.method.contains(method);
        Method::value_variants().iter().copied().filter(wanted).collect()
    }

    /// Ratios and seeds of a mesh that the table does not have in full.
    fn missing(&self, mesh: &str, rows: &[Row]) -> Vec<(f64, u64)> {
        let has = |ratio, seed, m: &Method| rows.iter().any(|row| row.is_case(mesh, ratio, seed, m.name()));
        let all = self.ratios.iter().flat_map(|&ratio| self.seeds.iter().map(move |&seed| (ratio, seed)));
        all.filter(|&(ratio, seed)| !self.methods().iter().all(|m| has(ratio, seed, m))).collect()
    }
}

/// One mesh at one size with one seed.
struct Case<'a> {
    mesh: &'a str,
    original: &'a Original,
    ratio: f64,
    seed: u64,
}

/// Runs every case and writes the table after each of them.
pub fn run(args: &Args) -> Result<()> {
    let timed = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build()?;
    let mut rows = if args.resume { table::read(&args.out)? } else { Vec::new() };
    for path in &args.mesh {
        let mesh = name(path);
        let missing = args.missing(&mesh, &rows);
        if missing.is_empty() {
            continue;
        }
        let original = Original::new(load_raw(path)?, args.samples)?;
        let input = Row { mesh: mesh.clone(), ratio: 1.0, method: "input".into(), ..topology_row(&original.mesh) };
        replace(&mut rows, vec![input]);
        for (ratio, seed) in missing {
            let case = Case { mesh: &mesh, original: &original, ratio, seed };
            replace(&mut rows, run_case(args, &timed, &case)?);
            table::write(&args.out, &rows)?;
        }
    }
    Ok(())
}

/// Puts rows in the place of those that stand for the same cases.
fn replace(rows: &mut Vec<Row>, new: Vec<Row>) {
    rows.retain(|old| !new.iter().any(|row| old.is_case(&row.mesh, row.ratio, row.seed, &row.method)));
    rows.extend(new);
}

/// Lets the methods take turns, then measures what each made.
fn run_case(args: &Args, timed: &rayon::ThreadPool, case: &Case) -> Result<Vec<Row>> {
    let methods = args.methods();
    let mut turns: Vec<Vec<Done>> = methods.iter().map(|_| Vec::new()).collect();
    for _ in 0..args.repeat.max(1) {
        let mut n_faces = (case.original.mesh.faces().len() as f64 * case.ratio).round() as usize;
        for (&method, turns) in methods.iter().zip(&mut turns) {
            let done = timed.install(|| simplify(args.oversample, case, method, n_faces));
            n_faces = if done.mesh.faces().is_empty() { n_faces } else { done.mesh.faces().len() };
            turns.push(done);
        }
    }
    methods.iter().zip(turns).map(|(&method, turns)| to_row(case, method, &turns)).collect()
}

fn to_row(case: &Case, method: Method, turns: &[Done]) -> Result<Row> {
    let mut seconds: Vec<f64> = turns.iter().map(|done| done.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let row = Row {
        mesh: case.mesh.to_owned(),
        ratio: case.ratio,
        seed: case.seed,
        method: method.name().to_owned(),
        seconds: seconds[seconds.len() / 2],
        ..measure(case.original, turns.first().context("no turn was taken")?)
    };
    tell(&row);
    Ok(row)
}

/// One turn; a method that panics or refuses has failed, and the comparison goes on.
fn simplify(oversample: Option<f64>, case: &Case, method: Method, n_faces: usize) -> Done {
    let turn = || match method {
        Method::Ours => methods::ours(&case.original.raw, case.ratio, oversample, case.seed),
        Method::Meshoptimizer => methods::meshoptimizer(&case.original.mesh, n_faces),
    };
    match catch_unwind(AssertUnwindSafe(turn)) {
        Ok(Ok(done)) => done,
        Ok(Err(error)) => Done::failed(&error.to_string()),
        Err(_) => Done::failed("panicked"),
    }
}

fn tell(row: &Row) {
    eprintln!(
        "{:18} {:.2} seed {} {:13} {:7} faces {:8.1} ms  mean {:8.2}e-4  hausdorff {:8.2}e-4  normals {:.4}  {}",
        row.mesh,
        row.ratio,
        row.seed,
        row.method,
        row.faces,
        row.seconds * 1e3,
        row.mean * 1e4,
        row.hausdorff * 1e4,
        row.normal_error,
        row.outcome
    );
}
