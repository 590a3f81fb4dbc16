//! Common parts of the writers: a mesh in file coordinates, and numbers in their shortest text.
//!
//! Singles get the fewest digits that read back as the same single; far from the origin and for thin faces, all digits.

use super::{WriteError, number};
use crate::mesh::{Frame, TriMesh, has_area};
use crate::parallel;

// From 2^24 on, the shortest text of a whole number has other digits.
const WHOLE: f32 = 16_777_216.0;
/// Distance from the origin, in diagonals, beyond which the fewest digits err by more than a millionth of the diagonal.
const FAR: f64 = 32.0;
const ROUNDING: f64 = 1.2e-7;
/// Faces that a thread looks at together.
const BLOCK: usize = 1 << 14;

pub(super) struct Content<'a> {
    positions: Positions<'a>,
    pub faces: &'a [[u32; 3]],
    // True if a coordinate needs double precision, which some programs do not read (three.js).
    pub double: bool,
    // Per axis, true if all coordinates are singles, so that their shorter text loses nothing.
    pub single: [bool; 3],
}

enum Positions<'a> {
    // Exact position of each vertex if present, else that of the mesh, moved by the frame.
    Mixed(&'a [[f32; 3]], Frame, Vec<Option<[f64; 3]>>),
    Exact(Vec<[f64; 3]>),
}

impl<'a> Content<'a> {
    pub fn from_mesh(mesh: &'a TriMesh, frame: &Frame) -> Self {
        let positions = Positions::Mixed(mesh.positions(), *frame, Vec::new());
        let single = frame.origin.map(|origin| !frame.double || origin == 0.0);
        Self { positions, faces: mesh.faces(), double: single != [true; 3], single }
    }

    pub fn from_positions(mesh: &'a TriMesh, positions: Vec<[f64; 3]>) -> Result<Self, WriteError> {
        // Exact positions come from callers, so they are checked; those of a mesh are finite.
        let finite = positions.iter().flatten().all(|x| x.is_finite());
        if positions.len() != mesh.positions().len() || !finite {
            return Err(WriteError::new("positions: give one finite position for each vertex"));
        }
        let double = positions.iter().flatten().any(|&x| is_double(x));
        Ok(Self { positions: Positions::Exact(positions), faces: mesh.faces(), double, single: [false; 3] })
    }

    pub fn from_mixed_positions(
        mesh: &'a TriMesh,
        frame: &Frame,
        kept: Vec<Option<[f64; 3]>>,
    ) -> Result<Self, WriteError> {
        if kept.len() != mesh.positions().len() || !kept.iter().flatten().flatten().all(|x| x.is_finite()) {
            return Err(WriteError::new("exact positions: give one finite position or none for each vertex"));
        }
        // Doubles are needed if either the frame or an exact position needs them.
        let bare = Self::from_mesh(mesh, frame);
        let double = bare.double || kept.iter().flatten().flatten().any(|&x| is_double(x));
        Ok(Self { positions: Positions::Mixed(mesh.positions(), *frame, kept), double, ..bare })
    }

    pub fn n_vertices(&self) -> usize {
        match &self.positions {
            Positions::Mixed(positions, ..) => positions.len(),
            Positions::Exact(positions) => positions.len(),
        }
    }

    fn exact_position(&self, vertex: usize) -> Option<[f64; 3]> {
        match &self.positions {
            Positions::Mixed(_, _, exact) => exact.get(vertex).copied().flatten(),
            Positions::Exact(positions) => Some(positions[vertex]),
        }
    }

    pub fn identity(&self, vertex: usize) -> [u64; 3] {
        match &self.positions {
            Positions::Mixed(positions, ..) => positions[vertex].map(|x| u64::from((x + 0.0).to_bits())),
            Positions::Exact(positions) => positions[vertex].map(|x| (x + 0.0).to_bits()),
        }
    }

    pub fn has_area(&self, face: [u32; 3]) -> bool {
        let has_given_area = || has_area(face.map(|vertex| self.position(vertex as usize)));
        let is_given = || face.iter().all(|&vertex| self.exact_position(vertex as usize).is_some());
        match &self.positions {
            Positions::Mixed(local, ..) => {
                has_area(face.map(|vertex| local[vertex as usize].map(f64::from))) && (!is_given() || has_given_area())
            }
            Positions::Exact(_) => has_given_area(),
        }
    }

    /// Returns whether the file may have other positions than the mesh.
    pub fn is_rounded(&self) -> bool {
        match &self.positions {
            Positions::Mixed(_, frame, exact) => !exact.is_empty() || frame.origin != [0.0; 3],
            Positions::Exact(_) => true,
        }
    }

    // All digits are needed far from the origin, and if fewer would flatten a face.
    pub fn with_needed_digits(self) -> Self {
        let (low, high) = self.bounds();
        let diagonal = diagonal(low, high);
        let is_near = |axis: usize| low[axis].abs().max(high[axis].abs()) <= FAR * diagonal;
        // Distance is tested first, since it is cheap; areas need every face.
        let near = Self { single: std::array::from_fn(|axis| self.single[axis] && is_near(axis)), ..self };
        let loses_area = |face: usize| near.loses_area(&near.faces[face]);
        if near.single == [false; 3] || !parallel::any(near.faces.len(), BLOCK, loses_area) {
            return near;
        }
        Self { single: [false; 3], ..near }
    }

    pub fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds();
        diagonal(low, high)
    }

    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let all = (0..self.n_vertices()).map(|vertex| self.position(vertex));
        all.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), p| {
            (std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k])))
        })
    }

    // Readers that take the text as doubles may flatten a face.
    fn loses_area(&self, face: &[u32; 3]) -> bool {
        let corners = face.map(|vertex| self.position(vertex as usize));
        is_nearly_flat(corners) && has_area(corners) && !has_area(face.map(|vertex| self.read_back(vertex as usize)))
    }

    fn read_back(&self, vertex: usize) -> [f64; 3] {
        let mut digits = zmij::Buffer::new();
        let position = self.position(vertex);
        std::array::from_fn(|axis| {
            // Only coordinates that the writer shortens can change.
            let is_short = self.single[axis] && self.exact_position(vertex).is_none();
            let short = || number::parse(format_single(&mut digits, position[axis] as f32).as_bytes());
            is_short.then(short).flatten().map_or(position[axis], |number| number.value)
        })
    }

    pub fn position(&self, vertex: usize) -> [f64; 3] {
        match &self.positions {
            Positions::Mixed(positions, frame, exact) => {
                exact.get(vertex).copied().flatten().unwrap_or_else(|| frame.to_file(positions[vertex]))
            }
            Positions::Exact(positions) => positions[vertex],
        }
    }

    /// Returns a local origin and positions relative to it, n_vertices x 3.
    pub fn local_positions(&self) -> ([f64; 3], Vec<[f32; 3]>) {
        let origin = match &self.positions {
            // A frame of doubles has its origin; positions that are all singles need none; others take their first
            // vertex.
            Positions::Mixed(_, frame, _) if frame.double => frame.origin,
            Positions::Mixed(..) => [0.0; 3],
            Positions::Exact(positions) if !positions.iter().flatten().any(|&x| is_double(x)) => [0.0; 3],
            Positions::Exact(positions) => positions.first().copied().unwrap_or_default(),
        };
        let local = |vertex| {
            let position = self.position(vertex);
            std::array::from_fn(|axis| (position[axis] - origin[axis]) as f32)
        };
        (origin, (0..self.n_vertices()).map(local).collect())
    }

    pub fn push_position(&self, out: &mut Vec<u8>, vertex: usize) {
        let mut digits = zmij::Buffer::new();
        let is_given = self.exact_position(vertex).is_some();
        for (axis, x) in self.position(vertex).into_iter().enumerate() {
            if axis > 0 {
                out.push(b' ');
            }
            let is_short = self.single[axis] && !is_given;
            let text = if is_short { format_single(&mut digits, x as f32) } else { digits.format_finite(x) };
            out.extend(strip_point(text).as_bytes());
        }
    }
}

fn diagonal(low: [f64; 3], high: [f64; 3]) -> f64 {
    let side = |axis: usize| high[axis] - low[axis];
    side(0).hypot(side(1)).hypot(side(2))
}

fn is_double(x: f64) -> bool {
    f64::from(x as f32) != x
}

fn is_nearly_flat([a, b, c]: [[f64; 3]; 3]) -> bool {
    // The bound adds the rounding of both edges, each up to `ROUNDING * reach`, to the cross product.
    let (a, b, c) = (glam::DVec3::from(a), glam::DVec3::from(b), glam::DVec3::from(c));
    let (u, v) = (b - a, c - a);
    let reach = a.abs().max(b.abs()).max(c.abs()).max_element();
    let most = 4.0 * ROUNDING * reach * (u.abs().max_element() + v.abs().max_element() + ROUNDING * reach);
    u.cross(v).abs().max_element() <= most
}

fn format_single(digits: &mut zmij::Buffer, x: f32) -> &str {
    if x.abs() < WHOLE { digits.format_finite(x) } else { digits.format_finite(f64::from(x)) }
}

pub(super) fn push_singles(out: &mut Vec<u8>, numbers: &[f32]) {
    for (axis, &x) in numbers.iter().enumerate() {
        if axis > 0 {
            out.push(b' ');
        }
        push_single(out, x);
    }
}

pub(super) fn push_single(out: &mut Vec<u8>, x: f32) {
    out.extend(strip_point(zmij::Buffer::new().format(x)).as_bytes());
}

fn strip_point(text: &str) -> &str {
    text.strip_suffix(".0").unwrap_or(text)
}
