//! Entry point and allocator of the program.

use std::process::ExitCode;

use neural_mesh_cli::BoundedAllocator;

#[global_allocator]
static ALLOCATOR: BoundedAllocator = BoundedAllocator;

fn main() -> ExitCode {
    neural_mesh_cli::run()
}
