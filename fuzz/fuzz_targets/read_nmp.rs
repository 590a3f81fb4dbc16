//! Arbitrary bytes as a progression, with the checksum that they need: an error, or a progression that makes levels.

#![no_main]

use neural_mesh::simplify::Progression;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let content = &bytes[..bytes.len().saturating_sub(8)];
    let bytes = [content, &checksum(content).to_le_bytes()].concat();
    let progression = match Progression::from_bytes(&bytes) {
        Ok(progression) => progression,
        Err(error) => return assert!(!error.to_string().contains(['\n', '\r'])),
    };
    for (n, refined) in [(1, false), (30, false), (30, true), (usize::MAX, true)] {
        let _ = progression.at_vertices(n, refined);
    }
    let _ = progression.at_error(0.1);
    assert!(Progression::from_bytes(&progression.to_bytes()).is_ok());
});

// Mixes words of eight bytes, as the format does.
fn checksum(bytes: &[u8]) -> u64 {
    let mix = |sum: u64, word: u64| (sum ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    let (words, rest) = bytes.as_chunks::<8>();
    let sum = words.iter().fold(bytes.len() as u64, |sum, word| mix(sum, u64::from_le_bytes(*word)));
    rest.iter().fold(sum, |sum, &byte| mix(sum, u64::from(byte)))
}
