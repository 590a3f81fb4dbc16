//! The shipped weights of the paper's network (60 KB).

use std::sync::LazyLock;

use super::Weights;
use super::shipped::read_shipped;

pub(super) const PAPER_OPEN_FILE: &[u8] = include_bytes!("../../weights/paper-open.safetensors");

static PAPER_OPEN: LazyLock<Weights> = LazyLock::new(|| read_shipped(PAPER_OPEN_FILE));

impl Weights {
    /// Returns the paper's network, trained on freely licensed meshes.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Weights;
    /// assert_eq!(Weights::shipped_paper_open().architecture().face_classifier_width, 32);
    /// ```
    pub fn shipped_paper_open() -> &'static Self {
        &PAPER_OPEN
    }
}

#[doc(hidden)]
pub fn paper_weights() -> Option<&'static Weights> {
    Some(Weights::shipped_paper_open())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ships_is_read_and_small() {
        assert!(Weights::shipped_paper_open().architecture().n_parameters() < 150_000);
    }

    #[cfg(feature = "weights")]
    #[test]
    fn what_ships_is_what_the_file_holds_bit_for_bit() {
        assert_eq!(read_shipped(PAPER_OPEN_FILE).to_bytes(), Weights::from_bytes(PAPER_OPEN_FILE).unwrap().to_bytes());
    }
}
