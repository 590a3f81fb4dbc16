//! Meshes with all attributes, and checks that know nothing of the library's.

use std::collections::HashMap;

use bevy_mesh::morph::MorphAttributes;
use bevy_mesh::{Indices, Mesh, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues, VertexFormat};
use neural_mesh::mesh::shapes;

/// Attribute of another crate.
pub const FLOW: MeshVertexAttribute = MeshVertexAttribute::new("Flow", 988_540_917, VertexFormat::Float32x3);
/// Attribute of another crate in a normalised format.
pub const BLEND: MeshVertexAttribute = MeshVertexAttribute::new("Blend", 988_540_918, VertexFormat::Unorm16x2);

/// Distance of the seam's two sides in the first texture coordinate.
pub const SEAM: f32 = 10.0;
/// Radii of the torus.
const RADII: [f32; 2] = [1.0, 0.4];

/// Returns a torus with all attributes, split along the plane x = 0.
pub fn torus(indices: fn(Vec<u32>) -> Option<Indices>) -> Mesh {
    let (positions, faces) = shapes::torus(64, 32, f64::from(RADII[0]), f64::from(RADII[1])).into_parts();
    let mut known: HashMap<(u32, bool), u32> = HashMap::new();
    let mut vertices = Vec::new();
    let mut corners = Vec::new();
    for face in &faces {
        let is_right = face.iter().map(|&v| positions[v as usize][0]).sum::<f32>() > 0.0;
        for &v in face {
            corners.push(*known.entry((v, is_right)).or_insert_with(|| {
                vertices.push((positions[v as usize], is_right));
                vertices.len() as u32 - 1
            }));
        }
    }
    match indices(corners.clone()) {
        Some(indices) => with_attributes(&vertices).with_inserted_indices(indices),
        None => {
            let loose: Vec<_> = corners.iter().map(|&corner| vertices[corner as usize]).collect();
            with_attributes(&loose)
        }
    }
}

pub fn short(corners: Vec<u32>) -> Option<Indices> {
    Some(Indices::U16(corners.iter().map(|&corner| corner as u16).collect()))
}

pub fn long(corners: Vec<u32>) -> Option<Indices> {
    Some(Indices::U32(corners))
}

pub fn none(_: Vec<u32>) -> Option<Indices> {
    None
}

fn with_attributes(vertices: &[([f32; 3], bool)]) -> Mesh {
    let expected: Vec<Expected> = vertices.iter().map(|&(position, is_right)| expect_at(position, is_right)).collect();
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, Default::default());
    let mut insert = |attribute, values: VertexAttributeValues| mesh.insert_attribute(attribute, values);
    insert(Mesh::ATTRIBUTE_POSITION, vertices.iter().map(|vertex| vertex.0).collect::<Vec<_>>().into());
    insert(Mesh::ATTRIBUTE_NORMAL, expected.iter().map(|it| it.normal).collect::<Vec<_>>().into());
    insert(Mesh::ATTRIBUTE_UV_0, expected.iter().map(|it| it.uv_0).collect::<Vec<_>>().into());
    insert(Mesh::ATTRIBUTE_UV_1, expected.iter().map(|it| it.uv_1).collect::<Vec<_>>().into());
    insert(Mesh::ATTRIBUTE_TANGENT, expected.iter().map(|it| it.tangent).collect::<Vec<_>>().into());
    insert(Mesh::ATTRIBUTE_COLOR, expected.iter().map(|it| it.colour).collect::<Vec<_>>().into());
    let joints = vec![[3, 7, 0, 0]; vertices.len()];
    insert(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints));
    insert(Mesh::ATTRIBUTE_JOINT_WEIGHT, expected.iter().map(|it| it.weights).collect::<Vec<_>>().into());
    insert(FLOW, expected.iter().map(|it| it.flow).collect::<Vec<_>>().into());
    let blend = expected.iter().map(|it| it.blend.map(|x| (x * 65535.0).round() as u16)).collect();
    insert(BLEND, VertexAttributeValues::Unorm16x2(blend));
    let targets = [0.25, -0.5];
    let offset = |share: f32| {
        let row = move |it: &Expected| MorphAttributes {
            position: it.normal.map(|x| share * x).into(),
            normal: it.uv_1.map(|x| share * x).map_or_zero(),
            ..MorphAttributes::default()
        };
        expected.iter().map(row).collect::<Vec<_>>()
    };
    mesh.set_morph_targets(targets.into_iter().flat_map(offset).collect());
    mesh.set_morph_target_names(vec!["wide".into(), "thin".into()]);
    mesh
}

trait OrZero {
    /// Appends a zero.
    fn map_or_zero<T: From<[f32; 3]>>(self) -> T;
}

impl OrZero for [f32; 2] {
    fn map_or_zero<T: From<[f32; 3]>>(self) -> T {
        [self[0], self[1], 0.0].into()
    }
}

/// Attributes of a point of the torus, all but normal and tangent linear in the position.
pub struct Expected {
    pub normal: [f32; 3],
    pub uv_0: [f32; 2],
    pub uv_1: [f32; 2],
    pub tangent: [f32; 4],
    pub colour: [f32; 4],
    pub weights: [f32; 4],
    pub flow: [f32; 3],
    pub blend: [f32; 2],
}

pub fn expect_at([x, y, z]: [f32; 3], is_right: bool) -> Expected {
    // The torus lies about the z axis.
    let around = x.hypot(y).max(1e-6);
    let centre = [x / around * RADII[0], y / around * RADII[0], 0.0];
    let out = [x - centre[0], y - centre[1], z];
    let length = out.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-6);
    let share = 0.5 + 0.25 * x;
    Expected {
        normal: out.map(|x| x / length),
        uv_0: [0.3 * x + if is_right { SEAM } else { 0.0 }, 0.3 * y],
        uv_1: [0.3 * y, 0.3 * z],
        tangent: [-y / around, x / around, 0.0, -1.0],
        colour: [0.5 + 0.2 * x, 0.5 + 0.2 * y, 0.5 + 0.2 * z, 1.0],
        weights: [share, 1.0 - share, 0.0, 0.0],
        flow: [2.0 * x, 2.0 * y, -z],
        blend: [0.5 + 0.2 * y, 0.5 + 0.2 * x],
    }
}

pub fn positions(mesh: &Mesh) -> &[[f32; 3]] {
    match mesh.attribute(Mesh::ATTRIBUTE_POSITION) {
        Some(VertexAttributeValues::Float32x3(positions)) => positions,
        other => panic!("positions are {other:?}"),
    }
}

pub fn corners(mesh: &Mesh) -> Vec<u32> {
    mesh.indices().expect("indices").iter().map(|index| index as u32).collect()
}

/// Returns the floats of an attribute, n_vertices x width.
pub fn floats(mesh: &Mesh, attribute: MeshVertexAttribute) -> Vec<Vec<f32>> {
    match mesh.attribute(attribute).expect(attribute.name) {
        VertexAttributeValues::Float32x2(rows) => rows.iter().map(|row| row.to_vec()).collect(),
        VertexAttributeValues::Float32x3(rows) => rows.iter().map(|row| row.to_vec()).collect(),
        VertexAttributeValues::Float32x4(rows) => rows.iter().map(|row| row.to_vec()).collect(),
        VertexAttributeValues::Unorm16x2(rows) => {
            rows.iter().map(|row| row.iter().map(|&x| f32::from(x) / 65535.0).collect()).collect()
        }
        other => panic!("{} is {other:?}", attribute.name),
    }
}

/// Returns whether each edge has two faces in opposite directions, with vertices at one position joined.
pub fn is_closed(mesh: &Mesh) -> bool {
    let positions = positions(mesh);
    let key = |v: u32| positions[v as usize].map(|x| (x + 0.0).to_bits());
    let mut edges: HashMap<_, i32> = HashMap::new();
    for face in corners(mesh).as_chunks::<3>().0 {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            *edges.entry((key(face[a]), key(face[b]))).or_default() += 1;
        }
    }
    edges.iter().all(|(&(a, b), &n)| n == 1 && a != b && edges.get(&(b, a)) == Some(&1))
}

/// Returns the number of different positions.
pub fn n_points(mesh: &Mesh) -> usize {
    let mut points: Vec<_> = positions(mesh).iter().map(|position| position.map(f32::to_bits)).collect();
    points.sort_unstable();
    points.dedup();
    points.len()
}
