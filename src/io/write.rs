//! What the writers share: a mesh in the coordinates of the file, and numbers with the fewest digits that read back
//! as the same.

use super::WriteError;
use crate::mesh::{Frame, TriMesh};

/// What a writer puts down.
pub(super) struct Content<'a> {
    positions: Positions<'a>,
    /// Vertex indices, n_faces x 3.
    pub faces: &'a [[u32; 3]],
    /// Whether some coordinate needs a double: not all programs read doubles, three.js draws none.
    pub double: bool,
    /// Per axis whether all coordinates are single ones: their shorter text then says all there is.
    pub single: [bool; 3],
}

/// Where the coordinates come from.
enum Positions<'a> {
    /// From the mesh, in the coordinates of the frame.
    Local(&'a [[f32; 3]], Frame),
    /// As given, n_vertices x 3.
    Exact(Vec<[f64; 3]>),
}

impl<'a> Content<'a> {
    /// A mesh in the coordinates of `frame`.
    pub fn of(mesh: &'a TriMesh, frame: &Frame) -> Self {
        let positions = Positions::Local(mesh.positions(), *frame);
        let single = frame.origin.map(|origin| !frame.double || origin == 0.0);
        Self { positions, faces: mesh.faces(), double: single != [true; 3], single }
    }

    /// A mesh with the positions it came with, n_vertices x 3, finite.
    pub fn checked(mesh: &'a TriMesh, positions: Vec<[f64; 3]>) -> Result<Self, WriteError> {
        let finite = positions.iter().flatten().all(|x| x.is_finite());
        if positions.len() != mesh.positions().len() || !finite {
            let what = "there is not one finite position for each vertex: give the mesh's own";
            return Err(WriteError { what: what.into() });
        }
        let double = positions.iter().flatten().any(|&x| f64::from(x as f32) != x);
        Ok(Self { positions: Positions::Exact(positions), faces: mesh.faces(), double, single: [false; 3] })
    }

    /// Number of vertices.
    pub fn n_vertices(&self) -> usize {
        match &self.positions {
            Positions::Local(positions, _) => positions.len(),
            Positions::Exact(positions) => positions.len(),
        }
    }

    /// Where a vertex lies, in the file's coordinates.
    pub fn position(&self, vertex: usize) -> [f64; 3] {
        match &self.positions {
            Positions::Local(positions, frame) => frame.to_file(positions[vertex]),
            Positions::Exact(positions) => positions[vertex],
        }
    }

    /// Positions in single precision, n_vertices x 3, and the point in the file's coordinates around which they lie.
    #[cfg(feature = "gltf")]
    pub fn around_origin(&self) -> ([f64; 3], Vec<[f32; 3]>) {
        let origin = match &self.positions {
            Positions::Local(_, frame) if frame.double => frame.origin,
            Positions::Local(..) => [0.0; 3],
            Positions::Exact(positions) if positions.iter().flatten().all(|&x| f64::from(x as f32) == x) => [0.0; 3],
            Positions::Exact(positions) => positions.first().copied().unwrap_or_default(),
        };
        let local = |vertex| {
            let position = self.position(vertex);
            std::array::from_fn(|axis| (position[axis] - origin[axis]) as f32)
        };
        (origin, (0..self.n_vertices()).map(local).collect())
    }

    /// Appends the coordinates of a vertex, separated by blanks.
    pub fn push_position(&self, out: &mut Vec<u8>, vertex: usize) {
        let mut digits = zmij::Buffer::new();
        for (axis, x) in self.position(vertex).into_iter().enumerate() {
            if axis > 0 {
                out.push(b' ');
            }
            let text = if self.single[axis] { digits.format_finite(x as f32) } else { digits.format_finite(x) };
            out.extend(without_point(text).as_bytes());
        }
    }
}

/// Appends numbers, separated by blanks.
pub(super) fn push_singles(out: &mut Vec<u8>, numbers: &[f32]) {
    for (axis, &x) in numbers.iter().enumerate() {
        if axis > 0 {
            out.push(b' ');
        }
        push_single(out, x);
    }
}

/// Appends a number.
pub(super) fn push_single(out: &mut Vec<u8>, x: f32) {
    out.extend(without_point(zmij::Buffer::new().format(x)).as_bytes());
}

/// Whole numbers need no decimal point.
fn without_point(text: &str) -> &str {
    text.strip_suffix(".0").unwrap_or(text)
}

/// Appends one line per vertex, then one per face, as OFF and the text of PLY have them.
pub(super) fn push_rows(out: &mut Vec<u8>, content: &Content) {
    for vertex in 0..content.n_vertices() {
        content.push_position(out, vertex);
        out.push(b'\n');
    }
    push_faces(out, content.faces);
}

/// Appends one line per face: 3 and the three vertex indices.
fn push_faces(out: &mut Vec<u8>, faces: &[[u32; 3]]) {
    let mut digits = itoa::Buffer::new();
    for face in faces {
        out.push(b'3');
        for &vertex in face {
            out.push(b' ');
            out.extend(digits.format(vertex).as_bytes());
        }
        out.push(b'\n');
    }
}
