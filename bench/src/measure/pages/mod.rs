//! The pages of `docs/measured`, one file for each.

mod assets;
mod benchmark;
mod curve;
mod paper;
mod parts;
mod performance;
mod pictures;
mod weights;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use neural_mesh::io::write_path;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::measure::markdown::csv;
use crate::measure::root;
use crate::measure::versions::{KEPT, Subsystem, describe_versions, stamp};
use crate::measure::workbench::Bench;

pub use performance::{MeshoptimizerArgs, run_meshoptimizer};

// Ratios of all pages that name no others.
const RATIOS: [f64; 4] = [0.05, 0.1, 0.2, 0.5];

struct Page {
    name: &'static str,
    title: &'static str,
    // The figures depend on these parts of the library.
    subsystems: &'static [Subsystem],
    make: fn(&Bench) -> Result<String>,
}

fn thread_pool(n: usize) -> Result<ThreadPool> {
    Ok(ThreadPoolBuilder::new().num_threads(n).build()?)
}

fn build_program() -> Result<PathBuf> {
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "--release", "-p", "neural-mesh-cli"]).current_dir(root());
    ensure!(cargo.status().context("cargo")?.success(), "the program cannot be built");
    Ok(root().join("target/release/neural-mesh"))
}

const PAGES: [Page; 8] = [
    Page { name: "benchmark", title: "Benchmark", subsystems: &[Subsystem::Closed], make: benchmark::page },
    Page { name: "performance", title: "Time and memory", subsystems: &[Subsystem::Closed], make: performance::page },
    Page { name: "paper", title: "The paper's tables", subsystems: &[Subsystem::Paper], make: paper::page },
    Page {
        name: "paper_cost",
        title: "Time and memory of the paper's assembly",
        subsystems: &[Subsystem::Paper],
        make: paper::cost::page,
    },
    Page {
        name: "paper_sizes",
        title: "Sizes of the paper's network",
        subsystems: &[Subsystem::Paper, Subsystem::Training],
        make: paper::sizes::page,
    },
    Page {
        name: "weights",
        title: "Scores, stages and weights",
        subsystems: &[Subsystem::Closed, Subsystem::Paper, Subsystem::Training],
        make: weights::page,
    },
    Page { name: "assets", title: "Assets", subsystems: &[Subsystem::Closed, Subsystem::Carried], make: assets::page },
    Page {
        name: "pictures",
        title: "Pictures",
        subsystems: &[Subsystem::Closed, Subsystem::Paper],
        make: pictures::page,
    },
];

pub fn make_pages(data: PathBuf, work: &Path, only: &[String]) -> Result<()> {
    let unknown = only.iter().find(|name| !PAGES.iter().any(|page| page.name == **name));
    let names = PAGES.map(|page| page.name).join(", ");
    ensure!(unknown.is_none(), "{}: no such page: give some of {names}", unknown.map_or("", |name| name));
    let folder = root().join("docs/measured");
    std::fs::create_dir_all(&folder)?;
    let mut failed = Vec::new();
    for page in PAGES.iter().filter(|page| only.is_empty() || only.iter().any(|name| name == page.name)) {
        // A page that fails does not prevent the others.
        match Bench::new(data.clone(), work, page.subsystems).and_then(|bench| (page.make)(&bench)) {
            Ok(body) => {
                let path = folder.join(page.name).with_extension("md");
                let text =
                    format!("{}{body}{}", format_head(page.title, page.subsystems, page.name), kept_sections(&path));
                write_path(&path, text.as_bytes(), true)?;
                eprintln!("wrote docs/measured/{}.md", page.name);
            }
            Err(error) => failed.push(format!("{}: {error:#}", page.name)),
        }
    }
    ensure!(failed.is_empty(), "not all pages are made:\n{}", failed.join("\n"));
    Ok(())
}

/// Returns the last sections of a page, which other scripts made and this program keeps.
fn kept_sections(path: &Path) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.find(KEPT).map_or(String::new(), |at| format!("\n{}", &text[at..]))
}

/// Writes `docs/measured/NAME.csv` and returns a link to it.
fn write_csv<H: AsRef<str>>(name: &str, head: &[H], rows: &[Vec<String>]) -> Result<String> {
    write_path(&root().join("docs/measured").join(name).with_extension("csv"), csv(head, rows).as_bytes(), true)?;
    Ok(format!("[{name}.csv]({name}.csv)"))
}

fn format_head(title: &str, subsystems: &[Subsystem], name: &str) -> String {
    format!(
        "# {title}\n\n<!-- {} -->\n*Measured with {}, by `neural-mesh-bench measure --only {name}`.*\n\n",
        stamp(subsystems),
        describe_versions(subsystems)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_of_other_scripts_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.md");
        let kept = format!("{KEPT}none -->\n## Other\n");
        std::fs::write(&page, format!("# Page\n\n{kept}")).unwrap();
        assert_eq!(kept_sections(&page), format!("\n{kept}"));
        assert_eq!(kept_sections(&folder.path().join("none.md")), "");
    }
}
