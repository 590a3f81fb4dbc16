//! Mesh folders, measured rows, and the folder that the pages are in.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use neural_mesh::io::write_path;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::meshes::mesh_paths;
use super::versions::{Subsystem, stamp};
use crate::evaluate::{EvaluateOptions, Settings, evaluate, write_report};
use crate::rows::{ResultRow, Table};
use crate::rows_file::RowsFile;
use crate::tables::TextTable;

/// Ratios of all pages that name no others.
pub const RATIOS: [f64; 4] = [0.05, 0.1, 0.2, 0.5];
/// Number of faces above which a mesh counts as large.
pub const LARGE: usize = 50_000;

// TOSCA's classes that the weights trained on TOSCA have not seen.
pub const CLASSES: [&str; 4] = ["cat", "gorilla", "victoria", "wolf"];

/// Names of marks with what belongs between them.
pub type Blocks = Vec<(&'static str, String)>;

#[derive(Clone, Debug)]
pub struct Bench {
    data: PathBuf,
    all_versions: PathBuf,
    work: PathBuf,
    out: PathBuf,
}

impl Bench {
    pub fn new(data: &Path, all: &Path, out: &Path, subsystems: &[Subsystem]) -> Result<Self> {
        let work = all.join(stamp(subsystems).replace(", ", "-").replace(' ', ""));
        std::fs::create_dir_all(&work).with_context(|| work.display().to_string())?;
        Ok(Self { data: data.into(), all_versions: all.into(), work, out: out.into() })
    }

    pub fn for_subsystems(&self, subsystems: &[Subsystem]) -> Result<Self> {
        Self::new(&self.data, &self.all_versions, &self.out, subsystems)
    }

    pub fn set_folder(&self, name: &str) -> PathBuf {
        self.data.join(name)
    }

    /// Returns the names and paths of the meshes of a set.
    pub fn meshes(&self, set: &str) -> Result<Vec<(String, PathBuf)>> {
        mesh_paths(&self.set_folder(set))
    }

    pub fn scratch(&self, name: &str) -> Result<PathBuf> {
        let folder = self.work.join("scratch").join(name);
        std::fs::create_dir_all(&folder)?;
        Ok(folder)
    }

    /// Returns the path of a file below the folder of the pages.
    pub fn output(&self, name: &str) -> PathBuf {
        self.out.join(name)
    }

    /// Measures each named item that has no rows in `NAME.csv` yet, and returns all rows.
    pub fn measure<T>(
        &self,
        name: &str,
        figures: &[&str],
        items: impl IntoIterator<Item = (String, T)>,
        measure: impl Fn(&str, &T) -> Result<Vec<ResultRow>>,
    ) -> Result<Table> {
        let figures: Vec<String> = figures.iter().map(|figure| figure.to_string()).collect();
        let mut file = RowsFile::open(&self.work.join(name).with_extension("csv"), &figures)?;
        for (mesh, item) in items {
            // A finished measurement is never repeated.
            if !file.table.rows.iter().any(|row| row.mesh == mesh) {
                eprintln!("measuring {name}: {mesh}");
                file.push(measure(&mesh, &item).with_context(|| format!("{name}: {mesh}"))?)?;
            }
        }
        Ok(file.table)
    }

    /// Evaluates methods on a set; rows of an earlier run are kept, and meshes lose their endings.
    pub fn evaluate_set(&self, name: &str, set: &str, settings: Settings, paper: Option<PathBuf>) -> Result<Table> {
        let folder = self.work.join(name);
        let resume = folder.join("settings.json").exists();
        let options = EvaluateOptions { settings, paper_weights: paper, resume, ..EvaluateOptions::default() };
        let done = evaluate(&self.set_folder(set), &folder, &options, &|line| eprintln!("{name}: {line}"));
        done.with_context(|| name.to_owned())?;
        let mut table = write_report(&folder, None)?;
        table.rows.iter_mut().for_each(|row| row.mesh.truncate(row.mesh.rfind('.').unwrap_or(row.mesh.len())));
        Ok(table)
    }

    /// Writes a table as `docs/measured/NAME.csv`.
    pub fn write_csv(&self, name: &str, table: &TextTable) -> Result<()> {
        let path = self.output("docs/measured").join(name).with_extension("csv");
        Ok(write_path(&path, table.csv()?.as_bytes(), true)?)
    }
}

/// Returns the folder of the repository.
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Returns the path of the weights trained on TOSCA.
pub fn tosca_weights() -> PathBuf {
    root().join("weights/paper-tosca.safetensors")
}

pub fn thread_pool(n: usize) -> Result<ThreadPool> {
    Ok(ThreadPoolBuilder::new().num_threads(n).build()?)
}

/// Builds the program `neural-mesh` and returns its path.
pub fn build_program() -> Result<PathBuf> {
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "--release", "-p", "neural-mesh-cli"]).current_dir(root());
    ensure!(cargo.status().context("cargo")?.success(), "the program cannot be built");
    Ok(root().join("target/release/neural-mesh"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measurements_are_stored_and_not_repeated() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let bench = Bench::new(path, path, path, &[Subsystem::Closed]).unwrap();
        let measured = |bench: &Bench, names: &[&str], value: f64| {
            let items = names.iter().map(|name| (name.to_string(), ()));
            let rows = bench.measure("x", &["a"], items, |name, ()| {
                anyhow::ensure!(value > 0.0, "why");
                Ok(vec![ResultRow::new(name, 0.1, "m", &[value])])
            });
            rows.map(|table| table.rows.iter().map(|row| row.values[0].unwrap()).collect::<Vec<_>>())
        };
        assert_eq!(measured(&bench, &["b"], 1.0).unwrap(), [1.0]);
        assert_eq!(measured(&bench, &["b", "c"], 2.0).unwrap(), [1.0, 2.0]);
        assert!(measured(&bench, &["d"], 0.0).is_err());
        assert_eq!(measured(&bench, &["d"], 4.0).unwrap(), [1.0, 2.0, 4.0]);
        assert_eq!(measured(&bench.for_subsystems(&[Subsystem::Paper]).unwrap(), &["b"], 5.0).unwrap(), [5.0]);
    }
}
