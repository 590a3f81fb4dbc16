//! Blocks on disk.

use std::io::{Error, ErrorKind, Result};
use std::path::Path;

use rustc_hash::{FxHashMap, FxHashSet};

use super::block::Block;
use super::plan::BlockPlan;
use crate::io::{Spool, Triangle};
use crate::mesh::cleanup::{CleanCounts, CleanError, CleanOptions, clean};
use crate::mesh::value_bytes::{ByteReader, Stored, write_list};
use crate::mesh::{PositionKey, RawMesh, TriMesh, position_key};

/// Largest number of a block's positions in memory before they are appended to its spool as one run.
const MAX_RUN_POSITIONS: usize = 2048;

/// Blocks of a file, on disk.
#[derive(Debug)]
pub struct SpooledBlocks {
    spool: Spool,
    plan: BlockPlan,
    open: Vec<BlockRun>,
}

#[derive(Clone, Debug, Default)]
struct BlockRun {
    positions: Vec<[f32; 3]>,
    numbers: FxHashMap<PositionKey, u16>,
    faces: Vec<[u16; 3]>,
    // Positions in this block used by faces of other blocks.
    used_elsewhere: Vec<[f32; 3]>,
}

pub struct StoredBlock {
    // `None` if no face is left.
    pub block: Option<Block>,
    // Number of vertices counted for this block and not for another one.
    pub n_own_vertices: usize,
    pub counts: CleanCounts,
}

struct RawBlock {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    // Positions in the block used by faces of other blocks.
    used_elsewhere: FxHashSet<PositionKey>,
}

impl SpooledBlocks {
    pub fn new(folder: &Path, plan: BlockPlan) -> Result<Self> {
        let n = plan.n_blocks();
        Ok(Self { spool: Spool::new(folder, n)?, plan, open: vec![BlockRun::default(); n] })
    }

    pub fn push(&mut self, triangle: Triangle) -> Result<()> {
        // A triangle belongs to the lowest of its corners' blocks.
        let homes = triangle.map(|corner| self.plan.block_at(corner));
        let block = homes.into_iter().fold(usize::MAX, usize::min);
        for (home, corner) in homes.into_iter().zip(triangle).filter(|(home, _)| *home != block) {
            self.open[home].used_elsewhere.push(corner);
            self.flush_if(home, MAX_RUN_POSITIONS)?;
        }
        let run = &mut self.open[block];
        let face = triangle.map(|corner| run.number(corner));
        run.faces.push(face);
        self.flush_if(block, MAX_RUN_POSITIONS)
    }

    pub fn close(&mut self) -> Result<()> {
        (0..self.open.len()).try_for_each(|block| self.flush_if(block, 1))?;
        self.open = Vec::new();
        Ok(())
    }

    fn flush_if(&mut self, block: usize, least: usize) -> Result<()> {
        let run = &mut self.open[block];
        // The run stays in memory while it has room for the three positions of another triangle.
        if run.positions.len() + 3 < least && run.used_elsewhere.len() < least {
            return Ok(());
        }
        // Each triangle of another block lists its shared corners, so positions repeat.
        run.used_elsewhere.sort_unstable_by_key(|&p| position_key(p));
        run.used_elsewhere.dedup();
        self.spool.append(block, &run.to_bytes())?;
        run.clear();
        Ok(())
    }

    pub fn n_blocks(&self) -> usize {
        self.plan.n_blocks()
    }

    fn read_raw(&self, number: usize) -> Result<RawBlock> {
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        let mut used_elsewhere = FxHashSet::default();
        for piece in self.spool.pieces(number) {
            let run = BlockRun::from_bytes(&piece?).ok_or_else(|| Error::from(ErrorKind::InvalidData))?;
            let start = positions.len() as u32;
            positions.extend(run.positions);
            faces.extend(run.faces.iter().map(|face| face.map(|v| start + u32::from(v))));
            used_elsewhere.extend(run.used_elsewhere.into_iter().map(position_key));
        }
        Ok(RawBlock { positions, faces, used_elsewhere })
    }

    /// Reads a block's surface without faces that repeat a corner; positions may repeat.
    pub fn surface(&self, number: usize) -> Result<TriMesh> {
        let RawBlock { positions, mut faces, .. } = self.read_raw(number)?;
        faces.retain(|[a, b, c]| a != b && b != c && c != a);
        TriMesh::new(positions, faces).map_err(|_| Error::from(ErrorKind::InvalidData))
    }

    pub fn read(&self, number: usize) -> Result<std::result::Result<StoredBlock, CleanError>> {
        let RawBlock { positions, faces, mut used_elsewhere } = self.read_raw(number)?;
        let positions = positions.into_iter().map(|p| p.map(f64::from)).collect();
        let n_used_elsewhere = used_elsewhere.len();
        let nothing = |counts| StoredBlock { block: None, n_own_vertices: n_used_elsewhere, counts };
        if faces.is_empty() {
            return Ok(Ok(nothing(CleanCounts::default())));
        }
        Ok(match clean(RawMesh::new(positions, faces), &CleanOptions::default()) {
            Ok(cleaned) => {
                let is_own = |p: &[f32; 3]| self.plan.block_at(*p) == number;
                let places = cleaned.mesh.positions();
                let shared: Vec<bool> =
                    places.iter().map(|p| !is_own(p) || used_elsewhere.contains(&position_key(*p))).collect();
                let n_own = places.iter().filter(|p| is_own(p)).count();
                for p in places {
                    used_elsewhere.remove(&position_key(*p));
                }
                let counts = CleanCounts { welded_vertices: 0, ..cleaned.counts };
                let block = Some(Block { mesh: cleaned.mesh, shared });
                Ok(StoredBlock { block, n_own_vertices: n_own + used_elsewhere.len(), counts })
            }
            Err(CleanError::NoFaces { counts, .. }) => Ok(nothing(CleanCounts { welded_vertices: 0, ..counts })),
            Err(error) => Err(error),
        })
    }
}

impl BlockRun {
    fn number(&mut self, position: [f32; 3]) -> u16 {
        *self.numbers.entry(position_key(position)).or_insert_with(|| {
            self.positions.push(position);
            (self.positions.len() - 1) as u16
        })
    }

    fn clear(&mut self) {
        let Self { positions, numbers, faces, used_elsewhere } = self;
        positions.clear();
        numbers.clear();
        faces.clear();
        used_elsewhere.clear();
    }

    fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_list(&self.positions, &mut bytes);
        write_list(&self.faces, &mut bytes);
        write_list(&self.used_elsewhere, &mut bytes);
        bytes
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut from = ByteReader { rest: bytes };
        let (positions, faces, used_elsewhere) = (Vec::read(&mut from)?, Vec::read(&mut from)?, Vec::read(&mut from)?);
        Some(Self { positions, faces, used_elsewhere, ..Self::default() })
    }
}
