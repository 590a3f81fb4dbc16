//! Ways to draw the sampled vertices, against each other: how evenly they cover the surface, and what they cost.

mod elimination;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use neural_mesh::metrics::Surface;
use neural_mesh::simplify::gumbel_top_k;
use neural_mesh::spatial::NearestOnTriangles;
use serde::{Deserialize, Serialize};

use crate::load::{load, name};
use crate::table;

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files.
    #[arg(long, num_args = 1.., required = true)]
    mesh: Vec<PathBuf>,
    /// Shares of the vertices that are drawn.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2,0.5")]
    ratios: Vec<f64>,
    /// Table to write.
    #[arg(long)]
    out: PathBuf,
}

/// One sample set.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SamplerRow {
    pub mesh: String,
    pub ratio: f64,
    pub sampler: String,
    /// Mean distance from the surface to the nearest sample, 1 for a hexagonal lattice on the plane.
    pub cover_mean: f64,
    /// The largest such distance, in the same unit.
    pub cover_max: f64,
    pub seconds: f64,
}

/// Mean distance to the nearest point of a hexagonal lattice with one point per unit of area.
const HEXAGONAL: f64 = 0.377_197;

/// Draws with every sampler and writes the table.
pub fn samplers(args: &Args) -> Result<()> {
    let mut rows = Vec::new();
    for path in &args.mesh {
        let mesh = load(path)?;
        let surface = Surface::new(&mesh, 50_000, 0);
        let points = mesh.positions();
        for &ratio in &args.ratios {
            let n_kept = (points.len() as f64 * ratio).floor() as usize;
            let gumbel = || gumbel_top_k(&vec![0.0; points.len()], n_kept, 0);
            let eliminate = || elimination::eliminate(points, n_kept, surface.area);
            let draws: [(&str, &dyn Fn() -> Vec<u32>); 2] =
                [("Gumbel-top-k, equal scores", &gumbel), ("weighted sample elimination", &eliminate)];
            for (sampler, draw) in draws {
                let start = Instant::now();
                let kept = draw();
                let seconds = start.elapsed().as_secs_f64();
                let spacing = HEXAGONAL * (surface.area / kept.len() as f64).sqrt();
                let (mean, max) = cover(&surface, points, &kept).context("nothing was drawn")?;
                let (cover_mean, cover_max) = (mean / spacing, max / spacing);
                rows.push(SamplerRow {
                    mesh: name(path),
                    ratio,
                    sampler: sampler.into(),
                    cover_mean,
                    cover_max,
                    seconds,
                });
            }
        }
        table::write(&args.out, &rows)?;
    }
    Ok(())
}

/// Mean and largest distance from points of the surface to the samples.
fn cover(surface: &Surface, points: &[[f32; 3]], kept: &[u32]) -> Option<(f64, f64)> {
    let as_triangles: Vec<_> = kept.iter().map(|&i| [points[i as usize]; 3]).collect();
    let tree = NearestOnTriangles::new(&as_triangles);
    let distances: Option<Vec<f64>> =
        surface.samples.iter().map(|&p| Some(tree.nearest(p)?.distance2.sqrt())).collect();
    let distances = distances?;
    let sum: f64 = distances.iter().sum();
    Some((sum / distances.len() as f64, distances.iter().copied().fold(0.0, f64::max)))
}
