//! Attributes of a 3MF: groups from materials, colours of corners.

use rustc_hash::FxHashMap;

use super::document::{FaceProperty, Object};
use crate::io::Group;
use crate::io::unique_materials::{UniqueMaterials, UniqueNames};
use crate::mesh::{Attributes, Channel, Look, RawMesh, Role, linear_light};

#[derive(Default)]
pub(super) struct ObjectMeshes {
    pub meshes: Vec<RawMesh>,
    pub first_groups: Vec<u32>,
    pub groups: Vec<Group>,
    pub materials: UniqueMaterials,
    names: UniqueNames,
    pub notes: IgnoredContent,
}

#[derive(Default)]
pub(super) struct IgnoredContent {
    pub has_beams: bool,
    pub has_textures: bool,
    pub n_mixed: usize,
}

impl IgnoredContent {
    pub fn lines(&self) -> Vec<String> {
        let mixed = (self.n_mixed > 0).then(|| {
            format!("materials that change within a face are taken from its first corner (faces: {})", self.n_mixed)
        });
        let beams = self.has_beams.then(|| "beams of the 3mf are dropped".into());
        let textures = self.has_textures.then(|| "textures and mixtures of the 3mf are dropped".into());
        [textures, beams, mixed].into_iter().flatten().collect()
    }
}

type FaceEntries = (u32, [u32; 3]);

impl ObjectMeshes {
    /// Adds an object's mesh and returns its index; `is_named` gives unnamed objects a numbered name.
    pub fn add(&mut self, object: &mut Object, properties: &FxHashMap<u32, FaceProperty>, is_named: bool) -> usize {
        let positions = std::mem::take(&mut object.positions);
        let faces = std::mem::take(&mut object.faces);
        // A face without its own property has that of its object.
        let entries_of = |face: usize| {
            let own = object.of_faces.get(face).copied().flatten();
            own.or(object.property.map(|(property, entry)| (property, [entry; 3])))
        };
        let name = object.name.clone().or_else(|| is_named.then(|| format!("object {}", object.id)));
        // Objects of equal name stay apart, as groups have only names.
        let name = name.map(|name| self.names.add(&name));
        let attributes = Attributes {
            groups: self.groups_of(name, (0..faces.len()).map(entries_of), properties),
            ..colour_corners(&faces, entries_of, properties)
        };
        self.meshes.push(RawMesh { positions, faces, attributes, ..RawMesh::default() });
        self.meshes.len() - 1
    }

    pub fn colour_width(&self) -> usize {
        let channels = self.meshes.iter().flat_map(|mesh| &mesh.attributes.channels);
        channels.map(|channel| channel.width).max().unwrap_or(0)
    }

    fn groups_of(
        &mut self,
        object: Option<String>,
        entries_of: impl Iterator<Item = Option<FaceEntries>>,
        properties: &FxHashMap<u32, FaceProperty>,
    ) -> Vec<u32> {
        let first = self.groups.len();
        self.first_groups.push(first as u32);
        let mut numbers: FxHashMap<Option<(u32, u32)>, u32> = FxHashMap::default();
        let mut groups = Vec::new();
        for entries_of in entries_of {
            let named =
                entries_of.and_then(|(property, entries)| Some((property, entries, properties.get(&property)?)));
            self.notes.has_textures |= matches!(named, Some((.., FaceProperty::Other)));
            let material = match named {
                // A group needs one material, so that of the first corner counts.
                Some((property, entries, FaceProperty::Materials(materials)))
                    if (entries[0] as usize) < materials.len() =>
                {
                    self.notes.n_mixed += usize::from(entries != [entries[0]; 3]);
                    Some((property, entries[0]))
                }
                _ => None,
            };
            let next = (self.groups.len() - first) as u32;
            let number = *numbers.entry(material).or_insert(next);
            if number == next {
                let material = material.and_then(|(property, entry)| match properties.get(&property) {
                    Some(FaceProperty::Materials(materials)) => materials.get(entry as usize),
                    _ => None,
                });
                let material = material.map(|(name, colour)| self.material(name, *colour));
                self.groups.push(Group { object: object.clone(), material, ..Group::default() });
            }
            groups.push(number);
        }
        groups
    }

    fn material(&mut self, name: &str, [red, green, blue, alpha]: [f32; 4]) -> String {
        let mut look = Look { colour: [red, green, blue].map(linear_light), ..Look::default() };
        look.finish.is_opaque = alpha == 1.0;
        self.materials.add(name, look)
    }
}

fn colour_corners(
    faces: &[[u32; 3]],
    entries_of: impl Fn(usize) -> Option<FaceEntries>,
    properties: &FxHashMap<u32, FaceProperty>,
) -> Attributes {
    let colours = |face: usize| match entries_of(face).map(|(property, entries)| (properties.get(&property), entries)) {
        Some((Some(FaceProperty::Colours(colours)), entries)) => {
            Some(entries.map(|entry| colours.get(entry as usize).copied().unwrap_or([1.0; 4])))
        }
        _ => None,
    };
    // Without colours no channel is made.
    if !(0..faces.len()).any(|face| colours(face).is_some()) {
        return Attributes::default();
    }
    let mut numbers: FxHashMap<(u32, [u32; 4]), u32> = FxHashMap::default();
    let (mut values, mut wedges) = (Vec::new(), Vec::with_capacity(faces.len()));
    for (face, corners) in faces.iter().enumerate() {
        let colours = colours(face).unwrap_or([[1.0; 4]; 3]);
        wedges.push(std::array::from_fn(|k| {
            let next = numbers.len() as u32;
            let wedge = *numbers.entry((corners[k], colours[k].map(f32::to_bits))).or_insert(next);
            if wedge == next {
                values.push(colours[k]);
            }
            wedge
        }));
    }
    // Alpha is stored unless all colours are opaque.
    let width = if values.iter().all(|colour| colour[3] == 1.0) { 3 } else { 4 };
    let values = values.iter().flat_map(|colour| &colour[..width]).copied().collect();
    let channel = Channel { name: "colour".into(), role: Role::Colour, width, values };
    Attributes { wedges, channels: vec![channel], groups: Vec::new() }
}
