//! Writing of PLY.

use rayon::prelude::*;

use super::BLOCK;
use super::columns::{layout_of, unit};
use crate::io::Scalar;
use crate::io::extra::{ColumnLayout, Extra};
use crate::io::write::{Content, push_rows};
use crate::mesh::{Attributes, Channel};

fn write_header(content: &Content, encoding: &str) -> String {
    let (n_vertices, n_faces) = (content.n_vertices(), content.faces.len());
    let scalar = if content.double { "double" } else { "float" };
    format!(
        "ply\nformat {encoding} 1.0\nelement vertex {n_vertices}\nproperty {scalar} x\nproperty {scalar} y\n\
         property {scalar} z\nelement face {n_faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

pub(in crate::io) fn write_binary(content: &Content) -> Vec<u8> {
    let header = write_header(content, "binary_little_endian").into_bytes();
    let stride = if content.double { 24 } else { 12 };
    let n_position_bytes = stride * content.n_vertices();
    let mut out = vec![0; header.len() + n_position_bytes + 13 * content.faces.len()];
    out[..header.len()].copy_from_slice(&header);
    let (positions, faces) = out[header.len()..].split_at_mut(n_position_bytes);
    positions.par_chunks_exact_mut(stride).with_min_len(BLOCK).enumerate().for_each(|(vertex, record)| {
        let position = content.position(vertex);
        if content.double {
            record.as_chunks_mut().0.iter_mut().zip(position).for_each(|(bytes, x)| *bytes = x.to_le_bytes());
        } else {
            record.as_chunks_mut().0.iter_mut().zip(position).for_each(|(bytes, x)| *bytes = (x as f32).to_le_bytes());
        }
    });
    faces.par_chunks_exact_mut(13).with_min_len(BLOCK).zip(content.faces).for_each(|(record, face)| {
        record[0] = 3;
        record[1..].as_chunks_mut().0.iter_mut().zip(face).for_each(|(bytes, v)| *bytes = v.to_le_bytes());
    });
    out
}

pub(in crate::io) fn write_text(content: &Content) -> Vec<u8> {
    let mut out = write_header(content, "ascii").into_bytes();
    push_rows(&mut out, content);
    out
}

/// Writes a PLY with attributes; returns its bytes and its number of vertex rows.
pub(in crate::io) fn write_attributed(
    content: &Content,
    attributes: &Attributes,
    extra: &Extra,
    as_text: bool,
    notes: &mut Vec<String>,
) -> (Vec<u8>, usize) {
    let columns = Columns::from_channels(attributes, extra);
    // A vertex at a seam gets a row for each set of values of its corners.
    let rows = VertexRows::from_wedges(content, attributes, &columns.of_vertices);
    let n_repeated = rows.sources.len() - content.n_vertices();
    if n_repeated > 0 {
        notes.push(format!("ply stores one set of values per vertex: {n_repeated} vertices are duplicated at seams"));
    }
    let mut out = write_full_header(content, extra, &columns, rows.sources.len(), as_text).into_bytes();
    let mut writer = ValueWriter { out: &mut out, as_text };
    write_vertices(&mut writer, content, &rows, &columns);
    write_faces(&mut writer, &rows, &columns, attributes, extra);
    (out, rows.sources.len())
}

fn write_vertices(writer: &mut ValueWriter, content: &Content, rows: &VertexRows, columns: &Columns) {
    for &(vertex, wedge) in &rows.sources {
        writer.position(content, vertex as usize);
        for (channel, layout) in &columns.of_vertices {
            let value = wedge.map(|wedge| channel.value(wedge));
            for (i, column) in layout.columns.iter().enumerate() {
                let stated = value.map_or(0.0, |value| f64::from(value[i]));
                writer.value(column.scalar, stated * unit(channel.role, column.scalar));
            }
        }
        writer.end_of_row();
    }
}

fn write_faces(writer: &mut ValueWriter, rows: &VertexRows, columns: &Columns, attributes: &Attributes, extra: &Extra) {
    for (face, corners) in rows.faces.iter().enumerate() {
        writer.value(Scalar::U8, 3.0);
        corners.iter().for_each(|&row| writer.value(Scalar::I32, f64::from(row)));
        if let (Some((channel, layout)), Some(wedges)) = (columns.of_corners, attributes.wedges.get(face)) {
            writer.value(Scalar::U8, (3 * channel.width) as f64);
            let values = wedges.iter().flat_map(|&wedge| channel.value(wedge));
            values.for_each(|&value| writer.value(layout.columns[0].scalar, f64::from(value)));
        }
        let values = extra.group(attributes.group(face as u32)).map_or(&[][..], |group| &group.values);
        for (i, column) in extra.face_columns.iter().enumerate() {
            writer.value(column.scalar, values.get(i).copied().unwrap_or(0.0));
        }
        writer.end_of_row();
    }
}

struct Columns<'a> {
    of_vertices: Vec<(&'a Channel, ColumnLayout)>,
    of_corners: Option<(&'a Channel, &'a ColumnLayout)>,
}

impl<'a> Columns<'a> {
    fn from_channels(attributes: &'a Attributes, extra: &'a Extra) -> Self {
        let mut columns = Self { of_vertices: Vec::new(), of_corners: None };
        for (i, channel) in attributes.channels.iter().enumerate() {
            // PLY has one list of coordinates per face, so only one channel can go there.
            let per_corner = extra.layout(&channel.name).filter(|layout| layout.per_corner && channel.width == 2);
            match per_corner {
                Some(layout) if columns.of_corners.is_none() => columns.of_corners = Some((channel, layout)),
                _ => {
                    let n_before = attributes.channels[..i].iter().filter(|other| other.role == channel.role).count();
                    columns.of_vertices.push((channel, layout_of(channel, extra, n_before)));
                }
            }
        }
        columns
    }
}

struct VertexRows {
    // Vertex of each row, and a wedge with its values; the first n_vertices rows are the vertices in order.
    sources: Vec<(u32, Option<u32>)>,
    faces: Vec<[u32; 3]>,
}

impl VertexRows {
    fn from_wedges(content: &Content, attributes: &Attributes, channels: &[(&Channel, ColumnLayout)]) -> Self {
        let mut sources: Vec<(u32, Option<u32>)> = (0..content.n_vertices() as u32).map(|v| (v, None)).collect();
        let mut faces = content.faces.to_vec();
        if channels.is_empty() {
            return Self { sources, faces };
        }
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
        Self { sources, faces }
    }
}

fn write_full_header(content: &Content, extra: &Extra, columns: &Columns, n_rows: usize, as_text: bool) -> String {
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

struct ValueWriter<'a> {
    out: &'a mut Vec<u8>,
    as_text: bool,
}

impl ValueWriter<'_> {
    fn value(&mut self, scalar: Scalar, value: f64) {
        if self.as_text {
            scalar.push_text(self.out, value);
            self.out.push(b' ');
        } else {
            scalar.push_bytes(self.out, value);
        }
    }

    fn position(&mut self, content: &Content, vertex: usize) {
        if self.as_text {
            content.push_position(self.out, vertex);
            self.out.push(b' ');
        } else {
            let scalar = if content.double { Scalar::F64 } else { Scalar::F32 };
            content.position(vertex).into_iter().for_each(|x| scalar.push_bytes(self.out, x));
        }
    }

    fn end_of_row(&mut self) {
        // The last blank of a row becomes the line end.
        if let Some(last) = self.out.last_mut().filter(|_| self.as_text) {
            *last = b'\n';
        }
    }
}
