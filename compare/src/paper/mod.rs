//! The paper's table (Table 1): its pipeline against QEM and meshoptimizer, mesh by mesh and ratio by ratio.

mod case;
mod contestant;
mod page;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use neural_mesh::model::Weights;
use serde::{Deserialize, Serialize};

use crate::load::name;
use crate::summary::markdown::publish;
use crate::table;
use case::Original;
use contestant::Contestant;
pub use contestant::{even, farthest, scattered};

#[derive(clap::Args)]
pub struct Args {
    /// Folder of meshes, PLY files named after their class and a number.
    #[arg(long)]
    data: PathBuf,
    /// Weights of the network; without them, only what needs none is measured.
    #[arg(long)]
    weights: Option<PathBuf>,
    /// Classes that count.
    #[arg(long, value_delimiter = ',', default_value = "cat,gorilla,wolf,victoria")]
    classes: Vec<String>,
    /// Shares of the vertices that stay.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2,0.5")]
    ratios: Vec<f64>,
    /// Seeds of the sampling.
    #[arg(long, value_delimiter = ',', default_value = "0")]
    seeds: Vec<u64>,
    /// Folder of results of QEM, made by `scripts/qem_open3d.py`.
    #[arg(long)]
    qem: Option<PathBuf>,
    /// Surface samples per mesh.
    #[arg(long, default_value_t = 50_000)]
    samples: usize,
    /// Threads of the timed part.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Table to write; rows that it has already are kept and not measured again. None is kept without it.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Page to write; standard output without it.
    #[arg(long)]
    page: Option<PathBuf>,
    /// A quick look: six meshes of the classes, ratios 0.05 and 0.2, whatever the ratios say.
    #[arg(long)]
    summary: bool,
    /// Leave out what the weights do not change, but for QEM's results.
    #[arg(long)]
    network_only: bool,
}

/// Every figure of one result. Distances are shares of the diagonal of the input's bounding box, squared where the
/// figure is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PaperRow {
    pub mesh: String,
    pub ratio: f64,
    pub seed: u64,
    pub method: String,
    /// `reached`, or why there is no result.
    pub outcome: String,
    /// Vertices asked for.
    pub asked: usize,
    pub vertices: usize,
    pub faces: usize,
    /// The paper's CD: mean squared distances between samples, both ways added up.
    pub chamfer: f64,
    /// Mean squared distance of samples to the other surface, both ways added up.
    pub mean_square: f64,
    pub hausdorff: f64,
    /// Mean of 1 - |n.n'|, both ways.
    pub normal_error: f64,
    /// The same from the result to the input only.
    pub normal_error_of_result: f64,
    /// Mean angle between the normals' lines, both ways, radians.
    pub normal_angle: f64,
    /// Edges without two faces, percent.
    pub wa_percent: f64,
    /// Those of them that do not lie on a border of the input, percent.
    pub open_percent: f64,
    pub seconds: Option<f64>,
}

impl PaperRow {
    /// Whether the row stands for this case.
    fn is_case(&self, mesh: &str, ratio: f64, seed: u64, method: &str) -> bool {
        self.mesh == mesh && self.ratio == ratio && self.seed == seed && self.method == method
    }
}

/// Measures every contestant on every mesh and writes table and page.
pub fn paper(args: &Args) -> Result<()> {
    let weights = args.weights.as_deref().map(read_weights).transpose()?;
    let meshes = class_meshes(&args.data, &args.classes, args.summary)?;
    ensure!(!meshes.is_empty(), "no mesh of the classes {} in {}", args.classes.join(", "), args.data.display());
    let ratios = if args.summary { &[0.05, 0.2] } else { args.ratios.as_slice() };
    let contestants = Contestant::all(weights.as_ref(), args.qem.as_deref(), args.network_only);
    let mut rows: Vec<PaperRow> = args.out.as_deref().map(table::read).transpose()?.unwrap_or_default();
    rows.retain(|row| row.faces > 0);
    for path in &meshes {
        let mesh = name(path);
        let missing = missing(&mesh, ratios, &args.seeds, &contestants, &rows);
        if !missing.is_empty() {
            rows.extend(measured(args, path, &missing)?);
            args.out.as_deref().map(|out| table::write(out, &rows)).transpose()?;
        }
        eprintln!("{mesh}");
    }
    rows.retain(|row| ratios.contains(&row.ratio));
    publish(&page::page(&rows, args.samples), args.page.as_deref())
}

/// A contestant, a ratio and a seed.
type Case<'a> = (&'a Contestant<'a>, f64, u64);

/// The cases of a mesh that the rows do not have; contestants without randomness run once.
fn missing<'a>(
    mesh: &str,
    ratios: &[f64],
    seeds: &[u64],
    contestants: &'a [Contestant<'a>],
    rows: &[PaperRow],
) -> Vec<Case<'a>> {
    let seeds_of = |contestant: &Contestant| seeds.iter().take(if contestant.is_random() { seeds.len() } else { 1 });
    let of_ratio = |&ratio| contestants.iter().flat_map(move |c| seeds_of(c).map(move |&seed| (c, ratio, seed)));
    let all = ratios.iter().flat_map(of_ratio);
    all.filter(|&(c, ratio, seed)| !rows.iter().any(|row| row.is_case(mesh, ratio, seed, c.name()))).collect()
}

/// The rows of some cases of one mesh.
fn measured(args: &Args, path: &Path, cases: &[Case]) -> Result<Vec<PaperRow>> {
    let timed = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build()?;
    let original = Original::load(path, args.samples)?;
    Ok(cases.iter().map(|&(contestant, ratio, seed)| original.row(&timed, contestant, ratio, seed)).collect())
}

/// Reads the network's weights from their file.
pub fn read_weights(path: &Path) -> Result<Weights> {
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    Weights::from_bytes(&bytes).with_context(|| path.display().to_string())
}

/// The files whose names are a class and a number, sorted; every fifth of them for a quick look.
pub fn class_meshes(folder: &Path, classes: &[String], is_quick: bool) -> Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        paths.push(entry?.path());
    }
    paths.retain(|path| is_of_class(&name(path), classes) && path.extension().is_some_and(|ext| ext == "ply"));
    paths.sort();
    Ok(if is_quick { paths.into_iter().step_by(5).collect() } else { paths })
}

fn is_of_class(name: &str, classes: &[String]) -> bool {
    let is_number = |rest: &str| !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit());
    classes.iter().any(|class| name.strip_prefix(class.as_str()).is_some_and(is_number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_are_names_before_a_number() {
        let classes = ["cat".to_owned(), "wolf".to_owned()];
        let is = |name| is_of_class(name, &classes);
        assert!(is("cat0") && is("wolf12") && !is("cat") && !is("cattle1") && !is("dog1"));
    }
}
