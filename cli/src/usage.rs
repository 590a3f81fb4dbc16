//! Messages for rejected option values.

use std::error::Error;

use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::failure::Failure;

/// Returns an error such as `--ratio 50: give a share ...` for a rejected value.
pub fn rejected_value(error: &clap::Error) -> Option<Failure> {
    let why = error.source().filter(|_| error.kind() == ErrorKind::ValueValidation)?;
    let context = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.as_str(),
        _ => "",
    };
    // The parser clap names the option with its value, as in `--fill-holes[=<EDGES>]`; only the name is kept.
    let option = context(ContextKind::InvalidArg).split([' ', '=', '[', '<']).next().unwrap_or_default();
    Some(Failure::Usage(format!("{option} {}: {why}", context(ContextKind::InvalidValue))))
}
