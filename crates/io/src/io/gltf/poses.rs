//! Poses of skinned meshes, from animations or invented.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use serde::Deserialize;

use super::asset::Asset;
use super::bones::{Bones, world_transforms};
use super::placements::local_transform;
use crate::io::ReadError;
use crate::mesh::{Channel, RawMesh, Role};

const POSES: usize = 12;
const BENT: f64 = std::f64::consts::FRAC_PI_3;
const POSE: &str = "POSE_";

#[derive(Default, Deserialize)]
#[serde(default)]
struct Animation {
    channels: Vec<AnimatedValue>,
    samplers: Vec<AnimationSampler>,
}

#[derive(Deserialize)]
struct AnimatedValue {
    sampler: usize,
    target: AnimationTarget,
}

#[derive(Deserialize)]
struct AnimationTarget {
    node: Option<usize>,
    path: String,
}

#[derive(Deserialize)]
struct AnimationSampler {
    input: usize,
    output: usize,
    #[serde(default)]
    interpolation: String,
}

impl Asset {
    /// Returns the displacements of each part in poses, in the order of [`Asset::parts`]; nothing without skins.
    ///
    /// Each pose is a channel `POSE_0`, ... of role [`Role::MorphPosition`], at the wedges and in the unit of the part.
    /// At most 12 poses are spread over the animations; without any, joints are bent by up to 60 degrees.
    ///
    /// # Errors
    /// [`ReadError`] if skins or animations have invalid indices.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// assert_eq!(asset.poses().unwrap(), [vec![]]);
    /// ```
    pub fn poses(&self) -> Result<Vec<Vec<Channel>>, ReadError> {
        let (data, nodes) = (self.container.data(), &self.container.root.nodes);
        let skins = self.container.root.skins.iter().map(|skin| Bones::read(&data, skin));
        let skins: Vec<Bones> = skins.collect::<Result<_, _>>()?;
        // The first node of a mesh decides.
        let skins_of_nodes = nodes.iter().rev().filter_map(|node| Some((node.mesh?, node.skin)));
        let skin_of: HashMap<usize, Option<usize>> = skins_of_nodes.collect();
        let bones = |mesh: &usize| skins.get(skin_of.get(mesh).copied()??);
        let bones_of: Vec<Option<&Bones>> = self.meshes.iter().map(bones).collect();
        // Most assets have no skins.
        if bones_of.iter().all(Option::is_none) {
            return Ok(vec![Vec::new(); self.parts().len()]);
        }
        let rest: Vec<DMat4> = nodes.iter().map(local_transform).collect();
        let poses = self.local_poses(&rest, &skins)?;
        // The rest pose comes first, for the scale of the displacements.
        let worlds: Vec<Vec<DMat4>> =
            std::iter::once(&rest).chain(&poses).map(|local| world_transforms(nodes, local)).collect();
        let of_part = |(part, bones): (&super::AssetPart, &Option<&Bones>)| {
            let places = wedge_positions(&part.mesh);
            let moved = |world: &Vec<DMat4>| bones.map(|bones| apply_skin(&part.mesh, &places, bones, world));
            let rest = moved(&worlds[0]);
            let channel = |(k, world): (usize, &Vec<DMat4>)| Channel {
                name: format!("{POSE}{k}"),
                role: Role::MorphPosition,
                width: 3,
                values: displacements(&places, rest.as_deref(), moved(world).as_deref()),
            };
            worlds[1..].iter().enumerate().map(channel).collect()
        };
        Ok(self.parts().iter().zip(&bones_of).map(of_part).collect())
    }

    fn local_poses(&self, rest: &[DMat4], skins: &[Bones]) -> Result<Vec<Vec<DMat4>>, ReadError> {
        let animations: Vec<Animation> = self.read_list("animations");
        let animations: Vec<Animation> = animations.into_iter().filter(Animation::moves_nodes).take(POSES).collect();
        if animations.is_empty() {
            return Ok((0..POSES as u64).map(|seed| bend_joints(rest, skins, seed)).collect());
        }
        let mut poses = Vec::new();
        for (i, animation) in animations.iter().enumerate() {
            // The first animations get the remainder.
            let n = POSES / animations.len() + usize::from(i < POSES % animations.len());
            let tracks = self.tracks(animation)?;
            poses.extend((0..n).map(|k| animate(rest, &tracks, (k as f64 + 0.5) / n as f64)));
        }
        Ok(poses)
    }

    fn tracks<'b>(&self, animation: &'b Animation) -> Result<Vec<(usize, &'b str, Track)>, ReadError> {
        let n_nodes = self.container.root.nodes.len();
        let mut tracks = Vec::new();
        for value in &animation.channels {
            let target = value.target.node.filter(|&node| node < n_nodes);
            if let (Some(node), Some(sampler)) = (target, animation.samplers.get(value.sampler)) {
                tracks.push((node, value.target.path.as_str(), self.track(sampler)?));
            }
        }
        Ok(tracks)
    }

    fn track(&self, sampler: &AnimationSampler) -> Result<Track, ReadError> {
        // Most numbers in a track, enough for hours of motion.
        const MOST: usize = 1 << 24;
        let data = self.container.data();
        let (_, times) = data.floats(sampler.input, MOST)?;
        let (width, values) = data.floats(sampler.output, MOST)?;
        let n_of_key = if sampler.interpolation == "CUBICSPLINE" { 3 } else { 1 };
        let row = |row: &[f32]| {
            let number = |i: usize| f64::from(row.get(i).copied().unwrap_or_default());
            glam::DVec4::new(number(0), number(1), number(2), number(3))
        };
        // A cubic spline has three rows per key; only the middle one, the value, is used, interpolated linearly.
        let values = values.chunks_exact(width).skip(n_of_key / 2).step_by(n_of_key).map(row).collect();
        let times = times.into_iter().map(f64::from).collect();
        Ok(Track { times, values, is_stepped: sampler.interpolation == "STEP" })
    }
}

fn animate(rest: &[DMat4], tracks: &[(usize, &str, Track)], share: f64) -> Vec<DMat4> {
    let end = tracks.iter().filter_map(|(_, _, track)| track.times.last().copied()).fold(0.0, f64::max);
    let mut parts: Vec<Option<[DVec3; 2]>> = vec![None; rest.len()];
    let mut turns: Vec<DQuat> = vec![DQuat::IDENTITY; rest.len()];
    for (node, path, track) in tracks {
        if parts[*node].is_none() {
            let (scale, turn, translation) = rest[*node].to_scale_rotation_translation();
            (parts[*node], turns[*node]) = (Some([scale, translation]), turn);
        }
        let Some(value) = track.interpolate(share * end) else { continue };
        let [scale, translation] = parts[*node].get_or_insert([DVec3::ONE, DVec3::ZERO]);
        match *path {
            "translation" => *translation = value.truncate(),
            "scale" => *scale = value.truncate(),
            "rotation" => turns[*node] = DQuat::from_vec4(value.normalize_or(glam::DVec4::W)),
            _ => {}
        }
    }
    let moved = |(node, parts): (usize, &Option<[DVec3; 2]>)| match parts {
        Some([scale, translation]) => DMat4::from_scale_rotation_translation(*scale, turns[node], *translation),
        None => rest[node],
    };
    parts.iter().enumerate().map(moved).collect()
}

impl Animation {
    fn moves_nodes(&self) -> bool {
        // Some animations move only morph targets.
        self.channels.iter().any(|value| value.target.node.is_some() && value.target.path != "weights")
    }
}

struct Track {
    times: Vec<f64>,
    values: Vec<glam::DVec4>,
    is_stepped: bool,
}

impl Track {
    // Rotations are interpolated the shorter way round; a track without keys has no value.
    fn interpolate(&self, time: f64) -> Option<glam::DVec4> {
        let last = self.times.len().min(self.values.len()).checked_sub(1)?;
        let after = self.times[..=last].partition_point(|&t| t <= time).min(last);
        let before = after.saturating_sub(1);
        let [a, b] = [before, after].map(|key| self.values[key]);
        let (begin, span) = (self.times[before], self.times[after] - self.times[before]);
        let share = if span > 0.0 && !self.is_stepped { ((time - begin) / span).clamp(0.0, 1.0) } else { 0.0 };
        Some(a.lerp(if a.dot(b) < 0.0 { -b } else { b }, share))
    }
}

fn bend_joints(rest: &[DMat4], skins: &[Bones], seed: u64) -> Vec<DMat4> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut unit = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let mut local = rest.to_vec();
    for &joint in skins.iter().flat_map(|skin| skin.joints.iter().skip(1)) {
        let axis = DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5).normalize_or(DVec3::X);
        let turn = DMat4::from_axis_angle(axis, BENT * unit());
        local.get_mut(joint).into_iter().for_each(|local| *local *= turn);
    }
    local
}

fn apply_skin(mesh: &RawMesh, places: &[DVec3], bones: &Bones, world: &[DMat4]) -> Vec<DVec3> {
    let joints = bones.joints.iter().zip(&bones.inverse_bind);
    let matrices: Vec<DMat4> =
        joints.map(|(&joint, inverse)| world.get(joint).map_or(DMat4::IDENTITY, |world| *world * *inverse)).collect();
    let Some(skin) = mesh.attributes.channel(Role::Skin) else {
        return places.to_vec();
    };
    let moved = |(wedge, place): (u32, &DVec3)| {
        let (joints, weights) = skin.value(wedge).split_at(skin.width / 2);
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (&joint, &weight) in joints.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
            if let Some(matrix) = matrices.get(joint as usize) {
                sum += f64::from(weight) * matrix.transform_point3(*place);
                total += f64::from(weight);
            }
        }
        // Weights that do not sum to one are normalised; absent weights leave the vertex.
        if total > 0.0 { sum / total } else { *place }
    };
    (0..).zip(places).map(moved).collect()
}

fn wedge_positions(mesh: &RawMesh) -> Vec<DVec3> {
    let mut places = vec![DVec3::ZERO; mesh.attributes.n_wedges()];
    for (face, wedges) in mesh.faces.iter().zip(&mesh.attributes.wedges) {
        for (&v, &wedge) in face.iter().zip(wedges) {
            if let (Some(p), Some(place)) = (mesh.positions.get(v as usize), places.get_mut(wedge as usize)) {
                *place = (*p).into();
            }
        }
    }
    places
}

/// Returns the displacements of wedges in a pose, n_wedges x 3.
fn displacements(places: &[DVec3], rest: Option<&[DVec3]>, pose: Option<&[DVec3]>) -> Vec<f32> {
    let (Some(rest), Some(pose)) = (rest, pose) else { return vec![0.0; 3 * places.len()] };
    let mean = |of: &[DVec3]| of.iter().sum::<DVec3>() / of.len().max(1) as f64;
    let spread = |of: &[DVec3], mean: DVec3| of.iter().map(|p| p.distance_squared(mean)).sum::<f64>().sqrt();
    let means = [places, rest, pose].map(mean);
    // The scene may scale a mesh, so displacements are measured in its own unit and about its centre.
    let scale = spread(places, means[0]) / spread(rest, means[1]);
    let scale = if scale.is_normal() { scale } else { 1.0 };
    let step = |(place, posed): (&DVec3, &DVec3)| (*posed - means[2]) * scale - (*place - means[0]);
    let finite = |step: glam::Vec3| if step.is_finite() { step } else { glam::Vec3::ZERO };
    places.iter().zip(pose).flat_map(|pair| finite(step(pair).as_vec3()).to_array()).collect()
}
