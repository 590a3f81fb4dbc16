//! Errors as Python exceptions.

use std::fmt::Display;

use neural_mesh::job::{Caller, respell_options};
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
        Failure::Usage(_) => OptionError::new_err(respell(failure)),
        Failure::LacksFeature { option, feature } => {
            let what = "this wheel lacks the feature";
            let text = format!(
                "{option}: {what} {feature}: build a wheel from the sources with `maturin build --features {feature}`"
            );
            OptionError::new_err(respell(text))
        }
        Failure::Interrupted => PyKeyboardInterrupt::new_err("interrupted"),
        _ => NeuralMeshError::new_err(respell(failure)),
    }
}

pub fn option_error(what: impl Display) -> PyErr {
    OptionError::new_err(respell(what))
}

pub fn invalid_array(what: impl Into<String>) -> PyErr {
    NeuralMeshError::new_err(what.into())
}

fn respell(message: impl Display) -> String {
    respell_options(&message.to_string(), Caller::Python)
}
