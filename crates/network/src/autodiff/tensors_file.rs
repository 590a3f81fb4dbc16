//! Tensors in safetensors files.

use super::weights_error::ARCHITECTURE_KEY;
use super::{Tensors, WeightsError};
use crate::linalg::Matrix;
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use std::collections::HashMap;
use std::sync::Arc;

/// Returns the text that states the network's sizes in a weights file.
///
/// # Errors
/// [`WeightsError`] if the bytes are no safetensors file or lack the text.
pub fn architecture_text(bytes: &[u8]) -> Result<String, WeightsError> {
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(not_safetensors)?;
    let text = metadata.metadata().as_ref().and_then(|entries| entries.get(ARCHITECTURE_KEY));
    text.cloned().ok_or(WeightsError::BadArchitecture("is missing: another program wrote them".into()))
}

impl Tensors<Arc<Matrix>> {
    /// Reads the tensors of a network with these shapes, in their order, ignoring others.
    ///
    /// # Errors
    /// [`WeightsError`] names the first fault.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::autodiff::{Tensors, architecture_text};
    /// let shapes: Tensors<[usize; 2]> = [("weights", [2, 3])].into_iter().collect();
    /// let tensors = shapes.draw(1);
    /// let bytes = tensors.to_bytes("width=3");
    /// assert_eq!(architecture_text(&bytes).unwrap(), "width=3");
    /// assert_eq!(Tensors::from_bytes(&bytes, &shapes), Ok(tensors));
    /// ```
    pub fn from_bytes(bytes: &[u8], shapes: &Tensors<[usize; 2]>) -> Result<Self, WeightsError> {
        let file = SafeTensors::deserialize(bytes).map_err(not_safetensors)?;
        shapes.try_map(|name, &shape| read_tensor(&file, name, shape))?.check_shapes(shapes)
    }

    /// Writes a safetensors file of `f32` tensors; equal tensors give equal bytes in any order.
    pub fn to_bytes(&self, architecture: &str) -> Vec<u8> {
        let data = |matrix: &Matrix| matrix.data().iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let parts = self.map(|_, matrix| (matrix.shape(), data(matrix)));
        let views = parts.iter().map(|(name, (shape, bytes))| {
            let view = TensorView::new(Dtype::F32, shape.to_vec(), bytes).expect("as many bytes as the shape says");
            (name, view)
        });
        let metadata = HashMap::from([(ARCHITECTURE_KEY.to_string(), architecture.to_string())]);
        serialize(views, Some(metadata)).expect("tensors that fit their shapes")
    }
}

fn read_tensor(file: &SafeTensors, name: &str, expected: [usize; 2]) -> Result<Arc<Matrix>, WeightsError> {
    let tensor = file.tensor(name).map_err(|_| WeightsError::Missing(name.into()))?;
    if tensor.dtype() != Dtype::F32 {
        return Err(WeightsError::NotF32(name.into()));
    }
    if tensor.shape() != expected {
        return Err(WeightsError::WrongShape { name: name.into(), expected, found: tensor.shape().to_vec() });
    }
    let (words, _) = tensor.data().as_chunks();
    let entries = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
    Ok(Arc::new(Matrix::new(expected[0], expected[1], entries)))
}

fn not_safetensors(error: safetensors::SafeTensorError) -> WeightsError {
    WeightsError::NotSafetensors(error.to_string())
}
