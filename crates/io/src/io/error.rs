//! Errors of readers and writers, each in one line.

use std::fmt;

use super::Format;

pub(super) const UNKNOWN: &str = "the content has no known format";

/// Location in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileLocation {
    /// File as a whole.
    File,
    /// Line of a text, counted from 1.
    Line(usize),
    /// Byte, counted from 0.
    Byte(usize),
}

/// Error of a reader.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadError {
    /// Format of the reader, if known.
    pub format: Option<Format>,
    /// Location in the file.
    pub location: FileLocation,
    /// Description of the problem, beginning in lower case.
    pub what: String,
    /// Advice for the user.
    pub remedy: String,
}

/// Error of a writer.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WriteError {
    /// Description of the problem and advice, beginning in lower case.
    pub what: String,
}

impl ReadError {
    /// Returns whether the format was not recognised.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::{Format, read};
    /// assert!(read(b"hello", None).unwrap_err().is_of_unknown_format());
    /// assert!(!read(b"hello", Some(Format::Ply)).unwrap_err().is_of_unknown_format());
    /// ```
    pub fn is_of_unknown_format(&self) -> bool {
        self.format.is_none() && self.what == UNKNOWN
    }

    /// Makes an error about the file as a whole.
    pub fn file(what: impl Into<String>, remedy: &str) -> Self {
        Self { format: None, location: FileLocation::File, what: what.into(), remedy: remedy.into() }
    }

    pub(super) fn line(text: &[u8], at: usize, what: impl Into<String>, remedy: &str) -> Self {
        // Lines are counted only here: an error is rare, and the cursors need not keep count.
        let before = &text[..at.min(text.len())];
        let line = 1 + memchr::memchr_iter(b'\n', before).count();
        Self { location: FileLocation::Line(line), ..Self::file(what, remedy) }
    }

    /// Adds the lines before a piece of a text to the location of an error in it.
    pub(super) fn after_lines(mut self, n_lines: usize) -> Self {
        if let FileLocation::Line(line) = &mut self.location {
            *line += n_lines;
        }
        self
    }

    pub(super) fn byte(at: usize, what: impl Into<String>, remedy: &str) -> Self {
        Self { location: FileLocation::Byte(at), ..Self::file(what, remedy) }
    }
}

impl WriteError {
    #[doc(hidden)]
    pub fn new(what: impl Into<String>) -> Self {
        Self { what: what.into() }
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(format) = self.format {
            write!(f, "{}: ", format.name())?;
        }
        match self.location {
            FileLocation::File => {}
            FileLocation::Line(line) => write!(f, "line {line}: ")?,
            FileLocation::Byte(byte) => write!(f, "byte {byte}: ")?,
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
