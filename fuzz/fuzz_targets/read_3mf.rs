//! Arbitrary bytes as 3MF, and as the model inside a 3MF file.

#![no_main]

use std::io::{Cursor, Write};

use neural_mesh::io::Format;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    neural_mesh_fuzz::check(bytes, Format::ThreeMf);
    neural_mesh_fuzz::check(&package(bytes), Format::ThreeMf);
});

fn package(model: &[u8]) -> Vec<u8> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    archive.start_file("3D/3dmodel.model", options).unwrap();
    archive.write_all(model).unwrap();
    archive.finish().unwrap().into_inner()
}
