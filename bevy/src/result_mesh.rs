//! Conversion of results to Bevy meshes.

use bevy_mesh::morph::MorphAttributes;
use bevy_mesh::{Indices, Mesh, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues};
use neural_mesh::mesh::{Channel, first_equal};
use neural_mesh::simplify::Simplified;

use crate::mesh_source::{ContentKind, MeshSource};
use crate::vertex_values::write_floats;

/// Largest number of vertices that 16 bits can name, one less for the index that restarts strips.
pub const MAX_SHORT: usize = 65_535;

/// Makes a mesh with one vertex per position and wedge, and the attributes, index size and usage of the original.
///
/// A mesh without indices gets indices of 16 bits if they suffice.
pub fn make_mesh(original: &Mesh, source: &MeshSource, result: &Simplified) -> Mesh {
    let vertices = ResultVertices::new(result);
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, original.asset_usage);
    mesh.enable_raytracing = original.enable_raytracing;
    let position = |&corner: &u32| {
        let v = result.mesh.faces().as_flattened()[corner as usize];
        source.cleaned.frame.to_file(result.mesh.positions()[v as usize]).map(|x| x as f32)
    };
    let positions: Vec<[f32; 3]> = vertices.corners.iter().map(position).collect();
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    let mut morphs: Vec<MorphAttributes> = Vec::new();
    for content in &source.contents {
        let channels = &result.attributes.channels;
        let Some(channel) = channels.iter().find(|channel| channel.name == content.name) else { continue };
        let values = vertices.gather(result, channel);
        match content.kind {
            ContentKind::Attribute(attribute) => insert_floats(&mut mesh, attribute, values),
            ContentKind::Skin { joints, weights } => {
                let rows = values.as_chunks::<8>().0;
                let indices = rows.iter().map(|&[a, b, c, d, ..]| [a, b, c, d].map(|x| x as u16)).collect();
                mesh.insert_attribute(joints, VertexAttributeValues::Uint16x4(indices));
                insert_floats(&mut mesh, weights, rows.iter().flat_map(|&[.., e, f, g, h]| [e, f, g, h]).collect());
            }
            ContentKind::Morph { target, part } => {
                let n_vertices = vertices.corners.len();
                morphs.resize(morphs.len().max((target + 1) * n_vertices), MorphAttributes::default());
                place_offsets(&mut morphs[target * n_vertices..], &values, part);
            }
        }
    }
    finish(mesh, original, morphs, vertices.to_indices(source.is_short))
}

/// Inserts floats in the attribute's format, which was read and so can be written.
fn insert_floats(mesh: &mut Mesh, attribute: MeshVertexAttribute, floats: Vec<f32>) {
    if let Some(values) = write_floats(attribute.format, floats) {
        mesh.insert_attribute(attribute, values);
    }
}

/// Adds morph targets, bounds of joints and indices.
fn finish(mut mesh: Mesh, original: &Mesh, morphs: Vec<MorphAttributes>, indices: Indices) -> Mesh {
    if !morphs.is_empty() {
        mesh.set_morph_targets(morphs);
        if let Some(names) = original.morph_target_names() {
            mesh.set_morph_target_names(names.to_vec());
        }
    }
    mesh.insert_indices(indices);
    // Bounds of joints hold vertices that may have moved, so they are found again.
    if original.skinned_mesh_bounds().is_some() && mesh.generate_skinned_mesh_bounds().is_err() {
        mesh.set_skinned_mesh_bounds(original.skinned_mesh_bounds().cloned());
    }
    mesh
}

fn place_offsets(rows: &mut [MorphAttributes], values: &[f32], part: usize) {
    for (row, &offset) in rows.iter_mut().zip(values.as_chunks::<3>().0) {
        let place = [&mut row.position, &mut row.normal, &mut row.tangent];
        place.into_iter().skip(part).take(1).for_each(|place| *place = offset.into());
    }
}

/// Vertices of the Bevy mesh: the different pairs of position and wedge.
struct ResultVertices {
    // First corner of each vertex, n_vertices.
    corners: Vec<u32>,
    // Vertex of each corner, 3 n_faces.
    indices: Vec<u32>,
}

impl ResultVertices {
    fn new(result: &Simplified) -> Self {
        let faces = result.mesh.faces().as_flattened();
        let wedges = result.attributes.wedges.as_flattened();
        let wedge = |corner: usize| wedges.get(corner).copied().unwrap_or(0);
        let (first, _) = first_equal(faces.len(), |corner| [faces[corner], wedge(corner), 0]);
        let mut number = vec![0; faces.len()];
        let (mut corners, mut indices) = (Vec::new(), Vec::with_capacity(faces.len()));
        for (corner, &first) in (0u32..).zip(&first) {
            if corner == first {
                number[corner as usize] = corners.len() as u32;
                corners.push(corner);
            }
            indices.push(number[first as usize]);
        }
        Self { corners, indices }
    }

    /// Returns the values of a channel, n_vertices x width.
    fn gather(&self, result: &Simplified, channel: &Channel) -> Vec<f32> {
        let wedges = result.attributes.wedges.as_flattened();
        self.corners.iter().flat_map(|&corner| channel.value(wedges[corner as usize])).copied().collect()
    }

    fn to_indices(&self, is_short: Option<bool>) -> Indices {
        if is_short.unwrap_or(true) && self.corners.len() <= MAX_SHORT {
            Indices::U16(self.indices.iter().map(|&index| index as u16).collect())
        } else {
            Indices::U32(self.indices.clone())
        }
    }
}
