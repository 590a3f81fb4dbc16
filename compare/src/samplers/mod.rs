//! Ways to draw the sampled vertices, against each other: what the one pass makes of them, before and after its sweeps.

mod draw;
mod elimination;
pub mod farthest;
pub mod metric;
mod page;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::simplify::{Samples, one_pass};
use serde::{Deserialize, Serialize};

use crate::load::{load, name};
use crate::methods::meshoptimizer;
use crate::row::Row;
use crate::summary::statistics::Figure;
use crate::table;
use draw::Sampler;

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files.
    #[arg(long, num_args = 1.., required = true)]
    mesh: Vec<PathBuf>,
    /// Shares of the vertices that are drawn.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2")]
    ratios: Vec<f64>,
    /// Seeds of the samplers that have one.
    #[arg(long, value_delimiter = ',', default_value = "0,1,2")]
    seeds: Vec<u64>,
    /// Surface samples per side.
    #[arg(long, default_value_t = 30_000)]
    samples: usize,
    /// Table to write; meshes that it has already are not measured again.
    #[arg(long)]
    out: PathBuf,
    /// Page to write.
    #[arg(long)]
    page: PathBuf,
}

/// What the one pass makes of one sample set. Figures are those of its mesh over those of meshoptimizer's at the same
/// number of faces.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SamplerRow {
    pub mesh: String,
    pub ratio: f64,
    pub sampler: String,
    pub seed: u64,
    /// After the sweeps, or before.
    pub swept: bool,
    pub input_vertices: usize,
    /// Samples asked for.
    pub asked: usize,
    pub vertices: usize,
    pub faces: usize,
    pub mean: f64,
    pub hausdorff: f64,
    pub normal_error: f64,
    /// The sampler alone; none for darts, which leave the regions as they fall.
    pub draw_seconds: Option<f64>,
    /// From the input to the finished mesh of the pass, the sampler included.
    pub seconds: f64,
}

impl SamplerRow {
    /// Whether the pass left the input as it is.
    pub fn is_whole(&self) -> bool {
        self.vertices == self.input_vertices
    }
}

/// Draws with every sampler, on one thread; writes the table and the page.
pub fn samplers(args: &Args) -> Result<()> {
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut rows: Vec<SamplerRow> = table::read(&args.out)?;
    for path in &args.mesh {
        let mesh = name(path);
        if rows.iter().all(|row| row.mesh != mesh) {
            let measured = one_thread.install(|| measure(args, &load(path)?))?;
            rows.extend(measured.into_iter().map(|row| SamplerRow { mesh: mesh.clone(), ..row }));
            table::write(&args.out, &rows)?;
            eprintln!("{mesh}");
        }
    }
    Ok(std::fs::write(&args.page, page::page(&rows))?)
}

/// The rows of one mesh.
fn measure(args: &Args, mesh: &TriMesh) -> Result<Vec<SamplerRow>> {
    let original = Surface::new(mesh, args.samples, 0);
    let mut rows = Vec::new();
    for (&ratio, sampler) in args.ratios.iter().flat_map(|ratio| Sampler::ALL.map(|sampler| (ratio, sampler))) {
        let n_seeds = if sampler.is_random() { args.seeds.len() } else { 1 };
        for &seed in args.seeds.iter().take(n_seeds) {
            let case = Case { mesh, original: &original, ratio, sampler, seed };
            rows.push(case.measure(false, args.samples)?);
            rows.push(case.measure(true, args.samples)?);
        }
    }
    Ok(rows)
}

/// One sample set of one mesh.
struct Case<'a> {
    mesh: &'a TriMesh,
    original: &'a Surface,
    ratio: f64,
    sampler: Sampler,
    seed: u64,
}

impl Case<'_> {
    fn measure(&self, swept: bool, n_samples: usize) -> Result<SamplerRow> {
        let n = self.mesh.positions().len();
        let asked = (n as f64 * self.ratio) as usize;
        let start = Instant::now();
        let drawn = self.sampler.draw(self.mesh, asked, self.seed);
        let draw_seconds = drawn.as_ref().map(|_| start.elapsed().as_secs_f64());
        let samples = drawn.as_deref().map_or(Samples::Darts { n: asked, seed: self.seed }, Samples::Vertices);
        let ours = one_pass(self.mesh, &samples, swept).context("the pass refused the samples")?;
        let seconds = start.elapsed().as_secs_f64();
        let theirs = meshoptimizer(self.mesh, ours.faces().len())?.mesh;
        let rows = [&ours, &theirs].map(|mesh| figures(self.original, mesh, n_samples));
        let over = |figure: Figure| figure.ratio(&rows[0], &rows[1]);
        Ok(SamplerRow {
            ratio: self.ratio,
            sampler: self.sampler.name().into(),
            seed: self.seed,
            swept,
            input_vertices: n,
            asked,
            vertices: ours.positions().len(),
            faces: ours.faces().len(),
            mean: over(Figure::Mean),
            hausdorff: over(Figure::Hausdorff),
            normal_error: over(Figure::NormalError),
            draw_seconds,
            seconds,
            ..SamplerRow::default()
        })
    }
}

/// Distances and normal error of a mesh.
fn figures(original: &Surface, mesh: &TriMesh, n_samples: usize) -> Row {
    let distance = surface_distance(original, &Surface::new(mesh, n_samples, 1)).unwrap_or_default();
    Row {
        mean: distance.both.mean / original.diagonal,
        hausdorff: distance.both.max / original.diagonal,
        normal_error: distance.both.normal_error,
        ..Row::default()
    }
}
