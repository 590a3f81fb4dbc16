//! Requests by name, each to its answer.

use std::ops::ControlFlow;

use serde_json::{Value, json};

use crate::message::{Answer, Message};
use crate::refusal::Refusal;
use crate::{documents, indices};

/// Hears how far a part of a run is, as a share and a number; `Break` ends the run.
pub type Tell = Box<dyn FnMut(f64, u32) -> ControlFlow<()> + Send>;

/// Answers a request; what cannot be done is an answer of one line.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh_web::{answer::answer_to, message::{Answer, Message}};
/// let request = Answer::default().with(&serde_json::json!({ "call": "dance" }));
/// let answer = answer_to(&request, Box::new(|_, _| ControlFlow::Continue(())));
/// assert_eq!(Message::read(&answer).unwrap().part(0).unwrap(), br#"{"error":"dance: no such call"}"#);
/// ```
pub fn answer_to(request: &[u8], tell: Tell) -> Vec<u8> {
    let mut answer = Answer::default();
    match answer_request(request, &mut answer, tell) {
        Ok(json) => answer.with(&json),
        Err(Refusal { what, is_interrupted: true }) => {
            Answer::default().with(&json!({ "error": what, "interrupted": true }))
        }
        Err(Refusal { what, .. }) => Answer::default().with(&json!({ "error": what })),
    }
}

fn answer_request(request: &[u8], answer: &mut Answer, tell: Tell) -> Result<Value, Refusal> {
    let request = Message::read(request)?;
    let json: Value = serde_json::from_slice(request.part(0)?)?;
    let call = json.get("call").and_then(Value::as_str).unwrap_or_default().to_string();
    match call.as_str() {
        "indices" => indices::simplify_indices(&request, json, answer, tell),
        "prune" => indices::prune_components(&request, json, answer),
        "points" => indices::select_points(&request, json, answer),
        _ => documents::answer_call(&call, &request, json, answer, tell),
    }
}
