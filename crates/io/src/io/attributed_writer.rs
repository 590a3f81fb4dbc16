//! Writing of meshes with attributes and companion files.

use std::borrow::Cow;

use super::companion_files::FileFinder;
use super::extra::Extra;
use super::format::StoredAttributes;
use super::stored_precision::{describe_rounding, prepare};
use super::write::Content;
use super::write_options::WriteOptions;
use super::{Format, OutputFile, PackOptions, Packing, WriteError, shorten_name};
use crate::mesh::{Attributes, Channel, Frame, TriMesh};

/// Mesh to be written, with its attributes.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Model<'a> {
    /// Positions and faces.
    pub mesh: &'a TriMesh,
    /// Local origin of the file's coordinates, and whether the file stores doubles.
    pub frame: Frame,
    /// Exact position of each vertex in the file's coordinates, or `None` for that of `mesh`.
    pub exact: Option<Vec<Option<[f64; 3]>>>,
    /// Attributes of corners and faces.
    pub attributes: &'a Attributes,
    /// Further content of the original file.
    pub extra: &'a Extra,
}

impl<'a> Model<'a> {
    /// Makes a model with the positions of `mesh`.
    pub fn new(mesh: &'a TriMesh, frame: Frame, attributes: &'a Attributes, extra: &'a Extra) -> Self {
        Self { mesh, frame, exact: None, attributes, extra }
    }
}

/// Bytes of a mesh file and its companion files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WrittenModel {
    /// Content of the mesh file.
    pub bytes: Vec<u8>,
    /// Further files: material libraries, textures.
    pub companion_files: Vec<OutputFile>,
    /// Content lost to the format and missing companion files, one line each.
    pub notes: Vec<String>,
    /// Number of vertices in the file, with the copies made at seams; `None` for STL.
    pub n_vertices: Option<usize>,
}

/// Writes a mesh with its attributes, groups and materials.
///
/// Companion files are read from [`Extra::folder`] and returned.
///
/// # Errors
/// [`WriteError`] if the format cannot store the mesh, or attributes or positions do not match it.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::{Format, Model, WriteOptions, read_attributed, write_attributed};
/// use neural_mesh::mesh::cleanup::{CleanOptions, clean};
/// let text = b"usemtl skin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.25\nf 1/1 2/1 3/1\n";
/// let read = read_attributed(text, None).unwrap();
/// let cleaned = clean(read.mesh, &CleanOptions::default()).unwrap();
/// let (mesh, attributes) = (&cleaned.mesh, &cleaned.attributes);
/// let model = Model::new(mesh, cleaned.frame, attributes, &read.extra);
/// let written = write_attributed(&model, &WriteOptions::new(Format::Obj, "mesh")).unwrap();
/// assert_eq!(written.bytes, b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.25\nusemtl skin\nf 1/1 2/1 3/1\n");
/// ```
pub fn write_attributed(model: &Model, options: &WriteOptions) -> Result<WrittenModel, WriteError> {
    let Model { mesh, attributes, extra, .. } = *model;
    // The caller gives attributes and mesh separately, so they may belong to different meshes.
    if !attributes.is_valid_for(mesh.faces().len()) {
        return Err(WriteError::new("the attributes do not match the faces: give one row for each face"));
    }
    WriteTask { content: content(model)?, attributes, extra, options }.run()
}

/// Mesh with its attributes, for the writer of a format.
pub(super) struct WriteTask<'a> {
    pub content: Content<'a>,
    pub attributes: &'a Attributes,
    pub extra: &'a Extra,
    pub options: &'a WriteOptions<'a>,
}

impl WriteTask<'_> {
    pub fn run(self) -> Result<WrittenModel, WriteError> {
        let Self { extra, options, .. } = self;
        let write = options.format.row().writer()?;
        // This checks the precision before companion files are read, since it may fail.
        let task = Self { content: prepare(self.content, options.format)?, ..self };
        let mut finder = FileFinder::new(extra, options.allow_outside);
        (finder.converter, finder.output) = (options.images, options.folder.as_ref());
        let mut written = write(&task, &mut finder)?;
        // Notes on missing files come last, as they concern less than the mesh.
        written.notes.append(&mut finder.notes);
        written.companion_files.extend(finder.into_files());
        Ok(written)
    }

    /// Makes the file of a format that stores positions and faces only.
    pub fn geometry_file(&self, bytes: Vec<u8>) -> WrittenModel {
        let format = self.options.format;
        let losses = describe_losses(format, self.attributes, self.extra);
        let notes = losses.into_iter().chain(describe_rounding(&self.content, format)).collect();
        let n_vertices = (!format.is_single_precision()).then_some(self.content.n_vertices());
        WrittenModel { bytes, notes, n_vertices, ..WrittenModel::default() }
    }
}

/// Chooses one packing for a mesh's levels of detail; a note says why positions stay unpacked.
///
/// # Errors
/// [`WriteError`] if a glTF cannot store a model.
///
/// ```
/// # use neural_mesh_io as neural_mesh;
/// use neural_mesh::io::{Extra, Model, PackOptions, packing};
/// use neural_mesh::mesh::{Attributes, Frame, shapes};
/// let (mesh, extra) = (shapes::icosphere(1), Extra::default());
/// let model = Model::new(&mesh, Frame::default(), Attributes::NONE, &extra);
/// let (packing, note) = packing(&[model], &PackOptions { bits: 14, compress: false }).unwrap();
/// assert!(packing.grid(0).is_some_and(|grid| grid.rounding() < 2e-4) && note.is_none());
/// ```
pub fn packing(models: &[Model], options: &PackOptions) -> Result<(Packing, Option<String>), WriteError> {
    let positions: Vec<Vec<[f32; 3]>> = models
        .iter()
        .map(|model| Ok(prepare(content(model)?, Format::Glb)?.local_positions().1))
        .collect::<Result<_, _>>()?;
    let levels: Vec<_> =
        positions.iter().zip(models).map(|(positions, model)| (&positions[..], model.mesh.faces())).collect();
    Ok(Packing::for_levels(&levels, options))
}

fn content<'a>(model: &Model<'a>) -> Result<Content<'a>, WriteError> {
    // Exact positions replace the rounded ones of the mesh.
    match model.exact.clone() {
        Some(positions) => Content::from_mixed_positions(model.mesh, &model.frame, positions),
        None => Ok(Content::from_mesh(model.mesh, &model.frame)),
    }
}

/// Returns a note on content that the format cannot store, or `None`.
pub fn describe_losses(format: Format, attributes: &Attributes, extra: &Extra) -> Option<String> {
    let is_storable = |channel: &&Channel| format.holds(channel.role);
    let lost = attributes.channels.iter().filter(|it| !is_storable(it));
    let mut dropped: Vec<Cow<str>> = lost.map(|channel| shorten_name(&channel.name)).collect();
    let has_libraries = !extra.material_libraries.is_empty();
    let stored = match format.row().attributes {
        StoredAttributes::All => return None,
        StoredAttributes::Colours => {
            let has_texture = extra.looks.iter().any(|(_, look)| look.texture.is_some());
            let has_more = has_texture || has_libraries;
            dropped.extend(has_more.then_some("material properties other than names and colours (Kd)".into()));
            "geometry, names and colours"
        }
        // The order is the one in which a user would look for losses.
        StoredAttributes::None => {
            dropped.extend((!extra.groups.is_empty()).then_some("groups".into()));
            dropped.extend((has_libraries || !extra.looks.is_empty()).then_some("materials".into()));
            "geometry"
        }
    };
    (!dropped.is_empty()).then(|| format!("{} stores only {stored}: {} dropped", format.name(), dropped.join(", ")))
}
