//! Versions of the library in the stamps of pages.

use std::path::Path;

use anyhow::{Context, Result};
use neural_mesh::simplify::{CARRIED_VERSION, CLOSED_VERSION, PAPER_VERSION};

use crate::tables::replace_between;

// A part of the library with a version of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subsystem {
    Closed,
    // Attributes, files and the rest that surrounds the closed assembly.
    Carried,
    Paper,
}

impl Subsystem {
    pub const ALL: [Self; 3] = [Self::Closed, Self::Carried, Self::Paper];

    // Name in stamps, name in sentences, and version.
    fn description(self) -> (&'static str, &'static str, u32) {
        match self {
            Self::Closed => ("closed", "the closed assembly", CLOSED_VERSION),
            Self::Carried => ("carried", "attributes and files", CARRIED_VERSION),
            Self::Paper => ("paper", "the paper's assembly", PAPER_VERSION),
        }
    }
}

fn join_descriptions(subsystems: &[Subsystem], between: &str, word: fn((&str, &str, u32)) -> String) -> String {
    subsystems.iter().map(|subsystem| word(subsystem.description())).collect::<Vec<_>>().join(between)
}

/// Formats the stamp of a page: `closed 1, paper 1`.
pub fn stamp(subsystems: &[Subsystem]) -> String {
    join_descriptions(subsystems, ", ", |(name, _, version)| format!("{name} {version}"))
}

/// Replaces the stamp of a page, and the sentence in italics below it.
pub fn restamp(page: &str, subsystems: &[Subsystem]) -> Result<String> {
    let words = join_descriptions(subsystems, " and ", |(_, label, version)| format!("version {version} of {label}"));
    let page = replace_between(page, "<!-- ", " -->", &stamp(subsystems))?;
    replace_between(&page, "*Measured with ", ", by ", &words)
}

// The stamp of a page that depends on no version.
const NONE: &str = "none";

// Start of the README's table; its stamp follows.
pub const TABLE_BEGINS: &str = "<!-- neural-mesh-bench measure: ";
pub const TABLE_ENDS: &str = "<!-- /neural-mesh-bench measure -->";

/// Start of a section with a stamp of its own, which follows.
pub const KEPT: &str = "<!-- kept by measure: ";

/// Lists the pages whose stamp is missing or outdated.
pub fn stale_pages(root: &Path) -> Result<Vec<String>> {
    let folder = root.join("docs/measured");
    let entries = std::fs::read_dir(&folder).with_context(|| folder.display().to_string())?;
    let mut pages: Vec<_> = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    pages.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    pages.push(root.join("README.md"));
    pages.sort();
    let mut stale = Vec::new();
    for page in pages {
        let text = std::fs::read_to_string(&page)?;
        let begins = if page.ends_with("README.md") && page.parent() == Some(root) { TABLE_BEGINS } else { "<!-- " };
        let kept = text.match_indices(KEPT).filter_map(|(at, _)| stamp_fault(&text[at..], KEPT));
        for why in stamp_fault(&text, begins).into_iter().chain(kept) {
            stale.push(format!("{}: {why}", page.strip_prefix(root)?.display()));
        }
    }
    Ok(stale)
}

fn stamp_fault(text: &str, begins: &str) -> Option<String> {
    let at = text.find(begins).map(|at| at + begins.len());
    let Some(found) = at.and_then(|at| text[at..].split_once(" -->")).map(|(stamp, _)| stamp) else {
        return Some("has no stamp".into());
    };
    let is_known = |word: &&str| *word == NONE || Subsystem::ALL.iter().any(|&subsystem| *word == stamp(&[subsystem]));
    found.split(", ").find(|word| !is_known(word)).map(|word| format!("is of {word}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_of_another_version_is_named() {
        let good = format!("# A\n\n<!-- {} -->\n", stamp(&Subsystem::ALL));
        assert_eq!(stamp_fault(&good, "<!-- "), None);
        let other = good.replace(&stamp(&[Subsystem::Paper]), "paper 4000000");
        assert_eq!(stamp_fault(&other, "<!-- ").unwrap(), "is of paper 4000000");
        assert_eq!(stamp_fault("<!-- none -->", "<!-- "), None);
        assert_eq!(stamp_fault("# A\n", "<!-- ").unwrap(), "has no stamp");
        assert_eq!(stamp_fault("<!-- words -->", "<!-- ").unwrap(), "is of words");
        assert_eq!(stamp_fault(&format!("{KEPT}paper 0 -->"), KEPT).unwrap(), "is of paper 0");
    }

    #[test]
    fn a_page_gets_the_present_versions() {
        let page = "# A\n\n<!-- closed 0 -->\n*Measured with version 0 of the closed assembly, by hand. More.*\n";
        let restamped = restamp(page, &[Subsystem::Closed]).unwrap();
        assert_eq!(stamp_fault(&restamped, "<!-- "), None);
        assert!(restamped.contains(&format!("version {CLOSED_VERSION} of the closed assembly, by hand. More.*")));
    }

    #[test]
    fn no_page_is_of_another_version() {
        let stale = stale_pages(super::super::bench::root()).unwrap();
        assert!(stale.is_empty(), "make these pages again with `neural-mesh-bench measure`:\n{}", stale.join("\n"));
    }
}
