//! Flat-shaded meshes.

use glam::Vec3;
use rustc_hash::FxHashMap;

use super::half_edges::{for_each_edge, next};
use super::{Attributes, Channel, Role, TriMesh};
use crate::geometry::triangle::unit_normal;

/// Least distance between two faces' unit normals at which their edge shows in shading.
const BENT: f32 = 0.004;
/// Largest distance of a flat corner's normal from its face's, relative to the distance between adjacent faces'
/// normals.
const NEAR: f32 = 0.25;
/// Smallest share of flat corners at bent edges in a flat-shaded mesh.
const NEARLY_ALL: f64 = 0.95;

/// Returns whether the corner normals are those of the faces; false for a plane mesh or one without normals.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{Attributes, is_shaded_flat, shapes};
/// assert!(!is_shaded_flat(&shapes::icosphere(2), &Attributes::default()));
/// ```
pub fn is_shaded_flat(mesh: &TriMesh, attributes: &Attributes) -> bool {
    let Some(channel) = attributes.channel(Role::Normal) else { return false };
    let normals: Vec<Vec3> = mesh.faces().iter().map(|face| normal(mesh, face)).collect();
    let mut bends = vec![0f32; 3 * normals.len()];
    for_each_edge(mesh.positions().len(), mesh.faces(), |_, half_edges| {
        if let &[a, b] = half_edges {
            let bend = normals[a.face() as usize].distance(normals[b.face() as usize]);
            for corner in [a, b].into_iter().flat_map(|side| [side.half_edge, next(side.half_edge)]) {
                bends[corner as usize] = bends[corner as usize].max(bend);
            }
        }
    });
    let (mut n_bent, mut n_flat) = (0usize, 0usize);
    for (corner, &bend) in (0u32..).zip(&bends).filter(|(_, bend)| **bend > BENT) {
        let Some(&[x, y, z]) = channel.value(attributes.wedges[corner as usize / 3][corner as usize % 3]).first_chunk()
        else {
            return false;
        };
        let own = Vec3::new(x, y, z).normalize_or_zero();
        n_bent += 1;
        n_flat += usize::from(own.distance(normals[corner as usize / 3]) <= NEAR * bend);
    }
    n_bent > 0 && n_flat as f64 >= NEARLY_ALL * n_bent as f64
}

/// Returns the attributes with face normals in a channel called `name`.
///
/// Corners of a vertex share a wedge if their faces are coplanar.
pub fn with_flat_normals(mesh: &TriMesh, attributes: &Attributes, name: &str) -> Attributes {
    let others: Vec<&Channel> = attributes.channels.iter().filter(|channel| channel.role != Role::Normal).collect();
    let mut channels: Vec<Channel> =
        others.iter().map(|channel| Channel { name: channel.name.clone(), values: Vec::new(), ..**channel }).collect();
    let mut flat = Channel { name: name.into(), role: Role::Normal, width: 3, values: Vec::new() };
    let mut known: FxHashMap<(u32, u32, [u32; 3]), u32> = FxHashMap::default();
    let mut wedges = Vec::with_capacity(mesh.faces().len());
    for (f, face) in mesh.faces().iter().enumerate() {
        let normal = normal(mesh, face).normalize_or(Vec3::Z).to_array();
        let before = |corner: usize| attributes.wedges.get(f).map_or(0, |wedges| wedges[corner]);
        wedges.push(std::array::from_fn(|corner| {
            let key = (face[corner], before(corner), normal.map(f32::to_bits));
            let next = known.len() as u32;
            *known.entry(key).or_insert_with(|| {
                for (all, one) in channels.iter_mut().zip(&others) {
                    all.values.extend_from_slice(one.value(before(corner)));
                }
                flat.values.extend(normal);
                next
            })
        }));
    }
    channels.push(flat);
    Attributes { wedges, channels, groups: attributes.groups.clone() }
}

fn normal(mesh: &TriMesh, face: &[u32; 3]) -> Vec3 {
    unit_normal(face.map(|v| Vec3::from(mesh.positions()[v as usize])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, vertex_normals};

    fn smooth(mesh: &TriMesh) -> Attributes {
        let values = vertex_normals(mesh).into_iter().flatten().collect();
        let channel = Channel { name: "NORMAL".into(), role: Role::Normal, width: 3, values };
        Attributes { wedges: mesh.faces().to_vec(), channels: vec![channel], groups: Vec::new() }
    }

    #[test]
    fn flat_normals_are_distinguished_from_smooth_ones() {
        for mesh in [shapes::icosphere(1), shapes::icosphere(6), shapes::torus(90, 30, 2.0, 0.5), shapes::bolt(48)] {
            let smooth = smooth(&mesh);
            assert!(!is_shaded_flat(&mesh, &smooth));
            let mut flat = with_flat_normals(&mesh, &smooth, "NORMAL");
            assert!(is_shaded_flat(&mesh, &flat) && flat.is_valid_for(mesh.faces().len()));
            // Rounds to 16 bits, as some files store normals.
            let normals = flat.channels.iter_mut().flat_map(|channel| &mut channel.values);
            normals.for_each(|x| *x = (*x * 32767.0).round() / 32767.0);
            assert!(is_shaded_flat(&mesh, &flat));
        }
        let plane = shapes::grid(5, 5);
        assert!(!is_shaded_flat(&plane, &with_flat_normals(&plane, &smooth(&plane), "NORMAL")));
    }

    #[test]
    fn what_else_corners_carry_stays() {
        let mesh = shapes::icosphere(2);
        let values = mesh.positions().iter().flat_map(|p| [p[0], p[1]]).collect();
        let mut attributes = smooth(&mesh);
        attributes.channels.push(Channel { name: "uv".into(), role: Role::Uv, width: 2, values });
        let flat = with_flat_normals(&mesh, &attributes, "NORMAL");
        assert_eq!(flat.n_wedges(), 3 * mesh.faces().len());
        for (face, wedges) in mesh.faces().iter().zip(&flat.wedges) {
            for (&v, &wedge) in face.iter().zip(wedges) {
                assert_eq!(flat.channels[0].value(wedge), &mesh.positions()[v as usize][..2]);
            }
        }
        let cube = shapes::cuboid([1.0; 3], 3);
        let corners = with_flat_normals(&cube, &smooth(&cube), "NORMAL");
        assert_eq!(corners.n_wedges(), 6 * 16);
    }
}
