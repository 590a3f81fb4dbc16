//! Conversion of FBX corners to wedges.

use rustc_hash::FxHashMap;
use ufbx::Mesh;

use crate::io::corner_wedges::NOWHERE;
use crate::mesh::{Attributes, Channel, DistinctKeys, Fans, RawMesh, Role};

pub(super) struct FbxMesh {
    pub mesh: RawMesh,
    pub slots: Vec<u32>,
    pub n_not_finite: usize,
}

pub(super) fn convert_mesh(mesh: &Mesh) -> FbxMesh {
    let (mut faces, mut groups, mut fans) = (Vec::new(), Vec::new(), Fans::default());
    let (mut slots, mut corners, mut dropped_faces) = (DistinctKeys::default(), Vec::new(), 0);
    for (i, face) in mesh.faces.iter().enumerate() {
        corners.clear();
        corners.extend((face.index_begin..face.index_begin.saturating_add(face.num_indices)).take(mesh.num_indices));
        // Faces with fewer than three corners are dropped and counted.
        if !fans.push(&corners, &mut faces) {
            dropped_faces += 1;
            continue;
        }
        // Faces without a material get the first material.
        let slot = mesh.face_material.get(i).copied().unwrap_or_default();
        groups.resize(faces.len(), slots.number(slot));
    }
    let vertex_of = |corner: u32| mesh.vertex_indices.get(corner as usize).copied().unwrap_or(NOWHERE);
    let position = |vertex: u32| mesh.vertices.get(vertex as usize).map(|p| [p.x, p.y, p.z]);
    // Polygons are triangulated while faces still index corners; the last step turns corners into vertices.
    fans.triangulate_with(|corner| position(vertex_of(corner)), &mut faces);
    let mut channels = channels(mesh);
    let wedges = if channels.is_empty() { Vec::new() } else { wedges(mesh, &faces, &mut channels) };
    let not_finite = |channel: &mut Channel| crate::io::extra::replace_non_finite(&mut channel.values);
    let n_not_finite = channels.iter_mut().map(not_finite).sum();
    faces.iter_mut().flatten().for_each(|corner| *corner = vertex_of(*corner));
    let positions = mesh.vertices.iter().map(|p| [p.x, p.y, p.z]).collect();
    let attributes = Attributes { wedges, channels, groups };
    let mesh = RawMesh { positions, faces, dropped_faces, attributes, double: false };
    FbxMesh { mesh, slots: slots.keys, n_not_finite }
}

fn channels(mesh: &Mesh) -> Vec<Channel> {
    let channel = |name: String, role, width| Channel { name, role, width, values: Vec::new() };
    let normal = mesh.vertex_normal.exists.then(|| channel("normal".into(), Role::Normal, 3));
    let n_sets = mesh.uv_sets.len();
    let names = (0..n_sets).map(|i| if i == 0 { "uv".into() } else { format!("uv{i}") });
    let uvs = names.map(|name| channel(name, Role::Uv, 2));
    let is_opaque = || mesh.vertex_color.values.iter().all(|colour| colour.w == 1.0);
    let width = if mesh.vertex_color.exists && is_opaque() { 3 } else { 4 };
    let colour = mesh.vertex_color.exists.then(|| channel("colour".into(), Role::Colour, width));
    normal.into_iter().chain(uvs).chain(colour).collect()
}

fn push_values(mesh: &Mesh, corner: usize, width_of_colour: usize, values: &mut Vec<f32>) {
    // Broken indices give zeros instead of an error.
    let index_at_corner = |indices: &[u32]| indices.get(corner).map_or(usize::MAX, |&index| index as usize);
    if mesh.vertex_normal.exists {
        let normal =
            mesh.vertex_normal.values.get(index_at_corner(&mesh.vertex_normal.indices)).copied().unwrap_or_default();
        values.extend([normal.x, normal.y, normal.z].map(|x| x as f32));
    }
    for set in mesh.uv_sets.iter() {
        let uv = set.vertex_uv.values.get(index_at_corner(&set.vertex_uv.indices)).copied().unwrap_or_default();
        values.extend([uv.x, uv.y].map(|x| x as f32));
    }
    if mesh.vertex_color.exists {
        let colour =
            mesh.vertex_color.values.get(index_at_corner(&mesh.vertex_color.indices)).copied().unwrap_or_default();
        let colour = [colour.x, colour.y, colour.z, colour.w].map(|x| (x as f32).clamp(0.0, 1.0));
        values.extend(&colour[..width_of_colour]);
    }
}

fn wedges(mesh: &Mesh, faces: &[[u32; 3]], channels: &mut [Channel]) -> Vec<[u32; 3]> {
    let width_of_colour = channels.iter().find(|it| it.role == Role::Colour).map_or(0, |it| it.width);
    // A key is the vertex, then the values as bits.
    let mut numbers: FxHashMap<Vec<u32>, u32> = FxHashMap::default();
    let (mut key, mut values) = (Vec::new(), Vec::new());
    let mut wedge = |corner: u32| {
        values.clear();
        push_values(mesh, corner as usize, width_of_colour, &mut values);
        key.clear();
        key.push(mesh.vertex_indices.get(corner as usize).copied().unwrap_or(NOWHERE));
        key.extend(values.iter().map(|x| (x + 0.0).to_bits()));
        // The lookup is by reference: most corners are known, and only new keys are cloned.
        if let Some(&wedge) = numbers.get(&key) {
            return wedge;
        }
        let wedge = numbers.len() as u32;
        numbers.insert(key.clone(), wedge);
        let mut rest = &values[..];
        for channel in channels.iter_mut() {
            let (own, others) = rest.split_at(channel.width);
            channel.values.extend(own);
            rest = others;
        }
        wedge
    };
    faces.iter().map(|face| face.map(&mut wedge)).collect()
}
