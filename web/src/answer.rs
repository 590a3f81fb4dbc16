//! Dispatch of requests by name.

use serde_json::{Value, json};

use crate::message::{Answer, Message, ProgressListener};
use crate::refusal::Refusal;
use crate::{documents, indices};

/// Answers a request; failures are answers with a one-line message.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh_web::{answer::answer_to, message::{Answer, Message}};
/// let request = Answer::default().into_bytes(&serde_json::json!({ "call": "dance" }));
/// let answer = answer_to(&request, Box::new(|_, _| ControlFlow::Continue(())));
/// assert_eq!(Message::read(&answer).unwrap().part(0).unwrap(), br#"{"error":"dance: no such call"}"#);
/// ```
pub fn answer_to(request: &[u8], listener: ProgressListener) -> Vec<u8> {
    let mut answer = Answer::default();
    match answer_request(request, &mut answer, listener) {
        Ok(json) => answer.into_bytes(&json),
        Err(Refusal { what, is_interrupted: true }) => {
            Answer::default().into_bytes(&json!({ "error": what, "interrupted": true }))
        }
        Err(Refusal { what, .. }) => Answer::default().into_bytes(&json!({ "error": what })),
    }
}

fn answer_request(request: &[u8], answer: &mut Answer, listener: ProgressListener) -> Result<Value, Refusal> {
    let request = Message::read(request)?;
    let json: Value = serde_json::from_slice(request.part(0)?)?;
    let call = json.get("call").and_then(Value::as_str).unwrap_or_default().to_string();
    match call.as_str() {
        "indices" | "sloppy" | "prune" | "points" => indices::answer_call(&call, &request, json, answer),
        _ => documents::answer_call(&call, &request, json, answer, listener),
    }
}
