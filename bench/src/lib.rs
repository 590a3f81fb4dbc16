//! Measures neural-mesh: the pages of `docs/measured`, and which of them are of another version. Never published.

mod command;
mod measure;
mod worker;

pub use command::run;
