//! Writing of a primitive.

use rustc_hash::FxHashMap;
use serde_json::{Map, Value};

use super::accessor::{UNSIGNED_BYTE, UNSIGNED_SHORT, shape_width};
use super::draft::{Draft, NumberStorage};
use super::packed::{PrimitivePacking, order_faces, push_directions};
use super::repair_values;
use super::semantics::{SKIN, is_own_channel, target_channel};
use super::simplified_part::SimplifiedPart;
use crate::io::extra::replace_non_finite;
use crate::mesh::{Channel, DistinctKeys, Role};

// Vertices that the file needs for the faces of a primitive: one per pair of vertex and wedge.
pub(super) struct PrimitiveVertices {
    pairs: Vec<[u32; 2]>,
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
}

impl PrimitiveVertices {
    pub fn collect(part: &SimplifiedPart, faces: &[u32]) -> Self {
        let mut pairs = DistinctKeys::default();
        let mut place_face = |&face: &u32| {
            let (vertices, wedges) = (part.faces[face as usize], part.wedges(face as usize));
            [0, 1, 2].map(|corner| pairs.number([vertices[corner], wedges[corner]]))
        };
        let faces = faces.iter().map(&mut place_face).collect();
        let pairs = pairs.keys;
        let positions = pairs.iter().map(|pair| part.positions[pair[0] as usize]).collect();
        Self { pairs, positions, faces }
    }

    /// Returns the vertices, without repeated values and in the order of fast drawing if they are to be compressed.
    pub fn for_packing(part: &SimplifiedPart, faces: &[u32], packed: Option<PrimitivePacking>) -> Self {
        let all = Self::collect(part, faces);
        if packed.is_some_and(|packed| packed.compress) { all.merge(part).reorder() } else { all }
    }

    pub fn merge(mut self, part: &SimplifiedPart) -> Self {
        let mut known: FxHashMap<Vec<u32>, u32> = FxHashMap::default();
        let mut place = |vertex: &u32| {
            let ([_, wedge], position) = (self.pairs[*vertex as usize], self.positions[*vertex as usize]);
            let values = part.attributes.channels.iter().flat_map(|channel| channel.value(wedge));
            let key = position.iter().chain(values).map(|x| (x + 0.0).to_bits()).collect();
            *known.entry(key).or_insert(*vertex)
        };
        let vertices: Vec<u32> = (0..self.len() as u32).map(|vertex| place(&vertex)).collect();
        self.faces.as_flattened_mut().iter_mut().for_each(|vertex| *vertex = vertices[*vertex as usize]);
        self
    }

    /// Reorders faces and vertices for fast drawing.
    pub fn reorder(mut self) -> Self {
        // Faces are ordered first: vertices then follow in the order of their first use.
        self.faces = order_faces(&self.faces, self.len());
        let (mut places, mut order) = (vec![u32::MAX; self.len()], Vec::new());
        for vertex in self.faces.as_flattened_mut() {
            let place = &mut places[*vertex as usize];
            if *place == u32::MAX {
                *place = order.len() as u32;
                order.push(*vertex as usize);
            }
            *vertex = *place;
        }
        let pairs = order.iter().map(|&vertex| self.pairs[vertex]).collect();
        let positions = order.iter().map(|&vertex| self.positions[vertex]).collect();
        Self { pairs, positions, ..self }
    }

    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    fn values(&self, channel: &Channel) -> Vec<f32> {
        let mut values: Vec<f32> = self.pairs.iter().flat_map(|pair| channel.value(pair[1])).copied().collect();
        replace_non_finite(&mut values);
        values
    }
}

// Names and storage of attributes, or of what a morph target adds to them.
pub(super) type AttributeStorage = Vec<(String, NumberStorage)>;

pub(super) struct PrimitiveWriter<'a, 'b> {
    pub draft: &'a mut Draft<'b>,
    pub part: &'a SimplifiedPart,
    pub vertices: &'a PrimitiveVertices,
    pub packed: Option<PrimitivePacking<'a>>,
}

impl PrimitiveWriter<'_, '_> {
    pub fn attributes(&mut self, slots: &AttributeStorage) -> Value {
        let n_sets = slots.iter().filter(|(name, _)| name.starts_with("JOINTS_")).count();
        // Joints and weights are one channel, written for all sets at once.
        let mut skin = self.push_skin(n_sets);
        let mut accessors = Map::new();
        for (name, stored) in slots {
            let accessor = match name.as_str() {
                "POSITION" => Some(self.push_positions()),
                _ if is_own_channel(name) => self.push_channel(name, stored),
                _ => skin.remove(name),
            };
            accessors.extend(accessor.map(|accessor| (name.clone(), accessor)));
        }
        Value::Object(accessors)
    }

    pub fn targets(&mut self, targets: &[AttributeStorage]) -> Value {
        let part = self.part;
        let mut next = 0;
        let mut write = |(target, slots): (usize, &AttributeStorage)| {
            let accessor = |(name, stored): &(String, NumberStorage)| {
                let found = part.attributes.find_channel(&target_channel(target, name), next)?;
                next = found + 1;
                let channel = &part.attributes.channels[found];
                let values = self.vertices.values(channel);
                let (values, stored) = self.pack_target(channel.role, values, stored);
                Some((name.clone(), self.push(values, channel.width, &stored, name == "POSITION")))
            };
            Value::Object(slots.iter().filter_map(accessor).collect())
        };
        Value::Array(targets.iter().enumerate().map(&mut write).collect())
    }

    fn pack_target(&self, role: Role, values: Vec<f32>, stored: &NumberStorage) -> (Vec<f32>, NumberStorage) {
        match (&self.packed, role) {
            (Some(packed), Role::MorphPosition) => {
                packed.pack_displacements(&values, stored).unwrap_or_else(|| (values, stored.clone()))
            }
            (Some(packed), Role::MorphDirection) => {
                let stored = packed.direction_storage(&values, stored);
                (values, stored)
            }
            _ => (values, stored.clone()),
        }
    }

    pub fn indices(&mut self) -> Value {
        self.draft.push_indices(&self.vertices.faces, self.vertices.positions.len())
    }

    fn push_positions(&mut self) -> Value {
        let packed = self.packed.and_then(|packed| packed.pack_positions(&self.vertices.positions));
        let plain = || (self.vertices.positions.as_flattened().to_vec(), NumberStorage::floats("VEC3"));
        let (values, stored) = packed.unwrap_or_else(plain);
        self.draft.push_values(&values, 3, &stored, true)
    }

    fn push_channel(&mut self, name: &str, stored: &NumberStorage) -> Option<Value> {
        let channel = self.part.channel(name)?;
        let mut values = self.vertices.values(channel);
        match channel.role {
            Role::Normal if channel.width == 3 => self.mend_normals(&mut values),
            Role::Tangent if channel.width == 4 => repair_values::mend_tangents(&mut values, self.normals().as_deref()),
            Role::Colour => repair_values::mend_colours(&mut values),
            _ => {}
        }
        let kind = (channel.role, channel.width);
        // Compressed normals and tangents are encoded on an octahedron.
        if self.packed.is_some_and(|packed| packed.is_filtered(kind)) {
            return Some(push_directions(self.draft, &values, channel.width));
        }
        let stored =
            self.packed.map_or(stored.clone(), |packed| packed.pack_attribute(name, kind, &mut values, stored));
        Some(self.push(values, channel.width, &stored, false))
    }

    fn push(&mut self, values: Vec<f32>, width: usize, stored: &NumberStorage, bounded: bool) -> Value {
        // The channel may be wider for other primitives of the mesh.
        let own = shape_width(&stored.shape).min(width);
        let values = match own == width {
            true => values,
            false => values.chunks_exact(width).flat_map(|row| row[..own].to_vec()).collect(),
        };
        self.draft.push_values(&values, own, stored, bounded)
    }

    fn mend_normals(&self, normals: &mut [f32]) {
        repair_values::mend_normals(normals, &self.vertices.positions, &self.vertices.faces);
    }

    fn normals(&self) -> Option<Vec<f32>> {
        let mut normals = self.vertices.values(self.part.channel("NORMAL").filter(|channel| channel.width == 3)?);
        self.mend_normals(&mut normals);
        Some(normals)
    }

    fn push_skin(&mut self, n_sets: usize) -> FxHashMap<String, Value> {
        let mut accessors = FxHashMap::default();
        let Some(channel) = self.part.channel(SKIN).filter(|_| n_sets > 0) else { return accessors };
        let (mut joints, mut weights) =
            repair_values::normalize_skin(&self.vertices.values(channel), channel.width, n_sets);
        let shares = self.packed.map(|packed| packed.pack_skin(&mut joints, &mut weights, 4 * n_sets));
        let weight_kind = shares.unwrap_or_else(|| NumberStorage::floats("VEC4"));
        // Joints need one byte unless there are more than 256.
        let small = joints.iter().all(|&joint| joint <= f32::from(u8::MAX));
        let component = if small { UNSIGNED_BYTE } else { UNSIGNED_SHORT };
        let joint_kind = NumberStorage { component, ..NumberStorage::floats("VEC4") };
        for set in 0..n_sets {
            let of_set = |values: &[f32]| {
                values.chunks_exact(4 * n_sets).flat_map(|row| row[4 * set..4 * set + 4].to_vec()).collect::<Vec<_>>()
            };
            for (name, values, stored) in [("JOINTS", &joints, &joint_kind), ("WEIGHTS", &weights, &weight_kind)] {
                let accessor = self.draft.push_values(&of_set(values), 4, stored, false);
                accessors.insert(format!("{name}_{set}"), accessor);
            }
        }
        accessors
    }
}
