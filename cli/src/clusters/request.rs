//! Options of the library from those of the program, and failures from its errors.

use std::ffi::OsString;

use clap::{Parser, ValueEnum};
use neural_mesh::clusters::{ClusterError, ClusterOptions};
use neural_mesh::simplify::{ClosedOptions, SimplifyError};

use crate::args::{ClustersArgs, SimplifyArgs};
use crate::failure::Failure;
use crate::request::{Request, resolve_request};

pub fn create_request(args: &ClustersArgs) -> Result<Request, Failure> {
    // A GLB holds all attributes, so that none is left out.
    let mut words: Vec<OsString> =
        ["simplify", "-o", "-", "--ratio", "50%", "--format", "glb"].map(OsString::from).into();
    let ignored = args.ignore.iter().filter_map(|what| Some(what.to_possible_value()?.get_name().to_string()));
    words.extend(ignored.map(|what| format!("--ignore={what}").into()));
    let effort = args.effort.to_possible_value();
    words.extend(effort.map(|effort| format!("--effort={}", effort.get_name()).into()));
    words.extend(args.memory.map(|gib| format!("--memory={gib}").into()));
    words.extend(["--".into(), args.input.clone().into_os_string()]);
    // The arguments are given to the parser of `simplify`, so that its checks and defaults apply.
    let parsed = SimplifyArgs::try_parse_from(words).map_err(|error| Failure::Usage(error.to_string()))?;
    resolve_request(parsed)
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
