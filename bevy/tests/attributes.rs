//! Attributes of results against those of the original.

use std::collections::HashMap;

use bevy_mesh::{Mesh, MeshVertexAttribute, VertexAttributeValues};
use neural_mesh_bevy::{ClosedOptions, Size, simplify_mesh};

use crate::helpers::{BLEND, Expected, FLOW, SEAM, expect_at, floats, long, positions, torus};

/// Every attribute of a vertex.
type Row = Vec<f32>;

/// All but joints and their weights, whose order is free.
const FLOATS: [MeshVertexAttribute; 7] = [
    Mesh::ATTRIBUTE_NORMAL,
    Mesh::ATTRIBUTE_UV_0,
    Mesh::ATTRIBUTE_UV_1,
    Mesh::ATTRIBUTE_TANGENT,
    Mesh::ATTRIBUTE_COLOR,
    FLOW,
    BLEND,
];

fn rows(mesh: &Mesh) -> Vec<Row> {
    let n = mesh.count_vertices();
    let mut rows = vec![Row::new(); n];
    for attribute in FLOATS {
        for (row, values) in rows.iter_mut().zip(floats(mesh, attribute)) {
            row.extend(values);
        }
    }
    for (row, weights) in rows.iter_mut().zip(joint_weights(mesh)) {
        row.extend(weights);
    }
    let morphs = mesh.morph_targets().expect("morph targets");
    assert_eq!(morphs.len(), 2 * n);
    for (i, morph) in morphs.iter().enumerate() {
        let offsets = [morph.position, morph.normal, morph.tangent];
        rows[i % n].extend(offsets.iter().flat_map(|offset| offset.to_array()));
    }
    rows
}

/// Returns the weights of the joints 3 and 7 at each vertex.
fn joint_weights(mesh: &Mesh) -> Vec<[f32; 2]> {
    let Some(VertexAttributeValues::Uint16x4(joints)) = mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
        panic!("no joints")
    };
    let weight = |joints: &[u16; 4], weights: &[f32], joint: u16| -> f32 {
        joints.iter().zip(weights).filter(|pair| *pair.0 == joint).map(|pair| pair.1).sum()
    };
    let all = joints.iter().zip(floats(mesh, Mesh::ATTRIBUTE_JOINT_WEIGHT));
    let pairs: Vec<[f32; 2]> =
        all.map(|(joints, weights)| [3, 7].map(|joint| weight(joints, &weights, joint))).collect();
    assert!(pairs.iter().all(|[x, y]| (x + y - 1.0).abs() < 1e-4), "other joints have weights");
    pairs
}

#[test]
fn vertices_that_stay_in_place_keep_all_their_values() {
    let mesh = torus(long);
    let options = ClosedOptions { subset: true, ..ClosedOptions::default() };
    let light = simplify_mesh(&mesh, Size::Ratio(0.2), &options).unwrap().mesh;
    assert!(light.count_vertices() < mesh.count_vertices() / 3);
    let mut known: HashMap<_, Vec<Row>> = HashMap::new();
    for (position, row) in positions(&mesh).iter().zip(rows(&mesh)) {
        known.entry(position.map(f32::to_bits)).or_default().push(row);
    }
    for (position, row) in positions(&light).iter().zip(rows(&light)) {
        let given = &known[&position.map(f32::to_bits)];
        // Unit vectors may be divided by their length once more.
        let is_equal = |other: &Row| row.iter().zip(other).all(|(x, y)| (x - y).abs() < 1e-6);
        assert!(given.iter().any(is_equal), "{position:?}: {row:?} is none of {given:?}");
    }
}

#[test]
fn vertices_that_move_get_the_values_of_their_place() {
    let mesh = torus(long);
    let light = simplify_mesh(&mesh, Size::Ratio(0.3), &ClosedOptions::default()).unwrap().mesh;
    let values = FLOATS.map(|attribute| floats(&light, attribute));
    let joints = joint_weights(&light);
    for (v, &position) in positions(&light).iter().enumerate() {
        let is_right = values[1][v][0] > 0.5 * SEAM;
        // Both sides meet at x = 0, where the surface is split; no vertex takes the other side's value.
        assert!(position[0].abs() < 0.15 || is_right == (position[0] > 0.0), "{position:?}");
        let Expected { normal, uv_0, uv_1, tangent, colour, weights, flow, blend } = expect_at(position, is_right);
        let expected: [&[f32]; 7] = [&normal, &uv_0, &uv_1, &tangent, &colour, &flow, &blend];
        let allowed = [0.2, 0.05, 0.05, 0.2, 0.05, 0.1, 0.05];
        for ((attribute, expected), (values, allowed)) in FLOATS.iter().zip(expected).zip(values.iter().zip(allowed)) {
            for (x, y) in values[v].iter().zip(expected) {
                assert!((x - y).abs() < allowed, "{}: {:?}, not {expected:?}", attribute.name, values[v]);
            }
        }
        let length = values[0][v].iter().map(|x| x * x).sum::<f32>();
        assert!((length - 1.0).abs() < 1e-5 && (joints[v][0] - weights[0]).abs() < 0.05, "{:?}", joints[v]);
    }
}

#[test]
fn morph_targets_keep_their_names_and_offsets() {
    let mesh = torus(long);
    let light = simplify_mesh(&mesh, Size::Ratio(0.3), &ClosedOptions::default()).unwrap().mesh;
    assert_eq!(light.morph_target_names(), mesh.morph_target_names());
    let n = light.count_vertices();
    let targets = light.morph_targets().unwrap();
    for (v, position) in positions(&light).iter().enumerate() {
        let normal = expect_at(*position, true).normal;
        for (target, share) in [0.25, -0.5].into_iter().enumerate() {
            let offset = targets[target * n + v].position.to_array();
            assert!(offset.iter().zip(normal).all(|(x, y)| (x - share * y).abs() < 0.1), "{offset:?} at {position:?}");
        }
    }
}

#[test]
fn usage_and_raytracing_stay() {
    let mut mesh = torus(long);
    mesh.enable_raytracing = false;
    mesh.generate_skinned_mesh_bounds().unwrap();
    let light = simplify_mesh(&mesh, Size::Ratio(0.3), &ClosedOptions::default()).unwrap().mesh;
    assert_eq!((light.asset_usage, light.enable_raytracing), (mesh.asset_usage, false));
    assert_eq!(light.skinned_mesh_bounds().unwrap().aabbs.len(), 2);
}

#[test]
fn quantised_colours_and_weights_come_back_in_their_formats() {
    let mut mesh = torus(long);
    mesh.quantize_colors(bevy_mesh::AttributeQuantization::Unorm8).unwrap();
    mesh.quantize_joint_weights(bevy_mesh::AttributeQuantization::Unorm16).unwrap();
    let light = simplify_mesh(&mesh, Size::Ratio(0.3), &ClosedOptions::default()).unwrap().mesh;
    let Some(VertexAttributeValues::Unorm8x4(colours)) = light.attribute(Mesh::ATTRIBUTE_COLOR) else {
        panic!("colours changed their format")
    };
    for (position, colour) in positions(&light).iter().zip(colours) {
        let expected = expect_at(*position, true).colour;
        assert!(colour.iter().zip(expected).all(|(&x, y)| (f32::from(x) / 255.0 - y).abs() < 0.05));
    }
    let weights = light.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT);
    assert!(matches!(weights, Some(VertexAttributeValues::Unorm16x4(_))));
}
