//! Checks that the fuzz targets of all readers share.

use neural_mesh::io::{self, Format};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};

/// Reads `bytes` with attributes, which must survive OBJ and PLY.
fn check_attributed(bytes: &[u8], format: Format) {
    let Ok(read) = io::read_attributed(bytes, Some(format)) else { return };
    assert!(read.notes.iter().all(|note| !note.contains(['\n', '\r'])));
    let Ok(cleaned) = clean(read.mesh, &CleanOptions::default()) else { return };
    let (mesh, attributes) = (&cleaned.mesh, &cleaned.attributes);
    assert!(attributes.is_valid_for(mesh.faces().len()));
    for format in [Format::Obj, Format::Ply, Format::PlyAscii] {
        let model = io::Model::new(mesh, cleaned.frame, attributes, &read.extra);
        let options = io::WriteOptions::new(format, "out");
        let written = io::write_attributed(&model, &options).unwrap();
        let back = io::read_attributed(&written.bytes, Some(format)).unwrap();
        assert_eq!(back.mesh.faces.len(), mesh.faces().len());
        assert!(back.mesh.attributes.is_valid_for(mesh.faces().len()));
    }
}

/// Reads and cleans `bytes`; the mesh must survive every format it is written to.
///
/// # Panics
/// If the result is neither a mesh nor a one-line error.
pub fn check(bytes: &[u8], format: Format) {
    check_attributed(bytes, format);
    let raw = match io::read(bytes, Some(format)) {
        Ok(raw) => raw,
        Err(error) => return assert!(!error.to_string().contains(['\n', '\r'])),
    };
    let cleaned = match clean(raw, &CleanOptions::default()) {
        Ok(cleaned) => cleaned,
        Err(error) => return assert!(!error.to_string().contains(['\n', '\r'])),
    };
    let (mesh, frame) = (&cleaned.mesh, &cleaned.frame);
    assert!(!mesh.faces().is_empty() && cleaned.source.len() == mesh.positions().len());
    for format in [Format::Ply, Format::PlyAscii, Format::Obj, Format::Off, Format::ThreeMf] {
        let back = io::read(&io::write(mesh, frame, format).unwrap(), None).unwrap();
        assert_eq!(back.faces, mesh.faces());
        for (found, &local) in back.positions.iter().zip(mesh.positions()) {
            let expected = frame.to_file(local);
            // Text holds the shortest digits of the single-precision value.
            assert!((0..3).all(|axis| found[axis] == expected[axis]
                || frame.origin[axis] == 0.0 && found[axis] as f32 == expected[axis] as f32));
        }
    }
    for format in [Format::Stl, Format::StlAscii] {
        let Ok(bytes) = io::write(mesh, frame, format) else { continue };
        let back = io::read(&bytes, None).unwrap();
        for (corners, face) in back.positions.chunks(3).zip(mesh.faces()) {
            let expected = face.map(|vertex| frame.to_file(mesh.positions()[vertex as usize]));
            let same = |(found, expected): (&[f64; 3], [f64; 3])| {
                (0..3).all(|axis| found[axis] as f32 == expected[axis] as f32)
            };
            assert!(corners.iter().zip(expected).all(same));
        }
    }
}
