//! Reading of a PLY, with or without attributes.

use super::columns::{ChannelPlan, unit};
use super::header::{Element, Header};
use super::source::Source;
use super::{BLOCK, decode_positions, open, read_leading_triangles, records};
use crate::io::corner_wedges::CornerWedges;
use crate::io::extra::{Column, ColumnLayout, Extra, Group, ReadMesh, has_too_many_groups, replace_non_finite};
use crate::io::memory::add_zeros;
use crate::io::{ReadError, Scalar};
use crate::mesh::{Attributes, Channel, DistinctKeys, Fans, RawMesh, Role};
use crate::parallel;

// With more distinct combinations, the numbers of faces identify faces and not groups.
const MOST_GROUPS: usize = 1 << 16;

pub(super) const LIST_NAMES: [&str; 2] = ["vertex_indices", "vertex_index"];

type RowValues = [Vec<f64>];

fn for_each_row(
    source: &mut Source,
    element: &Element,
    first: usize,
    take: impl FnMut(&RowValues),
) -> Result<(), ReadError> {
    match read_rows(source, element, first, take) {
        n if n < element.count => Err(source.cut_error(element, n)),
        _ => Ok(()),
    }
}

/// Passes rows from number `first` on to `take`; returns the number of a row that is cut, else that of all.
pub(super) fn read_rows(
    source: &mut Source,
    element: &Element,
    first: usize,
    mut take: impl FnMut(&RowValues),
) -> usize {
    let mut row = vec![vec![0.0]; element.properties.len()];
    // An element without properties takes no bytes, whatever its count: a loop over it could take forever.
    let n_rows = if row.is_empty() { first } else { element.count };
    for number in first..n_rows {
        let start = source.byte();
        if read_row(source, element, &mut row).is_none() {
            source.return_to(start);
            return number;
        }
        source.end_row();
        take(&row);
    }
    element.count
}

fn read_row(source: &mut Source, element: &Element, row: &mut RowValues) -> Option<()> {
    for (property, values) in element.properties.iter().zip(row) {
        let Some(length) = property.length else {
            values[0] = source.scalar(property.scalar)?;
            continue;
        };
        // A count that is negative or no number means none.
        let n_values = source.scalar(length)?.max(0.0) as u64;
        values.clear();
        for _ in 0..n_values {
            values.push(source.scalar(property.scalar)?);
        }
    }
    Some(())
}

/// Replaces `polygon` by the vertices of a list; a negative index becomes the largest.
pub(super) fn read_polygon(list: &[f64], polygon: &mut Vec<u32>) {
    polygon.clear();
    polygon.extend(list.iter().map(|&value| if value >= 0.0 { value as u32 } else { u32::MAX }));
}

#[derive(Default)]
pub(super) struct PlyReader {
    reads_attributes: bool,
    mesh: RawMesh,
    fans: Fans,
    channels: Vec<Channel>,
    layouts: Vec<ColumnLayout>,
    // Vertices and texture coordinates, as bits.
    corners: Option<CornerWedges>,
    groups: NumberedGroups,
    notes: Vec<String>,
}

impl PlyReader {
    pub fn read(bytes: &[u8], header: Header, reads_attributes: bool) -> Result<ReadMesh, ReadError> {
        let mut reader = Self { reads_attributes, ..Self::default() };
        let mut source = open(bytes, &header);
        // Corners of strips carry no texture coordinates, so those of faces would not cover the mesh.
        let with_strips = header.elements.iter().any(|element| element.name == "tristrips");
        for element in &header.elements {
            match element.name.as_str() {
                "vertex" => reader.read_vertices(&mut source, element)?,
                "face" => reader.read_faces(&mut source, element, with_strips)?,
                "tristrips" => reader.read_strips(&mut source, element)?,
                _ => {
                    for_each_row(&mut source, element, 0, |_| ())?;
                    if element.count > 0 {
                        reader.notes.push(format!("{} rows of the element {} dropped", element.count, element.name));
                    }
                }
            }
        }
        Ok(reader.finish(header.comments))
    }

    fn read_vertices(&mut self, source: &mut Source, element: &Element) -> Result<(), ReadError> {
        let axes = [element.scalar("x")?, element.scalar("y")?, element.scalar("z")?];
        // Whole numbers of 32 bits need doubles as well.
        self.mesh.double |= axes.iter().any(|&axis| element.properties[axis].scalar.is_wide());
        // The names of columns alone decide which columns form a channel.
        let plans = if self.reads_attributes { ChannelPlan::for_element(element, &axes) } else { Vec::new() };
        // Lists per vertex fit no channel.
        for property in element.properties.iter().filter(|property| property.length.is_some()) {
            self.notes.push(format!("the list {} of the vertices is dropped", property.name));
        }
        let mut tables = vec![Vec::new(); plans.len()];
        let positions = &mut self.mesh.positions;
        // Rows of equal length are decoded in parallel, after the check that all of them exist.
        if let (Source::Binary { bytes, at, big }, Some((offsets, stride))) = (&mut *source, element.layout()) {
            // The count is compared with the bytes before memory is reserved.
            let Some(records) = records(&bytes[*at..], element.count, stride) else {
                return Err(source.cut_error(element, source.n_bytes_left() / stride));
            };
            let scalars = axes.map(|axis| (offsets[axis], element.properties[axis].scalar));
            let first = positions.len();
            add_zeros(positions, element.count)?;
            decode_positions(records, stride, scalars, *big, &mut positions[first..]);
            for (table, plan) in tables.iter_mut().zip(&plans) {
                *table = decode_channel(records, stride, &channel_values(plan, element, Some(&offsets)), *big);
            }
            *at += records.len();
        } else {
            let columns: Vec<_> = plans.iter().map(|plan| channel_values(plan, element, None)).collect();
            for_each_row(source, element, 0, |row| {
                positions.push(axes.map(|axis| row[axis][0]));
                for (table, columns) in tables.iter_mut().zip(&columns) {
                    table.extend(columns.iter().map(|column| (row[column.property][0] / column.unit) as f32));
                }
            })?;
        }
        for (plan, values) in plans.iter().zip(tables) {
            self.layouts.push(plan.layout(&element.properties));
            self.add_channel(plan, values);
        }
        Ok(())
    }

    fn add_channel(&mut self, plan: &ChannelPlan, mut values: Vec<f32>) {
        // Later fits need finite values.
        let n_not_finite = replace_non_finite(&mut values);
        if n_not_finite > 0 {
            self.notes.push(format!("{n_not_finite} values of {} are not finite: they become 0", plan.name));
        }
        // Labels are stored as singles, which hold whole numbers only up to 2^24.
        if plan.role == Role::Label && values.iter().any(|value| value.abs() >= (1 << 24) as f32) {
            self.notes.push(format!("values of {} from 16777216 on are rounded to single precision", plan.name));
        }
        let width = plan.properties.len();
        self.channels.push(Channel { name: plan.name.clone(), role: plan.role, width, values });
    }

    fn read_faces(&mut self, source: &mut Source, element: &Element, with_strips: bool) -> Result<(), ReadError> {
        let Some(list) = element.list(&LIST_NAMES) else {
            // An empty table of faces may lack the list.
            return if element.count > 0 { Err(element.missing_error("list of vertex_indices")) } else { Ok(()) };
        };
        let texcoord = element.list(&["texcoord"]).filter(|_| self.reads_attributes && !with_strips);
        // Columns of whole numbers are taken as groups of faces: materials, labels, components.
        let is_group = |&i: &usize| element.properties[i].length.is_none() && element.properties[i].scalar.is_whole();
        let columns: Vec<usize> =
            (0..element.properties.len()).filter(|i| self.reads_attributes && is_group(i)).collect();
        for (i, property) in element.properties.iter().enumerate() {
            if i != list && Some(i) != texcoord && !columns.contains(&i) {
                self.notes.push(format!("the property {} of the faces is dropped", property.name));
            }
        }
        let column =
            |&i: &usize| Column { name: element.properties[i].name.clone(), scalar: element.properties[i].scalar };
        self.groups.columns = columns.iter().map(column).collect();
        self.corners = texcoord.map(|_| CornerWedges::default());
        let mut polygon = Vec::new();
        // Nearly all files consist of triangles, which are decoded in parallel; other faces go through the loop.
        let first = read_leading_triangles(source, element, 0, &mut self.mesh.faces)?;
        for_each_row(source, element, first, |row| {
            read_polygon(&row[list], &mut polygon);
            if let (Some(corners), Some(texcoord)) = (&mut self.corners, texcoord) {
                number_corners(corners, &mut polygon, &row[texcoord]);
            }
            let is_face = self.fans.push(&polygon, &mut self.mesh.faces);
            self.mesh.dropped_faces += usize::from(!is_face);
            self.groups.assign(columns.iter().map(|&i| row[i][0] as i64), self.mesh.faces.len());
        })
    }

    fn read_strips(&mut self, source: &mut Source, element: &Element) -> Result<(), ReadError> {
        let list = element.list(&LIST_NAMES).ok_or_else(|| element.missing_error("list of vertex_indices"))?;
        let mut indices = Vec::new();
        for_each_row(source, element, 0, |row| {
            read_polygon(&row[list], &mut indices);
            // -1 starts a new strip; each index after the first two makes a face with those before it.
            for strip in indices.split(|&index| index == u32::MAX) {
                for (i, corners) in strip.windows(3).enumerate() {
                    let [a, b, c] = [corners[0], corners[1], corners[2]];
                    // Strips repeat a vertex to turn, which makes no face.
                    if a != b && b != c && c != a {
                        self.mesh.faces.push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
                    }
                }
            }
        })
    }

    fn finish(mut self, comments: Vec<String>) -> ReadMesh {
        self.groups.drop_excessive(&mut self.notes);
        let RawMesh { positions, faces, attributes, .. } = &mut self.mesh;
        let mut channels = self.channels;
        if let Some(corners) = self.corners {
            attributes.wedges = corners.finish_faces(self.fans, positions, faces);
            for Channel { values, width, .. } in &mut channels {
                // Absent vertices have zeros.
                let zeros = || vec![0.0; corners.keys().len() * *width];
                *values = corners.values(0, values, *width).unwrap_or_else(zeros);
            }
            // Vertices may have coordinates named `uv` already.
            let name = if channels.iter().any(|channel| channel.name == "uv") { "texcoord" } else { "uv" };
            let column = Column { name: "texcoord".into(), scalar: Scalar::F32 };
            let columns = vec![column.clone(), column];
            self.layouts.push(ColumnLayout { channel: name.into(), columns, per_corner: true });
            let values = corners.keys().iter().flat_map(|&[_, u, v]| [u, v].map(f32::from_bits)).collect();
            channels.push(Channel { name: name.into(), role: Role::Uv, width: 2, values });
        } else {
            self.fans.triangulate(positions, faces);
            attributes.wedges = if channels.is_empty() { Vec::new() } else { faces.clone() };
        }
        let NumberedGroups { columns: face_columns, values, mut of_faces, .. } = self.groups;
        let group =
            |values: &Vec<i64>| Group { values: values.iter().map(|&x| x as f64).collect(), ..Group::default() };
        let groups: Vec<Group> = values.keys.iter().map(group).collect();
        // Faces from strips have no numbers: they join the first group.
        of_faces.resize(if groups.len() > 1 { faces.len() } else { 0 }, 0);
        let wedges = std::mem::take(&mut attributes.wedges);
        *attributes = Attributes { wedges, channels, groups: of_faces };
        let extra = Extra { groups, face_columns, layouts: self.layouts, comments, ..Extra::default() };
        ReadMesh { mesh: self.mesh, extra, notes: self.notes, format: None }
    }
}

struct ChannelValue {
    property: usize,
    offset: usize,
    scalar: Scalar,
    unit: f64,
}

fn channel_values(plan: &ChannelPlan, element: &Element, offsets: Option<&[usize]>) -> Vec<ChannelValue> {
    let number = |&property: &usize| {
        let scalar = element.properties[property].scalar;
        let offset = offsets.map_or(0, |offsets| offsets[property]);
        ChannelValue { property, offset, scalar, unit: unit(plan.role, scalar) }
    };
    plan.properties.iter().map(number).collect()
}

fn decode_channel(records: &[u8], stride: usize, columns: &[ChannelValue], big: bool) -> Vec<f32> {
    let width = columns.len();
    let mut values = vec![0.0; records.len() / stride * width];
    parallel::rows_mut(&mut values, width, BLOCK, |row, values| {
        let record = &records[stride * row..][..stride];
        for (value, column) in values.iter_mut().zip(columns) {
            let number = column.scalar.decode(&record[column.offset..], big).unwrap_or(0.0);
            *value = (number / column.unit) as f32;
        }
    });
    values
}

fn number_corners(wedges: &mut CornerWedges, polygon: &mut [u32], uvs: &[f64]) {
    // A list of another length cannot be assigned to corners.
    let fits = uvs.len() == 2 * polygon.len();
    for (i, corner) in polygon.iter_mut().enumerate() {
        let uv = [2 * i, 2 * i + 1].map(|at| if fits { uvs[at] as f32 } else { 0.0 });
        // Adding zero turns -0 into 0.
        let [u, v] = uv.map(|x| if x.is_finite() { (x + 0.0).to_bits() } else { 0 });
        *corner = wedges.number([*corner, u, v]);
    }
}

#[derive(Default)]
struct NumberedGroups {
    columns: Vec<Column>,
    values: DistinctKeys<Vec<i64>>,
    of_faces: Vec<u32>,
    too_many: bool,
}

impl NumberedGroups {
    fn assign(&mut self, values: impl Iterator<Item = i64>, n_faces: usize) {
        if self.columns.is_empty() || self.too_many {
            return;
        }
        let number = self.values.number(values.collect());
        // Such numbers identify faces instead of groups; further counting would only cost memory.
        self.too_many = self.values.keys.len() > MOST_GROUPS;
        self.of_faces.resize(n_faces, number);
    }

    fn drop_excessive(&mut self, notes: &mut Vec<String>) {
        let n_groups = self.values.keys.len();
        if self.too_many || has_too_many_groups(n_groups, self.of_faces.len()) {
            let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
            notes.push(format!(
                "the face property {} has too many different values to form groups: it is dropped",
                names.join(", ")
            ));
            *self = Self::default();
        }
    }
}
