//! Mesh folders and finished measurements.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use crate::evaluate::{Event, Request, Settings, Table, evaluate, write_report};
use anyhow::{Context, Result};
use neural_mesh::io::write_path;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::command::worker;
use crate::measure::meshes::mesh_paths;
use crate::measure::versions::{Subsystem, stamp};

pub struct Bench {
    data: PathBuf,
    all_versions: PathBuf,
    work: PathBuf,
}

impl Bench {
    pub fn new(data: PathBuf, all: &Path, subsystems: &[Subsystem]) -> Result<Self> {
        let work = all.join(stamp(subsystems).replace(", ", "-").replace(' ', ""));
        std::fs::create_dir_all(&work).with_context(|| work.display().to_string())?;
        Ok(Self { data, all_versions: all.into(), work })
    }

    pub fn for_subsystems(&self, subsystems: &[Subsystem]) -> Result<Self> {
        Self::new(self.data.clone(), &self.all_versions, subsystems)
    }

    pub fn set_folder(&self, name: &str) -> PathBuf {
        self.data.join(name)
    }

    pub fn meshes(&self, set: &str) -> Result<Vec<PathBuf>> {
        mesh_paths(&self.set_folder(set))
    }

    pub fn scratch(&self, name: &str) -> Result<PathBuf> {
        let folder = self.work.join("scratch").join(name);
        std::fs::create_dir_all(&folder)?;
        Ok(folder)
    }

    /// Returns the stored measurement `name`, or makes and stores it.
    pub fn measure_once<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        measure: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        let path = self.work.join(name).with_extension("json");
        // A finished measurement is never repeated.
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

    fn evaluation_folder(&self, name: &str) -> PathBuf {
        self.work.join(name)
    }

    pub fn evaluate_set(
        &self,
        name: &str,
        set: &str,
        settings: Settings,
        paper_weights: Option<PathBuf>,
    ) -> Result<Table> {
        let folder = self.evaluation_folder(name);
        let mut request = Request::new(self.set_folder(set), &folder);
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
        Ok(write_report(&request.folder, None)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measurements_are_stored_and_not_repeated() {
        let folder = tempfile::tempdir().unwrap();
        let bench = Bench::new(folder.path().into(), folder.path(), &[Subsystem::Closed]).unwrap();
        assert_eq!(bench.measure_once("a/b", || Ok(1)).unwrap(), 1);
        assert_eq!(bench.measure_once("a/b", || Ok(2)).unwrap(), 1);
        assert_eq!(bench.measure_once("a/c", || Ok(3)).unwrap(), 3);
        assert!(bench.measure_once::<u32>("d", || anyhow::bail!("why")).is_err());
        assert_eq!(bench.measure_once("d", || Ok(4)).unwrap(), 4);
        assert_eq!(bench.for_subsystems(&[Subsystem::Paper]).unwrap().measure_once("d", || Ok(5)).unwrap(), 5);
        assert_eq!(bench.for_subsystems(&[Subsystem::Closed]).unwrap().measure_once("d", || Ok(6)).unwrap(), 4);
    }
}
