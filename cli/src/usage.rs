//! Messages for option values that clap rejects, in one line each.

use std::error::Error;

use clap::error::{ContextKind, ContextValue, ErrorKind};

use crate::failure::Failure;

/// Returns an error such as `--ratio 50: give a share ...` if a value was rejected.
pub fn refused_value(error: &clap::Error) -> Option<Failure> {
    let why = error.source().filter(|_| error.kind() == ErrorKind::ValueValidation)?;
    let said = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.as_str(),
        _ => "",
    };
    // Named as in the usage: `--fill-holes[=<EDGES>]`.
    let option = said(ContextKind::InvalidArg).split([' ', '=', '[', '<']).next().unwrap_or_default();
    Some(Failure::Usage(format!("{option} {}: {why}", said(ContextKind::InvalidValue))))
}
