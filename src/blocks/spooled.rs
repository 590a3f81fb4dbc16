//! The triangles of blocks on the disk: runs of a few thousand with the positions they use, each once.

use std::io::{Error, ErrorKind, Result};
use std::path::Path;

use rustc_hash::{FxHashMap, FxHashSet};

use super::block::Block;
use super::plan::Plan;
use crate::io::{Spool, Triangle};
use crate::mesh::cleanup::{CleanCounts, CleanError, CleanOptions, clean};
use crate::mesh::{PositionKey, RawMesh, TriMesh, position_key};

/// Positions of a run at most.
const RUN: usize = 2048;

/// Blocks on their way to the disk.
#[derive(Debug)]
pub struct Spooled {
    spool: Spool,
    plan: Plan,
    open: Vec<Run>,
}

/// What is not yet on the disk of a block.
#[derive(Clone, Debug, Default)]
struct Run {
    positions: Vec<[f32; 3]>,
    numbers: FxHashMap<PositionKey, u16>,
    faces: Vec<[u16; 3]>,
    /// Positions of this block that faces of others use.
    told: Vec<[f32; 3]>,
}

/// A block read back, and what was cleaned of it.
pub struct Read {
    /// Nothing where no face is left.
    pub block: Option<Block>,
    /// Vertices that are counted here and nowhere else.
    pub n_own_vertices: usize,
    /// What was cleaned.
    pub counts: CleanCounts,
}

/// A block as it was put on the disk.
struct Gathered {
    positions: Vec<[f32; 3]>,
    faces: Vec<[u32; 3]>,
    /// Places in it that faces of others use.
    told: FxHashSet<PositionKey>,
}

impl Spooled {
    /// Nothing yet, on the disk of a folder.
    pub fn new(folder: &Path, plan: Plan) -> Result<Self> {
        let n = plan.n_blocks();
        Ok(Self { spool: Spool::new(folder, n)?, plan, open: vec![Run::default(); n] })
    }

    /// Takes a triangle into its block.
    pub fn push(&mut self, triangle: Triangle) -> Result<()> {
        // It is of the least of the blocks that its corners are of.
        let homes = triangle.map(|corner| self.plan.home(corner));
        let block = homes.into_iter().fold(usize::MAX, usize::min);
        for (home, corner) in homes.into_iter().zip(triangle).filter(|(home, _)| *home != block) {
            self.open[home].told.push(corner);
            self.close_if(home, RUN)?;
        }
        let run = &mut self.open[block];
        let face = triangle.map(|corner| run.number(corner));
        run.faces.push(face);
        self.close_if(block, RUN)
    }

    /// Puts what is left on the disk.
    pub fn close(&mut self) -> Result<()> {
        (0..self.open.len()).try_for_each(|block| self.close_if(block, 1))?;
        self.open = Vec::new();
        Ok(())
    }

    fn close_if(&mut self, block: usize, least: usize) -> Result<()> {
        let run = &mut self.open[block];
        // A triangle has room for three more; positions told lie close to each other and come again and again.
        if run.positions.len() + 3 < least && run.told.len() < least {
            return Ok(());
        }
        run.told.sort_unstable_by_key(|&p| position_key(p));
        run.told.dedup();
        self.spool.append(block, &run.to_bytes())?;
        run.clear();
        Ok(())
    }

    /// Number of blocks.
    pub fn n_blocks(&self) -> usize {
        self.plan.n_blocks()
    }

    fn gathered(&self, number: usize) -> Result<Gathered> {
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        let mut told = FxHashSet::default();
        for piece in self.spool.pieces(number) {
            let run = Run::from_bytes(&piece?).ok_or_else(|| Error::from(ErrorKind::InvalidData))?;
            let start = positions.len() as u32;
            positions.extend(run.positions);
            faces.extend(run.faces.iter().map(|face| face.map(|v| start + u32::from(v))));
            told.extend(run.told.into_iter().map(position_key));
        }
        Ok(Gathered { positions, faces, told })
    }

    /// What a block looks like: as its faces were, but for those with a corner twice; vertices may lie in one place.
    pub fn surface(&self, number: usize) -> Result<TriMesh> {
        let Gathered { positions, mut faces, .. } = self.gathered(number)?;
        faces.retain(|[a, b, c]| a != b && b != c && c != a);
        TriMesh::new(positions, faces).map_err(|_| Error::from(ErrorKind::InvalidData))
    }

    /// A block as its faces are after cleaning.
    pub fn read(&self, number: usize) -> Result<std::result::Result<Read, CleanError>> {
        let Gathered { positions, faces, mut told } = self.gathered(number)?;
        let positions = positions.into_iter().map(|p| p.map(f64::from)).collect();
        let n_told = told.len();
        let nothing = |counts| Read { block: None, n_own_vertices: n_told, counts };
        if faces.is_empty() {
            return Ok(Ok(nothing(CleanCounts::default())));
        }
        Ok(match clean(RawMesh::new(positions, faces), &CleanOptions::default()) {
            Ok(cleaned) => {
                let is_own = |p: &[f32; 3]| self.plan.home(*p) == number;
                let places = cleaned.mesh.positions();
                let shared: Vec<bool> = places.iter().map(|p| !is_own(p) || told.contains(&position_key(*p))).collect();
                let n_own = places.iter().filter(|p| is_own(p)).count();
                for p in places {
                    told.remove(&position_key(*p));
                }
                let counts = CleanCounts { welded_vertices: 0, ..cleaned.counts };
                let block = Some(Block { mesh: cleaned.mesh, shared });
                Ok(Read { block, n_own_vertices: n_own + told.len(), counts })
            }
            Err(CleanError::NoFaces { counts, .. }) => Ok(nothing(CleanCounts { welded_vertices: 0, ..counts })),
            Err(error) => Err(error),
        })
    }
}

impl Run {
    fn number(&mut self, position: [f32; 3]) -> u16 {
        *self.numbers.entry(position_key(position)).or_insert_with(|| {
            self.positions.push(position);
            (self.positions.len() - 1) as u16
        })
    }

    /// Nothing again, in the memory that is there.
    fn clear(&mut self) {
        let Self { positions, numbers, faces, told } = self;
        positions.clear();
        numbers.clear();
        faces.clear();
        told.clear();
    }

    fn to_bytes(&self) -> Vec<u8> {
        let counts = [self.positions.len(), self.faces.len(), self.told.len()];
        let mut bytes = Vec::with_capacity(12 + 12 * (counts[0] + counts[2]) + 6 * counts[1]);
        counts.iter().for_each(|&n| bytes.extend((n as u32).to_le_bytes()));
        let places = self.positions.iter().chain(&self.told);
        places.flatten().for_each(|x| bytes.extend(x.to_le_bytes()));
        self.faces.as_flattened().iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        bytes
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (counts, rest) = bytes.split_at_checked(12)?;
        let count = |i: usize| counts.as_chunks::<4>().0.get(i).map(|n| u32::from_le_bytes(*n) as usize);
        let (n_positions, n_told) = (count(0)?, count(2)?);
        let (places, faces) = rest.split_at_checked(12 * (n_positions + n_told))?;
        let place = |bytes: &[u8; 12]| [0, 4, 8].map(|at| f32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i])));
        let mut positions: Vec<[f32; 3]> = places.as_chunks::<12>().0.iter().map(place).collect();
        let told = positions.split_off(n_positions.min(positions.len()));
        let face = |bytes: &[u8; 6]| [0, 2, 4].map(|at| u16::from_le_bytes([bytes[at], bytes[at + 1]]));
        let faces = faces.as_chunks::<6>().0.iter().map(face).collect();
        Some(Self { positions, faces, told, ..Self::default() })
    }
}
