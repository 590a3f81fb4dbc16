//! Streams of triangles from mesh files larger than memory.

use std::path::{Path, PathBuf};

use super::runs::{FileOutline, PieceContent, PieceReceiver};
use super::{Format, ReadError, obj, ply, stl};
use crate::mesh::fallible_allocation::make_room;
use crate::mesh::{Frame, RawMesh};

/// Corners of a triangle.
pub type Triangle = [[f32; 3]; 3];

/// Mesh file that is read in a stream.
#[derive(Debug)]
pub struct Pieces {
    path: PathBuf,
    kind: PiecesKind,
    outline: FileOutline,
}

#[derive(Debug)]
enum PiecesKind {
    Ply(ply::PlyLayout),
    Stl,
    Obj,
}

impl Pieces {
    /// Opens a PLY, STL or OBJ file by the extension of its name.
    ///
    /// # Errors
    /// [`ReadError`] if the file cannot be streamed.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Pieces;
    /// let pieces = Pieces::open("../../tests/meshes/spot.ply".as_ref()).unwrap();
    /// let mut n_triangles = 0;
    /// pieces.each_triangle(&Default::default(), &mut |_| n_triangles += 1).unwrap();
    /// assert_eq!(n_triangles, 5856);
    /// ```
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let found = match Format::from_path(path) {
            // A compressed file cannot be read from the middle.
            _ if Format::without_gz(path) != path => None,
            Some(Format::Ply) => {
                ply::PlyLayout::open(path)?.map(|(layout, outline)| (PiecesKind::Ply(layout), outline))
            }
            Some(Format::Stl) => stl::outline(path)?.map(|outline| (PiecesKind::Stl, outline)),
            Some(Format::Obj) => Some((PiecesKind::Obj, obj::outline(path)?)),
            _ => None,
        };
        let what = "only OBJ and binary PLY and STL can be read in blocks";
        let (kind, outline) = found.ok_or_else(|| ReadError::file(what, "convert the mesh or allow more memory"))?;
        if outline.n_vertices > u64::from(u32::MAX) {
            return Err(ReadError::file("the file has more than 4294967295 vertices", "convert the mesh to STL"));
        }
        Ok(Self { path: path.into(), kind, outline })
    }

    /// Returns the number of faces; for OBJ, estimates two per vertex.
    pub fn n_faces(&self) -> u64 {
        self.outline.n_faces
    }

    /// Describes content of the file besides geometry.
    pub fn other_content(&self) -> Option<String> {
        self.outline.other_content.clone()
    }

    /// Returns the bytes kept in memory while triangles are read.
    pub fn n_memory_bytes(&self) -> u64 {
        12u64.saturating_mul(self.outline.n_vertices)
    }

    /// Returns whether the file's positions need double precision.
    pub fn is_double(&self) -> bool {
        self.outline.is_double
    }

    /// Passes every position to `take`; STL has one per corner.
    ///
    /// # Errors
    /// [`ReadError`] if the file is cut or has an invalid number.
    pub fn each_position(&self, take: &mut dyn FnMut([f64; 3])) -> Result<(), ReadError> {
        self.each_piece(PieceContent::Positions, &mut |piece| piece.positions.iter().for_each(|&p| take(p)))
    }

    /// Passes every triangle to `take`, in local coordinates, polygons as fans; returns the number of broken faces.
    ///
    /// # Errors
    /// As [`each_position`](Self::each_position), and if memory for the positions is lacking.
    pub fn each_triangle(&self, frame: &Frame, take: &mut dyn FnMut(Triangle)) -> Result<u64, ReadError> {
        let mut n_broken = 0;
        let mut emit = |corners: [Option<[f32; 3]>; 3]| match corners {
            // Non-finite positions are dropped with their faces.
            [Some(a), Some(b), Some(c)] if [a, b, c].as_flattened().iter().all(|x| x.is_finite()) => take([a, b, c]),
            _ => n_broken += 1,
        };
        if let PiecesKind::Stl = self.kind {
            let mut corners = |piece: &RawMesh| {
                let corners = piece.positions.as_chunks().0;
                corners.iter().for_each(|corners| emit(corners.map(|p| Some(frame.to_local(p)))));
            };
            self.each_piece(PieceContent::Positions, &mut corners)?;
            return Ok(n_broken);
        }
        // Faces refer to vertices in any order, so all positions are read first.
        let positions = self.positions(frame)?;
        let mut n_dropped = 0;
        self.each_piece(PieceContent::Faces, &mut |piece| {
            n_dropped += piece.dropped_faces as u64;
            // An index out of range breaks only its face.
            let find_position = |vertex: u32| positions.get(vertex as usize).copied();
            piece.faces.iter().for_each(|face| emit(face.map(find_position)));
        })?;
        Ok(n_broken + n_dropped)
    }

    fn each_piece(&self, content: PieceContent, take: &mut PieceReceiver) -> Result<(), ReadError> {
        match &self.kind {
            PiecesKind::Ply(layout) => layout.each_piece(&self.path, content, take),
            PiecesKind::Stl => stl::each_piece(&self.path, self.n_faces(), take),
            PiecesKind::Obj => obj::each_piece(&self.path, content, take),
        }
    }

    fn positions(&self, frame: &Frame) -> Result<Vec<[f32; 3]>, ReadError> {
        let mut positions = Vec::new();
        let n = usize::try_from(self.outline.n_vertices).unwrap_or(usize::MAX);
        let what = "the vertices need more memory than is available";
        make_room(&mut positions, n)
            .map_err(|_| ReadError::file(what, "allow more memory or convert the mesh to STL"))?;
        self.each_position(&mut |p| positions.push(frame.to_local(p)))?;
        Ok(positions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::read_path;

    fn read_both_ways(path: &Path) -> [Vec<Triangle>; 2] {
        let raw = read_path(path, None).unwrap();
        let position = |v: u32| raw.positions[v as usize].map(|x| x as f32);
        let whole = raw.faces.iter().map(|face| face.map(position)).collect();
        let mut pieces = Vec::new();
        let n_broken = Pieces::open(path).unwrap().each_triangle(&Frame::default(), &mut |it| pieces.push(it)).unwrap();
        assert_eq!(n_broken, 0);
        [whole, pieces]
    }

    fn write_file(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        (folder, path)
    }

    #[test]
    fn in_pieces_a_file_is_what_it_is_as_a_whole() {
        let mesh = crate::mesh::shapes::torus(12, 7, 1.0, 0.3);
        for format in [Format::Ply, Format::Stl, Format::Obj] {
            let bytes = crate::io::write(&mesh, &Frame::default(), format).unwrap();
            let (_folder, path) = write_file(&format!("a.{}", format.name()), &bytes);
            let [whole, pieces] = read_both_ways(&path);
            assert_eq!(whole, pieces, "{format:?}");
        }
    }

    #[test]
    fn lists_of_any_kind_and_other_properties_are_passed_over() {
        let mut bytes = b"ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty uchar red\nproperty double x\nproperty double y\nproperty double z\nelement face 1\nproperty list ushort float more\nproperty list uint short vertex_indices\nproperty int last\nend_header\n".to_vec();
        for i in 0..4u8 {
            bytes.push(i);
            [f64::from(i & 1), f64::from(i >> 1), 0.0].iter().for_each(|x| bytes.extend(x.to_be_bytes()));
        }
        bytes.extend([0, 1, 0, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0, 1, 0, 3, 0, 2, 0, 0, 0, 9]);
        let (_folder, path) = write_file("a.ply", &bytes);
        let pieces = Pieces::open(&path).unwrap();
        assert!(pieces.is_double() && pieces.n_memory_bytes() == 48);
        let mut triangles = Vec::new();
        pieces.each_triangle(&Frame::default(), &mut |it| triangles.push(it)).unwrap();
        assert_eq!(triangles.len(), 2);
        assert_eq!(triangles[1], [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn an_obj_counts_from_either_end_and_skips_what_is_no_geometry() {
        let text = "# a\r\nv 0 0 0\r\nv 1 0 0 0.5 0.5 0.5\nvt 0 0\nv 0 1 0\nusemtl x\nf 1/1 2/1/1 3//1\nf -3 -2 \\\n -1\nf 1 2\nf 1 2 9\nv 1 1 nan\nf 1 2 4\n";
        let (_folder, path) = write_file("a.obj", text.as_bytes());
        let mut triangles = Vec::new();
        let pieces = Pieces::open(&path).unwrap();
        let n_broken = pieces.each_triangle(&Frame::default(), &mut |it| triangles.push(it)).unwrap();
        assert_eq!((triangles.len(), n_broken), (2, 3));
        assert_eq!(triangles[0], triangles[1]);
    }

    #[test]
    fn what_is_cut_or_of_another_kind_is_said() {
        let mesh = crate::mesh::shapes::icosphere(1);
        for format in [Format::Ply, Format::Stl] {
            let bytes = crate::io::write(&mesh, &Frame::default(), format).unwrap();
            let (_folder, path) = write_file(&format!("a.{}", format.name()), &bytes[..bytes.len() - 7]);
            let error = Pieces::open(&path).and_then(|it| it.each_triangle(&Frame::default(), &mut |_| ()));
            assert!(error.unwrap_err().to_string().contains("too soon"), "{format:?}");
        }
        for (name, bytes) in [
            ("a.off", &b"OFF\n0 0 0\n"[..]),
            ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 0\nend_header\n"),
            ("a.stl", b"solid x\nendsolid x\n"),
        ] {
            let (_folder, path) = write_file(name, bytes);
            let error = Pieces::open(&path).unwrap_err().to_string();
            assert!(error.contains("only OBJ and binary PLY and STL"), "{name}: {error}");
        }
    }

    #[test]
    fn damaged_bytes_are_triangles_or_an_error() {
        use rand_xoshiro::rand_core::{Rng, SeedableRng};
        let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(7);
        let mesh = crate::mesh::shapes::icosphere(1);
        for format in [Format::Ply, Format::Stl, Format::Obj] {
            let whole = crate::io::write(&mesh, &Frame::default(), format).unwrap();
            let (_folder, path) = write_file(&format!("a.{}", format.name()), &whole);
            for _ in 0..400 {
                let mut bytes = whole.clone();
                for _ in 0..1 + random.next_u32() % 4 {
                    let at = random.next_u32() as usize % bytes.len();
                    bytes[at] = random.next_u32() as u8;
                }
                bytes.truncate(bytes.len() - (random.next_u32() as usize % 8) * (random.next_u32() as usize % 20));
                std::fs::write(&path, bytes).unwrap();
                let mut all_finite = true;
                let found = Pieces::open(&path).and_then(|pieces| {
                    let mut check = |it: Triangle| all_finite &= it.as_flattened().iter().all(|x| x.is_finite());
                    pieces.each_triangle(&Frame::default(), &mut check)
                });
                assert!(all_finite && found.err().is_none_or(|error| !error.to_string().contains('\n')));
            }
        }
    }
}
