//! Errors of weights.

/// Reason why bytes or tensors are not the weights of a network.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WeightsError {
    /// Not a safetensors file; the text holds the reader's message.
    NotSafetensors(String),
    /// Missing or wrong sizes of the network in the metadata.
    BadArchitecture(String),
    /// A tensor is missing.
    Missing(String),
    /// A tensor is not made of `f32`.
    NotF32(String),
    /// A tensor's shape does not match the network's sizes.
    WrongShape {
        /// Name of the tensor.
        name: String,
        /// Required numbers of rows and columns.
        expected: [usize; 2],
        /// Shape in the file.
        found: Vec<usize>,
    },
    /// A tensor has an infinite or NaN entry.
    NotFinite(String),
}

/// Key of the network's sizes in a weights file's metadata.
pub(super) const ARCHITECTURE_KEY: &str = "architecture";

impl std::fmt::Display for WeightsError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotSafetensors(why) => write!(f, "not a safetensors file ({why}): give weights of this program"),
            Self::BadArchitecture(why) => write!(f, "the weights' metadata `{ARCHITECTURE_KEY}` {why}"),
            Self::Missing(name) => write!(f, "the tensor `{name}` is missing: these weights belong to another network"),
            Self::NotF32(name) => write!(f, "the tensor `{name}` is not of type F32: convert the weights"),
            Self::WrongShape { name, expected, found } => {
                write!(f, "the tensor `{name}` has shape {found:?}, the architecture needs {expected:?}")
            }
            Self::NotFinite(name) => write!(f, "the tensor `{name}` has entries that are not finite: train again"),
        }
    }
}

impl std::error::Error for WeightsError {}
