//! Hierarchies of meshes larger than memory.
//!
//! A block gets its first levels on its own, while vertices of other blocks stay. Its clusters go to disk; those without
//! a group are joined with those of the other blocks, and further levels are added in memory.

use std::io::Write;

use rustc_hash::FxHashMap;

use crate::blocks::{
    Block, FACES_PER_BLOCK, OutOfCoreError, ProgressCallback, StoredBlock, WorkingSpace, check_room, cut_file,
    report_progress,
};
use crate::io::Pieces;
use crate::mesh::cleanup::CleanCounts;
use crate::mesh::{PositionKey, position_key};
use crate::simplify::{ClosedOptions, Input, SimplifyError};

use super::ancestors::AncestorLists;
use super::build::{Build, LiveCluster};
use super::container::StoredPages;
use super::vertices::VertexPool;
use super::{Cluster, ClusterError, ClusterFigures, ClusterOptions, Clusters};

/// Levels of each block; at more, vertices of other blocks would be most of those left.
const LEVELS_IN_BLOCKS: usize = 4;
/// Share of the faces that is left after these levels, halved: a face takes half of the memory that it takes elsewhere.
const LEFT_SHARE: f64 = 0.5 / (1 << LEVELS_IN_BLOCKS) as f64;

/// Progress, of 1, at the end of cutting and of the blocks.
const CUT_PROGRESS: f64 = 0.05;
const BLOCKS_PROGRESS: f64 = 0.95;

/// Hierarchy of a file's geometry, with the clusters on disk.
#[derive(Debug)]
#[non_exhaustive]
pub struct StoredClusters {
    /// Sizes of the hierarchy.
    pub figures: ClusterFigures,
    /// Number of faces in the file after cleaning.
    pub n_faces: usize,
    /// Number of blocks.
    pub n_blocks: usize,
    /// Changes made by cleaning, without welded vertices.
    pub counts: CleanCounts,
    // Clusters and groups, without vertices and faces.
    rows: Clusters,
    pages: StoredPages,
}

impl StoredClusters {
    /// Writes the hierarchy as the bytes of an `.nmc` file, and returns their number.
    ///
    /// # Errors
    /// An error of `out` or of the disk.
    pub fn write(&mut self, out: &mut dyn Write) -> std::io::Result<usize> {
        self.pages.write(&self.rows, out)
    }
}

/// Builds the hierarchy of a file's geometry in blocks.
///
/// The result is the same on any number of threads and with any memory, but not that of
/// [`build_clusters`](super::build_clusters).
///
/// # Errors
/// [`ClusterError`]; too little memory is reported before any work.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::{blocks::WorkingSpace, io::Pieces};
/// use neural_mesh::clusters::{ClusterOptions, Clusters, cluster_pieces};
/// let pieces = Pieces::open("tests/meshes/spot.ply".as_ref()).unwrap();
/// let room = WorkingSpace { n_bytes: 1 << 30, folder: "".as_ref() };
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let mut stored = cluster_pieces(&pieces, &ClusterOptions::default(), &room, go_on).unwrap();
/// let mut bytes = Vec::new();
/// stored.write(&mut bytes).unwrap();
/// assert_eq!(Clusters::from_bytes(&bytes).unwrap().roots().len(), 1);
/// ```
pub fn cluster_pieces(
    pieces: &Pieces,
    options: &ClusterOptions,
    room: &WorkingSpace,
    listener: &mut ProgressCallback,
) -> Result<StoredClusters, ClusterError> {
    cluster_with_block_size(FACES_PER_BLOCK, pieces, options, room, listener)
}

fn cluster_with_block_size(
    faces_per_block: usize,
    pieces: &Pieces,
    options: &ClusterOptions,
    room: &WorkingSpace,
    listener: &mut ProgressCallback,
) -> Result<StoredClusters, ClusterError> {
    options.check()?;
    check_room(pieces, LEFT_SHARE, room)?;
    report_progress(listener, 0.0)?;
    let (frame, spooled, n_broken) = cut_file(pieces, faces_per_block, room)?;
    let simplify = ClosedOptions { frame, ..options.simplify.clone() };
    let options = ClusterOptions { simplify, ..options.clone() };
    let mut joined = JoinedBlocks::new(&options, room)?;
    let mut counts = CleanCounts { dropped_faces: n_broken as usize, ..CleanCounts::default() };
    let (mut n_faces, n_blocks) = (0, spooled.n_blocks());
    for number in 0..n_blocks {
        let share_of_block = (BLOCKS_PROGRESS - CUT_PROGRESS) / n_blocks as f64;
        let begin = CUT_PROGRESS + share_of_block * number as f64;
        let StoredBlock { block, counts: of_block, .. } = spooled.read(number)?.map_err(OutOfCoreError::Clean)?;
        counts += of_block;
        let Some(block) = block else { continue };
        n_faces += block.mesh.faces().len();
        joined.add(build_block(block, &options, &mut |done| listener(begin + share_of_block * done))?)?;
    }
    let (rows, pages) = joined.finish(&mut |done| listener(BLOCKS_PROGRESS + (1.0 - BLOCKS_PROGRESS) * done))?;
    Ok(StoredClusters { figures: rows.figures(), n_faces, n_blocks, counts, rows, pages })
}

/// Builds the first levels of a block; `listener` receives the progress of 1.
fn build_block(
    block: Block,
    options: &ClusterOptions,
    listener: &mut ProgressCallback,
) -> Result<Build, SimplifyError> {
    let (pool, faces) = VertexPool::new(&Input::bare(&block.mesh));
    let mut build = Build::new(options, pool);
    // Positions of a cleaned mesh are distinct, so places are its vertices.
    build.held = block.shared;
    build.begin(faces);
    build.add_levels(LEVELS_IN_BLOCKS, &mut |event| listener(f64::from(event.total)))?;
    Ok(build)
}

/// Clusters of all blocks without a group, and the pages of the others.
struct JoinedBlocks {
    build: Build,
    /// Vertices that several blocks use.
    shared: FxHashMap<PositionKey, u32>,
    pages: StoredPages,
}

impl JoinedBlocks {
    fn new(options: &ClusterOptions, room: &WorkingSpace) -> Result<Self, OutOfCoreError> {
        let build = Build::new(options, VertexPool::default());
        Ok(Self { build, shared: FxHashMap::default(), pages: StoredPages::new(room.folder)? })
    }

    fn add(&mut self, mut block: Build) -> Result<(), OutOfCoreError> {
        let (live, held) = (std::mem::take(&mut block.live), std::mem::take(&mut block.held));
        let places = std::mem::take(&mut block.pool.places);
        let made = block.finish();
        self.pages.append(&made, &made.clusters)?;
        let [n_clusters, n_groups] = [self.build.made.clusters.len(), self.build.made.groups.len()].map(|n| n as u32);
        let mut numbers: FxHashMap<u32, u32> = FxHashMap::default();
        let mut number = |vertex: u32| {
            *numbers.entry(vertex).or_insert_with(|| {
                let position = made.positions[vertex as usize];
                let mut add = || self.build.pool.add_bare(position);
                match held.get(places[vertex as usize] as usize) {
                    Some(true) => *self.shared.entry(position_key(position)).or_insert_with(add),
                    _ => add(),
                }
            })
        };
        for LiveCluster { number: cluster, mut faces, .. } in live {
            faces.iter_mut().for_each(|face| face.corners = face.corners.map(&mut number));
            let ancestors = AncestorLists::default();
            self.build.live.push(LiveCluster { number: n_clusters + cluster, faces, ancestors });
        }
        let moved = |group: Option<u32>| group.map(|group| n_groups + group);
        let rows = made.clusters.into_iter().map(|cluster| Cluster {
            source: moved(cluster.source),
            group: moved(cluster.group),
            first_vertex: 0,
            first_face: 0,
            ..cluster
        });
        self.build.made.clusters.extend(rows);
        self.build.made.groups.extend(made.groups);
        Ok(())
    }

    /// Adds the further levels, and returns clusters and groups without vertices and faces.
    fn finish(mut self, listener: &mut ProgressCallback) -> Result<(Clusters, StoredPages), OutOfCoreError> {
        if self.build.live.is_empty() {
            return Err(SimplifyError::Empty.into());
        }
        let n_stored = self.build.made.clusters.len();
        self.build.add_levels(usize::MAX, &mut |event| listener(f64::from(event.total)))?;
        let made = self.build.finish();
        self.pages.append(&made, &made.clusters[n_stored..])?;
        let Clusters { origin, clusters, groups, .. } = made;
        Ok((Clusters { origin, clusters, groups, ..Clusters::default() }, self.pages))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clusters::ViewPoint;
    use crate::clusters::tests::assert_sound_with_one_root;
    use crate::io::{Format, write};
    use crate::mesh::{Frame, TriMesh, edges, shapes, topology};
    use crate::metrics::{Surface, surface_distance};
    use std::ops::ControlFlow;

    fn build_stored(mesh: &TriMesh, faces_per_block: usize) -> (StoredClusters, Vec<u8>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ply");
        std::fs::write(&path, write(mesh, &Frame::default(), Format::Ply).unwrap()).unwrap();
        let room = WorkingSpace { n_bytes: 1 << 30, folder: folder.path() };
        let pieces = Pieces::open(&path).unwrap();
        let mut heard = 0.0;
        let listener = &mut |done| {
            assert!((heard..=1.0).contains(&done), "{heard} {done}");
            heard = done;
            ControlFlow::Continue(())
        };
        let options = ClusterOptions::default();
        let mut stored = cluster_with_block_size(faces_per_block, &pieces, &options, &room, listener).unwrap();
        let mut bytes = Vec::new();
        assert_eq!(stored.write(&mut bytes).unwrap(), bytes.len());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        (stored, bytes)
    }

    #[test]
    fn cuts_across_blocks_are_closed_and_as_near_as_told() {
        let mesh = shapes::wavy_sphere(6, 9.0);
        let (stored, bytes) = build_stored(&mesh, 8000);
        assert!(stored.n_blocks > 8 && stored.n_faces == mesh.faces().len());
        let clusters = Clusters::from_bytes(&bytes).unwrap();
        assert_sound_with_one_root(&clusters, &ClusterOptions::default());
        assert_eq!(clusters.figures(), stored.figures);
        let (whole, _) = clusters.mesh_of(&clusters.cut_at_error(-1.0));
        assert_eq!(topology(&whole), topology(&mesh));
        for step in 0..20 {
            let eye = [3.0 * (step as f32).cos(), 3.0 * (step as f32).sin(), 0.5];
            let view = ViewPoint { eye, pixels: 1000.0, near: 0.01 };
            let (cut, _) = clusters.mesh_of(&clusters.cut_for_view(&view, 0.05 * 1.4f64.powi(step)));
            assert!(edges(&cut).iter().all(|edge| edge.n_faces() == 2), "{step}");
        }
        for error in [1e-3, 1e-2] {
            let (cut, _) = clusters.mesh_of(&clusters.cut_at_error(error));
            assert!(cut.faces().len() < mesh.faces().len() / 2);
            let [a, b] = [&mesh, &cut].map(|mesh| Surface::new(mesh, 20_000, 0));
            let measured = surface_distance(&a, &b).unwrap().both.max;
            assert!(measured <= error && measured > 0.1 * error, "{measured} {error}");
        }
    }

    #[test]
    fn the_number_of_threads_does_not_change_a_byte() {
        let mesh = shapes::torus(160, 80, 1.0, 0.4);
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let [one, three] = [1, 3].map(|n| pool(n).install(|| build_stored(&mesh, 4000).1));
        assert!(one == three);
    }

    #[test]
    fn one_block_has_the_levels_of_a_mesh_in_memory() {
        let mesh = shapes::torus(80, 40, 1.0, 0.4);
        let (stored, _) = build_stored(&mesh, 1 << 19);
        let go_on = &mut |_| ControlFlow::Continue(());
        let whole = crate::clusters::build_clusters(&Input::bare(&mesh), &ClusterOptions::default(), go_on).unwrap();
        assert_eq!((stored.n_blocks, stored.figures), (1, whole.figures()));
    }
}
