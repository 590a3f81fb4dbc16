//! Geomview OFF as text: positions and faces.

use super::memory::reserve;
use super::text::Text;
use super::write::Content;
use super::{ReadError, ReadMesh};
use crate::mesh::{Fans, RawMesh};

const REMEDY: &str = "export the mesh again";

pub(super) fn read(bytes: &[u8]) -> Result<ReadMesh, ReadError> {
    let mut text = Text::new(bytes);
    let mut notes = Vec::new();
    read_keyword(&mut text)?;
    let [n_vertices, n_faces, _] = read_counts(&mut text)?;
    // Counts are claims: memory is reserved only for what the bytes can hold.
    let possible = text.rest().len() / 6 + 1;
    let mut mesh = RawMesh::default();
    mesh.positions.reserve(n_vertices.min(possible));
    mesh.faces.reserve(n_faces.min(possible));
    let mut is_more_said = false;
    for vertex in 0..n_vertices {
        let position = text.read_position(Text::skip_space);
        let problem = || text.error(format!("vertex {vertex} of {n_vertices} needs three numbers"), REMEDY);
        mesh.positions.push(position.ok_or_else(problem)?);
        // Only the position is read; the rest of the line is noted.
        is_more_said |= !text.is_line_done();
        text.skip_line();
    }
    if is_more_said {
        notes.push("colours, normals or texture coordinates of off vertices are dropped".into());
    }
    if read_faces(&mut text, n_faces, &mut mesh)? {
        notes.push("colours of off faces are dropped".into());
    }
    mesh.double = text.double;
    Ok(ReadMesh { mesh, notes, ..ReadMesh::default() })
}

fn read_keyword(text: &mut Text) -> Result<(), ReadError> {
    text.skip_space();
    // Letters before OFF announce the contents of a vertex line.
    let word: Vec<u8> = text.rest().iter().copied().take_while(u8::is_ascii_alphanumeric).take(8).collect();
    // The keyword may be missing: then the counts come first.
    if word.iter().all(u8::is_ascii_digit) && !word.is_empty() {
        return Ok(());
    }
    let Some(start) = word.windows(3).position(|letters| letters == b"OFF") else {
        return Err(text.error("the file does not start with OFF", "name the right format"));
    };
    // Letters such as `4` or `n` announce more dimensions, whose vertices would be misread.
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

fn read_counts(text: &mut Text) -> Result<[usize; 3], ReadError> {
    let mut counts = [0; 3];
    for (i, count) in counts.iter_mut().enumerate() {
        // The number of edges means nothing and is often missing.
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

/// Reads the faces; returns whether a line has values after its vertex indices.
fn read_faces(text: &mut Text, n_faces: usize, mesh: &mut RawMesh) -> Result<bool, ReadError> {
    let mut is_more_said = false;
    let (mut fans, mut corners) = (Fans::default(), Vec::new());
    for face in 0..n_faces {
        text.skip_space();
        // A negative count gives a face without corners.
        let n_corners = text.integer().ok_or_else(|| missing(text, face, n_faces))?;
        corners.clear();
        for _ in 0..n_corners {
            text.skip_space();
            // Cleanup drops faces with an index out of range.
            let vertex = text.integer().ok_or_else(|| missing(text, face, n_faces))?;
            // A count is a claim as well: memory grows with the corners that exist.
            reserve(&mut corners, 1)?;
            corners.push(u32::try_from(vertex).unwrap_or(u32::MAX));
        }
        // The rest of the line is a colour.
        is_more_said |= !text.is_line_done();
        text.skip_line();
        reserve(&mut mesh.faces, corners.len())?;
        mesh.dropped_faces += usize::from(!fans.push(&corners, &mut mesh.faces));
    }
    fans.triangulate(&mesh.positions, &mut mesh.faces);
    Ok(is_more_said)
}

fn missing(text: &Text, face: usize, n_faces: usize) -> ReadError {
    text.error(format!("face {face} of {n_faces} needs a count and vertex numbers"), REMEDY)
}

pub(super) fn write(content: &Content) -> Vec<u8> {
    let (n_vertices, n_faces) = (content.n_vertices(), content.faces.len());
    let mut out = Vec::with_capacity(40 * n_vertices + 24 * n_faces + 64);
    out.extend(format!("OFF\n{n_vertices} {n_faces} 0\n").as_bytes());
    for vertex in 0..n_vertices {
        content.push_position(&mut out, vertex);
        out.push(b'\n');
    }
    let mut digits = itoa::Buffer::new();
    for face in content.faces {
        out.push(b'3');
        for &vertex in face {
            out.push(b' ');
            out.extend(digits.format(vertex).as_bytes());
        }
        out.push(b'\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACE: [[u32; 3]; 1] = [[0, 1, 2]];

    #[test]
    fn headers_of_every_spelling() {
        for start in [
            "OFF\n3 1 0\n",
            "OFF 3 1 0\n",
            "OFF3 1 0\n",
            "3 1 0\n",
            "\u{feff}  # a\r\n OFF # b\r\n# c\r\n3 1\r\n",
            "STOFF\n3 1 3\n",
        ] {
            let mesh = read(format!("{start}0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").as_bytes()).unwrap().mesh;
            assert_eq!((mesh.positions.len(), &mesh.faces[..]), (3, &FACE[..]), "{start}");
        }
    }

    #[test]
    fn colours_and_normals_are_passed_over() {
        let text =
            "NCOFF\n3 1 0\n0 0 0 0 0 1 255 0 0 255\n1 0 0 0 0 1 0.5 0.5 0.5 1\n0 1 0 0 0 1 1 1 1 1\n3 0 1 2 255 0 0\n";
        assert_eq!(read(text.as_bytes()).unwrap().mesh.faces, FACE);
    }

    #[test]
    fn values_broken_over_lines() {
        assert_eq!(read(b"OFF\n3\n1\n0\n0 0\n0\n1 0 0 0 1 0\n\n0 1 0\n3 0\n1 2\n").unwrap().mesh.faces, FACE);
    }

    #[test]
    fn what_cannot_be_read_is_said() {
        let cases = [
            ("OFF\n999999999999 1 0\n0 0 0\n", "vertex 1 of 999999999999 needs three numbers"),
            ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n999999999 0 1 2", "face 0 of 1 needs"),
            ("OFF BINARY\n", "this is a binary OFF file"),
            ("4OFF\n", "four or more dimensions"),
            ("nOFF 3\n", "four or more dimensions"),
            ("COFFEE\n", "the numbers of vertices and faces are missing"),
            ("OFF\n-3 1 0\n", "the numbers of vertices and faces are missing"),
            ("mesh\n", "does not start with OFF"),
            ("", "does not start with OFF"),
        ];
        for (text, expected) in cases {
            let error = read(text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(expected), "{text:?}: {error}");
        }
    }
}
