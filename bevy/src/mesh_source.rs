//! Conversion of Bevy meshes to meshes of the library.

use bevy_mesh::{
    Indices, Mesh, MeshVertexAttribute, MeshVertexAttributeId, PrimitiveTopology, VertexAttributeValues, VertexFormat,
};
use neural_mesh::mesh::cleanup::{CleanOptions, Cleaned, clean};
use neural_mesh::mesh::{Attributes, Channel, RawMesh, Role};
use neural_mesh::simplify::Input;

use crate::MeshError;
use crate::vertex_values::read_floats;
use crate::wedges::find_wedges;

/// Mesh of the library made from a Bevy mesh, and the content of its channels.
pub struct MeshSource {
    /// Valid mesh whose vertices are the different positions, with the attributes at its corners.
    pub cleaned: Cleaned,
    /// Content of each channel.
    pub contents: Vec<ChannelContent>,
    /// True if indices had 16 bits.
    pub is_short: Option<bool>,
}

/// Content of a channel, by which it returns to a Bevy mesh.
pub struct ChannelContent {
    /// Name of the channel, unique in the mesh.
    pub name: String,
    /// Kind of content.
    pub kind: ContentKind,
}

/// Kind of content.
#[derive(Clone, Copy)]
pub enum ContentKind {
    /// One attribute.
    Attribute(MeshVertexAttribute),
    /// Joint indices and joint weights.
    Skin {
        /// Attribute of the indices.
        joints: MeshVertexAttribute,
        /// Attribute of the weights.
        weights: MeshVertexAttribute,
    },
    /// Offsets of a morph target.
    Morph {
        /// Number of the target.
        target: usize,
        /// 0 for positions, 1 for normals, 2 for tangents.
        part: usize,
    },
}

impl MeshSource {
    /// Reads a mesh: joins vertices at one position, and vertices that are equal in all attributes.
    ///
    /// # Errors
    /// [`MeshError`] names what cannot be read.
    pub fn read(mesh: &Mesh) -> Result<Self, MeshError> {
        let (positions, corners) = read_triangles(mesh)?;
        let (mut channels, mut contents) = (Vec::new(), Vec::new());
        let mut add = |role, width, values, kind| {
            let name = format!("{}", contents.len());
            channels.push(Channel { name: name.clone(), role, width, values });
            contents.push(ChannelContent { name, kind });
        };
        read_skin(mesh, positions.len(), &mut add)?;
        read_attributes(mesh, positions.len(), &mut add)?;
        read_morph_targets(mesh, positions.len(), &mut add)?;
        let wedges = if channels.is_empty() { Vec::new() } else { find_wedges(positions, &channels) };
        let wide = positions.iter().map(|position| position.map(f64::from)).collect();
        let mut raw = RawMesh::new(wide, corners);
        if !channels.is_empty() {
            let wedges = raw.faces.iter().map(|face| face.map(|v| wedges[v as usize])).collect();
            raw.attributes = Attributes { wedges, channels, groups: Vec::new() };
        }
        let is_short = mesh.indices().map(|indices| matches!(indices, Indices::U16(_)));
        Ok(Self { cleaned: clean(raw, &CleanOptions::default())?, contents, is_short })
    }

    /// Returns the mesh with its attributes as the simplifier takes it.
    pub fn input(&self) -> Input<'_> {
        let mut input = Input::bare(&self.cleaned.mesh);
        input.attributes = &self.cleaned.attributes;
        input
    }
}

/// Positions, and the vertices of each triangle.
type Triangles<'a> = (&'a [[f32; 3]], Vec<[u32; 3]>);

/// Reads positions and triangles alone.
///
/// # Errors
/// [`MeshError`] for a mesh that is no list of triangles.
pub fn read_triangles(mesh: &Mesh) -> Result<Triangles<'_>, MeshError> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return Err(MeshError::Topology(mesh.primitive_topology()));
    }
    let positions = read_positions(mesh)?;
    Ok((positions, read_corners(mesh, positions.len())?))
}

type AddChannel<'a> = dyn FnMut(Role, usize, Vec<f32>, ContentKind) + 'a;

fn read_positions(mesh: &Mesh) -> Result<&[[f32; 3]], MeshError> {
    match mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION)? {
        Some(VertexAttributeValues::Float32x3(positions)) => Ok(positions),
        Some(values) => Err(format_error(&Mesh::ATTRIBUTE_POSITION, values)),
        None => Err(MeshError::NoPositions),
    }
}

/// Returns the vertices of each triangle.
fn read_corners(mesh: &Mesh, n_vertices: usize) -> Result<Vec<[u32; 3]>, MeshError> {
    let indices: Vec<u32> = match mesh.try_indices_option()? {
        Some(Indices::U16(indices)) => indices.iter().map(|&index| u32::from(index)).collect(),
        Some(Indices::U32(indices)) => indices.clone(),
        None => (0..n_vertices as u32).collect(),
    };
    if let Some(&index) = indices.iter().find(|&&index| index as usize >= n_vertices) {
        return Err(MeshError::Index { index, n_vertices });
    }
    let (corners, rest) = indices.as_chunks();
    if rest.is_empty() { Ok(corners.to_vec()) } else { Err(MeshError::IndexCount(indices.len())) }
}

fn read_skin(mesh: &Mesh, n_vertices: usize, add: &mut AddChannel) -> Result<(), MeshError> {
    let [joints, weights] = [Mesh::ATTRIBUTE_JOINT_INDEX, Mesh::ATTRIBUTE_JOINT_WEIGHT];
    let (of_joints, of_weights) = (find_attribute(mesh, joints.id)?, find_attribute(mesh, weights.id)?);
    let ((joints, joint_rows), (weights, weight_rows)) = match (of_joints, of_weights) {
        (Some(joints), Some(weights)) => (joints, weights),
        (None, None) => return Ok(()),
        _ => return Err(MeshError::HalfSkin),
    };
    let VertexAttributeValues::Uint16x4(joint_rows) = joint_rows else { return Err(format_error(joints, joint_rows)) };
    let Some((4, floats)) = read_floats(weight_rows) else { return Err(format_error(weights, weight_rows)) };
    check_length(joints.name, joint_rows.len(), n_vertices)?;
    check_length(weights.name, weight_rows.len(), n_vertices)?;
    let row = |(joints, weights): (&[u16; 4], &[f32; 4])| {
        let [a, b, c, d] = joints.map(f32::from);
        let [e, f, g, h] = *weights;
        [a, b, c, d, e, f, g, h]
    };
    let values = joint_rows.iter().zip(floats.as_chunks().0).flat_map(row).collect();
    add(Role::Skin, 8, values, ContentKind::Skin { joints: *joints, weights: *weights });
    Ok(())
}

fn read_attributes(mesh: &Mesh, n_vertices: usize, add: &mut AddChannel) -> Result<(), MeshError> {
    for (attribute, values) in mesh.try_attributes()? {
        let role = match attribute.id {
            id if id == Mesh::ATTRIBUTE_POSITION.id => continue,
            id if id == Mesh::ATTRIBUTE_JOINT_INDEX.id || id == Mesh::ATTRIBUTE_JOINT_WEIGHT.id => continue,
            id if id == Mesh::ATTRIBUTE_NORMAL.id => Role::Normal,
            id if id == Mesh::ATTRIBUTE_TANGENT.id => Role::Tangent,
            id if id == Mesh::ATTRIBUTE_UV_0.id || id == Mesh::ATTRIBUTE_UV_1.id => Role::Uv,
            id if id == Mesh::ATTRIBUTE_COLOR.id => Role::Colour,
            _ => Role::Other,
        };
        // Compressed normals, tangents and texture coordinates are encoded, so that their numbers are no directions.
        let is_usual = match role {
            Role::Normal => attribute.format == VertexFormat::Float32x3,
            Role::Tangent => attribute.format == VertexFormat::Float32x4,
            Role::Uv => attribute.format == VertexFormat::Float32x2,
            _ => true,
        };
        let floats = read_floats(values).filter(|(width, _)| is_usual && (role != Role::Colour || *width == 4));
        let (width, floats) = floats.ok_or_else(|| format_error(attribute, values))?;
        check_length(attribute.name, values.len(), n_vertices)?;
        add(role, width, floats, ContentKind::Attribute(*attribute));
    }
    Ok(())
}

/// Reads morph targets, which follow one another with one row per vertex each.
fn read_morph_targets(mesh: &Mesh, n_vertices: usize, add: &mut AddChannel) -> Result<(), MeshError> {
    if !mesh.try_has_morph_targets()? {
        return Ok(());
    }
    let rows = mesh.try_morph_targets()?;
    if n_vertices == 0 || !rows.len().is_multiple_of(n_vertices) {
        return Err(MeshError::Length { attribute: "morph targets", n_rows: rows.len(), n_vertices });
    }
    for (target, rows) in rows.chunks(n_vertices).enumerate() {
        let roles = [Role::MorphPosition, Role::MorphDirection, Role::MorphDirection];
        for (part, role) in roles.into_iter().enumerate() {
            let values = rows.iter().flat_map(|row| [row.position, row.normal, row.tangent][part].to_array());
            let values: Vec<f32> = values.collect();
            // Targets without normals or tangents have zeros, which come back without a channel.
            if role == Role::MorphPosition || values.iter().any(|&x| x != 0.0) {
                add(role, 3, values, ContentKind::Morph { target, part });
            }
        }
    }
    Ok(())
}

/// Returns an attribute as the mesh has it, which may be in another format than the usual one.
fn find_attribute(
    mesh: &Mesh,
    id: MeshVertexAttributeId,
) -> Result<Option<(&MeshVertexAttribute, &VertexAttributeValues)>, MeshError> {
    Ok(mesh.try_attributes()?.find(|(attribute, _)| attribute.id == id))
}

fn check_length(attribute: &'static str, n_rows: usize, n_vertices: usize) -> Result<(), MeshError> {
    if n_rows == n_vertices { Ok(()) } else { Err(MeshError::Length { attribute, n_rows, n_vertices }) }
}

fn format_error(attribute: &MeshVertexAttribute, values: &VertexAttributeValues) -> MeshError {
    MeshError::Format { attribute: attribute.name, format: values.into() }
}
