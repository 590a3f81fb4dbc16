//! What the writers share: a mesh in the coordinates of the file, and numbers with the fewest digits that read back
//! as the same.
//!
//! Coordinates of a mesh in single precision have in text the fewest digits that read back as the same single, as such
//! files come with. A reader in doubles then sees another number, by half of the last bit at most. Where that matters,
//! [`Content::in_decimals`] has all digits written: far from the origin, and where a face would lose its area.

use rayon::prelude::*;

use super::{WriteError, number};
use crate::mesh::{Frame, TriMesh, has_area};

/// Whole numbers from here on have digits of their own: the fewest that read back would be other ones and no fewer.
const WHOLE: f32 = 16_777_216.0;
/// How many diagonals from the origin on the rounding to the fewest digits is more than a millionth of the diagonal.
const FAR: f64 = 32.0;
/// Rounding of a coordinate to the fewest digits, as its share, generously.
const ROUNDING: f64 = 1.2e-7;

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
    /// As given where they are, else from the mesh; n_vertices.
    Kept(&'a [[f32; 3]], Frame, Vec<Option<[f64; 3]>>),
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
        let double = positions.iter().flatten().any(|&x| is_double(x));
        Ok(Self { positions: Positions::Exact(positions), faces: mesh.faces(), double, single: [false; 3] })
    }

    /// A mesh in the coordinates of `frame`, some of whose vertices have the positions that they came with; n_vertices.
    pub fn keeping(mesh: &'a TriMesh, frame: &Frame, kept: Vec<Option<[f64; 3]>>) -> Result<Self, WriteError> {
        if kept.len() != mesh.positions().len() || !kept.iter().flatten().flatten().all(|x| x.is_finite()) {
            let what = "the positions that stay are not one or none for each vertex, finite: give the mesh's own";
            return Err(WriteError { what: what.into() });
        }
        let bare = Self::of(mesh, frame);
        let double = bare.double || kept.iter().flatten().flatten().any(|&x| is_double(x));
        Ok(Self { positions: Positions::Kept(mesh.positions(), *frame, kept), double, ..bare })
    }

    /// Number of vertices.
    pub fn n_vertices(&self) -> usize {
        match &self.positions {
            Positions::Local(positions, _) | Positions::Kept(positions, ..) => positions.len(),
            Positions::Exact(positions) => positions.len(),
        }
    }

    /// The position that a vertex was given, where it was.
    fn given(&self, vertex: usize) -> Option<[f64; 3]> {
        match &self.positions {
            Positions::Local(..) => None,
            Positions::Kept(_, _, kept) => kept[vertex],
            Positions::Exact(positions) => Some(positions[vertex]),
        }
    }

    /// What of a vertex tells it from others, whatever becomes of it in the file.
    pub fn identity(&self, vertex: usize) -> [u64; 3] {
        match &self.positions {
            Positions::Local(positions, _) | Positions::Kept(positions, ..) => {
                positions[vertex].map(|x| u64::from((x + 0.0).to_bits()))
            }
            Positions::Exact(positions) => positions[vertex].map(|x| (x + 0.0).to_bits()),
        }
    }

    /// Whether a face has an area, whatever becomes of it in the file: that of the mesh, and of what was given.
    pub fn has_area(&self, face: [u32; 3]) -> bool {
        let has_given_area = || has_area(face.map(|vertex| self.position(vertex as usize)));
        let is_given = || face.iter().all(|&vertex| self.given(vertex as usize).is_some());
        match &self.positions {
            Positions::Local(local, _) => has_area(face.map(|vertex| local[vertex as usize].map(f64::from))),
            Positions::Kept(local, ..) => {
                has_area(face.map(|vertex| local[vertex as usize].map(f64::from))) && (!is_given() || has_given_area())
            }
            Positions::Exact(_) => has_given_area(),
        }
    }

    /// Whether the file can hold the positions otherwise than they are: sums with an origin, or those that were given.
    pub fn is_rounded(&self) -> bool {
        match &self.positions {
            Positions::Local(_, frame) => frame.origin != [0.0; 3],
            _ => true,
        }
    }

    /// The same for a text whose readers may take it as doubles: with all digits along the axes on which the mesh lies far
    /// out, and along all of them where fewer would take the area of a face.
    pub fn in_decimals(self) -> Self {
        let (low, high) = self.bounds();
        let diagonal = diagonal(low, high);
        let is_near = |axis: usize| low[axis].abs().max(high[axis].abs()) <= FAR * diagonal;
        let near = Self { single: std::array::from_fn(|axis| self.single[axis] && is_near(axis)), ..self };
        if near.single == [false; 3] || !near.faces.par_iter().any(|face| near.loses_area(face)) {
            return near;
        }
        Self { single: [false; 3], ..near }
    }

    /// The diagonal of the box around all vertices.
    pub fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds();
        diagonal(low, high)
    }

    /// The corners of the box around all vertices.
    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let all = (0..self.n_vertices()).map(|vertex| self.position(vertex));
        all.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), p| {
            (std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k])))
        })
    }

    /// Whether a face with an area has none where its corners are read as doubles.
    fn loses_area(&self, face: &[u32; 3]) -> bool {
        let corners = face.map(|vertex| self.position(vertex as usize));
        is_nearly_flat(corners) && has_area(corners) && !has_area(face.map(|vertex| self.read_back(vertex as usize)))
    }

    /// A position as a reader in doubles has it from the text.
    fn read_back(&self, vertex: usize) -> [f64; 3] {
        let mut digits = zmij::Buffer::new();
        let position = self.position(vertex);
        std::array::from_fn(|axis| {
            let is_short = self.single[axis] && self.given(vertex).is_none();
            let short = || number::parse(text_of_single(&mut digits, position[axis] as f32).as_bytes());
            is_short.then(short).flatten().map_or(position[axis], |number| number.value)
        })
    }

    /// Where a vertex lies, in the file's coordinates.
    pub fn position(&self, vertex: usize) -> [f64; 3] {
        match &self.positions {
            Positions::Local(positions, frame) => frame.to_file(positions[vertex]),
            Positions::Kept(positions, frame, kept) => kept[vertex].unwrap_or_else(|| frame.to_file(positions[vertex])),
            Positions::Exact(positions) => positions[vertex],
        }
    }

    /// Positions in single precision, n_vertices x 3, and the point in the file's coordinates around which they lie.
    pub fn around_origin(&self) -> ([f64; 3], Vec<[f32; 3]>) {
        let origin = match &self.positions {
            Positions::Local(_, frame) | Positions::Kept(_, frame, _) if frame.double => frame.origin,
            Positions::Local(..) | Positions::Kept(..) => [0.0; 3],
            Positions::Exact(positions) if !positions.iter().flatten().any(|&x| is_double(x)) => [0.0; 3],
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
        let is_given = self.given(vertex).is_some();
        for (axis, x) in self.position(vertex).into_iter().enumerate() {
            if axis > 0 {
                out.push(b' ');
            }
            let is_short = self.single[axis] && !is_given;
            let text = if is_short { text_of_single(&mut digits, x as f32) } else { digits.format_finite(x) };
            out.extend(without_point(text).as_bytes());
        }
    }
}

/// That of a box.
fn diagonal(low: [f64; 3], high: [f64; 3]) -> f64 {
    let side = |axis: usize| high[axis] - low[axis];
    side(0).hypot(side(1)).hypot(side(2))
}

/// Whether a single holds the number only in part.
fn is_double(x: f64) -> bool {
    f64::from(x as f32) != x
}

/// Whether the rounding to fewer digits may take the area of a triangle.
fn is_nearly_flat([a, b, c]: [[f64; 3]; 3]) -> bool {
    let (a, b, c) = (glam::DVec3::from(a), glam::DVec3::from(b), glam::DVec3::from(c));
    let (u, v) = (b - a, c - a);
    let reach = a.abs().max(b.abs()).max(c.abs()).max_element();
    let most = 4.0 * ROUNDING * reach * (u.abs().max_element() + v.abs().max_element() + ROUNDING * reach);
    u.cross(v).abs().max_element() <= most
}

/// The fewest digits that read back as the same single; whole numbers have their own.
fn text_of_single(digits: &mut zmij::Buffer, x: f32) -> &str {
    if x.abs() < WHOLE { digits.format_finite(x) } else { digits.format_finite(f64::from(x)) }
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
