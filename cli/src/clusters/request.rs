//! Options of the library from those of the program, and failures from its errors.

use neural_mesh::clusters::{ClusterError, ClusterOptions};
use neural_mesh::job::{Arguments, RatioOf};
use neural_mesh::simplify::{ClosedOptions, SimplifyError};

use crate::args::ClustersArgs;
use crate::failure::Failure;
use crate::memory;
use crate::names::refuse_progression;
use crate::request::Request;

pub fn create_request(args: &ClustersArgs) -> Result<Request, Failure> {
    refuse_progression(&args.input)?;
    // A GLB holds all attributes, so that none is left out.
    let arguments = Arguments {
        ratio: vec![RatioOf { name: None, share: 0.5 }],
        ignore: args.ignore.clone(),
        effort: args.effort,
        ..Arguments::default()
    };
    memory::limit_memory(args.memory);
    let request = Request::without_output(&args.input, Some("glb"), &arguments)?;
    Ok(Request { memory: args.memory.map(memory::gib_to_bytes), ..request })
}

pub fn cluster_options(args: &ClustersArgs, simplify: ClosedOptions) -> ClusterOptions {
    let &ClustersArgs { max_faces, max_vertices, clusters_per_group, .. } = args;
    ClusterOptions { max_faces, max_vertices, clusters_per_group, simplify }
}

pub fn to_failure(args: &ClustersArgs, error: ClusterError) -> Failure {
    match error {
        ClusterError::Simplify(SimplifyError::Interrupted) => Failure::Interrupted,
        ClusterError::BadSize { .. } => Failure::Usage(error.to_string()),
        error => Failure::in_file(&args.input, error),
    }
}
