//! Normals and tangents at the corners of a mesh.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};
use rustc_hash::FxHashMap;

use super::unfold::Charts;
use crate::geometry::triangle::area_normal;
use crate::mesh::pulse::Pulse;
use crate::mesh::thread_ranges::corner_rows;
use crate::mesh::{Attributes, Channel, Role, TriMesh};
use crate::parallel;

/// Largest angle in degrees between faces that share normals.
// Beyond, directions of the original may leave the range of a normal map.
const SMOOTH: f32 = 60.0;
// Above this number of faces around a vertex all share its normal; comparing all pairs would take too long.
const HUB: usize = 256;

pub(super) struct Frames {
    // Unit normals to be written, n_faces x 3.
    pub normals: Vec<[Vec3; 3]>,
    // Unit tangents with the sign of the bitangent, n_faces x 3.
    pub tangents: Vec<[Vec4; 3]>,
    // Unit normals common to all faces of a vertex, n_faces x 3, so that search lines leave no gap.
    pub rays: Vec<[Vec3; 3]>,
}

impl Frames {
    pub fn new(mesh: &TriMesh, charts: &Charts) -> Self {
        let normals = corner_normals(mesh, SMOOTH);
        let uvs: Vec<[Vec2; 3]> =
            charts.corners.iter().map(|corners| corners.map(|at| Vec2::from(charts.uv(at)))).collect();
        let tangents = tangents(mesh, &normals, &uvs);
        Self { rays: corner_normals(mesh, 180.0), normals, tangents }
    }

    pub fn attributes(&self, charts: &Charts, with_tangents: bool) -> Attributes {
        let mut known: FxHashMap<(u32, [u32; 3], [u32; 4]), u32> = FxHashMap::default();
        let (mut uvs, mut normals, mut tangents) = (Vec::new(), Vec::new(), Vec::new());
        let mut wedge = |face: usize, corner: usize| {
            let normal = self.normals[face][corner].to_array();
            let tangent = if with_tangents { self.tangents[face][corner].to_array() } else { [0.0; 4] };
            // Corners of different charts never share a wedge, whatever their values.
            let key = (charts.vertices[face][corner], normal.map(f32::to_bits), tangent.map(f32::to_bits));
            let next = known.len() as u32;
            *known.entry(key).or_insert_with(|| {
                uvs.extend(charts.uv(charts.corners[face][corner]));
                normals.extend(normal);
                tangents.extend(tangent);
                next
            })
        };
        let wedges = (0..self.normals.len()).map(|face| [0, 1, 2].map(|corner| wedge(face, corner))).collect();
        let channel = |name: &str, role, width, values| Channel { name: name.into(), role, width, values };
        let mut channels = vec![channel("uv", Role::Uv, 2, uvs), channel("normal", Role::Normal, 3, normals)];
        channels.extend(with_tangents.then(|| channel("tangent", Role::Tangent, 4, tangents)));
        Attributes { wedges, channels, groups: Vec::new() }
    }
}

/// Computes unit normals at corners, n_faces x 3, as angle-weighted means (Thurmer and Wuthrich 1998).
///
/// Each mean covers the faces joined to the corner's face over edges of at most `degrees`.
pub(super) fn corner_normals(mesh: &TriMesh, degrees: f32) -> Vec<[Vec3; 3]> {
    let corners = |face: &[u32; 3]| face.map(|v| Vec3::from(mesh.positions()[v as usize]));
    let normal = |face: usize| area_normal(corners(&mesh.faces()[face])).normalize_or_zero();
    let of_faces = parallel::map(mesh.faces().len(), 1024, normal);
    let around = corner_rows(Pulse::NONE, mesh.positions().len(), mesh.faces(), |face, _| face);
    let least = degrees.to_radians().cos() - 1e-5;
    let place = |face: u32, vertex: u32| mesh.faces()[face as usize].iter().position(|&v| v == vertex).unwrap_or(0);
    let normals = |vertex: usize| {
        let (faces, vertex) = (around.row(vertex), vertex as u32);
        // All pairs of faces are compared, which would take too long at a hub.
        let fans = if faces.len() > HUB { vec![0; faces.len()] } else { fans(mesh, faces, vertex, &of_faces, least) };
        let mut sums = vec![Vec3::ZERO; faces.len()];
        for (&face, &fan) in faces.iter().zip(&fans) {
            let angle = angle_at(corners(&mesh.faces()[face as usize]), place(face, vertex));
            sums[fan] += of_faces[face as usize] * angle;
        }
        let normal = |(&face, &fan): (&u32, &usize)| sums[fan].try_normalize().unwrap_or(of_faces[face as usize]);
        faces.iter().zip(&fans).map(normal).collect::<Vec<Vec3>>()
    };
    let of_vertices = parallel::map(mesh.positions().len(), 256, normals);
    let mut all = vec![[Vec3::ZERO; 3]; mesh.faces().len()];
    for (vertex, normals) in (0..).zip(of_vertices) {
        for (&face, normal) in around.row(vertex as usize).iter().zip(normals) {
            all[face as usize][place(face, vertex)] = normal;
        }
    }
    all
}

/// Returns the index of the first face in each face's fan; creases separate fans.
fn fans(mesh: &TriMesh, faces: &[u32], vertex: u32, of_faces: &[Vec3], least: f32) -> Vec<usize> {
    let mut fans: Vec<usize> = (0..faces.len()).collect();
    for (i, &face) in faces.iter().enumerate() {
        for (j, &before) in faces[..i].iter().enumerate() {
            let [a, b] = [face, before].map(|face| mesh.faces()[face as usize]);
            let is_joined = a.iter().any(|corner| *corner != vertex && b.contains(corner));
            let [one, other] = [fans[i], fans[j]];
            if is_joined && one != other && of_faces[face as usize].dot(of_faces[before as usize]) >= least {
                fans.iter_mut().filter(|fan| **fan == one.max(other)).for_each(|fan| *fan = one.min(other));
            }
        }
    }
    fans
}

fn angle_at(corners: [Vec3; 3], at: usize) -> f32 {
    let [a, b, c] = [corners[at], corners[(at + 1) % 3], corners[(at + 2) % 3]];
    let (ab, ac) = (b - a, c - a);
    ab.cross(ac).length().atan2(ab.dot(ac))
}

/// Computes MikkTSpace tangents at corners, n_faces x 3; texture coordinates have v upwards.
pub(super) fn tangents(mesh: &TriMesh, normals: &[[Vec3; 3]], uvs: &[[Vec2; 3]]) -> Vec<[Vec4; 3]> {
    let any = |normal: &Vec3| normal.try_normalize().unwrap_or(Vec3::Z).any_orthonormal_vector().extend(1.0);
    let tangents = normals.iter().map(|normals| normals.each_ref().map(any)).collect();
    let mut corners = TangentGeometry { mesh, normals, uvs, tangents };
    // The error type has no variants: nothing can fail.
    let _ = generate_tangents(&mut corners);
    corners.tangents
}

struct TangentGeometry<'a> {
    mesh: &'a TriMesh,
    normals: &'a [[Vec3; 3]],
    uvs: &'a [[Vec2; 3]],
    tangents: Vec<[Vec4; 3]>,
}

impl Geometry for TangentGeometry<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.faces().len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions()[self.mesh.faces()[face][corner] as usize]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[face][corner].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[face][corner].to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = space.map(|space| Vec4::from(space.tangent_encoded()));
        // A tangent along the normal, or of no length, spans no frame.
        let normal = self.normals[face][corner];
        let is_across = |tangent: &Vec4| tangent.is_finite() && normal.cross(tangent.truncate()).length() > 0.1;
        self.tangents[face][corner] = tangent.filter(is_across).unwrap_or(self.tangents[face][corner]);
    }
}
