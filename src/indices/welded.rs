//! Conversion of the caller's buffers to a mesh, and of results to corners of the buffers.
//!
//! Vertices at one position become one vertex; labels distinguish the sides of a seam. Weighted attributes become
//! poses, which raise the surface along its normals by an attribute times its weight, so that the price of a merge
//! includes the change of the attribute.

use crate::mesh::{Attributes, Channel, Role, TriMesh, compact, join_positions, vertex_normals};
use crate::simplify::{Input, Map, Simplified};
use rustc_hash::FxHashSet;

use super::IndexError;
use super::buffers::Buffers;
use super::slots::{ResultCorner, assign_slots};

/// Name of the channel whose label distinguishes the caller's vertices at one position.
const SIDE: &str = "side";
const NUMBERS: &str = "attributes";

/// Mesh of the caller's triangles in which vertices at one position are joined.
pub struct WeldedMesh {
    pub mesh: TriMesh,
    // Attributes of the corners, and labels that distinguish the sides of seams.
    pub attributes: Attributes,
    // True for locked vertices, n_vertices; empty without locks.
    pub locked: Vec<bool>,
    // Vertices of the caller at the corners of each face, n_faces x 3.
    pub wedges: Vec<[u32; 3]>,
    // Group and number of each of the caller's vertices at each vertex, sorted.
    slots: Vec<Vec<(u32, u32)>>,
}

impl WeldedMesh {
    /// Joins vertices at one position and drops triangles that lose a corner; attribute weights are multiplied by
    /// `extent`.
    ///
    /// # Errors
    /// [`IndexError`] if no mesh can be made.
    pub fn new(buffers: &Buffers, extent: f64) -> Result<Self, IndexError> {
        let (first, _) = join_positions(&buffers.positions);
        let joined = |face: &[u32; 3]| face.map(|v| first[v as usize]);
        let is_face = |&face: &usize| {
            let [a, b, c] = joined(&buffers.indices[face]);
            a != b && b != c && c != a
        };
        let faces: Vec<usize> = (0..buffers.indices.len()).filter(is_face).collect();
        let wedges: Vec<[u32; 3]> = faces.iter().map(|&face| buffers.indices[face]).collect();
        let (mesh, sources) = compact(&buffers.positions, wedges.iter().map(joined).collect())
            .map_err(|error| IndexError::Buffers(error.to_string()))?;
        let groups = faces.iter().filter_map(|&face| buffers.groups.get(face).copied()).collect();
        let mut welded = Self {
            mesh,
            attributes: Attributes { groups, ..Attributes::default() },
            locked: Vec::new(),
            wedges,
            slots: Vec::new(),
        };
        welded.slots = welded.find_slots();
        // A lock on one of the caller's vertices locks all at its position.
        let mut is_locked = vec![false; buffers.positions.len()];
        let locked = (0..first.len() as u32).filter(|&v| buffers.is_locked(v));
        locked.for_each(|v| is_locked[first[v as usize] as usize] = true);
        let locked: Vec<bool> = sources.iter().map(|&v| is_locked[v as usize]).collect();
        welded.locked = if locked.contains(&true) { locked } else { Vec::new() };
        welded.attributes.channels = welded.make_channels(buffers, extent);
        if !welded.attributes.channels.is_empty() {
            welded.attributes.wedges.clone_from(&welded.wedges);
        }
        Ok(welded)
    }

    pub fn to_input(&self) -> Input<'_> {
        let mut input = Input::bare(&self.mesh);
        (input.attributes, input.locked) = (&self.attributes, &self.locked);
        input
    }

    fn find_slots(&self) -> Vec<Vec<(u32, u32)>> {
        let mut slots = vec![Vec::new(); self.mesh.positions().len()];
        let corners = self.mesh.faces().as_flattened().iter().zip(self.group_slots());
        corners.for_each(|(&v, slot)| slots[v as usize].push(slot));
        for slots in &mut slots {
            slots.sort_unstable();
            slots.dedup();
        }
        slots
    }

    fn make_channels(&self, buffers: &Buffers, extent: f64) -> Vec<Channel> {
        let (n, width) = (buffers.positions.len(), buffers.weights.len());
        let mut channels = Vec::new();
        if width > 0 {
            let values = buffers.attributes.clone();
            channels.push(Channel { name: NUMBERS.into(), role: Role::Other, width, values });
        }
        let mut normals = vec![[0.0; 3]; n];
        for (slots, normal) in self.slots.iter().zip(vertex_normals(&self.mesh)) {
            slots.iter().for_each(|(_, slot)| normals[*slot as usize] = normal);
        }
        for (k, weight) in buffers.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let raise = |v: usize| normals[v].map(|x| x * weight * extent as f32 * buffers.attributes[v * width + k]);
            let values = (0..n).flat_map(raise).collect();
            channels.push(Channel { name: format!("raised {k}"), role: Role::MorphPosition, width: 3, values });
        }
        let mut sides = vec![0.0; n];
        for slots in self.slots.iter().flat_map(|slots| slots.chunk_by(|x, y| x.0 == y.0)) {
            slots.iter().enumerate().for_each(|(side, (_, slot))| sides[*slot as usize] = side as f32);
        }
        if sides.iter().any(|side| *side > 0.0) {
            channels.push(Channel { name: SIDE.into(), role: Role::Label, width: 1, values: sides });
        }
        channels
    }

    /// Returns the caller's vertex at each corner of a result whose vertices have not moved.
    ///
    /// The vertex is of the face's group on the corner's side of a seam, or of another group if the group has none
    /// there.
    pub fn corner_vertices(&self, result: &Simplified) -> Vec<[u32; 3]> {
        let sources = result.source_vertices.as_deref().unwrap_or_default();
        let sides = result.attributes.channels.iter().find(|channel| channel.name == SIDE);
        let corner = |face: usize, k: usize| {
            let slots = &self.slots[sources[result.mesh.faces()[face][k] as usize] as usize];
            let group = result.attributes.group(face as u32);
            let side = sides.map_or(0, |sides| sides.value(result.attributes.wedges[face][k])[0] as usize);
            let own = slots.iter().filter(|slot| slot.0 == group);
            own.clone().nth(side).or(own.clone().next()).or(slots.first()).map_or(0, |slot| slot.1)
        };
        (0..result.mesh.faces().len()).map(|face| [0, 1, 2].map(|k| corner(face, k))).collect()
    }

    /// Writes the vertices of a result into slots of the buffers and returns the slot of each corner.
    pub fn place_vertices(&self, result: &Simplified, buffers: &mut Buffers) -> Vec<[u32; 3]> {
        let slots = assign_slots(&self.result_corners(result), self.group_slots(), buffers.positions.len());
        let values = result.attributes.channels.iter().find(|channel| channel.name == NUMBERS);
        let width = buffers.weights.len();
        let mut is_written = vec![false; buffers.positions.len()];
        let corners = result.mesh.faces().as_flattened().iter().zip(&slots);
        for ((&v, &slot), corner) in corners.zip(0..) {
            if std::mem::replace(&mut is_written[slot as usize], true) {
                continue;
            }
            buffers.positions[slot as usize] = result.mesh.positions()[v as usize];
            if let Some(values) = values {
                let wedge = result.attributes.wedges.as_flattened()[corner];
                buffers.attributes[slot as usize * width..][..width].copy_from_slice(values.value(wedge));
            }
        }
        slots.as_chunks().0.to_vec()
    }

    fn result_corners(&self, result: &Simplified) -> Vec<ResultCorner> {
        let own: FxHashSet<(u32, u32)> = self.group_slots().collect();
        let (faces, wedges) = (result.mesh.faces(), &result.attributes.wedges);
        let wedges = if wedges.is_empty() { faces } else { wedges };
        let nearest = self.nearest_vertices(result.map.as_ref());
        let corner = |at: usize| {
            let (face, k) = (at / 3, at % 3);
            let group = result.attributes.group(face as u32);
            let nearest = nearest.get(face).map(|vertices| vertices[k]).filter(|&v| own.contains(&(group, v)));
            ResultCorner { vertex: faces[face][k], wedge: wedges[face][k], group, nearest }
        };
        (0..3 * faces.len()).map(corner).collect()
    }

    fn group_slots(&self) -> impl Iterator<Item = (u32, u32)> {
        (0u32..).zip(&self.wedges).flat_map(|(face, wedges)| wedges.map(|slot| (self.attributes.group(face), slot)))
    }

    /// Returns the caller's vertices nearest to the corners of a result, on their sides of seams.
    fn nearest_vertices(&self, map: Option<&Map>) -> Vec<[u32; 3]> {
        let Some(map) = map else { return Vec::new() };
        let nearest = |(face, weights): (&u32, &[f32; 3])| {
            let heaviest = (0..3).max_by(|&x, &y| weights[x].total_cmp(&weights[y])).unwrap_or(0);
            self.wedges[*face as usize][heaviest]
        };
        let of_face =
            |(faces, weights): (&[u32; 3], &[[f32; 3]; 3])| [0, 1, 2].map(|k| nearest((&faces[k], &weights[k])));
        map.corner_faces.iter().zip(&map.corner_weights).map(of_face).collect()
    }
}
