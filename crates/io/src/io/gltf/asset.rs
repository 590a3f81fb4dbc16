//! Whole glTF assets.

use std::collections::HashSet;
use std::fmt;
use std::path::Path;

use serde_json::Value;

use super::accessor::Data;
use super::asset_part::{self, AssetPart};
use super::container::{self, Container};
use super::load_uri::load_uri;
use super::placements::placements;
use super::refusals::REMEDY;
use super::schema::Root;
use crate::io::memory::read_file;
use crate::io::uri::{fetch, path_inside};
use crate::io::{
    FileFetcher, FilesRead, Folder, Format, OutputFile, ReadError, gzip, refuse_external_file, shorten_name,
};

/// glTF or GLB file with its companion files.
pub struct Asset {
    pub(super) document: Value,
    pub(super) container: Container<'static>,
    // Number of bytes in the asset's file and buffers.
    pub(super) n_bytes: usize,
    // True if the asset is one JSON file with its buffers inside.
    pub(super) is_embedded: bool,
    pub(super) images: Vec<OutputFile>,
    // Index in the glTF `meshes` of each part.
    pub(super) meshes: Vec<usize>,
    parts: Vec<AssetPart>,
    notes: Vec<String>,
    read: FilesRead,
}

impl Asset {
    /// Opens the glTF or GLB file at `path`, gzip-compressed or not.
    ///
    /// # Errors
    /// [`ReadError`], without the path.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// assert_eq!(asset.parts()[0].mesh.faces.len(), 4);
    /// ```
    pub fn read_path(path: &Path) -> Result<Self, ReadError> {
        let bytes = read_file(path)?;
        Self::from_bytes_in(&bytes, &Folder::from_file(path))
    }

    /// Opens the bytes of a glTF or GLB file; `fetch` returns companion files by URI.
    ///
    /// A missing image adds a note; a missing buffer is an error.
    ///
    /// # Errors
    /// [`ReadError`] names the problem, its location and a remedy.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Asset, ReadError};
    /// let text = br#"{"asset": {"version": "2.0"}, "images": [{"uri": "no.png"}]}"#;
    /// let missing = |uri: &str| Err(ReadError::file(format!("{uri} is not there"), "give it"));
    /// let asset = Asset::from_bytes(text, &missing).unwrap();
    /// assert!(asset.parts().is_empty() && asset.notes()[0].contains("no.png"));
    /// ```
    pub fn from_bytes(bytes: &[u8], fetch: &dyn Fn(&str) -> Result<Vec<u8>, ReadError>) -> Result<Self, ReadError> {
        let bytes = &*gzip::decompress(bytes)?;
        let opened = Container::open(bytes, fetch)
            .and_then(|container| Self::from_container(bytes, container.into_owned(), fetch));
        opened.map_err(|error| ReadError { format: Some(Format::Gltf), ..error })
    }

    /// Opens the bytes of a glTF or GLB file with companion files in `folder`.
    ///
    /// # Errors
    /// As [`from_bytes`](Self::from_bytes).
    pub fn from_bytes_in(bytes: &[u8], folder: &Folder) -> Result<Self, ReadError> {
        let asset = Self::from_bytes(bytes, &|uri| fetch(folder, uri))?;
        Ok(Self { read: folder.files_read(), ..asset })
    }

    /// Opens the bytes of a glTF or GLB file without companion files.
    ///
    /// # Errors
    /// As [`from_bytes`](Self::from_bytes).
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let bytes = std::fs::read("../../tests/meshes/tiny/tetrahedron.glb").unwrap();
    /// assert_eq!(Asset::from_stream(&bytes).unwrap().parts().len(), 1);
    /// ```
    pub fn from_stream(bytes: &[u8]) -> Result<Self, ReadError> {
        Self::from_bytes(bytes, &refuse_external_file)
    }

    fn from_container(bytes: &[u8], container: Container<'static>, fetch: &FileFetcher) -> Result<Self, ReadError> {
        let (json, _) = container::split_chunks(bytes)?;
        let broken = |error| ReadError::file(format!("the JSON is malformed or not glTF ({error})"), REMEDY);
        let document = serde_json::from_slice(json).map_err(broken)?;
        // A single JSON file stays one when it is written.
        let is_data = |uri: &Option<String>| uri.as_deref().is_some_and(|uri| uri.starts_with("data:"));
        let is_embedded = !bytes.starts_with(b"glTF") && container.root.buffers.iter().all(|it| is_data(&it.uri));
        let mut notes = Vec::new();
        let (meshes, parts) = read_parts(&container, bytes.len(), &mut notes)?;
        // Draco data are decoded once and never encoded again.
        if container.root.accessors.iter().any(|accessor| accessor.decoded.is_some()) {
            notes.push("geometry that Draco has compressed is written uncompressed".into());
        }
        let images = fetch_images(&container.root, fetch, &mut notes);
        let n_bytes = bytes.len() + container.buffers.n_bytes();
        let read = FilesRead::default();
        Ok(Self { document, container, n_bytes, is_embedded, images, meshes, parts, notes, read })
    }

    /// Returns the parts: the asset's meshes that have triangles, in file order.
    pub fn parts(&self) -> &[AssetPart] {
        &self.parts
    }

    /// Returns whether the asset has an extension, such as `VRM`.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let asset = Asset::from_stream(br#"{"asset": {"version": "2.0"}, "extensions": {"VRM": {}}}"#).unwrap();
    /// assert!(asset.has_extension("VRM") && !asset.has_extension("VRMC_vrm"));
    /// ```
    pub fn has_extension(&self, name: &str) -> bool {
        self.document.get("extensions").is_some_and(|extensions| extensions.get(name).is_some())
    }

    /// Returns the files on disk that were read: the asset, its buffers and its images.
    pub fn files_read(&self) -> &FilesRead {
        &self.read
    }

    /// Returns notes on repairs and missing files.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }
}

impl Asset {
    /// Makes the materials of some primitives of a part double-sided; returns how many materials change.
    #[doc(hidden)]
    pub fn show_both_sides(&mut self, part: usize, primitives: &[u32]) -> usize {
        let mut n_changed = 0;
        for &primitive in primitives {
            let at = format!("/meshes/{}/primitives/{primitive}/material", self.meshes[part]);
            let material = self.document.pointer(&at).and_then(Value::as_u64).unwrap_or_else(|| self.add_material(&at));
            let material = self.document.pointer_mut(&format!("/materials/{material}"));
            if let Some(material) = material.and_then(Value::as_object_mut) {
                let before = material.insert("doubleSided".into(), Value::Bool(true));
                n_changed += usize::from(before != Some(Value::Bool(true)));
            }
        }
        n_changed
    }

    /// Adds a default material, writes its number to the place `at` in the document, and returns it.
    fn add_material(&mut self, at: &str) -> u64 {
        let Some(root) = self.document.as_object_mut() else { return u64::MAX };
        let materials = root.entry("materials").or_insert_with(|| Value::Array(Vec::new()));
        let Some(materials) = materials.as_array_mut() else { return u64::MAX };
        materials.push(Value::Object(serde_json::Map::new()));
        let number = materials.len() as u64 - 1;
        let primitive = at.rsplit_once('/').and_then(|(primitive, _)| self.document.pointer_mut(primitive));
        if let Some(primitive) = primitive.and_then(Value::as_object_mut) {
            primitive.insert("material".into(), number.into());
        }
        number
    }
}

impl fmt::Debug for Asset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.parts.iter().map(|part| part.name.as_str()).collect();
        f.debug_struct("Asset").field("parts", &names).field("notes", &self.notes).finish_non_exhaustive()
    }
}

fn read_parts(
    container: &Container,
    n_bytes: usize,
    notes: &mut Vec<String>,
) -> Result<(Vec<usize>, Vec<AssetPart>), ReadError> {
    let (root, data) = (&container.root, container.data());
    let (mut budget, mut n_not_finite) = (container.budget(n_bytes), 0);
    let scales = largest_scales(&data, budget)?;
    let (mut meshes, mut parts) = (Vec::new(), Vec::new());
    for (index, mesh) in root.meshes.iter().enumerate() {
        let name = mesh.name.clone().unwrap_or_else(|| format!("mesh {index}"));
        let materials = asset_part::materials(root, mesh);
        // Meshes of lines or points alone are no parts.
        if let Some(mesh) = asset_part::read(&data, mesh, &mut budget, &mut n_not_finite)? {
            meshes.push(index);
            parts.push(AssetPart { name, mesh, materials, scale: scales[index] });
        }
    }
    if n_not_finite > 0 {
        notes.push(format!("{n_not_finite} values of vertex attributes are not finite: they become 0"));
    }
    Ok((meshes, parts))
}

/// Returns the largest scale at which nodes show each mesh, n_meshes.
fn largest_scales(data: &Data, limit: usize) -> Result<Vec<f64>, ReadError> {
    let mut scales = vec![0f64; data.root.meshes.len()];
    for placed in placements(data)? {
        let of_instances = placed.instances.and_then(|names| names.get("SCALE"));
        let of_instances = of_instances.map_or(Ok(1.0), |&accessor| largest_scale(data, accessor, limit))?;
        // The mean scale of all axes is one number per part, which is enough for tolerances.
        let of_node = placed.transform.determinant().abs().cbrt();
        let scale = of_node * of_instances;
        if let Some(largest) = scales.get_mut(placed.mesh).filter(|_| scale.is_finite()) {
            *largest = scale.max(*largest);
        }
    }
    Ok(scales.into_iter().map(|scale| if scale > 0.0 { scale } else { 1.0 }).collect())
}

fn largest_scale(data: &Data, accessor: usize, limit: usize) -> Result<f64, ReadError> {
    let (width, values) = data.floats(accessor, limit)?;
    let volume = |scale: &[f32]| scale.iter().map(|&x| f64::from(x)).product::<f64>().abs();
    Ok(values.chunks_exact(width).map(volume).fold(0.0, f64::max).cbrt())
}

fn fetch_images(root: &Root, fetch: &FileFetcher, notes: &mut Vec<String>) -> Vec<OutputFile> {
    let (mut images, mut known) = (Vec::new(), HashSet::new());
    for uri in root.images.iter().filter_map(|image| image.uri.as_deref()).filter(|uri| !uri.starts_with("data:")) {
        let short = shorten_name(uri);
        let Some(path) = path_inside(uri) else {
            notes.push(format!(
                "the image {short:?} is outside the folder of the asset: it is not copied, but the result refers to it"
            ));
            continue;
        };
        // Several images may name one file.
        if known.contains(&path) {
            continue;
        }
        match load_uri(uri, fetch) {
            Ok(bytes) => {
                known.insert(path.clone());
                images.push(OutputFile { path, bytes });
            }
            Err(_) => {
                notes.push(format!("the image {short:?} is missing: it is not copied, but the result refers to it"))
            }
        }
    }
    notes.dedup();
    images
}
