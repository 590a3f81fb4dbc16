//! One mesh made of several, to be simplified together.

use glam::{DMat4, DVec3};
use rustc_hash::FxHashMap;

use super::touching::join_touching;
use super::value_bytes::{ByteReader, Stored, store_fields};
use super::{Attributes, Channel, Role, TriMesh, compact};
use crate::geometry::extent;

/// Largest number of faces in a scene view; beyond, each piece shows only its largest instance.
const MOST_VIEWED: usize = 1 << 24;

/// A mesh to be united with others.
#[derive(Clone, Copy, Debug)]
pub struct ScenePiece<'a> {
    /// The mesh.
    pub mesh: &'a TriMesh,
    /// Attributes of the mesh.
    pub attributes: &'a Attributes,
    /// Factor of the positions in the united mesh, rounded to a power of two.
    pub scale: f64,
    /// Transforms of the mesh's instances to the scene.
    pub places: &'a [DMat4],
}

/// Scaled meshes in one, without shared vertices unless [`join_touching_pieces`](Self::join_touching_pieces) joins them.
#[derive(Clone, Debug, PartialEq)]
pub struct UnitedMesh {
    /// All faces and vertices.
    pub mesh: TriMesh,
    /// Attributes with the channels of all meshes and separate groups per mesh.
    pub attributes: Attributes,
    layout: UnitedPieces,
}

/// Pieces of a united mesh, without their vertices and faces.
#[derive(Clone, Debug, PartialEq)]
struct UnitedPieces {
    first_groups: Vec<u32>,
    channels: Vec<Vec<String>>,
    scales: Vec<f32>,
    has_groups: Vec<bool>,
    places: Vec<Vec<DMat4>>,
    diagonal: f64,
}

store_fields! {
    UnitedPieces { first_groups: Vec<u32>, channels: Vec<Vec<String>>, scales: Vec<f32>, has_groups: Vec<bool>,
        places: Vec<Vec<DMat4>>, diagonal: f64 };
}

/// Stores the layout alone, by which results are placed.
impl Stored for UnitedMesh {
    const LEAST: usize = UnitedPieces::LEAST;

    fn write(&self, bytes: &mut Vec<u8>) {
        self.layout.write(bytes);
    }

    fn read(from: &mut ByteReader) -> Option<Self> {
        let layout = UnitedPieces::read(from)?;
        let UnitedPieces { first_groups, channels, scales, has_groups, places, diagonal } = &layout;
        let n = scales.len();
        let fit = first_groups.len() == n + 1 && channels.len() == n && has_groups.len() == n && places.len() == n;
        let are_sorted = first_groups.first() == Some(&0) && first_groups.is_sorted();
        let are_finite = scales.iter().all(|scale| scale.is_normal()) && diagonal.is_finite();
        (n > 0 && fit && are_sorted && are_finite).then(|| Self::from_layout(layout))
    }
}

/// The meshes of a scene at all their instances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneView {
    /// All instances, with the scene's middle as the origin.
    pub mesh: TriMesh,
    /// Index in the united mesh of each face, n_faces.
    pub faces: Vec<u32>,
}

impl UnitedMesh {
    /// Unites meshes; `None` if there are too many vertices or a scale is out of range.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::mesh::{Attributes, ScenePiece, UnitedMesh, shapes};
    /// let (mesh, attributes) = (shapes::icosphere(1), Attributes::default());
    /// let piece = ScenePiece { mesh: &mesh, attributes: &attributes, scale: 2.0, places: &[] };
    /// let united = UnitedMesh::new(&[piece, piece]).unwrap();
    /// assert_eq!(united.mesh.faces().len(), 160);
    /// let pieces = united.split(&united.mesh, &united.attributes);
    /// assert_eq!(pieces[1].0, mesh);
    /// ```
    pub fn new(pieces: &[ScenePiece]) -> Option<Self> {
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        let mut attributes =
            Attributes { channels: all_channels(pieces.iter().map(|piece| piece.attributes)), ..Attributes::default() };
        let (mut first_groups, mut scales) = (vec![0], Vec::new());
        for ScenePiece { mesh, attributes: own, scale, .. } in pieces {
            let scale = Some(scale.log2().round().exp2() as f32).filter(|scale| scale.is_normal())?;
            let first = u32::try_from(positions.len()).ok()?;
            positions.extend(mesh.positions().iter().map(|p| p.map(|x| x * scale)));
            faces.extend(mesh.faces().iter().map(|face| face.map(|v| v + first)));
            let first_group = first_groups.last().copied()?;
            append_attributes(&mut attributes, own, mesh.faces().len() as u32, first_group, scale);
            first_groups
                .push(first_group.checked_add(own.groups.iter().max().map_or(0, |&last| last).checked_add(1)?)?);
            scales.push(scale);
        }
        if positions.len().max(attributes.n_wedges()) > (u32::MAX / 4) as usize {
            return None;
        }
        let layout = UnitedPieces {
            first_groups,
            channels: pieces.iter().map(channel_names).collect(),
            places: places(pieces, &scales),
            scales,
            has_groups: pieces.iter().map(|piece| !piece.attributes.groups.is_empty()).collect(),
            diagonal: 0.0,
        };
        Some(Self { mesh: TriMesh::new(positions, faces).ok()?, attributes, layout }.center_scene())
    }

    fn from_layout(layout: UnitedPieces) -> Self {
        Self { mesh: TriMesh::default(), attributes: Attributes::default(), layout }
    }

    /// Returns the scene without its mesh, to place results.
    #[doc(hidden)]
    pub fn without_mesh(&self) -> Self {
        Self::from_layout(self.layout.clone())
    }

    /// Joins pieces with the same instances where the surface goes on from one to the other; returns how many vertices go.
    ///
    /// Their common vertices then move together, so that no gap opens between the pieces.
    pub fn join_touching_pieces(&mut self) -> usize {
        let (mesh, attributes) = (&self.mesh, &self.attributes);
        // Without instances there is no common system of coordinates.
        let alike = self.pieces_placed_alike().into_iter().enumerate();
        let class: Vec<usize> = alike.map(|(i, first)| if self.places(i).is_empty() { i } else { first }).collect();
        if class.iter().enumerate().all(|(i, first)| i == *first) {
            return 0;
        }
        let n_faces = mesh.faces().len() as u32;
        let pieces: Vec<u32> = (0..n_faces).map(|f| self.piece_of_group(attributes.group(f)) as u32).collect();
        let (vertex, n_joined) = join_touching(mesh.positions(), mesh.faces(), &pieces, &class);
        let faces = mesh.faces().iter().map(|face| face.map(|v| vertex[v as usize])).collect();
        // A piece with several vertices at one position may refuse.
        let Some((joined, _)) = compact(mesh.positions(), faces).ok().filter(|_| n_joined > 0) else { return 0 };
        self.mesh = joined;
        n_joined
    }

    fn center_scene(mut self) -> Self {
        let (mesh, faces) = (&self.mesh, self.faces_of_pieces(&self.mesh, &self.attributes));
        let of_pieces = self.layout.places.iter().zip(&faces);
        let placed = of_pieces.flat_map(|(places, faces)| places.iter().map(move |place| (place, faces)));
        let (low, high) = extent(placed.flat_map(|(place, faces)| {
            let corners = faces.iter().flat_map(|&face| mesh.faces()[face as usize]);
            corners.map(move |v| place.transform_point3(point(mesh, v)))
        }));
        let middle = 0.5 * (low + high);
        if middle.is_finite() {
            self.layout.diagonal = (high - low).length();
            self.layout
                .places
                .iter_mut()
                .flatten()
                .for_each(|place| *place = DMat4::from_translation(-middle) * *place);
        }
        self
    }

    /// Returns the transforms from the united mesh to a piece's instances in the centred scene.
    pub fn places(&self, piece: usize) -> &[DMat4] {
        &self.layout.places[piece]
    }

    /// Returns the largest factor by which a piece's instances stretch an axis.
    pub fn stretch(&self, piece: usize) -> f64 {
        let columns = |place: &DMat4| [place.x_axis, place.y_axis, place.z_axis].map(|column| column.length());
        self.layout.places[piece].iter().flat_map(columns).fold(0.0, f64::max)
    }

    /// Returns the diagonal of the scene's bounding box.
    pub fn diagonal(&self) -> f64 {
        self.layout.diagonal
    }

    /// Returns the index of a united group's piece.
    pub fn piece_of_group(&self, group: u32) -> usize {
        (self.layout.first_groups.partition_point(|&first| first <= group) - 1).min(self.layout.scales.len() - 1)
    }

    /// Returns for each piece the first one with the same instances, so that both have one system of coordinates.
    #[doc(hidden)]
    pub fn pieces_placed_alike(&self) -> Vec<usize> {
        let bits = |place: &DMat4| place.to_cols_array().map(f64::to_bits);
        let mut first_at = FxHashMap::default();
        let pieces = self.layout.places.iter().enumerate();
        pieces.map(|(i, places)| *first_at.entry(places.iter().map(bits).collect::<Vec<_>>()).or_insert(i)).collect()
    }

    /// Places the united mesh, simplified or not, at all instances.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use glam::{DMat4, DVec3};
    /// use neural_mesh::mesh::{Attributes, ScenePiece, UnitedMesh, shapes};
    /// let (mesh, attributes) = (shapes::icosphere(1), Attributes::default());
    /// let places = [-5.0, 5.0].map(|x| DMat4::from_translation(DVec3::new(x, 0.0, 0.0)));
    /// let united = UnitedMesh::new(&[ScenePiece { mesh: &mesh, attributes: &attributes, scale: 1.0, places: &places }]).unwrap();
    /// let view = united.view(&united.mesh, &united.attributes);
    /// assert_eq!((united.mesh.faces().len(), view.mesh.faces().len()), (80, 160));
    /// assert!(view.mesh.diagonal() > 12.0);
    /// ```
    pub fn view(&self, mesh: &TriMesh, attributes: &Attributes) -> SceneView {
        let (mut positions, mut faces, mut sources) = (Vec::new(), Vec::new(), Vec::new());
        let mut number = vec![u32::MAX; mesh.positions().len()];
        for (places, own) in self.layout.places.iter().zip(self.faces_of_pieces(mesh, attributes)) {
            for place in places {
                let first = positions.len() as u32;
                let mut vertices = Vec::new();
                for v in own.iter().flat_map(|&face| mesh.faces()[face as usize]) {
                    if number[v as usize] == u32::MAX {
                        number[v as usize] = first + vertices.len() as u32;
                        vertices.push(v);
                    }
                }
                positions.extend(vertices.iter().map(|&v| finite(place.transform_point3(point(mesh, v)))));
                let is_mirrored = place.determinant() < 0.0;
                let turn = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
                faces.extend(own.iter().map(|&face| turn(mesh.faces()[face as usize].map(|v| number[v as usize]))));
                sources.extend(&own);
                vertices.iter().for_each(|&v| number[v as usize] = u32::MAX);
            }
        }
        SceneView { mesh: TriMesh::new(positions, faces).unwrap_or_default(), faces: sources }
    }

    fn faces_of_pieces(&self, mesh: &TriMesh, attributes: &Attributes) -> Vec<Vec<u32>> {
        let mut faces = vec![Vec::new(); self.layout.scales.len()];
        for f in 0..mesh.faces().len() as u32 {
            faces[self.piece_of_group(attributes.group(f))].push(f);
        }
        faces
    }

    /// Returns the scale of a piece.
    pub fn scale(&self, piece: usize) -> f64 {
        f64::from(self.layout.scales[piece])
    }

    /// Returns a piece's first group in the united mesh.
    pub fn first_group(&self, piece: usize) -> u32 {
        self.layout.first_groups[piece]
    }

    /// Splits the united mesh, simplified or not, into its pieces at their own scales.
    pub fn split(&self, mesh: &TriMesh, attributes: &Attributes) -> Vec<(TriMesh, Attributes)> {
        let faces = self.faces_of_pieces(mesh, attributes);
        faces.iter().enumerate().map(|(piece, faces)| self.piece(piece, faces, mesh, attributes)).collect()
    }

    fn piece(&self, piece: usize, faces: &[u32], mesh: &TriMesh, attributes: &Attributes) -> (TriMesh, Attributes) {
        let corners = faces.iter().map(|&f| mesh.faces()[f as usize]).collect();
        let unscaled = |mesh: TriMesh| {
            let (positions, faces) = mesh.into_parts();
            let positions = positions.iter().map(|p| p.map(|x| x / self.layout.scales[piece])).collect();
            TriMesh::new(positions, faces).unwrap_or_default()
        };
        let own = compact(mesh.positions(), corners).map_or_else(|_| TriMesh::default(), |(mesh, _)| unscaled(mesh));
        let groups = faces.iter().map(|&f| attributes.group(f) - self.layout.first_groups[piece]).collect();
        let groups = if self.layout.has_groups[piece] { groups } else { Vec::new() };
        let wedges = faces.iter().filter_map(|&f| attributes.wedges.get(f as usize).copied()).collect();
        let mut carried = with_own_wedges(attributes, &self.layout.channels[piece], wedges, groups);
        for channel in &mut carried.channels {
            rescale(channel.role, &mut channel.values, 1.0 / self.layout.scales[piece]);
        }
        (own, carried)
    }
}

fn channel_names(piece: &ScenePiece) -> Vec<String> {
    piece.attributes.channels.iter().map(|channel| channel.name.clone()).collect()
}

fn places(pieces: &[ScenePiece], scales: &[f32]) -> Vec<Vec<DMat4>> {
    let n_viewed: usize = pieces.iter().map(|piece| piece.places.len().saturating_mul(piece.mesh.faces().len())).sum();
    let of_piece = |(piece, &scale): (&ScenePiece, &f32)| {
        let own = DMat4::from_scale(DVec3::splat(1.0 / f64::from(scale)));
        let mut places: Vec<DMat4> = piece.places.iter().map(|place| *place * own).collect();
        if n_viewed > MOST_VIEWED {
            let size = |place: &DMat4| place.determinant().abs();
            let largest = places.iter().copied().reduce(|a, b| if size(&b) > size(&a) { b } else { a });
            places = largest.into_iter().collect();
        }
        places
    };
    pieces.iter().zip(scales).map(of_piece).collect()
}

fn point(mesh: &TriMesh, vertex: u32) -> DVec3 {
    DVec3::from(mesh.positions()[vertex as usize].map(f64::from))
}

fn finite(point: DVec3) -> [f32; 3] {
    point.to_array().map(|x| if (x as f32).is_finite() { x as f32 } else { 0.0 })
}

fn with_own_wedges(
    attributes: &Attributes,
    names: &[String],
    mut wedges: Vec<[u32; 3]>,
    groups: Vec<u32>,
) -> Attributes {
    let mut next = 0;
    let channels = names.iter().filter_map(|name| {
        let found = attributes.find_channel(name, next)?;
        next = found + 1;
        Some(&attributes.channels[found])
    });
    let channels: Vec<&Channel> = channels.collect();
    if channels.is_empty() {
        return Attributes { groups, ..Attributes::default() };
    }
    let mut used = wedges.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let number = |wedge: u32| used.binary_search(&wedge).unwrap_or(0) as u32;
    wedges.iter_mut().flatten().for_each(|wedge| *wedge = number(*wedge));
    let own = |channel: &Channel| Channel {
        values: used.iter().flat_map(|&wedge| channel.value(wedge)).copied().collect(),
        name: channel.name.clone(),
        ..*channel
    };
    Attributes { channels: channels.into_iter().map(own).collect(), wedges, groups }
}

fn rescale(role: Role, value: &mut [f32], scale: f32) {
    if role == Role::MorphPosition {
        value.iter_mut().for_each(|x| *x *= scale);
    }
}

/// Lists the channels of all meshes, one per name, without values.
pub(super) fn all_channels<'a>(pieces: impl Iterator<Item = &'a Attributes>) -> Vec<Channel> {
    let (mut channels, mut places): (Vec<Channel>, FxHashMap<&str, usize>) = Default::default();
    for channel in pieces.flat_map(|piece| &piece.channels) {
        let place = *places.entry(&channel.name).or_insert(channels.len());
        match channels.get_mut(place) {
            Some(other) => other.width = other.width.max(channel.width),
            None => channels.push(Channel { values: Vec::new(), name: channel.name.clone(), ..*channel }),
        }
    }
    channels
}

/// Appends the groups, wedges and values of a mesh with `n_faces` faces.
pub(super) fn append_attributes(all: &mut Attributes, own: &Attributes, n_faces: u32, first_group: u32, scale: f32) {
    all.groups.extend((0..n_faces).map(|face| first_group + own.group(face)));
    if all.channels.is_empty() {
        return;
    }
    // A mesh without channels has one wedge, of zeros.
    let (first, n_wedges) = (all.n_wedges() as u32, own.n_wedges().max(1));
    // Wedges out of range stay out of range.
    let shift = |w: u32| if w as usize >= n_wedges { u32::MAX } else { first + w };
    let wedge = |face: u32| own.wedges.get(face as usize).map_or([first; 3], |row| row.map(shift));
    all.wedges.extend((0..n_faces).map(wedge));
    let channels = all.channels.iter_mut().enumerate();
    channels.for_each(|(near, channel)| extend(channel, near, own, n_wedges, scale));
}

/// Appends a mesh's values to a channel, or zeros (white for colours) if it has none; they are likely at `near`.
fn extend(channel: &mut Channel, near: usize, attributes: &Attributes, n_wedges: usize, scale: f32) {
    let (first, width) = (channel.values.len(), channel.width.max(1));
    let missing = if channel.role == Role::Colour { 1.0 } else { 0.0 };
    channel.values.resize(first + n_wedges * width, missing);
    let Some(own) = attributes.find_channel(&channel.name, near).map(|at| &attributes.channels[at]) else { return };
    let n_front = if channel.role == Role::Skin { own.width / 2 } else { own.width };
    let rows = channel.values[first..].chunks_exact_mut(width);
    for (row, values) in rows.zip(own.values.chunks_exact(own.width.max(1))) {
        let (front, back) = values.split_at(n_front);
        row[..n_front].copy_from_slice(front);
        row[width / 2..][..back.len()].copy_from_slice(back);
        rescale(channel.role, row, scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn channel(name: &str, width: usize, n: usize) -> Channel {
        let values = (0..n * width).map(|i| i as f32).collect();
        Channel { name: name.into(), role: Role::Other, width, values }
    }

    #[test]
    fn a_united_mesh_splits_into_its_pieces() {
        let (sphere, box_) = (shapes::icosphere(1), shapes::cuboid([1.0; 3], 2));
        let n = sphere.faces().len();
        let painted = Attributes {
            wedges: sphere.faces().to_vec(),
            channels: vec![channel("a", 2, sphere.positions().len()), channel("b", 1, sphere.positions().len())],
            groups: (0..n as u32).map(|f| f % 3).collect(),
        };
        let other = Attributes {
            wedges: box_.faces().to_vec(),
            channels: vec![channel("b", 1, box_.positions().len())],
            groups: Vec::new(),
        };
        let bare = Attributes::default();
        let pieces = [
            ScenePiece { mesh: &sphere, attributes: &painted, scale: 0.3, places: &[] },
            ScenePiece { mesh: &box_, attributes: &bare, scale: 1.0, places: &[] },
            ScenePiece { mesh: &box_, attributes: &other, scale: 100.0, places: &[] },
        ];
        let united = UnitedMesh::new(&pieces).unwrap();
        assert!(united.attributes.is_valid_for(united.mesh.faces().len()));
        let split = united.split(&united.mesh, &united.attributes);
        for (piece, (mesh, attributes)) in pieces.iter().zip(&split) {
            assert_eq!((mesh, attributes), (piece.mesh, piece.attributes));
        }
    }

    #[test]
    fn pieces_are_placed_alike_if_all_their_instances_are() {
        let (sphere, bare) = (shapes::icosphere(0), Attributes::default());
        let [here, there] = [0.0, 5.0].map(|x| DMat4::from_translation(DVec3::new(x, 0.0, 0.0)));
        let all = [vec![here], vec![here, there], vec![there], vec![here], vec![here, there]];
        let piece = |places| ScenePiece { mesh: &sphere, attributes: &bare, scale: 1.0, places };
        let pieces: Vec<ScenePiece> = all.iter().map(|places| piece(places)).collect();
        assert_eq!(UnitedMesh::new(&pieces).unwrap().pieces_placed_alike(), [0, 1, 2, 0, 1]);
        // A scale of the coordinates is part of the transform.
        let scaled = [piece(&all[0]), ScenePiece { scale: 4.0, ..piece(&all[0]) }];
        assert_eq!(UnitedMesh::new(&scaled).unwrap().pieces_placed_alike(), [0, 1]);
    }

    #[test]
    fn widened_channels_keep_their_values() {
        let widened = |role, values: &[f32], width| {
            let channel = |width, values| Channel { name: "a".into(), role, width, values };
            let own = Attributes { channels: vec![channel(values.len(), values.to_vec())], ..Attributes::default() };
            let mut all = channel(width, vec![7.0; width]);
            extend(&mut all, 0, &own, 1, 1.0);
            all.values.split_off(width)
        };
        assert_eq!(widened(Role::Colour, &[0.1, 0.2, 0.3], 4), [0.1, 0.2, 0.3, 1.0]);
        assert_eq!(widened(Role::Skin, &[5.0, 6.0, 0.25, 0.75], 8), [5.0, 6.0, 0.0, 0.0, 0.25, 0.75, 0.0, 0.0]);
        assert_eq!(widened(Role::Other, &[1.0, 2.0], 3), [1.0, 2.0, 0.0]);
        assert_eq!(widened(Role::Colour, &[], 3), [1.0; 3]);
    }

    #[test]
    fn a_mesh_of_which_nothing_is_left_is_empty() {
        let (sphere, bare) = (shapes::icosphere(0), Attributes::default());
        let piece = ScenePiece { mesh: &sphere, attributes: &bare, scale: 1.0, places: &[] };
        let united = UnitedMesh::new(&[piece, piece]).unwrap();
        let attributes = Attributes { groups: vec![1; 20], ..Attributes::default() };
        let split = united.split(&sphere, &attributes);
        assert!(split[0].0.faces().is_empty() && split[1].0 == sphere);
        assert!(UnitedMesh::new(&[ScenePiece { scale: 0.0, ..piece }]).is_none());
    }
}
