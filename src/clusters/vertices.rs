//! Vertices of all levels, and the patches of faces that are simplified.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::mesh::{Attributes, Channel, DistinctKeys, PositionKey, TriMesh, join_positions, position_key};
use crate::simplify::{Input, SimplifyError};

/// A face over the pool's vertices.
#[derive(Clone, Copy, Debug)]
pub struct PoolFace {
    pub corners: [u32; 3],
    /// Material, primitive or group.
    pub group: u32,
    /// Bound of the distance to the part of the input surface that the face replaces, both ways.
    pub error: f32,
}

/// Vertices with their attributes.
///
/// Vertices at one position share a *place*, so that seams of attributes are no boundaries.
#[derive(Default)]
pub struct VertexPool {
    pub positions: Vec<[f32; 3]>,
    pub channels: Vec<Channel>,
    /// Place of each vertex, n_vertices.
    pub places: Vec<u32>,
    pub n_places: u32,
}

/// Faces of a group of clusters as a mesh of their own.
pub struct Patch {
    pub mesh: TriMesh,
    pub attributes: Attributes,
    /// Marks vertices that other groups use.
    pub locked: Vec<bool>,
    /// Place of each vertex of the mesh.
    places: Vec<u32>,
    /// Vertex in the pool of each wedge.
    wedges: Vec<u32>,
}

/// Simplified patch.
pub struct ReducedPatch {
    pub mesh: TriMesh,
    pub attributes: Attributes,
}

impl VertexPool {
    /// Collects the vertices and faces of an input; faces with two corners at one position are dropped.
    pub fn new(input: &Input) -> (Self, Vec<PoolFace>) {
        let mesh = input.mesh;
        let (first, _) = join_positions(mesh.positions());
        let mut vertices: DistinctKeys<[u32; 2]> = DistinctKeys::default();
        let mut faces = Vec::with_capacity(mesh.faces().len());
        for (face, corners) in mesh.faces().iter().enumerate() {
            let places = corners.map(|v| first[v as usize]);
            if places[0] == places[1] || places[1] == places[2] || places[2] == places[0] {
                continue;
            }
            let wedges = input.attributes.wedges.get(face).copied().unwrap_or([0; 3]);
            let corners = [0, 1, 2].map(|k| vertices.number([places[k], wedges[k]]));
            faces.push(PoolFace { corners, group: input.attributes.group(face as u32), error: 0.0 });
        }
        let (places, rows): (Vec<u32>, Vec<u32>) = vertices.keys.iter().map(|&[place, wedge]| (place, wedge)).unzip();
        let positions = places.iter().map(|&place| mesh.positions()[place as usize]).collect();
        let channels = input.attributes.channels.iter().map(|channel| select_rows(channel, &rows)).collect();
        (Self { positions, channels, places, n_places: first.len() as u32 }, faces)
    }

    /// Adds a vertex without attributes at a place of its own.
    #[cfg(all(feature = "io", feature = "job"))]
    pub fn add_bare(&mut self, position: [f32; 3]) -> u32 {
        self.positions.push(position);
        self.places.push(self.n_places);
        self.n_places += 1;
        (self.positions.len() - 1) as u32
    }

    pub fn place(&self, vertex: u32) -> u32 {
        self.places[vertex as usize]
    }

    /// Returns the centroid of a face.
    pub fn centroid(&self, face: &PoolFace) -> [f32; 3] {
        let [a, b, c] = face.corners.map(|v| self.positions[v as usize]);
        std::array::from_fn(|k| (a[k] / 3.0) + (b[k] / 3.0) + (c[k] / 3.0))
    }

    /// Builds the mesh of some faces; `is_shared` accepts places that other groups use.
    ///
    /// # Errors
    /// [`SimplifyError::Empty`] without faces.
    pub fn patch(&self, faces: &[PoolFace], is_shared: impl Fn(u32) -> bool) -> Result<Patch, SimplifyError> {
        let (mut places, mut wedges): (DistinctKeys<u32>, DistinctKeys<u32>) = Default::default();
        let mut positions = Vec::new();
        let mut corners = |face: &PoolFace| {
            let own = face.corners.map(|vertex| {
                let number = places.number(self.place(vertex));
                positions.extend((number as usize == positions.len()).then(|| self.positions[vertex as usize]));
                number
            });
            (own, face.corners.map(|vertex| wedges.number(vertex)))
        };
        let (own, own_wedges): (Vec<_>, Vec<_>) = faces.iter().map(&mut corners).unzip();
        let (places, wedges) = (places.keys, wedges.keys);
        let channels: Vec<Channel> = self.channels.iter().map(|channel| select_rows(channel, &wedges)).collect();
        let groups = faces.iter().map(|face| face.group);
        let attributes = Attributes {
            wedges: if channels.is_empty() { Vec::new() } else { own_wedges },
            channels,
            groups: if groups.clone().any(|group| group != 0) { groups.collect() } else { Vec::new() },
        };
        let locked = places.iter().map(|&place| is_shared(place)).collect();
        let mesh = TriMesh::new(positions, own).map_err(|_| SimplifyError::Empty)?;
        Ok(Patch { mesh, attributes, locked, places, wedges })
    }

    /// Adds the vertices of a simplified patch and returns its faces; corners at locked places keep their vertices.
    ///
    /// A face with two corners at one place is `None`.
    pub fn append(&mut self, patch: &Patch, reduced: &ReducedPatch, errors: &[f32]) -> Vec<Option<PoolFace>> {
        let held = patch.held_vertices(self);
        let mut numbers: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        let mut own_places: FxHashMap<u32, u32> = FxHashMap::default();
        let mut faces = Vec::with_capacity(reduced.mesh.faces().len());
        for (face, corners) in reduced.mesh.faces().iter().enumerate() {
            let wedges = reduced.attributes.wedges.get(face).copied().unwrap_or([0; 3]);
            let corners = [0, 1, 2].map(|k| {
                let key = (corners[k], wedges[k]);
                if let Some(&known) = numbers.get(&key) {
                    return known;
                }
                let position = reduced.mesh.positions()[corners[k] as usize];
                let number = match held.get(&position_key(position)) {
                    Some(vertices) => self.nearest_values(vertices, &reduced.attributes, wedges[k]),
                    None => {
                        let place = *own_places.entry(corners[k]).or_insert_with(|| {
                            self.n_places += 1;
                            self.n_places - 1
                        });
                        self.push(position, place, &reduced.attributes, wedges[k])
                    }
                };
                numbers.insert(key, number);
                number
            });
            let [a, b, c] = corners.map(|vertex| self.place(vertex));
            let made = PoolFace { corners, group: reduced.attributes.group(face as u32), error: errors[face] };
            faces.push((a != b && b != c && c != a).then_some(made));
        }
        faces
    }

    fn push(&mut self, position: [f32; 3], place: u32, attributes: &Attributes, wedge: u32) -> u32 {
        self.positions.push(position);
        self.places.push(place);
        for (channel, own) in self.channels.iter_mut().zip(&attributes.channels) {
            channel.values.extend_from_slice(own.value(wedge));
        }
        (self.positions.len() - 1) as u32
    }

    /// Returns the vertex whose attributes are nearest to those of a wedge.
    fn nearest_values(&self, vertices: &[u32], attributes: &Attributes, wedge: u32) -> u32 {
        let difference = |&vertex: &u32| {
            let channels = self.channels.iter().zip(&attributes.channels);
            let of_channel = |(a, b): (&Channel, &Channel)| {
                a.value(vertex).iter().zip(b.value(wedge)).map(|(x, y)| f64::from(x - y).powi(2)).sum::<f64>()
            };
            channels.map(of_channel).sum::<f64>()
        };
        // No patch has a locked position without vertices.
        vertices.iter().copied().min_by(|x, y| difference(x).total_cmp(&difference(y))).unwrap_or(0)
    }
}

impl Patch {
    /// Returns the positions of vertices that other groups use.
    pub fn locked_positions(&self) -> FxHashSet<PositionKey> {
        let locked = self.mesh.positions().iter().zip(&self.locked).filter(|(_, locked)| **locked);
        locked.map(|(&position, _)| position_key(position)).collect()
    }

    /// Returns the pool's vertices at each locked position.
    fn held_vertices(&self, pool: &VertexPool) -> FxHashMap<PositionKey, Vec<u32>> {
        let locked = self.places.iter().zip(&self.locked).filter(|(_, locked)| **locked);
        let locked: FxHashSet<u32> = locked.map(|(&place, _)| place).collect();
        let mut held: FxHashMap<PositionKey, Vec<u32>> = FxHashMap::default();
        for &vertex in self.wedges.iter().filter(|&&vertex| locked.contains(&pool.place(vertex))) {
            held.entry(position_key(pool.positions[vertex as usize])).or_default().push(vertex);
        }
        held
    }
}

fn select_rows(channel: &Channel, rows: &[u32]) -> Channel {
    let values = rows.iter().flat_map(|&row| channel.value(row)).copied().collect();
    Channel { name: channel.name.clone(), role: channel.role, width: channel.width, values }
}
