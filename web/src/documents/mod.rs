//! Calls on mesh files: simplify, compare, draw.

mod arrays;
mod clock;
mod compare;
mod file;
mod look;
mod simplify;

use neural_mesh::io::{Format, can_read, write_obstacle};
use neural_mesh::job::{Caller, JobError, respell_options};
use serde_json::{Value, json};

use crate::message::{Answer, Message, ProgressListener};
use crate::refusal::Refusal;

/// Answers the calls on mesh files.
///
/// # Errors
/// [`Refusal`] for an unknown call, and for errors of the call.
pub fn answer_call(
    call: &str,
    message: &Message,
    json: Value,
    answer: &mut Answer,
    listener: ProgressListener,
) -> Result<Value, Refusal> {
    match call {
        "simplify" => simplify::simplify_document(message, json, answer, listener),
        "compare" => compare::compare_files(message, json, answer, listener),
        "look" => look::describe_surface(message, json, answer),
        "formats" => Ok(list_formats()),
        _ => Err(Refusal::new(format!("{call}: no such call"))),
    }
}

fn list_formats() -> Value {
    let select_names = |is_known: &dyn Fn(Format) -> bool| -> Vec<&str> {
        Format::NAMES.into_iter().filter(|name| Format::from_name(name).is_some_and(is_known)).collect()
    };
    let written = |format| write_obstacle(format).is_none();
    json!({ "read": select_names(&can_read), "write": select_names(&written), "version": env!("CARGO_PKG_VERSION") })
}

impl From<JobError> for Refusal {
    fn from(error: JobError) -> Self {
        let what = respell_options(&error.to_string(), Caller::JavaScript);
        Self { is_interrupted: error == JobError::Interrupted, ..Self::new(what) }
    }
}
