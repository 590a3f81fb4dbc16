//! Mesh files: bytes to [`RawMesh`](crate::mesh::RawMesh) and back, one file per format.
