//! What a mesh file that does not fit into memory is as a surface.

use rayon::prelude::*;

use super::FACES;
use super::block::Block;
use super::out_of_core::{Heard, OutOfCoreError, Room, at_once, check_room, cut, heard};
use super::spooled::{Read, Spooled};
use crate::io::Pieces;
use crate::mesh::cleanup::CleanCounts;
use crate::mesh::{Frame, Topology, TopologyPatch, TopologyPatches};
use crate::simplify::SimplifyError;
use crate::spatial::Bounds;

/// A share of the time after which a mesh is cut into blocks.
const CUT: f64 = 0.5;

/// What a file is.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Described {
    /// As [`topology`](crate::mesh::topology) of the whole, cleaned.
    pub topology: Topology,
    /// The box around all vertices that faces use, in the coordinates of `frame`.
    pub bounds: Bounds,
    /// How coordinates lie in the file.
    pub frame: Frame,
    /// What was cleaned; vertices in one place, which each block counts for itself, are not told.
    pub counts: CleanCounts,
}

/// Describes the geometry of a file block by block, which wait on the disk.
///
/// # Errors
/// [`OutOfCoreError`]: what cannot be read, a disk that fails, too little memory, or by `listener`.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::{blocks::{Room, describe_pieces}, io::Pieces};
/// let pieces = Pieces::open("tests/meshes/spot.ply".as_ref()).unwrap();
/// let room = Room { n_bytes: 1 << 30, folder: "".as_ref() };
/// let found = describe_pieces(&pieces, &room, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!((found.topology.vertices, found.topology.genus), (2930, Some(0)));
/// ```
pub fn describe_pieces(pieces: &Pieces, room: &Room, listener: &mut Heard) -> Result<Described, OutOfCoreError> {
    in_blocks_of(FACES, pieces, room, listener)
}

/// The same, with blocks of about so many faces.
fn in_blocks_of(
    faces_of_block: usize,
    pieces: &Pieces,
    room: &Room,
    listener: &mut Heard,
) -> Result<Described, OutOfCoreError> {
    check_room(pieces, 0.0, room)?;
    heard(listener, 0.0)?;
    let n_faces = usize::try_from(pieces.n_faces()).unwrap_or(usize::MAX);
    let (frame, spooled, n_broken) = cut(pieces, n_faces.div_ceil(faces_of_block).max(1), room)?;
    let mut counts = CleanCounts { dropped_faces: n_broken as usize, ..CleanCounts::default() };
    let (mut patches, mut bounds) = (TopologyPatches::default(), Bounds::EMPTY);
    let (n_blocks, n_at_once) = (spooled.n_blocks(), at_once(room));
    for start in (0..n_blocks).step_by(n_at_once) {
        heard(listener, CUT + (1.0 - CUT) * start as f64 / n_blocks as f64)?;
        let numbers = start..(start + n_at_once).min(n_blocks);
        let found: Vec<_> = numbers.into_par_iter().map(|number| patch(&spooled, number)).collect();
        for found in found {
            let (of_block, patch) = found?;
            counts += of_block;
            let Some((patch, of_block)) = patch else { continue };
            patches.add(patch);
            bounds = bounds.union(&of_block);
        }
    }
    let topology = patches.count_topology();
    if topology.faces == 0 {
        return Err(SimplifyError::Empty.into());
    }
    Ok(Described { topology, bounds, frame, counts })
}

/// What was cleaned of a block, and what is left of it, with the box around it.
fn patch(spooled: &Spooled, number: usize) -> Result<(CleanCounts, Option<(TopologyPatch, Bounds)>), OutOfCoreError> {
    let Read { block, counts, .. } = spooled.read(number)?.map_err(OutOfCoreError::Clean)?;
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
            let room = Room { n_bytes: 1 << 30, folder: folder.path() };
            for format in [Format::Ply, Format::Stl, Format::Obj] {
                let path = folder.path().join(format!("a.{}", format.name()));
                std::fs::write(&path, write(&mesh, &Frame::default(), format).unwrap()).unwrap();
                let pieces = Pieces::open(&path).unwrap();
                let found = in_blocks_of(150, &pieces, &room, &mut |_| ControlFlow::Continue(())).unwrap();
                assert_eq!(found.topology, topology(&mesh), "{format:?}");
                assert_eq!(found.bounds, Bounds::from_points(mesh.positions()));
            }
        }
    }
}
