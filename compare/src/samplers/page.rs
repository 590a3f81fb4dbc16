//! The page of the samplers: what they are, medians at each ratio, every mesh at one of them.

use std::collections::BTreeSet;

use super::SamplerRow;
use super::draw::Sampler;
use crate::summary::markdown::{cells, number, table};
use crate::summary::statistics::median;

/// The ratio at which every mesh is listed.
const LISTED: f64 = 0.1;

const INTRODUCTION: &str = "\
The one pass keeps a share of the vertices, the samples: every other vertex joins the region of a sample near by, regions \
become vertices, and faces that touch three regions become faces. Which vertices are drawn decides much of what can \
come of it. This page compares ways to draw them without anything learned, as a reference for learned scores. Nothing \
after the pass takes part: no collapse, no flips, no fit.

The plain samplers want to spread over the surface evenly. Those with *bend* measure lengths and areas so that they \
count for more where the surface bends, in the metric of the closed assembly, `|e|^2 + 2 |e| |dn|` for the square of an \
edge's length with `dn` the difference of the vertex normals and lengths in diagonals of the bounding box.

| name | what it does |
|---|---|
| darts | what the closed assembly does: a vertex that nothing has claimed yet, in random order, claims the vertices within a radius along the edges (dart throwing, Cook 1986, along the mesh); always with bend. The radius is found so that at least the asked number of darts find room |
| elimination | weighted sample elimination (Yuksel 2015) from all vertices, straight-line distances; with bend, distances are scaled by the root of the density. No randomness |
| farthest | farthest points (Gonzalez 1985; Moenning and Dodgson 2003): the vertex farthest along the edges from all samples so far; the first at random |
| Gumbel, equal | Gumbel-top-k (Kool et al. 2019), the paper's sampling, with equal scores: any vertices |
| Gumbel, area | the same with the logarithm of the vertex's area as its score: random over the surface, however it is meshed |
| Gumbel, bend | the same with the area in the metric with bend |

Regions are always grown in that metric, from whichever samples. The sweeps then hand vertices at the borders of the \
regions to the neighbour that fits them better. Each cell says *before the sweeps → after them*:

- *distance* (two-sided mean point-to-surface), *Hausdorff* (its maximum), *normal error* (mean of 1 - n.n', signed): \
those of the pass's mesh over those of meshoptimizer's `simplify` at the same number of faces, without options or error \
limit. Below 1 is better than meshoptimizer, which collapses edge by edge.
- *vertices*: those of the mesh over the samples asked for. Regions are cut where the surface would not be a manifold \
otherwise, and darts may be more than asked for.
- *whole*: cases in which no manifold could be made of the regions, so that the pass left the input as it is. They are \
in none of the other figures.
- *draw*: the sampler alone, microseconds per vertex of the input, one thread. Darts leave the regions as they fall, so \
they have no time of their own. The others are written for comparison and not tuned.
- *draw and pass*: from the input to the mesh of the pass, the same unit. Times are of single runs: good for orders of \
magnitude.
";

/// The page.
pub fn page(rows: &[SamplerRow]) -> String {
    let count = |set: BTreeSet<String>| set.len();
    let n_meshes = count(rows.iter().map(|row| row.mesh.clone()).collect());
    let n_seeds = count(rows.iter().map(|row| row.seed.to_string()).collect());
    let mut ratios: Vec<f64> = rows.iter().map(|row| row.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    ratios.dedup();
    let sections: String =
        ratios.iter().map(|&ratio| format!("\n## Ratio {ratio}\n\n{}", medians(rows, ratio))).collect();
    format!(
        "# Samplers\n\nMade by `scripts/samplers DATA_DIR`.\n\n{INTRODUCTION}\n{n_meshes} meshes, {n_seeds} seeds: per mesh \
         the median over the seeds, then the median over the meshes. The ratio is that of samples to vertices.\n{sections}\n\
         ## Every mesh at {LISTED}\n\nDistance over meshoptimizer's, before → after the sweeps, median over the seeds.\n\n{}",
        every_mesh(rows)
    )
}

/// A line for each sampler.
fn medians(rows: &[SamplerRow], ratio: f64) -> String {
    let head = cells(&[
        "sampler",
        "distance",
        "Hausdorff",
        "normal error",
        "vertices",
        "whole",
        "draw, µs",
        "draw and pass, µs",
    ]);
    let line = |sampler: Sampler| {
        let rows: Vec<&SamplerRow> =
            rows.iter().filter(|row| row.ratio == ratio && row.sampler == sampler.name()).collect();
        let whole = [false, true].map(|swept| rows.iter().filter(|row| row.swept == swept && row.is_whole()).count());
        let whole = format!("{} → {} of {}", whole[0], whole[1], rows.len() / 2);
        let pair = |figure: fn(&SamplerRow) -> Option<f64>| before_after(&rows, figure);
        let draw = median_of_meshes(&rows, |row| row.draw_seconds.map(|seconds| per_vertex(row, seconds)));
        vec![
            sampler.name().to_owned(),
            pair(|row| Some(row.mean)),
            pair(|row| Some(row.hausdorff)),
            pair(|row| Some(row.normal_error)),
            pair(|row| Some(row.vertices as f64 / row.asked as f64)),
            whole,
            number(draw),
            pair(|row| Some(per_vertex(row, row.seconds))),
        ]
    };
    table(&head, &Sampler::ALL.map(line))
}

/// Microseconds per vertex of the input.
fn per_vertex(row: &SamplerRow, seconds: f64) -> f64 {
    1e6 * seconds / row.input_vertices as f64
}

/// A line for each mesh.
fn every_mesh(rows: &[SamplerRow]) -> String {
    let meshes: BTreeSet<&str> = rows.iter().map(|row| row.mesh.as_str()).collect();
    let head: Vec<String> =
        std::iter::once("mesh".to_owned()).chain(Sampler::ALL.map(|sampler| sampler.name().to_owned())).collect();
    let line = |mesh: &str| {
        let cell = |sampler: Sampler| {
            let is_case = |row: &&SamplerRow| row.mesh == mesh && row.ratio == LISTED && row.sampler == sampler.name();
            before_after(&rows.iter().filter(is_case).collect::<Vec<_>>(), |row| Some(row.mean))
        };
        std::iter::once(mesh.to_owned()).chain(Sampler::ALL.map(cell)).collect()
    };
    table(&head, &meshes.into_iter().map(line).collect::<Vec<_>>())
}

fn before_after(rows: &[&SamplerRow], figure: fn(&SamplerRow) -> Option<f64>) -> String {
    let [before, after] = [false, true].map(|swept| {
        let rows: Vec<&SamplerRow> = rows.iter().copied().filter(|row| row.swept == swept).collect();
        number(median_of_meshes(&rows, figure))
    });
    format!("{before} → {after}")
}

/// The median over the meshes of the medians over their seeds.
fn median_of_meshes(rows: &[&SamplerRow], figure: fn(&SamplerRow) -> Option<f64>) -> Option<f64> {
    let meshes: BTreeSet<&str> = rows.iter().map(|row| row.mesh.as_str()).collect();
    let cut = || rows.iter().filter(|row| !row.is_whole());
    let of = |mesh: &str| median(cut().filter(|row| row.mesh == mesh).filter_map(|row| figure(row)).collect());
    median(meshes.into_iter().filter_map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_first_then_meshes() {
        let row = |mesh: &str, seed, mean, swept| SamplerRow {
            mesh: mesh.into(),
            ratio: 0.1,
            sampler: "darts".into(),
            seed,
            swept,
            mean,
            asked: 1,
            input_vertices: 9,
            vertices: if mean == 0.0 { 9 } else { 1 },
            ..SamplerRow::default()
        };
        let rows = [
            row("ball", 0, 1.0, false),
            row("ball", 1, 2.0, false),
            row("ball", 2, 9.0, false),
            row("cube", 0, 4.0, false),
            row("ball", 0, 0.5, true),
            row("ball", 1, 0.0, true),
        ];
        let page = page(&rows);
        assert!(page.contains("| darts | 3.00 → 0.50 |"), "{page}");
        assert!(page.contains("| 0 → 1 of 3 |"), "{page}");
        assert!(page.contains("| cube | 4.00 → - |"), "{page}");
    }
}
