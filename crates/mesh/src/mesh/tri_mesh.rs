//! The triangle mesh.

/// A triangle mesh with indices in range, finite coordinates and three different corners per face.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::TriMesh;
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
/// assert_eq!(mesh.faces().len(), 1);
/// assert!(TriMesh::new(vec![[0.0; 3]], vec![[0, 0, 1]]).is_err());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
}

/// Reasons why vertices and faces make no [`TriMesh`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum InvalidMesh {
    /// Too many vertices or faces for `u32` indices.
    TooLarge,
    /// A coordinate is not finite.
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A corner is out of range.
    OutOfRange {
        /// Index of the face.
        face: usize,
    },
    /// This face uses a vertex twice.
    RepeatedVertex {
        /// Index of the face.
        face: usize,
    },
}

impl std::fmt::Display for InvalidMesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooLarge => write!(f, "more than {} vertices or faces: split the mesh", u32::MAX / 4),
            Self::NotFinite { vertex } => {
                write!(f, "vertex {vertex} has a coordinate that is not finite: clean the mesh first")
            }
            Self::OutOfRange { face } => {
                write!(f, "face {face} names a vertex that does not exist: clean the mesh first")
            }
            Self::RepeatedVertex { face } => write!(f, "face {face} uses a vertex twice: clean the mesh first"),
        }
    }
}

impl std::error::Error for InvalidMesh {}

impl TriMesh {
    /// Builds a mesh from positions (n_vertices x 3) and faces (n_faces x 3).
    ///
    /// # Errors
    /// [`InvalidMesh`] names the first wrong vertex or face.
    pub fn new(positions: Vec<[f32; 3]>, faces: Vec<[u32; 3]>) -> Result<Self, InvalidMesh> {
        let limit = (u32::MAX / 4) as usize;
        if positions.len() > limit || faces.len() > limit {
            return Err(InvalidMesh::TooLarge);
        }
        if let Some(vertex) = positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(InvalidMesh::NotFinite { vertex });
        }
        if are_sound(&faces, positions.len()) {
            return Ok(Self { positions, faces });
        }
        for (face, &[a, b, c]) in faces.iter().enumerate() {
            if [a, b, c].iter().any(|&v| v as usize >= positions.len()) {
                return Err(InvalidMesh::OutOfRange { face });
            }
            if a == b || b == c || c == a {
                return Err(InvalidMesh::RepeatedVertex { face });
            }
        }
        Ok(Self { positions, faces })
    }

    /// Returns the positions, n_vertices x 3.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Returns the faces' vertex indices, n_faces x 3.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Returns the diagonal of the used vertices' bounding box.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// assert_eq!(neural_mesh::mesh::shapes::cuboid([2.0, 3.0, 6.0], 2).diagonal(), 7.0);
    /// ```
    pub fn diagonal(&self) -> f64 {
        let corners = self.faces.iter().flatten().map(|&v| self.positions[v as usize]);
        let none = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        let (low, high) = corners.fold(none, |(low, high), p| {
            (std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k])))
        });
        let side = |k: usize| (f64::from(high[k]) - f64::from(low[k])).max(0.0);
        side(0).hypot(side(1)).hypot(side(2))
    }

    /// Returns positions and faces.
    pub fn into_parts(self) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        (self.positions, self.faces)
    }
}

/// Returns whether all faces have three different vertices in range.
pub(super) fn are_sound(faces: &[[u32; 3]], n_vertices: usize) -> bool {
    let n_vertices = u32::try_from(n_vertices).unwrap_or(u32::MAX);
    let wrong = |&[a, b, c]: &[u32; 3]| {
        (a >= n_vertices) | (b >= n_vertices) | (c >= n_vertices) | (a == b) | (b == c) | (c == a)
    };
    !faces.iter().fold(false, |any, face| any | wrong(face))
}
