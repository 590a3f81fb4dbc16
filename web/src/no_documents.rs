//! Stub of `documents` for builds with index buffers only.

use serde_json::Value;

use crate::message::{Answer, Message, ProgressListener};
use crate::refusal::Refusal;

pub fn answer_call(call: &str, _: &Message, _: Value, _: &mut Answer, _: ProgressListener) -> Result<Value, Refusal> {
    Err(Refusal::new(format!("{call}: no such call in this build: import 'neural-mesh'")))
}
