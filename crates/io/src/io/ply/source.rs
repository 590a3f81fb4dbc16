//! Values of a PLY body one by one.

use super::header::Element;
use crate::io::text::Text;
use crate::io::{ReadError, Scalar};

const REMEDY: &str = "the file is cut or its header wrong, export the mesh again";

pub(super) enum Source<'a> {
    Text {
        text: Text<'a>,
        rows_left: usize,
        // True if each row is one line; decided at the first row after which the line goes on.
        has_lines: Option<bool>,
    },
    Binary {
        bytes: &'a [u8],
        at: usize,
        big: bool,
    },
}

impl Source<'_> {
    pub fn scalar(&mut self, scalar: Scalar) -> Option<f64> {
        match self {
            Self::Text { text, .. } => {
                text.skip_space();
                text.number()
            }
            Self::Binary { bytes, at, big } => {
                let value = scalar.decode(bytes.get(*at..)?, *big)?;
                *at += scalar.size();
                Some(value)
            }
        }
    }

    // Words that the header does not declare are skipped if rows are lines.
    pub fn end_row(&mut self) {
        // Binary rows have no ends.
        let Self::Text { text, rows_left, has_lines } = self else { return };
        *rows_left = rows_left.saturating_sub(1);
        if text.is_line_done() {
            return;
        }
        let has_words = |line: &&[u8]| !line.trim_ascii().is_empty();
        let n_lines = || text.rest().split(|byte| matches!(byte, b'\n' | b'\r')).skip(1).filter(has_words).count();
        // If there are enough lines for all rows, each row is a line; else values run on across lines.
        if *has_lines.get_or_insert_with(|| n_lines() >= *rows_left) {
            text.skip_line();
        }
    }

    /// Returns the place of the next value in a binary body.
    pub fn byte(&self) -> usize {
        match self {
            Self::Text { .. } => 0,
            Self::Binary { at, .. } => *at,
        }
    }

    /// Returns to a place in a binary body; a text stays where it is, for its error.
    pub fn return_to(&mut self, byte: usize) {
        if let Self::Binary { at, .. } = self {
            *at = byte;
        }
    }

    pub fn n_bytes_left(&self) -> usize {
        match self {
            Self::Text { text, .. } => text.rest().len(),
            Self::Binary { bytes, at, .. } => bytes.len() - at,
        }
    }

    pub fn cut_error(&self, element: &Element, item: usize) -> ReadError {
        let what = format!("no value for {} {item} of {}", element.name, element.count);
        match self {
            Self::Text { text, .. } => text.error(what, REMEDY),
            Self::Binary { bytes, .. } => ReadError::byte(bytes.len(), what, REMEDY),
        }
    }
}
