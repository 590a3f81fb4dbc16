//! Which versions a page was made with: a comment that this program reads, and a line for people.

use std::path::Path;

use anyhow::{Context, Result};
use neural_mesh::simplify::{CARRIED_VERSION, CLOSED_VERSION, PAPER_VERSION};
use neural_mesh::train;

/// What the figures of a page depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The closed assembly.
    Closed,
    /// What holds it, and what its results carry.
    Carried,
    /// The paper's assembly.
    Paper,
    /// The training.
    Training,
}

impl Part {
    pub const ALL: [Self; 4] = [Self::Closed, Self::Carried, Self::Paper, Self::Training];

    /// Its name in stamps.
    fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Carried => "carried",
            Self::Paper => "paper",
            Self::Training => "training",
        }
    }

    fn about(self) -> &'static str {
        match self {
            Self::Closed => "the closed assembly",
            Self::Carried => "what it carries",
            Self::Paper => "the paper's assembly",
            Self::Training => "the training",
        }
    }

    /// The version of the library at hand.
    fn version(self) -> u32 {
        match self {
            Self::Closed => CLOSED_VERSION,
            Self::Carried => CARRIED_VERSION,
            Self::Paper => PAPER_VERSION,
            Self::Training => train::VERSION,
        }
    }
}

/// `closed 1, paper 1`.
pub fn stamp(parts: &[Part]) -> String {
    let words: Vec<String> = parts.iter().map(|part| format!("{} {}", part.name(), part.version())).collect();
    words.join(", ")
}

/// `version 1 of the closed assembly and version 1 of the training`.
pub fn in_words(parts: &[Part]) -> String {
    let words: Vec<String> =
        parts.iter().map(|part| format!("version {} of {}", part.version(), part.about())).collect();
    words.join(" and ")
}

/// The stamp of a page whose figures depend on no version.
const NONE: &str = "none";

/// What the README's table begins and ends with; the first holds its stamp.
pub const TABLE_BEGINS: &str = "<!-- neural-mesh-bench measure: ";
pub const TABLE_ENDS: &str = "<!-- /neural-mesh-bench measure -->";

/// The pages, the README among them, whose stamp is missing or not of the present versions, each with the reason.
pub fn stale(root: &Path) -> Result<Vec<String>> {
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
        if let Some(why) = difference(&text, begins) {
            stale.push(format!("{}: {why}", page.strip_prefix(root)?.display()));
        }
    }
    Ok(stale)
}

/// What is wrong with the stamp of a text, the first comment that begins so; `None` where nothing is.
fn difference(text: &str, begins: &str) -> Option<String> {
    let at = text.find(begins).map(|at| at + begins.len());
    let Some(found) = at.and_then(|at| text[at..].split_once(" -->")).map(|(stamp, _)| stamp) else {
        return Some("has no stamp".into());
    };
    let is_known = |word: &&str| *word == NONE || Part::ALL.iter().any(|&part| *word == stamp(&[part]));
    found.split(", ").find(|word| !is_known(word)).map(|word| format!("is of {word}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stamp_of_another_version_is_named() {
        let good = format!("# A\n\n<!-- {} -->\n", stamp(&Part::ALL));
        assert_eq!(difference(&good, "<!-- "), None);
        let other = good.replace(&stamp(&[Part::Paper]), "paper 4000000");
        assert_eq!(difference(&other, "<!-- ").unwrap(), "is of paper 4000000");
        assert_eq!(difference("<!-- none -->", "<!-- "), None);
        assert_eq!(difference("# A\n", "<!-- ").unwrap(), "has no stamp");
        assert_eq!(difference("<!-- words -->", "<!-- ").unwrap(), "is of words");
    }

    #[test]
    fn no_page_is_of_another_version() {
        let stale = stale(crate::measure::root()).unwrap();
        assert!(stale.is_empty(), "make these pages again with `neural-mesh-bench measure`:\n{}", stale.join("\n"));
    }
}
