//! Meshes that are refused, each with one clear line.

use bevy_mesh::{Indices, Mesh, MeshAttributeCompressionFlags, MeshCompressionArgs, MeshVertexAttribute};
use bevy_mesh::{PrimitiveTopology, VertexAttributeValues, VertexFormat};
use neural_mesh_bevy::{ClosedOptions, MeshError, Size, simplify_mesh};

use crate::helpers::{long, positions, torus};

fn error_of(mesh: &Mesh) -> MeshError {
    let error = simplify_mesh(mesh, Size::Ratio(0.5), &ClosedOptions::default()).expect_err("no error");
    let text = error.to_string();
    assert!(!text.contains('\n') && !text.ends_with('.') && text.contains(": "), "{text}");
    error
}

#[test]
fn strips_lines_and_points_are_refused() {
    for topology in [PrimitiveTopology::TriangleStrip, PrimitiveTopology::LineList, PrimitiveTopology::PointList] {
        let mesh = Mesh::new(topology, Default::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions(&torus(long)).to_vec());
        assert!(matches!(error_of(&mesh), MeshError::Topology(found) if found == topology));
    }
}

#[test]
fn meshes_without_positions_or_triangles_are_refused() {
    let mesh = Mesh::new(PrimitiveTopology::TriangleList, Default::default());
    assert!(matches!(error_of(&mesh), MeshError::NoPositions));
    let empty = mesh.with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, Vec::<[f32; 3]>::new());
    assert!(matches!(error_of(&empty), MeshError::Clean(_)));
}

#[test]
fn integers_are_refused_by_the_name_of_their_attribute() {
    const OBJECT: MeshVertexAttribute = MeshVertexAttribute::new("Object", 77_001, VertexFormat::Uint32);
    let mesh = torus(long);
    let n = mesh.count_vertices();
    let mesh = mesh.with_inserted_attribute(OBJECT, VertexAttributeValues::Uint32(vec![7; n]));
    let error = error_of(&mesh);
    assert!(error.to_string().contains("Object") && error.to_string().contains("Uint32"), "{error}");
}

#[test]
fn compressed_meshes_are_refused() {
    let flags = [
        (MeshAttributeCompressionFlags::COMPRESS_POSITION, "Vertex_Position"),
        (MeshAttributeCompressionFlags::COMPRESS_NORMAL, "Vertex_Normal"),
        (MeshAttributeCompressionFlags::COMPRESS_TANGENT, "Vertex_Tangent"),
        (MeshAttributeCompressionFlags::COMPRESS_UV0, "Vertex_Uv"),
        (MeshAttributeCompressionFlags::COMPRESS_UV1, "Vertex_Uv_1"),
    ];
    for (compress_attributes, name) in flags {
        let mut mesh = torus(long);
        mesh.compress_mesh(&MeshCompressionArgs { compress_attributes, ..MeshCompressionArgs::none() }).unwrap();
        let error = error_of(&mesh);
        assert!(matches!(error, MeshError::Format { .. }) && error.to_string().contains(name), "{error}");
    }
}

#[test]
fn unfit_lengths_and_indices_are_refused() {
    let mesh = torus(long).with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, vec![[0.0; 2]; 3]);
    assert!(matches!(error_of(&mesh), MeshError::Length { n_rows: 3, .. }));
    let mesh = torus(long).with_inserted_indices(Indices::U32(vec![0, 1, 999_999]));
    assert!(matches!(error_of(&mesh), MeshError::Index { index: 999_999, .. }));
    let mesh = torus(long).with_inserted_indices(Indices::U16(vec![0, 1, 2, 3]));
    assert!(matches!(error_of(&mesh), MeshError::IndexCount(4)));
    let mut mesh = torus(long);
    mesh.set_morph_targets(vec![Default::default(); 5]);
    assert!(matches!(error_of(&mesh), MeshError::Length { attribute: "morph targets", .. }));
    let mesh = torus(long).with_removed_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT);
    assert!(matches!(error_of(&mesh), MeshError::HalfSkin));
}

#[test]
fn meshes_of_the_render_world_are_refused() {
    let mut mesh = torus(long);
    mesh.take_gpu_data().unwrap();
    assert!(matches!(error_of(&mesh), MeshError::Access(_)));
}

#[test]
fn bad_sizes_are_refused() {
    let mesh = torus(long);
    for ratio in [0.0, 1.5, f64::NAN] {
        let result = simplify_mesh(&mesh, Size::Ratio(ratio), &ClosedOptions::default());
        assert!(matches!(result, Err(MeshError::Simplify(_))));
    }
}
