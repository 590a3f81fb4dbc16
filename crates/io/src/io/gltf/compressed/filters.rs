//! Filters of `EXT_meshopt_compression`: compact numbers become those that accessors describe, in place.

/// Decodes unit vectors on an octahedron: two coordinates, their maximum, and a fourth number that stays.
pub(super) fn undo_octahedral<const W: usize>(bytes: &mut [u8]) {
    let largest = largest_integer::<W>();
    for vector in bytes.as_chunks_mut::<W>().0.as_chunks_mut::<4>().0 {
        let [x, y, one] = [0, 1, 2].map(|at: usize| read_integer(vector[at]) as f32);
        let z = one - x.abs() - y.abs();
        // Coordinates of the lower half are folded outwards.
        let fold = z.min(0.0);
        let [x, y] = [x, y].map(|coordinate| coordinate + if coordinate >= 0.0 { fold } else { -fold });
        let scale = largest / (x * x + y * y + z * z).sqrt();
        for (target, coordinate) in vector.iter_mut().zip([x, y, z]) {
            *target = write_integer(coordinate * scale);
        }
    }
}

/// Decodes unit quaternions: three components without the largest, then the scale with the largest one's place.
pub(super) fn undo_quaternions(bytes: &mut [u8]) {
    for quaternion in bytes.as_chunks_mut::<2>().0.as_chunks_mut::<4>().0 {
        let [x, y, z, last] = quaternion.map(i16::from_le_bytes);
        let (scale, place) = (f32::from(last | 3), (last & 3) as usize);
        let [x, y, z] = [x, y, z].map(f32::from);
        let w = (scale * scale * 2.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let factor = largest_integer::<2>() / 2f32.sqrt() / scale;
        for (at, component) in [w, x, y, z].into_iter().enumerate() {
            quaternion[(place + at) & 3] = write_integer(component * factor);
        }
    }
}

/// Decodes floats: an exponent of 8 bits over a mantissa of 24, both signed.
pub(super) fn undo_exponents(bytes: &mut [u8]) {
    for number in bytes.as_chunks_mut::<4>().0 {
        let stored = i32::from_le_bytes(*number);
        // The exponent wraps within its eight bits, as in the reference.
        let power = f32::from_bits((((stored >> 24) + 127) as u32) << 23);
        *number = (power * (stored << 8 >> 8) as f32).to_le_bytes();
    }
}

/// Decodes colours from YCoCg, whose scale is the highest bit of alpha.
pub(super) fn undo_colours<const W: usize>(bytes: &mut [u8]) {
    // Colours are unsigned, two numbers of the code signed.
    let mask = (1i32 << (8 * W)) - 1;
    for colour in bytes.as_chunks_mut::<W>().0.as_chunks_mut::<4>().0 {
        let [y, co, cg, alpha] = colour.map(read_integer);
        let (y, alpha) = (y & mask, alpha & mask);
        // All bits up to the highest one of alpha.
        let full = (1i32 << (32 - alpha.leading_zeros())) - 1;
        let opacity = ((alpha << 1) & full) | (alpha & 1);
        let scale = mask as f32 / full as f32;
        for (target, channel) in colour.iter_mut().zip([y + co - cg, y + cg, y - co - cg, opacity]) {
            *target = low_bytes((channel as f32 * scale).round() as i32);
        }
    }
}

/// Returns the largest signed integer of `W` bytes.
fn largest_integer<const W: usize>() -> f32 {
    ((1i32 << (8 * W - 1)) - 1) as f32
}

fn read_integer<const W: usize>(bytes: [u8; W]) -> i32 {
    let mut wide = [0; 4];
    wide[4 - W..].copy_from_slice(&bytes);
    i32::from_le_bytes(wide) >> (32 - 8 * W)
}

fn write_integer<const W: usize>(number: f32) -> [u8; W] {
    low_bytes(number.round() as i32)
}

fn low_bytes<const W: usize>(number: i32) -> [u8; W] {
    let bytes = number.to_le_bytes();
    std::array::from_fn(|at| bytes[at])
}
