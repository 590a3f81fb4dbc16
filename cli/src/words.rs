//! What is said to people: the closing lines, notes, errors.

use std::io::Write;
use std::sync::OnceLock;

use crate::closed::is_closed;
use crate::failure::Failure;
use crate::plain::plain;
use neural_mesh::job::{
    Baked, Certified, Distance, Dropped, Level, NamedShare, Output, Repaired, Report, Seconds, Size, TargetWords,
    percent, why_stopped,
};

/// Names of dropped components in one line, at most.
const MOST_NAMES: usize = 4;

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
    /// Says a line, made plain. Where standard output takes none, [`heard`] tells; nobody listening to standard error is no
    /// failure.
    pub fn say(self, line: &str) {
        let line = plain(line);
        match self {
            Self::Out => {
                let _ = out(format!("{line}\n").as_bytes()).map_err(|error| UNHEARD.set(error));
            }
            Self::Err => drop(writeln!(std::io::stderr(), "{line}")),
            Self::Quiet => {}
        }
    }
}

/// Why standard output did not take a line, where it did not.
static UNHEARD: OnceLock<std::io::Error> = OnceLock::new();

/// Whether standard output took all that was said.
pub fn heard() -> Result<(), Failure> {
    match UNHEARD.get() {
        Some(error) => Err(closed(error)),
        None => Ok(()),
    }
}

/// Writes bytes to standard output.
pub fn out(bytes: &[u8]) -> std::io::Result<()> {
    if is_closed() {
        return Err(std::io::Error::other("is closed"));
    }
    let mut out = std::io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush())
}

/// Standard output is closed or full, or nobody reads it any more.
pub fn closed(error: &std::io::Error) -> Failure {
    Failure::Failed(format!("standard output: {error}: check the program that reads it"))
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
    notes.extend(report.repaired.as_ref().map(repaired));
    notes.extend(report.baked.as_ref().map(baked));
    notes.extend(report.named.iter().map(named));
    notes.extend(report.notes.iter().map(|note| format!("note      {note}")));
    if output.components_hidden > 0 {
        let n = grouped(output.components_hidden);
        notes.push(format!("hidden    {n} components dropped: they are invisible from outside"));
    }
    if output.components_pruned > output.components_hidden {
        // Those of the input are fewer where its sheets came apart.
        let shape = input.shape.filter(|shape| shape.components > output.components_pruned);
        let all = shape.map(|shape| format!(" of {}", shape.components)).unwrap_or_default();
        let how = ". --keep-components keeps all but those below --prune";
        let n = output.components_pruned - output.components_hidden;
        notes.push(format!(
            "dropped   {n}{all} components as too small to matter: {}{how}",
            names_of(&output.dropped, MOST_NAMES)
        ));
    }
    if output.components_at_minimum > 0 {
        notes.push(match output.components_at_minimum {
            1 => "minimum   1 component is as small as its topology allows".into(),
            n => format!("minimum   {n} components are as small as their topology allows"),
        });
    }
    if let Some(why) = why_stopped(&report.outcome) {
        notes.push(format!("stopped   {why}"));
        notes.extend(report.free.iter().map(|how| format!("try       {how}")));
    } else if (output.size.vertices, output.size.faces) == (input.vertices, input.faces) && report.mirror.is_none() {
        notes.push("unchanged the mesh already has the requested size".into());
    }
    notes.extend(report.mirror.iter().map(|plane| format!("mirrored  about {plane}, exactly")));
    notes
}

/// Components by name, those of one name once with their number; of many the first ones.
pub fn names_of(dropped: &[Dropped], most: usize) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for Dropped { name, .. } in dropped {
        match counts.iter_mut().find(|(known, _)| known == name) {
            Some((_, n)) => *n += 1,
            None => counts.push((name, 1)),
        }
    }
    let of_one = |(name, n): &(&str, usize)| if *n > 1 { format!("{n} of {name}") } else { (*name).to_owned() };
    let mut names: Vec<String> = counts.iter().take(most).map(of_one).collect();
    names.extend((counts.len() > most).then(|| format!("{} other names (--explain lists all)", counts.len() - most)));
    names.join(", ")
}

/// `repaired  holes filled: 3, faces added: 120, components dropped: 12`
fn repaired(done: &Repaired) -> String {
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
    let parts: Vec<_> =
        named.iter().filter(|(n, _)| *n > 0).map(|(n, name)| format!("{name}: {}", grouped(*n))).collect();
    format!("repaired  {}", if parts.is_empty() { "nothing to repair".into() } else { parts.join(", ") })
}

/// `share     head: 1,200 faces -> 598 faces (50 % of its vertices)`
fn named(share: &NamedShare) -> String {
    let NamedShare { name, ratio, faces_before, faces } = share;
    let [before, after] = [*faces_before, *faces].map(grouped);
    format!("share     {name}: {before} faces -> {after} faces ({} % of its vertices)", percent(*ratio))
}

/// `baked     2048 x 2048, 213 charts, 74 % of the texels`
fn baked(done: &Baked) -> String {
    let Baked { size, charts, covered, .. } = done;
    let share = 100.0 * covered;
    format!("baked     {size} x {size}, {} charts, {share:.0} % of the texels", grouped(*charts))
}

/// `held      12 kept edges: ...`, a line for each thing that holds a result.
pub fn held(output: &Output) -> Vec<String> {
    let held = [
        (output.kept_edges, "kept edges, such as seams, material borders and creases"),
        (output.locked_vertices, "locked vertices, on boundaries or kept faces"),
        (output.components_at_minimum, "components as small as their topology allows"),
        (output.split_vertices, "vertices added by splitting non-manifold vertices and edges"),
        (output.components_pruned, "components dropped"),
    ];
    held.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("limit     {} {what}", grouped(n))).collect()
}

/// What holds the result: what `--explain` says.
pub fn explained(report: &Report) -> Vec<String> {
    let Report { input, output, .. } = report;
    let mut lines = held(output);
    if !output.dropped.is_empty() {
        lines.push(format!("dropped   {}", names_of(&output.dropped, usize::MAX)));
    }
    if lines.is_empty() {
        lines.push("limit     none but the shape".into());
    }
    let asked = match (why_stopped(&report.outcome), &report.target) {
        (None, TargetWords::Error(_) | TargetWords::ErrorPercent(_) | TargetWords::LodsError(_)) => {
            "within the requested distance".to_string()
        }
        (None, _) => "the requested size was reached".to_string(),
        (Some(why), _) => format!("the target was not reached: {why}"),
    };
    let [after, before] = [output.size.vertices, input.vertices].map(grouped);
    let more = if output.size.vertices > input.vertices { ", more than before because of the splits" } else { "" };
    lines.push(format!("result    {asked}, {after} of {before} vertices{more}"));
    lines
}

/// `written   349 vertices, with a copy for each side of a seam`, where a file has more than the mesh.
pub fn written(output: &Output) -> Option<String> {
    let n = output.vertices_written.filter(|n| *n != output.size.vertices)?;
    Some(format!("written   {} vertices, with a copy for each side of a seam", grouped(n)))
}

/// `level 1   640 vertices, 1,276 faces (25.0 % of the vertices), distance 0.1 % mean, 0.4 % max, up to 0.23 of the screen`
pub fn level(number: usize, input: &Size, level: &Level) -> String {
    let size = &level.output.size;
    let share = 100.0 * size.vertices as f64 / input.vertices.max(1) as f64;
    let mut line = format!("level {number}   {} ({share:.1} % of the vertices)", counts(size));
    if let Some(n) = level.output.vertices_written.filter(|n| *n != size.vertices) {
        line += &format!(", {} vertices written", grouped(n));
    }
    if let (Some(distance), Some(coverage)) = (&level.distance, level.screen_coverage) {
        let (mean, max) = (distance.mean_percent, distance.max_percent);
        line += &format!(", distance {mean:.3} % mean, {max:.3} % max, up to {coverage:.2} of the screen");
    }
    if let Some(certified) = &level.certified {
        line += &format!(", proved within {:.4} %", certified.upper_percent);
    }
    if why_stopped(&level.outcome).is_some() {
        line += &format!(", {}", level.outcome);
    }
    line
}

/// `certain   largest distance 0.49 % of the diagonal at most, 0.48 % at least (0.017 and 0.0166 in the unit of the mesh)`
pub fn certified(distance: &Certified) -> String {
    let Certified { lower, upper, lower_percent, upper_percent } = distance;
    format!(
        "proved    largest distance at most {upper_percent:.4} % of the diagonal, at least {lower_percent:.4} % ({upper:.6} and {lower:.6} in units of the mesh)"
    )
}

/// `size      2,930 vertices, 5,856 faces -> 293 vertices, 582 faces (10.0 % of the vertices)`
pub fn size(input: &Size, output: &Size) -> String {
    let share = 100.0 * output.vertices as f64 / input.vertices.max(1) as f64;
    format!("size      {} -> {} ({share:.1} % of the vertices)", counts(input), counts(output))
}

/// `file      1.75 MB -> 0.369 MB`
pub fn bytes([before, after]: [u64; 2]) -> String {
    let megabytes = |bytes: u64| figures(bytes as f64 / 1e6);
    format!("file      {} MB -> {} MB", megabytes(before), megabytes(after))
}

/// `distance  mean 0.12 %, max at least 0.85 % of the bounding-box diagonal`
pub fn distance(distance: &Distance) -> String {
    let [mean, max] = [distance.mean_percent, distance.max_percent].map(figures);
    format!("distance  mean {mean} %, max at least {max} % of the bounding-box diagonal")
}

/// `ring: farthest, 0.85 % of the diagonal`
pub fn farthest(distance: &Distance) -> String {
    format!("ring: largest distance, {} % of the diagonal", figures(distance.max_percent))
}

/// `time      0.052 s (read 0.001, simplify 0.041, write 0.002, check 0.008)`
pub fn time(seconds: &Seconds) -> String {
    let Seconds { read, simplify, write, check, bake, .. } = seconds;
    let total = read + simplify + write + check + bake.unwrap_or(0.0);
    let baked = bake.map(|bake| format!("bake {bake:.3}, ")).unwrap_or_default();
    format!(
        "time      {total:.3} s (read {read:.3}, simplify {simplify:.3}, {baked}write {write:.3}, check {check:.3})"
    )
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

/// Three significant digits without an exponent; 0 for less than what single precision can tell of percent.
fn figures(number: f64) -> String {
    if number < 1e-5 {
        return "0".into();
    }
    let decimals = (2.0 - number.log10().floor()).max(0.0) as usize;
    format!("{number:.decimals$}")
}
