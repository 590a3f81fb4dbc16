//! The weights that ship with the library: embedded as the bytes of their files, parsed when first asked for.
//!
//! How they were trained is in `docs/training.md`; nothing in the code depends on their values.

use super::Weights;
use std::sync::LazyLock;

static DEFAULT: LazyLock<Weights> = LazyLock::new(|| parsed(include_bytes!("../../weights/default.safetensors")));

static PAPER_OPEN: LazyLock<Weights> = LazyLock::new(|| parsed(include_bytes!("../../weights/paper-open.safetensors")));

impl Weights {
    /// The network whose scores steer the closed assembly where the caller gives no weights.
    ///
    /// A small Point Sampler over positions and normals; its other stages are of width 1 and have learned nothing.
    ///
    /// ```
    /// use neural_mesh::model::Weights;
    /// assert_eq!(Weights::shipped_default().architecture().point_sampler_inputs, 6);
    /// ```
    pub fn shipped_default() -> &'static Self {
        &DEFAULT
    }

    /// The network of the paper's sizes, trained on meshes that anyone may use, for the paper's assembly and for clouds of
    /// points where the caller gives no weights.
    ///
    /// ```
    /// use neural_mesh::model::{Architecture, Weights};
    /// assert_eq!(Weights::shipped_paper_open().architecture(), &Architecture::default());
    /// ```
    pub fn shipped_paper_open() -> &'static Self {
        &PAPER_OPEN
    }
}

fn parsed(bytes: &[u8]) -> Weights {
    Weights::from_bytes(bytes).expect("weights that ship are weights")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ships_parses_and_is_small() {
        for (weights, most_parameters) in
            [(Weights::shipped_default(), 2_000), (Weights::shipped_paper_open(), 150_000)]
        {
            assert!(weights.to_bytes().len() < 1_000_000);
            assert!(weights.architecture().n_parameters() < most_parameters);
        }
    }
}
