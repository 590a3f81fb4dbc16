//! The paper's Table 2: drawn points against all vertices of the input, with noise and without.

use std::path::Path;

use crate::learned_baselines::{LearnedBaseline, LearnedWeights, potamias::simplify_points};
use anyhow::Result;
use glam::{DVec3, Vec3};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{chamfer, curvature_error};
use neural_mesh::model::{Weights, in_edge_lengths};
use neural_mesh::simplify::{edge_graph, gumbel_top_k, network_scores, scattered_samples};
use neural_mesh::spatial::farthest_points;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use super::print::TABLE_2;
use super::{CLASSES, weights};
use crate::measure::clock::measure_time;
use crate::measure::markdown::{number, table};
use crate::measure::meshes::{load, name};
use crate::measure::pages::thread_pool;
use crate::measure::pages::write_csv;
use crate::measure::workbench::Bench;

const RATIOS: [f64; 3] = [0.05, 0.2, 0.8];
// Standard deviations of the noise, in percent of the diagonal.
const NOISE: [f64; 3] = [0.0, 0.5, 1.0];
// Deviations for which the paper has figures; the page shows only these.
const PRINTED_NOISE: [f64; 2] = [NOISE[0], NOISE[2]];
// Stride: one mesh in three of the classes is measured.
const MESH_STEP: usize = 3;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Sampler {
    WithReplacement,
    WithoutReplacement,
    Farthest,
    Potamias,
    Scattered,
    Network,
    Independent,
}

impl Sampler {
    const ALL: [Self; 7] = [
        Self::WithReplacement,
        Self::WithoutReplacement,
        Self::Farthest,
        Self::Potamias,
        Self::Scattered,
        Self::Network,
        Self::Independent,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::WithReplacement => "uniform, with replacement",
            Self::WithoutReplacement => "uniform, without replacement",
            Self::Farthest => "farthest points",
            Self::Potamias => "potamias",
            Self::Scattered => "evenly apart",
            Self::Network => "network",
            Self::Independent => "network, drawn independently",
        }
    }

    /// Returns the positions of `n` drawn vertices; `potamias` also moves the drawn points.
    fn draw(self, mesh: &TriMesh, n: usize, weights: &Weights) -> Vec<[f32; 3]> {
        let even = || vec![0.0; mesh.positions().len()];
        let drawn = match self {
            Self::WithReplacement => with_replacement(mesh.positions().len(), n),
            Self::WithoutReplacement => gumbel_top_k(&even(), n, 0),
            Self::Scattered => draw_scattered(mesh, &even(), n),
            Self::Farthest => farthest_points(mesh.positions(), n, 0),
            Self::Potamias => {
                let weights = LearnedWeights::load_shipped(LearnedBaseline::Potamias);
                return simplify_points(mesh.positions(), n, 0, weights.tensors());
            }
            Self::Network => draw_scattered(mesh, &network_scores(mesh, weights), n),
            Self::Independent => gumbel_top_k(&network_scores(mesh, weights), n, 0),
        };
        drawn.iter().map(|&v| mesh.positions()[v as usize]).collect()
    }
}

/// Draws vertices by score and apart from each other, as the paper's assembly does.
fn draw_scattered(mesh: &TriMesh, scores: &[f32], n: usize) -> Vec<u32> {
    let rings = edge_graph(mesh);
    scattered_samples(&in_edge_lengths(mesh.positions(), &rings), &rings, scores, n, 0)
}

fn with_replacement(n_vertices: usize, n: usize) -> Vec<u32> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(0);
    let mut drawn: Vec<u32> = (0..n).map(|_| (unit(&mut rng) * n_vertices as f64) as u32).collect();
    drawn.sort_unstable();
    drawn.dedup();
    drawn
}

#[derive(Serialize, Deserialize)]
struct SampleFigures {
    sampler: Sampler,
    ratio: f64,
    noise: f64,
    // Chamfer distance in squared diagonals.
    chamfer: f64,
    curvature: f64,
    seconds: f64,
}

pub fn table_2(bench: &Bench) -> Result<String> {
    let meshes = bench.meshes("tosca")?;
    let is_class = |path: &&std::path::PathBuf| CLASSES.iter().any(|class| name(path).starts_with(class));
    let mut drawn: Vec<SampleFigures> = Vec::new();
    let mut n_meshes = 0;
    for path in meshes.iter().filter(is_class).step_by(MESH_STEP) {
        drawn.extend(
            bench.measure_once::<Vec<SampleFigures>>(&format!("table-2/{}", name(path)), || measure_mesh(path))?,
        );
        n_meshes += 1;
    }
    let link = write_csv("paper-samplers", &CSV_HEAD, &csv_rows(&drawn))?;
    let sections: String = PRINTED_NOISE.iter().map(|&noise| section(&drawn, noise)).collect();
    Ok(format!(
        "The drawn vertices are compared, as a set of points, with all vertices of the input without noise. Cells are means over \
         {n_meshes} of the meshes of TOSCA, divided by those of uniform sampling with replacement, where a vertex drawn twice counts once: *here / in \
         the paper*. The paper's figures with noise are next to those at 1 %. Undivided figures, and those with noise of 0.5 %: {link}.\n\n\
         - *CD*: mean squared distance to the nearest point of the other set, both ways added.\n\
         - *curvature*: mean squared difference of the smoothed surface variation at nearest points, both ways added.\n\
         - *ms*: processor time on one thread of scores and drawing.\n\n\
         `potamias` is the learned point-cloud simplification of Potamias et al. (2022), which moves its points; its weights have seen no \
         mesh of TOSCA.\n{sections}"
    ))
}

fn measure_mesh(path: &Path) -> Result<Vec<SampleFigures>> {
    let mesh = load(path)?;
    let weights = Weights::from_bytes(&std::fs::read(weights())?)?;
    let one = thread_pool(1)?;
    let mut all = Vec::new();
    for noise in NOISE {
        let noisy = with_noise(&mesh, 0.01 * noise);
        for ratio in RATIOS {
            let n = (mesh.positions().len() as f64 * ratio) as usize;
            for sampler in Sampler::ALL {
                let (points, time) = one.install(|| measure_time(|| Ok(sampler.draw(&noisy, n, &weights))))?;
                let distance = chamfer(&double(mesh.positions()), &double(&points)).unwrap_or_default();
                all.push(SampleFigures {
                    sampler,
                    ratio,
                    noise,
                    chamfer: distance.sum() / mesh.diagonal().powi(2),
                    curvature: curvature_error(mesh.positions(), &points).unwrap_or_default(),
                    seconds: time.thread,
                });
            }
        }
    }
    Ok(all)
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
    let radius = (-2.0 * (1.0 - unit(rng)).ln()).sqrt();
    radius * (std::f64::consts::TAU * unit(rng)).cos()
}

/// Draws a number in 0..1.
fn unit(rng: &mut Xoshiro256PlusPlus) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

// A figure of a sampler: its mean, this divided by that of uniform sampling, and this quotient in the paper.
type Compared = [Option<f64>; 3];

fn compare(drawn: &[SampleFigures], (sampler, ratio, noise): (Sampler, f64, f64)) -> [Compared; 2] {
    let at = |sampler: Sampler, figure: fn(&SampleFigures) -> f64| mean(drawn, (sampler, ratio, noise), figure);
    let figures: [fn(&SampleFigures) -> f64; 2] = [|drawn| 1e6 * drawn.chamfer, |drawn| 1e4 * drawn.curvature];
    [0, 1].map(|column| {
        let own = at(sampler, figures[column]);
        let over = own.zip(at(Sampler::WithReplacement, figures[column])).map(|(own, other)| own / other);
        [own, over, paper_quotient(sampler, noise, ratio, column)]
    })
}

fn mean(drawn: &[SampleFigures], case: (Sampler, f64, f64), figure: fn(&SampleFigures) -> f64) -> Option<f64> {
    let is_case = |drawn: &&SampleFigures| (drawn.sampler, drawn.ratio, drawn.noise) == case;
    let values: Vec<f64> = drawn.iter().filter(is_case).map(figure).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn milliseconds(drawn: &[SampleFigures], case: (Sampler, f64, f64)) -> String {
    number(mean(drawn, case, |drawn| 1e3 * drawn.seconds))
}

fn section(drawn: &[SampleFigures], noise: f64) -> String {
    let mut head = vec!["sampler".to_owned()];
    RATIOS.iter().for_each(|ratio| head.extend([format!("CD at {ratio}"), "curvature".into()]));
    head.push(format!("ms at {}", RATIOS[1]));
    let line = |&sampler: &Sampler| {
        let mut cells = vec![sampler.name().to_owned()];
        for ratio in RATIOS {
            let compared = compare(drawn, (sampler, ratio, noise));
            cells.extend(compared.map(|[_, over, print]| format!("{} / {}", number(over), number(print))));
        }
        cells.push(milliseconds(drawn, (sampler, RATIOS[1], noise)));
        cells
    };
    let others = Sampler::ALL.iter().filter(|&&sampler| sampler != Sampler::WithReplacement);
    format!("\n### Noise {noise} %\n\n{}", table(&head, &others.map(line).collect::<Vec<_>>()))
}

const CSV_HEAD: [&str; 10] = [
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

fn csv_rows(drawn: &[SampleFigures]) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for noise in NOISE {
        for sampler in Sampler::ALL {
            for ratio in RATIOS {
                let case = (sampler, ratio, noise);
                let mut row = vec![noise.to_string(), sampler.name().into(), ratio.to_string()];
                row.extend(compare(drawn, case).concat().into_iter().map(number));
                row.push(milliseconds(drawn, case));
                rows.push(row);
            }
        }
    }
    rows
}

/// Returns a figure of the paper's Table 2 divided by that of uniform sampling; `None` where the table lacks it.
fn paper_quotient(sampler: Sampler, noise: f64, ratio: f64, column: usize) -> Option<f64> {
    let [of_noise, at] =
        [PRINTED_NOISE.iter().position(|&own| own == noise)?, RATIOS.iter().position(|&own| own == ratio)?];
    let of = |sampler: Sampler| {
        let row = TABLE_2.iter().find(|(name, _)| *name == sampler.name())?;
        Some(row.1[of_noise][2 * at + column])
    };
    Some(of(sampler)? / of(Sampler::WithReplacement)?)
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
    fn noise_has_its_deviation() {
        let mesh = shapes::icosphere(5);
        let noisy = with_noise(&mesh, 0.01);
        let pairs = mesh.positions().as_flattened().iter().zip(noisy.positions().as_flattened());
        let square = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>() / (3 * mesh.positions().len()) as f64;
        assert!((square.sqrt() / (0.01 * mesh.diagonal()) - 1.0).abs() < 0.05);
    }

    #[test]
    fn figures_are_divided_by_those_of_uniform_sampling() {
        let drawn = |sampler, chamfer| SampleFigures {
            sampler,
            ratio: 0.2,
            noise: 0.0,
            chamfer,
            curvature: 1e-4,
            seconds: 0.002,
        };
        let both = [drawn(Sampler::WithReplacement, 4e-6), drawn(Sampler::Network, 2e-6)];
        let text = section(&both, 0.0);
        assert!(text.contains("| network | - / 0.76 | - / 0.92 | 0.50 / 0.66 | 1.00 / 0.92 | - / 0.21 |"), "{text}");
        let rows = csv_rows(&both);
        assert_eq!(rows[16], ["0", "network", "0.2", "2.00", "0.50", "0.66", "1.00", "1.00", "0.92", "2.00"]);
        assert_eq!(rows.len(), NOISE.len() * Sampler::ALL.len() * RATIOS.len());
    }
}
