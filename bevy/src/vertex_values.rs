//! Vertex attributes as rows of `f32`, and back in their format.

use bevy_mesh::{VertexAttributeValues as Values, VertexFormat};
use half::f16;

/// Reads an attribute as floats; returns its width and its values, n_vertices x width.
///
/// Normalised integers become the numbers that shaders see. `None` for integers, which cannot be interpolated.
pub fn read_floats(values: &Values) -> Option<(usize, Vec<f32>)> {
    fn map<T: Copy>(width: usize, values: &[T], float: impl Fn(T) -> f32) -> Option<(usize, Vec<f32>)> {
        Some((width, values.iter().map(|&value| float(value)).collect()))
    }
    // The least signed value is -128 or -32768, which graphics interfaces read as -1.
    let snorm8 = |x: i8| (f32::from(x) / 127.0).max(-1.0);
    let snorm16 = |x: i16| (f32::from(x) / 32767.0).max(-1.0);
    let unorm8 = |x: u8| f32::from(x) / 255.0;
    let unorm16 = |x: u16| f32::from(x) / 65535.0;
    match values {
        Values::Float32(values) => Some((1, values.clone())),
        Values::Float32x2(values) => Some((2, values.as_flattened().to_vec())),
        Values::Float32x3(values) => Some((3, values.as_flattened().to_vec())),
        Values::Float32x4(values) => Some((4, values.as_flattened().to_vec())),
        Values::Float16(values) => map(1, values, f16::to_f32),
        Values::Float16x2(values) => map(2, values.as_flattened(), f16::to_f32),
        Values::Float16x4(values) => map(4, values.as_flattened(), f16::to_f32),
        Values::Float64(values) => map(1, values, |x| x as f32),
        Values::Float64x2(values) => map(2, values.as_flattened(), |x| x as f32),
        Values::Float64x3(values) => map(3, values.as_flattened(), |x| x as f32),
        Values::Float64x4(values) => map(4, values.as_flattened(), |x| x as f32),
        Values::Unorm8(values) => map(1, values, unorm8),
        Values::Unorm8x2(values) => map(2, values.as_flattened(), unorm8),
        Values::Unorm8x4(values) | Values::Unorm8x4Bgra(values) => map(4, values.as_flattened(), unorm8),
        Values::Snorm8(values) => map(1, values, snorm8),
        Values::Snorm8x2(values) => map(2, values.as_flattened(), snorm8),
        Values::Snorm8x4(values) => map(4, values.as_flattened(), snorm8),
        Values::Unorm16(values) => map(1, values, unorm16),
        Values::Unorm16x2(values) => map(2, values.as_flattened(), unorm16),
        Values::Unorm16x4(values) => map(4, values.as_flattened(), unorm16),
        Values::Snorm16(values) => map(1, values, snorm16),
        Values::Snorm16x2(values) => map(2, values.as_flattened(), snorm16),
        Values::Snorm16x4(values) => map(4, values.as_flattened(), snorm16),
        _ => None,
    }
}

/// Writes floats, n_vertices x width, in a format that [`read_floats`] reads; `None` for other formats.
pub fn write_floats(format: VertexFormat, floats: Vec<f32>) -> Option<Values> {
    fn map<const N: usize, T>(floats: &[f32], to: impl Fn(f32) -> T) -> Vec<[T; N]> {
        floats.as_chunks::<N>().0.iter().map(|row| row.map(&to)).collect()
    }
    fn flat<T>(floats: &[f32], to: impl Fn(f32) -> T) -> Vec<T> {
        floats.iter().map(|&float| to(float)).collect()
    }
    // Casts of floats to integers saturate.
    let snorm8 = |x: f32| (x.clamp(-1.0, 1.0) * 127.0).round() as i8;
    let snorm16 = |x: f32| (x.clamp(-1.0, 1.0) * 32767.0).round() as i16;
    let unorm8 = |x: f32| (x * 255.0).round() as u8;
    let unorm16 = |x: f32| (x * 65535.0).round() as u16;
    Some(match format {
        VertexFormat::Float32 => Values::Float32(floats),
        VertexFormat::Float32x2 => Values::Float32x2(floats.as_chunks().0.to_vec()),
        VertexFormat::Float32x3 => Values::Float32x3(floats.as_chunks().0.to_vec()),
        VertexFormat::Float32x4 => Values::Float32x4(floats.as_chunks().0.to_vec()),
        VertexFormat::Float16 => Values::Float16(flat(&floats, f16::from_f32)),
        VertexFormat::Float16x2 => Values::Float16x2(map(&floats, f16::from_f32)),
        VertexFormat::Float16x4 => Values::Float16x4(map(&floats, f16::from_f32)),
        VertexFormat::Float64 => Values::Float64(flat(&floats, f64::from)),
        VertexFormat::Float64x2 => Values::Float64x2(map(&floats, f64::from)),
        VertexFormat::Float64x3 => Values::Float64x3(map(&floats, f64::from)),
        VertexFormat::Float64x4 => Values::Float64x4(map(&floats, f64::from)),
        VertexFormat::Unorm8 => Values::Unorm8(flat(&floats, unorm8)),
        VertexFormat::Unorm8x2 => Values::Unorm8x2(map(&floats, unorm8)),
        VertexFormat::Unorm8x4 => Values::Unorm8x4(map(&floats, unorm8)),
        VertexFormat::Unorm8x4Bgra => Values::Unorm8x4Bgra(map(&floats, unorm8)),
        VertexFormat::Snorm8 => Values::Snorm8(flat(&floats, snorm8)),
        VertexFormat::Snorm8x2 => Values::Snorm8x2(map(&floats, snorm8)),
        VertexFormat::Snorm8x4 => Values::Snorm8x4(map(&floats, snorm8)),
        VertexFormat::Unorm16 => Values::Unorm16(flat(&floats, unorm16)),
        VertexFormat::Unorm16x2 => Values::Unorm16x2(map(&floats, unorm16)),
        VertexFormat::Unorm16x4 => Values::Unorm16x4(map(&floats, unorm16)),
        VertexFormat::Snorm16 => Values::Snorm16(flat(&floats, snorm16)),
        VertexFormat::Snorm16x2 => Values::Snorm16x2(map(&floats, snorm16)),
        VertexFormat::Snorm16x4 => Values::Snorm16x4(map(&floats, snorm16)),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_comes_back_as_it_was() {
        let half = |x: f32| f16::from_f32(x);
        let all = [
            Values::Float32(vec![0.5, -2.0]),
            Values::Float32x2(vec![[0.5, 1.0]]),
            Values::Float32x3(vec![[0.5, 1.0, 2.0]]),
            Values::Float32x4(vec![[0.5, 1.0, 2.0, 3.0]]),
            Values::Float16(vec![half(0.1)]),
            Values::Float16x2(vec![[0.1, 0.2].map(half)]),
            Values::Float16x4(vec![[0.1, 0.2, 0.3, 0.4].map(half)]),
            Values::Float64(vec![0.5]),
            Values::Float64x2(vec![[0.5, 1.0]]),
            Values::Float64x3(vec![[0.5, 1.0, 2.0]]),
            Values::Float64x4(vec![[0.5, 1.0, 2.0, 3.0]]),
            Values::Unorm8((0..=255).collect()),
            Values::Unorm8x2(vec![[0, 255]]),
            Values::Unorm8x4(vec![[1, 2, 3, 4]]),
            Values::Unorm8x4Bgra(vec![[1, 2, 3, 4]]),
            Values::Snorm8((-127..=127).collect()),
            Values::Snorm8x2(vec![[-127, 127]]),
            Values::Snorm8x4(vec![[1, -2, 3, -4]]),
            Values::Unorm16((0..=65535).collect()),
            Values::Unorm16x2(vec![[0, 65535]]),
            Values::Unorm16x4(vec![[1, 2, 3, 4]]),
            Values::Snorm16((-32767..=32767).collect()),
            Values::Snorm16x2(vec![[-32767, 32767]]),
            Values::Snorm16x4(vec![[1, -2, 3, -4]]),
        ];
        for values in all {
            let (width, floats) = read_floats(&values).unwrap();
            assert_eq!(floats.len(), width * values.len());
            assert_eq!(write_floats(VertexFormat::from(&values), floats), Some(values));
        }
        assert_eq!(read_floats(&Values::Uint32(vec![7])), None);
        assert_eq!(write_floats(VertexFormat::Uint32, vec![7.0]), None);
    }

    #[test]
    fn normalised_integers_are_what_shaders_see() {
        assert_eq!(read_floats(&Values::Snorm8(vec![-128, -127, 0, 127])), Some((1, vec![-1.0, -1.0, 0.0, 1.0])));
        assert_eq!(write_floats(VertexFormat::Unorm8, vec![-1.0, 2.0, 0.5]), Some(Values::Unorm8(vec![0, 255, 128])));
    }
}
