//! The paper's table of samplers (Table 2): which vertices are drawn, judged as a set of points.

mod draw;
mod page;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Result, ensure};
use glam::DVec3;
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{chamfer, curvature_error};
use neural_mesh::model::Weights;
use rayon::ThreadPool;
use serde::{Deserialize, Serialize};

use crate::load::{load, name};
use crate::methods::compact;
use crate::paper::{class_meshes, read_weights};
use crate::summary::markdown::publish;
use crate::table;
use draw::{Sampler, with_noise};

#[derive(clap::Args)]
pub struct Args {
    /// Folder of meshes, PLY files named after their class and a number.
    #[arg(long)]
    data: PathBuf,
    /// Weights of the network; without them, only the other samplers are measured.
    #[arg(long)]
    weights: Option<PathBuf>,
    /// Classes that count.
    #[arg(long, value_delimiter = ',', default_value = "cat,gorilla,wolf,victoria")]
    classes: Vec<String>,
    /// Shares of the vertices that are drawn.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.2,0.8")]
    ratios: Vec<f64>,
    /// Noise on the vertices, standard deviation in percent of the bounding box's diagonal.
    #[arg(long, value_delimiter = ',', default_value = "0,0.5,1")]
    noise: Vec<f64>,
    /// Seeds of the sampling.
    #[arg(long, value_delimiter = ',', default_value = "0,1,2")]
    seeds: Vec<u64>,
    /// Table to write; rows that it has already are kept and not measured again. None is kept without it.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Page to write; standard output without it.
    #[arg(long)]
    page: Option<PathBuf>,
    /// A quick look: six meshes of the classes, without noise, one seed, without farthest points.
    #[arg(long)]
    summary: bool,
}

/// One sample set of one mesh. Distances are shares of the diagonal, squared.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PointRow {
    pub mesh: String,
    pub ratio: f64,
    /// Percent of the diagonal.
    pub noise: f64,
    pub seed: u64,
    pub sampler: String,
    pub points: usize,
    /// Between the drawn vertices and all of the input's without noise: mean squared, both ways added up.
    pub chamfer: f64,
    pub curvature_error: f64,
    pub seconds: f64,
}

/// Draws with every sampler from every mesh; writes table and page.
pub fn samplers_paper(args: &Args) -> Result<()> {
    let weights = args.weights.as_deref().map(read_weights).transpose()?;
    let meshes = class_meshes(&args.data, &args.classes, args.summary)?;
    ensure!(!meshes.is_empty(), "no mesh of the classes {} in {}", args.classes.join(", "), args.data.display());
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut rows: Vec<PointRow> = args.out.as_deref().map(table::read).transpose()?.unwrap_or_default();
    for path in &meshes {
        let mut original = None;
        for wanted in wanted(args, &name(path), weights.as_ref()) {
            if rows.iter().any(|row| wanted.is_of(row)) {
                continue;
            }
            let original = match &mut original {
                Some(original) => original,
                none => none.insert(loaded(path)?),
            };
            rows.push(wanted.row(&one_thread, original));
        }
        args.out.as_deref().map(|out| table::write(out, &rows)).transpose()?;
        eprintln!("{}", name(path));
    }
    publish(&page::page(&rows), args.page.as_deref())
}

/// The mesh without vertices that no face uses.
fn loaded(path: &Path) -> Result<TriMesh> {
    let read = load(path)?;
    compact(&read, read.faces())
}

/// Every case of one mesh.
fn wanted<'a>(args: &Args, mesh: &str, weights: Option<&'a Weights>) -> Vec<Case<'a>> {
    let noise = if args.summary { &[0.0] } else { args.noise.as_slice() };
    let seeds = if args.summary { &args.seeds[..1] } else { args.seeds.as_slice() };
    let mut cases = Vec::new();
    for (&noise, &ratio) in noise.iter().flat_map(|noise| args.ratios.iter().map(move |ratio| (noise, ratio))) {
        for (&seed, sampler) in seeds.iter().flat_map(|seed| Sampler::all(weights).map(move |s| (seed, s))) {
            if !(args.summary && matches!(sampler, Sampler::Farthest)) {
                cases.push(Case { mesh: mesh.to_owned(), ratio, noise, seed, sampler });
            }
        }
    }
    cases
}

struct Case<'a> {
    mesh: String,
    ratio: f64,
    noise: f64,
    seed: u64,
    sampler: Sampler<'a>,
}

impl Case<'_> {
    fn is_of(&self, row: &PointRow) -> bool {
        (row.ratio, row.noise, row.seed) == (self.ratio, self.noise, self.seed)
            && (row.mesh.as_str(), row.sampler.as_str()) == (self.mesh.as_str(), self.sampler.name())
    }

    /// Draws and measures.
    fn row(&self, one_thread: &ThreadPool, original: &TriMesh) -> PointRow {
        let noisy = with_noise(original, self.noise / 100.0, self.seed);
        let n = (original.positions().len() as f64 * self.ratio) as usize;
        let start = Instant::now();
        let drawn = one_thread.install(|| self.sampler.draw(&noisy, n, self.seed));
        let seconds = start.elapsed().as_secs_f64();
        let points: Vec<[f32; 3]> = drawn.iter().map(|&v| noisy.positions()[v as usize]).collect();
        let distance = chamfer(&double(original.positions()), &double(&points)).unwrap_or_default();
        let diagonal = draw::diagonal(original.positions());
        PointRow {
            mesh: self.mesh.clone(),
            ratio: self.ratio,
            noise: self.noise,
            seed: self.seed,
            sampler: self.sampler.name().into(),
            points: points.len(),
            chamfer: distance.sum() / (diagonal * diagonal),
            curvature_error: curvature_error(original.positions(), &points).unwrap_or_default(),
            seconds,
        }
    }
}

fn double(points: &[[f32; 3]]) -> Vec<DVec3> {
    points.iter().map(|p| DVec3::from(p.map(f64::from))).collect()
}
