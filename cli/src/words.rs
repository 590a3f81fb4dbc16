//! What is said to people: the closing lines, notes, errors.

use std::io::Write;

use crate::failure::Failure;
use crate::report::{Distance, Report, Seconds, Size};

/// Where words go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voice {
    /// To standard output.
    Out,
    /// To standard error, where standard output holds the mesh.
    Err,
    /// Nowhere.
    Quiet,
}

impl Voice {
    /// Says a line. Nobody listening is no failure.
    pub fn say(self, line: &str) {
        let _ = match self {
            Self::Out => writeln!(std::io::stdout(), "{line}"),
            Self::Err => writeln!(std::io::stderr(), "{line}"),
            Self::Quiet => Ok(()),
        };
    }
}

/// One line on standard error.
pub fn complain(failure: &Failure) {
    let _ = writeln!(std::io::stderr(), "neural-mesh: {failure}");
}

/// What deserves a line before the closing ones.
pub fn notes(report: &Report, cleaned: &str) -> Vec<String> {
    let Report { input, output, .. } = report;
    let mut notes = Vec::new();
    if cleaned != "nothing" {
        notes.push(format!("cleaned   {cleaned}"));
    }
    if output.components_pruned > 0 {
        let all = input.shape.map(|shape| format!(" of {}", shape.components)).unwrap_or_default();
        notes.push(format!("pruned    {}{all} components", output.components_pruned));
    }
    if output.components_at_minimum > 0 {
        notes.push(format!("smallest  {} components stand in their smallest form", output.components_at_minimum));
    }
    if report.outcome != "reached" {
        notes.push(format!("stopped   {}", report.outcome));
    } else if (output.size.vertices, output.size.faces) == (input.vertices, input.faces) {
        notes.push("reached   the mesh is no larger than asked: written as it is".into());
    }
    notes
}

/// `size      2,930 vertices, 5,856 faces -> 293 vertices, 582 faces (10.0 % of the vertices)`
pub fn size(input: &Size, output: &Size) -> String {
    let share = 100.0 * output.vertices as f64 / input.vertices.max(1) as f64;
    format!("size      {} -> {} ({share:.1} % of the vertices)", counts(input), counts(output))
}

/// `distance  mean 0.12 %, max 0.85 % of the bounding-box diagonal`
pub fn distance(distance: &Distance) -> String {
    let [mean, max] = [distance.mean_percent, distance.max_percent].map(figures);
    format!("distance  mean {mean} %, max {max} % of the bounding-box diagonal")
}

/// `time      0.052 s (read 0.001, simplify 0.041, write 0.002, check 0.008)`
pub fn time(seconds: &Seconds) -> String {
    let Seconds { read, simplify, write, check, .. } = seconds;
    let total = read + simplify + write + check;
    format!("time      {total:.3} s (read {read:.3}, simplify {simplify:.3}, write {write:.3}, check {check:.3})")
}

/// `2,930 vertices, 5,856 faces`
pub fn counts(size: &Size) -> String {
    format!("{} vertices, {} faces", grouped(size.vertices), grouped(size.faces))
}

/// The last part of a path, its end where it is long.
pub fn shortened(path: &str) -> String {
    let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
    let long = name.chars().count().saturating_sub(36);
    if long == 0 { name.into() } else { format!("...{}", name.chars().skip(long + 3).collect::<String>()) }
}

/// A number with commas between groups of three digits.
pub fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Three significant digits without an exponent; 0 for less than what single precision can tell.
fn figures(percent: f64) -> String {
    if percent < 1e-5 {
        return "0".into();
    }
    let decimals = (2.0 - percent.log10().floor()).max(0.0) as usize;
    format!("{percent:.decimals$}")
}
