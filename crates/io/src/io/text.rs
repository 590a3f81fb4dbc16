//! Cursor over a text in any encoding.

use super::ReadError;
use super::number;

#[derive(Clone)]
pub(super) struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    // True after a number that needs double precision was read.
    pub double: bool,
    // True if a backslash before a line end continues the line.
    continued: bool,
}

impl<'a> Text<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { bytes, at, double: false, continued: false }
    }

    pub fn with_continuation(self) -> Self {
        Self { continued: true, ..self }
    }

    pub fn starting_at(self, at: usize) -> Self {
        Self { at: at.min(self.bytes.len()), ..self }
    }

    pub fn error(&self, what: impl Into<String>, remedy: &str) -> ReadError {
        ReadError::line(self.bytes, self.at, what, remedy)
    }

    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    pub fn is_at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    pub fn advance(&mut self, n: usize) {
        self.at = (self.at + n).min(self.bytes.len());
    }

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

    pub fn skip_line(&mut self) {
        self.at = memchr::memchr2(b'\n', b'\r', self.rest()).map_or(self.bytes.len(), |n| self.at + n + 1);
    }

    pub fn is_between_words(&self) -> bool {
        match self.rest() {
            [] | [b' ' | b'\t' | b'\n' | b'\r' | b'\x0b' | b'\x0c' | b'#' | b'\0', ..] => true,
            [b'\\', b'\n' | b'\r', ..] => self.continued,
            _ => false,
        }
    }

    pub fn is_line_done(&mut self) -> bool {
        self.skip_blanks();
        matches!(self.rest(), [] | [b'\n' | b'\r' | b'#', ..])
    }

    pub fn word(&mut self) -> &'a [u8] {
        let length = self.rest().iter().position(|byte| byte.is_ascii_whitespace()).unwrap_or(self.rest().len());
        let word = &self.rest()[..length];
        self.at += length;
        word
    }

    pub fn rest_of_line(&self) -> &'a [u8] {
        let rest = self.rest();
        rest[..memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len())].trim_ascii()
    }

    /// Reads a number; returns `None`, without moving, if the word is no number.
    pub fn number(&mut self) -> Option<f64> {
        // `1.5x` is damage, not 1.5.
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

    /// Reads three numbers, each after `skip`.
    pub fn read_position(&mut self, skip: impl Fn(&mut Self)) -> Option<[f64; 3]> {
        let mut position = [0.0; 3];
        for x in &mut position {
            skip(self);
            *x = self.number()?;
        }
        Some(position)
    }

    pub fn integer(&mut self) -> Option<i64> {
        let rest = self.rest();
        let negative = rest.first() == Some(&b'-');
        let signed = usize::from(matches!(rest.first(), Some(b'-' | b'+')));
        let mut value = 0i64;
        let mut length = signed;
        // Saturation keeps huge indices out of range instead of wrapping them into it.
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
