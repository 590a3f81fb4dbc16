//! Integers as short text: LEB128, deflate, base64; the page's `numbers.js` decodes it.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;

/// Integers to embed in a page.
#[derive(Default)]
pub struct Packed {
    bytes: Vec<u8>,
}

impl Packed {
    /// Appends a number; small ones take fewer bytes.
    pub fn push(&mut self, mut number: u32) {
        while number >= 0x80 {
            self.bytes.push(number as u8 | 0x80);
            number >>= 7;
        }
        self.bytes.push(number as u8);
    }

    /// Appends the difference of two numbers, mapped from 0, -1, 1, -2 to 0, 1, 2, 3.
    pub fn push_difference(&mut self, number: u32, before: u32) {
        let difference = number.wrapping_sub(before) as i32;
        self.push(((difference << 1) ^ (difference >> 31)) as u32);
    }

    /// Returns all numbers as text that needs no escape in HTML.
    pub fn text(&self) -> String {
        pack_bytes(&self.bytes)
    }
}

/// Returns bytes as text that needs no escape in HTML.
pub fn pack_bytes(bytes: &[u8]) -> String {
    let mut deflate = DeflateEncoder::new(Vec::new(), Compression::new(6));
    // Writing to a vector cannot fail.
    let deflated = deflate.write_all(bytes).and_then(|()| deflate.finish());
    STANDARD.encode(deflated.unwrap_or_default())
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::page::check::unpack_numbers;

    pub fn decode_difference(difference: u32, before: u32) -> u32 {
        before.wrapping_add((difference >> 1) ^ (difference & 1).wrapping_neg())
    }

    #[test]
    fn numbers_survive_packing() {
        let numbers = [0, 1, 127, 128, 300, 65_535, 1 << 28, u32::MAX];
        let mut packed = Packed::default();
        numbers.iter().for_each(|&number| packed.push(number));
        assert_eq!(unpack_numbers(&packed.text()), numbers);
        assert_eq!(unpack_numbers(&Packed::default().text()), [0u32; 0]);
    }

    #[test]
    fn differences_survive_packing() {
        let numbers = [5, 5, 4, 70_000, 0, u32::MAX, 1];
        let mut packed = Packed::default();
        let mut before = 0;
        for number in numbers {
            packed.push_difference(number, before);
            before = number;
        }
        let mut before = 0;
        let back = unpack_numbers(&packed.text()).into_iter().map(|difference| {
            before = decode_difference(difference, before);
            before
        });
        assert_eq!(back.collect::<Vec<_>>(), numbers);
    }
}
