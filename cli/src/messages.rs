//! Messages for users.

use std::io::Write;
use std::sync::OnceLock;

use crate::closed_stdout::is_stdout_closed;
use crate::escapes::escape_controls;
use crate::failure::Failure;
use neural_mesh::io::shorten_name;
use neural_mesh::job::{
    BakeFigures, Certified, DistanceFigures, Dropped, JobReport, Level, MeshSize, NamedShare, OutputFigures, Seconds,
    percent, stop_reason,
};
use neural_mesh::repair::RepairCounts;

const MAX_LISTED_NAMES: usize = 4;

/// Destination of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageStream {
    /// Standard output.
    Out,
    /// Standard error, if standard output takes the mesh.
    Err,
    /// No output.
    Quiet,
}

impl MessageStream {
    /// Prints a line with control characters escaped; keeps a failed write for [`check_stdout_written`].
    pub fn print_line(self, line: &str) {
        let line = escape_controls(line);
        match self {
            Self::Out => {
                let _ = write_stdout(format!("{line}\n").as_bytes()).map_err(|error| FAILED_WRITE.set(error));
            }
            Self::Err => drop(writeln!(std::io::stderr(), "{line}")),
            Self::Quiet => {}
        }
    }
}

static FAILED_WRITE: OnceLock<std::io::Error> = OnceLock::new();

/// Returns an error if a write to standard output failed.
pub fn check_stdout_written() -> Result<(), Failure> {
    match FAILED_WRITE.get() {
        Some(error) => Err(stdout_failure(error)),
        None => Ok(()),
    }
}

pub fn write_stdout(bytes: &[u8]) -> std::io::Result<()> {
    if is_stdout_closed() {
        return Err(std::io::Error::other("is closed"));
    }
    let mut out = std::io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush())
}

pub fn stdout_failure(error: &std::io::Error) -> Failure {
    Failure::Failed(format!("standard output: {error}: check the program that reads it"))
}

/// Prints an error on standard error.
pub fn print_error(failure: &Failure) {
    let _ = writeln!(std::io::stderr(), "neural-mesh: {failure}");
}

pub fn note_lines(report: &JobReport, cleaned: &str) -> Vec<String> {
    let JobReport { input, output, .. } = report;
    let mut notes = Vec::new();
    if cleaned != "nothing" {
        notes.push(format!("cleaned   {cleaned}"));
    }
    notes.extend(report.repaired.as_ref().map(repaired_line));
    notes.extend(report.baked.as_ref().map(baked_line));
    notes.extend(report.named.iter().map(share_line));
    notes.extend(report.notes.iter().map(|note| format!("note      {note}")));
    if output.components_hidden > 0 {
        let n = group_digits(output.components_hidden);
        notes.push(format!("hidden    {n} components dropped: they are invisible from outside"));
    }
    if output.components_pruned > output.components_hidden {
        notes.push(dropped_line(report));
    }
    notes.extend(describe_cost(report, output).map(|cost| format!("cost      {cost}")));
    // A run that stopped at the smallest form says so itself.
    if output.components_at_minimum > 0 && stop_reason(&report.outcome).is_none() {
        notes.push(match output.components_at_minimum {
            1 => "minimum   1 component is as small as its topology allows".into(),
            n => format!("minimum   {n} components are as small as their topology allows"),
        });
    }
    if let Some(why) = stop_reason(&report.outcome) {
        notes.push(format!("stopped   {why}"));
        notes.extend(report.free.iter().map(|how| format!("try       {how}")));
    } else if (output.size.vertices, output.size.faces) == (input.vertices, input.faces) {
        let what = match report.target.is_by_error() {
            true => "no smaller mesh was found within the requested distance: allow a larger one",
            false => "the mesh already has the requested size",
        };
        notes.push(format!("unchanged {what}"));
    }
    notes
}

/// Largest distance, in percent of the diagonal, that costs nothing worth a line.
const LEAST_COST: f64 = 1.0;

/// Describes what a size costs at which shapes are lost, and the size at which they are kept.
pub fn describe_cost(report: &JobReport, output: &OutputFigures) -> Option<String> {
    let (vertices, faces) = output.size_with_shape.filter(|_| report.certified.is_none())?;
    if vertices >= report.input.vertices {
        return Some("no smaller mesh keeps all shapes".into());
    }
    let share = 100.0 * vertices as f64 / report.input.vertices.max(1) as f64;
    let distance = report.distance.as_ref();
    // A picture hardly shows less, if nothing is missing.
    if distance.is_some_and(|it| it.max_percent < LEAST_COST) && output.components_pruned == 0 {
        return None;
    }
    let largest = distance.map(|it| format!("up to {} % of the diagonal; ", format_figure(it.max_percent)));
    // Who asks for an estimate as it is gets another one, a few faces above it.
    let step = 10usize.pow(faces.max(1).ilog10().saturating_sub(1));
    let (largest, faces) = (largest.unwrap_or_default(), group_digits(faces.div_ceil(step) * step));
    Some(format!("{largest}about {faces} faces ({share:.0} % of the vertices) keep the shape"))
}

fn dropped_line(JobReport { input, output, .. }: &JobReport) -> String {
    // Separated sheets count as components of the output but not of the input; the input's total is then left out.
    let shape = input.shape.filter(|shape| shape.components > output.components_pruned);
    let all = shape.map(|shape| format!(" of {}", shape.components)).unwrap_or_default();
    let n = output.components_pruned - output.components_hidden;
    let names = list_names(&output.dropped, MAX_LISTED_NAMES);
    let how = "--keep-components keeps them, except those smaller than --prune=SIZE";
    let is_pressed = output.size_with_shape.is_some() || output.components_at_minimum > 0;
    let why = if is_pressed { "missed least at this size" } else { "too small to matter" };
    format!("dropped   {n}{all} components, {why}: {names}. {how}")
}

/// Lists the names of dropped components, each once with its count; after `most` names, only counts the rest.
pub fn list_names(dropped: &[Dropped], most: usize) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for Dropped { name, .. } in dropped {
        match counts.iter_mut().find(|(known, _)| known == name) {
            Some((_, n)) => *n += 1,
            None => counts.push((name, 1)),
        }
    }
    let describe = |(name, n): &(&str, usize)| {
        let name = shorten_name(name);
        if *n > 1 { format!("{n} of {name}") } else { name.into_owned() }
    };
    let mut names: Vec<String> = counts.iter().take(most).map(describe).collect();
    names.extend((counts.len() > most).then(|| format!("{} other names (--explain lists all)", counts.len() - most)));
    names.join(", ")
}

fn repaired_line(done: &RepairCounts) -> String {
    let named = [
        (done.holes_filled, "holes filled"),
        (done.holes_left, "holes left"),
        (done.faces_added, "faces added"),
        (done.faces_removed, "faces removed"),
        (done.faces_turned, "faces turned"),
        (done.components_dropped, "components dropped"),
        (done.components_added, "components added"),
        (done.components_flipped, "components flipped"),
    ];
    let counts: Vec<_> =
        named.iter().filter(|(n, _)| *n > 0).map(|(n, name)| format!("{name}: {}", group_digits(*n))).collect();
    format!("repaired  {}", if counts.is_empty() { "nothing to repair".into() } else { counts.join(", ") })
}

fn share_line(share: &NamedShare) -> String {
    let NamedShare { name, ratio, faces_before, faces } = share;
    let ([before, after], name) = ([*faces_before, *faces].map(group_digits), shorten_name(name));
    format!("share     {name}: {before} faces -> {after} faces (target: keep {} % of its vertices)", percent(*ratio))
}

fn baked_line(done: &BakeFigures) -> String {
    let BakeFigures { size, charts, covered, .. } = done;
    let share = 100.0 * covered;
    format!("baked     {size} x {size} texels, {} charts, which cover {share:.0} % of them", group_digits(*charts))
}

pub fn limit_lines(output: &OutputFigures) -> Vec<String> {
    let limits = [
        (output.kept_edges, "kept edges, such as seams, material borders and creases"),
        (output.locked_vertices, "locked vertices, on boundaries or kept faces"),
        (output.components_at_minimum, "components as small as their topology allows"),
        (output.split_vertices, "vertices added by splitting non-manifold vertices and edges"),
        (output.components_pruned, "components dropped"),
    ];
    limits
        .into_iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, what)| format!("limit     {} {what}", group_digits(n)))
        .collect()
}

pub fn explain_lines(report: &JobReport) -> Vec<String> {
    let JobReport { input, output, .. } = report;
    let mut lines = limit_lines(output);
    if !output.dropped.is_empty() {
        lines.push(format!("dropped   {}", list_names(&output.dropped, usize::MAX)));
    }
    if lines.is_empty() {
        lines.push("limit     only the shape: no edge is kept and no vertex locked".into());
    }
    let result = match (stop_reason(&report.outcome), &report.target) {
        (None, goal) if goal.is_by_error() => "the requested distance is kept".to_string(),
        (None, _) => "the requested size was reached".to_string(),
        (Some(why), _) => format!("the target was not reached: {why}"),
    };
    let [after, before] = [output.size.vertices, input.vertices].map(group_digits);
    let more = if output.size.vertices > input.vertices {
        ", more than in the input, as non-manifold vertices and edges were split"
    } else {
        ""
    };
    lines.push(format!("result    {result}; {after} vertices, of {before}{more}"));
    lines
}

pub fn written_line(output: &OutputFigures) -> Option<String> {
    let n = output.vertices_written.filter(|n| *n != output.size.vertices)?;
    Some(format!("written   {} vertices: the file has a copy of a vertex for each side of a seam", group_digits(n)))
}

/// Formats a level: sizes, distances, and the screen coverage up to which it suffices.
pub fn level_line(number: usize, input: &MeshSize, level: &Level) -> String {
    let size = &level.output.size;
    let share = 100.0 * size.vertices as f64 / input.vertices.max(1) as f64;
    let mut line = format!("level {number}   {} ({share:.1} % of the vertices)", format_size(size));
    if let Some(n) = level.output.vertices_written.filter(|n| *n != size.vertices) {
        line += &format!(", {} vertices written", group_digits(n));
    }
    if let Some(distance) = &level.distance {
        let (mean, max) = (distance.mean_percent, distance.max_percent);
        line += &format!(", distance mean {mean:.3} %, max {max:.3} % of the diagonal");
    }
    if let Some(certified) = &level.certified {
        line += &format!(", largest distance proved at most {:.4} % of the diagonal", certified.upper_percent);
    }
    if let (Some(coverage), Some(distance)) = (level.screen_coverage, level.switch_distance) {
        line += &format!(", fits up to {coverage:.2} of the screen height, from a distance of {distance:.3}");
    }
    // What the first level drops, a line of its own says.
    if number > 0 && level.output.components_pruned > 0 {
        line += &format!(", dropped {}", list_names(&level.output.dropped, MAX_LISTED_NAMES));
    }
    if stop_reason(&level.outcome).is_some() {
        line += &format!(", {}", level.outcome);
    }
    line
}

pub fn certified_line(distance: &Certified) -> String {
    let Certified { lower, upper, lower_percent, upper_percent } = distance;
    format!(
        "proved    largest distance at most {upper_percent:.4} % of the diagonal, at least {lower_percent:.4} % ({upper:.6} and {lower:.6} in units of the mesh)"
    )
}

/// Formats `size      2,930 vertices, 5,856 faces -> ...`.
pub fn size_line(input: &MeshSize, output: &MeshSize) -> String {
    let share = 100.0 * output.vertices as f64 / input.vertices.max(1) as f64;
    format!("size      {} -> {} ({share:.1} % of the vertices)", format_size(input), format_size(output))
}

pub fn file_line([before, after]: [u64; 2]) -> String {
    let megabytes = |bytes: u64| format_figure(bytes as f64 / 1e6);
    format!("file      {} MB -> {} MB", megabytes(before), megabytes(after))
}

pub fn distance_line(distance: &DistanceFigures) -> String {
    let [mean, max] = [distance.mean_percent, distance.max_percent].map(format_figure);
    format!("distance  mean {mean} %, max at least {max} % of the bounding-box diagonal")
}

pub fn ring_caption(distance: &DistanceFigures) -> String {
    format!("ring: place of the largest distance, {} % of the diagonal", format_figure(distance.max_percent))
}

pub fn time_line(seconds: &Seconds) -> String {
    let Seconds { read, simplify, write, check, bake, picture, .. } = seconds;
    let total = read + simplify + write + check + bake.unwrap_or(0.0) + picture.unwrap_or(0.0);
    let baked = bake.map(|bake| format!("bake {bake:.3}, ")).unwrap_or_default();
    let drawn = picture.map(|picture| format!(", picture {picture:.3}")).unwrap_or_default();
    format!(
        "time      {total:.3} s (read {read:.3}, simplify {simplify:.3}, {baked}write {write:.3}, check {check:.3}{drawn})"
    )
}

pub fn format_size(size: &MeshSize) -> String {
    format!("{} vertices, {} faces", group_digits(size.vertices), group_digits(size.faces))
}

/// Returns the last element of a path, cut at the front if it is long.
pub fn shorten_path(path: &str) -> String {
    let name = path.rsplit(['/', '\\']).next().unwrap_or(path);
    let long = name.chars().count().saturating_sub(36);
    if long == 0 { name.into() } else { format!("...{}", name.chars().skip(long + 3).collect::<String>()) }
}

/// Formats a number with commas between groups of three digits.
pub fn group_digits(number: usize) -> String {
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

/// Formats three significant digits without an exponent; numbers below 1e-5 as 0.
fn format_figure(number: f64) -> String {
    if number < 1e-5 {
        return "0".into();
    }
    let decimals = (2.0 - number.log10().floor()).max(0.0) as usize;
    format!("{number:.decimals$}")
}
