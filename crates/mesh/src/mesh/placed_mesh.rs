//! Merges the meshes of a scene.

use glam::{DMat3, DMat4, Vec3};

use super::united_mesh::{all_channels, append_attributes};
use super::{Attributes, Channel, RawMesh, Role};

#[doc(hidden)]
pub struct PlacedMesh<'a> {
    pub mesh: &'a RawMesh,
    pub transform: DMat4,
    /// Merged index of the mesh's first group.
    pub first_group: u32,
}

/// Merges meshes in common coordinates, with the channels whose role `is_carried` accepts.
///
/// Missing channels become zeros, missing colours white.
#[doc(hidden)]
pub fn merge_placed_meshes(meshes: &[PlacedMesh], is_carried: impl Fn(Role) -> bool) -> RawMesh {
    let mut channels = all_channels(meshes.iter().map(|placed| &placed.mesh.attributes));
    channels.retain(|channel| is_carried(channel.role));
    let mut all = RawMesh { attributes: Attributes { channels, ..Attributes::default() }, ..RawMesh::default() };
    meshes.iter().for_each(|placed| add(&mut all, placed));
    all
}

fn add(all: &mut RawMesh, PlacedMesh { mesh, transform, first_group }: &PlacedMesh) {
    let first = all.positions.len();
    let is_mirrored = transform.determinant() < 0.0;
    let turn = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
    all.positions.extend(mesh.positions.iter().map(|&p| transform.transform_point3(p.into()).to_array()));
    // Indices out of range stay out of range, so that cleaning drops their faces.
    let shift_vertex = |v: u32| if v as usize >= mesh.positions.len() { u32::MAX } else { first as u32 + v };
    all.faces.extend(mesh.faces.iter().map(|face| turn(face.map(shift_vertex))));
    all.dropped_faces += mesh.dropped_faces;
    let attributes = &mut all.attributes;
    let (first_row, first_wedge) = (attributes.wedges.len(), attributes.n_wedges());
    append_attributes(attributes, &mesh.attributes, mesh.faces.len() as u32, *first_group, 1.0);
    attributes.wedges[first_row..].iter_mut().for_each(|row| *row = turn(*row));
    attributes.channels.iter_mut().for_each(|channel| turn_directions(channel, first_wedge, *transform));
}

fn turn_directions(channel: &mut Channel, first_wedge: usize, transform: DMat4) {
    let linear = DMat3::from_mat4(transform);
    let turned = match channel.role {
        Role::Normal => linear.inverse().transpose(),
        Role::Tangent | Role::MorphPosition | Role::MorphDirection => linear,
        _ => return,
    };
    let is_unit = matches!(channel.role, Role::Normal | Role::Tangent);
    for row in channel.values[first_wedge * channel.width..].chunks_exact_mut(channel.width) {
        let Some(vector) = row.first_chunk_mut::<3>() else { return };
        let found = turned * Vec3::from(*vector).as_dvec3();
        let found = if is_unit { found.normalize_or_zero() } else { found }.as_vec3();
        *vector = if found.is_finite() { found.into() } else { [0.0; 3] };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    fn triangle(with_normals: bool) -> RawMesh {
        let normal = Channel { name: "NORMAL".into(), role: Role::Normal, width: 3, values: vec![1.0, 0.0, 0.0] };
        let channels = if with_normals { vec![normal] } else { Vec::new() };
        let wedges = if with_normals { vec![[0; 3]] } else { Vec::new() };
        RawMesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            faces: vec![[0, 1, 2]],
            attributes: Attributes { wedges, channels, groups: vec![1] },
            ..RawMesh::default()
        }
    }

    #[test]
    fn meshes_are_moved_and_turned_by_their_transforms() {
        let (bare, shaded) = (triangle(false), triangle(true));
        let turned = DMat4::from_rotation_translation(DQuat::from_rotation_z(0.5_f64.acos() * 1.5), DVec3::X);
        let mirrored = DMat4::from_scale(DVec3::new(-2.0, 1.0, 1.0));
        let meshes = [
            PlacedMesh { mesh: &bare, transform: DMat4::IDENTITY, first_group: 0 },
            PlacedMesh { mesh: &shaded, transform: turned, first_group: 2 },
            PlacedMesh { mesh: &shaded, transform: mirrored, first_group: 4 },
        ];
        let all = merge_placed_meshes(&meshes, |_| true);
        assert_eq!(all.faces, [[0, 1, 2], [3, 4, 5], [6, 8, 7]]);
        assert_eq!((all.attributes.groups.as_slice(), all.positions[7]), (&[1, 3, 5][..], [-2.0, 0.0, 0.0]));
        assert!((DVec3::from(all.positions[4]) - DVec3::new(1.0, 1.0, 0.0)).length() < 1e-12);
        let normals = &all.attributes.channels[0].values;
        for (found, expected) in normals.iter().zip([0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0]) {
            assert!((found - expected).abs() < 1e-6, "{normals:?}");
        }
        assert!(all.attributes.is_valid_for(3));
        assert_eq!(merge_placed_meshes(&meshes, |role| role != Role::Normal).attributes.channels, []);
    }

    #[test]
    fn corners_that_do_not_exist_reach_no_other_mesh() {
        let broken = RawMesh { faces: vec![[0, 1, 3]], ..triangle(false) };
        let placed = || PlacedMesh { mesh: &broken, transform: DMat4::IDENTITY, first_group: 0 };
        assert_eq!(merge_placed_meshes(&[placed(), placed()], |_| true).faces[0], [0, 1, u32::MAX]);
        let mut beyond = triangle(true);
        beyond.attributes.wedges[0][2] = u32::MAX;
        let placed = || PlacedMesh { mesh: &beyond, transform: DMat4::IDENTITY, first_group: 0 };
        assert_eq!(
            merge_placed_meshes(&[placed(), placed()], |_| true).attributes.wedges,
            [[0, 0, u32::MAX], [1, 1, u32::MAX]]
        );
    }
}
