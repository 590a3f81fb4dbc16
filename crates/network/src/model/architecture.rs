//! Sizes of the paper's network.

use super::{Affine, DevConv, EdgePredictor, FaceClassifier, Network, PointSampler, SparseAttention, TriConv};

/// Numbers of layers, widths and neighbours of the paper's network; the default is that of the shipped weights.
///
/// The paper states only the number of layers (three), of a sample's neighbours (15) and of a triangle's (20).
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::model::Architecture;
/// let sizes = Architecture::default();
/// assert_eq!((sizes.edge_knn, sizes.face_classifier_width), (15, 32));
/// assert_eq!(sizes.n_parameters(), 14_658);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Architecture {
    /// Inputs of the Point Sampler per vertex: 3 for the position (the paper), 6 with the normal.
    pub point_sampler_inputs: usize,
    /// DevConv layers of the Point Sampler.
    pub point_sampler_layers: usize,
    /// Width of the Point Sampler's layers.
    pub point_sampler_width: usize,
    /// Width of the Point Sampler's hidden layer before the score; 0 (the paper) for none.
    pub point_sampler_hidden: usize,
    /// Width of the Edge Predictor's DevConv.
    pub edge_predictor_width: usize,
    /// Width of the Edge Predictor's queries and keys.
    pub attention_width: usize,
    /// Number of nearest samples that G_ext joins with each sample.
    pub edge_knn: usize,
    /// TriConv layers of the Face Classifier.
    pub face_classifier_layers: usize,
    /// Width of the Face Classifier's layers.
    pub face_classifier_width: usize,
    /// Number of candidate faces per sample, chosen by largest prior; 0 (the paper) keeps all.
    pub face_candidates: usize,
    /// Number of nearest triangles joined with each triangle, 20 in the paper; 0 joins triangles that share an edge.
    pub face_knn: usize,
}

impl Default for Architecture {
    fn default() -> Self {
        Self {
            point_sampler_inputs: 3,
            point_sampler_layers: 3,
            point_sampler_width: 32,
            point_sampler_hidden: 0,
            edge_predictor_width: 32,
            attention_width: 32,
            edge_knn: 15,
            face_classifier_layers: 3,
            face_classifier_width: 32,
            face_candidates: 6,
            face_knn: 0,
        }
    }
}

#[cfg(any(test, feature = "test-support"))]
impl Architecture {
    #[doc(hidden)]
    pub const TINY: Self = Self {
        point_sampler_inputs: 6,
        point_sampler_layers: 2,
        point_sampler_width: 5,
        point_sampler_hidden: 4,
        edge_predictor_width: 5,
        attention_width: 4,
        edge_knn: 4,
        face_classifier_layers: 2,
        face_classifier_width: 5,
        face_candidates: 0,
        face_knn: 3,
    };

    #[doc(hidden)]
    pub fn narrow() -> Self {
        Self {
            point_sampler_width: 16,
            edge_predictor_width: 16,
            attention_width: 8,
            edge_knn: 8,
            face_classifier_width: 16,
            face_knn: 8,
            ..Self::default()
        }
    }
}

/// Names of the sizes that a weights file may omit.
const NOT_IN_THE_PAPER: [&str; 3] = ["point_sampler_inputs", "point_sampler_hidden", "face_candidates"];

/// Largest value of a size in a weights file.
const MAX_SIZE: usize = 1024;

impl Architecture {
    /// Returns the shapes of all tensors.
    pub fn shapes(&self) -> Network<[usize; 2]> {
        let width = self.point_sampler_width;
        let n_in = |i: usize| if i == 0 { self.point_sampler_inputs } else { width };
        let dev_convs = (0..self.point_sampler_layers).map(|i| DevConv::shape(n_in(i), width)).collect();
        let (hidden, last) = match self.point_sampler_hidden {
            0 => (None, width),
            hidden => (Some(Affine::shape(width, hidden)), hidden),
        };
        let attention = [self.edge_predictor_width, self.attention_width];
        let face_width = self.face_classifier_width;
        let tri_convs =
            (0..self.face_classifier_layers).map(|i| TriConv::shape(if i == 0 { 1 } else { face_width }, face_width));
        Network {
            point_sampler: PointSampler { dev_convs, hidden, score: Affine::shape(last, 1) },
            edge_predictor: EdgePredictor {
                dev_conv: DevConv::shape(3, self.edge_predictor_width),
                attention: SparseAttention { query: attention, key: attention },
            },
            face_classifier: FaceClassifier { tri_convs: tri_convs.collect(), output: Affine::shape(face_width, 1) },
        }
    }

    /// Returns the number of weights.
    pub fn n_parameters(&self) -> usize {
        let mut sum = 0;
        self.shapes().map(|_, [n_rows, n_cols]| sum += n_rows * n_cols);
        sum
    }

    /// Reads `name=size` words from a weights file.
    ///
    /// # Errors
    /// A description of the size that is missing, repeated or out of range.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Architecture;
    /// let text = Architecture::default().sizes().map(|(name, size)| format!("{name}={size}")).join(" ");
    /// assert_eq!(Architecture::from_text(&text), Ok(Architecture::default()));
    /// assert!(Architecture::from_text("edge_knn=15").is_err());
    /// ```
    pub fn from_text(text: &str) -> Result<Self, String> {
        let mut sizes = Self::default();
        for (name, size) in sizes.fields() {
            let words = || text.split_whitespace().filter_map(|word| word.split_once('='));
            let mut values = words().filter(|(n, _)| *n == name);
            if NOT_IN_THE_PAPER.contains(&name) && values.clone().next().is_none() {
                continue;
            }
            let (Some((_, value)), None) = (values.next(), values.next()) else {
                return Err(format!("must state `{name}` once"));
            };
            *size = value
                .parse()
                .ok()
                .filter(|&size| is_size(name, size))
                .ok_or(format!("`{name}={value}` is not an allowed size"))?;
        }
        Ok(sizes)
    }

    /// Returns the name and value of the first size out of range.
    pub fn bad_size(self) -> Option<(&'static str, usize)> {
        self.sizes().into_iter().find(|&(name, size)| !is_size(name, size))
    }

    /// Returns all sizes with their names.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// use neural_mesh::model::Architecture;
    /// assert!(Architecture::default().sizes().contains(&("edge_knn", 15)));
    /// ```
    pub fn sizes(mut self) -> [(&'static str, usize); 11] {
        self.fields().map(|(name, size)| (name, *size))
    }

    /// Returns all sizes, to be changed, with their names.
    #[doc(hidden)]
    pub fn fields(&mut self) -> [(&'static str, &mut usize); 11] {
        [
            ("point_sampler_inputs", &mut self.point_sampler_inputs),
            ("point_sampler_layers", &mut self.point_sampler_layers),
            ("point_sampler_width", &mut self.point_sampler_width),
            ("point_sampler_hidden", &mut self.point_sampler_hidden),
            ("edge_predictor_width", &mut self.edge_predictor_width),
            ("attention_width", &mut self.attention_width),
            ("edge_knn", &mut self.edge_knn),
            ("face_classifier_layers", &mut self.face_classifier_layers),
            ("face_classifier_width", &mut self.face_classifier_width),
            ("face_candidates", &mut self.face_candidates),
            ("face_knn", &mut self.face_knn),
        ]
    }
}

fn is_size(name: &str, size: usize) -> bool {
    match name {
        "point_sampler_inputs" => size == 3 || size == 6,
        "point_sampler_hidden" | "face_candidates" | "face_knn" => size <= MAX_SIZE,
        _ => (1..=MAX_SIZE).contains(&size),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_read_and_bad_text_is_named() {
        let sizes = Architecture { edge_knn: 7, ..Architecture::default() };
        let text = sizes.sizes().map(|(name, size)| format!("{name}={size}")).join(" ");
        assert_eq!(Architecture::from_text(&text), Ok(sizes));
        assert!(Architecture::from_text(&text.replace("edge_knn=7", "")).unwrap_err().contains("edge_knn"));
        for bad in ["edge_knn=0", "edge_knn=99999999999", "edge_knn=-1", "edge_knn=7 edge_knn=8"] {
            assert!(Architecture::from_text(&text.replace("edge_knn=7", bad)).unwrap_err().contains("edge_knn"));
        }
    }
}
