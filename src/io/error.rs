//! What goes wrong with files, in one line each: what, where, what to do.

use std::fmt;

use super::Format;

/// What is wrong with bytes of no known format.
pub(super) const UNKNOWN: &str = "the content is of no known format";

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text, counted from 1.
    Line(usize),
    /// A byte, counted from 0.
    Byte(usize),
}

/// Why bytes are no mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadError {
    /// The format they were read as, if one was found.
    pub format: Option<Format>,
    /// Where in the file.
    pub place: Place,
    /// What is wrong, in lower case.
    pub what: String,
    /// What to do about it.
    pub remedy: String,
}

/// Why a mesh could not be written.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WriteError {
    /// What is wrong and what to do about it, in lower case.
    pub what: String,
}

impl ReadError {
    /// Whether nothing says which format it is: then the caller may name it.
    ///
    /// ```
    /// use neural_mesh::io::{Format, read};
    /// assert!(read(b"hello", None).unwrap_err().is_of_unknown_format());
    /// assert!(!read(b"hello", Some(Format::Ply)).unwrap_err().is_of_unknown_format());
    /// ```
    pub fn is_of_unknown_format(&self) -> bool {
        self.format.is_none() && self.what == UNKNOWN
    }

    /// An error about the file as a whole: what is wrong, in lower case, and what to do about it.
    pub fn file(what: impl Into<String>, remedy: &str) -> Self {
        Self { format: None, place: Place::File, what: what.into(), remedy: remedy.into() }
    }

    /// An error at the line of `text` that holds the byte `at`.
    pub(super) fn line(text: &[u8], at: usize, what: impl Into<String>, remedy: &str) -> Self {
        let before = &text[..at.min(text.len())];
        let line = 1 + memchr::memchr_iter(b'\n', before).count();
        Self { place: Place::Line(line), ..Self::file(what, remedy) }
    }

    /// An error at the byte `at`.
    pub(super) fn byte(at: usize, what: impl Into<String>, remedy: &str) -> Self {
        Self { place: Place::Byte(at), ..Self::file(what, remedy) }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(format) = self.format {
            write!(f, "{}: ", format.name())?;
        }
        match self.place {
            Place::File => {}
            Place::Line(line) => write!(f, "line {line}: ")?,
            Place::Byte(byte) => write!(f, "byte {byte}: ")?,
        }
        write!(f, "{}: {}", self.what, self.remedy)
    }
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl std::error::Error for ReadError {}
impl std::error::Error for WriteError {}
