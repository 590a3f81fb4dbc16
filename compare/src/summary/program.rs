//! Memory, repeatability and broken files.

use std::collections::BTreeMap;

use super::markdown::{cells, list, table};
use super::statistics::median;
use crate::broken_files::BrokenRow;
use crate::memory::MemoryRow;
use crate::same_bits::BitsRow;

/// Peak memory per input face.
pub fn memory(rows: &[MemoryRow]) -> String {
    let head = cells(&["mesh", "ratio", "faces", "peak (MB)", "bytes per input face", "target"]);
    let row = |row: &MemoryRow| {
        let per_face = format!("{:.0}", row.peak_bytes as f64 / row.faces as f64);
        let megabytes = format!("{:.1}", row.peak_bytes as f64 / 1e6);
        vec![row.mesh.clone(), row.ratio.to_string(), row.faces.to_string(), megabytes, per_face, "400".to_owned()]
    };
    table(&head, &rows.iter().map(row).collect::<Vec<_>>())
}

/// How many cases came out the same every time.
pub fn same_bits(rows: &[BitsRow]) -> String {
    let same = rows.iter().filter(|row| row.same).count();
    let others = rows.iter().filter(|row| !row.same);
    let others: Vec<_> = others.map(|row| format!("{} at {}, seed {}", row.mesh, row.ratio, row.seed)).collect();
    format!("{same} of {} cases have the same bits every time. Others: {}", rows.len(), list(&others))
}

/// What became of the broken files, and everything that should not have happened.
pub fn broken_files(rows: &[BrokenRow]) -> String {
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for row in rows {
        *counts.entry((if row.valid { "valid" } else { "broken" }, &row.verdict)).or_default() += 1;
    }
    let head = cells(&["the file is", "the program", "files"]);
    let lines =
        counts.iter().map(|((kind, verdict), n)| vec![(*kind).to_owned(), (*verdict).to_owned(), n.to_string()]);
    let wrong = rows.iter().filter(|row| row.verdict != "read" && (row.valid || row.verdict != "refused"));
    let wrong: Vec<_> = wrong.map(|row| format!("{}: {} ({})", row.file, row.verdict, row.message)).collect();
    let slowest = median_and_most(rows);
    format!(
        "{}\n{slowest}\nPanics, silent failures, refused valid files: {}",
        table(&head, &lines.collect::<Vec<_>>()),
        list(&wrong)
    )
}

fn median_and_most(rows: &[BrokenRow]) -> String {
    let seconds: Vec<f64> = rows.iter().map(|row| row.seconds).collect();
    let most = seconds.iter().copied().fold(0.0, f64::max);
    format!("Answers come after {:.3} s (median), {most:.2} s at most.\n", median(seconds).unwrap_or_default())
}
