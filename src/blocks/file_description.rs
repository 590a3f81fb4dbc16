//! Description of a mesh file larger than memory.

use super::FACES_PER_BLOCK;
use super::block::Block;
use super::out_of_core::{
    OutOfCoreError, ProgressCallback, WorkingSpace, check_room, cut_file, parallel_blocks, report_progress,
};
use super::spooled_blocks::{SpooledBlocks, StoredBlock};
use crate::io::Pieces;
use crate::mesh::cleanup::CleanCounts;
use crate::mesh::{Frame, Topology, TopologyPatch, TopologyPatches};
use crate::parallel;
use crate::simplify::SimplifyError;
use crate::spatial::Bounds;

const CUT_PROGRESS: f64 = 0.5;

/// Topology and extent of the mesh in a file.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FileDescription {
    /// [`Topology`](crate::mesh::topology) of the whole cleaned mesh.
    pub topology: Topology,
    /// Box around all vertices used by faces, in the coordinates of `frame`.
    pub bounds: Bounds,
    /// Local origin of the file's coordinates, and whether the file stores doubles.
    pub frame: Frame,
    /// Changes made by cleaning, without welded vertices.
    pub counts: CleanCounts,
}

/// Describes the geometry of a file, block by block.
///
/// # Errors
/// [`OutOfCoreError`] for an unreadable file, a disk error, too little memory, or a stop by `listener`.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::{blocks::{WorkingSpace, describe_pieces}, io::Pieces};
/// let pieces = Pieces::open("tests/meshes/spot.ply".as_ref()).unwrap();
/// let room = WorkingSpace { n_bytes: 1 << 30, folder: "".as_ref() };
/// let found = describe_pieces(&pieces, &room, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!((found.topology.vertices, found.topology.genus), (2930, Some(0)));
/// ```
pub fn describe_pieces(
    pieces: &Pieces,
    room: &WorkingSpace,
    listener: &mut ProgressCallback,
) -> Result<FileDescription, OutOfCoreError> {
    describe_with_block_size(FACES_PER_BLOCK, pieces, room, listener)
}

fn describe_with_block_size(
    faces_per_block: usize,
    pieces: &Pieces,
    room: &WorkingSpace,
    listener: &mut ProgressCallback,
) -> Result<FileDescription, OutOfCoreError> {
    check_room(pieces, 0.0, room)?;
    report_progress(listener, 0.0)?;
    let (frame, spooled, n_broken) = cut_file(pieces, faces_per_block, room)?;
    let mut counts = CleanCounts { dropped_faces: n_broken as usize, ..CleanCounts::default() };
    let (mut patches, mut bounds) = (TopologyPatches::default(), Bounds::EMPTY);
    let (n_blocks, n_at_once) = (spooled.n_blocks(), parallel_blocks(room));
    for start in (0..n_blocks).step_by(n_at_once) {
        report_progress(listener, CUT_PROGRESS + (1.0 - CUT_PROGRESS) * start as f64 / n_blocks as f64)?;
        let numbers = start..(start + n_at_once).min(n_blocks);
        for found in parallel::each(numbers, |number| block_patch(&spooled, number)) {
            let (cleaned, patch) = found?;
            counts += cleaned;
            let Some((patch, block_bounds)) = patch else { continue };
            patches.add(patch);
            bounds = bounds.union(&block_bounds);
        }
    }
    let topology = patches.count_topology();
    if topology.faces == 0 {
        return Err(SimplifyError::Empty.into());
    }
    Ok(FileDescription { topology, bounds, frame, counts })
}

fn block_patch(
    spooled: &SpooledBlocks,
    number: usize,
) -> Result<(CleanCounts, Option<(TopologyPatch, Bounds)>), OutOfCoreError> {
    let StoredBlock { block, counts, .. } = spooled.read(number)?.map_err(OutOfCoreError::Clean)?;
    let patch = |block: Block| {
        let patch = TopologyPatch::new(&block.mesh, |v| block.shared[v as usize]);
        (patch, Bounds::from_points(block.mesh.positions()))
    };
    Ok((counts, block.map(patch)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{Format, write};
    use crate::mesh::{compact, shapes, topology};
    use std::ops::ControlFlow;

    #[test]
    fn in_blocks_a_file_is_what_it_is_as_a_whole() {
        let sphere = shapes::wavy_sphere(4, 9.0);
        let mut turned = sphere.faces().to_vec();
        turned.iter_mut().step_by(7).for_each(|face| face.swap(0, 1));
        turned.truncate(turned.len() - 9);
        let (ragged, _) = compact(sphere.positions(), turned).unwrap();
        for mesh in [sphere, ragged, shapes::torus(40, 20, 1.0, 0.3), shapes::open_cylinder(40, 20)] {
            let folder = tempfile::tempdir().unwrap();
            let room = WorkingSpace { n_bytes: 1 << 30, folder: folder.path() };
            for format in [Format::Ply, Format::Stl, Format::Obj] {
                let path = folder.path().join(format!("a.{}", format.name()));
                std::fs::write(&path, write(&mesh, &Frame::default(), format).unwrap()).unwrap();
                let pieces = Pieces::open(&path).unwrap();
                let found = describe_with_block_size(150, &pieces, &room, &mut |_| ControlFlow::Continue(())).unwrap();
                assert_eq!(found.topology, topology(&mesh), "{format:?}");
                assert_eq!(found.bounds, Bounds::from_points(mesh.positions()));
            }
        }
    }
}
