//! The figures of textured models as Markdown.

use crate::summary::markdown::{number, table};
use crate::summary::statistics::median;

/// One model at one ratio; ours first, then meshoptimizer by each weighting.
#[derive(Debug)]
pub struct Row {
    pub name: String,
    pub ratio: f64,
    pub faces: Vec<usize>,
    /// Two-sided mean distances, in shares of the diagonal.
    pub distances: Vec<f64>,
    /// PSNR against the original's pictures, in decibels.
    pub likeness: Vec<f64>,
}

impl Row {
    /// Our distance over the best of theirs.
    fn quotient(&self) -> f64 {
        self.distances[0] / self.distances[1..].iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Our PSNR less the best of theirs.
    fn gain(&self) -> f64 {
        self.likeness[0] - self.likeness[1..].iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    fn cells(&self) -> Vec<String> {
        let join = |values: Vec<String>| values.join(" / ");
        let distances = self.distances.iter().map(|distance| format!("{:.3}", 1e3 * distance)).collect();
        let likeness = self.likeness.iter().map(|decibels| format!("{decibels:.2}")).collect();
        vec![
            self.name.clone(),
            self.ratio.to_string(),
            join(self.faces.iter().map(usize::to_string).collect()),
            join(distances),
            number(Some(self.quotient())),
            join(likeness),
            format!("{:+.2}", self.gain()),
        ]
    }
}

/// Every row, then the medians of each ratio and of all.
pub fn page(rows: &[Row], ratios: &[f64]) -> String {
    let head =
        ["model", "ratio", "faces", "distance, 1/1000 of the diagonal", "ours / theirs", "PSNR, dB", "ours - theirs"];
    let head: Vec<String> = head.map(String::from).into();
    let mut page = table(&head, &rows.iter().map(Row::cells).collect::<Vec<_>>());
    let head = ["ratio", "distance, ours / theirs: median", "PSNR, ours - theirs: median", "PSNR better on"];
    let mut summary: Vec<Vec<String>> = Vec::new();
    for &ratio in ratios {
        summary.push(summed(&ratio.to_string(), rows.iter().filter(|row| row.ratio == ratio).collect()));
    }
    summary.push(summed("all", rows.iter().collect()));
    page.push('\n');
    page.push_str(&table(&head.map(String::from), &summary));
    page.push_str(&format!("\nBetter by the median of its PSNR over the ratios: {}.\n", models(rows)));
    page
}

fn summed(name: &str, rows: Vec<&Row>) -> Vec<String> {
    let better = rows.iter().filter(|row| row.gain() > 0.0).count();
    let gain = median(rows.iter().map(|row| row.gain()).collect());
    vec![
        name.into(),
        number(median(rows.iter().map(|row| row.quotient()).collect())),
        gain.map_or_else(String::new, |gain| format!("{gain:+.2}")),
        format!("{better} of {}", rows.len()),
    ]
}

/// On how many models ours is better.
fn models(rows: &[Row]) -> String {
    let mut names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
    names.dedup();
    let gain = |name: &&str| median(rows.iter().filter(|row| row.name == **name).map(Row::gain).collect());
    let better = names.iter().filter(|name| gain(name).is_some_and(|gain| gain > 0.0)).count();
    format!("{better} of {} models", names.len())
}
