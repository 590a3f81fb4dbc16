//! The paper's Table 2: drawn points against all vertices of the input, with noise and without.

use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use glam::{DVec3, Vec3};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{chamfer, curvature_error};
use neural_mesh::model::{Weights, in_edge_lengths, vertex_scores};
use neural_mesh::simplify::{Draw, edge_graph, gumbel_top_k};
use neural_mesh::spatial::farthest_points;
use neural_mesh::train::random::uniform;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::bench::{Bench, Blocks, CLASSES, thread_pool, tosca_weights};
use super::meshes::load;
use crate::cells::number;
use crate::clock::measure_time;
use crate::learned_baselines::{LearnedBaseline, LearnedWeights, potamias::simplify_points};
use crate::rows::{ResultRow, Table};
use crate::tables::TextTable;

const RATIOS: [f64; 3] = [0.05, 0.2, 0.8];
// Standard deviations of the noise, in percent of the diagonal.
const NOISE: [f64; 3] = [0.0, 0.5, 1.0];
const FIGURES: [&str; 3] = ["chamfer in 1e-6", "curvature in 1e-4", "ms"];
const UNIFORM: &str = "uniform, with replacement";
const SAMPLERS: [&str; 8] = [
    UNIFORM,
    "uniform, without replacement",
    "farthest points",
    "farthest points, all distances",
    "potamias",
    "evenly apart",
    "network",
    "network, drawn independently",
];

// CD and curvature error of the paper's Table 2 at 0.05, 0.2 and 0.8, without noise and with.
#[allow(clippy::approx_constant)] // one printed figure is 3.14
const TABLE_2: [(&str, [[f64; 6]; 2]); 4] = [
    ("farthest points", [[4.02, 3.42, 0.81, 2.99, 0.01, 2.21], [7.31, 4.79, 3.47, 4.35, 2.11, 4.07]]),
    (UNIFORM, [[6.71, 2.73, 1.85, 2.44, 0.24, 2.19], [7.43, 4.20, 3.67, 3.97, 2.58, 3.71]]),
    ("potamias", [[4.78, 2.51, 1.18, 2.27, 0.03, 2.14], [7.61, 4.12, 3.38, 3.65, 2.11, 3.14]]),
    ("network", [[5.12, 2.51, 1.22, 2.24, 0.05, 2.16], [7.18, 4.01, 3.21, 3.18, 1.99, 3.12]]),
];

pub fn measure(bench: &Bench) -> Result<Blocks> {
    let meshes = bench.meshes("tosca")?.into_iter();
    // One in three is enough.
    let meshes = meshes.filter(|(name, _)| CLASSES.iter().any(|class| name.starts_with(class))).step_by(3);
    let meshes: Vec<_> = meshes.collect();
    let measured = |noise: f64| {
        // Whole numbers: what follows a dot would be taken for the ending of the file.
        let name = format!("table-2-noise-{}", 10.0 * noise);
        bench.measure(&name, &FIGURES, meshes.clone(), |name, path| measure_mesh(name, path, noise))
    };
    let [none, some, most] = NOISE.map(measured);
    let tables = [none?, some?, most?];
    let csv = NOISE.iter().zip(&tables).map(|(&noise, table)| csv_table(table, noise));
    bench.write_csv("paper-samplers", &csv.fold(TextTable::default(), TextTable::with_lines_of))?;
    Ok(vec![
        ("table-2", page_table(&tables[0], NOISE[0]).markdown()),
        ("table-2-with-noise", page_table(&tables[2], NOISE[2]).markdown()),
    ])
}

fn measure_mesh(name: &str, path: &Path, noise: f64) -> Result<Vec<ResultRow>> {
    let mesh = load(path)?;
    let weights = Weights::from_bytes(&std::fs::read(tosca_weights())?)?;
    let noisy = with_noise(&mesh, 0.01 * noise);
    let one = thread_pool(1)?;
    let mut rows = Vec::new();
    for ratio in RATIOS {
        let n = (mesh.positions().len() as f64 * ratio) as usize;
        for sampler in SAMPLERS {
            let (points, time) = one.install(|| measure_time(|| Ok(draw(sampler, &noisy, n, &weights))))?;
            let distance = chamfer(&double(mesh.positions()), &double(&points)).unwrap_or_default();
            let distance = 1e6 * distance.sum() / mesh.diagonal().powi(2);
            let curvature = 1e4 * curvature_error(mesh.positions(), &points).unwrap_or_default();
            rows.push(ResultRow::new(name, ratio, sampler, &[distance, curvature, 1e3 * time.thread]));
        }
    }
    Ok(rows)
}

/// Returns the positions of `n` drawn vertices; `potamias` also moves the drawn points.
fn draw(sampler: &str, mesh: &TriMesh, n: usize, weights: &Weights) -> Vec<[f32; 3]> {
    let even = || vec![0.0; mesh.positions().len()];
    let drawn = match sampler {
        UNIFORM => with_replacement(mesh.positions().len(), n),
        "uniform, without replacement" => gumbel_top_k(&even(), n, 0),
        "evenly apart" => draw_by_scores(mesh, None, n, Draw::Scattered),
        "farthest points" => farthest_points(mesh.positions(), n, 0),
        "farthest points, all distances" => farthest_by_all_distances(mesh.positions(), n),
        "potamias" => {
            let weights = LearnedWeights::load_shipped(LearnedBaseline::Potamias);
            return simplify_points(mesh.positions(), n, 0, weights.tensors());
        }
        "network" => draw_by_scores(mesh, Some(weights), n, Draw::Scattered),
        _ => draw_by_scores(mesh, Some(weights), n, Draw::Multinomial),
    };
    drawn.iter().map(|&v| mesh.positions()[v as usize]).collect()
}

/// Draws vertices as the paper's assembly does, by the scores of a network, or by equal ones.
fn draw_by_scores(mesh: &TriMesh, weights: Option<&Weights>, n: usize, draw: Draw) -> Vec<u32> {
    let rings = Arc::new(edge_graph(mesh));
    let points = in_edge_lengths(mesh.positions(), &rings);
    let scores = match weights {
        Some(weights) => vertex_scores(weights, &points, None, &rings),
        None => vec![0.0; points.len()],
    };
    draw.draw_samples(&points, &rings, &scores, n, 0)
}

/// Draws the points of [`farthest_points`] as Sec. 3.1 has it, with a distance from each sample to each point.
fn farthest_by_all_distances(points: &[[f32; 3]], n: usize) -> Vec<u32> {
    let (mut drawn, mut next) = (Vec::with_capacity(n), 0);
    let mut nearest = vec![f32::INFINITY; points.len()];
    while drawn.len() < n.min(points.len()) {
        drawn.push(next as u32);
        let [x, y, z] = points[next];
        for (nearest, p) in nearest.iter_mut().zip(points) {
            *nearest = nearest.min((p[0] - x).powi(2) + (p[1] - y).powi(2) + (p[2] - z).powi(2));
        }
        let farthest = nearest.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        next = farthest.map_or(0, |(at, _)| at);
    }
    drawn
}

fn with_replacement(n_vertices: usize, n: usize) -> Vec<u32> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(0);
    let mut drawn: Vec<u32> = (0..n).map(|_| (uniform(&mut rng) * n_vertices as f64) as u32).collect();
    drawn.sort_unstable();
    drawn.dedup();
    drawn
}

fn double(points: &[[f32; 3]]) -> Vec<DVec3> {
    points.iter().map(|&p| DVec3::from(Vec3::from(p))).collect()
}

/// Adds normal noise to every coordinate, `sigma` in diagonals of the bounding box.
fn with_noise(mesh: &TriMesh, sigma: f64) -> TriMesh {
    let scale = sigma * mesh.diagonal();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(0x6e6f_6973_6521);
    let moved = mesh.positions().iter().map(|p| p.map(|x| (f64::from(x) + scale * normal(&mut rng)) as f32));
    TriMesh::new(moved.collect(), mesh.faces().to_vec()).unwrap_or_else(|_| mesh.clone())
}

/// Draws a standard normal number (Box and Muller 1958).
fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let radius = (-2.0 * (1.0 - uniform(rng)).ln()).sqrt();
    radius * (std::f64::consts::TAU * uniform(rng)).cos()
}

// CD and curvature of a sampler: its mean, this divided by that of uniform sampling, and this quotient in the paper.
fn compare(table: &Table, sampler: &str, ratio: f64, noise: f64) -> [[Option<f64>; 3]; 2] {
    [0, 1].map(|column| {
        let [own, uniform] = [sampler, UNIFORM].map(|sampler| table.mean(ratio, sampler, FIGURES[column]));
        let over = own.zip(uniform).map(|(own, uniform)| own / uniform);
        [own, over, paper_quotient(sampler, noise, ratio, column)]
    })
}

fn page_table(table: &Table, noise: f64) -> TextTable {
    let titles = RATIOS.iter().flat_map(|ratio| [format!("CD at {ratio}"), "curvature".into()]);
    let head = ["sampler".into()].into_iter().chain(titles).chain([format!("ms at {}", RATIOS[1])]).collect();
    let line = |&sampler: &&str| {
        let both = |ratio: f64| compare(table, sampler, ratio, noise);
        let cells = RATIOS.into_iter().flat_map(both);
        let cells = cells.map(|[_, over, print]| format!("{} / {}", number(over), number(print)));
        let time = number(table.mean(RATIOS[1], sampler, FIGURES[2]));
        [sampler.to_owned()].into_iter().chain(cells).chain([time]).collect()
    };
    TextTable { head, lines: SAMPLERS[1..].iter().map(line).collect() }
}

fn csv_table(table: &Table, noise: f64) -> TextTable {
    let head = [
        "noise %",
        "sampler",
        "ratio",
        "CD in 1e-6",
        "CD / uniform",
        "CD / uniform in the paper",
        "curvature in 1e-4",
        "curvature / uniform",
        "curvature / uniform in the paper",
        "ms",
    ];
    let line = |(sampler, ratio): (&str, f64)| {
        let cells = compare(table, sampler, ratio, noise).concat();
        let cells = cells.into_iter().chain([table.mean(ratio, sampler, FIGURES[2])]).map(number);
        [noise.to_string(), sampler.into(), ratio.to_string()].into_iter().chain(cells).collect()
    };
    let cases = SAMPLERS.iter().flat_map(|&sampler| RATIOS.map(|ratio| (sampler, ratio)));
    TextTable { head: head.map(String::from).into(), lines: cases.map(line).collect() }
}

/// Returns a figure of the paper's Table 2 divided by that of uniform sampling; `None` where the table lacks it.
fn paper_quotient(sampler: &str, noise: f64, ratio: f64, column: usize) -> Option<f64> {
    let of_noise = [NOISE[0], NOISE[2]].iter().position(|&own| own == noise)?;
    let at = RATIOS.iter().position(|&own| own == ratio)?;
    let of = |sampler: &str| {
        let row = TABLE_2.iter().find(|(name, _)| *name == sampler)?;
        Some(row.1[of_noise][2 * at + column])
    };
    Some(of(sampler)? / of(UNIFORM)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    #[test]
    fn draws_with_replacement_repeat_a_share() {
        let drawn = with_replacement(10_000, 10_000);
        // Of 10 000 vertices drawn with replacement, a share of 1 - 1 / e is distinct.
        assert!((6_200..=6_450).contains(&drawn.len()), "{}", drawn.len());
    }

    #[test]
    fn farthest_points_are_as_far_apart_by_all_distances_as_by_a_tree() {
        let points = shapes::wavy_sphere(4, 5.0).positions().to_vec();
        let spread = |drawn: Vec<u32>| {
            let drawn: Vec<[f32; 3]> = drawn.iter().map(|&v| points[v as usize]).collect();
            chamfer(&double(&points), &double(&drawn)).unwrap().sum()
        };
        let [naive, tree] = [farthest_by_all_distances(&points, 100), farthest_points(&points, 100, 0)].map(spread);
        assert!((naive / tree - 1.0).abs() < 0.02, "{naive} {tree}");
    }

    #[test]
    fn noise_has_its_deviation() {
        let mesh = shapes::icosphere(5);
        let noisy = with_noise(&mesh, 0.01);
        let pairs = mesh.positions().as_flattened().iter().zip(noisy.positions().as_flattened());
        let square = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / (3 * mesh.positions().len()) as f64;
        assert!((square.sqrt() / (0.01 * mesh.diagonal()) - 1.0).abs() < 0.05);
    }

    #[test]
    fn figures_are_divided_by_those_of_uniform_sampling() {
        let drawn = |sampler, chamfer| ResultRow::new("cat0", 0.2, sampler, &[chamfer, 1.0, 2.0]);
        let table = Table::new(&FIGURES, vec![drawn(UNIFORM, 4.0), drawn("network", 2.0)]);
        let text = page_table(&table, 0.0).markdown();
        let line = "| network | - / 0.76 | - / 0.92 | 0.50 / 0.66 | 1.00 / 0.92 | - / 0.21 |";
        assert!(text.contains(line), "{text}");
        let csv = csv_table(&table, 0.0);
        assert_eq!(csv.lines[19], ["0", "network", "0.2", "2.00", "0.50", "0.66", "1.00", "1.00", "0.92", "2.00"]);
        assert_eq!(csv.lines.len(), SAMPLERS.len() * RATIOS.len());
    }
}
