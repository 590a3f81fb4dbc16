//! Decimal numbers in bytes: a short path for what mesh files hold, the crate `fast-float2` for the rest.

/// Powers of ten that `f64` holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// A number and what its text tells about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    /// The value, correctly rounded.
    pub value: f64,
    /// Bytes that the text takes.
    pub length: usize,
    /// Whether the digits say more than `f32` holds: its nearest value, written with as many decimals, would differ.
    pub double: bool,
}

/// The number at the start of `text`; `None` where none starts. `nan`, `inf` and `infinity` are numbers.
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
    if n_digits == 0 || n_digits > 19 || mantissa > 1 << 53 || power.abs() > 22 {
        return parse_any(text, power);
    }
    // Both factors are exact, so one rounding gives the nearest value (Clinger 1990).
    let scale = POWERS[power.unsigned_abs() as usize];
    let size = if power < 0 { mantissa as f64 / scale } else { mantissa as f64 * scale };
    let value = if text[0] == b'-' { -size } else { size };
    Some(Number { value, length: length + n_exponent, double: n_digits > 6 && says_more_than_single(value, power) })
}

/// The unsigned decimal integer that continues `start`, modulo 2^64, and its number of digits.
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

/// The exponent after a mantissa and the bytes it takes; (0, 0) where there is none.
fn exponent(text: &[u8]) -> (i32, usize) {
    let [b'e' | b'E', rest @ ..] = text else { return (0, 0) };
    let signed = usize::from(matches!(rest.first(), Some(b'-' | b'+')));
    let (value, n) = digits(rest.get(signed..).unwrap_or_default(), 0);
    if n == 0 {
        return (0, 0);
    }
    let size = if n > 6 { 1_000_000 } else { value as i32 };
    (if rest[0] == b'-' { -size } else { size }, 1 + signed + n)
}

/// The slow path: any length, any exponent, names of infinities.
fn parse_any(text: &[u8], power: i32) -> Option<Number> {
    let plus = usize::from(text.first() == Some(&b'+') && text.get(1) != Some(&b'-') && text.get(1) != Some(&b'+'));
    let (value, length) = fast_float2::parse_partial::<f64, _>(&text[plus..]).ok()?;
    Some(Number { value, length: plus + length, double: says_more_than_single(value, power) })
}

/// Whether a text with last digit 10^power cannot stand for an `f32`.
fn says_more_than_single(value: f64, power: i32) -> bool {
    let error = (f64::from(value as f32) - value).abs();
    error != 0.0 && value.is_finite() && error > 0.5 * 10f64.powi(power.clamp(-400, 400))
}
