//! Parser of decimal numbers: a fast path for most, the crate `fast-float2` for the rest.

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    pub value: f64,
    pub length: usize,
    // True if the digits need a double: the nearest single, written with as many decimals, would differ.
    pub double: bool,
}

/// Parses the number at the start of `text`, including `nan` and `inf`.
pub(super) fn parse(text: &[u8]) -> Option<Number> {
    let signed = usize::from(matches!(text.first(), Some(b'-' | b'+')));
    let (whole, n_whole) = digits(text.get(signed..)?, 0);
    let mut length = signed + n_whole;
    let (mut mantissa, mut n_decimals) = (whole, 0);
    if text.get(length) == Some(&b'.') {
        (mantissa, n_decimals) = digits(&text[length + 1..], whole);
        length += 1 + n_decimals;
    }
    let n_digits = n_whole + n_decimals;
    let (exponent, n_exponent) = exponent(&text[length..]);
    let power = exponent - n_decimals as i32;
    // Trailing zeros of a whole number may be padding, so they do not count as digits.
    let n_zeros =
        if n_decimals > 0 { 0 } else { text[..length].iter().rev().take_while(|&&byte| byte == b'0').count() };
    let last_digit = power.saturating_add(n_zeros as i32);
    // The fast path needs a mantissa and a power that doubles represent exactly.
    if n_digits == 0 || n_digits > 19 || mantissa > 1 << 53 || power.abs() > 22 {
        return parse_any(text, last_digit);
    }
    // Both factors are exact, so one rounding gives the nearest value (Clinger 1990).
    let scale = POWERS[power.unsigned_abs() as usize];
    let size = if power < 0 { mantissa as f64 / scale } else { mantissa as f64 * scale };
    let value = if text[0] == b'-' { -size } else { size };
    Some(Number {
        value,
        length: length + n_exponent,
        double: n_digits > 6 && exceeds_single_precision(value, last_digit),
    })
}

fn digits(text: &[u8], start: u64) -> (u64, usize) {
    let mut value = start;
    for (i, &byte) in text.iter().enumerate() {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return (value, i);
        }
        value = value.wrapping_mul(10).wrapping_add(u64::from(digit));
    }
    (value, text.len())
}

fn exponent(text: &[u8]) -> (i32, usize) {
    let [b'e' | b'E', rest @ ..] = text else { return (0, 0) };
    let signed = usize::from(matches!(rest.first(), Some(b'-' | b'+')));
    let (value, n) = digits(rest.get(signed..).unwrap_or_default(), 0);
    if n == 0 {
        return (0, 0);
    }
    // Six digits exceed any exponent of a double; more would overflow.
    let size = if n > 6 { 1_000_000 } else { value as i32 };
    (if rest[0] == b'-' { -size } else { size }, 1 + signed + n)
}

fn parse_any(text: &[u8], last_digit: i32) -> Option<Number> {
    let plus = usize::from(text.first() == Some(&b'+') && text.get(1) != Some(&b'-') && text.get(1) != Some(&b'+'));
    let (value, length) = fast_float2::parse_partial::<f64, _>(&text[plus..]).ok()?;
    Some(Number { value, length: plus + length, double: exceeds_single_precision(value, last_digit) })
}

/// Returns whether a number whose last digit counts 10^last_digit cannot be the text of an `f32`.
fn exceeds_single_precision(value: f64, last_digit: i32) -> bool {
    let error = (f64::from(value as f32) - value).abs();
    // The tolerance is half of the last digit, and the rounding of the value itself.
    let tolerance = || 0.5 * 10f64.powi(last_digit.clamp(-400, 400)) + value.abs() * f64::EPSILON;
    error != 0.0 && value.is_finite() && error > tolerance()
}

#[cfg(test)]
mod tests {
    use super::parse;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_the_standard_library(value in prop::num::f64::NORMAL | prop::num::f64::ZERO, decimals in 0usize..25) {
            for text in [format!("{value}"), format!("{value:e}"), format!("{value:.decimals$e}"), format!("{:.decimals$}", value % 1e6)] {
                let number = parse(text.as_bytes()).unwrap();
                prop_assert_eq!(number.value.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{}", text);
                prop_assert_eq!(number.length, text.len());
            }
        }

        #[test]
        fn single_precision_never_looks_like_double(bits in any::<u32>(), decimals in 0usize..18) {
            let value = f32::from_bits(bits);
            prop_assume!(value.is_finite());
            for text in [format!("{value}"), format!("{value:e}"), format!("{value:.decimals$e}")] {
                prop_assert!(!parse(text.as_bytes()).unwrap().double || text.parse::<f32>().unwrap().is_infinite(), "{}", text);
            }
        }
    }

    #[test]
    fn digits_beyond_single_precision_are_noticed() {
        for (text, double) in
            [("5123456.789", true), ("0.1", false), ("123456.7", false), ("1e39", true), ("1e-40", false)]
        {
            assert_eq!(parse(text.as_bytes()).unwrap().double, double, "{text}");
        }
    }

    #[test]
    fn odd_texts() {
        for (text, value, length) in [
            ("+1.5 ", 1.5, 4),
            (".5", 0.5, 2),
            ("5.", 5.0, 2),
            ("1e", 1.0, 1),
            ("-2.e1x", -20.0, 5),
            ("+.5e-3", 0.0005, 6),
            ("1e400", f64::INFINITY, 5),
            ("1e-999999999999", 0.0, 15),
            ("inf", f64::INFINITY, 3),
            ("-Infinity", f64::NEG_INFINITY, 9),
        ] {
            let number = parse(text.as_bytes()).unwrap();
            assert_eq!((number.value, number.length), (value, length), "{text}");
        }
        assert!(parse(b"nan").unwrap().value.is_nan());
        for text in ["", "-", "+", ".", "e5", "+-1", "++1", "x", "-e"] {
            assert_eq!(parse(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn four_hundred_digits() {
        let text = "1".repeat(200) + "." + &"3".repeat(200);
        assert_eq!(parse(text.as_bytes()).unwrap().value, text.parse::<f64>().unwrap());
    }
}
