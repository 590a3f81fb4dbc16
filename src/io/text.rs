//! A cursor over the bytes of a text file: blanks, lines, words and numbers, with no assumption about the encoding.

use super::ReadError;
use super::number;

/// Where reading has come to in a text.
#[derive(Clone)]
pub(super) struct Text<'a> {
    /// The whole file, so that errors can count lines.
    bytes: &'a [u8],
    /// Bytes read so far.
    at: usize,
    /// Whether a number said more than `f32` holds.
    pub double: bool,
    /// Whether a backslash before a line's end joins it to the next.
    continued: bool,
}

impl<'a> Text<'a> {
    /// A cursor at the start of `bytes`, behind a byte order mark.
    pub fn new(bytes: &'a [u8]) -> Self {
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { bytes, at, double: false, continued: false }
    }

    /// The same cursor, for a format in which a backslash continues a line.
    pub fn with_continuation(self) -> Self {
        Self { continued: true, ..self }
    }

    /// The same cursor, moved to the byte `at`.
    pub fn starting_at(self, at: usize) -> Self {
        Self { at: at.min(self.bytes.len()), ..self }
    }

    /// An error at the line of the cursor.
    pub fn error(&self, what: impl Into<String>, remedy: &str) -> ReadError {
        ReadError::line(self.bytes, self.at, what, remedy)
    }

    /// What is left.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// Whether nothing is left.
    pub fn is_at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// Moves by `n` bytes.
    pub fn advance(&mut self, n: usize) {
        self.at = (self.at + n).min(self.bytes.len());
    }

    /// Moves over spaces and tabs (and continued line ends).
    pub fn skip_blanks(&mut self) {
        loop {
            match self.rest() {
                [b' ' | b'\t' | b'\x0b' | b'\x0c' | b'\0', ..] => self.at += 1,
                [b'\\', b'\r', b'\n', ..] if self.continued => self.at += 3,
                [b'\\', b'\n' | b'\r', ..] if self.continued => self.at += 2,
                _ => return,
            }
        }
    }

    /// Moves over blanks, line ends and comments that start with `#`.
    pub fn skip_space(&mut self) {
        loop {
            self.skip_blanks();
            match self.rest() {
                [b'\n' | b'\r', ..] => self.at += 1,
                [b'#', ..] => self.skip_line(),
                _ => return,
            }
        }
    }

    /// Moves behind the next line end.
    pub fn skip_line(&mut self) {
        self.at = memchr::memchr2(b'\n', b'\r', self.rest()).map_or(self.bytes.len(), |n| self.at + n + 1);
    }

    /// Whether the cursor stands at a blank, a line end, a comment or the end.
    pub fn is_between_words(&self) -> bool {
        match self.rest() {
            [] | [b' ' | b'\t' | b'\n' | b'\r' | b'\x0b' | b'\x0c' | b'#' | b'\0', ..] => true,
            [b'\\', b'\n' | b'\r', ..] => self.continued,
            _ => false,
        }
    }

    /// Whether nothing but blanks is left on this line.
    pub fn is_line_done(&mut self) -> bool {
        self.skip_blanks();
        matches!(self.rest(), [] | [b'\n' | b'\r' | b'#', ..])
    }

    /// The bytes up to the next blank or line end.
    pub fn word(&mut self) -> &'a [u8] {
        let length = self.rest().iter().position(|byte| byte.is_ascii_whitespace()).unwrap_or(self.rest().len());
        let word = &self.rest()[..length];
        self.at += length;
        word
    }

    /// The bytes up to the end of the line, without blanks around them.
    pub fn rest_of_line(&self) -> &'a [u8] {
        let rest = self.rest();
        rest[..memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len())].trim_ascii()
    }

    /// The number at the cursor, `None` (and no move) where there is none or more than blanks follow it.
    pub fn number(&mut self) -> Option<f64> {
        let number = number::parse(self.rest())?;
        let start = self.at;
        self.at += number.length;
        if !self.is_between_words() {
            self.at = start;
            return None;
        }
        self.double |= number.double;
        Some(number.value)
    }

    /// The integer at the cursor, saturated; `None` (and no move) where there is none.
    pub fn integer(&mut self) -> Option<i64> {
        let rest = self.rest();
        let negative = rest.first() == Some(&b'-');
        let signed = usize::from(matches!(rest.first(), Some(b'-' | b'+')));
        let mut value = 0i64;
        let mut length = signed;
        while let Some(digit) = rest.get(length).map(|byte| byte.wrapping_sub(b'0')).filter(|&digit| digit <= 9) {
            value = value.saturating_mul(10).saturating_add(i64::from(digit));
            length += 1;
        }
        if length == signed {
            return None;
        }
        self.at += length;
        Some(if negative { -value } else { value })
    }
}
