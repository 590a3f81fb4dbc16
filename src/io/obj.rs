//! Wavefront OBJ: positions and faces; materials, texture coordinates, normals, curves and lines are passed over.

use super::ReadError;
use super::text::Text;
use super::write::Content;
use crate::mesh::{Fans, RawMesh};

/// An index that no vertex has: faces with it are for cleanup to drop.
const NOWHERE: u32 = u32::MAX;

/// Reads an OBJ text: BOM, CRLF, continued lines, relative indices and comments in any encoding are fine.
pub(super) fn read(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    let mut text = Text::new(bytes).with_continuation();
    let (mut mesh, mut fans, mut corners) = (RawMesh::default(), Fans::default(), Vec::new());
    while !text.is_at_end() {
        text.skip_blanks();
        match text.rest() {
            [b'v', b' ' | b'\t' | b'\\', ..] => {
                text.advance(1);
                mesh.positions.push(read_position(&mut text)?);
            }
            [b'f', b' ' | b'\t' | b'\\' | b'\r' | b'\n', ..] | [b'f'] => {
                text.advance(1);
                read_corners(&mut text, mesh.positions.len(), &mut corners)?;
                mesh.dropped_faces += usize::from(!fans.push(&corners, &mut mesh.faces));
            }
            _ => {}
        }
        text.skip_line();
    }
    fans.settle(&mesh.positions, &mut mesh.faces);
    mesh.double = text.double;
    Ok(mesh)
}

/// Three numbers; a weight or a colour may follow.
fn read_position(text: &mut Text) -> Result<[f64; 3], ReadError> {
    let mut position = [0.0; 3];
    for x in &mut position {
        text.skip_blanks();
        let problem = "a vertex needs three numbers";
        *x = text.number().ok_or_else(|| text.error(problem, "mend the line or export the mesh again"))?;
    }
    Ok(position)
}

/// The vertex of each `v`, `v/vt`, `v//vn` or `v/vt/vn` up to the end of the line.
fn read_corners(text: &mut Text, n_vertices: usize, corners: &mut Vec<u32>) -> Result<(), ReadError> {
    corners.clear();
    while !text.is_line_done() {
        let problem = "a corner of a face needs a vertex number";
        let index = text.integer().ok_or_else(|| text.error(problem, "mend the line or export the mesh again"))?;
        let from_zero = if index < 0 { n_vertices as i64 + index } else { index - 1 };
        corners.push(u32::try_from(from_zero).unwrap_or(NOWHERE));
        while !text.is_between_words() {
            text.advance(1);
        }
    }
    Ok(())
}

/// Writes an OBJ text with the shortest digits that read back as the same numbers.
pub(super) fn write(content: &Content) -> Vec<u8> {
    let mut out = Vec::with_capacity(40 * content.n_vertices() + 24 * content.faces.len());
    for vertex in 0..content.n_vertices() {
        out.extend(b"v ");
        content.push_position(&mut out, vertex);
        out.push(b'\n');
    }
    let mut digits = itoa::Buffer::new();
    for face in content.faces {
        out.push(b'f');
        for &vertex in face {
            out.push(b' ');
            out.extend(digits.format(vertex + 1).as_bytes());
        }
        out.push(b'\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    fn faces(text: &str) -> Vec<[u32; 3]> {
        read(format!("{SQUARE}{text}").as_bytes()).unwrap().faces
    }

    #[test]
    fn corners_of_every_spelling() {
        for face in [
            "f 1 2 3",
            "f 1/1 2/2/2 3//3",
            "f 1// 2/ 3/7/",
            "f -4 -3 -2",
            "f\t1  2 \t3\r",
            "f 1 2 3 # words",
            "f +1 2 3",
        ] {
            assert_eq!(faces(face), [[0, 1, 2]], "{face}");
            assert_eq!(faces(&format!("{face}\n")), [[0, 1, 2]], "{face}");
        }
    }

    #[test]
    fn continued_lines() {
        assert_eq!(faces("f 1 \\\n 2 \\\r\n3\n"), [[0, 1, 2]]);
        assert_eq!(read(b"v 1 \\\n2 3\nv\\\n 4 5 6").unwrap().positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    }

    #[test]
    fn indices_that_lead_nowhere_are_left_to_cleanup() {
        for face in ["f 0 1 2", "f 9 1 2", "f -5 1 2", "f 99999999999999999999 1 2", "f -99999999999999999999 1 2"] {
            assert!(faces(face)[0][0] as usize >= 4, "{face}");
        }
    }

    #[test]
    fn faces_before_their_vertices() {
        let text = "f 1 2 3 4\nv 0 0 0\nv 2 -1 0\nv 0.5 0 0\nv 2 1 0\n";
        assert_eq!(read(text.as_bytes()).unwrap().faces.len(), 2);
    }

    #[test]
    fn what_is_no_geometry_is_passed_over() {
        let text = b"\xef\xbb\xbf# caf\xe9 \xff\r\nmtllib a b\ng f 1 2 3\nvn 0 0 1\nvt 0 0\nvp 1\nl 1 2\np 1\nusemtl v\nfoo\n\nv 1 2 3 0.5 nan 0\n";
        assert_eq!(read(text).unwrap(), RawMesh { positions: vec![[1.0, 2.0, 3.0]], ..RawMesh::default() });
    }

    #[test]
    fn faces_of_two_corners_are_counted() {
        let mesh = read(format!("{SQUARE}f 1 2\nf\nf 1 2 3\nf").as_bytes()).unwrap();
        assert_eq!((mesh.faces.len(), mesh.dropped_faces), (1, 3));
    }

    #[test]
    fn errors_name_the_line() {
        for (text, line) in [("v 0 0\n", 1), ("v 0 0 0\nv 1 x 0", 2), ("\n\nv 1 2 3.1+e2\n", 3), ("# a\r\nf 1 a 2", 2)]
        {
            let error = read(text.as_bytes()).unwrap_err();
            assert_eq!(error.place, crate::io::Place::Line(line), "{error}");
        }
    }
}
