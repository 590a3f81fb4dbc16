//! Figures packed as integers for `points.js` of the page.

use neural_mesh_cli::shared::page::Packed;

// Number of low bits that are dropped; 12 bits of the mantissa stay.
const DROPPED: u32 = 11;

pub fn pack_values(values: &[Option<f32>]) -> String {
    let mut packed = Packed::default();
    values.iter().for_each(|value| {
        // A missing value is written as 0, any other as its upper 21 bits plus 1.
        packed.push(value.filter(|value| value.is_finite()).map_or(0, |value| 1 + round_bits(value)))
    });
    packed.text()
}

fn round_bits(value: f32) -> u32 {
    let up = value.to_bits() + (1 << (DROPPED - 1));
    (if f32::from_bits(up).is_finite() { up } else { value.to_bits() }) >> DROPPED
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_page::unpack_numbers;

    #[test]
    fn values_come_back_with_three_digits() {
        let values = [0.0, 1.0, -2.5, 1234.5, 1e-7, 0.999_99, f32::MAX, -f32::MAX, 1e-42];
        let packed = pack_values(&values.map(Some));
        let back = unpack_numbers(&packed).into_iter().map(|number| f32::from_bits((number - 1) << DROPPED));
        for (found, wanted) in back.zip(values) {
            assert!((found - wanted).abs() <= wanted.abs() / 4000.0 + 1e-41, "{found} is not {wanted}");
        }
        assert_eq!(unpack_numbers(&super::pack_values(&[None, Some(f32::NAN), Some(f32::INFINITY)])), [0, 0, 0]);
    }
}
