//! Damaged copies of a file, which Bevy has to refuse.

use crate::content::HEAD;
use crate::server::Server;

/// A copy, and a part of the message with which Bevy refuses it.
struct DamagedCopy {
    name: &'static str,
    bytes: Vec<u8>,
    message: &'static str,
}

/// Loads damaged copies of a file; returns their number.
///
/// # Errors
/// Message about a copy that Bevy reads, or refuses for another reason.
pub fn check_damaged_copies(server: &mut Server, bytes: &[u8]) -> Result<usize, String> {
    let copies = damage(bytes);
    for copy in &copies {
        let DamagedCopy { name, message, .. } = copy;
        match server.load(&copy.bytes) {
            Ok(_) => return Err(format!("Bevy reads a copy with {name}")),
            Err(error) if error.contains(message) => {}
            Err(error) => return Err(format!("a copy with {name} is refused, but not with \"{message}\": {error}")),
        }
    }
    Ok(copies.len())
}

fn damage(bytes: &[u8]) -> Vec<DamagedCopy> {
    let cut_at = |name, length: usize, message| DamagedCopy { name, bytes: bytes[..length].to_vec(), message };
    let with_byte = |name, at: usize, message| {
        let mut bytes = bytes.to_vec();
        bytes[at] ^= 1;
        DamagedCopy { name, bytes, message }
    };
    vec![
        cut_at("no byte", 0, "unexpected end of file"),
        cut_at("half of a head", HEAD / 2, "unexpected end of file"),
        cut_at("a head alone", HEAD, "failed to fill whole buffer"),
        cut_at("half of the content", bytes.len() / 2, "failed to fill whole buffer"),
        // The end mark of the frame has four bytes, which Bevy does not read.
        cut_at("one byte of content too few", bytes.len() - 5, "failed to fill whole buffer"),
        with_byte("a wrong magic number", 0, "file was not a MeshletMesh asset"),
        with_byte("a wrong version", 8, "expected asset version 3 but found version 2"),
        with_byte("a wrong magic number of LZ4", HEAD, "WrongMagicNumber"),
    ]
}
