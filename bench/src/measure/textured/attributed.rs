//! meshoptimizer's `simplifyWithAttributes`, called as its own gltfpack calls it: vertices split where their attributes
//! differ, seams kept, no limit but the number of faces.

use std::collections::HashMap;

use anyhow::Result;
use meshopt::{SimplifyOptions, VertexDataAdapter, simplify_with_attributes_and_locks, typed_to_bytes};
use neural_mesh::mesh::{Attributes, Channel, Role, compact};

use super::Carrier;

/// What the attributes count beside the position, whose unit is the extent of the mesh.
#[derive(Clone, Copy)]
pub enum Weighting {
    /// As gltfpack: each number of a normal 0.5, of a colour 1, texture coordinates nothing.
    Gltfpack,
    /// Each number of texture coordinates 1 beside that.
    WithUvs,
}

impl Weighting {
    pub const ALL: [Self; 2] = [Self::Gltfpack, Self::WithUvs];

    fn of(self, role: Role) -> f32 {
        match (role, self) {
            (Role::Normal, _) => 0.5,
            (Role::Colour, _) | (Role::Uv, Self::WithUvs) => 1.0,
            _ => 0.0,
        }
    }
}

/// What it makes of a mesh down to a number of faces; it stops above where seams hold it.
pub fn simplified(original: &Carrier, n_faces: usize, weighting: Weighting) -> Result<Carrier> {
    let split = Split::of(original);
    let positions: Vec<[f32; 3]> = split.corners.iter().map(|c| original.mesh.positions()[c.vertex as usize]).collect();
    let (weights, values) = weighed(&original.attributes, &split.corners, weighting);
    let vertices = VertexDataAdapter::new(typed_to_bytes(&positions), size_of::<[f32; 3]>(), 0)?;
    let unlocked = vec![false; positions.len()];
    let stride = weights.len() * size_of::<f32>();
    let indices = simplify_with_attributes_and_locks(
        split.faces.as_flattened(),
        &vertices,
        &values,
        &weights,
        stride,
        &unlocked,
        3 * n_faces.min(split.faces.len()),
        1e10,
        SimplifyOptions::None,
        None,
    );
    split.united(original, indices.as_chunks().0)
}

/// A corner as a vertex of its own: where it is, what it carries, of which material it is.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    vertex: u32,
    wedge: u32,
    group: u32,
}

/// The mesh with a vertex for each kind of corner.
struct Split {
    corners: Vec<Corner>,
    faces: Vec<[u32; 3]>,
}

impl Split {
    fn of(Carrier { mesh, attributes }: &Carrier) -> Self {
        let mut split = Self { corners: Vec::new(), faces: Vec::new() };
        let mut known: HashMap<Corner, u32> = HashMap::new();
        for (f, face) in mesh.faces().iter().enumerate() {
            let wedges = attributes.wedges.get(f).copied().unwrap_or_default();
            let group = attributes.group(f as u32);
            split.faces.push(std::array::from_fn(|i| {
                let corner = Corner { vertex: face[i], wedge: wedges[i], group };
                *known.entry(corner).or_insert_with(|| {
                    split.corners.push(corner);
                    split.corners.len() as u32 - 1
                })
            }));
        }
        split
    }

    /// Faces over the split vertices as a mesh that shares vertices, with what its corners carry.
    fn united(&self, original: &Carrier, faces: &[[u32; 3]]) -> Result<Carrier> {
        let corners: Vec<[Corner; 3]> = faces.iter().map(|face| face.map(|v| self.corners[v as usize])).collect();
        let is_face = |[a, b, c]: &&[Corner; 3]| a.vertex != b.vertex && b.vertex != c.vertex && c.vertex != a.vertex;
        let corners: Vec<[Corner; 3]> = corners.iter().filter(is_face).copied().collect();
        let faces = corners.iter().map(|face| face.map(|corner| corner.vertex)).collect();
        let attributes = Attributes {
            wedges: match original.attributes.wedges[..] {
                [] => Vec::new(),
                _ => corners.iter().map(|face| face.map(|corner| corner.wedge)).collect(),
            },
            channels: original.attributes.channels.clone(),
            groups: corners.iter().map(|face| face[0].group).collect(),
        };
        Ok(Carrier { mesh: compact(original.mesh.positions(), faces)?.0, attributes })
    }
}

/// Weights of the numbers that count, and these numbers for each corner, n_corners x n_weights.
fn weighed(attributes: &Attributes, corners: &[Corner], weighting: Weighting) -> (Vec<f32>, Vec<f32>) {
    let channels = attributes.channels.iter().filter(|channel| weighting.of(channel.role) > 0.0);
    let channels: Vec<&Channel> = channels.collect();
    let width = |channel: &Channel| channel.width.min(3);
    let weights = channels.iter().flat_map(|channel| vec![weighting.of(channel.role); width(channel)]).collect();
    let of_corner = |corner: &Corner| {
        let numbers = channels.iter().flat_map(|channel| channel.of(corner.wedge)[..width(channel)].to_vec());
        numbers.collect::<Vec<f32>>()
    };
    (weights, corners.iter().flat_map(of_corner).collect())
}
