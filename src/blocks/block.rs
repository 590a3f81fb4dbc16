//! A block: some faces of a mesh, and which of their vertices others use, too.

use rustc_hash::{FxHashMap, FxHashSet};

use super::FACES;
use super::plan::{Census, Plan};
use crate::mesh::TriMesh;
use crate::model::Weights;
use crate::simplify::{Options, SimplifyError, simplify_piece};

/// Faces of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Its faces, over vertices of its own.
    pub mesh: TriMesh,
    /// Whether each vertex is one of another block, too, n_vertices.
    pub shared: Vec<bool>,
}

/// What became of a block; its shared vertices are where they were.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighter {
    /// The lighter block.
    pub mesh: TriMesh,
    /// Whether each vertex is one of another block, too, n_vertices.
    pub shared: Vec<bool>,
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
    blocks.filter_map(|faces| compacted(mesh, faces, |v| users[v as usize].1)).collect()
}

/// What two vertices in one place have in common.
pub(super) fn key(position: [f32; 3]) -> [u32; 3] {
    position.map(|x| (x + 0.0).to_bits())
}

fn planned(mesh: &TriMesh, n_blocks: usize) -> Plan {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for (p, axis) in mesh.positions().iter().flat_map(|p| [0, 1, 2].map(|axis| (p, axis))) {
        (low[axis], high[axis]) = (low[axis].min(p[axis]), high[axis].max(p[axis]));
    }
    let mut census = Census::new(low, high);
    mesh.positions().iter().for_each(|&p| census.count(p));
    census.plan(n_blocks)
}

/// Faces over the vertices that they use, in the order of these.
fn compacted(mesh: &TriMesh, mut faces: Vec<[u32; 3]>, is_shared: impl Fn(u32) -> bool) -> Option<Block> {
    let mut used: Vec<u32> = faces.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let number: FxHashMap<u32, u32> = used.iter().copied().zip(0..).collect();
    faces.as_flattened_mut().iter_mut().for_each(|v| *v = number[v]);
    let shared = used.iter().map(|&v| is_shared(v)).collect();
    let positions = used.iter().map(|&v| mesh.positions()[v as usize]).collect();
    Some(Block { mesh: TriMesh::new(positions, faces).ok()?, shared })
}

/// Simplifies a block as long as merges cost no more than `price`, squared distance times area in the unit of the mesh; `share` is about
/// the share of the vertices that this leaves in the mean of all blocks. Of `options` the scores, the figure to be near in, creases,
/// seed and frame count.
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
) -> Result<Lighter, SimplifyError> {
    let n_shared = block.shared.iter().filter(|shared| **shared).count();
    let n_vertices = n_shared + (share * block.mesh.positions().len() as f64) as usize;
    let piece = simplify_piece(&block.mesh, &block.shared, (n_vertices, Some(price)), weights, options)?;
    // By where they lie: where faces of a block meet in a vertex alone, that is several vertices of the result.
    let places = block.mesh.positions().iter().zip(&block.shared).filter(|(_, shared)| **shared).map(|(&p, _)| key(p));
    let places: FxHashSet<[u32; 3]> = places.collect();
    let shared = piece.mesh.positions().iter().map(|&p| places.contains(&key(p))).collect();
    Ok(Lighter { mesh: piece.mesh, shared })
}
