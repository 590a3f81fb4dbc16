//! The loop over meshes, ratios and seeds.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::{Parser, ValueEnum};

use crate::load::load;
use crate::measure::{Original, measure, topology_row};
use crate::methods::{self, Done};
use crate::row::{self, Row};

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Method {
    #[cfg(feature = "ours")]
    Ours,
    Meshoptimizer,
}

/// Simplify meshes with neural-mesh and meshoptimizer and measure both.
#[derive(Parser)]
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
    /// Methods to run.
    #[arg(long, value_enum, value_delimiter = ',')]
    method: Vec<Method>,
    /// Keep the rows that the table already has.
    #[arg(long)]
    resume: bool,
}

impl Args {
    fn runs(&self, method: Method) -> bool {
        self.method.is_empty() || self.method.contains(&method)
    }

    /// The methods to run, ours first: the other one gets its number of faces.
    fn methods(&self) -> Vec<Method> {
        Method::value_variants().iter().copied().filter(|&method| self.runs(method)).collect()
    }
}

/// One mesh at one size with one seed.
struct Case<'a> {
    name: &'a str,
    original: &'a Original,
    ratio: f64,
    seed: u64,
}

/// Runs every case and writes the table after each of them.
pub fn run(args: &Args) -> Result<()> {
    let timed = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build()?;
    let mut rows = if args.resume { row::read(&args.out)? } else { Vec::new() };
    for path in &args.mesh {
        let name = name(path);
        let missing = |ratio, seed, rows: &[Row]| {
            args.methods().iter().any(|&m| !rows.iter().any(|row| row.same_case(&name, ratio, seed, label(m))))
        };
        let cases = args.ratios.iter().flat_map(|&ratio| args.seeds.iter().map(move |&seed| (ratio, seed)));
        let cases: Vec<_> = cases.filter(|&(ratio, seed)| missing(ratio, seed, &rows)).collect();
        if cases.is_empty() {
            continue;
        }
        let original = Original::new(load(path)?, args.samples);
        rows.retain(|row| !row.same_case(&name, 1.0, 0, "input"));
        rows.push(Row { mesh: name.clone(), ratio: 1.0, method: "input".into(), ..topology_row(&original.mesh) });
        for (ratio, seed) in cases {
            let case = Case { name: &name, original: &original, ratio, seed };
            rows.retain(|row| !args.methods().iter().any(|&m| row.same_case(&name, ratio, seed, label(m))));
            rows.extend(run_case(args, &timed, &case)?);
            row::write(&args.out, &rows)?;
        }
    }
    Ok(())
}

/// Lets the methods take turns, then measures what each made.
fn run_case(args: &Args, timed: &rayon::ThreadPool, case: &Case) -> Result<Vec<Row>> {
    let methods = args.methods();
    let mut turns: Vec<Vec<Done>> = methods.iter().map(|_| Vec::new()).collect();
    for _ in 0..args.repeat.max(1) {
        let mut n_faces = (case.original.mesh.faces().len() as f64 * case.ratio).round() as usize;
        for (&method, turns) in methods.iter().zip(&mut turns) {
            let done = timed.install(|| simplify(args, case, method, n_faces))?;
            n_faces = done.mesh.faces().len();
            turns.push(done);
        }
    }
    let rows = methods.iter().zip(turns).map(|(&method, turns)| {
        let mut seconds: Vec<f64> = turns.iter().map(|done| done.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        let row = Row {
            mesh: case.name.to_owned(),
            ratio: case.ratio,
            seed: case.seed,
            method: label(method).to_owned(),
            seconds: seconds[seconds.len() / 2],
            ..measure(case.original, &turns[0])
        };
        tell(&row);
        row
    });
    Ok(rows.collect())
}

fn simplify(args: &Args, case: &Case, method: Method, n_faces: usize) -> Result<Done> {
    match method {
        #[cfg(feature = "ours")]
        Method::Ours => methods::ours(&case.original.mesh, case.ratio, args.oversample, case.seed),
        Method::Meshoptimizer => methods::meshoptimizer(&case.original.mesh, n_faces),
    }
}

fn label(method: Method) -> &'static str {
    match method {
        #[cfg(feature = "ours")]
        Method::Ours => "ours",
        Method::Meshoptimizer => "meshoptimizer",
    }
}

/// The mesh's name in the tables: its file name without extension, with the folder for the textured ones.
fn name(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn tell(row: &Row) {
    eprintln!(
        "{:18} {:.2} seed {} {:13} {:7} faces {:8.1} ms  mean {:8.2}e-4  hausdorff {:8.2}e-4  normals {:.4}",
        row.mesh,
        row.ratio,
        row.seed,
        row.method,
        row.faces,
        row.seconds * 1e3,
        row.mean * 1e4,
        row.hausdorff * 1e4,
        row.normal_error
    );
}
