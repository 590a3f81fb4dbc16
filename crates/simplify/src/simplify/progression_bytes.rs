//! Progressions as bytes.
//!
//! Eight bytes of [`MAGIC`] and the version (`u32`) come first, then the fields of [`Progression::write`] in their order,
//! in the form of `mesh::value_bytes`, and last a checksum (`u64`) of all bytes before it.

use glam::Vec3;

use crate::mesh::value_bytes::{ByteReader, Stored, store_choices, store_fields, write_list};
use crate::mesh::{Attributes, Channel, Role, TriMesh, UnitedMesh};

use super::closed::{CollapseEnd, ProgressionSurface, RecordedMerge, vertex_components};
use super::options::{ClosedOptions, DroppedComponent, ScoreSource, SimplifyError};
use super::progression::{Drop, Progression, ProvedLevel};
use super::sub_mesh::SubMeshOrigin;

const MAGIC: &[u8; 8] = b"NMESHPRG";
const VERSION: u32 = 2;

impl Progression {
    /// Returns the progression as bytes that [`from_bytes`](Self::from_bytes) reads.
    ///
    /// ```
    /// # use neural_mesh_simplify as neural_mesh;
    /// use std::ops::ControlFlow;
    /// use neural_mesh::{mesh::shapes, simplify::{ClosedOptions, Progression}};
    /// let (mesh, options) = (shapes::icosphere(3), ClosedOptions::default());
    /// let progression = Progression::new(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap();
    /// let read = Progression::from_bytes(&progression.to_bytes()).unwrap();
    /// assert_eq!(read.at_faces(200, true), progression.at_faces(200, true));
    /// ```
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        VERSION.write(&mut bytes);
        self.write(&mut bytes);
        checksum(&bytes).write(&mut bytes);
        bytes
    }

    /// Reads a progression; never takes more memory than a multiple of the bytes given.
    ///
    /// # Errors
    /// [`SimplifyError::BadProgression`] if the bytes are of another format or version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SimplifyError> {
        let bad = SimplifyError::BadProgression;
        let Some(rest) = bytes.strip_prefix(MAGIC) else { return Err(bad("it begins with other bytes")) };
        let mut reader = ByteReader { rest };
        if u32::read(&mut reader) != Some(VERSION) {
            return Err(bad("its version is not known"));
        }
        let Some((content, sum)) = reader.rest.split_last_chunk::<8>() else { return Err(bad("it is cut off")) };
        if u64::from_le_bytes(*sum) != checksum(&bytes[..bytes.len() - 8]) {
            return Err(bad("it is damaged"));
        }
        let mut reader = ByteReader { rest: content };
        let read = Self::read(&mut reader).filter(|_| reader.rest.is_empty());
        read.ok_or(bad("its parts do not fit together"))
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        write_list(self.mesh.positions(), bytes);
        write_list(self.mesh.faces(), bytes);
        self.attributes.write(bytes);
        self.kept.write(bytes);
        self.locked.write(bytes);
        self.scene.write(bytes);
        self.options.write(bytes);
        self.scores.write(bytes);
        (self.n_kept_edges as u64).write(bytes);
        self.end.write(bytes);
        self.size.map(|n| n as u64).write(bytes);
        self.origins.write(bytes);
        self.surface.faces.write(bytes);
        self.surface.copies.write(bytes);
        self.surface.sequence.merges().collect::<Vec<_>>().write(bytes);
        self.drops.write(bytes);
        self.proofs.write(bytes);
        self.files.write(bytes);
    }

    fn read(from: &mut ByteReader) -> Option<Self> {
        let mesh = TriMesh::new(Vec::read(from)?, Vec::read(from)?).ok()?;
        let attributes = Attributes::read(from)?;
        let (kept, locked): (Vec<bool>, Vec<bool>) = (Vec::read(from)?, Vec::read(from)?);
        let scene = Option::<UnitedMesh>::read(from)?;
        let options = ClosedOptions::read(from)?;
        let (scores, n_kept_edges) = (ScoreSource::read(from)?, u64::read(from)? as usize);
        let end = CollapseEnd::read(from)?;
        let size = <[u64; 2]>::read(from)?.map(|n| n as usize);
        let origins = <[SubMeshOrigin; 2]>::read(from)?;
        let surface = read_surface(from, &mesh)?;
        let (drops, proofs, files) = (Vec::read(from)?, Vec::read(from)?, Vec::read(from)?);
        // All is checked here, so that levels are made without a further look.
        if !are_origins_of(&origins, &mesh, size) {
            return None;
        }
        let (components, _) = vertex_components(surface.sequence.n_vertices(), surface.faces(&mesh));
        let progression = Self {
            mesh,
            attributes,
            kept,
            locked,
            scene,
            options,
            scores,
            n_kept_edges,
            end,
            size,
            origins,
            surface,
            components,
            drops,
            proofs,
            files,
            is_from_bytes: true,
        };
        progression.is_consistent().then_some(progression)
    }

    fn is_consistent(&self) -> bool {
        let n_components = self.n_components();
        let mut is_dropped = vec![false; n_components];
        // No component is dropped twice, and one stays.
        let drops_once = |&component: &u32| {
            let flag = is_dropped.get_mut(component as usize);
            flag.is_some_and(|flag| !std::mem::replace(flag, true))
        };
        let drops_fit = self.drops.iter().flat_map(|drop| &drop.components).all(drops_once);
        let faces_fit =
            self.drops.iter().flat_map(|drop| &drop.dropped).all(|it| (it.face as usize) < self.mesh.faces().len());
        let proofs_fit = self.proofs.iter().all(|level| level.distance >= 0.0 && level.n_vertices > 0);
        let channels_fit = self.attributes.channels.iter().all(has_usual_width);
        let some_stays = is_dropped.contains(&false);
        self.input().check().is_ok() && drops_fit && faces_fit && proofs_fit && channels_fit && some_stays
    }
}

/// Reads the merges of a mesh's surface.
///
/// The surface is stored for readers that cannot make a mesh manifold; here it must be the one that is made.
fn read_surface(from: &mut ByteReader, mesh: &TriMesh) -> Option<ProgressionSurface> {
    let (faces, copies): (Option<Vec<[u32; 3]>>, Vec<u32>) = (Option::read(from)?, Vec::read(from)?);
    let merges: Vec<RecordedMerge> = Vec::read(from)?;
    if mesh.faces().is_empty() || !merges.iter().all(|merge| merge.position.is_finite()) {
        return None;
    }
    let surface = ProgressionSurface::from_merges(mesh, &merges)?;
    (surface.faces == faces && surface.copies == copies).then_some(surface)
}

/// Returns whether origins lead from the mesh to used vertices and faces, and on to the caller's mesh.
fn are_origins_of([pruned, used]: &[SubMeshOrigin; 2], mesh: &TriMesh, [n_vertices, n_faces]: [usize; 2]) -> bool {
    let fits = |rows: &Option<Vec<u32>>, n: usize, n_whole: usize| match rows {
        Some(rows) => rows.len() == n && rows.iter().all(|&row| (row as usize) < n_whole),
        None => n == n_whole,
    };
    // A number that claims many vertices must not make a large array.
    let is_small = used.n_vertices <= 16 * n_vertices + (1 << 20);
    fits(&pruned.vertices, mesh.positions().len(), n_vertices)
        && fits(&pruned.faces, mesh.faces().len(), n_faces)
        && fits(&used.vertices, n_vertices, used.n_vertices)
        && pruned.n_vertices == n_vertices
        && used.faces.is_none()
        && is_small
}

fn has_usual_width(channel: &Channel) -> bool {
    match channel.role {
        Role::Normal | Role::MorphPosition | Role::MorphDirection => channel.width == 3,
        Role::Tangent => channel.width == 4,
        Role::Uv => channel.width == 2,
        Role::Colour => matches!(channel.width, 3 | 4),
        Role::Skin => channel.width.is_multiple_of(2),
        Role::Other | Role::Label => true,
    }
}

/// Mixes words of eight bytes; the last may be shorter.
fn checksum(bytes: &[u8]) -> u64 {
    const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
    let mix = |sum: u64, word: u64| (sum ^ word).wrapping_mul(FACTOR).rotate_left(29);
    let (words, rest) = bytes.as_chunks::<8>();
    let sum = words.iter().fold(bytes.len() as u64, |sum, word| mix(sum, u64::from_le_bytes(*word)));
    rest.iter().fold(sum, |sum, &byte| mix(sum, u64::from(byte)))
}

// The third code was that of an end that is gone.
store_choices! {
    CollapseEnd: [CollapseEnd::Reached, CollapseEnd::Smallest, CollapseEnd::Smallest, CollapseEnd::WouldTurn,
        CollapseEnd::LosesShape, CollapseEnd::Held];
}

store_fields! {
    DroppedComponent { face: u32, n_faces: usize };
    SubMeshOrigin { n_vertices: usize, vertices: Option<Vec<u32>>, faces: Option<Vec<u32>>, n_dropped: usize, n_hidden: usize,
        dropped: Vec<DroppedComponent> };
    RecordedMerge { kept: u32, removed: u32, position: Vec3, takes_removed_place: bool } ..Self::UNPRICED;
    Drop { n_vertices: usize, components: Vec<u32>, dropped: Vec<DroppedComponent> };
    ProvedLevel { n_vertices: usize, distance: f64 };
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat4;
    use std::ops::ControlFlow;

    use crate::mesh::cleanup::{CleanOptions, clean};
    use crate::mesh::{RawMesh, ScenePiece, shapes};
    use crate::simplify::Input;
    use proptest::prelude::*;

    fn progression<'a>(input: impl Into<Input<'a>>) -> Progression {
        let options = ClosedOptions { crease_angle: Some(60.0), ..ClosedOptions::default() };
        Progression::new(input, &options, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    fn small() -> Progression {
        let mesh = shapes::wavy_sphere(2, 6.0);
        let values = mesh.positions().iter().flat_map(|p| [p[0], p[1]]).collect();
        let attributes = Attributes {
            groups: (0..mesh.faces().len() as u32).map(|f| u32::from(f < 90)).collect(),
            wedges: mesh.faces().to_vec(),
            channels: vec![Channel { name: "uv".into(), role: Role::Uv, width: 2, values }],
        };
        let input = Input { attributes: &attributes, ..Input::bare(&mesh) };
        Progression { files: vec![("a.ply".into(), vec![1, 2, 3])], ..progression(input) }
    }

    /// Replaces the checksum by that of the bytes, as one who means harm would.
    fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
        bytes.truncate(bytes.len() - 8);
        checksum(&bytes).write(&mut bytes);
        bytes
    }

    #[test]
    fn a_progression_comes_back_with_all_it_carries() {
        let mut written = small();
        written.proofs = vec![ProvedLevel { n_vertices: 80, distance: 0.5 }];
        let bytes = written.to_bytes();
        let read = Progression::from_bytes(&bytes).unwrap();
        assert_eq!(read.to_bytes(), bytes);
        for n in [162, 100, 50, 20] {
            for refined in [false, true] {
                assert_eq!(read.at_vertices(n, refined), written.at_vertices(n, refined));
            }
        }
        assert_eq!((read.at_error(0.6), read.files.len()), (written.at_vertices(80, false), 1));
    }

    #[test]
    fn scenes_and_surfaces_that_are_split_come_back() {
        let (mesh, attributes) = (shapes::touching_spheres(2), Attributes::default());
        let places = [-5.0, 5.0].map(|x| DMat4::from_translation(glam::DVec3::new(x, 0.0, 0.0)));
        let piece = ScenePiece { mesh: &mesh, attributes: &attributes, scale: 1.0, places: &places };
        let united = UnitedMesh::new(&[piece, piece]).unwrap();
        let mut input = Input::bare(&united.mesh);
        (input.attributes, input.scene) = (&united.attributes, Some(&united));
        let written = progression(input);
        let read = Progression::from_bytes(&written.to_bytes()).unwrap();
        assert_eq!(read.scene, written.scene);
        for refined in [false, true] {
            assert_eq!(read.at_vertices(200, refined), written.at_vertices(200, refined));
        }
    }

    #[test]
    fn damaged_bytes_are_refused() {
        let bytes = small().to_bytes();
        for n in (0..bytes.len()).step_by(7) {
            assert!(Progression::from_bytes(&bytes[..n]).is_err(), "{n}");
            let mut changed = bytes.clone();
            changed[n] ^= 1 << (n % 8);
            assert!(matches!(Progression::from_bytes(&changed), Err(SimplifyError::BadProgression(_))), "{n}");
        }
    }

    #[test]
    fn hostile_bytes_give_an_error_or_a_progression_that_answers() {
        let bytes = small().to_bytes();
        let mut n_read = 0;
        for n in (12..bytes.len() - 8).step_by(5) {
            for value in [0, 1, 0x7f, 0xff] {
                let mut changed = bytes.clone();
                changed[n] = value;
                let Ok(read) = Progression::from_bytes(&with_checksum(changed)) else { continue };
                n_read += 1;
                if n_read % 16 == 0 {
                    [false, true].into_iter().for_each(|refined| drop(read.at_vertices(30, refined)));
                }
            }
        }
        assert!(n_read > 100, "{n_read}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
        #[test]
        fn levels_of_any_mesh_come_back(
            points in proptest::collection::vec(proptest::array::uniform3(-3i8..3), 8..80),
            corners in proptest::collection::vec(proptest::array::uniform3(0usize..80), 20..300),
        ) {
            let positions = points.iter().map(|p| p.map(f64::from)).collect();
            let faces = corners.iter().map(|face| face.map(|v| (v % points.len()) as u32)).collect();
            let Ok(cleaned) = clean(RawMesh::new(positions, faces), &CleanOptions::default()) else { return Ok(()) };
            let made = progression(&cleaned.mesh);
            let read = Progression::from_bytes(&made.to_bytes()).unwrap();
            for n in [4, 10, 20, 40, 79] {
                for refined in [false, true] {
                    let [own, back] = [&made, &read].map(|it| it.at_vertices(n, refined).map(|level| level.mesh));
                    prop_assert_eq!(own, back);
                }
            }
        }
    }
}
