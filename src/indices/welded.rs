//! Buffers as a mesh, and results as corners of the buffers.
//!
//! Vertices at one position are one vertex; where several share it, the surface has a seam there, and a label tells its sides apart. Numbers that count
//! are poses: in each the surface is raised by one of them, times its weight, so that a merge costs what it changes of it.

use crate::mesh::{Attributes, Channel, Role, TriMesh, compact, first_equal, vertex_normals};
use crate::simplify::{Input, Map, Simplified};
use rustc_hash::FxHashSet;

use super::IndexError;
use super::buffers::Buffers;
use super::places::{Corner, assign_places};

/// The channel whose label tells the caller's vertices at a position apart.
const SIDE: &str = "side";
/// The channel of the caller's numbers.
const NUMBERS: &str = "attributes";

/// A mesh whose vertices at one position are joined.
pub struct WeldedMesh {
    /// The surface.
    pub mesh: TriMesh,
    /// Attributes of the corners, and the labels of seams.
    pub attributes: Attributes,
    locked: Vec<bool>,
    /// The caller's vertices of each face's corners.
    wedges: Vec<[u32; 3]>,
    /// The groups and the caller's vertices at each vertex, in their order.
    at_vertices: Vec<Vec<(u32, u32)>>,
}

impl WeldedMesh {
    /// Joins vertices at one position. Triangles that lose a corner by that are none.
    ///
    /// # Errors
    /// [`IndexError`] where no mesh can be made of them.
    pub fn new(buffers: &Buffers) -> Result<Self, IndexError> {
        let bits = |v: usize| buffers.positions[v].map(|x| (x + 0.0).to_bits());
        let (first, _) = first_equal(buffers.positions.len(), bits);
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
        let mut given = Self {
            mesh,
            attributes: Attributes { groups, ..Attributes::default() },
            locked: Vec::new(),
            wedges,
            at_vertices: Vec::new(),
        };
        given.at_vertices = given.find_places();
        let is_held = |vertex: u32| buffers.locks.get(vertex as usize).is_some_and(|lock| lock & 1 == 1);
        let mut held = vec![false; buffers.positions.len()];
        (0..first.len() as u32).filter(|&v| is_held(v)).for_each(|v| held[first[v as usize] as usize] = true);
        let locked: Vec<bool> = sources.iter().map(|&v| held[v as usize]).collect();
        given.locked = if locked.contains(&true) { locked } else { Vec::new() };
        given.attributes.channels = given.make_channels(buffers);
        if !given.attributes.channels.is_empty() {
            given.attributes.wedges.clone_from(&given.wedges);
        }
        Ok(given)
    }

    /// Returns the input of the simplifier.
    pub fn to_input(&self) -> Input<'_> {
        let mut input = Input::bare(&self.mesh);
        (input.attributes, input.locked) = (&self.attributes, &self.locked);
        input
    }

    fn find_places(&self) -> Vec<Vec<(u32, u32)>> {
        let mut places = vec![Vec::new(); self.mesh.positions().len()];
        let corners = self.mesh.faces().as_flattened().iter().zip(self.places_of_groups());
        corners.for_each(|(&v, place)| places[v as usize].push(place));
        for places in &mut places {
            places.sort_unstable();
            places.dedup();
        }
        places
    }

    /// Makes the channels: the numbers of the vertices, the poses that these are, and which of those at a position each is.
    fn make_channels(&self, buffers: &Buffers) -> Vec<Channel> {
        let (n, width) = (buffers.positions.len(), buffers.weights.len());
        let mut channels = Vec::new();
        if width > 0 {
            let values = buffers.attributes.clone();
            channels.push(Channel { name: NUMBERS.into(), role: Role::Other, width, values });
        }
        let mut normals = vec![[0.0; 3]; n];
        for (places, normal) in self.at_vertices.iter().zip(vertex_normals(&self.mesh)) {
            places.iter().for_each(|(_, place)| normals[*place as usize] = normal);
        }
        let extent = buffers.extent() as f32;
        for (k, weight) in buffers.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let raised = |v: usize| normals[v].map(|x| x * weight * extent * buffers.attributes[v * width + k]);
            let values = (0..n).flat_map(raised).collect();
            channels.push(Channel { name: format!("raised {k}"), role: Role::MorphPosition, width: 3, values });
        }
        let mut sides = vec![0.0; n];
        for places in self.at_vertices.iter().flat_map(|places| places.chunk_by(|x, y| x.0 == y.0)) {
            places.iter().enumerate().for_each(|(side, (_, place))| sides[*place as usize] = side as f32);
        }
        if sides.iter().any(|side| *side > 0.0) {
            channels.push(Channel { name: SIDE.into(), role: Role::Label, width: 1, values: sides });
        }
        channels
    }

    /// The caller's vertex at each corner of a result whose vertices have not moved: one of its group, on the corner's side of a seam. Where
    /// a group has come to a vertex at which it had none, that of another.
    pub fn corner_vertices(&self, made: &Simplified) -> Vec<[u32; 3]> {
        let sources = made.source_vertices.as_deref().unwrap_or_default();
        let sides = made.attributes.channels.iter().find(|channel| channel.name == SIDE);
        let corner = |face: usize, k: usize| {
            let places = &self.at_vertices[sources[made.mesh.faces()[face][k] as usize] as usize];
            let group = made.attributes.group(face as u32);
            let side = sides.map_or(0, |sides| sides.value(made.attributes.wedges[face][k])[0] as usize);
            let own = places.iter().filter(|place| place.0 == group);
            own.clone().nth(side).or(own.clone().next()).or(places.first()).map_or(0, |place| place.1)
        };
        (0..made.mesh.faces().len()).map(|face| [0, 1, 2].map(|k| corner(face, k))).collect()
    }

    /// Puts the vertices of a result in places of the buffers. Returns the place of each corner.
    pub fn place_vertices(&self, made: &Simplified, buffers: &mut Buffers) -> Vec<[u32; 3]> {
        let places = assign_places(&self.corners(made), self.places_of_groups(), buffers.positions.len());
        let (values, width) = (made.attributes.channels.iter().find(|it| it.name == NUMBERS), buffers.weights.len());
        let mut is_written = vec![false; buffers.positions.len()];
        let corners = made.mesh.faces().as_flattened().iter().zip(&places);
        for ((&v, &place), number) in corners.zip(0..) {
            if std::mem::replace(&mut is_written[place as usize], true) {
                continue;
            }
            buffers.positions[place as usize] = made.mesh.positions()[v as usize];
            if let Some(values) = values {
                let wedge = made.attributes.wedges.as_flattened()[number];
                buffers.attributes[place as usize * width..][..width].copy_from_slice(values.value(wedge));
            }
        }
        places.as_chunks().0.to_vec()
    }

    /// The corners of a result, with the caller's vertices nearest to them on their sides of seams.
    fn corners(&self, made: &Simplified) -> Vec<Corner> {
        let own: FxHashSet<(u32, u32)> = self.places_of_groups().collect();
        let wedges = if made.attributes.wedges.is_empty() { made.mesh.faces() } else { &made.attributes.wedges };
        let near = self.nearest_corners(made.map.as_ref());
        let corner = |at: usize| {
            let (face, k) = (at / 3, at % 3);
            let group = made.attributes.group(face as u32);
            let near = near.get(face).map(|near| near[k]).filter(|&near| own.contains(&(group, near)));
            Corner { vertex: made.mesh.faces()[face][k], wedge: wedges[face][k], group, near }
        };
        (0..3 * made.mesh.faces().len()).map(corner).collect()
    }

    /// The group and the caller's vertex of each corner.
    fn places_of_groups(&self) -> impl Iterator<Item = (u32, u32)> {
        (0u32..).zip(&self.wedges).flat_map(|(face, wedges)| wedges.map(|place| (self.attributes.group(face), place)))
    }

    /// The caller's vertices nearest to the corners of a result, on their sides of seams.
    fn nearest_corners(&self, map: Option<&Map>) -> Vec<[u32; 3]> {
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
