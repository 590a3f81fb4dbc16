//! The closed assembly with scores from the network, against geometry, shuffled weights, a formula and meshoptimizer.

pub mod bending;
mod page;
pub mod shuffled;
pub mod versus;
pub mod weighed;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{Options, Parts, ScoreSource, Target};

use crate::methods::{Done, meshoptimizer, simplified};
use crate::paper::read_weights;
use crate::row::Row;
use crate::summary::markdown::publish;
use crate::table;
use crate::turns::{Case, Contestant, Plan, fill};
use shuffled::shuffled;
use weighed::{Source, weighed};

#[derive(clap::Args)]
pub struct Args {
    /// Folder of meshes: PLY, OBJ and GLB files in it and in the folders within.
    #[arg(long)]
    data: PathBuf,
    /// Weights of the network.
    #[arg(long)]
    weights: PathBuf,
    #[command(flatten)]
    plan: Plan,
    /// Table to write; rows that it has already are kept and not measured again. None is kept without it.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Page to write; standard output without it.
    #[arg(long)]
    page: Option<PathBuf>,
}

impl Args {
    pub fn read_weights(&self) -> Result<Weights> {
        read_weights(&self.weights)
    }

    /// Lets the contestants simplify what the table does not have, and writes the page that `to_page` makes.
    pub fn publish(&self, contestants: &[Contestant], to_page: impl Fn(&[Row]) -> String) -> Result<()> {
        let meshes = mesh_files(&self.data)?;
        ensure!(!meshes.is_empty(), "no mesh in {}", self.data.display());
        let mut rows = self.out.as_deref().map(table::read).transpose()?.unwrap_or_default();
        fill(&mut rows, &meshes, contestants, &self.plan, self.out.as_deref())?;
        publish(&format!("{}\n{}", self.conditions(&rows), to_page(&rows)), self.page.as_deref())
    }

    /// What the figures were measured on, and how.
    fn conditions(&self, rows: &[Row]) -> String {
        let meshes: BTreeSet<&str> = rows.iter().map(|row| row.mesh.as_str()).collect();
        let seeds: BTreeSet<u64> = rows.iter().filter(|row| row.method != "input").map(|row| row.seed).collect();
        format!(
            "{} meshes, {} seeds, {} samples per surface; times are medians of {} runs on {} thread(s), cleanup included \
             but for meshoptimizer.\n",
            meshes.len(),
            seeds.len(),
            self.plan.samples,
            self.plan.repeat,
            self.plan.threads
        )
    }
}

/// Measures the scores against each other and writes table and page.
pub fn closed(args: &Args) -> Result<()> {
    let weights = args.read_weights()?;
    args.publish(&contestants(&weights), page::page)
}

/// The network first, whose number of faces meshoptimizer gets.
fn contestants(weights: &Weights) -> Vec<Contestant<'_>> {
    vec![
        Contestant::new("network", |case, _| by_scores(case, Some(weights))),
        Contestant::new("geometry", |case, _| by_scores(case, None)),
        Contestant::new("shuffled", |case, _| by_scores(case, Some(&shuffled(weights, case.seed)?))),
        Contestant::new("bending", |case, _| weighed(case, Source::Bending, &Parts::default())),
        Contestant::new("meshoptimizer", |case, n_faces| meshoptimizer(&case.original.mesh, n_faces)),
    ]
}

/// Ours with the scores of these weights, or of the geometry alone.
fn by_scores(case: &Case, weights: Option<&Weights>) -> Result<Done> {
    let scores = if weights.is_some() { ScoreSource::Network } else { ScoreSource::Geometry };
    let options = Options { scores, seed: case.seed, ..Options::new(Target::Ratio(case.ratio)) };
    simplified(&case.original.raw, weights, options)
}

/// The mesh files of a folder and of the folders within, sorted.
fn mesh_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() {
            files.extend(mesh_files(&path)?);
        } else if path.extension().is_some_and(|end| ["ply", "obj", "glb"].iter().any(|&known| end == known)) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
