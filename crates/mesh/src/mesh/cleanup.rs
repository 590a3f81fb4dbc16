//! Cleans a mesh as read from a file into a valid one, in these steps:
//!
//! 1. Drops faces with a vertex index out of range.
//! 2. Drops faces with a corner that is not finite.
//! 3. Welds vertices at equal positions, in single precision about a local origin (-0 equals 0), unless the options
//!    forbid it.
//! 4. Drops faces that use a vertex twice, before or after welding.
//! 5. Drops all but one of the faces with the same three vertices, the one that is wound as its neighbours or outward, else
//!    the first; another stays if closed bodies touch there.
//! 6. Welds vertices that rounding errors of zeros keep apart (1e-17 if the largest coordinate is 1) where that closes open
//!    edges, unless the options forbid it.
//! 7. Drops unused vertices.
//!
//! Faces of zero area stay, since they hold the surface together.

use rustc_hash::FxHashSet;

use super::compact::{renumber_used, used_vertices};
use super::first_equal::join_positions;
use super::precision::{LostComponent, find_lost_component};
use super::repeated_faces::{prefer_wound_sides, repeated_faces, superfluous_faces};
use super::tri_mesh::are_sound;
use super::zero_noise::{Magnitudes, join_across_noise};
use super::{Attributes, Frame, InvalidMesh, RawMesh, TriMesh};
use crate::geometry::extent;

/// Options of [`clean`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct CleanOptions {
    /// True if vertices at equal positions are welded.
    pub weld: bool,
}

impl Default for CleanOptions {
    fn default() -> Self {
        Self { weld: true }
    }
}

/// Numbers of merged vertices and dropped faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CleanCounts {
    /// Vertices welded to another one.
    pub welded_vertices: usize,
    /// Vertices that no remaining face uses.
    pub unreferenced_vertices: usize,
    /// Faces that used a vertex twice.
    pub degenerate_faces: usize,
    /// Faces that repeat an earlier one.
    pub duplicate_faces: usize,
    /// Faces with a corner that is not finite.
    pub non_finite_faces: usize,
    /// Faces with a vertex index out of range.
    pub out_of_range_faces: usize,
    /// Polygons of the file with fewer than three corners.
    pub dropped_faces: usize,
}

impl std::ops::AddAssign for CleanCounts {
    fn add_assign(&mut self, other: Self) {
        self.welded_vertices += other.welded_vertices;
        self.unreferenced_vertices += other.unreferenced_vertices;
        self.degenerate_faces += other.degenerate_faces;
        self.duplicate_faces += other.duplicate_faces;
        self.non_finite_faces += other.non_finite_faces;
        self.out_of_range_faces += other.out_of_range_faces;
        self.dropped_faces += other.dropped_faces;
    }
}

/// A valid mesh and its relation to the raw one.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Cleaned {
    /// Mesh with at least one face.
    pub mesh: TriMesh,
    /// Conversion of the coordinates to the file's.
    pub frame: Frame,
    /// Numbers of changes.
    pub counts: CleanCounts,
    /// Index in the raw mesh of each vertex, n_vertices.
    pub source: Vec<u32>,
    /// Attributes of the mesh.
    pub attributes: Attributes,
    /// Groups of faces that lost their back, ascending: a duplicate face that was wound the other way.
    pub lost_backs: Vec<u32>,
}

/// Reasons why a mesh cannot be cleaned.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CleanError {
    /// No face is left.
    NoFaces {
        /// Number of vertices in the raw mesh.
        n_vertices: usize,
        /// Number of triangles in the raw mesh.
        n_faces: usize,
        /// Numbers of dropped faces, by reason.
        counts: CleanCounts,
    },
    /// Too many vertices or faces for `u32` indices.
    TooLarge,
    /// The attributes do not fit the faces.
    UnfitAttributes,
    /// Single precision cannot hold a component that is too small or too far from the others.
    TooCoarse {
        /// Index of one vertex of the component.
        vertex: usize,
        /// Diagonal of the component's bounding box.
        size: f64,
        /// Spacing of `f32` numbers at the component.
        step: f64,
    },
    /// A vertex is beyond the range of `f32`.
    TooFar {
        /// Index of the vertex.
        vertex: usize,
    },
}

impl std::fmt::Display for CleanError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoFaces { n_vertices, n_faces: 0, counts: CleanCounts { dropped_faces: 0, .. } } => {
                write!(
                    f,
                    "no faces (vertices: {n_vertices}): a mesh needs triangles or polygons; mesh-points makes them for a point cloud"
                )
            }
            Self::NoFaces { n_vertices, n_faces, counts } => {
                let n_faces = n_faces + counts.dropped_faces;
                write!(f, "no usable face (faces: {n_faces}, vertices: {n_vertices}, {counts}): repair the mesh")
            }
            Self::TooLarge => write!(f, "more than {} vertices or faces: split the mesh", u32::MAX / 4),
            Self::UnfitAttributes => write!(f, "the attributes do not match the faces: give one row for each face"),
            Self::TooCoarse { vertex, size, step } => write!(
                f,
                "the component at vertex {vertex} is {size:.2e} across, but single precision rounds by {step:.1e} at its position: save distant components, and components of very different sizes, as separate files"
            ),
            Self::TooFar { vertex } => {
                write!(f, "vertex {vertex} is beyond the range of single precision (3.4e38): scale the mesh")
            }
        }
    }
}

impl std::error::Error for CleanError {}

impl std::fmt::Display for CleanCounts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let named = [
            (self.welded_vertices, "welded vertices"),
            (self.unreferenced_vertices, "unreferenced vertices"),
            (self.degenerate_faces, "degenerate faces"),
            (self.duplicate_faces, "duplicate faces"),
            (self.non_finite_faces, "faces with non-finite corners"),
            (self.out_of_range_faces, "faces with corners out of range"),
            (self.dropped_faces, "faces with fewer than three corners"),
        ];
        let parts: Vec<_> = named.iter().filter(|(n, _)| *n > 0).map(|(n, name)| format!("{name}: {n}")).collect();
        f.write_str(if parts.is_empty() { "nothing" } else { "" })?;
        f.write_str(&parts.join(", "))
    }
}

/// Cleans a mesh by the steps of this module.
///
/// Doubles are moved to a local origin, which the returned frame holds.
///
/// # Errors
/// [`CleanError`] if no face is left or single precision cannot hold the mesh.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::mesh::{RawMesh, cleanup};
/// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 0.0]];
/// let raw = RawMesh::new(positions, vec![[3, 1, 2], [0, 1, 2], [0, 1, 3]]);
/// let cleaned = cleanup::clean(raw, &cleanup::CleanOptions::default()).unwrap();
/// assert_eq!(cleaned.mesh.faces(), [[0, 1, 2]]);
/// assert_eq!(cleaned.counts.to_string(), "welded vertices: 1, degenerate faces: 1, duplicate faces: 1");
/// ```
pub fn clean(raw: RawMesh, options: &CleanOptions) -> Result<Cleaned, CleanError> {
    let RawMesh { positions, faces, double, dropped_faces, mut attributes } = raw;
    let (n_raw_vertices, n_raw_faces) = (positions.len(), faces.len());
    if n_raw_vertices.max(n_raw_faces) > (u32::MAX / 4) as usize {
        return Err(CleanError::TooLarge);
    }
    let mut counts = CleanCounts { dropped_faces, ..CleanCounts::default() };
    let mut faces = FaceList::new(faces, !attributes.is_empty());
    if !are_sound(&faces.corners, n_raw_vertices) || !positions.as_flattened().iter().all(|x| x.is_finite()) {
        drop_broken_faces(&positions, &mut faces, &mut counts);
    }
    let used = used_vertices(&faces.corners, n_raw_vertices);
    let frame = Frame { origin: if double { local_origin(&positions, &used) } else { [0.0; 3] }, double };
    let (local, magnitudes) = to_local(&positions, &used, &frame)?;
    let n_sound_faces = faces.len();
    let is_welded = options.weld && weld(positions, &local, &used, &frame, &mut faces.corners, &mut counts)?;
    if is_welded {
        drop_degenerate_faces(&mut faces, &mut counts);
    }
    let duplicates = drop_duplicate_faces(&local, &mut faces, &mut counts);
    let lost_backs = groups_without_backs(&faces, &duplicates, &attributes);
    let are_as_before = !is_welded && faces.len() == n_sound_faces;
    let FaceList { corners: mut faces, numbers } = faces;
    let mut used = if are_as_before { used } else { used_vertices(&faces, local.len()) };
    if options.weld && magnitudes.has_noise() {
        counts.welded_vertices += join_across_noise(&local, &mut faces, &mut used);
    }
    let (local, source) = drop_unused_vertices(local, &mut faces, &used);
    counts.unreferenced_vertices = n_raw_vertices - counts.welded_vertices - local.len();
    if faces.is_empty() {
        return Err(CleanError::NoFaces { n_vertices: n_raw_vertices, n_faces: n_raw_faces, counts });
    }
    if let Some(numbers) = numbers {
        attributes = attributes.select_faces(&numbers).ok_or(CleanError::UnfitAttributes)?;
    }
    let mesh = TriMesh::new(local, faces).map_err(|error| match error {
        InvalidMesh::NotFinite { vertex } => CleanError::TooFar { vertex: source[vertex] as usize },
        _ => CleanError::TooLarge,
    })?;
    Ok(Cleaned { mesh, frame, counts, source, attributes, lost_backs })
}

struct FaceList {
    corners: Vec<[u32; 3]>,
    numbers: Option<Vec<u32>>,
}

impl FaceList {
    fn new(corners: Vec<[u32; 3]>, numbered: bool) -> Self {
        let numbers = numbered.then(|| (0..corners.len() as u32).collect());
        Self { corners, numbers }
    }

    fn len(&self) -> usize {
        self.corners.len()
    }

    fn retain(&mut self, mut is_wanted: impl FnMut(&[u32; 3]) -> bool) {
        let Some(numbers) = &mut self.numbers else { return self.corners.retain(is_wanted) };
        let mut both = std::mem::take(&mut self.corners).into_iter().zip(std::mem::take(numbers)).collect::<Vec<_>>();
        both.retain(|(face, _)| is_wanted(face));
        (self.corners, *numbers) = both.into_iter().unzip();
    }
}

/// Applies steps 1 and 2, and step 4 to the faces as read.
fn drop_broken_faces(positions: &[[f64; 3]], faces: &mut FaceList, counts: &mut CleanCounts) {
    let n_vertices = positions.len();
    let all_finite = positions.iter().flatten().all(|x| x.is_finite());
    faces.retain(|face| {
        let outside = face.iter().any(|&v| v as usize >= n_vertices);
        let infinite =
            !outside && !all_finite && face.iter().any(|&v| positions[v as usize].iter().any(|x| !x.is_finite()));
        counts.out_of_range_faces += usize::from(outside);
        counts.non_finite_faces += usize::from(infinite);
        !outside && !infinite
    });
    drop_degenerate_faces(faces, counts);
}

fn drop_degenerate_faces(faces: &mut FaceList, counts: &mut CleanCounts) {
    let before = faces.len();
    faces.retain(|&[a, b, c]| a != b && b != c && c != a);
    counts.degenerate_faces += before - faces.len();
}

/// Returns a local origin near the centre of the used vertices, to which local coordinates add exactly.
pub(super) fn local_origin(positions: &[[f64; 3]], used: &[bool]) -> [f64; 3] {
    let used = positions.iter().zip(used).filter(|(_, used)| **used);
    let (low, high) = extent(used.map(|(&position, _)| position.into()));
    origin_within(low.into(), high.into())
}

#[doc(hidden)]
pub fn origin_within(low: [f64; 3], high: [f64; 3]) -> [f64; 3] {
    // Halves first: the extent of coordinates near the largest double would overflow.
    let half = (0..3).map(|axis| high[axis] / 2.0 - low[axis] / 2.0).fold(0.0, f64::max);
    let grid = half.log2().ceil().exp2() * 2.0;
    std::array::from_fn(|axis| {
        let centre = low[axis] / 2.0 + high[axis] / 2.0;
        let origin = if half > 0.0 { (centre / grid).round() * grid } else { centre };
        // Adding zero turns -0 into 0.
        if origin.is_finite() { origin + 0.0 } else { 0.0 }
    })
}

/// Returns the local coordinates, and the magnitudes of those of used vertices.
pub(super) fn to_local(
    positions: &[[f64; 3]],
    used: &[bool],
    frame: &Frame,
) -> Result<(Vec<[f32; 3]>, Magnitudes), CleanError> {
    let local: Vec<[f32; 3]> = positions.iter().map(|&p| frame.to_local(p)).collect();
    let magnitudes = Magnitudes::of_used(&local, used);
    if magnitudes.are_finite() {
        return Ok((local, magnitudes));
    }
    let is_outside = |(p, used): (&[f32; 3], &bool)| *used && p.iter().any(|x| !x.is_finite());
    let vertex = local.iter().zip(used).position(is_outside).unwrap_or_default();
    Err(CleanError::TooFar { vertex })
}

/// Welds vertices (step 3); returns whether any two share a position.
fn weld(
    positions: Vec<[f64; 3]>,
    local: &[[f32; 3]],
    used: &[bool],
    frame: &Frame,
    faces: &mut [[u32; 3]],
    counts: &mut CleanCounts,
) -> Result<bool, CleanError> {
    let (first, repeated) = join_positions(local);
    let lost = frame.double.then(|| find_lost_component(&positions, local, &first, faces)).flatten();
    if let Some(LostComponent { vertex, size, step }) = lost {
        return Err(CleanError::TooCoarse { vertex, size, step });
    }
    drop(positions);
    if repeated {
        for vertex in faces.iter_mut().flatten() {
            *vertex = first[*vertex as usize];
        }
        let count = |marks: &[bool]| marks.iter().filter(|mark| **mark).count();
        counts.welded_vertices = count(used) - count(&used_vertices(faces, local.len()));
    }
    Ok(repeated)
}

/// Drops duplicate faces (step 5) until nothing changes, and returns them.
fn drop_duplicate_faces(local: &[[f32; 3]], faces: &mut FaceList, counts: &mut CleanCounts) -> Vec<[u32; 3]> {
    let mut dropped = Vec::new();
    loop {
        let mut repeated = superfluous_faces(local, &faces.corners, repeated_faces(&faces.corners, local.len()));
        if repeated.is_empty() {
            return dropped;
        }
        prefer_wound_sides(local, &faces.corners, &mut repeated);
        counts.duplicate_faces += repeated.len();
        dropped.extend(repeated.iter().map(|&face| faces.corners[face as usize]));
        let mut repeated = repeated.into_iter().peekable();
        let mut faces_before = 0..;
        faces.retain(|_| faces_before.next() != repeated.peek().copied() || repeated.next().is_none());
    }
}

/// Returns the groups of faces whose other side is among the dropped faces, ascending.
fn groups_without_backs(faces: &FaceList, dropped: &[[u32; 3]], attributes: &Attributes) -> Vec<u32> {
    if dropped.is_empty() {
        return Vec::new();
    }
    let from_lowest = |mut face: [u32; 3]| {
        let first = (0..3).min_by_key(|&corner| face[corner]).unwrap_or(0);
        face.rotate_left(first);
        face
    };
    let dropped: FxHashSet<[u32; 3]> = dropped.iter().map(|&face| from_lowest(face)).collect();
    let lost = (0u32..).zip(&faces.corners).filter(|(_, [a, b, c])| dropped.contains(&from_lowest([*a, *c, *b])));
    let number = |face: u32| faces.numbers.as_ref().map_or(face, |numbers| numbers[face as usize]);
    let mut groups: Vec<u32> = lost.map(|(face, _)| attributes.group(number(face))).collect();
    groups.sort_unstable();
    groups.dedup();
    groups
}

/// Drops unused vertices (step 7); also returns each vertex's old index.
fn drop_unused_vertices(local: Vec<[f32; 3]>, faces: &mut [[u32; 3]], used: &[bool]) -> (Vec<[f32; 3]>, Vec<u32>) {
    if used.iter().all(|used| *used) {
        let source = (0..local.len() as u32).collect();
        return (local, source);
    }
    let source = renumber_used(faces, used);
    (source.iter().map(|&old| local[old as usize]).collect(), source)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Channel, Role};
    use proptest::prelude::*;

    const NAN: f64 = f64::NAN;

    fn clean_soup(positions: &[[f64; 3]], faces: &[[u32; 3]]) -> Result<Cleaned, CleanError> {
        let raw = RawMesh { positions: positions.to_vec(), faces: faces.to_vec(), ..RawMesh::default() };
        clean(raw, &CleanOptions::default())
    }

    fn naive(positions: &[[f64; 3]], faces: &[[u32; 3]], weld: bool) -> (Vec<[[f32; 3]; 3]>, CleanCounts) {
        let mut counts = CleanCounts::default();
        let (mut kept, mut used) = (Vec::<[u32; 3]>::new(), std::collections::BTreeSet::new());
        for face in faces {
            if face.iter().any(|&v| v as usize >= positions.len()) {
                counts.out_of_range_faces += 1;
                continue;
            }
            if face.iter().any(|&v| positions[v as usize].iter().any(|x| !x.is_finite())) {
                counts.non_finite_faces += 1;
                continue;
            }
            let sorted = |mut face: [u32; 3]| {
                face.sort_unstable();
                face
            };
            let repeats = |[a, b, c]: [u32; 3]| a == b || b == c || c == a;
            let first = |v: u32| positions.iter().position(|p| *p == positions[v as usize]).unwrap() as u32;
            let welded = if weld { face.map(first) } else { *face };
            if !repeats(*face) {
                used.extend(*face);
            }
            if repeats(welded) {
                counts.degenerate_faces += 1;
            } else if kept.iter().any(|other| sorted(*other) == sorted(welded)) {
                counts.duplicate_faces += 1;
            } else {
                kept.push(welded);
            }
        }
        let distinct = |vertices: Vec<u32>| vertices.into_iter().collect::<std::collections::BTreeSet<_>>().len();
        let first = |&v: &u32| positions.iter().position(|p| *p == positions[v as usize]).unwrap() as u32;
        counts.welded_vertices = if weld { used.len() - distinct(used.iter().map(first).collect()) } else { 0 };
        let n_kept = distinct(kept.iter().flatten().copied().collect());
        counts.unreferenced_vertices = positions.len() - counts.welded_vertices - n_kept;
        (kept.iter().map(|face| face.map(|v| positions[v as usize].map(|x| x as f32))).collect(), counts)
    }

    proptest! {
        #[test]
        fn agrees_with_the_naive_policy(
            positions in prop::collection::vec(prop::array::uniform3(prop::sample::select(vec![0.0, -0.0, 1.0, 2.5, NAN])), 1..30),
            faces in prop::collection::vec(prop::array::uniform3(0u32..32), 1..60),
            weld in any::<bool>(),
        ) {
            let (corners, counts) = naive(&positions, &faces, weld);
            let raw = RawMesh { positions: positions.clone(), faces, ..RawMesh::default() };
            match clean(raw, &CleanOptions { weld }) {
                Ok(cleaned) => {
                    let mesh = &cleaned.mesh;
                    let found: Vec<_> = mesh.faces().iter().map(|f| f.map(|v| mesh.positions()[v as usize])).collect();
                    prop_assert_eq!(found, corners);
                    prop_assert_eq!(cleaned.counts, counts);
                    for (position, &source) in mesh.positions().iter().zip(&cleaned.source) {
                        prop_assert_eq!(*position, positions[source as usize].map(|x| x as f32));
                    }
                }
                Err(error) => {
                    prop_assert!(corners.is_empty());
                    let expected = matches!(error, CleanError::NoFaces { counts: found, .. } if found == counts);
                    prop_assert!(expected, "{:?} {:?}", error, counts);
                }
            }
        }
    }

    #[test]
    fn negative_zero_is_zero() {
        let cleaned =
            clean_soup(&[[0.0; 3], [1.0, 0.0, -0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 3], [0, 2, 3]])
                .unwrap();
        assert_eq!((cleaned.mesh.faces(), cleaned.counts.duplicate_faces), (&[[0, 1, 2]][..], 1));
        assert!(cleaned.mesh.positions().iter().flatten().all(|x| x.is_sign_positive()));
    }

    #[test]
    fn faces_without_area_stay() {
        let cleaned = clean_soup(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[[0, 1, 2]]).unwrap();
        assert_eq!(cleaned.counts, CleanCounts::default());
    }

    #[test]
    fn coordinates_far_from_the_origin_keep_their_precision() {
        let step = 0.001;
        let positions: Vec<_> =
            (0..30).map(|i| [5e6 + step * f64::from(i), -4.2e6 + step * f64::from(i * i), 300.0]).collect();
        let faces = (0..28).map(|i| [i, i + 1, i + 2]).collect();
        let raw = RawMesh { positions: positions.clone(), faces, double: true, ..RawMesh::default() };
        let Cleaned { mesh, frame, .. } = clean(raw, &CleanOptions::default()).unwrap();
        for (local, exact) in mesh.positions().iter().zip(&positions) {
            let written = frame.to_file(*local);
            assert!((0..3).all(|axis| (written[axis] - exact[axis]).abs() < 1e-6), "{written:?} {exact:?}");
        }
    }

    #[test]
    fn doubles_near_the_origin_are_not_moved() {
        let positions = vec![[0.1f32; 3].map(f64::from), [1.0, -0.2, 0.0], [0.0, 1.0, 0.0]];
        let raw = RawMesh { positions, faces: vec![[0, 1, 2]], double: true, ..RawMesh::default() };
        assert_eq!(clean(raw, &CleanOptions::default()).unwrap().frame.origin, [0.0; 3]);
    }

    #[test]
    fn what_exceeds_single_precision_is_refused_in_one_line() {
        for double in [false, true] {
            let positions = vec![[0.0; 3], [1e300, 0.0, 0.0], [0.0, 1.0, 0.0], [-1e300, 0.0, 0.0]];
            let raw = RawMesh { positions, faces: vec![[0, 1, 2], [1, 2, 3]], double, ..RawMesh::default() };
            let error = clean(raw, &CleanOptions::default()).unwrap_err();
            assert!(matches!(error, CleanError::TooFar { .. }), "{error}");
            assert!(!error.to_string().contains('\n'));
        }
        // Far out, but small: fits once moved.
        let positions = vec![[1e300, 0.0, 0.0], [1e300, 1.0, 0.0], [1e300, 0.0, 1.0]];
        let raw = RawMesh { positions, faces: vec![[0, 1, 2]], double: true, ..RawMesh::default() };
        assert!(clean(raw, &CleanOptions::default()).is_ok());
    }

    #[test]
    fn a_mesh_without_remaining_faces_is_refused_with_the_reason() {
        let error = clean_soup(&[[0.0; 3], [1.0, 0.0, NAN], [2.0, 0.0, 0.0]], &[[0, 1, 2], [0, 2, 7]]).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with("no usable face (faces: 2, vertices: 3"), "{text}");
        assert!(text.contains("faces with non-finite corners: 1, faces with corners out of range: 1"), "{text}");
        assert!(clean_soup(&[[0.0; 3]], &[]).unwrap_err().to_string().starts_with("no faces (vertices: 1)"));
    }

    #[test]
    fn attributes_stay_with_their_faces() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]];
        let faces = vec![[0, 1, 9], [3, 1, 2], [0, 0, 1], [0, 2, 1]];
        let values = (0..4).map(|i| i as f32).collect();
        let channels = vec![Channel { name: "heat".into(), role: Role::Other, width: 1, values }];
        let attributes = Attributes { wedges: faces.clone(), channels, groups: vec![5, 6, 7, 8] };
        let raw = RawMesh { positions, faces, attributes, ..RawMesh::default() };
        let Cleaned { mesh, attributes, .. } = clean(raw.clone(), &CleanOptions::default()).unwrap();
        assert_eq!(mesh.faces(), [[0, 1, 2]]);
        assert_eq!((attributes.wedges, attributes.groups), (vec![[3, 1, 2]], vec![6]));
        let mut short = raw;
        short.attributes.groups.truncate(1);
        assert_eq!(clean(short, &CleanOptions::default()), Err(CleanError::UnfitAttributes));
    }

    #[test]
    fn groups_that_lose_the_back_of_a_face_are_named() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let lost = |faces: Vec<[u32; 3]>, groups: Vec<u32>| {
            let attributes = Attributes { groups, ..Attributes::default() };
            let raw = RawMesh { attributes, ..RawMesh::new(positions.to_vec(), faces) };
            clean(raw, &CleanOptions::default()).unwrap().lost_backs
        };
        assert_eq!(lost(vec![[0, 1, 2], [1, 3, 2], [2, 1, 0]], vec![3, 5, 4]), [3]);
        assert_eq!(lost(vec![[0, 1, 2], [1, 3, 2], [3, 1, 2]], Vec::new()), [0]);
        // The same face twice has no back.
        assert!(lost(vec![[0, 1, 2], [1, 2, 0]], vec![1, 2]).is_empty());
    }
}
