//! The program `neural-mesh-bench`.

use std::process::ExitCode;

fn main() -> ExitCode {
    neural_mesh_bench::run()
}
