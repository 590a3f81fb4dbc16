//! The page of results: every table that the measurements make, as Markdown.

mod cases;
mod every_mesh;
pub mod markdown;
mod program;
pub mod statistics;
mod surfaces;
mod targets;

use std::path::PathBuf;

use anyhow::Result;

use crate::row::Row;
use crate::table;

#[derive(clap::Args)]
pub struct Args {
    /// The main table.
    #[arg(long)]
    rows: PathBuf,
    /// The table of peak memory.
    #[arg(long)]
    memory: Option<PathBuf>,
    /// The table of repeated runs.
    #[arg(long)]
    same_bits: Option<PathBuf>,
    /// The table of broken files.
    #[arg(long)]
    broken_files: Option<PathBuf>,
    /// Words on the machine, for the heading of the times.
    #[arg(long, default_value = "")]
    machine: String,
}

/// Prints the page.
pub fn summary(args: &Args) -> Result<()> {
    let rows: Vec<Row> = table::read(&args.rows)?;
    print!("{}", measured(&rows, &args.machine));
    if let Some(path) = &args.memory {
        println!(
            "## Memory\n\nPeak of the whole program with its defaults, files and the distance check included, one thread.\n\n{}",
            program::memory(&table::read(path)?)
        );
    }
    if let Some(path) = &args.same_bits {
        let text = program::same_bits(&table::read(path)?);
        println!("## Same bits\n\nOn 1, 2 and 8 threads and on a second run, on one instruction set.\n\n{text}");
    }
    if let Some(path) = &args.broken_files {
        println!("## Broken files\n\n{}", program::broken_files(&table::read(path)?));
    }
    Ok(())
}

fn measured(rows: &[Row], machine: &str) -> String {
    let cases = cases::Cases::new(rows);
    let sections = [
        ("Medians", targets::medians(&cases)),
        ("Sharp edges", targets::sharp(&cases)),
        ("Topology", surfaces::topology(&cases)),
        ("Folds", surfaces::folds(&cases)),
        ("Sizes", surfaces::sizes(&cases)),
        ("One pass and collapse", surfaces::removal(&cases)),
        ("Every mesh", every_mesh::every_mesh(&cases)),
    ];
    let seeds =
        rows.iter().filter(|row| row.method == "ours").map(|row| row.seed).collect::<std::collections::BTreeSet<_>>();
    let intro = format!(
        "{} meshes, {} seeds; per mesh the median over the seeds. Distances are two-sided point-to-surface, from samples \
         of both surfaces, in shares of the diagonal of the input's bounding box; the normal error is the mean of 1 - n.n'. \
         meshoptimizer's `simplify` runs without options or error limit to our number of faces, in turns with us, on one \
         thread{}.\n\n",
        cases.meshes.len(),
        seeds.len(),
        if machine.is_empty() { String::new() } else { format!(" ({machine})") }
    );
    let body: String = sections.iter().map(|(title, text)| format!("## {title}\n\n{text}\n")).collect();
    format!("# Against meshoptimizer\n\nMade by `scripts/results`. {intro}{body}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: &str, seed: u64, mean: f64) -> Row {
        let outcome = "reached".to_owned();
        Row {
            mesh: "ball".into(),
            ratio: 0.5,
            seed,
            method: method.into(),
            vertices: 50,
            mean,
            outcome,
            ..Row::default()
        }
    }

    #[test]
    fn the_page_has_the_median_over_the_seeds_and_says_what_failed() {
        let input = Row { mesh: "ball".into(), ratio: 1.0, method: "input".into(), vertices: 100, ..Row::default() };
        let mut rows = vec![input];
        for (seed, mean) in [(0, 1e-4), (1, 3e-4), (2, 9e-4)] {
            rows.extend([row("ours", seed, mean), row("meshoptimizer", seed, 6e-4)]);
        }
        rows.push(Row { outcome: "failed: panicked".into(), ..row("ours", 3, 0.0) });
        let page = measured(&rows, "");
        assert!(page.contains("| distance, mean | 0.50 (0.50) | 0.50 (0.50) |"), "{page}");
        assert!(page.contains("- ball at 0.5, seed 3: failed: panicked"), "{page}");
        assert!(page.contains("3 of 3 results have the number of vertices asked for"), "{page}");
    }
}
