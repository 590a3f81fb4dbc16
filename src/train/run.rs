//! A training in its folder, new or resumed from its checkpoint.

use super::checkpoint::{Checkpoint, Origin, Position, read_checkpoint, write_checkpoint};
use super::csv_table::CsvTable;
use super::data::{data_table, find_changed_file, sha256};
use super::loss_watch::LossWatch;
use super::{DataSet, Moments, OWN_OBJECTIVE, Settings, TrainError, read_data, step_function};
use crate::autodiff::{Tensors, WeightsError};
use crate::io::write_path;
use crate::linalg::Matrix;
use crate::model::Weights;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Prefix of temporary files, which remain if the program is killed.
const TEMPORARY: &str = ".neural-mesh-";
/// Names of the files that a training writes into its folder, with those of the program's curves.
pub const OUTPUT_FILES: [&str; 8] = [
    "config.toml",
    "data.csv",
    "steps.csv",
    "epochs.csv",
    "best.safetensors",
    "last.safetensors",
    "checkpoint.safetensors",
    "curves.svg",
];

/// The inputs of a training.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct TrainRequest<'a> {
    /// Folder with the meshes.
    pub data: &'a Path,
    /// Folder of the training; created if missing.
    pub folder: &'a Path,
    /// Settings as TOML; `None` for the defaults, or for those of the checkpoint.
    pub settings: Option<&'a str>,
    /// Objective, instead of that in the settings; [`OWN_OBJECTIVE`] for a custom step.
    pub objective: Option<&'a str>,
    /// Number of epochs, instead of that in the settings.
    pub epochs: Option<usize>,
    /// True to resume from the checkpoint, if there is one.
    pub resume: bool,
    /// Bytes of a weights file to start from, which also sets the sizes of the network.
    pub init: Option<&'a [u8]>,
    /// A network other than the paper's, with a custom step.
    pub network: Option<&'a OwnNetwork>,
}

/// A network other than the paper's.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnNetwork {
    /// Initial weights.
    pub tensors: Tensors<Arc<Matrix>>,
    /// Text on the sizes in the weights files, read by [`architecture_text`](crate::autodiff::architecture_text).
    pub about: String,
}

impl<'a> TrainRequest<'a> {
    /// Creates a request for a new training with default settings.
    pub fn new(data: &'a Path, folder: &'a Path) -> Self {
        Self { data, folder, settings: None, objective: None, epochs: None, resume: false, init: None, network: None }
    }
}

/// An open training, new or resumed.
#[derive(Debug)]
pub struct TrainingRun {
    /// The settings in force.
    pub settings: Settings,
    /// The meshes.
    pub data: DataSet,
    /// The folder for all output.
    pub folder: PathBuf,
    about: Option<String>,
    pub(super) state: Checkpoint,
    pub(super) steps: CsvTable,
    pub(super) epochs: CsvTable,
}

/// Opens a training: reads settings, data and checkpoint, and writes `config.toml` and `data.csv`.
///
/// # Errors
/// [`TrainError`] for faults of settings, data or folder, and for a checkpoint made with other inputs.
///
/// ```
/// use neural_mesh::train::{TrainRequest, open};
/// let folder = tempfile::tempdir().unwrap();
/// let run = folder.path().join("run");
/// let refusal = open(&TrainRequest::new(folder.path(), &run)).unwrap_err();
/// assert!(refusal.to_string().contains("no mesh to train on"));
/// ```
pub fn open(request: &TrainRequest) -> Result<TrainingRun, TrainError> {
    let checkpoint = request.folder.join("checkpoint.safetensors");
    let (state, settings, data) = if checkpoint.exists() {
        if !request.resume {
            let what = "already contains a training: continue with --resume, or choose another folder";
            return Err(TrainError::file(request.folder, what));
        }
        resume_training(request, &checkpoint)?
    } else {
        begin_training(request, &checkpoint)?
    };
    // The tables are locked from here on, so files of a running training are not touched.
    let [steps, epochs] = state.position.n_bytes;
    let steps = CsvTable::open(&request.folder.join("steps.csv"), steps)?;
    let epochs = CsvTable::open(&request.folder.join("epochs.csv"), epochs)?;
    remove_leftovers(request.folder);
    let write = |name: &str, text: String| {
        let path = request.folder.join(name);
        write_path(&path, text.as_bytes(), true).map_err(|error| TrainError::file(&path, error))
    };
    write("config.toml", config(&state.origin, &settings))?;
    write("data.csv", data_table(&data))?;
    let about = request.network.map(|network| network.about.clone());
    Ok(TrainingRun { settings, data, folder: request.folder.into(), about, state, steps, epochs })
}

impl TrainingRun {
    /// Returns the numbers of finished epochs and of finished steps in this epoch.
    pub fn position(&self) -> (usize, usize) {
        (self.state.position.epoch, self.state.position.n_done)
    }

    /// Returns the current weights.
    pub fn tensors(&self) -> &Tensors<Arc<Matrix>> {
        &self.state.tensors
    }

    pub(super) fn save(&mut self) -> Result<(), TrainError> {
        self.steps.sync()?;
        self.epochs.sync()?;
        self.state.position.n_bytes = [self.steps.n_bytes, self.epochs.n_bytes];
        write_checkpoint(&self.folder.join("checkpoint.safetensors"), &self.state)?;
        self.write_weights("last.safetensors")
    }

    pub(super) fn write_weights(&self, name: &str) -> Result<(), TrainError> {
        let path = self.folder.join(name);
        let bytes = self.weights_file().map_err(|error| TrainError::file(&path, error))?;
        write_path(&path, &bytes, true).map_err(|error| TrainError::file(&path, error))
    }

    fn weights_file(&self) -> Result<Vec<u8>, WeightsError> {
        let (settings, tensors) = (&self.settings, &self.state.tensors);
        match &self.about {
            Some(about) => Ok(tensors.to_bytes(about)),
            None => {
                Ok(Weights::from_named(settings.architecture, tensors)?.with_objective(&settings.objective).to_bytes())
            }
        }
    }
}

fn begin_training(request: &TrainRequest, checkpoint: &Path) -> Result<(Checkpoint, Settings, DataSet), TrainError> {
    check_is_empty(request.folder)?;
    let settings = apply_overrides(request, Settings::from_toml(request.settings.unwrap_or_default())?)?;
    let (settings, tensors) = match (request.network, request.init) {
        (Some(network), _) => (settings, network.tensors.clone()),
        (None, Some(bytes)) => read_initial_weights(bytes, &settings)?,
        (None, None) => {
            let weights = Weights::random_of(settings.architecture, settings.seed);
            (settings, weights.tensors().named_tensors())
        }
    };
    // Settings are checked before anything is written.
    if request.network.is_none() && request.objective != Some(OWN_OBJECTIVE) {
        step_function(&settings).map(drop)?;
    }
    let data = read_data(request.data, &settings)?;
    let origin = Origin {
        version: env!("CARGO_PKG_VERSION").into(),
        settings: settings.to_toml(),
        files: data.files.clone(),
        init: request.init.map(sha256),
    };
    let moments = Moments::zero(&shapes(&tensors));
    let state = Checkpoint { origin, position: start_position(settings.seed), tensors, moments };
    let problem =
        |error| TrainError::file(request.folder, format!("cannot be created: {error}: choose another folder"));
    std::fs::create_dir_all(request.folder).map_err(problem)?;
    write_checkpoint(checkpoint, &state)?;
    Ok((state, settings, data))
}

fn read_initial_weights(bytes: &[u8], settings: &Settings) -> Result<(Settings, Tensors<Arc<Matrix>>), TrainError> {
    let weights = Weights::from_bytes(bytes).map_err(|error| TrainError::Settings(error.to_string()))?;
    Ok((settings.with_architecture(weights.architecture())?, weights.tensors().named_tensors()))
}

fn shapes(tensors: &Tensors<Arc<Matrix>>) -> Tensors<[usize; 2]> {
    tensors.map(|_, matrix| matrix.shape())
}

fn start_position(seed: u64) -> Position {
    Position {
        epoch: 0,
        order: Vec::new(),
        n_done: 0,
        step: 0,
        random: Xoshiro256PlusPlus::seed_from_u64(seed),
        names: Vec::new(),
        sums: Vec::new(),
        n_summed: 0,
        watch: LossWatch::default(),
        best: None,
        n_bytes: [0, 0],
    }
}

fn resume_training(request: &TrainRequest, checkpoint: &Path) -> Result<(Checkpoint, Settings, DataSet), TrainError> {
    let paper_shapes =
        |origin: &Origin| Settings::from_toml(&origin.settings).map(|s| s.architecture.shapes().named_tensors());
    let mut state = read_checkpoint(checkpoint, |origin| match request.network {
        Some(network) => Ok(shapes(&network.tensors)),
        None => paper_shapes(origin),
    })?;
    let origin = &state.origin;
    let before = Settings::from_toml(&origin.settings)?;
    let mut settings = before.clone();
    if let Some(text) = request.settings {
        settings = Settings::from_toml(text)?;
        if origin.init.is_some() {
            settings = settings.with_architecture(&before.architecture)?;
        }
    }
    let settings = apply_overrides(request, settings)?;
    let init = request.init.map(sha256).filter(|sha256| origin.init.as_ref() != Some(sha256));
    let data = read_data(request.data, &settings)?;
    let version = env!("CARGO_PKG_VERSION");
    let differences = [
        (origin.version != version)
            .then(|| format!("it was made by version {} of neural-mesh, this is version {version}", origin.version)),
        before.difference(&settings),
        init.map(|_| "it started from other weights".to_string()),
        find_changed_file(&origin.files, &data.files),
    ];
    if let Some(difference) = differences.into_iter().flatten().next() {
        return Err(TrainError::Differs(difference));
    }
    if settings.epochs < state.position.epoch {
        let what =
            format!("`epochs` is {}, but {} are done: give at least that many", settings.epochs, state.position.epoch);
        return Err(TrainError::Settings(what));
    }
    state.origin.settings = settings.to_toml();
    Ok((state, settings, data))
}

fn apply_overrides(request: &TrainRequest, settings: Settings) -> Result<Settings, TrainError> {
    let settings = request.objective.map_or(Ok(settings.clone()), |objective| settings.with_objective(objective))?;
    request.epochs.map_or(Ok(settings.clone()), |epochs| settings.with_epochs(epochs))
}

fn check_is_empty(folder: &Path) -> Result<(), TrainError> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    match names.into_iter().find(|name| !name.starts_with(TEMPORARY)) {
        Some(name) => {
            let what = format!(
                "contains {name}, but no training to resume; a new one needs an empty folder: empty this one, or choose another"
            );
            Err(TrainError::file(folder, what))
        }
        None => Ok(()),
    }
}

fn remove_leftovers(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten().filter(|entry| entry.file_name().to_string_lossy().starts_with(TEMPORARY)) {
        // A file that cannot be removed only takes space.
        let _ = std::fs::remove_file(entry.path());
    }
}

fn config(origin: &Origin, settings: &Settings) -> String {
    let init = origin.init.as_ref().map(|sha256| format!("# Started from the weights file with SHA-256 {sha256}.\n"));
    format!("# Used by neural-mesh {}.\n{}\n{}", origin.version, init.unwrap_or_default(), settings.to_toml())
}
