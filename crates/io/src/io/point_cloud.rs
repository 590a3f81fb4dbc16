//! Point clouds: vertices of a mesh file, or XYZ text.

use super::text::Text;
use super::{Format, ReadError, gzip, read};
use crate::mesh::RawMesh;

const REMEDY: &str = "give a mesh file, or text with x y z on each line";

/// Reads points from a mesh file, or from text with three numbers per line.
///
/// Blanks, commas or semicolons separate numbers; further columns are ignored. `#` and `//` open comments. A first line
/// with a single number is a count.
///
/// # Errors
/// [`ReadError`] for invalid content, and without points.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::read_points;
/// let cloud = read_points(b"# x y z red\n0 0 0 255\n1, 0.5, 0\n").unwrap();
/// assert_eq!((cloud.positions, cloud.faces.len()), (vec![[0.0; 3], [1.0, 0.5, 0.0]], 0));
/// assert_eq!(read_points(b"v 0 0 0\nv 1 0 0\n").unwrap().positions.len(), 2);
/// let error = read_points(b"0 0 0\n1 2\n").unwrap_err();
/// assert!(error.to_string().starts_with("line 2: a point needs three numbers"));
/// ```
pub fn read_points(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    let bytes = &gzip::decompress(bytes)?;
    let cloud = match Format::from_content(bytes) {
        Some(format) => RawMesh { faces: Vec::new(), ..read(bytes, Some(format))? },
        None => read_lines(bytes)?,
    };
    if cloud.positions.is_empty() {
        return Err(ReadError::file("there are no points", REMEDY));
    }
    Ok(cloud)
}

fn read_lines(bytes: &[u8]) -> Result<RawMesh, ReadError> {
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(ReadError::file("the text is in UTF-16", "save it as UTF-8 or ASCII"));
    }
    // A zero byte means binary data: no line of it would be worth an error.
    if bytes.contains(&0) {
        return Err(ReadError::file("the content has no known format", REMEDY));
    }
    // Separators become blanks, so that the cursor needs no mode for them.
    let commas_as_blanks: Vec<u8> =
        bytes.iter().map(|&byte| if matches!(byte, b',' | b';') { b' ' } else { byte }).collect();
    let mut text = Text::new(&commas_as_blanks);
    let mut cloud = RawMesh::default();
    let mut may_be_count = true;
    loop {
        text.skip_space();
        if text.is_at_end() {
            break;
        }
        // `#` comments are skipped with the blanks; `//` comments are not.
        if !text.rest().starts_with(b"//") {
            let point = read_point(&mut text, may_be_count)?;
            may_be_count = false;
            cloud.positions.extend(point);
        }
        text.skip_line();
    }
    cloud.double = text.double;
    Ok(cloud)
}

fn read_point(text: &mut Text, may_be_count: bool) -> Result<Option<[f64; 3]>, ReadError> {
    let x = read_number(text)?;
    // Only the first line may be a count: a later single number is a damaged point.
    if may_be_count && text.is_line_done() {
        return Ok(None);
    }
    Ok(Some([x, read_number(text)?, read_number(text)?]))
}

fn read_number(text: &mut Text) -> Result<f64, ReadError> {
    text.skip_blanks();
    text.number().ok_or_else(|| text.error("a point needs three numbers", REMEDY))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(text: &str) -> Vec<[f64; 3]> {
        read_points(text.as_bytes()).unwrap().positions
    }

    fn refusal(bytes: &[u8]) -> String {
        read_points(bytes).unwrap_err().to_string()
    }

    #[test]
    fn text_is_read_however_it_is_laid_out() {
        let two = [[1.0, 2.0, 3.0], [-4.5, 5e-1, 6.0]];
        let texts = [
            "1 2 3\n-4.5 5e-1 6\n",
            "\u{feff}1,2,3\r\n-4.5,0.5,6",
            "2\n1 2 3\n\n  -4.5\t.5 6 0 0 1 # up\n",
            "// made by hand\n1;2;3;255;0;0\n# more\n-4.5 ; 0.5 ; 6\n",
        ];
        for text in texts {
            assert_eq!(points(text), two, "{text:?}");
        }
    }

    #[test]
    fn mesh_files_give_their_vertices_with_faces_and_without() {
        let ply = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
        assert_eq!(points(&format!("{ply}0 0 1\n0 2 0\n")), [[0.0, 0.0, 1.0], [0.0, 2.0, 0.0]]);
        assert_eq!(points("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").len(), 3);
        assert!(read_points(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap().faces.is_empty());
        assert_eq!(points("OFF\n2 0 0\n0 0 0\n1 1 1\n").len(), 2);
    }

    #[test]
    fn digits_beyond_single_precision_are_remembered() {
        assert!(read_points(b"5000000.125 0 0\n").unwrap().double);
        assert!(!read_points(b"0.125 0 0\n").unwrap().double);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        assert!(refusal(b"").contains("there are no points"));
        assert!(refusal(b"# nothing\n").contains("there are no points"));
        assert!(refusal(b"7\n").contains("there are no points"));
        assert!(refusal(b"1 2 3\n7\n").starts_with("line 2: a point needs three numbers"));
        assert!(refusal(b"x y z\n1 2 3\n").starts_with("line 1: a point needs three numbers"));
        assert!(refusal(b"1 2 3\n4 5 6a\n").starts_with("line 2: a point needs three numbers"));
        assert!(refusal(b"\x89PNG\x00\x01").contains("no known format"));
        assert!(refusal(b"\xff\xfe1\x00").contains("UTF-16"));
        assert!(refusal(b"v 0 0\n").starts_with("obj: line 1"));
    }
}
