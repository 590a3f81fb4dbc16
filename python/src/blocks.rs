//! Blocks of a mesh, simplified separately by any number of workers.

use std::path::PathBuf;

use neural_mesh::blocks::{self, Block, BlockPrices};
use neural_mesh::io;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::simplify::{ClosedOptions, ScoreSource};
use neural_mesh_cli::embedded::Failure;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::{array, numbers, points, rows, sequence, triples};
use crate::background::run_in_background;
use crate::failure::{invalid_array, to_exception};
use crate::mesh_arrays::MeshArrays;

/// Vertices of a block, n x 3, its faces, n x 3, and for each vertex whether other blocks share it.
#[derive(FromPyObject)]
pub struct BlockArrays<'py>(PyReadonlyArray2<'py, f32>, PyReadonlyArray2<'py, u32>, PyReadonlyArray1<'py, bool>);

type Arrays = (Py<PyAny>, Py<PyAny>, Py<PyAny>);

/// Prices of a block: its vertices, its shared vertices, and pairs of remaining vertices and last price.
type BlockPriceTuple = (usize, usize, Vec<(usize, f64)>);

impl BlockArrays<'_> {
    fn block(&self) -> PyResult<Block> {
        let Self(positions, faces, shared) = self;
        let mesh = TriMesh::new(points(positions, "vertices")?, rows(faces, "faces")?.to_vec());
        let mesh = mesh.map_err(|error| invalid_array(error.to_string()))?;
        let shared = numbers(shared, "shared")?.to_vec();
        if shared.len() != mesh.positions().len() {
            return Err(invalid_array(format!("shared: {} values: give one for each vertex", shared.len())));
        }
        Ok(Block { mesh, shared })
    }
}

fn arrays(py: Python, block: Block) -> PyResult<Arrays> {
    let (positions, faces) = block.mesh.into_parts();
    Ok((array(py, positions)?, triples(py, faces)?, sequence(py, block.shared)))
}

fn options(scores: &str) -> PyResult<ClosedOptions> {
    let scores = match scores {
        "bending" => ScoreSource::Bending,
        "geometry" => ScoreSource::Geometry,
        "network" => ScoreSource::Network,
        _ => return Err(to_exception(&Failure::Usage(format!("scores: {scores}: give bending, network or geometry")))),
    };
    Ok(ClosedOptions { scores, ..ClosedOptions::default() })
}

/// Cuts a mesh or a file into blocks; returns these in local coordinates, their origin, and the number of vertices.
#[pyfunction]
pub fn cut(py: Python, path: Option<PathBuf>, mesh: Option<MeshArrays>) -> PyResult<(Vec<Arrays>, [f64; 3], usize)> {
    let given = mesh.map(|mesh| mesh.read()).transpose()?.map(|read| read.mesh);
    let (found, frame, n) = run_in_background(py, None, None, move |_| {
        let path = path.unwrap_or_default();
        let failed = |error: &dyn std::fmt::Display| Failure::Failed(format!("{}: {error}", path.display()));
        let read = || io::read_path(&path, None).map_err(|error| failed(&error));
        let raw = given.map_or_else(read, Ok)?;
        let cleaned = clean(raw, &CleanOptions::default()).map_err(|error| failed(&error))?;
        Ok((blocks::cut(&cleaned.mesh), cleaned.frame, cleaned.mesh.positions().len()))
    })?;
    Ok((found.into_iter().map(|block| arrays(py, block)).collect::<PyResult<_>>()?, frame.origin, n))
}

/// Simplifies a block to a share of its vertices and returns the prices paid.
#[pyfunction]
pub fn sample_block(
    py: Python,
    block: BlockArrays,
    share: f64,
    scores: &str,
    threads: Option<usize>,
) -> PyResult<BlockPriceTuple> {
    let (block, options) = (block.block()?, options(scores)?);
    let sample =
        run_in_background(py, threads, None, move |_| Ok(blocks::sample_block(&block, share, None, &options)?))?;
    Ok((sample.n_vertices, sample.n_shared, sample.pass_prices))
}

/// Returns the price at which all blocks together keep this share.
#[pyfunction]
pub fn price_for(samples: Vec<BlockPriceTuple>, share: f64) -> f64 {
    let samples: Vec<BlockPrices> =
        samples.into_iter().map(|(n, n_shared, pass_prices)| BlockPrices::new(n, n_shared, pass_prices)).collect();
    blocks::price_for(&samples, share)
}

/// Simplifies a block by all merges that cost at most `price`.
#[pyfunction]
pub fn simplify_block(
    py: Python,
    block: BlockArrays,
    share: f64,
    price: f64,
    scores: &str,
    threads: Option<usize>,
) -> PyResult<Arrays> {
    let (block, options) = (block.block()?, options(scores)?);
    let simplified = run_in_background(py, threads, None, move |_| {
        Ok(blocks::simplify_block(&block, share, price, None, &options)?)
    })?;
    arrays(py, simplified)
}

/// Joins blocks into one mesh at their shared vertices.
#[pyfunction]
pub fn join(py: Python, blocks: Vec<BlockArrays>) -> PyResult<(Py<PyAny>, Py<PyAny>)> {
    let blocks: Vec<Block> = blocks.iter().map(BlockArrays::block).collect::<PyResult<_>>()?;
    let joined = blocks::join(blocks).map_err(|error| invalid_array(error.to_string()))?;
    let (positions, faces) = joined.into_parts();
    Ok((array(py, positions)?, triples(py, faces)?))
}
