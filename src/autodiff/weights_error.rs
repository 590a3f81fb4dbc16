//! Why bytes or tensors are not the weights of a network.

/// Why bytes are not weights.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WeightsError {
    /// Not a safetensors file; the text says where it fails.
    NotSafetensors(String),
    /// The metadata do not state the sizes of the network; the text says what is wrong.
    BadArchitecture(String),
    /// A tensor is missing.
    Missing(String),
    /// A tensor is not made of `f32`.
    NotF32(String),
    /// A tensor has another shape than the sizes ask for.
    WrongShape {
        /// Name of the tensor.
        name: String,
        /// Rows and columns asked for.
        expected: [usize; 2],
        /// The shape in the file.
        found: Vec<usize>,
    },
    /// A tensor holds an infinite entry or one that is not a number.
    NotFinite(String),
}

/// The entry of a file's metadata that states the sizes.
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
