//! The values of a PLY body one by one, from text or from bytes.

use super::header::Element;
use crate::io::text::Text;
use crate::io::{ReadError, Scalar};

const REMEDY: &str = "the file is cut or its header wrong, export the mesh again";

/// Where values come from.
pub(super) enum Source<'a> {
    /// Words of a text.
    Text {
        text: Text<'a>,
        /// Rows that are not read yet.
        rows_left: usize,
        /// Whether each row has a line of its own; known from the first row on that does not end its line.
        has_lines: Option<bool>,
    },
    /// Bytes from `at` on, most significant first where `big`.
    Binary { bytes: &'a [u8], at: usize, big: bool },
}

impl Source<'_> {
    /// The next value; `None` at the end or where the text is no number.
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

    /// Ends a row of an element. Where each row has a line of its own, what the header does not name is passed over.
    pub fn end_row(&mut self) {
        let Self::Text { text, rows_left, has_lines } = self else { return };
        *rows_left = rows_left.saturating_sub(1);
        if text.is_line_done() {
            return;
        }
        let has_words = |line: &&[u8]| !line.trim_ascii().is_empty();
        let n_lines = || text.rest().split(|byte| matches!(byte, b'\n' | b'\r')).skip(1).filter(has_words).count();
        if *has_lines.get_or_insert_with(|| n_lines() >= *rows_left) {
            text.skip_line();
        }
    }

    /// Bytes that are left.
    pub fn left(&self) -> usize {
        match self {
            Self::Text { text, .. } => text.rest().len(),
            Self::Binary { bytes, at, .. } => bytes.len() - at,
        }
    }

    /// The error for a value that is missing in item `item` of `element`.
    pub fn cut(&self, element: &Element, item: usize) -> ReadError {
        let what = format!("no value for {} {item} of {}", element.name, element.count);
        match self {
            Self::Text { text, .. } => text.error(what, REMEDY),
            Self::Binary { bytes, .. } => ReadError::byte(bytes.len(), what, REMEDY),
        }
    }
}
