//! Markdown tables.

use std::path::Path;

use anyhow::{Context, Result};

/// Writes a page to its file, or to standard output where it has none.
pub fn publish(page: &str, path: Option<&Path>) -> Result<()> {
    match path {
        Some(path) => std::fs::write(path, page).with_context(|| path.display().to_string())?,
        None => print!("{page}"),
    }
    Ok(())
}

/// A table with a head and rows of cells.
pub fn table(head: &[String], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule = format!("|{}\n", "---|".repeat(head.len()));
    [line(head), rule].into_iter().chain(rows.iter().map(|row| line(row))).collect()
}

/// Words as cells.
pub fn cells(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// A number with two digits after the point, or a dash.
pub fn number(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| if value >= 100.0 { format!("{value:.0}") } else { format!("{value:.2}") })
}

/// A list on lines of its own, or a word for none.
pub fn list(items: &[String]) -> String {
    let lines: String = items.iter().map(|item| format!("- {item}\n")).collect();
    if items.is_empty() { "none.\n".to_owned() } else { format!("\n\n{lines}") }
}
