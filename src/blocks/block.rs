//! Blocks of a mesh.

use rustc_hash::FxHashSet;

use super::FACES_PER_BLOCK;
use super::plan::{BlockPlan, Census};
use crate::mesh::{PositionKey, TriMesh, compact, position_key};
use crate::model::Weights;
use crate::simplify::{ClosedOptions, SimplifiedBlock, SimplifyError, asked_scores, simplify_block_mesh};
use crate::spatial::Bounds;

/// Faces of a mesh in one box, with marks on vertices shared with other blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Faces over the block's own vertices.
    pub mesh: TriMesh,
    /// True if another block uses the vertex, n_vertices.
    pub shared: Vec<bool>,
}

impl Block {
    /// Returns the target size: a share of the vertices, plus the shared ones, which stay.
    pub(super) fn target_vertices(&self, share: f64) -> usize {
        self.n_shared() + (share * self.mesh.positions().len() as f64) as usize
    }

    /// Simplifies to a share of the vertices, or by merges that cost at most `price`; shared vertices stay.
    pub(super) fn simplify(
        &self,
        share: f64,
        price: Option<f64>,
        weights: Option<&Weights>,
        options: &ClosedOptions,
    ) -> Result<SimplifiedBlock, SimplifyError> {
        let scores = asked_scores(options.scores, &self.mesh, weights);
        simplify_block_mesh(&self.mesh, &self.shared, (self.target_vertices(share), price), &scores, options)
    }

    pub(super) fn n_shared(&self) -> usize {
        self.shared.iter().filter(|shared| **shared).count()
    }
}

/// Cuts a mesh in memory into blocks of about [`FACES_PER_BLOCK`] faces.
///
/// ```
/// use neural_mesh::{blocks::cut, mesh::shapes};
/// let sphere = shapes::icosphere(3);
/// let blocks = cut(&sphere);
/// assert_eq!((blocks.len(), &blocks[0].mesh), (1, &sphere));
/// ```
pub fn cut(mesh: &TriMesh) -> Vec<Block> {
    cut_into_blocks(mesh, mesh.faces().len().div_ceil(FACES_PER_BLOCK))
}

pub(super) fn cut_into_blocks(mesh: &TriMesh, n_blocks: usize) -> Vec<Block> {
    let plan = plan_blocks(mesh, n_blocks);
    let mut faces: Vec<Vec<[u32; 3]>> = vec![Vec::new(); plan.n_blocks()];
    let homes: Vec<u32> = mesh.positions().iter().map(|&p| plan.block_at(p) as u32).collect();
    // An entry has the first block that uses the vertex, and true if another block uses it too.
    let mut users: Vec<(u32, bool)> = vec![(u32::MAX, false); homes.len()];
    for &face in mesh.faces() {
        let block = face.map(|v| homes[v as usize]).into_iter().fold(u32::MAX, u32::min);
        faces[block as usize].push(face);
        for v in face {
            let (first, others) = &mut users[v as usize];
            (*first, *others) = if *first == u32::MAX { (block, false) } else { (*first, *others || *first != block) };
        }
    }
    let blocks = faces.into_iter().filter(|faces| !faces.is_empty());
    let block = |faces| {
        let (mesh, sources) = compact(mesh.positions(), faces).ok()?;
        Some(Block { mesh, shared: sources.iter().map(|&v| users[v as usize].1).collect() })
    };
    blocks.filter_map(block).collect()
}

fn plan_blocks(mesh: &TriMesh, n_blocks: usize) -> BlockPlan {
    let Bounds { low, high } = Bounds::from_points(mesh.positions());
    let mut census = Census::new(low, high);
    mesh.positions().iter().for_each(|&p| census.count(p));
    census.plan(n_blocks)
}

/// Simplifies a block with merges that cost at most `price`; shared vertices stay.
///
/// `price` is a squared distance times area; `share` is the expected share of remaining vertices over all blocks. Creases
/// are kept; other `options` of what to keep, drop or return have no effect, and the purpose decides about scores only.
///
/// # Errors
/// As for [`simplify`](crate::simplify::simplify).
///
/// ```
/// use neural_mesh::{blocks::{Block, simplify_block}, mesh::shapes};
/// use neural_mesh::simplify::ClosedOptions;
/// let mesh = shapes::icosphere(5);
/// let shared = mesh.positions().iter().map(|p| p[2] == 0.0).collect();
/// let options = ClosedOptions::default();
/// let simplified_blocks = simplify_block(&Block { mesh, shared }, 0.1, 1e-9, None, &options).unwrap();
/// assert!(simplified_blocks.mesh.positions().len() < 5000 && simplified_blocks.shared.contains(&true));
/// ```
pub fn simplify_block(
    block: &Block,
    share: f64,
    price: f64,
    weights: Option<&Weights>,
    options: &ClosedOptions,
) -> Result<Block, SimplifyError> {
    let piece = block.simplify(share, Some(price), weights, options)?;
    // Shared vertices are found by position: a vertex whose faces form several fans becomes several vertices.
    let places =
        block.mesh.positions().iter().zip(&block.shared).filter(|(_, shared)| **shared).map(|(&p, _)| position_key(p));
    let places: FxHashSet<PositionKey> = places.collect();
    let shared = piece.mesh.positions().iter().map(|&p| places.contains(&position_key(p))).collect();
    Ok(Block { mesh: piece.mesh, shared })
}
