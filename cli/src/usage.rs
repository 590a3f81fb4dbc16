//! What clap refuses, as the program says it: a value that no option takes is one line that says what it takes.

use std::error::Error;

use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::failure::Failure;

/// `--ratio 50: give a share ...`, where a value is what is wrong.
pub fn refused_value(error: &clap::Error) -> Option<Failure> {
    let why = error.source().filter(|_| error.kind() == ErrorKind::ValueValidation)?;
    let said = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.as_str(),
        _ => "",
    };
    // As in the usage: `--fill-holes[=<EDGES>]`.
    let option = said(ContextKind::InvalidArg).split([' ', '=', '[', '<']).next().unwrap_or_default();
    Some(Failure::Usage(format!("{option} {}: {why}", said(ContextKind::InvalidValue))))
}
