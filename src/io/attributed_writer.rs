//! Writing of meshes with attributes and companion files.

use rustc_hash::FxHashMap;

use super::companion_files::{FileFinder, to_reference};
use super::extra::{Column, ColumnLayout, Extra, Group};
use super::gltf_file::GltfFile;
use super::group_looks::read_looks;
use super::material_libraries::Libraries;
use super::material_writer::MaterialLibrary;
use super::texture_comments::{comment_textures, texture_name, texture_number};
use super::write::Content;
use super::write_options::WriteOptions;
use super::{
    Format, ImageUse, OutputFile, PackOptions, Packing, Scalar, WriteError, gltf, obj, ply, prepare_content,
    stored_precision, threemf, write_prepared,
};
use crate::mesh::{Attributes, Channel, Frame, Role, TriMesh};

const BASE_ONLY: &str = "gltf takes names, colours (Kd, Ke), roughness, metal and textures (map_Kd, map_Ke, norm) from a material library: its other properties are left out";

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
    let Model { mesh, attributes, .. } = *model;
    // The caller gives attributes and mesh separately, so they may belong to different meshes.
    if !attributes.is_valid_for(mesh.faces().len()) {
        return Err(WriteError { what: "the attributes do not match the faces: give one row for each face".into() });
    }
    // This checks the precision before companion files are read, since it may fail.
    let content = content(model, options.format)?;
    let mut finder = FileFinder::new(model.extra, options.allow_outside);
    finder.converter = options.images;
    let (mut notes, mut images) = (Vec::new(), Vec::new());
    let (bytes, n_vertices) = match options.format {
        Format::Obj => {
            let extra = for_obj(model.extra, attributes, &options.name, &mut finder);
            (obj::write_attributed(&content, attributes, &extra, &mut notes), content.n_vertices())
        }
        Format::Ply | Format::PlyAscii => {
            let extra = for_ply(model.extra, attributes, &options.name, &mut finder, &mut notes);
            let as_text = options.format == Format::PlyAscii;
            ply::write_attributed(&content, attributes, &extra, as_text, &mut notes)
        }
        Format::Gltf | Format::Glb => {
            let written = as_gltf(model, &content, options)?;
            (images, notes) = (written.images, written.notes);
            (written.bytes, written.n_vertices)
        }
        Format::ThreeMf => (as_threemf(model, &content, options, &mut notes)?, content.n_vertices()),
        Format::Stl | Format::StlAscii | Format::Off | Format::Fbx => {
            notes.extend(describe_losses(options.format, attributes, model.extra));
            notes.extend(stored_precision::describe_rounding(&content, options.format));
            (write_prepared(&content, options.format)?, content.n_vertices())
        }
    };
    // Notes on missing files come last, as they concern less than the mesh.
    notes.append(&mut finder.notes);
    let shares_vertices = !matches!(options.format, Format::Stl | Format::StlAscii);
    images.extend(finder.into_files());
    Ok(WrittenModel { bytes, companion_files: images, notes, n_vertices: shares_vertices.then_some(n_vertices) })
}

/// Chooses one packing for a mesh's levels of detail; a note says why positions stay unpacked.
///
/// # Errors
/// [`WriteError`] if a glTF cannot store a model.
///
/// ```
/// use neural_mesh::io::{Extra, Model, PackOptions, packing};
/// use neural_mesh::mesh::{Attributes, Frame, shapes};
/// let (mesh, extra) = (shapes::icosphere(1), Extra::default());
/// let model = Model::new(&mesh, Frame::default(), Attributes::NONE, &extra);
/// let (packing, note) = packing(&[model], &PackOptions { bits: 14, compress: false }).unwrap();
/// assert!(packing.grid(0).is_some_and(|grid| grid.rounding() < 2e-4) && note.is_none());
/// ```
pub fn packing(models: &[Model], options: &PackOptions) -> Result<(Packing, Option<String>), WriteError> {
    let positions: Vec<Vec<[f32; 3]>> =
        models.iter().map(|model| Ok(content(model, Format::Glb)?.local_positions().1)).collect::<Result<_, _>>()?;
    let levels: Vec<_> =
        positions.iter().zip(models).map(|(positions, model)| (&positions[..], model.mesh.faces())).collect();
    Ok(Packing::for_levels(&levels, options))
}

fn content<'a>(model: &Model<'a>, format: Format) -> Result<Content<'a>, WriteError> {
    // Exact positions replace the rounded ones of the mesh.
    let kept = model.exact.clone().map(|positions| Content::from_mixed_positions(model.mesh, &model.frame, positions));
    prepare_content(kept.unwrap_or_else(|| Ok(Content::from_mesh(model.mesh, &model.frame)))?, format)
}

fn as_gltf(model: &Model, content: &Content, options: &WriteOptions) -> Result<GltfFile, WriteError> {
    let Model { attributes, extra, .. } = *model;
    let names = material_names(attributes, extra);
    let of_library = (!extra.material_libraries.is_empty()).then(|| BASE_ONLY.into());
    let (looks, missing) = read_looks(extra, options.allow_outside);
    let objects: Vec<Option<String>> = extra.groups.iter().map(|group| group.object.clone()).collect();
    let mut written = gltf::write_attributed(content, attributes, &names, &objects, &looks.of_groups, options)?;
    written.notes = of_library.into_iter().chain(missing).chain(written.notes).collect();
    Ok(written)
}

fn as_threemf(
    model: &Model,
    content: &Content,
    options: &WriteOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<u8>, WriteError> {
    let Model { attributes, extra, .. } = *model;
    let (looks, missing) = read_looks(extra, options.allow_outside);
    notes.extend(describe_losses(options.format, attributes, extra).into_iter().chain(missing));
    let (bytes, dropped) = threemf::write_attributed(content, attributes, extra, &looks.of_groups)?;
    notes.extend(dropped);
    Ok(bytes)
}

// A mesh with one unnamed group has no material.
fn material_names(attributes: &Attributes, extra: &Extra) -> Vec<String> {
    let is_material = |group: &&Group| !attributes.groups.is_empty() || group.material.is_some();
    extra.groups.iter().filter(is_material).map(Group::title).collect()
}

fn for_obj(extra: &Extra, attributes: &Attributes, name: &str, finder: &mut FileFinder) -> Extra {
    let mut extra = Extra { material_libraries: Libraries::find(extra, finder).names, ..extra.clone() };
    // OBJ cannot store numbers of faces (PLY columns such as `label`), so they become names of groups.
    for group in extra.groups.iter_mut().filter(|group| group.name.is_none() && !group.values.is_empty()) {
        let parts = extra.face_columns.iter().zip(&group.values);
        let parts: Vec<String> = parts.map(|(column, value)| format!("{}_{value}", column.name)).collect();
        group.name = Some(parts.join("_"));
    }
    // Materials that came with the mesh (glTF) become a library of their own.
    let own = MaterialLibrary::from_looks(&extra, name, finder);
    if !own.text.is_empty() {
        let library = format!("{name}.mtl");
        finder.add_file(library.as_ref(), &own.text);
        extra.material_libraries.push(library);
    }
    // Textures of a PLY become a library, unless the mesh already names one.
    let textures = textures_of_comments(&extra, finder);
    if !textures.is_empty() && extra.material_libraries.is_empty() {
        let library = format!("{name}.mtl");
        let texts = textures.iter().enumerate();
        let text: String =
            texts.map(|(i, texture)| format!("newmtl texture_{i}\nKd 1 1 1\nmap_Kd {texture}\n")).collect();
        finder.add_file(library.as_ref(), text.as_bytes());
        extra.material_libraries = vec![library];
        if extra.groups.is_empty() && attributes.groups.is_empty() {
            extra.groups = vec![Group::default()];
        }
        let number = |group: &Group| texture_number(&extra, group).filter(|&number| number < textures.len());
        let numbers: Vec<Option<usize>> = extra.groups.iter().map(number).collect();
        for (group, number) in extra.groups.iter_mut().zip(numbers) {
            group.material = number.map(|number| format!("texture_{number}"));
        }
    }
    extra
}

fn textures_of_comments(extra: &Extra, finder: &mut FileFinder) -> Vec<String> {
    let place = |name: &str| match finder.find("".as_ref(), name) {
        Some(found) => {
            let place = to_reference(&found.output_path);
            finder.add_image(&found.output_path, &found.bytes, ImageUse::Colours);
            place
        }
        None => name.to_string(),
    };
    comment_textures(extra).map(place).collect()
}

fn for_ply(
    extra: &Extra,
    attributes: &Attributes,
    name: &str,
    finder: &mut FileFinder,
    notes: &mut Vec<String>,
) -> Extra {
    let mut textures = textures_of_comments(extra, finder).into_iter();
    let mut extra = extra.clone();
    for comment in &mut extra.comments {
        if texture_name(comment).is_some() {
            *comment = textures.next().map_or_else(|| comment.clone(), |name| format!("comment TextureFile {name}"));
        }
    }
    // PLY groups faces by number columns and has no names.
    let named = |group: &Group| group.object.is_some() || group.name.is_some() || group.smoothing.is_some();
    if extra.groups.iter().any(named) {
        notes.push("ply cannot store objects, groups or smoothing groups: they are dropped".into());
    }
    // Without materials there is nothing to number.
    if extra.materials().is_empty() {
        return extra;
    }
    let mut libraries = Libraries::find(&extra, finder);
    // Textures of the mesh's own materials count like those of its libraries.
    libraries.textures.extend(MaterialLibrary::from_looks(&extra, name, finder).textures);
    // A PLY cannot name material libraries, so only their textures are copied.
    finder.files.retain(|file| libraries.textures.iter().any(|(_, place)| file.path == std::path::Path::new(place)));
    notes.push("ply cannot store materials: faces carry material numbers, and comments name the textures".into());
    let extra = with_material_numbers(extra, &libraries);
    if comment_textures(&extra).nth(1).is_some() { with_texture_coordinates_of_faces(extra, attributes) } else { extra }
}

// With several textures, MeshLab reads only coordinates stored per face.
fn with_texture_coordinates_of_faces(mut extra: Extra, attributes: &Attributes) -> Extra {
    let is_uv = |channel: &&Channel| channel.role == Role::Uv && channel.width == 2;
    if let Some(channel) = attributes.channels.iter().find(is_uv) {
        let columns = vec![Column { name: "texcoord".into(), scalar: Scalar::F32 }; 2];
        extra.layouts.retain(|layout| layout.channel != channel.name);
        extra.layouts.push(ColumnLayout { channel: channel.name.clone(), columns, per_corner: true });
    }
    extra
}

// The column is called `texnumber` if every material has a texture.
fn with_material_numbers(mut extra: Extra, libraries: &Libraries) -> Extra {
    let materials: Vec<String> = extra.materials().into_iter().map(String::from).collect();
    let of_materials: FxHashMap<&String, &String> =
        libraries.textures.iter().rev().map(|(name, at)| (name, at)).collect();
    let textures: Option<Vec<_>> = materials.iter().map(|material| of_materials.get(material)).collect();
    let name = if textures.is_some() { "texnumber" } else { "material_index" };
    let names = textures.into_iter().flatten().map(|place| format!("comment TextureFile {place}"));
    extra.comments.extend(names);
    // A single material needs no column.
    if materials.len() > 1 {
        extra.face_columns.push(Column { name: name.into(), scalar: Scalar::I32 });
        let numbers: FxHashMap<&String, usize> = materials.iter().zip(0..).collect();
        for group in &mut extra.groups {
            let number = group.material.as_ref().and_then(|material| numbers.get(material));
            // -1 means no material.
            group.values.push(number.map_or(-1.0, |&number| number as f64));
        }
    }
    extra
}

/// Returns a note on content that the format cannot store, or `None`.
pub fn describe_losses(format: Format, attributes: &Attributes, extra: &Extra) -> Option<String> {
    let is_storable = |channel: &&Channel| format.holds(channel.role);
    let mut dropped: Vec<&str> =
        attributes.channels.iter().filter(|it| !is_storable(it)).map(|channel| channel.name.as_str()).collect();
    if format == Format::ThreeMf {
        let has_texture = extra.looks.iter().any(|(_, look)| look.texture.is_some());
        let has_more = has_texture || !extra.material_libraries.is_empty();
        dropped.extend(has_more.then_some("material properties other than names and colours (Kd)"));
        return (!dropped.is_empty())
            .then(|| format!("3mf stores only geometry, names and colours: {} dropped", dropped.join(", ")));
    }
    if !format.is_bare() {
        return None;
    }
    // The order is the one in which a user would look for losses.
    if !extra.groups.is_empty() {
        dropped.push("groups");
    }
    if !extra.material_libraries.is_empty() || !extra.looks.is_empty() {
        dropped.push("materials");
    }
    (!dropped.is_empty()).then(|| format!("{} stores only geometry: {} dropped", format.name(), dropped.join(", ")))
}
