//! Bytes that are read in order and end early without a panic.

/// Remaining bytes of a compressed view.
pub(super) struct ByteStream<'a>(pub &'a [u8]);

impl<'a> ByteStream<'a> {
    pub fn take(&mut self, n_bytes: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n_bytes)?;
        self.0 = rest;
        Some(taken)
    }

    pub fn take_byte(&mut self) -> Option<u8> {
        let (&byte, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(byte)
    }

    /// Takes a number of up to five bytes, seven bits each, lowest first.
    pub fn take_number(&mut self) -> Option<u32> {
        let mut number = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.take_byte()?;
            number |= u32::from(byte & 127) << shift;
            if byte < 128 {
                break;
            }
        }
        Some(number)
    }
}

/// Returns a difference from the form that stores its sign in the lowest bit.
pub(super) fn undo_zigzag(stored: u32) -> u32 {
    (stored >> 1) ^ (stored & 1).wrapping_neg()
}
