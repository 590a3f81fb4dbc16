//! The pages of `docs/measured`: prose kept by hand, and marks between which measuring puts tables and numbers.

use std::path::PathBuf;

use anyhow::{Result, bail, ensure};
use neural_mesh::io::write_path;

use super::bench::{Bench, Blocks, root};
use super::versions::{Subsystem, restamp, stale_pages};
use super::{assets, benchmark, paper, performance, pictures, samplers, weights};
use crate::tables::fill;

/// Arguments of `measure`.
#[derive(Debug, clap::Args)]
pub struct MeasureArgs {
    /// Folder with the mesh folders `train`, `test` and `tosca`
    #[arg(long)]
    data: PathBuf,
    /// Folder for measured rows, by version; those already there are not repeated
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/measured"))]
    work: PathBuf,
    /// Folder with README.md and docs, whose tables are replaced
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/.."))]
    out: PathBuf,
    /// Pages to make [default: all]
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
}

struct Page {
    name: &'static str,
    // File without its ending, if it is not the name: several entries can make parts of a page.
    file: Option<&'static str>,
    // The figures depend on these parts of the library.
    subsystems: &'static [Subsystem],
    measure: fn(&Bench) -> Result<Blocks>,
}

const PAGES: [Page; 7] = [
    Page { name: "benchmark", file: None, subsystems: &[Subsystem::Closed], measure: benchmark::measure },
    Page { name: "performance", file: None, subsystems: &[Subsystem::Closed], measure: performance::measure },
    Page { name: "paper", file: None, subsystems: &[Subsystem::Paper], measure: paper::measure },
    // Table 2 of that page alone, which takes minutes and not hours.
    Page { name: "samplers", file: Some("paper"), subsystems: &[Subsystem::Paper], measure: samplers::measure },
    Page { name: "weights", file: None, subsystems: &[Subsystem::Closed, Subsystem::Paper], measure: weights::measure },
    Page { name: "assets", file: None, subsystems: &[Subsystem::Closed, Subsystem::Carried], measure: assets::measure },
    Page {
        name: "pictures",
        file: None,
        subsystems: &[Subsystem::Closed, Subsystem::Paper],
        measure: pictures::measure,
    },
];

pub fn run(MeasureArgs { data, work, out, only }: MeasureArgs) -> Result<()> {
    let unknown = only.iter().find(|name| !PAGES.iter().any(|page| page.name == **name));
    let names = PAGES.map(|page| page.name).join(", ");
    ensure!(unknown.is_none(), "{}: no such page: give some of {names}", unknown.map_or("", |name| name));
    let mut failed = Vec::new();
    for page in PAGES.iter().filter(|page| only.is_empty() || only.iter().any(|name| name == page.name)) {
        // A page that fails does not prevent the others.
        match Bench::new(&data, &work, &out, page.subsystems).and_then(|bench| make_page(&bench, page)) {
            Ok(()) => eprintln!("wrote docs/measured/{}.md", page.file.unwrap_or(page.name)),
            Err(error) => failed.push(format!("{}: {error:#}", page.name)),
        }
    }
    ensure!(failed.is_empty(), "not all pages are made:\n{}", failed.join("\n"));
    Ok(())
}

fn make_page(bench: &Bench, page: &Page) -> Result<()> {
    let path = bench.output(&format!("docs/measured/{}.md", page.file.unwrap_or(page.name)));
    let blocks = (page.measure)(bench)?;
    let text = restamp(&std::fs::read_to_string(&path)?, page.subsystems)?;
    let text = blocks.iter().try_fold(text, |text, (name, content)| fill(&text, name, content))?;
    Ok(write_path(&path, text.as_bytes(), true)?)
}

pub fn print_stale() -> Result<()> {
    let pages = stale_pages(root())?;
    pages.iter().for_each(|page| println!("{page}"));
    if pages.is_empty() {
        Ok(())
    } else {
        bail!("{} pages are of another version: run neural-mesh-bench measure", pages.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Blocks of a page are known only after measuring; every mark that opens must close.
    #[test]
    fn marks_of_the_pages_are_in_pairs() {
        for Page { name, file, .. } in PAGES {
            let page = root().join("docs/measured").join(file.unwrap_or(name)).with_extension("md");
            let text = std::fs::read_to_string(page).unwrap();
            let marks: Vec<&str> =
                text.split("<!-- ").skip(1).filter_map(|rest| Some(rest.split_once(" -->")?.0)).collect();
            let is_name = |mark: &&&str| !mark.contains(' ') && !mark.starts_with('/');
            let opened: Vec<&&str> = marks.iter().filter(is_name).collect();
            assert!(!opened.is_empty(), "{name}");
            for mark in opened {
                assert!(fill(&text, mark, "").is_ok(), "{name}: {mark}");
                assert_eq!(marks.iter().filter(|other| *other == mark).count(), 1, "{name}: {mark}");
            }
        }
    }
}
