//! The meshes of the default scene as one, with what their corners carry and what they look like, for formats without scenes.
//!
//! Texture coordinates are turned so that v runs upwards and colours are those of sRGB, as OBJ and PLY have them. Tangents, skins
//! and morph targets stay behind.

use glam::{DMat3, DMat4, DVec3};

use super::asset::Asset;
use super::part::Part;
use super::placements::{Placed, placements};
use super::{REFUSED, is_far_out, refuse, spend};
use crate::io::ReadError;
use crate::io::extra::{Extra, Group, ReadMesh};
use crate::mesh::{Channel, Role, srgb};

/// What a mesh without a scene does not hold.
const LEFT: &str = "tangents, skins and morph targets belong to the scene: left out";

/// Reads a glTF asset as one mesh with all that goes along; `fetch` gives the bytes of a file that it names, by its URI. What
/// cannot be read but for its geometry is read as [`read`](super::read) does.
pub(in crate::io) fn read_attributed(
    bytes: &[u8],
    fetch: &dyn Fn(&str) -> Result<Vec<u8>, ReadError>,
) -> Result<ReadMesh, ReadError> {
    let asset = match Asset::from_bytes(bytes, fetch) {
        Ok(asset) => asset,
        Err(error) => {
            let mesh = super::read(bytes, fetch)?;
            let notes = vec![format!("geometry alone: {}", ReadError { format: None, ..error })];
            return Ok(ReadMesh { mesh, notes, ..ReadMesh::default() });
        }
    };
    refuse(&asset.container.root, &REFUSED)?;
    let mut united = United::new(&asset);
    let mut budget = asset.container.budget(bytes.len());
    for placed in placements(&asset.container.root)? {
        if let Some(part) = asset.meshes.iter().position(|&mesh| mesh == placed.mesh) {
            united.add(part, &placed, &mut budget)?;
        }
    }
    let mut read = united.read;
    read.mesh.double = is_far_out(&read.mesh.positions);
    Ok(read)
}

/// The mesh and what was collected for it.
struct United<'a> {
    parts: &'a [Part],
    read: ReadMesh,
    /// The first group of each part.
    first_groups: Vec<u32>,
    n_wedges: usize,
}

impl<'a> United<'a> {
    fn new(asset: &'a Asset) -> Self {
        let (looks, notes) = asset.looks();
        let names = material_names(asset);
        let (mut extra, mut first_groups) = (Extra::default(), Vec::new());
        for ((part, &mesh), looks) in asset.parts().iter().zip(&asset.meshes).zip(looks) {
            first_groups.push(extra.groups.len() as u32);
            let Some(mesh) = asset.container.root.meshes.get(mesh) else { continue };
            for (primitive, look) in mesh.primitives.iter().zip(looks) {
                let material = primitive.material.and_then(|index| names.get(index)).cloned();
                let is_new = |name: &&String| extra.looks.iter().all(|(known, _)| known != *name);
                extra.looks.extend(material.as_ref().filter(is_new).map(|name| (name.clone(), look)));
                extra.groups.push(Group { object: Some(part.name.clone()), material, ..Group::default() });
            }
        }
        let mut read = ReadMesh { extra, notes: [asset.notes(), &notes].concat(), ..ReadMesh::default() };
        read.mesh.attributes.channels = channels(asset.parts());
        let all = asset.parts().iter().flat_map(|part| &part.mesh.attributes.channels);
        read.notes.extend(all.into_iter().any(|channel| !is_carried(channel.role)).then(|| LEFT.to_string()));
        Self { parts: asset.parts(), read, first_groups, n_wedges: 0 }
    }

    /// Adds a part where a node places it.
    fn add(&mut self, part: usize, placed: &Placed, budget: &mut usize) -> Result<(), ReadError> {
        let (mesh, first_group) = (&self.parts[part].mesh, self.first_groups[part]);
        let n_wedges = mesh.attributes.n_wedges().max(1);
        let numbers = &self.read.mesh.attributes.channels.iter().map(|channel| channel.width).sum::<usize>();
        spend(budget, mesh.positions.len() + mesh.faces.len() + n_wedges * numbers)?;
        let transform = placed.transform;
        let is_mirrored = transform.determinant() < 0.0;
        let turned = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        let united = &mut self.read.mesh;
        let (first, n_own, first_wedge) = (united.positions.len(), mesh.positions.len(), self.n_wedges as u32);
        let place = |v: u32| if (v as usize) < n_own { (first + v as usize) as u32 } else { u32::MAX };
        united.positions.extend(mesh.positions.iter().map(|&p| transform.transform_point3(p.into()).to_array()));
        united.faces.extend(mesh.faces.iter().map(|&face| turned(face.map(place))));
        let attributes = &mut united.attributes;
        let group = |f: u32| first_group + mesh.attributes.group(f);
        attributes.groups.extend((0..mesh.faces.len() as u32).map(group));
        if attributes.channels.is_empty() {
            return Ok(());
        }
        let wedges = |f: usize| mesh.attributes.wedges.get(f).copied().unwrap_or_default();
        attributes.wedges.extend((0..mesh.faces.len()).map(|f| turned(wedges(f).map(|wedge| wedge + first_wedge))));
        for channel in &mut attributes.channels {
            let own = mesh.attributes.channels.iter().find(|own| own.name == channel.name);
            extend(channel, own, n_wedges, &transform);
        }
        self.n_wedges += n_wedges;
        Ok(())
    }
}

/// The names of the materials, each once and without blanks, which end a name in many readers of MTL.
fn material_names(asset: &Asset) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (index, material) in asset.container.root.materials.iter().enumerate() {
        let name = material.name.as_deref().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join("_");
        let is_own = !name.is_empty() && !names.contains(&name);
        names.push(if is_own { name } else { format!("{}_{index}", if name.is_empty() { "material" } else { &name }) });
    }
    names
}

fn is_carried(role: Role) -> bool {
    matches!(role, Role::Normal | Role::Uv | Role::Colour | Role::Other | Role::Label)
}

/// The channels of all parts, each once, without values.
fn channels(parts: &[Part]) -> Vec<Channel> {
    let mut channels: Vec<Channel> = Vec::new();
    let all = parts.iter().flat_map(|part| &part.mesh.attributes.channels);
    for channel in all.filter(|channel| is_carried(channel.role)) {
        match channels.iter_mut().find(|other| other.name == channel.name) {
            Some(other) => other.width = other.width.max(channel.width),
            None => channels.push(Channel { values: Vec::new(), name: channel.name.clone(), ..*channel }),
        }
    }
    channels
}

/// Appends the values of a part's wedges as they are in the scene; zeros where it has none, and 1 for an alpha that it lacks.
fn extend(channel: &mut Channel, own: Option<&Channel>, n_wedges: usize, transform: &DMat4) {
    let to_scene = DMat3::from_mat4(*transform).inverse().transpose();
    for wedge in 0..n_wedges as u32 {
        let start = channel.values.len();
        let values = own.map_or(&[][..], |own| own.of(wedge));
        channel.values.extend_from_slice(values);
        let missing = if channel.role == Role::Colour { 1.0 } else { 0.0 };
        channel.values.resize(start + channel.width, missing);
        let row = &mut channel.values[start..];
        match channel.role {
            Role::Normal => turn(row, &to_scene),
            Role::Uv => row.iter_mut().skip(1).step_by(2).for_each(|v| *v = 1.0 - *v),
            Role::Colour => row.iter_mut().take(3).for_each(|x| *x = srgb(*x)),
            _ => {}
        }
    }
}

/// Turns a direction with a node.
fn turn(row: &mut [f32], to_scene: &DMat3) {
    if let [x, y, z] = row {
        let turned = (*to_scene * DVec3::new(f64::from(*x), f64::from(*y), f64::from(*z))).normalize_or_zero();
        let turned = if turned.is_finite() { turned.as_vec3() } else { glam::Vec3::ZERO };
        [*x, *y, *z] = turned.to_array();
    }
}
