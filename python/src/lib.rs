//! neural-mesh for Python: converts arrays to meshes and back; all algorithms are in the library.
//!
//! This is the private module `neural_mesh._native` of the Python package `neural_mesh/`.

mod arrays;
mod background;
mod blocks;
mod compare;
mod failure;
mod learn;
mod mesh_arrays;
mod network;
mod plain;
mod points;
mod progression;
mod record;
mod simplify;
mod values;

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("NeuralMeshError", py.get_type::<failure::NeuralMeshError>())?;
    module.add("OptionError", py.get_type::<failure::OptionError>())?;
    module.add_class::<simplify::Outcome>()?;
    module.add_class::<simplify::ResultArrays>()?;
    module.add_class::<plain::PlainResult>()?;
    module.add_class::<points::Meshed>()?;
    module.add_class::<progression::Progression>()?;
    module.add_class::<record::Record>()?;
    module.add_function(wrap_pyfunction!(simplify::simplify, module)?)?;
    module.add_function(wrap_pyfunction!(plain::simplify_plain, module)?)?;
    module.add_function(wrap_pyfunction!(progression::progression, module)?)?;
    module.add_function(wrap_pyfunction!(progression::read_progression, module)?)?;
    module.add_function(wrap_pyfunction!(compare::compare, module)?)?;
    module.add_function(wrap_pyfunction!(points::mesh_points, module)?)?;
    module.add_function(wrap_pyfunction!(record::record, module)?)?;
    module.add_function(wrap_pyfunction!(learn::train, module)?)?;
    module.add_function(wrap_pyfunction!(learn::estimate, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::cut, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::sample_block, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::price_for, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::simplify_block, module)?)?;
    module.add_function(wrap_pyfunction!(blocks::join, module)?)?;
    network::add(module)
}
