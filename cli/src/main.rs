//! The `neural-mesh` program: arguments in, files out; no algorithm lives here.

fn main() {}
