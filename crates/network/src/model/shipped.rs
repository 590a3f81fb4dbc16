//! The shipped weights, embedded as files and read on first use without a JSON parser.

use super::{Architecture, Network, Weights};
use crate::linalg::Matrix;
use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

const DEFAULT_FILE: &[u8] = include_bytes!("../../weights/default.safetensors");

static DEFAULT: LazyLock<Weights> = LazyLock::new(|| read_shipped(DEFAULT_FILE));

impl Weights {
    /// Returns the default network, whose scores steer the closed assembly.
    ///
    /// Only its Point Sampler, over positions and normals, is trained.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Weights;
    /// assert_eq!(Weights::shipped_default().architecture().point_sampler_inputs, 6);
    /// ```
    pub fn shipped_default() -> &'static Self {
        &DEFAULT
    }
}

pub(super) fn read_shipped(file: &[u8]) -> Weights {
    own_file(file).expect("shipped weights are valid")
}

/// Reads a file in the exact layout of `Weights::to_bytes`; returns `None` for other files.
fn own_file(bytes: &[u8]) -> Option<Weights> {
    let (length, rest) = bytes.split_first_chunk()?;
    let (header, data) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    let (_, text) = str::from_utf8(header).ok()?.split_once(r#""architecture":""#)?;
    let text = text.split('"').next()?;
    let architecture = Architecture::from_text(text).ok()?;
    let (words, []) = data.as_chunks() else { return None };
    if words.len() != architecture.n_parameters() {
        return None;
    }
    let shapes = architecture.shapes();
    let starts = starts(&shapes);
    let tensors = shapes.map(|name, &[n_rows, n_cols]| {
        let words = &words[starts[name]..][..n_rows * n_cols];
        Arc::new(Matrix::new(n_rows, n_cols, words.iter().map(|word| f32::from_le_bytes(*word)).collect()))
    });
    Some(Weights::from_tensors(architecture, tensors).ok()?.with_objective_of(text))
}

/// Returns the index of each tensor's first entry; tensors follow in the order of their names.
fn starts(shapes: &Network<[usize; 2]>) -> BTreeMap<String, usize> {
    let mut sizes = BTreeMap::new();
    shapes.map(|name, [n_rows, n_cols]| sizes.insert(name.to_string(), n_rows * n_cols));
    let mut end = 0;
    for size in sizes.values_mut() {
        end += *size;
        *size = end - *size;
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ships_is_read_and_small() {
        assert!(Weights::shipped_default().architecture().n_parameters() < 2_000);
    }

    #[cfg(feature = "weights")]
    #[test]
    fn what_ships_is_what_the_file_holds_bit_for_bit() {
        assert_eq!(read_shipped(DEFAULT_FILE).to_bytes(), Weights::from_bytes(DEFAULT_FILE).unwrap().to_bytes());
    }

    #[test]
    fn other_files_are_none() {
        let at = DEFAULT_FILE.len() - 4;
        let width = b"edge_predictor_width=";
        let digit = DEFAULT_FILE.windows(width.len()).position(|words| words == width).unwrap() + width.len();
        let mut wider = DEFAULT_FILE.to_vec();
        wider[digit] = b'2';
        let nan = [&DEFAULT_FILE[..at], &f32::NAN.to_le_bytes()].concat();
        for other in [&b""[..], b"12345678", &DEFAULT_FILE[..at], &DEFAULT_FILE[..at + 3], &wider, &nan] {
            assert_eq!(own_file(other), None);
        }
    }
}
