//! Entry point and allocator of the program.

use std::process::ExitCode;

use neural_mesh_cli::Bounded;

#[global_allocator]
static BOUNDED: Bounded = Bounded;

fn main() -> ExitCode {
    neural_mesh_cli::run()
}
