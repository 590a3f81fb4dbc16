//! Reads the meshes of a comparison into one frame.

use std::path::{Path, PathBuf};

use neural_mesh::io::{self, FilesRead, ReadMesh};
use neural_mesh::mesh::cleanup::Cleaned;
use neural_mesh::mesh::{Looks, RawMesh, TriMesh, move_to_common_frame};
use neural_mesh::picture::{CornerNormals, ShadedMesh};

use super::mesh_cover::{MeshCover, mesh_cover, only_texture};
use crate::args::CompareArgs;
use crate::failure::{Failure, display_path};
use crate::names::refuse_progression;
use crate::read::{clean_mesh, parse_source, read_asset};
use crate::request::Source;

pub struct NamedMesh {
    /// File name, or the whole path if two files share the name.
    pub name: String,
    /// Bytes of the file; `None` for standard input and files that refer to others.
    pub bytes: Option<u64>,
    /// Cleaned mesh, around the origin that all meshes of a comparison share.
    pub mesh: TriMesh,
    pub cover: Option<MeshCover>,
    pub normals: Option<CornerNormals>,
    pub notes: Vec<String>,
}

impl NamedMesh {
    pub fn to_shaded(&self) -> ShadedMesh<'_> {
        let mut shaded = ShadedMesh::bare(&self.mesh);
        shaded.materials = self.cover.as_ref().map(|cover| &cover.materials);
        shaded.normals = self.normals.as_ref();
        shaded
    }
}

pub struct ComparedMeshes {
    pub original: NamedMesh,
    pub simplified: Vec<NamedMesh>,
    pub unread: Vec<Failure>,
}

/// Reads the original and the simplified meshes from their files, except those in `given`; adds the files to `read`.
///
/// # Errors
/// If the original cannot be read.
pub fn read_all(args: &CompareArgs, given: Vec<Option<ReadMesh>>, read: &FilesRead) -> Result<ComparedMeshes, Failure> {
    let (mut paths, mut meshes, mut unread) = (Vec::new(), Vec::new(), Vec::new());
    let mut given = given.into_iter();
    for path in args.inputs() {
        match read_mesh_with_looks(path, given.next().flatten(), args, read) {
            Ok(mesh) => {
                paths.push(path);
                meshes.push(mesh);
            }
            Err(failure) if meshes.is_empty() => return Err(failure),
            Err(failure) => unread.push(failure),
        }
    }
    let texture = meshes.first().and_then(|original| only_texture(&original.looks));
    let (mut framed, mut carried) = (Vec::new(), Vec::new());
    for MeshWithLooks { cleaned: Cleaned { mesh, frame, attributes, .. }, looks, notes } in meshes {
        framed.push((mesh, frame));
        carried.push((attributes, looks, notes));
    }
    let framed = move_to_common_frame(framed).map_err(|error| Failure::Failed(error.to_string()))?;
    let mut named = Vec::new();
    let paths_and_names = paths.iter().zip(short_names(&paths));
    for ((mesh, (attributes, looks, notes)), (path, name)) in framed.into_iter().zip(carried).zip(paths_and_names) {
        let normals = CornerNormals::new(&attributes);
        let cover = mesh_cover(attributes, looks, texture.as_ref());
        let bytes = lone_file_bytes(path, cover.is_some());
        named.push(NamedMesh { name, bytes, mesh, cover, normals, notes });
    }
    let simplified = named.split_off(1);
    let original = named.pop().ok_or_else(|| Failure::Usage("the original is missing: name its file".into()))?;
    Ok(ComparedMeshes { original, simplified, unread })
}

struct MeshWithLooks {
    cleaned: Cleaned,
    looks: Looks,
    notes: Vec<String>,
}

fn read_mesh_with_looks(
    path: &Path,
    given: Option<ReadMesh>,
    args: &CompareArgs,
    read: &FilesRead,
) -> Result<MeshWithLooks, Failure> {
    refuse_progression(path)?;
    let source = Source::new(PathBuf::from(path), None, !args.no_weld);
    let (raw, looks, notes) = match given {
        Some(given) => with_looks(given, read),
        None => read_with_looks(&source, read)?,
    };
    Ok(MeshWithLooks { cleaned: clean_mesh(raw, &source)?, looks, notes })
}

/// Reads a mesh and its groups' appearance; joins the meshes of a glTF scene.
fn read_with_looks(source: &Source, read: &FilesRead) -> Result<(RawMesh, Looks, Vec<String>), Failure> {
    if source.is_gltf() {
        let asset = read_asset(source)?;
        read.join(asset.files_read());
        let meshes: Vec<RawMesh> = asset.parts().iter().map(|part| part.mesh.clone()).collect();
        let scene = asset.scene_mesh(&meshes).map_err(|error| Failure::in_file(&source.path, error))?;
        let (looks, missing) = asset.scene_looks();
        return Ok((scene, looks, missing));
    }
    Ok(with_looks(parse_source(source, io::read_attributed, io::read_attributed_path)?, read))
}

fn with_looks(given: ReadMesh, read: &FilesRead) -> (RawMesh, Looks, Vec<String>) {
    let (looks, missing) = io::read_looks(&given.extra, false);
    given.extra.folder.iter().for_each(|folder| drop(read.join(&folder.files_read())));
    (given.mesh, looks, missing)
}

/// Returns the bytes of a file that holds all of a mesh, which a glTF never does and a covered OBJ not.
fn lone_file_bytes(path: &Path, is_covered: bool) -> Option<u64> {
    // What has no ending is the name of a mesh in memory, or standard input.
    let ending = path.extension()?.to_ascii_lowercase();
    let refers = ending == "gltf" || (ending == "obj" && is_covered);
    let file = std::fs::metadata(path).ok()?;
    (file.is_file() && !refers).then_some(file.len())
}

fn short_names(paths: &[&Path]) -> Vec<String> {
    let last =
        |path: &Path| path.file_name().map_or_else(|| display_path(path), |name| name.to_string_lossy().into_owned());
    let short: Vec<String> =
        paths.iter().map(|path| if path.as_os_str() == "-" { display_path(path) } else { last(path) }).collect();
    let is_alone = |at: usize| short.iter().filter(|other| **other == short[at]).count() == 1;
    (0..paths.len()).map(|at| if is_alone(at) { short[at].clone() } else { display_path(paths[at]) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_one_name_are_shown_with_their_paths() {
        let paths = ["a/x.ply", "b/x.ply", "b/y.ply", "-"].map(Path::new);
        assert_eq!(short_names(&paths), ["a/x.ply", "b/x.ply", "y.ply", "standard input"]);
    }
}
