//! Which faces use a vertex.

/// The faces around each vertex as compressed rows.
pub(super) struct FacesAround {
    starts: Vec<u32>,
    rows: Vec<u32>,
}

impl FacesAround {
    /// Sorts `faces` under their `n_vertices` corners.
    pub fn new(n_vertices: usize, faces: &[[u32; 3]]) -> Self {
        let mut starts = vec![0u32; n_vertices + 2];
        faces.as_flattened().iter().for_each(|&v| starts[v as usize + 2] += 1);
        (2..starts.len()).for_each(|v| starts[v] += starts[v - 1]);
        let mut rows = vec![0; 3 * faces.len()];
        for (f, face) in faces.iter().enumerate() {
            for &v in face {
                rows[starts[v as usize + 1] as usize] = f as u32;
                starts[v as usize + 1] += 1;
            }
        }
        Self { starts, rows }
    }

    /// The faces that use `vertex`.
    pub fn faces(&self, vertex: u32) -> &[u32] {
        &self.rows[self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize]
    }
}
