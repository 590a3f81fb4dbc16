//! Whether the same input, options and seed give the same bits: on 1, 2 and 8 threads, and on a second run.

use std::path::PathBuf;

use anyhow::Result;
use serde::{Deserialize, Serialize};

use crate::load::{load_raw, name};
use crate::methods::{self, Ours, Scores};
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
    #[arg(long, value_delimiter = ',', default_value = "0")]
    seeds: Vec<u64>,
    /// Where our scores come from.
    #[arg(long, value_enum, default_value = "network")]
    scores: Scores,
    /// Table to write; rows it already has are kept.
    #[arg(long)]
    out: PathBuf,
}

/// Whether one case came out the same every time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BitsRow {
    pub mesh: String,
    pub ratio: f64,
    pub seed: u64,
    pub same: bool,
}

/// Simplifies every case on one thread, once more, and on two and eight.
pub fn same_bits(args: &Args) -> Result<()> {
    let mut rows: Vec<BitsRow> = table::read(&args.out)?;
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pools = [pool(1)?, pool(1)?, pool(2)?, pool(8)?];
    for path in &args.mesh {
        let name = name(path);
        let cases = args.ratios.iter().flat_map(|&ratio| args.seeds.iter().map(move |&seed| (ratio, seed)));
        let known = |ratio, seed| rows.iter().any(|r| r.mesh == name && r.ratio == ratio && r.seed == seed);
        let cases: Vec<_> = cases.filter(|&(ratio, seed)| !known(ratio, seed)).collect();
        if cases.is_empty() {
            continue;
        }
        let raw = load_raw(path)?;
        for (ratio, seed) in cases {
            let settings = Ours { seed, scores: args.scores, ..Ours::default() };
            let once = |pool: &rayon::ThreadPool| pool.install(|| methods::ours(&raw, ratio, settings));
            let results: Vec<_> = pools.iter().map(once).collect::<Result<_>>()?;
            let same = results.windows(2).all(|pair| pair[0].mesh == pair[1].mesh);
            rows.push(BitsRow { mesh: name.clone(), ratio, seed, same });
            table::write(&args.out, &rows)?;
        }
    }
    Ok(())
}
