//! neural-mesh as WebAssembly: requests and answers are bytes, no algorithm lives here.
//!
//! There is no generated binding: [`door`] has the four functions that JavaScript calls, `caller` and `documents::clock` the two that it gives, [`message`] says how
//! numbers and JSON lie in bytes, [`answer`] knows the requests by name. A run that JavaScript ends is a `Break`, so nothing unwinds. JavaScript's
//! side is `web/package`.

pub mod answer;
mod caller;
#[cfg(feature = "documents")]
mod documents;
#[cfg(not(feature = "documents"))]
#[path = "no_documents.rs"]
mod documents;
pub mod door;
mod indices;
pub mod message;
pub mod refusal;
