//! A block: some faces of a mesh, and which of their vertices others use, too.

use rustc_hash::FxHashSet;

use super::FACES;
use super::plan::{Census, Plan};
use crate::mesh::{PositionKey, TriMesh, compact, position_key};
use crate::model::Weights;
use crate::simplify::{Options, SimplifyError, simplify_block_mesh};
use crate::spatial::Bounds;

/// Faces of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Its faces, over vertices of its own.
    pub mesh: TriMesh,
    /// Whether each vertex is one of another block, too, n_vertices.
    pub shared: Vec<bool>,
}

impl Block {
    /// A share of its vertices, beside those that are shared and stay.
    pub(super) fn n_left(&self, share: f64) -> usize {
        self.n_shared() + (share * self.mesh.positions().len() as f64) as usize
    }

    /// Its vertices that others use, too.
    pub(super) fn n_shared(&self) -> usize {
        self.shared.iter().filter(|shared| **shared).count()
    }
}

/// The blocks of a mesh in memory, with about [`FACES`] faces each.
///
/// ```
/// use neural_mesh::{blocks::cut, mesh::shapes};
/// let sphere = shapes::icosphere(3);
/// let blocks = cut(&sphere);
/// assert_eq!((blocks.len(), &blocks[0].mesh), (1, &sphere));
/// ```
pub fn cut(mesh: &TriMesh) -> Vec<Block> {
    cut_into(mesh, mesh.faces().len().div_ceil(FACES))
}

/// About so many blocks.
pub(super) fn cut_into(mesh: &TriMesh, n_blocks: usize) -> Vec<Block> {
    let plan = planned(mesh, n_blocks);
    let mut faces: Vec<Vec<[u32; 3]>> = vec![Vec::new(); plan.n_blocks()];
    let homes: Vec<u32> = mesh.positions().iter().map(|&p| plan.home(p) as u32).collect();
    // The block that a vertex was first used by, and whether another one does.
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

fn planned(mesh: &TriMesh, n_blocks: usize) -> Plan {
    let Bounds { low, high } = Bounds::from_points(mesh.positions());
    let mut census = Census::new(low, high);
    mesh.positions().iter().for_each(|&p| census.count(p));
    census.plan(n_blocks)
}

/// Simplifies a block, whose shared vertices stay where they are, as long as merges cost no more than `price`, squared distance
/// times area in the unit of the mesh; `share` is about the share of the vertices that this leaves in the mean of all blocks. Of
/// `options` the scores, the figure to be near in, creases, seed and frame count.
///
/// # Errors
/// [`SimplifyError`] as of [`simplify`](crate::simplify::simplify).
///
/// ```
/// use neural_mesh::{blocks::{Block, simplify_block}, mesh::shapes};
/// use neural_mesh::simplify::{Options, Target};
/// let mesh = shapes::icosphere(5);
/// let shared = mesh.positions().iter().map(|p| p[2] == 0.0).collect();
/// let options = Options::new(Target::Ratio(0.1));
/// let lighter = simplify_block(&Block { mesh, shared }, 0.1, 1e-9, None, &options).unwrap();
/// assert!(lighter.mesh.positions().len() < 5000 && lighter.shared.contains(&true));
/// ```
pub fn simplify_block(
    block: &Block,
    share: f64,
    price: f64,
    weights: Option<&Weights>,
    options: &Options,
) -> Result<Block, SimplifyError> {
    let asked = (block.n_left(share), Some(price));
    let piece = simplify_block_mesh(&block.mesh, &block.shared, asked, weights, options)?;
    // By where they lie: where faces of a block meet in a vertex alone, that is several vertices of the result.
    let places =
        block.mesh.positions().iter().zip(&block.shared).filter(|(_, shared)| **shared).map(|(&p, _)| position_key(p));
    let places: FxHashSet<PositionKey> = places.collect();
    let shared = piece.mesh.positions().iter().map(|&p| places.contains(&position_key(p))).collect();
    Ok(Block { mesh: piece.mesh, shared })
}
