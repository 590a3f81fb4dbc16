//! What the text writers share: coordinates with the fewest digits that read back as the same number.

use crate::mesh::Frame;

/// Appends the three file coordinates of a local position, separated by blanks.
pub(super) fn push_position(out: &mut Vec<u8>, frame: &Frame, local: [f32; 3]) {
    let mut digits = zmij::Buffer::new();
    for (axis, x) in frame.to_file(local).into_iter().enumerate() {
        if axis > 0 {
            out.push(b' ');
        }
        // Where nothing was shifted the value is a single one, and its shorter text says all there is.
        let single = !frame.double || frame.origin[axis] == 0.0;
        let text = if single { digits.format_finite(x as f32) } else { digits.format_finite(x) };
        out.extend(text.strip_suffix(".0").unwrap_or(text).as_bytes());
    }
}

/// Appends one line per face: 3 and the three vertex indices.
pub(super) fn push_faces(out: &mut Vec<u8>, faces: &[[u32; 3]]) {
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
