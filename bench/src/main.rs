//! The program `neural-mesh-bench`; everything is in the library beside it.

use std::process::ExitCode;

fn main() -> ExitCode {
    neural_mesh_bench::run()
}
