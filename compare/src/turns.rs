//! The loop over meshes, ratios and seeds that fills a table: contestants take turns, then every result is measured.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::load::{load_raw, name};
use crate::measure::{Original, measure, topology_row};
use crate::methods::Done;
use crate::row::Row;
use crate::table;

/// What is asked for, and how it is measured.
#[derive(clap::Args)]
pub struct Plan {
    /// Shares of the vertices that stay.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2,0.5")]
    pub ratios: Vec<f64>,
    /// Seeds of our sampling.
    #[arg(long, value_delimiter = ',', default_value = "0,1,2")]
    pub seeds: Vec<u64>,
    /// Times each simplification is run; the median time counts.
    #[arg(long, default_value_t = 3)]
    pub repeat: usize,
    /// Threads of the timed part.
    #[arg(long, default_value_t = 1)]
    pub threads: usize,
    /// Surface samples per side.
    #[arg(long, default_value_t = 100_000)]
    pub samples: usize,
}

/// One mesh at one size with one seed.
pub struct Case<'a> {
    pub mesh: &'a str,
    pub original: &'a Original,
    pub ratio: f64,
    pub seed: u64,
}

/// How a contestant simplifies a case; the number of faces is the one that the first contestant came to.
type Simplify<'a> = dyn Fn(&Case, usize) -> Result<Done> + Sync + 'a;

/// Who takes part, under the name in the tables.
pub struct Contestant<'a> {
    pub name: &'static str,
    pub simplify: Box<Simplify<'a>>,
}

impl<'a> Contestant<'a> {
    pub fn new(name: &'static str, simplify: impl Fn(&Case, usize) -> Result<Done> + Sync + 'a) -> Self {
        Self { name, simplify: Box::new(simplify) }
    }
}

/// Measures every case that `rows` do not have in full, and writes the table, if any, after each of them.
pub fn fill(
    rows: &mut Vec<Row>,
    meshes: &[PathBuf],
    contestants: &[Contestant],
    plan: &Plan,
    out: Option<&Path>,
) -> Result<()> {
    let timed = rayon::ThreadPoolBuilder::new().num_threads(plan.threads).build()?;
    for path in meshes {
        let mesh = name(path);
        let missing = missing(&mesh, contestants, plan, rows);
        if missing.is_empty() {
            continue;
        }
        let original = Original::new(load_raw(path)?, plan.samples)?;
        let input = Row { mesh: mesh.clone(), ratio: 1.0, method: "input".into(), ..topology_row(&original.mesh) };
        replace(rows, vec![input]);
        for (ratio, seed) in missing {
            let case = Case { mesh: &mesh, original: &original, ratio, seed };
            replace(rows, run_case(contestants, plan.repeat, &timed, &case)?);
            out.map(|out| table::write(out, rows)).transpose()?;
        }
    }
    Ok(())
}

/// Ratios and seeds of a mesh that the rows do not have in full.
fn missing(mesh: &str, contestants: &[Contestant], plan: &Plan, rows: &[Row]) -> Vec<(f64, u64)> {
    let has = |ratio, seed, name: &str| rows.iter().any(|row| row.is_case(mesh, ratio, seed, name));
    let all = plan.ratios.iter().flat_map(|&ratio| plan.seeds.iter().map(move |&seed| (ratio, seed)));
    all.filter(|&(ratio, seed)| !contestants.iter().all(|c| has(ratio, seed, c.name))).collect()
}

/// Puts rows in the place of those that stand for the same cases.
fn replace(rows: &mut Vec<Row>, new: Vec<Row>) {
    rows.retain(|old| !new.iter().any(|row| old.is_case(&row.mesh, row.ratio, row.seed, &row.method)));
    rows.extend(new);
}

/// Lets the contestants take turns, then measures what each made.
fn run_case(contestants: &[Contestant], repeat: usize, timed: &rayon::ThreadPool, case: &Case) -> Result<Vec<Row>> {
    let mut turns: Vec<Vec<Done>> = contestants.iter().map(|_| Vec::new()).collect();
    let mut n_faces = (case.original.mesh.faces().len() as f64 * case.ratio).round() as usize;
    for _ in 0..repeat.max(1) {
        for (place, (contestant, turns)) in contestants.iter().zip(&mut turns).enumerate() {
            let done = timed.install(|| simplify(contestant, case, n_faces));
            if place == 0 && !done.mesh.faces().is_empty() {
                n_faces = done.mesh.faces().len();
            }
            turns.push(done);
        }
    }
    contestants.iter().zip(turns).map(|(contestant, turns)| to_row(case, contestant.name, &turns)).collect()
}

fn to_row(case: &Case, method: &str, turns: &[Done]) -> Result<Row> {
    let mut seconds: Vec<f64> = turns.iter().map(|done| done.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let row = Row {
        mesh: case.mesh.to_owned(),
        ratio: case.ratio,
        seed: case.seed,
        method: method.to_owned(),
        seconds: seconds[seconds.len() / 2],
        ..measure(case.original, turns.first().context("no turn was taken")?)
    };
    tell(&row);
    Ok(row)
}

/// One turn; a contestant that panics or refuses has failed, and the comparison goes on.
fn simplify(contestant: &Contestant, case: &Case, n_faces: usize) -> Done {
    match catch_unwind(AssertUnwindSafe(|| (contestant.simplify)(case, n_faces))) {
        Ok(Ok(done)) => done,
        Ok(Err(error)) => Done::failed(&error.to_string()),
        Err(_) => Done::failed("panicked"),
    }
}

fn tell(row: &Row) {
    eprintln!(
        "{:18} {:.2} seed {} {:20} {:7} faces {:8.1} ms  mean {:8.2}e-4  hausdorff {:8.2}e-4  normals {:.4}  {}",
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
