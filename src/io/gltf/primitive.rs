//! A primitive on its way out: its vertices, their attributes and morph targets, its indices.

use rustc_hash::FxHashMap;
use serde_json::{Map, Value};

use super::accessor::shape_width;
use super::draft::{Draft, Stored, UNSIGNED_BYTE, UNSIGNED_SHORT};
use super::lighter::LighterPart;
use super::semantics::{SKIN, is_own_channel, target_channel};
use super::values;
use crate::mesh::{Channel, Role};

/// The vertices of a file that some faces need: one for each pair of a vertex and a wedge.
pub(super) struct Vertices {
    /// Vertex and wedge of the part, n_vertices.
    pairs: Vec<[u32; 2]>,
    /// Positions, n_vertices x 3.
    positions: Vec<[f32; 3]>,
    /// Indices of these vertices, n_faces x 3.
    faces: Vec<[u32; 3]>,
}

impl Vertices {
    /// The vertices of these faces, in the order in which faces need them.
    pub fn of(part: &LighterPart, faces: &[u32]) -> Self {
        let (mut known, mut pairs) = (FxHashMap::default(), Vec::new());
        let mut place = |pair: [u32; 2]| {
            *known.entry(pair).or_insert_with(|| {
                pairs.push(pair);
                pairs.len() as u32 - 1
            })
        };
        let place_face = |&face: &u32| {
            let (vertices, wedges) = (part.faces[face as usize], part.wedges(face as usize));
            [0, 1, 2].map(|corner| place([vertices[corner], wedges[corner]]))
        };
        let faces = faces.iter().map(place_face).collect();
        let positions = pairs.iter().map(|pair| part.positions[pair[0] as usize]).collect();
        Self { pairs, positions, faces }
    }

    /// How many they are.
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// The values of a channel at the vertices, n_vertices x width.
    fn values(&self, channel: &Channel) -> Vec<f32> {
        let mut values: Vec<f32> = self.pairs.iter().flat_map(|pair| channel.of(pair[1])).copied().collect();
        values::mend_numbers(&mut values);
        values
    }
}

/// How an attribute or what a morph target adds to it is stored, by its name.
pub(super) type Slots = Vec<(String, Stored)>;

/// The vertices of a primitive on their way into a document.
pub(super) struct PrimitiveWriter<'a, 'b> {
    pub draft: &'a mut Draft<'b>,
    pub part: &'a LighterPart,
    pub vertices: &'a Vertices,
}

impl PrimitiveWriter<'_, '_> {
    /// Writes the attributes that a primitive has: name -> accessor. What the part lost is left out.
    pub fn attributes(&mut self, slots: &Slots) -> Value {
        let n_sets = slots.iter().filter(|(name, _)| name.starts_with("JOINTS_")).count();
        let mut skin = self.skin(n_sets);
        let mut accessors = Map::new();
        for (name, stored) in slots {
            let accessor = match name.as_str() {
                "POSITION" => Some(self.positions()),
                _ if is_own_channel(name) => self.own(name, stored),
                _ => skin.remove(name),
            };
            accessors.extend(accessor.map(|accessor| (name.clone(), accessor)));
        }
        Value::Object(accessors)
    }

    /// Writes the morph targets of a primitive: for each name -> accessor.
    pub fn targets(&mut self, targets: &[Slots]) -> Value {
        let mut write = |(target, slots): (usize, &Slots)| {
            let accessor = |(name, stored): &(String, Stored)| {
                let channel = self.part.channel(&target_channel(target, name))?;
                let values = self.vertices.values(channel);
                Some((name.clone(), self.push(values, channel.width, stored, name == "POSITION")))
            };
            Value::Object(slots.iter().filter_map(accessor).collect())
        };
        Value::Array(targets.iter().enumerate().map(&mut write).collect())
    }

    /// Writes the faces: their accessor.
    pub fn indices(&mut self) -> Value {
        self.draft.push_indices(&self.vertices.faces, self.vertices.positions.len())
    }

    fn positions(&mut self) -> Value {
        self.draft.push_values(self.vertices.positions.as_flattened(), 3, &Stored::floats("VEC3"), true)
    }

    /// Writes the channel of the attribute `name`.
    fn own(&mut self, name: &str, stored: &Stored) -> Option<Value> {
        let channel = self.part.channel(name)?;
        let mut values = self.vertices.values(channel);
        match channel.role {
            Role::Normal if channel.width == 3 => self.mend_normals(&mut values),
            Role::Tangent if channel.width == 4 => values::mend_tangents(&mut values, self.normals().as_deref()),
            Role::Colour => values::mend_colours(&mut values),
            _ => {}
        }
        Some(self.push(values, channel.width, stored, false))
    }

    /// Appends values of which a primitive has as many columns as its own shape says; more are lent by others in the mesh.
    fn push(&mut self, values: Vec<f32>, width: usize, stored: &Stored, bounded: bool) -> Value {
        let own = shape_width(&stored.shape).min(width);
        let values = match own == width {
            true => values,
            false => values.chunks_exact(width).flat_map(|row| row[..own].to_vec()).collect(),
        };
        self.draft.push_values(&values, own, stored, bounded)
    }

    fn mend_normals(&self, normals: &mut [f32]) {
        values::mend_normals(normals, &self.vertices.positions, &self.vertices.faces);
    }

    fn normals(&self) -> Option<Vec<f32>> {
        let mut normals = self.vertices.values(self.part.channel("NORMAL").filter(|channel| channel.width == 3)?);
        self.mend_normals(&mut normals);
        Some(normals)
    }

    /// Writes joints and weights in sets of four: name -> accessor.
    fn skin(&mut self, n_sets: usize) -> FxHashMap<String, Value> {
        let mut accessors = FxHashMap::default();
        let Some(channel) = self.part.channel(SKIN).filter(|_| n_sets > 0) else { return accessors };
        let (joints, weights) = values::skin(&self.vertices.values(channel), channel.width, n_sets);
        let small = joints.iter().all(|&joint| joint <= f32::from(u8::MAX));
        let component = if small { UNSIGNED_BYTE } else { UNSIGNED_SHORT };
        let joint_kind = Stored { component, ..Stored::floats("VEC4") };
        for set in 0..n_sets {
            let of_set = |values: &[f32]| {
                values.chunks_exact(4 * n_sets).flat_map(|row| row[4 * set..4 * set + 4].to_vec()).collect::<Vec<_>>()
            };
            for (name, values, stored) in
                [("JOINTS", &joints, &joint_kind), ("WEIGHTS", &weights, &Stored::floats("VEC4"))]
            {
                let accessor = self.draft.push_values(&of_set(values), 4, stored, false);
                accessors.insert(format!("{name}_{set}"), accessor);
            }
        }
        accessors
    }
}
