//! The workbench: the meshes, and a folder where everything that was measured is kept, so that nothing is measured twice.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use crate::evaluate::{Event, Request, Settings, Table, evaluate, report};
use anyhow::{Context, Result};
use neural_mesh::io::write_path;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::command::worker;
use crate::measure::meshes::mesh_files;
use crate::measure::versions::{Part, stamp};

/// Folders of meshes, and the folder of what was measured with the present versions.
pub struct Bench {
    data: PathBuf,
    /// What is kept of all versions, a folder for those of a page.
    all: PathBuf,
    work: PathBuf,
}

impl Bench {
    /// For what depends on these parts: what was measured stays while their versions do.
    pub fn new(data: PathBuf, all: &Path, parts: &[Part]) -> Result<Self> {
        let work = all.join(stamp(parts).replace(", ", "-").replace(' ', ""));
        std::fs::create_dir_all(&work).with_context(|| work.display().to_string())?;
        Ok(Self { data, all: all.into(), work })
    }

    /// The same for what depends on other parts.
    pub fn of(&self, parts: &[Part]) -> Result<Self> {
        Self::new(self.data.clone(), &self.all, parts)
    }

    /// The folder of a set of meshes.
    pub fn set(&self, name: &str) -> PathBuf {
        self.data.join(name)
    }

    /// The mesh files of a set.
    pub fn meshes(&self, set: &str) -> Result<Vec<PathBuf>> {
        mesh_files(&self.set(set))
    }

    /// A folder for files that are needed for a while.
    pub fn scratch(&self, name: &str) -> Result<PathBuf> {
        let folder = self.work.join("scratch").join(name);
        std::fs::create_dir_all(&folder)?;
        Ok(folder)
    }

    /// What was measured under this name; it is measured where there is nothing yet, and kept.
    pub fn kept<T: Serialize + DeserializeOwned>(&self, name: &str, measure: impl FnOnce() -> Result<T>) -> Result<T> {
        let path = self.work.join(name).with_extension("json");
        if path.exists() {
            let text = std::fs::read_to_string(&path)?;
            return serde_json::from_str(&text).with_context(|| format!("{}: remove it", path.display()));
        }
        eprintln!("measuring {name}");
        let measured = measure().with_context(|| name.to_owned())?;
        std::fs::create_dir_all(path.parent().unwrap_or(&self.work))?;
        write_path(&path, serde_json::to_string(&measured)?.as_bytes(), true)?;
        Ok(measured)
    }

    /// The folder of an evaluation.
    pub fn run_of(&self, name: &str) -> PathBuf {
        self.work.join(name)
    }

    /// The rows of an evaluation of a set, kept case by case.
    pub fn evaluated(
        &self,
        name: &str,
        set: &str,
        settings: Settings,
        paper_weights: Option<PathBuf>,
    ) -> Result<Table> {
        let folder = self.run_of(name);
        let mut request = Request::new(self.set(set), &folder);
        request.settings = settings;
        request.paper_weights = paper_weights;
        request.resume = folder.join("settings.json").exists();
        request.worker = Some(worker()?);
        evaluate(&request, &mut |event| {
            if let Event::Case { mesh, ratio, seed, n_done, n_cases } = event {
                eprintln!("{name} {n_done}/{n_cases}: {mesh} at {ratio}, seed {seed}");
            }
            ControlFlow::Continue(())
        })
        .with_context(|| name.to_owned())?;
        Ok(report(&request.folder, None)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_measured_is_not_measured_again() {
        let folder = tempfile::tempdir().unwrap();
        let bench = Bench::new(folder.path().into(), folder.path(), &[Part::Closed]).unwrap();
        assert_eq!(bench.kept("a/b", || Ok(1)).unwrap(), 1);
        assert_eq!(bench.kept("a/b", || Ok(2)).unwrap(), 1);
        assert_eq!(bench.kept("a/c", || Ok(3)).unwrap(), 3);
        assert!(bench.kept::<u32>("d", || anyhow::bail!("why")).is_err());
        assert_eq!(bench.kept("d", || Ok(4)).unwrap(), 4);
        assert_eq!(bench.of(&[Part::Paper]).unwrap().kept("d", || Ok(5)).unwrap(), 5);
        assert_eq!(bench.of(&[Part::Closed]).unwrap().kept("d", || Ok(6)).unwrap(), 4);
    }
}
