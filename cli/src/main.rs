//! The program: its allocator, and what the library of the same package does with the words of the command line.

use std::process::ExitCode;

use neural_mesh_cli::Bounded;

#[global_allocator]
static BOUNDED: Bounded = Bounded;

fn main() -> ExitCode {
    neural_mesh_cli::run()
}
