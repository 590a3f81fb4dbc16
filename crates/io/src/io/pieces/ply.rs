//! Reading of binary PLY files as streams.

use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::{Pieces, PiecesKind, PositionReceiver, number, read_beginning, unreadable};
use crate::io::ply::header::{Element, Encoding, Header, PlyProperty};
use crate::io::{ReadError, Scalar};

const LONGEST_HEADER: u64 = 1 << 20;
const RUN: usize = 1 << 16;
// A polygon with more corners is taken as damage of the file.
const MOST_CORNERS: usize = 1 << 20;

#[derive(Debug)]
pub struct PlyLayout {
    big: bool,
    body: u64,
    n_vertices: u64,
    stride: usize,
    axes: [(usize, Scalar); 3],
    faces: Element,
    corners: usize,
}

pub fn open_pieces(path: &Path) -> Result<Option<Pieces>, ReadError> {
    // The header of a mesh is not longer than this.
    let header = Header::parse(&read_beginning(path, LONGEST_HEADER)?)?;
    let big = match header.encoding {
        Encoding::Text => return Ok(None),
        encoding => encoding == Encoding::BigEndian,
    };
    // Other tables, or another order, are left to the reader of whole files.
    let [vertices, faces] = &header.elements[..] else { return Ok(None) };
    // Vertices of fixed length can be skipped without reading them.
    let (Some((offsets, stride)), Some(corners)) = (vertices.layout(), faces.list(&["vertex_indices", "vertex_index"]))
    else {
        return Ok(None);
    };
    if vertices.name != "vertex" || faces.name != "face" {
        return Ok(None);
    }
    let axis = |name: &str| vertices.scalar(name).map(|at| (offsets[at], vertices.properties[at].scalar));
    let axes = [axis("x")?, axis("y")?, axis("z")?];
    let of_vertices =
        vertices.properties.iter().map(|it| &it.name).filter(|name| !["x", "y", "z"].contains(&name.as_str()));
    let of_faces = faces.properties.iter().enumerate().filter(|(at, _)| *at != corners).map(|(_, it)| &it.name);
    let others: Vec<&str> = of_vertices.chain(of_faces).map(String::as_str).collect();
    let other_content = (!others.is_empty()).then(|| others.join(", "));
    let is_double = axes.iter().any(|(_, scalar)| scalar.is_wide());
    let (n_vertices, n_faces, faces) = (vertices.count as u64, faces.count as u64, faces.clone());
    let kind = PiecesKind::Ply(PlyLayout { big, body: header.body as u64, n_vertices, stride, axes, faces, corners });
    Ok(Some(Pieces { path: path.into(), kind, n_vertices, n_faces, is_double, other_content }))
}

impl PlyLayout {
    pub fn each_position<R: Read + Seek>(
        &self,
        mut file: BufReader<R>,
        take: &mut PositionReceiver,
    ) -> Result<(), ReadError> {
        file.seek(SeekFrom::Start(self.body)).map_err(|error| unreadable(&error))?;
        // Few large reads are faster; a single vertex may still exceed the run.
        let n_at_once = (RUN / self.stride).max(1);
        let mut rows = vec![0; self.stride * n_at_once];
        let mut left = usize::try_from(self.n_vertices).unwrap_or(usize::MAX);
        while left > 0 {
            let n = left.min(n_at_once);
            let rows = &mut rows[..self.stride * n];
            file.read_exact(rows).map_err(|error| unreadable(&error))?;
            for row in rows.chunks_exact(self.stride) {
                take(self.position(row)?);
            }
            left -= n;
        }
        Ok(())
    }

    fn position(&self, row: &[u8]) -> Result<[f64; 3], ReadError> {
        let mut position = [0.0; 3];
        for (x, (at, scalar)) in position.iter_mut().zip(&self.axes) {
            // The usual type has a path of its own, as this runs for every coordinate.
            *x = match (scalar, self.big, row[*at..].first_chunk()) {
                (Scalar::F32, false, Some(bytes)) => f64::from(f32::from_le_bytes(*bytes)),
                _ => number(*scalar, &row[*at..], self.big)?,
            };
        }
        Ok(position)
    }

    pub fn each_face<R: Read + Seek>(
        &self,
        mut file: BufReader<R>,
        take: &mut dyn FnMut(&[i64]),
    ) -> Result<(), ReadError> {
        // Faces begin right after the vertices, so these are not read again.
        let start = self.n_vertices.saturating_mul(self.stride as u64).saturating_add(self.body);
        file.seek(SeekFrom::Start(start)).map_err(|error| unreadable(&error))?;
        let mut corners = Vec::new();
        // Nearly all files hold plain triangles, which need no property loop.
        let n_usual = if self.is_plain_list() { self.each_leading_triangle(&mut file, take)? } else { 0 };
        for _ in n_usual..self.faces.count {
            for (at, property) in self.faces.properties.iter().enumerate() {
                let n = match property.length {
                    Some(length) => self.read_scalar(&mut file, length)? as usize,
                    None => 1,
                };
                // Other properties are skipped by their size.
                if at != self.corners {
                    skip(&mut file, n.saturating_mul(property.scalar.size()))?;
                    continue;
                }
                corners.clear();
                // A damaged count may be huge: its corners are skipped, not stored.
                for _ in 0..n.min(MOST_CORNERS) {
                    corners.push(self.read_scalar(&mut file, property.scalar)? as i64);
                }
                skip(&mut file, n.saturating_sub(MOST_CORNERS).saturating_mul(property.scalar.size()))?;
            }
            take(&corners);
        }
        Ok(())
    }

    fn is_plain_list(&self) -> bool {
        // The fast path needs single lists of little-endian 32-bit numbers with a count of one byte.
        let is_list =
            |it: &PlyProperty| it.length == Some(Scalar::U8) && matches!(it.scalar, Scalar::I32 | Scalar::U32);
        !self.big && matches!(&self.faces.properties[..], [only] if is_list(only))
    }

    fn each_leading_triangle(&self, file: &mut impl BufRead, take: &mut dyn FnMut(&[i64])) -> Result<usize, ReadError> {
        let (mut n_faces, mut face) = (0, [0; 13]);
        while n_faces < self.faces.count && file.fill_buf().map_err(|error| unreadable(&error))?.first() == Some(&3) {
            file.read_exact(&mut face).map_err(|error| unreadable(&error))?;
            take(&triangle(&face));
            n_faces += 1;
        }
        Ok(n_faces)
    }

    fn read_scalar(&self, file: &mut impl Read, scalar: Scalar) -> Result<f64, ReadError> {
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..scalar.size()];
        file.read_exact(bytes).map_err(|error| unreadable(&error))?;
        number(scalar, bytes, self.big)
    }
}

fn triangle(face: &[u8; 13]) -> [i64; 3] {
    [1, 5, 9].map(|at| i64::from(u32::from_le_bytes([0, 1, 2, 3].map(|i| face[at + i]))))
}

fn skip(file: &mut impl BufRead, n: usize) -> Result<(), ReadError> {
    if n == 0 {
        return Ok(());
    }
    let skipped = std::io::copy(&mut file.take(n as u64), &mut std::io::sink()).map_err(|error| unreadable(&error))?;
    if skipped == n as u64 { Ok(()) } else { Err(unreadable(&std::io::ErrorKind::UnexpectedEof.into())) }
}
