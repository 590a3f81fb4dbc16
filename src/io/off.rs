//! Geomview OFF as text, with or without colours, normals and texture coordinates, which are passed over.

use super::ReadError;
use super::text::Text;
use super::write::{push_faces, push_position};
use crate::mesh::{Fans, Frame, RawMesh, TriMesh};

const REMEDY: &str = "export the mesh again";

/// Reads an OFF text: comments, counts on the first line and irregular blanks are fine.
pub(super) fn read(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    let mut text = Text::new(bytes);
    read_keyword(&mut text)?;
    let [n_vertices, n_faces, _] = read_counts(&mut text)?;
    // Counts are claims: room is made only for what the bytes can hold.
    let possible = text.rest().len() / 6 + 1;
    let mut mesh = RawMesh::default();
    mesh.positions.reserve(n_vertices.min(possible));
    mesh.faces.reserve(n_faces.min(possible));
    for vertex in 0..n_vertices {
        mesh.positions.push(read_position(&mut text, vertex, n_vertices)?);
    }
    read_faces(&mut text, n_faces, &mut mesh)?;
    mesh.double = text.double;
    Ok(mesh)
}

/// The optional first word: OFF behind letters that say what a vertex line holds besides its position.
fn read_keyword(text: &mut Text) -> Result<(), ReadError> {
    text.skip_space();
    let word: Vec<u8> = text.rest().iter().copied().take_while(u8::is_ascii_alphanumeric).take(8).collect();
    if word.iter().all(u8::is_ascii_digit) && !word.is_empty() {
        return Ok(());
    }
    let Some(start) = word.windows(3).position(|letters| letters == b"OFF") else {
        return Err(text.error("the file does not start with OFF", "name the right format"));
    };
    if !word[..start].iter().all(|letter| b"STCN".contains(letter)) {
        return Err(text.error("the vertices have four or more dimensions", "export the mesh with three"));
    }
    text.advance(start + 3);
    text.skip_blanks();
    if text.rest().starts_with(b"BINARY") {
        return Err(text.error("this is a binary OFF file", "save it as text"));
    }
    Ok(())
}

/// Numbers of vertices, faces and edges; the last one is often left out.
fn read_counts(text: &mut Text) -> Result<[usize; 3], ReadError> {
    let mut counts = [0; 3];
    for (i, count) in counts.iter_mut().enumerate() {
        if i == 2 && text.is_line_done() {
            break;
        }
        text.skip_space();
        let value = text.integer().and_then(|value| usize::try_from(value).ok());
        *count = value.ok_or_else(|| text.error("the numbers of vertices and faces are missing", REMEDY))?;
    }
    text.skip_line();
    Ok(counts)
}

/// Three numbers, over line ends where need be; the rest of the line is passed over.
fn read_position(text: &mut Text, vertex: usize, n_vertices: usize) -> Result<[f64; 3], ReadError> {
    let mut position = [0.0; 3];
    for x in &mut position {
        text.skip_space();
        *x = text
            .number()
            .ok_or_else(|| text.error(format!("vertex {vertex} of {n_vertices} needs three numbers"), REMEDY))?;
    }
    text.skip_line();
    Ok(position)
}

fn read_faces(text: &mut Text, n_faces: usize, mesh: &mut RawMesh) -> Result<(), ReadError> {
    let (mut fans, mut corners) = (Fans::default(), Vec::new());
    for face in 0..n_faces {
        text.skip_space();
        let n_corners = text.integer().ok_or_else(|| missing(text, face, n_faces))?;
        corners.clear();
        for _ in 0..n_corners {
            text.skip_space();
            let vertex = text.integer().ok_or_else(|| missing(text, face, n_faces))?;
            corners.push(u32::try_from(vertex).unwrap_or(u32::MAX));
        }
        text.skip_line();
        mesh.dropped_faces += usize::from(!fans.push(&corners, &mut mesh.faces));
    }
    fans.settle(&mesh.positions, &mut mesh.faces);
    Ok(())
}

fn missing(text: &Text, face: usize, n_faces: usize) -> ReadError {
    text.error(format!("face {face} of {n_faces} needs a count and vertex numbers"), REMEDY)
}

/// Writes an OFF text with the shortest digits that read back as the same numbers.
pub(super) fn write(mesh: &TriMesh, frame: &Frame) -> Vec<u8> {
    let (n_vertices, n_faces) = (mesh.positions().len(), mesh.faces().len());
    let mut out = Vec::with_capacity(40 * n_vertices + 24 * n_faces + 64);
    out.extend(format!("OFF\n{n_vertices} {n_faces} 0\n").as_bytes());
    for &position in mesh.positions() {
        push_position(&mut out, frame, position);
        out.push(b'\n');
    }
    push_faces(&mut out, mesh.faces());
    out
}
