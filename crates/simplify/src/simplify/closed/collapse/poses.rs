//! Quadrics summed over poses of the mesh (DeCoro and Rusinkiewicz 2005, "Pose-independent simplification of
//! articulated meshes"; Mohr and Gleicher 2003, "Deformation sensitive decimation").

use glam::{DMat3, DQuat, DVec3, Mat3, Quat, Vec3};

use crate::geometry::Quadric;
use crate::mesh::{Attributes, Channel, Role};
use crate::simplify::closed::original::Original;
use crate::simplify::closed::request::Task;
use crate::simplify::options::Purpose;

/// Pull to a vertex's position for unknown poses, per share of the surface's weight.
// Six bodies: half or twice as much changes the mean distance by 1 %.
const UNKNOWN_POSE_PULL: f64 = 10.0;
const STEPS: usize = 12;

#[derive(Clone, Copy, Debug)]
pub(super) struct PosedVertex {
    pub position: Vec3,
    /// Rotation of the neighbourhood from the present pose to this one.
    rotation: Quat,
    pub planes: [f32; 6],
}

#[derive(Clone, Default)]
pub struct Poses {
    n_poses: usize,
    posed: Vec<PosedVertex>,
    growing_pull: f32,
}

/// Builds each surface vertex's position and rotation in every morph target, without planes.
fn poses_of_targets(original: &Original, attributes: &Attributes) -> Poses {
    let targets: Vec<&Channel> =
        attributes.channels.iter().filter(|channel| channel.role == Role::MorphPosition).collect();
    let surface = &original.surface;
    // Morph targets are stored per corner; any wedge of a vertex has its step.
    let mut wedge_of = vec![0; original.mesh.positions().len()];
    for (face, wedges) in original.mesh.faces().iter().zip(&attributes.wedges) {
        (0..3).for_each(|k| wedge_of[face[k] as usize] = wedges[k]);
    }
    let scale = surface.length(1.0);
    let place = |v: u32, target: &Channel| {
        // Targets that are not finite leave a vertex where it is.
        let step = match *target.value(wedge_of[surface.source(v) as usize]) {
            [x, y, z] if Vec3::new(x, y, z).is_finite() => Vec3::new(x, y, z),
            _ => Vec3::ZERO,
        };
        surface.positions[v as usize] + step * scale
    };
    let n_vertices = surface.n_vertices() as u32;
    let places: Vec<Vec<Vec3>> =
        targets.iter().map(|target| (0..n_vertices).map(|v| place(v, target)).collect()).collect();
    let posed = (0..n_vertices).flat_map(|v| places.iter().map(move |places| (v, places)));
    let posed = posed.map(|(v, places)| {
        // The rotation of each neighbourhood relates positions here to those in the pose.
        let rotation = find_rotation(v, surface.neighbors(v), &surface.positions, places);
        PosedVertex { position: places[v as usize], rotation, planes: [0.0; 6] }
    });
    Poses { n_poses: targets.len(), posed: posed.collect(), growing_pull: 0.0 }
}

impl Poses {
    pub fn new(original: &Original, task: &Task) -> Self {
        match task.pose_attributes() {
            Some(attributes) => poses_of_targets(original, attributes),
            None if task.options.purpose == Purpose::Poses => {
                let surface = &original.surface;
                // For unknown poses vertices are pulled to their positions, more strongly where areas are large. The
                // pull is relative to the total weight, so that it depends on the share of the surface.
                let weight: f64 = (0..surface.n_vertices()).map(|v| surface.weight(v)).sum();
                let growing_pull = if weight > 0.0 { (UNKNOWN_POSE_PULL / weight) as f32 } else { 0.0 };
                Self { growing_pull, ..Self::default() }
            }
            None => Self::default(),
        }
    }

    pub(super) fn growing_pull(&self) -> f32 {
        self.growing_pull
    }

    pub fn is_empty(&self) -> bool {
        self.n_poses == 0
    }

    pub(super) fn vertex_poses(&self, v: u32) -> &[PosedVertex] {
        &self.posed[v as usize * self.n_poses..][..self.n_poses]
    }

    pub(super) fn vertex_poses_mut(&mut self, v: u32) -> &mut [PosedVertex] {
        &mut self.posed[v as usize * self.n_poses..][..self.n_poses]
    }

    pub(super) fn n_poses(&self) -> usize {
        self.n_poses
    }

    /// Returns the mean of a merge's quadrics over all poses; `here` is that of the present pose.
    #[inline(never)]
    pub(super) fn mean_price(&self, [u, v]: [u32; 2], other: DVec3, here: Quadric) -> Quadric {
        let pairs = self.vertex_poses(u).iter().zip(self.vertex_poses(v));
        let sum = pairs.fold(here, |sum, (u, v)| sum + price_in([u, v], other));
        sum * (1.0 / (1 + self.n_poses) as f64)
    }

    pub(super) fn merge(&mut self, [u, v]: [u32; 2], other: DVec3, step: DVec3) {
        (0..self.n_poses).for_each(|k| self.vertex_poses_mut(u)[k] = self.merge_in_pose(k, [u, v], other, step));
    }

    /// Returns the merged vertex in pose `k` if in the present pose `u` moves by `step`; `other` is the offset of `v`
    /// from `u`.
    pub(super) fn merge_in_pose(&self, k: usize, vertices: [u32; 2], other: DVec3, step: DVec3) -> PosedVertex {
        let [u, v] = vertices.map(|w| self.vertex_poses(w)[k]);
        // The merged vertex keeps its offset from the edge's middle, rotated like both ends.
        let rotation = mean_rotation([&u, &v]);
        let middle = 0.5 * (u.position + v.position).as_dvec3();
        PosedVertex {
            position: (middle + rotation * (step - 0.5 * other)).as_vec3(),
            rotation: rotation.as_quat(),
            ..u
        }
    }
}

fn price_in([u, v]: [&PosedVertex; 2], other: DVec3) -> Quadric {
    let quadric = |posed: &PosedVertex| Quadric { a: posed.planes.map(f64::from), ..Quadric::default() };
    let to_other = (v.position - u.position).as_dvec3();
    // Around an edge the pose is a rotation about the edge's middle, which carries the quadric back to the present
    // pose.
    let rotation = DMat3::from_quat(mean_rotation([u, v]));
    let sum = quadric(u) + quadric(v).with_origin(-to_other);
    rotate_quadric(&sum.with_origin(0.5 * to_other - rotation * (0.5 * other)), &rotation)
}

fn rotate_quadric(form: &Quadric, rotation: &DMat3) -> Quadric {
    let [xx, xy, xz, yy, yz, zz] = form.a;
    let a = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    let a = rotation.transpose() * a * *rotation;
    let a = [a.x_axis.x, a.y_axis.x, a.z_axis.x, a.y_axis.y, a.z_axis.y, a.z_axis.z];
    Quadric { a, b: rotation.transpose() * form.b, c: form.c }
}

fn mean_rotation([u, v]: [&PosedVertex; 2]) -> DQuat {
    let (u, v) = (u.rotation.as_dquat(), v.rotation.as_dquat());
    // A quaternion and its negative are one rotation.
    let sum = if u.dot(v) < 0.0 { u - v } else { u + v };
    if sum.length_squared() > 0.0 { sum.normalize() } else { u }
}

/// Finds the rotation that best maps a vertex's edges and normal from pose `here` to `there`.
///
/// Müller et al. 2016, "A robust method to extract the rotational part of deformations".
fn find_rotation(v: u32, neighbors: &[u32], here: &[Vec3], there: &[Vec3]) -> Quat {
    let edges =
        |places: &[Vec3]| -> Vec<Vec3> { neighbors.iter().map(|&w| places[w as usize] - places[v as usize]).collect() };
    let normal = |edges: &[Vec3]| edges.windows(2).map(|pair| pair[0].cross(pair[1])).sum::<Vec3>().normalize_or_zero();
    let [here, there] = [here, there].map(edges);
    let [of_here, of_there] = [&here, &there].map(|edges| normal(edges));
    let outer = |there: Vec3, here: Vec3| Mat3::from_cols(there * here.x, there * here.y, there * here.z);
    let edges = here.iter().zip(&there).map(|(&here, &there)| outer(there, here));
    let sum = edges.fold(Mat3::ZERO, |sum, edge| sum + edge);
    let size: f32 = here.iter().map(|edge| edge.length_squared()).sum();
    let sum = sum + size * outer(of_there, of_here);
    // A good start keeps the iteration away from the opposite rotation.
    let mut rotation = initial_rotation([of_here, of_there], here.first().zip(there.first()));
    for _ in 0..STEPS {
        let now = Mat3::from_quat(rotation);
        let axes = [(now.x_axis, sum.x_axis), (now.y_axis, sum.y_axis), (now.z_axis, sum.z_axis)];
        let torque: Vec3 = axes.iter().map(|(now, sum)| now.cross(*sum)).sum();
        // Torque over stiffness, as for a rigid body with springs at its axes.
        let along: f32 = axes.iter().map(|(now, sum)| now.dot(*sum)).sum();
        let step = torque / (along.abs() + f32::MIN_POSITIVE);
        let angle = step.length();
        if !(angle > 1e-6 && angle.is_finite()) {
            break;
        }
        rotation = (Quat::from_axis_angle(step / angle, angle) * rotation).normalize();
    }
    rotation
}

fn initial_rotation([here, there]: [Vec3; 2], edges: Option<(&Vec3, &Vec3)>) -> Quat {
    let frame = |normal: Vec3, edge: Vec3| {
        let along = edge.reject_from_normalized(normal).normalize_or_zero();
        (along != Vec3::ZERO).then(|| Mat3::from_cols(along, normal.cross(along), normal))
    };
    let frames = edges.and_then(|(&of_here, &of_there)| frame(here, of_here).zip(frame(there, of_there)));
    frames.map_or(Quat::IDENTITY, |(here, there)| Quat::from_mat3(&(there * here.transpose())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn posed_vertex(position: [f32; 3], normals: &[[f32; 3]], rotation: Quat) -> PosedVertex {
        let mut planes = [0.0; 6];
        for &[x, y, z] in normals {
            planes.iter_mut().zip([x * x, x * y, x * z, y * y, y * z, z * z]).for_each(|(sum, entry)| *sum += entry);
        }
        PosedVertex { position: position.into(), rotation, planes }
    }

    #[test]
    fn what_a_merge_costs_in_a_pose_is_the_squared_distance_from_its_planes_there() {
        let rotation = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-0.4);
        let of_u = [[1.0, 0.0, 0.0], [0.6, 0.8, 0.0]];
        let of_v = [[0.0, 0.6, 0.8]];
        let (u, v) = (posed_vertex([1.0, 2.0, 3.0], &of_u, rotation), posed_vertex([1.5, 2.5, 2.0], &of_v, rotation));
        let other = DVec3::new(0.3, -0.5, 1.0);
        for x in [DVec3::ZERO, other, DVec3::new(0.4, 0.1, -0.7)] {
            let middle = 0.5 * (u.position + v.position).as_dvec3();
            let there = middle + rotation.as_dquat() * (x - 0.5 * other);
            let squares = |posed: &PosedVertex, normals: &[[f32; 3]]| -> f64 {
                let height = |n: &[f32; 3]| Vec3::from(*n).as_dvec3().dot(there - posed.position.as_dvec3());
                normals.iter().map(|n| height(n).powi(2)).sum()
            };
            let (found, naive) = (price_in([&u, &v], other).value(x), squares(&u, &of_u) + squares(&v, &of_v));
            assert!((found - naive).abs() < 1e-5 * naive.max(1.0), "{found} {naive}");
        }
    }

    #[test]
    fn the_turn_of_a_turned_surface_is_its_rotation() {
        let mesh = shapes::wavy_sphere(3, 6.0);
        let original = Original::bare(&mesh);
        let surface = &original.surface;
        for rotation in [Quat::from_rotation_z(3.0), Quat::from_rotation_x(1.2) * Quat::from_rotation_y(-2.0)] {
            let there: Vec<Vec3> = surface.positions.iter().map(|&p| rotation * p + Vec3::ONE).collect();
            for v in 0..surface.n_vertices() as u32 {
                let found = find_rotation(v, surface.neighbors(v), &surface.positions, &there);
                assert!(found.dot(rotation).abs() > 1.0 - 1e-5, "{v}: {found} {rotation}");
            }
        }
    }

    #[test]
    fn a_pose_that_is_a_turn_costs_what_is_paid_here() {
        let mesh = shapes::wavy_sphere(3, 6.0);
        let rotation = Quat::from_rotation_x(1.2) * Quat::from_rotation_y(-2.0);
        let step = |p: &[f32; 3]| (rotation * Vec3::from(*p) - Vec3::from(*p)).to_array();
        let values = mesh.positions().iter().flat_map(step).collect();
        let target = Channel { name: "TARGET_0/POSITION".into(), role: Role::MorphPosition, width: 3, values };
        let attributes = Attributes { wedges: mesh.faces().to_vec(), channels: vec![target], groups: Vec::new() };
        let original = Original::bare(&mesh);
        let mut poses = poses_of_targets(&original, &attributes);
        let turned: Vec<PosedVertex> = (0..mesh.positions().len() as u32).map(|v| poses.vertex_poses(v)[0]).collect();
        let (u, v) = (7, original.surface.neighbors(7)[0]);
        let other = (original.surface.positions[v as usize] - original.surface.positions[u as usize]).as_dvec3();
        let step = DVec3::new(0.01, 0.02, -0.01);
        poses.merge([u, v], other, step);
        let meant = turned[u as usize].position + rotation * step.as_vec3();
        assert!(poses.vertex_poses(u)[0].position.distance(meant) < 1e-5);
    }
}
