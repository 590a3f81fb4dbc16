//! Arbitrary bytes as STL.

#![no_main]

use neural_mesh::io::Format;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| neural_mesh_fuzz::check(bytes, Format::Stl));
