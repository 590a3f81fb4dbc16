//! The pages of `docs/measured`, one file for each: what it measures, and how it tells.

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

use crate::measure::root;
use crate::measure::versions::{Part, in_words, stamp};
use crate::measure::workbench::Bench;

pub use performance::{WholeOther, whole_other};

/// Shares of the vertices that stay, of all pages that do not say others.
const RATIOS: [f64; 4] = [0.05, 0.1, 0.2, 0.5];

/// A page.
struct Page {
    name: &'static str,
    title: &'static str,
    /// What its figures depend on.
    parts: &'static [Part],
    /// What it says under the title.
    make: fn(&Bench) -> Result<String>,
}

/// The program, built.
fn program() -> Result<PathBuf> {
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "--release", "-p", "neural-mesh-cli"]).current_dir(root());
    ensure!(cargo.status().context("cargo")?.success(), "the program cannot be built");
    Ok(root().join("target/release/neural-mesh"))
}

/// All of them, in the order in which they are made.
const PAGES: [Page; 7] = [
    Page { name: "benchmark", title: "Benchmark", parts: &[Part::Closed], make: benchmark::page },
    Page {
        name: "performance",
        title: "Time and memory",
        parts: &[Part::Closed, Part::Paper],
        make: performance::page,
    },
    Page { name: "parts", title: "Scores and parts of the closed assembly", parts: &[Part::Closed], make: parts::page },
    Page { name: "paper", title: "The paper's tables", parts: &[Part::Paper], make: paper::page },
    Page {
        name: "weights",
        title: "Weights",
        parts: &[Part::Closed, Part::Paper, Part::Training],
        make: weights::page,
    },
    Page { name: "assets", title: "Assets", parts: &[Part::Closed, Part::Carried], make: assets::page },
    Page { name: "pictures", title: "Pictures", parts: &[Part::Closed, Part::Paper], make: pictures::page },
];

/// Makes the pages of these names, or all of them, and an index.
pub fn make(data: PathBuf, work: &Path, only: &[String]) -> Result<()> {
    let unknown = only.iter().find(|name| !PAGES.iter().any(|page| page.name == **name));
    let names = PAGES.map(|page| page.name).join(", ");
    ensure!(unknown.is_none(), "{}: no such page: give some of {names}", unknown.map_or("", |name| name));
    let folder = root().join("docs/measured");
    std::fs::create_dir_all(&folder)?;
    let mut failed = Vec::new();
    for page in PAGES.iter().filter(|page| only.is_empty() || only.iter().any(|name| name == page.name)) {
        // A page that cannot be made keeps no other from being made.
        match Bench::new(data.clone(), work, page.parts).and_then(|bench| (page.make)(&bench)) {
            Ok(body) => {
                let text = format!("{}{body}", head(page.title, page.parts, page.name));
                write_path(&folder.join(page.name).with_extension("md"), text.as_bytes(), true)?;
                eprintln!("wrote docs/measured/{}.md", page.name);
            }
            Err(error) => failed.push(format!("{}: {error:#}", page.name)),
        }
    }
    write_path(&folder.join("README.md"), index().as_bytes(), true)?;
    ensure!(failed.is_empty(), "not all pages are made:\n{}", failed.join("\n"));
    Ok(())
}

/// Title, stamp, and how to make the page again.
fn head(title: &str, parts: &[Part], name: &str) -> String {
    format!(
        "# {title}\n\n<!-- {} -->\n*Measured with {}, by `neural-mesh-bench measure --only {name}`.*\n\n",
        stamp(parts),
        in_words(parts)
    )
}

fn index() -> String {
    let line = |Page { title, name, .. }: &Page| {
        if root().join("docs/measured").join(name).with_extension("md").exists() {
            return format!("- [{title}]({name}.md)\n");
        }
        format!("- {title}: not made yet, `neural-mesh-bench measure --only {name}`\n")
    };
    let lines: String = PAGES.iter().map(line).collect();
    let lines =
        lines + "- [Scenes](scenes.md), by `scripts/scenes`\n- [Build and shape](build.md), by `scripts/build_page`\n";
    format!(
        "# Measured\n\n<!-- {} -->\nEvery figure on these pages is of the present code. One command makes all of them; killed, it \
         goes on where it was:\n\n```\ncargo run --release -p neural-mesh-bench -- measure --data MESHES\n```\n\n`MESHES` holds the folders `train`, \
         `test` and `tosca`. `scripts/stale_pages` lists pages of another version.\n\n{lines}",
        stamp(&Part::ALL)
    )
}
