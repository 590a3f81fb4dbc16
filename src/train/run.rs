//! A training and its folder: begun anew, or taken up again where its checkpoint left it.

use super::checkpoint::{Checkpoint, Origin, Position, read_checkpoint, write_checkpoint};
use super::data::{changed_file, data_table, sha256};
use super::rows::Rows;
use super::watch::Watch;
use super::{DataSet, Moments, OWN_OBJECTIVE, Settings, TrainError, read_data, step_function};
use crate::autodiff::{Tensors, WeightsError};
use crate::io::write_path;
use crate::linalg::Matrix;
use crate::model::Weights;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How the names of files begin that were being written when the program was killed.
const TEMPORARY: &str = ".neural-mesh-";

/// What a caller asks for.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Request<'a> {
    /// Folder with the meshes.
    pub data: &'a Path,
    /// Folder of the training: made if missing, and filled.
    pub folder: &'a Path,
    /// Settings as TOML; `None` for the defaults, or for those of the checkpoint.
    pub settings: Option<&'a str>,
    /// Another objective than the settings say: [`OWN_OBJECTIVE`] for a step by a function of one's own.
    pub objective: Option<&'a str>,
    /// Another number of epochs than the settings say.
    pub epochs: Option<usize>,
    /// Whether to go on from the checkpoint, where there is one.
    pub resume: bool,
    /// The bytes of a weights file to start from; the sizes of the network are then those of the file.
    pub init: Option<&'a [u8]>,
    /// Another network than the paper's, whose step is one's own; with `init` its tensors are those of that file.
    pub network: Option<&'a OwnNetwork>,
}

/// A network other than the paper's.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnNetwork {
    /// The weights that its training begins with.
    pub tensors: Tensors<Arc<Matrix>>,
    /// What the file of its weights says of it, which [`architecture_text`](crate::autodiff::architecture_text) reads.
    pub about: String,
}

impl<'a> Request<'a> {
    /// A new training of the meshes in `data`, into `folder`, with the default settings.
    pub fn new(data: &'a Path, folder: &'a Path) -> Self {
        Self { data, folder, settings: None, objective: None, epochs: None, resume: false, init: None, network: None }
    }
}

/// A training that is ready to go on.
#[derive(Debug)]
pub struct Run {
    /// The settings in force.
    pub settings: Settings,
    /// The meshes.
    pub data: DataSet,
    /// Where all is written.
    pub folder: PathBuf,
    /// What the file of the weights says of a network of one's own.
    about: Option<String>,
    pub(super) state: Checkpoint,
    /// The table of steps.
    pub(super) steps: Rows,
    /// The table of epochs.
    pub(super) epochs: Rows,
}

/// Opens a training: reads settings and data, and the checkpoint where there is one to go on from. Writes the copies
/// of the settings (`config.toml`) and the list of the data (`data.csv`).
///
/// # Errors
/// [`TrainError`] says what is wrong with settings, data or folder; one that holds a training already is left alone
/// unless `resume`, and a checkpoint made with other settings, data or program is not taken up.
///
/// ```
/// use neural_mesh::train::{Request, open};
/// let folder = tempfile::tempdir().unwrap();
/// let run = folder.path().join("run");
/// let refusal = open(&Request::new(folder.path(), &run)).unwrap_err();
/// assert!(refusal.to_string().contains("no mesh to train on"));
/// ```
pub fn open(request: &Request) -> Result<Run, TrainError> {
    let checkpoint = request.folder.join("checkpoint.safetensors");
    let (state, settings, data) = if checkpoint.exists() {
        if !request.resume {
            let what = "holds a training already: continue with --resume, or choose another folder";
            return Err(TrainError::file(request.folder, what));
        }
        taken_up(request, &checkpoint)?
    } else {
        begun(request, &checkpoint)?
    };
    // Locked from here on: nothing of a training that still runs is touched.
    let [steps, epochs] = state.position.n_bytes;
    let steps = Rows::open(&request.folder.join("steps.csv"), steps)?;
    let epochs = Rows::open(&request.folder.join("epochs.csv"), epochs)?;
    remove_leftovers(request.folder);
    let write = |name: &str, text: String| {
        let path = request.folder.join(name);
        write_path(&path, text.as_bytes(), true).map_err(|error| TrainError::file(&path, error))
    };
    write("config.toml", config(&state.origin, &settings))?;
    write("data.csv", data_table(&data))?;
    let about = request.network.map(|network| network.about.clone());
    Ok(Run { settings, data, folder: request.folder.into(), about, state, steps, epochs })
}

impl Run {
    /// Epochs done and steps done in this one.
    pub fn position(&self) -> (usize, usize) {
        (self.state.position.epoch, self.state.position.n_done)
    }

    /// The weights as they are: the tensors of the network that the objective trains.
    pub fn tensors(&self) -> &Tensors<Arc<Matrix>> {
        &self.state.tensors
    }

    /// Writes the checkpoint and the weights as they are; the tables reach the disk first.
    pub(super) fn save(&mut self) -> Result<(), TrainError> {
        self.steps.sync()?;
        self.epochs.sync()?;
        self.state.position.n_bytes = [self.steps.n_bytes, self.epochs.n_bytes];
        write_checkpoint(&self.folder.join("checkpoint.safetensors"), &self.state)?;
        self.write_weights("last.safetensors")
    }

    /// Writes the weights as they are.
    pub(super) fn write_weights(&self, name: &str) -> Result<(), TrainError> {
        let path = self.folder.join(name);
        let bytes = self.weights_file().map_err(|error| TrainError::file(&path, error))?;
        write_path(&path, &bytes, true).map_err(|error| TrainError::file(&path, error))
    }

    /// The file of the weights; that of the paper's network says by which objective they were learned.
    fn weights_file(&self) -> Result<Vec<u8>, WeightsError> {
        let (settings, tensors) = (&self.settings, &self.state.tensors);
        match &self.about {
            Some(about) => Ok(tensors.to_bytes(about)),
            None => Ok(Weights::from_named(settings.architecture(), tensors)?.learned(&settings.objective).to_bytes()),
        }
    }
}

/// A training of its own: the checkpoint before the first step comes first, so that a folder with anything of a
/// training in it has one.
fn begun(request: &Request, checkpoint: &Path) -> Result<(Checkpoint, Settings, DataSet), TrainError> {
    check_is_empty(request.folder)?;
    let settings = asked(request, Settings::from_toml(request.settings.unwrap_or_default())?)?;
    let (settings, tensors) = match (request.network, request.init) {
        (Some(network), _) => (settings, network.tensors.clone()),
        (None, Some(bytes)) => weights_of(bytes, &settings)?,
        (None, None) => {
            let weights = Weights::random_of(settings.architecture(), settings.seed);
            (settings, weights.tensors().named())
        }
    };
    // What is wrong with the settings is found before anything is written.
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
    let state = Checkpoint { origin, position: start(settings.seed), tensors, moments };
    let problem =
        |error| TrainError::file(request.folder, format!("cannot be created: {error}: choose another folder"));
    std::fs::create_dir_all(request.folder).map_err(problem)?;
    write_checkpoint(checkpoint, &state)?;
    Ok((state, settings, data))
}

/// The settings with the sizes of the network in a file of weights, and its tensors.
fn weights_of(bytes: &[u8], settings: &Settings) -> Result<(Settings, Tensors<Arc<Matrix>>), TrainError> {
    let weights = Weights::from_bytes(bytes).map_err(|error| TrainError::Settings(error.to_string()))?;
    Ok((settings.with_architecture(weights.architecture())?, weights.tensors().named()))
}

fn shapes(tensors: &Tensors<Arc<Matrix>>) -> Tensors<[usize; 2]> {
    tensors.map(|_, matrix| matrix.shape())
}

fn start(seed: u64) -> Position {
    Position {
        epoch: 0,
        order: Vec::new(),
        n_done: 0,
        step: 0,
        random: Xoshiro256PlusPlus::seed_from_u64(seed),
        names: Vec::new(),
        sums: Vec::new(),
        n_summed: 0,
        watch: Watch::default(),
        best: None,
        n_bytes: [0, 0],
    }
}

/// A training from its checkpoint, if nothing that it was made with has changed but the number of epochs.
fn taken_up(request: &Request, checkpoint: &Path) -> Result<(Checkpoint, Settings, DataSet), TrainError> {
    let of_paper = |origin: &Origin| Settings::from_toml(&origin.settings).map(|s| s.architecture().shapes().named());
    let mut state = read_checkpoint(checkpoint, |origin| match request.network {
        Some(network) => Ok(shapes(&network.tensors)),
        None => of_paper(origin),
    })?;
    let origin = &state.origin;
    let before = Settings::from_toml(&origin.settings)?;
    let mut settings = before.clone();
    if let Some(text) = request.settings {
        settings = Settings::from_toml(text)?;
        if origin.init.is_some() {
            settings = settings.with_architecture(&before.architecture())?;
        }
    }
    let settings = asked(request, settings)?;
    let init = request.init.map(sha256).filter(|sha256| origin.init.as_ref() != Some(sha256));
    let data = read_data(request.data, &settings)?;
    let version = env!("CARGO_PKG_VERSION");
    let differences = [
        (origin.version != version).then(|| format!("version {} of the program, this is {version}", origin.version)),
        before.difference(&settings),
        init.map(|_| "other weights to start from".to_string()),
        changed_file(&origin.files, &data.files),
    ];
    if let Some(difference) = differences.into_iter().flatten().next() {
        return Err(TrainError::Differs(difference));
    }
    if settings.epochs < state.position.epoch {
        let what = format!("`epochs` is {}, but {} are done: ask for more", settings.epochs, state.position.epoch);
        return Err(TrainError::Settings(what));
    }
    state.origin.settings = settings.to_toml();
    Ok((state, settings, data))
}

/// The settings with what the request says beside them.
fn asked(request: &Request, settings: Settings) -> Result<Settings, TrainError> {
    let settings = request.objective.map_or(Ok(settings.clone()), |objective| settings.with_objective(objective))?;
    request.epochs.map_or(Ok(settings.clone()), |epochs| settings.with_epochs(epochs))
}

/// Refuses a folder that holds anything but what a killed training was just writing.
fn check_is_empty(folder: &Path) -> Result<(), TrainError> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    match names.into_iter().find(|name| !name.starts_with(TEMPORARY)) {
        Some(name) => {
            let what = format!("holds {name} but no checkpoint: choose another folder or empty it");
            Err(TrainError::file(folder, what))
        }
        None => Ok(()),
    }
}

/// Removes what was being written when the program was killed.
fn remove_leftovers(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten().filter(|entry| entry.file_name().to_string_lossy().starts_with(TEMPORARY)) {
        // What cannot be removed takes room, nothing else.
        let _ = std::fs::remove_file(entry.path());
    }
}

/// The copy of the settings, with what else the training was made with.
fn config(origin: &Origin, settings: &Settings) -> String {
    let init = origin.init.as_ref().map(|sha256| format!("# Started from the weights file with SHA-256 {sha256}.\n"));
    format!("# Used by neural-mesh {}.\n{}\n{}", origin.version, init.unwrap_or_default(), settings.to_toml())
}
