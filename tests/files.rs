//! Mesh files through the public readers and writers: every format gives back what it was given.

use neural_mesh::io::{self, Format};
use neural_mesh::mesh::{Frame, TriMesh, cleanup};

/// The formats that can be written.
const WRITTEN: [Format; 6] = [Format::Obj, Format::Ply, Format::PlyAscii, Format::Stl, Format::StlAscii, Format::Off];

fn tetrahedron(scale: f32) -> TriMesh {
    let positions = [[0.1, 0.2, 0.3], [1.0, 0.0, 1e-20], [0.0, 1.0 / 3.0, 0.0], [0.0, -7e-3, 1.0]];
    let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    TriMesh::new(positions.map(|p| p.map(|x| x * scale)).to_vec(), faces).unwrap()
}

#[test]
fn every_format_gives_single_precision_back_exactly() {
    let frame = Frame::default();
    for scale in [1.0, 1e-30, 1e30] {
        let mesh = tetrahedron(scale);
        for format in WRITTEN {
            let bytes = io::write(&mesh, &frame, format).unwrap();
            let back = cleanup::clean(io::read(&bytes, None).unwrap(), &cleanup::CleanOptions::default()).unwrap();
            let corners = |mesh: &TriMesh| {
                mesh.faces().iter().map(|f| f.map(|v| mesh.positions()[v as usize])).collect::<Vec<_>>()
            };
            assert_eq!(corners(&back.mesh), corners(&mesh), "{format:?}");
        }
    }
}
