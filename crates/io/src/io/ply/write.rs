//! Writing of PLY.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use rustc_hash::{FxHashMap, FxHashSet};

use super::BLOCK;
use super::columns::{layout_of, unit};
use crate::io::attributed_writer::{WriteTask, WrittenModel};
use crate::io::companion_files::FileFinder;
use crate::io::extra::{Column, ColumnLayout, Extra, Group};
use crate::io::material_libraries::Libraries;
use crate::io::material_writer::MaterialLibrary;
use crate::io::texture_comments::{comment_textures, copy_comment_textures, texture_name};
use crate::io::write::Content;
use crate::io::{Format, Scalar, WriteError};
use crate::mesh::{Attributes, Channel, Role};
use crate::parallel;

// Blocks of rows that are written in parallel before they are joined: work for 64 threads, about 16 MiB.
const BATCH: usize = 64;

/// Writes a PLY; the textures of its materials are added to `finder`.
pub(in crate::io) fn write(task: &WriteTask, finder: &mut FileFinder) -> Result<WrittenModel, WriteError> {
    let WriteTask { content, attributes, options, .. } = task;
    let mut notes = Vec::new();
    let extra = &with_material_comments(task.extra, attributes, &options.name, finder, &mut notes);
    let as_text = options.format == Format::PlyAscii;
    let columns = Columns::from_channels(attributes, extra);
    // A vertex at a seam gets a row for each set of values of its corners.
    let rows = VertexRows::from_wedges(content, attributes, &columns.of_vertices);
    let n_rows = rows.sources.len();
    let n_repeated = n_rows - content.n_vertices();
    if n_repeated > 0 {
        notes.push(format!("ply stores one set of values per vertex: {n_repeated} vertices are duplicated at seams"));
    }
    let mut bytes = write_header(content, extra, &columns, n_rows, as_text).into_bytes();
    bytes.reserve(16 * (n_rows + rows.faces.len()));
    let table = Table { content, attributes, extra, columns, rows };
    write_rows(&mut bytes, n_rows, as_text, |writer, row| table.write_vertex(writer, row));
    write_rows(&mut bytes, content.faces.len(), as_text, |writer, face| table.write_face(writer, face));
    Ok(WrittenModel { bytes, notes, n_vertices: Some(n_rows), ..WrittenModel::default() })
}

fn with_material_comments(
    extra: &Extra,
    attributes: &Attributes,
    name: &str,
    finder: &mut FileFinder,
    notes: &mut Vec<String>,
) -> Extra {
    let mut textures = copy_comment_textures(extra, finder).into_iter();
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
    let places: FxHashSet<&Path> = libraries.textures.iter().map(|(_, place)| Path::new(place)).collect();
    finder.files.retain(|file| places.contains(file.path.as_path()));
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

/// Writes rows in parallel, a batch of blocks at a time to save memory.
fn write_rows(out: &mut Vec<u8>, n_rows: usize, as_text: bool, write: impl Fn(&mut ValueWriter, usize) + Sync) {
    let block = |rows: Range<usize>| {
        let mut writer = ValueWriter { out: Vec::with_capacity(16 * rows.len()), as_text };
        for row in rows {
            write(&mut writer, row);
            writer.end_row();
        }
        writer.out
    };
    let starts: Vec<usize> = (0..n_rows).step_by(BLOCK).collect();
    for starts in starts.chunks(BATCH) {
        let blocks = parallel::each(starts, |&start| block(start..n_rows.min(start + BLOCK)));
        blocks.iter().for_each(|block| out.extend_from_slice(block));
    }
}

struct Table<'a> {
    content: &'a Content<'a>,
    attributes: &'a Attributes,
    extra: &'a Extra,
    columns: Columns<'a>,
    rows: VertexRows<'a>,
}

impl Table<'_> {
    fn write_vertex(&self, writer: &mut ValueWriter, row: usize) {
        let (vertex, wedge) = self.rows.sources[row];
        writer.position(self.content, vertex as usize);
        for (channel, layout) in &self.columns.of_vertices {
            let value = wedge.map(|wedge| channel.value(wedge));
            for (i, column) in layout.columns.iter().enumerate() {
                let stated = value.map_or(0.0, |value| f64::from(value[i]));
                writer.value(column.scalar, stated * unit(channel.role, column.scalar));
            }
        }
    }

    fn write_face(&self, writer: &mut ValueWriter, face: usize) {
        let Self { attributes, extra, columns, .. } = self;
        writer.value(Scalar::U8, 3.0);
        self.rows.faces[face].into_iter().for_each(|row| writer.value(Scalar::I32, f64::from(row)));
        if let (Some((channel, layout)), Some(wedges)) = (columns.of_corners, attributes.wedges.get(face)) {
            writer.value(Scalar::U8, (3 * channel.width) as f64);
            let values = wedges.iter().flat_map(|&wedge| channel.value(wedge));
            values.for_each(|&value| writer.value(layout.columns[0].scalar, f64::from(value)));
        }
        let values = extra.group(attributes.group(face as u32)).map_or(&[][..], |group| &group.values);
        for (i, column) in extra.face_columns.iter().enumerate() {
            writer.value(column.scalar, values.get(i).copied().unwrap_or(0.0));
        }
    }
}

struct Columns<'a> {
    of_vertices: Vec<(&'a Channel, ColumnLayout)>,
    of_corners: Option<(&'a Channel, &'a ColumnLayout)>,
}

impl<'a> Columns<'a> {
    fn from_channels(attributes: &'a Attributes, extra: &'a Extra) -> Self {
        let mut columns = Self { of_vertices: Vec::new(), of_corners: None };
        // The first layout of a name counts.
        let layouts = extra.layouts.iter().rev().map(|layout| (layout.channel.as_str(), layout));
        let layouts: FxHashMap<&str, &ColumnLayout> = layouts.collect();
        let mut n_of_roles: FxHashMap<Role, usize> = FxHashMap::default();
        for channel in &attributes.channels {
            let layout = layouts.get(channel.name.as_str()).copied();
            let n_of_role = n_of_roles.entry(channel.role).or_insert(0);
            let n_before = *n_of_role;
            *n_of_role += 1;
            // PLY has one list of coordinates per face, so only one channel can go there.
            match layout.filter(|layout| layout.per_corner && channel.width == 2) {
                Some(layout) if columns.of_corners.is_none() => columns.of_corners = Some((channel, layout)),
                _ => columns.of_vertices.push((channel, layout_of(channel, layout, n_before))),
            }
        }
        columns
    }
}

struct VertexRows<'a> {
    // Vertex of each row, and a wedge with its values; the first n_vertices rows are the vertices in order.
    sources: Vec<(u32, Option<u32>)>,
    faces: Cow<'a, [[u32; 3]]>,
}

impl<'a> VertexRows<'a> {
    fn from_wedges(content: &Content<'a>, attributes: &Attributes, channels: &[(&Channel, ColumnLayout)]) -> Self {
        let mut sources: Vec<(u32, Option<u32>)> = (0..content.n_vertices() as u32).map(|v| (v, None)).collect();
        if channels.is_empty() {
            return Self { sources, faces: Cow::Borrowed(content.faces) };
        }
        let mut faces = content.faces.to_vec();
        // The rows of one vertex form a chain, so that a corner finds an equal row by a short walk.
        let mut next: Vec<Option<u32>> = vec![None; sources.len()];
        let same = |a: u32, b: u32| a == b || channels.iter().all(|(channel, _)| channel.value(a) == channel.value(b));
        for (corner, &wedge) in faces.iter_mut().flatten().zip(attributes.wedges.iter().flatten()) {
            loop {
                let row = *corner as usize;
                // A row takes the values of its first corner; corners with other values move to the next row of the
                // chain.
                if same(*sources[row].1.get_or_insert(wedge), wedge) {
                    break;
                }
                *corner = *next[row].get_or_insert(sources.len() as u32);
                if *corner as usize == sources.len() {
                    sources.push((sources[row].0, Some(wedge)));
                    next.push(None);
                }
            }
        }
        Self { sources, faces: Cow::Owned(faces) }
    }
}

fn write_header(content: &Content, extra: &Extra, columns: &Columns, n_rows: usize, as_text: bool) -> String {
    let encoding = if as_text { "ascii" } else { "binary_little_endian" };
    let mut header = format!("ply\nformat {encoding} 1.0\n");
    // Comments come before the elements, where readers expect texture names.
    for comment in &extra.comments {
        header += &format!("{comment}\n");
    }
    header += &format!("element vertex {n_rows}\n");
    let scalar = if content.double { Scalar::F64 } else { Scalar::F32 }.name();
    header += &format!("property {scalar} x\nproperty {scalar} y\nproperty {scalar} z\n");
    for column in columns.of_vertices.iter().flat_map(|(_, layout)| &layout.columns) {
        header += &format!("property {} {}\n", column.scalar.name(), column.name);
    }
    header += &format!("element face {}\nproperty list uchar int vertex_indices\n", content.faces.len());
    if let Some((_, layout)) = columns.of_corners {
        header += &format!("property list uchar {} texcoord\n", layout.columns[0].scalar.name());
    }
    for column in &extra.face_columns {
        header += &format!("property {} {}\n", column.scalar.name(), column.name);
    }
    header + "end_header\n"
}

struct ValueWriter {
    out: Vec<u8>,
    as_text: bool,
}

impl ValueWriter {
    fn value(&mut self, scalar: Scalar, value: f64) {
        if self.as_text {
            scalar.push_text(&mut self.out, value);
            self.out.push(b' ');
        } else {
            scalar.push_bytes(&mut self.out, value);
        }
    }

    fn position(&mut self, content: &Content, vertex: usize) {
        if self.as_text {
            content.push_position(&mut self.out, vertex);
            self.out.push(b' ');
        } else {
            let scalar = if content.double { Scalar::F64 } else { Scalar::F32 };
            content.position(vertex).into_iter().for_each(|x| scalar.push_bytes(&mut self.out, x));
        }
    }

    fn end_row(&mut self) {
        // The last blank of a row becomes the line end.
        if let Some(last) = self.out.last_mut().filter(|_| self.as_text) {
            *last = b'\n';
        }
    }
}
