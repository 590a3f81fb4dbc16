//! Checkpoint of a training in one safetensors file.

use super::data::DataFile;
use super::loss_watch::LossWatch;
use super::{Moments, TrainError};
use crate::autodiff::Tensors;
use crate::io::write_path;
use crate::linalg::Matrix;
use rand_xoshiro::Xoshiro256PlusPlus;
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

const STATE_KEY: &str = "training";

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Origin {
    pub version: String,
    pub settings: String,
    pub files: Vec<DataFile>,
    /// SHA-256 of the given initial weights file, if any.
    pub init: Option<String>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Position {
    pub epoch: usize,
    /// Order in which this epoch visits the meshes; empty before the epoch begins.
    pub order: Vec<u32>,
    pub n_done: usize,
    /// Number of steps over all epochs, skipped ones included.
    pub step: u64,
    pub random: Xoshiro256PlusPlus,
    /// Names of the loss terms; empty before the first step.
    pub names: Vec<String>,
    pub sums: Vec<f64>,
    pub n_summed: usize,
    pub watch: LossWatch,
    /// Smallest mean loss of a validation so far; without validation, of an epoch's steps.
    pub best: Option<f64>,
    /// Lengths in bytes of `steps.csv` and `epochs.csv`.
    pub n_bytes: [u64; 2],
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Checkpoint {
    pub origin: Origin,
    pub position: Position,
    pub tensors: Tensors<Arc<Matrix>>,
    pub moments: Moments,
}

#[derive(Serialize, Deserialize)]
struct CheckpointState {
    origin: Origin,
    position: Position,
    adam_steps: u64,
}

/// Replaces the checkpoint atomically.
pub(super) fn write_checkpoint(path: &Path, checkpoint: &Checkpoint) -> Result<(), TrainError> {
    let bytes = to_bytes(checkpoint).map_err(|what| TrainError::file(path, what))?;
    write_path(path, &bytes, true).map_err(|error| TrainError::file(path, error))
}

/// Reads a checkpoint; `shapes` derives the tensor shapes from the origin stored in it.
pub(super) fn read_checkpoint(
    path: &Path,
    shapes: impl FnOnce(&Origin) -> Result<Tensors<[usize; 2]>, TrainError>,
) -> Result<Checkpoint, TrainError> {
    let broken = |what: String| {
        TrainError::file(path, format!("is not a complete checkpoint ({what}): train in another folder"))
    };
    let bytes = std::fs::read(path)
        .map_err(|error| TrainError::file(path, format!("cannot be read: {error}: check the file")))?;
    let (_, metadata) = SafeTensors::read_metadata(&bytes).map_err(|error| broken(error.to_string()))?;
    let state = metadata.metadata().as_ref().and_then(|entries| entries.get(STATE_KEY));
    let state = state.ok_or_else(|| broken("it contains no training state".into()))?;
    let CheckpointState { origin, position, adam_steps } =
        serde_json::from_str(state).map_err(|error| broken(error.to_string()))?;
    let shapes = shapes(&origin)?;
    let file = SafeTensors::deserialize(&bytes).map_err(|error| broken(error.to_string()))?;
    let read = |prefix: &str| read_tensors(&file, prefix, &shapes).map_err(broken);
    let tensors = read("weights")?.map(|_, matrix| Arc::new(matrix.clone()));
    let tensors = tensors.check_shapes(&shapes).map_err(|error| broken(error.to_string()))?;
    let moments = Moments { first: read("first")?, second: read("second")?, steps: adam_steps };
    Ok(Checkpoint { origin, position, tensors, moments })
}

fn to_bytes(checkpoint: &Checkpoint) -> Result<Vec<u8>, String> {
    let Checkpoint { origin, position, tensors, moments } = checkpoint;
    let mut parts: Vec<(String, [usize; 2], Vec<u8>)> = Vec::new();
    let mut add = |prefix: &str, name: &str, matrix: &Matrix| {
        let bytes = matrix.data().iter().flat_map(|x| x.to_le_bytes()).collect();
        parts.push((format!("{prefix}.{name}"), matrix.shape(), bytes));
    };
    tensors.map(|name, matrix| add("weights", name, matrix));
    moments.first.map(|name, matrix| add("first", name, matrix));
    moments.second.map(|name, matrix| add("second", name, matrix));
    let state = CheckpointState { origin: origin.clone(), position: position.clone(), adam_steps: moments.steps };
    let state = serde_json::to_string(&state).map_err(|error| error.to_string())?;
    let views = parts.iter().map(|(name, shape, bytes)| {
        TensorView::new(Dtype::F32, shape.to_vec(), bytes).map(|view| (name, view)).map_err(|error| error.to_string())
    });
    let views = views.collect::<Result<Vec<_>, _>>()?;
    serialize(views, Some(HashMap::from([(STATE_KEY.to_string(), state)]))).map_err(|error| error.to_string())
}

fn read_tensors(file: &SafeTensors, prefix: &str, shapes: &Tensors<[usize; 2]>) -> Result<Tensors<Matrix>, String> {
    shapes.try_map(|name, &[n_rows, n_cols]| {
        let name = format!("{prefix}.{name}");
        let tensor = file.tensor(&name).map_err(|_| format!("it lacks {name}"))?;
        if tensor.dtype() != Dtype::F32 || tensor.shape() != [n_rows, n_cols] {
            return Err(format!("{name} has another shape"));
        }
        let (words, _) = tensor.data().as_chunks();
        Ok(Matrix::new(n_rows, n_cols, words.iter().map(|word| f32::from_le_bytes(*word)).collect()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_xoshiro::rand_core::{Rng, SeedableRng};

    fn shapes() -> Tensors<[usize; 2]> {
        [("b.weights", [7, 5]), ("a.bias", [1, 5])].into_iter().collect()
    }

    fn checkpoint() -> Checkpoint {
        let tensors = shapes().draw(1);
        let moments = |seed| shapes().draw(seed).map(|_, matrix| matrix.as_ref().clone());
        let moments = Moments { first: moments(2), second: moments(3), steps: 9 };
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        random.next_u64();
        let position = Position {
            epoch: 2,
            order: vec![1, 0, 2],
            n_done: 1,
            step: 10,
            random,
            names: vec!["a".into()],
            sums: vec![0.1 + 0.2],
            n_summed: 1,
            watch: LossWatch::default(),
            best: Some(1.0 / 3.0),
            n_bytes: [100, 50],
        };
        let files = vec![DataFile { name: "a \"quoted\".ply".into(), sha256: "00".into() }];
        let origin = Origin { version: "1".into(), settings: "epochs = 3\n".into(), files, init: None };
        Checkpoint { origin, position, tensors, moments }
    }

    #[test]
    fn every_bit_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.safetensors");
        let written = checkpoint();
        write_checkpoint(&path, &written).unwrap();
        write_checkpoint(&path, &written).unwrap();
        let mut read = read_checkpoint(&path, |_| Ok(shapes())).unwrap();
        assert_eq!(read, written);
        assert_eq!(read.position.random.next_u64(), written.position.random.clone().next_u64());
        assert_eq!(read.position.sums[0].to_bits(), written.position.sums[0].to_bits());
    }

    #[test]
    fn what_is_no_checkpoint_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.safetensors");
        let written = checkpoint();
        let bytes = to_bytes(&written).unwrap();
        for broken in [&bytes[..bytes.len() / 2], b"", &written.tensors.to_bytes("")] {
            std::fs::write(&path, broken).unwrap();
            let error = read_checkpoint(&path, |_| Ok(shapes())).unwrap_err();
            assert!(error.to_string().contains("not a complete checkpoint"), "{error}");
        }
    }
}
