//! Number types of file columns.

use super::write::push_single;

/// Type of a number in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// Signed, one byte.
    I8,
    /// Unsigned, one byte.
    U8,
    /// Signed, two bytes.
    I16,
    /// Unsigned, two bytes.
    U16,
    /// Signed, four bytes.
    I32,
    /// Unsigned, four bytes.
    U32,
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

/// Types in their order, with their names in a PLY and their bytes.
const TYPES: [(Scalar, [&str; 2], usize); 8] = [
    (Scalar::I8, ["char", "int8"], 1),
    (Scalar::U8, ["uchar", "uint8"], 1),
    (Scalar::I16, ["short", "int16"], 2),
    (Scalar::U16, ["ushort", "uint16"], 2),
    (Scalar::I32, ["int", "int32"], 4),
    (Scalar::U32, ["uint", "uint32"], 4),
    (Scalar::F32, ["float", "float32"], 4),
    (Scalar::F64, ["double", "float64"], 8),
];

impl Scalar {
    pub(super) fn from_name(name: &str) -> Option<Self> {
        TYPES.iter().find(|(_, names, _)| names.contains(&name)).map(|row| row.0)
    }

    pub(super) fn size(self) -> usize {
        TYPES[self as usize].2
    }

    /// Returns the name that is written.
    pub(super) fn name(self) -> &'static str {
        TYPES[self as usize].1[0]
    }

    pub(super) fn decode(self, bytes: &[u8], big: bool) -> Option<f64> {
        let mut raw = [0; 8];
        let size = self.size();
        let value = raw.get_mut(..size)?;
        value.copy_from_slice(bytes.get(..size)?);
        if big {
            value.reverse();
        }
        let bits = u64::from_le_bytes(raw);
        Some(match self {
            Self::I8 => f64::from(bits as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as i16),
            Self::U16 => f64::from(bits as u16),
            Self::I32 => f64::from(bits as i32),
            Self::U32 => f64::from(bits as u32),
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        })
    }

    /// Returns the largest number of an integer type, or 1.
    #[cfg(feature = "gltf")]
    pub(super) fn largest(self) -> f64 {
        self.to_integer(f64::INFINITY).map_or(1.0, |largest| largest as f64)
    }

    pub(super) fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Returns whether single precision cannot represent every value.
    pub(super) fn is_wide(self) -> bool {
        matches!(self, Self::F64 | Self::I32 | Self::U32)
    }

    /// Returns the nearest number of an integer type, or `None` for other types.
    fn to_integer(self, value: f64) -> Option<i64> {
        let whole = value.round();
        Some(match self {
            Self::I8 => i64::from(whole as i8),
            Self::U8 => i64::from(whole as u8),
            Self::I16 => i64::from(whole as i16),
            Self::U16 => i64::from(whole as u16),
            Self::I32 => i64::from(whole as i32),
            Self::U32 => i64::from(whole as u32),
            Self::F32 | Self::F64 => return None,
        })
    }

    /// Appends a value as little-endian bytes; integers are rounded and clamped.
    pub(super) fn push_bytes(self, out: &mut Vec<u8>, value: f64) {
        match (self, self.to_integer(value)) {
            (_, Some(integer)) => out.extend_from_slice(&integer.to_le_bytes()[..self.size()]),
            (Self::F32, _) => out.extend((value as f32).to_le_bytes()),
            _ => out.extend(value.to_le_bytes()),
        }
    }

    pub(super) fn push_text(self, out: &mut Vec<u8>, value: f64) {
        match self.to_integer(value) {
            Some(integer) => out.extend(itoa::Buffer::new().format(integer).as_bytes()),
            None => push_single(out, value as f32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Scalar;

    #[test]
    fn whole_numbers_are_rounded_and_held_in_range() {
        for (kind, value, expected) in [
            (Scalar::U8, 254.6, 255.0),
            (Scalar::U8, 300.0, 255.0),
            (Scalar::U8, -3.0, 0.0),
            (Scalar::I8, -128.4, -128.0),
            (Scalar::I16, 2.5, 3.0),
            (Scalar::U16, 7e4, 65_535.0),
            (Scalar::I32, -5e9, -2_147_483_648.0),
            (Scalar::U32, 4e9, 4e9),
            (Scalar::F32, 0.1, f64::from(0.1f32)),
            (Scalar::F64, 0.1, 0.1),
        ] {
            let (mut bytes, mut text) = (Vec::new(), Vec::new());
            kind.push_bytes(&mut bytes, value);
            kind.push_text(&mut text, value);
            assert_eq!((bytes.len(), kind.decode(&bytes, false)), (kind.size(), Some(expected)), "{kind:?}");
            let said: f64 = std::str::from_utf8(&text).unwrap().parse().unwrap();
            assert_eq!(said as f32, expected as f32, "{kind:?}");
            assert_eq!(Scalar::from_name(kind.name()), Some(kind));
        }
    }
}
