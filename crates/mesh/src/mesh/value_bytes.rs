//! Values as bytes of a file: packing, and reading that checks every length before it takes memory.
//!
//! Numbers are little endian. A list is its length (`u64`) and its elements; text is a list of UTF-8 bytes; an option is
//! a byte, 0 or 1, and then the value.

use glam::{DMat4, Vec3};

use super::{Attributes, Channel, Frame, Role};

/// Value with a fixed form as bytes.
pub trait Stored: Sized {
    /// Least number of bytes of a value.
    const LEAST: usize;

    fn write(&self, bytes: &mut Vec<u8>);

    /// Reads a value; `None` if the bytes end or are none.
    fn read(from: &mut ByteReader) -> Option<Self>;
}

pub struct ByteReader<'a> {
    pub rest: &'a [u8],
}

impl ByteReader<'_> {
    /// Reads `n` values without their number.
    pub fn read_rows<T: Stored>(&mut self, n: usize) -> Option<Vec<T>> {
        // The length is checked before memory is taken for it.
        if n > self.rest.len() / T::LEAST {
            return None;
        }
        let mut values = Vec::with_capacity(n);
        for _ in 0..n {
            values.push(T::read(self)?);
        }
        Some(values)
    }
}

/// Writes values without their number.
pub fn write_rows<T: Stored>(values: &[T], bytes: &mut Vec<u8>) {
    bytes.reserve(values.len() * T::LEAST);
    values.iter().for_each(|value| value.write(bytes));
}

macro_rules! store_numbers {
    ($($number:ty),*) => {$(
        impl Stored for $number {
            const LEAST: usize = size_of::<Self>();

            fn write(&self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }

            fn read(from: &mut ByteReader) -> Option<Self> {
                let (number, rest) = from.rest.split_first_chunk()?;
                from.rest = rest;
                Some(Self::from_le_bytes(*number))
            }
        }
    )*};
}
store_numbers!(u8, u16, u32, u64, f32, f64);

/// Stores each of the listed values as a byte, its first place in the list; a later place is of a value that is gone.
#[doc(hidden)]
#[macro_export]
macro_rules! store_choices {
    ($($choice:ty: [$($value:expr),*];)*) => {$(
        impl $crate::mesh::value_bytes::Stored for $choice {
            const LEAST: usize = 1;

            fn write(&self, bytes: &mut Vec<u8>) {
                bytes.push([$($value),*].iter().position(|value| value == self).map_or(u8::MAX, |i| i as u8));
            }

            fn read(from: &mut $crate::mesh::value_bytes::ByteReader) -> Option<Self> {
                let (choices, i) = ([$($value),*], usize::from(<u8 as $crate::mesh::value_bytes::Stored>::read(from)?));
                let first = |value: &Self| choices.iter().position(|other| other == value);
                choices.get(i).copied().filter(|value| first(value) == Some(i))
            }
        }
    )*};
}
pub use store_choices;
store_choices! {
    bool: [false, true];
    Role: [Role::Normal, Role::Tangent, Role::Uv, Role::Colour, Role::Skin, Role::MorphPosition, Role::MorphDirection,
        Role::Other, Role::Label];
}

/// Stores a struct by its fields, in this order.
#[doc(hidden)]
#[macro_export]
macro_rules! store_fields {
    ($($whole:ident { $($field:ident: $part:ty),* } $(..$others:expr)?;)*) => {$(
        impl $crate::mesh::value_bytes::Stored for $whole {
            const LEAST: usize = 0 $(+ <$part as $crate::mesh::value_bytes::Stored>::LEAST)*;

            fn write(&self, bytes: &mut Vec<u8>) {
                $($crate::mesh::value_bytes::Stored::write(&self.$field, bytes);)*
            }

            fn read(from: &mut $crate::mesh::value_bytes::ByteReader) -> Option<Self> {
                Some(Self {
                    $($field: <$part as $crate::mesh::value_bytes::Stored>::read(from)?,)*
                    $(..$others)?
                })
            }
        }
    )*};
}
pub use store_fields;
store_fields! {
    Vec3 { x: f32, y: f32, z: f32 };
    Channel { name: String, role: Role, width: usize, values: Vec<f32> };
    Attributes { wedges: Vec<[u32; 3]>, channels: Vec<Channel>, groups: Vec<u32> };
    Frame { origin: [f64; 3], double: bool };
}

impl Stored for usize {
    const LEAST: usize = 8;

    fn write(&self, bytes: &mut Vec<u8>) {
        (*self as u64).write(bytes);
    }

    fn read(from: &mut ByteReader) -> Option<Self> {
        Self::try_from(u64::read(from)?).ok()
    }
}

impl<T: Stored + Default, const N: usize> Stored for [T; N] {
    const LEAST: usize = N * T::LEAST;

    fn write(&self, bytes: &mut Vec<u8>) {
        self.iter().for_each(|value| value.write(bytes));
    }

    fn read(from: &mut ByteReader) -> Option<Self> {
        // A closure cannot leave the function.
        let mut n_read = 0;
        let values = std::array::from_fn(|_| T::read(from).inspect(|_| n_read += 1).unwrap_or_default());
        (n_read == N).then_some(values)
    }
}

/// Writes a list: its length and its elements.
pub fn write_list<T: Stored>(values: &[T], bytes: &mut Vec<u8>) {
    values.len().write(bytes);
    write_rows(values, bytes);
}

impl<T: Stored> Stored for Vec<T> {
    const LEAST: usize = 8;

    fn write(&self, bytes: &mut Vec<u8>) {
        write_list(self, bytes);
    }

    fn read(from: &mut ByteReader) -> Option<Self> {
        let n = usize::read(from)?;
        from.read_rows(n)
    }
}

impl Stored for DMat4 {
    const LEAST: usize = <[f64; 16]>::LEAST;

    fn write(&self, bytes: &mut Vec<u8>) {
        self.to_cols_array().write(bytes);
    }

    fn read(from: &mut ByteReader) -> Option<Self> {
        Stored::read(from).map(|columns| Self::from_cols_array(&columns))
    }
}

impl<T: Stored> Stored for Option<T> {
    const LEAST: usize = 1;

    fn write(&self, bytes: &mut Vec<u8>) {
        self.is_some().write(bytes);
        self.iter().for_each(|value| value.write(bytes));
    }

    fn read(from: &mut ByteReader) -> Option<Self> {
        if bool::read(from)? { T::read(from).map(Some) } else { Some(None) }
    }
}

impl<A: Stored, B: Stored> Stored for (A, B) {
    const LEAST: usize = A::LEAST + B::LEAST;

    fn write(&self, bytes: &mut Vec<u8>) {
        self.0.write(bytes);
        self.1.write(bytes);
    }

    fn read(from: &mut ByteReader) -> Option<Self> {
        Some((A::read(from)?, B::read(from)?))
    }
}

impl Stored for String {
    const LEAST: usize = 8;

    fn write(&self, bytes: &mut Vec<u8>) {
        write_list(self.as_bytes(), bytes);
    }

    fn read(from: &mut ByteReader) -> Option<Self> {
        Self::from_utf8(Vec::read(from)?).ok()
    }
}
