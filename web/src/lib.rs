//! neural-mesh as WebAssembly; requests and answers are bytes, and all algorithms are in the library, or for index buffers in its kernel.
//!
//! [`exports`] has the functions that JavaScript calls, `caller` and `documents::clock` those of JavaScript. [`message`]
//! defines the bytes, [`answer`] finds the requests by name. A run that JavaScript ends is a `Break`, so nothing
//! unwinds. The JavaScript is in `web/package`.

pub mod answer;
mod caller;
#[cfg(feature = "documents")]
mod documents;
#[cfg(not(feature = "documents"))]
#[path = "no_documents.rs"]
mod documents;
pub mod exports;
mod indices;
pub mod message;
pub mod refusal;
