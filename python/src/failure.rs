//! Errors as Python exceptions.

use std::fmt::Display;

use neural_mesh_cli::embedded::Failure;
use pyo3::create_exception;
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;

create_exception!(neural_mesh, NeuralMeshError, PyValueError, "Why there is no result, in one line.");
create_exception!(
    neural_mesh,
    OptionError,
    NeuralMeshError,
    "An option that is out of range, unknown, or fits no other."
);

pub fn to_exception(failure: &Failure) -> PyErr {
    match failure {
        Failure::Usage(_) => OptionError::new_err(as_keywords(&failure.to_string())),
        Failure::Interrupted => PyKeyboardInterrupt::new_err("interrupted"),
        _ => NeuralMeshError::new_err(as_keywords(&failure.to_string())),
    }
}

pub fn option_error(what: impl Display) -> PyErr {
    OptionError::new_err(what.to_string())
}

pub fn invalid_array(what: impl Into<String>) -> PyErr {
    NeuralMeshError::new_err(what.into())
}

/// Replaces options in a message by Python keywords: `--keep-components` becomes `keep_components`.
fn as_keywords(text: &str) -> String {
    let mut parts = text.split("--");
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |said, part| {
        let end = part.find(|letter: char| !letter.is_ascii_lowercase() && letter != '-').unwrap_or(part.len());
        let (name, rest) = part.split_at(end);
        said + &name.replace('-', "_") + rest
    })
}
