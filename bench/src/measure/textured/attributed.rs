//! meshoptimizer's `simplifyWithAttributes`, called as in gltfpack.

use std::collections::HashMap;

use anyhow::Result;
use meshopt::{SimplifyOptions, VertexDataAdapter, simplify_with_attributes_and_locks, typed_to_bytes};
use neural_mesh::mesh::{Attributes, Channel, Role, TriMesh, compact};

pub struct AttributedMesh {
    pub mesh: TriMesh,
    pub attributes: Attributes,
}

// Weights of attributes relative to the position, whose unit is the mesh's extent.
#[derive(Clone, Copy)]
pub enum Weighting {
    // Weights of gltfpack: normals 0.5 per component, colours 1, texture coordinates 0.
    Gltfpack,
    // Weights of gltfpack, and texture coordinates 1 per component.
    WithUvs,
}

impl Weighting {
    pub const ALL: [Self; 2] = [Self::Gltfpack, Self::WithUvs];

    fn weight(self, role: Role) -> f32 {
        match (role, self) {
            (Role::Normal, _) => 0.5,
            (Role::Colour, _) | (Role::Uv, Self::WithUvs) => 1.0,
            _ => 0.0,
        }
    }
}

pub fn simplify_weighted(original: &AttributedMesh, n_faces: usize, weighting: Weighting) -> Result<AttributedMesh> {
    let split = SplitMesh::new(original);
    let positions: Vec<[f32; 3]> = split.corners.iter().map(|c| original.mesh.positions()[c.vertex as usize]).collect();
    let (weights, values) = weighted_values(&original.attributes, &split.corners, weighting);
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
    split.unite(original, indices.as_chunks().0)
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct SplitCorner {
    vertex: u32,
    wedge: u32,
    group: u32,
}

struct SplitMesh {
    corners: Vec<SplitCorner>,
    faces: Vec<[u32; 3]>,
}

impl SplitMesh {
    fn new(AttributedMesh { mesh, attributes }: &AttributedMesh) -> Self {
        let mut split = Self { corners: Vec::new(), faces: Vec::new() };
        let mut known: HashMap<SplitCorner, u32> = HashMap::new();
        for (f, face) in mesh.faces().iter().enumerate() {
            let wedges = attributes.wedges.get(f).copied().unwrap_or_default();
            let group = attributes.group(f as u32);
            split.faces.push(std::array::from_fn(|i| {
                let corner = SplitCorner { vertex: face[i], wedge: wedges[i], group };
                *known.entry(corner).or_insert_with(|| {
                    split.corners.push(corner);
                    split.corners.len() as u32 - 1
                })
            }));
        }
        split
    }

    fn unite(&self, original: &AttributedMesh, faces: &[[u32; 3]]) -> Result<AttributedMesh> {
        let corners: Vec<[SplitCorner; 3]> = faces.iter().map(|face| face.map(|v| self.corners[v as usize])).collect();
        let is_face =
            |[a, b, c]: &&[SplitCorner; 3]| a.vertex != b.vertex && b.vertex != c.vertex && c.vertex != a.vertex;
        let corners: Vec<[SplitCorner; 3]> = corners.iter().filter(is_face).copied().collect();
        let faces = corners.iter().map(|face| face.map(|corner| corner.vertex)).collect();
        let attributes = Attributes {
            wedges: match original.attributes.wedges[..] {
                [] => Vec::new(),
                _ => corners.iter().map(|face| face.map(|corner| corner.wedge)).collect(),
            },
            channels: original.attributes.channels.clone(),
            groups: corners.iter().map(|face| face[0].group).collect(),
        };
        Ok(AttributedMesh { mesh: compact(original.mesh.positions(), faces)?.0, attributes })
    }
}

fn weighted_values(attributes: &Attributes, corners: &[SplitCorner], weighting: Weighting) -> (Vec<f32>, Vec<f32>) {
    let channels = attributes.channels.iter().filter(|channel| weighting.weight(channel.role) > 0.0);
    let channels: Vec<&Channel> = channels.collect();
    let width = |channel: &Channel| channel.width.min(3);
    let weights = channels.iter().flat_map(|channel| vec![weighting.weight(channel.role); width(channel)]).collect();
    let of_corner = |corner: &SplitCorner| {
        let numbers = channels.iter().flat_map(|channel| channel.value(corner.wedge)[..width(channel)].to_vec());
        numbers.collect::<Vec<f32>>()
    };
    (weights, corners.iter().flat_map(of_corner).collect())
}
